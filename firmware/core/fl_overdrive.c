/* Mirrors overdrive_step of control/lookup.py. */
#include "fl_overdrive.h"

int32_t fl_overdrive(int32_t *believed, int32_t wanted, int32_t decay, fl_gain inverse, int32_t largest) {
    int32_t missing = fl_subtract(wanted, fl_mul28(decay, *believed));
    int32_t command = fl_clip(fl_mul(inverse, missing), 0, largest);
    *believed = fl_add(command, fl_mul28(decay, fl_subtract(*believed, command)));
    return command;
}

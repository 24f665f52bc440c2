/* Begin, and what the board can tell about itself. */
#include <string.h>

#include "fl_app_parts.h"

size_t fl_app_size(void) { return sizeof(fl_app); }

void fl_app_start(fl_app *app, const fl_identity *identity, const fl_parameters *parameters) {
    memset(app, 0, sizeof *app);
    app->identity = *identity;
    app->asked_state = FL_NO_STATE;
    fl_parameters_start(app, parameters);
    if (app->fault != FL_FAULT_NONE) return;
    uint8_t fault = identity->reset == FL_RESET_BROWN_OUT  ? FL_FAULT_BROWN_OUT
                    : identity->reset == FL_RESET_WATCHDOG ? FL_FAULT_WATCHDOG
                                                           : FL_FAULT_NONE;
    if (fault == FL_FAULT_NONE) return;
    app->raised.fault = app->fault = fault;
    app->state = FL_STATE_FAULT;
    app->tell_fault = 1;
}

void fl_app_took(fl_app *app, uint32_t duration) {
    if (duration > app->longest) app->longest = duration;
}

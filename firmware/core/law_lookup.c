/* Mirrors open_loop_step of control/lookup.py: the set-point commands and nothing is fed back. No gains. */
#include "laws.h"

fl_force_command fl_open_loop_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    (void)state, (void)measurement, (void)gains;
    int32_t u = fl_clip(setpoint, clamp.low, clamp.high);
    return (fl_force_command){u, u != setpoint};
}

/* Mirrors pi_step of control/pi.py. State: integral in N. Gains: kp, ki dt. */
#include "laws.h"

fl_force_command fl_pi_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    int32_t integral = state[0], v = integral;
    if (measurement->valid) {
        int32_t error = fl_subtract(setpoint, measurement->force);
        v = fl_fma(gains[0], error, integral);
        int pushes = (v > clamp.high && error > 0) || (v < clamp.low && error < 0);
        if (!pushes) state[0] = fl_fma(gains[1], error, integral);
    }
    int32_t u = fl_clip(v, clamp.low, clamp.high);
    return (fl_force_command){u, v != u};
}

void fl_pi_begin(int32_t *state, int32_t force, int32_t setpoint, const fl_gain *gains) {
    (void)setpoint, (void)gains;
    state[0] = force;
}

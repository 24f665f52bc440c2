/* The disturbance observer: disturbance_observer_step of control/disturbance_observer.py. */
#include "laws.h"
#include "fl_observer.h"

enum { OVERDRIVEN = FL_OBSERVER_GAINS };

const int8_t fl_disturbance_observer_places[] = {FL_OBSERVER_PLACES};

fl_force_command fl_disturbance_observer_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    fl_observe(state, measurement, gains);
    const int32_t v = fl_subtract(setpoint, state[FL_KEPT]), u = fl_clip(v, clamp.low, clamp.high);
    const int32_t held = gains[OVERDRIVEN].mantissa ? fl_held(state[FL_AHEAD], u, gains, clamp) : u;
    fl_predict(state, held, gains);
    return (fl_force_command){u, v != u};
}

/* Super-twisting sliding mode: super_twisting_step of control/super_twisting.py. */
#include "laws.h"
#include "fl_observer.h"

enum { W = FL_OBSERVER_STATES, BEFORE, TARGET };

/* REACH is dt k1 and REACH_SQUARED its square, BAND dt^2 k2; all but OVERDRIVEN are q28. */
enum { REACH = FL_OBSERVER_GAINS, REACH_SQUARED, BAND, FASTEST, OVERDRIVEN };

const int8_t fl_super_twisting_places[] = {FL_OBSERVER_PLACES, 28, 28, 28};

static int64_t clip(int64_t x, int64_t most) { return x > most ? most : x < -most ? -most : x; }

/* super_twist_step: s+ and w+ from s + drift + w and w; in q28, beyond +-8 N within. */
static int64_t twist(int64_t b, int32_t *w, const fl_gain *gains) {
    const int64_t pulled = clip(b, gains[BAND].mantissa), over = b > pulled ? b - pulled : pulled - b;
    /* |s+| + reach |s+|^(1/2) = |b| - band */
    const int64_t square = gains[REACH_SQUARED].mantissa + 4 * over;
    const int64_t most = INT64_C(1) << 34; /* its root is whole in 32 bits */
    const uint64_t scaled = (uint64_t)(square < most ? square : most) << 28;
    const int64_t root = fl_saturate((int64_t)fl_root(scaled) - gains[REACH].mantissa);
    const int64_t ahead = root > 0 ? fl_scale(root * root, 30) : 0; /* the half of the root, squared */
    *w = fl_saturate(*w - pulled);
    return b > 0 ? ahead : -ahead;
}

fl_force_command fl_super_twisting_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    const int32_t begins = state[FL_FORWARD] == 0;
    fl_observe(state, measurement, gains);
    const int32_t ahead = state[FL_AHEAD], d = state[FL_KEPT];
    const int64_t drift = begins ? 0 : (int64_t)d - state[BEFORE];
    const int64_t s = begins ? 0 : (int64_t)ahead + d - state[TARGET];
    int32_t w = state[W];
    const int64_t v = (int64_t)setpoint - d - drift + twist(s + drift + w, &w, gains);
    const int32_t wanted = fl_clip(fl_saturate(v), clamp.low, clamp.high);
    const int32_t held = fl_held(ahead, wanted, gains, clamp);
    fl_predict(state, held, gains);
    state[W] = v == wanted ? (int32_t)clip(w, gains[FASTEST].mantissa) : 0;
    state[BEFORE] = d;
    state[TARGET] = setpoint;
    return (fl_force_command){gains[OVERDRIVEN].mantissa ? wanted : held, v != wanted};
}

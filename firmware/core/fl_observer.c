#include "fl_observer.h"

#include "fl_row.h"

void fl_observe(int32_t *state, const fl_measurement *measurement, const fl_gain *gains) {
    const int32_t y = measurement->force, valid = measurement->valid;
    const int32_t direction = measurement->speed >= 0 ? 1 : -1;
    const int32_t begins = state[FL_FORWARD] == 0;
    const int32_t turns = direction > 0 ? state[FL_FORWARD] < 0 : state[FL_FORWARD] > 0;
    const int32_t y26 = (int32_t)fl_scale(y, 2), p = state[FL_PLATE];
    int32_t x1 = state[FL_SPRING], x2 = state[FL_RATE], x3 = state[FL_READING];
    int64_t d = state[FL_REST]; /* of a reversal it may leave +-8 N before it is limited */
    if (turns) {
        x1 = fl_subtract(0, x1);
        x2 = fl_subtract(0, x2);
        x3 = fl_subtract(0, x3);
        d = -2 * (int64_t)p - d;
    }
    if (begins) { /* the sensor has settled before the first reading */
        x1 = x3 = y26;
        d = (int64_t)y - p;
    } else if (valid && (turns || !state[FL_SLID])) {
        d = state[FL_KEPT];
    }
    const int32_t e = fl_subtract(y26, x3);
    const int64_t limit = gains[FL_LIMIT].mantissa;
    const fl_gain kd = gains[FL_KD];
    d += fl_scale((int64_t)kd.mantissa * e, kd.shift - 2);
    state[FL_REST] = (int32_t)(d > limit ? limit : d < -limit ? -limit : d);
    state[FL_SPRING] = fl_fma(gains[FL_K1], e, x1);
    state[FL_RATE] = fl_fma(gains[FL_K2], e, x2);
    state[FL_READING] = fl_fma(gains[FL_K3], e, x3);
    if (valid) state[FL_KEPT] = state[FL_REST];
    state[FL_SLID] = valid;
    state[FL_FORWARD] = direction;
}

void fl_predict(int32_t *state, int32_t command, const fl_gain *gains) {
    const int32_t whole = gains[FL_WHOLE].mantissa;
    const int32_t p = state[FL_PLATE], x1 = state[FL_SPRING], x2 = state[FL_RATE], x3 = state[FL_READING];
    const int32_t d = state[FL_REST], o = state[FL_NOW], n = whole == 0 ? command : state[FL_NEXT];
    const fl_gain *g = gains;
    for (int k = FL_NEXT; k < FL_OBSERVER_STATES - 1; k++) state[k] = state[k + 1];
    if (whole > 0 && whole < FL_OBSERVER_STATES - FL_NOW) state[FL_NOW + whole] = command;
    state[FL_NOW] = n;
    state[FL_PLATE] = fl_sum(fl_term(g[FL_PP], p) + fl_term(g[FL_PO], o) + fl_term(g[FL_PN], n));
    state[FL_AHEAD] = fl_fma(g[FL_PP], fl_subtract(state[FL_AHEAD], command), command);
    g = gains + FL_X1P;
    state[FL_SPRING] = fl_sum(
        fl_term(g[0], p) + fl_term(g[1], x1) + fl_term(g[2], x2) + fl_term(g[3], o) + fl_term(g[4], n)
        + fl_term(g[5], d));
    g = gains + FL_X2P;
    state[FL_RATE] = fl_sum(
        fl_term(g[0], p) + fl_term(g[1], x1) + fl_term(g[2], x2) + fl_term(g[3], o) + fl_term(g[4], n)
        + fl_term(g[5], d));
    g = gains + FL_X3P;
    state[FL_READING] = fl_sum(
        fl_term(g[0], p) + fl_term(g[1], x1) + fl_term(g[2], x2) + fl_term(g[3], x3) + fl_term(g[4], o)
            + fl_term(g[5], n) + fl_term(g[6], d));
}

int32_t fl_held(int32_t ahead, int32_t wanted, const fl_gain *gains, fl_clamp clamp) {
    const fl_gain pp = gains[FL_PP], inverse = gains[FL_INVERSE_PLATE];
    const int64_t beyond = wanted - fl_scale((int64_t)pp.mantissa * ahead, pp.shift);
    return fl_clip(fl_mul(inverse, fl_saturate(beyond)), clamp.low, clamp.high);
}

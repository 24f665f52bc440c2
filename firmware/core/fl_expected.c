/* Mirrors expected_step of control/expected.py. */
#include "fl_expected.h"

enum { C1, C2, C3, DRIVEN, PLATE, SPRING, RATE, THE_READING }; /* state */
enum {
    WHOLE, OVERDRIVE, FOLLOW, DECAY, NEWEST, MEAN_DECAY, MEAN_NEWEST, A11, A12, A21, A22, A31, A32, A33, NARROW, WIDEN
}; /* gains */

int fl_expects(const fl_gain *gains) { return gains[WHOLE].mantissa >= 0; }

int32_t fl_expected(const int32_t *state, const fl_gain *gains) { return fl_mul(gains[WIDEN], state[THE_READING]); }

/* old + decay (from - old) + share (new - old) */
static int32_t blend(fl_gain decay, int32_t from, fl_gain share, int32_t new, int32_t old) {
    return fl_fma(decay, fl_subtract(from, old), fl_fma(share, fl_subtract(new, old), old));
}

/* The springs and the pole over a period of constant force. */
static void springs(int32_t *state, int32_t force, const fl_gain *gains) {
    int32_t s = fl_subtract(state[SPRING], force), r = fl_subtract(state[THE_READING], force), rate = state[RATE];
    state[SPRING] = fl_fma(gains[A11], s, fl_fma(gains[A12], rate, force));
    state[RATE] = fl_fma(gains[A21], s, fl_mul(gains[A22], rate));
    state[THE_READING] = fl_fma(gains[A31], s, fl_fma(gains[A32], rate, fl_fma(gains[A33], r, force)));
}

void fl_expect(int32_t *state, int32_t setpoint, fl_clamp clamp, const fl_gain *gains) {
    const int32_t whole = fl_clip(gains[WHOLE].mantissa, 0, 3), driven = state[DRIVEN];
    int32_t wanted = fl_fma(gains[OVERDRIVE], fl_subtract(setpoint, driven), setpoint);
    int32_t command = fl_clip(
        wanted, clamp.low < setpoint ? clamp.low : setpoint, clamp.high > setpoint ? clamp.high : setpoint);
    int32_t new = whole == 0 ? command : state[C1 + whole - 1];
    int32_t old = state[whole == 0 ? C1 : whole == 1 ? C2 : C3];
    /* With three periods of delay, new and old are both the oldest command, as in the float law. */
    int32_t mean = blend(gains[MEAN_DECAY], state[PLATE], gains[MEAN_NEWEST], new, old);
    state[PLATE] = blend(gains[DECAY], state[PLATE], gains[NEWEST], new, old);
    state[DRIVEN] = fl_fma(gains[FOLLOW], fl_subtract(command, driven), driven);
    state[C3] = state[C2];
    state[C2] = state[C1];
    state[C1] = command;
    springs(state, fl_mul(gains[NARROW], mean), gains);
}

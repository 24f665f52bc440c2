/* The limit observer: limit_observer_step of control/limit_step.py, line by line.
 *
 * Places of what is not q28: limits (N) and binary logarithms q26, springs, rate, reading and innovation (N) q24, ways
 * (um) q20, squares of amplitudes (um^2) q25. */
#include "fl_real.h"
#include "fl_row.h"
#include "laws.h"

/* As LimitState. */
enum { AMPLITUDE, COMMAND, D, FRICTION, SPRING, RATE, READING, FORWARD };

const int8_t fl_limit_observer_places[] = {28, 28, 26, 28, 24, 24, 24, 0};

/* As firmware/quantised_limit.py. */
enum {
    DECAY_REST, DECAY_LEFT, DECAY, INVERSE,           /* q30, q30, q30, q24 */
    A11, A12, A21, A22, A31, A32, A33,                /* rows */
    KD, K1, K2, K3, KDS, KFS, K1S, K2S, K3S,          /* q24, and what is more per period of T q28 */
    SLIP_UM, WAY, MOST_UM, MOST_SQUARE,               /* q20; dt in us q20; q28, q25 */
    LOG2_NOMINAL, PER_FALL, MODEL_FALL, FALL          /* q26, q26, q28, q28 */
};

/* Constants of limit_step.py in the places of what they meet. */
enum {
    SLOWEST = 536871, LEAST_FORCE = 26843546, MOST_FORCE = 2 * FL_ONE, /* 0.002 m/s; 0.1 N */
    LARGEST_UP = 107374182, LARGEST_N = 5 * FL_ONE, LARGEST_LOG2 = 5 << 26, /* 0.4 */
    LONGEST = 15 * (FL_ONE / 2), LEAST_SETPOINT = 5368709, /* 7.5; 0.02 N */
    LOG2_E = 1549082005, ROUNDED = 64 /* q30; of a power of 2 at the ends of the clamp */
};

/* a + b, which gains within their ranges keep within 32 bits; it wraps around otherwise */
static int32_t plus(int32_t a, int32_t b) { return fl_low((int64_t)a + b); }

/* from + share (to - from) of a q30 share */
static int32_t towards(fl_gain share, int32_t from, int32_t to) {
    return fl_low(from + fl_product(share.mantissa, fl_low((int64_t)to - from), 30));
}

/* x + (k + more lag) e of a state in q24 */
static int32_t corrected(int32_t x, fl_gain k, fl_gain more, int32_t lag, int32_t e) {
    return fl_saturate(x + fl_product(plus(k.mantissa, fl_high(more.mantissa, lag)), e, 24));
}

fl_force_command fl_limit_observer_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    const int32_t y = measurement->force >> 4, slides = measurement->valid, a = state[AMPLITUDE];
    const int32_t forward = measurement->speed >= 0 ? 1 : -1, before = state[FORWARD], begins = before == 0;
    int32_t f = state[FRICTION], x1 = state[SPRING], x2 = state[RATE], x3 = state[READING];
    const int32_t fall = gains[FALL].mantissa;
    int32_t d = state[D];
    if (forward > 0 ? before < 0 : before > 0) {
        f = fl_subtract(0, f);
        x1 = fl_subtract(0, x1);
        x2 = fl_subtract(0, x2);
        x3 = fl_subtract(0, x3);
    }
    if (begins) {
        f = measurement->force;
        x1 = x3 = y;
    }

    /* Correct by the reading. */
    const int32_t speed = measurement->speed < 0 ? fl_subtract(0, measurement->speed) : measurement->speed;
    const int32_t v = speed > SLOWEST ? speed : SLOWEST;
    const int32_t force = fl_clip(f, LEAST_FORCE, MOST_FORCE), slip_um = gains[SLIP_UM].mantissa;
    const int32_t way_um = fl_saturate(fl_product(gains[WAY].mantissa, v, 28));
    const int32_t far_um = fl_saturate(((int64_t)way_um * 15) >> 1); /* as LONGEST */
    const int32_t lag = slip_um < far_um ? fl_ratio(slip_um, fl_invert(way_um)) : LONGEST;
    const int32_t e = fl_subtract(y, x3);
    const int32_t kd = plus(gains[KD].mantissa, fl_high(gains[KDS].mantissa, lag));
    if (slides) {
        const int32_t most = (int32_t)fl_product(LARGEST_UP, force, 28);
        const int32_t up = fl_share(fl_clip(fl_saturate(fl_product(kd, e, 20)), -most, most), fl_invert(force));
        d = fl_add(d, fl_high(LOG2_E, up));
    }
    const int32_t lower = fl_low(fl_product(fl_low(fl_product(fall, a, 30)), a, 28)); /* q26 */
    d = fl_clip(d, fl_subtract(lower, LARGEST_LOG2), fl_add(lower, LARGEST_LOG2));
    const int32_t kf = slides ? plus(gains[KD].mantissa, fl_high(gains[KFS].mantissa, lag)) : gains[KD].mantissa;
    f = fl_clip(fl_saturate(f + fl_product(kf, e, 20)), -LARGEST_N, LARGEST_N);
    x1 = corrected(x1, gains[K1], gains[K1S], lag, e);
    x2 = corrected(x2, gains[K2], gains[K2S], lag, e);
    x3 = corrected(x3, gains[K3], gains[K3S], lag, e);

    /* Command. */
    const int32_t target = fl_log2(setpoint > LEAST_SETPOINT ? setpoint : LEAST_SETPOINT, 28);
    const int32_t then = towards(gains[DECAY_REST], state[COMMAND], a);
    const int32_t square = fl_saturate(fl_over(fl_low((int64_t)d - target), fl_invert(fall), 27));
    const int32_t within = fl_clip(square, 0, gains[MOST_SQUARE].mantissa);
    const fl_gain nominal = gains[LOG2_NOMINAL], model = gains[MODEL_FALL];
    const int32_t wanted = fl_exp2(fl_saturate(nominal.mantissa - fl_product(model.mantissa, within, 27)), 28);
    const int32_t u = fl_clip(wanted, clamp.low, clamp.high);
    const int32_t clamped = fl_subtract(u, wanted);
    int32_t held = within;
    if (clamped > ROUNDED || clamped < -ROUNDED) {
        const int32_t given = u == setpoint && u > LEAST_SETPOINT ? target : fl_log2(u > 0 ? u : 1, 28); /* open loop */
        const int32_t over = fl_low((int64_t)nominal.mantissa - given);
        held = fl_clip(fl_saturate(fl_product(over, gains[PER_FALL].mantissa, 27)), 0, gains[MOST_SQUARE].mantissa);
    }
    const int32_t missing = fl_low((int32_t)fl_root((uint64_t)held << 31) - fl_product(gains[DECAY].mantissa, then, 30));
    const int32_t command = fl_clip(
        fl_saturate(fl_product(gains[INVERSE].mantissa, missing, 24)), 0, gains[MOST_UM].mantissa);

    /* Go on to the next sample. */
    const int32_t a_next = towards(gains[DECAY_LEFT], command, then);
    const int32_t above = fl_exp2(fl_saturate(d - fl_product(fl_low(fl_product(fall, a_next, 30)), a_next, 28)), 28);
    const int32_t limit = above < LARGEST_N ? above : LARGEST_N;
    const int32_t share = fl_share(way_um, fl_invert(fl_add(slip_um, way_um))); /* at most 1 */
    const int64_t change = slides ? fl_product(share, limit, 28) - fl_product(share, f, 28) : 0;
    const int32_t mean = fl_low(f + (change >> 1)) >> 4; /* between f and the limit */
    const int32_t s = fl_subtract(x1, mean), r = fl_subtract(x3, mean);
    const fl_gain *g = gains;
    state[AMPLITUDE] = a_next;
    state[COMMAND] = command;
    state[D] = d;
    state[FRICTION] = fl_low(f + change);
    state[SPRING] = fl_add(fl_sum(fl_term(g[A11], s) + fl_term(g[A12], x2)), mean);
    state[RATE] = fl_sum(fl_term(g[A21], s) + fl_term(g[A22], x2));
    state[READING] = fl_add(fl_sum(fl_term(g[A31], s) + fl_term(g[A32], x2) + fl_term(g[A33], r)), mean);
    state[FORWARD] = forward;
    return (fl_force_command){u, square != held};
}

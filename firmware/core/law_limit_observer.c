/* The limit observer: limit_observer_step of control/limit_observer.py, line by line.
 *
 * Places of what is not q28: limits (N) and binary logarithms q26, springs, rate, reading and innovation (N) q24, ways
 * and compliance times force (um) q20, squares of amplitudes (um^2) q25, mean square of the logarithm q25. */
#include "fl_real.h"
#include "fl_row.h"
#include "laws.h"

/* As LimitState. */
enum {
    AMPLITUDE, COMMAND, D, FRICTION, SPRING, RATE, READING, FORWARD, FALL, SLOW_TARGET, SLOW_LIMIT, SWING, STUCK
};

const int8_t fl_limit_observer_places[] = {28, 28, 26, 28, 24, 24, 24, 0, 28, 26, 26, 25, 0};

/* As firmware/quantised_limit.py; of LEARN, SLOW and FORGET the shift counts. */
enum {
    DECAY_REST, DECAY_LEFT, DECAY, INVERSE,           /* q30, q30, q30, q24 */
    A11, A12, A21, A22, A31, A32, A33,                /* rows */
    KD, KDS, KFS, K1, K1S, K2, K2S, K3, K3S,          /* q24 */
    COMPLIANCE, WAY, SKIN, MOST_UM, MOST_SQUARE,      /* q20; dt in us q20; skin dt q28; q28, q25 */
    LOG2_NOMINAL, MODEL_FALL, LEAST_FALL, MOST_FALL,  /* q26, q28, q28, q28 */
    LEARN, SLOW, FORGET, ENDS                         /* dt/T_l, 2 pi dt SLOW_HZ, dt/MEMORY_S */
};

/* Constants of limit_observer.py in the places of what they meet. */
enum {
    SLOWEST = 536871, LEAST_FORCE = 26843546, MOST_FORCE = 2 * FL_ONE, /* 0.002 m/s; 0.1 N */
    LARGEST_UP = 107374182, LARGEST_N = 5 * FL_ONE, LARGEST_LOG2 = 5 << 26, /* 0.4 */
    LONGEST = 15 * (FL_ONE / 2), LEAST_SQUARE = 174590, LEAST_SETPOINT = 5368709, /* 7.5; q25; 0.02 N */
    LOG2_E = 1549082005, ROUNDED = 64 /* q30; of a power of 2 at the ends of the clamp */
};

typedef struct { int32_t share, ramp, lag; } contact;

/* contact_shares, q28 (the first up to 1.1), and lag/way up to LONGEST; lag and way q20, at least 0 and above 0. */
static contact contact_of(int32_t lag, int32_t way) {
    const int32_t up = __builtin_clz((uint32_t)(lag | way)) - 5; /* below 2^27 */
    const int32_t l = up > 0 ? lag << up : lag >> -up, w = up > 0 ? way << up : way >> -up;
    const uint64_t whole = (uint64_t)((int64_t)(6 * l) * l + (int64_t)(4 * l + w) * w);
    const int32_t bits = __builtin_clzll(whole);
    const int32_t factor = fl_reciprocal((uint32_t)(whole << bits >> 32));
    const int32_t share = (int32_t)((uint64_t)((int64_t)w * (6 * l + w)) << (bits - 1) >> 33);
    const int32_t ramp = (int32_t)((uint64_t)((int64_t)w * (3 * l + w)) << (bits - 1) >> 33);
    const int32_t ratio = 2 * (int64_t)lag >= 15 * (int64_t)way ? LONGEST : (int32_t)fl_over(lag, fl_invert(way), 28);
    return (contact){(int32_t)fl_product(share, factor, 32), (int32_t)fl_product(ramp, factor, 32), ratio};
}

/* 2^(d - fall a^2), q26 */
static int32_t limit_of(int32_t d, int32_t fall, int32_t a) {
    return fl_exp2(fl_saturate(d - fl_product(fl_low(fl_product(fall, a, 30)), a, 28)), 26);
}

/* from + share (to - from) of a q30 share */
static int32_t towards(fl_gain share, int32_t from, int32_t to) {
    return fl_low(from + fl_product(share.mantissa, fl_low((int64_t)to - from), 30));
}

/* (k + more lag) e of a state in q24 */
static int32_t corrected(int32_t x, const fl_gain *k, int32_t lag, int32_t e) {
    return fl_saturate(x + fl_product(fl_low(k[0].mantissa + fl_product(k[1].mantissa, lag, 28)), e, 24));
}

/* phi after a period, of z, h and the mean square */
static int32_t learnt(int32_t fall, int32_t z, int32_t h, int32_t swing, const fl_gain *gains) {
    const int64_t ratio = fl_over(fl_saturate(fl_product(z, h, 27)), fl_invert(swing), 28);
    const int32_t taught = ratio > 2 * FL_ONE ? 2 * FL_ONE : ratio < -2 * FL_ONE ? -2 * FL_ONE : (int32_t)ratio;
    const int32_t moved = fl_fma(gains[LEARN], fl_saturate(fl_product(fall, taught, 28)), fall);
    return fl_clip(moved, gains[LEAST_FALL].mantissa, gains[MOST_FALL].mantissa);
}

fl_force_command fl_limit_observer_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    const int32_t y = measurement->force >> 4, slides = measurement->valid, stuck = state[STUCK], a = state[AMPLITUDE];
    const int32_t forward = measurement->speed >= 0 ? 1 : -1, before = state[FORWARD], begins = before == 0;
    int32_t f = state[FRICTION], x1 = state[SPRING], x2 = state[RATE], x3 = state[READING];
    int32_t d = state[D], fall = state[FALL];
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

    /* The contact. */
    const int32_t speed = measurement->speed < 0 ? fl_subtract(0, measurement->speed) : measurement->speed;
    const int32_t v = speed > SLOWEST ? speed : SLOWEST;
    const int32_t force = fl_clip(f, LEAST_FORCE, MOST_FORCE);
    const int32_t lag_um = fl_clip(fl_saturate(fl_product(gains[COMPLIANCE].mantissa, force, 28)), 0, INT32_MAX);
    const int32_t way_um = fl_clip(fl_saturate(fl_product(gains[WAY].mantissa, v, 28)), 1, INT32_MAX);
    const contact with = contact_of(lag_um, way_um);
    const int64_t fastest = fl_product(gains[SKIN].mantissa, v, 28);

    /* Correct by the reading. */
    const int32_t e = fl_subtract(y, x3);
    const int32_t kd = fl_low(gains[KD].mantissa + fl_product(gains[KDS].mantissa, with.lag, 28));
    if (slides && (!stuck || e < 0)) {
        const int32_t most = (int32_t)fl_product(LARGEST_UP, force, 28);
        const int32_t missed = fl_clip(fl_saturate(fl_product(kd, e, 20)), -most, most);
        const int32_t up = fl_low(fl_product(missed, fl_low(fl_over(FL_ONE, fl_invert(force), 27)), 27));
        d = fl_low(d + fl_product(LOG2_E, up, 32));
    }
    d = fl_clip(d, -LARGEST_LOG2, LARGEST_LOG2);
    const int32_t kf = fl_low(gains[KD].mantissa + (slides && !stuck ? fl_product(gains[KFS].mantissa, with.lag, 28) : 0));
    f = fl_clip(fl_saturate(f + fl_product(kf, e, 20)), -LARGEST_N, LARGEST_N);
    x1 = corrected(x1, gains + K1, with.lag, e);
    x2 = corrected(x2, gains + K2, with.lag, e);
    x3 = corrected(x3, gains + K3, with.lag, e);

    /* What set-point and limit do. */
    const int32_t target = fl_log2(setpoint > LEAST_SETPOINT ? setpoint : LEAST_SETPOINT, 28);
    int32_t slow_target = begins ? target : state[SLOW_TARGET], slow_limit = begins ? d : state[SLOW_LIMIT];
    const int32_t z = fl_low((int64_t)target - slow_target), h = fl_saturate((int64_t)d - slow_limit);
    slow_target = fl_fma(gains[SLOW], z, slow_target);
    slow_limit = fl_fma(gains[SLOW], h, slow_limit);
    const int32_t swing = fl_fma(gains[FORGET], fl_saturate(fl_product(z, z, 27) - state[SWING]), state[SWING]);

    /* Command. */
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
        held = fl_clip(fl_saturate(fl_over(over, fl_invert(model.mantissa), 27)), 0, gains[MOST_SQUARE].mantissa);
    } else if (slides && !stuck && swing > LEAST_SQUARE && square == within) { /* the limit that there is stays */
        const int32_t new = learnt(fall, z, h, swing, gains);
        const int32_t more = (int32_t)fl_product(fl_low(fl_product(fl_subtract(new, fall), a, 28)), a, 30);
        d = fl_add(d, more);
        slow_limit = fl_add(slow_limit, more);
        fall = new;
    }
    const int32_t missing = fl_low((int32_t)fl_root((uint64_t)held << 31) - fl_product(gains[DECAY].mantissa, then, 30));
    const int32_t command = fl_clip(
        fl_saturate(fl_product(gains[INVERSE].mantissa, missing, 24)), 0, gains[MOST_UM].mantissa);

    /* Go on to the next sample. */
    const int32_t a_next = towards(gains[DECAY_LEFT], command, then);
    const int32_t limit = limit_of(d, fall, a), limit_next = limit_of(d, fall, a_next);
    const int32_t behind = fl_saturate(4 * (int64_t)limit - f), rises = fl_saturate(4 * ((int64_t)limit_next - limit));
    const int64_t follows = fl_product(with.share, behind, 28) + fl_product(with.ramp, rises, 28);
    const int32_t change = slides ? fl_saturate(follows < fastest ? follows : fastest) : 0;
    const int32_t mean = (int32_t)(((int64_t)f + (change >> 1)) >> 4);
    const int32_t s = fl_subtract(x1, mean), r = fl_subtract(x3, mean);
    const fl_gain *g = gains;
    state[AMPLITUDE] = a_next;
    state[COMMAND] = command;
    state[D] = d;
    state[FRICTION] = fl_add(f, change);
    state[SPRING] = fl_add(fl_sum(fl_term(g[A11], s) + fl_term(g[A12], x2)), mean);
    state[RATE] = fl_sum(fl_term(g[A21], s) + fl_term(g[A22], x2));
    state[READING] = fl_add(fl_sum(fl_term(g[A31], s) + fl_term(g[A32], x2) + fl_term(g[A33], r)), mean);
    state[FORWARD] = forward;
    state[FALL] = fall;
    state[SLOW_TARGET] = slow_target;
    state[SLOW_LIMIT] = slow_limit;
    state[SWING] = swing;
    state[STUCK] = slides && follows > fastest;
    return (fl_force_command){u, square != held};
}

/* The limit observer: limit_observer_step of control/limit_step.py, line by line.
 *
 * Places of what is not q28: limits (N) and binary logarithms q26, springs, rate, reading and innovation (N) q24, ways
 * and compliance times force (um) q20, squares of amplitudes (um^2) q25, mean square of the logarithm q25. */
#include "fl_real.h"
#include "fl_row.h"
#include "laws.h"

/* As LimitState. */
enum {
    AMPLITUDE, COMMAND, D, FRICTION, SPRING, RATE, READING, FORWARD, FALL, SLOW_TARGET, SLOW_LIMIT, SWING, STUCK,
    MISFIT = FL_MISFIT
};

const int8_t fl_limit_observer_places[] = {28, 28, 26, 28, 24, 24, 24, 0, 28, 26, 26, 25, 0, 28};

/* As firmware/quantised_limit.py. */
enum {
    DECAY_REST, DECAY_LEFT, DECAY, INVERSE,           /* q30, q30, q30, q24 */
    A11, A12, A21, A22, A31, A32, A33,                /* rows */
    KD, K1, K2, K3, KDS, KFS, K1S, K2S, K3S,          /* q24, and what is more per period of T q28 */
    COMPLIANCE, WAY, SKIN, MOST_UM, MOST_SQUARE,      /* q20; dt in us q20; skin dt q28; q28, q25 */
    LOG2_NOMINAL, PER_FALL, MODEL_FALL, LEAST_FALL, MOST_FALL, /* q26, q26, q28, q28, q28 */
    LEARN, SLOW, FORGET, WINDOW                       /* q32: dt/T_l, 2 pi dt SLOW_HZ, dt/MEMORY_S, dt/WINDOW_S */
};

/* Constants of limit_step.py in the places of what they meet. */
enum {
    SLOWEST = 536871, LEAST_FORCE = 26843546, MOST_FORCE = 2 * FL_ONE, /* 0.002 m/s; 0.1 N */
    LARGEST_UP = 107374182, LARGEST_N = 5 * FL_ONE, LARGEST_LOG2 = 5 << 26, /* 0.4 */
    LONGEST = 15 * (FL_ONE / 2), LEAST_SQUARE = 174590, LEAST_SETPOINT = 5368709, /* 7.5; q25; 0.02 N */
    LOG2_E = 1549082005, ROUNDED = 64 /* q30; of a power of 2 at the ends of the clamp */
};

/* a + b, which gains within their ranges keep within 32 bits; it wraps around otherwise */
static int32_t plus(int32_t a, int32_t b) { return fl_low((int64_t)a + b); }

/* from + share (to - from) of a q30 share */
static int32_t towards(fl_gain share, int32_t from, int32_t to) {
    return fl_low(from + fl_product(share.mantissa, fl_low((int64_t)to - from), 30));
}

/* The same, of a q32 share. */
static int32_t slowly(fl_gain share, int32_t from, int32_t to) {
    return plus(from, fl_high(share.mantissa, fl_low((int64_t)to - from)));
}

/* x + (k + more lag) e of a state in q24 */
static int32_t corrected(int32_t x, fl_gain k, fl_gain more, int32_t lag, int32_t e) {
    return fl_saturate(x + fl_product(plus(k.mantissa, fl_high(more.mantissa, lag)), e, 24));
}

/* phi after a period, of z, h and the mean square */
static int32_t learnt(int32_t fall, int32_t z, int32_t h, int32_t swing, const fl_gain *gains) {
    const int64_t ratio = fl_over(fl_saturate(fl_product(z, h, 27)), fl_invert(swing), 28);
    const int32_t taught = ratio > 2 * FL_ONE ? 2 * FL_ONE : ratio < -2 * FL_ONE ? -2 * FL_ONE : (int32_t)ratio;
    const int32_t moved = plus(fall, fl_high(gains[LEARN].mantissa, fl_saturate(fl_product(fall, taught, 28))));
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
    const int32_t lag_um = fl_saturate(fl_product(gains[COMPLIANCE].mantissa, force, 28));
    const int32_t way_um = fl_saturate(fl_product(gains[WAY].mantissa, v, 28));
    const int32_t far_um = fl_saturate(((int64_t)way_um * 15) >> 1); /* as LONGEST */
    const int32_t lag = lag_um < far_um ? fl_ratio(lag_um, fl_invert(way_um)) : LONGEST;
    const int32_t share = fl_share(way_um, fl_invert(fl_add(lag_um, way_um)));
    const int32_t fastest = fl_saturate(fl_product(gains[SKIN].mantissa, v, 28));

    /* Correct by the reading. */
    const int32_t e = fl_subtract(y, x3);
    const int32_t kd = plus(gains[KD].mantissa, fl_high(gains[KDS].mantissa, lag));
    int32_t up = 0;
    if (slides && (!stuck || e < 0)) {
        const int32_t most = (int32_t)fl_product(LARGEST_UP, force, 28);
        up = fl_share(fl_clip(fl_saturate(fl_product(kd, e, 20)), -most, most), fl_invert(force));
        d = fl_add(d, fl_high(LOG2_E, up));
    }
    const int32_t misfit = slowly(gains[WINDOW], state[MISFIT], fl_low(fl_product(up, up, 28)));
    const int32_t lower = fl_low(fl_product(fl_low(fl_product(fall, a, 30)), a, 28)); /* q26 */
    d = fl_clip(d, fl_subtract(lower, LARGEST_LOG2), fl_add(lower, LARGEST_LOG2));
    const int32_t kf = slides && !stuck ? plus(gains[KD].mantissa, fl_high(gains[KFS].mantissa, lag)) : gains[KD].mantissa;
    f = fl_clip(fl_saturate(f + fl_product(kf, e, 20)), -LARGEST_N, LARGEST_N);
    x1 = corrected(x1, gains[K1], gains[K1S], lag, e);
    x2 = corrected(x2, gains[K2], gains[K2S], lag, e);
    x3 = corrected(x3, gains[K3], gains[K3S], lag, e);

    /* What set-point and limit do. */
    const int32_t target = fl_log2(setpoint > LEAST_SETPOINT ? setpoint : LEAST_SETPOINT, 28);
    int32_t slow_target = begins ? target : state[SLOW_TARGET], slow_limit = begins ? d : state[SLOW_LIMIT];
    const int32_t z = fl_subtract(target, slow_target), h = fl_subtract(d, slow_limit);
    slow_target = slowly(gains[SLOW], slow_target, target);
    slow_limit = slowly(gains[SLOW], slow_limit, d);
    const int32_t swing = slowly(gains[FORGET], state[SWING], fl_saturate(fl_product(z, z, 27)));

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
        held = fl_clip(fl_saturate(fl_product(over, gains[PER_FALL].mantissa, 27)), 0, gains[MOST_SQUARE].mantissa);
    }
    int32_t new = fall;
    if (misfit > FL_MOST_MISFIT) {
        new = gains[MOST_FALL].mantissa;
    } else if (slides && !stuck && swing > LEAST_SQUARE && square == held) {
        new = learnt(fall, z, h, swing, gains);
    }
    if (new != fall) { /* the limit that there is stays */
        const int32_t more = (int32_t)fl_product(fl_low(fl_product(fl_subtract(new, fall), a, 28)), a, 30);
        d = fl_add(d, more);
        slow_limit = fl_add(slow_limit, more);
    }
    const int32_t missing = fl_low((int32_t)fl_root((uint64_t)held << 31) - fl_product(gains[DECAY].mantissa, then, 30));
    const int32_t command = fl_clip(
        fl_saturate(fl_product(gains[INVERSE].mantissa, missing, 24)), 0, gains[MOST_UM].mantissa);

    /* Go on to the next sample. */
    const int32_t a_next = towards(gains[DECAY_LEFT], command, then);
    const int32_t limit = fl_exp2(fl_saturate(d - fl_product(fl_low(fl_product(new, a_next, 30)), a_next, 28)), 28);
    const int32_t follows = fl_low(fl_product(share, fl_subtract(limit, f), 28)); /* share is at most 1 */
    const int32_t change = slides ? (follows < fastest ? follows : fastest) : 0;
    const int32_t mean = plus(f, change >> 1) >> 4; /* between f and the limit */
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
    state[FALL] = new;
    state[SLOW_TARGET] = slow_target;
    state[SLOW_LIMIT] = slow_limit;
    state[SWING] = swing;
    state[STUCK] = slides && follows > fastest;
    state[MISFIT] = misfit;
    return (fl_force_command){u, square != held};
}

/* The tracker: tracker_step of control/tracker.py, line by line; formats in fl_tracker.h.
 *
 * Divisions of a tick, 12 at most, none of more than 32 bits. */
#include "fl_row.h"
#include "fl_tracker.h"
#include "laws.h"

/* As TrackerState; of the mean squares the upper words, the lower ones last. BY_C and BY_T begin groups of
 * five. */
enum {
    AMPLITUDE, COMMAND, D, TRUSTED, FRICTION, SPRING, RATE, READING, FORWARD, LOAD, RISING, FALLING,
    BEFORE, COMPLIANCE, FALL, POWER_C, POWER_T, LEAPT, QUICK, BY_C, BY_T = BY_C + 5, POWER_C_LOW = BY_T + 5, POWER_T_LOW
};

const int8_t fl_tracker_places[] = {
    28, 28, 26, 26, 28, 23, 22, 24, 0, 26, 15, 15, 28, 20, 28, 28, 20, 28, 15, /* to QUICK */
    30, 30, 31, 30, 32, 26, 26, 27, 26, 28, 60, 52};

/* As TrackerGains, a product where the comment says so, each in its places; of LEARN_C and LEARN_T the
 * shift counts. */
enum {
    REST, DECAY_REST, DECAY_LEFT, DECAY, INVERSE,             /* q30, q30, q30, q30, q24 */
    MOST_UM, MOST_SQUARE, MOST_C,                             /* q28; its square, um^2, q25; q20 */
    LEARN_C, LEARN_T, EXPONENT, LOAD_GAIN,                    /* -, -, q29, q30 */
    FASTEST, LARGEST_RISE, WAY, SMOOTH_RATE,           /* skin, q12; 1.2 skin dt, dt in us, SMOOTH/dt, q20 */
    JUMP, LOG2_NOMINAL, MODEL_FALL,                           /* q28, q26, q28 */
    STUCK_FRICTION, STUCK_SPRING, STUCK_RATE, STUCK_READING,  /* q24 */
    SENSOR, TABLE = SENSOR + FL_SENSOR_STEP
};

enum { KD, KF, K1, K2, K3, LEAD, TRUST }; /* values of a row of the schedule: the last two q28, the others q24 */

/* Constants of tracker.py in the places of what they meet. */
enum {
    LOWEST = -221459251, HIGHEST = 335544320,                 /* q26: -3.3, 5 */
    LARGEST = 5 * FL_ONE, LARGEST_UP = 107374182,             /* 0.4 */
    FASTEST_C = 2 << 20, FASTEST_FALL = 53687,                /* q20; q28: 2e-4 */
    LARGEST_BY_C = 85899346, LARGEST_BY_T = 1 << 30,          /* q32: 0.02; q28 */
    LEAST_POWER_C = 115292150, LEAST_POWER_T = 22517998,      /* q60: 1e-10; q52: 5e-9 */
    LEAN = 120, LEAST_LEAN = 53687091, LEAN_SPEED = 5368709,  /* 0.2; 0.02 m/s */
    SHORT = 4026532, MOST_ADDED = 1 << 30,                    /* q27: 0.03 N; q30: 1 */
    SLOWEST = 536871, LEAST_LEAD = 1 << 20, MOST_JUMP = 214748364, /* 0.002 m/s, 1/256, 0.8 N */
    SMOOTH = 429496730, SMOOTH_FALLS = 85899346,              /* q32: 0.1, 0.02 */
    QUICK_OVER_SMOOTH = 5, RINGING = 104858, CALMED_C = 20 << 20, /* q21: 0.05 N m/s^2; q20 */
    CALM_C = 536871, CALM_T = 268435,                         /* 2e-3, 1e-3 */
    LEAST_FALL = 53687091, MOST_FALL = 3 * FL_ONE,            /* 0.2 */
    LEAP = 40265318, LEAP_SHARE = 1932735283,                 /* 0.15 N; q31: 0.9 */
    LEAP_TICK = FL_ONE / 16, MOST_PUSH = 20 << 26,
    LOG2_E = 1549082005, HALF_LN_2 = 1488522236,              /* q30, q32 */
    LEAST_PRESSED = 5368709, LEAST_WANTED = 335544,           /* 0.02 N in q28 and in q24 */
    STEADY_FORCE = 40265318, STEADY_ERROR = 2013266,          /* 0.15 N; q26: 0.03 */
    LEAST_FORCE = 26843546, MOST_FORCE = 2 * FL_ONE,          /* 0.1 N */
    LEAST_LIMIT = 3355443, AT_ONCE = 260382392                /* q26: 0.05 N; 0.97 */
};

/* Leaps are kept out of the way of the longest tick, one that learns. */
#define SELDOM(condition) __builtin_expect(condition, 0)

static int32_t magnitude(int32_t x) { return x < 0 ? fl_subtract(0, x) : x; }

/* a x + b y of two q28 shares a and b */
static int32_t blend(int32_t a, int32_t x, int32_t b, int32_t y) {
    return fl_low(((int64_t)a * x + (int64_t)b * y + (FL_ONE >> 1)) >> 28);
}

/* from + share (to - from) of a q30 share */
static int32_t towards(fl_gain share, int32_t from, int32_t to) {
    return fl_low(from + fl_product(share.mantissa, fl_low((int64_t)to - from), 30));
}

fl_force_command fl_tracker_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    int32_t *x = state + SPRING, *by_c = state + BY_C, *by_t = state + BY_T;
    const int32_t valid = measurement->valid, a = state[AMPLITUDE];
    const int32_t forward = measurement->speed >= 0 ? 1 : -1;
    const int32_t turned = forward > 0 ? state[FORWARD] < 0 : state[FORWARD] > 0;
    int32_t f = state[FRICTION], d = state[D], c = state[COMPLIANCE], fall = state[FALL];
    int32_t rising = state[RISING], falling = state[FALLING], before = state[BEFORE];
    if (turned) {
        f = fl_subtract(0, f);
        before = fl_subtract(0, before);
        for (int i = 0; i < 3; i++) x[i] = fl_subtract(0, x[i]);
    }
    int32_t v = magnitude(measurement->speed);
    if (v < SLOWEST) v = SLOWEST;
    const int64_t far = ((int64_t)gains[WAY].mantissa * v) >> 2;
    const int64_t way = far > FL_LEAST_WAY ? far : FL_LEAST_WAY;
    const int32_t fastest = fl_saturate(fl_product(gains[FASTEST].mantissa, v, 25));
    const int32_t pressed = measurement->load > LEAST_PRESSED ? measurement->load : LEAST_PRESSED;
    const int32_t load = towards(gains[LOAD_GAIN], state[LOAD], fl_log2(pressed, 27));
    int32_t push = fl_low(fl_product(gains[EXPONENT].mantissa, load, 29));

    /* Correct by the reading. */
    const int32_t error = fl_saturate((measurement->force - (int64_t)x[2] * 16 + 2) >> 2);
    int32_t limit = fl_limit_of(fl_low((int64_t)d + push), fall, a);
    fl_inverse per_whole;
    int32_t share = fl_share_of(c, f >> 2, way, &per_whole), k[FL_SCHEDULED];
    fl_schedule(k, share, v, gains + TABLE);
    const int32_t w = fl_stuck_share(f, limit, rising, fastest, valid);
    const int32_t calm = 2 * (int64_t)magnitude(rising) < fastest;
    const int32_t off = (f >> 1) - (setpoint >> 1), leaps = valid && magnitude(off) > LEAP / 2;
    int32_t leapt = state[LEAPT];
    if (SELDOM(leaps || leapt)) {
        const int64_t drop = (int64_t)before - f;
        const int32_t drops = leaps && off > 0 && drop > fl_product(gains[LARGEST_RISE].mantissa, v, 20);
        leapt = drops ? FL_ONE : leapt > LEAP_TICK ? leapt - LEAP_TICK : 0;
        state[LEAPT] = leapt;
    } else if (w == 0 && f > STEADY_FORCE && magnitude(error) < STEADY_ERROR && calm) {
        const int64_t pc = fl_mean_square(state + POWER_C, state + POWER_C_LOW, by_c[4]) + LEAST_POWER_C;
        const int64_t pt = fl_mean_square(state + POWER_T, state + POWER_T_LOW, by_t[4]) + LEAST_POWER_T;
        int32_t more_c = fl_learnt(gains[LEARN_C], error, by_c[4], pc, 32 - 60 - 20, FASTEST_C);
        if (more_c > 0) {
            const int32_t pace = v > LEAN_SPEED ? v : LEAN_SPEED;
            const int32_t pace2 = fl_saturate(fl_product(pace, pace, 26)); /* q30 */
            const int64_t counts = (((int64_t)c * pace2) >> 22) * LEAN;
            if (counts < FL_ONE)
                more_c = (int32_t)fl_product(counts > LEAST_LEAN ? (int32_t)counts : LEAST_LEAN, more_c, 28);
        }
        c = fl_add(c, more_c);
        c = fl_clip(c, 0, gains[MOST_C].mantissa);
        fall = fl_add(fall, fl_learnt(gains[LEARN_T], error, by_t[4], pt, 28 - 52 - 28, FASTEST_FALL));
    }
    const int32_t rings = valid && rising < -2 * (int64_t)fastest;
    const int32_t shakes = c > CALMED_C && falling > fastest >> 2 && ((int64_t)falling * v) >> 22 > RINGING;
    if (rings || (valid && shakes)) c -= (int32_t)fl_product(CALM_C, c, 28);
    if (rings) fall = fl_saturate(fall + fl_product(CALM_T, fall, 28));
    fall = fl_clip(fall, LEAST_FALL, MOST_FALL);
    const int32_t slides = FL_ONE - w, jump = fl_clip(gains[JUMP].mantissa, 0, MOST_JUMP);
    const int32_t force = fl_clip(f, LEAST_FORCE, MOST_FORCE);
    const int32_t per_force = fl_low(fl_over(FL_ONE, fl_invert(force), 27));
    const int32_t moves = (int32_t)fl_product(LARGEST_UP, force, 28), most = moves < jump ? moves : jump;
    int32_t missed = fl_clip(fl_saturate(fl_product(k[KD], error, 22)), -most, most);
    if (SELDOM(leapt)) missed = fl_low(fl_product(FL_ONE - leapt, missed, 28));
    const int32_t up = fl_low(fl_product(fl_low(fl_product(slides, missed, 28)), per_force, 27));
    d = fl_clip(fl_low(d + fl_product(LOG2_E, up, 32)), LOWEST, HIGHEST);
    limit = fl_saturate(limit + fl_product(limit, up, 28));
    const int32_t slid = fl_clip(fl_saturate(fl_product(k[KF], error, 22)), -2 * jump, 2 * jump);
    const int64_t stuck = fl_product(fl_low(fl_product(w, gains[STUCK_FRICTION].mantissa, 28)), error, 22);
    f = fl_clip(fl_saturate(f + fl_product(slides, slid, 28) + stuck), -LARGEST, LARGEST);
    x[0] = fl_saturate(x[0] + fl_product(blend(slides, k[K1], w, gains[STUCK_SPRING].mantissa), error, 27));
    x[1] = fl_saturate(x[1] + fl_product(blend(slides, k[K2], w, gains[STUCK_RATE].mantissa), error, 28));
    x[2] = fl_saturate(x[2] + fl_product(blend(slides, k[K3], w, gains[STUCK_READING].mantissa), error, 26));
    const int32_t rise = (int32_t)(((int64_t)f - before) >> 1);
    const int32_t risen = fl_saturate(fl_product(gains[SMOOTH_RATE].mantissa, rise, 32));
    rising = fl_saturate(rising - fl_product(SMOOTH, rising, 32) + risen);
    const int32_t quick = fl_saturate((state[QUICK] >> 1) + QUICK_OVER_SMOOTH * (int64_t)risen);
    const int32_t excess = fl_saturate(-(int64_t)quick - fastest);
    const int64_t fallen = excess > 0 ? fl_product(SMOOTH_FALLS, excess, 32) : 0;
    falling = fl_saturate(falling - fl_product(SMOOTH_FALLS, falling, 32) + fallen);

    /* Go on to when the command takes effect. */
    const int32_t a_then = towards(gains[DECAY_REST], state[COMMAND], a);
    state[FALL] = fall;
    int32_t more = 0;
    if (SELDOM(leaps)) {
        const int32_t least = fl_low(fl_product(LEAP_SHARE, gains[MODEL_FALL].mantissa, 31));
        more = fall - fl_clip(least, LEAST_FALL, MOST_FALL);
        fall -= more;
        push = fl_clip(fl_saturate((int64_t)push - fl_lowering(more, a)), -MOST_PUSH, MOST_PUSH);
    }
    const int32_t limit_then = fl_limit_of(fl_low((int64_t)d + push), fall, a_then);
    int32_t mean = (int32_t)(((int64_t)limit + limit_then) >> 1);
    share = fl_share_of(c, mean, way, &per_whole);
    if (share > AT_ONCE) mean = limit_then;
    const int64_t behind = (int64_t)mean * 4 - f;
    const int64_t fast = fl_product(gains[LARGEST_RISE].mantissa, v, 20), slow = (share * behind) >> 28;
    const int32_t change = fl_saturate(slow < fast ? slow : fast);
    const int32_t f_next = fl_add(f, change);
    const int32_t f_then = fl_saturate(f + fl_product(gains[REST].mantissa, change, 30));

    /* Command. */
    const fl_inverse per_lead = fl_invert(k[LEAD] > LEAST_LEAD ? k[LEAD] : LEAST_LEAD);
    const int32_t ahead = fl_low(((int64_t)setpoint - f_then) >> 1); /* q27: it may be 13 N */
    const int32_t wanted_limit = fl_saturate(fl_over(ahead, per_lead, 25) + (f_then >> 4));
    const int32_t wanted_log2 = fl_log2(wanted_limit > LEAST_WANTED ? wanted_limit : LEAST_WANTED, 24);
    const int32_t behind_d = fl_low((int64_t)d - state[TRUSTED]);
    int32_t trusted = fl_low(state[TRUSTED] + fl_product(k[TRUST], behind_d, 28));
    const int32_t over = fl_low((int64_t)trusted + push - wanted_log2);
    const int32_t square = fl_saturate(fl_over(over, fl_invert(fall), 27));
    const int32_t within = fl_clip(square, 0, gains[MOST_SQUARE].mantissa);
    const int32_t held = state[COMMAND] == 0 && ahead > SHORT ? 0 : within;
    const int32_t wanted = (int32_t)fl_root((uint64_t)held << 31);
    const int32_t missing = fl_low(wanted - fl_product(gains[DECAY].mantissa, a_then, 30));
    const int32_t command = fl_clip(
        fl_saturate(fl_product(gains[INVERSE].mantissa, missing, 24)), 0, gains[MOST_UM].mantissa);
    const int64_t u_log2 = gains[LOG2_NOMINAL].mantissa - fl_product(gains[MODEL_FALL].mantissa, held, 27);
    const int32_t u = fl_clip(fl_exp2(fl_saturate(u_log2), 28), clamp.low, clamp.high);

    /* Go on to the next sample. */
    const int32_t kd = fl_low(fl_product(k[KD], per_force, 31));
    const fl_sensitivity with = {
        {(int32_t)fl_product(slides, kd, 28), (int32_t)fl_product(slides, k[KF], 28), k[K1], k[K2], k[K3]},
        share, mean, gains + SENSOR};
    /* share / way is 1 / (way + c L) */
    const int64_t pressing = mean > LEAST_LIMIT ? mean : LEAST_LIMIT;
    const int64_t steep = (pressing * per_whole.factor) >> (48 - per_whole.bits);
    const int32_t slower = fl_low(fl_product(share, fl_saturate(steep), 28));
    const int32_t lags = fl_saturate(-fl_product(slower, fl_saturate(behind >> 2), 22));
    const int32_t added_c = fl_clip(lags, -MOST_ADDED, MOST_ADDED);
    const int32_t squares = fl_low(fl_product(a, a, 32) + fl_product(a_then, a_then, 32)); /* q24 */
    const int32_t lower = (int32_t)fl_product(HALF_LN_2, (int32_t)fl_product(share, mean, 28), 32);
    const int32_t added_t = fl_saturate(-fl_product(lower, squares, 24));
    const int32_t keep = !turned && magnitude(by_c[4]) <= LARGEST_BY_C && magnitude(by_t[4]) <= LARGEST_BY_T;
    fl_sensitivity_step(by_c, keep, &with, added_c);
    fl_sensitivity_step(by_t, keep, &with, added_t);
    fl_sensor_step(x, f >> 6, f_next >> 6, gains + SENSOR);
    const int32_t a_next = towards(gains[DECAY_LEFT], command, a_then);
    if (SELDOM(more)) {
        const int64_t d_next = (int64_t)d + fl_lowering(more, a_next) - fl_lowering(more, a);
        const int32_t moved = fl_clip(fl_saturate(d_next), LOWEST, HIGHEST) - d;
        d += moved;
        trusted = fl_low((int64_t)trusted + moved);
    }
    state[AMPLITUDE] = a_next;
    state[COMMAND] = command;
    state[D] = d;
    state[TRUSTED] = trusted;
    state[FRICTION] = f_next;
    state[FORWARD] = forward;
    state[LOAD] = load;
    state[RISING] = rising;
    state[FALLING] = falling;
    state[QUICK] = quick;
    state[BEFORE] = f;
    state[COMPLIANCE] = c;
    return (fl_force_command){u, square != within};
}

void fl_tracker_follow(int32_t *state, int32_t command, const fl_gain *gains) {
    const int32_t left = fl_subtract(1 << 30, gains[DECAY_LEFT].mantissa); /* a' = a_then + left (c - a_then) */
    const int32_t other = fl_subtract(command, state[COMMAND]);
    state[AMPLITUDE] = fl_add(state[AMPLITUDE], fl_low(fl_product(left, other, 30)));
    state[COMMAND] = command;
}

/* The tracker: tracker_step of control/tracker.py, line by line; formats in fl_tracker.h.
 *
 * Divisions of a tick, by reciprocals: 11. Nothing here divides 64 bits. */
#include "fl_tracker.h"
#include "laws.h"

/* As TrackerState; of the mean squares the upper words, the lower ones last. BY_C and BY_T begin groups of five. */
enum {
    AMPLITUDE, COMMAND, D, TRUSTED, FRICTION, SPRING, RATE, READING, FORWARD, LOAD, RISING, BEFORE, COMPLIANCE, FALL,
    POWER_C, POWER_T, BY_C, BY_T = BY_C + 5, POWER_C_LOW = BY_T + 5, POWER_T_LOW
};

const int8_t fl_tracker_places[] = {
    28, 28, 26, 26, 28, 23, 22, 24, 0, 26, 15, 28, 20, 28, 28, 20, 30, 30, 31, 30, 32, 26, 26, 27, 26, 28, 60, 52};

/* As TrackerGains, a product where the comment says so. The second group is numbers in fixed places (its mantissas). */
enum {
    REST, DECAY_REST, DECAY_LEFT, DECAY, INVERSE, LEARN_C, LEARN_T, EXPONENT, LOAD_GAIN, MODEL_FALL,
    FASTEST,      /* skin */
    LARGEST_RISE, /* 1.2 skin dt */
    WAY,          /* dt in us */
    SMOOTH_RATE,  /* SMOOTH / dt */
    MOST_UM, MOST_SQUARE, MOST_C, JUMP, LOG2_NOMINAL, /* q28; um^2, q25; q20; q28; q26 */
    STUCK_FRICTION, STUCK_SPRING, STUCK_RATE, STUCK_READING, /* q24 */
    SENSOR, TABLE = SENSOR + FL_SENSOR_STEP
};

enum { KD, KF, K1, K2, K3, LEAD, TRUST }; /* columns of the schedule */

/* Constants of tracker.py in the places of what they meet. */
enum {
    LOWEST = -221459251, HIGHEST = 241591910, /* q26: -3.3, 3.6 */
    LARGEST = 5 * FL_ONE,
    FASTEST_C = 2 << 20, FASTEST_FALL = 53687, /* q20, q28: 2e-4 */
    LARGEST_BY_C = 85899346, LARGEST_BY_T = 1 << 30, /* q32: 0.02; q28 */
    SLOWEST = 536871, /* 0.002 m/s */
    FORGET = 1717987, /* q32: 4e-4 */
    CALM_C = 536871, CALM_T = 268435, /* 2e-3, 1e-3 */
    LEAST_FALL = 53687091, MOST_FALL = 3 * FL_ONE, /* 0.2 */
    SMOOTH = 214748365, /* q31: 0.1 */
    LOG2_E = 1549082005, HALF_LN_2 = 744261118, /* q30, q31 */
    N_0_15 = 40265318, N_0_03 = 2013266, /* q28; q26 */
    N_0_1 = 26843546, N_0_02 = 5368709, N_0_05 = 3355443, /* q28, q28, q26 */
    SHARE_0_97 = 260382392
};

static int64_t clip(int64_t x, int64_t most) { return x > most ? most : x < -most ? -most : x; }

static int32_t magnitude(int32_t x) { return x < 0 ? fl_subtract(0, x) : x; }

/* a b 2^-shift */
static int64_t product(int32_t a, int32_t b, int32_t shift) { return fl_scale((int64_t)a * b, shift); }

/* The mean square goes on to the square of x, whose places are half its own and 2. */
static int64_t mean_square(int32_t *high, int32_t *low, int32_t x) {
    int64_t mean = (int64_t)(*high > 0 ? *high : 0) * (INT64_C(1) << 32) + (uint32_t)*low;
    const int64_t change = (((int64_t)x * x) >> 4) - mean;
    mean += (change >> 32) * FORGET + (int64_t)(((uint64_t)(uint32_t)change * FORGET) >> 32);
    *high = (int32_t)(mean >> 32);
    *low = (int32_t)(uint32_t)mean;
    return mean;
}

/* learn error s / mean: a step of an estimate in `to` places; s has `from` and its mean square and `least` `over`. */
static int64_t learnt(fl_gain learn, int32_t error, int32_t s, int32_t from, int64_t mean, int32_t over, int32_t to) {
    const fl_gain moved = fl_times(
        fl_real((int64_t)learn.mantissa * error, learn.shift + 26), fl_real(s, from));
    return fl_fixed(fl_times(moved, fl_inverse(mean, over)), to);
}

static void turn(int32_t *state) {
    static const uint8_t turned[] = {FRICTION, BEFORE, SPRING, RATE, READING};
    for (int k = 0; k < 5; k++) state[turned[k]] = fl_subtract(0, state[turned[k]]);
}

fl_force_command fl_tracker_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    const fl_gain *sensor = gains + SENSOR, *table = gains + TABLE;
    int32_t *by_c = state + BY_C, *by_t = state + BY_T;
    const int32_t valid = measurement->valid;
    const int32_t forward = measurement->speed >= 0 ? 1 : -1;
    const int32_t turned = forward > 0 ? state[FORWARD] < 0 : state[FORWARD] > 0;
    if (turned) turn(state);
    int32_t f = state[FRICTION], d = state[D], c = state[COMPLIANCE], fall = state[FALL];
    int32_t rising = state[RISING], *x = state + SPRING;
    const int32_t a = state[AMPLITUDE], before = state[BEFORE];

    int32_t v = magnitude(measurement->speed);
    if (v < SLOWEST) v = SLOWEST;
    const fl_gain way = gains[WAY];
    const fl_gain per_way = fl_inverse((int64_t)way.mantissa * v, way.shift + 28);
    const int32_t fastest = fl_saturate(fl_product(gains[FASTEST], v, 28, 15));
    const int32_t pressed = measurement->load > N_0_02 ? measurement->load : N_0_02;
    const int32_t load = fl_fma(gains[LOAD_GAIN], fl_subtract(fl_log2(pressed, 27), state[LOAD]), state[LOAD]);
    const int32_t push = fl_mul(gains[EXPONENT], load);

    /* Correct by the reading. */
    const int32_t error = fl_saturate(fl_scale(measurement->force - (int64_t)x[2] * 16, 2));
    int32_t limit = fl_limit_of(fl_add(d, push), fall, a);
    int32_t share = fl_share_of(c, fl_saturate(fl_scale(f, 2)), per_way);
    int32_t k[FL_SCHEDULED];
    for (int i = 0; i < FL_SCHEDULED; i++)
        k[i] = fl_scheduled(share, table + FL_SHARES * i, i < LEAD ? FL_CORRECTING : FL_SHARING);
    const int32_t w = fl_stuck_share(f, limit, rising, fastest, valid);
    if (w == 0 && f > N_0_15 && magnitude(error) < N_0_03 && 2 * (int64_t)magnitude(rising) < fastest) {
        const int64_t pc = mean_square(state + POWER_C, state + POWER_C_LOW, by_c[4]);
        const int64_t pt = mean_square(state + POWER_T, state + POWER_T_LOW, by_t[4]);
        const int64_t least_c = 115292150, least_t = 22517998; /* 1e-10 in q60, 5e-9 in q52 */
        const int64_t step_c = learnt(gains[LEARN_C], error, by_c[4], 32, pc + least_c, 60, 20);
        const int64_t step_t = learnt(gains[LEARN_T], error, by_t[4], 28, pt + least_t, 52, 28);
        c = fl_clip(fl_saturate(c + clip(step_c, FASTEST_C)), 0, gains[MOST_C].mantissa);
        fall = fl_saturate(fall + clip(step_t, FASTEST_FALL));
    }
    if (valid && rising < -2 * (int64_t)fastest) {
        c -= (int32_t)product(CALM_C, c, 28);
        fall = fl_saturate(fall + product(CALM_T, fall, 28));
    }
    fall = fl_clip(fall, LEAST_FALL, MOST_FALL);
    const int32_t slides = FL_ONE - w, jump = gains[JUMP].mantissa;
    const int32_t per_force = (int32_t)fl_fixed(fl_inverse(fl_clip(f, N_0_1, 2 * FL_ONE), 28), 27);
    const int32_t missed = fl_mul28(slides, fl_saturate(clip(product(k[KD], error, 22), jump)));
    const int32_t up = fl_saturate(product(missed, per_force, 27));
    d = fl_clip(fl_saturate(d + product(LOG2_E, up, 32)), LOWEST, HIGHEST);
    limit = fl_saturate(limit + product(limit, up, 28));
    const int64_t slid = product(slides, fl_saturate(clip(product(k[KF], error, 22), 2 * (int64_t)jump)), 28);
    const int64_t stuck = product(fl_mul28(w, gains[STUCK_FRICTION].mantissa), error, 22);
    f = fl_clip(fl_saturate(f + slid + stuck), -LARGEST, LARGEST);
    for (int i = 0; i < 3; i++) {
        static const int32_t shifts[] = {27, 28, 26};
        const int32_t gain = fl_add(fl_mul28(slides, k[K1 + i]), fl_mul28(w, gains[STUCK_SPRING + i].mantissa));
        x[i] = fl_saturate(x[i] + product(gain, error, shifts[i]));
    }
    const fl_gain smooth = gains[SMOOTH_RATE];
    const int64_t slope = fl_shift(smooth.mantissa * ((int64_t)f - before), smooth.shift + 13);
    rising = fl_saturate(rising - product(SMOOTH, rising, 31) + slope);

    /* Go on to when the command takes effect. */
    const int32_t a_then = fl_fma(gains[DECAY_REST], fl_subtract(a, state[COMMAND]), state[COMMAND]);
    const int32_t limit_then = fl_limit_of(fl_add(d, push), fall, a_then);
    int32_t mean = (int32_t)(((int64_t)limit + limit_then) >> 1);
    share = fl_share_of(c, mean, per_way);
    if (share > SHARE_0_97) mean = limit_then;
    const int64_t behind = (int64_t)mean * 4 - f;
    const int64_t change = fl_scale(share * behind, 28), rise = fl_mul(gains[LARGEST_RISE], v);
    const int32_t moved = fl_saturate(change < rise ? change : rise);
    const int32_t f_then = fl_fma(gains[REST], moved, f), f_next = fl_add(f, moved);

    /* Command. */
    const fl_gain per_lead = fl_inverse(k[LEAD] > 1 ? k[LEAD] : 1, FL_SHARING);
    const int64_t wanted_limit = fl_product(per_lead, fl_subtract(setpoint, f_then), 28, 28) + f_then;
    const int32_t trusted = fl_saturate(
        state[TRUSTED] + fl_scale((int64_t)k[TRUST] * ((int64_t)d - state[TRUSTED]), FL_SHARING));
    const int32_t over = fl_saturate(
        (int64_t)trusted + push - fl_log2(wanted_limit > N_0_02 ? wanted_limit : N_0_02, 28));
    const int32_t square = fl_saturate(fl_product(fl_inverse(fall, 28), over, 26, 25));
    const int32_t held = fl_clip(square, 0, gains[MOST_SQUARE].mantissa);
    const int32_t wanted = (int32_t)fl_root((uint64_t)held << 31);
    const int32_t missing = fl_subtract(wanted, fl_mul(gains[DECAY], a_then));
    const int32_t command = fl_clip(fl_mul(gains[INVERSE], missing), 0, gains[MOST_UM].mantissa);
    const int32_t u_log2 = fl_saturate(gains[LOG2_NOMINAL].mantissa - fl_product(gains[MODEL_FALL], held, 25, 26));
    const int32_t u = fl_clip(fl_exp2(u_log2, 28), clamp.low, clamp.high);

    /* Go on to the next sample. */
    const fl_sensitivity with = {
        {fl_saturate(product(k[KD], per_force, 31)), k[KF], k[K1], k[K2], k[K3]}, slides, share, mean, sensor};
    const int64_t steep = product((int32_t)product(share, share, 28), mean > N_0_05 ? mean : N_0_05, 28);
    const fl_gain slower = fl_real(steep * fl_saturate(fl_scale(behind, 2)), 52);
    const int32_t added_c = fl_saturate(-fl_fixed(fl_times(slower, per_way), 30));
    const int64_t squares = product(a, a, 32) + product(a_then, a_then, 32); /* q24 */
    const int64_t lower = product(HALF_LN_2, (int32_t)product(share, mean, 28), 31);
    const int32_t added_t = fl_saturate(-fl_scale(lower * squares, 24));
    const int32_t keep = !turned && magnitude(by_c[4]) <= LARGEST_BY_C && magnitude(by_t[4]) <= LARGEST_BY_T;
    fl_sensitivity_step(by_c, keep, &with, added_c);
    fl_sensitivity_step(by_t, keep, &with, added_t);
    fl_sensor_step(x, (int32_t)fl_scale(f, 6), (int32_t)fl_scale(f_next, 6), sensor);
    state[AMPLITUDE] = fl_fma(gains[DECAY_LEFT], fl_subtract(a_then, command), command);
    state[COMMAND] = command;
    state[D] = d;
    state[TRUSTED] = trusted;
    state[FRICTION] = f_next;
    state[FORWARD] = forward;
    state[LOAD] = load;
    state[RISING] = rising;
    state[BEFORE] = f;
    state[COMPLIANCE] = c;
    state[FALL] = fall;
    return (fl_force_command){u, square != held};
}

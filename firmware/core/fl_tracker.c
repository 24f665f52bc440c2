#include "fl_tracker.h"

#include "fl_row.h"

/* place_of for a slow stroke, from 0.75 on: how far beyond that, q28, at most 1/2 */
static int32_t stretched(int32_t beyond, int32_t speed) {
    enum { SLOW = 5368709 }; /* 0.02 m/s */
    const int32_t far = (int32_t)fl_product(beyond, speed > SLOW ? speed : SLOW, 28);
    return far < FL_ONE / 100 ? 50 * far : FL_ONE / 2;
}

void fl_schedule(int32_t *values, int32_t share, int32_t speed, const fl_gain *table) {
    enum { ROW = 18790482, SECOND = FL_ONE / 8, QUARTER = FL_ONE / 4, QUICK = 9 * (FL_ONE / 128) }; /* 0.07 */
    const int quick = speed > QUICK, next = quick ? -FL_SCHEDULED : FL_SCHEDULED;
    int32_t row = 1, way = 0; /* from one row to the next, q31, at most all but 2^-31 */
    if (share > 3 * QUARTER) {
        row = 4;
        if (!quick) {
            const int32_t far = stretched(share - 3 * QUARTER, speed) - 1;
            row += far >> 26; /* quarters: 0 or 1 */
            way = (far & (QUARTER - 1)) * 32;
        }
    } else if (share > QUARTER) {
        const int32_t place = share - 1;
        row += place >> 26; /* quarters: 1 or 2 */
        way = (place & (QUARTER - 1)) * 32;
    } else if (share > SECOND) {
        way = (share - SECOND - 1) * 64;
    } else if (!quick) {
        row = 0;
        if (share > ROW) way = (int32_t)fl_product(share - ROW, 1220161164, 23); /* q26: 1/(0.125 - 0.07) */
    }
    /* Quick strokes come from the other end of the table, to the row of place 1.25 at 0.75. */
    const fl_gain *from = (quick ? table + FL_PLACES * FL_SCHEDULED : table) + row * next, *to = from + next;
    for (int i = 0; i < FL_SCHEDULED; i++) {
        const int32_t further = fl_subtract(to[i].mantissa, from[i].mantissa);
        values[i] = from[i].mantissa + 2 * (int32_t)(((int64_t)further * way) >> 32);
    }
}

int32_t fl_share_of(int32_t compliance, int32_t limit, int64_t way, fl_inverse *per_whole) {
    const int32_t least = 3355443; /* 0.05 N */
    const int64_t lag = (int64_t)compliance * (limit > least ? limit : least);
    const int64_t whole = way + (lag > 0 ? lag : 0);
    const int32_t bits = __builtin_clzll((uint64_t)whole);
    const int32_t factor = fl_reciprocal((uint32_t)((uint64_t)whole << bits >> 32));
    *per_whole = (fl_inverse){factor, bits};
    const int32_t part = (int32_t)((uint64_t)way << bits >> 33);
    return fl_low(((int64_t)part * factor) >> 33);
}

int32_t fl_limit_of(int32_t limit_log2, int32_t fall, int32_t amplitude) {
    const int32_t slope = fl_low(fl_product(fall, amplitude, 30)); /* q26 */
    return fl_exp2(fl_saturate(limit_log2 - fl_product(slope, amplitude, 28)), 26);
}

int32_t fl_lowering(int32_t fall, int32_t amplitude) {
    return fl_saturate(fl_product(fl_low(fl_product(fall, amplitude, 30)), amplitude, 28));
}

int32_t fl_stuck_share(int32_t friction, int32_t limit, int32_t rising, int32_t fastest, int32_t valid) {
    if (friction < 0 || !valid) return FL_ONE;
    if (4 * (int64_t)rising < fastest) return 0;
    const int32_t least = 1342177; /* 0.02 N */
    if (limit < least) limit = least;
    /* 10 below - 1 = 9 - 10 f/L */
    if (10 * (int64_t)friction >= 36 * (int64_t)limit) return 0;
    const int64_t w = 9 * (int64_t)FL_ONE - 10 * (int64_t)fl_over(friction, fl_invert(limit), 26);
    return w < 0 ? 0 : w > FL_ONE ? FL_ONE : (int32_t)w;
}

void fl_sensor_step(int32_t *x, int32_t friction, int32_t next, const fl_gain *sensor) {
    const fl_gain *one = sensor, *two = sensor + 4, *three = sensor + 8;
    const int32_t spring = x[0], rate = x[1], reading = x[2];
    x[0] = fl_sum(
        fl_term(one[0], spring) + fl_term(one[1], rate) + fl_term(one[2], friction) + fl_term(one[3], next));
    x[1] = fl_sum(
        fl_term(two[0], spring) + fl_term(two[1], rate) + fl_term(two[2], friction) + fl_term(two[3], next));
    x[2] = fl_sum(fl_term(three[0], spring) + fl_term(three[1], rate) + fl_term(three[2], reading)
        + fl_term(three[3], friction) + fl_term(three[4], next));
}

void fl_sensitivity_step(int32_t *s, int32_t keep, const fl_sensitivity *with, int32_t added) {
    if (!keep) s[0] = s[1] = s[2] = s[3] = s[4] = 0;
    const int32_t error = s[4], *k = with->k;
    s[0] = fl_saturate(s[0] - fl_product(k[0], error, 22));
    s[1] = fl_saturate(s[1] - fl_product(k[1], error, 26));
    s[2] = fl_saturate(s[2] - fl_product(k[2], error, 25));
    s[3] = fl_saturate(s[3] - fl_product(k[3], error, 26));
    s[4] = fl_saturate(s[4] - fl_product(k[4], error, 24));
    const int32_t behind = fl_saturate(fl_product(with->limit, s[0], 26) - s[1]);
    const int32_t after = fl_saturate(s[1] + fl_product(with->share, behind, 28) + added);
    fl_sensor_step(s + 2, s[1], after, with->sensor);
    s[1] = after;
}

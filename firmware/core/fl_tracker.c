#include "fl_tracker.h"

#include "fl_row.h"

int32_t fl_scheduled(int32_t share, const fl_gain *column, int32_t places) {
    static const int32_t from[] = {18790482, 33554432, 67108864, 134217728}; /* 0.07, 0.125, 0.25, 0.5 */
    uint64_t v = fl_term(column[0], FL_ONE);
    for (int k = 0; k < FL_SHARES - 1 && share > from[k]; k++) v += fl_term(column[k + 1], share - from[k]);
    return fl_saturate(fl_shift((int64_t)v, column[0].shift + 28 - places));
}

int32_t fl_share_of(int32_t compliance, int32_t limit, fl_gain per_way) {
    const int32_t least = 3355443; /* 0.05 N */
    const fl_gain lag = fl_times(fl_real((int64_t)compliance * (limit > least ? limit : least), 46), per_way);
    const int64_t share = fl_fixed(fl_inverse(fl_fixed(lag, 28) + FL_ONE, 28), 28);
    return share < FL_ONE ? (int32_t)share : FL_ONE;
}

int32_t fl_limit_of(int32_t limit_log2, int32_t fall, int32_t amplitude) {
    const int32_t slope = fl_saturate(fl_scale((int64_t)fall * amplitude, 30)); /* q26 */
    return fl_exp2(fl_saturate(limit_log2 - fl_scale((int64_t)slope * amplitude, 28)), 26);
}

int32_t fl_stuck_share(int32_t friction, int32_t limit, int32_t rising, int32_t fastest, int32_t valid) {
    if (friction < 0 || !valid) return FL_ONE;
    if (4 * (int64_t)rising < fastest) return 0;
    const int32_t least = 1342177; /* 0.02 N */
    const int64_t share = fl_product(fl_inverse(limit > least ? limit : least, 26), friction, 28, 28);
    /* 10 below - 1 = 9 - 10 f/L */
    const int64_t w = share > FL_ONE ? 0 : 9 * (int64_t)FL_ONE - 10 * share;
    return w < 0 ? 0 : w > FL_ONE ? FL_ONE : (int32_t)w;
}

void fl_sensor_step(int32_t *x, int32_t friction, int32_t next, const fl_gain *sensor) {
    const fl_gain *one = sensor, *two = sensor + 4, *three = sensor + 8;
    const int32_t spring = x[0], rate = x[1], reading = x[2];
    x[0] = fl_sum(fl_term(one[0], spring) + fl_term(one[1], rate) + fl_term(one[2], friction)
        + fl_term(one[3], next), one[0]);
    x[1] = fl_sum(fl_term(two[0], spring) + fl_term(two[1], rate) + fl_term(two[2], friction)
        + fl_term(two[3], next), two[0]);
    x[2] = fl_sum(fl_term(three[0], spring) + fl_term(three[1], rate) + fl_term(three[2], reading)
        + fl_term(three[3], friction) + fl_term(three[4], next), three[0]);
}

/* k error more, in the format that `shift` leaves. */
static int32_t corrected(int32_t x, int32_t k, int32_t error, int32_t shift) {
    return fl_saturate(x + fl_scale((int64_t)k * error, shift));
}

void fl_sensitivity_step(int32_t *s, int32_t keep, const fl_sensitivity *with, int32_t added) {
    if (!keep) s[0] = s[1] = s[2] = s[3] = s[4] = 0;
    const int32_t error = fl_subtract(0, s[4]), *k = with->k;
    s[0] = corrected(s[0], fl_mul28(with->slides, k[0]), error, 22);
    s[1] = corrected(s[1], fl_mul28(with->slides, k[1]), error, 26);
    s[2] = corrected(s[2], k[2], error, 25);
    s[3] = corrected(s[3], k[3], error, 26);
    s[4] = corrected(s[4], k[4], error, 24);
    const int32_t behind = fl_saturate(fl_scale((int64_t)with->limit * s[0], 26) - s[1]);
    const int32_t after = fl_saturate(s[1] + fl_scale((int64_t)with->share * behind, 28) + added);
    fl_sensor_step(s + 2, s[1], after, with->sensor);
    s[1] = after;
}

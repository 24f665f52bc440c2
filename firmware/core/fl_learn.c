/* What the tracker learns: control/tracker.py, compliance and fall by the sensitivities of the reading. */
#include "fl_row.h"
#include "fl_tracker.h"

enum { FORGET = 1717987 }; /* q32: 4e-4 */

int64_t fl_mean_square(int32_t *high, int32_t *low, int32_t x) {
    int64_t mean = (int64_t)(*high > 0 ? *high : 0) * (INT64_C(1) << 32) + (uint32_t)*low;
    const int64_t change = (((int64_t)x * x) >> 4) - mean;
    mean += (change >> 32) * FORGET + (int64_t)(((uint64_t)(uint32_t)change * FORGET) >> 32);
    *high = (int32_t)(mean >> 32);
    *low = (int32_t)(uint32_t)mean;
    return mean;
}

int32_t fl_learnt(fl_gain learn, int32_t error, int32_t s, int64_t mean, int32_t places, int32_t most) {
    const int32_t bits = __builtin_clzll((uint64_t)mean);
    int64_t moved = (int64_t)fl_saturate(fl_product(learn.mantissa, error, 20)) * s;
    if (moved == 0) return 0;
    const int32_t drop = 33 - __builtin_clzll((uint64_t)(moved < 0 ? -moved : moved));
    if (drop > 0) moved >>= drop;
    const int32_t down = 94 - bits + learn.shift + 6 + places - (drop > 0 ? drop : 0);
    moved *= fl_reciprocal((uint32_t)((uint64_t)mean << bits >> 32));
    if (down > 62) return 0;
    return fl_clip(fl_saturate(down < 1 ? moved : fl_scale(moved, down)), -most, most);
}

#include "fl_real.h"

/* 2^62/d for d from 2^31 on; relative error below 2^-28. */
static int32_t reciprocal(uint32_t d) {
    const uint32_t r = UINT32_MAX / (d >> 16) << 14; /* to 15 bits, below 2^31 */
    const int32_t error = (1 << 30) - (int32_t)(((uint64_t)d * r) >> 32);
    return fl_saturate(r + (((int64_t)r * error) >> 30));
}

fl_inverse fl_invert(int32_t x) {
    const int32_t bits = __builtin_clz((uint32_t)(x > 0 ? x : (x = 1)));
    return (fl_inverse){reciprocal((uint32_t)x << bits), bits};
}

fl_inverse fl_invert_long(int64_t x) {
    if (x <= INT32_MAX) return fl_invert((int32_t)(x > 0 ? x : 1));
    const int32_t bits = __builtin_clzll((uint64_t)x);
    return (fl_inverse){reciprocal((uint32_t)((uint64_t)x << bits >> 32)), bits - 32};
}

#include "fl_real.h"

fl_gain fl_real(int64_t x, int32_t places) {
    if (x == 0) return (fl_gain){0, 0};
    uint64_t size = x < 0 ? -(uint64_t)x : (uint64_t)x;
    int32_t drop = 33 - __builtin_clzll(size);
    uint32_t mantissa = (uint32_t)(drop > 0 ? size >> drop : size << -drop);
    return (fl_gain){x < 0 ? -(int32_t)mantissa : (int32_t)mantissa, places - drop};
}

fl_gain fl_times(fl_gain a, fl_gain b) {
    return (fl_gain){(int32_t)(((int64_t)a.mantissa * b.mantissa) >> 31), a.shift + b.shift - 31};
}

fl_gain fl_inverse(int64_t x, int32_t places) {
    fl_gain g = fl_real(x > 0 ? x : 1, places);
    uint32_t d = (uint32_t)g.mantissa << 1; /* 2^31 to 2^32 */
    int64_t r = (int64_t)(UINT32_MAX / (d >> 16)) << 14; /* 2^62/d to 15 bits */
    int64_t error = (INT64_C(1) << 62) - (int64_t)((uint64_t)d * (uint64_t)r);
    r += (r * (error >> 16)) >> 46;
    return (fl_gain){fl_saturate(r), 61 - g.shift};
}

int64_t fl_shift(int64_t x, int32_t shift) {
    const int64_t most = INT64_C(1) << 62;
    if (shift > 62) return 0;
    if (shift > 0) return fl_scale(x, shift);
    if (x == 0) return 0;
    if (shift < -62) return x > 0 ? most : -most;
    int64_t bound = most >> -shift;
    return x > bound ? most : x < -bound ? -most : x * (INT64_C(1) << -shift);
}

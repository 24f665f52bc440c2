/* 2^x and log2 x: the polynomials of quantities/arithmetic.py, shorter. */
#include "fl_real.h"

int32_t fl_exp2(int32_t x, int32_t places) {
    /* (2^r - 1)/r for |r| <= 1/2, q31: Chebyshev interpolation, error 8e-9. r is q32. */
    static const int32_t c[] = {1488522252, 515882497, 119193011, 20654675, 2875666, 331854};
    const int32_t whole = (x >> 26) + ((x >> 25) & 1);
    const int32_t r = (int32_t)((uint32_t)x << 6);
    int32_t sum = c[5];
    for (int k = 4; k >= 0; k--) sum = c[k] + fl_high(sum, r);
    const int32_t mantissa = (1 << 30) + (fl_high(sum, r) >> 1); /* q30, 0.7 to 1.42 */
    const int32_t down = 30 - whole - places;
    if (down < 0) return down == -1 && mantissa < 1 << 30 ? mantissa * 2 : INT32_MAX;
    return down > 31 ? 0 : mantissa >> down;
}

int32_t fl_log2(int32_t x, int32_t places) {
    /* log2 m = 2 atanh(s)/ln 2, s = (m - 1)/(m + 1), |s| < 0.172; in s^2, q29. */
    static const int32_t c[] = {1549082005, 516360668, 309816401, 221297332, 172129613};
    const int32_t bits = __builtin_clz((uint32_t)x);
    const int32_t low = (int32_t)((uint32_t)x << bits >> 1); /* q30, 1 to 2 */
    const int32_t halve = low > 1518500250; /* above sqrt 2 */
    const int32_t m = halve ? low / 2 : low; /* q30 */
    const int32_t above = m - (1 << 30);
    const fl_inverse mean = fl_invert(m / 2 + (1 << 29)); /* bits 1 or 2 */
    const int32_t s = (int32_t)(((int64_t)(above * (1 << mean.bits)) * mean.factor) >> 31); /* q32 */
    const int32_t z = fl_high(s, s);
    int32_t sum = c[4];
    for (int k = 3; k >= 0; k--) sum = c[k] + fl_high(sum, z);
    return (31 - bits - places + halve) * (1 << 26) + (fl_high(s, sum) >> 3);
}

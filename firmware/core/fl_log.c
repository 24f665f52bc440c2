/* 2^x and log2 x without tables: the polynomials of quantities/arithmetic.py, shorter. */
#include "fl_real.h"

/* a b of two q31 */
static int32_t times31(int32_t a, int32_t b) { return (int32_t)(((int64_t)a * b) >> 31); }

int32_t fl_exp2(int32_t x, int32_t places) {
    /* (2^r - 1)/r for |r| <= 1/2 , q31: Chebyshev interpolation, error 8e-9. */
    static const int32_t c[] = {1488522252, 515882497, 119193011, 20654675, 2875666, 331854};
    int32_t whole = (x >> 26) + ((x >> 25) & 1);
    int32_t r = (int32_t)((int64_t)x - (int64_t)whole * (1 << 26)) * 32;
    int32_t sum = c[5];
    for (int k = 4; k >= 0; k--) sum = c[k] + times31(sum, r);
    int32_t mantissa = (1 << 30) + (int32_t)(((int64_t)sum * r) >> 32);
    return fl_saturate(fl_shift(mantissa, 30 - whole - places));
}

int32_t fl_log2(int64_t x, int32_t places) {
    /* log2 m = 2 atanh(s)/ln 2, s = (m - 1)/(m + 1), |s| < 0.172; in s^2, q29. */
    static const int32_t c[] = {1549082005, 516360668, 309816401, 221297332, 172129613};
    fl_gain g = fl_real(x, places);
    int32_t exponent = 30 - g.shift;
    int64_t m = g.mantissa; /* 1 to 2 in q30 */
    if (m > 1518500250) { /* sqrt 2 */
        exponent += 1;
    } else {
        m *= 2;
    }
    /* now q31, sqrt 1/2 to sqrt 2 */
    const int64_t one = INT64_C(1) << 31;
    int32_t s = fl_saturate(fl_product(fl_inverse(m + one, 31), (int32_t)(m - one), 31, 31));
    int32_t z = times31(s, s);
    int32_t sum = c[4];
    for (int k = 3; k >= 0; k--) sum = c[k] + times31(sum, z);
    return exponent * (1 << 26) + (int32_t)fl_scale((int64_t)s * sum, 34);
}

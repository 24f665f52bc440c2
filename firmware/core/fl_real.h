/* Quotients and numbers of any size: an fl_gain as a small floating-point number, mantissa * 2^-shift.
 *
 * 30 significant bits. Division is by a reciprocal, 32-bit hardware division and one Newton step: a Cortex-M4 divides 32
 * bits in 2 to 12 cycles, and 64 bits in some 100 or more. */
#ifndef FL_REAL_H
#define FL_REAL_H

#include "fl_fixed.h"

/* x 2^-places as a number with 31 bits, cut off; 0 is {0, 0}. */
fl_gain fl_real(int64_t x, int32_t places);

/* a b, as far as 30 bits of either go. */
fl_gain fl_times(fl_gain a, fl_gain b);

/* 1 / (x 2^-places), relative error below 2^-28; of x <= 0 that of 1. */
fl_gain fl_inverse(int64_t x, int32_t places);

/* x 2^-shift for any shift: rounded to the nearest, within +-2^62. */
int64_t fl_shift(int64_t x, int32_t shift);

/* g with `places` binary places. */
static inline int64_t fl_fixed(fl_gain g, int32_t places) { return fl_shift(g.mantissa, g.shift - places); }

/* g x, x with `from` binary places and the product with `to`. */
static inline int64_t fl_product(fl_gain g, int32_t x, int32_t from, int32_t to) {
    return fl_shift((int64_t)g.mantissa * x, g.shift + from - to);
}

/* 2^x with `places` binary places, x in q26; relative error below 1e-8 (or half a step), saturates. */
int32_t fl_exp2(int32_t x, int32_t places);

/* log2(x 2^-places) in q26, x > 0; error below 2e-8. */
int32_t fl_log2(int64_t x, int32_t places);

#endif

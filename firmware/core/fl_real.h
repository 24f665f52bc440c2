/* Quotients, powers and logarithms without tables.
 *
 * Division is by a reciprocal: 32-bit hardware division for half of the bits, and one Newton step. A
 * Cortex-M4 divides 32 bits in 2 to 12 cycles, and 64 bits in some 100 or more. */
#ifndef FL_REAL_H
#define FL_REAL_H

#include "fl_fixed.h"

/* 1/x = factor 2^(bits - 62). */
typedef struct { int32_t factor, bits; } fl_inverse;

/* 2^62/d for d from 2^31 on; too small by a relative 2^-28 at most. */
static inline int32_t fl_reciprocal(uint32_t d) {
    const int32_t r = (int32_t)(UINT32_MAX / (d >> 16) << 14); /* to 15 bits, below 2^31 */
    const int32_t error = (1 << 30) - 1 - (int32_t)(((uint64_t)d * (uint32_t)r) >> 32);
    return r + (int32_t)(((int64_t)r * error) >> 30);
}

/* 1/x of x > 0, relative error below 2^-28, bits = 0 to 31; of x < 1 that of 1. */
static inline fl_inverse fl_invert(int32_t x) {
    const uint32_t size = x > 0 ? (uint32_t)x : 1;
    const int32_t bits = __builtin_clz(size);
    return (fl_inverse){fl_reciprocal(size << bits), bits};
}

/* a/x 2^places, rounded down: places = 0 to 31. */
static inline int64_t fl_over(int32_t a, fl_inverse x, int32_t places) {
    return ((int64_t)a * x.factor) >> (62 - places - x.bits);
}

/* a b 2^-32: one instruction */
static inline int32_t fl_high(int32_t a, int32_t b) { return (int32_t)(((int64_t)a * b) >> 32); }

/* a/x in q28 of |a/x| below 1, with the bits of fl_over; x below 2^31 has a bit to spare. */
static inline int32_t fl_share(int32_t a, fl_inverse x) {
    return fl_high((int32_t)((uint32_t)a << (x.bits - 1)), x.factor) >> 1;
}

/* a/x in q28 of |a/x| below 8, likewise. */
static inline int32_t fl_ratio(int32_t a, fl_inverse x) {
    return x.bits < 4 ? (int32_t)fl_over(a, x, 28)
                      : (int32_t)(((int64_t)(int32_t)((uint32_t)a << (x.bits - 4)) * x.factor) >> 30);
}

/* 2^x with `places` binary places, x in q26; relative error below 1e-8 (or a step), saturates. */
int32_t fl_exp2(int32_t x, int32_t places);

/* log2(x 2^-places) in q26, x > 0; error below 3e-8. */
int32_t fl_log2(int32_t x, int32_t places);

#endif

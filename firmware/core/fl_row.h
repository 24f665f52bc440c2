/* Products with a constant shift: what laws with many terms are made of (some 5 instructions of a Cortex-M4
 * each, where fl_mul with its shift from memory takes 30).
 *
 * A row is a sum of products in 64 bits, rounded once: its coefficients have FL_ROW binary places,
 * magnitude below 8 and together below 16. Where terms or result have other places than 28, the
 * coefficients hold the difference (firmware/quantised.py). */
#ifndef FL_ROW_H
#define FL_ROW_H

#include "fl_fixed.h"

enum { FL_ROW = 28 };

/* The lower word: for what cannot be larger, by the bounds of its terms. */
static inline int32_t fl_low(int64_t x) { return (int32_t)((uint64_t)x & UINT32_MAX); }

/* a b 2^-shift, rounded down; shift 0 to 62. */
static inline int64_t fl_product(int32_t a, int32_t b, int32_t shift) { return ((int64_t)a * b) >> shift; }

/* c x, one term more of a row; sums beyond 64 bits, of coefficients that break the rule, wrap around. */
static inline uint64_t fl_term(fl_gain c, int32_t x) { return (uint64_t)((int64_t)c.mantissa * x); }

/* What a row is. */
static inline int32_t fl_sum(uint64_t terms) {
    return fl_saturate((int64_t)(terms + (UINT64_C(1) << (FL_ROW - 1))) >> FL_ROW);
}

#endif

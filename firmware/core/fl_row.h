/* Rows of a matrix: products summed in 64 bits and rounded once.
 *
 * The coefficients of a row have one shift, that of the first, and they are so small that the sum cannot overflow:
 * the magnitudes of its mantissas add up to less than 2^31 (others wrap around). Where terms or result have other binary places than 28,
 * the coefficients hold the difference (control/quantised.py, to_row). */
#ifndef FL_ROW_H
#define FL_ROW_H

#include "fl_fixed.h"

/* c x, one term more of a sum */
static inline uint64_t fl_term(fl_gain c, int32_t x) { return (uint64_t)((int64_t)c.mantissa * x); }

/* What a sum of such terms is, with the row's shift. */
static inline int32_t fl_sum(uint64_t terms, fl_gain first) {
    return fl_saturate(fl_scale((int64_t)terms, first.shift));
}

#endif

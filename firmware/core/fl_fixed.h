/* Fixed point: the same bits from every compiler and processor.
 *
 * A signal is an int32_t in q28: 2^-28 of its unit (N, um, m/s, m), up to 8, in steps of 3.7e-9.
 * A coefficient is an fl_gain: mantissa * 2^-shift, so that any size keeps 30 bits.
 * Sums and products saturate. No float, no division by zero, no shift of a negative number to the left.
 * Shifts of negative numbers to the right are arithmetic with every compiler we build with (checked at build time). */
#ifndef FL_FIXED_H
#define FL_FIXED_H

#include <stdint.h>

typedef struct { int32_t mantissa, shift; } fl_gain;

#define FL_ONE (1 << 28)
_Static_assert((-3 >> 1) == -2, "shifts to the right must be arithmetic");

/* Within 32 bits the upper half is all sign. Compilers make two comparisons of 64 bits of this, whatever the C says. */
static inline int32_t fl_saturate(int64_t x) {
    int32_t low = (int32_t)((uint64_t)x & UINT32_MAX);
    return low == x ? low : (int32_t)(x >> 63) ^ INT32_MAX;
}

/* The sum of two int32_t, written as compilers know one instruction for. */
static inline int32_t fl_clip_sum(int64_t x) {
    return x > INT32_MAX ? INT32_MAX : x < INT32_MIN ? INT32_MIN : (int32_t)x;
}

static inline int32_t fl_add(int32_t a, int32_t b) { return fl_clip_sum((int64_t)a + b); }

static inline int32_t fl_subtract(int32_t a, int32_t b) { return fl_clip_sum((int64_t)a - b); }

static inline int32_t fl_clip(int32_t x, int32_t low, int32_t high) { return x < low ? low : x > high ? high : x; }

/* As fl_scale, for a shift of 0 or -1: hardly any gain has it, so it has no place in every product. */
int64_t fl_scale_up(int64_t product, int32_t shift);

/* x * 2^-shift, rounded to the nearest, halves up; shift -1 to 62. */
static inline int64_t fl_scale(int64_t product, int32_t shift) {
    if (shift <= 0) return fl_scale_up(product, shift);
    return ((product >> (shift - 1)) + 1) >> 1;
}

/* g x */
static inline int32_t fl_mul(fl_gain g, int32_t x) { return fl_saturate(fl_scale((int64_t)g.mantissa * x, g.shift)); }

/* g x + b */
static inline int32_t fl_fma(fl_gain g, int32_t x, int32_t b) {
    return fl_saturate(fl_scale((int64_t)g.mantissa * x, g.shift) + b);
}

/* a b of two q28 */
static inline int32_t fl_mul28(int32_t a, int32_t b) { return fl_saturate(fl_scale((int64_t)a * b, 28)); }

/* Quotient of whole numbers, rounded down; bit by bit, for the background. */
uint64_t fl_divide(uint64_t x, uint32_t by);

/* Square root of a whole number, rounded down. */
uint32_t fl_root(uint64_t x);

#endif

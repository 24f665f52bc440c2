/* Square root without division by more than 32 bits: the upper half by digits, the lower half by one division
 * (P. Zimmermann, Karatsuba Square Root, INRIA report 3805, 1999). */
#include "fl_fixed.h"

/* Digit by digit, two bits of x each; rounded down. */
static uint32_t root_32(uint32_t x) {
    uint32_t root = 0;
    for (uint32_t bit = 1u << 30; bit != 0; bit >>= 2) {
        if (x >= root + bit) {
            x -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return root;
}

uint32_t fl_root(uint64_t x) {
    if (x == 0) return 0;
    uint32_t pairs = 0; /* of leading zero bits; the division wants a one among the first two bits */
    for (uint32_t step = 16; step != 0; step >>= 1) {
        if (x >> (64 - 2 * step) == 0) {
            x <<= 2 * step;
            pairs += step;
        }
    }
    uint32_t high = (uint32_t)(x >> 32), next = (uint32_t)x >> 16, last = (uint32_t)x & 0xffff;
    uint32_t root = root_32(high), rest = high - root * root; /* rest <= 2 root < 2^17 */
    /* (rest 2^16 + next) / (2 root), both halved to fit 32 bits */
    uint32_t half = (rest << 15) | (next >> 1);
    uint32_t quotient = half / root;
    rest = (half - quotient * root) * 2 + (next & 1);
    root = (root << 16) + quotient; /* of 2^32 the lower 32 bits, 0: the correction below then makes it 2^32 - 1 */
    if ((((uint64_t)rest << 16) | last) < (uint64_t)quotient * quotient) root -= 1;
    return root >> pairs;
}

int64_t fl_scale_up(int64_t product, int32_t shift) {
    return shift == 0 ? product : (int64_t)fl_saturate(product) * 2; /* all callers saturate */
}

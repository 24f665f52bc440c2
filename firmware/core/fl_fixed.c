/* Square root without division by more than 32 bits: the upper half by Newton's steps, the lower half by one division
 * (P. Zimmermann, Karatsuba Square Root, INRIA report 3805, 1999). */
#include "fl_fixed.h"

/* Of x >= 2^30, rounded down: Newton's steps for y^2 = x from y = x/(3 2^15) + 3 2^13, at most 9 % above the root. Two
 * leave it at most 1 above. */
static uint32_t root_32(uint32_t x) {
    uint32_t root = x / 98304 + 24576;
    root = (root + x / root) / 2;
    root = (root + x / root) / 2;
    return root > 65535 || root * root > x ? root - 1 : root;
}

uint32_t fl_root(uint64_t x) {
    if (x == 0) return 0;
    uint32_t pairs = (uint32_t)__builtin_clzll(x) / 2; /* the division wants a one among the first two bits */
    x <<= 2 * pairs;
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

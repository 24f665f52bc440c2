/* In the place of the compiler's own division of 64 bits, which is quick, and as large as a control law. */
#include "fl_fixed.h"

uint64_t fl_divide(uint64_t x, uint32_t by) {
    uint64_t rest = 0;
    for (int bit = 0; bit < 64; bit++) {
        rest = rest << 1 | x >> 63;
        x <<= 1;
        if (rest >= by) {
            rest -= by;
            x |= 1;
        }
    }
    return x;
}

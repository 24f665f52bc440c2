/* Mirrors table_position and interpolate_step of control/lookup.py.
 *
 * The square of the amplitude is tabulated: a(u) has a vertical tangent at u = f0, where a^2 is smooth. */
#include "fl_lookup.h"

int32_t fl_lookup(int32_t u, const int32_t *squares, fl_gain cells_per_n, int32_t low_n) {
    const int64_t end = (int64_t)FL_CELLS << 28;
    int64_t position = fl_scale((int64_t)cells_per_n.mantissa * fl_subtract(u, low_n), cells_per_n.shift);
    position = position < 0 ? 0 : position > end ? end : position;
    int32_t cell = (int32_t)(position >> 28);
    if (cell == FL_CELLS) cell = FL_CELLS - 1;
    int32_t fraction = (int32_t)(position - ((int64_t)cell << 28));
    int32_t rise = fl_subtract(squares[cell + 1], squares[cell]);
    int32_t square = fl_add(squares[cell], fl_mul28(fraction, rise));
    if (square <= 0) return 0;
    /* sqrt(s 2^-25) 2^28 = sqrt(s 2^31) */
    uint32_t root = fl_root((uint64_t)square << 31);
    return root > INT32_MAX ? INT32_MAX : (int32_t)root;
}

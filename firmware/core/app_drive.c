/* Amplitude to duty of the carrier, whose fundamental goes with the sine of it: a table with the arcsine,
 * linear between 257 amplitudes. It is part of the image, so that no host can put more on the pin than it says. */
#include "fl_app_parts.h"
#include "fl_duty.h"

enum { CELLS = 256 };

/* Cells an amplitude with 30 bits: a position of 16 binary places is mantissa a 2^-shift. */
fl_derived fl_derive(const fl_parameters *p) {
    fl_derived derived = {{0, 0}, 0, 0, {0}, fl_derive_easing(p)};
    fl_derive_ends(derived.ends, p);
    if (p->drive_largest_um <= 0) return derived;
    int32_t places = 0;
    while (p->drive_largest_um >> places > 1) places++;
    uint64_t mantissa = fl_divide((uint64_t)1 << (30 + places), (uint32_t)p->drive_largest_um);
    derived.cells_per_um = (fl_gain){(int32_t)mantissa, 30 + places - 24};
    derived.rise_um = p->drive_largest_um / FL_RISE_TICKS + 1;
    derived.ceiling_duty = INT32_MAX;
    derived.ceiling_duty = fl_duty(&derived, p->drive_ceiling_um);
    return derived;
}

int32_t fl_duty(const fl_derived *derived, int32_t amplitude) {
    fl_gain cells = derived->cells_per_um;
    int64_t position = fl_scale((int64_t)cells.mantissa * amplitude, cells.shift);
    position = position < 0 ? 0 : position > (CELLS << 16) ? CELLS << 16 : position;
    int32_t cell = (int32_t)(position >> 16);
    if (cell == CELLS) cell = CELLS - 1;
    int32_t share = (int32_t)position - (cell << 16), rise = fl_duties[cell + 1] - fl_duties[cell];
    int32_t duty = fl_duties[cell] + (int32_t)fl_scale((int64_t)rise * share, 16);
    return duty < derived->ceiling_duty ? duty : derived->ceiling_duty;
}

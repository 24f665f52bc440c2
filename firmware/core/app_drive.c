/* Amplitude to duty of the carrier, whose fundamental goes with the sine of it: a table with the arcsine,
 * linear between 257 amplitudes. It is part of the image, so that no host can put more on the pin than it says. */
#include "fl_app_parts.h"
#include "fl_duty.h"

enum { CELLS = 256 };

/* What the set-point may move in a tick while one effect gives way to another: the band of the law in the time of the
 * longest ramp of the drive. */
static double easing(const fl_parameters *p) {
    return (p->law_high_n - p->law_low_n) * p->drive_ramp_um / p->drive_largest_um;
}

fl_derived fl_derive(const fl_parameters *p) {
    fl_derived derived = {0};
    fl_derive_ends(derived.ends, p);
    if (p->drive_largest_um <= 0) return derived;
    derived.easing = easing(p);
    derived.cells_per_um = CELLS / p->drive_largest_um;
    derived.rise_um = p->drive_largest_um / FL_RISE_TICKS;
    derived.ceiling_duty = INT32_MAX;
    derived.ceiling_duty = fl_duty(&derived, p->drive_ceiling_um);
    return derived;
}

int32_t fl_duty(const fl_derived *derived, double amplitude) {
    double position = fl_clip(derived->cells_per_um * amplitude, 0, CELLS);
    int32_t cell = (int32_t)position;
    if (cell == CELLS) cell = CELLS - 1;
    double rise = fl_duties[cell + 1] - fl_duties[cell];
    int32_t duty = fl_duties[cell] + (int32_t)(rise * (position - cell) + 0.5);
    return duty < derived->ceiling_duty ? duty : derived->ceiling_duty;
}

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

/* What a force can bend a reading by in a tick, in counts: springs swing with |x''| <= w^2 (|f| + |x|) (1 + 1/(2 Q)),
 * both within the range, Q above 10 (assumed); they jump by w T of the range. No less than a sixteenth: noise (assumed). */
static int32_t bend(const fl_parameters *p) {
    double range = 32768 * fl_size(p->force_n_per_count[0]), jump = p->safety_force_jump_n;
    if (jump >= 2 * range) return INT32_MAX / 4;
    double share = 2.1 * (jump / range) * (jump / range);
    return (int32_t)(32768 * (share > 1.0 / 16 ? share : 1.0 / 16));
}

fl_derived fl_derive(const fl_parameters *p) {
    fl_derived derived = {0};
    fl_derive_ends(derived.ends, p);
    derived.bend_counts = bend(p);
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

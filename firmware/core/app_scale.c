/* Converter counts to newtons and metres.
 *
 * The force a law gets is the component along the motion, positive when it opposes it
 * (sensing/measurement.py). With one axis that is what the first channel has to be; a sensor that is fixed
 * to the bench reads the other sign on the way back, and is used with two axes: their magnitude is friction
 * whatever the direction, and a channel that does not exist has gain 0. */
#include "fl_app_parts.h"

int32_t fl_counts(fl_gain unit_per_count, int32_t counts) {
    int64_t product = (int64_t)unit_per_count.mantissa * counts;
    if (unit_per_count.shift >= 28) return fl_saturate(fl_scale(product, unit_per_count.shift - 28));
    return fl_saturate((int64_t)fl_saturate(product) * ((int64_t)1 << (28 - unit_per_count.shift)));
}

static int32_t channel(const fl_parameters *p, const fl_sample *sample, int k) {
    int32_t counts = fl_clip(sample->force[k], INT16_MIN, INT16_MAX);
    return fl_counts(p->force_n_per_count[k], counts - p->force_zero_counts[k]);
}

int32_t fl_force(const fl_parameters *p, const fl_sample *sample) {
    int32_t x = channel(p, sample, 0);
    if (p->force_axes == 1) return x;
    int32_t y = channel(p, sample, 1);
    uint32_t magnitude = fl_root((uint64_t)((int64_t)x * x) + (uint64_t)((int64_t)y * y));
    return magnitude > INT32_MAX ? INT32_MAX : (int32_t)magnitude;
}

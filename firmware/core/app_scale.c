/* Converter counts to newtons and metres.
 *
 * The force a law gets is the component along the motion, positive when it opposes it
 * (sensing/measurement.py). With one axis that is what the first channel has to be; a sensor that is fixed
 * to the bench reads the other sign on the way back, and is used with two axes: their magnitude is friction
 * whatever the direction, and a channel that does not exist has gain 0. */
#include "fl_app_parts.h"

#include <math.h>

static double channel(const fl_parameters *p, const fl_sample *sample, int k) {
    return p->force_n_per_count[k] * (fl_clip_whole(sample->force[k], INT16_MIN, INT16_MAX) - p->force_zero_counts[k]);
}

double fl_force(const fl_parameters *p, const fl_sample *sample) {
    double x = channel(p, sample, 0);
    if (p->force_axes == 1) return x;
    double y = channel(p, sample, 1);
    return sqrt(x * x + y * y);
}

/* The core as a shared library. Everything is doubles, so that a caller needs no structures: `words` is the parameter table
 * (fl_parameters), a measurement five numbers (fl_measurement). */
#ifndef FL_HOST_H
#define FL_HOST_H

#include <stddef.h>

#include "fl_app.h"

/* `count` ticks of law, lookup and overdrive, one after the other, the loop open below tick `open_until`: states of the law
 * after each, and out u, saturated and amplitude command. Ramps, touch and faults are fl_app's. */
void fl_host_run(
    const double *words, size_t count, size_t open_until, const double *measurements, const double *setpoints,
    double *states, double *out);

/* What a tick had: measurement, set-point, u, saturated, amplitude, then the state of the law. */
void fl_host_last(const fl_app *app, double *out);

/* An effect of `size` words, from its beginning: `count` ticks, of each place (mm), speed (m/s) and load; `limits` are the
 * load that touches and the clamp; out are the forces. Returns the index of the first word that is wrong, else -1. */
int32_t fl_host_effect(
    const int16_t *words, uint32_t size, size_t count, const double *touches, const double *limits, double *out);

#endif

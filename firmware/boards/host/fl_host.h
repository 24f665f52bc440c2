/* The core as a shared library: one tick, or many in one call. Everything is int32_t, so that a caller needs no
 * structures: `words` is the parameter table (fl_parameters), `measurement` five words (fl_measurement).
 *
 * The amplitude goes through lookup and overdrive, up to drive.ceiling_um; ramps, touch and faults are fl_app's. */
#ifndef FL_HOST_H
#define FL_HOST_H

#include <stddef.h>

#include "fl_protocol.h"

/* How many states the law of a number has; -1 where it is not built in. */
int32_t fl_host_states(uint32_t number);

/* Binary places of a state. */
int32_t fl_host_places(uint32_t number, uint32_t index);

/* Law, lookup and overdrive: the amplitude command in um; `state` and `believed` (um) go on by one period. */
int32_t fl_host_tick(
    const int32_t *words, int32_t *state, int32_t *believed, const int32_t *measurement, int32_t setpoint);

/* The same for a loop that is opened and closed (fl_switch.h): `closing` goes on too, out is u and saturated. */
int32_t fl_host_switched(
    const int32_t *words, int32_t *state, int32_t *believed, int32_t *closing, const int32_t *measurement,
    int32_t setpoint, int32_t closed, int32_t *out);

/* `count` ticks one after the other; out is u, saturated and amplitude command of each. */
void fl_host_run(
    const int32_t *words, size_t count, int32_t *state, int32_t *believed, const int32_t *measurements,
    const int32_t *setpoints, int32_t *out);

/* `count` steps of the law alone, each from a state of its own (row by row); out is u and saturated of each. */
void fl_host_steps(
    const int32_t *words, size_t count, int32_t *states, const int32_t *measurements, const int32_t *setpoints,
    int32_t *out);

/* Amplitudes at `count` forces. */
void fl_host_lookup(const int32_t *words, size_t count, const int32_t *forces, int32_t *amplitudes);

/* `count` amplitude commands, each from a belief of its own, which goes on by one period. */
void fl_host_overdrive(
    const int32_t *words, size_t count, int32_t *believed, const int32_t *wanted, int32_t *commands);

/* An effect of `size` words, from its beginning: `count` ticks, of each place (2^-32 m), speed and load; `limits` are the
 * load that touches and the clamp; out are the forces. Returns the index of the first word that is wrong, else -1. */
int32_t fl_host_effect(
    const int16_t *words, uint32_t size, size_t count, const int32_t *touches, const int32_t *limits, int32_t *out);

/* A tick for a simulator with floating point: see simulated.c. */
void fl_host_simulated(int32_t *context, double *given);

/* Square roots, for tests. */
void fl_host_roots(size_t count, const uint64_t *squares, uint32_t *roots);

#endif

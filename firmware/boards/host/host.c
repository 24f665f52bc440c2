/* See fl_host.h. */
#include "fl_host.h"

#include <string.h>

#include "fl_effect.h"
#include "fl_law.h"
#include "fl_lookup.h"
#include "fl_overdrive.h"
#include "fl_switch.h"

enum { MEASURED = 5 };
_Static_assert(sizeof(fl_parameters) == 4 * FL_WORDS, "a parameter table is its words");
_Static_assert(sizeof(fl_measurement) == 4 * MEASURED, "a measurement is its words");

static const fl_parameters *table(const int32_t *words) { return (const fl_parameters *)words; }

static fl_force_command decide(
    const fl_parameters *p, int32_t *state, const int32_t *measurement, int32_t setpoint) {
    fl_clamp clamp = {p->law_low_n, p->law_high_n};
    const fl_measurement *measured = (const fl_measurement *)measurement;
    return fl_laws[p->law_number].step(state, measured, setpoint, p->law_gains, clamp);
}

static int32_t drive(const fl_parameters *p, int32_t *believed, int32_t force) {
    int32_t wanted = fl_lookup(force, p->lookup_squares_um2, p->lookup_cells_per_n, p->law_low_n);
    return fl_overdrive(believed, wanted, p->overdrive_decay, p->overdrive_inverse, p->drive_ceiling_um);
}

int32_t fl_host_switched(
    const int32_t *words, int32_t *state, int32_t *believed, int32_t *closing, const int32_t *measurement,
    int32_t setpoint, int32_t closed, int32_t *out) {
    const fl_parameters *p = table(words);
    const fl_measurement *measured = (const fl_measurement *)measurement;
    fl_force_command command = fl_switched(p, state, closing, closed, measured, setpoint);
    out[0] = command.force;
    out[1] = command.saturated;
    return drive(p, believed, command.force);
}

int32_t fl_host_states(uint32_t number) {
    return number < fl_law_count && fl_laws[number].step ? fl_laws[number].states : -1;
}

int32_t fl_host_places(uint32_t number, uint32_t index) {
    return fl_laws[number].places ? fl_laws[number].places[index] : 28;
}

int32_t fl_host_tick(
    const int32_t *words, int32_t *state, int32_t *believed, const int32_t *measurement, int32_t setpoint) {
    return drive(table(words), believed, decide(table(words), state, measurement, setpoint).force);
}

void fl_host_run(
    const int32_t *words, size_t count, int32_t *state, int32_t *believed, const int32_t *measurements,
    const int32_t *setpoints, int32_t *out) {
    const fl_parameters *p = table(words);
    for (size_t k = 0; k < count; k++, out += 3) {
        fl_force_command command = decide(p, state, measurements + MEASURED * k, setpoints[k]);
        out[0] = command.force;
        out[1] = command.saturated;
        out[2] = drive(p, believed, command.force);
    }
}

void fl_host_steps(
    const int32_t *words, size_t count, int32_t *states, const int32_t *measurements, const int32_t *setpoints,
    int32_t *out) {
    const fl_parameters *p = table(words);
    for (size_t k = 0; k < count; k++, states += fl_laws[p->law_number].states, out += 2) {
        fl_force_command command = decide(p, states, measurements + MEASURED * k, setpoints[k]);
        out[0] = command.force;
        out[1] = command.saturated;
    }
}

void fl_host_lookup(const int32_t *words, size_t count, const int32_t *forces, int32_t *amplitudes) {
    const fl_parameters *p = table(words);
    for (size_t k = 0; k < count; k++)
        amplitudes[k] = fl_lookup(forces[k], p->lookup_squares_um2, p->lookup_cells_per_n, p->law_low_n);
}

void fl_host_overdrive(
    const int32_t *words, size_t count, int32_t *believed, const int32_t *wanted, int32_t *commands) {
    const fl_parameters *p = table(words);
    for (size_t k = 0; k < count; k++)
        commands[k] = fl_overdrive(
            believed + k, wanted[k], p->overdrive_decay, p->overdrive_inverse, p->drive_ceiling_um);
}

int32_t fl_host_effect(
    const int16_t *words, uint32_t size, size_t count, const int32_t *touches, const int32_t *limits, int32_t *out) {
    fl_store store = {{0}};
    fl_effect effect = {0};
    if (size > FL_POINTS) return FL_POINTS;
    memcpy(store.points, words, sizeof *words * size);
    int32_t wrong = fl_effect_wrong(&store, (uint16_t)size);
    if (wrong >= 0) return wrong;
    for (size_t k = 0; k < count; k++, touches += 3) {
        fl_measurement m = {.speed = touches[1], .load = touches[2]};
        out[k] = fl_effect_force(&effect, &store, touches[0], &m, limits[0], (fl_clamp){limits[1], limits[2]});
    }
    return -1;
}

void fl_host_roots(size_t count, const uint64_t *squares, uint32_t *roots) {
    for (size_t k = 0; k < count; k++) roots[k] = fl_root(squares[k]);
}

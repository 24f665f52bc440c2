/* See fl_host.h. */
#include "fl_app_state.h"
#include "fl_host.h"

#include <string.h>

enum { MEASURED = 5, OUT = 3 };
_Static_assert(sizeof(fl_parameters) == sizeof(double) * FL_WORDS, "a parameter table is its words");
_Static_assert(sizeof(fl_measurement) == sizeof(double) * MEASURED, "a measurement is its words");

void fl_host_run(
    const double *words, size_t count, size_t open_until, const double *measurements, const double *setpoints,
    double *states, double *out) {
    const fl_parameters *p = (const fl_parameters *)words;
    fl_clamp whole = {p->law_low_n, p->law_high_n};
    double state[FL_STATES], believed = 0;
    memcpy(state, p->law_start, sizeof state);
    for (size_t k = 0; k < count; k++, states += fl_own.states, out += OUT) {
        const fl_measurement *m = (const fl_measurement *)(measurements + MEASURED * k);
        int32_t since = k < open_until ? -1 : open_until ? (int32_t)(k - open_until) : fl_closing;
        fl_clamp clamp = fl_switched_clamp(setpoints[k], whole, since < fl_closing ? since : fl_closing);
        if (since == 0) fl_own_begin(state, clamp.low, setpoints[k], p, clamp);
        fl_force_command command = fl_own_step(state, m, setpoints[k], p, clamp);
        memcpy(states, state, sizeof(double) * fl_own.states);
        out[0] = command.force;
        out[1] = command.saturated;
        out[2] = fl_overdrive(&believed, fl_look_up(command.force, p), p->drive_ceiling_um, p);
    }
}

void fl_host_last(const fl_app *app, double *out) {
    memcpy(out, &app->measured, sizeof app->measured);
    out += MEASURED;
    *out++ = app->setpoint;
    *out++ = app->command.force;
    *out++ = app->command.saturated;
    *out++ = app->amplitude;
    memcpy(out, app->law_state, sizeof(double) * fl_own.states);
}

int32_t fl_host_effect(
    const int16_t *words, uint32_t size, size_t count, const double *touches, const double *limits, double *out) {
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

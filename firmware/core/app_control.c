/* The tick: sample -> measurement -> set-point -> law -> amplitude -> duty.
 *
 * Open: u is the set-point within the clamp. Closed: the law's. The change between them has no bump upwards
 * in amplitude: a law begins with its start words, a PI law with the integral at what open loop commands,
 * and for FL_CLOSING ticks the lower clamp comes down from there to where it belongs, so that the amplitude
 * begins with at most what the set-point asks for. Its anti-windup knows the clamp. Opening again commands
 * what the set-point asks for. Idle and fault: the amplitude falls by drive.ramp_um a tick to 0. */
#include "fl_app_parts.h"
#include "fl_lookup.h"
#include "fl_overdrive.h"

enum { PI = 1, FILTERED_PI = 3 }; /* laws whose first state is the integral in N */

static void close_loop(fl_app *app, const fl_parameters *p, int32_t open) {
    const fl_law *law = &fl_laws[p->law_number];
    for (int k = 0; k < FL_STATES; k++) app->law_state[k] = p->law_start[k];
    app->closing = FL_CLOSING;
    if (p->law_number != PI && p->law_number != FILTERED_PI) return;
    int finer = (law->places ? law->places[0] : 28) - 28;
    app->law_state[0] = finer < 0 ? open >> -finer : fl_saturate((int64_t)open * ((int64_t)1 << finer));
}

static fl_force_command decide(
    fl_app *app, const fl_parameters *p, const fl_measurement *m, int32_t setpoint) {
    int32_t open = fl_clip(setpoint, p->law_low_n, p->law_high_n);
    if (app->state == FL_STATE_OPEN) return (fl_force_command){open, open != setpoint};
    if (app->state != FL_STATE_CLOSED) return (fl_force_command){p->law_high_n, 0};
    if (app->closing < 0) close_loop(app, p, open);
    int32_t down = (int32_t)((int64_t)(open - p->law_low_n) * app->closing / FL_CLOSING);
    if (app->closing > 0) app->closing--;
    fl_clamp clamp = {p->law_low_n + down, p->law_high_n};
    return fl_laws[p->law_number].step(app->law_state, m, setpoint, p->law_gains, clamp);
}

/* The amplitude command, never above the ceiling. */
static int32_t amplitude(fl_app *app, const fl_parameters *p, int32_t force) {
    int32_t command;
    if (app->state == FL_STATE_OPEN || app->state == FL_STATE_CLOSED) {
        int32_t wanted = fl_lookup(force, p->lookup_squares_um2, p->lookup_cells_per_n, p->law_low_n);
        command = fl_overdrive(
            &app->believed, wanted, p->overdrive_decay, p->overdrive_inverse, p->drive_ceiling_um);
    } else {
        command = fl_clip(fl_subtract(app->amplitude, p->drive_ramp_um), 0, p->drive_ceiling_um);
        app->believed = fl_add(command, fl_mul28(p->overdrive_decay, fl_subtract(app->believed, command)));
    }
    return fl_clip(command, 0, p->drive_ceiling_um);
}

fl_drive fl_app_tick(fl_app *app, const fl_sample *sample, uint32_t now_us, int32_t late) {
    app->tick++;
    fl_parameters_take(app);
    fl_waveform_take(app);
    const fl_parameters *p = fl_in_force(app);
    int32_t position = fl_counts(p->touch_m_per_count, sample->position);
    int32_t load = fl_counts(p->touch_n_per_count, fl_subtract(sample->load, p->touch_zero_counts));
    fl_measurement m = fl_touch_step(&app->touch, p, position, load, fl_force(p, sample));
    fl_watch_step(app, sample, &m, late);
    fl_state_step(app, sample, &m, now_us);
    int32_t setpoint = fl_setpoint(app, position);
    fl_force_command command = decide(app, p, &m, setpoint);
    app->amplitude = amplitude(app, p, command.force);
    fl_keep(app, &m, setpoint, command);
    int32_t duty = fl_duty(p, &app->derived[app->parameters.in_force], app->amplitude);
    return (fl_drive){duty, app->amplitude};
}

/* The tick: sample -> measurement -> set-point -> law -> amplitude -> duty.
 *
 * Open: u is the set-point within the clamp. Closed: the law's. The law begins with its start words when
 * the loop goes on. While it is open, the law runs along with both ends of its clamp at what is commanded,
 * so that its observers know what goes on. When it closes, an integral begins with what open loop commands,
 * and for FL_CLOSING ticks the lower clamp comes down from there to where it belongs: the amplitude begins
 * with at most what the set-point asks for, and the law's anti-windup knows why. Opening again commands
 * what the set-point asks for. Idle and fault: the amplitude falls by drive.ramp_um a tick to 0. */
#include <string.h>

#include "fl_app_parts.h"
#include "fl_lookup.h"
#include "fl_overdrive.h"
#include "laws.h"

static void begin(fl_app *app, const fl_parameters *p) {
    memcpy(app->law_state, p->law_start, sizeof app->law_state);
    app->law_runs = 1;
    app->closing = -1;
}

/* The clamp of the law while it closes; `open` is what open loop would command. */
static fl_clamp closing(fl_app *app, const fl_parameters *p, int32_t open, int32_t setpoint) {
    if (app->closing < 0) {
        fl_begin *integral = fl_begins[p->law_number];
        if (integral) integral(app->law_state, open, setpoint, p->law_gains);
        app->closing = FL_CLOSING;
    }
    int32_t down = (int32_t)((int64_t)(open - p->law_low_n) * app->closing / FL_CLOSING);
    if (app->closing > 0) app->closing--;
    return (fl_clamp){p->law_low_n + down, p->law_high_n};
}

static fl_force_command decide(
    fl_app *app, const fl_parameters *p, const fl_measurement *m, int32_t setpoint) {
    int32_t open = fl_clip(setpoint, p->law_low_n, p->law_high_n);
    if (app->state != FL_STATE_OPEN && app->state != FL_STATE_CLOSED) {
        app->law_runs = 0;
        return (fl_force_command){p->law_high_n, 0};
    }
    if (!app->law_runs) begin(app, p);
    fl_step *step = fl_laws[p->law_number].step;
    if (app->state == FL_STATE_CLOSED)
        return step(app->law_state, m, setpoint, p->law_gains, closing(app, p, open, setpoint));
    step(app->law_state, m, setpoint, p->law_gains, (fl_clamp){open, open});
    app->closing = -1;
    return (fl_force_command){open, open != setpoint};
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

/* The tick: sample -> measurement -> set-point -> law -> amplitude -> duty.
 *
 * The law begins with its start words when the loop goes on, open or closed (fl_switch.h). Opening again commands
 * what the set-point asks for. Idle and fault: the amplitude falls by drive.ramp_um a tick to 0. */
#include <string.h>

#include "fl_app_parts.h"
#include "fl_lookup.h"
#include "fl_overdrive.h"
#include "fl_switch.h"

static void begin(fl_app *app, const fl_parameters *p) {
    memcpy(app->law_state, p->law_start, sizeof app->law_state);
    app->law_runs = 1;
    app->closing = -1;
}

static fl_force_command decide(
    fl_app *app, const fl_parameters *p, const fl_measurement *m, int32_t setpoint) {
    if (app->state != FL_STATE_OPEN && app->state != FL_STATE_CLOSED) {
        app->law_runs = 0;
        return (fl_force_command){p->law_high_n, 0};
    }
    if (!app->law_runs) begin(app, p);
    return fl_switched(p, app->law_state, &app->closing, app->state == FL_STATE_CLOSED, m, setpoint);
}

/* The most by which the amplitude may rise in this tick. */
static int32_t rise(const fl_app *app) { return app->derived[app->parameters.in_force].rise_um; }

/* The amplitude command, never above the ceiling, and up by a share of the largest a tick. */
static int32_t amplitude(fl_app *app, const fl_parameters *p, int32_t force) {
    int32_t command;
    if (app->state == FL_STATE_OPEN || app->state == FL_STATE_CLOSED) {
        int32_t wanted = fl_lookup(force, p->lookup_squares_um2, p->lookup_cells_per_n, p->law_low_n);
        int32_t most = fl_clip(fl_add(app->amplitude, rise(app)), 0, p->drive_ceiling_um);
        command = fl_overdrive(&app->believed, wanted, p->overdrive_decay, p->overdrive_inverse, most);
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
    int32_t setpoint = fl_setpoint(app, &m);
    fl_sensors_step(app, &m, setpoint);
    fl_force_command command = decide(app, p, &m, setpoint);
    app->amplitude = amplitude(app, p, command.force);
    fl_keep(app, &m, setpoint, command);
    int32_t duty = fl_duty(&app->derived[app->parameters.in_force], app->amplitude);
    return (fl_drive){duty, app->amplitude};
}

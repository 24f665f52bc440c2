/* The tick: sample -> measurement -> set-point -> law -> amplitude -> duty.
 *
 * The law begins with its start words when the loop goes on, open or closed. Open, the lookup commands, and the law runs
 * along, whatever it says. Opening again commands what the set-point asks for. Idle and fault: the amplitude falls by drive.ramp_um a tick
 * to 0. */
#include <string.h>

#include "fl_app_parts.h"

static void begin(fl_app *app, const fl_parameters *p) {
    memcpy(app->law_state, p->law_start, sizeof app->law_state);
    app->law_runs = 1;
    app->since = -1;
}

/* Whether a command is within the clamp and the state of the law is made of numbers. */
static int is_sound(const fl_app *app, double u, fl_clamp clamp) {
    double sum = 0;
    for (uint32_t k = 0; k < fl_own.states; k++) sum += 0 * app->law_state[k];
    return u >= clamp.low && u <= clamp.high && sum == 0;
}

static fl_force_command decide(fl_app *app, const fl_parameters *p, const fl_measurement *m, double setpoint) {
    fl_clamp whole = {p->law_low_n, p->law_high_n};
    if (!fl_is_on(app)) {
        app->law_runs = 0;
        return (fl_force_command){whole.high, 0};
    }
    if (!app->law_runs) begin(app, p);
    fl_force_command open = fl_open_step(setpoint, whole);
    if (p->law_hash == 0) return open;
    int closed = app->state == FL_STATE_CLOSED;
    app->since = !closed ? -1 : app->since < fl_closing ? app->since + 1 : fl_closing;
    fl_clamp clamp = fl_switched_clamp(setpoint, whole, app->since);
    if (app->since == 0) fl_own_begin(app->law_state, open.force, setpoint, p, clamp);
    fl_force_command command = fl_own_step(app->law_state, m, setpoint, p, clamp);
    if (!closed || is_sound(app, command.force, clamp)) return closed ? command : open;
    fl_raise(app, (fl_raised){FL_FAULT_LAW_WRONG, app->tick, command.force});
    return (fl_force_command){fl_is_number(command.force) ? fl_clip(command.force, whole.low, whole.high) : whole.high, 1};
}

/* The amplitude command, never above the ceiling, and up by a share of the largest a tick. */
static double amplitude(fl_app *app, const fl_parameters *p, double force) {
    if (fl_is_on(app)) {
        double rise = app->derived[app->parameters.in_force].rise_um;
        double most = fl_clip(app->amplitude + rise, 0, p->drive_ceiling_um);
        return fl_overdrive(&app->believed, fl_look_up(force, p), most, p);
    }
    double command = fl_clip(app->amplitude - p->drive_ramp_um, 0, p->drive_ceiling_um);
    app->believed = command + p->overdrive_decay * (app->believed - command);
    return command;
}

fl_drive fl_app_tick(fl_app *app, const fl_sample *sample, uint32_t now_us, int32_t late) {
    app->tick++;
    fl_parameters_take(app);
    fl_waveform_take(app);
    const fl_parameters *p = fl_in_force(app);
    double position = p->touch_m_per_count * sample->position;
    double load = p->touch_n_per_count * (sample->load - p->touch_zero_counts);
    if (!app->touched) fl_touch_begin(app->touch, position, p);
    app->touched = 1;
    fl_measurement m = fl_touch_step(app->touch, position, load, fl_force(p, sample), p);
    fl_watch_step(app, sample, &m, late);
    fl_state_step(app, sample, &m, now_us);
    double setpoint = fl_setpoint(app, &m);
    fl_sensors_step(app, sample, &m, setpoint);
    app->measured = m;
    app->command = decide(app, p, &m, setpoint);
    app->amplitude = amplitude(app, p, app->command.force);
    fl_keep(app, &m, setpoint, app->command);
    return (fl_drive){fl_duty(&app->derived[app->parameters.in_force], app->amplitude), app->amplitude};
}

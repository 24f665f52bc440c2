/* The effect in the loop: where the finger is for it, what the host triggers, and how one follows another. */
#include "fl_app_parts.h"

/* Measured, or where the finger will be at its speed when the command is in force. */
static double place(const fl_app *app, const fl_measurement *m, int predicted) {
    const double *tracked = app->touch; /* position and speed first */
    return predicted ? tracked[0] + fl_in_force(app)->touch_lead_s * tracked[1] : m->position;
}

static void obey(fl_app *app) {
    uint8_t asked = app->asked_trigger;
    if (asked == 0) return;
    app->asked_trigger = 0;
    fl_effect *effect = &app->effect;
    if (asked > FL_TRIGGERS) {
        effect->ticks = 0;
    } else {
        effect->on[asked - 1] ^= 1;
        effect->since[asked - 1] = 0;
    }
}

double fl_effect_setpoint(fl_app *app, const fl_measurement *m) {
    const fl_parameters *p = fl_in_force(app);
    const fl_store *store = &app->stores[app->table.in_force];
    if (app->effect.runs) obey(app);
    double along = 1e3 * place(app, m, store->program.predicted);
    return fl_effect_force(
        &app->effect, store, along, m, p->touch_touch_n, (fl_clamp){p->law_low_n, p->law_high_n});
}

fl_answer fl_trigger(fl_app *app, uint8_t number) {
    if (number >= FL_TRIGGERS && number != FL_ALL_TRIGGERS)
        return (fl_answer){FL_REFUSAL_OUT_OF_RANGE, FL_NO_INDEX};
    int plays = app->plays[app->table.in_force].source == FL_SOURCE_EFFECT && !app->table.asked;
    if (!plays || app->asked_trigger) return (fl_answer){FL_REFUSAL_NOT_NOW, FL_NO_INDEX};
    app->asked_trigger = number == FL_ALL_TRIGGERS ? FL_TRIGGERS + 1 : (uint8_t)(number + 1);
    return (fl_answer){0, FL_NO_INDEX};
}

double fl_eased(fl_app *app, double wanted) {
    if (app->eases) {
        double step = app->derived[app->parameters.in_force].easing, before = app->setpoint;
        double next = fl_clip(wanted, before - step, before + step);
        app->eases = next != wanted;
        wanted = next;
    }
    app->setpoint = wanted;
    return wanted;
}

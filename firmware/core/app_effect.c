/* The effect in the loop: where the finger is for it, what the host triggers, and how one follows another. */
#include "fl_app_parts.h"

enum { FINE_TO_PLACE = 44 - 32, MEASURED_TO_PLACE = 32 - 28, LEAD_TO_PLACE = 28 + 28 - 32 };

/* Measured, or where the finger will be at its speed when the command is in force. */
static int32_t place(const fl_app *app, const fl_measurement *m, int predicted) {
    if (!predicted) return fl_saturate((int64_t)m->position * (1 << MEASURED_TO_PLACE));
    int64_t ahead = fl_scale((int64_t)fl_in_force(app)->touch_lead_s * m->speed, LEAD_TO_PLACE);
    return fl_saturate(fl_scale(app->touch.position, FINE_TO_PLACE) + ahead);
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

int32_t fl_effect_setpoint(fl_app *app, const fl_measurement *m) {
    const fl_parameters *p = fl_in_force(app);
    const fl_store *store = &app->stores[app->table.in_force];
    if (app->effect.runs) obey(app);
    int32_t along = place(app, m, store->program.predicted);
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

/* The band of the law in the time of the longest ramp of the drive: what the set-point may move in a tick while one
 * effect gives way to another. */
int32_t fl_derive_easing(const fl_parameters *p) {
    if (p->law_high_n <= p->law_low_n || p->drive_largest_um <= 0) return 1;
    uint32_t band = (uint32_t)p->law_high_n - (uint32_t)p->law_low_n;
    uint64_t step = fl_divide((uint64_t)band * (uint32_t)p->drive_ramp_um, (uint32_t)p->drive_largest_um);
    return step < 1 ? 1 : step > INT32_MAX ? INT32_MAX : (int32_t)step;
}

int32_t fl_eased(fl_app *app, int32_t wanted) {
    if (app->eases) {
        int32_t step = app->derived[app->parameters.in_force].easing;
        int32_t before = app->setpoint, next = fl_clip(wanted, fl_subtract(before, step), fl_add(before, step));
        app->eases = next != wanted;
        wanted = next;
    }
    app->setpoint = wanted;
    return wanted;
}

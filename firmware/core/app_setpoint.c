/* The set-point: held, an effect, or a table over time or over position, linear between its points.
 *
 * A phase counts points in 2^-24, so that a table over time keeps its period exactly. A table that loops has its first
 * point behind its last; one that does not stays at its ends. */
#include "fl_app_parts.h"

static const double PER_POINT = 1e-4; /* N */

static double at(const int16_t *points, const fl_play *play, uint32_t here, double share) {
    uint32_t next = here + 1 < play->count ? here + 1 : play->loops ? 0 : here;
    return PER_POINT * (points[here] + (points[next] - points[here]) * share);
}

static uint64_t last(const fl_play *play) { return (uint64_t)(play->count - 1) << 24; }

/* The end of a table that loops is its first point again. */
static uint64_t period(const fl_play *play) { return (uint64_t)play->count << 24; }

static double over_time(fl_app *app, const int16_t *points, const fl_play *play) {
    double force = at(points, play, (uint32_t)(app->phase >> 24), ((uint32_t)app->phase & 0xffffff) * 0x1p-24);
    app->phase += play->step;
    if (play->loops && app->phase >= period(play)) app->phase -= period(play);
    if (!play->loops && app->phase > last(play)) app->phase = last(play);
    return force;
}

static double over_position(const int16_t *points, const fl_play *play, double position) {
    double along = (1e6 * position - play->start_um) * (play->step * 0x1p-24); /* points */
    if (play->loops) along = fl_turned(along, play->count);
    along = fl_clip(along, 0, play->loops ? play->count : play->count - 1);
    uint32_t here = (uint32_t)along;
    return at(points, play, here < play->count ? here : 0, along - here);
}

static double wanted(fl_app *app, const fl_measurement *m) {
    const fl_play *play = &app->plays[app->table.in_force];
    const int16_t *points = app->stores[app->table.in_force].points;
    switch (play->source) {
    case FL_SOURCE_TIME: return over_time(app, points, play);
    case FL_SOURCE_POSITION: return over_position(points, play, m->position);
    case FL_SOURCE_EFFECT: return fl_effect_setpoint(app, m);
    default: return fl_in_force(app)->setpoint_hold_n;
    }
}

double fl_setpoint(fl_app *app, const fl_measurement *m) { return fl_eased(app, wanted(app, m)); }

/* From the first point, or the beginning of an effect. */
void fl_setpoint_begin(fl_app *app) {
    app->phase = 0;
    app->asked_trigger = 0;
    app->effect.runs = 0;
}

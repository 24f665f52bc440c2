/* The set-point: held, an effect, or a table over time or over position, linear between its points.
 *
 * A phase counts points in 2^-24. A table that loops has its first point behind its last; one that does not
 * stays at its ends. */
#include "fl_app_parts.h"

/* Points are 0.1 mN; with 16 binary places, times 2^28/(10^4 2^16), they are q28. */
static const fl_gain n_per_point = {1759218604, 32};

static int32_t at(const int16_t *points, const fl_play *play, uint64_t phase) {
    uint32_t here = (uint32_t)(phase >> 24), share = (uint32_t)phase & 0xffffff;
    uint32_t next = here + 1 < play->count ? here + 1 : play->loops ? 0 : here;
    int64_t rise = fl_scale((int64_t)(points[next] - points[here]) * share, 24 - 16);
    int64_t between = (int64_t)points[here] * 65536 + rise;
    return fl_mul(n_per_point, (int32_t)between);
}

static uint64_t last(const fl_play *play) { return (uint64_t)(play->count - 1) << 24; }

/* The end of a table that loops is its first point again. */
static uint64_t period(const fl_play *play) { return (uint64_t)play->count << 24; }

static int32_t over_time(fl_app *app, const int16_t *points, const fl_play *play) {
    int32_t force = at(points, play, app->phase);
    app->phase += play->step;
    if (play->loops && app->phase >= period(play)) app->phase -= period(play);
    if (!play->loops && app->phase > last(play)) app->phase = last(play);
    return force;
}

static int32_t over_position(const int16_t *points, const fl_play *play, int32_t position) {
    /* um with 8 binary places: 10^6 2^8/2^28 = 15625/2^14. A table is followed to 4 m from its start. */
    int64_t from_start = fl_scale((int64_t)position * 15625, 14) - (int64_t)play->start_um * 256;
    from_start = from_start < -(1 << 30) ? -(1 << 30) : from_start > 1 << 30 ? 1 << 30 : from_start;
    int64_t phase = fl_scale(from_start * (int64_t)play->step, 8);
    if (play->loops) {
        /* Whole points alone say how many periods to leave out; they fit a word, and divide in 12 cycles, not 300. */
        int32_t point = (int32_t)(phase >> 24) % (int32_t)play->count;
        if (point < 0) point += play->count;
        phase = ((int64_t)point << 24) | (phase & 0xffffff);
    }
    uint64_t along = phase < 0 ? 0 : (uint64_t)phase;
    return at(points, play, !play->loops && along > last(play) ? last(play) : along);
}

static int32_t wanted(fl_app *app, const fl_measurement *m) {
    const fl_play *play = &app->plays[app->table.in_force];
    const int16_t *points = app->stores[app->table.in_force].points;
    switch (play->source) {
    case FL_SOURCE_TIME: return over_time(app, points, play);
    case FL_SOURCE_POSITION: return over_position(points, play, m->position);
    case FL_SOURCE_EFFECT: return fl_effect_setpoint(app, m);
    default: return fl_in_force(app)->setpoint_hold_n;
    }
}

int32_t fl_setpoint(fl_app *app, const fl_measurement *m) { return fl_eased(app, wanted(app, m)); }

/* From the first point, or the beginning of an effect. */
void fl_setpoint_begin(fl_app *app) {
    app->phase = 0;
    app->asked_trigger = 0;
    app->effect.runs = 0;
}

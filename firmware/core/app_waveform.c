/* The set-point table, or the effect: a copy that waits is written piece by piece, checked, and swapped in at a tick. */
#include "fl_app_parts.h"

enum { FARTHEST_UM = 2000000000 };

static const fl_answer done = {0, FL_NO_INDEX};

static fl_answer refused(uint8_t reason, uint16_t index) { return (fl_answer){reason, index}; }

/* From the tick: the table begins at its first point. */
void fl_waveform_take(fl_app *app) {
    if (!app->table.asked) return;
    uint8_t before = app->plays[app->table.in_force].source;
    app->table.in_force ^= 1;
    uint8_t now = app->plays[app->table.in_force].source;
    app->eases = fl_is_on(app) && (before == FL_SOURCE_EFFECT || now == FL_SOURCE_EFFECT);
    fl_setpoint_begin(app);
    app->table.stale = 1;
    fl_fence();
    app->table.asked = 0;
}

static fl_store *waiting(fl_app *app) {
    fl_store *store = &app->stores[!app->table.in_force];
    if (app->table.stale) *store = app->stores[app->table.in_force];
    app->table.stale = 0;
    return store;
}

fl_answer fl_waveform(fl_app *app, uint16_t first, const uint8_t *values, uint16_t count) {
    if (first >= FL_POINTS || count > FL_POINTS - first)
        return refused(FL_REFUSAL_OUT_OF_RANGE, first < FL_POINTS ? FL_POINTS : first);
    if (app->table.asked) return refused(FL_REFUSAL_NOT_NOW, FL_NO_INDEX);
    int16_t *points = waiting(app)->points;
    for (uint16_t k = 0; k < count; k++) points[first + k] = (int16_t)fl_u16(values + 2 * k);
    return done;
}

static uint32_t crc_of(const int16_t *points, uint16_t count) {
    uint32_t crc = 0;
    for (uint16_t k = 0; k < count; k++) {
        uint8_t bytes[2];
        fl_put16(bytes, (uint16_t)points[k]);
        crc = fl_crc32(crc, bytes, 2);
    }
    return crc;
}

/* A table that loops may not be passed in one tick; a held set-point has none. */
static int makes_sense(const fl_play *play) {
    if (play->source > FL_SOURCE_EFFECT || play->loops > 1 || play->count > FL_POINTS) return 0;
    if (play->count == 0 && play->source != FL_SOURCE_HOLD) return 0;
    if (play->start_um > FARTHEST_UM || play->start_um < -FARTHEST_UM) return 0;
    return !(play->source == FL_SOURCE_TIME && play->loops) || play->step <= (uint64_t)play->count << 24;
}

fl_answer fl_play_table(fl_app *app, const fl_play *play, uint32_t crc) {
    if (!makes_sense(play)) return refused(FL_REFUSAL_OUT_OF_RANGE, FL_NO_INDEX);
    if (app->table.asked) return refused(FL_REFUSAL_NOT_NOW, FL_NO_INDEX);
    const fl_store *store = waiting(app);
    if (crc_of(store->points, play->count) != crc) return refused(FL_REFUSAL_WRONG_CRC, FL_NO_INDEX);
    int32_t wrong = play->source == FL_SOURCE_EFFECT ? fl_effect_wrong(store, play->count) : -1;
    if (wrong >= 0) return refused(FL_REFUSAL_OUT_OF_RANGE, (uint16_t)wrong);
    app->plays[!app->table.in_force] = *play;
    fl_fence();
    app->table.asked = 1;
    return done;
}

/* Telemetry: the tick keeps samples in a ring, the background makes frames of them. What does not fit is
 * counted. */
#include "fl_app_parts.h"
#include "laws.h"

enum {
    TOGETHER = FL_SAMPLES_A_FRAME,
    OLDEST = FL_OLDEST_MS * FL_TICK_HZ / 1000, /* ticks until a frame goes out with fewer */
    PREFIX = 10    /* bytes before the values */
};
_Static_assert(PREFIX + 2 * TOGETHER * FL_CHANNELS <= FL_LARGEST_BODY, "a frame takes all channels");
_Static_assert(FL_CHANNELS == 8, "the scales below");

/* 2^-28 over the channel's scale (protocol/frictionloop.toml), exactly. */
static const fl_gain per_01_mn = {1310720000, 45}, per_10_um = {1638400000, 42},
                     per_50_um_s = {1310720000, 44}, per_02_mn = {1310720000, 46};

static int16_t scaled(fl_gain scale, int32_t value) {
    return (int16_t)fl_clip(fl_mul(scale, value), INT16_MIN, INT16_MAX);
}

static uint16_t after(uint16_t at) { return at + 1 < FL_SAMPLES ? (uint16_t)(at + 1) : 0; }

static int16_t flags(const fl_app *app, const fl_measurement *m, fl_force_command command) {
    return (int16_t)((m->valid ? 1 : 0) | (command.saturated ? 2 : 0) | app->state << 2 | app->fault << 4);
}

void fl_keep(fl_app *app, const fl_measurement *m, int32_t setpoint, fl_force_command command) {
    if (app->decimation == 0 || app->tick % app->decimation != 0) return;
    if (after(app->head) == app->tail) {
        app->dropped++;
        return;
    }
    fl_kept *kept = &app->samples[app->head];
    kept->tick = app->tick;
    kept->values[FL_CHANNEL_F_R] = scaled(per_01_mn, setpoint);
    kept->values[FL_CHANNEL_F_M] = scaled(per_01_mn, m->force);
    kept->values[FL_CHANNEL_U] = scaled(per_01_mn, command.force);
    kept->values[FL_CHANNEL_A] = scaled(per_01_mn, app->amplitude);
    kept->values[FL_CHANNEL_POSITION] = scaled(per_10_um, m->position);
    kept->values[FL_CHANNEL_SPEED] = scaled(per_50_um_s, m->speed);
    kept->values[FL_CHANNEL_LOAD] = scaled(per_02_mn, m->load);
    kept->values[FL_CHANNEL_FLAGS] = flags(app, m, command);
    fl_fence();
    app->head = after(app->head);
}

/* Asked for again as it is, it goes on. Stopped, what is left is still sent; begun otherwise, it is let go
 * while the tick keeps none. */
fl_answer fl_stream(fl_app *app, uint16_t decimation, uint16_t mask) {
    if (mask >> FL_CHANNELS || (decimation && !mask))
        return (fl_answer){FL_REFUSAL_OUT_OF_RANGE, FL_NO_INDEX};
    int other = decimation && (decimation != app->spacing || mask != app->mask);
    if (other) {
        app->decimation = 0;
        fl_fence();
        app->tail = app->head;
        app->mask = mask;
        app->spacing = decimation;
        fl_fence();
    }
    app->decimation = decimation;
    return (fl_answer){0, FL_NO_INDEX};
}

/* Samples from the tail on that follow one another without a gap. */
static uint16_t in_a_row(const fl_app *app) {
    uint16_t count = 0, head = app->head;
    uint32_t first = app->samples[app->tail].tick;
    for (uint16_t k = app->tail; k != head && count < TOGETHER; k = after(k), count++)
        if (app->samples[k].tick != first + (uint32_t)count * app->spacing) break;
    return count;
}

/* Body of the next frame, its length; 0 where there is nothing to send yet. */
size_t fl_telemetry(fl_app *app, uint8_t *body) {
    if (app->tail == app->head) return 0;
    fl_fence();
    uint16_t count = in_a_row(app), next = app->tail;
    uint32_t first = app->samples[next].tick;
    for (uint16_t k = 0; k < count; k++) next = after(next);
    int waits = app->decimation && next == app->head && app->tick - first < OLDEST;
    if (count < TOGETHER && waits) return 0;
    uint8_t *at = fl_put16(fl_put16(fl_put32(body, first), app->spacing), app->mask);
    at = fl_put16(at, (uint16_t)app->dropped);
    for (uint16_t k = app->tail; k != next; k = after(k))
        for (int channel = 0; channel < FL_CHANNELS; channel++)
            if (app->mask >> channel & 1) at = fl_put16(at, (uint16_t)app->samples[k].values[channel]);
    fl_fence();
    app->tail = next;
    return (size_t)(at - body);
}

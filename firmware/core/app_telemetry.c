/* Telemetry: the tick keeps samples in a ring, the background makes frames of them. What does not fit is
 * counted. */
#include "fl_app_parts.h"
#include <math.h>

enum {
    TOGETHER = FL_SAMPLES_A_FRAME,
    OLDEST = FL_OLDEST_MS * FL_TICK_HZ / 1000, /* ticks until a frame goes out with fewer */
    PREFIX = 10    /* bytes before the values */
};
_Static_assert(PREFIX + 2 * TOGETHER * FL_CHANNELS <= FL_LARGEST_BODY, "a frame takes all channels");
_Static_assert(FL_CHANNELS == 8, "the scales below");

/* One over the channel's scale (protocol/frictionloop.toml). */
static const double PER_01_MN = 1e4, PER_10_UM = 1e5, PER_50_UM_S = 2e4, PER_02_MN = 5e3;

static int16_t scaled(double scale, double value) {
    return (int16_t)fl_clip(floor(scale * value + 0.5), INT16_MIN, INT16_MAX);
}

static uint16_t after(uint16_t at) { return at + 1 < FL_SAMPLES ? (uint16_t)(at + 1) : 0; }

static int16_t flags(const fl_app *app, const fl_measurement *m, fl_force_command command) {
    return (int16_t)((m->valid > 0.5 ? 1 : 0) | (command.saturated != 0 ? 2 : 0) | app->state << 2 | app->fault << 4);
}

void fl_keep(fl_app *app, const fl_measurement *m, double setpoint, fl_force_command command) {
    if (app->decimation == 0 || app->tick % app->decimation != 0) return;
    if (after(app->head) == app->tail) {
        app->dropped++;
        return;
    }
    fl_kept *kept = &app->samples[app->head];
    kept->tick = app->tick;
    kept->values[FL_CHANNEL_F_R] = scaled(PER_01_MN, setpoint);
    kept->values[FL_CHANNEL_F_M] = scaled(PER_01_MN, m->force);
    kept->values[FL_CHANNEL_U] = scaled(PER_01_MN, command.force);
    kept->values[FL_CHANNEL_A] = scaled(PER_01_MN, app->amplitude);
    kept->values[FL_CHANNEL_POSITION] = scaled(PER_10_UM, m->position);
    kept->values[FL_CHANNEL_SPEED] = scaled(PER_50_UM_S, m->speed);
    kept->values[FL_CHANNEL_LOAD] = scaled(PER_02_MN, m->load);
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

/* A board under random tables, samples and bytes, with the sanitizers watching: `wild SEED TICKS`.
 *
 * After every tick: duty at most that of the ceiling built in (by the sine), amplitude within 0 and the
 * ceiling, no rise while idle or at fault, no large one in a tick, no other table without a commit, and the loop on
 * only while the host was heard. Prints the ticks in each state, those of a loop that plays an effect, those with a
 * table about to be taken, and a digest of what was driven. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fl_app_parts.h"

static uint64_t state;
static uint32_t draw(void) { /* xorshift64*, Vigna 2016 */
    state ^= state >> 12, state ^= state << 25, state ^= state >> 27;
    return (uint32_t)((state * 2685821657736338717u) >> 32);
}
static uint32_t below(uint32_t n) { return draw() % n; }

static int32_t any(int64_t low, int64_t high) {
    switch (below(4)) {
    case 0: return (int32_t)low;
    case 1: return (int32_t)high;
    default: break;
    }
    uint64_t wide = (uint64_t)draw() << 32;
    wide |= draw(); /* one draw a statement: their order is the same with every compiler */
    return (int32_t)(low + (int64_t)(wide % (uint64_t)(high - low + 1)));
}

static int rising(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}
static int falling(const void *a, const void *b) { return rising(b, a); }

/* A table that passes its checks, with any number that they leave to a board that was built with these. */
static void fill(fl_table *table, fl_built_in built) {
    static const fl_range ranges[FL_RANGES] = FL_RANGE_TABLE;
    for (int k = 0; k < FL_RANGES; k++)
        for (int i = 0; i < ranges[k].count * ranges[k].stride; i++)
            table->words[ranges[k].first + i] = ranges[k].stride == 2 && i % 2 == 0
                                                    ? any(INT32_MIN + 1, INT32_MAX)
                                                    : any(ranges[k].low, ranges[k].high);
    fl_parameters *p = &table->named;
    do p->law_number = (int32_t)below(fl_law_count);
    while (!fl_laws[p->law_number].step);
    if (p->law_low_n == p->law_high_n) p->law_high_n ^= 1;
    if (p->law_low_n > p->law_high_n) {
        int32_t low = p->law_high_n;
        p->law_high_n = p->law_low_n, p->law_low_n = low;
    }
    if (p->drive_largest_um == 0) p->drive_largest_um = 1;
    p->drive_ceiling_um = any(0, p->drive_largest_um);
    if (built.largest_um > 0 && built.ceiling_um >= 0) {
        int64_t most = (int64_t)built.ceiling_um * p->drive_largest_um / built.largest_um;
        if (p->drive_ceiling_um > most) p->drive_ceiling_um = (int32_t)most;
    }
    if (p->drive_ramp_um < p->drive_ceiling_um / 500) p->drive_ramp_um = p->drive_ceiling_um / 500;
    qsort(p->lookup_squares_um2, 257, 4, falling);
    p->safety_force_ticks = 1 + (int32_t)below(100); /* so that it gets somewhere before it faults */
    if (below(2)) p->safety_force_limit_n = INT32_MAX;
    if (below(4)) p->safety_force_jump_n = p->safety_position_jump_m = p->safety_load_jump_n = INT32_MAX;
    if (below(2)) p->safety_contrary_n = INT32_MAX;
    if (below(2)) return; /* or a board that takes any reading */
    p->safety_force_limit_n = p->safety_force_jump_n = p->safety_position_jump_m = p->safety_load_jump_n = INT32_MAX;
    p->safety_contrary_n = p->safety_hum_n = INT32_MAX, p->safety_stuck_ticks = 500000;
}

static void spoil(fl_table *table) {
    fl_parameters *p = &table->named;
    uint32_t at = below(FL_WORDS);
    if (below(2)) p->drive_ceiling_um = any(0, p->drive_largest_um);
    else table->words[at] = (int32_t)draw();
}

static void say(fl_app *app, uint8_t type, const void *body, size_t count, uint32_t now) {
    static uint16_t sequence;
    uint8_t frame[FL_LARGEST_FRAME], coded[FL_LARGEST_CODED];
    frame[0] = type;
    uint32_t session = type == FL_MESSAGE_HELLO ? 0 : app->sessions[below(200) == 0].id;
    fl_put32(fl_put16(frame + 1, sequence), below(200) ? session : draw());
    sequence += below(64) != 0;
    memcpy(frame + FL_HEADER, body, count);
    size_t length = fl_frame_encode(coded, sizeof coded, frame, FL_HEADER + count);
    uint32_t hit = below(50), where = below((uint32_t)length), bit = below(8);
    if (hit == 0) coded[where] ^= (uint8_t)(1 << bit);
    fl_app_receive(app, coded, length, now);
}

static void commit(fl_app *app, uint32_t now) {
    fl_table table;
    uint8_t body[2 + 256];
    uint32_t crc = 0;
    fill(&table, app->built);
    if (below(4) == 0) spoil(&table);
    for (int first = 0; first < FL_WORDS; first += 64) {
        int count = FL_WORDS - first < 64 ? FL_WORDS - first : 64;
        uint8_t *at = fl_put16(body, (uint16_t)first);
        for (int k = 0; k < count; k++) at = fl_put32(at, (uint32_t)table.words[first + k]);
        crc = fl_crc32(crc, body + 2, 4 * (size_t)count);
        say(app, FL_MESSAGE_SET, body, 2 + 4 * (size_t)count, now);
    }
    fl_put32(body, crc);
    say(app, FL_MESSAGE_COMMIT, body, 4, now);
}

/* Words about the end of the table. */
static void set(fl_app *app, uint32_t now) {
    uint8_t body[2 + 256];
    uint32_t first = FL_WORDS - below(80), count = 1 + below(64);
    uint8_t *at = fl_put16(body, (uint16_t)first);
    for (uint32_t k = first; k < first + count; k++)
        at = fl_put32(at, k < FL_WORDS ? (uint32_t)app->tables[app->parameters.in_force].words[k] : 1);
    say(app, FL_MESSAGE_SET, body, 2 + 4 * (size_t)count, now);
}

static void play(fl_app *app, uint32_t now) {
    uint8_t body[2 + 256];
    uint16_t count = (uint16_t)(1 + below(128));
    for (int k = 0; k < 256; k++) body[2 + k] = (uint8_t)draw();
    fl_put16(body, 0);
    say(app, FL_MESSAGE_WAVEFORM, body, 2 + 2 * (size_t)count, now);
    uint32_t crc = fl_crc32(0, body + 2, 2 * (size_t)count);
    body[0] = (uint8_t)below(3), body[1] = (uint8_t)below(2);
    uint8_t *at = fl_put32(fl_put16(body + 2, count), (uint32_t)any(0, UINT32_MAX));
    fl_put32(fl_put32(at, (uint32_t)any(-8000000, 8000000)), crc);
    say(app, FL_MESSAGE_PLAY, body, 16, now);
}

/* An effect whose steps are mostly ones that can be run, over tables of anything. */
static void effect(fl_app *app, uint32_t now) {
    static const uint8_t sources[] = {FL_STEP_TABLE, FL_STEP_WAVE, FL_STEP_DIRECTION, FL_STEP_SPEED, FL_STEP_TRIGGER};
    fl_store store;
    uint8_t body[2 + 256];
    for (int k = 0; k < FL_POINTS; k++) store.points[k] = (int16_t)any(INT16_MIN, INT16_MAX);
    int steps = 1 + (int)below(FL_EFFECT_STEPS), depth = 0, from = 2 + 12 * steps;
    store.program.count = (uint16_t)steps, store.program.predicted = (uint16_t)below(2);
    for (int k = 0; k < steps; k++) {
        fl_effect_step *s = &store.program.steps[k];
        int pops = depth > 1 && (depth >= steps - k || below(2));
        int count = (int)below((uint32_t)(FL_POINTS - from - 1)) + 1;
        s->what = pops ? (uint8_t)(FL_STEP_ADD + below(3 + (depth > 2))) : sources[below(5)];
        if (depth == 1 && k == steps - 1) s->what = FL_STEP_SCALED;
        depth += s->what == FL_STEP_SCALED ? 0 : s->what == FL_STEP_MIX ? -2 : pops ? -1 : 1;
        s->nearest = (uint8_t)below(2), s->repeats = (uint8_t)below(2), s->number = (uint8_t)below(4);
        s->count = (uint16_t)count, s->first = (uint16_t)(from + any(0, FL_POINTS - from - count - s->repeats));
        if (s->what == FL_STEP_TRIGGER) s->first = (uint16_t)below(3);
        s->start = any(INT32_MIN, INT32_MAX), s->per = any(0, (1 << 30) - 1), s->scale = any(0, INT32_MAX);
        s->per_shift = (int8_t)any(14, 62), s->scale_shift = (int8_t)any(-1, 62);
        if (below(200) == 0) s->what = (uint8_t)draw();
        if (below(200) == 0) s->count = (uint16_t)draw();
        if (below(200) == 0) s->per_shift = (int8_t)draw();
    }
    for (int first = 0; first < FL_POINTS; first += 128) {
        uint8_t *at = fl_put16(body, (uint16_t)first);
        for (int k = 0; k < 128; k++) at = fl_put16(at, (uint16_t)store.points[first + k]);
        say(app, FL_MESSAGE_WAVEFORM, body, sizeof body, now);
    }
    uint32_t crc = fl_crc32(0, (const uint8_t *)store.points, sizeof store);
    body[0] = FL_SOURCE_EFFECT, body[1] = 0;
    fl_put32(fl_put32(fl_put32(fl_put16(body + 2, FL_POINTS), 0), 0), crc);
    say(app, FL_MESSAGE_PLAY, body, 16, now);
}

static void talk(fl_app *app, uint32_t now) {
    uint8_t bytes[300];
    for (size_t k = 0; k < sizeof bytes; k++) bytes[k] = below(3) ? (uint8_t)draw() : 0;
    switch (below(16)) {
    case 15: set(app, now); break;
    case 13: effect(app, now); break;
    case 14: bytes[0] = (uint8_t)below(6), say(app, FL_MESSAGE_TRIGGER, bytes, 1, now); break;
    case 0: commit(app, now); break;
    case 1: play(app, now); break;
    case 2: fl_app_receive(app, bytes, below(300), now); break;
    case 3: say(app, bytes[0] % 24, bytes + 1, below(FL_LARGEST_BODY + 1), now); break;
    case 4: say(app, FL_MESSAGE_CLEAR, bytes, 0, now); break;
    case 5: bytes[0] = 0, say(app, FL_MESSAGE_MODE, bytes, 1, now); break;
    case 6: bytes[0] = 1, say(app, FL_MESSAGE_MODE, bytes, 1, now); break;
    case 7: case 8: bytes[0] = 2, say(app, FL_MESSAGE_MODE, bytes, 1, now); break;
    case 10: bytes[0] = FL_MAJOR, say(app, FL_MESSAGE_HELLO, bytes, 5, now); break;
    case 9: bytes[0] = (uint8_t)below(4), bytes[1] = 0, say(app, FL_MESSAGE_STREAM, bytes, 4, now); break;
    default: say(app, FL_MESSAGE_HEARTBEAT, bytes, 0, now); break;
    }
}

/* The amplitude that the carrier's fundamental stands for, of a plate as the board was built for. Between 257
 * amplitudes the arcsine is a straight line, which is a quarter of a cell too high at most. */
static double at_the_pin(const fl_app *app, fl_drive drive) {
    return app->built.largest_um * (sin(3.14159265358979 * drive.duty / 131072) - 1.0 / 1024);
}

/* Whether the table in force has changed without a commit. */
static int is_other(const fl_app *app) {
    static fl_table kept;
    static int32_t commits = -1;
    int is_new = commits != app->commits;
    int other = !is_new && memcmp(&kept, &app->tables[app->parameters.in_force], sizeof kept) != 0;
    if (is_new) kept = app->tables[app->parameters.in_force];
    commits = app->commits;
    return other;
}

static void check(const fl_app *app, fl_drive drive, fl_drive before, uint32_t now, uint32_t tick) {
    static int32_t largest;
    const fl_parameters *p = fl_in_force(app);
    int renamed = p->drive_largest_um != largest; /* the duty then stands for another amplitude */
    int rises = drive.duty > before.duty || (!renamed && drive.amplitude > before.amplitude);
    int32_t most = p->drive_largest_um / FL_RISE_TICKS + 1;
    int leaps = !renamed && drive.amplitude - before.amplitude > most;
    largest = p->drive_largest_um;
    int on = app->state == FL_STATE_OPEN || app->state == FL_STATE_CLOSED;
    const char *wrong = drive.duty < 0 || at_the_pin(app, drive) > app->built.ceiling_um  ? "duty"
                        : drive.amplitude < 0 || drive.amplitude > p->drive_ceiling_um ? "amplitude"
                        : !on && rises                                                 ? "rises"
                        : leaps                                                        ? "leaps"
                        : is_other(app)                                                ? "table"
                        : on && (int32_t)(now - app->heard_us) > FL_SILENCE_MS * 1000  ? "silence"
                                                                                       : 0;
    if (!wrong) return;
    printf("tick %" PRIu32 ": %s: state %d duty %d, %f of %d, amplitude %d of %d\n", tick, wrong, app->state, drive.duty,
           at_the_pin(app, drive), app->built.ceiling_um, drive.amplitude, p->drive_ceiling_um);
    exit(1);
}

/* Readings of anything, and between them a second of a finger that slides. */
static fl_sample sampled(uint32_t tick) {
    static fl_sample sample;
    if (tick / 5000 % 2) return (fl_sample){{(int32_t)(1000 + tick % 3), 0}, (int32_t)(4 * (tick % 5000)), 3277};
    if (below(4) == 0) {
        sample.force[0] = any(-32768, 32767), sample.force[1] = any(-32768, 32767);
        sample.position = any(INT32_MIN, INT32_MAX), sample.load = any(INT32_MIN, INT32_MAX);
    }
    if (below(1000) == 0) sample.force[0] = any(INT32_MIN, INT32_MAX);
    sample.position = (int32_t)((uint32_t)sample.position + below(100));
    return sample;
}

int main(int count, char **arguments) {
    if (count != 3) return 2;
    state = strtoull(arguments[1], 0, 10) * 2654435769u + 1;
    uint32_t ticks = (uint32_t)strtoul(arguments[2], 0, 10), now = draw();
    uint32_t seen[4] = {0}, accepted = 0, effects = 0, quiet = 0;
    uint64_t digest = 14695981039346656037u;
    fl_app *app = malloc(sizeof *app);
    fl_table table;
    fill(&table, (fl_built_in){0, 0});
    if (below(3) == 0) spoil(&table);
    fl_app_start(app, &(fl_identity){FL_BOARD_HOST, 1, "wild", FL_RESET_POWER_ON}, &table.named);
    fl_drive before = {0};
    for (uint32_t k = 0; k < ticks; k++) {
        uint8_t out[300];
        now += 200;
        if (quiet) quiet--;
        else if (below(20) == 0) talk(app, now);
        if (below(4000) == 0) quiet = 1500; /* ticks, 0.3 s */
        accepted += app->parameters.asked;
        fl_sample sample = sampled(k);
        fl_drive drive = fl_app_tick(app, &sample, now, below(5000) == 0);
        check(app, drive, before, now, k);
        before = drive;
        seen[app->state]++;
        effects += fl_is_on(app) && app->plays[app->table.in_force].source == FL_SOURCE_EFFECT;
        digest ^= (uint32_t)drive.duty ^ (uint64_t)(uint32_t)drive.amplitude << 32;
        digest *= 1099511628211u; /* as FNV-1a */
        if (below(3) == 0) fl_app_transmit(app, out, below(sizeof out), now);
    }
    free(app);
    for (int k = 0; k < 4; k++) printf("%" PRIu32 " ", seen[k]);
    printf("%" PRIu32 " %" PRIu32 "\n%016" PRIx64 "\n", effects, accepted, digest);
    return 0;
}

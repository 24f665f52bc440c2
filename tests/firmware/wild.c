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

static double real(double low, double high) {
    switch (below(4)) {
    case 0: return low;
    case 1: return high;
    default: return low + (high - low) * (draw() * 0x1p-32);
    }
}

static int falling(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* A table that passes its checks, with any number that they leave to a board that was built with these. */
static void fill(fl_table *table, fl_built_in built) {
    static const fl_range ranges[FL_RANGES] = FL_RANGE_TABLE;
    for (int k = 0; k < FL_RANGES; k++)
        for (int i = ranges[k].first; i < (k + 1 < FL_RANGES ? ranges[k + 1].first : FL_WORDS); i++)
            table->words[i] = ranges[k].whole ? floor(real(ranges[k].low, ranges[k].high))
                                              : real(ranges[k].low, ranges[k].high);
    fl_parameters *p = &table->named;
    p->law_hash = below(3) ? fl_own.hash : 0;
    double most = below(2) ? 1e30 : 1; /* of gains that no law survives, and of those that it may */
    for (int k = 0; k < FL_GAINS; k++) p->law_gains[k] = real(-most, most);
    for (int k = 0; k < FL_STATES; k++) p->law_start[k] = real(-most, most);
    if (p->law_low_n == p->law_high_n) p->law_high_n = p->law_low_n > 0 ? 0 : 1;
    if (p->law_low_n > p->law_high_n) {
        double low = p->law_high_n;
        p->law_high_n = p->law_low_n, p->law_low_n = low;
    }
    if (p->lookup_entries == 1) p->lookup_entries = 0;
    if (p->drive_largest_um == 0) p->drive_largest_um = 1e-9;
    p->drive_ceiling_um = real(0, p->drive_largest_um);
    if (built.largest_um > 0 && built.ceiling_um >= 0) {
        double ceiling = built.ceiling_um * p->drive_largest_um / built.largest_um;
        if (p->drive_ceiling_um > ceiling) p->drive_ceiling_um = ceiling;
    }
    if (p->drive_ramp_um < p->drive_ceiling_um / 500) p->drive_ramp_um = p->drive_ceiling_um / 499;
    qsort(p->lookup_squares_um2, 257, sizeof(double), falling);
    p->safety_hum_ticks = 1 + below(FL_HUM_TICKS);
    p->safety_force_ticks = 1 + below(100); /* so that it gets somewhere before it faults */
    if (below(2)) p->safety_force_limit_n = 8;
    if (below(4)) p->safety_force_jump_n = p->safety_position_jump_m = p->safety_load_jump_n = 8;
    if (below(2)) p->safety_contrary_n = 8;
    if (below(2)) return; /* or a board that takes any reading */
    for (int k = 0; k < 2; k++) p->force_n_per_count[k] *= 1e-35;
    p->touch_m_per_count *= 1e-38, p->touch_n_per_count *= 1e-38;
    p->safety_force_limit_n = p->safety_force_jump_n = p->safety_position_jump_m = p->safety_load_jump_n = 8;
    p->safety_contrary_n = p->safety_hum_n = 8, p->safety_stuck_ticks = 500000;
}

static void spoil(fl_table *table) {
    fl_parameters *p = &table->named;
    uint32_t at = below(FL_WORDS);
    uint64_t bits = (uint64_t)draw() << 32;
    bits |= draw();
    if (below(2)) p->drive_ceiling_um = real(0, p->drive_largest_um);
    else memcpy(table->words + at, &bits, sizeof bits);
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
    for (int first = 0; first < FL_WORDS; first += 32) {
        int count = FL_WORDS - first < 32 ? FL_WORDS - first : 32;
        uint8_t *at = fl_put16(body, (uint16_t)first);
        for (int k = 0; k < count; k++) at = fl_put64(at, table.words[first + k]);
        crc = fl_crc32(crc, body + 2, 8 * (size_t)count);
        say(app, FL_MESSAGE_SET, body, 2 + 8 * (size_t)count, now);
    }
    fl_put32(body, crc);
    say(app, FL_MESSAGE_COMMIT, body, 4, now);
}

/* Words about the end of the table. */
static void set(fl_app *app, uint32_t now) {
    uint8_t body[2 + 256];
    uint32_t first = FL_WORDS - below(80), count = 1 + below(32);
    uint8_t *at = fl_put16(body, (uint16_t)first);
    for (uint32_t k = first; k < first + count; k++)
        at = fl_put64(at, k < FL_WORDS ? app->tables[app->parameters.in_force].words[k] : 1);
    say(app, FL_MESSAGE_SET, body, 2 + 8 * (size_t)count, now);
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
    int steps = 1 + (int)below(FL_EFFECT_STEPS), depth = 0, from = 4 + 16 * steps;
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
        s->start = real(-1e30, 1e30), s->per = real(0, below(2) ? 1e30 : 1), s->scale = real(0, below(2) ? 1e30 : 1);
        if (below(200) == 0) s->what = (uint8_t)draw();
        if (below(200) == 0) s->count = (uint16_t)draw();
        if (below(200) == 0) s->per = NAN;
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
    static double largest;
    const fl_parameters *p = fl_in_force(app);
    int renamed = p->drive_largest_um != largest; /* the duty then stands for another amplitude */
    int rises = drive.duty > before.duty || (!renamed && drive.amplitude > before.amplitude);
    double most = p->drive_largest_um / FL_RISE_TICKS;
    int leaps = !renamed && drive.amplitude - before.amplitude > most * (1 + 1e-12);
    largest = p->drive_largest_um;
    int on = app->state == FL_STATE_OPEN || app->state == FL_STATE_CLOSED;
    const char *wrong = drive.duty < 0 || at_the_pin(app, drive) > app->built.ceiling_um  ? "duty"
                        : !(drive.amplitude >= 0 && drive.amplitude <= p->drive_ceiling_um) ? "amplitude"
                        : !on && rises                                                 ? "rises"
                        : leaps                                                        ? "leaps"
                        : is_other(app)                                                ? "table"
                        : on && (int32_t)(now - app->heard_us) > FL_SILENCE_MS * 1000  ? "silence"
                                                                                       : 0;
    if (!wrong) return;
    printf("tick %" PRIu32 ": %s: state %d duty %d, %f of %f, amplitude %g of %g\n", tick, wrong, app->state, drive.duty,
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
        uint64_t bits;
        memcpy(&bits, &drive.amplitude, sizeof bits);
        digest ^= (uint32_t)drive.duty ^ bits;
        digest *= 1099511628211u; /* as FNV-1a */
        if (below(3) == 0) fl_app_transmit(app, out, below(sizeof out), now);
    }
    free(app);
    for (int k = 0; k < 4; k++) printf("%" PRIu32 " ", seen[k]);
    printf("%" PRIu32 " %" PRIu32 "\n%016" PRIx64 "\n", effects, accepted, digest);
    return 0;
}

/* The parameter table: a copy that waits is written word by word, checked as a whole, and swapped in at a
 * tick. */
#include <math.h>
#include <string.h>

#include "fl_app_parts.h"

#define INDEX(member) ((uint16_t)(offsetof(fl_parameters, member) / 8))

static const fl_range ranges[FL_RANGES] = FL_RANGE_TABLE;
static const fl_built_in NOTHING = {1, -1}; /* no table will do */
enum { RAMP_TICKS = FL_RAMP_MS * FL_TICK_HZ / 1000 };

/* Whether a word may have a value: within its range, and whole where it counts. */
static int fits(uint16_t index, double value) {
    const fl_range *range = ranges;
    while (range + 1 < ranges + FL_RANGES && range[1].first <= index) range++;
    return value >= range->low && value <= range->high && (!range->whole || value == floor(value));
}

/* Index of the first square of an amplitude that is above the one before. */
static uint16_t rising(const fl_table *table) {
    const uint16_t first = INDEX(lookup_squares_um2);
    for (uint16_t k = first + 1; k < first + table->named.lookup_entries; k++)
        if (table->words[k] > table->words[k - 1]) return k;
    return FL_NO_INDEX;
}

/* Whether the ceiling takes a larger duty than the one that was built in. */
static int is_more(const fl_parameters *p, fl_built_in built) {
    return p->drive_ceiling_um * built.largest_um > built.ceiling_um * p->drive_largest_um * (1 + 1e-12);
}

uint16_t fl_check_table(const fl_table *table, fl_built_in built) {
    const fl_parameters *p = &table->named;
    for (uint16_t k = 0; k < FL_WORDS; k++)
        if (!fits(k, table->words[k])) return k;
    if (p->law_hash != 0 && p->law_hash != fl_own.hash) return INDEX(law_hash);
    if (p->lookup_entries == 1) return INDEX(lookup_entries);
    if (p->law_low_n >= p->law_high_n) return INDEX(law_high_n);
    if (p->drive_largest_um <= 0) return INDEX(drive_largest_um);
    if (p->drive_ceiling_um > p->drive_largest_um || is_more(p, built)) return INDEX(drive_ceiling_um);
    if (p->drive_ramp_um * RAMP_TICKS < p->drive_ceiling_um * (1 - 1e-12)) return INDEX(drive_ramp_um);
    if (p->safety_hum_ticks > FL_HUM_TICKS) return INDEX(safety_hum_ticks);
    return rising(table);
}

/* A table that fails its checks is not run, not even at amplitude 0: its numbers may be anything. In its
 * place all is zero, which gives no amplitude, until the host commits one that passes. */
void fl_parameters_start(fl_app *app, const fl_parameters *parameters) {
    if (!parameters) {
        app->built = NOTHING;
        app->raised.fault = app->fault = FL_FAULT_BAD_IMAGE;
        app->state = FL_STATE_FAULT;
        app->bad_table = app->tell_fault = 1;
        return;
    }
    app->tables[0].named = *parameters;
    app->built = (fl_built_in){parameters->drive_largest_um, parameters->drive_ceiling_um};
    uint16_t wrong = fl_check_table(&app->tables[0], app->built);
    if (wrong >= INDEX(drive_largest_um) && wrong <= INDEX(drive_ceiling_um))
        app->built = NOTHING; /* nobody knows the plate */
    if (wrong != FL_NO_INDEX) {
        memset(&app->tables[0], 0, sizeof app->tables[0]);
        app->raised = (fl_raised){FL_FAULT_BAD_PARAMETER, 0, wrong};
        app->fault = FL_FAULT_BAD_PARAMETER;
        app->state = FL_STATE_FAULT;
        app->bad_table = app->tell_fault = 1;
    }
    app->tables[1] = app->tables[0];
    app->derived[0] = fl_derive(&app->tables[0].named);
}

/* From the tick. A law that was changed under way begins anew. The duty at the pin stays, and is another amplitude
 * where the plate is said to be another one. */
void fl_parameters_take(fl_app *app) {
    if (!app->parameters.asked) return;
    const fl_parameters *before = fl_in_force(app);
    app->parameters.in_force ^= 1;
    const fl_parameters *now = fl_in_force(app);
    if (now->law_hash != before->law_hash) app->law_runs = 0;
    if (app->amplitude > 0 && now->drive_largest_um != before->drive_largest_um)
        app->amplitude *= now->drive_largest_um / before->drive_largest_um;
    app->bad_table = 0;
    app->commits++;
    app->parameters.stale = 1;
    fl_fence();
    app->parameters.asked = 0;
}

/* The copy that waits, equal to the one in force where nothing was written since. */
static fl_table *waiting(fl_app *app) {
    fl_table *table = &app->tables[!app->parameters.in_force];
    if (app->parameters.stale) *table = app->tables[app->parameters.in_force];
    app->parameters.stale = 0;
    return table;
}

fl_answer fl_set(fl_app *app, uint16_t first, const uint8_t *values, uint16_t count) {
    if (first >= FL_WORDS || count > FL_WORDS - first)
        return (fl_answer){FL_REFUSAL_UNKNOWN_WORD, first < FL_WORDS ? FL_WORDS : first};
    for (uint16_t k = 0; k < count; k++)
        if (!fits(first + k, fl_f64(values + 8 * k)))
            return (fl_answer){FL_REFUSAL_OUT_OF_RANGE, (uint16_t)(first + k)};
    if (app->parameters.asked) return (fl_answer){FL_REFUSAL_NOT_NOW, FL_NO_INDEX};
    fl_table *table = waiting(app);
    for (uint16_t k = 0; k < count; k++) table->words[first + k] = fl_f64(values + 8 * k);
    return (fl_answer){0, FL_NO_INDEX};
}

static uint32_t crc_of(const fl_table *table) {
    uint32_t crc = 0;
    for (uint16_t k = 0; k < FL_WORDS; k++) {
        uint8_t bytes[8];
        fl_put64(bytes, table->words[k]);
        crc = fl_crc32(crc, bytes, 8);
    }
    return crc;
}

/* Until the tick has taken it, the same commit again is done already. */
fl_answer fl_commit(fl_app *app, uint32_t crc) {
    fl_table *table = app->parameters.asked ? &app->tables[!app->parameters.in_force] : waiting(app);
    if (crc_of(table) != crc) return (fl_answer){FL_REFUSAL_WRONG_CRC, FL_NO_INDEX};
    uint16_t wrong = fl_check_table(table, app->built);
    if (wrong != FL_NO_INDEX) return (fl_answer){FL_REFUSAL_OUT_OF_RANGE, wrong};
    app->derived[!app->parameters.in_force] = fl_derive(&table->named);
    fl_fence();
    app->parameters.asked = 1;
    return (fl_answer){0, FL_NO_INDEX};
}

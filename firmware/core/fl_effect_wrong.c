/* Whether a program can be run at all: every table within the store, every number finite, no stack too deep. */
#include "fl_effect.h"

enum { HEAD = 4, WORDS = sizeof(fl_effect_step) / 2 };

/* What a step takes from the stack, and what it puts there. */
static const struct { uint8_t takes, puts; } arity[] = {
    [FL_STEP_TABLE] = {0, 1}, [FL_STEP_WAVE] = {0, 1},      [FL_STEP_ADD] = {2, 1},   [FL_STEP_MULTIPLY] = {2, 1},
    [FL_STEP_LARGER] = {2, 1}, [FL_STEP_MIX] = {3, 1},      [FL_STEP_DIRECTION] = {0, 1}, [FL_STEP_SPEED] = {0, 1},
    [FL_STEP_TRIGGER] = {0, 1}, [FL_STEP_SCALED] = {1, 1},
};
enum { STEPS = sizeof arity / sizeof arity[0] };

static int reads(const fl_effect_step *s, uint16_t from, uint16_t until) {
    if (s->repeats > 1 || s->nearest > 1 || s->count < (s->repeats ? 1 : 2)) return 0;
    if (s->first < from || s->first > until || s->count + s->repeats > until - s->first) return 0;
    return s->per >= 0;
}

/* No product of two of these and a place overflows. */
static int is_plain(double x) { return fl_size(x) <= 1e30; }

static int fits(const fl_effect_step *s, uint16_t from, uint16_t until) {
    if (s->what >= STEPS || !is_plain(s->start) || !is_plain(s->per) || !is_plain(s->scale)) return 0;
    if (s->what == FL_STEP_TRIGGER)
        return s->number < FL_TRIGGERS && s->first <= FL_CONDITION_PLACE && s->start != s->per && s->scale >= 0;
    if (s->what == FL_STEP_WAVE && s->number > FL_TRIGGERS) return 0;
    return (s->what != FL_STEP_TABLE && s->what != FL_STEP_WAVE) || reads(s, from, until);
}

int32_t fl_effect_wrong(const fl_store *store, uint16_t count) {
    uint16_t steps = count >= HEAD ? store->program.count : 0, from = HEAD + WORDS * steps;
    if (steps < 1 || steps > FL_EFFECT_STEPS || from > count || store->program.predicted > 1) return 0;
    int depth = 0;
    for (uint16_t k = 0; k < steps; k++) {
        const fl_effect_step *s = &store->program.steps[k];
        if (!fits(s, from, count) || depth < arity[s->what].takes) return HEAD + WORDS * k;
        depth += arity[s->what].puts - arity[s->what].takes;
        if (depth > FL_STACK) return HEAD + WORDS * k;
    }
    return depth == 1 ? -1 : 0;
}

/* Mirrors rendering/player.py. What it reads was checked by fl_effect_wrong. */
#include <string.h>

#include "fl_effect.h"

/* Speed above which the direction is that of the motion: TURNS_MM_S of rendering/effect.py, q28. */
enum { TURNS = 536871 };

void fl_effect_begin(fl_effect *effect) {
    memset(effect, 0, sizeof *effect);
    for (int k = 0; k < FL_TRIGGERS; k++) effect->since[k] = FL_FAR;
}

/* Phases count values in 2^-24. */
static int32_t between(const fl_effect_step *s, const fl_store *store, int64_t phase, int32_t last) {
    int32_t cell = (int32_t)(phase >> 24);
    if (cell > last) cell = last;
    const int16_t *here = store->points + s->first + cell;
    int64_t share = phase - (int64_t)cell * (1 << 24);
    int64_t rise = fl_scale((here[1] - here[0]) * share, 24 - 16);
    return fl_mul((fl_gain){s->scale, s->scale_shift}, (int32_t)(here[0] * 65536 + rise));
}

/* Whole values alone say how many periods to leave out; they fit a word, and divide in 12 cycles, not 300. */
static int64_t turned(int64_t phase, int32_t count) {
    int32_t value = (int32_t)(phase >> 24) % count;
    if (value < 0) value += count;
    return (int64_t)value * (1 << 24) + (phase & 0xffffff);
}

static int32_t table(const fl_effect_step *s, const fl_store *store, int32_t along) {
    int64_t phase = fl_scale((int64_t)s->per * fl_subtract(along, s->start), s->per_shift);
    int64_t end = (int64_t)(s->count - 1) * (1 << 24);
    if (s->repeats) phase = turned(phase, s->count);
    else phase = phase < 0 ? 0 : phase > end ? end : phase;
    if (s->nearest) phase = (phase + (1 << 23)) & ~(int64_t)0xffffff;
    return between(s, store, phase, s->repeats ? s->count - 1 : s->count - 2);
}

static int32_t wave(const fl_effect_step *s, const fl_store *store, const fl_effect *effect) {
    int32_t ticks = effect->ticks;
    if (s->number < FL_TRIGGERS) {
        ticks = effect->since[s->number];
        if (effect->on[s->number] != s->nearest || ticks == FL_FAR) return 0;
    }
    int64_t phase = fl_scale((int64_t)s->per * ticks, s->per_shift);
    if (s->repeats) phase = turned(phase, s->count);
    else if (phase > (int64_t)(s->count - 1) * (1 << 24)) return 0;
    return between(s, store, phase, s->repeats ? s->count - 1 : s->count - 2);
}

static int32_t trigger(const fl_effect_step *s, fl_effect *effect, int32_t along, int32_t speed, int32_t load) {
    int32_t quantity = s->first == FL_CONDITION_LOAD ? load : s->first == FL_CONDITION_SPEED ? speed : along;
    int32_t on = s->start, off = s->per;
    int now_on = on > off ? quantity >= on : quantity <= on;
    int now_off = on > off ? quantity <= off : quantity >= off;
    uint8_t *is_on = &effect->on[s->number];
    if (!effect->runs) {
        *is_on = (uint8_t)now_on;
    } else if (effect->since[s->number] >= s->scale && (*is_on ? now_off : now_on)) {
        *is_on ^= 1;
        effect->since[s->number] = 0;
    }
    return *is_on ? FL_ONE : 0;
}

static int32_t mixed(int32_t share, int32_t one, int32_t other) {
    int64_t apart = (int64_t)one - other;
    return fl_saturate(other + fl_scale(fl_clip(share, 0, FL_ONE) * apart, 28));
}

static int32_t run(
    fl_effect *effect, const fl_store *store, int32_t along, const fl_measurement *m) {
    int32_t stack[FL_STACK], *top = stack, speed = m->speed < 0 ? fl_subtract(0, m->speed) : m->speed;
    const fl_effect_step *s = store->program.steps, *end = s + store->program.count;
    for (; s < end; s++) {
        fl_gain factor = {s->scale, s->scale_shift};
        switch (s->what) {
        case FL_STEP_TABLE: *top++ = table(s, store, along); break;
        case FL_STEP_WAVE: *top++ = wave(s, store, effect); break;
        case FL_STEP_ADD: top--; top[-1] = fl_add(top[-1], *top); break;
        case FL_STEP_MULTIPLY: top--; top[-1] = fl_mul28(top[-1], *top); break;
        case FL_STEP_LARGER: top--; if (*top > top[-1]) top[-1] = *top; break;
        case FL_STEP_MIX: top -= 2; top[-1] = mixed(top[-1], top[0], top[1]); break;
        case FL_STEP_DIRECTION: *top++ = effect->back ? -FL_ONE : FL_ONE; break;
        case FL_STEP_SPEED: *top++ = fl_mul(factor, speed); break;
        case FL_STEP_TRIGGER: *top++ = trigger(s, effect, along, speed, m->load); break;
        default: top[-1] = fl_mul(factor, top[-1]); break;
        }
    }
    return stack[0];
}

static int32_t later(int32_t ticks) { return ticks < FL_FAR ? ticks + 1 : ticks; }

int32_t fl_effect_force(
    fl_effect *effect, const fl_store *store, int32_t along, const fl_measurement *m, int32_t touch, fl_clamp clamp) {
    if (m->speed > TURNS) effect->back = 0;
    if (m->speed < -TURNS) effect->back = 1;
    if (m->load >= touch || !effect->runs)
        effect->held = fl_clip(run(effect, store, along, m), clamp.low, clamp.high);
    effect->runs = 1;
    effect->ticks = later(effect->ticks);
    for (int k = 0; k < FL_TRIGGERS; k++) effect->since[k] = later(effect->since[k]);
    return effect->held;
}

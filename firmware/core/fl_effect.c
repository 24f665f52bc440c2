/* Mirrors rendering/player.py. What it reads was checked by fl_effect_wrong. */
#include "fl_effect.h"

/* Speed above which the direction is that of the motion: TURNS_MM_S of rendering/effect.py, q28. */
enum { TURNS = 536871 };

static void begin(fl_effect *effect) {
    effect->ticks = 0;
    effect->back = 0;
    for (int k = 0; k < FL_TRIGGERS; k++) effect->since[k] = FL_FAR;
}

/* A phase counts values in 2^-16. A gain with 30 bits and a shift of at least 14 leaves 47 bits of it. */
typedef struct { int32_t value; int32_t share; } fl_phase;

static fl_phase phase_of(const fl_effect_step *s, int32_t along) {
    int64_t phase = ((int64_t)s->per * along) >> s->per_shift;
    return (fl_phase){(int32_t)(phase >> 16), (int32_t)(phase & 0xffff)};
}

/* Whole values alone say how many periods to leave out; they fit a word, and divide in 12 cycles, not 300. */
static int32_t turned(int32_t value, int32_t count) {
    int32_t left = value % count;
    return left < 0 ? left + count : left;
}

/* A value is 2^-15 of `scale`; with the 16 places of the share it is 2^-31 of it. */
static int32_t between(const fl_effect_step *s, const fl_store *store, fl_phase at) {
    const int16_t *here = store->points + s->first + at.value;
    uint32_t rise = (uint32_t)(here[1] - here[0]) * (uint32_t)at.share; /* modulo 2^32, as the sum, which fits */
    int32_t value = (int32_t)((uint32_t)here[0] * 65536u + rise);
    return (int32_t)(((int64_t)value * s->scale) >> 31);
}

static int32_t table(const fl_effect_step *s, const fl_store *store, int32_t along) {
    fl_phase at = phase_of(s, fl_subtract(along, s->start));
    int32_t last = s->count - (s->repeats ? 1 : 2);
    if (s->repeats) at.value = turned(at.value, s->count);
    else if (at.value < 0) at = (fl_phase){0, 0};
    else if (at.value > last) at = (fl_phase){last, 0x10000};
    if (s->nearest) at.share = at.share < 0x8000 ? 0 : 0x10000;
    return between(s, store, at);
}

static int32_t wave(const fl_effect_step *s, const fl_store *store, const fl_effect *effect) {
    int32_t ticks = effect->ticks;
    if (s->number < FL_TRIGGERS) {
        ticks = effect->since[s->number];
        if (effect->on[s->number] != s->nearest || ticks == FL_FAR) return 0;
    }
    fl_phase at = phase_of(s, ticks);
    if (s->repeats) {
        at.value = turned(at.value, s->count);
    } else if (at.value > s->count - 2) {
        if (at.value > s->count - 1 || at.share) return 0;
        at = (fl_phase){s->count - 2, 0x10000};
    }
    return between(s, store, at);
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
    int64_t part = (int64_t)fl_clip(share, 0, FL_ONE) * fl_subtract(one, other);
    return fl_add(other, (int32_t)(part >> 28));
}

static fl_gain factor_of(const fl_effect_step *s) { return (fl_gain){s->scale, s->scale_shift}; }

static int32_t run(
    fl_effect *effect, const fl_store *store, int32_t along, const fl_measurement *m) {
    int32_t stack[FL_STACK], *top = stack, speed = m->speed < 0 ? fl_subtract(0, m->speed) : m->speed;
    const fl_effect_step *s = store->program.steps, *end = s + store->program.count;
    for (; s < end; s++) {
        switch (s->what) {
        case FL_STEP_TABLE: *top++ = table(s, store, along); break;
        case FL_STEP_WAVE: *top++ = wave(s, store, effect); break;
        case FL_STEP_ADD: top--; top[-1] = fl_add(top[-1], *top); break;
        case FL_STEP_MULTIPLY: top--; top[-1] = fl_mul28(top[-1], *top); break;
        case FL_STEP_LARGER: top--; if (*top > top[-1]) top[-1] = *top; break;
        case FL_STEP_MIX: top -= 2; top[-1] = mixed(top[-1], top[0], top[1]); break;
        case FL_STEP_DIRECTION: *top++ = effect->back ? -FL_ONE : FL_ONE; break;
        case FL_STEP_SPEED: *top++ = fl_mul(factor_of(s), speed); break;
        case FL_STEP_TRIGGER: *top++ = trigger(s, effect, along, speed, m->load); break;
        default: top[-1] = fl_mul(factor_of(s), top[-1]); break;
        }
    }
    return stack[0];
}

static int32_t later(int32_t ticks) { return ticks < FL_FAR ? ticks + 1 : ticks; }

int32_t fl_effect_force(
    fl_effect *effect, const fl_store *store, int32_t along, const fl_measurement *m, int32_t touch, fl_clamp clamp) {
    if (!effect->runs) begin(effect);
    if (m->speed > TURNS) effect->back = 0;
    if (m->speed < -TURNS) effect->back = 1;
    if (m->load >= touch || !effect->runs)
        effect->held = fl_clip(run(effect, store, along, m), clamp.low, clamp.high);
    effect->runs = 1;
    effect->ticks = later(effect->ticks);
    for (int k = 0; k < FL_TRIGGERS; k++) effect->since[k] = later(effect->since[k]);
    return effect->held;
}

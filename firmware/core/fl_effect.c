/* As rendering/effect_program.py, whose instructions these are. What it reads was checked by fl_effect_wrong. */
#include "fl_effect.h"

#include <math.h>

static const double TURNS = 2e-3; /* speed above which the direction is that of the motion: TURNS_MM_S */

static void begin(fl_effect *effect) {
    effect->ticks = 0;
    effect->back = 0;
    for (int k = 0; k < FL_TRIGGERS; k++) effect->since[k] = FL_FAR;
}

double fl_turned(double x, double count) {
    return fl_clip(x - count * floor(x / count), 0, count);
}

/* Between two values; `u` is within them. */
static double between(const fl_effect_step *s, const fl_store *store, double u) {
    int32_t last = s->count - (s->repeats ? 1 : 2), cell = (int32_t)u < last ? (int32_t)u : last;
    const int16_t *here = store->points + s->first + cell;
    return s->scale * 0x1p-15 * (here[0] + (u - cell) * (here[1] - here[0]));
}

static double table(const fl_effect_step *s, const fl_store *store, double along) {
    double u = (along - s->start) * s->per;
    u = s->repeats ? fl_turned(u, s->count) : fl_clip(u, 0, s->count - 1);
    return between(s, store, s->nearest ? floor(u + 0.5) : u);
}

static double wave(const fl_effect_step *s, const fl_store *store, const fl_effect *effect) {
    int32_t ticks = effect->ticks;
    if (s->number < FL_TRIGGERS) {
        ticks = effect->since[s->number];
        if (effect->on[s->number] != s->nearest || ticks == FL_FAR) return 0;
    }
    double u = ticks * s->per;
    if (!s->repeats && u > s->count - 1) return 0;
    return between(s, store, s->repeats ? fl_turned(u, s->count) : u);
}

static double trigger(const fl_effect_step *s, fl_effect *effect, double along, double speed, double load) {
    double quantity = s->first == FL_CONDITION_LOAD ? load : s->first == FL_CONDITION_SPEED ? speed : along;
    double on = s->start, off = s->per;
    int now_on = on > off ? quantity >= on : quantity <= on;
    int now_off = on > off ? quantity <= off : quantity >= off;
    uint8_t *is_on = &effect->on[s->number];
    if (!effect->runs) {
        *is_on = (uint8_t)now_on;
    } else if (effect->since[s->number] >= s->scale && (*is_on ? now_off : now_on)) {
        *is_on ^= 1;
        effect->since[s->number] = 0;
    }
    return *is_on;
}

static double run(fl_effect *effect, const fl_store *store, double along, const fl_measurement *m) {
    double stack[FL_STACK], *top = stack, speed = 1e3 * fl_size(m->speed);
    const fl_effect_step *s = store->program.steps, *end = s + store->program.count;
    for (; s < end; s++) {
        switch (s->what) {
        case FL_STEP_TABLE: *top++ = table(s, store, along); break;
        case FL_STEP_WAVE: *top++ = wave(s, store, effect); break;
        case FL_STEP_ADD: top--; top[-1] += *top; break;
        case FL_STEP_MULTIPLY: top--; top[-1] *= *top; break;
        case FL_STEP_LARGER: top--; if (*top > top[-1]) top[-1] = *top; break;
        case FL_STEP_MIX: top -= 2; top[-1] = top[1] + fl_clip(top[-1], 0, 1) * (top[0] - top[1]); break;
        case FL_STEP_DIRECTION: *top++ = effect->back ? -1 : 1; break;
        case FL_STEP_SPEED: *top++ = s->scale * speed; break;
        case FL_STEP_TRIGGER: *top++ = trigger(s, effect, along, speed, m->load); break;
        default: top[-1] *= s->scale; break;
        }
    }
    return stack[0];
}

static int32_t later(int32_t ticks) { return ticks < FL_FAR ? ticks + 1 : ticks; }

double fl_effect_force(
    fl_effect *effect, const fl_store *store, double along, const fl_measurement *m, double touch, fl_clamp clamp) {
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

/* Mirrors touch_step of sensing/touch.py: an alpha-beta filter of the position, and whether a reading is
 * valid.
 *
 * Position and way are q44: at 20 mm/s a tick is 4 um, and a step of q28 would be 1e-3 of it. */
#include "fl_app_parts.h"

static const fl_gain period_s = {1759218604, 43}; /* 1/FL_TICK_HZ */
_Static_assert(FL_TICK_HZ == 5000, "period_s is 1/FL_TICK_HZ");
enum { FINER = 16 };                             /* q28 to q44 */
static const int64_t FARTHEST = (int64_t)1 << 48; /* 16 m: nothing gets there, and nothing overflows */

/* Way in a period at a speed, m in q44: q28 and q43 is q71. */
static int64_t moved(int32_t speed) {
    return fl_scale((int64_t)speed * period_s.mantissa, 28 + period_s.shift - 44);
}

static int64_t within(int64_t way) { return way > FARTHEST ? FARTHEST : way < -FARTHEST ? -FARTHEST : way; }

static void land_or_lift(fl_touch *touch, int64_t position) {
    touch->position = position;
    touch->speed = 0;
    touch->way = 0;
}

static void track(fl_touch *touch, const fl_parameters *p, int64_t position, int presses) {
    int64_t predicted = touch->position + moved(touch->speed);
    int32_t error = fl_saturate(fl_scale(position - predicted, FINER));
    touch->position = within(predicted + fl_scale((int64_t)p->touch_position_gain * error, 28 - FINER));
    touch->speed = fl_fma(p->touch_speed_gain, error, touch->speed);
    int64_t way = moved(touch->speed);
    if (presses) touch->way = within(touch->way + (way < 0 ? -way : way));
}

fl_measurement fl_touch_step(
    fl_touch *touch, const fl_parameters *p, int32_t position, int32_t load, int32_t force) {
    int64_t fine = (int64_t)position * (1 << FINER);
    int32_t share = fl_mul28(p->touch_touch_share, touch->mean_load);
    int touches = load >= p->touch_touch_n, presses = touches && load >= share;
    if (!touch->begun) land_or_lift(touch, fine);
    touch->begun = 1;
    if (touches) {
        int32_t above = fl_subtract(load, touch->mean_load);
        touch->mean_load = fl_add(touch->mean_load, fl_mul28(p->touch_mean_gain, above));
        track(touch, p, fine, presses);
    } else {
        land_or_lift(touch, fine);
    }
    int fast = touch->speed >= p->touch_least_speed_m_s || touch->speed <= -p->touch_least_speed_m_s;
    int developed = touch->way >= (int64_t)p->touch_developed_m * (1 << FINER);
    return (fl_measurement){force, position, touch->speed, load, presses && fast && developed};
}

/* Mirrors touch_step of sensing/touch.py: an alpha-beta filter of the position, and whether a reading is
 * valid.
 *
 * Position and ways are q44: at 20 mm/s a tick is 4 um, and a step of q28 would be 1e-3 of it. */
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

static int64_t developed(const fl_parameters *p) { return (int64_t)p->touch_developed_m * (1 << FINER); }

static int32_t size(int32_t x) { return x < 0 ? fl_subtract(0, x) : x; }

static void follow(int32_t *mean, int32_t gain, int32_t now) {
    *mean = fl_add(*mean, fl_mul28(gain, fl_subtract(now, *mean)));
}

static void land_or_lift(fl_touch *touch, const fl_parameters *p, int64_t position) {
    touch->position = position;
    touch->speed = 0;
    touch->missing = developed(p);
    touch->back = 0;
}

/* The way that the skin still misses, within a play of `developed` on both sides, and whether the finger has turned. */
static void stretch(fl_touch *touch, const fl_parameters *p, int64_t ahead, int presses) {
    int64_t missing = touch->missing - (presses ? ahead : 0), most = 2 * developed(p), back = touch->back - ahead;
    touch->missing = missing < 0 ? 0 : missing > most ? most : missing;
    touch->back = back < 0 ? 0 : back;
    if (touch->back > (int64_t)p->touch_turn_m * (1 << FINER)) {
        touch->missing = most - touch->missing;
        touch->back = 0;
        touch->backwards ^= 1;
    }
}

static void track(fl_touch *touch, const fl_parameters *p, int64_t position, int presses) {
    int64_t predicted = touch->position + moved(touch->speed);
    int32_t error = fl_saturate(fl_scale(position - predicted, FINER));
    touch->position = within(predicted + fl_scale((int64_t)p->touch_position_gain * error, 28 - FINER));
    touch->speed = fl_fma(p->touch_speed_gain, error, touch->speed);
    int64_t way = moved(touch->speed);
    stretch(touch, p, touch->backwards ? -way : way, presses);
}

fl_measurement fl_touch_step(
    fl_touch *touch, const fl_parameters *p, int32_t position, int32_t load, int32_t force) {
    int64_t fine = (int64_t)position * (1 << FINER);
    int32_t share = fl_mul28(p->touch_touch_share, touch->mean_load);
    int touches = load >= p->touch_touch_n, presses = touches && load >= share;
    if (!touch->begun) land_or_lift(touch, p, fine);
    touch->begun = 1;
    if (touches) {
        follow(&touch->mean_load, p->touch_mean_gain, load);
        track(touch, p, fine, presses);
        follow(&touch->mean_speed, p->touch_mean_gain, size(touch->speed));
    } else {
        land_or_lift(touch, p, fine);
    }
    int32_t ahead = touch->backwards ? fl_subtract(0, touch->speed) : touch->speed, least = ahead > 1 ? ahead : 1;
    int32_t told = touch->backwards ? -least : least;
    int32_t usual = fl_mul28(p->touch_speed_share, touch->mean_speed), most = size(ahead);
    int fast = most >= p->touch_least_speed_m_s && most >= usual;
    return (fl_measurement){force, position, told, load, presses && fast && touch->missing <= 0};
}

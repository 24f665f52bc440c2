/* What readings cannot be while the sensors are whole; docs/firmware-states.md has where the limits come from.
 *
 * Jump: a channel moves further in a tick than finger, plate and springs can. Contradiction: a force without
 * load, or along the motion. Hum: the force swings at the beat of the mains while the set-point is calm. */
#include "fl_app_parts.h"

enum {
    JUMPS = 3,                             /* of force or load; of the position one is enough */
    JUMPS_TICKS = FL_TICK_HZ / 50,         /* 20 ms, in which one of them is forgotten */
    CONTRARY_TICKS = FL_TICK_HZ * 3 / 200, /* 15 ms */
    /* Ticks in a period of the mains, of 60 and of 50 Hz, a twelfth shorter and longer: a swing is told at a quarter of
     * the limit, and the mean of the force may move by as much within a period (assumed), so that an end of one that is
     * as large as the limit moves by asin(1/2)/2pi of a period. The mains themselves stay within 1 % (EN 50160). */
    SHORTEST = FL_TICK_HZ * 11 / (12 * 60),
    LONGEST = FL_TICK_HZ * 13 / (12 * 50),
    HALF = FL_TICK_HZ * 6 / 1000,          /* the shorter half of one that a drift bends (assumed) */
    BEATS = 2,                             /* such periods, each half a period after the one before */
    MEMORY = 7,                            /* force and set-point are forgotten in 2^7 ticks */
    COARSER = 15                           /* q28 to 13 binary places, +-4 N in 16 bits */
};

static int32_t size(int32_t x) { return x < 0 ? fl_subtract(0, x) : x; }

/* Whether a reading has moved by more than `most` since the tick before. */
static int jumps(int32_t *last, int32_t now, int32_t most) {
    int32_t moved = size(fl_subtract(now, *last));
    *last = now;
    return moved > most;
}

static void watch_jumps(fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m) {
    int slid = sensors->valid;
    sensors->valid = (uint8_t)m->valid;
    if (sensors->jumped > 0) sensors->jumped--;
    /* The sign of the force turns with the motion. */
    if (jumps(&sensors->force, size(m->force), p->safety_force_jump_n))
        sensors->jumped += JUMPS_TICKS, sensors->channel = 1;
    if (jumps(&sensors->load, m->load, p->safety_load_jump_n))
        sensors->jumped += JUMPS_TICKS, sensors->channel = 3;
    if (jumps(&sensors->position, m->position, p->safety_position_jump_m) && slid && m->load >= p->touch_touch_n)
        sensors->jumped = JUMPS * JUMPS_TICKS, sensors->channel = 2;
    if (sensors->jumped > JUMPS * JUMPS_TICKS) sensors->jumped = JUMPS * JUMPS_TICKS;
}

/* Whether the finger slides, and has slid for so far since it landed or turned that the softest skin pulls no more. */
static int slides(fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m) {
    uint8_t heading = m->speed < 0 ? 2 : 1; /* 0 before the first reading */
    if (m->load < p->touch_touch_n || heading != sensors->heading) sensors->turned = m->position;
    sensors->heading = heading;
    return m->valid && size(fl_subtract(m->position, sensors->turned)) > p->safety_turn_m;
}

static int is_contrary(const fl_parameters *p, const fl_measurement *m, int slid) {
    int tells_load = p->touch_touch_n > 0 && p->touch_n_per_count.mantissa;
    if (tells_load && m->load < p->touch_touch_n) return size(m->force) > p->safety_contrary_n;
    return slid && m->force < -p->safety_contrary_n;
}

/* Hum is told from springs that ring: where they swing more than it in half of their period, the force is theirs.
 *
 * About half a period of the mains apart a hum has opposite signs, a force that stays is gone, and so are springs
 * that ring with a whole number of their periods in that time. */
static int32_t swing(fl_sensors *sensors, int32_t ticks, int32_t now) {
    int16_t *before = &sensors->forces[sensors->at];
    int32_t swung = now - *before;
    *before = (int16_t)now;
    if (++sensors->at >= ticks) sensors->at = 0;
    return swung;
}

static int32_t coarse(int32_t force) { return fl_clip(force >> COARSER, INT16_MIN, INT16_MAX); }

static void watch_hum(fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m, int32_t setpoint, int slid) {
    int32_t force = coarse(m->force), asked = coarse(setpoint), limit = p->safety_hum_n >> COARSER;
    int32_t swung = swing(sensors, p->safety_hum_ticks, force);
    sensors->level += size(force) - (sensors->level >> MEMORY);
    sensors->restless += size(asked - sensors->asked) - (sensors->restless >> MEMORY);
    sensors->asked = (int16_t)asked;
    if (sensors->since <= LONGEST) sensors->since++;
    if (!slid || sensors->restless > limit / 8 || sensors->since > LONGEST) sensors->beats = 0;
    int32_t half_way = sensors->at + p->safety_hum_ticks / 2;
    half_way -= half_way < p->safety_hum_ticks ? 0 : p->safety_hum_ticks;
    int32_t rung = size(force - sensors->forces[half_way]);
    if (rung > sensors->rung) sensors->rung = rung;
    int32_t up = sensors->up ? swung : -swung;
    if (up > sensors->peak) sensors->peak = up;
    if (up > -limit / 4) return;
    int32_t period = sensors->half + sensors->since, least = sensors->level >> (MEMORY + 1);
    int beats = period >= SHORTEST && period <= LONGEST && sensors->half >= HALF && sensors->since >= HALF;
    int hums = sensors->peak >= limit && sensors->peak >= least && sensors->rung <= 3 * sensors->peak;
    if (!beats || !hums) sensors->beats = 0;
    else if (sensors->beats < BEATS) sensors->beats++;
    sensors->period = (uint8_t)period;
    sensors->half = sensors->since;
    sensors->since = 0;
    sensors->rung = 0;
    sensors->peak = -up;
    sensors->up ^= 1;
}

void fl_sensors_step(fl_app *app, const fl_measurement *m, int32_t setpoint) {
    const fl_parameters *p = fl_in_force(app);
    fl_sensors *sensors = &app->sensors;
    int slid = slides(sensors, p, m);
    watch_jumps(sensors, p, m);
    if (!is_contrary(p, m, slid)) sensors->contrary = 0;
    else if (sensors->contrary < CONTRARY_TICKS) sensors->contrary++;
    watch_hum(sensors, p, m, setpoint, slid);
}

fl_raised fl_sensors_fault(const fl_app *app, int32_t force) {
    const fl_sensors *sensors = &app->sensors;
    uint32_t tick = app->tick;
    if (sensors->jumped > (JUMPS - 1) * JUMPS_TICKS)
        return (fl_raised){FL_FAULT_SENSOR_JUMPS, tick, sensors->channel};
    if (sensors->contrary >= CONTRARY_TICKS) return (fl_raised){FL_FAULT_SENSOR_CONTRARY, tick, force};
    if (sensors->beats >= BEATS) return (fl_raised){FL_FAULT_SENSOR_HUMS, tick, sensors->period};
    return (fl_raised){FL_FAULT_NONE, tick, 0};
}

/* What readings cannot be while the sensors are whole; docs/firmware-states.md has where the limits come from.
 *
 * Jump: a channel moves further in a tick than finger, plate and springs can, or turns faster and stays. Contradiction:
 * a force without load, none under load, or along the motion. Hum: the force swings at the beat of the mains while the
 * set-point is calm. */
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
    BEATS = 12                             /* such periods, each half a period after the one before */
};
static const double FORGOTTEN = 1 / (0.0256 * FL_TICK_HZ); /* of force and set-point in a tick */
/* Of any finger: half of the least published coefficient of friction, and tau in 1/um^2 four standard deviations up. */
static const double LEAST = 0.2, STEEPEST = 1.5;

/* Whether a reading has moved by more than `most` since the tick before. */
static int jumps(double *last, double now, double most) {
    double moved = fl_size(now - *last);
    *last = now;
    return moved > most;
}

static int is_within(int32_t x, int32_t most) { return x <= most && x >= -most; }

/* Whether a reading has stepped between the ticks before: bent one way by more than `most`, and back as much in the next
 * tick, after which it stays. A spark comes back. */
static int steps(fl_sensors *sensors, int k, int32_t now, int32_t most) {
    int32_t moved = now - sensors->counts[k], bent = moved - sensors->moved[k], *before = sensors->bent[k];
    int32_t bent_twice = before[0] + before[1];
    int up = before[0] > most && before[1] < -most, down = before[0] < -most && before[1] > most;
    sensors->counts[k] = now;
    sensors->moved[k] = moved;
    before[0] = before[1];
    before[1] = bent;
    return (up || down) && is_within(bent, most) && is_within(bent_twice, most);
}

/* Of the magnitudes: the sign of the force turns with the motion, where the magnitude bends but once. */
static void watch_steps(fl_sensors *sensors, const fl_parameters *p, const fl_sample *sample, int32_t most) {
    for (int k = 0; k < 2; k++) {
        int32_t now = fl_clip_whole(sample->force[k], INT16_MIN, INT16_MAX) - (int32_t)p->force_zero_counts[k];
        if (now < 0) now = -now;
        if (!sensors->heading) sensors->counts[k] = now;
        if (steps(sensors, k, now, most)) sensors->jumped = JUMPS * JUMPS_TICKS, sensors->channel = 1;
    }
}

static void watch_jumps(fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m) {
    int slid = sensors->valid;
    sensors->valid = m->valid > 0.5;
    if (sensors->jumped > 0) sensors->jumped--;
    /* The sign of the force turns with the motion. */
    if (jumps(&sensors->force, fl_size(m->force), p->safety_force_jump_n))
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
    if (m->load < p->touch_touch_n || heading != sensors->heading) sensors->turned = sensors->pulled = m->position;
    if (fl_size(m->force) > p->safety_force_limit_n) sensors->pulled = m->position;
    sensors->heading = heading;
    return m->valid > 0.5 && fl_size(m->position - sensors->turned) > p->safety_turn_m;
}

/* Least friction of any finger under a load: mu N exp(-tau a^2), whose exp(-x) is above (1 - x/8)^8. */
static double least(const fl_sensors *sensors, double load) {
    double left = fl_clip(1 - STEEPEST / 8 * sensors->driven * sensors->driven, 0, 1);
    left *= left;
    left *= left;
    return LEAST * load * left * left;
}

static int is_contrary(const fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m, int slid) {
    int tells_load = p->touch_touch_n > 0 && p->touch_n_per_count != 0;
    if (tells_load && m->load < p->touch_touch_n) return fl_size(m->force) > p->safety_contrary_n;
    int skin_pulls = fl_size(m->position - sensors->pulled) <= p->safety_turn_m; /* after a force too large to tell */
    int along = m->force < -p->safety_contrary_n && !skin_pulls;
    return slid && (along || sensors->level < least(sensors, m->load));
}

/* Hum is told from springs that ring: where they swing more than it in half of their period, the force is theirs.
 *
 * About half a period of the mains apart a hum has opposite signs, a force that stays is gone, and so are springs
 * that ring with a whole number of their periods in that time. */
static double swing(fl_sensors *sensors, int32_t ticks, double now) {
    double *before = &sensors->forces[sensors->at], swung = now - *before;
    *before = now;
    if (++sensors->at >= ticks) sensors->at = 0;
    return swung;
}

static void watch_hum(fl_sensors *sensors, const fl_parameters *p, const fl_measurement *m, double setpoint, int slid) {
    double force = m->force, limit = p->safety_hum_n;
    int32_t ticks = (int32_t)p->safety_hum_ticks;
    double swung = swing(sensors, ticks, force);
    sensors->level += FORGOTTEN * (fl_size(force) - sensors->level);
    sensors->restless += fl_size(setpoint - sensors->asked) - FORGOTTEN * sensors->restless;
    sensors->asked = setpoint;
    if (sensors->since <= LONGEST) sensors->since++;
    if (!slid || sensors->restless > limit / 8 || sensors->since > LONGEST) sensors->beats = 0;
    int32_t half_way = sensors->at + ticks / 2;
    half_way -= half_way < ticks ? 0 : ticks;
    double rung = fl_size(force - sensors->forces[half_way]);
    if (rung > sensors->rung) sensors->rung = rung;
    double up = sensors->up ? swung : -swung;
    if (up > sensors->peak) sensors->peak = up;
    if (up > -limit / 4) return;
    int32_t period = sensors->half + sensors->since;
    double least = sensors->level / 2;
    int beats = period >= SHORTEST && period <= LONGEST && sensors->half >= HALF && sensors->since >= HALF;
    int hums = sensors->peak >= limit && sensors->peak >= least && sensors->rung <= 3 * sensors->peak;
    if (!beats || !hums) sensors->beats = 0;
    else if (sensors->beats < BEATS) sensors->beats++;
    sensors->period = period;
    sensors->half = sensors->since;
    sensors->since = 0;
    sensors->rung = 0;
    sensors->peak = -up;
    sensors->up ^= 1;
}

void fl_sensors_step(fl_app *app, const fl_sample *sample, const fl_measurement *m, double setpoint) {
    const fl_parameters *p = fl_in_force(app);
    fl_sensors *sensors = &app->sensors;
    watch_steps(sensors, p, sample, app->derived[app->parameters.in_force].bend_counts);
    int slid = slides(sensors, p, m);
    watch_jumps(sensors, p, m);
    sensors->driven += FORGOTTEN * (app->amplitude - sensors->driven);
    if (app->amplitude > sensors->driven) sensors->driven = app->amplitude;
    if (!is_contrary(sensors, p, m, slid)) sensors->contrary = 0;
    else if (sensors->contrary < CONTRARY_TICKS) sensors->contrary++;
    watch_hum(sensors, p, m, setpoint, slid);
}

fl_raised fl_sensors_fault(const fl_app *app, double force) {
    const fl_sensors *sensors = &app->sensors;
    uint32_t tick = app->tick;
    if (sensors->jumped > (JUMPS - 1) * JUMPS_TICKS)
        return (fl_raised){FL_FAULT_SENSOR_JUMPS, tick, sensors->channel};
    if (sensors->contrary >= CONTRARY_TICKS) return (fl_raised){FL_FAULT_SENSOR_CONTRARY, tick, force};
    if (sensors->beats >= BEATS) return (fl_raised){FL_FAULT_SENSOR_HUMS, tick, (double)sensors->period / FL_TICK_HZ};
    return (fl_raised){FL_FAULT_NONE, tick, 0};
}

/* States and faults (docs/firmware-states.md). A fault is raised while the loop is on, that of the table
 * always; it is latched, told once, and cleared by the host when its cause is over. */
#include "fl_app_parts.h"

static void count(uint32_t *ticks, int holds) {
    if (!holds) *ticks = 0;
    else if (*ticks < UINT32_MAX) *ticks += 1;
}

/* Of ticks that come and go: each that holds weighs two, any other takes one back. Full after `full/2` in a row,
 * and as soon when it comes back half of the time. */
static void weigh(uint32_t *weight, int holds, uint32_t full) {
    if (holds) *weight = *weight + 2 < full ? *weight + 2 : full;
    else if (*weight) *weight -= 1;
}

/* Both ends of 16 bits, -32768 and 32767, have the magnitude 32767. A force may be read with fewer bits than
 * are counted, 12 at least (chosen): its upper end is 32752 then. None reaches the end of a channel that is not there,
 * which has gain 0: it is neither stuck nor saturated. */
static const uint32_t NOT_THERE = UINT32_MAX;
enum { CHANNELS = 4, ALONE_TICKS = FL_ALONE_S * FL_TICK_HZ, FORCE_BITS = 12 };
enum { FORCE_END = (1 << 15) - (1 << (16 - FORCE_BITS)) };

static uint32_t magnitude(int32_t counts) { return (uint32_t)(counts < 0 ? ~counts : counts); }

void fl_derive_ends(uint32_t ends[4], const fl_parameters *p) {
    const double *force = p->force_n_per_count;
    double across = p->force_axes == 2 ? force[1] : 0;
    double scales[CHANNELS] = {force[0], across, p->touch_m_per_count, p->touch_n_per_count};
    for (int k = 0; k < CHANNELS; k++) ends[k] = scales[k] == 0 ? NOT_THERE : k < 2 ? FORCE_END : INT16_MAX;
}

static const uint32_t *ends_in_force(const fl_app *app) { return app->derived[app->parameters.in_force].ends; }

/* The first channel at an end, CHANNELS where there is none. Position and load may be counted wider than a
 * converter does: only its two ends themselves are ends of theirs. */
static int ended(const uint32_t *ends, const fl_sample *sample) {
    if (magnitude(sample->force[0]) >= ends[0]) return 0;
    if (magnitude(sample->force[1]) >= ends[1]) return 1;
    if (magnitude(sample->position) == ends[2]) return 2;
    return magnitude(sample->load) == ends[3] ? 3 : CHANNELS;
}

void fl_watch_step(fl_app *app, const fl_sample *sample, const fl_measurement *m, int32_t late) {
    const fl_parameters *p = fl_in_force(app);
    fl_watch *watch = &app->watch;
    const uint32_t *ends = ends_in_force(app);
    int at_end = ended(ends, sample) < CHANNELS;
    int beyond = m->force > p->safety_force_limit_n || m->force < -p->safety_force_limit_n;
    for (int k = 0; k < 2; k++) {
        int32_t now = sample->force[k];
        if (now < watch->low[k]) watch->low[k] = now;
        if (now > watch->high[k]) watch->high[k] = now;
        int stays = ends[k] != NOT_THERE && m->valid > 0.5 && (uint32_t)watch->high[k] - (uint32_t)watch->low[k] <= 1;
        count(&watch->stuck[k], stays);
        if (!stays) watch->low[k] = watch->high[k] = now;
    }
    weigh(&watch->saturated, at_end, 2 * (uint32_t)p->safety_force_ticks);
    count(&watch->out_of_range, beyond);
    if (++watch->second >= FL_TICK_HZ) watch->second = watch->late = 0;
    if (late) {
        watch->late++;
        app->overruns++;
    }
}

static int is_saturated(const fl_watch *watch, const fl_parameters *p) {
    return watch->saturated >= 2 * (uint32_t)p->safety_force_ticks;
}

/* A reading that has been within one step for n ticks has stayed n - 1 times. */
static int is_stuck(const fl_watch *watch, int k, const fl_parameters *p) {
    return watch->stuck[k] + 1 >= (uint32_t)p->safety_stuck_ticks;
}

static int32_t reading(const fl_sample *sample, int k) {
    return k < 2 ? sample->force[k] : k == 2 ? sample->position : sample->load;
}

/* The fault that there is reason for, the more telling first. */
static fl_raised cause(const fl_app *app, const fl_sample *sample, const fl_measurement *m, uint32_t now_us) {
    const fl_parameters *p = fl_in_force(app);
    const fl_watch *watch = &app->watch;
    int32_t silent_us = (int32_t)(now_us - app->heard_us);
    uint32_t tick = app->tick;
    if (is_saturated(watch, p))
        return (fl_raised){FL_FAULT_SENSOR_SATURATED, tick, reading(sample, ended(ends_in_force(app), sample))};
    if (watch->out_of_range >= (uint32_t)p->safety_force_ticks)
        return (fl_raised){FL_FAULT_FORCE_RANGE, tick, m->force};
    /* What is too large stays at an end in a sensor that works: while either count runs, it is what will be told. */
    for (int k = 0; k < 2 && !watch->saturated && !watch->out_of_range; k++)
        if (is_stuck(watch, k, p)) return (fl_raised){FL_FAULT_SENSOR_STUCK, tick, sample->force[k]};
    if (silent_us > FL_SILENCE_MS * 1000) return (fl_raised){FL_FAULT_HOST_SILENT, tick, 1e-3 * silent_us};
    if (watch->late >= (uint32_t)p->safety_overrun_ticks)
        return (fl_raised){FL_FAULT_TICK_OVERRUN, tick, watch->late};
    return fl_sensors_fault(app, m->force);
}

void fl_raise(fl_app *app, fl_raised raised) {
    app->raised = raised;
    app->fault = raised.fault;
    app->state = FL_STATE_FAULT;
    fl_fence();
    app->tell_fault = 1;
}

static void obey(fl_app *app) {
    if (app->asked_clear) {
        app->asked_clear = 0;
        if (app->state == FL_STATE_FAULT && !app->bad_table) {
            app->state = FL_STATE_IDLE;
            app->fault = FL_FAULT_NONE;
        }
    }
    uint8_t wanted = app->asked_state;
    if (wanted == FL_NO_STATE) return;
    app->asked_state = FL_NO_STATE;
    if (app->state == FL_STATE_FAULT) return;
    int was_on = fl_is_on(app);
    app->state = wanted;
    if (!was_on && fl_is_on(app)) fl_setpoint_begin(app); /* a run begins with the first point of its table */
}

void fl_state_step(fl_app *app, const fl_sample *sample, const fl_measurement *m, uint32_t now_us) {
    obey(app);
    uint32_t *alone = &app->watch.alone;
    if (!fl_is_on(app)) {
        *alone = 0;
        return;
    }
    fl_raised found = cause(app, sample, m, now_us);
    if (found.fault != FL_FAULT_NONE) fl_raise(app, found);
    else if (m->valid > 0.5) *alone = 0;
    else if (++*alone >= ALONE_TICKS)
        fl_raise(app, (fl_raised){FL_FAULT_NO_FINGER, app->tick, (double)*alone / FL_TICK_HZ});
}

int fl_cause_lasts(const fl_app *app) {
    const fl_watch *watch = &app->watch;
    const fl_parameters *p = fl_in_force(app);
    switch (app->fault) {
    case FL_FAULT_FORCE_RANGE: return watch->out_of_range > 0;
    case FL_FAULT_SENSOR_SATURATED: return is_saturated(watch, p);
    case FL_FAULT_SENSOR_STUCK: return is_stuck(watch, 0, p) || is_stuck(watch, 1, p);
    case FL_FAULT_TICK_OVERRUN: return watch->late >= (uint32_t)p->safety_overrun_ticks;
    case FL_FAULT_BAD_PARAMETER:
    case FL_FAULT_BAD_IMAGE: return app->bad_table;
    case FL_FAULT_SENSOR_JUMPS:
    case FL_FAULT_SENSOR_CONTRARY:
    case FL_FAULT_SENSOR_HUMS: return fl_sensors_fault(app, 0).fault == app->fault;
    default: return 0; /* a host that asks is not silent */
    }
}

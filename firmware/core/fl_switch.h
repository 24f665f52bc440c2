/* How the loop is opened and closed, in the tick and in the simulator alike (control/law.py).
 *
 * Open: u is the set-point within the clamp, and the law runs along with both ends of its clamp there, so that
 * its observers know what goes on. When the loop closes, an integral begins with what open loop commands, and
 * for FL_CLOSING ticks the lower clamp comes down from there to where it belongs: the amplitude begins with at
 * most what the set-point asks for, and the law's anti-windup knows why.
 *
 * In a header, so that the tick spends no calls on it. */
#ifndef FL_SWITCH_H
#define FL_SWITCH_H

#include "fl_protocol.h"
#include "laws.h"

/* Ticks over which the clamp opens after closing, 0.1 s (assumed): a power of two, as the tick divides by it. */
enum { FL_CLOSING_BITS = 9, FL_CLOSING = 1 << FL_CLOSING_BITS };

/* The clamp of the law while it closes; `open` is what open loop would command. */
static inline fl_clamp fl_closing_clamp(
    const fl_parameters *p, int32_t *state, int32_t *closing, int32_t open, int32_t setpoint) {
    if (*closing < 0) {
        fl_begin *integral = fl_begins[p->law_number];
        if (integral) integral(state, open, setpoint, p->law_gains);
        *closing = FL_CLOSING;
    }
    int32_t down = (int32_t)(((int64_t)(open - p->law_low_n) * *closing) >> FL_CLOSING_BITS);
    return (fl_clamp){p->law_low_n + down, p->law_high_n};
}

/* u of a tick. `closing` is -1 while the loop is open, then the ticks left of closing, 0 when it is closed. */
static inline fl_force_command fl_switched(
    const fl_parameters *p, int32_t *state, int32_t *closing, int closed, const fl_measurement *m,
    int32_t setpoint) {
    int32_t open = fl_clip(setpoint, p->law_low_n, p->law_high_n);
    fl_step *step = fl_laws[p->law_number].step;
    if (closed) {
        fl_clamp clamp = fl_closing_clamp(p, state, closing, open, setpoint);
        if (*closing > 0) --*closing;
        return step(state, m, setpoint, p->law_gains, clamp);
    }
    step(state, m, setpoint, p->law_gains, (fl_clamp){open, open});
    *closing = -1;
    return (fl_force_command){open, open != setpoint};
}

#endif

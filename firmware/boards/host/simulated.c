/* The controller as a simulator with floating point calls it: one function of two addresses (loop/kernel/fixed_tile.py).
 *
 * context: the parameter table, the law's state, the believed amplitude, and how far the loop has closed. given: force,
 * position, speed, load (SI), valid, set-point, and 1 unless the loop is open; back come u in N, saturated, and the
 * amplitude command in um. */
#include "fl_host.h"

#include "fl_law.h"

static int32_t q28(double x) {
    double scaled = x * FL_ONE;
    if (!(scaled > (double)INT32_MIN)) return INT32_MIN; /* as well for what is no number */
    if (scaled >= (double)INT32_MAX) return INT32_MAX;
    return (int32_t)(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

void fl_host_simulated(int32_t *context, double *given) {
    int32_t *state = context + FL_WORDS, *believed = state + FL_STATES, *closing = believed + 1, out[2];
    int32_t measured[5] = {q28(given[0]), q28(given[1]), q28(given[2]), q28(given[3]), given[4] > 0.5};
    int32_t setpoint = q28(given[5]), closed = given[6] > 0.5;
    int32_t amplitude = fl_host_switched(context, state, believed, closing, measured, setpoint, closed, out);
    given[7] = (double)out[0] / FL_ONE;
    given[8] = out[1];
    given[9] = (double)amplitude / FL_ONE;
}

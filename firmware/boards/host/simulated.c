/* The controller as a simulator with floating point calls it: one function of two addresses (loop/fixed_tile.py).
 *
 * context: the parameter table, the law's state, and the believed amplitude. given: force, position, speed, load (SI),
 * valid and set-point; back come u in N, saturated, and the amplitude command in um. */
#include "fl_host.h"

#include "fl_law.h"

static int32_t q28(double x) {
    double scaled = x * FL_ONE;
    if (!(scaled > (double)INT32_MIN)) return INT32_MIN; /* as well for what is no number */
    if (scaled >= (double)INT32_MAX) return INT32_MAX;
    return (int32_t)(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

void fl_host_simulated(int32_t *context, double *given) {
    int32_t *state = context + FL_WORDS, *believed = state + FL_STATES, out[3];
    int32_t measured[5] = {q28(given[0]), q28(given[1]), q28(given[2]), q28(given[3]), given[4] > 0.5};
    int32_t setpoint = q28(given[5]);
    fl_host_run(context, 1, state, believed, measured, &setpoint, out);
    given[6] = (double)out[0] / FL_ONE;
    given[7] = out[1];
    given[8] = (double)out[2] / FL_ONE;
}

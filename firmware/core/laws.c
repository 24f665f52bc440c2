/* Every control law by the number that the parameter law.number has: the order of LAWS in control/laws.py.
 *
 * A law without a step is not built in. */
#include "laws.h"

const fl_law fl_laws[] = {
    {0, 0, 0, 0, 0},
    {"pi", fl_pi_step, 1, 2, 0},
    {"lookup", fl_open_loop_step, 1, 0, 0},
    {"filtered_pi", fl_filtered_pi_step, 21, 52, 0},
    {"observer", 0, 0, 0, 0},
    {"super_twisting", 0, 0, 0, 0},
    {"tracker", 0, 0, 0, 0},
};
const uint32_t fl_law_count = sizeof fl_laws / sizeof fl_laws[0];

/* Every control law by the number that the parameter law.number has: the order of LAWS in control/laws.py.
 *
 * A law without a step is not built in. */
#include "laws.h"

const fl_law fl_laws[] = {
    {0, 0, 0, 0, 0},
    {"pi", fl_pi_step, 1, 2, 0},
    {"lookup", fl_open_loop_step, 1, 0, 0},
    {"filtered_pi", fl_filtered_pi_step, 21, 52, 0},
    {"observer", fl_disturbance_observer_step, 18, 30, fl_disturbance_observer_places},
    {"super_twisting", fl_super_twisting_step, 21, 34, fl_super_twisting_places},
    {"tracker", fl_tracker_step, 31, 71, fl_tracker_places},
};
const uint32_t fl_law_count = sizeof fl_laws / sizeof fl_laws[0];

fl_begin *const fl_begins[] = {0, fl_pi_begin, 0, fl_filtered_pi_begin, 0, 0, 0};
fl_follow *const fl_follows[] = {0, 0, 0, 0, 0, 0, fl_tracker_follow};
_Static_assert(sizeof fl_follows == sizeof fl_begins, "for each law");
_Static_assert(sizeof fl_begins / sizeof fl_begins[0] == sizeof fl_laws / sizeof fl_laws[0], "for each law");

/* Every control law, a row each, by the number that the parameter law.number has: 1 is the first, as in NUMBERED of
 * control/laws.py. A law without a step is not built in. */
#include "laws.h"

/* Kind, step, numbers of states and gains, binary places of the states (0: 28 for all), begin and follow (laws.h). */
#define LAWS(LAW) \
    LAW("pi", fl_pi_step, 1, 2, 0, fl_pi_begin, 0) \
    LAW("lookup", fl_open_loop_step, 1, 0, 0, 0, 0) \
    LAW("filtered_pi", fl_filtered_pi_step, 21, 52, 0, fl_filtered_pi_begin, 0) \
    LAW("observer", fl_disturbance_observer_step, 18, 30, fl_disturbance_observer_places, 0, 0) \
    LAW("super_twisting", fl_super_twisting_step, 21, 34, fl_super_twisting_places, 0, 0) \
    LAW("tracker", fl_tracker_step, 31, 71, fl_tracker_places, 0, fl_tracker_follow)

#define LAW(kind, step, states, gains, places, begin, follow) {kind, step, states, gains, places},
#define BEGIN(kind, step, states, gains, places, begin, follow) begin,
#define FOLLOW(kind, step, states, gains, places, begin, follow) follow,

const fl_law fl_laws[] = {{0, 0, 0, 0, 0}, LAWS(LAW)};
const uint32_t fl_law_count = sizeof fl_laws / sizeof fl_laws[0];
fl_begin *const fl_begins[] = {0, LAWS(BEGIN)};
fl_follow *const fl_follows[] = {0, LAWS(FOLLOW)};

/* Every control law, a row each, by the number that the parameter law.number has: 1 is the first, as in NUMBERED of
 * control/laws.py. A law without a step is not built in: its code is nowhere named, and the linker leaves it out. */
#include <stddef.h>

#include "laws.h"

/* Bit n is set where law n is built in; frictionloop.firmware.image chooses. */
#ifndef FL_LAWS_BUILT_IN
#define FL_LAWS_BUILT_IN 0xFFFFu
#endif

/* Number, kind, step, numbers of states and gains, binary places of the states (0: 28 for all), and begin (laws.h). */
#define LAWS(LAW) \
    LAW(1, "pi", fl_pi_step, 1, 2, 0, fl_pi_begin) \
    LAW(2, "lookup", fl_open_loop_step, 1, 0, 0, 0) \
    LAW(3, "filtered_pi", fl_filtered_pi_step, 21, 52, 0, fl_filtered_pi_begin) \
    LAW(4, "limit_observer", fl_limit_observer_step, 8, 28, fl_limit_observer_places, 0)

#define BUILT_IN(number, what) (FL_LAWS_BUILT_IN >> (number) & 1 ? (what) : NULL)
#define LAW(number, kind, step, states, gains, places, begin) \
    {kind, BUILT_IN(number, step), states, gains, BUILT_IN(number, places)},
#define BEGIN(number, kind, step, states, gains, places, begin) BUILT_IN(number, begin),

const fl_law fl_laws[] = {{0, 0, 0, 0, 0}, LAWS(LAW)};
const uint32_t fl_law_count = sizeof fl_laws / sizeof fl_laws[0];
fl_begin *const fl_begins[] = {0, LAWS(BEGIN)};

uint16_t fl_laws_built_in(void) {
    uint16_t built = 0;
    for (uint32_t number = 1; number < fl_law_count; number++)
        if (fl_laws[number].step) built |= (uint16_t)(1u << number);
    return built;
}

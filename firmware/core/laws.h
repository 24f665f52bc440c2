/* The steps of all laws, for the table in laws.c. */
#ifndef FL_LAWS_H
#define FL_LAWS_H

#include "fl_law.h"

fl_step fl_pi_step, fl_open_loop_step, fl_filtered_pi_step, fl_limit_observer_step;
extern const int8_t fl_limit_observer_places[];

/* Sets the integral of a law that has one so that, with no error, it commands `force`: for closing without
 * a bump. */
typedef void fl_begin(int32_t *state, int32_t force, int32_t setpoint, const fl_gain *gains);
fl_begin fl_pi_begin, fl_filtered_pi_begin;

/* By number as fl_laws; 0 where a law has no integral. */
extern fl_begin *const fl_begins[];

/* Bit n is set where law n is built in. */
uint16_t fl_laws_built_in(void);

#endif

/* The steps of all laws, for the table in laws.c. */
#ifndef FL_LAWS_H
#define FL_LAWS_H

#include "fl_law.h"

fl_step fl_pi_step, fl_open_loop_step, fl_filtered_pi_step;

#endif

/* A run of known length with known input, for comparing boards and compilers by one number. */
#ifndef FL_SCENARIO_H
#define FL_SCENARIO_H

#include "stimulus.h"

typedef struct {
    uint64_t drives, bytes; /* digests of what the tick and what the background gave out */
    uint32_t sent;          /* bytes */
} fl_scenario;

/* Begin with parameters in force. */
void fl_scenario_start(
    fl_scenario *scenario, fl_app *app, const fl_identity *identity, const fl_parameters *table);

/* What the interrupt does at a tick, and what the background does between it and the next. */
void fl_scenario_tick(fl_scenario *scenario, fl_app *app, uint32_t tick);
void fl_scenario_background(fl_scenario *scenario, fl_app *app, uint32_t tick);

/* The whole scenario, one after the other: for the host. */
void fl_scenario_run(
    fl_scenario *scenario, fl_app *app, const fl_identity *identity, const fl_parameters *table);

#endif

/* The friction force earlier than the sensor tells it: control/force_observer.py in fixed point. */
#ifndef FL_OBSERVER_H
#define FL_OBSERVER_H

#include "fl_law.h"

/* As ObserverState. Forces are q28, those of the sensor (spring, rate, reading) q26: a knock makes them
 * ring, +-32 N. SLID and FORWARD are whole numbers. */
enum {
    FL_PLATE, FL_AHEAD, FL_SPRING, FL_RATE, FL_READING, FL_REST, FL_KEPT, FL_SLID, FL_FORWARD, FL_NOW, FL_NEXT,
    FL_OBSERVER_STATES = 18
};

#define FL_OBSERVER_PLACES 28, 28, 26, 26, 26, 28, 28, 0, 0, 28, 28, 28, 28, 28, 28, 28, 28, 28

/* As ObserverGains. A row of the believed step has one shift (fl_row.h); WHOLE is a whole number, LIMIT
 * q28. */
enum {
    FL_PP, FL_PO, FL_PN,
    FL_X1P, FL_X11, FL_X12, FL_X1O, FL_X1N, FL_X1D,
    FL_X2P, FL_X21, FL_X22, FL_X2O, FL_X2N, FL_X2D,
    FL_X3P, FL_X31, FL_X32, FL_X33, FL_X3O, FL_X3N, FL_X3D,
    FL_K1, FL_K2, FL_K3, FL_KD, FL_WHOLE, FL_INVERSE_PLATE, FL_LIMIT, FL_OBSERVER_GAINS
};

/* observe_step: correct the state by one reading; the friction force at its time is then PLATE + KEPT. */
void fl_observe(int32_t *state, const fl_measurement *measurement, const fl_gain *gains);

/* predict_step: go on by one period with the command in N, as it will be held. */
void fl_predict(int32_t *state, int32_t command, const fl_gain *gains);

/* held_step: the command that takes the plate from `ahead` to `wanted` within a period. */
int32_t fl_held(int32_t ahead, int32_t wanted, const fl_gain *gains, fl_clamp clamp);

#endif

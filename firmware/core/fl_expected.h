/* What the force sensor should read if the controller's model were right (control/expected.py).
 *
 * State: three commands under way, driven, plate (N, q28), spring, rate, reading (N, places of their own, because
 * springs resonate). Gains: 16. */
#ifndef FL_EXPECTED_H
#define FL_EXPECTED_H

#include "fl_law.h"

/* Whether there is feed-forward. */
int fl_expects(const fl_gain *gains);

/* The reading expected now, N, q28. */
int32_t fl_expected(const int32_t *state, const fl_gain *gains);

/* Go on by one period under this set-point. */
void fl_expect(int32_t *state, int32_t setpoint, fl_clamp clamp, const fl_gain *gains);

#endif

/* Steps of the tracker's observer: control/limit_observer.py in fixed point, and the formats of its states.
 *
 * Binary places, and so ranges, of what is not q28:
 *   limits (N) and binary logarithms  q26, +-32: a limit above 32 N counts as 32 N
 *   springs, rate, reading            q23, q22, q24: +-256, 512 and 128 N; readings of +-2.5 N, however
 *                                     wild, reached 20, 67 and 13
 *   innovation (N)                    q26, +-32
 *   compliance (um/N)                 q20, +-2048
 *   rates of friction (N/s)           q15, +-65536: 10 N in a period, smoothed
 *   sensitivities by the compliance   q30, springs q31, rate q30, reading q32 (+-0.5): begin anew above 0.02
 *                                     of the reading's; typical is 1e-7, and mean squares of 1e-12 decide
 *                                     how much is learnt
 *   sensitivities by the fall         q26, springs q27, rate q26, reading q28 (+-8): begin anew above 4;
 *                                     typical is 1e-4
 *   mean squares                      q60 and q52 in two words each
 * Of sensitivities beyond their range the reading's passes its limit within a few ticks, and all begin anew.
 *
 * In all three groups springs, rate and reading have 1, 0 and 2 places more than the friction that drives
 * them (the observer's friction is taken as q22 there), so that one set of coefficients steps all. */
#ifndef FL_TRACKER_H
#define FL_TRACKER_H

#include "fl_real.h"

enum { FL_SENSOR_STEP = 13, FL_SCHEDULED = 7, FL_PLACES = 10 };
#define FL_LEAST_WAY (INT64_C(1) << 40) /* 0.016 um */

/* scheduled at place_of: the schedule, row by row, at a share and a speed (q28; m/s, at least 0), between its
 * rows at the ten of PLACES. */
void fl_schedule(int32_t *values, int32_t share, int32_t speed, const fl_gain *table);

/* share_of: way / (way + c L) in q28, way = v dt in um; c q20, L q26, way q46, at least FL_LEAST_WAY.
 * `per_whole` becomes 1 / (way + c L), of a number in q46 and its upper 32 bits: `bits` are 1 to 23. */
int32_t fl_share_of(int32_t compliance, int32_t limit, int64_t way, fl_inverse *per_whole);

/* limit_of: 2^(d - fall a^2) in q26; d q26, fall and a q28. */
int32_t fl_limit_of(int32_t limit_log2, int32_t fall, int32_t amplitude);

/* fall a^2 in q26; fall and a q28. */
int32_t fl_lowering(int32_t fall, int32_t amplitude);

/* stuck_share in q28; friction q28, limit q26, both rates q15. */
int32_t fl_stuck_share(int32_t friction, int32_t limit, int32_t rising, int32_t fastest, int32_t valid);

/* sensor_step: spring, rate and reading of x a period on, for a force from `friction` to `next`. */
void fl_sensor_step(int32_t *x, int32_t friction, int32_t next, const fl_gain *sensor);

typedef struct {
    int32_t k[5];  /* on the limit's logarithm (q20) and the friction while it slides, and the sensor (q24) */
    int32_t share; /* q28 */
    int32_t limit; /* q26 */
    const fl_gain *sensor;
} fl_sensitivity;

/* sensitivity_step: s is ln L, friction, spring, rate and reading by a parameter; `added` has the friction's
 * places. */
void fl_sensitivity_step(int32_t *s, int32_t keep, const fl_sensitivity *with, int32_t added);

/* The mean square goes on to the square of x, which has half of its places and 2 more; returns it. */
int64_t fl_mean_square(int32_t *high, int32_t *low, int32_t x);

/* learn error s / mean, at most `most`: a step of an estimate. The error is q26 and below 0.03; `places` are
 * those of s less those of the mean square and of the estimate. */
int32_t fl_learnt(fl_gain learn, int32_t error, int32_t s, int64_t mean, int32_t places, int32_t most);

#endif

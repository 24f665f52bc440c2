/* What frictionloop translates from its compiled steps for an image (frictionloop.firmware.image_law): the law of a file,
 * and what stands around every law. One source: numba compiles the same steps for the simulator, with the same bits.
 *
 * States, gains and coefficients are the named tuples of the steps, number by number; the caller owns them. */
#ifndef FL_LAW_H
#define FL_LAW_H

#include "fl_protocol.h"

enum {
    FL_GAINS = sizeof(((fl_parameters *)0)->law_gains) / sizeof(double),
    FL_STATES = sizeof(((fl_parameters *)0)->law_start) / sizeof(double),
    FL_TOUCHES = 7
};

/* As sensing/measurement.py. */
typedef struct {
    double force;    /* N, positive when it opposes the motion */
    double position; /* m */
    double speed;    /* m/s */
    double load;     /* N */
    double valid;    /* 1 while the finger slides on the plate, else 0 */
} fl_measurement;

typedef struct {
    double force;     /* u in N, within the clamp */
    double saturated; /* 1 where the clamp acted */
} fl_force_command;

typedef struct { double low, high; } fl_clamp; /* N */

typedef struct {
    const char *kind; /* as controller.kind */
    uint32_t hash;    /* as law.hash: of the C below */
    uint32_t states, gains;
} fl_law;
extern const fl_law fl_own;

/* A tick of the law. */
fl_force_command fl_own_step(
    double *state, const fl_measurement *measurement, double setpoint, const fl_parameters *p, fl_clamp clamp);

/* Lets an integral begin so that, with no error, the law commands `force`: for closing without a bump. */
void fl_own_begin(double *state, double force, double setpoint, const fl_parameters *p, fl_clamp clamp);

/* The lookup alone, open loop. */
fl_force_command fl_open_step(double setpoint, fl_clamp clamp);

/* The clamp so many ticks after the loop closed, below 0 while it is open (control/law.py). */
fl_clamp fl_switched_clamp(double setpoint, fl_clamp clamp, int32_t since);

/* Ticks over which the clamp opens. */
extern const int32_t fl_closing;

/* The touch of a finger that lies where it was first seen, and a tick of it (sensing/finger_tracking.py). */
void fl_touch_begin(double *touch, double position, const fl_parameters *p);
fl_measurement fl_touch_step(double *touch, double position, double load, double force, const fl_parameters *p);

/* Amplitude in um at a force, by the controller's model. */
double fl_look_up(double force, const fl_parameters *p);

/* Amplitude command in um; `believed` is the plate's amplitude as believed, and goes on by one period. */
double fl_overdrive(double *believed, double wanted, double largest, const fl_parameters *p);

/* What is no number becomes the lower end. */
static inline double fl_clip(double x, double low, double high) { return x > low ? (x < high ? x : high) : low; }
static inline double fl_size(double x) { return x < 0 ? -x : x; }
static inline int32_t fl_clip_whole(int32_t x, int32_t low, int32_t high) { return x < low ? low : x > high ? high : x; }

/* Infinity and NaN are not. */
static inline int fl_is_number(double x) { return x - x == 0; }

#endif

/* A control law in fixed point: the same equations as the float64 step of the same name in control/.
 *
 * A law is a pure step over caller-owned state. Its gains are numbers that firmware/compiled.py makes of the float gains
 * and the period (products that are constant are one number); each state has a format, its binary places. */
#ifndef FL_LAW_H
#define FL_LAW_H

#include "fl_fixed.h"

enum { FL_STATES = 21 };

typedef struct {
    int32_t force;     /* N, positive when it opposes the motion */
    int32_t position;  /* m */
    int32_t speed;     /* m/s */
    int32_t load;      /* N */
    int32_t valid;     /* 1 while the finger slides on the plate, else 0 */
} fl_measurement;

typedef struct {
    int32_t force;      /* u in N, within the clamp */
    int32_t saturated;  /* 1 where the clamp acted */
} fl_force_command;

typedef struct { int32_t low, high; } fl_clamp;  /* N */

typedef fl_force_command fl_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp);

typedef struct {
    const char *kind;    /* as controller.kind */
    fl_step *step;
    uint8_t states, gains;
    const int8_t *places; /* binary places of each state; 0: 28 for all */
} fl_law;

/* By number, as in control/laws.LAWS; 0 is none. */
extern const fl_law fl_laws[];
extern const uint32_t fl_law_count;

#endif

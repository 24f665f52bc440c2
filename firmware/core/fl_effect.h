/* An effect in fixed point: a force over place, time and touch, as rendering/player.py has it.
 *
 * It is a program for a stack of forces, in q28 of a newton: tables of place and time, and what mixes them. A place is
 * an int32_t in 2^-32 m, so a path reaches from -0.5 to 0.5 m. Program and tables lie in one store, which a host writes as
 * it writes a set-point table; docs/protocol.md lists the fields of a step. */
#ifndef FL_EFFECT_H
#define FL_EFFECT_H

#include "fl_law.h"
#include "fl_protocol.h"

enum {
    FL_POINTS = 1024,
    FL_STACK = 8,
    FL_TRIGGERS = 4,
    FL_FAR = (1 << 30) - 1 /* ticks since what has never been, 60 hours; time stops there */
};

typedef struct {
    uint8_t what;        /* FL_STEP_... */
    uint8_t nearest;     /* of a table; of a wave: since its trigger turned on */
    uint8_t repeats;     /* of a table and of a wave */
    uint8_t number;      /* of a trigger; of a wave: of its trigger, FL_TRIGGERS since the start */
    uint16_t first;      /* value in the store; of a trigger: its quantity, FL_CONDITION_... */
    uint16_t count;      /* values */
    int32_t start;       /* place of the first value; of a trigger: what turns it on */
    int32_t per;         /* values in 2^-16 per 2^-32 m, or per tick; of a trigger: what turns it off */
    int32_t scale;       /* N of 2^15 of a value, q28; or a factor; of a trigger: its dead time, ticks */
    int8_t per_shift, scale_shift;
    uint16_t none;
} fl_effect_step;

typedef union {
    int16_t points[FL_POINTS];
    struct {
        uint16_t count;
        uint16_t predicted; /* 1: asked at the place where the finger will be, 0: where it was measured */
        fl_effect_step steps[FL_EFFECT_STEPS];
    } program;
} fl_store;
_Static_assert(sizeof(fl_store) == 2 * FL_POINTS && sizeof(fl_effect_step) == 24, "points, and nothing between");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "a store is read as it is sent");

/* What an effect keeps from tick to tick. */
typedef struct {
    int32_t held;
    int32_t ticks;               /* since it began */
    int32_t since[FL_TRIGGERS];  /* ticks since each trigger changed */
    uint8_t on[FL_TRIGGERS];
    uint8_t back, runs;
} fl_effect;

/* Index of the first word that is wrong in a program of `count` words, else -1. */
int32_t fl_effect_wrong(const fl_store *store, uint16_t count);

/* The force of a tick, of the first where `runs` is 0; below `touch` of load it is held. */
int32_t fl_effect_force(
    fl_effect *effect, const fl_store *store, int32_t along, const fl_measurement *m, int32_t touch, fl_clamp clamp);

#endif

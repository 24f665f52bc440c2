/* An effect: a force over place, time and touch, as rendering/effect_program.py has it, in N and mm.
 *
 * It is a program for a stack of forces: tables of place and time, and what mixes them. Program and tables lie in one
 * store, which a host writes as it writes a set-point table; docs/protocol.md lists the fields of a step. */
#ifndef FL_EFFECT_H
#define FL_EFFECT_H

#include "fl_law.h"

enum {
    FL_POINTS = 1024,
    FL_STACK = 8,
    FL_TRIGGERS = 4,
    FL_FAR = (1 << 30) - 1 /* ticks since what has never been; time stops there */
};

typedef struct {
    uint8_t what;        /* FL_STEP_... */
    uint8_t nearest;     /* of a table; of a wave: since its trigger turned on */
    uint8_t repeats;     /* of a table and of a wave */
    uint8_t number;      /* of a trigger; of a wave: of its trigger, FL_TRIGGERS since the start */
    uint16_t first;      /* value in the store; of a trigger: its quantity, FL_CONDITION_... */
    uint16_t count;      /* values */
    double start;        /* place of the first value; of a trigger: what turns it on */
    double per;          /* values per mm, or per tick; of a trigger: what turns it off */
    double scale;        /* N of 2^15 of a value; or a factor; of a trigger: its dead time, ticks */
} fl_effect_step;

typedef union {
    int16_t points[FL_POINTS];
    struct {
        uint16_t count;
        uint16_t predicted; /* 1: asked at the place where the finger will be, 0: where it was measured */
        uint16_t none[2];
        fl_effect_step steps[FL_EFFECT_STEPS];
    } program;
} fl_store;
_Static_assert(sizeof(fl_store) == 2 * FL_POINTS && sizeof(fl_effect_step) == 32, "points, and nothing between");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "a store is read as it is sent");

/* What an effect keeps from tick to tick. */
typedef struct {
    double held;
    int32_t ticks;               /* since it began */
    int32_t since[FL_TRIGGERS];  /* ticks since each trigger changed */
    uint8_t on[FL_TRIGGERS];
    uint8_t back, runs;
} fl_effect;

/* Index of the first word that is wrong in a program of `count` words, else -1. */
int32_t fl_effect_wrong(const fl_store *store, uint16_t count);

/* The force of a tick, of the first where `runs` is 0; below `touch` of load it is held. `along` is in mm. */
double fl_effect_force(
    fl_effect *effect, const fl_store *store, double along, const fl_measurement *m, double touch, fl_clamp clamp);

/* What is left of a number without whole multiples of a count: 0 to the count. */
double fl_turned(double x, double count);

#endif

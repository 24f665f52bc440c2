/* The parameters that are in force at reset: frictionloop.firmware.image writes built.c from the words of a
 * bench. */
#ifndef FL_BUILT_H
#define FL_BUILT_H

#include "fl_protocol.h"

typedef union {
    double words[FL_WORDS];
    fl_parameters table;
} fl_built;
_Static_assert(sizeof(fl_built) == 8 * FL_WORDS, "the table is its words, without gaps");

extern const fl_built fl_built_parameters;
extern const char fl_built_revision[];

#endif

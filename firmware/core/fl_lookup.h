/* Force command to amplitude command: the inverse of the friction law by the controller's model. */
#ifndef FL_LOOKUP_H
#define FL_LOOKUP_H

#include "fl_fixed.h"

enum { FL_CELLS = 256 };

/* Amplitude in um (q28) at force u in N (q28); `squares` has FL_CELLS + 1 entries of a^2 in um^2 (q25), the first at
 * low_n, and cells_per_n cells for every newton. */
int32_t fl_lookup(int32_t u, const int32_t *squares, fl_gain cells_per_n, int32_t low_n);

#endif

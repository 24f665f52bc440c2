/* Overdrive: the amplitude command overshoots so that the plate gets where it is wanted in one period. */
#ifndef FL_OVERDRIVE_H
#define FL_OVERDRIVE_H

#include "fl_fixed.h"

/* Amplitude command in um; `believed` is the plate's amplitude as believed, and goes on by one period. All in q28;
 * decay of the believed plate in a period, and inverse = 1/(1 - decay). Without overdrive decay is 0, inverse 1. */
int32_t fl_overdrive(int32_t *believed, int32_t wanted, int32_t decay, fl_gain inverse, int32_t largest);

#endif

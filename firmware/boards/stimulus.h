/* A finger that never was: samples made of whole numbers, the same on every board and on the host. */
#ifndef FL_STIMULUS_H
#define FL_STIMULUS_H

#include "fl_app.h"

/* The sample of a tick: strokes there and back, load and force with noise, lifted now and then, a reading
 * at the converter's end now and then. A function of the tick alone. */
fl_sample fl_stimulus(uint32_t tick);

/* Bytes that the host of the scenario sends at this tick, at most 64. */
size_t fl_stimulus_bytes(uint32_t tick, uint8_t *bytes);

enum { FL_SCENARIO_TICKS = 20000 };

/* FNV-1a of 64 bits over what a scenario gives out; begin with FL_DIGEST. */
#define FL_DIGEST 0xCBF29CE484222325u
uint64_t fl_digest(uint64_t digest, const void *bytes, size_t count);

#endif

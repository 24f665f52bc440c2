/* The firmware without its board: what the tick interrupt, the receiver and the background loop call.
 *
 * One producer and one consumer on each side of the tick: fl_app_tick runs in the interrupt, the others in the
 * background, and what they share are rings and flags that one side alone writes. No heap; the caller owns fl_app. */
#ifndef FL_APP_H
#define FL_APP_H

#include <stddef.h>

#include "fl_law.h"
#include "fl_protocol.h"

_Static_assert(1000000 % FL_TICK_HZ == 0, "a tick lasts whole microseconds");

typedef struct {
    int32_t force[2];  /* converter counts, -32768 to 32767; see app_scale.c for what they are of */
    int32_t position;  /* counts of the position sensor; of a 16-bit converter, or of a sensor that counts wider */
    int32_t load;      /* counts, the sum of the cells; likewise */
} fl_sample;

typedef struct {
    int32_t duty;       /* of the carrier in 2^-17: 65536 is 1/2, the largest amplitude */
    double amplitude;   /* um: what the duty stands for */
} fl_drive;

typedef struct {
    uint8_t board;
    uint32_t serial;
    const char *revision;
    uint8_t reset; /* what the last reset came from: FL_RESET_... */
} fl_identity;

typedef struct fl_app fl_app;

/* Size in bytes of fl_app, for callers that cannot see it (the host library). */
size_t fl_app_size(void);

/* Begin: idle, amplitude 0, with these parameters in force; bad ones are FL_FAULT_BAD_PARAMETER. Without any, of
 * an image that is damaged, FL_FAULT_BAD_IMAGE for good. After a reset that should not have been, FL_FAULT_BROWN_OUT or
 * FL_FAULT_WATCHDOG until the host clears it. */
void fl_app_start(fl_app *app, const fl_identity *identity, const fl_parameters *parameters);

/* The tick: FL_TICK_HZ times a second, from the interrupt. now_us counts on modulo 2^32; late is 1 when the tick began late. */
fl_drive fl_app_tick(fl_app *app, const fl_sample *sample, uint32_t now_us, int32_t late);

/* How long the last tick took, in 2^-8 us, where the board can tell. */
void fl_app_took(fl_app *app, uint32_t duration);

/* Bytes that came in; from the background. */
void fl_app_receive(fl_app *app, const uint8_t *bytes, size_t count, uint32_t now_us);

/* Fill `bytes` with what is to be sent, whole frames or parts of them; returns how many. From the background. */
size_t fl_app_transmit(fl_app *app, uint8_t *bytes, size_t room, uint32_t now_us);

#endif

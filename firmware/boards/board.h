/* What main.c asks of a board, and what a board calls.
 *
 * A board gives samples, takes duties, moves bytes and calls fl_tick 5000 times a second from its timer's
 * interrupt. board_read and board_write never wait. */
#ifndef FL_BOARD_H
#define FL_BOARD_H

#include "fl_app.h"

/* Clocks, converters, carrier, port, timer; the first tick comes after it returns. Amplitude is 0
 * throughout. */
void board_start(void);

/* Whether the image is what was built. */
int board_is_whole(void);

/* What the last reset came from: FL_RESET_... */
uint8_t board_reset(void);

/* Begin the ticks. */
void board_run(void);

/* The microseconds since the ticks began, modulo 2^32; goes on inside a tick. From the background. */
uint32_t board_now_us(void);

/* The latest conversions; from the tick. */
fl_sample board_sample(void);

/* Set the duty of the carrier, in 2^-17; from the tick. */
void board_drive(int32_t duty);

/* Bytes received, at most `room`; returns how many. From the background. */
size_t board_read(uint8_t *bytes, size_t room);

/* Send as many of the bytes as the port takes now; returns how many. From the background. */
size_t board_write(const uint8_t *bytes, size_t count);

/* Nothing to do until the next interrupt. */
void board_rest(void);

/* Carrier off, for good: until the watchdog or a reset. */
_Noreturn void board_stop(void);

extern const fl_identity board_identity;

/* How long the tick has taken so far, in 2^-8 us; 0 where the board cannot tell. From the tick. */
uint32_t board_took(void);

/* Called by the board in its timer's interrupt; late is 1 when the tick began late. */
void fl_tick(int32_t late);

/* Ticks since board_run. */
extern volatile uint32_t fl_ticks;

enum { FL_TICK_US = 1000000 / FL_TICK_HZ };

#endif

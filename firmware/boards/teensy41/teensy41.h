/* The parts of this board; board.c puts them together. */
#ifndef FL_TEENSY41_H
#define FL_TEENSY41_H

#include "board.h"

enum { CORE_HZ = 396000000, BUS_HZ = 132000000, TIMER_HZ = 24000000, TICK_COUNTS = TIMER_HZ / FL_TICK_HZ };
_Static_assert(FL_TICK_HZ >= 1000 && FL_TICK_HZ <= 20000, "1 to 20 kHz");
_Static_assert(TICK_COUNTS * FL_TICK_HZ == TIMER_HZ, "a period is whole counts of 24 MHz");

/* watchdog.c */
void watchdog_start(void);
void watchdog_refresh(void);

/* protection.c: regions of the memory, caches */
void protection_start(void);

/* clock.c: the ROM's, refused if they are others */
void clock_start(void);

/* converters.c, or ads8688.c: force, load and position */
void converters_start(void);
fl_sample converters_read(void);

/* carrier.c: 46 kHz of variable duty at pin 22 */
void carrier_start(void);
void carrier_set(int32_t duty);
void carrier_off(void);

/* port.c: LPUART6 at pins 0 and 1, 2 Mbaud 8N1 */
void port_start(void);
void port_interrupt(void);

/* board.c */
void tick_interrupt(void);

#endif

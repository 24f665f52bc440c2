/* The parts of this board; board.c puts them together. */
#ifndef FL_TEENSY31_H
#define FL_TEENSY31_H

#include "board.h"

enum { CORE_HZ = 72000000, BUS_HZ = 36000000, TICK_COUNTS = BUS_HZ / FL_TICK_HZ };

/* watchdog.c: refuse to run for longer than this without a tick */
enum { WATCHDOG_MS = 50 };
void watchdog_start(void);
void watchdog_refresh(void);

/* clock.c: 72 MHz core, 36 MHz bus, 24 MHz flash from the 16 MHz crystal */
void clock_start(void);

/* converters.c: force, load and position, started by the PDB before the tick */
void converters_start(void);
fl_sample converters_read(void);

/* carrier.c: 46 kHz of variable duty at pin 22 */
void carrier_start(void);
void carrier_set(int32_t duty);
void carrier_off(void);

/* port.c: UART0 at pins 0 and 1, 2 Mbaud 8N1 */
void port_start(void);
void port_interrupt(void);

/* board.c */
void tick_interrupt(void);

#endif

/* The watchdog, which resets the processor, and so drops the amplitude, when no tick has come for WATCHDOG_MS; and what a
 * reset came from. */
#include "board.h"
#include "registers.h"
#include "teensy31.h"

enum {
    ENABLED = 1 << 0,
    IN_STOP = 1 << 6,
    IN_WAIT = 1 << 7,
    RESERVED = 1 << 8, /* reads 1 after reset */
    POWER_ON = 1 << 7, PIN = 1 << 6, BY_WATCHDOG = 1 << 5, LOW_VOLTAGE = 1 << 1, /* RCM_SRS0 */
    SOFTWARE = 1 << 2,                                                          /* RCM_SRS1 */
};

/* Within 20 bus cycles of each other and 256 of reset: the first thing the reset handler calls.
 * Runs from the 1 kHz oscillator, which no error in clock.c can stop; may not be changed afterwards. */
void watchdog_start(void) {
    WDOG_UNLOCK = 0xC520;
    WDOG_UNLOCK = 0xD928;
    __asm volatile("nop\n nop"); /* a cycle until the registers are open */
    WDOG_TOVALH = 0;
    WDOG_TOVALL = WATCHDOG_MS;
    WDOG_PRESC = 0;
    WDOG_STCTRLH = RESERVED | IN_WAIT | IN_STOP | ENABLED;
}

/* Both words within 20 bus cycles of each other: nothing may come between them. */
void watchdog_refresh(void) {
    __asm volatile("cpsid i" ::: "memory");
    WDOG_REFRESH = 0xA602;
    WDOG_REFRESH = 0xB480;
    __asm volatile("cpsie i" ::: "memory");
}

/* Power that comes sets POWER_ON and LOW_VOLTAGE both. */
uint8_t board_reset(void) {
    uint8_t why = RCM_SRS0;
    if (why & POWER_ON) return FL_RESET_POWER_ON;
    if (why & LOW_VOLTAGE) return FL_RESET_BROWN_OUT;
    if (why & BY_WATCHDOG) return FL_RESET_WATCHDOG;
    if (RCM_SRS1 & SOFTWARE) return FL_RESET_SOFTWARE;
    return why & PIN ? FL_RESET_PIN : FL_RESET_OTHER;
}

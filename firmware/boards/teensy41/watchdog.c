/* The watchdog, which resets the processor, and so drops the amplitude, when no tick has come for 50 ms; and what a reset
 * came from. */
#include "board.h"
#include "registers.h"
#include "teensy41.h"

enum {
    UNLOCK = 0xD928C520, REFRESH = 0xB480A602,
    TIMEOUT = 1638, /* 50 ms at 32.768 kHz; 13 ms where its oscillator has 128 kHz: both are reported */
    ENABLED = 1 << 7, IN_STOP = 1 << 0, IN_WAIT = 1 << 1, OSCILLATOR = 1 << 8, COMMANDS_32 = 1 << 13,
    UNLOCKED = 1 << 11, TAKEN = 1 << 10,
    POWER_ON = 1 << 0, SOFTWARE = 1 << 1, PIN = 1 << 3, BY_WATCHDOGS = 1 << 4 | 1 << 7, /* SRC_SRSR */
};

/* SRC_SCR: what the watchdog asks for is not masked. */
#define RESETS (10u << 28)
#define MASK (15u << 28)

/* Within 128 bus cycles of unlocking, with interrupts off. Runs from its own oscillator; may not be changed afterwards. */
void watchdog_start(void) {
    CCM_CCGR5 |= 3u << 4; /* WDOG3 */
    SRC_SCR = (SRC_SCR & ~MASK) | RESETS;
    RTWDOG_CNT = UNLOCK;
    while (!(RTWDOG_CS & UNLOCKED)) {}
    RTWDOG_WIN = 0;
    RTWDOG_TOVAL = TIMEOUT;
    RTWDOG_CS = ENABLED | IN_STOP | IN_WAIT | OSCILLATOR | COMMANDS_32;
    while (!(RTWDOG_CS & TAKEN)) {}
}

void watchdog_refresh(void) { RTWDOG_CNT = REFRESH; }

/* Causes add up until they are cleared. The processor that locks up and software that asks are one bit. */
uint8_t board_reset(void) {
    uint32_t why = SRC_SRSR;
    SRC_SRSR = why;
    if (why & POWER_ON) return FL_RESET_POWER_ON;
    if (why & BY_WATCHDOGS) return FL_RESET_WATCHDOG;
    if (why & SOFTWARE) return FL_RESET_SOFTWARE;
    return why & PIN ? FL_RESET_PIN : FL_RESET_OTHER;
}

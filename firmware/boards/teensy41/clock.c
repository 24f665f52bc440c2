/* The ROM's clocks, looked at and kept: 396 MHz core, 132 MHz bus; timer and port from the 24 MHz crystal. No PLL is
 * changed, and no voltage. */
#include "registers.h"
#include "teensy41.h"

enum {
    BUS_BY_3 = 2 << 8, BUS_DIVIDER = 3 << 8,
    TIMER_FROM_CRYSTAL = 1 << 6, TIMER_DIVIDER = 63,
    PORT_FROM_CRYSTAL = 1 << 6, PORT_DIVIDER = 63,
    LOW_POWER = 3, /* 0: clocks go on while the processor waits for an interrupt */
    TRACE_ON = 1 << 24, COUNTER_ON = 1 << 0,
    TIMER_ON = 1 << 0,
    WATCHED = 2400, /* counts of the timer: 100 us */
};

/* Cycles of the core in so many counts of the timer. */
static uint32_t cycles_in(uint32_t counts) {
    PIT_MCR = 0;
    PIT_TCTRL0 = 0;
    PIT_LDVAL0 = 0xFFFFFFFF;
    PIT_TCTRL0 = TIMER_ON;
    uint32_t began = PIT_CVAL0, cycles = DWT_CYCCNT;
    while (began - PIT_CVAL0 < counts) {}
    cycles = DWT_CYCCNT - cycles;
    PIT_TCTRL0 = 0;
    return cycles;
}

void clock_start(void) {
    DEMCR |= TRACE_ON;
    DWT_CYCCNT = 0;
    DWT_CTRL |= COUNTER_ON;
    CCM_CLPCR &= ~(uint32_t)LOW_POWER;
    CCM_CSCMR1 = (CCM_CSCMR1 & ~(uint32_t)TIMER_DIVIDER) | TIMER_FROM_CRYSTAL;
    CCM_CSCDR1 = (CCM_CSCDR1 & ~(uint32_t)PORT_DIVIDER) | PORT_FROM_CRYSTAL;
    CCM_CCGR1 |= 3u << 12; /* PIT */
    const uint32_t cycles = cycles_in(WATCHED), expected = CORE_HZ / (TIMER_HZ / WATCHED);
    if (cycles < expected - expected / 100 || cycles > expected + expected / 100) board_stop();
    CCM_CBCDR = (CCM_CBCDR & ~(uint32_t)BUS_DIVIDER) | BUS_BY_3;
}

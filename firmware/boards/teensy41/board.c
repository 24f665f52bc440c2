/* Teensy 4.1: the board of board.h, and the interrupt of its timer. */
#include "board.h"
#include "built.h"
#include "registers.h"
#include "teensy41.h"

enum {
    LATE_COUNTS = TIMER_HZ / 100000, /* 10 us after its time a tick is late: a twentieth at 5 kHz (assumed) */
    PIT_ON = 1 << 0, PIT_INTERRUPTS = 1 << 1, PIT_EXPIRED = 1,
    TICK_PRIORITY = 0x40,
};

const fl_identity board_identity = {FL_BOARD_TEENSY41, 0, fl_built_revision, FL_RESET_UNKNOWN};
static uint32_t began; /* cycle at which the tick began */

void board_start(void) {
    carrier_off();
    clock_start();
    converters_start();
    port_start();
    carrier_start();
    watchdog_refresh();
}

/* The first period has no tick: what it would read is converted in it. No interrupt may be pending from its end. */
void board_run(void) {
    watchdog_refresh();
    PIT_LDVAL0 = TICK_COUNTS - 1;
    PIT_TFLG0 = PIT_EXPIRED;
    PIT_TCTRL0 = PIT_ON;
    while (!PIT_TFLG0) {}
    PIT_TFLG0 = PIT_EXPIRED;
    NVIC_IPR(PIT_INTERRUPT) = TICK_PRIORITY;
    NVIC_ISER(PIT_INTERRUPT / 32) = 1u << PIT_INTERRUPT % 32;
    PIT_TCTRL0 = PIT_INTERRUPTS | PIT_ON;
}

/* A tick is late when the timer is well past its end, or when the tick before it lasted into this period. */
void tick_interrupt(void) {
    static uint32_t lasted;
    began = DWT_CYCCNT;
    uint32_t after = TICK_COUNTS - 1 - PIT_CVAL0;
    PIT_TFLG0 = PIT_EXPIRED;
    fl_tick(after > LATE_COUNTS || lasted);
    watchdog_refresh();
    lasted = PIT_TFLG0;
}

/* Twice the same tick around the reading of the counter: no tick came between. */
uint32_t board_now_us(void) {
    uint32_t tick, counts;
    do {
        tick = fl_ticks;
        counts = TICK_COUNTS - 1 - PIT_CVAL0;
    } while (tick != fl_ticks);
    return tick * FL_TICK_US + counts / (TIMER_HZ / 1000000);
}

fl_sample board_sample(void) { return converters_read(); }

void board_drive(int32_t duty) { carrier_set(duty); }

/* cycles * 2^8 / 396; a tick of 0.17 s would wrap */
uint32_t board_took(void) { return (DWT_CYCCNT - began) * 64u / 99u; }

void board_rest(void) { __asm volatile("wfi"); }

_Noreturn void board_stop(void) {
    __asm volatile("cpsid i" ::: "memory");
    carrier_off();
    for (;;) {} /* the watchdog ends this, and the host finds a device that began anew */
}

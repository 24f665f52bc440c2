/* MPS2 AN500: the board of board.h under qemu-system-arm. It has no bench: its samples are those of the
 * stimulus. */
#include "built.h"
#include "mps2.h"
#include "stimulus.h"

enum {
    LATE_COUNTS = CLOCK_HZ / 100000, /* 10 us, as on the Teensy */
    TIMER_ON = 1 << 0, TIMER_INTERRUPTS = 1 << 3,
    SEND = 1 << 0, RECEIVE = 1 << 1, RECEIVE_INTERRUPTS = 1 << 3,
    FULL = 1 << 0, WAITING = 1 << 1, RECEIVED = 1 << 1,
    RING = 1024,
};

const fl_identity board_identity = {FL_BOARD_MPS2, 0, fl_built_revision, FL_RESET_UNKNOWN};
static volatile uint8_t ring[RING];
static volatile uint32_t filled, taken;
static uint32_t began;

void board_start(void) {
    UART_BAUDDIV = 16;
    UART_CTRL = SEND | RECEIVE | RECEIVE_INTERRUPTS;
    NVIC_IPR(UART0_INTERRUPT) = 0x00;
    NVIC_IPR(TIMER0_INTERRUPT) = 0x40;
    NVIC_ISER0 = 1u << UART0_INTERRUPT | 1u << TIMER0_INTERRUPT;
}

uint8_t board_reset(void) { return FL_RESET_UNKNOWN; } /* its emulator has no such register */

void board_run(void) {
    TIMER_RELOAD = TICK_COUNTS - 1;
    TIMER_VALUE = TICK_COUNTS - 1;
    TIMER_CTRL = TIMER_ON | TIMER_INTERRUPTS;
}

void tick_interrupt(void) {
    static uint32_t lasted;
    began = TIMER_VALUE;
    TIMER_INTERRUPT = 1;
    fl_tick(TICK_COUNTS - 1 - began > LATE_COUNTS || lasted);
    lasted = TIMER_INTERRUPT;
}

void port_interrupt(void) {
    while (UART_STATE & WAITING) {
        uint8_t byte = (uint8_t)UART_DATA;
        if (filled - taken == RING) continue;
        ring[filled % RING] = byte;
        filled++;
    }
    UART_INTERRUPT = RECEIVED;
}

uint32_t board_now_us(void) {
    uint32_t tick, counts;
    do {
        tick = fl_ticks;
        counts = TICK_COUNTS - 1 - TIMER_VALUE;
    } while (tick != fl_ticks);
    return tick * FL_TICK_US + counts / (CLOCK_HZ / 1000000);
}

size_t board_read(uint8_t *bytes, size_t room) {
    size_t count = 0;
    for (; count < room && taken != filled; count++) {
        bytes[count] = ring[taken % RING];
        taken++;
    }
    return count;
}

size_t board_write(const uint8_t *bytes, size_t count) {
    size_t sent = 0;
    while (sent < count && !(UART_STATE & FULL)) UART_DATA = bytes[sent++];
    return sent;
}

fl_sample board_sample(void) { return fl_stimulus(fl_ticks); }

void board_drive(int32_t duty) { (void)duty; }

/* counts * 2^8 / 25; a tick that lasts into the next reads short, and is counted as late instead */
uint32_t board_took(void) { return (began - TIMER_VALUE) % TICK_COUNTS * 256u / 25u; }

/* No WFI: under -icount QEMU 7.2 then loses every second tick. */
void board_rest(void) {}

_Noreturn void board_stop(void) { semihosting_exit(1); }

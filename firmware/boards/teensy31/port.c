/* UART0, pins 0 (receive) and 1 (send): 72 MHz / 16 / (2 + 8/32) = 2 Mbaud.
 *
 * The receiver's queue holds eight bytes, 40 us, less than a long tick takes: its interrupt goes before the tick's.
 * It comes at four bytes; board_read takes what is left below that. Sending is not in a hurry and is done from the background. */
#include "registers.h"
#include "teensy31.h"

enum {
    RING = 1024, /* bytes, 5 ms */
    QUEUE = 8,
    QUEUES_ON = 1 << 7 | 1 << 3, QUEUES_EMPTY = 1 << 7 | 1 << 6, RECEIVER_EMPTY = 1 << 6,
    RECEIVE_INTERRUPT = 1 << 5, SEND = 1 << 3, RECEIVE = 1 << 2,
    OVERRUN = 1 << 3,
    PIN_UART = 3 << 8, PULL_UP = 3,
};

static uint8_t ring[RING];
static volatile uint32_t filled, taken; /* bytes so far: the first is written here, the second by board_read */

void port_start(void) {
    SIM_SCGC4 |= 1u << 10; /* UART0 */
    SIM_SCGC5 |= 1u << 10; /* port B */
    PORTB_PCR16 = PIN_UART | PULL_UP; /* not connected reads as idle */
    PORTB_PCR17 = PIN_UART;
    UART0_C2 = 0;
    UART0_BDH = 0;
    UART0_BDL = 2;
    UART0_C4 = 8;
    UART0_C1 = 0;
    UART0_PFIFO = QUEUES_ON;
    UART0_CFIFO = QUEUES_EMPTY;
    UART0_RWFIFO = QUEUE / 2;
    UART0_C2 = RECEIVE_INTERRUPT | SEND | RECEIVE;
    NVIC_IPR(UART0_INTERRUPT) = 0x00;
    NVIC_ISER(UART0_INTERRUPT / 32) = 1u << UART0_INTERRUPT % 32;
}

/* The interrupt of the receiver; a full ring loses bytes, which the CRC of the frame notices. */
void port_received(void) {
    uint8_t status = UART0_S1; /* with the read of D below this clears OVERRUN, which stops the receiver */
    for (uint32_t count = UART0_RCFIFO; count > 0; count--) {
        uint8_t byte = UART0_D;
        if (filled - taken == RING) continue;
        ring[filled % RING] = byte;
        filled++;
    }
    if (status & OVERRUN) {
        (void)UART0_D; /* the queue may have been empty: reading it then misaligns it, 47.3.8, and emptying mends that */
        UART0_CFIFO = RECEIVER_EMPTY;
    }
}

size_t board_read(uint8_t *bytes, size_t room) {
    __asm volatile("cpsid i" ::: "memory");
    port_received();
    __asm volatile("cpsie i" ::: "memory");
    size_t count = 0;
    for (; count < room && taken != filled; count++) {
        bytes[count] = ring[taken % RING];
        taken++;
    }
    return count;
}

size_t board_write(const uint8_t *bytes, size_t count) {
    size_t sent = 0;
    while (sent < count && UART0_TCFIFO < QUEUE) UART0_D = bytes[sent++];
    return sent;
}

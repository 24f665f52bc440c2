/* UART0, pins 0 (receive) and 1 (send): 72 MHz / 16 / (2 + 8/32) = 2 Mbaud.
 *
 * The receiver's queue holds eight bytes, 40 us, less than a long tick takes: the interrupt goes before the
 * tick's. It comes when four bytes have come in, or when two are left to send of those in the ring.
 * board_read also takes what is below four. Each ring has one writer and one reader, and is volatile so
 * that a byte is there before the count says so. */
#include "registers.h"
#include "teensy31.h"

enum {
    RING = 1024, /* bytes, 5 ms */
    SENDING = 256,
    QUEUE = 8,
    QUEUES_ON = 1 << 7 | 1 << 3, QUEUES_EMPTY = 1 << 7 | 1 << 6, RECEIVER_EMPTY = 1 << 6,
    SEND_INTERRUPT = 1 << 7, RECEIVE_INTERRUPT = 1 << 5, SEND = 1 << 3, RECEIVE = 1 << 2,
    OVERRUN = 1 << 3,
    PIN_UART = 3 << 8, PULL_UP = 3,
};

static volatile uint8_t received[RING], sending[SENDING];
static volatile uint32_t filled, taken; /* bytes received so far, and of these taken by board_read */
static volatile uint32_t given, sent;   /* bytes given to board_write so far, and of these sent */

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
    UART0_TWFIFO = 2;
    UART0_C2 = RECEIVE_INTERRUPT | SEND | RECEIVE;
    NVIC_IPR(UART0_INTERRUPT) = 0x00;
    NVIC_ISER(UART0_INTERRUPT / 32) = 1u << UART0_INTERRUPT % 32;
}

/* A full ring loses bytes, which the CRC of the frame notices. */
static void receive(void) {
    uint8_t status = UART0_S1; /* with the read of D below this clears OVERRUN, which stops the receiver */
    for (uint32_t count = UART0_RCFIFO; count > 0; count--) {
        uint8_t byte = UART0_D;
        if (filled - taken == RING) continue;
        received[filled % RING] = byte;
        filled++;
    }
    if (status & OVERRUN) {
        (void)UART0_D;
        UART0_CFIFO = RECEIVER_EMPTY; /* reading an empty queue misaligns it: this mends it */
    }
}

static void send(void) {
    for (uint32_t free = QUEUE - UART0_TCFIFO; free > 0 && sent != given; free--) {
        UART0_D = sending[sent % SENDING];
        sent++;
    }
    UART0_C2 = RECEIVE_INTERRUPT | SEND | RECEIVE | (sent != given ? SEND_INTERRUPT : 0);
}

void port_interrupt(void) {
    receive();
    send(); /* also with nothing left to send, to end the interrupt */
}

size_t board_read(uint8_t *bytes, size_t room) {
    __asm volatile("cpsid i" ::: "memory");
    receive();
    __asm volatile("cpsie i" ::: "memory");
    size_t count = 0;
    for (; count < room && taken != filled; count++) {
        bytes[count] = received[taken % RING];
        taken++;
    }
    return count;
}

size_t board_write(const uint8_t *bytes, size_t count) {
    size_t put = 0;
    while (put < count && given - sent < SENDING) {
        sending[given % SENDING] = bytes[put++];
        given++;
    }
    if (put > 0) UART0_C2 = SEND_INTERRUPT | RECEIVE_INTERRUPT | SEND | RECEIVE;
    return put;
}

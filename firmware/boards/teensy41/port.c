/* LPUART6, pins 0 (receive) and 1 (send): 24 MHz / 12 = 2 Mbaud.
 *
 * The receiver's queue holds four bytes, 20 us, less than a long tick takes: the interrupt goes before the tick's. It
 * comes when two bytes have come in, or when one is left to send of those in the ring. board_read also takes what is
 * below two. Each ring has one writer and one reader, and is volatile so that a byte is there before the count says so. */
#include "registers.h"
#include "teensy41.h"

enum {
    RING = 1024, /* bytes, 5 ms */
    SENDING = 256,
    QUEUE = 4,
    BAUD_BY_12 = 11 << 24, BAUD_BY_1 = 1,
    QUEUES_ON = 1 << 7 | 1 << 3, QUEUES_EMPTY = 1 << 15 | 1 << 14,
    SEND_AT_1 = 1, RECEIVE_ABOVE_1 = 1 << 16,
    SEND_INTERRUPT = 1 << 23, RECEIVE_INTERRUPT = 1 << 21, SEND = 1 << 19, RECEIVE = 1 << 18,
    LISTENING = RECEIVE_INTERRUPT | SEND | RECEIVE,
    OVERRUN = 1 << 19,
    PIN_UART = 2, PULL_UP_22K = 1 << 12 | 1 << 13 | 3 << 14, HYSTERESIS = 1 << 16, FROM_PIN_0 = 1,
};

static volatile uint8_t received[RING], sending[SENDING];
static volatile uint32_t filled, taken; /* bytes received so far, and of these taken by board_read */
static volatile uint32_t given, sent;   /* bytes given to board_write so far, and of these sent */

void port_start(void) {
    CCM_CCGR3 |= 3u << 6; /* LPUART6 */
    IOMUXC_PAD_AD_B0_03 = PULL_UP_22K | HYSTERESIS; /* not connected reads as idle */
    IOMUXC_MUX_AD_B0_03 = PIN_UART;
    IOMUXC_LPUART6_RX_SELECT_INPUT = FROM_PIN_0;
    IOMUXC_MUX_AD_B0_02 = PIN_UART;
    LPUART6_CTRL = 0;
    LPUART6_BAUD = BAUD_BY_12 | BAUD_BY_1;
    LPUART6_FIFO = QUEUES_ON | QUEUES_EMPTY;
    LPUART6_WATER = RECEIVE_ABOVE_1 | SEND_AT_1;
    LPUART6_CTRL = LISTENING;
    NVIC_IPR(LPUART6_INTERRUPT) = 0x00;
    NVIC_ISER(LPUART6_INTERRUPT / 32) = 1u << LPUART6_INTERRUPT % 32;
}

/* A full ring loses bytes, which the CRC of the frame notices. */
static void receive(uint32_t count) {
    if (LPUART6_STAT & OVERRUN) LPUART6_STAT = OVERRUN; /* until it is cleared nothing more comes in */
    for (; count > 0; count--) {
        uint8_t byte = (uint8_t)LPUART6_DATA;
        if (filled - taken == RING) continue;
        received[filled % RING] = byte;
        filled++;
    }
}

static void send(uint32_t room) {
    for (; room > 0 && sent != given; room--) {
        LPUART6_DATA = sending[sent % SENDING];
        sent++;
    }
    if (sent == given) LPUART6_CTRL = LISTENING;
}

/* Again while there is room for what is left: a queue that is full ends it. */
void port_interrupt(void) {
    uint32_t room;
    do {
        uint32_t queues = LPUART6_WATER;
        room = QUEUE - (queues >> 8 & 7);
        receive(queues >> 24 & 7);
        send(room);
    } while (room > 0 && sent != given);
    __asm volatile("dsb" ::: "memory");
}

size_t board_read(uint8_t *bytes, size_t room) {
    __asm volatile("cpsid i" ::: "memory");
    receive(LPUART6_WATER >> 24 & 7);
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
    if (put > 0) LPUART6_CTRL = LISTENING | SEND_INTERRUPT;
    return put;
}

/* From reset to main: the vector table, the words that configure the flash, .data and .bss. */
#include "board.h"
#include "registers.h"
#include "teensy31.h"

extern uint32_t stack_top[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern int main(void);

typedef void handler(void);
handler reset;

void reset(void) {
    watchdog_start(); /* within 256 cycles of reset */
    const uint32_t *from = data_load;
    for (uint32_t *to = data_begin; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    main();
}

/* Anything unforeseen: carrier off, and the watchdog resets. */
static void fault(void) { board_stop(); }

/* Stack pointer, 15 exceptions; then the interrupts of the K20
 * (its manual, Interrupt channel assignments). */
typedef union { uint32_t *stack; handler *handler; } vector;
__attribute__((section(".vectors"), used)) const vector vectors[16 + INTERRUPTS] = {
    [0] = {.stack = stack_top},
    [1] = {.handler = reset},
    [2 ... 15] = {.handler = fault},
    [16 ... 15 + UART0_INTERRUPT] = {.handler = fault},
    [16 + UART0_INTERRUPT] = {.handler = port_interrupt},
    [17 + UART0_INTERRUPT ... 15 + PIT0_INTERRUPT] = {.handler = fault},
    [16 + PIT0_INTERRUPT] = {.handler = tick_interrupt},
    [17 + PIT0_INTERRUPT ... 15 + INTERRUPTS] = {.handler = fault},
};

/* Flash configuration field: key 8 x FF, no protection, FSEC 0xDE: unsecured, mass erase enabled; FOPT 0xF9:
 * no NMI pin. Other words can lock the chip for good. */
__attribute__((section(".flashconfig"), used)) const uint32_t flash_configuration[4] = {
    0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFF9DE};

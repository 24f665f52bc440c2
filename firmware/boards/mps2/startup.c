/* From reset to main on the MPS2 AN500, a Cortex-M7. */
#include "mps2.h"

extern uint32_t stack_top[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern int main(void);

typedef void handler(void);
handler reset;

/* Without access to its registers any floating-point instruction is a fault. Interrupts keep them, lazily, as from reset. */
void reset(void) {
    CPACR |= 0xFu << 20; /* coprocessors 10 and 11 */
    __asm volatile("dsb\n isb" ::: "memory");
    const uint32_t *from = data_load;
    for (uint32_t *to = data_begin; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    main();
}

static void fault(void) { board_stop(); }

/* Arm application note AN500, as AN386, table 3-3: UART 0 receives on interrupt 0, timer 0 is 8. */
typedef union { uint32_t *stack; handler *handler; } vector;
__attribute__((section(".vectors"), used)) const vector vectors[16 + INTERRUPTS] = {
    [0] = {.stack = stack_top},
    [1] = {.handler = reset},
    [2 ... 15] = {.handler = fault},
    [16] = {.handler = port_interrupt},
    [17 ... 15 + TIMER0_INTERRUPT] = {.handler = fault},
    [16 + TIMER0_INTERRUPT] = {.handler = tick_interrupt},
    [17 + TIMER0_INTERRUPT ... 15 + INTERRUPTS] = {.handler = fault},
};

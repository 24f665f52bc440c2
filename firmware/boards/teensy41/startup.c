/* From the ROM to main: memory shared out, code and data copied, floating point on; and the vector table. */
#include "board.h"
#include "registers.h"
#include "teensy41.h"

extern volatile uint32_t itcm_load[], itcm_begin[], itcm_end[], data_load[], data_begin[], data_end[];
extern volatile uint32_t bss_begin[], bss_end[];
extern uint32_t stack_top[];
extern int main(void);
enum { COPROCESSORS_10_11 = 0xF << 20 };

typedef void handler(void);
handler reset;

/* Anything unforeseen: carrier off, and the watchdog resets. */
static void fault(void) { board_stop(); }

/* Stack pointer, 15 exceptions; then the interrupts of the RT1062 (its manual, Interrupts). */
typedef union { uint32_t *stack; handler *handler; } vector;
__attribute__((section(".vectors"), used)) const vector vectors[16 + INTERRUPTS] = {
    [0] = {.stack = stack_top},
    [1] = {.handler = reset},
    [2 ... 15] = {.handler = fault},
    [16 ... 15 + LPUART6_INTERRUPT] = {.handler = fault},
    [16 + LPUART6_INTERRUPT] = {.handler = port_interrupt},
    [17 + LPUART6_INTERRUPT ... 15 + PIT_INTERRUPT] = {.handler = fault},
    [16 + PIT_INTERRUPT] = {.handler = tick_interrupt},
    [17 + PIT_INTERRUPT ... 15 + INTERRUPTS] = {.handler = fault},
};

/* Runs from the flash, as reset does, and calls nothing before all is copied. */
__attribute__((section(".startup"), noinline, used)) static void begin(void) {
    volatile uint32_t *from = itcm_load;
    for (volatile uint32_t *to = itcm_begin; to < itcm_end;) *to++ = *from++;
    from = data_load;
    for (volatile uint32_t *to = data_begin; to < data_end;) *to++ = *from++;
    for (volatile uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    SCB_CPACR = COPROCESSORS_10_11;
    __asm volatile("dsb\n isb" ::: "memory");
    SCB_VTOR = (uint32_t)vectors;
    watchdog_start();
    protection_start();
    __asm volatile("cpsie i" ::: "memory");
    main();
}

/* IOMUXC_GPR_GPR17: the banks; GPR16: these instead of the fuses', both memories on; GPR14: 512 KB at most of either. */
__attribute__((section(".startup"), naked, used)) void reset(void) {
    __asm volatile("cpsid i\n"
                   "ldr r0, =0x400AC000\n"
                   "ldr r1, =flexram_banks\n str r1, [r0, #0x44]\n"
                   "ldr r1, =0x00200007\n str r1, [r0, #0x40]\n"
                   "ldr r1, =0x00AA0000\n str r1, [r0, #0x38]\n"
                   "dsb\n isb\n"
                   "ldr r0, =stack_top\n mov sp, r0\n"
                   "b %c0" ::"i"(begin));
}

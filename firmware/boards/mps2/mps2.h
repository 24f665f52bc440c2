/* The registers of the MPS2 AN500 that this board uses: Arm DDI 0479, CMSDK timer and UART. */
#ifndef FL_MPS2_H
#define FL_MPS2_H

#include "board.h"

#define REGISTER32(address) (*(volatile uint32_t *)(address))
#define REGISTER8(address) (*(volatile uint8_t *)(address))

#define TIMER_CTRL REGISTER32(0x40000000)
#define TIMER_VALUE REGISTER32(0x40000004)
#define TIMER_RELOAD REGISTER32(0x40000008)
#define TIMER_INTERRUPT REGISTER32(0x4000000C)
#define UART_DATA REGISTER32(0x40004000)
#define UART_STATE REGISTER32(0x40004004)
#define UART_CTRL REGISTER32(0x40004008)
#define UART_INTERRUPT REGISTER32(0x4000400C)
#define UART_BAUDDIV REGISTER32(0x40004010)
#define CPACR REGISTER32(0xE000ED88)
#define NVIC_ISER0 REGISTER32(0xE000E100)
#define NVIC_IPR(interrupt) REGISTER8(0xE000E400 + (interrupt))

enum { UART0_INTERRUPT = 0, TIMER0_INTERRUPT = 8, INTERRUPTS = 32 };
enum { CLOCK_HZ = 25000000, TICK_COUNTS = CLOCK_HZ / FL_TICK_HZ };

void port_interrupt(void);
void tick_interrupt(void);

/* semihosting.c: one string to the debugger, and the end of the run */
void semihosting_write(const char *text);
_Noreturn void semihosting_exit(int status);

#endif

/* The registers of the MK20DX256VLH7 that this board uses, and no others.
 *
 * Headings name the chapters of the K20 Sub-Family Reference Manual, K20P64M72SF1RM; those of the core are in
 * the ARMv7-M Architecture Reference Manual, DDI 0403. check_registers.py compares them with the vendor's SVD
 * file; not compared with silicon. */
#ifndef FL_REGISTERS_H
#define FL_REGISTERS_H

#include <stdint.h>

#define REGISTER32(address) (*(volatile uint32_t *)(address))
#define REGISTER16(address) (*(volatile uint16_t *)(address))
#define REGISTER8(address) (*(volatile uint8_t *)(address))

/* Clock gates and dividers: System Integration Module */
#define SIM_SCGC3 REGISTER32(0x40048030)
#define SIM_SCGC4 REGISTER32(0x40048034)
#define SIM_SCGC5 REGISTER32(0x40048038)
#define SIM_SCGC6 REGISTER32(0x4004803C)
#define SIM_CLKDIV1 REGISTER32(0x40048044)
#define SIM_UIDL REGISTER32(0x40048060)

/* Multipurpose Clock Generator, Oscillator */
#define MCG_C1 REGISTER8(0x40064000)
#define MCG_C2 REGISTER8(0x40064001)
#define MCG_C5 REGISTER8(0x40064004)
#define MCG_C6 REGISTER8(0x40064005)
#define MCG_S REGISTER8(0x40064006)
#define OSC_CR REGISTER8(0x40065000)

/* Reset Control Module: what the last reset came from */
#define RCM_SRS0 REGISTER8(0x4007F000)
#define RCM_SRS1 REGISTER8(0x4007F001)

/* Watchdog Timer */
#define WDOG_STCTRLH REGISTER16(0x40052000)
#define WDOG_TOVALH REGISTER16(0x40052004)
#define WDOG_TOVALL REGISTER16(0x40052006)
#define WDOG_REFRESH REGISTER16(0x4005200C)
#define WDOG_UNLOCK REGISTER16(0x4005200E)
#define WDOG_PRESC REGISTER16(0x40052016)

/* Analog-to-Digital Converter, of ADC0 or ADC1 */
typedef struct {
    volatile uint32_t SC1A, SC1B, CFG1, CFG2, RA, RB, CV1, CV2, SC2, SC3, OFS, PG, MG;
    volatile uint32_t CLPD, CLPS, CLP4, CLP3, CLP2, CLP1, CLP0;
} converter;
#define ADC0 ((converter *)0x4003B000)
#define ADC1 ((converter *)0x400BB000)

/* Programmable Delay Block: channel 0 starts ADC0, channel 1 ADC1 */
#define PDB_SC REGISTER32(0x40036000)
#define PDB_MOD REGISTER32(0x40036004)
#define PDB_IDLY REGISTER32(0x4003600C)
#define PDB_CH0C1 REGISTER32(0x40036010)
#define PDB_CH0S REGISTER32(0x40036014)
#define PDB_CH0DLY0 REGISTER32(0x40036018)
#define PDB_CH1C1 REGISTER32(0x40036038)
#define PDB_CH1S REGISTER32(0x4003603C)
#define PDB_CH1DLY0 REGISTER32(0x40036040)

/* FlexTimer 0 */
#define FTM0_SC REGISTER32(0x40038000)
#define FTM0_CNT REGISTER32(0x40038004)
#define FTM0_MOD REGISTER32(0x40038008)
#define FTM0_C0SC REGISTER32(0x4003800C)
#define FTM0_C0V REGISTER32(0x40038010)
#define FTM0_CNTIN REGISTER32(0x4003804C)

/* Periodic Interrupt Timer */
#define PIT_MCR REGISTER32(0x40037000)
#define PIT_LDVAL0 REGISTER32(0x40037100)
#define PIT_CVAL0 REGISTER32(0x40037104)
#define PIT_TCTRL0 REGISTER32(0x40037108)
#define PIT_TFLG0 REGISTER32(0x4003710C)

/* UART 0, clocked by the core's clock */
#define UART0_BDH REGISTER8(0x4006A000)
#define UART0_BDL REGISTER8(0x4006A001)
#define UART0_C1 REGISTER8(0x4006A002)
#define UART0_C2 REGISTER8(0x4006A003)
#define UART0_S1 REGISTER8(0x4006A004)
#define UART0_D REGISTER8(0x4006A007)
#define UART0_C4 REGISTER8(0x4006A00A)
#define UART0_PFIFO REGISTER8(0x4006A010)
#define UART0_CFIFO REGISTER8(0x4006A011)
#define UART0_TWFIFO REGISTER8(0x4006A013)
#define UART0_TCFIFO REGISTER8(0x4006A014)
#define UART0_RWFIFO REGISTER8(0x4006A015)
#define UART0_RCFIFO REGISTER8(0x4006A016)

/* Pin control, General-purpose output of port C */
#define PORTB_PCR16 REGISTER32(0x4004A040)
#define PORTB_PCR17 REGISTER32(0x4004A044)
#define PORTC_PCR1 REGISTER32(0x4004B004)
#define GPIOC_PCOR REGISTER32(0x400FF088)
#define GPIOC_PDDR REGISTER32(0x400FF094)

/* Nested vectored interrupt controller: bit or byte per interrupt */
#define NVIC_ISER(word) REGISTER32(0xE000E100 + 4 * (word))
#define NVIC_IPR(interrupt) REGISTER8(0xE000E400 + (interrupt))

/* Trace enable and cycle counter */
#define DEMCR REGISTER32(0xE000EDFC)
#define DWT_CTRL REGISTER32(0xE0001000)
#define DWT_CYCCNT REGISTER32(0xE0001004)

/* Interrupt channel assignments */
enum { UART0_INTERRUPT = 45, PIT0_INTERRUPT = 68, INTERRUPTS = 95 };

#endif

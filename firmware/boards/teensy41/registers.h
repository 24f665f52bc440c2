/* The registers of the MIMXRT1062 that this board uses, and no others.
 *
 * Headings name the chapters of the i.MX RT1060 Processor Reference Manual; those of the core are in the ARMv7-M
 * Architecture Reference Manual, DDI 0403. check_registers.py compares them with the vendor's SVD file; not compared with
 * silicon. */
#ifndef FL_REGISTERS_H
#define FL_REGISTERS_H

#include <stdint.h>

#define REGISTER32(address) (*(volatile uint32_t *)(address))
#define REGISTER16(address) (*(volatile uint16_t *)(address))
#define REGISTER8(address) (*(volatile uint8_t *)(address))

/* Clock Controller Module */
#define CCM_CBCDR REGISTER32(0x400FC014)
#define CCM_CBCMR REGISTER32(0x400FC018)
#define CCM_CSCMR1 REGISTER32(0x400FC01C)
#define CCM_CSCDR1 REGISTER32(0x400FC024)
#define CCM_CLPCR REGISTER32(0x400FC054)
#define CCM_CCGR1 REGISTER32(0x400FC06C)
#define CCM_CCGR2 REGISTER32(0x400FC070)
#define CCM_CCGR3 REGISTER32(0x400FC074)
#define CCM_CCGR4 REGISTER32(0x400FC078)
#define CCM_CCGR5 REGISTER32(0x400FC07C)

/* System Reset Controller: what may reset, and what the last reset came from */
#define SRC_SCR REGISTER32(0x400F8000)
#define SRC_SRSR REGISTER32(0x400F8008)

/* Watchdog Timer 3 */
#define RTWDOG_CS REGISTER32(0x400BC000)
#define RTWDOG_CNT REGISTER32(0x400BC004)
#define RTWDOG_TOVAL REGISTER32(0x400BC008)
#define RTWDOG_WIN REGISTER32(0x400BC00C)

/* Analog-to-Digital Converter, of ADC1 or ADC2 */
typedef struct {
    volatile uint32_t HC0, HC1, HC2, HC3, HC4, HC5, HC6, HC7, HS, R0, R1, R2, R3, R4, R5, R6, R7, CFG, GC, GS;
} converter;
#define ADC1 ((converter *)0x400C4000)
#define ADC2 ((converter *)0x400C8000)

/* ADC External Trigger Control: triggers 0 to 3 start ADC1, 4 to 7 ADC2 */
typedef struct {
    volatile uint32_t CTRL, COUNTER, CHAIN_1_0, CHAIN_3_2, CHAIN_5_4, CHAIN_7_6, RESULT_1_0;
} trigger;
#define ADC_ETC_CTRL REGISTER32(0x403B0000)
#define ADC_ETC_TRIG0 ((trigger *)0x403B0010)
#define ADC_ETC_TRIG4 ((trigger *)0x403B00B0)

/* Inter-Peripheral Crossbar Switch A */
#define XBARA1_SEL51 REGISTER16(0x403BC066)
#define XBARA1_SEL53 REGISTER16(0x403BC06A)

/* Enhanced Flex Pulse Width Modulator 4 */
#define PWM4_SM0INIT REGISTER16(0x403E8002)
#define PWM4_SM0CTRL2 REGISTER16(0x403E8004)
#define PWM4_SM0CTRL REGISTER16(0x403E8006)
#define PWM4_SM0VAL1 REGISTER16(0x403E800E)
#define PWM4_SM0VAL2 REGISTER16(0x403E8012)
#define PWM4_SM0VAL3 REGISTER16(0x403E8016)
#define PWM4_OUTEN REGISTER16(0x403E8180)
#define PWM4_MCTRL REGISTER16(0x403E8188)
#define PWM4_FCTRL0 REGISTER16(0x403E818C)
#define PWM4_FSTS0 REGISTER16(0x403E818E)

/* Periodic Interrupt Timer */
#define PIT_MCR REGISTER32(0x40084000)
#define PIT_LDVAL0 REGISTER32(0x40084100)
#define PIT_CVAL0 REGISTER32(0x40084104)
#define PIT_TCTRL0 REGISTER32(0x40084108)
#define PIT_TFLG0 REGISTER32(0x4008410C)

/* Low Power Universal Asynchronous Receiver/Transmitter 6 */
#define LPUART6_BAUD REGISTER32(0x40198010)
#define LPUART6_STAT REGISTER32(0x40198014)
#define LPUART6_CTRL REGISTER32(0x40198018)
#define LPUART6_DATA REGISTER32(0x4019801C)
#define LPUART6_FIFO REGISTER32(0x40198028)
#define LPUART6_WATER REGISTER32(0x4019802C)

/* Low Power Serial Peripheral Interface 4 */
#define LPSPI4_CR REGISTER32(0x403A0010)
#define LPSPI4_SR REGISTER32(0x403A0014)
#define LPSPI4_CFGR1 REGISTER32(0x403A0024)
#define LPSPI4_CCR REGISTER32(0x403A0040)
#define LPSPI4_TCR REGISTER32(0x403A0060)
#define LPSPI4_TDR REGISTER32(0x403A0064)
#define LPSPI4_RDR REGISTER32(0x403A0074)

/* IOMUX Controller: which function a pin has, and its pad; General Purpose Input/Output 1 */
#define IOMUXC_MUX_AD_B0_02 REGISTER32(0x401F80C4)
#define IOMUXC_MUX_AD_B0_03 REGISTER32(0x401F80C8)
#define IOMUXC_MUX_AD_B1_08 REGISTER32(0x401F811C)
#define IOMUXC_MUX_B0_00 REGISTER32(0x401F813C)
#define IOMUXC_MUX_B0_01 REGISTER32(0x401F8140)
#define IOMUXC_MUX_B0_02 REGISTER32(0x401F8144)
#define IOMUXC_MUX_B0_03 REGISTER32(0x401F8148)
#define IOMUXC_PAD_AD_B0_03 REGISTER32(0x401F82B8)
#define IOMUXC_PAD_AD_B1_00 REGISTER32(0x401F82EC)
#define IOMUXC_PAD_AD_B1_06 REGISTER32(0x401F8304)
#define IOMUXC_PAD_AD_B1_07 REGISTER32(0x401F8308)
#define IOMUXC_PAD_AD_B1_14 REGISTER32(0x401F8324)
#define IOMUXC_LPUART6_RX_SELECT_INPUT REGISTER32(0x401F8550)
#define GPIO1_GDIR REGISTER32(0x401B8004)
#define GPIO1_DR_CLEAR REGISTER32(0x401B8088)

/* Nested vectored interrupt controller: bit or byte per interrupt */
#define NVIC_ISER(word) REGISTER32(0xE000E100 + 4 * (word))
#define NVIC_IPR(interrupt) REGISTER8(0xE000E400 + (interrupt))

/* System control: vectors, faults, caches, coprocessors */
#define SCB_VTOR REGISTER32(0xE000ED08)
#define SCB_CCR REGISTER32(0xE000ED14)
#define SCB_SHCSR REGISTER32(0xE000ED24)
#define SCB_CPACR REGISTER32(0xE000ED88)
#define SCB_ICIALLU REGISTER32(0xE000EF50)

/* Memory protection unit */
#define MPU_CTRL REGISTER32(0xE000ED94)
#define MPU_RBAR REGISTER32(0xE000ED9C)
#define MPU_RASR REGISTER32(0xE000EDA0)

/* Trace enable and cycle counter */
#define DEMCR REGISTER32(0xE000EDFC)
#define DWT_CTRL REGISTER32(0xE0001000)
#define DWT_CYCCNT REGISTER32(0xE0001004)

/* Interrupt channel assignments */
enum { LPUART6_INTERRUPT = 25, PIT_INTERRUPT = 122, INTERRUPTS = 158 };

#endif

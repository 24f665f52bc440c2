/* 72 MHz from the 16 MHz crystal: 16 / 6 * 27. The modes in between are those of its manual: FEI, FBE, PBE,
 * PEE. */
#include "registers.h"
#include "teensy31.h"

enum {
    OSC_18PF = 0x0A, /* SC8P and SC2P, 10 pF to ground on either side: the crystal of the Teensy needs them */
    C1_EXTERNAL = 2 << 6 | 4 << 3,   /* CLKS external, FRDIV 512: 31.25 kHz for the FLL */
    C1_PLL = 4 << 3,                 /* CLKS output of FLL or PLL */
    C2_CRYSTAL = 2 << 4 | 1 << 2,    /* RANGE very high, EREFS */
    C5_BY_6 = 5,                     /* PRDIV: 2.667 MHz, within 2 to 4 MHz */
    C6_TIMES_27 = 1 << 6 | 3,        /* PLLS, VDIV 24 + 3 */
    S_CRYSTAL = 1 << 1,              /* OSCINIT */
    S_INTERNAL = 1 << 4,             /* IREFST */
    S_SOURCE = 3 << 2,               /* CLKST */
    S_SOURCE_EXTERNAL = 2 << 2,
    S_SOURCE_PLL = 3 << 2,
    S_PLL = 1 << 5,                  /* PLLST */
    S_LOCKED = 1 << 6,               /* LOCK */
};
/* OUTDIV1 core by 1, OUTDIV2 bus by 2, OUTDIV4 flash by 3 (SIM_CLKDIV1); flash runs at 25 MHz at most. */
#define DIVIDERS (0u << 28 | 1u << 24 | 2u << 16)

static void until(uint8_t mask, uint8_t value) {
    while ((MCG_S & mask) != value) {} /* a crystal that does not start ends in the watchdog */
}

void clock_start(void) {
    OSC_CR = OSC_18PF;
    MCG_C2 = C2_CRYSTAL;
    MCG_C1 = C1_EXTERNAL;
    until(S_CRYSTAL, S_CRYSTAL);
    until(S_INTERNAL, 0);
    until(S_SOURCE, S_SOURCE_EXTERNAL);
    MCG_C5 = C5_BY_6;
    MCG_C6 = C6_TIMES_27;
    until(S_PLL, S_PLL);
    until(S_LOCKED, S_LOCKED);
    SIM_CLKDIV1 = DIVIDERS; /* before the clock rises */
    MCG_C1 = C1_PLL;
    until(S_SOURCE, S_SOURCE_PLL);
}

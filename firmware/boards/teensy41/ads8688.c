/* Force, load and position in place of converters.c: an ADS8688 on pins 10 (select), 11 (in), 12 (out) and 13 (clock), 16
 * bit. `firmware build --board teensy41-ads8688`.
 *
 * A frame of 32 bits sends a command and brings, in its lower half, what the command before it asked for, sampled as the
 * frame begins. The tick waits for four frames, 8 us; its force was sampled 8 us before it is used.
 *
 * | input | channel |
 * | force along the motion, across | 0, 1 |
 * | load, position | 2, 3: all +-10.24 V, or another range by RANGE |
 */
#include "registers.h"
#include "teensy41.h"

enum {
    CLOCK_BY_8 = 7 << 26, CLOCK_DIVIDER = 7 << 26, FROM_PLL2 = 2 << 4, CLOCK_SOURCE = 3 << 4, /* 528 MHz / 8 */
    SCK_BY_4 = 2, BETWEEN = 2 << 8, BEFORE = 2 << 16, AFTER = 2 << 24, /* 16.5 MHz, at most 17 */
    ENABLE = 1 << 0, RESET = 1 << 1 | 3 << 8, MASTER = 1 << 0, FRAME_32 = 31, LATCH_ON_FALL = 1 << 30,
    RECEIVED = 1 << 1,
    PIN_SPI = 3,
    SAMPLE = 0xC000, CHANNEL = 0x0400, /* the next frame brings this channel */
    WRITE_RANGE = 0x05 << 9 | 1 << 8, REGISTER = 1 << 9, RANGE = 0,
    CHANNELS = 4, HALF = 32768,
};

static uint32_t exchange(uint32_t command) {
    LPSPI4_TDR = command << 16;
    while (!(LPSPI4_SR & RECEIVED)) {} /* a line that hangs ends in the watchdog */
    return LPSPI4_RDR & 0xFFFF;
}

void converters_start(void) {
    CCM_CBCMR = (CCM_CBCMR & ~(uint32_t)(CLOCK_DIVIDER | CLOCK_SOURCE)) | CLOCK_BY_8 | FROM_PLL2;
    CCM_CCGR1 |= 3u << 6; /* LPSPI4 */
    IOMUXC_MUX_B0_00 = IOMUXC_MUX_B0_01 = IOMUXC_MUX_B0_02 = IOMUXC_MUX_B0_03 = PIN_SPI;
    LPSPI4_CR = RESET;
    LPSPI4_CR = 0;
    LPSPI4_CFGR1 = MASTER;
    LPSPI4_CCR = SCK_BY_4 | BETWEEN | BEFORE | AFTER;
    LPSPI4_CR = ENABLE;
    LPSPI4_TCR = LATCH_ON_FALL | FRAME_32;
    for (uint32_t k = 0; k < CHANNELS; k++) exchange(WRITE_RANGE + k * REGISTER | RANGE);
    exchange(SAMPLE);
}

fl_sample converters_read(void) {
    int32_t counts[CHANNELS];
    for (uint32_t k = 0; k < CHANNELS; k++)
        counts[k] = (int32_t)exchange(SAMPLE + (k + 1) % CHANNELS * CHANNEL) - HALF;
    return (fl_sample){.force = {counts[0], counts[1]}, .load = counts[2], .position = counts[3]};
}

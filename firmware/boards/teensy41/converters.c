/* Force, load and position: the converters on the chip, 12 bit, each the mean of eight conversions.
 *
 * No instruction waits for a conversion. The timer that starts the tick also starts the external trigger control
 * (ADC_ETC); its delay later that starts the first input of both converters, and the second follows by itself (back to
 * back). All four are done a few microseconds before the next tick, which reads them: a force is between 38 (begin of its
 * conversion) and 21 us old (its end), a load or position 21 to 5 us.
 *
 * | input | pin | converter |
 * | force along the motion | A2, 16 | ADC1 first: channel 12 |
 * | force across | A3, 17 | ADC2 first: channel 11 |
 * | load | A5, 19 | ADC1 second: channel 5 |
 * | position | A12, 26 | ADC2 second: channel 3 |
 */
#include "registers.h"
#include "teensy41.h"

enum {
    CLOCKS = 8 * (25 + 8) + 6,    /* of the converter for eight conversions, by the manual */
    CONVERTER_KHZ = BUS_HZ / 2 / 4 / 1000,
    CONVERSION_NS = CLOCKS * 1000 * 1000 / CONVERTER_KHZ,
    BEFORE_NS = 38000,
    DELAY_KHZ = BUS_HZ / 4 / 1000,
    DELAY = DELAY_KHZ * 1000 / FL_TICK_HZ - BEFORE_NS / 1000 * DELAY_KHZ / 1000,
    FORCE_ALONG = 12, FORCE_ACROSS = 11, LOAD = 5, POSITION = 3,
    HALF = 32768, /* counts: inputs lie in the middle of 0 to 3.3 V, samples count from there */
    CFG_12_BIT = 2 << 2, CFG_BUS_BY_2_BY_4 = 1 | 2 << 5, CFG_8_CLOCKS = 3 << 8, CFG_FAST = 1 << 10,
    CFG_MEAN_OF_8 = 1 << 14, CFG_HARDWARE = 1 << 13, CFG_OVERWRITE = 1 << 16,
    CFG_MEAN_OF_32 = 3 << 14,
    CFG = CFG_12_BIT | CFG_BUS_BY_2_BY_4 | CFG_8_CLOCKS | CFG_FAST,
    GC_MEAN = 1 << 5, GC_CALIBRATE = 1 << 7, GS_FAILED = 1 << 1,
    HC_BY_ETC = 16,
    ETC_TRIGGERS = 1 << 0 | 1 << 4, ETC_BY_4 = 3 << 16,
    CHAIN_OF_2 = 1 << 8,
    FIRST_BY_HC0 = 1 << 4 | 1 << 12, SECOND_BY_HC1 = 2 << 20 | 1 << 28,
    FROM_PIT0 = 56 << 8,
    PAD_ANALOG = 0, /* no keeper, no pull */
};
_Static_assert(2 * CONVERSION_NS < BEFORE_NS, "both conversions end before the tick");
_Static_assert(DELAY > 0 && DELAY < 65536, "the delay has 16 bits");

static void prepare(converter *adc) {
    adc->CFG = CFG | CFG_MEAN_OF_32;
    adc->GC = GC_MEAN | GC_CALIBRATE;
    while (adc->GC & GC_CALIBRATE) {}
    if (adc->GS & GS_FAILED) board_stop();
    adc->CFG = CFG | CFG_MEAN_OF_8 | CFG_HARDWARE | CFG_OVERWRITE;
    adc->GC = GC_MEAN;
    adc->HC0 = HC_BY_ETC;
    adc->HC1 = HC_BY_ETC;
}

static void chain_up(trigger *trigger, uint32_t first, uint32_t second) {
    trigger->CTRL = CHAIN_OF_2;
    trigger->COUNTER = DELAY;
    trigger->CHAIN_1_0 = first | FIRST_BY_HC0 | second << 16 | SECOND_BY_HC1;
}

void converters_start(void) {
    CCM_CCGR1 |= 3u << 8 | 3u << 16; /* ADC2, ADC1 */
    CCM_CCGR2 |= 3u << 22;           /* XBAR1 */
    IOMUXC_PAD_AD_B1_07 = IOMUXC_PAD_AD_B1_06 = IOMUXC_PAD_AD_B1_00 = IOMUXC_PAD_AD_B1_14 = PAD_ANALOG;
    prepare(ADC1);
    prepare(ADC2);
    ADC_ETC_CTRL = 0; /* out of reset */
    ADC_ETC_CTRL = ETC_BY_4 | ETC_TRIGGERS;
    chain_up(ADC_ETC_TRIG0, FORCE_ALONG, LOAD);
    chain_up(ADC_ETC_TRIG4, FORCE_ACROSS, POSITION);
    XBARA1_SEL51 = FROM_PIT0; /* output 103: trigger 0 */
    XBARA1_SEL53 = FROM_PIT0; /* output 107: trigger 4 */
}

/* Steps of 16 counts; the upper end is that of 16 bits. */
static int32_t counts(uint32_t raw) { return raw == 0xFFF ? HALF - 1 : (int32_t)(raw << 4) - HALF; }

fl_sample converters_read(void) {
    uint32_t adc1 = ADC_ETC_TRIG0->RESULT_1_0, adc2 = ADC_ETC_TRIG4->RESULT_1_0;
    fl_sample sample;
    sample.force[0] = counts(adc1 & 0xFFF);
    sample.force[1] = counts(adc2 & 0xFFF);
    sample.load = counts(adc1 >> 16 & 0xFFF);
    sample.position = counts(adc2 >> 16 & 0xFFF);
    return sample;
}

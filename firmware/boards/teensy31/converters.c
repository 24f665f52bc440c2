/* Force, load and position: 16 bit, each the mean of four conversions.
 *
 * No instruction waits for a conversion. The timer that starts the tick also starts the PDB; START_COUNTS
 * later that starts input A of both converters, and input B follows by itself (back to back). All four are
 * done a few microseconds before the next tick, which reads them: a force is between 27.5 (begin of input
 * A) and 15.7 us old (its end), a load or position 15.7 to 3.9 us.
 *
 * | input | pin | converter |
 * | force along the motion | A2, 16 | ADC0 input A: SE8 |
 * | force across | A3, 17 | ADC1 input A: SE9 |
 * | load | A5, 19 | ADC0 input B: SE12 |
 * | position | A12 | ADC1 input B: DP0 |
 */
#include "registers.h"
#include "teensy31.h"

enum {
    CONVERSION_NS = 11806, /* 5 bus clocks and 5 + 4 * 25 converter clocks at 9 MHz, by the manual */
    START_COUNTS = TICK_COUNTS - 990, /* 27.5 us, two conversions and 3.9 us, before the next tick */
    PASS_COUNTS = TICK_COUNTS - 100,  /* the delay block is done before the next trigger */
    FORCE_ALONG = 8, FORCE_ACROSS = 9, LOAD = 12, POSITION = 0,
    HALF = 32768, /* counts: inputs lie in the middle of 0 to 3.3 V, samples count from there */
    CFG1_16_BIT = 3 << 2, CFG1_BUS_BY_2 = 1,
    CFG1_9_MHZ = CFG1_16_BIT | CFG1_BUS_BY_2 | 1 << 5,          /* at most 12 MHz with 16 bits */
    CFG1_CALIBRATION = CFG1_16_BIT | CFG1_BUS_BY_2 | 3 << 5,    /* 2.25 MHz, at most 4 MHz */
    SC2_HARDWARE = 1 << 6,
    SC3_MEAN_OF_4 = 1 << 2, SC3_MEAN_OF_32 = 1 << 2 | 3, SC3_CALIBRATE = 1 << 7, SC3_FAILED = 1 << 6,
    PDB_LOAD = 1 << 0, PDB_ENABLE = 1 << 7, PDB_TIMER_0 = 4 << 8,
    PDB_BOTH = 3 | 3 << 8 | 2 << 16, /* EN, TOS: both inputs; BB: B after A */
};
_Static_assert(2 * CONVERSION_NS < 990 * 1000 / 36, "both conversions end before the tick");

static void calibrate(converter *adc) {
    adc->CFG1 = CFG1_CALIBRATION;
    adc->SC2 = 0;
    adc->SC3 = SC3_CALIBRATE | SC3_MEAN_OF_32;
    while (adc->SC3 & SC3_CALIBRATE) {}
    if (adc->SC3 & SC3_FAILED) board_stop();
    uint32_t sum = adc->CLP0 + adc->CLP1 + adc->CLP2 + adc->CLP3 + adc->CLP4 + adc->CLPS;
    adc->PG = sum / 2 | 0x8000;
}

static void prepare(converter *adc, uint32_t a, uint32_t b) {
    calibrate(adc);
    adc->CFG1 = CFG1_9_MHZ;
    adc->CFG2 = 0;
    adc->SC2 = SC2_HARDWARE;
    adc->SC3 = SC3_MEAN_OF_4;
    adc->SC1A = a;
    adc->SC1B = b;
}

void converters_start(void) {
    SIM_SCGC3 |= 1u << 27;            /* ADC1 */
    SIM_SCGC6 |= 1u << 27 | 1u << 22; /* ADC0, PDB */
    prepare(ADC0, FORCE_ALONG, LOAD);
    prepare(ADC1, FORCE_ACROSS, POSITION);
    PDB_SC = PDB_ENABLE | PDB_TIMER_0;
    PDB_MOD = PASS_COUNTS; /* one pass a trigger, over when the next comes: no trigger finds it running */
    PDB_IDLY = 0;
    PDB_CH0DLY0 = PDB_CH1DLY0 = START_COUNTS;
    PDB_CH0C1 = PDB_CH1C1 = PDB_BOTH;
    PDB_SC |= PDB_LOAD;
}

fl_sample converters_read(void) {
    PDB_CH0S = PDB_CH1S = 0; /* a sequence that went wrong does not stop those to come */
    fl_sample sample;
    sample.force[0] = (int32_t)ADC0->RA - HALF;
    sample.force[1] = (int32_t)ADC1->RA - HALF;
    sample.load = (int32_t)ADC0->RB - HALF;
    sample.position = (int32_t)ADC1->RB - HALF;
    return sample;
}

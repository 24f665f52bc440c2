/* The carrier: edge-aligned PWM of FTM0 channel 0 at pin 22 (PTC1), 36 MHz / FL_CARRIER_TICKS; 783 is 45 977 Hz.
 *
 * frictionloop.firmware.image gives the number that fits the plate. A new compare value counts from the next period
 * on, at most a period later. */
#include "registers.h"
#include "teensy31.h"

#ifndef FL_CARRIER_TICKS
#define FL_CARRIER_TICKS 783
#endif
_Static_assert(FL_CARRIER_TICKS >= 2 && FL_CARRIER_TICKS < 32767, "the product with a duty of 2^16 is below 2^31");

enum {
    PERIOD = FL_CARRIER_TICKS,
    DUTY_BITS = 17,
    CLOCK_BUS = 1 << 3,
    EDGE_ALIGNED_HIGH = 1 << 5 | 1 << 3, /* MSB and ELSB: set at overflow, cleared at match */
    PIN_GPIO = 1 << 8,
    PIN_CARRIER = 4 << 8,
    PIN = 1 << 1,
};

void carrier_start(void) {
    SIM_SCGC5 |= 1u << 11; /* port C */
    SIM_SCGC6 |= 1u << 24; /* FTM0 */
    FTM0_SC = 0;
    FTM0_CNTIN = 0;
    FTM0_CNT = 0;
    FTM0_MOD = PERIOD - 1;
    FTM0_C0SC = EDGE_ALIGNED_HIGH;
    FTM0_C0V = 0;
    FTM0_SC = CLOCK_BUS;
    PORTC_PCR1 = PIN_CARRIER;
}

/* Nearest compare value, halves down: 65536, one half, is 391 of 783. */
void carrier_set(int32_t duty) {
    const int32_t half = 1 << (DUTY_BITS - 1);
    FTM0_C0V = (uint32_t)(fl_clip(duty, 0, half) * PERIOD + half - 1) >> DUTY_BITS;
}

/* The pin low whatever the timer does: also from a fault, before anything was started. */
void carrier_off(void) {
    SIM_SCGC5 |= 1u << 11; /* port C */
    GPIOC_PCOR = PIN;
    GPIOC_PDDR |= PIN;
    PORTC_PCR1 = PIN_GPIO;
}

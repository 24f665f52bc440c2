/* The carrier: edge-aligned PWM of FlexPWM4, submodule 0 output A, at pin 22 (AD_B1_08): 132 MHz / FL_CARRIER_TICKS; 2870 is
 * 45 993 Hz.
 *
 * frictionloop.firmware.image gives the number that fits the plate. A new compare value counts from the next period
 * on, at most a period later. */
#include "registers.h"
#include "teensy41.h"

#ifndef FL_CARRIER_TICKS
#define FL_CARRIER_TICKS 2870
#endif
_Static_assert(FL_CARRIER_TICKS >= 2 && FL_CARRIER_TICKS < 32767, "the product with a duty of 2^16 is below 2^31");

enum {
    PERIOD = FL_CARRIER_TICKS,
    DUTY_BITS = 17,
    INDEPENDENT = 1 << 13, IN_WAIT = 1 << 14,
    RELOAD_EVERY_PERIOD = 1 << 10,
    FAULTS_HIGH = 15 << 12, FAULT_FLAGS = 15, /* fault inputs are low: none of them holds the output */
    CLEAR_LOAD = 1 << 4, LOAD = 1 << 0, RUN = 1 << 8,
    OUTPUT_A = 1 << 8,
    PIN_CARRIER = 1, PIN_GPIO = 5,
    PIN = 1 << 24,
};

void carrier_start(void) {
    CCM_CCGR4 |= 3u << 22; /* PWM4 */
    PWM4_FCTRL0 = FAULTS_HIGH;
    PWM4_FSTS0 = FAULT_FLAGS;
    PWM4_MCTRL = CLEAR_LOAD;
    PWM4_SM0CTRL2 = INDEPENDENT | IN_WAIT;
    PWM4_SM0CTRL = RELOAD_EVERY_PERIOD;
    PWM4_SM0INIT = 0;
    PWM4_SM0VAL1 = PERIOD - 1;
    PWM4_SM0VAL2 = 0; /* high from here to VAL3 */
    PWM4_SM0VAL3 = 0;
    PWM4_OUTEN = OUTPUT_A;
    PWM4_MCTRL = LOAD;
    PWM4_MCTRL = RUN;
    IOMUXC_MUX_AD_B1_08 = PIN_CARRIER;
}

/* Nearest compare value, halves down: 65536, one half, is 1435 of 2870. */
void carrier_set(int32_t duty) {
    const int32_t half = 1 << (DUTY_BITS - 1);
    PWM4_MCTRL = RUN | CLEAR_LOAD;
    PWM4_SM0VAL3 = (uint16_t)((uint32_t)(fl_clip(duty, 0, half) * PERIOD + half - 1) >> DUTY_BITS);
    PWM4_MCTRL = RUN | LOAD;
}

/* The pin low whatever the timer does: also from a fault, before anything was started. */
void carrier_off(void) {
    CCM_CCGR1 |= 3u << 26; /* GPIO1 */
    GPIO1_DR_CLEAR = PIN;
    GPIO1_GDIR |= PIN;
    IOMUXC_MUX_AD_B1_08 = PIN_GPIO;
}

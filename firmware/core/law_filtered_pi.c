/* Mirrors filtered_pi_step of control/filtered_pi.py: PI behind up to six sections, with feed-forward of the set-point.
 *
 * Outputs and memories of a section have binary places of their own, which firmware/quantised_filtered.py chooses so
 * that none overflows; the gains between them hold the shifts. Integral and PI command have others again. Idle
 * sections cost nothing. Without feed-forward the expected reading is not computed. */
#include "fl_expected.h"
#include "laws.h"

enum { COUNT, KP, KI, HOLD, NARROW, WIDEN, FIRST, EXPECTED = FIRST + 5 * 6 }; /* gains */
enum { FREE = 2, MEMORY = 1, READING = 13 };                                   /* sections; states */

/* One section, transposed direct form II (quantities/arithmetic.py). */
static int32_t section(int32_t *memory, const fl_gain *c, int32_t x) {
    int32_t y = fl_fma(c[0], x, memory[0]);
    memory[0] = fl_saturate((int64_t)fl_mul(c[1], x) - fl_mul(c[3], y) + memory[1]);
    memory[1] = fl_subtract(fl_mul(c[2], x), fl_mul(c[4], y));
    return y;
}

fl_force_command fl_filtered_pi_step(
    int32_t *state, const fl_measurement *measurement, int32_t setpoint, const fl_gain *gains, fl_clamp clamp) {
    const int32_t count = fl_clip(gains[COUNT].mantissa, 0, 6), free = count < FREE ? count : FREE;
    const int feed = fl_expects(gains + EXPECTED), held = gains[HOLD].mantissa != 0;
    int32_t e = 0, ahead = feed ? setpoint : 0;
    if (measurement->valid) {
        int32_t reference = feed ? fl_expected(state + READING, gains + EXPECTED) : setpoint;
        e = fl_subtract(reference, measurement->force);
    }
    for (int32_t i = 0; i < free; i++) e = section(state + MEMORY + 2 * i, gains + FIRST + 5 * i, e);
    int32_t y = e; /* what the other sections would make of it */
    for (int32_t i = free; i < count; i++) y = fl_fma(gains[FIRST + 5 * i], y, state[MEMORY + 2 * i]);
    /* The PI has what the set-point leaves of the clamp. */
    int32_t integral = state[0], asked = fl_fma(gains[KP], y, integral);
    int32_t v = measurement->valid ? asked : integral;
    int32_t low = fl_mul(gains[NARROW], fl_subtract(clamp.low, ahead));
    int32_t high = fl_mul(gains[NARROW], fl_subtract(clamp.high, ahead));
    int32_t within = fl_clip(v, low, high);
    if (held) e = fl_fma(gains[HOLD], fl_subtract(within, asked), e);
    for (int32_t i = free; i < count; i++) e = section(state + MEMORY + 2 * i, gains + FIRST + 5 * i, e);
    int pushes = !held && ((v > within && e > 0) || (v < within && e < 0));
    if (measurement->valid && !pushes) state[0] = fl_fma(gains[KI], e, integral);
    if (feed) fl_expect(state + READING, setpoint, clamp, gains + EXPECTED);
    int32_t u = fl_clip(fl_add(ahead, fl_mul(gains[WIDEN], within)), clamp.low, clamp.high);
    return (fl_force_command){u, v != within};
}

/* With feed-forward the set-point is ahead of the integral. */
void fl_filtered_pi_begin(int32_t *state, int32_t force, int32_t setpoint, const fl_gain *gains) {
    state[0] = fl_mul(gains[NARROW], fl_subtract(force, fl_expects(gains + EXPECTED) ? setpoint : 0));
}

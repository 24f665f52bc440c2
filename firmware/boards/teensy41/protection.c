/* What may be read, written and run (memory protection unit), and the cache of instructions; ARMv7-M Architecture Reference
 * Manual, B3.5. Where no region lies nothing may be touched, not even by the processor ahead of its program. */
#include "board.h"
#include "registers.h"
#include "teensy41.h"

enum {
    VALID = 1 << 4, ENABLE = 1 << 0, ON = 1 << 0,
    READ_WRITE = 3 << 24, READ_ONLY = 7 << 24, NEVER_RUN = 1 << 28, CACHED = 1 << 17, DEVICE = 2 << 19, NORMAL = 1 << 19,
    CACHE = 1 << 17, /* of instructions: no data are read from the flash in a tick */
    FAULTS = 1 << 16,
};
#define SIZE(bits) (((uint32_t)(bits) - 1u) << 1 | ENABLE)

/* Later ones count where two overlap. */
static const struct { uint32_t begin, what; } regions[] = {
    {0x00000000, NEVER_RUN | SIZE(32)},                          /* all: nothing */
    {0x00000000, NORMAL | READ_ONLY | SIZE(19)},                 /* instructions */
    {0x00000000, NEVER_RUN | SIZE(5)},                           /* address 0 */
    {0x20000000, NORMAL | READ_WRITE | NEVER_RUN | SIZE(19)},    /* data */
    {0x40000000, DEVICE | READ_WRITE | NEVER_RUN | SIZE(26)},    /* peripherals */
    {0x60000000, CACHED | READ_ONLY | SIZE(23)},                 /* flash */
};

void protection_start(void) {
    MPU_CTRL = 0;
    for (uint32_t k = 0; k < sizeof regions / sizeof *regions; k++) {
        MPU_RBAR = regions[k].begin | VALID | k;
        MPU_RASR = regions[k].what;
    }
    SCB_SHCSR |= FAULTS;
    MPU_CTRL = ON;
    __asm volatile("dsb\n isb" ::: "memory");
    SCB_ICIALLU = 0;
    __asm volatile("dsb\n isb" ::: "memory");
    SCB_CCR |= CACHE;
    __asm volatile("dsb\n isb" ::: "memory");
}

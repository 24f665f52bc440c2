/* Arm semihosting (ARM IHI 0100): a breakpoint that the emulator takes as a call to its host. */
#include "mps2.h"

enum { WRITE0 = 0x04, EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

static uint32_t call(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void semihosting_write(const char *text) { call(WRITE0, text); }

_Noreturn void semihosting_exit(int status) {
    uint32_t block[2] = {APPLICATION_EXIT, (uint32_t)status};
    call(EXIT_EXTENDED, block);
    for (;;) {}
}

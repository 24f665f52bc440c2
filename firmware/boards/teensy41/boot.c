/* What the ROM reads before it starts the image (i.MX RT1060 Reference Manual, System Boot): how to read the flash, where
 * the image begins, how long it is. The bootloader of the board looks for the first word. */
#include <stdint.h>

void reset(void);
extern uint32_t flash_begin[], flash_bytes[];

/* FlexSPI configuration block: a Winbond W25Q64 at 100 MHz, four lines, fast read quad (0xEB). */
enum {
    TAG = 0x42464346, VERSION = 0x56010000,
    SAMPLE_FROM_PAD = 1, HOLD_AND_SETUP = 3 << 8 | 3 << 16,
    SERIAL_NOR = 1, FOUR_PADS = 4 << 8, MHZ_100 = 6 << 16,
    CAPACITY = 8 << 20,
    READ_AND_ADDRESS = 0x0A1804EB, /* command on one line, 24 bits of address on four */
    MODE_AND_WAIT = 0x32041EFF,    /* eight mode bits: no read follows without its command; four cycles */
    DATA = 0x00002604,
};
__attribute__((section(".flexspi"), used)) const uint32_t flexspi[128] = {
    [0] = TAG, [1] = VERSION, [3] = SAMPLE_FROM_PAD << 0 | HOLD_AND_SETUP, [17] = SERIAL_NOR | FOUR_PADS | MHZ_100,
    [20] = CAPACITY, [32] = READ_AND_ADDRESS, [33] = MODE_AND_WAIT, [34] = DATA,
    [112] = 256, [113] = 4096, [114] = 1, [116] = 65536, /* bytes of a page, of a sector; 30 MHz; of a block */
};

__attribute__((section(".boot"), used)) const uint32_t boot_data[3] = {
    (uint32_t)flash_begin, (uint32_t)flash_bytes, 0};

/* Image vector table: tag, length and version; entry; boot data; itself. */
__attribute__((section(".ivt"), used)) const uint32_t image_vectors[8] = {
    0x432000D1, (uint32_t)reset, 0, 0, (uint32_t)boot_data, (uint32_t)image_vectors, 0, 0};

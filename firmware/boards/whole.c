/* Whether the flash is what was built, the built-in table and all. */
#include "board.h"
#include "fl_frame.h"

extern const uint8_t flash_begin[], flash_end[];

/* CRC-32 of all before it, gaps as erased; written into the image when it has been linked. */
__attribute__((section(".crc"), used)) const volatile uint32_t flash_crc = 0;

int board_is_whole(void) { return fl_crc32(0, flash_begin, (size_t)(flash_end - flash_begin)) == flash_crc; }

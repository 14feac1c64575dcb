/// flash: erasing and writing pages in the second bank of the STM32G474's flash.
#ifndef SWAY_STM32G4_FLASH_H
#define SWAY_STM32G4_FLASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Erases a page of 2 KiB, 0 .. 127 of the second bank; 25 ms. False: the flash reports an error,
/// or is not ready in time. The program in the first bank runs on meanwhile.
bool flash_erase(uint32_t page);
/// Writes `size` bytes from `offset` on (a multiple of 8) of a page that is erased there. What is
/// missing to a multiple of 8 is written as 0xFF.
bool flash_write(uint32_t page, uint32_t offset, const uint8_t *bytes, size_t size);

/// Reads `size` bytes from the start of a page. False: not all of them could be read; where power
/// went while a double word was written, its ECC is wrong and reading it raises the NMI.
bool flash_read(uint32_t page, uint8_t *bytes, size_t size);
/// To be called by the NMI. True: it was an ECC error in what flash_read() reads, and that is all:
/// go on. False: it was something else, or an error in the program itself.
bool flash_nmi(void);

#endif

/// sway_checks: what start-up code looks at before the program runs.
#ifndef SWAY_CHECKS_H
#define SWAY_CHECKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// True where every bit of the words from `first` up to `end` can be 0 and 1. What they hold is put
/// back; nothing else may use them meanwhile. About 12 instructions a word.
bool sway_check_memory(volatile uint32_t *first, const volatile uint32_t *end);

/// True where the CRC-32 of `size` bytes at `image` is `crc`, which the build has put behind them
/// (tests/firmware/seal.py).
bool sway_check_image(const void *image, size_t size, uint32_t crc);

#endif

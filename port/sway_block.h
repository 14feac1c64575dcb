/// sway_block: the parameters of one ECU as bytes for flash or EEPROM.
///
/// Layout, all little-endian: "SWAY", version u16, number of words u16, sequence number u32, the
/// words of sway_core_config_t as int32 in their order, CRC-32 (IEEE 802.3) of all before it.
/// The words are numbered from 0; `swaywatch.dbc` uses the same numbers in SwayParameterRequest.
#ifndef SWAY_BLOCK_H
#define SWAY_BLOCK_H

#include <stddef.h>
#include <stdint.h>

#include "sway_core.h"

/// Counts up with every change of sway_core_config_t; a block of another version is refused.
#define SWAY_BLOCK_VERSION 3U

#define SWAY_BLOCK_WORDS (sizeof(sway_core_config_t) / sizeof(int32_t))
#define SWAY_BLOCK_SIZE (12U + 4U * SWAY_BLOCK_WORDS + 4U)

typedef enum {
    SWAY_BLOCK_OK,
    SWAY_BLOCK_EMPTY, ///< no "SWAY" at its start: never written
    SWAY_BLOCK_VERSION_UNKNOWN,
    SWAY_BLOCK_CRC,     ///< damaged
    SWAY_BLOCK_REFUSED, ///< intact, but sway_core_init() refuses the values
} sway_block_result_t;

/// Writes SWAY_BLOCK_SIZE bytes.
void sway_block_write(const sway_core_config_t *config, uint32_t sequence, uint8_t *block);

/// Reads a block of `size` bytes (more than SWAY_BLOCK_SIZE are ignored). `config` and `sequence`
/// are unchanged unless the result is SWAY_BLOCK_OK. The values are not judged here.
sway_block_result_t sway_block_read(const uint8_t *block, size_t size, sway_core_config_t *config,
                                    uint32_t *sequence);

/// The same without the values.
sway_block_result_t sway_block_check(const uint8_t *block, size_t size, uint32_t *sequence);

/// Word `index` of a configuration; SWAY_ERROR_ARGUMENT beyond the last one.
sway_error_t sway_block_get(const sway_core_config_t *config, uint32_t index, int32_t *value);
sway_error_t sway_block_set(sway_core_config_t *config, uint32_t index, int32_t value);

/// The number of the first word that an ECU refuses: all that sway_core_init() does, and thresholds
/// of the alarm by which it would hardly ever come. SWAY_BLOCK_WORDS: it refuses none.
uint32_t sway_block_offender(const sway_core_config_t *config);

/// The range of word `index`, for tools; 0 may be allowed besides [low, high].
/// SWAY_ERROR_ARGUMENT beyond the last word.
sway_error_t sway_block_range(uint32_t index, int32_t *low, int32_t *high, bool *may_be_zero);

/// CRC-32 (IEEE 802.3) of `size` bytes; 0 to start, the last result to go on.
uint32_t sway_block_crc32(uint32_t crc, const void *bytes, size_t size);

#endif

#include "sway_block.h"

#include <string.h>

/* The configuration is nothing but int32_t; the compiler says so here if that ever changes. */
typedef char sway_block_only_words[sizeof(sway_core_config_t) % sizeof(int32_t) == 0U ? 1 : -1];

static const uint8_t magic[4] = {'S', 'W', 'A', 'Y'};

static void put(uint8_t *bytes, uint32_t value, int count)
{
    for (int i = 0; i < count; i++) {
        bytes[i] = (uint8_t)(value >> (8 * i));
    }
}

static uint32_t get(const uint8_t *bytes, int count)
{
    uint32_t value = 0;
    for (int i = 0; i < count; i++) {
        value |= (uint32_t)bytes[i] << (8 * i);
    }
    return value;
}

uint32_t sway_block_crc32(uint32_t crc, const void *bytes, size_t size)
{
    const uint8_t *at = bytes;
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= at[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ ((crc & 1U) != 0U ? UINT32_C(0xEDB88320) : 0U);
        }
    }
    return ~crc;
}

void sway_block_write(const sway_core_config_t *config, uint32_t sequence, uint8_t *block)
{
    memcpy(block, magic, sizeof magic);
    put(block + 4, SWAY_BLOCK_VERSION, 2);
    put(block + 6, (uint32_t)SWAY_BLOCK_WORDS, 2);
    put(block + 8, sequence, 4);
    for (uint32_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        int32_t value = 0;
        (void)sway_block_get(config, i, &value);
        put(block + 12U + 4U * i, (uint32_t)value, 4);
    }
    put(block + SWAY_BLOCK_SIZE - 4U, sway_block_crc32(0, block, SWAY_BLOCK_SIZE - 4U), 4);
}

sway_block_result_t sway_block_read(const uint8_t *block, size_t size, sway_core_config_t *config,
                                    uint32_t *sequence)
{
    if (block == NULL || size < SWAY_BLOCK_SIZE || memcmp(block, magic, sizeof magic) != 0) {
        return SWAY_BLOCK_EMPTY;
    }
    if (get(block + 4, 2) != SWAY_BLOCK_VERSION || get(block + 6, 2) != SWAY_BLOCK_WORDS) {
        return SWAY_BLOCK_VERSION_UNKNOWN;
    }
    const uint32_t crc = sway_block_crc32(0, block, SWAY_BLOCK_SIZE - 4U);
    if (get(block + SWAY_BLOCK_SIZE - 4U, 4) != crc) {
        return SWAY_BLOCK_CRC;
    }
    *sequence = get(block + 8, 4);
    for (uint32_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        (void)sway_block_set(config, i, (int32_t)get(block + 12U + 4U * i, 4));
    }
    return SWAY_BLOCK_OK;
}

sway_error_t sway_block_get(const sway_core_config_t *config, uint32_t index, int32_t *value)
{
    if (index >= SWAY_BLOCK_WORDS) {
        return SWAY_ERROR_ARGUMENT;
    }
    memcpy(value, (const uint8_t *)config + 4U * (size_t)index, sizeof *value);
    return SWAY_OK;
}

sway_error_t sway_block_set(sway_core_config_t *config, uint32_t index, int32_t value)
{
    if (index >= SWAY_BLOCK_WORDS) {
        return SWAY_ERROR_ARGUMENT;
    }
    memcpy((uint8_t *)config + 4U * (size_t)index, &value, sizeof value);
    return SWAY_OK;
}

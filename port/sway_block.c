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

/* Four bits at a time: a table of 64 bytes for a third of the time of single bits. */
uint32_t sway_block_crc32(uint32_t crc, const void *bytes, size_t size)
{
    static const uint32_t table[16] = {0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU,
                                       0x76DC4190U, 0x6B6B51F4U, 0x4DB26158U, 0x5005713CU,
                                       0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
                                       0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU};
    const uint8_t *at = bytes;
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= at[i];
        crc = (crc >> 4) ^ table[crc & 15U];
        crc = (crc >> 4) ^ table[crc & 15U];
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

sway_block_result_t sway_block_check(const uint8_t *block, size_t size, uint32_t *sequence)
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
    return SWAY_BLOCK_OK;
}

sway_block_result_t sway_block_read(const uint8_t *block, size_t size, sway_core_config_t *config,
                                    uint32_t *sequence)
{
    const sway_block_result_t result = sway_block_check(block, size, sequence);
    for (uint32_t i = 0; result == SWAY_BLOCK_OK && i < SWAY_BLOCK_WORDS; i++) {
        (void)sway_block_set(config, i, (int32_t)get(block + 12U + 4U * i, 4));
    }
    return result;
}

/* Words beyond the vehicle; the limits are those of the headers that the fields belong to, or
 * narrower. */
typedef struct {
    size_t offset;
    size_t end;
    int32_t low;
    int32_t high;
    bool may_be_zero;
} range_t;

#define AT(field) offsetof(sway_core_config_t, field)
static const range_t ranges[] = {
    {AT(sample_period_us), AT(window_cycles_milli), 5000, 20000, false},
    {AT(window_cycles_milli), AT(input_delay_us), 1500, 6000, false},
    {AT(input_delay_us), AT(input_period_us), -500000, 500000, false},
    {AT(input_period_us), AT(alarm), 1000, 100000, true},
    /* Nobody can set thresholds by which the alarm never comes. */
    {AT(alarm.notice_margin_mm_s), AT(alarm.margin_hysteresis_mm_s), 556, 13889, false},
    {AT(alarm.margin_hysteresis_mm_s), AT(alarm.notice_damping_ratio_ppm), 0, 5556, false},
    {AT(alarm.notice_damping_ratio_ppm), AT(alarm.damping_hysteresis_ppm), 10000, 200000, false},
    {AT(alarm.damping_hysteresis_ppm), AT(alarm.minimum_amplitude_urad_s), 0, 100000, false},
    {AT(alarm.minimum_amplitude_urad_s), AT(alarm.large_amplitude_urad_s), 8727, 87266, false},
    {AT(alarm.large_amplitude_urad_s), AT(alarm.limit_amplitude_urad_s), 34907, 209440, false},
    {AT(alarm.limit_amplitude_urad_s), AT(alarm.critical_time_ms), 87266, 523599, false},
    {AT(alarm.critical_time_ms), AT(alarm.hold_ms), 500, 20000, false},
    {AT(alarm.hold_ms), AT(alarm.minimum_speed_mm_s), 200, 20000, false},
    {AT(alarm.minimum_speed_mm_s), AT(alarm.confidence_milli), 2778, 16667, false},
    {AT(alarm.confidence_milli), sizeof(sway_core_config_t), 0, 3000, false},
};

uint32_t sway_block_offender(const sway_core_config_t *config)
{
    const sway_vehicle_range_t *vehicle = NULL;
    if (sway_vehicle_check(&config->vehicle, &vehicle) != SWAY_OK) {
        return (uint32_t)((AT(vehicle) + vehicle->offset) / sizeof(int32_t));
    }
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        for (size_t at = ranges[i].offset; at < ranges[i].end; at += sizeof(int32_t)) {
            int32_t value = 0;
            memcpy(&value, (const uint8_t *)config + at, sizeof value);
            const bool is_zero = value == 0 && ranges[i].may_be_zero;
            if (!is_zero && (value < ranges[i].low || value > ranges[i].high)) {
                return (uint32_t)(at / sizeof(int32_t));
            }
        }
    }
    return SWAY_BLOCK_WORDS;
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

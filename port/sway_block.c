#include "sway_block.h"

#include <string.h>

/* The configuration is nothing but int32_t; the compiler says so here if that ever changes. */
typedef char sway_block_only_words[sizeof(sway_core_config_t) % sizeof(int32_t) == 0U ? 1 : -1];

static const uint8_t magic[4] = {'S', 'W', 'A', 'Y'};

static void put(uint8_t *bytes, uint32_t value, int count)
{
    for (int i = 0; i < count; i++) {
        bytes[i] = (uint8_t)(value >> (8U * (uint32_t)i));
    }
}

static uint32_t get(const uint8_t *bytes, int count)
{
    uint32_t value = 0;
    for (int i = 0; i < count; i++) {
        value |= (uint32_t)bytes[i] << (8U * (uint32_t)i);
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
    (void)memcpy(block, magic, sizeof magic);
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

/* Words beyond the vehicle, one range after the other; the limits are those of the headers that the
 * fields belong to, or narrower. `unit` is that of low and high. */
typedef struct {
    uint8_t words;
    bool may_be_zero;
    int16_t low;
    int16_t high;
    uint16_t unit;
} range_t;

#define AT(field) offsetof(sway_core_config_t, field)
#define FIRST (AT(sample_period_us) / sizeof(int32_t))
static const range_t ranges[] = {
    {1, false, 5, 20, 1000},                    // sample_period_us
    {1, false, 15, 60, 100},                    // window_cycles_milli
    {SWAY_INPUT_COUNT, false, -500, 500, 1000}, // input_delay_us
    {1, true, 1, 100, 1000},                    // input_period_us
    /* Nobody can set thresholds by which the alarm never comes. */
    {1, false, 5, 140, 100},           // notice_margin_mm_s
    {1, false, 0, 56, 100},            // margin_hysteresis_mm_s
    {1, false, 10, 200, 1000},         // notice_damping_ratio_ppm
    {1, false, 0, 100, 1000},          // damping_hysteresis_ppm
    {1, false, 9, 87, 1000},           // minimum_amplitude_urad_s
    {1, false, 35, 210, 1000},         // large_amplitude_urad_s
    {1, false, 87, 524, 1000},         // limit_amplitude_urad_s
    {1, false, 5, 200, 100},           // critical_time_ms
    {1, false, 2, 200, 100},           // hold_ms
    {1, false, 28, 167, 100},          // minimum_speed_mm_s
    {1, false, 0, 30, 100},            // confidence_milli
    {1, true, 0, SWAY_ASSUMED_ALL, 1}, // trailer_assumed
};
typedef char sway_block_ranges_follow_the_fields
    [AT(alarm) / sizeof(int32_t) == FIRST + 2U + SWAY_INPUT_COUNT + 1U &&
             SWAY_BLOCK_WORDS == AT(alarm) / sizeof(int32_t) + sizeof ranges / sizeof ranges[0] - 4U
         ? 1
         : -1];

sway_error_t sway_block_range(uint32_t index, int32_t *low, int32_t *high, bool *may_be_zero)
{
    size_t count = 0;
    const sway_vehicle_range_t *const vehicle = sway_vehicle_ranges(&count);
    for (size_t i = 0; i < count; i++) {
        if ((AT(vehicle) + vehicle[i].offset) / sizeof(int32_t) == index) {
            *low = vehicle[i].low;
            *high = vehicle[i].high;
            *may_be_zero = vehicle[i].may_be_zero;
            return SWAY_OK;
        }
    }
    uint32_t end = (uint32_t)FIRST;
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        end += ranges[i].words;
        if (index < end) {
            *low = ranges[i].low * (int32_t)ranges[i].unit;
            *high = ranges[i].high * (int32_t)ranges[i].unit;
            *may_be_zero = ranges[i].may_be_zero;
            return SWAY_OK;
        }
    }
    return SWAY_ERROR_ARGUMENT;
}

uint32_t sway_block_offender(const sway_core_config_t *config)
{
    const sway_vehicle_range_t *vehicle = NULL;
    if (sway_vehicle_check(&config->vehicle, &vehicle) != SWAY_OK) {
        return (uint32_t)((AT(vehicle) + vehicle->offset) / sizeof(int32_t));
    }
    uint32_t word = (uint32_t)FIRST;
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const range_t *r = &ranges[i];
        for (uint32_t end = word + r->words; word < end; word++) {
            int32_t value = 0;
            (void)sway_block_get(config, word, &value);
            if (!(value == 0 && r->may_be_zero) &&
                (value < r->low * (int32_t)r->unit || value > r->high * (int32_t)r->unit)) {
                return word;
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
    (void)memcpy(value, (const uint8_t *)config + 4U * (size_t)index, sizeof *value);
    return SWAY_OK;
}

sway_error_t sway_block_set(sway_core_config_t *config, uint32_t index, int32_t value)
{
    if (index >= SWAY_BLOCK_WORDS) {
        return SWAY_ERROR_ARGUMENT;
    }
    (void)memcpy((uint8_t *)config + 4U * (size_t)index, &value, sizeof value);
    return SWAY_OK;
}

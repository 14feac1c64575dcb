#include "sway_remember.h"

#if SWAY_REMEMBER

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* Natural logarithms: another trailer below the first (0 of 40 drives with the same one), the same
 * one above the second; the product of variances has to fall by the third to be worth a write. The
 * likeness compares with a trailer that nobody knows; trailers of one car are more alike than that,
 * which makes a similar one too probable. Of 20 swapped ones (seeds 300 to 319) five had 4.4
 * to 6.2, the same one 5.6 to 7.9. */
#define ANOTHER (-1)
#define SAME 6
#define WORTH 2

static const uint8_t magic[4] = {'S', 'W', 'T', 'R'};

static void put(uint8_t *bytes, uint32_t value, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        bytes[i] = (uint8_t)(value >> (8U * i));
    }
}

static uint32_t get(const uint8_t *bytes, uint32_t count)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < count; i++) {
        value |= (uint32_t)bytes[i] << (8U * i);
    }
    return value;
}

/* --- the record ------------------------------------------------------------------------------- */

static sway_real_t *number_of(sway_trailer_memory_t *memory, uint32_t index)
{
    return index < SWAY_TRAILER_MEMORY ? &memory->value[index]
                                       : &memory->covariance[index - SWAY_TRAILER_MEMORY];
}

sway_block_result_t sway_remember_check(const uint8_t *record, size_t size, uint32_t *sequence)
{
    if (record == NULL || size < SWAY_REMEMBER_SIZE || memcmp(record, magic, sizeof magic) != 0) {
        return SWAY_BLOCK_EMPTY;
    }
    if (get(record + 4, 2) != SWAY_REMEMBER_VERSION || get(record + 6, 2) != SWAY_REMEMBER_WORDS) {
        return SWAY_BLOCK_VERSION_UNKNOWN;
    }
    if (get(record + SWAY_REMEMBER_SIZE - 4U, 4) !=
        sway_block_crc32(0, record, SWAY_REMEMBER_SIZE - 4U)) {
        return SWAY_BLOCK_CRC;
    }
    *sequence = get(record + 8, 4);
    return SWAY_BLOCK_OK;
}

static void write_record(const sway_remember_t *remember, sway_trailer_memory_t *memory,
                         uint8_t *record)
{
    (void)memcpy(record, magic, sizeof magic);
    put(record + 4, SWAY_REMEMBER_VERSION, 2);
    put(record + 6, SWAY_REMEMBER_WORDS, 2);
    put(record + 8, remember->sequence + 1U, 4);
    put(record + 12, remember->parameters, 4);
    for (uint32_t i = 0; i < SWAY_REMEMBER_NUMBERS; i++) {
        const sway_real_t number = *number_of(memory, i);
        put(record + 16U + 8U * i, (uint32_t)number.m, 4);
        put(record + 20U + 8U * i, (uint32_t)number.e, 4);
    }
    put(record + SWAY_REMEMBER_SIZE - 4U, sway_block_crc32(0, record, SWAY_REMEMBER_SIZE - 4U), 4);
}

/* --- a drive ---------------------------------------------------------------------------------- */

/* Of what the values are relative to. */
static uint32_t crc_of(const sway_core_config_t *config)
{
    uint32_t crc = sway_block_crc32(0, &config->vehicle, sizeof config->vehicle);
    crc = sway_block_crc32(crc, &config->trailer_assumed, sizeof config->trailer_assumed);
    return sway_block_crc32(crc, &config->sample_period_us, sizeof config->sample_period_us);
}

/* Logarithm of the product of the trailer's variances. */
static sway_real_t volume_of(const sway_trailer_memory_t *memory)
{
    sway_real_t sum = sway_real_zero();
    for (uint32_t i = SWAY_TRAILER_CAR; i < SWAY_TRAILER_MEMORY; i++) {
        sum = ADD(sum, sway_real_ln(memory->covariance[i * (i + 1U) / 2U + i]));
    }
    return sum;
}

void sway_remember_begin(sway_remember_t *remember, const uint8_t *record, size_t size,
                         const sway_core_config_t *config)
{
    uint32_t sequence = 0;
    (void)memset(remember, 0, sizeof *remember);
    remember->parameters = crc_of(config);
    if (sway_remember_check(record, size, &sequence) != SWAY_BLOCK_OK) {
        return;
    }
    remember->sequence = sequence;
    remember->has_memory = get(record + 12, 4) == remember->parameters;
    for (uint32_t i = 0; i < SWAY_REMEMBER_NUMBERS; i++) {
        sway_real_t *const number = number_of(&remember->memory, i);
        number->m = (int32_t)get(record + 16U + 8U * i, 4);
        number->e = (int32_t)get(record + 20U + 8U * i, 4);
    }
    remember->volume = volume_of(&remember->memory);
}

void sway_remember_restart(sway_remember_t *remember, sway_trailer_watch_t *watch,
                           const sway_core_config_t *config)
{
    if (crc_of(config) != remember->parameters) {
        remember->parameters = crc_of(config);
        remember->has_memory = false;
        remember->kept = false;
    }
    remember->asked_ms = 0;
    remember->likeness = sway_real_zero();
    if (remember->has_memory) {
        sway_trailer_recall(watch, &remember->memory);
    }
}

static bool is_there(const sway_trailer_watch_t *watch)
{
    return !watch->sensed && watch->presence == (uint8_t)SWAY_TRAILER_THERE;
}

bool sway_remember_look(sway_remember_t *remember, const sway_trailer_watch_t *watch)
{
    if (!remember->has_memory || !is_there(watch) ||
        watch->learnt_ms - remember->asked_ms < SWAY_REMEMBER_ASK_MS) {
        return false;
    }
    remember->asked_ms = watch->learnt_ms;
    remember->likeness = sway_trailer_likeness(watch, &remember->memory);
    remember->was_another =
        remember->was_another || sway_real_less(remember->likeness, sway_real_int(ANOTHER));
    return true;
}

sway_remember_state_t sway_remember_state(const sway_remember_t *remember,
                                          const sway_trailer_watch_t *watch)
{
    if (!watch->sensed && watch->presence == (uint8_t)SWAY_TRAILER_NONE) {
        return SWAY_REMEMBER_NONE;
    }
    if (!is_there(watch)) {
        return SWAY_REMEMBER_UNKNOWN;
    }
    if (!remember->has_memory) {
        return SWAY_REMEMBER_NEW;
    }
    if (remember->was_another) {
        return SWAY_REMEMBER_ANOTHER;
    }
    return sway_real_less(sway_real_int(SAME), remember->likeness) ? SWAY_REMEMBER_SAME
                                                                   : SWAY_REMEMBER_UNKNOWN;
}

bool sway_remember_wants(const sway_remember_t *remember, const sway_trailer_watch_t *watch,
                         uint8_t *record)
{
    sway_trailer_memory_t now;
    if (!is_there(watch) || watch->learnt_ms < SWAY_REMEMBER_LEARNT_MS) {
        return false;
    }
    sway_trailer_remember(watch, &now);
    const bool replaces = !remember->kept && (!remember->has_memory || remember->was_another);
    const sway_real_t worth = ADD(volume_of(&now), sway_real_int(WORTH));
    if (!replaces && sway_real_compare(worth, remember->volume) > 0) {
        return false;
    }
    write_record(remember, &now, record);
    return true;
}

void sway_remember_kept(sway_remember_t *remember, const sway_trailer_watch_t *watch)
{
    sway_trailer_memory_t now;
    sway_trailer_remember(watch, &now);
    remember->volume = volume_of(&now);
    remember->kept = true;
    remember->writes++;
    remember->sequence++;
}

#else
/* An empty file is no C. */
typedef int sway_remember_is_left_out;
#endif

/* Harnesses for `make proofs-any` (tests/mk/proofs.mk): each function of a list for every input
 * within its stated bounds. Frama-C's Eva computes over all of them at once and reports what it
 * cannot exclude: an access out of bounds, a signed overflow, a shift beyond the width, a division
 * by zero, a read of what was never written. Nothing reported is a proof. The bounds stand beside
 * each harness. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "__fc_builtin.h"

#include "arithmetic/sway_int64.h"
#include "arithmetic/sway_real.h"
#include "bus/sway_e2e.h"
#include "bus/sway_frames.h"
#include "candump.h"
#include "sway_block.h"
#include "sway_siphash.h"
#include "sway_vehicle.h"

static int32_t any_int32(void)
{
    return Frama_C_int_interval(INT32_MIN, INT32_MAX);
}

static uint8_t any_uint8(void)
{
    return (uint8_t)Frama_C_unsigned_char_interval(0, 255);
}

static void any_bytes(uint8_t *bytes, size_t size)
{
    Frama_C_make_unknown((char *)bytes, size);
}

/* Any line of up to 39 characters, ended by a zero: a frame has up to 38, what is longer goes on
 * only in the name of the interface or in digits that are refused. */
/* Any frame whose time is one that candump_parse() gives: 0 to 1e17 us. */
void prove_candump_format(void)
{
    char line[80];
    sway_port_frame_t frame;
    frame.time_us = Frama_C_long_interval(0, 100000000000000000);
    frame.id = (uint16_t)Frama_C_unsigned_short_interval(0, 0x7FF);
    frame.dlc = any_uint8();
    any_bytes(frame.data, sizeof frame.data);
    (void)candump_format(&frame, line);
}

/* Any bytes of any length up to 40 bytes more than a block. */
void prove_block_read(void)
{
    uint8_t block[SWAY_BLOCK_SIZE + 40U];
    sway_core_config_t config;
    uint32_t sequence = 0;
    any_bytes(block, sizeof block);
    memset(&config, 0, sizeof config);
    const size_t size = (size_t)Frama_C_unsigned_int_interval(0, (unsigned)sizeof block);
    (void)sway_block_read(block, size, &config, &sequence);
    (void)sway_block_read(NULL, size, &config, &sequence);
}

/* Any configuration, any number of a word, any value. */
void prove_block_words(void)
{
    sway_core_config_t config;
    int32_t value = 0;
    Frama_C_make_unknown((char *)&config, sizeof config);
    (void)sway_block_set(&config, (uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX),
                         any_int32());
    (void)sway_block_get(&config, (uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX), &value);
}

void prove_block_offender(void)
{
    sway_core_config_t config;
    Frama_C_make_unknown((char *)&config, sizeof config);
    (void)sway_block_offender(&config);
}

void prove_vehicle_check(void)
{
    sway_vehicle_t vehicle;
    const sway_vehicle_range_t *offender = NULL;
    Frama_C_make_unknown((char *)&vehicle, sizeof vehicle);
    (void)sway_vehicle_check(&vehicle, &offender);
    (void)sway_vehicle_is_complete(&vehicle);
}

/* Any frame: any of the messages, any eight bytes. */
void prove_frames_decode(void)
{
    uint8_t data[8];
    sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
    any_bytes(data, sizeof data);
    const sway_message_t message = (sway_message_t)Frama_C_interval(0, SWAY_MESSAGE_COUNT - 1);
    (void)sway_frames_decode(message, data, samples);
    (void)sway_frames_find((uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX));
    (void)sway_frames_input_id(message);
}

/* Any frame, counter and identifier. */
void prove_e2e(void)
{
    uint8_t data[8];
    const uint32_t id = (uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX);
    any_bytes(data, sizeof data);
    (void)sway_e2e_check(id, data);
    sway_e2e_protect(id, any_uint8(), data);
    (void)sway_e2e_crc(id, data);
    (void)sway_e2e_next(any_uint8());
}

/* Any 64 bits through a divisor of any 64 bits. */
void prove_divide(void)
{
    (void)sway_int64_divide(Frama_C_long_interval(INT64_MIN, INT64_MAX),
                            Frama_C_long_interval(INT64_MIN, INT64_MAX));
}

/* A number as the core has it: mantissa 0 or of 31 bits and a sign, exponent within the range. */
static sway_real_t any_real(void)
{
    const int32_t size = Frama_C_int_interval(1 << 30, INT32_MAX);
    sway_real_t a;
    a.m = Frama_C_int_interval(0, 1) ? size : -size;
    a.e = Frama_C_int_interval(0, 1) ? Frama_C_int_interval(0, SWAY_REAL_EXPONENT_MAX)
                                     : Frama_C_int_interval(-SWAY_REAL_EXPONENT_MAX, -1);
    return Frama_C_int_interval(0, 1) ? a : sway_real_zero();
}

void prove_real_compare(void)
{
    (void)sway_real_compare(any_real(), any_real());
}

void prove_real_make(void)
{
    (void)sway_real(Frama_C_long_interval(INT64_MIN, INT64_MAX),
                    Frama_C_int_interval(-1000000, 1000000));
}

/* Any key and any message of up to 64 bytes. */
void prove_siphash(void)
{
    uint8_t key[16];
    uint8_t bytes[64];
    any_bytes(key, sizeof key);
    any_bytes(bytes, sizeof bytes);
    (void)sway_siphash(key, bytes, (size_t)Frama_C_unsigned_int_interval(0, sizeof bytes));
}

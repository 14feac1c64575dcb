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
#include "bus/sway_map.h"
#include "candump.h"
#include "sway_bit_timing.h"
#include "sway_block.h"
#include "sway_siphash.h"
#include "sway_vehicle.h"
#include "sway_xcp_daq.h"

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

/* Any map at all: counts, fields, everything that a file may hold. */
void prove_map_check(void)
{
    sway_map_t map;
    uint32_t where = 0;
    Frama_C_make_unknown((char *)&map, sizeof map);
    (void)sway_map_check(&map, &where);
}

/* Any counter at any time. Of both times only their difference is used, so the last frame is at 0
 * and this one up to 2^61 us before or behind it: the farthest that two times of the core's epochs
 * (2^60 us either way) lie apart. The limit is the one there is (sway_node.c); what was learned of
 * a period is a mean of silences up to it, so it is at most that. */
void prove_e2e_step(void)
{
    const int64_t apart_us = INT64_C(1) << 61;
    /*@ loop unroll SWAY_E2E_LEARN_MAX + 1; */
    for (uint8_t learned = 0; learned <= SWAY_E2E_LEARN_MAX; learned++) {
        sway_e2e_t e2e;
        e2e.time_us = 0;
        e2e.period_us = Frama_C_int_interval(0, SWAY_NODE_COUNT_LIMIT_US);
        e2e.counter = Frama_C_unsigned_char_interval(0, SWAY_E2E_COUNTER_MAX);
        e2e.learned = learned;
        e2e.started = Frama_C_interval(0, 1) != 0;
        (void)sway_e2e_step(&e2e, Frama_C_unsigned_char_interval(0, SWAY_E2E_COUNTER_MAX),
                            Frama_C_long_interval(-apart_us, apart_us), SWAY_NODE_COUNT_LIMIT_US);
        /*@ assert e2e.learned <= SWAY_E2E_LEARN_MAX; */
        /*@ assert e2e.counter <= SWAY_E2E_COUNTER_MAX; */
    }
}

/* Each output of any status, valid or not: any number in any field. */
void prove_frames_encode(void)
{
    sway_status_t status;
    uint8_t state[SWAY_MESSAGE_COUNT];
    uint32_t fault[SWAY_FRAME_FAULT_COUNT];
    uint8_t data[8];
    Frama_C_make_unknown((char *)&status, sizeof status);
    Frama_C_make_unknown((char *)fault, sizeof fault);
    any_bytes(state, sizeof state);
    const sway_frames_source_t source = {&status, state, fault, Frama_C_interval(0, 1) != 0,
                                         Frama_C_interval(0, 1) != 0};
    /*@ loop unroll SWAY_OUTPUT_COUNT; */
    for (uint32_t output = 0; output < (uint32_t)SWAY_OUTPUT_COUNT; output++) {
        sway_frames_encode((sway_output_t)output, &source, data);
        (void)sway_frames_output_id((sway_output_t)output);
    }
}

/* Any clock, rate and sample point, any controller whose fields are at most those of M_CAN, the
 * widest here: 9, 8, 7 and 7 bits. The prescaler that is found fits and is not 0, of which
 * the register would hold one less; tests/port/test_common.c compares the segments with every
 * division there is. */
void prove_bit_timing(void)
{
    sway_bit_limits_t limits;
    sway_bit_timing_t timing = {1U, 1U, 1U, 1U};
    limits.prescaler_max = (uint32_t)Frama_C_unsigned_int_interval(1, 512);
    limits.segment1_max = (uint32_t)Frama_C_unsigned_int_interval(1, 256);
    limits.segment2_max = (uint32_t)Frama_C_unsigned_int_interval(1, 128);
    limits.jump_max = (uint32_t)Frama_C_unsigned_int_interval(1, 128);
    (void)sway_bit_timing((uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX),
                          (uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX),
                          (uint32_t)Frama_C_unsigned_int_interval(0, UINT32_MAX), &limits, &timing);
    /*@ assert 1 <= timing.prescaler <= 512; */
}

/* A number of bytes that WRITE_DAQ takes (sway_xcp.c), each by itself. */
static uint32_t any_size(void)
{
    uint32_t size = (uint32_t)Frama_C_unsigned_int_interval(1, SWAY_XCP_ODT_BYTES);
    /*@ split size; */
    return size;
}

/* A list of one frame with two entries of any size, with or without a time stamp, that is started
 * alone or among those selected; before it starts an entry may be written anew. Its
 * sample stays in the frame. More lists, frames and entries are tested (test_xcp_daq.c), not
 * proven.
 */
void prove_xcp_daq(void)
{
    static const uint8_t memory[SWAY_XCP_ODT_BYTES];
    static sway_xcp_daq_t daq;
    sway_xcp_daq_free(&daq);
    (void)sway_xcp_daq_lists(&daq, 1U);
    (void)sway_xcp_daq_odts(&daq, 0U, 1U);
    (void)sway_xcp_daq_entries(&daq, 0U, 0U, 2U);
    (void)sway_xcp_daq_point(&daq, 0U, 0U, 0U);
    (void)sway_xcp_daq_write(&daq, memory, any_size());
    (void)sway_xcp_daq_write(&daq, memory, any_size());
    const uint32_t mode = Frama_C_interval(0, 1) ? SWAY_XCP_MODE_TIMESTAMP : 0U;
    (void)sway_xcp_daq_mode(&daq, 0U, mode, SWAY_XCP_EVENT_10_MS, 1U);
    const uint32_t start = Frama_C_interval(0, 1) ? 1U : 2U;
    (void)sway_xcp_daq_start(&daq, start, 0U);
    if (Frama_C_interval(0, 1)) {
        (void)sway_xcp_daq_point(&daq, 0U, 0U, 1U);
        (void)sway_xcp_daq_write(&daq, memory, any_size());
    }
    if (start == 2U) {
        (void)sway_xcp_daq_synch(&daq, 1U);
    }
    sway_xcp_daq_sample(&daq, 0U, 0);
    const sway_xcp_packet_t *const packet = sway_xcp_daq_next(&daq);
    if (packet != NULL) {
        /*@ assert packet->size <= 8; */
        sway_xcp_daq_sent(&daq);
    }
}

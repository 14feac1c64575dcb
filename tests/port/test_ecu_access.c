/* Parameters over CAN: what is taken, what is refused, and who may write. */
#include "ecu_bench.h"

/* --- parameters over CAN ---------------------------------------------------------------------- */

static void test_every_word_can_be_written_and_read(void)
{
    start_good();
    (void)open_session();
    for (uint16_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        TEST_ASSERT_EQUAL_UINT8(0, ask(WRITE, i, -1000 - i).parameter_result);
    }
    for (uint16_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        const struct swaywatch_dbc_sway_parameter_reply_t reply = ask(READ, i, 0);
        TEST_ASSERT_EQUAL_UINT8(0, reply.parameter_result);
        TEST_ASSERT_EQUAL_UINT16(i, reply.parameter_reply_index);
        TEST_ASSERT_EQUAL_INT32(-1000 - i, reply.parameter_reply_value);
    }
    const sway_core_config_t config = good_config();
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config); // only staged
    TEST_ASSERT_EQUAL_UINT8(0, ask(DISCARD, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL_INT32(1955000, ask(READ, 0, 0).parameter_reply_value);
}

static void test_wrong_requests_are_answered_and_counted(void)
{
    start_good();
    const uint16_t beyond = (uint16_t)SWAY_BLOCK_WORDS;
    (void)open_session();
    TEST_ASSERT_EQUAL_UINT8(1, ask(READ, beyond, 0).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(1, ask(WRITE, 65535, 0).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(4, ask(9, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL_UINT32(3, ecu.requests_refused);
    sway_port_frame_t frame = request_frame(WRITE, 0, 5);
    frame.data[0] ^= 1U; // CRC
    sent_count = 0U;
    give(frame);
    frame = request_frame(WRITE, 0, 5);
    frame.dlc = 7;
    give(frame);
    TEST_ASSERT_NULL(last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID));
    TEST_ASSERT_EQUAL_UINT32(5, ecu.requests_refused);
    TEST_ASSERT_EQUAL_INT32(1955000, ask(READ, 0, 0).parameter_reply_value);
}

/* The reply names the word, the ECU goes on with the values before. */
static void check_refusal(uint16_t index, int32_t value, uint16_t named)
{
    (void)open_session();
    TEST_ASSERT_EQUAL_UINT8(DONE, ask(DISCARD, 0, 0).parameter_result);
    const struct swaywatch_dbc_sway_parameter_reply_t reply = change(APPLY, index, value);
    TEST_ASSERT_EQUAL_UINT8(REFUSED, reply.parameter_result);
    TEST_ASSERT_EQUAL_UINT16(named, reply.parameter_reply_index);
    int32_t present = 0;
    (void)sway_block_get(&ecu.staged, named, &present);
    TEST_ASSERT_EQUAL_INT32(present, reply.parameter_reply_value);
    const sway_core_config_t config = good_config();
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    TEST_ASSERT_EQUAL_UINT8(REFUSED, change(STORE, NOTHING, 0).parameter_result);
}

static void test_refused_values_name_their_parameter(void)
{
    start_good();
    check_refusal(WORD_OF(vehicle.car.mass_g), 0, WORD_OF(vehicle.car.mass_g));
    check_refusal(WORD_OF(vehicle.trailer.axles), 3, WORD_OF(vehicle.trailer.axles));
    check_refusal(WORD_OF(sample_period_us), 4999, WORD_OF(sample_period_us));
    check_refusal(WORD_OF(window_cycles_milli), 6001, WORD_OF(window_cycles_milli));
    check_refusal(WORD_OF(input_delay_us[7]), 500001, WORD_OF(input_delay_us[7]));
    check_refusal(WORD_OF(input_period_us), 999, WORD_OF(input_period_us));
    check_refusal(WORD_OF(alarm.hold_ms), -1, WORD_OF(alarm.hold_ms));
    for (uint16_t i = WORD_OF(alarm); i < SWAY_BLOCK_WORDS;
         i++) { // the alarm cannot be put to sleep
        check_refusal(i, INT32_MAX, i);
    }
    /* Each in its range, but not together: the wheelbase. */
    check_refusal(WORD_OF(vehicle.trailer.front_axle_to_cog_um), -600000,
                  WORD_OF(vehicle.trailer.rear_axle_to_cog_um));
}

/* Whatever the core refuses has a word to name; beside it, only thresholds of the alarm have. */
static void test_offender_agrees_with_the_core(void)
{
    static sway_core_t core;
    srand(7);
    for (int trial = 0; trial < 20000; trial++) {
        sway_core_config_t config = good_config();
        const uint32_t index = (uint32_t)rand() % SWAY_BLOCK_WORDS;
        const int32_t values[] = {0,       1,         -1,        999,    1000,   1499,
                                  1500,    4999,      5000,      6000,   6001,   20000,
                                  20001,   100000,    100001,    500000, 500001, -500000,
                                  -500001, INT32_MAX, INT32_MIN, rand(), -rand()};
        const int32_t value = values[(size_t)rand() % (sizeof values / sizeof values[0])];
        (void)sway_block_set(&config, index, value);
        const bool refused = sway_core_init(&core, &config) != SWAY_OK;
        const uint32_t offender = sway_block_offender(&config);
        TEST_ASSERT_TRUE(!refused || offender != SWAY_BLOCK_WORDS);
        TEST_ASSERT_TRUE(refused || offender >= WORD_OF(alarm));
    }
}

static void test_new_values_are_applied_and_stored(void)
{
    start_good();
    TEST_ASSERT_EQUAL_INT32((int32_t)(SWAY_BLOCK_VERSION | 1U << 16),
                            ask(VERSION, 0, 0).parameter_reply_value);
    TEST_ASSERT_EQUAL_UINT8(DONE, change(APPLY, 0, 1800000).parameter_result);
    TEST_ASSERT_EQUAL_INT32(1800000, sway_ecu_config(&ecu)->vehicle.car.mass_g);
    start(); // not stored: the old ones again
    TEST_ASSERT_EQUAL_INT32(1955000, sway_ecu_config(&ecu)->vehicle.car.mass_g);
    TEST_ASSERT_EQUAL_UINT8(DONE, change(STORE, 0, 1800000).parameter_result);
    start();
    TEST_ASSERT_EQUAL_INT32(1800000, sway_ecu_config(&ecu)->vehicle.car.mass_g);
    TEST_ASSERT_EQUAL_INT32((int32_t)(SWAY_BLOCK_VERSION | 2U << 16),
                            ask(VERSION, 0, 0).parameter_reply_value);
}

static void test_port_without_memory_says_so(void)
{
    const sway_core_config_t config = good_config();
    sway_port_t bare = port;
    bare.store = NULL;
    bare.alive = NULL;
    put_block(0, &config, 1);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &bare, &retained, page[0], SWAY_BLOCK_SIZE));
    TEST_ASSERT_EQUAL_UINT8(NOT_STORED, change(STORE, NOTHING, 0).parameter_result);
}

static void test_safe_state_ends_only_where_parameters_were_missing(void)
{
    start();
    TEST_ASSERT_EQUAL_UINT8(REFUSED, change(APPLY, NOTHING, 0).parameter_result); // no vehicle
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    (void)open_session();
    TEST_ASSERT_EQUAL_UINT8(DONE, ask(WRITE, 0, 1800000).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(DONE, ask(DISCARD, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
    ecu.staged = good_config();
    TEST_ASSERT_EQUAL_UINT8(DONE, change(APPLY, NOTHING, 0).parameter_result);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    sway_ecu_fail(&ecu, SWAY_ECU_MEMORY);
    TEST_ASSERT_EQUAL_UINT8(REFUSED, finish(APPLY, opened).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(OPEN, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
}

/* --- who may write -----------------------------------------------------------------------------
 */

/* The values that the authors of SipHash publish. */
static void test_siphash_gives_the_published_values(void)
{
    uint8_t key[SWAY_SIPHASH_KEY];
    uint8_t message[15];
    for (uint8_t i = 0; i < sizeof key; i++) {
        key[i] = i;
    }
    for (uint8_t i = 0; i < sizeof message; i++) {
        message[i] = i;
    }
    TEST_ASSERT_EQUAL_HEX64(0x726FDB47DD0E0E31, sway_siphash(key, message, 0));
    TEST_ASSERT_EQUAL_HEX64(0x93F5F5799A932462, sway_siphash(key, message, 8));
    TEST_ASSERT_EQUAL_HEX64(0xA129CA6149BE45E5, sway_siphash(key, message, 15));
}

/* The attack of the review: frames with right CRC and counter, from anybody, at any speed. */
static void test_nobody_writes_without_a_session(void)
{
    start_good();
    const sway_core_config_t config = good_config();
    for (int i = 0; i < 4435; i++) {
        const uint8_t command = (uint8_t)(i % 4 == 0 ? DISCARD : WRITE + i % 3);
        TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(command, WORD_OF(alarm), 0).parameter_result);
    }
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config);
    TEST_ASSERT_EQUAL_MEMORY(&config, &ecu.staged, sizeof config);
    TEST_ASSERT_EQUAL_UINT32(4435, ecu.requests_refused);
    TEST_ASSERT_EQUAL_UINT16(4435, access_said().access_refused);
}

static void test_a_wrong_proof_changes_nothing_and_is_reported(void)
{
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    uint8_t wrong_key[SWAY_SIPHASH_KEY];
    memcpy(wrong_key, test_key, sizeof wrong_key);
    start_good();
    for (unsigned bit = 0; bit < 8U * sizeof wrong_key; bit++) {
        const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
        wrong_key[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
        TEST_ASSERT_EQUAL_UINT8(FORGED,
                                say(proof_frame(APPLY, wrong_key, opened, block)).parameter_result);
        wrong_key[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        TEST_ASSERT_EQUAL_UINT8(LOCKED, finish(APPLY, opened).parameter_result); // one try
    }
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config);
    TEST_ASSERT_EQUAL_UINT16(8U * sizeof wrong_key, access_said().access_forged);
}

/* A proof is for one session, one command, one set of values, one state of the flash. */
static void test_a_proof_fits_nothing_else(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    start_good();
    struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
    sway_port_frame_t frame = proof_frame(APPLY, test_key, opened, block);
    (void)ask(WRITE, WORD_OF(alarm.hold_ms), 20000); // somebody else's, in the session
    TEST_ASSERT_EQUAL_UINT8(FORGED, say(frame).parameter_result);
    opened = open_session();
    (void)ask(DISCARD, 0, 0);
    frame = proof_frame(APPLY, test_key, opened, block);
    struct swaywatch_dbc_sway_parameter_request_t request;
    swaywatch_dbc_sway_parameter_request_unpack(&request, frame.data, 8);
    TEST_ASSERT_EQUAL_UINT8(
        FORGED, ask(STORE, request.parameter_index, request.parameter_value).parameter_result);
    opened = open_session();
    frame = proof_frame(APPLY, test_key, opened, block);
    TEST_ASSERT_EQUAL_UINT8(DONE, say(frame).parameter_result);
    (void)open_session(); // replayed in the next session
    swaywatch_dbc_sway_parameter_request_unpack(&request, frame.data, 8);
    TEST_ASSERT_EQUAL_UINT8(
        FORGED, ask(APPLY, request.parameter_index, request.parameter_value).parameter_result);
    opened = open_session();
    sway_block_write(&ecu.staged, ecu.block_sequence, block); // of the block before
    TEST_ASSERT_EQUAL_UINT8(FORGED,
                            say(proof_frame(STORE, test_key, opened, block)).parameter_result);
}

/* Every bit of a proof counts, a right one is not counted as forged. */
static void test_every_bit_of_a_proof_counts(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    start_good();
    for (unsigned bit = 0; bit < 8U * SWAY_ACCESS_PROOF; bit++) {
        const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
        sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
        sway_port_frame_t frame = proof_frame(APPLY, test_key, opened, block);
        frame.data[2U + bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        sway_e2e_protect(frame.id, (uint8_t)(frame.data[1] & 15U), frame.data);
        TEST_ASSERT_EQUAL_UINT8(FORGED, say(frame).parameter_result);
        TEST_ASSERT_EQUAL_UINT32(bit + 1U, ecu.access.forged);
    }
    TEST_ASSERT_EQUAL_UINT8(DONE, change(APPLY, NOTHING, 0).parameter_result);
    TEST_ASSERT_EQUAL_UINT32(8U * SWAY_ACCESS_PROOF, ecu.access.forged);
}

/* As port/sway_access.h says: a tester may count on it. */
static void test_challenge_is_the_hash_of_the_moment(void)
{
    const uint8_t moment[16] = {0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11,
                                0x0D, 0x0C, 0x0B, 0x0A, 0x78, 0x56, 0x34, 0x12};
    const uint64_t wanted = sway_siphash(test_key, moment, sizeof moment);
    sway_access_t access = {0};
    sway_access_open(&access, test_key, INT64_C(0x1122334455667788), 0x0A0B0C0D, 0x12345678);
    for (unsigned i = 0; i < SWAY_ACCESS_PROOF; i++) {
        TEST_ASSERT_EQUAL_HEX8((uint8_t)(wanted >> 8U * i), access.challenge[i]);
    }
    const int64_t end_us = INT64_C(0x1122334455667788) + SWAY_ACCESS_SESSION_US;
    TEST_ASSERT_TRUE(sway_access_is_open(&access, end_us - 1));
    TEST_ASSERT_FALSE(sway_access_is_open(&access, end_us));
}

static void test_challenges_do_not_come_twice(void)
{
    static uint64_t seen[500];
    start_good();
    for (unsigned i = 0; i < 500U; i++) {
        const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
        seen[i] =
            (uint64_t)(uint32_t)opened.parameter_reply_value << 16 | opened.parameter_reply_index;
        for (unsigned k = 0; k < i; k++) {
            TEST_ASSERT_TRUE(seen[i] != seen[k]);
        }
    }
}

static uint32_t noise(void *context)
{
    (void)context;
    return 77;
}

static void test_the_hardware_s_noise_is_in_the_challenge(void)
{
    sway_port_t noisy = port;
    const sway_core_config_t config = good_config();
    int32_t value[2];
    noisy.random = noise;
    for (int i = 0; i < 2; i++) {
        setUp();
        put_block(0, &config, 1);
        TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, i == 0 ? &port : &noisy, &retained, page[0],
                                                  SWAY_BLOCK_SIZE));
        value[i] = open_session().parameter_reply_value;
    }
    TEST_ASSERT_TRUE(value[0] != value[1]);
}

static void test_parameters_change_at_standstill_only(void)
{
    start_good();
    speed_mm_s = -1; // not known
    TEST_ASSERT_EQUAL_UINT8(MOVING, ask(OPEN, 0, 0).parameter_result);
    speed_mm_s = SWAY_ECU_STANDSTILL_MM_S + 20;
    drive();
    TEST_ASSERT_EQUAL_UINT8(MOVING, ask(OPEN, 0, 0).parameter_result);
    speed_mm_s = SWAY_ECU_STANDSTILL_MM_S - 20;
    drive();
    const struct swaywatch_dbc_sway_parameter_reply_t opened = ask(OPEN, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(DONE, opened.parameter_result);
    speed_mm_s = 25000; // driven off in the session
    drive();
    TEST_ASSERT_EQUAL_UINT8(MOVING, finish(APPLY, opened).parameter_result);
    speed_mm_s = 0;
    drive();
    speed_mm_s = -1; // the speed has gone
    now_us += 200000;
    TEST_ASSERT_EQUAL_UINT8(MOVING, ask(OPEN, 0, 0).parameter_result);
}

static void test_a_session_ends_by_itself(void)
{
    start_good();
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    TEST_ASSERT_EQUAL_UINT8(1, access_said().access_state);
    now_us += SWAY_ACCESS_SESSION_US;
    drive();
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(WRITE, 0, 1800000).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, finish(APPLY, opened).parameter_result);
}

static void test_an_ecu_without_a_key_takes_nothing(void)
{
    sway_port_t bare = port;
    bare.key = NULL;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &bare, &retained, NULL, 0));
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(OPEN, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(WRITE, 0, 1800000).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(2, access_said().access_state);
}

static void test_a_store_that_comes_twice_is_written_once(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    start_good();
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
    const sway_port_frame_t frame = proof_frame(STORE, test_key, opened, block);
    TEST_ASSERT_EQUAL_UINT8(DONE, say(frame).parameter_result);
    sent_count = 0U;
    give(frame);
    TEST_ASSERT_NULL(last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID));
    TEST_ASSERT_EQUAL_UINT32(2, ecu.block_sequence);
    TEST_ASSERT_EQUAL_UINT32(1, ecu.requests_refused);
    TEST_ASSERT_EQUAL_UINT8(1, access_said().access_stores);
}

static void test_stores_are_limited(void)
{
    start_good();
    for (unsigned i = 0; i < SWAY_ACCESS_STORES_MAX; i++) {
        TEST_ASSERT_EQUAL_UINT8(DONE, change(STORE, NOTHING, 0).parameter_result);
    }
    TEST_ASSERT_EQUAL_UINT8(WORN, change(STORE, 0, 1800000).parameter_result);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ACCESS_STORES_MAX, access_said().access_stores);
    TEST_ASSERT_EQUAL_INT32(1800000, sway_ecu_config(&ecu)->vehicle.car.mass_g); // applied
    (void)start();
    TEST_ASSERT_EQUAL_INT32(1955000, sway_ecu_config(&ecu)->vehicle.car.mass_g); // not stored
    const sway_core_config_t config = good_config();
    put_block(0, &config, SWAY_ACCESS_SEQUENCE_MAX);
    memset(page[1], 0xFF, sizeof page[1]);
    (void)start();
    TEST_ASSERT_EQUAL_UINT8(WORN, change(STORE, NOTHING, 0).parameter_result);
}

/* --- the proof ---------------------------------------------------------------------------------
 */

static uint64_t turned(uint64_t a, unsigned left)
{
    return a << left | a >> (64U - left);
}

static void sip_round(uint64_t *v)
{
    v[0] += v[1];
    v[1] = turned(v[1], 13) ^ v[0];
    v[0] = turned(v[0], 32);
    v[2] += v[3];
    v[3] = turned(v[3], 16) ^ v[2];
    v[0] += v[3];
    v[3] = turned(v[3], 21) ^ v[0];
    v[2] += v[1];
    v[1] = turned(v[1], 17) ^ v[2];
    v[2] = turned(v[2], 32);
}

/* SipHash-2-4 as its paper has it, in 64-bit words. */
static uint64_t siphash_of_the_paper(const uint8_t *key, const uint8_t *bytes, size_t size)
{
    uint64_t k[2] = {0, 0};
    for (unsigned i = 0; i < 16U; i++) {
        k[i / 8U] |= (uint64_t)key[i] << (8U * (i % 8U));
    }
    uint64_t v[4] = {k[0] ^ UINT64_C(0x736F6D6570736575), k[1] ^ UINT64_C(0x646F72616E646F6D),
                     k[0] ^ UINT64_C(0x6C7967656E657261), k[1] ^ UINT64_C(0x7465646279746573)};
    for (size_t at = 0; at <= size / 8U * 8U; at += 8U) {
        uint64_t m = at + 8U > size ? (uint64_t)(size & 0xFFU) << 56 : 0U;
        for (size_t i = at; i < at + 8U && i < size; i++) {
            m |= (uint64_t)bytes[i] << (8U * (i - at));
        }
        v[3] ^= m;
        sip_round(v);
        sip_round(v);
        v[0] ^= m;
    }
    v[2] ^= 0xFFU;
    for (int i = 0; i < 4; i++) {
        sip_round(v);
    }
    return v[0] ^ v[1] ^ v[2] ^ v[3];
}

static void test_siphash_is_that_of_the_paper_for_every_length(void)
{
    uint8_t bytes[300];
    uint8_t key[SWAY_SIPHASH_KEY];
    uint32_t seed = 7;
    for (int round = 0; round < 20; round++) {
        for (size_t i = 0; i < sizeof bytes; i++) {
            seed = seed * 1664525U + 1013904223U;
            bytes[i] = (uint8_t)(seed >> 24);
        }
        memcpy(key, bytes + 200, sizeof key);
        for (size_t size = 0; size < sizeof bytes; size++) {
            TEST_ASSERT_EQUAL_HEX64(siphash_of_the_paper(key, bytes, size),
                                    sway_siphash(key, bytes, size));
        }
    }
    for (unsigned i = 0; i < 16U; i++) {
        key[i] = (uint8_t)i;
        bytes[i] = (uint8_t)i;
    }
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xA129CA6149BE45E5), sway_siphash(key, bytes, 15));
    /* "uespemos" as the key's first word makes the first sum 0 + x, which has no carry. */
    memcpy(key, "uespemos", 8);
    TEST_ASSERT_EQUAL_HEX64(siphash_of_the_paper(key, bytes, 15), sway_siphash(key, bytes, 15));
}

/* Time, number of the block and chance are all in the challenge. */
static void test_no_two_challenges_are_alike(void)
{
    sway_access_t access;
    uint8_t moment[16];
    const int64_t now = INT64_C(0x0123456789ABCDEF);
    const uint32_t sequence = 0x11223344U;
    const uint32_t random = 0x55667788U;
    memset(&access, 0, sizeof access);
    sway_access_open(&access, test_key, now, sequence, random);
    for (unsigned i = 0; i < 16U; i++) {
        moment[i] = i < 8U    ? (uint8_t)(now >> (8U * i))
                    : i < 12U ? (uint8_t)(sequence >> (8U * (i - 8U)))
                              : (uint8_t)(random >> (8U * (i - 12U)));
    }
    const uint64_t expected = siphash_of_the_paper(test_key, moment, sizeof moment);
    for (unsigned i = 0; i < SWAY_ACCESS_PROOF; i++) {
        TEST_ASSERT_EQUAL_HEX8((uint8_t)(expected >> (8U * i)), access.challenge[i]);
    }
}

static void test_after_five_restarts_nobody_may_write(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    for (unsigned i = 0; i < SWAY_ECU_RESTARTS_MAX; i++) {
        sway_ecu_note_fault(&retained, 3, 0);
    }
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RESTARTS, ecu.cause);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(OPEN, 0, 0).parameter_result);
    TEST_ASSERT_EQUAL(SWAY_ECU_NOT_NOW, sway_ecu_calibrate(&ecu, &config));
}

/* Standing is a speed of up to 0.5 m/s from the last half second, in a message that still comes. */
static void test_standing_is_what_it_is_said_to_be(void)
{
    static const struct {
        int32_t speed_mm_s;
        int64_t age_us;
        int64_t silent_us;
        sway_ecu_change_t expected;
    } cases[] = {{SWAY_ECU_STANDSTILL_MM_S, 0, 0, SWAY_ECU_CHANGED},
                 {SWAY_ECU_STANDSTILL_MM_S + 1, 0, 0, SWAY_ECU_NOT_NOW},
                 {0, 500000, 0, SWAY_ECU_CHANGED},
                 {0, 500001, 0, SWAY_ECU_NOT_NOW},
                 {0, 0, 100000, SWAY_ECU_CHANGED},
                 {0, 0, 100001, SWAY_ECU_NOT_NOW}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        start_good();
        drive();
        const sway_core_config_t config = good_config();
        ecu.now_us = ecu.node.message[SWAY_MESSAGE_SPEED].accepted_us + cases[i].silent_us;
        ecu.node.core.speed_mm_s = cases[i].speed_mm_s;
        ecu.node.core.speed_time_us = ecu.now_us - cases[i].age_us;
        TEST_ASSERT_EQUAL(cases[i].expected, sway_ecu_calibrate(&ecu, &config));
    }
}

static void test_the_end_of_a_session_is_reported_and_says_nothing_else(void)
{
    start_good();
    const struct swaywatch_dbc_sway_parameter_reply_t done =
        change(STORE, WORD_OF(alarm.hold_ms), 2500);
    TEST_ASSERT_EQUAL_UINT8(DONE, done.parameter_result);
    TEST_ASSERT_EQUAL_UINT16(0, done.parameter_reply_index);
    TEST_ASSERT_EQUAL_INT32(0, done.parameter_reply_value);
    TEST_ASSERT_TRUE(ecu.access_news || last_of(SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID) != NULL);
    const struct swaywatch_dbc_sway_access_t said = access_said();
    TEST_ASSERT_EQUAL(1, said.access_stores);
}

/* The same counter twice, for requests that differ, is two requests. */
static void test_requests_that_differ_are_two(void)
{
    start_good();
    (void)open_session();
    sway_port_frame_t first = request_frame(WRITE, 0, 1000000);
    sway_port_frame_t second = first;
    second.data[4] ^= 1U;
    sway_e2e_protect(second.id, first.data[1] & 15U, second.data);
    const uint32_t refused = ecu.requests_refused;
    (void)say(first);
    (void)say(second);
    TEST_ASSERT_EQUAL_UINT32(refused, ecu.requests_refused);
}

/* However many refusals there are, they are reported ten times a second at most. */
static void test_refusals_do_not_flood_the_bus(void)
{
    start_good();
    drive();
    (void)ask(READ, 9999, 0);
    sent_count = 0U;
    unsigned answers = 0;
    for (int i = 0; i < 200; i++) {
        give(request_frame(READ, 9999, 0));
    }
    for (unsigned i = 0; i < sent_count; i++) {
        answers += sent[i].id == SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID;
    }
    TEST_ASSERT_TRUE(answers == 2U || answers == 3U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_word_can_be_written_and_read);
    RUN_TEST(test_wrong_requests_are_answered_and_counted);
    RUN_TEST(test_refused_values_name_their_parameter);
    RUN_TEST(test_offender_agrees_with_the_core);
    RUN_TEST(test_new_values_are_applied_and_stored);
    RUN_TEST(test_port_without_memory_says_so);
    RUN_TEST(test_safe_state_ends_only_where_parameters_were_missing);
    RUN_TEST(test_siphash_gives_the_published_values);
    RUN_TEST(test_nobody_writes_without_a_session);
    RUN_TEST(test_a_wrong_proof_changes_nothing_and_is_reported);
    RUN_TEST(test_a_proof_fits_nothing_else);
    RUN_TEST(test_every_bit_of_a_proof_counts);
    RUN_TEST(test_challenge_is_the_hash_of_the_moment);
    RUN_TEST(test_challenges_do_not_come_twice);
    RUN_TEST(test_the_hardware_s_noise_is_in_the_challenge);
    RUN_TEST(test_parameters_change_at_standstill_only);
    RUN_TEST(test_a_session_ends_by_itself);
    RUN_TEST(test_an_ecu_without_a_key_takes_nothing);
    RUN_TEST(test_a_store_that_comes_twice_is_written_once);
    RUN_TEST(test_stores_are_limited);
    RUN_TEST(test_siphash_is_that_of_the_paper_for_every_length);
    RUN_TEST(test_no_two_challenges_are_alike);
    RUN_TEST(test_after_five_restarts_nobody_may_write);
    RUN_TEST(test_standing_is_what_it_is_said_to_be);
    RUN_TEST(test_the_end_of_a_session_is_reported_and_says_nothing_else);
    RUN_TEST(test_requests_that_differ_are_two);
    RUN_TEST(test_refusals_do_not_flood_the_bus);
    return UNITY_END();
}

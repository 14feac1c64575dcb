/* port/sway_ecu, sway_block, sway_store, sway_checks: start-up, parameters over CAN and in flash,
 * safe state, fault reports. */
#include <stdlib.h>

#include "port_test.h"
#include "sway_checks.h"
#include "sway_store.h"

#define QUEUE 64
#define WORD_OF(field) ((uint16_t)(offsetof(sway_core_config_t, field) / 4U))

static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static sway_port_frame_t inbox[QUEUE];
static unsigned inbox_count;
static unsigned inbox_at;
static sway_port_frame_t sent[4096];
static unsigned sent_count;
static int64_t now_us;
static int32_t speed_mm_s; // sent before each request; negative: not at all
static bool no_room;
static bool read_fails[SWAY_STORE_SLOTS];
static unsigned alive_count;

/* Two pages of flash, and when the power goes: after so many bytes, the erasure counts as one. */
static uint8_t page[SWAY_STORE_SLOTS][SWAY_BLOCK_SIZE];
static int power_left;
static bool flash_is_dead;

static bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (inbox_at == inbox_count) {
        return false;
    }
    *frame = inbox[inbox_at++ % QUEUE];
    return true;
}

static bool send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (!no_room && sent_count < sizeof sent / sizeof sent[0]) {
        sent[sent_count++] = *frame;
    }
    return !no_room;
}

static int64_t time_us(void *context)
{
    (void)context;
    return now_us;
}

static bool read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    (void)context;
    memcpy(bytes, page[slot], size);
    return !read_fails[slot];
}

static bool erase(void *context, uint32_t slot)
{
    (void)context;
    if (power_left == 0 || flash_is_dead) {
        return false;
    }
    power_left -= power_left > 0 ? 1 : 0;
    memset(page[slot], 0xFF, sizeof page[slot]);
    return true;
}

static bool write(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)context;
    for (size_t i = 0; i < size; i++) {
        if (power_left == 0) {
            return false;
        }
        power_left -= power_left > 0 ? 1 : 0;
        page[slot][i] = (uint8_t)(page[slot][i] & block[i]);
    }
    return true;
}

static const sway_store_t flash = {.read = read, .erase = erase, .write = write};

static bool store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    return sway_store_write(&flash, block, size);
}

static void alive(void *context)
{
    (void)context;
    alive_count++;
}

static const sway_port_t port = {.receive = receive,
                                 .send = send,
                                 .time_us = time_us,
                                 .store = store,
                                 .alive = alive,
                                 .key = test_key};

void setUp(void)
{
    memset(&retained, 0, sizeof retained);
    memset(page, 0xFF, sizeof page);
    inbox_count = inbox_at = sent_count = alive_count = 0U;
    now_us = 0;
    no_room = flash_is_dead = read_fails[0] = read_fails[1] = false;
    speed_mm_s = 0;
    power_left = -1;
}

void tearDown(void)
{
}

static void start_from(const uint8_t *block)
{
    sent_count = 0U;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, block, SWAY_BLOCK_SIZE));
}

static bool start(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    const bool interrupted = sway_store_find(&flash, block);
    start_from(block);
    return interrupted;
}

static void put_block(unsigned slot, const sway_core_config_t *config, uint32_t sequence)
{
    sway_block_write(config, sequence, page[slot]);
}

static void start_good(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

static void give(sway_port_frame_t frame)
{
    now_us += 1000;
    frame.time_us = now_us;
    inbox[inbox_count++ % QUEUE] = frame;
    for (int i = 0; i < 64; i++) {
        (void)sway_ecu_poll(&ecu);
    }
}

static void give_speed(void)
{
    static uint8_t counter;
    const struct swaywatch_dbc_sway_speed_t speed = {.vehicle_speed =
                                                         (uint16_t)(speed_mm_s * 36 / 100)};
    sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
    swaywatch_dbc_sway_speed_pack(frame.data, &speed, sizeof frame.data);
    sway_e2e_protect(frame.id, counter, frame.data);
    counter = sway_e2e_next(counter);
    give(frame);
}

/* Long enough for the grid to have rows of it. */
static void drive(void)
{
    for (int i = 0; i < 30 && speed_mm_s >= 0; i++) {
        now_us += 9000;
        give_speed();
    }
}

static const sway_port_frame_t *last_of(uint16_t id)
{
    for (unsigned i = sent_count; i > 0U; i--) {
        if (sent[i - 1U].id == id) {
            return &sent[i - 1U];
        }
    }
    return NULL;
}

static struct swaywatch_dbc_sway_parameter_reply_t say(sway_port_frame_t frame)
{
    if (speed_mm_s >= 0) {
        give_speed();
    }
    sent_count = 0U;
    give(frame);
    const sway_port_frame_t *reply = last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID);
    TEST_ASSERT_NOT_NULL_MESSAGE(reply, "no reply");
    return reply_of(reply);
}

static struct swaywatch_dbc_sway_parameter_reply_t ask(uint8_t command, uint16_t index,
                                                       int32_t value)
{
    return say(request_frame(command, index, value));
}

static struct swaywatch_dbc_sway_parameter_reply_t open_session(void)
{
    drive();
    const struct swaywatch_dbc_sway_parameter_reply_t opened = ask(OPEN, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(DONE, opened.parameter_result);
    return opened;
}

static struct swaywatch_dbc_sway_parameter_reply_t
finish(uint8_t command, struct swaywatch_dbc_sway_parameter_reply_t opened)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
    return say(proof_frame(command, test_key, opened, block));
}

/* A whole session: opens it, writes one word (none beyond the last), ends it. */
static struct swaywatch_dbc_sway_parameter_reply_t change(uint8_t command, uint32_t index,
                                                          int32_t value)
{
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    if (index < SWAY_BLOCK_WORDS) {
        TEST_ASSERT_EQUAL_UINT8(DONE, ask(WRITE, (uint16_t)index, value).parameter_result);
    }
    return finish(command, opened);
}

#define NOTHING UINT32_MAX

/* The newest SwayAccess; what has changed is told within 100 ms, on a silent bus
 * 200. */
static struct swaywatch_dbc_sway_access_t access_said(void)
{
    struct swaywatch_dbc_sway_access_t said;
    for (int i = 0; i < 210 && ecu.access_news; i++) {
        now_us += 1000;
        (void)sway_ecu_poll(&ecu);
        (void)sway_ecu_poll(&ecu);
    }
    TEST_ASSERT_FALSE(ecu.access_news);
    const sway_port_frame_t *frame = last_of(SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID);
    TEST_ASSERT_NOT_NULL_MESSAGE(frame, "no SwayAccess");
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_access_unpack(&said, frame->data, frame->dlc);
    return said;
}

static struct swaywatch_dbc_sway_fault_report_t report(void)
{
    sent_count = 0U;
    for (int i = 0; i < 1200; i++) {
        now_us += 1000;
        (void)sway_ecu_poll(&ecu);
        if (sent_count > 0U &&
            sent[sent_count - 1U].id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
            return report_of(&sent[sent_count - 1U]);
        }
        sent_count = sent_count > 4000U ? 0U : sent_count;
    }
    TEST_FAIL_MESSAGE("no report");
    return report_of(&sent[0]);
}

/* --- the block -------------------------------------------------------------------------------- */

static void test_good_block_starts(void)
{
    sway_core_config_t config = good_config();
    config.alarm.hold_ms = 777;
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config);
    TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
}

static void test_empty_flash_is_the_safe_state(void)
{
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_EMPTY, report().fault_cause);
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
    start_from(NULL);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
}

/* Every single bit that flips is found, and nothing of the block is used. */
static void test_damaged_block_is_never_used(void)
{
    const sway_core_config_t config = good_config();
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    for (unsigned bit = 0; bit < 8U * SWAY_BLOCK_SIZE; bit++) {
        put_block(0, &config, 1);
        page[0][bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        start();
        TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
        TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
        const unsigned wanted = bit < 32U   ? SWAY_BLOCK_EMPTY
                                : bit < 64U ? SWAY_BLOCK_VERSION_UNKNOWN
                                            : SWAY_BLOCK_CRC;
        TEST_ASSERT_EQUAL_UINT(SWAY_ECU_BLOCK + wanted, ecu.cause);
    }
}

static void test_block_of_another_version_is_refused(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    page[0][4] = SWAY_BLOCK_VERSION - 1U;
    const uint32_t crc = sway_block_crc32(0, page[0], SWAY_BLOCK_SIZE - 4U);
    memcpy(page[0] + SWAY_BLOCK_SIZE - 4U, &crc, 4);
    start();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_VERSION_UNKNOWN, report().fault_cause);
}

static void test_intact_block_with_wrong_values_is_refused(void)
{
    sway_core_config_t config = good_config();
    config.vehicle.trailer.mass_g = 1;
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_REFUSED, report().fault_cause);
}

/* --- two pages -------------------------------------------------------------------------------- */

static uint32_t found_sequence(bool *interrupted)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    uint32_t sequence = 0;
    *interrupted = sway_store_find(&flash, block);
    TEST_ASSERT_EQUAL(SWAY_BLOCK_OK, sway_block_check(block, sizeof block, &sequence));
    return sequence;
}

static void test_newest_good_block_wins(void)
{
    bool interrupted = false;
    sway_core_config_t config = good_config();
    put_block(0, &config, 4);
    config.vehicle.car.mass_g = 1700000;
    put_block(1, &config, 5);
    TEST_ASSERT_EQUAL_UINT32(5, found_sequence(&interrupted));
    put_block(0, &config, 6);
    TEST_ASSERT_EQUAL_UINT32(6, found_sequence(&interrupted));
    put_block(0, &config, UINT32_MAX); // the numbers turn over
    put_block(1, &config, 0);
    TEST_ASSERT_EQUAL_UINT32(0, found_sequence(&interrupted));
    TEST_ASSERT_FALSE(interrupted);
    page[1][40] ^= 1U;
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, found_sequence(&interrupted));
    TEST_ASSERT_TRUE(interrupted);
}

/* A block that looks whole is not used where the memory calls it damaged. */
static void test_what_the_memory_calls_damaged_is_not_used(void)
{
    const sway_core_config_t config = good_config();
    bool interrupted = false;
    put_block(0, &config, 4);
    put_block(1, &config, 5);
    read_fails[1] = true;
    TEST_ASSERT_EQUAL_UINT32(4, found_sequence(&interrupted));
    TEST_ASSERT_TRUE(interrupted);
    read_fails[0] = true;
    (void)start();
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL_UINT(SWAY_ECU_BLOCK + SWAY_BLOCK_CRC, ecu.cause);
}

/* Power cut after every byte of a store: old or new parameters, whole, and never silently. */
static void test_power_cut_at_every_byte_of_a_store(void)
{
    const int whole = 1 + (int)SWAY_BLOCK_SIZE;
    for (int cut = 0; cut <= whole; cut++) {
        setUp();
        const sway_core_config_t config = good_config();
        put_block(0, &config, 1);
        put_block(1, &config, 2);
        start();
        power_left = cut;
        TEST_ASSERT_EQUAL_UINT8(cut < whole ? NOT_STORED : DONE,
                                change(STORE, 0, 1800000).parameter_result);
        const bool interrupted = start();
        TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
        TEST_ASSERT_EQUAL_INT32(cut < whole ? 1955000 : 1800000,
                                sway_ecu_config(&ecu)->vehicle.car.mass_g);
        TEST_ASSERT_EQUAL(cut > 0 && cut < whole, interrupted);
    }
}

/* With a single page a cut means defaults, the safe state and a report: never half a block. */
static void test_power_cut_with_nothing_stored_before(void)
{
    const int whole = 1 + (int)SWAY_BLOCK_SIZE;
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    for (int cut = 0; cut < whole; cut++) {
        setUp();
        start();
        ecu.staged = good_config();
        power_left = cut;
        TEST_ASSERT_EQUAL_UINT8(NOT_STORED, change(STORE, NOTHING, 0).parameter_result);
        start();
        TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
        TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
        const uint8_t cause = report().fault_cause;
        TEST_ASSERT_TRUE(cause == SWAY_ECU_BLOCK + SWAY_BLOCK_EMPTY ||
                         cause == SWAY_ECU_BLOCK + SWAY_BLOCK_VERSION_UNKNOWN ||
                         cause == SWAY_ECU_BLOCK + SWAY_BLOCK_CRC);
    }
}

static void test_dead_flash_keeps_the_old_block(void)
{
    start_good();
    flash_is_dead = true;
    TEST_ASSERT_EQUAL_UINT8(NOT_STORED, change(STORE, NOTHING, 0).parameter_result);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

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

static void test_a_wrong_proof_changes_nothing_and_is_told(void)
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

/* --- faults ----------------------------------------------------------------------------------- */

static void test_fault_is_reported_after_the_restart(void)
{
    start_good();
    sway_ecu_note_fault(&retained, 4, 0x1234);
    start();
    const struct swaywatch_dbc_sway_fault_report_t told = report();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RUNNING, told.ecu_state);
    TEST_ASSERT_EQUAL_UINT8(4, told.fault_cause);
    TEST_ASSERT_EQUAL_HEX32(0x1234, told.fault_address);
    TEST_ASSERT_EQUAL_UINT8(1, told.fault_restarts);
}

/* README says five: the fifth is the last. */
static void test_endless_restarts_end_safe(void)
{
    start_good();
    for (unsigned i = 1; i < SWAY_ECU_RESTARTS_MAX; i++) {
        sway_ecu_note_fault(&retained, 3, 0);
        start();
        TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    }
    sway_ecu_note_fault(&retained, 3, 0);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RESTARTS, report().fault_cause);
    for (int i = 0; i < 300; i++) {
        sway_ecu_note_fault(&retained, 3, 0);
    }
    TEST_ASSERT_EQUAL_UINT32(255, retained.restarts);
}

static void test_retained_memory_after_power_on_is_not_believed(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    memset(&retained, 0xA7, sizeof retained);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
    memset(&retained, 0xA7, sizeof retained);
    sway_ecu_note_fault(&retained, 3, 0); // before the first start
    TEST_ASSERT_EQUAL_UINT32(1, retained.restarts);
}

static void test_warning_is_told_while_running(void)
{
    start_good();
    sway_ecu_warn(&ecu, SWAY_ECU_BUS_OFF);
    const struct swaywatch_dbc_sway_fault_report_t told = report();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BUS_OFF, told.fault_cause);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RUNNING, told.ecu_state);
}

/* Somebody else sends a message, 0.4 ms before its owner, with the counter that is due: his values
 * are used, the owner's are the repeated ones. That is told within a second or two. */
static void test_a_second_sender_is_told(void)
{
    start_good();
    (void)report();
    unsigned told = 0;
    for (unsigned i = 0; i < 500U; i++) {
        sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
        sway_e2e_protect(frame.id, (uint8_t)(i % 15U), frame.data);
        now_us += 8600;
        sent_count = 0U;
        give(frame);
        frame.data[2] = 1;
        sway_e2e_protect(frame.id, (uint8_t)(i % 15U), frame.data);
        now_us -= 600;
        give(frame);
        const sway_port_frame_t *said = last_of(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID);
        told += said != NULL && report_of(said).fault_cause == SWAY_ECU_DOUBLED;
    }
    TEST_ASSERT_TRUE(told >= 3U);
    for (unsigned i = 0; i < 10U; i++) { // and it is over
        now_us += 9000;
        give_speed();
    }
    (void)report();
    TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
}

static void test_overwritten_state_lets_the_watchdog_bite(void)
{
    start_good();
    (void)sway_ecu_poll(&ecu);
    const unsigned before = alive_count;
    TEST_ASSERT_TRUE(before > 0U);
    ecu.canary ^= 4U;
    TEST_ASSERT_FALSE(sway_ecu_poll(&ecu));
    TEST_ASSERT_EQUAL_UINT(before, alive_count);
}

static void test_safe_state_sends_nothing_but_reports(void)
{
    start_good();
    sway_ecu_fail(&ecu, SWAY_ECU_MEMORY);
    sent_count = 0U;
    for (uint8_t i = 0; i < 100U; i++) {
        sway_port_frame_t frame = {.id = 0x121, .dlc = 8};
        sway_e2e_protect(frame.id, i % 15U, frame.data);
        give(frame);
    }
    TEST_ASSERT_TRUE(sent_count >= 1U && sent_count <= 2U); // 100 ms
    for (unsigned i = 0; i < sent_count; i++) {
        TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_MEMORY, report_of(&sent[i]).fault_cause);
    }
}

/* A bus that takes nothing for a second: what comes is still received, checked and worked on. */
static void test_receiving_goes_on_while_sending_is_refused(void)
{
    start_good();
    drive();
    no_room = true;
    const uint32_t before = ecu.frames_received;
    const uint32_t accepted = ecu.node.accepted;
    for (int i = 0; i < 100; i++) {
        now_us += 9000;
        give_speed();
    }
    TEST_ASSERT_EQUAL_UINT32(before + 100U, ecu.frames_received);
    TEST_ASSERT_EQUAL_UINT32(accepted + 100U, ecu.node.accepted);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&ecu.node, SWAY_MESSAGE_SPEED));
    const sway_port_frame_t first = request_frame(READ, 0, 0);
    give(first);
    give(request_frame(READ, 1, 0)); // no room for a second answer: counted
    TEST_ASSERT_EQUAL_UINT32(1, ecu.requests_refused);
    no_room = false;
    sent_count = 0U;
    for (int i = 0; i < 100; i++) {
        (void)sway_ecu_poll(&ecu);
    }
    TEST_ASSERT_NOT_NULL(last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID));
    TEST_ASSERT_EQUAL_UINT16(
        0, reply_of(last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID)).parameter_reply_index);
}

static void test_nothing_is_lost_when_the_bus_has_no_room(void)
{
    start_good();
    no_room = true;
    give(request_frame(READ, 0, 0));
    TEST_ASSERT_EQUAL_UINT(0, sent_count);
    no_room = false;
    for (int i = 0; i < 10; i++) {
        (void)sway_ecu_poll(&ecu);
    }
    unsigned replies = 0;
    for (unsigned i = 0; i < sent_count; i++) {
        replies += sent[i].id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID;
    }
    TEST_ASSERT_EQUAL_UINT(1, replies);
}

static void test_null_arguments_are_refused(void)
{
    sway_port_t bad = port;
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_ecu_start(NULL, &port, &retained, NULL, 0));
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_ecu_start(&ecu, NULL, &retained, NULL, 0));
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_ecu_start(&ecu, &port, NULL, NULL, 0));
    bad.send = NULL;
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_ecu_start(&ecu, &bad, &retained, NULL, 0));
}

/* --- checks of memory and image --------------------------------------------------------------- */

static void test_memory_check_puts_everything_back(void)
{
    uint32_t words[64];
    uint32_t before[64];
    for (unsigned i = 0; i < 64U; i++) {
        words[i] = before[i] = i * 0x01234567U;
    }
    TEST_ASSERT_TRUE(sway_check_memory(words, words + 64));
    TEST_ASSERT_EQUAL_MEMORY(before, words, sizeof words);
}

static void test_image_check_finds_every_flipped_bit(void)
{
    uint8_t image[64];
    for (unsigned i = 0; i < sizeof image; i++) {
        image[i] = (uint8_t)(i * 7U);
    }
    const uint32_t crc = sway_block_crc32(0, image, sizeof image);
    TEST_ASSERT_TRUE(sway_check_image(image, sizeof image, crc));
    for (unsigned bit = 0; bit < 8U * sizeof image; bit++) {
        image[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        TEST_ASSERT_FALSE(sway_check_image(image, sizeof image, crc));
        image[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
    }
}

static void test_self_test_passes(void)
{
    TEST_ASSERT_EQUAL(SWAY_ECU_NO_CAUSE, sway_ecu_self_test());
}

/* --- counters and due times --------------------------------------------------------------------
 */

static void test_frames_and_refusals_are_counted(void)
{
    start_good();
    (void)report();
    const uint32_t sent_before = ecu.frames_sent;
    TEST_ASSERT_EQUAL_UINT32(0, ecu.frames_received);
    sent_count = 0U;
    for (uint8_t i = 0; i < 5U; i++) {
        sway_port_frame_t frame = {.id = 0x121, .dlc = 8};
        sway_e2e_protect(frame.id, i, frame.data);
        give(frame);
    }
    give(request_frame(READ, 0, 0));
    TEST_ASSERT_EQUAL_UINT32(6, ecu.frames_received);
    TEST_ASSERT_EQUAL_UINT32(sent_before + sent_count, ecu.frames_sent);
    TEST_ASSERT_EQUAL_UINT32(0, ecu.requests_refused);
}

/* Reports at start and then every second while running, every 100 ms in the safe state. */
static void test_reports_come_when_they_are_due(void)
{
    for (int safe = 0; safe < 2; safe++) {
        setUp();
        start_good();
        if (safe) {
            sway_ecu_fail(&ecu, SWAY_ECU_MEMORY);
        }
        const int64_t period_us = safe ? 100000 : 1000000;
        int64_t last_us = -1;
        for (int i = 0; i < 4000; i++, now_us += 1000) {
            sent_count = 0U;
            while (sway_ecu_poll(&ecu)) {
            }
            for (unsigned k = 0; k < sent_count; k++) {
                if (sent[k].id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
                    TEST_ASSERT_TRUE(last_us < 0 ? now_us == 0 : now_us - last_us == period_us);
                    last_us = now_us;
                }
            }
        }
        TEST_ASSERT_TRUE(last_us > 4000000 - 2 * period_us);
    }
}

/* --- flash that lies ---------------------------------------------------------------------------
 */

static bool forget(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)write(context, slot, block, size);
    page[slot][17] ^= 1U;
    return true;
}

static bool deny(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)write(context, slot, block, size);
    return false;
}

static bool keep(void *context, uint32_t slot)
{
    (void)context;
    (void)slot;
    return true; // erased nothing
}

static void test_flash_that_does_not_hold_is_found(void)
{
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_store_t bad = flash;
    sway_block_write(&config, 1, block);
    TEST_ASSERT_TRUE(sway_store_write(&flash, block, sizeof block));
    TEST_ASSERT_FALSE(sway_store_write(&flash, block, sizeof block - 1U));
    bad.write = forget;
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    bad.write = deny;
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    bad = flash;
    bad.erase = keep;
    memset(page[1], 0, sizeof page[1]);
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    TEST_ASSERT_TRUE(sway_store_write(&flash, block, sizeof block));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_good_block_starts);
    RUN_TEST(test_empty_flash_is_the_safe_state);
    RUN_TEST(test_damaged_block_is_never_used);
    RUN_TEST(test_block_of_another_version_is_refused);
    RUN_TEST(test_intact_block_with_wrong_values_is_refused);
    RUN_TEST(test_newest_good_block_wins);
    RUN_TEST(test_power_cut_at_every_byte_of_a_store);
    RUN_TEST(test_power_cut_with_nothing_stored_before);
    RUN_TEST(test_dead_flash_keeps_the_old_block);
    RUN_TEST(test_every_word_can_be_written_and_read);
    RUN_TEST(test_wrong_requests_are_answered_and_counted);
    RUN_TEST(test_refused_values_name_their_parameter);
    RUN_TEST(test_offender_agrees_with_the_core);
    RUN_TEST(test_new_values_are_applied_and_stored);
    RUN_TEST(test_port_without_memory_says_so);
    RUN_TEST(test_safe_state_ends_only_where_parameters_were_missing);
    RUN_TEST(test_fault_is_reported_after_the_restart);
    RUN_TEST(test_endless_restarts_end_safe);
    RUN_TEST(test_retained_memory_after_power_on_is_not_believed);
    RUN_TEST(test_warning_is_told_while_running);
    RUN_TEST(test_overwritten_state_lets_the_watchdog_bite);
    RUN_TEST(test_safe_state_sends_nothing_but_reports);
    RUN_TEST(test_nothing_is_lost_when_the_bus_has_no_room);
    RUN_TEST(test_null_arguments_are_refused);
    RUN_TEST(test_memory_check_puts_everything_back);
    RUN_TEST(test_image_check_finds_every_flipped_bit);
    RUN_TEST(test_self_test_passes);
    RUN_TEST(test_frames_and_refusals_are_counted);
    RUN_TEST(test_reports_come_when_they_are_due);
    RUN_TEST(test_flash_that_does_not_hold_is_found);
    RUN_TEST(test_what_the_memory_calls_damaged_is_not_used);
    RUN_TEST(test_siphash_gives_the_published_values);
    RUN_TEST(test_nobody_writes_without_a_session);
    RUN_TEST(test_a_wrong_proof_changes_nothing_and_is_told);
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
    RUN_TEST(test_a_second_sender_is_told);
    RUN_TEST(test_receiving_goes_on_while_sending_is_refused);
    return UNITY_END();
}

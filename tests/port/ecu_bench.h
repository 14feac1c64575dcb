/* An ECU on a bus, a flash with power cuts, and a tester, for the tests of sway_ecu. */
#ifndef ECU_BENCH_H
#define ECU_BENCH_H

#include <stdlib.h>

#include "bus_bench.h"
#include "sway_checks.h"
#include "sway_store.h"

#define QUEUE 64
#define WORD_OF(field) ((uint16_t)(offsetof(sway_core_config_t, field) / 4U))

static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static sway_port_frame_t inbox[QUEUE];
static unsigned inbox_count;
static unsigned inbox_at;
static int32_t speed_mm_s; // sent before each request; negative: not at all
static bool read_fails[SWAY_STORE_SLOTS];
static unsigned alive_count;

/* Two pages of flash, and when the power goes: after so many bytes, the erasure counts as one. */
static uint8_t page[SWAY_STORE_SLOTS][SWAY_BLOCK_SIZE];
static int power_left;
static bool flash_is_dead;

static inline bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (inbox_at == inbox_count) {
        return false;
    }
    *frame = inbox[inbox_at++ % QUEUE];
    return true;
}

static inline bool read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    (void)context;
    memcpy(bytes, page[slot], size);
    return !read_fails[slot];
}

static inline bool erase(void *context, uint32_t slot)
{
    (void)context;
    if (power_left == 0 || flash_is_dead) {
        return false;
    }
    power_left -= power_left > 0 ? 1 : 0;
    memset(page[slot], 0xFF, sizeof page[slot]);
    return true;
}

static inline bool write(void *context, uint32_t slot, const uint8_t *block, size_t size)
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

static const sway_store_t flash = {.size = SWAY_BLOCK_SIZE,
                                   .check = sway_block_check,
                                   .read = read,
                                   .erase = erase,
                                   .write = write};

static inline bool store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    return sway_store_write(&flash, block, size);
}

static inline void alive(void *context)
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

static inline void start_from(const uint8_t *block)
{
    sent_count = 0U;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, block, SWAY_BLOCK_SIZE));
}

static inline bool start(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    const bool interrupted = sway_store_find(&flash, block);
    start_from(block);
    return interrupted;
}

static inline void put_block(unsigned slot, const sway_core_config_t *config, uint32_t sequence)
{
    sway_block_write(config, sequence, page[slot]);
}

static inline void start_good(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

static inline void give(sway_port_frame_t frame)
{
    now_us += 1000;
    frame.time_us = now_us;
    inbox[inbox_count++ % QUEUE] = frame;
    for (int i = 0; i < 64; i++) {
        (void)sway_ecu_poll(&ecu);
    }
}

static inline void give_speed(void)
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
static inline void drive(void)
{
    for (int i = 0; i < 30 && speed_mm_s >= 0; i++) {
        now_us += 9000;
        give_speed();
    }
}

static inline const sway_port_frame_t *last_of(uint16_t id)
{
    for (unsigned i = sent_count; i > 0U; i--) {
        if (sent[i - 1U].id == id) {
            return &sent[i - 1U];
        }
    }
    return NULL;
}

static inline struct swaywatch_dbc_sway_parameter_reply_t say(sway_port_frame_t frame)
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

static inline struct swaywatch_dbc_sway_parameter_reply_t ask(uint8_t command, uint16_t index,
                                                              int32_t value)
{
    return say(request_frame(command, index, value));
}

static inline struct swaywatch_dbc_sway_parameter_reply_t open_session(void)
{
    drive();
    const struct swaywatch_dbc_sway_parameter_reply_t opened = ask(OPEN, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(DONE, opened.parameter_result);
    return opened;
}

static inline struct swaywatch_dbc_sway_parameter_reply_t
finish(uint8_t command, struct swaywatch_dbc_sway_parameter_reply_t opened)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
    return say(proof_frame(command, test_key, opened, block));
}

/* A whole session: opens it, writes one word (none beyond the last), ends it. */
static inline struct swaywatch_dbc_sway_parameter_reply_t change(uint8_t command, uint32_t index,
                                                                 int32_t value)
{
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    if (index < SWAY_BLOCK_WORDS) {
        TEST_ASSERT_EQUAL_UINT8(DONE, ask(WRITE, (uint16_t)index, value).parameter_result);
    }
    return finish(command, opened);
}

#define NOTHING UINT32_MAX

/* The newest SwayAccess; what has changed is reported within 100 ms, on a silent bus
 * 200. */
static inline struct swaywatch_dbc_sway_access_t access_said(void)
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

static inline struct swaywatch_dbc_sway_fault_report_t report(void)
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

#endif

/* Shared by the tests of port/xcp: an ECU with the slave before it, and a master's commands. */
#ifndef XCP_BENCH_H
#define XCP_BENCH_H

#include "bus_bench.h"
#include "sway_xcp.h"

#define REQUEST 0x6E4
#define REPLY 0x6E5
#define ECU_AT 0x20000000U
#define WORKING_AT 0x30000000U
#define SPEED_KNOWN_US 100000 // a frame of the speed comes at least every 100 ms

static sway_xcp_t xcp;
static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static sway_port_frame_t inbox;
static bool has_inbox;
static bool is_endless;
static uint8_t speed_counter;

static inline bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    *frame = inbox;
    const bool was_there = has_inbox;
    has_inbox = is_endless;
    return was_there;
}

static inline void begin(const uint8_t *key)
{
    const sway_port_t board = {.receive = receive, .send = send, .time_us = time_us, .key = key};
    const sway_xcp_config_t at = {REQUEST, REPLY, ECU_AT, WORKING_AT};
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&config, 1, block);
    memset(&retained, 0, sizeof retained);
    has_inbox = is_endless = no_room = false;
    sent_count = 0;
    now_us = 0;
    speed_counter = 0;
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &at);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, block, sizeof block));
    sway_xcp_start(&xcp);
}

void setUp(void)
{
    begin(test_key);
}

void tearDown(void)
{
}

static inline void hand_over(sway_port_frame_t frame)
{
    now_us += 10000;
    frame.time_us = now_us;
    inbox = frame;
    has_inbox = true;
    for (int i = 0; i < 500 && (sway_xcp_poll(&xcp) || has_inbox); i++) {
    }
}

static inline void speed(uint16_t centi_kmh)
{
    sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
    frame.data[2] = (uint8_t)centi_kmh;
    frame.data[3] = (uint8_t)(centi_kmh >> 8);
    sway_e2e_protect(frame.id, speed_counter, frame.data);
    speed_counter = sway_e2e_next(speed_counter);
    hand_over(frame);
}

/* The slave's answer to a command; NULL: none. */
static inline const sway_port_frame_t *ask(unsigned size, const uint8_t *command)
{
    sway_port_frame_t frame = {.id = REQUEST, .dlc = (uint8_t)size};
    memcpy(frame.data, command, size);
    sent_count = 0;
    hand_over(frame);
    for (unsigned i = 0; i < sent_count; i++) {
        if (sent[i].id == REPLY && sent[i].data[0] >= 0xFEU) {
            return &sent[i];
        }
    }
    return NULL;
}

#define ASK(...) ask(sizeof((uint8_t[]){__VA_ARGS__}), (const uint8_t[]){__VA_ARGS__})
#define ADDRESS(a)                                                                                 \
    (uint8_t)(a), (uint8_t)((a) >> 8), (uint8_t)((a) >> 16), (uint8_t)((uint32_t)(a) >> 24)

#define GOOD(...)                                                                                  \
    do {                                                                                           \
        const sway_port_frame_t *answer_ = ASK(__VA_ARGS__);                                       \
        TEST_ASSERT_NOT_NULL(answer_);                                                             \
        TEST_ASSERT_EQUAL_HEX8(0xFF, answer_->data[0]);                                            \
    } while (0)
#define REFUSED(code, ...)                                                                         \
    do {                                                                                           \
        const sway_port_frame_t *answer_ = ASK(__VA_ARGS__);                                       \
        TEST_ASSERT_NOT_NULL(answer_);                                                             \
        TEST_ASSERT_EQUAL_HEX8(0xFE, answer_->data[0]);                                            \
        TEST_ASSERT_EQUAL_HEX8(code, answer_->data[1]);                                            \
        TEST_ASSERT_EQUAL_UINT8(2, answer_->dlc);                                                  \
    } while (0)
#define CONNECT() GOOD(0xFF, 0)

static inline void unlock(void)
{
    uint8_t command[8] = {0xF7, 6};
    uint8_t message[8] = {0, 0, 0, 0, 0, 0, 0xF7, 0};
    const sway_port_frame_t *seed = ASK(0xF8, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(6, seed->data[1]);
    TEST_ASSERT_EQUAL_UINT8(8, seed->dlc);
    memcpy(message, seed->data + 2, 6);
    const uint64_t key = sway_siphash(test_key, message, sizeof message);
    for (unsigned i = 0; i < 6; i++) {
        command[2 + i] = (uint8_t)(key >> (8U * i));
    }
    const sway_port_frame_t *answer = ask(8, command);
    TEST_ASSERT_EQUAL_HEX8(0xFF, answer->data[0]);
    TEST_ASSERT_EQUAL_HEX8(0, answer->data[1]);
    TEST_ASSERT_EQUAL_UINT8(2, answer->dlc);
}

#endif

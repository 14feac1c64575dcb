/* port/xcp: sessions, locks, memory, pages, answers; DAQ lists are in test_xcp_daq.c. What a master
 * of others sees of it is in tests/host/test_xcp.py and tests/hil/test_xcp.py. */
#include "xcp_bench.h"

/* --- sessions --------------------------------------------------------------------------------- */

static void test_it_is_silent_until_it_is_connected(void)
{
    TEST_ASSERT_NULL(ASK(0xFD));
    TEST_ASSERT_NULL(ASK(0xFC));
    const uint8_t resources = ASK(0xFF, 0)->data[1];
    TEST_ASSERT_EQUAL_HEX8(0x05, resources);
    GOOD(0xFD);
    GOOD(0xFE);
    TEST_ASSERT_NULL(ASK(0xFD));
}

static void test_commands_that_are_none(void)
{
    CONNECT();
    REFUSED(0x00, 0xFC);          // that is how SYNCH is answered
    REFUSED(0x20, 0xF9, 1, 0, 0); // nothing is stored
    REFUSED(0x20, 0xD2);          // nor programmed
    REFUSED(0x20, 0x00);
    REFUSED(0x21, 0xF6, 0, 0, 0); // too short
    REFUSED(0x21, 0xF0, 4, 1, 2); // shorter than it says
    REFUSED(0x22, 0xF8, 0, 2);    // no such resource
    TEST_ASSERT_NULL(ask(0, (const uint8_t *)""));
    TEST_ASSERT_EQUAL_UINT32(3, ecu.requests_refused);
}

/* A master that does not stop gets a few answers a call, and none of its commands is a frame of the
 * car's. */
static void test_commands_without_end_end(void)
{
    CONNECT();
    inbox = (sway_port_frame_t){.id = REQUEST, .dlc = 1, .data = {0xFD}};
    sent_count = 0;
    has_inbox = is_endless = true;
    const uint32_t before = ecu.frames_received;
    (void)sway_xcp_poll(&xcp);
    TEST_ASSERT_TRUE(sent_count > 0U && sent_count <= SWAY_XCP_FRAMES_MAX + 1U);
    TEST_ASSERT_EQUAL_UINT32(before, ecu.frames_received);
}

static void test_a_port_without_a_key_cannot_be_calibrated(void)
{
    begin(NULL);
    CONNECT();
    REFUSED(0x24, 0xF8, 0, 1);
    REFUSED(0x29, 0xF7, 6, 1, 2, 3, 4, 5, 6);
    REFUSED(0x25, 0xEB, 0x83, 0, 1);
    REFUSED(0x25, 0xE4, 0, 0, 0, 1);
    REFUSED(0x25, 0xF0, 4, 0, 0, 0, 0);
    GOOD(0xF8, 0, 4); // DAQ is not locked: a seed of no bytes
}

static void test_a_wrong_key_ends_the_connection_and_is_reported(void)
{
    CONNECT();
    GOOD(0xF8, 0, 1);
    REFUSED(0x25, 0xF7, 6, 1, 2, 3, 4, 5, 6);
    TEST_ASSERT_EQUAL_UINT32(1, ecu.access.forged);
    unsigned refusals = 0;
    for (unsigned i = 0; i < sent_count; i++) {
        refusals += sent[i].id == SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID;
    }
    TEST_ASSERT_EQUAL_UINT(1, refusals);
    TEST_ASSERT_NULL(ASK(0xFD));
    CONNECT();
    REFUSED(0x29, 0xF7, 6, 1, 2, 3, 4, 5, 6); // a seed serves once
}

static void test_the_lock_closes_again_after_its_time(void)
{
    CONNECT();
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xF8, 0, 1)->data[1]); // open: no seed
    now_us += SWAY_ACCESS_SESSION_US;
    TEST_ASSERT_EQUAL_HEX8(0x01, ASK(0xFD)->data[2]);
    REFUSED(0x25, 0xEB, 0x02, 0, 1);
    unlock();
    CONNECT(); // locks, too
    REFUSED(0x25, 0xEB, 0x02, 0, 1);
}

static void test_what_it_says_of_itself(void)
{
    CONNECT();
    const uint8_t length = ASK(0xFA, 1)->data[4];
    TEST_ASSERT_EQUAL_UINT8(9, length);
    TEST_ASSERT_EQUAL_STRING_LEN("swaywat", &ASK(0xF5, 7)->data[1], 7);
    TEST_ASSERT_EQUAL_STRING_LEN("ch", &ASK(0xF5, 2)->data[1], 2);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xFA, 2)->data[4]); // no path
    TEST_ASSERT_EQUAL_UINT8(5, ASK(0xD7, 0, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_STRING_LEN("10 ms", &ASK(0xF5, 5)->data[1], 5);
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xD7, 0, 1, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("10 ms", &ASK(0xF5, 5)->data[1], 5);
    TEST_ASSERT_EQUAL_HEX8(0x93, ASK(0xDA)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x34, ASK(0xD9)->data[5]);
}

static unsigned stores;
static unsigned lives;

static bool store(void *context, const uint8_t *block, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    TEST_ASSERT_NOT_NULL(block);
    TEST_ASSERT_EQUAL_size_t(SWAY_BLOCK_SIZE, size);
    return ++stores == 1U;
}

static void alive(void *context)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    lives++;
}

static uint32_t noise(void *context)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    return 42U;
}

static void test_the_rest_of_the_port_is_passed_on(void)
{
    const sway_port_t board = {.receive = receive,
                               .send = send,
                               .time_us = time_us,
                               .store = store,
                               .alive = alive,
                               .random = noise,
                               .key = test_key,
                               .context = &stores};
    const uint8_t block[SWAY_BLOCK_SIZE] = {0};
    const sway_xcp_config_t at = xcp.config;
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &at);
    TEST_ASSERT_TRUE(port.store(port.context, block, sizeof block));
    TEST_ASSERT_FALSE(port.store(port.context, block, sizeof block));
    port.alive(port.context);
    TEST_ASSERT_EQUAL_UINT(1, lives);
    TEST_ASSERT_EQUAL_UINT32(42, port.random(port.context));
    TEST_ASSERT_EQUAL_PTR(test_key, port.key);
}

static void test_an_answer_that_waits_is_sent_first(void)
{
    CONNECT();
    no_room = true;
    TEST_ASSERT_NULL(ASK(0xFD));
    TEST_ASSERT_NULL(ASK(0xDA)); // is not listened to: the master has to wait for its answer
    no_room = false;
    sent_count = 0;
    hand_over((sway_port_frame_t){.id = 0x7FF, .dlc = 1});
    TEST_ASSERT_EQUAL_UINT16(REPLY, sent[0].id);
    TEST_ASSERT_EQUAL_UINT8(6, sent[0].dlc); // of GET_STATUS
    GOOD(0xDA);
}

/* --- memory and pages ------------------------------------------------------------------------- */

static void test_memory_ends_where_the_ecu_ends(void)
{
    const uint32_t end = ECU_AT + (uint32_t)sizeof ecu;
    CONNECT();
    GOOD(0xF4, 4, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xF4, 1, 0, 0, ADDRESS(end - 1U));
    REFUSED(0x24, 0xF4, 2, 0, 0, ADDRESS(end - 1U));
    REFUSED(0x24, 0xF4, 1, 0, 0, ADDRESS(ECU_AT - 1U));
    REFUSED(0x24, 0xF4, 1, 0, 1, ADDRESS(200U)); // behind the texts
    REFUSED(0x24, 0xF4, 1, 0, 2, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF4, 0, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF4, 8, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF3, 0, 0, 0, ADDRESS(0U));
    REFUSED(0x24, 0xE1, 0xFF, 4, 0, ADDRESS(0U));
    REFUSED(0x22, 0xE1, 0xFF, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xE1, 0xFF, 8, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF8, 1, 1); // a seed has one part
    REFUSED(0x22, 0xF3, 0, 0, 0, ADDRESS(0xFFFFFFFFU));
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xF3, 0, 0, 0, ADDRESS(4U));
    GOOD(0xF6, 0, 0, 0, ADDRESS(end));
    REFUSED(0x24, 0xF3, 0, 0, 0, ADDRESS(4U));
}

static void write_mass(uint32_t grams, uint8_t wanted)
{
    const uint32_t at = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, vehicle.trailer.mass_g);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    const sway_port_frame_t *answer = ASK(0xF0, 4, ADDRESS(grams));
    TEST_ASSERT_EQUAL_HEX8(wanted, answer->data[0] == 0xFF ? 0xFF : answer->data[1]);
}

static int32_t used_mass(void)
{
    return sway_ecu_config(&ecu)->vehicle.trailer.mass_g;
}

static void test_pages(void)
{
    CONNECT();
    unlock();
    write_mass(2000000, 0x23); // the master sees page 0
    GOOD(0xEB, 0x02, 0, 1);
    write_mass(49999, 0x22);
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 2U));
    REFUSED(0x22, 0xF0, 4, 0, 0, 0, 0); // half of two words
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x23, 0xF0, 4, 0, 0, 0, 0);
    write_mass(2000000, 0xFF);
    REFUSED(0x24, 0xEB, 0x01, 0, 1); // speed not known
    speed(0);
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL_INT32(2000000, used_mass());
    write_mass(2100000, 0x10); // busy: begun anew, the speed has not come yet
    now_us = xcp.changed_us + SPEED_KNOWN_US - 20001; // each command is 10 ms later
    write_mass(2100000, 0x10);
    now_us = xcp.changed_us + SPEED_KNOWN_US - 20000;
    write_mass(2100000, 0x24); // it has not come at all
    speed(0);
    write_mass(2100000, 0xFF);
    TEST_ASSERT_EQUAL_INT32(2100000, used_mass());
    speed(0);
    GOOD(0xE4, 0, 0, 0, 1); // the reference into the page that is used
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    speed(5000);
    write_mass(2000000, 0x10);
    now_us += 200000;
    speed(5000);
    write_mass(2000000, 0x24); // moves
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 1, 0)->data[3]);
    REFUSED(0x24, 0xEB, 0x81, 0, 0);
}

static void test_pages_that_are_none(void)
{
    CONNECT();
    unlock();
    REFUSED(0x28, 0xEB, 0x02, 1, 0);
    REFUSED(0x26, 0xEB, 0x02, 0, 2);
    REFUSED(0x27, 0xEB, 0x00, 0, 1);
    REFUSED(0x28, 0xEA, 1, 1);
    REFUSED(0x27, 0xEA, 3, 0);
    speed(0);
    GOOD(0xE8, 0, 0, 1, 0);
    REFUSED(0x28, 0xE4, 1, 0, 0, 1);
    REFUSED(0x26, 0xE4, 0, 1, 0, 0); // page 0 is read only
    REFUSED(0x28, 0xE8, 0, 1, 0, 0);
    REFUSED(0x22, 0xE8, 0, 0, 2, 0);
    REFUSED(0x22, 0xE8, 2, 0, 0, 0);
    REFUSED(0x28, 0xE7, 0, 1, 0);
    REFUSED(0x26, 0xE7, 0, 0, 2);
    TEST_ASSERT_EQUAL_HEX8(0x0F, ASK(0xE7, 0, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x3F, ASK(0xE7, 0, 0, 1)->data[1]);
    TEST_ASSERT_EQUAL_UINT8(2, ASK(0xE8, 1, 0, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xE9)->data[1]);
}

static void test_a_page_without_a_vehicle_is_filled_word_by_word(void)
{
    const sway_core_config_t good = good_config();
    uint8_t nothing[SWAY_BLOCK_SIZE] = {0};
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &xcp.port, &xcp.config);
    const sway_port_t board = {
        .receive = receive, .send = send, .time_us = time_us, .key = test_key};
    xcp.port = board;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, nothing, sizeof nothing));
    xcp.config = (sway_xcp_config_t){REQUEST, REPLY, ECU_AT, WORKING_AT};
    sway_xcp_start(&xcp);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    CONNECT();
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    REFUSED(0x22, 0xEB, 0x01, 0, 1);
    for (uint32_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        int32_t value = 0;
        (void)sway_block_get(&good, i, &value);
        const uint32_t word = (uint32_t)value;
        GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 4U * i));
        GOOD(0xF0, 4, ADDRESS(word));
    }
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

static void test_what_the_parameter_frames_apply_is_the_new_reference(void)
{
    CONNECT();
    speed(0);
    sway_core_config_t other = good_config();
    other.vehicle.trailer.mass_g = 1700000;
    TEST_ASSERT_EQUAL(SWAY_ECU_CHANGED, sway_ecu_calibrate(&ecu, &other));
    GOOD(0xFD);
    TEST_ASSERT_EQUAL_INT32(1700000, xcp.reference.vehicle.trailer.mass_g);
    TEST_ASSERT_EQUAL_INT32(1700000, xcp.working.vehicle.trailer.mass_g);
}

/* --- every answer, byte by byte -----------------------------------------------------------------
 */

static void expect_answer(unsigned size, const uint8_t *expected, const sway_port_frame_t *answer)
{
    TEST_ASSERT_NOT_NULL(answer);
    TEST_ASSERT_EQUAL_UINT8(size, answer->dlc);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, answer->data, size);
    TEST_ASSERT_EQUAL_INT64(now_us, answer->time_us);
}

static void test_answers_are_those_of_the_standard(void)
{
    static const struct {
        uint8_t size, command[8], length, answer[8];
    } cases[] = {
        {2, {0xFF, 0}, 8, {0xFF, 0x05, 0, 8, 8, 0, 1, 1}},
        {1, {0xFD}, 6, {0xFF, 0, 1}},
        {2, {0xFA, 1}, 8, {0xFF, 0, 0, 0, 9}},
        {2, {0xF5, 7}, 8, {0xFF, 's', 'w', 'a', 'y', 'w', 'a', 't'}},
        {2, {0xF5, 2}, 3, {0xFF, 'c', 'h'}},
        {2, {0xFA, 0}, 8, {0xFF, 0, 0, 0, 9}},
        {2, {0xF5, 1}, 2, {0xFF, 's'}},
        {1, {0xE9}, 3, {0xFF, 1}},
        {5, {0xE8, 0, 0, 0, 0}, 8, {0xFF, 0, 0, 0, ADDRESS(WORKING_AT)}},
        {5, {0xE8, 0, 0, 1, 0}, 8, {0xFF, 0, 0, 0, ADDRESS(sizeof(sway_core_config_t))}},
        {5, {0xE8, 1, 0, 0, 0}, 6, {0xFF, 2}},
        {4, {0xE7, 0, 0, 1}, 3, {0xFF, 0x3F}},
        {3, {0xEA, 1, 0}, 4, {0xFF}},
        {3, {0xEA, 2, 0}, 4, {0xFF}},
        {1, {0xDA}, 8, {0xFF, 0x93, 0, 0, SWAY_XCP_EVENTS}},
        {1, {0xD9}, 8, {0xFF, 1, 7, 1, 0, 0x34, 1}},
        {4, {0xD7, 0, 0, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 12, 0, 6}},
        {2, {0xF5, 7}, 8, {0xFF, 'n', 'e', 'w', ' ', 'e', 's', 't'}},
        {4, {0xD7, 0, 1, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 5, 10, 6}},
        {2, {0xF5, 5}, 6, {0xFF, '1', '0', ' ', 'm', 's'}},
        {4, {0xD7, 0, 2, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 6, 100, 6}},
        {2, {0xF5, 6}, 7, {0xFF, '1', '0', '0', ' ', 'm', 's'}},
        {3, {0xF8, 0, 4}, 2, {0xFF}},
        {1, {0xD6}, 1, {0xFF}},
        {4, {0xD5, 0, 2, 0}, 1, {0xFF}},
        {1, {0xDA}, 8, {0xFF, 0x93, 2, 0, SWAY_XCP_EVENTS}},
        {5, {0xD4, 0, 0, 0, 2}, 1, {0xFF}},
        {5, {0xD4, 0, 1, 0, 1}, 1, {0xFF}},
        {6, {0xD3, 0, 1, 0, 0, 1}, 1, {0xFF}},
        {6, {0xE2, 0, 1, 0, 0, 0}, 1, {0xFF}},
        {8, {0xE1, 0xFF, 7, 0, ADDRESS(ECU_AT)}, 1, {0xFF}},
        {8, {0xE0, 0, 1, 0, 2, 0, 3, 0}, 1, {0xFF}},
        {4, {0xDF, 0, 1, 0}, 8, {0xFF, 0, 0, 0, 2, 0, 3}},
        {4, {0xDE, 1, 1, 0}, 2, {0xFF, 2}},
        {1, {0xFD}, 6, {0xFF, 0x40, 1}},
        {4, {0xDF, 0, 1, 0}, 8, {0xFF, 0x40, 0, 0, 2, 0, 3}},
        {2, {0xDD, 0}, 1, {0xFF}},
        {1, {0xFE}, 1, {0xFF}},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        expect_answer(cases[i].length, cases[i].answer, ask(cases[i].size, cases[i].command));
    }
    CONNECT();
    const sway_port_frame_t *clock = ASK(0xDC);
    const uint8_t answer[8] = {0xFF, 0, 0, 0, ADDRESS(now_us)};
    expect_answer(8, answer, clock);
}

/* Memory is what is there, a checksum its CRC-32, and each goes on where the last one ended. */
static void test_memory_is_what_is_there(void)
{
    uint8_t expected[8] = {0xFF};
    CONNECT();
    ecu.access.forged = 0x11223344U;
    const uint32_t at = ECU_AT + (uint32_t)offsetof(sway_ecu_t, access.forged);
    memcpy(expected + 1, &ecu.access.forged, 4);
    expect_answer(5, expected, ASK(0xF4, 4, 0, 0, ADDRESS(at)));
    const uint8_t *const page = (const uint8_t *)&xcp.reference;
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 4U));
    const uint32_t crc = sway_block_crc32(0, page + 4, 8);
    const uint8_t sum[8] = {0xFF, 9, 0, 0, ADDRESS(crc)};
    expect_answer(8, sum, ASK(0xF3, 0, 0, 0, ADDRESS(8U)));
    memcpy(expected + 1, page + 12, 4);
    expect_answer(5, expected, ASK(0xF5, 4));
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT));
    GOOD(0xF3, 0, 0, 0, ADDRESS(sizeof(sway_core_config_t)));
    REFUSED(0x24, 0xF4, 1, 0, 1, ADDRESS(32U)); // right behind the texts
    GOOD(0xF4, 1, 0, 1, ADDRESS(31U));
}

static void test_words_are_downloaded_one_after_the_other(void)
{
    const uint32_t at = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, alarm.critical_time_ms);
    CONNECT();
    REFUSED(0x25, 0xF0, 1, 0);
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    GOOD(0xF0, 4, ADDRESS(2500U));
    GOOD(0xF0, 4, ADDRESS(1500U));
    TEST_ASSERT_EQUAL_INT32(2500, xcp.working.alarm.critical_time_ms);
    TEST_ASSERT_EQUAL_INT32(1500, xcp.working.alarm.hold_ms);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    REFUSED(0x22, 0xF0, 2, 0, 0);
    REFUSED(0x22, 0xF0, 2, 0xC4, 0x09); // half a word, whose number is in range
    REFUSED(0x22, 0xF0, 4, ADDRESS(0U));
    GOOD(0xF0, 4, ADDRESS(500U)); // the limits themselves are taken
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    GOOD(0xF0, 4, ADDRESS(20000U));
    const uint32_t period = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, input_period_us);
    GOOD(0xF6, 0, 0, 0, ADDRESS(period));
    REFUSED(0x22, 0xF0, 4, ADDRESS(999U));
    GOOD(0xF0, 4, ADDRESS(0U)); // of any rate
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + sizeof(sway_core_config_t)));
    REFUSED(0x23, 0xF0, 4, 0, 0, 0, 0);
}

static void test_each_page_is_set_by_itself(void)
{
    CONNECT();
    unlock();
    speed(0);
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 2, 0)->data[3]);
    speed(0);
    GOOD(0xEB, 0x01, 0, 0);
    GOOD(0xEB, 0x02, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 2, 0)->data[3]);
    REFUSED(0x26, 0xE4, 0, 1, 0, 1);
    REFUSED(0x26, 0xE4, 0, 0, 0, 0);
    CONNECT(); // the master sees what the ECU uses
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 2, 0)->data[3]);
}

/* To the microsecond; and a seed of before a connection opens nothing. */
static void test_a_lock_is_open_for_its_time(void)
{
    CONNECT();
    unlock();
    TEST_ASSERT_EQUAL_INT64(now_us, xcp.unlocked_us);
    const int64_t end_us = now_us + SWAY_ACCESS_SESSION_US;
    now_us = end_us - 10001;
    TEST_ASSERT_EQUAL_HEX8(0, ASK(0xFD)->data[2]);
    now_us = end_us - 10000;
    TEST_ASSERT_EQUAL_HEX8(1, ASK(0xFD)->data[2]);
    GOOD(0xF8, 0, 1);
    TEST_ASSERT_TRUE(xcp.access.is_open);
    GOOD(0xFE);
    CONNECT();
    REFUSED(0x29, 0xF7, 6);
    const uint32_t refused = xcp.refused;
    REFUSED(0x20, 0x00);
    TEST_ASSERT_EQUAL_UINT32(refused + 1U, xcp.refused);
}

static void test_the_reference_is_what_the_ecu_runs_with(void)
{
    memset(&xcp, 0xA5, sizeof xcp);
    begin(test_key);
    TEST_ASSERT_NULL(ASK(0xFD)); // not connected
    ecu.staged.alarm.hold_ms = 9999;
    sway_xcp_start(&xcp);
    TEST_ASSERT_EQUAL_INT32(sway_ecu_config(&ecu)->alarm.hold_ms, xcp.reference.alarm.hold_ms);
    CONNECT();
    unlock();
    speed(0);
    GOOD(0xEB, 0x01, 0, 1);
    speed(0);
    sway_core_config_t other = good_config();
    other.vehicle.trailer.mass_g = 1700000;
    TEST_ASSERT_EQUAL(SWAY_ECU_CHANGED, sway_ecu_calibrate(&ecu, &other));
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 1, 0)->data[3]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_is_silent_until_it_is_connected);
    RUN_TEST(test_commands_that_are_none);
    RUN_TEST(test_commands_without_end_end);
    RUN_TEST(test_a_port_without_a_key_cannot_be_calibrated);
    RUN_TEST(test_a_wrong_key_ends_the_connection_and_is_reported);
    RUN_TEST(test_the_lock_closes_again_after_its_time);
    RUN_TEST(test_what_it_says_of_itself);
    RUN_TEST(test_the_rest_of_the_port_is_passed_on);
    RUN_TEST(test_an_answer_that_waits_is_sent_first);
    RUN_TEST(test_memory_ends_where_the_ecu_ends);
    RUN_TEST(test_pages);
    RUN_TEST(test_pages_that_are_none);
    RUN_TEST(test_a_page_without_a_vehicle_is_filled_word_by_word);
    RUN_TEST(test_what_the_parameter_frames_apply_is_the_new_reference);
    RUN_TEST(test_answers_are_those_of_the_standard);
    RUN_TEST(test_memory_is_what_is_there);
    RUN_TEST(test_words_are_downloaded_one_after_the_other);
    RUN_TEST(test_each_page_is_set_by_itself);
    RUN_TEST(test_a_lock_is_open_for_its_time);
    RUN_TEST(test_the_reference_is_what_the_ecu_runs_with);
    return UNITY_END();
}

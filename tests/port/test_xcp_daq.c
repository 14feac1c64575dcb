/* port/xcp: DAQ lists, by a master's commands and by themselves. */
#include "xcp_bench.h"

/* --- by commands ------------------------------------------------------------------------------ */

/* One list of one entry: the ECU's count of frames received. */
static void allocate(void)
{
    const uint32_t at = ECU_AT + (uint32_t)offsetof(sway_ecu_t, frames_received);
    GOOD(0xD6);
    GOOD(0xD5, 0, 1, 0);
    GOOD(0xD4, 0, 0, 0, 1);
    GOOD(0xD3, 0, 0, 0, 0, 1);
    GOOD(0xE2, 0, 0, 0, 0, 0);
    GOOD(0xE1, 0xFF, 4, 0, ADDRESS(at));
}

static unsigned samples(void)
{
    unsigned count = 0;
    for (unsigned i = 0; i < sent_count; i++) {
        count += sent[i].id == REPLY && sent[i].data[0] == 0;
    }
    return count;
}

static void test_a_list_is_sampled_every_10_ms(void)
{
    CONNECT();
    allocate();
    REFUSED(0x22, 0xDF, 0, 1, 0);    // there is one list
    allocate();                      // the old ones are given back
    GOOD(0xE0, 0, 0, 0, 1, 0, 2, 0); // event 1, every second time
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xDE, 1, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x40, ASK(0xFD)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x40, ASK(0xDF, 0, 0, 0)->data[1]);
    REFUSED(0x11, 0xE0, 0, 0, 0, 1, 0, 1, 0);
    sent_count = 0;
    for (int i = 0; i < 20; i++) {
        speed(0);
    }
    TEST_ASSERT_EQUAL_UINT(10, samples());
    GOOD(0xDE, 0, 0, 0);
    sent_count = 0;
    speed(0);
    TEST_ASSERT_EQUAL_UINT(0, samples());
}

static void test_selected_lists_start_together_with_time_stamps(void)
{
    CONNECT();
    allocate();
    REFUSED(0x27, 0xE0, 2, 0, 0, 1, 0, 1, 0); // no stimulation
    REFUSED(0x22, 0xE0, 0, 0, 0, 3, 0, 1, 0);
    GOOD(0xE0, 0x10, 0, 0, 2, 0, 1, 0);
    REFUSED(0x2A, 0xDE, 2, 0, 0); // 4 bytes of time and 4 are too many
    GOOD(0xE0, 0, 0, 0, 2, 0, 1, 0);
    GOOD(0xDE, 2, 0, 0);
    GOOD(0xDD, 1);
    sent_count = 0;
    for (int i = 0; i < 30; i++) {
        speed(0);
    }
    TEST_ASSERT_EQUAL_UINT(3, samples());
    GOOD(0xDE, 2, 0, 0);
    GOOD(0xDD, 2);
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&xcp.daq));
    GOOD(0xDD, 0);
    REFUSED(0x27, 0xDD, 3);
    REFUSED(0x27, 0xDE, 3, 0, 0);
    REFUSED(0x22, 0xDE, 1, 1, 0);
    GOOD(0xDC);
}

static void test_lists_are_made_in_order_and_within_their_memory(void)
{
    CONNECT();
    REFUSED(0x29, 0xD4, 0, 0, 0, 1);
    GOOD(0xD6);
    REFUSED(0x30, 0xD5, 0, (uint8_t)(SWAY_XCP_LISTS + 1U), 0);
    GOOD(0xD5, 0, 2, 0);
    REFUSED(0x29, 0xD5, 0, 2, 0);
    REFUSED(0x29, 0xD3, 0, 0, 0, 0, 1);
    REFUSED(0x22, 0xD4, 0, 2, 0, 1);
    REFUSED(0x30, 0xD4, 0, 0, 0, (uint8_t)(SWAY_XCP_ODTS + 1U));
    GOOD(0xD4, 0, 0, 0, 1);
    REFUSED(0x29, 0xD4, 0, 0, 0, 1);
    REFUSED(0x22, 0xD3, 0, 0, 0, 1, 1);
    REFUSED(0x30, 0xD3, 0, 0, 0, 0, (uint8_t)(SWAY_XCP_ENTRIES + 1U));
    GOOD(0xD3, 0, 0, 0, 0, 2);
    REFUSED(0x29, 0xD3, 0, 0, 0, 0, 2);
    REFUSED(0x29, 0xD4, 0, 1, 0, 1);
    REFUSED(0x29, 0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT)); // no pointer yet
    REFUSED(0x22, 0xE2, 0, 0, 0, 0, 2);
    REFUSED(0x22, 0xE2, 0, 1, 0, 0, 0);
    GOOD(0xE2, 0, 0, 0, 0, 1);
    REFUSED(0x22, 0xE1, 3, 1, 0, ADDRESS(ECU_AT)); // single bits
    REFUSED(0x24, 0xE1, 0xFF, 4, 0, ADDRESS(0U));
    GOOD(0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT));
    REFUSED(0x29, 0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT));
    GOOD(0xE0, 0, 0, 0, 1, 0, 1, 0);
    REFUSED(0x2A, 0xDE, 1, 0, 0); // entry 0 was never written
    REFUSED(0x22, 0xE3, 0, 9, 0);
    GOOD(0xE3, 0, 0, 0);
    REFUSED(0x22, 0xDF, 0, 9, 0);
    REFUSED(0x22, 0xD7, 0, 3, 0);
}

static void test_samples_without_room_are_left_out_whole_and_reported(void)
{
    CONNECT();
    allocate();
    GOOD(0xE0, 0, 0, 0, 1, 0, 1, 0);
    GOOD(0xDE, 1, 0, 0);
    no_room = true;
    for (unsigned i = 0; i < SWAY_XCP_QUEUE + 10U; i++) {
        speed(0);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(10, xcp.daq.left_out);
    no_room = false;
    sent_count = 0;
    speed(0);
    speed(0);
    bool is_reported = false;
    for (unsigned i = 0; i < sent_count; i++) {
        is_reported |= sent[i].id == REPLY && sent[i].data[0] == 0xFD && sent[i].data[1] == 0x06;
    }
    TEST_ASSERT_TRUE(is_reported);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT(SWAY_XCP_QUEUE, samples());
    GOOD(0xFE); // ends it
    sent_count = 0;
    speed(0);
    TEST_ASSERT_EQUAL_UINT(0, samples());
}

/* --- by themselves ---------------------------------------------------------------------------- */

static sway_xcp_daq_t daq;
static const uint8_t bytes[] = {10, 11, 12, 13, 14, 15, 16, 17, 18, 19};

static void expect_packet(unsigned size, const uint8_t *expected)
{
    const sway_xcp_packet_t *const packet = sway_xcp_daq_next(&daq);
    TEST_ASSERT_NOT_NULL(packet);
    TEST_ASSERT_EQUAL_UINT8(size, packet->size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, packet->data, size);
    sway_xcp_daq_sent(&daq);
}

#define PACKET(...) expect_packet(sizeof((uint8_t[]){__VA_ARGS__}), (const uint8_t[]){__VA_ARGS__})
#define OK(call) TEST_ASSERT_EQUAL(SWAY_XCP_OK, call)

static void enter(uint32_t list, uint32_t odt, uint32_t entry, const uint8_t *from, uint32_t size)
{
    OK(sway_xcp_daq_point(&daq, list, odt, entry));
    OK(sway_xcp_daq_write(&daq, from, size));
}

static void sent_all(void)
{
    while (daq.queue_length > 0U) {
        sway_xcp_daq_sent(&daq);
    }
}

/* List 0: two ODTs, of two entries and one; list 1: one of two. */
static void two_lists(void)
{
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, 2));
    OK(sway_xcp_daq_odts(&daq, 0, 2));
    OK(sway_xcp_daq_odts(&daq, 1, 1));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 2));
    OK(sway_xcp_daq_entries(&daq, 0, 1, 1));
    OK(sway_xcp_daq_entries(&daq, 1, 0, 2));
    enter(0, 0, 0, bytes, 1);
    OK(sway_xcp_daq_write(&daq, bytes + 2, 2)); // the pointer goes on
    enter(0, 1, 0, bytes + 4, 3);
    enter(1, 0, 0, bytes + 7, 1);
    enter(1, 0, 1, bytes + 8, 2);
}

static void test_samples_hold_what_was_entered(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_mode(&daq, 1, SWAY_XCP_MODE_TIMESTAMP, 2, 1));
    OK(sway_xcp_daq_start(&daq, 1, 0));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    TEST_ASSERT_TRUE(sway_xcp_daq_is_running(&daq));
    sway_xcp_daq_sample(&daq, 0, 0x01020304);
    PACKET(0, 10, 12, 13);
    PACKET(1, 14, 15, 16);
    PACKET(2, 4, 3, 2, 1, 17, 18, 19);
    TEST_ASSERT_NULL(sway_xcp_daq_next(&daq));
    OK(sway_xcp_daq_start(&daq, 0, 0));
    TEST_ASSERT_TRUE(sway_xcp_daq_is_running(&daq)); // the second one
    OK(sway_xcp_daq_start(&daq, 0, 1));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq));
}

/* Every 10 ms, whatever the steps of the clock; anew after a pause and where it is set back. */
static void test_events_come_by_the_clock(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 1, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    static const int64_t times_us[][2] = {
        /* now, sampled */
        {5000, 1},  {9999, 0},   {10000, 1},  {14999, 0},  {18000, 0},  {26000, 1},
        {29999, 0}, {30000, 1},  {90000, 1},  {99999, 0},  {100000, 1}, {50000, 1},
        {59999, 0}, {60000, 1},  {60001, 0},  {70000, 1},  {89999, 1},  {90001, 1},
        {99999, 0}, {100000, 1}, {120000, 1}, {120001, 0}, {129999, 0}, {130000, 1}};
    for (unsigned i = 0; i < sizeof times_us / sizeof times_us[0]; i++) {
        sway_xcp_daq_sample(&daq, 0, times_us[i][0]);
        char text[20];
        (void)snprintf(text, sizeof text, "%d us", (int)times_us[i][0]);
        TEST_ASSERT_EQUAL_MESSAGE(times_us[i][1], daq.queue_length, text);
        sent_all();
    }
}

static void test_an_event_of_100_ms_and_a_list_that_is_stopped(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_mode(&daq, 1, 0, 2, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    for (int64_t i = 0; i < 100; i++) { // more events than a countdown has numbers
        for (int64_t part = 0; part < 10; part++) {
            sway_xcp_daq_sample(&daq, 0, i * 100000 + part * 10000);
            TEST_ASSERT_EQUAL_UINT32(part == 0, daq.queue_length);
            sent_all();
        }
    }
}

static void test_every_odt_of_a_list_is_asked(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    enter(0, 1, 0, bytes, 8);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0));
    enter(0, 1, 0, bytes, 7);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, 1));
    OK(sway_xcp_daq_odts(&daq, 0, 1));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 1));
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // nothing entered
}

static void test_an_estimate_is_an_event_when_it_is_new(void)
{
    static const uint32_t numbers[][2] = {{0, 0}, {1, 1}, {1, 0}, {2, 1}, {0, 0}, {1, 1}};
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 1, 0, SWAY_XCP_EVENT_ESTIMATE, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    for (unsigned i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        sway_xcp_daq_sample(&daq, numbers[i][0], 1000 * (int64_t)i);
        TEST_ASSERT_EQUAL_UINT32(numbers[i][1], daq.queue_length);
        sent_all();
    }
    daq.left_out = 7;
    sway_xcp_daq_free(&daq); // neither what was lost nor which estimate was the last is forgotten
    TEST_ASSERT_EQUAL_UINT32(7, daq.left_out);
    TEST_ASSERT_EQUAL_UINT32(1, daq.sequence);
}

/* Up to the last list, ODT, entry and byte, and not one more. */
static void test_all_of_the_memory_can_be_used(void)
{
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, SWAY_XCP_LISTS));
    OK(sway_xcp_daq_odts(&daq, 0, 3));
    TEST_ASSERT_EQUAL(SWAY_XCP_NO_MEMORY, sway_xcp_daq_odts(&daq, 1, SWAY_XCP_ODTS - 2U));
    OK(sway_xcp_daq_odts(&daq, 1, SWAY_XCP_ODTS - 3U));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 3));
    OK(sway_xcp_daq_entries(&daq, 0, 2, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_NO_MEMORY, sway_xcp_daq_entries(&daq, 1, 0, SWAY_XCP_ENTRIES - 3U));
    OK(sway_xcp_daq_entries(&daq, 1, 0, SWAY_XCP_ENTRIES - 4U));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_point(&daq, SWAY_XCP_LISTS, 0, 0));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_point(&daq, 0, 3, 0));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_mode(&daq, SWAY_XCP_LISTS, 0, 1, 1));
    enter(0, 2, 0, bytes, 7);
    enter(0, 0, 0, bytes, 3);
    enter(0, 0, 1, bytes, 2);
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // one is missing
    enter(0, 0, 2, bytes, 3);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // a byte too many
    enter(0, 0, 2, bytes, 2);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    sway_xcp_daq_sample(&daq, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(3, daq.queue_length);
    OK(sway_xcp_daq_synch(&daq, 0));
    two_lists();
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // no prescaler
}

static void test_the_queue_keeps_its_order_and_tells_what_it_lost(void)
{
    uint8_t number = 0;
    two_lists();
    enter(1, 0, 0, &number, 1);
    OK(sway_xcp_daq_mode(&daq, 1, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    int64_t now = 0;
    for (unsigned i = 0; i < 3U * SWAY_XCP_QUEUE; i++, now += 10000) {
        number = (uint8_t)i;
        sway_xcp_daq_sample(&daq, 0, now);
        if (i >= 5U) {
            PACKET(2, (uint8_t)(i - 5U), 18, 19);
        }
    }
    for (unsigned i = 0; i < SWAY_XCP_QUEUE - 5U; i++, now += 10000) {
        sway_xcp_daq_sample(&daq, 0, now);
    }
    TEST_ASSERT_EQUAL_UINT32(SWAY_XCP_QUEUE, daq.queue_length);
    TEST_ASSERT_EQUAL_UINT32(0, daq.left_out);
    sway_xcp_daq_sample(&daq, 0, now);
    TEST_ASSERT_EQUAL_UINT32(1, daq.left_out);
    OK(sway_xcp_daq_start(&daq, 0, 1));
    sway_xcp_daq_sent(&daq);
    sway_xcp_daq_sample(&daq, 0, now); // reported once
    TEST_ASSERT_EQUAL_UINT32(SWAY_XCP_QUEUE, daq.queue_length);
    sway_xcp_daq_sent(&daq);
    sway_xcp_daq_sample(&daq, 0, now);
    for (unsigned i = 0; i < SWAY_XCP_QUEUE - 2U; i++) {
        sway_xcp_daq_sent(&daq);
    }
    PACKET(0xFD, 0x06);
    TEST_ASSERT_NULL(sway_xcp_daq_next(&daq));
}

static void test_selected_lists_and_no_others_are_started_and_stopped(void)
{
    two_lists();
    for (uint32_t list = 0; list < 2U; list++) {
        OK(sway_xcp_daq_mode(&daq, list, 0, 1, 1));
    }
    OK(sway_xcp_daq_start(&daq, 2, 1));
    OK(sway_xcp_daq_synch(&daq, 1));
    TEST_ASSERT_FALSE((daq.list[0].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    TEST_ASSERT_TRUE((daq.list[1].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    OK(sway_xcp_daq_start(&daq, 2, 1));
    OK(sway_xcp_daq_synch(&daq, 2));
    TEST_ASSERT_TRUE((daq.list[0].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    TEST_ASSERT_FALSE((daq.list[1].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    OK(sway_xcp_daq_start(&daq, 1, 1));
    OK(sway_xcp_daq_synch(&daq, 0));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq));
}

/* Between the selection and the start an entry may grow: the sample would be longer than a frame.
 */
static void test_selected_lists_are_asked_again_when_they_start(void)
{
    two_lists();
    for (uint32_t list = 0; list < 2U; list++) {
        OK(sway_xcp_daq_mode(&daq, list, 0, 1, 1));
        OK(sway_xcp_daq_start(&daq, 2, list));
    }
    enter(1, 0, 0, bytes, 7);
    enter(1, 0, 1, bytes, 7);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_synch(&daq, 1));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq)); // not the other one either
    sway_xcp_daq_sample(&daq, 0, 0);
    TEST_ASSERT_NULL(sway_xcp_daq_next(&daq));
    OK(sway_xcp_daq_synch(&daq, 2)); // it need not be whole to be stopped
    enter(1, 0, 0, bytes, 1);
    enter(1, 0, 1, bytes, 6);
    OK(sway_xcp_daq_start(&daq, 2, 1));
    OK(sway_xcp_daq_synch(&daq, 1));
    sway_xcp_daq_sample(&daq, 0, 10000);
    PACKET(2, 10, 10, 11, 12, 13, 14, 15);
}

/* Nothing behind the last list is taken for one: there the first ODT lies, here with a first entry
 * whose bits would be those of a list that is selected and runs. */
static void test_there_is_no_list_behind_the_last(void)
{
    const uint8_t first = SWAY_XCP_MODE_RUNNING | SWAY_XCP_MODE_SELECTED;
    sway_xcp_odt_t before[SWAY_XCP_ODTS];
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, SWAY_XCP_LISTS));
    for (uint32_t list = 0; list < SWAY_XCP_LISTS; list++) {
        OK(sway_xcp_daq_odts(&daq, list, 1));
    }
    OK(sway_xcp_daq_entries(&daq, 1, 0, first));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 1));
    enter(0, 0, 0, bytes + 3, 1);
    TEST_ASSERT_EQUAL_HEX8(first, daq.odt_of[0].first);
    memcpy(before, daq.odt_of, sizeof before);
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 2, 0));
    OK(sway_xcp_daq_synch(&daq, 1));
    for (int64_t now = 0; now < 30000; now += 10000) {
        sway_xcp_daq_sample(&daq, 0, now);
        PACKET(0, 13);
    }
    OK(sway_xcp_daq_synch(&daq, 0));
    TEST_ASSERT_EQUAL_MEMORY(before, daq.odt_of, sizeof before);
}

/* One list; `entries` in its first frame. */
static void only_list(uint8_t odts, uint8_t entries)
{
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, 1));
    OK(sway_xcp_daq_odts(&daq, 0, odts));
    OK(sway_xcp_daq_entries(&daq, 0, 0, entries));
}

/* The only list, which is the first. */
static void test_the_first_list_is_asked_again_too(void)
{
    only_list(1, 2);
    enter(0, 0, 0, bytes, 1);
    enter(0, 0, 1, bytes, 6);
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 2, 0));
    enter(0, 0, 0, bytes, 7);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_synch(&daq, 1));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq));
}

/* A frame without entries is sent by its number alone; it gets none while its list runs. */
static void test_a_list_that_runs_gets_no_entries(void)
{
    only_list(2, 1);
    enter(0, 0, 0, bytes, 2);
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 1, 0));
    TEST_ASSERT_EQUAL(SWAY_XCP_BUSY_DAQ, sway_xcp_daq_entries(&daq, 0, 1, 1));
    sway_xcp_daq_sample(&daq, 0, 0);
    PACKET(0, 10, 11);
    expect_packet(1, (const uint8_t[]){1});
    OK(sway_xcp_daq_start(&daq, 0, 0));
    OK(sway_xcp_daq_entries(&daq, 0, 1, 1));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_list_is_sampled_every_10_ms);
    RUN_TEST(test_selected_lists_start_together_with_time_stamps);
    RUN_TEST(test_lists_are_made_in_order_and_within_their_memory);
    RUN_TEST(test_samples_without_room_are_left_out_whole_and_reported);
    RUN_TEST(test_samples_hold_what_was_entered);
    RUN_TEST(test_events_come_by_the_clock);
    RUN_TEST(test_an_event_of_100_ms_and_a_list_that_is_stopped);
    RUN_TEST(test_every_odt_of_a_list_is_asked);
    RUN_TEST(test_an_estimate_is_an_event_when_it_is_new);
    RUN_TEST(test_all_of_the_memory_can_be_used);
    RUN_TEST(test_the_queue_keeps_its_order_and_tells_what_it_lost);
    RUN_TEST(test_selected_lists_and_no_others_are_started_and_stopped);
    RUN_TEST(test_selected_lists_are_asked_again_when_they_start);
    RUN_TEST(test_there_is_no_list_behind_the_last);
    RUN_TEST(test_the_first_list_is_asked_again_too);
    RUN_TEST(test_a_list_that_runs_gets_no_entries);
    return UNITY_END();
}

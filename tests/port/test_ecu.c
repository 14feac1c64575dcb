/* The ECU's loop: faults, restarts, the safe state, checks of memory and image, reports. */
#include "ecu_bench.h"

/* --- faults ----------------------------------------------------------------------------------- */

static void test_fault_is_reported_after_the_restart(void)
{
    start_good();
    sway_ecu_note_fault(&retained, 4, 0x1234);
    start();
    const struct swaywatch_dbc_sway_fault_report_t reported = report();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RUNNING, reported.ecu_state);
    TEST_ASSERT_EQUAL_UINT8(4, reported.fault_cause);
    TEST_ASSERT_EQUAL_HEX32(0x1234, reported.fault_address);
    TEST_ASSERT_EQUAL_UINT8(1, reported.fault_restarts);
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

static void test_warning_is_reported_while_running(void)
{
    start_good();
    sway_ecu_warn(&ecu, SWAY_ECU_BUS_OFF);
    const struct swaywatch_dbc_sway_fault_report_t reported = report();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BUS_OFF, reported.fault_cause);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RUNNING, reported.ecu_state);
}

/* Somebody else sends a message, 0.4 ms before its owner, with the counter that is due: his values
 * are used, the owner's are the repeated ones. That is reported within a second or two. */
static void test_a_second_sender_is_reported(void)
{
    start_good();
    (void)report();
    unsigned reported = 0;
    for (unsigned i = 0; i < 500U; i++) {
        sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
        sway_e2e_protect(frame.id, (uint8_t)(i % 16U), frame.data);
        now_us += 8600;
        sent_count = 0U;
        give(frame);
        frame.data[2] = 1;
        sway_e2e_protect(frame.id, (uint8_t)(i % 16U), frame.data);
        now_us -= 600;
        give(frame);
        const sway_port_frame_t *said = last_of(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID);
        reported += said != NULL && report_of(said).fault_cause == SWAY_ECU_DOUBLED;
    }
    TEST_ASSERT_TRUE(reported >= 3U);
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
        sway_e2e_protect(frame.id, i % 16U, frame.data);
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

/* --- what else is promised ----------------------------------------------------------------------
 */

/* A single flipped bit of what is kept over a restart is noticed, and nothing of it believed. */
static void test_a_flipped_bit_of_what_is_kept_is_noticed(void)
{
    start_good();
    for (unsigned i = 0; i < SWAY_ECU_RESTARTS_MAX; i++) {
        sway_ecu_note_fault(&retained, 3, 0xA5A55A5AU);
    }
    TEST_ASSERT_TRUE(sway_ecu_gave_up(&retained));
    for (unsigned bit = 0; bit < 8U * sizeof retained; bit++) {
        sway_ecu_retained_t flipped = retained;
        ((uint8_t *)&flipped)[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_FALSE(sway_ecu_gave_up(&flipped));
        sway_ecu_note_fault(&flipped, 3, 0);
        TEST_ASSERT_EQUAL_UINT32(1, flipped.restarts);
    }
}

/* On a bus with nobody else: heartbeats of the node, reports, each with the time of its sending. */
static void test_a_running_ecu_says_what_its_node_says(void)
{
    start_good();
    unsigned alarms = 0;
    unsigned reports = 0;
    unsigned calls = 0;
    while (sway_ecu_poll(&ecu)) { // what is due at the start
    }
    for (int i = 0; i < 1000; i++) {
        now_us += 1000;
        sent_count = 0U;
        while (sway_ecu_poll(&ecu)) {
            calls++;
        }
        for (unsigned k = 0; k < sent_count; k++) {
            TEST_ASSERT_EQUAL_UINT8(8, sent[k].dlc);
            TEST_ASSERT_TRUE(sway_e2e_check(sent[k].id, sent[k].data));
            TEST_ASSERT_EQUAL_INT64(now_us, sent[k].time_us);
            alarms += sent[k].id == SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID;
            reports += sent[k].id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID;
        }
        TEST_ASSERT_TRUE(i >= 99 || ecu.now_us == 0); // frames might still come with their times
    }
    TEST_ASSERT_EQUAL_UINT(10, alarms);
    TEST_ASSERT_EQUAL_UINT(1, reports);
    TEST_ASSERT_TRUE(calls >= alarms + reports);
}

/* As long as frames come, time is theirs. */
static void test_time_is_that_of_the_frames(void)
{
    start_good();
    for (int i = 0; i < 100; i++) {
        sway_port_frame_t frame = {.id = 0x121, .dlc = 8, .time_us = 10000 * (int64_t)i};
        sway_e2e_protect(frame.id, (uint8_t)(i % 16), frame.data);
        now_us = frame.time_us + 50000; // by the ECU's clock it comes late
        inbox[inbox_count++ % QUEUE] = frame;
        TEST_ASSERT_TRUE(sway_ecu_poll(&ecu) || sway_ecu_poll(&ecu));
        while (sway_ecu_poll(&ecu)) {
        }
        TEST_ASSERT_EQUAL_INT64(frame.time_us, ecu.now_us);
    }
    TEST_ASSERT_EQUAL_UINT32(100, ecu.node.accepted);
}

/* Its first report is of its start, whatever the clock says then. */
static void test_an_ecu_may_start_at_any_time(void)
{
    static const int64_t starts_us[] = {-5000000, 0, 5000000};
    for (int i = 0; i < 3; i++) {
        setUp();
        now_us = starts_us[i];
        start_good();
        while (sway_ecu_poll(&ecu)) {
        }
        TEST_ASSERT_EQUAL_INT64(starts_us[i], ecu.now_us);
        const sway_port_frame_t *reported = last_of(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID);
        TEST_ASSERT_NOT_NULL(reported);
        TEST_ASSERT_EQUAL_INT64(starts_us[i], reported->time_us);
        now_us += 99999;
        while (sway_ecu_poll(&ecu)) {
        }
        TEST_ASSERT_EQUAL_INT64(starts_us[i], ecu.now_us);
        now_us += 1;
        while (sway_ecu_poll(&ecu)) {
        }
        TEST_ASSERT_EQUAL_INT64(starts_us[i] + 100000, ecu.now_us);
    }
}

static void test_faults_and_warnings_are_reported_at_once(void)
{
    for (int fails = 0; fails < 2; fails++) {
        setUp();
        start_good();
        (void)report();
        sent_count = 0U;
        if (fails) {
            sway_ecu_fail(&ecu, SWAY_ECU_MEMORY);
        } else {
            sway_ecu_warn(&ecu, SWAY_ECU_BUS_OFF);
        }
        while (sway_ecu_poll(&ecu)) {
        }
        const sway_port_frame_t *reported = last_of(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID);
        TEST_ASSERT_NOT_NULL(reported);
        TEST_ASSERT_EQUAL_UINT8(fails ? SWAY_ECU_MEMORY : SWAY_ECU_BUS_OFF,
                                report_of(reported).fault_cause);
    }
}

/* What had to wait for room goes out as it was, counted once. */
static void test_what_waits_goes_out_unchanged(void)
{
    start_good();
    (void)report();
    no_room = true;
    give(request_frame(READ, 0, 0));
    const uint32_t before = ecu.frames_sent;
    no_room = false;
    sent_count = 0U;
    for (int i = 0; i < 10; i++) {
        (void)sway_ecu_poll(&ecu);
    }
    TEST_ASSERT_TRUE(sent_count >= 1U);
    TEST_ASSERT_EQUAL_UINT32(before + sent_count, ecu.frames_sent);
    for (unsigned i = 0; i < sent_count; i++) {
        TEST_ASSERT_TRUE(sway_e2e_check(sent[i].id, sent[i].data));
    }
    TEST_ASSERT_EQUAL_INT32(
        1955000,
        reply_of(last_of(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID)).parameter_reply_value);
}

/* Ten repeated frames in a second are a second sender, nine are not; new values begin anew. */
static void test_ten_repetitions_in_a_second_are_a_second_sender(void)
{
    for (uint32_t count = 9; count <= 10U; count++) {
        start_good();
        (void)report();
        ecu.node.frame_fault[SWAY_FRAME_FAULT_REPEATED] += count;
        TEST_ASSERT_EQUAL_UINT8(count == 10U ? SWAY_ECU_DOUBLED : 0, report().fault_cause);
        drive();
        const sway_core_config_t config = good_config();
        TEST_ASSERT_EQUAL(SWAY_ECU_CHANGED, sway_ecu_calibrate(&ecu, &config));
        TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
    }
}

#if SWAY_MAP
static unsigned listened;

static void listen(void *context, sway_node_t *node, const sway_port_frame_t *frame)
{
    TEST_ASSERT_EQUAL_PTR(&listened, context);
    TEST_ASSERT_EQUAL_PTR(&ecu.node, node);
    listened += frame->id == 0x345U;
}

static void test_who_listens_gets_every_frame(void)
{
    start_good();
    listened = 0;
    sway_ecu_listen(&ecu, listen, &listened);
    const sway_port_frame_t frame = {.id = 0x345, .dlc = 4};
    give(frame);
    give(frame);
    TEST_ASSERT_EQUAL_UINT(2, listened);
}
#endif

/* One frame in or one out, and true; nothing, and false, once there is nothing to do. What is to be
 * sent goes first: no reply is lost to the next request. */
static void test_a_poll_does_one_thing_and_says_so(void)
{
    unsigned idle = 0;
    start_good();
    for (unsigned round = 0; round < 300U; round++) {
        now_us += 10000;
        for (unsigned i = 0; i < 2U; i++) {
            sway_port_frame_t frame = request_frame(i == 0U ? READ : APPLY, 0, 0);
            frame.time_us = now_us;
            inbox[inbox_count++ % QUEUE] = frame;
        }
        unsigned replies = 0;
        for (bool busy = true; busy;) {
            const unsigned in = inbox_at;
            const unsigned out = sent_count;
            busy = sway_ecu_poll(&ecu);
            const unsigned done = inbox_at - in + sent_count - out;
            TEST_ASSERT_TRUE(done <= (busy ? 1U : 0U));
            replies +=
                sent_count > out && sent[out].id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID;
            idle += busy ? 0U : 1U;
        }
        TEST_ASSERT_EQUAL_UINT(2, replies);
    }
    TEST_ASSERT_EQUAL_UINT(300, idle);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_fault_is_reported_after_the_restart);
    RUN_TEST(test_endless_restarts_end_safe);
    RUN_TEST(test_retained_memory_after_power_on_is_not_believed);
    RUN_TEST(test_warning_is_reported_while_running);
    RUN_TEST(test_a_poll_does_one_thing_and_says_so);
    RUN_TEST(test_a_second_sender_is_reported);
    RUN_TEST(test_overwritten_state_lets_the_watchdog_bite);
    RUN_TEST(test_safe_state_sends_nothing_but_reports);
    RUN_TEST(test_receiving_goes_on_while_sending_is_refused);
    RUN_TEST(test_nothing_is_lost_when_the_bus_has_no_room);
    RUN_TEST(test_null_arguments_are_refused);
    RUN_TEST(test_memory_check_puts_everything_back);
    RUN_TEST(test_image_check_finds_every_flipped_bit);
    RUN_TEST(test_self_test_passes);
    RUN_TEST(test_frames_and_refusals_are_counted);
    RUN_TEST(test_reports_come_when_they_are_due);
    RUN_TEST(test_a_flipped_bit_of_what_is_kept_is_noticed);
    RUN_TEST(test_a_running_ecu_says_what_its_node_says);
    RUN_TEST(test_time_is_that_of_the_frames);
    RUN_TEST(test_an_ecu_may_start_at_any_time);
    RUN_TEST(test_faults_and_warnings_are_reported_at_once);
    RUN_TEST(test_what_waits_goes_out_unchanged);
    RUN_TEST(test_ten_repetitions_in_a_second_are_a_second_sender);
    RUN_TEST(test_who_listens_gets_every_frame);
    return UNITY_END();
}

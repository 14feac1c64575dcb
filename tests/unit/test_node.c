/* The node: frames in, status frames out, and every fault of the bus counted once. */
#include "node_test.h"

static uint32_t skip(sway_message_t m, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        counter[m] = sway_e2e_next(counter[m]);
    }
    return n;
}

static void units_are_exact(void)
{
    static const struct {
        sway_message_t message;
        int16_t raw[2];
        int32_t value[2];
    } cases[] = {{SWAY_MESSAGE_STEERING, {1800, 0}, {3141593, 0}},
                 {SWAY_MESSAGE_STEERING, {-7200, 0}, {-12566371, 0}},
                 {SWAY_MESSAGE_SPEED, {10000, 0}, {27778, 0}},
                 {SWAY_MESSAGE_SPEED, {(int16_t)40000, 0}, {111111, 0}},
                 {SWAY_MESSAGE_CAR_MOTION, {18000, -20000}, {3141593, -40000000}},
                 {SWAY_MESSAGE_TRAILER_MOTION, {-1, 1}, {-175, 2000}},
                 {SWAY_MESSAGE_ARTICULATION, {-9000, 0}, {-1570796, 0}},
                 {SWAY_MESSAGE_HITCH_FORCES, {-30000, 7}, {-30000000, 7000}},
                 {SWAY_MESSAGE_CAR_WHEEL_FL, {-1, 30000}, {-1000, 30000000}},
                 {SWAY_MESSAGE_TRAILER_WHEEL_RR, {5, (int16_t)50000}, {5000, 50000000}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint8_t data[8];
        sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
        fill(data, cases[i].raw[0], cases[i].raw[1]);
        const uint32_t n = sway_frames_decode(cases[i].message, data, samples);
        for (uint32_t k = 0; k < n; k++) {
            TEST_ASSERT_EQUAL_INT32(cases[i].value[k], samples[k].value);
            TEST_ASSERT_TRUE(samples[k].valid);
        }
    }
}

static void every_input_is_in_exactly_one_message(void)
{
    int seen[SWAY_INPUT_COUNT] = {0};
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        uint8_t data[8] = {0};
        sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
        const uint32_t n = sway_frames_decode((sway_message_t)m, data, samples);
        for (uint32_t k = 0; k < n; k++) {
            seen[samples[k].input]++;
        }
        TEST_ASSERT_EQUAL(m, sway_frames_find(sway_frames_input_id((sway_message_t)m)));
    }
    for (int i = 0; i < SWAY_INPUT_COUNT; i++) {
        TEST_ASSERT_EQUAL_MESSAGE(1, seen[i], "input");
    }
}

static void lost_frames_are_counted_over_turns_of_the_counter(void)
{
    uint32_t lost = 0;
    int64_t t = 0;
    for (int i = 0; i < 20; i++, t += 1000) {
        TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)i, 0));
    }
    for (uint32_t burst = 1; burst < 900; burst += 1 + burst / 10) {
        if (burst % 16 == 0) {
            continue; /* looks like a pause */
        }
        lost += skip(SWAY_MESSAGE_CAR_MOTION, burst);
        t += (int64_t)burst * 1000;
        for (int i = 0; i < 3; i++, t += 1000) {
            const int16_t value = (int16_t)(t % 999);
            TEST_ASSERT_NOT_EQUAL(SWAY_ERROR_FRAME, send(SWAY_MESSAGE_CAR_MOTION, t, value, 0));
        }
        TEST_ASSERT_EQUAL(lost, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LATE));
}

static void jitter_of_half_a_turn_does_not_confuse(void)
{
    int64_t t = 0;
    uint32_t noise = 1;
    for (int i = 0; i < 2000; i++, t += 10000) {
        noise = noise * 1664525U + 1013904223U;
        const int64_t late = (noise >> 16) % 9000U;
        TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_SPEED, t + late, 9000, 0));
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void first_frames_in_one_burst_do_not_confuse(void)
{
    int64_t t = 0;
    for (int i = 0; i < 6; i++, t += 50) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
    }
    for (int i = 0; i < 100; i++, t += 10000) {
        TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_SPEED, t, 9000, 0));
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void slow_sender_loses_nothing(void)
{
    for (int64_t t = 0; t < 20000000; t += 95000) {
        TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_SPEED, t, 9000, 0));
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void sender_that_pauses_and_catches_up_loses_nothing(void)
{
    int64_t t = 0;
    for (int i = 0; i < 1000; i++) {
        t += i % 50 == 0 ? 400000 : (i % 50 < 40 ? 100 : 10000);
        TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_SPEED, t, 9000, 0));
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void sender_with_another_period_is_learned_anew(void)
{
    int64_t t = 0;
    for (int i = 0; i < 100; i++, t += 1000) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
    }
    for (int i = 0; i < 200; i++, t += 20000) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
    t += 20000 * skip(SWAY_MESSAGE_SPEED, 40);
    send(SWAY_MESSAGE_SPEED, t, 9000, 0);
    TEST_ASSERT_EQUAL(40, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void doubled_and_reordered_frames_are_dropped_and_counted(void)
{
    int64_t t = 0;
    uint8_t a[8], b[8];
    for (int i = 0; i < 10; i++, t += 10000) {
        send(SWAY_MESSAGE_STEERING, t, 0, 0);
    }
    fill(a, 1, 0);
    sway_e2e_protect(0x120, 10, a);
    fill(b, 2, 0);
    sway_e2e_protect(0x120, 11, b);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_receive(&node, t, 0x120, 8, b)); /* lost: a */
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, sway_node_receive(&node, t + 100, 0x120, 8, a)); /* late */
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, sway_node_receive(&node, t + 200, 0x120, 8, b)); /* twice */
    counter[SWAY_MESSAGE_STEERING] = 12;
    TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_STEERING, t + 10000, 0, 0));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_LATE));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_STUCK));
}

static void reordering_from_the_first_frame_on_is_understood(void)
{
    for (int i = 0; i < 50; i++) {
        uint8_t a[8], b[8];
        fill(a, 1, 0);
        sway_e2e_protect(0x120, (uint8_t)((2 * i) % 16), a);
        fill(b, 2, 0);
        sway_e2e_protect(0x120, (uint8_t)((2 * i + 1) % 16), b);
        sway_node_receive(&node, 20000 * i, 0x120, 8, b);
        sway_node_receive(&node, 20000 * i + 100, 0x120, 8, a);
    }
    TEST_ASSERT_EQUAL(50, sway_node_fault(&node, SWAY_FRAME_FAULT_LATE));
    TEST_ASSERT_EQUAL(49, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

static void stuck_counter_is_reported_and_recovers_at_once(void)
{
    int64_t t = 0;
    for (int i = 0; i < 10; i++, t += 10000) {
        send(SWAY_MESSAGE_STEERING, t, 0, 0);
    }
    const uint8_t stuck = counter[SWAY_MESSAGE_STEERING];
    for (int i = 0; i < 50; i++, t += 10000) {
        counter[SWAY_MESSAGE_STEERING] = stuck;
        const sway_error_t error = send(SWAY_MESSAGE_STEERING, t, (int16_t)i, 0);
        TEST_ASSERT_EQUAL(i == 0 ? SWAY_OK : SWAY_ERROR_FRAME, error);
    }
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_STUCK, sway_node_message_state(&node, SWAY_MESSAGE_STEERING));
    TEST_ASSERT_EQUAL(49, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_STUCK));
    TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_STEERING, t, 0, 0));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_STEERING));
}

static void restarted_sender_is_believed_within_seven_frames(void)
{
    for (uint8_t restart = 0; restart <= SWAY_E2E_COUNTER_MAX; restart++) {
        setUp();
        int64_t t = 0;
        for (int i = 0; i < 18; i++, t += 10000) {
            send(SWAY_MESSAGE_STEERING, t, 0, 0);
        }
        counter[SWAY_MESSAGE_STEERING] = restart;
        int refused = 0;
        while (send(SWAY_MESSAGE_STEERING, t, 0, 0) != SWAY_OK) {
            refused++;
            t += 10000;
        }
        TEST_ASSERT_LESS_THAN(8, refused);
    }
}

static void length_crc_and_identifier_are_counted(void)
{
    uint8_t data[8];
    fill(data, 0, 0);
    sway_e2e_protect(0x120, 0, data);
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, sway_node_receive(&node, 0, 0x120, 7, data));
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, sway_node_receive(&node, 0, 0x120, 0, data));
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, sway_node_receive(&node, 0, 0x121, 8, data));
    TEST_ASSERT_EQUAL(SWAY_ERROR_UNKNOWN_ID, sway_node_receive(&node, 0, 0x7FF, 8, data));
    TEST_ASSERT_EQUAL(SWAY_ERROR_UNKNOWN_ID, sway_node_receive(&node, 0, 0x80000120U, 8, data));
    TEST_ASSERT_EQUAL(2, sway_node_fault(&node, SWAY_FRAME_FAULT_LENGTH));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_CRC));
    TEST_ASSERT_EQUAL(2, sway_node_fault(&node, SWAY_FRAME_FAULT_UNKNOWN));
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_receive(&node, 0, 0x120, 8, data));
}

static void invalid_samples_are_reported(void)
{
    uint8_t data[8];
    fill(data, 100, 0);
    data[1] = 1U << 4; /* not available */
    sway_e2e_protect(0x121, 0, data);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_receive(&node, 0, 0x121, 8, data));
    const sway_status_t *s = sway_core_status(&node.core);
    TEST_ASSERT_EQUAL(1, s->fault_count[SWAY_FAULT_INVALID]);
}

static void samples_out_of_range_are_reported(void)
{
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SWAY_MESSAGE_STEERING, 0, 30000, 0));
    TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_STEERING, 10000, 0, 0));
    TEST_ASSERT_EQUAL(1, sway_core_status(&node.core)->fault_count[SWAY_FAULT_RANGE]);
}

static void good_messages_time_out_and_come_back(void)
{
    int64_t t = 0;
    for (int i = 0; i < 20; i++, t += 10000) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
        send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)i, (int16_t)i);
        send(SWAY_MESSAGE_TRAILER_MOTION, t, (int16_t)i, (int16_t)i);
    }
    TEST_ASSERT_FALSE(sway_node_inputs_lost(&node));
    for (int i = 0; i < 12; i++, t += 10000) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
        send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)i, (int16_t)i);
    }
    TEST_ASSERT_TRUE(sway_node_inputs_lost(&node));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_TIMED_OUT,
                      sway_node_message_state(&node, SWAY_MESSAGE_TRAILER_MOTION));
    uint8_t data[8];
    TEST_ASSERT_GREATER_THAN(0, drain(0x1A0, data));
    TEST_ASSERT_EQUAL(2, data[4] & 2); /* InputsLost */
    for (int i = 0; i < 12; i++, t += 10000) {
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
    }
    TEST_ASSERT_GREATER_THAN(0, drain(0x1A0, data));
    TEST_ASSERT_EQUAL(0, data[2] & 7); /* off: no motion is left */
    send(SWAY_MESSAGE_CAR_MOTION, t, 0, 0);
    send(SWAY_MESSAGE_TRAILER_MOTION, t, 0, 0);
    TEST_ASSERT_FALSE(sway_node_inputs_lost(&node));
    TEST_ASSERT_GREATER_THAN(0, drain(0x1A0, data));
    TEST_ASSERT_EQUAL(0, data[4] & 2);
}

static void silence_of_the_whole_bus_is_reported_by_time_alone(void)
{
    uint8_t data[8];
    send(SWAY_MESSAGE_SPEED, 0, 9000, 0);
    drain(0, data);
    sway_node_time(&node, 99999);
    TEST_ASSERT_EQUAL(0, drain(0x1A0, data));
    sway_node_time(&node, 100001);
    TEST_ASSERT_EQUAL(1, drain(0x1A0, data));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
    sway_node_time(&node, 5);
    TEST_ASSERT_EQUAL(0, drain(0x1A0, data));
}

static void frozen_sensor_is_found_only_while_the_car_moves(void)
{
    int64_t t = 0;
    for (int i = 0; i < 300; i++, t += 10000) { /* standing still: nothing is frozen */
        send(SWAY_MESSAGE_CAR_MOTION, t, 0, 0);
        send(SWAY_MESSAGE_TRAILER_MOTION, t, 0, 0);
    }
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_FROZEN));
    for (int i = 0; i < 300; i++, t += 10000) { /* the trailer swings, its accelerometer is dead */
        const int16_t yaw = (int16_t)((i % 100 < 50 ? i % 50 : 50 - i % 50) * 40);
        send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)(yaw / 2), (int16_t)(yaw / 3));
        send(SWAY_MESSAGE_TRAILER_MOTION, t, yaw, 0);
    }
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_FROZEN));
    TEST_ASSERT_TRUE(node.watch[SWAY_INPUT_TRAILER_LATERAL_ACC].frozen);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_STUCK,
                      sway_node_message_state(&node, SWAY_MESSAGE_TRAILER_MOTION));
    send(SWAY_MESSAGE_TRAILER_MOTION, t, 0, 1);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD,
                      sway_node_message_state(&node, SWAY_MESSAGE_TRAILER_MOTION));
}

static void heartbeat_and_reports_come_by_bus_time(void)
{
    int alarms = 0;
    int reports = 0;
    for (int64_t t = 0; t < 10000000; t += 10000) {
        uint32_t id;
        uint8_t dlc;
        uint8_t data[8];
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
        while (sway_node_transmit(&node, &id, &dlc, data)) {
            alarms += id == 0x1A0;
            reports += id == 0x1B6;
        }
    }
    TEST_ASSERT_GREATER_OR_EQUAL(100, alarms);
    TEST_ASSERT_EQUAL(10, reports);
}

static void fault_counters_saturate(void)
{
    uint8_t data[8] = {0};
    node.frame_fault[SWAY_FRAME_FAULT_UNKNOWN] = UINT32_MAX;
    sway_node_receive(&node, 0, 0x7FF, 8, data);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, sway_node_fault(&node, SWAY_FRAME_FAULT_UNKNOWN));
    node.frame_fault[SWAY_FRAME_FAULT_CRC] = 70000;
    const sway_frames_source_t source = {.status = sway_core_status(&node.core),
                                         .message_state = node.message_state,
                                         .frame_fault = node.frame_fault,
                                         .inputs_lost = false};
    sway_frames_encode(SWAY_OUTPUT_FAULTS_FRAMES, &source, data);
    TEST_ASSERT_EQUAL_HEX8(0xFF, data[2]);
    TEST_ASSERT_EQUAL_HEX8(0xFF, data[3]);
}

static void null_arguments_are_refused(void)
{
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_node_init(NULL, config()));
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_node_init(&node, NULL));
}

/* --- what is sent, and when --------------------------------------------------------------------
 */

#define ESTIMATE_FRAMES 0xE0FFFFFU /* 0x1A0 to 0x1B3, 0x1B9 to 0x1BB */
#define REPORT_FRAMES 0x1F00000U   /* 0x1B4 to 0x1B8 */
#define ALARM_FRAME 1U
#define INPUTS_FRAME (1U << 24)

static void nothing_is_due_before_anything_was_heard(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, due());
    TEST_ASSERT_FALSE(sway_node_run(&node));
    TEST_ASSERT_TRUE(sway_node_inputs_lost(&node));
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_NEVER, sway_node_message_state(&node, (sway_message_t)m));
    }
}

/* Every 100 ms the alarm, every second the reports, from the first time that is heard of. */
static void the_heart_beats_every_100_ms_and_reports_every_tenth_time(void)
{
    const int64_t start = 7092345;
    int beat = 1;
    for (int64_t t = start; t < start + 3500000; t += 20000) {
        sway_node_time(&node, t);
        const bool is_beat = (t - start) % 100000 == 0;
        const uint32_t report = is_beat && beat % 10 == 0 ? REPORT_FRAMES : 0U;
        TEST_ASSERT_EQUAL_HEX32(is_beat ? ALARM_FRAME | report : 0U, due());
        beat += is_beat;
    }
}

static void beats_that_were_missed_are_not_made_up_for(void)
{
    sway_node_time(&node, 0);
    TEST_ASSERT_EQUAL_HEX32(ALARM_FRAME, due());
    sway_node_time(&node, 99999);
    TEST_ASSERT_EQUAL_HEX32(0, due());
    sway_node_time(&node, 1234567);
    TEST_ASSERT_EQUAL_HEX32(ALARM_FRAME, due());
    sway_node_time(&node, 1299999);
    TEST_ASSERT_EQUAL_HEX32(0, due());
    sway_node_time(&node, 1300000);
    TEST_ASSERT_EQUAL_HEX32(ALARM_FRAME, due());
    sway_node_time(&node, 1000000); /* before the newest time: ignored */
    TEST_ASSERT_EQUAL_HEX32(0, due());
    sway_node_time(&node, 1399999);
    TEST_ASSERT_EQUAL_HEX32(0, due());
    sway_node_time(&node, 1400000);
    TEST_ASSERT_EQUAL_HEX32(ALARM_FRAME, due());
}

/* 12 s of a swinging combination at 90 km/h; counts how often each set of frames was sent. */
static int swing(uint32_t *estimates)
{
    int wrong = 0;
    *estimates = 0;
    uint32_t sequence = 0;
    for (int i = 0; i < 1200; i++) {
        const int64_t t = i * INT64_C(10000);
        const int phase = i % 130 < 65 ? i % 65 - 32 : 32 - i % 65; /* 0.77 Hz */
        send(SWAY_MESSAGE_SPEED, t, 9000, 0);
        send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)(8 * phase), (int16_t)(9 * phase));
        send(SWAY_MESSAGE_TRAILER_MOTION, t, (int16_t)(-30 * phase), (int16_t)(-20 * phase));
        const uint32_t sent = due();
        const uint32_t now = sway_core_status(&node.core)->sequence;
        wrong += now != sequence ? (sent & ESTIMATE_FRAMES) != ESTIMATE_FRAMES
                                 : (sent & ESTIMATE_FRAMES & ~ALARM_FRAME) != 0;
        *estimates += now != sequence;
        sequence = now;
    }
    return wrong;
}

static void every_estimate_is_sent_at_once_and_once(void)
{
    uint32_t estimates;
    slices = 0;
    TEST_ASSERT_EQUAL(0, swing(&estimates));
    TEST_ASSERT_GREATER_THAN_UINT32(20, estimates);
    TEST_ASSERT_GREATER_THAN_UINT32(estimates, slices); /* an estimate is several */
    TEST_ASSERT_EQUAL_UINT32(estimates, sway_core_status(&node.core)->sequence);
}

/* What a port leaves undone is done when the next frame comes: the same statuses. */
static void work_that_was_left_is_done_with_the_next_frame(void)
{
    uint32_t estimates;
    swing(&estimates);
    static sway_status_t before;
    before = *sway_core_status(&node.core);
    TEST_ASSERT_NOT_EQUAL(0, estimates);
    setUp();
    for (int i = 0; i < 1200; i++) {
        const int64_t t = i * INT64_C(10000);
        const int phase = i % 130 < 65 ? i % 65 - 32 : 32 - i % 65;
        const int16_t values[3][2] = {{9000, 0},
                                      {(int16_t)(8 * phase), (int16_t)(9 * phase)},
                                      {(int16_t)(-30 * phase), (int16_t)(-20 * phase)}};
        for (int m = 0; m < 3; m++) {
            uint8_t data[8];
            fill(data, values[m][0], values[m][1]);
            sway_e2e_protect(0x121U + (uint32_t)m, (uint8_t)(i % 16), data);
            sway_node_receive(&node, t, 0x121U + (uint32_t)m, 8, data);
        }
    }
    sway_node_time(&node, 0); /* only what is left */
    TEST_ASSERT_EQUAL_MEMORY(&before, sway_core_status(&node.core), sizeof before);
}

static void the_alarm_is_sent_when_it_changes(void)
{
    send(SWAY_MESSAGE_SPEED, 0, 9000, 0);
    due();
    send(SWAY_MESSAGE_CAR_MOTION, 1000, 1, 1);
    TEST_ASSERT_EQUAL_HEX32(INPUTS_FRAME, due()); /* still lost: no news but the input */
    send(SWAY_MESSAGE_TRAILER_MOTION, 2000, 1, 1);
    TEST_ASSERT_EQUAL_HEX32(ALARM_FRAME | INPUTS_FRAME, due());
    send(SWAY_MESSAGE_TRAILER_MOTION, 12000, 2, 1);
    TEST_ASSERT_EQUAL_HEX32(0, due());
}

static void each_output_has_its_own_counter(void)
{
    int next[SWAY_OUTPUT_COUNT] = {0};
    for (int64_t t = 0; t < 40000000; t += 100000) {
        uint32_t id;
        uint8_t dlc;
        uint8_t data[8];
        sway_node_time(&node, t);
        while (sway_node_transmit(&node, &id, &dlc, data)) {
            TEST_ASSERT_EQUAL(8, dlc);
            TEST_ASSERT_TRUE(sway_e2e_check(id, data));
            TEST_ASSERT_EQUAL(next[id - 0x1A0]++ % 16, data[1] & 0x0F);
        }
    }
    TEST_ASSERT_EQUAL(400, next[0]);
    TEST_ASSERT_EQUAL(40, next[SWAY_OUTPUT_INPUTS]);
}

/* Twenty frames in a row far behind the newest are a clock that was set back; fewer, or with one of
 * now among them, are stray. */
static void a_clock_that_is_set_back_is_followed(void)
{
    uint8_t data[8];
    int64_t now_us = 100000000;
    (void)send(SWAY_MESSAGE_SPEED, now_us, 2000, 0);
    for (int k = 0; k < 19; k++) {
        (void)send(SWAY_MESSAGE_SPEED, 10000 + 10000 * k, 2000, 0);
    }
    TEST_ASSERT_EQUAL_INT64(now_us, node.time_us);
    (void)send(SWAY_MESSAGE_SPEED, now_us += 10000, 2000, 0);
    for (int k = 0; k < 19; k++) {
        (void)send(SWAY_MESSAGE_SPEED, 10000 + 10000 * k, 2000, 0);
    }
    TEST_ASSERT_EQUAL_INT64(now_us, node.time_us);
    TEST_ASSERT_EQUAL_UINT8(19, node.behind);
    (void)send(SWAY_MESSAGE_SPEED, 200000, 2000, 0);
    TEST_ASSERT_EQUAL_INT64(200000, node.time_us);
    TEST_ASSERT_EQUAL_UINT8(0, node.behind);
    const uint32_t alarm = sway_frames_output_id(SWAY_OUTPUT_ALARM);
    (void)drain(0, data);
    for (int k = 1; k <= 200; k++) { // heartbeats go on by the new clock
        (void)send(SWAY_MESSAGE_SPEED, 200000 + 10000 * k, 2000, 0);
    }
    TEST_ASSERT_TRUE(drain(alarm, data) >= 1);
}

/* Messages all good, then the clock set back to `since_us`. */
static void set_back(int64_t since_us)
{
    setUp();
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        (void)send((sway_message_t)m, 100000000, 7, 7);
    }
    for (int k = 0; k < 20; k++) {
        sway_node_time(&node, since_us - 20 + k);
    }
    TEST_ASSERT_EQUAL_INT64(since_us - 1, node.time_us);
}

static void after_the_clock_was_set_back_the_heart_beats_on(void)
{
    uint8_t data[8];
    int beats = 0;
    set_back(1000000);
    (void)drain(0, data);
    for (int64_t t = 1000000; t < 2000000; t += 10000) {
        sway_node_time(&node, t);
        beats += drain(sway_frames_output_id(SWAY_OUTPUT_ALARM), data);
    }
    TEST_ASSERT_EQUAL(9, beats); // the one at the start went out with what was pending
}

static void after_the_clock_was_set_back_every_silence_is_reported(void)
{
    set_back(1000000);
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
    sway_node_time(&node, 1100000);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_COUNT, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
}

static void after_the_clock_was_set_back_a_frozen_sensor_is_found(void)
{
    set_back(1000000);
    for (int64_t t = 1000000; t < 3000000; t += 10000) {
        (void)send(SWAY_MESSAGE_TRAILER_MOTION, t, (int16_t)(t / 10000 % 2 * 3000), (int16_t)t);
        (void)send(SWAY_MESSAGE_ARTICULATION, t, 7, 0); // as before
    }
    TEST_ASSERT_EQUAL(1, frozen());
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_STUCK,
                      sway_node_message_state(&node, SWAY_MESSAGE_ARTICULATION));
}

/* Late by as much as a silence may last, time and again, is no clock that was set back. */
static void jitter_of_100_ms_is_no_new_clock(void)
{
    (void)send(SWAY_MESSAGE_SPEED, 1000000, 2000, 0);
    for (int k = 0; k < 40; k++) {
        sway_node_time(&node, 1000000 - SWAY_NODE_TIMEOUT_US);
    }
    TEST_ASSERT_EQUAL_INT64(1000000, node.time_us);
    for (int k = 0; k < 20; k++) {
        sway_node_time(&node, 1000000 - SWAY_NODE_TIMEOUT_US - 1);
    }
    TEST_ASSERT_EQUAL_INT64(1000000 - SWAY_NODE_TIMEOUT_US - 1, node.time_us);
}

static void time_may_begin_below_zero(void)
{
    uint8_t data[8];
    int beats = 0;
    for (int64_t t = -10000000; t < -9000000; t += 10000) {
        sway_node_time(&node, t);
        TEST_ASSERT_EQUAL_INT64(t, node.time_us);
        beats += drain(sway_frames_output_id(SWAY_OUTPUT_ALARM), data);
    }
    TEST_ASSERT_EQUAL(10, beats);
}

/* Any motion that comes is enough to judge by. */
static void the_alarm_is_off_only_without_any_motion(void)
{
    static const sway_message_t motions[] = {SWAY_MESSAGE_CAR_MOTION, SWAY_MESSAGE_TRAILER_MOTION,
                                             SWAY_MESSAGE_ARTICULATION};
    const uint32_t id = sway_frames_output_id(SWAY_OUTPUT_ALARM);
    for (unsigned given = 0; given < 8U; given++) {
        uint8_t data[8];
        setUp();
        node.core.status.alarm = SWAY_ALARM_WARNING;
        for (int k = 0; k < 3; k++) {
            if ((given >> k & 1U) != 0U) {
                send(motions[k], 0, 0, 0);
            }
        }
        sway_node_time(&node, 1000);
        TEST_ASSERT_TRUE(drain(id, data) > 0);
        TEST_ASSERT_EQUAL(given == 0U ? SWAY_ALARM_OFF : SWAY_ALARM_WARNING, node.alarm_sent & 0xF);
        TEST_ASSERT_EQUAL(given == 0U ? SWAY_ALARM_OFF : SWAY_ALARM_WARNING, data[2] & 7);
    }
}

/* With all inputs there, too, the first thing that is said is said at once. */
static void from_off_to_normal_is_reported_at_once(void)
{
    uint8_t data[8];
    const uint32_t id = sway_frames_output_id(SWAY_OUTPUT_ALARM);
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        (void)send((sway_message_t)m, 0, 0, 0);
    }
    TEST_ASSERT_FALSE(sway_node_inputs_lost(&node));
    (void)drain(id, data);
    node.core.status.alarm = SWAY_ALARM_NORMAL;
    sway_node_time(&node, 1000);
    TEST_ASSERT_EQUAL(1, drain(id, data));
}

static void repetitions_with_a_new_frame_between_are_not_in_a_row(void)
{
    static const uint8_t counters[] = {0, 0, 0, 1, 1, 1};
    for (unsigned i = 0; i < sizeof counters; i++) {
        counter[SWAY_MESSAGE_STEERING] = counters[i];
        send(SWAY_MESSAGE_STEERING, (int64_t)i * 1000, 0, 0);
    }
    TEST_ASSERT_EQUAL(4, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
    TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_STUCK));
}

/* Samples of a car's own bus, and frames of it that are refused, carry time on like frames of ours:
 * what is silent meanwhile is reported, and what comes is reported at once. */
static void samples_and_refused_frames_carry_time_on(void)
{
    const sway_sample_t sample = {.input = SWAY_INPUT_SPEED, .value = 20000, .valid = true};
    (void)send(SWAY_MESSAGE_ARTICULATION, 0, 0, 0);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, reported_state(SWAY_MESSAGE_ARTICULATION));
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_sample(&node, 100001, &sample));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_TIMED_OUT, reported_state(SWAY_MESSAGE_ARTICULATION));
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_sample(&node, 100002, &sample));
    sway_node_refuse(&node, 300000, SWAY_FRAME_FAULT_CRC);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_TIMED_OUT, reported_state(SWAY_MESSAGE_SPEED));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_CRC));
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_sample(&node, 300001, &sample));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, reported_state(SWAY_MESSAGE_SPEED));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(units_are_exact);
    RUN_TEST(every_input_is_in_exactly_one_message);
    RUN_TEST(lost_frames_are_counted_over_turns_of_the_counter);
    RUN_TEST(jitter_of_half_a_turn_does_not_confuse);
    RUN_TEST(first_frames_in_one_burst_do_not_confuse);
    RUN_TEST(slow_sender_loses_nothing);
    RUN_TEST(sender_that_pauses_and_catches_up_loses_nothing);
    RUN_TEST(sender_with_another_period_is_learned_anew);
    RUN_TEST(doubled_and_reordered_frames_are_dropped_and_counted);
    RUN_TEST(reordering_from_the_first_frame_on_is_understood);
    RUN_TEST(stuck_counter_is_reported_and_recovers_at_once);
    RUN_TEST(restarted_sender_is_believed_within_seven_frames);
    RUN_TEST(length_crc_and_identifier_are_counted);
    RUN_TEST(invalid_samples_are_reported);
    RUN_TEST(samples_out_of_range_are_reported);
    RUN_TEST(good_messages_time_out_and_come_back);
    RUN_TEST(silence_of_the_whole_bus_is_reported_by_time_alone);
    RUN_TEST(frozen_sensor_is_found_only_while_the_car_moves);
    RUN_TEST(heartbeat_and_reports_come_by_bus_time);
    RUN_TEST(fault_counters_saturate);
    RUN_TEST(null_arguments_are_refused);
    RUN_TEST(nothing_is_due_before_anything_was_heard);
    RUN_TEST(the_heart_beats_every_100_ms_and_reports_every_tenth_time);
    RUN_TEST(beats_that_were_missed_are_not_made_up_for);
    RUN_TEST(every_estimate_is_sent_at_once_and_once);
    RUN_TEST(work_that_was_left_is_done_with_the_next_frame);
    RUN_TEST(the_alarm_is_sent_when_it_changes);
    RUN_TEST(each_output_has_its_own_counter);
    RUN_TEST(a_clock_that_is_set_back_is_followed);
    RUN_TEST(after_the_clock_was_set_back_the_heart_beats_on);
    RUN_TEST(after_the_clock_was_set_back_every_silence_is_reported);
    RUN_TEST(after_the_clock_was_set_back_a_frozen_sensor_is_found);
    RUN_TEST(jitter_of_100_ms_is_no_new_clock);
    RUN_TEST(time_may_begin_below_zero);
    RUN_TEST(the_alarm_is_off_only_without_any_motion);
    RUN_TEST(from_off_to_normal_is_reported_at_once);
    RUN_TEST(repetitions_with_a_new_frame_between_are_not_in_a_row);
    RUN_TEST(samples_and_refused_frames_carry_time_on);
    return UNITY_END();
}

/* sway_node: what it makes of its inputs: silence, counters, validity, frozen sensors. */
#include "node_test.h"

/* --- inputs ------------------------------------------------------------------------------------
 */

static void every_message_times_out_after_100_ms_and_is_reported(void)
{
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        setUp();
        TEST_ASSERT_EQUAL(SWAY_OK, send((sway_message_t)m, 5000, 0, 0));
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, (sway_message_t)m));
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, reported_state((sway_message_t)m));
        sway_node_time(&node, 105000);
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, (sway_message_t)m));
        TEST_ASSERT_EQUAL(0, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
        sway_node_time(&node, 105001);
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_TIMED_OUT, reported_state((sway_message_t)m));
        sway_node_time(&node, 305001); /* once only */
        TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_TIMEOUT));
        TEST_ASSERT_EQUAL(SWAY_OK, send((sway_message_t)m, 306000, 0, 0));
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, reported_state((sway_message_t)m));
    }
}

/* By the frame of the inputs alone, when the alarm has no news. */
static void a_change_of_state_is_reported_at_once(void)
{
    send(SWAY_MESSAGE_SPEED, 0, 9000, 0);
    due();
    send(SWAY_MESSAGE_ARTICULATION, 1000, 0, 0);
    uint32_t id;
    uint8_t dlc;
    uint8_t data[8];
    TEST_ASSERT_TRUE(sway_node_transmit(&node, &id, &dlc, data));
    TEST_ASSERT_EQUAL_HEX32(0x1B8, id);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD << 2, data[2]); /* SwaySpeed */
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, data[3]);      /* SwayArticulation */
    TEST_ASSERT_FALSE(sway_node_transmit(&node, &id, &dlc, data));
}

static void speed_and_both_motions_are_needed(void)
{
    static const sway_message_t needed[] = {SWAY_MESSAGE_SPEED, SWAY_MESSAGE_CAR_MOTION,
                                            SWAY_MESSAGE_TRAILER_MOTION};
    for (uint32_t given = 0; given < 8; given++) {
        for (int trailer = 0; trailer < 2; trailer++) {
            static sway_core_config_t c;
            c = *config();
            c.vehicle.trailer.axles = trailer;
            TEST_ASSERT_EQUAL(SWAY_OK, sway_node_init(&node, &c));
            memset(counter, 0, sizeof counter);
            for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) { /* all that are not needed */
                if (m < SWAY_MESSAGE_SPEED || m > SWAY_MESSAGE_TRAILER_MOTION) {
                    send((sway_message_t)m, 0, 0, 0);
                }
            }
            for (int k = 0; k < 3; k++) {
                if ((given >> k & 1U) != 0U) {
                    send(needed[k], 0, 0, 0);
                }
            }
            const bool enough = (given | (trailer ? 0U : 4U)) == 7U;
            TEST_ASSERT_EQUAL(!enough, sway_node_inputs_lost(&node));
        }
    }
}

static void a_counter_is_stuck_at_its_third_repetition(void)
{
    send(SWAY_MESSAGE_STEERING, 0, 0, 0);
    for (int i = 1; i <= 600; i++) { /* beyond what a byte can count */
        counter[SWAY_MESSAGE_STEERING] = 0;
        TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, send(SWAY_MESSAGE_STEERING, i * 1000, 0, 0));
        if (i < 3) {
            TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD,
                              sway_node_message_state(&node, SWAY_MESSAGE_STEERING));
        }
        TEST_ASSERT_EQUAL(i >= 3, sway_node_fault(&node, SWAY_FRAME_FAULT_STUCK));
    }
    TEST_ASSERT_EQUAL(600, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_STUCK, sway_node_message_state(&node, SWAY_MESSAGE_STEERING));
    int64_t t = 600000;
    for (int i = 0; i < 10; i++) { /* twice each: never three in a row */
        for (int k = 0; k < 3; k++, t += 1000) {
            counter[SWAY_MESSAGE_STEERING] = (uint8_t)(1 + i);
            send(SWAY_MESSAGE_STEERING, t, 0, 0);
        }
    }
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_STUCK));
    TEST_ASSERT_EQUAL(620, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
}

static void either_sample_of_a_frame_can_be_refused(void)
{
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SWAY_MESSAGE_CAR_MOTION, 0, 32767, 0));
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SWAY_MESSAGE_CAR_MOTION, 1000, 0, 32767));
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SWAY_MESSAGE_CAR_MOTION, 2000, -32767, -32767));
    TEST_ASSERT_EQUAL(SWAY_OK, send(SWAY_MESSAGE_CAR_MOTION, 3000, 0, 0));
    TEST_ASSERT_EQUAL(4, sway_core_status(&node.core)->fault_count[SWAY_FAULT_RANGE]);
    TEST_ASSERT_EQUAL(4, node.accepted);
}

/* One signal invalid, the other in the same frame is used. */
static void validity_is_that_of_each_signal(void)
{
    uint8_t data[8];
    for (unsigned code = 0; code < 16; code++) {
        setUp();
        fill(data, 100, 100);
        data[1] = (uint8_t)(code << 4);
        sway_e2e_protect(0x122, 0, data);
        TEST_ASSERT_EQUAL(SWAY_OK, sway_node_receive(&node, 0, 0x122, 8, data));
        TEST_ASSERT_EQUAL(((code & 3U) != 0) + ((code >> 2) != 0),
                          sway_core_status(&node.core)->fault_count[SWAY_FAULT_INVALID]);
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD,
                          sway_node_message_state(&node, SWAY_MESSAGE_CAR_MOTION));
    }
}

/* --- frozen sensors ----------------------------------------------------------------------------
 */

/* 3 s in which both yaw rates swing by 20 deg/s and message m says nothing new in its first signal,
 * its second, or both. */
static void hold(sway_message_t m, bool first, bool second)
{
    setUp();
    for (int i = 0; i < 300; i++) {
        const int64_t t = i * INT64_C(10000);
        const int16_t yaw = (int16_t)((i % 40 < 20 ? i % 20 : 20 - i % 20) * 100);
        const int16_t other = (int16_t)(yaw / 3 + i);
        send(m, t, first ? 50 : yaw, second ? 50 : other);
        if (m != SWAY_MESSAGE_CAR_MOTION) {
            send(SWAY_MESSAGE_CAR_MOTION, t + 1, yaw, other);
        }
        if (m != SWAY_MESSAGE_TRAILER_MOTION) {
            send(SWAY_MESSAGE_TRAILER_MOTION, t + 2, yaw, other);
        }
    }
}

static void motion_and_lateral_force_are_watched_and_nothing_else(void)
{
    static const struct {
        bool first, second;
    } watched[SWAY_MESSAGE_COUNT] = {[SWAY_MESSAGE_CAR_MOTION] = {true, true},
                                     [SWAY_MESSAGE_TRAILER_MOTION] = {true, true},
                                     [SWAY_MESSAGE_ARTICULATION] = {true, false},
                                     [SWAY_MESSAGE_HITCH_FORCES] = {false, true},
                                     [SWAY_MESSAGE_CAR_WHEEL_FL] = {true, false},
                                     [SWAY_MESSAGE_CAR_WHEEL_FR] = {true, false},
                                     [SWAY_MESSAGE_CAR_WHEEL_RL] = {true, false},
                                     [SWAY_MESSAGE_CAR_WHEEL_RR] = {true, false},
                                     [SWAY_MESSAGE_TRAILER_WHEEL_FL] = {true, false},
                                     [SWAY_MESSAGE_TRAILER_WHEEL_FR] = {true, false},
                                     [SWAY_MESSAGE_TRAILER_WHEEL_RL] = {true, false},
                                     [SWAY_MESSAGE_TRAILER_WHEEL_RR] = {true, false}};
    for (int m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        const bool two = m != SWAY_MESSAGE_STEERING && m != SWAY_MESSAGE_SPEED;
        hold((sway_message_t)m, false, false);
        TEST_ASSERT_EQUAL(0, frozen());
        hold((sway_message_t)m, true, false);
        TEST_ASSERT_EQUAL(watched[m].first, frozen());
        TEST_ASSERT_EQUAL(watched[m].first ? SWAY_MESSAGE_STUCK : SWAY_MESSAGE_GOOD,
                          sway_node_message_state(&node, (sway_message_t)m));
        hold((sway_message_t)m, false, two);
        TEST_ASSERT_EQUAL(watched[m].second, frozen());
        TEST_ASSERT_EQUAL(watched[m].second ? SWAY_MESSAGE_STUCK : SWAY_MESSAGE_GOOD,
                          sway_node_message_state(&node, (sway_message_t)m));
    }
}

/* The articulation stands still from 0; `m` moves by `travel` raw (0.01 deg/s) in steps. At
 * `time_us` the articulation is heard again: is it frozen then? */
static bool is_frozen_after(sway_message_t m, int travel, int step, int64_t time_us)
{
    setUp();
    send(SWAY_MESSAGE_ARTICULATION, 0, 5, 0);
    int64_t t = 1000;
    for (int yaw = 0; yaw <= travel; yaw += step, t += 1000) {
        send(m, t, (int16_t)yaw, (int16_t)yaw);
    }
    send(SWAY_MESSAGE_ARTICULATION, time_us, 5, 0);
    return frozen() == 1;
}

static void a_second_and_20_deg_per_s_make_a_sensor_frozen(void)
{
    static const sway_message_t motion[] = {SWAY_MESSAGE_CAR_MOTION, SWAY_MESSAGE_TRAILER_MOTION};
    for (int k = 0; k < 2; k++) {
        TEST_ASSERT_FALSE(is_frozen_after(motion[k], 2000, 100, 999999));
        TEST_ASSERT_TRUE(is_frozen_after(motion[k], 2000, 100, 1000000));
        TEST_ASSERT_FALSE(is_frozen_after(motion[k], 1999, 1999, 1000000));
        TEST_ASSERT_TRUE(is_frozen_after(motion[k], 2000, 2000, 1000000));
        TEST_ASSERT_TRUE(is_frozen_after(motion[k], 2000, 50, 1000000)); /* 0.5 deg/s count */
    }
    TEST_ASSERT_FALSE(is_frozen_after(SWAY_MESSAGE_CAR_MOTION, 1950, 50, 1000000));
    TEST_ASSERT_FALSE(is_frozen_after(SWAY_MESSAGE_STEERING, 2000, 100, 1000000));
    TEST_ASSERT_FALSE(is_frozen_after(SWAY_MESSAGE_HITCH_FORCES, 2000, 100, 1000000));
}

/* Noise below 0.5 deg/s is no travel, however long it lasts; a slow turn is taken together. */
static void noise_of_the_yaw_rate_is_no_travel(void)
{
    for (int amplitude = 49; amplitude <= 50; amplitude++) {
        setUp();
        for (int i = 0; i < 1000; i++) {
            const int64_t t = i * INT64_C(10000);
            send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)(i % 2 * amplitude), (int16_t)i);
            send(SWAY_MESSAGE_ARTICULATION, t, 5, 0);
        }
        TEST_ASSERT_EQUAL(amplitude == 50, frozen());
    }
    setUp();
    for (int i = 0; i <= 2000; i++) { /* 0.01 deg/s each */
        send(SWAY_MESSAGE_CAR_MOTION, i * INT64_C(10000), (int16_t)-i, (int16_t)i);
    }
    TEST_ASSERT_INT64_WITHIN(9000, 349066, node.travel_urad_s); /* but for the last step */
}

static void both_yaw_rates_travel_by_themselves(void)
{
    setUp();
    send(SWAY_MESSAGE_CAR_MOTION, 0, 1000, 0);
    send(SWAY_MESSAGE_TRAILER_MOTION, 0, 1000, 0); /* 10 deg/s from 0 each */
    TEST_ASSERT_EQUAL_INT64(2 * 174533, node.travel_urad_s);
    send(SWAY_MESSAGE_CAR_MOTION, 1000, 0, 0);
    TEST_ASSERT_EQUAL_INT64(3 * 174533, node.travel_urad_s);
}

static void travel_before_a_value_came_does_not_count(void)
{
    TEST_ASSERT_FALSE(is_frozen_after(SWAY_MESSAGE_CAR_MOTION, 1900, 100, 999000));
    send(SWAY_MESSAGE_ARTICULATION, 1000000, 6, 0); /* a new one, 19 deg/s on */
    send(SWAY_MESSAGE_CAR_MOTION, 1010000, 0, 0);   /* and 19 back */
    send(SWAY_MESSAGE_ARTICULATION, 2000000, 6, 0);
    TEST_ASSERT_EQUAL(0, frozen());
    send(SWAY_MESSAGE_CAR_MOTION, 2010000, 100, 0); /* 20 since it came */
    send(SWAY_MESSAGE_ARTICULATION, 2020000, 6, 0);
    TEST_ASSERT_EQUAL(1, frozen());
}

/* A frozen value goes to the core as not valid and used again as soon as it changes. */
static void a_frozen_sensor_is_not_believed_until_it_moves(void)
{
    TEST_ASSERT_TRUE(is_frozen_after(SWAY_MESSAGE_CAR_MOTION, 2000, 100, 1000000));
    const uint32_t *fault_count = sway_core_status(&node.core)->fault_count;
    TEST_ASSERT_EQUAL(1, fault_count[SWAY_FAULT_INVALID]);
    send(SWAY_MESSAGE_ARTICULATION, 1010000, 5, 0);
    TEST_ASSERT_EQUAL(2, fault_count[SWAY_FAULT_INVALID]);
    TEST_ASSERT_EQUAL(1, frozen()); /* found once */
    send(SWAY_MESSAGE_ARTICULATION, 1020000, 6, 0);
    TEST_ASSERT_EQUAL(2, fault_count[SWAY_FAULT_INVALID]);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_ARTICULATION));
    for (int64_t t = 1030000; t < 1200000; t += 10000) { /* not long enough again */
        send(SWAY_MESSAGE_CAR_MOTION, t, (int16_t)(t / 10000 % 2 * 3000), 0);
        send(SWAY_MESSAGE_ARTICULATION, t, 6, 0);
    }
    TEST_ASSERT_EQUAL(1, frozen());
    TEST_ASSERT_EQUAL(2, fault_count[SWAY_FAULT_INVALID]);
}

static void losses_saturate_too(void)
{
    send(SWAY_MESSAGE_STEERING, 0, 0, 0);
    node.frame_fault[SWAY_FRAME_FAULT_LOST] = UINT32_MAX - 5U;
    counter[SWAY_MESSAGE_STEERING] = 6; /* 5 missing */
    send(SWAY_MESSAGE_STEERING, 1000, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
    counter[SWAY_MESSAGE_STEERING] = 9;
    send(SWAY_MESSAGE_STEERING, 2000, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, sway_node_fault(&node, SWAY_FRAME_FAULT_LOST));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_message_times_out_after_100_ms_and_is_reported);
    RUN_TEST(a_change_of_state_is_reported_at_once);
    RUN_TEST(speed_and_both_motions_are_needed);
    RUN_TEST(a_counter_is_stuck_at_its_third_repetition);
    RUN_TEST(either_sample_of_a_frame_can_be_refused);
    RUN_TEST(validity_is_that_of_each_signal);
    RUN_TEST(motion_and_lateral_force_are_watched_and_nothing_else);
    RUN_TEST(a_second_and_20_deg_per_s_make_a_sensor_frozen);
    RUN_TEST(noise_of_the_yaw_rate_is_no_travel);
    RUN_TEST(both_yaw_rates_travel_by_themselves);
    RUN_TEST(travel_before_a_value_came_does_not_count);
    RUN_TEST(a_frozen_sensor_is_not_believed_until_it_moves);
    RUN_TEST(losses_saturate_too);
    return UNITY_END();
}

/* Protection of frames: CRC of every identifier, counter, and how many frames are missing. */
#include <string.h>

#include "bus/sway_e2e.h"
#include "unity.h"

#define LIMIT_US 300000

static sway_e2e_t e2e;

void setUp(void)
{
    memset(&e2e, 0, sizeof e2e);
}

void tearDown(void)
{
}

/* CRC-8 SAE J1850, bit by bit. */
static uint8_t reference_crc(const uint8_t *bytes, unsigned length)
{
    unsigned crc = 0xFF;
    for (unsigned i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc << 1 ^ ((crc & 0x80U) != 0 ? 0x1DU : 0U)) & 0xFFU;
        }
    }
    return (uint8_t)(crc ^ 0xFFU);
}

static void crc_is_that_of_the_catalogue_for_every_identifier(void)
{
    const uint8_t check[] = "123456789";
    TEST_ASSERT_EQUAL_HEX8(0x4B, reference_crc(check, 9));
    uint32_t noise = 1;
    for (uint32_t id = 0; id < 0x800; id++) {
        uint8_t bytes[10] = {(uint8_t)(id & 0xFFU), (uint8_t)(id >> 8)};
        for (int i = 2; i < 10; i++) {
            noise = noise * 1664525U + 1013904223U;
            bytes[i] = (uint8_t)(noise >> 24);
        }
        uint8_t data[8];
        memcpy(data + 1, bytes + 2, 7);
        data[0] = bytes[9]; /* not looked at */
        TEST_ASSERT_EQUAL_HEX8(reference_crc(bytes, 9), sway_e2e_crc(id, data));
    }
}

static void protect_writes_counter_and_crc_and_nothing_else(void)
{
    for (unsigned before = 0; before < 256; before++) {
        for (uint8_t counter = 0; counter <= SWAY_E2E_COUNTER_MAX; counter++) {
            uint8_t data[9] = {0xEE, (uint8_t)before, 2, 3, 4, 5, 6, 7, 0xA5};
            sway_e2e_protect(0x1A5, counter, data);
            const uint8_t expected[] = {(uint8_t)((before & 0xF0U) | counter), 2, 3, 4, 5, 6, 7};
            TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, data + 1, 7);
            TEST_ASSERT_EQUAL_HEX8(0xA5, data[8]);
            TEST_ASSERT_TRUE(sway_e2e_check(0x1A5, data));
            data[0] ^= 1U;
            TEST_ASSERT_FALSE(sway_e2e_check(0x1A5, data));
        }
    }
    uint8_t data[8] = {0};
    sway_e2e_protect(0x1A5, 15, data);
    TEST_ASSERT_FALSE(sway_e2e_check(0x1A5, data)); /* the counter that is never sent */
}

static void counter_runs_from_0_to_14(void)
{
    for (uint8_t counter = 0; counter < 14; counter++) {
        TEST_ASSERT_EQUAL(counter + 1, sway_e2e_next(counter));
    }
    TEST_ASSERT_EQUAL(0, sway_e2e_next(14));
    TEST_ASSERT_EQUAL(0, sway_e2e_next(15));
}

/* The first frame with `counter`, then `intervals` more in order. Returns the time of the last. */
static int64_t frames(uint8_t *counter, int intervals, int64_t period_us)
{
    int64_t time_us = 1000000;
    setUp();
    TEST_ASSERT_EQUAL(1, sway_e2e_step(&e2e, *counter, time_us, LIMIT_US));
    for (int i = 0; i < intervals; i++) {
        time_us += period_us;
        *counter = sway_e2e_next(*counter);
        TEST_ASSERT_EQUAL(1, sway_e2e_step(&e2e, *counter, time_us, LIMIT_US));
    }
    return time_us;
}

/* What a frame is told that comes `elapsed_us` after those, `ahead` counts on. */
static int32_t then(int intervals, int64_t period_us, int ahead, int64_t elapsed_us)
{
    uint8_t counter = 3;
    const int64_t time_us = frames(&counter, intervals, period_us);
    return sway_e2e_step(&e2e, (uint8_t)((counter + ahead) % 15), time_us + elapsed_us, LIMIT_US);
}

static void first_frame_is_in_order_whatever_its_counter(void)
{
    for (uint8_t counter = 0; counter <= SWAY_E2E_COUNTER_MAX; counter++) {
        uint8_t first = counter;
        frames(&first, 0, 0);
    }
}

static void before_the_period_is_known_the_nearest_step_is_told(void)
{
    for (int ahead = 0; ahead < 15; ahead++) {
        TEST_ASSERT_EQUAL(ahead <= 7 ? ahead : ahead - 15, then(0, 0, ahead, 200000));
        TEST_ASSERT_EQUAL(ahead <= 7 ? ahead : ahead - 15,
                          then(SWAY_E2E_LEARN_MIN - 1, 10000, ahead, 200000));
    }
}

static void the_period_is_relied_on_from_the_eighth_interval(void)
{
    TEST_ASSERT_EQUAL(5, then(SWAY_E2E_LEARN_MIN - 1, 10000, 5, 200000));
    TEST_ASSERT_EQUAL(20, then(SWAY_E2E_LEARN_MIN, 10000, 5, 200000));
}

static void a_period_below_the_shortest_is_not_relied_on(void)
{
    TEST_ASSERT_EQUAL(20, then(20, SWAY_E2E_PERIOD_MIN_US, 5, 20 * SWAY_E2E_PERIOD_MIN_US));
    TEST_ASSERT_EQUAL(5, then(20, SWAY_E2E_PERIOD_MIN_US - 1, 5, 20 * SWAY_E2E_PERIOD_MIN_US));
}

/* Up to the limit every missing frame is counted, over turns of the counter; only a step of one
 * turn and one may be a pause. */
static void missing_frames_are_counted_up_to_the_limit(void)
{
    for (int steps = 2; steps <= 30; steps++) {
        for (int64_t jitter_us = -60000; jitter_us <= 60000; jitter_us += 12000) {
            const int64_t elapsed_us = steps * INT64_C(10000) + jitter_us;
            if (steps % 15 != 1 && elapsed_us >= 0 && elapsed_us <= LIMIT_US) {
                TEST_ASSERT_EQUAL(steps, then(40, 10000, steps % 15, elapsed_us));
            }
        }
    }
    TEST_ASSERT_EQUAL(1, then(40, 10000, 16, 160000));
}

static void late_frames_are_told_by_how_much(void)
{
    for (int late = 1; late <= 7; late++) {
        TEST_ASSERT_EQUAL(-late, then(40, 10000, 15 - late, 100));
        TEST_ASSERT_EQUAL(-late, then(0, 0, 15 - late, 100));
    }
}

/* 8 ahead after half a period: 8 steps on and 7 steps back are equally near. */
static void between_two_equally_near_the_later_is_told(void)
{
    TEST_ASSERT_EQUAL(-7, then(40, 10000, 8, 4999));
    TEST_ASSERT_EQUAL(8, then(40, 10000, 8, 5000));
    TEST_ASSERT_EQUAL(8, then(40, 10000, 8, 5001));
}

static void a_frame_that_comes_again_is_no_step(void)
{
    TEST_ASSERT_EQUAL(0, then(0, 0, 0, 10000));
    TEST_ASSERT_EQUAL(0, then(40, 10000, 0, 10000));
    TEST_ASSERT_EQUAL(0, then(40, 10000, 0, 74999));
    TEST_ASSERT_EQUAL(15, then(40, 10000, 0, 75001));
    uint8_t counter = 3;
    const int64_t time_us = frames(&counter, 40, 10000);
    for (int i = 1; i <= 100; i++) { /* a stuck counter is heard all the time */
        TEST_ASSERT_EQUAL(0, sway_e2e_step(&e2e, counter, time_us + i * 10000, LIMIT_US));
    }
    TEST_ASSERT_EQUAL(
        2, sway_e2e_step(&e2e, (uint8_t)((counter + 2) % 15), time_us + 1020000, LIMIT_US));
}

static void beyond_the_limit_the_counter_alone_counts(void)
{
    TEST_ASSERT_EQUAL(30, then(40, 10000, 0, LIMIT_US));
    TEST_ASSERT_EQUAL(1, then(40, 10000, 0, LIMIT_US + 1)); /* silent, not stuck */
    for (int ahead = 1; ahead < 15; ahead++) {
        TEST_ASSERT_EQUAL(ahead, then(40, 10000, ahead, LIMIT_US + 1));
        TEST_ASSERT_EQUAL(ahead, then(0, 0, ahead, LIMIT_US + 1));
        TEST_ASSERT_EQUAL(ahead, then(40, 10000, ahead, INT64_C(1) << 40));
    }
}

/* A late frame is not the last one: what comes next is counted from the frame before it. */
static void a_late_frame_changes_nothing(void)
{
    uint8_t counter = 3;
    const int64_t time_us = frames(&counter, 40, 10000);
    const sway_e2e_t before = e2e;
    TEST_ASSERT_EQUAL(-2,
                      sway_e2e_step(&e2e, (uint8_t)((counter + 13) % 15), time_us + 9, LIMIT_US));
    TEST_ASSERT_EQUAL(before.counter, e2e.counter);
    TEST_ASSERT_EQUAL(before.time_us, e2e.time_us);
    TEST_ASSERT_EQUAL(before.period_us, e2e.period_us);
    TEST_ASSERT_EQUAL(1, sway_e2e_step(&e2e, sway_e2e_next(counter), time_us + 10000, LIMIT_US));
}

static void the_period_is_a_mean_at_first_and_then_smoothed(void)
{
    uint8_t counter = 3;
    int64_t time_us = frames(&counter, 1, 4000);
    TEST_ASSERT_EQUAL(4000, e2e.period_us);
    time_us += 8000;
    counter = sway_e2e_next(counter);
    sway_e2e_step(&e2e, counter, time_us, LIMIT_US);
    TEST_ASSERT_EQUAL(6000, e2e.period_us); /* mean of two */
    TEST_ASSERT_EQUAL(2, e2e.learned);

    counter = 3;
    time_us = frames(&counter, SWAY_E2E_LEARN_MAX, 10000);
    TEST_ASSERT_EQUAL(10000, e2e.period_us);
    sway_e2e_step(&e2e, sway_e2e_next(counter), time_us + 11600, LIMIT_US);
    TEST_ASSERT_EQUAL(10100, e2e.period_us); /* 1600 / 16 */
    TEST_ASSERT_EQUAL(SWAY_E2E_LEARN_MAX, e2e.learned);
}

/* Once the period is known a pause counts as two periods and a millisecond at most. */
static void a_pause_moves_the_period_little(void)
{
    uint8_t counter = 3;
    int64_t time_us = frames(&counter, SWAY_E2E_LEARN_MAX, 10000);
    sway_e2e_step(&e2e, sway_e2e_next(counter), time_us + 250000, LIMIT_US);
    TEST_ASSERT_INT_WITHIN(1, 10000 + 11000 / 16, e2e.period_us);

    counter = 3;
    time_us = frames(&counter, SWAY_E2E_LEARN_MAX - 1, 10000);
    sway_e2e_step(&e2e, sway_e2e_next(counter), time_us + 250000, LIMIT_US);
    TEST_ASSERT_EQUAL(25000, e2e.period_us); /* still a mean */
}

static void time_that_goes_back_is_no_time(void)
{
    uint8_t counter = 3;
    int64_t time_us = frames(&counter, 0, 0);
    TEST_ASSERT_EQUAL(1, sway_e2e_step(&e2e, 4, time_us - 5000, LIMIT_US));
    TEST_ASSERT_EQUAL(0, e2e.period_us);
    TEST_ASSERT_EQUAL(time_us - 5000, e2e.time_us);
    TEST_ASSERT_EQUAL(-1, then(40, 10000, 14, -50000));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(crc_is_that_of_the_catalogue_for_every_identifier);
    RUN_TEST(protect_writes_counter_and_crc_and_nothing_else);
    RUN_TEST(counter_runs_from_0_to_14);
    RUN_TEST(first_frame_is_in_order_whatever_its_counter);
    RUN_TEST(before_the_period_is_known_the_nearest_step_is_told);
    RUN_TEST(the_period_is_relied_on_from_the_eighth_interval);
    RUN_TEST(a_period_below_the_shortest_is_not_relied_on);
    RUN_TEST(missing_frames_are_counted_up_to_the_limit);
    RUN_TEST(late_frames_are_told_by_how_much);
    RUN_TEST(between_two_equally_near_the_later_is_told);
    RUN_TEST(a_frame_that_comes_again_is_no_step);
    RUN_TEST(beyond_the_limit_the_counter_alone_counts);
    RUN_TEST(a_late_frame_changes_nothing);
    RUN_TEST(the_period_is_a_mean_at_first_and_then_smoothed);
    RUN_TEST(a_pause_moves_the_period_little);
    RUN_TEST(time_that_goes_back_is_no_time);
    return UNITY_END();
}

/* Protection of frames: CRC of every identifier, counter, and how many frames are missing. */
#include <stdio.h>
#include <string.h>

#include "bus/sway_e2e.h"
#include "unity.h"

#define LIMIT_US 300000

static sway_e2e_t e2e;
static uint32_t noise = 1;

void setUp(void)
{
    memset(&e2e, 0, sizeof e2e);
}

void tearDown(void)
{
}

/* CRC-8H2F, bit by bit. */
static uint8_t reference_crc(const uint8_t *bytes, unsigned length)
{
    unsigned crc = 0xFF;
    for (unsigned i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc << 1 ^ ((crc & 0x80U) != 0 ? 0x2FU : 0U)) & 0xFFU;
        }
    }
    return (uint8_t)(crc ^ 0xFFU);
}

static void crc_is_that_of_the_catalogue_for_every_identifier(void)
{
    const uint8_t check[] = "123456789";
    TEST_ASSERT_EQUAL_HEX8(0xDF, reference_crc(check, 9));
    for (uint32_t id = 0; id < 0x800; id++) {
        uint8_t data[9];
        for (int i = 0; i < 8; i++) {
            noise = noise * 1664525U + 1013904223U;
            data[i] = (uint8_t)(noise >> 24);
        }
        data[8] = (uint8_t)(id & 0xFFU);
        const uint8_t expected = reference_crc(data + 1, 8);
        TEST_ASSERT_EQUAL_HEX8(expected, sway_e2e_crc(id, data));
        data[0] ^= 0xFFU; /* not looked at */
        TEST_ASSERT_EQUAL_HEX8(expected, sway_e2e_crc(id, data));
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
}

/* 1 where a frame of 0x122 with the bits of `error` turned is not refused; bit 63 is sent first. */
static uint32_t missed(const uint8_t *data, uint64_t error)
{
    uint8_t bad[8];
    for (unsigned i = 0; i < 8; i++) {
        bad[i] = (uint8_t)(data[i] ^ (error >> (56U - 8U * i) & 0xFFU));
    }
    return sway_e2e_check(0x122, bad) ? 1 : 0;
}

static uint64_t any_bits(void)
{
    uint64_t any = 0;
    for (unsigned i = 0; i < 8; i++) {
        noise = noise * 1664525U + 1013904223U;
        any = any << 8 | noise >> 24;
    }
    return any;
}

static void any_frame(uint8_t counter, uint8_t *data)
{
    const uint64_t any = any_bits();
    for (unsigned i = 0; i < 8; i++) {
        data[i] = (uint8_t)(any >> (8U * i));
    }
    sway_e2e_protect(0x122, counter, data);
}

/* These three are the table in port/README.md. */
static void errors_of_up_to_three_bits_are_found(void)
{
    for (uint8_t counter = 0; counter <= SWAY_E2E_COUNTER_MAX; counter++) {
        uint8_t data[8];
        any_frame(counter, data);
        for (unsigned a = 0; a < 64; a++) {
            for (unsigned b = a; b < 64; b++) {
                const uint64_t two = UINT64_C(1) << a | UINT64_C(1) << b;
                for (unsigned c = b; c < 64; c++) {
                    TEST_ASSERT_EQUAL(0, missed(data, two | UINT64_C(1) << c));
                }
            }
        }
    }
}

/* The CRC comes first in the frame and last in what it is taken of: a burst over the edge of byte 0
 * is two. */
static void bursts_of_up_to_eight_bits_are_found_except_over_the_edge_of_the_crc(void)
{
    uint8_t data[8];
    any_frame(5, data);
    uint32_t edge = 0, over = 0;
    for (unsigned last = 0; last < 64; last++) {
        for (uint64_t burst = 1; burst < 256; burst += 2) {
            const uint64_t error = burst << last;
            const bool is_over = error >> 56 != 0 && (error & UINT64_C(0x00FFFFFFFFFFFFFF)) != 0;
            const uint32_t passed = missed(data, error);
            edge += is_over ? 1 : 0;
            over += is_over ? passed : 0;
            TEST_ASSERT_EQUAL(is_over ? passed : 0, passed);
        }
    }
    printf("bursts of up to 8 bits over the edge of byte 0: %u of %u missed\n", over, edge);
    TEST_ASSERT_LESS_THAN(edge / 100, over);
}

static void of_other_errors_one_in_256_is_missed(void)
{
    const uint32_t tries = 1U << 18;
    uint32_t random = 0, four = 0;
    for (uint32_t i = 0; i < tries; i++) {
        uint8_t data[8];
        any_frame((uint8_t)(i % 16), data);
        random += missed(data, any_bits());
        uint64_t error = 0;
        for (uint64_t bits = any_bits(); error == 0 || (error & (error - 1)) == 0; bits >>= 6) {
            error = UINT64_C(1) << (bits & 63U) | UINT64_C(1) << (bits >> 6 & 63U) |
                    UINT64_C(1) << (bits >> 12 & 63U) | UINT64_C(1) << (bits >> 18 & 63U);
        }
        four += missed(data, error);
    }
    printf("any bits: %u of %u missed, four bits: %u\n", random, tries, four);
    TEST_ASSERT_UINT32_WITHIN(tries / 256 / 10, tries / 256, random);
    TEST_ASSERT_LESS_THAN(tries / 100, four);
}

static void counter_runs_from_0_to_15(void)
{
    for (uint8_t counter = 0; counter < 15; counter++) {
        TEST_ASSERT_EQUAL(counter + 1, sway_e2e_next(counter));
    }
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

/* What is reported of a frame that comes `elapsed_us` after those, `ahead` counts on. */
static int32_t then(int intervals, int64_t period_us, int ahead, int64_t elapsed_us)
{
    uint8_t counter = 3;
    const int64_t time_us = frames(&counter, intervals, period_us);
    return sway_e2e_step(&e2e, (uint8_t)((counter + ahead) % 16), time_us + elapsed_us, LIMIT_US);
}

static void first_frame_is_in_order_whatever_its_counter(void)
{
    for (uint8_t counter = 0; counter <= SWAY_E2E_COUNTER_MAX; counter++) {
        uint8_t first = counter;
        frames(&first, 0, 0);
    }
}

static void before_the_period_is_known_the_nearest_step_is_reported(void)
{
    for (int ahead = 0; ahead < 16; ahead++) {
        TEST_ASSERT_EQUAL(ahead <= 8 ? ahead : ahead - 16, then(0, 0, ahead, 200000));
        TEST_ASSERT_EQUAL(ahead <= 8 ? ahead : ahead - 16,
                          then(SWAY_E2E_LEARN_MIN - 1, 10000, ahead, 200000));
    }
}

static void the_period_is_relied_on_from_the_eighth_interval(void)
{
    TEST_ASSERT_EQUAL(4, then(SWAY_E2E_LEARN_MIN - 1, 10000, 4, 200000));
    TEST_ASSERT_EQUAL(20, then(SWAY_E2E_LEARN_MIN, 10000, 4, 200000));
}

static void a_period_below_the_shortest_is_not_relied_on(void)
{
    TEST_ASSERT_EQUAL(20, then(20, SWAY_E2E_PERIOD_MIN_US, 4, 20 * SWAY_E2E_PERIOD_MIN_US));
    TEST_ASSERT_EQUAL(4, then(20, SWAY_E2E_PERIOD_MIN_US - 1, 4, 20 * SWAY_E2E_PERIOD_MIN_US));
}

/* Up to the limit every missing frame is counted, over turns of the counter; only a step of one
 * turn and one may be a pause. */
static void missing_frames_are_counted_up_to_the_limit(void)
{
    for (int steps = 2; steps <= 30; steps++) {
        for (int64_t jitter_us = -60000; jitter_us <= 60000; jitter_us += 12000) {
            const int64_t elapsed_us = steps * INT64_C(10000) + jitter_us;
            if (steps % 16 != 1 && elapsed_us >= 0 && elapsed_us <= LIMIT_US) {
                TEST_ASSERT_EQUAL(steps, then(40, 10000, steps % 16, elapsed_us));
            }
        }
    }
    TEST_ASSERT_EQUAL(1, then(40, 10000, 17, 170000));
}

static void late_frames_are_reported_by_how_much(void)
{
    for (int late = 1; late <= 7; late++) {
        TEST_ASSERT_EQUAL(-late, then(40, 10000, 16 - late, 100));
        TEST_ASSERT_EQUAL(-late, then(0, 0, 16 - late, 100));
    }
}

/* 9 ahead after one period: 9 steps on and 7 steps back are equally near. */
static void between_two_equally_near_the_later_is_reported(void)
{
    TEST_ASSERT_EQUAL(-7, then(40, 10000, 9, 9999));
    TEST_ASSERT_EQUAL(9, then(40, 10000, 9, 10000));
    TEST_ASSERT_EQUAL(9, then(40, 10000, 9, 10001));
}

static void a_frame_that_comes_again_is_no_step(void)
{
    TEST_ASSERT_EQUAL(0, then(0, 0, 0, 10000));
    TEST_ASSERT_EQUAL(0, then(40, 10000, 0, 10000));
    TEST_ASSERT_EQUAL(0, then(40, 10000, 0, 79999));
    TEST_ASSERT_EQUAL(16, then(40, 10000, 0, 80001));
    uint8_t counter = 3;
    const int64_t time_us = frames(&counter, 40, 10000);
    for (int i = 1; i <= 100; i++) { /* a stuck counter is heard all the time */
        TEST_ASSERT_EQUAL(0, sway_e2e_step(&e2e, counter, time_us + i * 10000, LIMIT_US));
    }
    TEST_ASSERT_EQUAL(
        2, sway_e2e_step(&e2e, (uint8_t)((counter + 2) % 16), time_us + 1020000, LIMIT_US));
}

static void beyond_the_limit_the_counter_alone_counts(void)
{
    TEST_ASSERT_EQUAL(32, then(40, 10000, 0, LIMIT_US));
    TEST_ASSERT_EQUAL(1, then(40, 10000, 0, LIMIT_US + 1)); /* silent, not stuck */
    for (int ahead = 1; ahead < 16; ahead++) {
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
                      sway_e2e_step(&e2e, (uint8_t)((counter + 14) % 16), time_us + 9, LIMIT_US));
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
    TEST_ASSERT_EQUAL(-1, then(40, 10000, 15, -50000));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(crc_is_that_of_the_catalogue_for_every_identifier);
    RUN_TEST(protect_writes_counter_and_crc_and_nothing_else);
    RUN_TEST(errors_of_up_to_three_bits_are_found);
    RUN_TEST(bursts_of_up_to_eight_bits_are_found_except_over_the_edge_of_the_crc);
    RUN_TEST(of_other_errors_one_in_256_is_missed);
    RUN_TEST(counter_runs_from_0_to_15);
    RUN_TEST(first_frame_is_in_order_whatever_its_counter);
    RUN_TEST(before_the_period_is_known_the_nearest_step_is_reported);
    RUN_TEST(the_period_is_relied_on_from_the_eighth_interval);
    RUN_TEST(a_period_below_the_shortest_is_not_relied_on);
    RUN_TEST(missing_frames_are_counted_up_to_the_limit);
    RUN_TEST(late_frames_are_reported_by_how_much);
    RUN_TEST(between_two_equally_near_the_later_is_reported);
    RUN_TEST(a_frame_that_comes_again_is_no_step);
    RUN_TEST(beyond_the_limit_the_counter_alone_counts);
    RUN_TEST(a_late_frame_changes_nothing);
    RUN_TEST(the_period_is_a_mean_at_first_and_then_smoothed);
    RUN_TEST(a_pause_moves_the_period_little);
    RUN_TEST(time_that_goes_back_is_no_time);
    return UNITY_END();
}

/* What the ports share: sway_bit_timing against trying every division there is, can, sway_checks.
 */
#include <stdlib.h>
#include <string.h>

#include "can.h"
#include "sway_bit_timing.h"
#include "sway_checks.h"
#include "unity.h"

/* FDCAN of the STM32G4, CAN of the Zynq UltraScale+, and one narrower than both. */
static const sway_bit_limits_t limits[] = {
    {512, 256, 128, 128}, {256, 16, 8, 4}, {4, 8, 5, 2}, {64, 9, 8, 3}};

void setUp(void)
{
}

void tearDown(void)
{
}

/* Thousandths of a bit, rounded, between the sample point and the one that is wanted. */
static uint32_t error_of(uint32_t segment1, uint32_t segment2, uint32_t wanted_milli)
{
    const uint32_t quanta = 1U + segment1 + segment2;
    const uint32_t point = (2000U * (1U + segment1) + quanta) / (2U * quanta);
    return point > wanted_milli ? point - wanted_milli : wanted_milli - point;
}

/* The least error of all exact divisions with a second segment of 2 quanta or more. */
static uint32_t least_error(uint32_t clocks, uint32_t wanted_milli, const sway_bit_limits_t *limit)
{
    uint32_t least = UINT32_MAX;
    for (uint32_t quanta = 8; quanta <= 80; quanta++) {
        if (clocks % quanta != 0U || clocks / quanta > limit->prescaler_max) {
            continue;
        }
        for (uint32_t segment2 = 2; segment2 <= limit->segment2_max; segment2++) {
            if (quanta >= 2U + segment2 && quanta - 1U - segment2 <= limit->segment1_max) {
                const uint32_t error = error_of(quanta - 1U - segment2, segment2, wanted_milli);
                least = error < least ? error : least;
            }
        }
    }
    return least;
}

static void expect_best(uint32_t clock_hz, uint32_t bit_rate, uint32_t wanted_milli,
                        const sway_bit_limits_t *limit)
{
    sway_bit_timing_t timing = {0};
    const bool found = sway_bit_timing(clock_hz, bit_rate, wanted_milli, limit, &timing);
    const uint32_t least = clock_hz % bit_rate == 0U
                               ? least_error(clock_hz / bit_rate, wanted_milli, limit)
                               : UINT32_MAX;
    TEST_ASSERT_EQUAL(least != UINT32_MAX, found);
    if (found) {
        const uint32_t quanta = 1U + timing.segment1 + timing.segment2;
        TEST_ASSERT_EQUAL_UINT32(clock_hz, bit_rate * quanta * timing.prescaler);
        TEST_ASSERT_TRUE(quanta >= 8U && quanta <= 80U);
        TEST_ASSERT_TRUE(timing.prescaler >= 1U && timing.prescaler <= limit->prescaler_max);
        TEST_ASSERT_TRUE(timing.segment1 >= 1U && timing.segment1 <= limit->segment1_max);
        TEST_ASSERT_TRUE(timing.segment2 >= 2U && timing.segment2 <= limit->segment2_max);
        TEST_ASSERT_TRUE(timing.jump >= 1U && timing.jump <= limit->jump_max);
        TEST_ASSERT_TRUE(timing.jump == limit->jump_max || timing.jump == timing.segment2);
        TEST_ASSERT_EQUAL_UINT32(least, error_of(timing.segment1, timing.segment2, wanted_milli));
    }
}

static void the_best_of_all_divisions_is_found(void)
{
    static const uint32_t clock_hz[] = {8000000,  16000000, 24000000, 40000000,
                                        48000000, 80000000, 85000000, 170000000};
    static const uint32_t bit_rate[] = {50000,  83333,  100000, 125000,
                                        250000, 500000, 800000, 1000000};
    static const uint32_t wanted_milli[] = {500, 625, 700, 750, 800, 850, 875, 900, 990};
    for (size_t c = 0; c < sizeof clock_hz / sizeof clock_hz[0]; c++) {
        for (size_t b = 0; b < sizeof bit_rate / sizeof bit_rate[0]; b++) {
            for (size_t w = 0; w < sizeof wanted_milli / sizeof wanted_milli[0]; w++) {
                for (size_t l = 0; l < sizeof limits / sizeof limits[0]; l++) {
                    expect_best(clock_hz[c], bit_rate[b], wanted_milli[w], &limits[l]);
                }
            }
        }
    }
}

/* Any sample point, any number of clocks in a bit. */
static void the_best_is_found_for_any_sample_point(void)
{
    uint32_t noise = 1;
    for (int trial = 0; trial < 20000; trial++) {
        noise = noise * 1664525U + 1013904223U;
        const uint32_t clocks = 8U + (noise >> 8) % 400U;
        const uint32_t wanted_milli = 300U + (noise >> 20) % 700U;
        expect_best(clocks * 100000U, 100000U, wanted_milli, &limits[trial % 4]);
    }
}

/* Of equally good ones the one with the most quanta: the finest adjustment. */
static void of_equals_the_finest_is_taken(void)
{
    sway_bit_timing_t timing;
    TEST_ASSERT_TRUE(sway_bit_timing(80000000, 500000, 875, &limits[0], &timing));
    TEST_ASSERT_EQUAL_UINT32(2, timing.prescaler); /* 80 quanta, the most there are */
    TEST_ASSERT_EQUAL_UINT32(69, timing.segment1);
    TEST_ASSERT_EQUAL_UINT32(10, timing.segment2);
    TEST_ASSERT_EQUAL_UINT32(10, timing.jump);
    TEST_ASSERT_TRUE(sway_bit_timing(8000000, 1000000, 875, &limits[0], &timing));
    TEST_ASSERT_EQUAL_UINT32(5, timing.segment1); /* 8 quanta, the fewest: 1 would be too short */
    TEST_ASSERT_EQUAL_UINT32(2, timing.segment2);
}

static void what_cannot_be_is_refused(void)
{
    sway_bit_timing_t timing;
    TEST_ASSERT_FALSE(sway_bit_timing(80000000, 0, 875, &limits[0], &timing));
    TEST_ASSERT_FALSE(
        sway_bit_timing(0, 500000, 875, &limits[0], &timing)); /* a clock that stands */
    TEST_ASSERT_FALSE(sway_bit_timing(80000000, 333333, 875, &limits[0], &timing));
    TEST_ASSERT_FALSE(sway_bit_timing(80000000, 500000, 1000, &limits[0], &timing));
    TEST_ASSERT_TRUE(sway_bit_timing(80000000, 500000, 999, &limits[0], &timing));
    TEST_ASSERT_FALSE(sway_bit_timing(7000000, 1000000, 875, &limits[0], &timing));  /* 7 quanta */
    TEST_ASSERT_FALSE(sway_bit_timing(83000000, 1000000, 875, &limits[0], &timing)); /* a prime */
}

/* --- port/can.c --------------------------------------------------------------------------------
 */

static int64_t now_ns;

static int64_t time_ns(void)
{
    return now_ns;
}

static can_config_t good(void)
{
    const can_config_t config = {.bit_rate = 500000, .filters = CAN_FILTERS, .time_ns = time_ns};
    return config;
}

static void can_needs_a_rate_a_clock_and_few_enough_filters(void)
{
    static can_t can;
    can_config_t config = good();
    TEST_ASSERT_TRUE(can_prepare(&can, &config));
    config.filters = CAN_FILTERS + 1U;
    TEST_ASSERT_FALSE(can_prepare(&can, &config));
    config = good();
    config.bit_rate = 0;
    TEST_ASSERT_FALSE(can_prepare(&can, &config));
    config = good();
    config.time_ns = NULL;
    TEST_ASSERT_FALSE(can_prepare(&can, &config));
}

/* Nothing is lost up to the ring's length, over many turns of it; what is beyond is counted. */
static void the_ring_gives_back_what_went_in(void)
{
    static can_t can;
    const can_config_t config = good();
    sway_port_frame_t frame = {0};
    memset(&can, 0xA5, sizeof can);
    TEST_ASSERT_TRUE(can_prepare(&can, &config));
    TEST_ASSERT_FALSE(can_receive(&can, &frame));
    uint16_t in = 0, out = 0;
    for (uint32_t turn = 0; turn < 5; turn++) {
        for (uint32_t i = 0; i < CAN_RING + turn; i++) {
            frame.id = in;
            in = (uint16_t)(in + (i < CAN_RING));
            can_put(&can, &frame);
        }
        while (can_receive(&can, &frame)) {
            TEST_ASSERT_EQUAL_UINT16(out++, frame.id);
        }
        TEST_ASSERT_EQUAL_UINT16(in, out);
        frame.id = in++;
        can_put(&can, &frame); /* so that the ring starts elsewhere */
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        out++;
    }
    TEST_ASSERT_EQUAL_UINT32(5 * CAN_RING + 5, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(1 + 2 + 3 + 4, can.counters.overflows);
}

/* 128 times 11 bits at first, then twice as long each time up to 1 s; a frame ends the doubling. */
static void bus_off_waits_longer_each_time(void)
{
    static can_t can;
    const can_config_t config = good();
    const int64_t first_ns = INT64_C(128) * 11 * 2000;
    const sway_port_frame_t frame = {0};
    TEST_ASSERT_TRUE(can_prepare(&can, &config));
    now_ns = 123456789;
    int64_t wait_ns = first_ns;
    for (uint32_t i = 1; i <= 20; i++) {
        can.bus_off = false;
        can_note_bus_off(&can);
        TEST_ASSERT_TRUE(can.bus_off);
        TEST_ASSERT_EQUAL_UINT32(i, can.counters.bus_offs);
        TEST_ASSERT_EQUAL_INT64(now_ns + wait_ns, can.restart_ns);
        wait_ns = 2 * wait_ns > 1000000000 ? 1000000000 : 2 * wait_ns;
    }
    can_put(&can, &frame);
    can_note_bus_off(&can);
    TEST_ASSERT_EQUAL_INT64(now_ns + first_ns, can.restart_ns);
}

/* --- port/sway_checks.c ------------------------------------------------------------------------
 */

static void memory_outside_the_check_is_not_touched(void)
{
    uint32_t *const words = calloc(8U, sizeof *words); /* a sanitizer watches both ends */
    TEST_ASSERT_NOT_NULL(words);
    memset(words, 0x5A, 8U * sizeof *words);
    TEST_ASSERT_TRUE(sway_check_memory(words, words + 8));
    TEST_ASSERT_TRUE(sway_check_memory(words, words));
    TEST_ASSERT_EACH_EQUAL_HEX32(0x5A5A5A5A, words, 8);
    free(words);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_best_of_all_divisions_is_found);
    RUN_TEST(the_best_is_found_for_any_sample_point);
    RUN_TEST(of_equals_the_finest_is_taken);
    RUN_TEST(what_cannot_be_is_refused);
    RUN_TEST(can_needs_a_rate_a_clock_and_few_enough_filters);
    RUN_TEST(the_ring_gives_back_what_went_in);
    RUN_TEST(bus_off_waits_longer_each_time);
    RUN_TEST(memory_outside_the_check_is_not_touched);
    return UNITY_END();
}

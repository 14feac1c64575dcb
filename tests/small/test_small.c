/* The smallest configuration: steering, yaw rate and acceleration of the car, yaw rate of the
 * trailer (FW_SIZES_small of tests/mk/firmware.mk). What it has no place for is taken and dropped.
 */
#include <math.h>
#include <string.h>

#include "bus/sway_e2e.h"
#include "reference_vehicle.h"
#include "signal/sway_grid.h"
#include "sway_node.h"
#include "unity.h"

#if SWAY_CHANNELS != 4
#error "to be built with FW_SIZES_small"
#endif

static sway_core_config_t config;
static sway_core_t core;
static sway_node_t node;

void setUp(void)
{
    sway_core_defaults(&config);
    config.vehicle = reference_vehicle();
    config.sample_period_us = 20000; // rows at 50 Hz, the last 2.5 s of them
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
}

void tearDown(void)
{
}

/* 6 s of a swing of 0.67 Hz; with_forces: and the wheel forces that this build drops. */
static void drive(bool with_forces)
{
    for (int64_t t = 0; t < 6000000; t += 10000) {
        const double angle = 2 * M_PI * 0.67 * (double)t * 1e-6;
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_SPEED, t, 25000));
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, t,
                                                       (int32_t)lround(5e4 * cos(angle))));
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_TRAILER_YAW_RATE, t,
                                                       (int32_t)lround(1e5 * cos(angle - 0.4))));
        if (with_forces) {
            TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_HITCH_FY, t, 1000));
            sway_core_invalid(&core, SWAY_INPUT_CAR_FY_FL, t);
        }
        while (sway_core_run(&core)) {
        }
    }
}

static void the_swing_is_estimated_and_forces_are_dropped(void)
{
    drive(false);
    const sway_status_t without = *sway_core_status(&core);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, without.valid);
    TEST_ASSERT_INT_WITHIN(2000, 670000, without.frequency_uhz);
    setUp();
    drive(true);
    TEST_ASSERT_EQUAL_MEMORY(&without, sway_core_status(&core), sizeof without);
}

static void the_range_of_what_is_dropped_is_checked_all_the_same(void)
{
    const int32_t limit = sway_grid_limit(SWAY_INPUT_HITCH_FY);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_HITCH_FY, 0, limit));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                          sway_core_input(&core, SWAY_INPUT_HITCH_FY, 0, limit + 1));
    TEST_ASSERT_EQUAL_UINT32(1, sway_core_status(&core)->fault_count[SWAY_FAULT_RANGE]);
}

static void frames_of_what_is_dropped_are_good_frames(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_node_init(&node, &config));
    for (int m = 0; m < (int)SWAY_MESSAGE_COUNT; m++) {
        const uint32_t id = sway_frames_input_id((sway_message_t)m);
        uint8_t data[8] = {0};
        sway_e2e_protect(id, 0, data);
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_node_receive(&node, 1000000, id, 8, data));
        TEST_ASSERT_EQUAL_INT(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, (sway_message_t)m));
    }
    TEST_ASSERT_EQUAL_UINT32(SWAY_MESSAGE_COUNT, node.accepted);
}

static void samples_of_what_is_dropped_are_good_samples(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_node_init(&node, &config));
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        const sway_sample_t sample = {.input = (sway_input_t)i, .valid = true};
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_node_sample(&node, 1000000, &sample));
    }
    TEST_ASSERT_EQUAL_UINT32(SWAY_INPUT_COUNT, node.accepted);
    TEST_ASSERT_EQUAL_INT(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_SPEED));
}

/* A row has the four channels and the speed, and the speed in no other place. */
static void a_row_has_no_channel_beyond_the_last(void)
{
    static sway_grid_t grid;
    const sway_grid_config_t how = sway_grid_default(20000);
    sway_row_t row;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &how));
    for (int64_t t = 0; t < 200000; t += 20000) {
        (void)sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, t, 7);
        (void)sway_grid_input(&grid, SWAY_INPUT_SPEED, t, 25000);
    }
    TEST_ASSERT_TRUE(sway_grid_next_row(&grid, &row));
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                                SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED),
                            row.present_mask);
    TEST_ASSERT_EQUAL_HEX32(row.present_mask, row.valid_mask);
    TEST_ASSERT_EQUAL_INT32(0, row.value[SWAY_CHANNELS]);
    TEST_ASSERT_EQUAL_INT32(25000, row.value[SWAY_CHANNEL_SPEED]);
}

/* As many rows as the grid holds but two: an input may come so late. */
static void an_input_may_be_late_by_six_rows(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    TEST_ASSERT_EQUAL_INT32(6 * config.sample_period_us, core.grid.config.max_wait_us);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_swing_is_estimated_and_forces_are_dropped);
    RUN_TEST(the_range_of_what_is_dropped_is_checked_all_the_same);
    RUN_TEST(frames_of_what_is_dropped_are_good_frames);
    RUN_TEST(samples_of_what_is_dropped_are_good_samples);
    RUN_TEST(a_row_has_no_channel_beyond_the_last);
    RUN_TEST(an_input_may_be_late_by_six_rows);
    return UNITY_END();
}

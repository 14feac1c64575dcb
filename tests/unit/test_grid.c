/* Tests of sway_grid and sway_ring: rows from samples that come as they like. */
#include "grid_feed.h"
#include "signal/sway_ring.h"

/* Takes rows until the one of `time_us`. */
static void take_row(int64_t time_us)
{
    do {
        TEST_ASSERT_TRUE_MESSAGE(sway_grid_next_row(&grid, &tick), "the row is not ready");
    } while (tick.time_us < time_us);
    TEST_ASSERT_EQUAL_INT64(time_us, tick.time_us);
}

static void test_each_input_is_interpolated_on_its_own_clock(void)
{
    for (int64_t t = 0; t < 60000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t + 3000, (int32_t)(t + 3000));
        put(SWAY_INPUT_TRAILER_YAW_RATE, t + 7500, (int32_t)(-2 * (t + 7500)));
    }
    take_row(20000);
    TEST_ASSERT_EQUAL_INT32(20000, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    TEST_ASSERT_EQUAL_INT32(-40000, tick.value[SWAY_CHANNEL_TRAILER_YAW_RATE]);
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_ARTICULATION));
}

static void test_interpolation_is_rounded_to_the_nearest(void)
{
    uint32_t seed = 1;
    for (int k = 0; k < 2000; k++) {
        int32_t value[2];
        int64_t time_us[2];
        setUp();
        for (int i = 0; i < 2; i++) {
            seed = seed * 1664525U + 1013904223U;
            value[i] = (int32_t)(seed >> 8) % 5300000;
            value[i] = (seed & 1U) != 0U ? value[i] : -value[i] / 3000;
            seed = seed * 1664525U + 1013904223U;
            time_us[i] = i == 0 ? 10000 - (int64_t)(seed >> 19) - 1 : 10001 + (int64_t)(seed >> 17);
            put(SWAY_INPUT_CAR_YAW_RATE, time_us[i], value[i]);
        }
        take_row(10000);
        const double part = (double)(10000 - time_us[0]) / (double)(time_us[1] - time_us[0]);
        const double exact = value[0] + part * (value[1] - value[0]);
        TEST_ASSERT_DOUBLE_WITHIN(0.5000001, exact, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    }
}

static void test_slow_messages_are_interpolated_too(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 0);
    put(SWAY_INPUT_CAR_YAW_RATE, 20000, 2000);
    take_row(10000);
    TEST_ASSERT_EQUAL_INT32(1000, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

static void test_wheels_of_an_axle_add_up(void)
{
    for (int64_t t = 0; t <= 20000; t += 10000) {
        put(SWAY_INPUT_CAR_FY_FL, t, 50000000);
        put(SWAY_INPUT_CAR_FY_FR, t, 50000000);
        put(SWAY_INPUT_TRAILER_FZ_RL, t, 7);
    }
    take_row(10000);
    TEST_ASSERT_EQUAL_INT32(100000000, tick.value[SWAY_CHANNEL_CAR_FRONT_FY]);
    TEST_ASSERT_TRUE(tick.value[SWAY_CHANNEL_CAR_FRONT_FY] < SWAY_SAMPLE_LIMIT);
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_FRONT_FY));
    TEST_ASSERT_FALSE_MESSAGE(is_valid(SWAY_CHANNEL_TRAILER_REAR_FZ), "one wheel is no axle");
}

/* Each input by itself: in its own channel, nowhere else. */
static void test_every_input_has_its_channel(void)
{
    for (int input = 0; input <= (int)SWAY_INPUT_HITCH_FY; input++) {
        setUp();
        for (int64_t t = 0; t < 60000; t += 10000) {
            put((sway_input_t)input, t, 4321 + input);
        }
        take_row(20000);
        TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(input), tick.valid_mask);
        TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(input), tick.present_mask);
        TEST_ASSERT_EQUAL_INT32(4321 + input, tick.value[input]);
    }
    static const sway_input_t left[] = {SWAY_INPUT_CAR_FY_FL,     SWAY_INPUT_CAR_FY_RL,
                                        SWAY_INPUT_CAR_FZ_FL,     SWAY_INPUT_CAR_FZ_RL,
                                        SWAY_INPUT_TRAILER_FY_FL, SWAY_INPUT_TRAILER_FY_RL,
                                        SWAY_INPUT_TRAILER_FZ_FL, SWAY_INPUT_TRAILER_FZ_RL};
    for (uint32_t k = 0; k < 8; k++) {
        const uint32_t channel = (uint32_t)SWAY_CHANNEL_CAR_FRONT_FY + k;
        setUp();
        for (int64_t t = 0; t < 60000; t += 10000) {
            put(left[k], t, 1000);
            put((sway_input_t)(left[k] + 1), t, 300);
        }
        take_row(20000);
        TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(channel), tick.valid_mask);
        TEST_ASSERT_EQUAL_INT32(1300, tick.value[channel]);
    }
}

static void test_a_delay_is_taken_from_the_timestamp(void)
{
    sway_grid_config_t config = sway_grid_default(10000);
    config.delay_us[SWAY_INPUT_ARTICULATION] = 4000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    for (int64_t t = 0; t < 50000; t += 10000) {
        put(SWAY_INPUT_ARTICULATION, t + 4000, (int32_t)t);
    }
    take_row(20000);
    TEST_ASSERT_EQUAL_INT32(20000, tick.value[SWAY_CHANNEL_ARTICULATION]);
}

static void test_a_long_gap_is_marked_and_the_rest_goes_on(void)
{
    int rows = 0;
    int invalid = 0;
    for (int64_t t = 0; t <= 1000000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 5);
        if (t < 300000 || t >= 600000) {
            put(SWAY_INPUT_TRAILER_YAW_RATE, t, 7);
        }
        while (sway_grid_next_row(&grid, &tick)) {
            rows++;
            TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
            invalid += is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE) ? 0 : 1;
        }
    }
    TEST_ASSERT_EQUAL_INT(101, rows);
    TEST_ASSERT_EQUAL_INT(30, invalid); // 300 .. 590 ms; 600 ms is a sample again
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.gaps);
}

static void test_a_lost_frame_is_bridged(void)
{
    for (int64_t t = 0; t <= 100000; t += 10000) {
        if (t != 50000) {
            put(SWAY_INPUT_CAR_YAW_RATE, t, (int32_t)t);
        }
    }
    take_row(50000);
    TEST_ASSERT_EQUAL_INT32(50000, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

static void test_out_of_range_is_refused_and_counted(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                          sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 0, 5300001));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                          sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 0, INT32_MIN));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE, sway_grid_input(&grid, SWAY_INPUT_SPEED, 0, -1));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE, sway_grid_input(&grid, SWAY_INPUT_CAR_FZ_FL, 0, -1));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_input(&grid, SWAY_INPUT_COUNT, 0, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_grid_input(&grid, SWAY_INPUT_SPEED, INT64_MAX, 0));
    TEST_ASSERT_EQUAL_UINT32(4, grid.faults.out_of_range);
    TEST_ASSERT_FALSE(sway_grid_next_row(&grid, &tick));
}

/* Of all inputs, as sway_types.h says. */
static void test_every_input_has_its_range(void)
{
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        const bool fz = (i >= SWAY_INPUT_CAR_FZ_FL && i <= SWAY_INPUT_CAR_FZ_RR) ||
                        (i >= SWAY_INPUT_TRAILER_FZ_FL && i <= SWAY_INPUT_TRAILER_FZ_RR);
        const bool yaw = i == SWAY_INPUT_CAR_YAW_RATE || i == SWAY_INPUT_TRAILER_YAW_RATE;
        const bool acc = i == SWAY_INPUT_CAR_LATERAL_ACC || i == SWAY_INPUT_TRAILER_LATERAL_ACC;
        int32_t limit = yaw ? 5300000 : acc ? 40000000 : 50000000;
        limit = i == SWAY_INPUT_STEERING_WHEEL_ANGLE ? 12600000 : limit;
        limit = i == SWAY_INPUT_ARTICULATION ? 1600000 : limit;
        limit = i == SWAY_INPUT_SPEED ? 120000 : limit;
        const int32_t low = fz || i == SWAY_INPUT_SPEED ? 0 : -limit;
        const sway_input_t input = (sway_input_t)i;
        TEST_ASSERT_EQUAL_INT32(limit, sway_grid_limit(input));
        put(input, 10000 * i, limit);
        put(input, 10000 * i, low);
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE, sway_grid_input(&grid, input, 0, limit + 1));
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE, sway_grid_input(&grid, input, 0, low - 1));
    }
    TEST_ASSERT_EQUAL_UINT32(2U * SWAY_INPUT_COUNT, grid.faults.out_of_range);
    TEST_ASSERT_EQUAL_INT32(0, sway_grid_limit(SWAY_INPUT_COUNT));
}

static void test_an_axle_is_present_when_both_wheels_are(void)
{
    put(SWAY_INPUT_CAR_FY_FR, 0, 1);
    put(SWAY_INPUT_CAR_FY_RL, 0, 1);
    put(SWAY_INPUT_TRAILER_FZ_RL, 0, 1);
    put(SWAY_INPUT_TRAILER_FZ_RR, 0, 1);
    take_row(0);
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_REAR_FZ), tick.present_mask);
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_REAR_FZ), tick.valid_mask);
    TEST_ASSERT_EQUAL_INT32(2, tick.value[SWAY_CHANNEL_TRAILER_REAR_FZ]);
}

static void test_a_value_out_of_range_is_no_data(void)
{
    for (int64_t t = 0; t <= 100000; t += 10000) {
        put(SWAY_INPUT_TRAILER_YAW_RATE, t, 5);
        if (t == 50000) {
            TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                                  sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, t, INT32_MAX));
        } else {
            put(SWAY_INPUT_CAR_YAW_RATE, t, 9);
        }
    }
    for (int64_t t = 0; t <= 100000; t += 10000) {
        take_row(t);
        TEST_ASSERT_EQUAL(t != 50000, is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
        TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
    }
}

static void test_time_going_back_is_refused_and_the_next_is_taken(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 100000, 1);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 90000, 2));
    put(SWAY_INPUT_CAR_YAW_RATE, 110000, 3);
    put(SWAY_INPUT_CAR_YAW_RATE, 120000, 4);
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.time_backward);
    take_row(110000);
    TEST_ASSERT_EQUAL_INT32(3, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    TEST_ASSERT_FALSE_MESSAGE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE), "its clock is uncertain");
    take_row(120000);
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

static void test_a_clock_that_restarts_is_followed(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 900000000, 1);
    int refused = 0;
    for (int64_t t = 0; t < 400000; t += 10000) {
        refused += sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, t, 2) == SWAY_OK ? 0 : 1;
        while (sway_grid_next_row(&grid, &tick)) {
        }
    }
    TEST_ASSERT_EQUAL_INT(15, refused);
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.restarts);
    TEST_ASSERT_EQUAL_INT64(390000, tick.time_us);
}

static void test_a_restart_is_one_for_all_inputs(void)
{
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        put((sway_input_t)i, 900000000, 1);
    }
    for (int k = 0; k < 16; k++) {
        (void)sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 10000 * k, 2);
    }
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        put((sway_input_t)i, 160000, 3);
    }
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.restarts);
}

static void test_one_wild_stamp_does_no_harm(void)
{
    int rows = 0;
    for (int64_t t = 0; t < 500000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 2);
        if (t == 200000) {
            TEST_ASSERT_EQUAL_INT(
                SWAY_ERROR_TIME,
                sway_grid_input(&grid, SWAY_INPUT_TRAILER_YAW_RATE, INT64_C(1) << 50, 1));
        }
        while (sway_grid_next_row(&grid, &tick)) {
            rows++;
            TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
        }
    }
    TEST_ASSERT_EQUAL_INT(50, rows);
    TEST_ASSERT_EQUAL_UINT32(0, grid.faults.restarts);
}

static void test_a_pause_of_the_bus_restarts_without_a_flood_of_rows(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
    put(SWAY_INPUT_CAR_YAW_RATE, 10000, 1);
    take_row(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, INT64_C(3600000000), 1));
    put(SWAY_INPUT_CAR_YAW_RATE, INT64_C(3600010000), 1);
    int rows = 0;
    while (sway_grid_next_row(&grid, &tick)) {
        rows++;
    }
    TEST_ASSERT_EQUAL_INT(1, rows);
    TEST_ASSERT_TRUE(tick.restart);
}

static void test_a_silent_input_is_waited_for_no_longer_than_configured(void)
{
    put(SWAY_INPUT_TRAILER_YAW_RATE, 0, 1);
    for (int64_t t = 0; t <= 90000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 1);
    }
    take_row(0);
    TEST_ASSERT_FALSE(sway_grid_next_row(&grid, &tick));
    put(SWAY_INPUT_CAR_YAW_RATE, 110000, 1);
    take_row(10000);
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

static void test_silence_is_counted_while_it_lasts_and_once(void)
{
    for (int64_t t = 0; t <= 4000000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 5);
        if (t < 300000 || (t >= 1000000 && t < 2000000)) {
            put(SWAY_INPUT_TRAILER_YAW_RATE, t, 7);
        }
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
        }
        const uint32_t before = t < 300000 ? 0 : t < 2000000 ? 1 : 2;
        const bool settled = t % 1000000 > 500000;
        TEST_ASSERT_TRUE(!settled || grid.faults.gaps == before);
    }
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
    TEST_ASSERT_EQUAL_UINT32(2, grid.faults.gaps);
}

static void test_an_input_that_stays_away_after_a_restart_is_counted(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 5);
    put(SWAY_INPUT_TRAILER_YAW_RATE, 0, 5);
    (void)sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, INT64_C(3600000000), 1);
    for (int64_t t = 10000; t < 500000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, INT64_C(3600000000) + t, 1);
        while (sway_grid_next_row(&grid, &tick)) {
        }
    }
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.restarts);
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.gaps);
}

/* Yaw rates of both bodies, the car's every `period_us` with a jitter of a fifth of it and every
 * `lost`-th frame lost; returns the rows of the last second in which the car's are not valid. */
static int invalid_at_period(int64_t period_us, int lost)
{
    uint32_t seed = 1;
    int invalid = 0;
    int64_t car_us = 0;
    for (int64_t t = 0, k = 0; t < 4000000; t += 10000) {
        put(SWAY_INPUT_TRAILER_YAW_RATE, t, 7);
        for (; car_us <= t; k++) {
            seed = seed * 1664525U + 1013904223U;
            car_us = k * period_us + (int64_t)(seed >> 16) * period_us / 5 / 65536;
            if (lost == 0 || k % lost != 0) {
                put(SWAY_INPUT_CAR_YAW_RATE, car_us, 5);
            }
        }
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
            invalid += tick.time_us >= 3000000 && !is_valid(SWAY_CHANNEL_CAR_YAW_RATE) ? 1 : 0;
        }
    }
    return invalid;
}

static void watch_rates(void)
{
    sway_grid_config_t config = sway_grid_default(10000);
    config.input_period_us = 10000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
}

static void test_a_rate_off_by_a_tenth_is_counted_and_no_data(void)
{
    static const int64_t wrong_us[] = {9000, 9091, 10900, 11000, 11111, 22000};
    for (int i = 0; i < 6; i++) {
        watch_rates();
        TEST_ASSERT_INT_WITHIN(10, 95, invalid_at_period(wrong_us[i], 0));
        TEST_ASSERT_EQUAL_UINT32(1, grid.faults.off_rate);
    }
}

static void test_lost_frames_jitter_and_other_plain_rates_are_no_wrong_rate(void)
{
    static const int64_t right_us[] = {2500, 5000, 9700, 10000, 10300, 20000, 50000};
    for (int i = 0; i < 7; i++) {
        for (int lost = 0; lost <= 20; lost += 20) {
            watch_rates();
            TEST_ASSERT_EQUAL_INT(0,
                                  right_us[i] > 30000 ? 0 : invalid_at_period(right_us[i], lost));
            TEST_ASSERT_EQUAL_UINT32(0, grid.faults.off_rate);
        }
    }
    setUp();
    TEST_ASSERT_EQUAL_INT(0, invalid_at_period(11000, 0)); // no nominal rate, none to leave
}

static void test_a_rate_that_comes_back_is_data_again(void)
{
    watch_rates();
    int64_t at = 0;
    for (int k = 0; k < 900; k++) {
        at += k >= 300 && k < 600 ? 11000 : 10000;
        put(SWAY_INPUT_CAR_YAW_RATE, at, 5);
        while (sway_grid_next_row(&grid, &tick)) {
        }
        TEST_ASSERT_EQUAL(k < 300 || k > 800,
                          k < 300 || (k > 800 && is_valid(SWAY_CHANNEL_CAR_YAW_RATE)));
        TEST_ASSERT_EQUAL_UINT32(k < 300 ? 0 : 1, k < 500 && k >= 300 ? 1 : grid.faults.off_rate);
        TEST_ASSERT_TRUE(k < 500 || k >= 600 || !is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    }
}

static void test_not_valid_from_the_sender(void)
{
    for (int64_t t = 0; t <= 100000; t += 10000) {
        if (t == 50000) {
            sway_grid_invalid(&grid, SWAY_INPUT_CAR_YAW_RATE, t);
        } else {
            put(SWAY_INPUT_CAR_YAW_RATE, t, 9);
        }
    }
    for (int64_t t = 0; t <= 100000; t += 10000) {
        take_row(t);
        TEST_ASSERT_EQUAL(t != 50000, is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    }
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.invalid);
}

static void test_speed_is_held_between_slow_messages(void)
{
    for (int64_t t = 0; t <= 1000000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 9);
        if (t % 200000 == 0 && t < 700000) {
            put(SWAY_INPUT_SPEED, t, 30000);
        }
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_SPEED));
        }
    }
    TEST_ASSERT_EQUAL_INT32(30000, tick.value[SWAY_CHANNEL_SPEED]);
}

static void test_bad_configurations_are_refused(void)
{
    sway_grid_config_t config = sway_grid_default(999);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
    config = sway_grid_default(10000);
    config.max_wait_us = 10000 * SWAY_GRID_ROWS;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
    config = sway_grid_default(10000);
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        config.delay_us[i] = 500001;
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
        config.delay_us[i] = -500000;
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    }
    config = sway_grid_default(10000);
    config.input_period_us = 999;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, NULL));
    config = sway_grid_default(10000);
    config.max_gap_us = 9999; // less than a row
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
    config = sway_grid_default(10000);
    config.max_speed_gap_us = 9999;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &config));
}

static void test_calls_without_a_grid_or_an_input_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_input(NULL, SWAY_INPUT_SPEED, 0, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_input(&grid, SWAY_INPUT_COUNT, 0, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_grid_input(&grid, SWAY_INPUT_SPEED, SWAY_GRID_TIME_LIMIT + 1, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_grid_input(&grid, SWAY_INPUT_SPEED, -SWAY_GRID_TIME_LIMIT - 1, 0));
    sway_grid_invalid(&grid, SWAY_INPUT_COUNT, 0);
    sway_grid_invalid(NULL, SWAY_INPUT_SPEED, 0);
    TEST_ASSERT_EQUAL_UINT32(0, grid.faults.invalid);
    TEST_ASSERT_FALSE(sway_grid_next_row(NULL, &tick));
    TEST_ASSERT_FALSE(sway_grid_next_row(&grid, NULL));
    TEST_ASSERT_FALSE(grid.running);
}

static void test_a_counter_stays_at_its_end(void)
{
    grid.faults.invalid = UINT32_MAX - 1U;
    for (int k = 0; k < 3; k++) {
        sway_grid_invalid(&grid, SWAY_INPUT_SPEED, 10000 * k);
    }
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, grid.faults.invalid);
}

/* Two wild stamps are believed only when they are near each other. */
static void test_wild_stamps_far_from_each_other_are_not_believed(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 0);
    const int64_t wild[] = {900000000, 100000000, 500000000};
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                              sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, wild[k], 0));
    }
    put(SWAY_INPUT_CAR_YAW_RATE, 500010000, 0);
    TEST_ASSERT_EQUAL_INT64(500010000, grid.newest_time_us);
}

/* An input that has never been heard, too, may not speak of long ago. */
static void test_a_first_sample_of_long_ago_is_refused(void)
{
    for (int64_t t = 0; t <= 2000000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 0);
        while (sway_grid_next_row(&grid, &tick)) {
        }
    }
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_grid_input(&grid, SWAY_INPUT_TRAILER_YAW_RATE, 100000, 0));
}

/* A speed that was never heard is not held, one that its sender takes back neither. */
static void test_a_speed_that_is_not_usable_is_not_held(void)
{
    put(SWAY_INPUT_SPEED, 0, 20000);
    sway_grid_invalid(&grid, SWAY_INPUT_SPEED, 20000);
    for (int64_t t = 0; t <= 100000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 0);
    }
    take_row(50000);
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_SPEED));
    TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

static void test_ring_clips_and_marks(void)
{
    static sway_ring_t ring;
    sway_ring_clear(&ring);
    memset(&tick, 0, sizeof tick);
    tick.valid_mask = 3;
    tick.value[0] = INT32_MIN;
    tick.value[1] = 5;
    tick.value[2] = INT32_MAX;
    tick.valid_mask = 7;
    sway_ring_push(&ring, &tick);
    TEST_ASSERT_EQUAL_INT32(SWAY_SAMPLE_LIMIT - 1, ring.sample[2][sway_ring_slot(&ring, 0)]);
    TEST_ASSERT_EQUAL_INT32(1 - SWAY_SAMPLE_LIMIT, ring.sample[0][sway_ring_slot(&ring, 0)]);
    TEST_ASSERT_EQUAL_HEX32(2, ring.valid[sway_ring_slot(&ring, 0)]);
    TEST_ASSERT_EQUAL_UINT32(1, ring.filled);
    TEST_ASSERT_EQUAL_INT32(0, ring.sample[1][sway_ring_slot(&ring, 1)]);
}

static void test_ring_sums_are_those_of_its_newest_rows(void)
{
    static sway_ring_t ring;
    sway_ring_clear(&ring);
    memset(&tick, 0, sizeof tick);
    for (int row = 0; row < SWAY_RING_SAMPLES + 101; row++) {
        int64_t sums[4];
        tick.value[3] = row;
        tick.valid_mask = row % 100 == 0 ? 0 : SWAY_CHANNEL_BIT(3);
        sway_ring_push(&ring, &tick);
        const int filled = row < SWAY_RING_SAMPLES ? row + 1 : SWAY_RING_SAMPLES;
        TEST_ASSERT_EQUAL_UINT32(filled, ring.filled);
        const uint64_t missing = sway_ring_sums(&ring, 3, ring.head, 5, 4, sums);
        for (int b = 0; b < 4 && row >= 19; b++) {
            const int first = row - 19 + 5 * b;
            const bool bad = (first + 4) / 100 != (first - 1) / 100 || first == 0;
            TEST_ASSERT_EQUAL_INT64(5 * first + 10, sums[b]);
            TEST_ASSERT_EQUAL(bad, (missing >> b) & 1U);
        }
    }
}

static void configure(int32_t max_gap_us, int32_t input_period_us)
{
    sway_grid_config_t config = sway_grid_default(10000);
    config.max_gap_us = max_gap_us;
    config.input_period_us = input_period_us;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
}

static void test_the_bounds_of_a_configuration_are_allowed(void)
{
    sway_grid_config_t config = sway_grid_default(1000);
    TEST_ASSERT_EQUAL_INT32(60000, config.max_gap_us);
    TEST_ASSERT_EQUAL_INT32(500000, config.max_speed_gap_us);
    TEST_ASSERT_EQUAL_INT32(100000, config.max_wait_us);
    config.max_wait_us = 0;
    config.input_period_us = 1000;
    config.delay_us[0] = 500000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    config.sample_period_us = 100000;
    config.max_gap_us = 100000;
    config.input_period_us = 100000;
    config.delay_us[0] = -500000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    sway_grid_config_t beyond = config;
    beyond.sample_period_us = beyond.max_gap_us = 100001;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &beyond));
    beyond = config;
    beyond.input_period_us = 100001;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &beyond));
    beyond = config;
    beyond.delay_us[1] = -500001;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_grid_init(&grid, &beyond));
    TEST_ASSERT_EQUAL_INT32(0, sway_grid_limit(SWAY_INPUT_COUNT)); // there is none
}

/* Long spans, where they are allowed to be data, are interpolated to the nearest as well. */
static void test_long_spans_are_interpolated_to_the_nearest(void)
{
    static const int64_t spans_us[] = {60000, 65535, 65536, 65537, 100000, 290001};
    static const int32_t to[] = {1, -1, 3, 5000000, -5000000};
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 5; k++) {
            configure(300000, 0);
            put(SWAY_INPUT_CAR_YAW_RATE, 5000, 0);
            put(SWAY_INPUT_CAR_YAW_RATE, 5000 + spans_us[i], to[k]);
            for (int64_t row = 10000; row <= 50000; row += 10000) {
                take_row(row);
                TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
                const double exact = (double)to[k] * (double)(row - 5000) / (double)spans_us[i];
                TEST_ASSERT_DOUBLE_WITHIN(0.5000001, exact, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
            }
        }
    }
    for (int sign = -1; sign <= 1; sign += 2) { // a half away from zero
        configure(300000, 0);
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 0);
        put(SWAY_INPUT_CAR_YAW_RATE, 20000, sign);
        take_row(10000);
        TEST_ASSERT_EQUAL_INT32(sign, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    }
}

static void test_a_silence_that_outlasts_a_restart_is_counted_again(void)
{
    put(SWAY_INPUT_TRAILER_YAW_RATE, 0, 7);
    for (int part = 1; part <= 2; part++) {
        for (int64_t t = 0; t < 1500000; t += 10000) {
            const int64_t now = (part == 1 ? 0 : INT64_C(3600000000)) + t;
            (void)sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, now, 5);
            while (sway_grid_next_row(&grid, &tick)) {
            }
        }
        TEST_ASSERT_EQUAL_UINT32(part, grid.faults.gaps);
    }
}

/* A stamp half a second ahead is taken, beyond that when a second one is within half a second of
 * it; a jump of up to 2 s is no restart. */
static void test_jumps_are_believed_as_it_is_said(void)
{
    static const int64_t second_us[][2] = {{500000, 1}, {-500000, 1}, {500001, 0}, {-500001, 0}};
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
    put(SWAY_INPUT_CAR_YAW_RATE, 500000, 1);
    TEST_ASSERT_EQUAL_UINT32(0, grid.faults.time_backward);
    for (int i = 0; i < 4; i++) {
        setUp();
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                              sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 9000000, 1));
        TEST_ASSERT_EQUAL_INT(
            second_us[i][1] != 0 ? SWAY_OK : SWAY_ERROR_TIME,
            sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 9000000 + second_us[i][0], 1));
    }
    for (int64_t jump = 1000000; jump <= 2000001; jump = jump < 2000000 ? 2000000 : jump + 1) {
        setUp();
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        (void)sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, jump, 1);
        put(SWAY_INPUT_CAR_YAW_RATE, jump, 1);
        TEST_ASSERT_EQUAL_UINT32(jump > 2000000, grid.faults.restarts);
    }
    /* two strays with a good stamp between them are strays */
    setUp();
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
    for (int k = 1; k < 30; k++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                              sway_grid_input(&grid, SWAY_INPUT_TRAILER_YAW_RATE, 9000000, 1));
        put(SWAY_INPUT_CAR_YAW_RATE, 10000 * k, 1);
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                              sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 10000 * k - 1, 1));
        put(SWAY_INPUT_CAR_YAW_RATE, 10000 * k + 1, 1);
    }
    TEST_ASSERT_EQUAL_UINT32(0, grid.faults.restarts);
}

static void test_a_sample_is_late_behind_its_row_and_refused_a_second_behind(void)
{
    for (int64_t t = 0; t <= 2000000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 1);
        while (sway_grid_next_row(&grid, &tick)) {
        }
    }
    TEST_ASSERT_EQUAL_INT64(2010000, grid.next_time_us);
    TEST_ASSERT_EQUAL_UINT32(0, grid.faults.late);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_grid_input(&grid, SWAY_INPUT_ARTICULATION, 1009999, 1));
    put(SWAY_INPUT_ARTICULATION, 1010000, 1);
    TEST_ASSERT_EQUAL_UINT32(1, grid.faults.late);
    put(SWAY_INPUT_ARTICULATION, 2009999, 1);
    TEST_ASSERT_EQUAL_UINT32(2, grid.faults.late);
    put(SWAY_INPUT_ARTICULATION, 2010000, 1);
    TEST_ASSERT_EQUAL_UINT32(2, grid.faults.late);
}

/* An input far ahead of the others does not write over rows that wait. */
static void test_rows_that_wait_are_not_written_over(void)
{
    configure(500000, 0);
    put(SWAY_INPUT_TRAILER_YAW_RATE, 0, 1);
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 0);
    put(SWAY_INPUT_CAR_YAW_RATE, 400000, 4000);
    for (int64_t row = 0; row < 160000; row += 10000) {
        take_row(row);
        TEST_ASSERT_EQUAL_INT32((int32_t)(row / 100), tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    }
}

static void test_a_steering_angle_that_is_not_valid_is_not(void)
{
    put(SWAY_INPUT_STEERING_WHEEL_ANGLE, 0, 1);
    sway_grid_invalid(&grid, SWAY_INPUT_STEERING_WHEEL_ANGLE, 10000);
    take_row(10000);
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_STEERING_WHEEL_ANGLE));
}

static void test_a_gap_is_longer_than_the_longest_that_is_allowed(void)
{
    for (int more = 0; more <= 1; more++) {
        setUp();
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        put(SWAY_INPUT_CAR_YAW_RATE, 60000 + more, 1);
        TEST_ASSERT_EQUAL_UINT32(more, grid.faults.gaps);
        take_row(10000);
        TEST_ASSERT_EQUAL(more == 0, is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    }
}

/* The mean in units of 2 us follows a span's deviation by a 64th, rounded; of short spans (less
 * than 3/4) nothing is said, long ones are multiples. */
static void test_the_rate_follows_by_a_sixty_fourth(void)
{
    static const int32_t cases[][2] = {{10640, 5},   {9360, -5},   {10062, 0},   {10064, 1},
                                       {9938, 0},    {9936, -1},   {14000, 31},  {14999, 39},
                                       {15000, 39},  {15001, -39}, {16000, -31}, {25000, 39},
                                       {25001, -39}, {7500, -20},  {7499, 0},    {20640, 5}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        configure(60000, 10000);
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        put(SWAY_INPUT_CAR_YAW_RATE, cases[i][0], 1);
        TEST_ASSERT_EQUAL_INT32(cases[i][1], grid.input[SWAY_INPUT_CAR_YAW_RATE].drift);
    }
}

/* Off from more than 6 % on, right again from less than 4 % on, fast or slow. */
static void test_the_rate_is_off_where_it_is_said(void)
{
    static const int32_t cases[][3] = {/* mean in 2 us, off before, off after */
                                       {300, 0, 0}, {301, 0, 1}, {-300, 0, 0}, {-301, 0, 1},
                                       {200, 1, 1}, {199, 1, 0}, {-200, 1, 1}, {-199, 1, 0}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        configure(60000, 10000);
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        sway_grid_input_t *const in = &grid.input[SWAY_INPUT_CAR_YAW_RATE];
        in->drift = (int16_t)cases[i][0];
        in->off_rate = cases[i][1] != 0;
        put(SWAY_INPUT_CAR_YAW_RATE, 10000 + 2 * cases[i][0], 1);
        TEST_ASSERT_EQUAL_INT32(cases[i][0], in->drift);
        TEST_ASSERT_EQUAL(cases[i][2] != 0, in->off_rate);
        TEST_ASSERT_EQUAL_UINT32(cases[i][2] > cases[i][1], grid.faults.off_rate);
    }
}

/* Inputs that come 50 ms after the others are waited for in every row, and where they end the rows
 * have nothing of them. */
static void test_every_input_is_waited_for_in_every_row(void)
{
    static const sway_input_t late[] = {SWAY_INPUT_STEERING_WHEEL_ANGLE, SWAY_INPUT_ARTICULATION,
                                        SWAY_INPUT_CAR_YAW_RATE};
    for (int i = 0; i < 3; i++) {
        setUp();
        int64_t rows = 0;
        for (int64_t t = 0; t < 1000000; t += 10000) {
            put(SWAY_INPUT_TRAILER_YAW_RATE, t, 1);
            if (t == 0 || (t >= 50000 && t < 700000)) {
                put(late[i], t == 0 ? 0 : t - 50000, 5);
            }
            while (sway_grid_next_row(&grid, &tick)) {
                rows++;
                TEST_ASSERT_EQUAL(tick.time_us < 650000, is_valid((sway_channel_t)late[i]));
            }
        }
        TEST_ASSERT_TRUE(rows > 80);
        TEST_ASSERT_EQUAL_UINT32(1, grid.faults.gaps);
    }
}

static void test_a_stamp_that_was_refused_is_forgotten_with_the_next_good_one(void)
{
    for (int refused = 0; refused < 2; refused++) {
        setUp();
        put(SWAY_INPUT_CAR_YAW_RATE, 0, 1);
        put(SWAY_INPUT_CAR_YAW_RATE, 10000, 1);
        if (refused != 0) {
            TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                                  sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, 5000, 1));
        }
        put(SWAY_INPUT_CAR_YAW_RATE, 20000, 1);
        take_row(20000);
        put(SWAY_INPUT_CAR_YAW_RATE, 120000, 1); // behind a gap, on its row
        take_row(120000);
        TEST_ASSERT_TRUE(is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    }
}

static void test_time_is_taken_up_to_its_limit(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        put(SWAY_INPUT_CAR_YAW_RATE, sign * SWAY_GRID_TIME_LIMIT, 1);
        TEST_ASSERT_EQUAL_INT(
            SWAY_ERROR_ARGUMENT,
            sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, sign * (SWAY_GRID_TIME_LIMIT + 1), 1));
    }
}

static void test_what_is_not_valid_is_delayed_as_what_is(void)
{
    sway_grid_config_t config = sway_grid_default(10000);
    config.delay_us[SWAY_INPUT_CAR_YAW_RATE] = 20000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    for (int64_t t = 20000; t <= 100000; t += 10000) {
        if (t == 60000) {
            sway_grid_invalid(&grid, SWAY_INPUT_CAR_YAW_RATE, t);
        } else {
            put(SWAY_INPUT_CAR_YAW_RATE, t, 1);
        }
    }
    for (int64_t row = 0; row <= 80000; row += 10000) {
        take_row(row);
        TEST_ASSERT_EQUAL(row != 40000, is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
    }
}

static void test_speed_is_held_for_half_a_second(void)
{
    put(SWAY_INPUT_SPEED, 0, 25000);
    for (int64_t t = 0; t <= 600000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 1);
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_EQUAL(tick.time_us <= 500000, is_valid(SWAY_CHANNEL_SPEED));
        }
    }
}

static void test_one_wheel_of_the_first_axle_is_no_axle(void)
{
    for (int64_t t = 0; t <= 20000; t += 10000) {
        put(SWAY_INPUT_CAR_FY_FL, t, 5);
    }
    take_row(10000);
    TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_CAR_FRONT_FY));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_input_is_interpolated_on_its_own_clock);
    RUN_TEST(test_interpolation_is_rounded_to_the_nearest);
    RUN_TEST(test_slow_messages_are_interpolated_too);
    RUN_TEST(test_wheels_of_an_axle_add_up);
    RUN_TEST(test_every_input_has_its_channel);
    RUN_TEST(test_a_delay_is_taken_from_the_timestamp);
    RUN_TEST(test_a_long_gap_is_marked_and_the_rest_goes_on);
    RUN_TEST(test_a_lost_frame_is_bridged);
    RUN_TEST(test_out_of_range_is_refused_and_counted);
    RUN_TEST(test_time_going_back_is_refused_and_the_next_is_taken);
    RUN_TEST(test_a_clock_that_restarts_is_followed);
    RUN_TEST(test_one_wild_stamp_does_no_harm);
    RUN_TEST(test_a_pause_of_the_bus_restarts_without_a_flood_of_rows);
    RUN_TEST(test_a_silent_input_is_waited_for_no_longer_than_configured);
    RUN_TEST(test_every_input_has_its_range);
    RUN_TEST(test_an_axle_is_present_when_both_wheels_are);
    RUN_TEST(test_a_restart_is_one_for_all_inputs);
    RUN_TEST(test_a_value_out_of_range_is_no_data);
    RUN_TEST(test_silence_is_counted_while_it_lasts_and_once);
    RUN_TEST(test_an_input_that_stays_away_after_a_restart_is_counted);
    RUN_TEST(test_a_rate_off_by_a_tenth_is_counted_and_no_data);
    RUN_TEST(test_lost_frames_jitter_and_other_plain_rates_are_no_wrong_rate);
    RUN_TEST(test_a_rate_that_comes_back_is_data_again);
    RUN_TEST(test_not_valid_from_the_sender);
    RUN_TEST(test_speed_is_held_between_slow_messages);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_calls_without_a_grid_or_an_input_are_refused);
    RUN_TEST(test_a_counter_stays_at_its_end);
    RUN_TEST(test_wild_stamps_far_from_each_other_are_not_believed);
    RUN_TEST(test_a_first_sample_of_long_ago_is_refused);
    RUN_TEST(test_a_speed_that_is_not_usable_is_not_held);
    RUN_TEST(test_ring_clips_and_marks);
    RUN_TEST(test_ring_sums_are_those_of_its_newest_rows);
    RUN_TEST(test_the_bounds_of_a_configuration_are_allowed);
    RUN_TEST(test_long_spans_are_interpolated_to_the_nearest);
    RUN_TEST(test_a_silence_that_outlasts_a_restart_is_counted_again);
    RUN_TEST(test_jumps_are_believed_as_it_is_said);
    RUN_TEST(test_a_sample_is_late_behind_its_row_and_refused_a_second_behind);
    RUN_TEST(test_rows_that_wait_are_not_written_over);
    RUN_TEST(test_a_steering_angle_that_is_not_valid_is_not);
    RUN_TEST(test_a_gap_is_longer_than_the_longest_that_is_allowed);
    RUN_TEST(test_the_rate_follows_by_a_sixty_fourth);
    RUN_TEST(test_the_rate_is_off_where_it_is_said);
    RUN_TEST(test_every_input_is_waited_for_in_every_row);
    RUN_TEST(test_a_stamp_that_was_refused_is_forgotten_with_the_next_good_one);
    RUN_TEST(test_time_is_taken_up_to_its_limit);
    RUN_TEST(test_what_is_not_valid_is_delayed_as_what_is);
    RUN_TEST(test_speed_is_held_for_half_a_second);
    RUN_TEST(test_one_wheel_of_the_first_axle_is_no_axle);
    return UNITY_END();
}

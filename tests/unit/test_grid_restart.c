/* What a grid keeps in its rows when the clock jumps, and when it has come round them once. */
#include "grid_feed.h"

/* Nothing of before: rows that waited, an input's silence. */
static void test_a_restart_leaves_nothing_of_before(void)
{
    for (int64_t t = 0; t <= 50000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 100);
        put(SWAY_INPUT_TRAILER_YAW_RATE, t < 20000 ? t : 20000, 200); // rows wait for it
    }
    for (int k = 0; k < 16; k++) {
        const sway_error_t error =
            sway_grid_input(&grid, SWAY_INPUT_CAR_YAW_RATE, -9000000 + 10000 * k, 7);
        TEST_ASSERT_EQUAL_INT(k < 15 ? SWAY_ERROR_TIME : SWAY_OK, error);
    }
    TEST_ASSERT_EQUAL_UINT32(16, grid.faults.time_backward);
    int rows = 0;
    for (int64_t t = -8840000; t < -8500000; t += 10000) {
        put(SWAY_INPUT_CAR_LATERAL_ACC, t, 5);
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_TRAILER_YAW_RATE));
            TEST_ASSERT_TRUE(!is_valid(SWAY_CHANNEL_CAR_YAW_RATE) || rows == 0);
            rows++;
        }
    }
    TEST_ASSERT_TRUE(rows > 20);
}

/* The row of this time is the next, with the car's yaw rate or without. */
static void take(int64_t time_us, bool valid)
{
    TEST_ASSERT_TRUE(sway_grid_next_row(&grid, &tick));
    TEST_ASSERT_EQUAL_INT64(time_us, tick.time_us);
    TEST_ASSERT_EQUAL(valid, is_valid(SWAY_CHANNEL_CAR_YAW_RATE));
}

/* Rows wait for one input, another has put its values into them; then the clock jumps by 9 s. */
static void jump(void)
{
    put(SWAY_INPUT_CAR_YAW_RATE, 0, 100);
    put(SWAY_INPUT_TRAILER_YAW_RATE, 0, 200);
    for (int64_t t = 10000; t <= 90000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 100);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_grid_input(&grid, SWAY_INPUT_TRAILER_YAW_RATE, 9000000, 200));
    put(SWAY_INPUT_TRAILER_YAW_RATE, 9000000, 200);
}

/* What had come for the rows before the jump is no reason not to wait for what comes after it. */
static void test_rows_wait_after_a_jump_as_before(void)
{
    jump();
    put(SWAY_INPUT_CAR_YAW_RATE, 9000000, 300);
    take(9000000, true);
    for (int64_t t = 9010000; t <= 9090000; t += 10000) {
        put(SWAY_INPUT_TRAILER_YAW_RATE, t, 200);
        TEST_ASSERT_FALSE(sway_grid_next_row(&grid, &tick));
    }
    for (int64_t t = 9010000; t <= 9090000; t += 10000) {
        put(SWAY_INPUT_CAR_YAW_RATE, t, 300);
        take(t, true);
        TEST_ASSERT_EQUAL_INT32(300, tick.value[SWAY_CHANNEL_CAR_YAW_RATE]);
    }
}

/* What was data before the jump does not make data of what is none after it. */
static void test_what_is_not_valid_after_a_jump_is_not(void)
{
    jump();
    for (int64_t t = 9000000; t <= 9300000; t += 10000) {
        put(SWAY_INPUT_TRAILER_YAW_RATE, t, 200);
        sway_grid_invalid(&grid, SWAY_INPUT_CAR_YAW_RATE, t);
        take(t, false);
    }
}

/* Once round its rows: what was valid in one does not make the next in its place valid. */
static void test_a_steering_angle_is_valid_for_its_own_row_only(void)
{
    for (int64_t t = 0; t <= 200000; t += 10000) {
        put(SWAY_INPUT_STEERING_WHEEL_ANGLE, t, 1);
    }
    while (sway_grid_next_row(&grid, &tick)) {
    }
    int rows = 0;
    for (int64_t t = 210000; t <= 800000; t += 10000) {
        sway_grid_invalid(&grid, SWAY_INPUT_STEERING_WHEEL_ANGLE, t);
        while (sway_grid_next_row(&grid, &tick)) {
            TEST_ASSERT_FALSE(is_valid(SWAY_CHANNEL_STEERING_WHEEL_ANGLE));
            rows++;
        }
    }
    TEST_ASSERT_TRUE(rows > 2 * SWAY_GRID_ROWS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_restart_leaves_nothing_of_before);
    RUN_TEST(test_rows_wait_after_a_jump_as_before);
    RUN_TEST(test_what_is_not_valid_after_a_jump_is_not);
    RUN_TEST(test_a_steering_angle_is_valid_for_its_own_row_only);
    return UNITY_END();
}

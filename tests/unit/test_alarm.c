/* Alarm states: what asks for each, hysteresis, hold, time to limit. */
#include "sway_alarm.h"
#include "sway_test.h"
#include "unity.h"

static sway_alarm_t alarm_;
static sway_alarm_input_t input;

void setUp(void)
{
    sway_alarm_config_t config;
    sway_alarm_defaults(&config);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_alarm_init(&alarm_, &config));
    memset(&input, 0, sizeof input);
    input.speed_mm_s = 25000;
    input.belief = SWAY_BELIEF_MODEL;
    input.damping.ratio = real(0.15);
    input.damping.se = real(0.01);
    input.damping.usable = true;
    input.has_critical_speed = true;
    input.is_identified = true;
    input.v_crit_mm_s = 34000;
    input.v_crit_se_mm_s = 500;
}

void tearDown(void)
{
}

static sway_alarm_state_t after(double seconds)
{
    input.time_us += (int64_t)(seconds * 1e6);
    input.mid_time_us = input.time_us - 1000000;
    sway_alarm_update(&alarm_, &input);
    return alarm_.state;
}

/* A free swing of the trailer with a yaw rate in deg/s. */
static void swing(double degrees, double growth, double ratio, double se)
{
    input.has_oscillation = true;
    input.belief = SWAY_BELIEF_BOTH;
    input.omega_rad_s = real(4.2);
    input.amplitude_rad_s = real(degrees * M_PI / 180);
    input.growth_1_s = real(growth);
    input.growth_se_1_s = real(0.02);
    input.damping.ratio = real(ratio);
    input.damping.se = real(se);
}

static void normal_when_there_is_margin(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.1));
    TEST_ASSERT_EQUAL_UINT32(0, alarm_.reasons);
    TEST_ASSERT_EQUAL_INT32(-1, alarm_.time_to_limit_ms);
}

static void off_without_speed_or_knowledge(void)
{
    input.speed_mm_s = -1;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, after(0.1));
    input.speed_mm_s = 8000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, after(0.1));
    input.speed_mm_s = 25000;
    input.belief = SWAY_BELIEF_NONE;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, after(0.1));
}

static void little_margin_is_noticed_with_hysteresis(void)
{
    input.speed_mm_s = 31300;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_SMALL_MARGIN, alarm_.reasons);
    input.speed_mm_s = 31000; // margin 3.0 m/s: above the threshold, within the hysteresis
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(5));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(5));
    input.speed_mm_s = 30000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.5)); // held
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(2));
}

static void above_critical_speed_warns_beyond_its_error(void)
{
    input.speed_mm_s = 35200; // 2.4 standard errors
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.speed_mm_s = 35300;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_ABOVE_CRITICAL_SPEED, alarm_.reasons);
    TEST_ASSERT_BITS_LOW(SWAY_REASON_STATIC, alarm_.reasons);
}

static void at_the_limit_amplitude_a_probable_excess_warns(void)
{
    input.speed_mm_s = 34500; // 1 standard error
    input.has_swing = true;
    input.amplitude_rad_s = real(0.2);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.amplitude_rad_s = real(0.27);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_ABOVE_CRITICAL_SPEED, alarm_.reasons);
}

static void a_users_stiffness_alone_does_not_warn(void)
{
    input.is_identified = false;
    input.speed_mm_s = 40000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
}

static void a_static_limit_is_named(void)
{
    input.is_static = true;
    input.speed_mm_s = 36000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_STATIC, alarm_.reasons);
}

static void a_decaying_swing_is_noticed_only_when_slow(void)
{
    swing(5, -0.5, 0.12, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.1));
    swing(5, -0.1, 0.03, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_LOW_DAMPING, alarm_.reasons);
}

static void a_growing_swing_warns_then_is_critical(void)
{
    swing(4, 0.1, -0.025, 0.01);
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_GROWING, alarm_.reasons);
    /* ln(15 / (4 e^0.1)) / 0.1 = 12.2 s */
    TEST_ASSERT_INT32_WITHIN(20, 12218, alarm_.time_to_limit_ms);
    swing(9, 0.1, -0.025, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_CRITICAL, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_LARGE_AMPLITUDE, alarm_.reasons);
    swing(6, 0.4, -0.09, 0.01);
    (void)after(0.1);
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_SHORT_TIME, alarm_.reasons);
}

static void small_or_uncertain_growth_does_not_warn(void)
{
    swing(1, 0.3, -0.07, 0.01);
    for (int i = 0; i < 50; i++) {
        TEST_ASSERT_LESS_THAN_INT(SWAY_ALARM_WARNING, after(0.1));
    }
    swing(5, 0.3, -0.07, 0.1);
    for (int i = 0; i < 50; i++) {
        TEST_ASSERT_LESS_THAN_INT(SWAY_ALARM_WARNING, after(0.1));
    }
}

static void a_forced_oscillation_does_not_warn(void)
{
    swing(20, 0.3, 0.15, 0.01);
    input.has_oscillation = false; // what the core says of a slalom
    input.belief = SWAY_BELIEF_MODEL;
    for (int i = 0; i < 50; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.1));
    }
}

static void growth_against_the_model_must_last_one_oscillation(void)
{
    swing(5, 0.3, -0.07, 0.01);
    input.belief = SWAY_BELIEF_SIGNAL;
    double warned = -1;
    for (int i = 0; i < 40 && warned < 0; i++) {
        if (after(0.1) >= SWAY_ALARM_WARNING) {
            warned = 0.1 * i;
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 2 * M_PI / 4.2, warned);
}

static void negative_thresholds_are_refused(void)
{
    sway_alarm_config_t config;
    sway_alarm_defaults(&config);
    config.hold_ms = -1;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_alarm_init(&alarm_, &config));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(normal_when_there_is_margin);
    RUN_TEST(off_without_speed_or_knowledge);
    RUN_TEST(little_margin_is_noticed_with_hysteresis);
    RUN_TEST(above_critical_speed_warns_beyond_its_error);
    RUN_TEST(at_the_limit_amplitude_a_probable_excess_warns);
    RUN_TEST(a_users_stiffness_alone_does_not_warn);
    RUN_TEST(a_static_limit_is_named);
    RUN_TEST(a_decaying_swing_is_noticed_only_when_slow);
    RUN_TEST(a_growing_swing_warns_then_is_critical);
    RUN_TEST(small_or_uncertain_growth_does_not_warn);
    RUN_TEST(a_forced_oscillation_does_not_warn);
    RUN_TEST(growth_against_the_model_must_last_one_oscillation);
    RUN_TEST(negative_thresholds_are_refused);
    return UNITY_END();
}

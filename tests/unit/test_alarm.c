/* Alarm states: what asks for each, hysteresis, hold, time to limit. */
#include "judge/sway_alarm.h"
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
    input.speed_mm_s = 34700; // 1.4 standard errors
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.speed_mm_s = 34800;
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

/* --- the thresholds themselves -----------------------------------------------------------------
 */

static sway_real_t urad(int32_t value)
{
    return sway_real_ratio(value, 1000000);
}

static void every_threshold_may_be_zero_but_not_negative(void)
{
    for (size_t i = 0; i < sizeof(sway_alarm_config_t) / sizeof(int32_t); i++) {
        for (int32_t value = -1; value <= 0; value++) {
            sway_alarm_config_t config;
            sway_alarm_defaults(&config);
            memcpy((char *)&config + i * sizeof(int32_t), &value, sizeof value);
            TEST_ASSERT_EQUAL_INT(value < 0 ? SWAY_ERROR_ARGUMENT : SWAY_OK,
                                  sway_alarm_init(&alarm_, &config));
        }
    }
}

static void off_below_the_minimum_speed(void)
{
    input.speed_mm_s = 8333;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.1));
    setUp();
    input.speed_mm_s = 8332;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, after(0.1));
}

static void small_margin_begins_and_ends_where_it_is_said(void)
{
    input.speed_mm_s = 34000 - 2778;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
    input.speed_mm_s = 34000 - 2777;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(3));
    input.speed_mm_s = 34000 - 3333;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(3));
    input.speed_mm_s = 34000 - 3334;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
    input.has_critical_speed = false;
    input.speed_mm_s = 50000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
}

/* 1.5 standard errors of 0.5 m/s; 0.75 where the swing is at the limit amplitude. */
static void the_excess_that_warns_is_that_many_errors(void)
{
    input.speed_mm_s = 34750;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.speed_mm_s = 34751;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    setUp();
    input.has_swing = true;
    input.amplitude_rad_s = urad(261799);
    input.speed_mm_s = 34375;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.speed_mm_s = 34376;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    setUp();
    input.speed_mm_s = 34376;
    input.has_swing = true;
    input.amplitude_rad_s = urad(261798);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.amplitude_rad_s = urad(300000);
    input.has_swing = false; /* an amplitude of nothing */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
}

static void low_damping_begins_and_ends_where_it_is_said(void)
{
    swing(5, -0.1, 0.05, 0.01);
    input.damping.ratio = urad(50000);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
    input.damping.ratio = urad(49999);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(3));
    input.damping.ratio = urad(64999);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(3));
    input.damping.ratio = urad(65000);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
    input.damping.ratio = urad(10000);
    input.amplitude_rad_s = urad(43632);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
    input.amplitude_rad_s = urad(43633);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(3));
    setUp();
    swing(5, -0.1, 0.01, 0.01);
    input.belief = SWAY_BELIEF_MODEL; /* the model's damping is no low damping of a swing */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(3));
}

static void time_to_limit_is_reported_only_of_a_free_growth(void)
{
    swing(4, 0.1, 0.1, 0.01);
    (void)after(0.1);
    TEST_ASSERT_INT32_WITHIN(20, 12218, alarm_.time_to_limit_ms);
    input.has_oscillation = false;
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT32(-1, alarm_.time_to_limit_ms);
    swing(4, 0, 0.1, 0.01);
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT32(-1, alarm_.time_to_limit_ms);
    swing(4, -0.1, 0.1, 0.01);
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT32(-1, alarm_.time_to_limit_ms);
    swing(20, 0.1, 0.1, 0.01); /* beyond the limit already */
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT32(0, alarm_.time_to_limit_ms);
    swing(0.001, 0.0001, 0.1, 0.01); /* an hour is the most */
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT32(3600000, alarm_.time_to_limit_ms);
}

/* What has to hold for growth to warn; each alone is not enough. */
static void growth_warns_when_it_is_sure(void)
{
    swing(5, 0.1, -0.025, 0.03);
    input.damping.ratio = urad(-22499); /* 0.75 errors of 0.03 would be 0.0225 */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.damping.ratio = urad(-22501);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    setUp();
    swing(5, 0.1, -0.1, 0.03);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1)); /* no time yet in which it grew */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    setUp();
    swing(5, 0.1, -0.1, 0.03);
    input.growth_se_1_s = input.growth_1_s; /* growth is not beyond its error */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    setUp();
    swing(5, 0.1, -0.1, 0.03);
    input.belief = SWAY_BELIEF_SIGNAL;
    for (int i = 0; i < 14; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1)); /* an oscillation is 1.5 s */
    }
    input.amplitude_rad_s = urad(43632); /* a break: it begins anew */
    (void)after(0.1);
    input.amplitude_rad_s = urad(43633);
    for (int i = 0; i < 14; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    }
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
}

static void a_large_or_soon_large_swing_is_critical(void)
{
    for (int k = 0; k < 2; k++) { /* exactly large, not more; then more */
        setUp();
        swing(8, 0.03, -0.025, 0.01);
        input.growth_se_1_s = real(0.001);
        input.time_us = 1000000;
        for (int i = 0; i < 3; i++) {
            input.time_us += 100000;
            input.mid_time_us = input.time_us; /* nothing to carry on */
            input.amplitude_rad_s = urad(139626 + k);
            sway_alarm_update(&alarm_, &input);
        }
        TEST_ASSERT_EQUAL_INT(k == 0 ? SWAY_ALARM_WARNING : SWAY_ALARM_CRITICAL, alarm_.state);
        TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_LOW_DAMPING | SWAY_REASON_GROWING |
                                     (k == 0 ? 0 : SWAY_REASON_LARGE_AMPLITUDE),
                                 alarm_.reasons);
    }
    /* ln(15/5) / g = 3 s at 0.366/s */
    for (int k = 0; k < 2; k++) {
        setUp();
        swing(5, k == 0 ? 0.3659 : 0.3665, -0.09, 0.01);
        for (int i = 0; i < 3; i++) {
            input.time_us += 100000;
            input.mid_time_us = input.time_us;
            sway_alarm_update(&alarm_, &input);
        }
        TEST_ASSERT_INT32_WITHIN(6, 3000, alarm_.time_to_limit_ms);
        TEST_ASSERT_EQUAL_INT(k == 0 ? SWAY_ALARM_WARNING : SWAY_ALARM_CRITICAL, alarm_.state);
    }
}

/* Down only after hold_ms without having been asked for; reasons are gathered meanwhile. */
static void a_state_is_held_and_its_reasons_too(void)
{
    input.speed_mm_s = 36000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(1));
    const uint32_t reasons = alarm_.reasons;
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_SMALL_MARGIN | SWAY_REASON_ABOVE_CRITICAL_SPEED, reasons);
    input.speed_mm_s = 25000;
    swing(5, -0.1, 0.03, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(1.999999));
    TEST_ASSERT_EQUAL_UINT32(reasons | SWAY_REASON_LOW_DAMPING, alarm_.reasons);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.000001));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_LOW_DAMPING, alarm_.reasons);
    input.speed_mm_s = 36000; /* up at once */
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.000001));
}

/* What the signals did in a pause nobody knows. */
static void growth_before_a_pause_does_not_count(void)
{
    input.belief = SWAY_BELIEF_SIGNAL;
    swing(4, 0.3, -0.07, 0.01);
    input.belief = SWAY_BELIEF_SIGNAL; // alone: it has to last an oscillation
    TEST_ASSERT_LESS_THAN(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_LESS_THAN(SWAY_ALARM_WARNING, after(30));
    TEST_ASSERT_LESS_THAN(SWAY_ALARM_WARNING, after(0.2));
    for (int k = 0; k < 8; k++) {
        (void)after(0.2);
    }
    TEST_ASSERT_GREATER_OR_EQUAL(SWAY_ALARM_WARNING, after(0.2));
}

/* A clock that starts again holds the state for its time from then on, no longer. */
static void a_clock_that_goes_back_does_not_hold_the_alarm(void)
{
    input.time_us = 1000000000;
    swing(10, 0.3, -0.07, 0.01);
    for (int k = 0; k < 20; k++) {
        (void)after(0.2);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_CRITICAL, alarm_.state);
    swing(10, -0.3, 0.07, 0.01);
    input.time_us = 5000000;
    sway_alarm_restart(&alarm_, input.time_us);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_CRITICAL, after(1.9));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.2));
}

static void thresholds_may_be_as_large_as_they_are_accepted(void)
{
    sway_alarm_config_t config;
    sway_alarm_defaults(&config);
    config.notice_margin_mm_s = INT32_MAX;
    config.margin_hysteresis_mm_s = INT32_MAX;
    config.notice_damping_ratio_ppm = INT32_MAX;
    config.damping_hysteresis_ppm = INT32_MAX;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_alarm_init(&alarm_, &config));
    swing(5, -0.5, 0.9, 0.01);
    for (int k = 0; k < 2; k++) { // with and without the hysteresis
        TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
        TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_SMALL_MARGIN | SWAY_REASON_LOW_DAMPING,
                                 alarm_.reasons);
    }
    config.confidence_milli = INT32_MAX;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_alarm_init(&alarm_, &config));
    input.has_swing = true;
    input.amplitude_rad_s = real(1);
    input.v_crit_se_mm_s = INT32_MAX;
    input.speed_mm_s = INT32_MAX;
    input.v_crit_mm_s = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.v_crit_se_mm_s = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
}

/* Below the range of the search there is no speed to compare with, and no error of it: what the
 * model says of the damping here decides, with its error. */
static void a_limit_below_the_range_warns_by_the_damping(void)
{
    input.has_critical_speed = false;
    input.is_below_range = true;
    input.v_crit_mm_s = 2778;
    input.v_crit_se_mm_s = 0;
    input.model.usable = true;
    input.model.ratio = real(-0.1);
    input.model.se = real(0.07); // 1.3 standard errors
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    input.model.se = real(0.03);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_ABOVE_CRITICAL_SPEED, alarm_.reasons);
    setUp();
    input.has_critical_speed = false;
    input.is_below_range = true;
    input.v_crit_mm_s = 2778;
    input.model.ratio = real(-0.1);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1)); // no model here
    input.model.usable = true;
    input.is_identified = false;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
}

/* Growth counts only while time goes on: an estimate of before begins it anew. */
static void time_that_goes_back_is_no_growth(void)
{
    swing(4, 0.3, -0.07, 0.01);
    (void)after(0.5);
    (void)after(0.5);
    TEST_ASSERT_EQUAL_INT64(500000, alarm_.growing_us);
    (void)after(-0.2);
    TEST_ASSERT_EQUAL_INT64(0, alarm_.growing_us);
    (void)after(0.5);
    TEST_ASSERT_EQUAL_INT64(500000, alarm_.growing_us);
}

static void before_the_first_estimate_no_time_to_the_limit_is_known(void)
{
    TEST_ASSERT_EQUAL_INT32(-1, alarm_.time_to_limit_ms);
    TEST_ASSERT_EQUAL_INT32(3000, alarm_.config.critical_time_ms);
}

/* One oscillation of growth against the model is enough, a microsecond less is not; estimates a
 * second apart still follow each other. */
static void growth_of_one_period_is_enough(void)
{
    for (int less_us = 0; less_us <= 1; less_us++) {
        setUp();
        swing(5, 0.1, -0.03, 0.01);
        input.belief = SWAY_BELIEF_SIGNAL;
        input.omega_rad_s = sway_real_scale(sway_real_pi(), 1); // a period of 1 s
        (void)after(10);
        input.time_us += 1000000 - less_us;
        sway_alarm_update(&alarm_, &input);
        TEST_ASSERT_EQUAL_INT(less_us == 0 ? SWAY_ALARM_WARNING : SWAY_ALARM_NOTICE, alarm_.state);
    }
}

static void a_damping_of_exactly_the_bound_does_not_warn(void)
{
    swing(5, 0.1, 0, 0);
    (void)after(0.1);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.1));
    setUp();
    input.is_below_range = true;
    input.model.usable = true;
    input.model.se = real(0.01);
    const sway_real_t errors = sway_real_add(input.model.se, sway_real_micro(5000));
    input.model.ratio = sway_real_neg(sway_real_mul(sway_real_ratio(1500, 1000), errors));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.1));
    input.model.ratio = sway_real_sub(input.model.ratio, real(1e-6));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_ABOVE_CRITICAL_SPEED, alarm_.reasons);
}

static void exactly_the_critical_time_is_not_critical(void)
{
    for (int more_ms = 0; more_ms <= 1; more_ms++) {
        setUp();
        swing(5, 0.3, -0.07, 0.01);
        (void)after(0.1);
        alarm_.config.critical_time_ms = alarm_.time_to_limit_ms + more_ms;
        TEST_ASSERT_EQUAL_INT(more_ms == 0 ? SWAY_ALARM_WARNING : SWAY_ALARM_CRITICAL, after(0.1));
    }
}

/* The reasons are those of now as long as the state is asked for, and its hold counts from the last
 * time that it was. */
static void a_state_that_goes_on_has_the_reasons_of_now(void)
{
    input.speed_mm_s = 32000;
    (void)after(0.1);
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_SMALL_MARGIN, alarm_.reasons);
    input.speed_mm_s = 25000;
    swing(5, -0.1, 0.03, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(1.5));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_LOW_DAMPING, alarm_.reasons);
    swing(5, -0.5, 0.2, 0.01);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE,
                          after(1.5)); // 3 s after the first, 1.5 s after the last
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, after(0.5));
}

static void off_has_no_reasons(void)
{
    input.speed_mm_s = 32000;
    (void)after(0.1);
    input.speed_mm_s = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, after(3));
    TEST_ASSERT_EQUAL_UINT32(0, alarm_.reasons);
}

/* A clock that starts again: growth of before does not count, that since then does. */
static void growth_begins_anew_with_the_clock(void)
{
    swing(5, 0.1, -0.03, 0.01);
    input.belief = SWAY_BELIEF_SIGNAL;
    (void)after(100);
    (void)after(0.9);
    (void)after(0.5); // of a period of 1.5 s
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, alarm_.state);
    sway_alarm_restart(&alarm_, 50000000);
    input.time_us = 50000000;
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.9));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, after(0.55));
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_WARNING, after(0.1));
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
    RUN_TEST(every_threshold_may_be_zero_but_not_negative);
    RUN_TEST(off_below_the_minimum_speed);
    RUN_TEST(small_margin_begins_and_ends_where_it_is_said);
    RUN_TEST(the_excess_that_warns_is_that_many_errors);
    RUN_TEST(low_damping_begins_and_ends_where_it_is_said);
    RUN_TEST(time_to_limit_is_reported_only_of_a_free_growth);
    RUN_TEST(growth_warns_when_it_is_sure);
    RUN_TEST(a_large_or_soon_large_swing_is_critical);
    RUN_TEST(a_state_is_held_and_its_reasons_too);
    RUN_TEST(growth_before_a_pause_does_not_count);
    RUN_TEST(a_clock_that_goes_back_does_not_hold_the_alarm);
    RUN_TEST(thresholds_may_be_as_large_as_they_are_accepted);
    RUN_TEST(a_limit_below_the_range_warns_by_the_damping);
    RUN_TEST(time_that_goes_back_is_no_growth);
    RUN_TEST(before_the_first_estimate_no_time_to_the_limit_is_known);
    RUN_TEST(growth_of_one_period_is_enough);
    RUN_TEST(a_damping_of_exactly_the_bound_does_not_warn);
    RUN_TEST(exactly_the_critical_time_is_not_critical);
    RUN_TEST(a_state_that_goes_on_has_the_reasons_of_now);
    RUN_TEST(off_has_no_reasons);
    RUN_TEST(growth_begins_anew_with_the_clock);
    return UNITY_END();
}

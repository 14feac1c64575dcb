/* What one estimate is judged by: each condition of its own. */
#include "judge/sway_judge.h"
#include "sway_test.h"
#include "unity.h"

static sway_judge_t judge;
static sway_judge_evidence_t evidence;
static sway_judgement_t judgement;
static sway_line_t line;
static sway_margin_model_t model;

void setUp(void)
{
    const test_plant_t plant = reference_plant(100);
    const sway_vehicle_t vehicle = reference_vehicle();
    sway_alarm_config_t alarm;
    sway_alarm_defaults(&alarm);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_judge_init(&judge, &vehicle, &alarm));
    plant_line(&plant, &vehicle, &line);
    for (int c = 0; c < (int)SWAY_CHANNELS; c++) {
        line.channel[c].amplitude_se = real(1e-4);
    }
    line.growth_se_1_s = real(0.01);
    line.omega_se_rad_s = real(0.01);
    line.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                      SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    memset(&model, 0, sizeof model);
    memset(&evidence, 0, sizeof evidence);
    evidence.time_us = 10000000;
    evidence.speed_mm_s = 27778;
    evidence.line = &line;
    evidence.model = &model;
}

void tearDown(void)
{
}

static void take(void)
{
    sway_judge_take(&judge, &evidence, &judgement);
}

static double size_of(sway_channel_t channel)
{
    return cabs(cvalue(line.channel[channel].amplitude));
}

static void the_swing_is_the_best_that_is_known_of_the_trailer(void)
{
    const uint32_t trailer = SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    const uint32_t car = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE);
    const double of_car = size_of(SWAY_CHANNEL_CAR_YAW_RATE);
    evidence.has_reconstruction = true;
    evidence.reconstructed_rad_s = real(0.123);
    line.valid_mask = trailer | car;
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, size_of(SWAY_CHANNEL_TRAILER_YAW_RATE),
                              value(judgement.swing_rad_s));
    setUp();
    evidence.has_reconstruction = true;
    evidence.reconstructed_rad_s = real(0.123);
    line.valid_mask = car;
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.123, value(judgement.swing_rad_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.123 * 1e-4 / of_car, value(judgement.swing_se_rad_s));
    setUp(); // what it is reconstructed from is not there: a motion stands in
    evidence.has_reconstruction = true;
    evidence.reconstructed_rad_s = real(0.123);
    line.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC);
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.066 * size_of(SWAY_CHANNEL_CAR_LATERAL_ACC),
                              value(judgement.swing_rad_s));
    setUp();
    line.valid_mask = car;
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.9 * of_car, value(judgement.swing_rad_s));
    setUp();
    line.valid_mask = 0;
    take();
    TEST_ASSERT_FALSE(judgement.has_swing);
    setUp();
    evidence.quality = SWAY_QUALITY_SEEKING;
    take();
    TEST_ASSERT_FALSE(judgement.has_swing);
}

static void a_hand_that_is_seen_and_not_understood_takes_the_signal(void)
{
    take();
    TEST_ASSERT_TRUE(judgement.signal.usable);
    setUp();
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    take(); // free, by the line
    TEST_ASSERT_TRUE(judgement.signal.usable);
    setUp();
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    evidence.quality = SWAY_QUALITY_FORCED; // how much of it is the hand's nobody can say
    take();
    TEST_ASSERT_TRUE(judgement.has_swing);
    TEST_ASSERT_FALSE(judgement.signal.usable);
}

static void only_a_model_of_this_estimate_is_below_its_range(void)
{
    model.has_model = true;
    model.source = SWAY_SOURCE_IDENTIFIED;
    model.kind = SWAY_VCRIT_BELOW_RANGE;
    model.v_crit_m_s = real(8.33);
    model.damping_ratio = real(-0.2);
    model.damping_ratio_se = real(0.01);
    evidence.modelled = false;
    take();
    TEST_ASSERT_BITS_LOW(SWAY_REASON_ABOVE_CRITICAL_SPEED | SWAY_REASON_SMALL_MARGIN,
                         judge.alarm.reasons);
    evidence.modelled = true;
    take();
    TEST_ASSERT_BITS_HIGH(SWAY_REASON_ABOVE_CRITICAL_SPEED, judge.alarm.reasons);
    setUp();
    model.has_model = true;
    model.source = SWAY_SOURCE_IDENTIFIED;
    model.kind = SWAY_VCRIT_NONE;
    model.damping_ratio = real(-0.2);
    model.damping_ratio_se = real(0.01);
    evidence.modelled = true;
    take();
    TEST_ASSERT_BITS_LOW(SWAY_REASON_ABOVE_CRITICAL_SPEED, judge.alarm.reasons);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_swing_is_the_best_that_is_known_of_the_trailer);
    RUN_TEST(a_hand_that_is_seen_and_not_understood_takes_the_signal);
    RUN_TEST(only_a_model_of_this_estimate_is_below_its_range);
    return UNITY_END();
}

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

/* What is not there is said, and what was said of the estimate stays said. */
static void quality_is_that_of_the_estimate_and_of_the_judgement(void)
{
    const uint32_t both = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                          SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    const struct {
        int32_t speed_mm_s;
        uint32_t valid, quality;
        bool modelled;
        sway_vcrit_t kind;
        uint32_t expected;
    } cases[] = {
        {27778, both, 0, true, SWAY_VCRIT_FOUND, 0},
        {8333, both, SWAY_QUALITY_GAP, true, SWAY_VCRIT_FOUND, SWAY_QUALITY_GAP},
        {8332, both, SWAY_QUALITY_GAP, true, SWAY_VCRIT_FOUND,
         SWAY_QUALITY_GAP | SWAY_QUALITY_SLOW},
        {0, both, 0, true, SWAY_VCRIT_FOUND, SWAY_QUALITY_SLOW},
        {-1, both, SWAY_QUALITY_MISFIT, true, SWAY_VCRIT_FOUND,
         SWAY_QUALITY_MISFIT | SWAY_QUALITY_NO_SPEED},
        {27778, both, SWAY_QUALITY_GAP, true, SWAY_VCRIT_SINGULAR,
         SWAY_QUALITY_GAP | SWAY_QUALITY_SINGULAR},
        {27778, both, 0, false, SWAY_VCRIT_SINGULAR, 0},
        {27778, SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC), SWAY_QUALITY_GAP, true,
         SWAY_VCRIT_FOUND, SWAY_QUALITY_GAP | SWAY_QUALITY_MISSING_INPUT},
        {27778, SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC), SWAY_QUALITY_SEEKING, true,
         SWAY_VCRIT_FOUND, SWAY_QUALITY_SEEKING},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        evidence.speed_mm_s = cases[i].speed_mm_s;
        evidence.quality = cases[i].quality;
        evidence.modelled = cases[i].modelled;
        line.valid_mask = cases[i].valid;
        model.kind = cases[i].kind;
        take();
        TEST_ASSERT_EQUAL_HEX32(cases[i].expected, judgement.quality);
    }
}

static void a_motion_stands_in_by_what_was_learnt_of_it(void)
{
    set_channel(&line, SWAY_CHANNEL_ARTICULATION, 0.02);
    line.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_ARTICULATION);
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 4 * 0.02, value(judgement.swing_rad_s));
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    take(); // learns a quarter of the way
    const double swing = size_of(SWAY_CHANNEL_TRAILER_YAW_RATE);
    line.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_ARTICULATION);
    take();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.75 * 4 * 0.02 + 0.25 * swing, value(judgement.swing_rad_s));
}

/* A speed that is gone is remembered for a while, and as long as there is a swing. */
static void a_speed_is_remembered(void)
{
    evidence.modelled = true;
    model.has_model = true;
    model.damping_ratio = real(0.1);
    model.damping_ratio_se = real(0.01);
    evidence.quality = SWAY_QUALITY_SEEKING; // no swing
    take();
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, judge.alarm.state);
    evidence.speed_mm_s = -1;
    evidence.time_us += 60000000;
    take();
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, judge.alarm.state);
    evidence.quality = 0;
    evidence.time_us += 1000000;
    take();
    TEST_ASSERT_TRUE(judge.alarm.state >= SWAY_ALARM_NORMAL);
}

static void a_swing_without_any_speed_is_judged_and_one_of_standing_is_not(void)
{
    evidence.speed_mm_s = -1;
    take();
    TEST_ASSERT_TRUE(judge.alarm.state >= SWAY_ALARM_NORMAL);
    setUp();
    evidence.speed_mm_s = 0;
    take();
    evidence.speed_mm_s = -1;
    take();
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, judge.alarm.state);
}

static void only_a_free_swing_without_gaps_teaches_what_disturbs_it(void)
{
    static const uint32_t bad[] = {SWAY_QUALITY_FORCED, SWAY_QUALITY_GAP, SWAY_QUALITY_SEEKING};
    for (int i = 0; i < 3; i++) {
        setUp();
        evidence.modelled = true;
        model.has_model = true;
        model.damping_ratio_se = real(0.01);
        evidence.quality = bad[i];
        take();
        TEST_ASSERT_FALSE(judge.disturbance.started);
    }
    setUp();
    take();
    TEST_ASSERT_TRUE(judge.disturbance.started);
    sway_judge_restart(&judge, 5000);
    TEST_ASSERT_EQUAL_INT64(5000, judge.disturbance.time_us);
    TEST_ASSERT_EQUAL_INT64(5000, judge.last_speed_us);
}

static void a_critical_speed_warns_by_its_own_error(void)
{
    evidence.modelled = true;
    evidence.quality = SWAY_QUALITY_SEEKING;
    model.source = SWAY_SOURCE_IDENTIFIED;
    model.has_model = true;
    model.damping_ratio_se = real(0.5);
    model.kind = SWAY_VCRIT_FOUND;
    model.v_crit_m_s = real(25.0);
    model.v_crit_se_m_s = real(2.0); // 27.778 is 1.4 of them above
    take();
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN, judge.alarm.reasons);
    model.v_crit_se_m_s = real(1.8);
    take();
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN | SWAY_REASON_ABOVE_CRITICAL_SPEED,
                            judge.alarm.reasons);
}

static void the_swing_is_carried_on_from_the_middle_of_its_window(void)
{
    line.growth_1_s = real(0.5);
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.03);
    line.mid_time_us = evidence.time_us - 1500000;
    take();
    const double now = size_of(SWAY_CHANNEL_TRAILER_YAW_RATE) * exp(0.5 * 1.5);
    TEST_ASSERT_INT_WITHIN(2, (int)(1000 * log(0.261799 / now) / 0.5),
                           judge.alarm.time_to_limit_ms);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_swing_is_the_best_that_is_known_of_the_trailer);
    RUN_TEST(a_hand_that_is_seen_and_not_understood_takes_the_signal);
    RUN_TEST(only_a_model_of_this_estimate_is_below_its_range);
    RUN_TEST(quality_is_that_of_the_estimate_and_of_the_judgement);
    RUN_TEST(a_motion_stands_in_by_what_was_learnt_of_it);
    RUN_TEST(a_speed_is_remembered);
    RUN_TEST(a_swing_without_any_speed_is_judged_and_one_of_standing_is_not);
    RUN_TEST(only_a_free_swing_without_gaps_teaches_what_disturbs_it);
    RUN_TEST(a_critical_speed_warns_by_its_own_error);
    RUN_TEST(the_swing_is_carried_on_from_the_middle_of_its_window);
    return UNITY_END();
}

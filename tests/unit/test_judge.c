/* The judge on evidence that is made by hand: what each piece of it does, and what its absence. */
#include "judge/sway_judge.h"
#include "sway_test.h"
#include "unity.h"

#define BIT(channel) SWAY_CHANNEL_BIT(SWAY_CHANNEL_##channel)
#define SECOND_US INT64_C(1000000)

static sway_judge_t judge;
static sway_vehicle_t vehicle;
static sway_alarm_config_t alarm;
static sway_judge_evidence_t evidence;
static sway_judgement_t judgement;
static sway_line_t line;
static sway_margin_model_t model;

/* Motions of the line: none has the size of another. */
static const struct {
    sway_channel_t channel;
    double re, im, size;
} MOTION[] = {
    {SWAY_CHANNEL_STEERING_WHEEL_ANGLE, 0.012, 0.005, 0.013},
    {SWAY_CHANNEL_CAR_YAW_RATE, 0.024, -0.007, 0.025},
    {SWAY_CHANNEL_CAR_LATERAL_ACC, -0.32, 0.24, 0.4},
    {SWAY_CHANNEL_TRAILER_YAW_RATE, 0.036, 0.048, 0.06},
    {SWAY_CHANNEL_TRAILER_LATERAL_ACC, 0.3, -0.4, 0.5},
    {SWAY_CHANNEL_ARTICULATION, 0.008, 0.006, 0.01},
};
#define TRAILER_SWING 0.06
#define CAR_SWING 0.025

static void start(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_judge_init(&judge, &vehicle, &alarm));
}

/* A free swing of both yaw rates at 27.8 m/s, 7 % damped; no model. States end at once. */
void setUp(void)
{
    vehicle = reference_vehicle();
    sway_alarm_defaults(&alarm);
    alarm.hold_ms = 0;
    start();
    memset(&line, 0, sizeof line);
    for (unsigned i = 0; i < sizeof MOTION / sizeof MOTION[0]; i++) {
        const sway_channel_t channel = MOTION[i].channel;
        set_channel(&line, channel, MOTION[i].re + MOTION[i].im * I);
        line.channel[channel].amplitude_se = real(0.01 * (1 + (int)channel) * MOTION[i].size);
    }
    line.valid_mask = BIT(CAR_YAW_RATE) | BIT(TRAILER_YAW_RATE);
    line.growth_1_s = real(-0.3);
    line.growth_se_1_s = real(0.01);
    line.omega_rad_s = real(4);
    line.mid_time_us = 9 * SECOND_US;
    memset(&model, 0, sizeof model);
    memset(&evidence, 0, sizeof evidence);
    evidence.time_us = 10 * SECOND_US;
    evidence.speed_mm_s = 27778;
    evidence.line = &line;
    evidence.model = &model;
}

void tearDown(void)
{
}

/* What was in the judgement before does not count. */
static void take(void)
{
    memset(&judgement, 0x55, sizeof judgement);
    judgement.has_swing = true;
    judgement.signal.usable = true;
    judgement.combined.usable = true;
    sway_judge_take(&judge, &evidence, &judgement);
}

static void take_at(double seconds)
{
    evidence.time_us = llround(seconds * 1e6);
    take();
}

static void set_model(double damping, double se)
{
    evidence.modelled = true;
    model.has_model = true;
    model.damping_ratio = real(damping);
    model.damping_ratio_se = real(se);
}

/* A model of identified stiffnesses, well damped where it is, with this limit. */
static void set_limit(sway_vcrit_t kind, double m_s, double se_m_s)
{
    set_model(0.1, 0.05);
    model.source = SWAY_SOURCE_IDENTIFIED;
    model.kind = kind;
    model.v_crit_m_s = real(m_s);
    model.v_crit_se_m_s = real(se_m_s);
}

static void no_line(void)
{
    evidence.quality |= SWAY_QUALITY_SEEKING;
}

static double damping_of_line(void)
{
    const double g = value(line.growth_1_s);
    return -g / hypot(g, value(line.omega_rad_s));
}

/* Of the fit, by the growth's error alone. */
static double se_of_fit(void)
{
    const double g = value(line.growth_1_s), w = value(line.omega_rad_s);
    return w * w / pow(hypot(g, w), 3) * value(line.growth_se_1_s);
}

/* Twice the fit's, 3 mrad/s of the road, and 3/4 of what is steered, over the swing. */
static double se_of_signal(double swing, double steered)
{
    return hypot(2 * se_of_fit(), hypot(0.003, 0.75 * steered) / swing);
}

/* --- how large the swing is --------------------------------------------------------------------
 */

static void expect_swing(double swing, double relative_se)
{
    take();
    TEST_ASSERT_TRUE(judgement.has_swing);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7 * swing, swing, value(judgement.swing_rad_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7 * swing, swing * relative_se, value(judgement.swing_se_rad_s));
}

static void expect_no_swing(void)
{
    take();
    TEST_ASSERT_FALSE(judgement.has_swing);
    TEST_ASSERT_TRUE(sway_real_is_zero(judgement.swing_rad_s));
    TEST_ASSERT_TRUE(sway_real_is_zero(judgement.swing_se_rad_s));
    TEST_ASSERT_FALSE(judgement.signal.usable);
}

/* Half of all combinations are within 6 % of these; the first that is there is taken. */
static void each_motion_stands_in_by_its_own_factor_the_best_first(void)
{
    static const struct {
        sway_channel_t channel;
        double factor;
    } standin[] = {
        {SWAY_CHANNEL_CAR_YAW_RATE, 1.9},
        {SWAY_CHANNEL_ARTICULATION, 4},
        {SWAY_CHANNEL_TRAILER_LATERAL_ACC, 0.051},
        {SWAY_CHANNEL_CAR_LATERAL_ACC, 0.066},
    };
    for (unsigned first = 0; first < 4; first++) {
        line.valid_mask = BIT(STEERING_WHEEL_ANGLE) | BIT(HITCH_FY); // no motions
        for (unsigned i = first; i < 4; i++) {
            line.valid_mask |= SWAY_CHANNEL_BIT(standin[i].channel);
        }
        const sway_channel_t channel = standin[first].channel;
        const double size = cabs(cvalue(line.channel[channel].amplitude));
        expect_swing(standin[first].factor * size, 0.01 * (1 + (int)channel));
    }
    line.valid_mask = BIT(STEERING_WHEEL_ANGLE) | BIT(HITCH_FY);
    expect_no_swing();
}

static void a_car_without_trailer_swings_by_its_own_yaw_rate(void)
{
    vehicle.trailer.axles = 0;
    start();
    expect_swing(CAR_SWING, 0.02);
    TEST_ASSERT_EQUAL_HEX32(0, judgement.quality);
    vehicle.trailer.axles = 1;
    start();
    expect_swing(TRAILER_SWING, 0.04);
}

static void a_line_that_is_not_held_has_no_swing(void)
{
    evidence.quality = SWAY_QUALITY_NO_OSCILLATION;
    expect_no_swing();
    evidence.quality = SWAY_QUALITY_SEEKING;
    expect_no_swing();
    evidence.quality = ~(uint32_t)(SWAY_QUALITY_SEEKING | SWAY_QUALITY_NO_OSCILLATION);
    expect_swing(TRAILER_SWING, 0.04);
}

static void a_reconstruction_is_better_than_a_motion_and_has_the_error_of_what_it_is_of(void)
{
    evidence.has_reconstruction = true;
    evidence.reconstructed_rad_s = real(0.2);
    expect_swing(TRAILER_SWING, 0.04);
    line.valid_mask = BIT(CAR_YAW_RATE) | BIT(ARTICULATION);
    expect_swing(0.2, 0.02);
    line.valid_mask = BIT(ARTICULATION); // it is of the car's yaw rate
    expect_swing(4 * 0.01, 0.06);
    setUp(); // without a reconstruction
    line.valid_mask = BIT(CAR_YAW_RATE);
    expect_swing(1.9 * CAR_SWING, 0.02);
}

/* A quarter of the way each time, of what stands clear of its noise. */
static void how_much_of_the_swing_goes_with_a_motion_is_learnt(void)
{
    static const struct {
        double errors; // size over standard error
        bool is_valid, learns;
    } cases[] = {{8.01, true, true}, {7.99, true, false}, {100, false, false}, {100, true, true}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        line.channel[SWAY_CHANNEL_ARTICULATION].amplitude_se = real(0.01 / cases[i].errors);
        line.valid_mask = BIT(TRAILER_YAW_RATE) | (cases[i].is_valid ? BIT(ARTICULATION) : 0U);
        take();
        take();
        const double gap = cases[i].learns ? 0.75 * 0.75 : 1;
        const double factor = TRAILER_SWING / 0.01;
        line.valid_mask = BIT(ARTICULATION);
        expect_swing(0.01 * (factor + gap * (4 - factor)), 1 / cases[i].errors);
        expect_swing(0.01 * (factor + gap * (4 - factor)), 1 / cases[i].errors); // nor from itself
    }
}

static void all_motions_are_learnt_beside_each_other(void)
{
    static const sway_channel_t standin[] = {SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_ARTICULATION,
                                             SWAY_CHANNEL_TRAILER_LATERAL_ACC,
                                             SWAY_CHANNEL_CAR_LATERAL_ACC};
    for (unsigned i = 0; i < sizeof MOTION / sizeof MOTION[0]; i++) {
        line.valid_mask |= SWAY_CHANNEL_BIT(MOTION[i].channel);
    }
    for (int i = 0; i < 80; i++) { // until no more than 1e-9 of the first guess is left
        take();
    }
    for (unsigned i = 0; i < 4; i++) {
        line.valid_mask = SWAY_CHANNEL_BIT(standin[i]);
        expect_swing(TRAILER_SWING, 0.01 * (1 + (int)standin[i]));
    }
}

/* --- what the line says ------------------------------------------------------------------------
 */

static void expect_signal(double swing, double steered)
{
    take();
    TEST_ASSERT_TRUE(judgement.signal.usable);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, damping_of_line(), value(judgement.signal.ratio));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, se_of_signal(swing, steered), value(judgement.signal.se));
}

static void a_free_swing_is_evidence_with_its_error_however_large(void)
{
    expect_signal(TRAILER_SWING, 0);
    setUp();
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.006); // twice the road's
    expect_signal(0.006, 0);
    TEST_ASSERT_TRUE(value(judgement.signal.se) > 0.4);
    setUp();
    no_line();
    take();
    TEST_ASSERT_FALSE(judgement.signal.usable);
    TEST_ASSERT_TRUE(sway_real_is_zero(judgement.signal.ratio));
}

/* The yaw rate that would follow the wheel slowly: angle / ratio x gain, of either sign. */
static void a_hand_on_the_wheel_takes_certainty(void)
{
    line.valid_mask |= BIT(STEERING_WHEEL_ANGLE);
    model.has_steady = true;
    for (int sign = -1; sign <= 1; sign += 2) {
        start();
        model.steady.yaw_rate_gain_1_s = real(sign * 7.5);
        expect_signal(TRAILER_SWING, 0.013 / 15 * 7.5);
    }
    vehicle.car.steering_ratio_milli = 10000;
    start();
    expect_signal(TRAILER_SWING, 0.013 / 10 * 7.5);
    start();
    model.has_steady = false; // free, so the hand is small however much follows it
    expect_signal(TRAILER_SWING, 0);
    start();
    model.has_steady = true;
    line.valid_mask &= ~BIT(STEERING_WHEEL_ANGLE);
    expect_signal(TRAILER_SWING, 0);
}

static void a_forced_swing_is_evidence_only_if_the_hand_explains_little_of_it(void)
{
    static const struct {
        double se;
        bool forced, usable;
    } cases[] = {
        {0.0999, true, true}, {0.1001, true, false}, {0.5, true, false}, {0.5, false, true}};
    model.has_steady = true;
    line.valid_mask |= BIT(STEERING_WHEEL_ANGLE);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const double of_hand = sqrt(pow(cases[i].se, 2) - pow(se_of_signal(TRAILER_SWING, 0), 2));
        const double steered = of_hand * TRAILER_SWING / 0.75;
        start();
        model.steady.yaw_rate_gain_1_s = real(steered * 15 / 0.013);
        evidence.quality = cases[i].forced ? SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP : 0U;
        take();
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, cases[i].se, value(judgement.signal.se));
        TEST_ASSERT_EQUAL(cases[i].usable, judgement.signal.usable);
        TEST_ASSERT_EQUAL(cases[i].usable ? SWAY_BELIEF_SIGNAL : SWAY_BELIEF_NONE,
                          judgement.belief);
    }
}

static void a_forced_swing_by_a_hand_of_unknown_effect_is_no_evidence(void)
{
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.6); // the error alone would do
    line.valid_mask |= BIT(STEERING_WHEEL_ANGLE);
    take();
    TEST_ASSERT_TRUE(judgement.signal.usable);
    evidence.quality = SWAY_QUALITY_FORCED;
    take();
    TEST_ASSERT_TRUE(judgement.has_swing);
    TEST_ASSERT_FALSE(judgement.signal.usable);
    TEST_ASSERT_TRUE(sway_real_is_zero(judgement.signal.ratio));
    line.valid_mask &= ~BIT(STEERING_WHEEL_ANGLE); // no hand was seen
    take();
    TEST_ASSERT_TRUE(judgement.signal.usable);
}

/* --- what is believed --------------------------------------------------------------------------
 */

static void a_model_is_believed_if_it_is_there_and_of_this_estimate(void)
{
    for (int i = 0; i < 4; i++) {
        setUp();
        no_line();
        set_model(0.11, 0.03);
        evidence.modelled = (i & 1) != 0;
        model.has_model = (i & 2) != 0;
        take();
        TEST_ASSERT_EQUAL(i == 3, judgement.combined.usable);
        TEST_ASSERT_EQUAL(i == 3 ? SWAY_BELIEF_MODEL : SWAY_BELIEF_NONE, judgement.belief);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.11, value(judgement.combined.ratio));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.03, value(judgement.combined.se));
}

/* By their variances; the model's is that of 0.5 % at the least beside its own. */
static void signal_and_model_are_weighed_by_their_errors(void)
{
    set_model(0.02, 0.04);
    evidence.quality = SWAY_QUALITY_GAP;
    take();
    const double se = se_of_signal(TRAILER_SWING, 0);
    const double by_signal = 1 / (se * se), by_model = 1 / (0.04 * 0.04 + 0.005 * 0.005);
    const double both = (damping_of_line() * by_signal + 0.02 * by_model) / (by_signal + by_model);
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_BOTH, judgement.belief);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, both, value(judgement.combined.ratio));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1 / sqrt(by_signal + by_model), value(judgement.combined.se));
    TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_GAP, judgement.quality);
}

static void a_swing_that_contradicts_the_model_says_so(void)
{
    set_model(-0.2, 0.04); // four of both errors away
    evidence.quality = SWAY_QUALITY_MISFIT;
    take();
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_SIGNAL, judgement.belief);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, damping_of_line(), value(judgement.combined.ratio));
    TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_MISFIT | SWAY_QUALITY_MODEL_DISAGREES, judgement.quality);
}

/* --- what disturbs the swing -------------------------------------------------------------------
 */

/* How the error of the line changes when a second has passed, with a swing of these qualities. */
static void learns_from(uint32_t quality, uint32_t valid, bool expected)
{
    setUp();
    set_model(0.02, 0.01);
    take(); // the first one begins
    const double before = se_of_signal(TRAILER_SWING, 0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, before, value(judgement.signal.se));
    evidence.quality = quality;
    line.valid_mask = valid;
    take_at(11);
    evidence.quality = 0;
    line.valid_mask = BIT(TRAILER_YAW_RATE);
    take_at(11);
    const bool learnt = fabs(value(judgement.signal.se) - before) > 1e-4;
    TEST_ASSERT_EQUAL(expected, learnt);
}

static void every_free_swing_teaches_what_disturbs_it(void)
{
    const uint32_t yaw = BIT(TRAILER_YAW_RATE);
    learns_from(0, yaw, true);
    learns_from(SWAY_QUALITY_MISFIT | SWAY_QUALITY_NONLINEAR, yaw, true);
    learns_from(SWAY_QUALITY_FORCED, yaw, false);
    learns_from(SWAY_QUALITY_GAP, yaw, false);
    learns_from(SWAY_QUALITY_SEEKING, yaw, false);
    learns_from(SWAY_QUALITY_NO_OSCILLATION, yaw, false);
    learns_from(0, BIT(STEERING_WHEEL_ANGLE), false); // no motion
}

/* From signal less combined, in this swing, with this hand on the wheel. */
static void the_disturbance_is_learnt_from_what_was_judged(void)
{
    line.valid_mask |= BIT(STEERING_WHEEL_ANGLE);
    model.has_steady = true;
    model.steady.yaw_rate_gain_1_s = real(0.5);
    set_model(0.02, 0.01);
    take();
    sway_disturbance_t expected = judge.disturbance;
    take_at(12);
    sway_disturbance_learn(&expected, 12 * SECOND_US,
                           real(damping_of_line() - value(judgement.combined.ratio)),
                           real(TRAILER_SWING), real(0.013 / 15 * 0.5));
    TEST_ASSERT_TRUE(value(judgement.combined.ratio) < damping_of_line() - 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1,
                              value(judge.disturbance.variance) / value(expected.variance));
    TEST_ASSERT_EQUAL_INT32(8 * SECOND_US, judge.disturbance.learnt_us); // 6 of no experience
    TEST_ASSERT_EQUAL_INT64(12 * SECOND_US, judge.disturbance.time_us);
}

/* --- quality and what is missing ---------------------------------------------------------------
 */

static uint32_t quality_with(uint32_t quality, uint32_t valid)
{
    evidence.quality = quality;
    line.valid_mask = valid;
    take();
    return judgement.quality;
}

static void a_line_without_a_yaw_rate_misses_an_input(void)
{
    const uint32_t missing = SWAY_QUALITY_MISSING_INPUT, gap = SWAY_QUALITY_GAP;
    const uint32_t acc = BIT(CAR_LATERAL_ACC), car = BIT(CAR_YAW_RATE);
    const uint32_t trailer = BIT(TRAILER_YAW_RATE);
    TEST_ASSERT_EQUAL_HEX32(gap | missing, quality_with(gap, acc));
    TEST_ASSERT_EQUAL_HEX32(gap, quality_with(gap, acc | car));
    TEST_ASSERT_EQUAL_HEX32(gap, quality_with(gap, acc | trailer));
    TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_SEEKING, quality_with(SWAY_QUALITY_SEEKING, acc));
    TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_NO_OSCILLATION,
                            quality_with(SWAY_QUALITY_NO_OSCILLATION, acc));
    vehicle.trailer.axles = 0;
    start();
    TEST_ASSERT_EQUAL_HEX32(gap, quality_with(gap, acc | car));
    TEST_ASSERT_EQUAL_HEX32(gap | missing, quality_with(gap, acc | trailer));
}

static void a_speed_is_none_slow_or_enough(void)
{
    static const struct {
        int32_t least, speed;
        uint32_t quality;
    } cases[] = {
        {8333, INT32_MAX, 0},
        {8333, 8333, 0},
        {8333, 8332, SWAY_QUALITY_SLOW},
        {8333, 0, SWAY_QUALITY_SLOW},
        {8333, -1, SWAY_QUALITY_NO_SPEED},
        {20000, 19999, SWAY_QUALITY_SLOW},
        {20000, 20000, 0},
        {0, 0, 0},
        {0, -1, SWAY_QUALITY_NO_SPEED},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        alarm.minimum_speed_mm_s = cases[i].least;
        start();
        evidence.speed_mm_s = cases[i].speed;
        evidence.quality = SWAY_QUALITY_HITCH;
        take();
        TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_HITCH | cases[i].quality, judgement.quality);
    }
}

static void only_a_singular_model_of_this_estimate_is_reported(void)
{
    for (int kind = SWAY_VCRIT_NONE; kind <= SWAY_VCRIT_DIVERGENCE; kind++) {
        const bool is_singular = kind == SWAY_VCRIT_SINGULAR;
        model.kind = (sway_vcrit_t)kind;
        evidence.quality = SWAY_QUALITY_HITCH;
        evidence.modelled = true;
        take();
        TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_HITCH | (is_singular ? SWAY_QUALITY_SINGULAR : 0),
                                judgement.quality);
        evidence.modelled = false;
        take();
        TEST_ASSERT_EQUAL_HEX32(SWAY_QUALITY_HITCH, judgement.quality);
    }
}

/* Missing now, or too often for the line; a speed is in no line. */
static void an_input_that_came_before_is_missing_when_the_line_is_without_it(void)
{
    const uint32_t yaw = BIT(TRAILER_YAW_RATE) | BIT(CAR_YAW_RATE), speed = BIT(SPEED);
    const struct {
        uint32_t valid, seen, missing, expected;
    } cases[] = {
        {yaw, yaw | speed, 0, 0},
        {yaw, yaw | speed | BIT(HITCH_FX), 0, BIT(HITCH_FX)},
        {yaw, yaw | BIT(HITCH_FX), BIT(CAR_YAW_RATE), BIT(HITCH_FX) | BIT(CAR_YAW_RATE)},
        {yaw, 0, speed, speed},
        {BIT(CAR_YAW_RATE), yaw, 0, BIT(TRAILER_YAW_RATE)},
        {0, yaw | speed, 0, 0}, // there is no line
        {0, yaw | speed, BIT(CAR_YAW_RATE), BIT(CAR_YAW_RATE)},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        line.valid_mask = cases[i].valid;
        evidence.seen_mask = cases[i].seen;
        evidence.missing_mask = cases[i].missing;
        take();
        TEST_ASSERT_EQUAL_HEX32(cases[i].expected, judgement.missing_mask);
    }
}

/* --- the speed that is judged ------------------------------------------------------------------
 */

static bool is_judged(void)
{
    take();
    return judge.alarm.state != SWAY_ALARM_OFF;
}

static void without_a_swing_a_lost_speed_counts_for_ten_seconds(void)
{
    set_model(0.1, 0.05);
    no_line();
    TEST_ASSERT_TRUE(is_judged());
    evidence.speed_mm_s = -1;
    evidence.time_us += 10 * SECOND_US - 1;
    TEST_ASSERT_TRUE(is_judged());
    evidence.time_us += 1;
    TEST_ASSERT_FALSE(is_judged());
    evidence.speed_mm_s = 27778;
    TEST_ASSERT_TRUE(is_judged());
    evidence.speed_mm_s = -1;
    evidence.time_us += 10 * SECOND_US - 1; // from its newest sample
    TEST_ASSERT_TRUE(is_judged());
}

static void with_a_swing_a_lost_speed_counts_as_long_as_it_sways(void)
{
    set_model(0.1, 0.05);
    take();
    evidence.speed_mm_s = -1;
    evidence.time_us += 3600 * SECOND_US;
    TEST_ASSERT_TRUE(is_judged());
    no_line();
    TEST_ASSERT_FALSE(is_judged());
}

static void the_lost_speed_is_the_newest(void)
{
    evidence.speed_mm_s = 8333;
    TEST_ASSERT_TRUE(is_judged());
    evidence.speed_mm_s = -1;
    TEST_ASSERT_TRUE(is_judged());
    evidence.speed_mm_s = 8332;
    TEST_ASSERT_FALSE(is_judged());
    evidence.speed_mm_s = -1;
    TEST_ASSERT_FALSE(is_judged());
    evidence.speed_mm_s = 27778;
    TEST_ASSERT_TRUE(is_judged());
    evidence.speed_mm_s = 0; // known: it stands
    TEST_ASSERT_FALSE(is_judged());
    evidence.speed_mm_s = -1;
    TEST_ASSERT_FALSE(is_judged());
}

/* Where every speed is judged, still none is one that is not known. */
static void a_speed_that_never_came_is_judged_with_a_swing_only(void)
{
    for (int32_t least = 0; least <= 8333; least += 8333) {
        setUp();
        alarm.minimum_speed_mm_s = least;
        start();
        TEST_ASSERT_EQUAL_INT32(-1, judge.last_speed_mm_s);
        set_model(0.1, 0.05);
        evidence.speed_mm_s = -1;
        evidence.time_us = SECOND_US; // less than ten seconds after any beginning
        no_line();
        TEST_ASSERT_FALSE(is_judged());
        evidence.quality = 0;
        TEST_ASSERT_TRUE(is_judged());
        no_line();
        TEST_ASSERT_FALSE(is_judged());
        evidence.speed_mm_s = least;
        TEST_ASSERT_TRUE(is_judged());
        evidence.speed_mm_s = -1;
        evidence.time_us = 11 * SECOND_US;
        TEST_ASSERT_FALSE(is_judged());
    }
}

/* --- what the alarm is given ---------------------------------------------------------------------
 */

static uint32_t reasons(void)
{
    take();
    TEST_ASSERT_EQUAL_INT64(evidence.time_us, judge.alarm.last_us);
    return judge.alarm.reasons;
}

/* Notice is at 2778 mm/s of margin, to the millimetre per second. */
static void a_margin_is_that_of_a_limit_that_was_found_now(void)
{
    alarm.margin_hysteresis_mm_s = 0;
    for (int kind = SWAY_VCRIT_NONE; kind <= SWAY_VCRIT_DIVERGENCE; kind++) {
        const bool has = kind == SWAY_VCRIT_FOUND || kind == SWAY_VCRIT_DIVERGENCE;
        model.kind = (sway_vcrit_t)kind;
        TEST_ASSERT_EQUAL(has, sway_judge_has_limit(&model));
        setUp();
        no_line();
        alarm.margin_hysteresis_mm_s = 0;
        start();
        set_limit((sway_vcrit_t)kind, 30.556, 0.1);
        TEST_ASSERT_EQUAL_HEX32(0, reasons());
        model.v_crit_m_s = real(30.555);
        const bool small = has || kind == SWAY_VCRIT_BELOW_RANGE; // that says 10 km/h
        TEST_ASSERT_EQUAL_HEX32(small ? SWAY_REASON_SMALL_MARGIN : 0, reasons());
        evidence.modelled = false;
        evidence.quality = 0; // there is still something to judge
        TEST_ASSERT_EQUAL_HEX32(0, reasons());
    }
}

static void the_error_of_a_limit_is_taken_to_the_millimetre(void)
{
    const uint32_t small = SWAY_REASON_SMALL_MARGIN;
    const uint32_t above = small | SWAY_REASON_ABOVE_CRITICAL_SPEED;
    no_line();
    set_limit(SWAY_VCRIT_FOUND, 27.777, 0);
    TEST_ASSERT_EQUAL_HEX32(above, reasons()); // by 1 mm/s, and nothing is unsure
    set_limit(SWAY_VCRIT_FOUND, 26.278, 1);
    TEST_ASSERT_EQUAL_HEX32(small, reasons()); // by 1.5 errors
    set_limit(SWAY_VCRIT_FOUND, 26.277, 1);
    TEST_ASSERT_EQUAL_HEX32(above, reasons());
    set_limit(SWAY_VCRIT_DIVERGENCE, 26.277, 1);
    TEST_ASSERT_EQUAL_HEX32(above | SWAY_REASON_STATIC, reasons());
    model.source = SWAY_SOURCE_PARTLY; // what the user says of the tyres does not warn
    TEST_ASSERT_EQUAL_HEX32(small, reasons());
    model.source = SWAY_SOURCE_USER;
    TEST_ASSERT_EQUAL_HEX32(small, reasons());
}

/* Such a limit is reported with its error; what it would say of this speed is a guess. */
static void a_vague_limit_raises_no_notice(void)
{
    no_line();
    set_limit(SWAY_VCRIT_FOUND, 25.0, 0);
    model.vague = true;
    TEST_ASSERT_EQUAL_HEX32(0, reasons());
    set_limit(SWAY_VCRIT_BELOW_RANGE, 2.778, 0);
    model.vague = true;
    TEST_ASSERT_EQUAL_HEX32(0, reasons());
    model.vague = false;
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN, reasons());
}

/* Then 3/4 of an error is enough. */
static void a_swing_at_the_limit_amplitude_warns_sooner(void)
{
    set_limit(SWAY_VCRIT_FOUND, 26.278, 1);
    evidence.quality = SWAY_QUALITY_FORCED; // however it came there
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN, reasons());
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.2617);
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN, reasons());
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.2619);
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_SMALL_MARGIN | SWAY_REASON_ABOVE_CRITICAL_SPEED, reasons());
}

/* At 10 km/h and unstable already: its limit says nothing, its damping does. */
static void a_model_that_is_unstable_at_any_speed_warns_by_its_damping(void)
{
    const uint32_t small = SWAY_REASON_SMALL_MARGIN;
    no_line();
    set_limit(SWAY_VCRIT_BELOW_RANGE, 2.778, 0);
    TEST_ASSERT_EQUAL_HEX32(small, reasons());
    set_model(-0.2, 0.05);
    TEST_ASSERT_EQUAL_HEX32(small | SWAY_REASON_ABOVE_CRITICAL_SPEED, reasons());
    set_model(-0.2, 0.15);
    TEST_ASSERT_EQUAL_HEX32(small, reasons());
    model.kind = SWAY_VCRIT_FOUND; // by far above a limit that has no error
    TEST_ASSERT_EQUAL_HEX32(small | SWAY_REASON_ABOVE_CRITICAL_SPEED, reasons());
    model.kind = SWAY_VCRIT_BEYOND_RANGE;
    TEST_ASSERT_EQUAL_HEX32(0, reasons());
}

static void a_swing_that_is_little_damped_is_noticed(void)
{
    line.growth_1_s = real(-0.1); // 2.5 %
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_LOW_DAMPING, reasons());
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, judge.alarm.state);
    set_model(0.14, 0.02); // the combination is above 5 %
    TEST_ASSERT_EQUAL_HEX32(0, reasons());
    evidence.modelled = false;
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.0436); // too small to be seen
    TEST_ASSERT_EQUAL_HEX32(0, reasons());
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.0437);
    TEST_ASSERT_EQUAL_HEX32(SWAY_REASON_LOW_DAMPING, reasons());
}

/* Swings of 0.12 rad/s from 10 s on, ten in a second; when growth is reported first, or -1. */
static double growing_since(double growth, double growth_se, double omega)
{
    set_channel(&line, SWAY_CHANNEL_TRAILER_YAW_RATE, 0.12);
    line.growth_1_s = real(growth);
    line.growth_se_1_s = real(growth_se);
    line.omega_rad_s = real(omega);
    for (int k = 0; k < 40; k++) {
        line.mid_time_us = 10 * SECOND_US + 100000 * k;
        take_at(10 + 0.1 * k);
        if ((judge.alarm.reasons & SWAY_REASON_GROWING) != 0U) {
            return 0.1 * k;
        }
    }
    return -1;
}

static void growth_warns_by_itself_after_one_oscillation(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.6, growing_since(0.3, 0.01, 4)); // 2 pi / 4 = 1.571
    setUp();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.1, growing_since(0.3, 0.01, 3));
    setUp();
    TEST_ASSERT_EQUAL_DOUBLE(-1, growing_since(-0.3, 0.01, 4));
}

static void growth_that_the_model_predicts_warns_at_once_if_it_is_sure(void)
{
    set_model(-0.2, 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1, growing_since(0.3, 0.28, 4));
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_BOTH, judgement.belief);
    setUp();
    set_model(-0.2, 0.01);
    TEST_ASSERT_EQUAL_DOUBLE(-1, growing_since(0.3, 0.32, 4));
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_BOTH, judgement.belief);
}

/* From now on; the swing is that of the middle of its window. */
static void a_time_to_the_limit_is_that_of_growth_that_is_evidence(void)
{
    const double age = 2.5, growth = 0.2;
    line.growth_1_s = real(growth);
    line.mid_time_us = evidence.time_us - (int64_t)(age * 1e6);
    take();
    const double seconds = log(0.261799 / TRAILER_SWING) / growth - age;
    TEST_ASSERT_INT_WITHIN(1, (int)lround(1000 * seconds), judge.alarm.time_to_limit_ms);
    line.valid_mask |= BIT(STEERING_WHEEL_ANGLE);
    evidence.quality = SWAY_QUALITY_FORCED; // by a hand of unknown effect
    take();
    TEST_ASSERT_EQUAL_INT32(-1, judge.alarm.time_to_limit_ms);
}

/* --- beginning ---------------------------------------------------------------------------------
 */

static void a_bad_threshold_is_refused(void)
{
    alarm.confidence_milli = -1;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_judge_init(&judge, &vehicle, &alarm));
}

static void nothing_that_was_in_memory_counts(void)
{
    static sway_judge_t clean;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_judge_init(&clean, &vehicle, &alarm));
    for (int i = 0; i < 5; i++) { // a judge that has learnt
        line.valid_mask |= BIT(ARTICULATION);
        take_at(10 + i);
    }
    TEST_ASSERT_TRUE(memcmp(&clean, &judge, sizeof judge) != 0);
    start();
    TEST_ASSERT_EQUAL_MEMORY(&clean, &judge, sizeof judge);
}

static void a_speed_counts_for_ten_seconds_of_a_clock_that_began_again(void)
{
    set_model(0.1, 0.05);
    no_line();
    take_at(100);
    sway_judge_restart(&judge, SECOND_US);
    evidence.speed_mm_s = -1;
    take_at(10.9);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, judge.alarm.state);
    take_at(11);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, judge.alarm.state);
}

static void the_disturbance_is_learnt_on_when_the_clock_begins_again(void)
{
    static sway_judge_t other;
    set_model(0.02, 0.01);
    take_at(100);
    other = judge;
    sway_judge_restart(&judge, SECOND_US);
    take_at(3);
    const sway_disturbance_t after = judge.disturbance;
    judge = other; // the same without
    take_at(102);
    TEST_ASSERT_EQUAL_INT32(judge.disturbance.learnt_us, after.learnt_us);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, value(judge.disturbance.variance), value(after.variance));
    TEST_ASSERT_TRUE(fabs(value(after.variance) - 0.003 * 0.003) > 1e-8);
}

static void a_state_is_held_from_the_beginning_of_the_new_clock(void)
{
    alarm.hold_ms = 2000;
    start();
    no_line();
    set_limit(SWAY_VCRIT_FOUND, 29, 1);
    take_at(100);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, judge.alarm.state);
    sway_judge_restart(&judge, SECOND_US);
    model.v_crit_m_s = real(40);
    take_at(2.9);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NOTICE, judge.alarm.state);
    take_at(3);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_NORMAL, judge.alarm.state);
}

static void what_was_learnt_of_a_motion_stays_when_the_clock_begins_again(void)
{
    line.valid_mask = BIT(TRAILER_YAW_RATE) | BIT(ARTICULATION);
    take();
    sway_judge_restart(&judge, SECOND_US);
    line.valid_mask = BIT(ARTICULATION);
    expect_swing(0.75 * 4 * 0.01 + 0.25 * TRAILER_SWING, 0.06);
}

/* The first damping ratio of a model, in steps of 0.001, that the line of 0.075 contradicts. */
static double apart(bool reconstructed)
{
    for (double ratio = 0.1; ratio < 1; ratio += 0.001) {
        setUp();
        evidence.has_reconstruction = reconstructed;
        set_model(ratio, 0.01);
        take();
        if ((judgement.quality & SWAY_QUALITY_MODEL_DISAGREES) != 0U) {
            return ratio - 0.075;
        }
    }
    return 1;
}

/* Four errors of difference; three where the model is of the car's own sensors. */
static void a_model_of_the_cars_own_sensors_is_left_sooner(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 4.0 / 3, apart(false) / apart(true));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_model_of_the_cars_own_sensors_is_left_sooner);
    RUN_TEST(each_motion_stands_in_by_its_own_factor_the_best_first);
    RUN_TEST(a_car_without_trailer_swings_by_its_own_yaw_rate);
    RUN_TEST(a_line_that_is_not_held_has_no_swing);
    RUN_TEST(a_reconstruction_is_better_than_a_motion_and_has_the_error_of_what_it_is_of);
    RUN_TEST(how_much_of_the_swing_goes_with_a_motion_is_learnt);
    RUN_TEST(all_motions_are_learnt_beside_each_other);
    RUN_TEST(a_free_swing_is_evidence_with_its_error_however_large);
    RUN_TEST(a_hand_on_the_wheel_takes_certainty);
    RUN_TEST(a_forced_swing_is_evidence_only_if_the_hand_explains_little_of_it);
    RUN_TEST(a_forced_swing_by_a_hand_of_unknown_effect_is_no_evidence);
    RUN_TEST(a_model_is_believed_if_it_is_there_and_of_this_estimate);
    RUN_TEST(signal_and_model_are_weighed_by_their_errors);
    RUN_TEST(a_swing_that_contradicts_the_model_says_so);
    RUN_TEST(every_free_swing_teaches_what_disturbs_it);
    RUN_TEST(the_disturbance_is_learnt_from_what_was_judged);
    RUN_TEST(a_line_without_a_yaw_rate_misses_an_input);
    RUN_TEST(a_speed_is_none_slow_or_enough);
    RUN_TEST(only_a_singular_model_of_this_estimate_is_reported);
    RUN_TEST(an_input_that_came_before_is_missing_when_the_line_is_without_it);
    RUN_TEST(without_a_swing_a_lost_speed_counts_for_ten_seconds);
    RUN_TEST(with_a_swing_a_lost_speed_counts_as_long_as_it_sways);
    RUN_TEST(the_lost_speed_is_the_newest);
    RUN_TEST(a_speed_that_never_came_is_judged_with_a_swing_only);
    RUN_TEST(a_margin_is_that_of_a_limit_that_was_found_now);
    RUN_TEST(the_error_of_a_limit_is_taken_to_the_millimetre);
    RUN_TEST(a_vague_limit_raises_no_notice);
    RUN_TEST(a_swing_at_the_limit_amplitude_warns_sooner);
    RUN_TEST(a_model_that_is_unstable_at_any_speed_warns_by_its_damping);
    RUN_TEST(a_swing_that_is_little_damped_is_noticed);
    RUN_TEST(growth_warns_by_itself_after_one_oscillation);
    RUN_TEST(growth_that_the_model_predicts_warns_at_once_if_it_is_sure);
    RUN_TEST(a_time_to_the_limit_is_that_of_growth_that_is_evidence);
    RUN_TEST(a_bad_threshold_is_refused);
    RUN_TEST(nothing_that_was_in_memory_counts);
    RUN_TEST(a_speed_counts_for_ten_seconds_of_a_clock_that_began_again);
    RUN_TEST(the_disturbance_is_learnt_on_when_the_clock_begins_again);
    RUN_TEST(a_state_is_held_from_the_beginning_of_the_new_clock);
    RUN_TEST(what_was_learnt_of_a_motion_stays_when_the_clock_begins_again);
    return UNITY_END();
}

/* One estimate into integers: the unit of every field, what is written when, valid and old. */
#include "core/sway_publish.h"
#include "sway_test.h"
#include "unity.h"

static sway_status_t status;
static sway_status_t blank;
static sway_identify_t id;
static sway_line_t line;
static sway_margin_model_t model;
static sway_publish_t from;
static sway_judgement_t judgement;
static sway_alarm_t alarm_;

static sway_complex_t polar(double size, double angle)
{
    return complex_of(size * cexp(I * angle));
}

/* Numbers in which a thousandth of a unit would show. */
void setUp(void)
{
    memset(&status, 0, sizeof status);
    memset(&blank, 0, sizeof blank);
    memset(&id, 0, sizeof id);
    memset(&line, 0, sizeof line);
    memset(&model, 0, sizeof model);
    memset(&from, 0, sizeof from);
    memset(&judgement, 0, sizeof judgement);
    memset(&alarm_, 0, sizeof alarm_);
    alarm_.time_to_limit_ms = -1;
    from.judgement = &judgement;
    from.alarm = &alarm_;
    from.speed_mm_s = -1;
    for (int k = 0; k < SWAY_AXLE_COUNT; k++) {
        sway_axle_estimate_t *const axle = &id.axle[k];
        axle->stiffness.value = polar(100000 + k, -0.02);
        axle->stiffness.se = real(1234);
        axle->slip = sway_phasor_constant(polar(0.03, 2));
        axle->force = sway_phasor_constant(polar(3000, 2));
        axle->load_n = real(8000);
        axle->effective_load_n = real(7000);
        axle->effective_load_se_n = real(5555);
        axle->load_harmonic_n = polar(4000, 1);
    }
    id.car_inertia = (sway_estimate_t){polar(2690, 0.1), real(1500)};
    id.trailer_inertia = (sway_estimate_t){polar(10350, -0.2), real(2500)};
    id.trailer_inertia_1 = (sway_estimate_t){polar(10100, 0.3), real(3500)};
    id.trailer_inertia_2 = (sway_estimate_t){polar(10200, 0.3), real(4500)};
}

void tearDown(void)
{
}

static void put_parts(void)
{
    for (uint32_t part = 0; part < SWAY_PUBLISH_PARTS; part++) {
        sway_publish_part(&status, &id, part);
    }
}

static void stiffness_is_reported_of_its_axle_alone(void)
{
    for (unsigned k = 0; k < SWAY_AXLE_COUNT; k++) {
        setUp();
        id.valid = (uint32_t)SWAY_VALID_CAR_FRONT << k;
        put_parts();
        const sway_axle_status_t *const a = &status.axle[k];
        TEST_ASSERT_EQUAL_INT32(100000 + (int)k, a->cornering_stiffness_n_per_rad);
        TEST_ASSERT_EQUAL_INT32(1234, a->cornering_stiffness_se_n_per_rad);
        TEST_ASSERT_INT32_WITHIN(1, -20000, a->argument_urad);
        TEST_ASSERT_INT32_WITHIN(1, 12340, a->argument_se_urad);
        TEST_ASSERT_INT32_WITHIN(1, 30000, a->slip_amplitude_urad);
        TEST_ASSERT_INT32_WITHIN(1, 3000000, a->force_amplitude_mn);
        const sway_axle_status_t given = {.cornering_stiffness_n_per_rad = 100000 + (int)k,
                                          .cornering_stiffness_se_n_per_rad = 1234,
                                          .argument_urad = a->argument_urad,
                                          .argument_se_urad = a->argument_se_urad,
                                          .slip_amplitude_urad = a->slip_amplitude_urad,
                                          .force_amplitude_mn = a->force_amplitude_mn};
        blank.axle[k] = given;
        TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
        memset(&blank, 0, sizeof blank);
    }
}

static void loads_are_reported_of_their_axle_alone(void)
{
    for (unsigned k = 0; k < SWAY_AXLE_COUNT; k++) {
        setUp();
        id.valid = (uint32_t)SWAY_VALID_CAR_FRONT_LOAD << k;
        put_parts();
        sway_axle_status_t *const a = &status.axle[k];
        TEST_ASSERT_EQUAL_INT32(8000000, a->load_mn);
        TEST_ASSERT_EQUAL_INT32(7000000, a->effective_load_mn);
        TEST_ASSERT_EQUAL_INT32(5555000, a->effective_load_se_mn);
        TEST_ASSERT_INT32_WITHIN(1, 4000000, a->load_harmonic_mn);
        TEST_ASSERT_INT32_WITHIN(1, 1000000, a->load_harmonic_phase_urad);
        TEST_ASSERT_INT32_WITHIN(1, 14286, a->normalised_stiffness_milli_per_rad);
        TEST_ASSERT_INT32_WITHIN(1, 428571, a->lateral_friction_ppm);
        TEST_ASSERT_EQUAL_INT32(0, a->cornering_stiffness_n_per_rad);
        memset(a, 0, sizeof *a);
        TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
    }
}

static void inertias_are_reported_each_by_its_bit(void)
{
    put_parts();
    TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status); /* nothing is valid */
    id.valid = SWAY_VALID_CAR_INERTIA;
    put_parts();
    TEST_ASSERT_INT32_WITHIN(1, 2690000, status.car_yaw_inertia_gm2);
    TEST_ASSERT_EQUAL_INT32(1500000, status.car_yaw_inertia_se_gm2);
    TEST_ASSERT_INT32_WITHIN(1, 100000, status.car_yaw_inertia_argument_urad);
    status.car_yaw_inertia_gm2 = status.car_yaw_inertia_se_gm2 = 0;
    status.car_yaw_inertia_argument_urad = 0;
    TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
    id.valid = SWAY_VALID_TRAILER_INERTIA;
    put_parts();
    TEST_ASSERT_INT32_WITHIN(1, 10350000, status.trailer_yaw_inertia_gm2);
    TEST_ASSERT_EQUAL_INT32(2500000, status.trailer_yaw_inertia_se_gm2);
    TEST_ASSERT_INT32_WITHIN(1, -200000, status.trailer_yaw_inertia_argument_urad);
    status.trailer_yaw_inertia_gm2 = status.trailer_yaw_inertia_se_gm2 = 0;
    status.trailer_yaw_inertia_argument_urad = 0;
    TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
    id.valid = SWAY_VALID_TRAILER_INERTIA_1;
    put_parts();
    TEST_ASSERT_INT32_WITHIN(1, 10100000, status.trailer_yaw_inertia_1_gm2);
    status.trailer_yaw_inertia_1_gm2 = 0;
    TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
    id.valid = SWAY_VALID_TRAILER_INERTIA_2;
    put_parts();
    TEST_ASSERT_INT32_WITHIN(1, 10200000, status.trailer_yaw_inertia_2_gm2);
}

static void a_value_beyond_its_integer_is_its_end(void)
{
    id.valid = SWAY_VALID_CAR_FRONT_LOAD;
    id.axle[0].load_n = real(1e9);
    id.axle[0].effective_load_n = real(-1e9);
    put_parts();
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, status.axle[0].load_mn);
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, status.axle[0].effective_load_mn);
}

/* --- all but the parts -------------------------------------------------------------------------
 */

static void nothing_known_says_nothing(void)
{
    from.time_us = INT64_C(123456789012);
    judgement.quality = SWAY_QUALITY_NO_SPEED;
    blank.time_to_limit_ms = -1;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_INT64(from.time_us, status.time_us);
    TEST_ASSERT_EQUAL_UINT32(SWAY_QUALITY_NO_SPEED, status.quality);
    status.time_us = 0;
    status.quality = 0;
    TEST_ASSERT_EQUAL_MEMORY(&blank, &status, sizeof status);
}

static void speed_zero_is_known(void)
{
    status.speed_mm_s = 5;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(0, status.valid);
    TEST_ASSERT_EQUAL_INT32(5, status.speed_mm_s);
    from.speed_mm_s = 0;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_SPEED, status.valid);
    TEST_ASSERT_EQUAL_INT32(0, status.speed_mm_s);
}

static void the_line_is_reported_in_its_units(void)
{
    line.mid_time_us = 987654321;
    line.omega_rad_s = real(2 * M_PI * 600);
    line.omega_se_rad_s = real(2 * M_PI * 500);
    line.growth_1_s = real(-700);
    line.growth_se_1_s = real(800);
    line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude = polar(300, 1);
    line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude_se = real(200);
    line.channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude = polar(150, 1);
    line.channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude_se = real(100);
    from.line = &line;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_LINE, status.valid);
    TEST_ASSERT_EQUAL_INT64(987654321, status.mid_time_us);
    TEST_ASSERT_INT32_WITHIN(3, 600000000, status.frequency_uhz);
    TEST_ASSERT_INT32_WITHIN(3, 500000000, status.frequency_se_uhz);
    TEST_ASSERT_INT32_WITHIN(3, -700000000, status.growth_ppm_per_s);
    TEST_ASSERT_INT32_WITHIN(3, 800000000, status.growth_se_ppm_per_s);
    const double ratio = 700 / hypot(700, 2 * M_PI * 600);
    TEST_ASSERT_INT32_WITHIN(1, (int32_t)lround(ratio * 1e6), status.damping_ratio_ppm);
    TEST_ASSERT_EQUAL_INT32(0, status.amplitude_urad_s); /* no swing in it */
    judgement.swing_rad_s = real(150);
    judgement.swing_se_rad_s = real(100);
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_INT32(0, status.amplitude_urad_s);
    judgement.has_swing = true;
    sway_publish(&status, &from);
    TEST_ASSERT_INT32_WITHIN(3, 150000000, status.amplitude_urad_s);
    TEST_ASSERT_EQUAL_INT32(100000000, status.amplitude_se_urad_s);
}

static void what_is_identified_counts_only_while_a_line_is_held(void)
{
    id.valid = SWAY_VALID_CAR_FRONT | SWAY_VALID_TRAILER_INERTIA;
    from.identify = &id;
    for (int bit = 0; bit < SWAY_QUALITY_BITS; bit++) {
        judgement.quality = 1U << bit;
        sway_publish(&status, &from);
        const bool nothing = judgement.quality == SWAY_QUALITY_NO_OSCILLATION ||
                             judgement.quality == SWAY_QUALITY_SEEKING;
        TEST_ASSERT_EQUAL_UINT32(nothing ? 0 : id.valid, status.valid);
        TEST_ASSERT_EQUAL_UINT32(judgement.quality, status.quality);
    }
}

static void the_model_is_reported_in_its_units(void)
{
    from.model = &model;
    model.kind = SWAY_VCRIT_NONE;
    model.source = SWAY_SOURCE_PARTLY;
    model.damping_ratio = real(0.123456);
    model.damping_ratio_se = real(1234);
    model.root = complex_of(-1 + 2 * M_PI * 700 * I);
    model.v_crit_m_s = real(34567);
    model.v_crit_se_m_s = real(1234);
    for (int i = 0; i < SWAY_PARAMETER_COUNT; i++) {
        model.sensitivity_m_s[i] = real(5000 + i);
    }
    model.steady.understeer_gradient_rad = real(101);
    model.steady.combination_understeer_gradient_rad = real(-102);
    model.steady.characteristic_speed_m_s = real(10300);
    model.steady.yaw_rate_gain_1_s = real(104);
    model.steady.hitch_angle_gain = real(-105);
    from.speed_mm_s = 2000000;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_SPEED, status.valid);
    TEST_ASSERT_EQUAL_INT32(SWAY_SOURCE_PARTLY, status.source);
    TEST_ASSERT_EQUAL_INT32(0, status.understeer_gradient_urad);
    TEST_ASSERT_EQUAL_INT32(0, status.model_damping_ratio_ppm);
    model.has_model = true;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_SPEED | SWAY_VALID_MODEL, status.valid);
    TEST_ASSERT_EQUAL_INT32(123456, status.model_damping_ratio_ppm);
    TEST_ASSERT_EQUAL_INT32(1234000000, status.model_damping_ratio_se_ppm);
    TEST_ASSERT_INT32_WITHIN(3, 700000000, status.model_frequency_uhz);
    TEST_ASSERT_EQUAL_INT32(0, status.v_crit_mm_s);
    model.has_steady = true;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_INT32(101000000, status.understeer_gradient_urad);
    TEST_ASSERT_EQUAL_INT32(-102000000, status.combination_understeer_gradient_urad);
    TEST_ASSERT_EQUAL_INT32(10300000, status.characteristic_speed_mm_s);
    TEST_ASSERT_EQUAL_INT32(104000000, status.yaw_rate_gain_micro_per_s);
    TEST_ASSERT_EQUAL_INT32(-105000000, status.hitch_angle_gain_ppm);
}

/* The largest swing in which a tyre was seen; below the limit's the critical speed says so. */
static void a_critical_speed_says_up_to_which_swing_it_was_seen(void)
{
    static const struct {
        int32_t swing_mrad_s;
        uint32_t valid;
        uint32_t quality;
        int32_t seen_mrad_s;
        bool small;
    } cases[] = {
        {100, SWAY_VALID_TRAILER_INERTIA, 0, 0, true},
        {100, SWAY_VALID_CAR_FRONT, SWAY_QUALITY_SEEKING, 0, true},
        {100, SWAY_VALID_CAR_FRONT, 0, 100, true},
        {50, SWAY_VALID_TRAILER_REAR, 0, 100, true},
        {299, SWAY_VALID_TRAILER_FRONT, 0, 299, true},
        {300, SWAY_VALID_CAR_REAR, 0, 300, false},
        {10, SWAY_VALID_CAR_REAR, 0, 300, false},
    };
    sway_alarm_t alarm;
    memset(&alarm, 0, sizeof alarm);
    alarm.config.limit_amplitude_urad_s = 300000;
    from.alarm = &alarm;
    from.identify = &id;
    from.model = &model;
    from.line = &line;
    judgement.has_swing = true;
    model.kind = SWAY_VCRIT_FOUND;
    memset(&status, 0, sizeof status);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        id.valid = cases[i].valid;
        judgement.quality = cases[i].quality;
        judgement.swing_rad_s = real(cases[i].swing_mrad_s * 1e-3 + 1e-9);
        sway_publish(&status, &from);
        TEST_ASSERT_INT32_WITHIN(1, 1000 * cases[i].seen_mrad_s, status.v_crit_swing_urad_s);
        TEST_ASSERT_EQUAL(cases[i].small, (status.quality & SWAY_QUALITY_SMALL_SWING) != 0U);
    }
}

static void a_critical_speed_is_reported_of_every_kind_that_has_one(void)
{
    from.model = &model;
    model.v_crit_m_s = real(34567);
    model.v_crit_se_m_s = real(1234);
    for (int i = 0; i < SWAY_PARAMETER_COUNT; i++) {
        model.sensitivity_m_s[i] = real(5000 + i);
    }
    for (int kind = SWAY_VCRIT_NONE; kind <= SWAY_VCRIT_DIVERGENCE; kind++) {
        /* What ends at a bound of the search is no critical speed. */
        const bool has = kind == SWAY_VCRIT_FOUND || kind == SWAY_VCRIT_DIVERGENCE;
        memset(&status, 0, sizeof status);
        model.kind = (sway_vcrit_t)kind;
        from.speed_mm_s = -1;
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_INT32(kind, status.v_crit_kind);
        TEST_ASSERT_EQUAL_UINT32(has ? SWAY_VALID_CRITICAL_SPEED : 0, status.valid);
        TEST_ASSERT_EQUAL_INT32(has ? 34567000 : 0, status.v_crit_mm_s);
        TEST_ASSERT_EQUAL_INT32(has ? 1234000 : 0, status.v_crit_se_mm_s);
        for (int i = 0; i < SWAY_PARAMETER_COUNT; i++) {
            TEST_ASSERT_EQUAL_INT32(has ? 5000000 + 1000 * i : 0, status.sensitivity_mm_s[i]);
        }
        TEST_ASSERT_EQUAL_INT32(0, status.margin_mm_s);
        from.speed_mm_s = 0;
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_INT32(has ? 34567000 : 0, status.margin_mm_s);
        from.speed_mm_s = 40000000;
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_INT32(has ? -5433000 : 0, status.margin_mm_s);
    }
}

static void the_belief_makes_the_combined_damping_valid(void)
{
    judgement.combined.ratio = real(-0.012345);
    judgement.combined.se = real(1234);
    for (int belief = SWAY_BELIEF_NONE; belief <= SWAY_BELIEF_BOTH; belief++) {
        memset(&status, 0, sizeof status);
        judgement.belief = (sway_belief_t)belief;
        sway_publish(&status, &from);
        const bool known = belief != SWAY_BELIEF_NONE;
        TEST_ASSERT_EQUAL_INT32(belief, status.belief);
        TEST_ASSERT_EQUAL_UINT32(known ? SWAY_VALID_MARGIN : 0, status.valid);
        TEST_ASSERT_EQUAL_INT32(known ? -12345 : 0, status.margin_damping_ratio_ppm);
        TEST_ASSERT_EQUAL_INT32(known ? 1234000000 : 0, status.margin_damping_ratio_se_ppm);
    }
}

static void what_was_valid_once_is_old_and_keeps_its_value(void)
{
    judgement.belief = SWAY_BELIEF_MODEL;
    judgement.combined.ratio = real(0.2);
    from.speed_mm_s = 1000;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(0, status.old);
    judgement.belief = SWAY_BELIEF_NONE;
    judgement.combined.ratio = real(0.3);
    for (int i = 0; i < 2; i++) { /* and stays it */
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_SPEED, status.valid);
        TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_MARGIN, status.old);
        TEST_ASSERT_EQUAL_INT32(200000, status.margin_damping_ratio_ppm);
    }
    judgement.belief = SWAY_BELIEF_SIGNAL;
    from.speed_mm_s = -1;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_MARGIN, status.valid);
    TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_SPEED, status.old);
}

static void a_time_to_limit_is_valid_or_old_never_both(void)
{
    for (int round = 0; round < 3; round++) {
        alarm_.time_to_limit_ms = 1500;
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_TIME_TO_LIMIT, status.valid);
        TEST_ASSERT_EQUAL_UINT32(0, status.old);
        TEST_ASSERT_EQUAL_INT32(1500, status.time_to_limit_ms);
        alarm_.time_to_limit_ms = -1;
        sway_publish(&status, &from);
        TEST_ASSERT_EQUAL_UINT32(0, status.valid);
        TEST_ASSERT_EQUAL_UINT32(SWAY_VALID_TIME_TO_LIMIT, status.old);
    }
}

static void what_the_alarm_says_and_what_is_missing_is_reported(void)
{
    alarm_.state = SWAY_ALARM_WARNING;
    alarm_.reasons = SWAY_REASON_GROWING;
    judgement.missing_mask = 0x12345;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_WARNING, status.alarm);
    TEST_ASSERT_EQUAL_UINT32(SWAY_REASON_GROWING, status.reasons);
    TEST_ASSERT_EQUAL_HEX32(0x12345, status.missing_inputs);
}

/* Values above 1, of which a millionth shows: micro and ppm are exact. */
static void micro_is_a_millionth(void)
{
    judgement.belief = SWAY_BELIEF_BOTH;
    judgement.combined = (sway_evidence_t){real(3), real(3), true, false};
    line.growth_1_s = real(-20);
    line.omega_rad_s = real(1);
    line.omega_se_rad_s = real(1000);
    model.has_model = true;
    model.damping_ratio = real(3);
    from.line = &line;
    from.model = &model;
    sway_publish(&status, &from);
    TEST_ASSERT_EQUAL_INT32(998752, status.damping_ratio_ppm);         /* 20 / sqrt(401) */
    TEST_ASSERT_INT32_WITHIN(1, 2490654, status.damping_ratio_se_ppm); /* 20000 / 401^1.5 */
    TEST_ASSERT_EQUAL_INT32(3000000, status.margin_damping_ratio_ppm);
    TEST_ASSERT_EQUAL_INT32(3000000, status.model_damping_ratio_ppm);
    sway_axle_estimate_t *const axle = &id.axle[0];
    axle->stiffness.value = polar(1000, -3);
    axle->stiffness.se = real(3000);
    axle->slip = sway_phasor_constant(polar(3, 0));
    axle->force = sway_phasor_constant(polar(21000, 0));
    axle->load_harmonic_n = polar(4000, 3);
    id.car_inertia.value = polar(2690, 3);
    id.valid = SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_FRONT_LOAD | SWAY_VALID_CAR_INERTIA;
    put_parts();
    const sway_axle_status_t *const a = &status.axle[0];
    TEST_ASSERT_INT32_WITHIN(1, -3000000, a->argument_urad);
    TEST_ASSERT_INT32_WITHIN(1, 3000000, a->argument_se_urad);
    TEST_ASSERT_INT32_WITHIN(1, 3000000, a->slip_amplitude_urad);
    TEST_ASSERT_INT32_WITHIN(1, 3000000, a->load_harmonic_phase_urad);
    TEST_ASSERT_INT32_WITHIN(1, 3000000, a->lateral_friction_ppm);
    TEST_ASSERT_INT32_WITHIN(1, 3000000, status.car_yaw_inertia_argument_urad);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(stiffness_is_reported_of_its_axle_alone);
    RUN_TEST(loads_are_reported_of_their_axle_alone);
    RUN_TEST(inertias_are_reported_each_by_its_bit);
    RUN_TEST(a_value_beyond_its_integer_is_its_end);
    RUN_TEST(nothing_known_says_nothing);
    RUN_TEST(speed_zero_is_known);
    RUN_TEST(the_line_is_reported_in_its_units);
    RUN_TEST(what_is_identified_counts_only_while_a_line_is_held);
    RUN_TEST(the_model_is_reported_in_its_units);
    RUN_TEST(a_critical_speed_says_up_to_which_swing_it_was_seen);
    RUN_TEST(a_critical_speed_is_reported_of_every_kind_that_has_one);
    RUN_TEST(the_belief_makes_the_combined_damping_valid);
    RUN_TEST(what_was_valid_once_is_old_and_keeps_its_value);
    RUN_TEST(a_time_to_limit_is_valid_or_old_never_both);
    RUN_TEST(what_the_alarm_says_and_what_is_missing_is_reported);
    RUN_TEST(micro_is_a_millionth);
    return UNITY_END();
}

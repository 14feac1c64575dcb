/* Model margin, its errors, the combination with the signals. */
#include "judge/sway_evidence.h"
#include "model/sway_margin.h"
#include "sway_test.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static sway_line_t line;
static sway_identify_t id;
static sway_margin_t margin;

void setUp(void)
{
    vehicle = reference_vehicle();
    sway_margin_init(&margin, &vehicle);
}

void tearDown(void)
{
}

static void run(const sway_identify_t *identify, int64_t time_us, double kmh)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_margin_start(&margin, identify, time_us, real(kmh / 3.6)));
    int slices = 1;
    while (sway_margin_run(&margin)) {
        slices++;
    }
    TEST_ASSERT_LESS_THAN_INT(100, slices);
    TEST_ASSERT_FALSE(sway_margin_run(&margin));
}

/* One good line of a plant; every amplitude known to `relative` of itself. */
static void identify_plant(const test_plant_t *plant, double relative)
{
    plant_line(plant, &vehicle, &line);
    for (int i = 0; i < (int)SWAY_CHANNELS; i++) {
        line.channel[i].amplitude_se = real(relative * cabs(cvalue(line.channel[i].amplitude)));
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_identify_start(&id, &vehicle, &line));
    while (sway_identify_run(&id)) {
    }
}

static void the_users_vehicle_gives_the_golden_values(void)
{
    static const double golden[5][2] = {
        {80, 0.2520}, {100, 0.1115}, {107.9, 0.0689}, {117.3, 0.0250}, {140, -0.0587}};
    static const double sensitivity[SWAY_PARAMETER_COUNT] = {0.188,  -0.216, 0.140,  -0.721, 0.064,
                                                             0.844,  -0.767, -0.062, 0.284,  1.452,
                                                             -0.156, 0.440,  0.005,  0.334};
    for (int i = 0; i < 5; i++) {
        run(NULL, 1000000 * i, golden[i][0]);
        TEST_ASSERT_TRUE(margin.model.has_model && margin.model.has_steady);
        TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.model.kind);
        TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_USER, margin.model.source);
        TEST_ASSERT_DOUBLE_WITHIN(0.001, 123.3397, value(margin.model.v_crit_m_s) * 3.6);
        TEST_ASSERT_DOUBLE_WITHIN(0.0001, golden[i][1], value(margin.model.damping_ratio));
        for (int p = 0; p < (int)SWAY_PARAMETER_COUNT; p++) {
            TEST_ASSERT_DOUBLE_WITHIN(fmax(0.03 * fabs(sensitivity[p]), 0.005), sensitivity[p],
                                      value(margin.model.sensitivity_m_s[p]) * 3.6);
        }
    }
    /* 10 % on each stiffness, 7 % on each inertia, 4 % on each argument. */
    TEST_ASSERT_TRUE(value(margin.model.v_crit_se_m_s) * 3.6 > 5);
    TEST_ASSERT_TRUE(value(margin.model.v_crit_se_m_s) * 3.6 < 20);
}

/* A moment at the ball is none of the model's. */
static void the_margin_is_that_of_a_swing_that_nothing_holds(void)
{
    test_plant_t plant = reference_plant(110);
    for (int i = 0; i < 40; i++) {
        plant.friction = 6000;
        identify_plant(&plant, 0.001);
        run(&id, 1000000 + 100000 * i, 110);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 123.3, value(margin.model.v_crit_m_s) * 3.6);
}

static void identified_stiffnesses_replace_the_users(void)
{
    test_plant_t plant = reference_plant(110);
    plant.inertia[1] = 10350 * 1.12;
    for (int i = 0; i < 80; i++) {
        identify_plant(&plant, 0.001);
        run(&id, 1000000 + 100000 * i, 110);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, margin.model.source);
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 115.44, value(margin.model.v_crit_m_s) * 3.6);
    TEST_ASSERT_TRUE(value(margin.model.v_crit_se_m_s) * 3.6 < 1);
}

static void the_argument_of_a_stiffness_is_a_lag_in_the_model(void)
{
    /* sigma = 0.7 m on the car's rear axle, seen at 90 km/h: v_crit 111.83 as of the plant with
     * the lag as a state. */
    test_plant_t plant = reference_plant(90);
    plant.stiffness[1] /= 1 + 0.7 * plant.s / plant.v;
    for (int i = 0; i < 80; i++) {
        identify_plant(&plant, 0.001);
        run(&id, 1000000 + 100000 * i, 90);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.model.kind);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 111.83, value(margin.model.v_crit_m_s) * 3.6);
    const sway_complex_t s = {sway_real_int(0), margin.model.omega_crit_rad_s};
    const sway_complex_t f =
        sway_single_track_characteristic(&margin.stm, s, margin.model.v_crit_m_s);
    const sway_complex_t far = sway_single_track_characteristic(
        &margin.stm, s, real(value(margin.model.v_crit_m_s) * 1.01));
    TEST_ASSERT_TRUE(value(sway_complex_abs(f)) < 1e-3 * value(sway_complex_abs(far)));
}

static void the_lag_stays_when_the_frequency_changes(void)
{
    /* A slalom goes from 0.5 to 0.78 Hz: the argument of the lagging axle grows with it. */
    static const double hertz[] = {0.5, 0.78, 0.62};
    for (unsigned part = 0; part < 3; part++) {
        for (int i = 0; i < 40; i++) {
            test_plant_t plant = reference_plant(90);
            plant.s = 2 * M_PI * I * hertz[part];
            plant.stiffness[1] /= 1 + 0.7 * plant.s / plant.v;
            identify_plant(&plant, 0.001);
            run(&id, 1000000 + 100000 * (int64_t)(40 * part + (unsigned)i), 90);
            if (part > 0 || i > 30) {
                TEST_ASSERT_DOUBLE_WITHIN(0.5, 111.83, value(margin.model.v_crit_m_s) * 3.6);
            }
        }
    }
}

static void a_sudden_change_is_followed(void)
{
    test_plant_t plant = reference_plant(100);
    for (int i = 0; i < 60; i++) {
        identify_plant(&plant, 0.01);
        run(&id, 1000000 + 100000 * i, 100);
    }
    plant.stiffness[3] *= 0.5;
    for (int i = 0; i < 12; i++) {
        identify_plant(&plant, 0.01);
        run(&id, 7000000 + 100000 * i, 100);
    }
    TEST_ASSERT_DOUBLE_WITHIN(8000, 0.5 * 124400, value(margin.stiffness[3].value.re));
}

static void without_enough_vehicle_data_there_is_no_model(void)
{
    vehicle.car.yaw_inertia_gm2 = 0;
    sway_margin_init(&margin, &vehicle);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_margin_start(&margin, NULL, 0, real(30)));
    vehicle = reference_vehicle();
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 0;
    sway_margin_init(&margin, &vehicle);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_margin_start(&margin, NULL, 0, real(30)));
    /* Identification supplies what the user does not know. */
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_identify_start(&id, &vehicle, &line));
    while (sway_identify_run(&id)) {
    }
    run(&id, 1000000, 100);
    TEST_ASSERT_DOUBLE_WITHIN(1, 123.34, value(margin.model.v_crit_m_s) * 3.6);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SPEED, sway_margin_start(&margin, NULL, 0, real(8)));
}

/* Their standard errors have grown with the gap: they count as little as they say. */
static void estimates_over_gaps_count_by_their_errors(void)
{
    test_plant_t plant = reference_plant(100);
    plant.stiffness[1] *= 0.8;
    identify_plant(&plant, 0.001);
    run(&id, 1000000, 100);
    const double whole = value(margin.model.v_crit_m_s);
    setUp();
    identify_plant(&plant, 0.1);
    id.quality |= SWAY_QUALITY_GAP;
    run(&id, 1000000, 100);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, margin.model.source);
    const double moved = (123.34 / 3.6 - value(margin.model.v_crit_m_s)) / (123.34 / 3.6 - whole);
    TEST_ASSERT_TRUE(moved > 0 && moved < 0.3);
}

static void modes_that_change_kind_are_followed(void)
{
    /* Slow: two real roots; fast: two pairs. The roots of one speed start those of the next. */
    static const double kmh[] = {40, 140, 35, 60, 31, 120, 200, 32, 240, 80};
    for (unsigned i = 0; i < sizeof kmh / sizeof kmh[0]; i++) {
        run(NULL, 1000000 * (int64_t)i, kmh[i]);
        TEST_ASSERT_TRUE(margin.model.has_model);
        const sway_single_track_quartic_t quartic =
            sway_single_track_quartic(&margin.stm, real(kmh[i] / 3.6));
        sway_single_track_roots_t roots;
        sway_single_track_roots_start(&roots, &quartic);
        for (int sweep = 0; sweep < 60 && !sway_single_track_roots_sweep(&roots, &quartic);
             sweep++) {
        }
        const double expected =
            value(sway_single_track_damping_ratio(sway_single_track_dominant(&roots)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected, value(margin.model.damping_ratio));
    }
}

/* A car that is close to its static critical speed has two real roots, one of them near zero: the
 * errors must stay errors of a ratio, and the limit has one, too. */
static void an_overdamped_solo_car_has_errors_that_mean_something(void)
{
    vehicle.trailer.axles = 0;
    vehicle.car.front_cornering_stiffness_n_per_rad = 185200;
    vehicle.car.rear_cornering_stiffness_n_per_rad = 109300;
    sway_margin_init(&margin, &vehicle);
    run(NULL, 0, 60);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_DIVERGENCE, margin.model.kind);
    const double v_crit = value(margin.model.v_crit_m_s);
    const double se = value(margin.model.v_crit_se_m_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * v_crit, -value(margin.model.steady.characteristic_speed_m_s),
                              v_crit);
    for (double part = 0.5; part < 1.4; part += 0.0625) {
        run(NULL, 1000000, part * v_crit * 3.6);
        TEST_ASSERT_TRUE(margin.model.has_model);
        const double ratio = value(margin.model.damping_ratio);
        TEST_ASSERT_TRUE(ratio >= -1 && ratio <= 1);
        TEST_ASSERT_TRUE(value(margin.model.damping_ratio_se) >= 0);
        TEST_ASSERT_TRUE(value(margin.model.damping_ratio_se) <= 1);
    }
    /* 10 % on each stiffness: v_crit by finite differences of the closed form. */
    double variance = 0;
    for (int axle = 0; axle < 2; axle++) {
        sway_vehicle_t changed = vehicle;
        int32_t *const field = axle == 0 ? &changed.car.front_cornering_stiffness_n_per_rad
                                         : &changed.car.rear_cornering_stiffness_n_per_rad;
        *field += *field / 1000;
        sway_margin_init(&margin, &changed);
        run(NULL, 0, 60);
        variance += pow(100 * (value(margin.model.v_crit_m_s) - v_crit), 2);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.03 * sqrt(variance), sqrt(variance), se);
}

static sway_evidence_t damping(double ratio, double se, bool usable)
{
    const sway_evidence_t result = {real(ratio), real(se), usable, false};
    return result;
}

static void which_margin_is_believed(void)
{
    sway_evidence_t combined;
    bool disagrees;
    sway_evidence_t model = damping(0.05, 0.02, true);
    sway_evidence_t signal = damping(0.02, 0.02, false);
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_MODEL,
                          sway_evidence_combine(&model, &signal, &combined, &disagrees));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.05, value(combined.ratio));
    signal.usable = true;
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_BOTH,
                          sway_evidence_combine(&model, &signal, &combined, &disagrees));
    TEST_ASSERT_TRUE(value(combined.ratio) > 0.02 && value(combined.ratio) < 0.05);
    TEST_ASSERT_TRUE(value(combined.se) < 0.02);
    TEST_ASSERT_FALSE(disagrees);
    signal = damping(-0.1, 0.005, true);
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_SIGNAL,
                          sway_evidence_combine(&model, &signal, &combined, &disagrees));
    TEST_ASSERT_TRUE(disagrees);
    model.usable = false;
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_SIGNAL,
                          sway_evidence_combine(&model, &signal, &combined, &disagrees));
    TEST_ASSERT_FALSE(disagrees);
    signal.usable = false;
    TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_NONE,
                          sway_evidence_combine(&model, &signal, &combined, &disagrees));
}

static void a_restless_road_widens_the_signals_error(void)
{
    sway_disturbance_t unrest = {{0, 0}, 0, 0, false};
    const double before = value(sway_disturbance_se(&unrest, real(0.001), real(0.05), real(0)));
    for (int i = 1; i < 600; i++) {
        sway_disturbance_learn(&unrest, 100000 * i, real(0.2), real(0.03), real(0));
    }
    const double restless = value(sway_disturbance_se(&unrest, real(0.001), real(0.05), real(0)));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.12, restless); // 0.2 * 0.03 / 0.05
    for (int i = 600; i < 2400; i++) {
        sway_disturbance_learn(&unrest, 100000 * i, real(0.001), real(0.03), real(0));
    }
    const double calm = value(sway_disturbance_se(&unrest, real(0.001), real(0.05), real(0)));
    TEST_ASSERT_TRUE(calm < before && before < restless);
    /* A hand on the wheel: 0.02 rad/s of yaw rate would follow it, 0.05 rad/s swing. */
    const double handled = value(sway_disturbance_se(&unrest, real(0.001), real(0.05), real(0.02)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, hypot(calm, 0.3), handled);
    /* Twice what the fit states, and 0.003 rad/s before any experience. */
    const sway_disturbance_t none = {{0, 0}, 0, 0, false};
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, hypot(0.2, 0.003 / 0.05),
                              value(sway_disturbance_se(&none, real(0.1), real(0.05), real(0))));
}

/* Loads that are valid are no stiffnesses, and inertias do not count as axles. */
static void the_source_counts_axles_alone(void)
{
    const uint32_t inertias = SWAY_VALID_CAR_INERTIA | SWAY_VALID_TRAILER_INERTIA;
    const uint32_t axles = SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR | SWAY_VALID_TRAILER_FRONT |
                           SWAY_VALID_TRAILER_REAR;
    const uint32_t loads = axles << 4;
    test_plant_t plant = reference_plant(100);
    identify_plant(&plant, 0.001);
    TEST_ASSERT_BITS_HIGH(axles | inertias, id.valid);
    id.valid = inertias | loads;
    run(&id, 1000000, 100);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_USER, margin.model.source);
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        setUp();
        id.valid = (uint32_t)SWAY_VALID_CAR_FRONT << (unsigned)axle;
        run(&id, 1000000, 100);
        TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_PARTLY, margin.model.source);
        setUp();
        id.valid = axles & ~id.valid;
        run(&id, 1000000, 100);
        TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_PARTLY, margin.model.source);
    }
    setUp();
    id.valid = axles;
    run(&id, 1000000, 100);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, margin.model.source);
    TEST_ASSERT_FALSE(margin.inertia[0].identified || margin.inertia[1].identified);
}

/* Per square root of a second: 0.2 % of a stiffness, 0.05 % of it its argument, 0.1 % of an
 * inertia. The user's values, which nobody has measured, stay as certain as they were. */
static void identified_values_grow_less_certain_with_time(void)
{
    test_plant_t plant = reference_plant(100);
    identify_plant(&plant, 0.001);
    for (int measured = 0; measured < 2; measured++) {
        setUp();
        run(measured ? &id : NULL, 1000000, 100);
        const sway_margin_t before = margin;
        run(NULL, 101000000, 100); /* 100 s on */
        for (int k = 0; k < 6; k++) {
            const sway_quantity_t *const a = k < 4 ? &before.stiffness[k] : &before.inertia[k - 4];
            const sway_quantity_t *const b = k < 4 ? &margin.stiffness[k] : &margin.inertia[k - 4];
            const double size = value(a->value.re) * measured;
            const double re = pow(size * (k < 4 ? 0.02 : 0.01), 2);
            const double im = pow(size * (k < 4 ? 0.005 : 0), 2);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4 * re, re, value(b->variance_re) - value(a->variance_re));
            TEST_ASSERT_DOUBLE_WITHIN(1e-4 * im, im, value(b->variance_im) - value(a->variance_im));
            TEST_ASSERT_DOUBLE_WITHIN(0, value(a->value.re), value(b->value.re));
        }
    }
}

/* An eighth of 20 s at most, of the 6 s that the value before is worth and what came since. */
static void after_a_pause_the_unrest_is_learnt_as_after_2_5_s(void)
{
    static const double pause_s[][2] = {{1, 1}, {2.4, 2.4}, {2.5, 2.5}, {100, 2.5}};
    for (int k = 0; k < 4; k++) {
        sway_disturbance_t unrest = {{0, 0}, 0, 0, false};
        const double start = 0.003 * 0.003, seen = 0.2 * 0.2 * 0.03 * 0.03;
        sway_disturbance_learn(&unrest, 1000000, real(0.2), real(0.03), real(0));
        sway_disturbance_learn(&unrest, 1000000 + (int64_t)(pause_s[k][0] * 1e6), real(0.2),
                               real(0.03), real(0));
        const double weight = pause_s[k][1] / (6 + pause_s[k][1]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * start, start + weight * (seen - start),
                                  value(unrest.variance));
    }
}

/* An estimate of the same time or of before adds nothing to what is learnt. */
static void unrest_is_not_learnt_while_time_stands(void)
{
    sway_disturbance_t unrest = {{0, 0}, 0, 0, false};
    sway_disturbance_learn(&unrest, 1000000, real(0.2), real(0.03), real(0));
    const double before = value(unrest.variance);
    sway_disturbance_learn(&unrest, 1000000, real(0.2), real(0.03), real(0));
    TEST_ASSERT_DOUBLE_WITHIN(0, before, value(unrest.variance));
    sway_disturbance_learn(&unrest, 900000, real(0.2), real(0.03), real(0));
    TEST_ASSERT_DOUBLE_WITHIN(0, before, value(unrest.variance));
}

/* Three where the model is slow. */
static void evidence_disagrees_beyond_four_errors(void)
{
    const double se = sqrt(0.01 * 0.01 + 0.005 * 0.005 + 0.01 * 0.01);
    static const double errors[] = {3.95, 4.05, 2.95, 3.05};
    for (int k = 0; k < 4; k++) {
        const sway_evidence_t model = {real(0.1), real(0.01), true, k >= 2};
        const sway_evidence_t signal = {real(0.1 + errors[k] * se), real(0.01), true, false};
        sway_evidence_t combined;
        bool disagrees;
        TEST_ASSERT_EQUAL_INT(k % 2 == 0 ? SWAY_BELIEF_BOTH : SWAY_BELIEF_SIGNAL,
                              sway_evidence_combine(&model, &signal, &combined, &disagrees));
        TEST_ASSERT_EQUAL_INT(k % 2 == 1, disagrees);
    }
}

/* However calm a road was: a disturbance of 0.5 mrad/s is always expected. */
static void the_road_is_never_taken_to_be_still(void)
{
    sway_disturbance_t calm = {{0, 0}, 0, 0, false};
    for (int i = 1; i <= 200; i++) {
        sway_disturbance_learn(&calm, 5000000LL * i, real(0), real(0.03), real(0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0005 / 0.05,
                              value(sway_disturbance_se(&calm, real(0), real(0.05), real(0))));
}

/* Stiffnesses and the inertia of the car that the user has not given are not asked for once they
 * are identified. */
static void an_identified_vehicle_needs_no_stiffness_of_the_user(void)
{
    test_plant_t plant = reference_plant(100);
    identify_plant(&plant, 0.001);
    vehicle.car.yaw_inertia_gm2 = 0;
    vehicle.car.front_cornering_stiffness_n_per_rad = 0;
    vehicle.car.rear_cornering_stiffness_n_per_rad = 0;
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 0;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 0;
    sway_margin_init(&margin, &vehicle);
    run(&id, 1000000, 100);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, margin.model.source);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 123.34, value(margin.model.v_crit_m_s) * 3.6);
}

/* Three axles are all that a single-axle trailer has. */
static void three_identified_axles_are_all_of_a_single_axle_trailer(void)
{
    vehicle.trailer.axles = 1;
    vehicle.trailer.rear_axle_to_cog_um = 201000;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 255600;
    sway_margin_init(&margin, &vehicle);
    test_plant_t plant = reference_plant(100);
    plant.stiffness[3] = 255600;
    identify_plant(&plant, 0.001);
    run(&id, 1000000, 100);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, margin.model.source);
}

static void nothing_is_left_of_what_was_in_the_memory_or_of_a_broken_off_estimate(void)
{
    run(NULL, 1000000, 100);
    const sway_margin_model_t expected = margin.model;
    memset(&margin, 0x5A, sizeof margin);
    sway_margin_init(&margin, &vehicle);
    run(NULL, 1000000, 100);
    TEST_ASSERT_EQUAL_MEMORY(&expected, &margin.model, sizeof expected);
    for (int slices = 1; slices < 60; slices++) {
        sway_margin_init(&margin, &vehicle);
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_margin_start(&margin, NULL, 1000000, real(140 / 3.6)));
        for (int i = 0; i < slices; i++) {
            (void)sway_margin_run(&margin);
        }
        const bool done = margin.model.has_model;
        run(NULL, 1000000, 100);
        TEST_ASSERT_DOUBLE_WITHIN(done ? 1e-5 : 0, value(expected.v_crit_m_s),
                                  value(margin.model.v_crit_m_s));
        TEST_ASSERT_DOUBLE_WITHIN(done ? 1e-5 : 0, value(expected.damping_ratio),
                                  value(margin.model.damping_ratio));
    }
}

/* The lag of any axle alone moves the limit. */
static void the_lag_of_each_axle_counts(void)
{
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        test_plant_t plant = reference_plant(100);
        setUp();
        identify_plant(&plant, 0.001);
        for (int k = 0; k < (int)SWAY_AXLE_COUNT; k++) {
            id.axle[k].stiffness.value.im = sway_real_zero();
        }
        run(&id, 1000000, 100);
        const double without = value(margin.model.v_crit_m_s);
        id.axle[axle].stiffness.value.im = real(-0.1 * plant.stiffness[axle]);
        for (int i = 0; i < 20; i++) {
            run(&id, 1000000, 100);
        }
        TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.model.kind);
        const sway_complex_t s = {sway_real_int(0), margin.model.omega_crit_rad_s};
        const double here = value(sway_complex_abs(
            sway_single_track_characteristic(&margin.stm, s, margin.model.v_crit_m_s)));
        const double there = value(
            sway_complex_abs(sway_single_track_characteristic(&margin.stm, s, real(without))));
        TEST_ASSERT_TRUE(here < 0.01 * there);
    }
}

/* Each uncertainty is in the error of the limit: of stiffnesses, of their lags, of inertias. */
static void every_variance_is_in_the_error_of_the_limit(void)
{
    run(NULL, 1000000, 110);
    const double before = value(margin.model.v_crit_se_m_s);
    const double ratio_before = value(margin.model.damping_ratio_se);
    for (int k = 0; k < 10; k++) {
        setUp();
        sway_quantity_t *const state = k < 8 ? &margin.stiffness[k / 2] : &margin.inertia[k - 8];
        sway_real_t *const variance =
            k < 8 && k % 2 == 1 ? &state->variance_im : &state->variance_re;
        *variance = real(pow(0.3 * value(state->value.re), 2));
        run(NULL, 1000000, 110);
        TEST_ASSERT_TRUE(value(margin.model.v_crit_se_m_s) > 1.00002 * before);
        TEST_ASSERT_TRUE(value(margin.model.damping_ratio_se) > 1.00002 * ratio_before);
    }
    /* An inertia's variance is that of this inertia: 30 % instead of the user's 7 %. */
    for (int body = 0; body < 2; body++) {
        setUp();
        margin.inertia[body].variance_re = real(pow(0.3 * value(margin.inertia[body].value.re), 2));
        run(NULL, 1000000, 110);
        const int parameter =
            body == 0 ? SWAY_PARAMETER_CAR_YAW_INERTIA : SWAY_PARAMETER_TRAILER_YAW_INERTIA;
        const double by_percent = value(margin.model.sensitivity_m_s[parameter]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * before,
                                  sqrt(before * before + by_percent * by_percent * (900 - 49)),
                                  value(margin.model.v_crit_se_m_s));
    }
    setUp();
    margin.stiffness[3].variance_re = real(pow(100 * value(margin.stiffness[3].value.re), 2));
    run(NULL, 1000000, 110);
    TEST_ASSERT_EQUAL_DOUBLE(1, value(margin.model.damping_ratio_se));
}

/* After the first time two parameters are renewed each time, in turn: all in seven estimates. */
static void the_sensitivities_are_renewed_in_turn(void)
{
    run(NULL, 1000000, 110);
    const sway_margin_model_t expected = margin.model;
    memset(margin.limit_per_percent, 0, sizeof margin.limit_per_percent);
    for (int i = 1; i <= (int)SWAY_PARAMETER_COUNT / SWAY_MARGIN_TURN; i++) {
        int renewed = 0;
        run(NULL, 1000000, 110);
        for (int p = 0; p < (int)SWAY_PARAMETER_COUNT; p++) {
            renewed += value(margin.model.sensitivity_m_s[p]) != 0;
        }
        TEST_ASSERT_EQUAL_INT(i * SWAY_MARGIN_TURN, renewed);
    }
    for (int p = 0; p < (int)SWAY_PARAMETER_COUNT; p++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(value(expected.sensitivity_m_s[p])) + 1e-6,
                                  value(expected.sensitivity_m_s[p]),
                                  value(margin.model.sensitivity_m_s[p]));
    }
}

/* The derivatives are those at the limit with the lags, also where that is far from the one
 * without: the same as when the search begins at the limit itself. */
static void derivatives_are_those_at_the_limit_that_was_found(void)
{
    test_plant_t plant = reference_plant(90);
    plant.stiffness[1] /= 1 + 0.7 * plant.s / plant.v;
    for (int i = 0; i < 40; i++) {
        identify_plant(&plant, 0.001);
        run(&id, 1000000 + 100000 * i, 90);
    }
    TEST_ASSERT_FALSE(margin.far);
    const sway_margin_t near = margin;
    margin.model.kind = SWAY_VCRIT_SINGULAR; // the search begins without lags
    margin.complete = false;
    run(NULL, 5000000, 90);
    TEST_ASSERT_TRUE(margin.far);
    for (int p = 0; p < (int)SWAY_PARAMETER_COUNT; p++) {
        const double expected = value(near.model.sensitivity_m_s[p]);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * fabs(expected) + 1e-4, expected,
                                  value(margin.model.sensitivity_m_s[p]));
    }
}

/* --- forces from balances ------------------------------------------------------------------------
 */

static void derive_plant(const test_plant_t *plant, const sway_vehicle_t *known)
{
    plant_line(plant, known, &line);
    for (int i = SWAY_CHANNEL_HITCH_FX; i < (int)SWAY_CHANNELS; i++) {
        line.valid_mask &= ~SWAY_CHANNEL_BIT(i);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_identify_start(&id, known, &line));
    while (sway_identify_run(&id)) {
    }
}

/* Swing of 4 rad/s that fades with a damping ratio, `time_us` on, times `turn`. */
static void seen_at(int64_t time_us, double damping, double complex turn, sway_channel_t channel)
{
    const double complex swing = turn * cexp((I - damping) * 4e-6 * (double)time_us);
    line.omega_rad_s = real(4);
    line.channel[channel].amplitude = complex_of(swing);
    line.flags = 0;
}

/* Variance of the car's rear stiffness by its start, after an estimate at 2.4 s; four others, all
 * that are remembered, were at 2.0 to 2.3 s. */
static double taught(int64_t time_us, double complex turn, uint32_t flags, sway_channel_t channel)
{
    setUp();
    run(NULL, 1900000, 100);
    margin.model.damping_ratio = real(0.1);
    const double start = value(margin.stiffness[1].variance_re);
    for (int i = 0; i < 4; i++) {
        seen_at(2000000 + 100000 * i, 0.1, 1, channel);
        TEST_ASSERT_EQUAL_INT(SWAY_OK,
                              sway_margin_start(&margin, &id, 2000000 + 100000 * i, real(28)));
        TEST_ASSERT_EQUAL_DOUBLE(start, value(margin.stiffness[1].variance_re));
        TEST_ASSERT_FALSE(margin.stiffness[1].identified); // nothing predicted it
    }
    seen_at(time_us, 0.1, turn, channel);
    line.flags = flags;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_margin_start(&margin, &id, time_us, real(28)));
    return value(margin.stiffness[1].variance_re) / start;
}

/* What is left of the variance by gain and share, as reckoned here. */
static double expected(double share)
{
    const double p = pow(0.1 * 185200, 2);
    const double one = pow(value(id.axle[1].stiffness.se), 2);
    const double gain =
        fmin(p * share / (p * share * share + 4 * one), 1 - one / 4 * pow(1 - share, 2) / p);
    return (pow(1 - gain, 2) * p + gain * gain * 4 * one) / p;
}

/* Wind is in a force from balances and in the motion of its window, not in the motion before. */
static void an_estimate_from_balances_counts_as_far_as_its_swing_was_predicted(void)
{
    const sway_channel_t trailer = SWAY_CHANNEL_TRAILER_YAW_RATE;
    test_plant_t plant = reference_plant(100);
    derive_plant(&plant, &vehicle);
    TEST_ASSERT_TRUE(id.axle[0].derived && id.axle[1].derived && id.axle[2].derived);
    const double all = expected(1);
    TEST_ASSERT_TRUE(all < 0.9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, all, taught(2400000, 1, 0, trailer));
    TEST_ASSERT_TRUE(margin.stiffness[1].identified);
    /* Half of it; 60 deg ahead, which is half of it, too; smaller than predicted. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected(0.5), taught(2400000, 2, 0, trailer));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected(0.5), taught(2400000, cexp(I * M_PI / 3), 0, trailer));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, all, taught(2400000, 0.5, 0, trailer));
    /* Against it, or across: nothing; with the hand on the wheel: all. */
    TEST_ASSERT_EQUAL_DOUBLE(1, taught(2400000, -1, 0, trailer));
    TEST_ASSERT_EQUAL_DOUBLE(1, taught(2400000, 1.001 * I, 0, trailer));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, all, taught(2400000, -1, SWAY_LINE_FORCED, trailer));
    /* Up to one turn of 1.57 s after it; not at its own time, nor before it. */
    TEST_ASSERT_TRUE(taught(3570000, 1, 0, trailer) < 1);
    TEST_ASSERT_EQUAL_DOUBLE(1, taught(3572000, 1, 0, trailer));
    TEST_ASSERT_EQUAL_DOUBLE(1, taught(2000000, 1, 0, trailer));
    TEST_ASSERT_EQUAL_DOUBLE(1, taught(1999000, 1, 0, trailer));
    TEST_ASSERT_TRUE(taught(2001000, 1, 0, trailer) < 1);
}

/* It is carried on with the damping so far, between 0 and 0.2. */
static void the_past_swing_fades_as_the_model_says(void)
{
    static const double damping_ratio[][2] = {{-0.1, 0}, {0.05, 0.05}, {0.19, 0.19}, {0.5, 0.2}};
    test_plant_t plant = reference_plant(100);
    derive_plant(&plant, &vehicle);
    for (int k = 0; k < 4; k++) {
        setUp();
        run(NULL, 1900000, 100);
        margin.model.damping_ratio = real(damping_ratio[k][0]);
        const double start = value(margin.stiffness[1].variance_re);
        for (int i = 0; i <= 4; i++) {
            seen_at(2000000 + 100000 * i, 0, 2, SWAY_CHANNEL_TRAILER_YAW_RATE);
            (void)sway_margin_start(&margin, &id, 2000000 + 100000 * i, real(28));
        }
        const double share = exp(-1.6 * damping_ratio[k][1]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected(share),
                                  value(margin.stiffness[1].variance_re) / start);
    }
}

static void without_a_trailers_yaw_rate_the_cars_predicts(void)
{
    vehicle.trailer.axles = 0;
    test_plant_t plant = reference_plant(100);
    derive_plant(&plant, &vehicle);
    sway_vehicle_t solo = vehicle;
    setUp();
    vehicle = solo;
    sway_margin_init(&margin, &vehicle);
    for (int i = 0; i <= 4; i++) {
        TEST_ASSERT_FALSE(margin.stiffness[1].identified);
        seen_at(2000000 + 100000 * i, 0, 1, SWAY_CHANNEL_CAR_YAW_RATE);
        (void)sway_margin_start(&margin, &id, 2000000 + 100000 * i, real(28));
    }
    TEST_ASSERT_TRUE(margin.stiffness[1].identified);
}

/* --- one quantity --------------------------------------------------------------------------------
 */

static sway_quantity_t quantity;

static void estimate_1000(double innovation, double se)
{
    const sway_estimate_t estimate = {complex_of(1000 + innovation - 50 * I), real(se)};
    const sway_complex_t s_by_v = complex_of(0.14 * I);
    sway_quantity_take(&quantity, &estimate, s_by_v, NULL);
}

static void a_users_quantity_has_its_errors_and_its_lag_at_two_thirds_of_a_hertz(void)
{
    memset(&quantity, 0x5A, sizeof quantity);
    sway_quantity_start(&quantity, real(1000), 100000, 40000);
    TEST_ASSERT_TRUE(quantity.started);
    TEST_ASSERT_FALSE(quantity.identified || quantity.strange);
    TEST_ASSERT_EQUAL_INT64(0, quantity.time_us);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1e4, value(quantity.variance_re));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1600, value(quantity.variance_im));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.14, value(quantity.s_by_v.im));
    TEST_ASSERT_EQUAL_DOUBLE(0, value(quantity.value.im));
    const sway_estimate_t at_twice = {complex_of(1000), real(1e6)};
    sway_quantity_take(&quantity, &at_twice, complex_of(0.28 * I), NULL);
    TEST_ASSERT_DOUBLE_WITHIN(1, 6400, value(quantity.variance_im)); // the argument is twice it
}

static void a_first_estimate_is_taken_with_its_error(void)
{
    sway_quantity_start(&quantity, real(0), 100000, 40000);
    TEST_ASSERT_FALSE(quantity.started);
    estimate_1000(0, 3);
    TEST_ASSERT_TRUE(quantity.started && quantity.identified);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1000, value(quantity.value.re));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 9 * SWAY_QUANTITY_OVERLAP, value(quantity.variance_re));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 9 * SWAY_QUANTITY_OVERLAP, value(quantity.variance_im));
}

/* With two estimates in a row that are off by more than two errors the value so far grows less
 * certain, by a sixteenth of the square; with one it does not. */
static void a_jump_is_followed_at_the_second_estimate(void)
{
    for (int k = 0; k < 2; k++) {
        const double off = sqrt(k == 0 ? 3.99 : 4.01) * hypot(100, 10);
        sway_quantity_start(&quantity, real(1000), 100000, 40000);
        estimate_1000(off, 10);
        TEST_ASSERT_EQUAL_INT(k == 1, quantity.strange);
        TEST_ASSERT_TRUE(value(quantity.variance_re) < 1e4);
    }
    sway_quantity_start(&quantity, real(1000), 1000, 1000);
    for (int k = 0; k < 2; k++) {
        const sway_quantity_t before = quantity;
        const double off = 500 - (value(quantity.value.re) - 1000);
        const double r = 100.0 * SWAY_QUANTITY_OVERLAP;
        estimate_1000(500, 10);
        const double grown_re = value(before.variance_re) + (k == 1 ? off * off / 16 : 0);
        const double grown_im = value(before.variance_im) + (k == 1 ? off * off / 64 : 0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * r, grown_re * r / (grown_re + r),
                                  value(quantity.variance_re));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * r, grown_im * r / (grown_im + r),
                                  value(quantity.variance_im));
    }
}

/* Noise that makes a slip too large makes the stiffness too small, and its stated error with it: in
 * a swing that fades an estimate at half the value counts with twice its error, one above the value
 * with its own. In one that grows or stays all count as stated. */
static void a_low_estimate_of_a_fading_swing_counts_with_the_error_it_would_have(void)
{
    const double measured[5] = {500, 999, 1001, 0, -500};
    const double counted[5] = {100, 50.05, 50, 50, 50};
    for (int k = 0; k < 15; k++) {
        const double growth[3] = {-0.01, 0, 0.01};
        const double se = k < 5 ? counted[k] : 50;
        const double r = se * se * SWAY_QUANTITY_OVERLAP;
        const sway_estimate_t estimate = {complex_of(measured[k % 5]), real(50)};
        sway_quantity_start(&quantity, real(1000), 1000000, 1000000);
        sway_quantity_take(&quantity, &estimate, complex_of(growth[k / 5] + 0.14 * I), NULL);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * r, 1e6 * r / (1e6 + r), value(quantity.variance_re));
    }
    /* Stated errors of 130 and 100 are 217 and 192 at the value so far. */
    const sway_complex_t fading = complex_of(-0.01 + 0.14 * I);
    sway_quantity_start(&quantity, real(1000), 10000, 10000);
    sway_quantity_take(&quantity, &(sway_estimate_t){complex_of(600), real(130)}, fading, NULL);
    TEST_ASSERT_FALSE(quantity.strange); // 400 < 2 * 217
    sway_quantity_take(&quantity, &(sway_estimate_t){complex_of(520), real(100)}, fading, NULL);
    TEST_ASSERT_TRUE(quantity.strange); // about 480 > 2 * 192
}

/* However many come, a quarter of one's variance stays where nothing was predicted, with half of it
 * a sixteenth: what they have in common. */
static void estimates_from_balances_leave_an_error_in_common(void)
{
    const sway_estimate_t estimate = {complex_of(1100), real(50)};
    const sway_real_t half = real(0.5);
    sway_quantity_start(&quantity, real(1000), 100000, 100000);
    for (int i = 0; i < 400; i++) {
        sway_quantity_take(&quantity, &estimate, complex_of(0.14 * I), &half);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 2500.0 / 16, value(quantity.variance_re));
    TEST_ASSERT_TRUE(value(quantity.value.re) > 1090);
    /* Where less than that is left already they teach nothing more. */
    const sway_quantity_t before = quantity;
    const sway_estimate_t worse = {complex_of(1200), real(60)};
    sway_quantity_take(&quantity, &worse, complex_of(0.14 * I), &half);
    TEST_ASSERT_EQUAL_DOUBLE(value(before.value.re), value(quantity.value.re));
    TEST_ASSERT_EQUAL_DOUBLE(value(before.variance_re), value(quantity.variance_re));
    /* The first of all is taken as it is. */
    sway_quantity_start(&quantity, real(0), 100000, 40000);
    sway_quantity_take(&quantity, &estimate, complex_of(0.14 * I), &half);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2500 * SWAY_QUANTITY_OVERLAP, value(quantity.variance_re));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_estimate_from_balances_counts_as_far_as_its_swing_was_predicted);
    RUN_TEST(the_past_swing_fades_as_the_model_says);
    RUN_TEST(without_a_trailers_yaw_rate_the_cars_predicts);
    RUN_TEST(estimates_from_balances_leave_an_error_in_common);
    RUN_TEST(the_users_vehicle_gives_the_golden_values);
    RUN_TEST(the_margin_is_that_of_a_swing_that_nothing_holds);
    RUN_TEST(identified_stiffnesses_replace_the_users);
    RUN_TEST(the_argument_of_a_stiffness_is_a_lag_in_the_model);
    RUN_TEST(the_lag_stays_when_the_frequency_changes);
    RUN_TEST(a_sudden_change_is_followed);
    RUN_TEST(without_enough_vehicle_data_there_is_no_model);
    RUN_TEST(estimates_over_gaps_count_by_their_errors);
    RUN_TEST(modes_that_change_kind_are_followed);
    RUN_TEST(an_overdamped_solo_car_has_errors_that_mean_something);
    RUN_TEST(which_margin_is_believed);
    RUN_TEST(a_restless_road_widens_the_signals_error);
    RUN_TEST(the_source_counts_axles_alone);
    RUN_TEST(identified_values_grow_less_certain_with_time);
    RUN_TEST(after_a_pause_the_unrest_is_learnt_as_after_2_5_s);
    RUN_TEST(unrest_is_not_learnt_while_time_stands);
    RUN_TEST(evidence_disagrees_beyond_four_errors);
    RUN_TEST(the_road_is_never_taken_to_be_still);
    RUN_TEST(an_identified_vehicle_needs_no_stiffness_of_the_user);
    RUN_TEST(three_identified_axles_are_all_of_a_single_axle_trailer);
    RUN_TEST(nothing_is_left_of_what_was_in_the_memory_or_of_a_broken_off_estimate);
    RUN_TEST(the_lag_of_each_axle_counts);
    RUN_TEST(every_variance_is_in_the_error_of_the_limit);
    RUN_TEST(the_sensitivities_are_renewed_in_turn);
    RUN_TEST(derivatives_are_those_at_the_limit_that_was_found);
    RUN_TEST(a_users_quantity_has_its_errors_and_its_lag_at_two_thirds_of_a_hertz);
    RUN_TEST(a_first_estimate_is_taken_with_its_error);
    RUN_TEST(a_jump_is_followed_at_the_second_estimate);
    RUN_TEST(a_low_estimate_of_a_fading_swing_counts_with_the_error_it_would_have);
    return UNITY_END();
}

/* Where the identification and the margin have nothing to say, or only a part of it. */
#include "model/sway_margin.h"
#include "sway_test.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static sway_line_t line;
static sway_identify_t id;
static sway_margin_t margin;

/* Steps of a computation, as sway_margin.c counts them. */
enum {
    STEP_ROOTS = 2,
    STEP_ROOT = 4,
    STEP_CRITICAL_SLOPE_S = 7,
    STEP_CRITICAL_NEWTON = 9,
    STEP_CRITICAL_RANGE = 10,
    STEP_LIMIT_SLOPE_S,
    STEP_LIMIT_SLOPE_V
};

void setUp(void)
{
    vehicle = reference_vehicle();
    memset(&margin, 0, sizeof margin);
    sway_margin_init(&margin, &vehicle);
}

void tearDown(void)
{
}

static void identify(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_identify_start(&id, &vehicle, &line));
    while (sway_identify_run(&id)) {
    }
}

static void drop(sway_channel_t channel)
{
    line.valid_mask &= ~SWAY_CHANNEL_BIT(channel);
}

static void start(double kmh)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_margin_start(&margin, NULL, 0, real(kmh / 3.6)));
}

static void until(int step)
{
    while ((int)margin.step < step) {
        TEST_ASSERT_TRUE(sway_margin_run(&margin));
    }
}

static void finish(void)
{
    while (sway_margin_run(&margin)) {
    }
}

/* --- identification --------------------------------------------------------------------------- */

static void a_single_axle_takes_the_whole_force(void)
{
    const test_plant_t plant = {-0.1 + 4.2 * I, 28, {109300, 185200, 0, 250000},
                                {2690, 10350},  0,  0};
    vehicle.trailer.axles = 1;
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 0;
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_TRAILER_REAR_FY); // the balance has to do
    identify();
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_REAR, id.valid);
    TEST_ASSERT_BITS_LOW(SWAY_VALID_TRAILER_FRONT, id.valid);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_EQUAL_SPLIT, id.quality); // there is nothing to split
    TEST_ASSERT_DOUBLE_WITHIN(250, 250000,
                              value(id.axle[SWAY_AXLE_TRAILER_REAR].stiffness.value.re));
    drop(SWAY_CHANNEL_HITCH_FY); // from both balances, by the user's inertia
    drop(SWAY_CHANNEL_CAR_FRONT_FY);
    identify();
    TEST_ASSERT_DOUBLE_WITHIN(250, 250000,
                              value(id.axle[SWAY_AXLE_TRAILER_REAR].stiffness.value.re));
    plant_line(&plant, &vehicle, &line); // measured, of one axle: the other's force is not missed
    identify();
    TEST_ASSERT_DOUBLE_WITHIN(250, 250000,
                              value(id.axle[SWAY_AXLE_TRAILER_REAR].stiffness.value.re));
}

static void one_of_two_axles_measured_is_no_total(void)
{
    const test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_TRAILER_FRONT_FY);
    identify();
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_EQUAL_SPLIT, id.quality);
    TEST_ASSERT_DOUBLE_WITHIN(200, 124400,
                              value(id.axle[SWAY_AXLE_TRAILER_REAR].stiffness.value.re));
}

static void without_forces_and_inertia_the_cars_axles_are_not_known(void)
{
    const test_plant_t plant = reference_plant(100);
    vehicle.car.yaw_inertia_gm2 = 0;
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_CAR_FRONT_FY);
    identify();
    TEST_ASSERT_BITS_LOW(SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR, id.valid);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_REAR, id.valid);
}

static void the_articulation_is_taken_where_it_is_measured(void)
{
    test_plant_t plant = reference_plant(100);
    plant.pull = 800;
    plant_line(&plant, &vehicle, &line);
    const double complex angle = (cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude) -
                                  cvalue(line.channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude)) /
                                 plant.s;
    identify();
    const double without = value(id.axle[SWAY_AXLE_CAR_REAR].stiffness.value.re);
    TEST_ASSERT_DOUBLE_WITHIN(100, 185200, without);
    set_channel(&line, SWAY_CHANNEL_ARTICULATION, angle);
    identify();
    TEST_ASSERT_DOUBLE_WITHIN(1, without, value(id.axle[SWAY_AXLE_CAR_REAR].stiffness.value.re));
}

static void a_ratio_of_one_axle_alone_is_no_ratio(void)
{
    const test_plant_t plant = {-0.1 + 4.2 * I, 28, {109300, 185200, 120000, 120000},
                                {2690, 10350},  0,  0};
    for (int missing = 0; missing < 2; missing++) {
        vehicle = reference_vehicle();
        vehicle.trailer.front_cornering_stiffness_n_per_rad = missing == 0 ? 0 : 90000;
        vehicle.trailer.rear_cornering_stiffness_n_per_rad = missing == 1 ? 0 : 90000;
        plant_line(&plant, &vehicle, &line);
        drop(SWAY_CHANNEL_TRAILER_FRONT_FY);
        drop(SWAY_CHANNEL_TRAILER_REAR_FY);
        identify(); // half and half, which is right here
        TEST_ASSERT_DOUBLE_WITHIN(200, 120000,
                                  value(id.axle[SWAY_AXLE_TRAILER_FRONT].stiffness.value.re));
    }
}

static void no_tyre_is_that_soft_or_stiff(void)
{
    static const double complex impossible[] = {500, 6e6, 1e5 + 1.2e5 * I, -1e5};
    for (int i = 0; i < 4; i++) {
        test_plant_t plant = reference_plant(100);
        plant.stiffness[0] = impossible[i];
        plant_line(&plant, &vehicle, &line);
        identify();
        TEST_ASSERT_BITS_LOW(SWAY_VALID_CAR_FRONT, id.valid);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_CAR_REAR, id.valid);
        TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_SINGULAR, id.quality);
    }
}

static void a_load_on_an_axle_without_stiffness_says_nothing(void)
{
    test_plant_t plant = reference_plant(100);
    plant.stiffness[0] = 6e6;
    plant_line(&plant, &vehicle, &line);
    set_channel(&line, SWAY_CHANNEL_CAR_FRONT_FZ, 100);
    line.channel[SWAY_CHANNEL_CAR_FRONT_FZ].mean = real(9800);
    identify();
    TEST_ASSERT_BITS_LOW(SWAY_VALID_CAR_FRONT_LOAD, id.valid);
    plant.stiffness[0] = 109300;
    plant_line(&plant, &vehicle, &line);
    set_channel(&line, SWAY_CHANNEL_CAR_FRONT_FZ, 100);
    line.channel[SWAY_CHANNEL_CAR_FRONT_FZ].mean = real(9800);
    identify();
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_CAR_FRONT_LOAD, id.valid);
}

/* --- what the margin needs -------------------------------------------------------------------- */

static void each_value_that_the_model_is_made_of_is_needed(void)
{
    int32_t *const needed[] = {&vehicle.car.yaw_inertia_gm2,
                               &vehicle.car.hitch_to_cog_um,
                               &vehicle.car.front_cornering_stiffness_n_per_rad,
                               &vehicle.car.rear_cornering_stiffness_n_per_rad,
                               &vehicle.trailer.yaw_inertia_gm2,
                               &vehicle.trailer.front_cornering_stiffness_n_per_rad,
                               &vehicle.trailer.rear_cornering_stiffness_n_per_rad};
    for (unsigned i = 0; i < sizeof needed / sizeof needed[0]; i++) {
        vehicle = reference_vehicle();
        *needed[i] = 0;
        sway_margin_init(&margin, &vehicle);
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_margin_start(&margin, NULL, 0, real(30)));
    }
    vehicle = reference_vehicle();
    vehicle.trailer.axles = 1;
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 0; // of an axle that is not there
    sway_margin_init(&margin, &vehicle);
    start(100);
    vehicle = reference_vehicle();
    vehicle.car.mass_g = 0; // not even to be identified
    sway_margin_init(&margin, &vehicle);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_margin_start(&margin, NULL, 0, real(30)));
}

static void a_car_alone_takes_no_notice_of_a_trailers_values(void)
{
    vehicle.trailer.axles = 0;
    sway_margin_init(&margin, &vehicle);
    start(100);
    finish();
    TEST_ASSERT_TRUE(margin.model.has_model);
    for (int p = SWAY_PARAMETER_TRAILER_FRONT_STIFFNESS; p <= SWAY_PARAMETER_TRAILER_REAR_STIFFNESS;
         p++) {
        TEST_ASSERT_TRUE(sway_real_is_zero(margin.root_per_percent[p].re));
        TEST_ASSERT_TRUE(sway_real_is_zero(margin.root_per_percent[p].im));
    }
}

/* --- computations that do not end well -------------------------------------------------------- */

static void lag(int axle, double complex s_by_v, double argument)
{
    margin.stiffness[axle].identified = true;
    margin.stiffness[axle].s_by_v = complex_of(s_by_v);
    margin.stiffness[axle].value = complex_of(185200 * cexp(I * argument));
}

static void a_lag_is_positive_at_the_line_that_shows_it(void)
{
    lag(1, 0.02 + 0.16 * I, -0.1);
    start(100);
    until(STEP_ROOTS);
    TEST_ASSERT_TRUE(value(margin.stm.body[0].relaxation_m[1]) > 0.3);
    lag(1, 2.0 + 0.16 * I, -0.1); // grows so fast that no lag gives this argument
    start(100);
    until(STEP_ROOTS);
    TEST_ASSERT_TRUE(sway_real_is_zero(margin.stm.body[0].relaxation_m[1]));
}

static void roots_that_do_not_settle_are_no_model(void)
{
    start(100);
    until(STEP_ROOTS);
    margin.count = 30; // sweeps: the most that it may take
    finish();
    TEST_ASSERT_FALSE(margin.model.has_model);
}

static void a_root_that_newton_does_not_find_is_no_model(void)
{
    lag(1, 0.02 + 0.16 * I, -0.1);
    start(100);
    finish();
    TEST_ASSERT_TRUE(margin.model.has_model);
    start(100);
    until(STEP_ROOT);
    margin.next.root.im = sway_real_scale(margin.next.root.im, -1); // wild
    finish();
    TEST_ASSERT_FALSE(margin.model.has_model);
    start(100);
    until(STEP_ROOT);
    margin.count = 100; // steps: more than it may take
    finish();
    TEST_ASSERT_FALSE(margin.model.has_model);
}

static void a_limit_that_newton_does_not_find_is_singular(void)
{
    lag(1, 0.02 + 0.16 * I, -0.1);
    start(100);
    finish();
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.model.kind);
    start(100);
    until(STEP_CRITICAL_NEWTON);
    margin.f_v = sway_complex(sway_real_neg(margin.f_s.im), margin.f_s.re); // parallel
    finish();
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_SINGULAR, margin.model.kind);
    start(100);
    until(STEP_CRITICAL_NEWTON);
    margin.count = 100;
    finish();
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_SINGULAR, margin.model.kind);
}

static void a_limit_that_leaves_the_range_is_held_at_its_end(void)
{
    lag(1, 0.02 + 0.16 * I, -0.1);
    start(100);
    until(STEP_CRITICAL_RANGE);
    margin.next.v_crit_m_s = real(2.0);
    finish();
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BELOW_RANGE, margin.model.kind);
    TEST_ASSERT_TRUE(value(margin.model.v_crit_m_s) == value(sway_single_track_speed_low()));
    start(100);
    until(STEP_CRITICAL_RANGE);
    margin.next.v_crit_m_s = real(200.0);
    finish();
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BEYOND_RANGE, margin.model.kind);
    TEST_ASSERT_TRUE(value(margin.model.v_crit_m_s) == value(sway_single_track_speed_high()));
    TEST_ASSERT_EQUAL_UINT32(1U, sway_margin_cost(&margin)); // nothing is left to do
}

/* Without lags the limit is that of the closed form to the last bit, whatever was found before. */
static void without_lags_the_limit_is_that_of_the_closed_form(void)
{
    sway_real_t v;
    sway_real_t omega;
    for (int time = 0; time < 2; time++) {
        start(100);
        finish();
        TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND,
                              sway_single_track_critical_speed(&margin.stm, &v, &omega));
        TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.model.kind);
        TEST_ASSERT_EQUAL_MEMORY(&v, &margin.model.v_crit_m_s, sizeof v);
        TEST_ASSERT_EQUAL_MEMORY(&omega, &margin.model.omega_crit_rad_s, sizeof omega);
        margin.stiffness[1].value.re = real(1.1 * value(margin.stiffness[1].value.re));
    }
}

static int slices_at(int step)
{
    int slices = 0;
    until(step);
    while ((int)margin.step == step) {
        TEST_ASSERT_TRUE(sway_margin_run(&margin));
        slices++;
    }
    return slices;
}

/* Slopes at the limit that was found cost two slices each; they are made where lags have moved the
 * limit, and far. */
static void slopes_are_made_again_only_at_a_limit_that_lags_moved_far(void)
{
    for (int lags = 0; lags < 2; lags++) {
        for (int far = 0; far < 2; far++) {
            const int expected = lags != 0 && far != 0 ? 2 : 1;
            setUp();
            if (lags != 0) {
                lag(1, 0.02 + 0.16 * I, -0.1);
            }
            start(100);
            until(STEP_LIMIT_SLOPE_S);
            TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, margin.next.kind);
            margin.far = far != 0;
            TEST_ASSERT_EQUAL_INT(expected, slices_at(STEP_LIMIT_SLOPE_S));
            TEST_ASSERT_EQUAL_INT(expected, slices_at(STEP_LIMIT_SLOPE_V));
        }
    }
}

/* Derivatives are renewed two at a time only where all of them are there: after a result without a
 * limit, or without a root, all are made. */
static void what_was_not_whole_is_made_whole_the_next_time(void)
{
    start(100);
    finish();
    const sway_margin_t whole = margin;
    for (int missing = 0; missing < 2; missing++) {
        setUp();
        start(100);
        if (missing == 0) {
            until(STEP_CRITICAL_SLOPE_S);
            margin.next.kind = SWAY_VCRIT_BEYOND_RANGE;
        } else {
            until(STEP_ROOTS);
            margin.count = 30; // sweeps: the most that it may take
        }
        finish();
        TEST_ASSERT_EQUAL(missing == 0, margin.model.has_model);
        TEST_ASSERT_EQUAL(missing == 1, margin.model.kind == SWAY_VCRIT_FOUND);
        start(100);
        finish();
        for (int p = 0; p < (int)SWAY_PARAMETER_COUNT; p++) {
            const double limit = value(whole.model.sensitivity_m_s[p]);
            const double complex root = cvalue(whole.root_per_percent[p]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(limit), limit,
                                      value(margin.model.sensitivity_m_s[p]));
            TEST_ASSERT_TRUE(cabs(cvalue(margin.root_per_percent[p]) - root) <= 1e-4 * cabs(root));
        }
    }
}

/* --- the filter of a quantity ----------------------------------------------------------------- */

static void a_lag_seen_at_rest_keeps_its_argument(void)
{
    sway_quantity_t quantity;
    memset(&quantity, 0, sizeof quantity);
    const sway_complex_t still = {sway_real_zero(), sway_real_zero()};
    const sway_complex_t moving = {sway_real_zero(), real(0.16)};
    sway_estimate_t estimate = {complex_of(100000 - 5000 * I), real(100)};
    sway_quantity_take(&quantity, &estimate, still, NULL);
    sway_quantity_take(&quantity, &estimate, still, NULL);
    const double before = value(quantity.value.im);
    sway_quantity_take(&quantity, &estimate, moving, NULL);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, -5000, value(quantity.value.im));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, before, value(quantity.value.im));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_single_axle_takes_the_whole_force);
    RUN_TEST(one_of_two_axles_measured_is_no_total);
    RUN_TEST(without_forces_and_inertia_the_cars_axles_are_not_known);
    RUN_TEST(the_articulation_is_taken_where_it_is_measured);
    RUN_TEST(a_ratio_of_one_axle_alone_is_no_ratio);
    RUN_TEST(no_tyre_is_that_soft_or_stiff);
    RUN_TEST(a_load_on_an_axle_without_stiffness_says_nothing);
    RUN_TEST(each_value_that_the_model_is_made_of_is_needed);
    RUN_TEST(a_car_alone_takes_no_notice_of_a_trailers_values);
    RUN_TEST(a_lag_is_positive_at_the_line_that_shows_it);
    RUN_TEST(roots_that_do_not_settle_are_no_model);
    RUN_TEST(a_root_that_newton_does_not_find_is_no_model);
    RUN_TEST(a_limit_that_newton_does_not_find_is_singular);
    RUN_TEST(a_limit_that_leaves_the_range_is_held_at_its_end);
    RUN_TEST(without_lags_the_limit_is_that_of_the_closed_form);
    RUN_TEST(slopes_are_made_again_only_at_a_limit_that_lags_moved_far);
    RUN_TEST(what_was_not_whole_is_made_whole_the_next_time);
    RUN_TEST(a_lag_seen_at_rest_keeps_its_argument);
    return UNITY_END();
}

/* Critical speed over the swing: against tyres that saturate, and what is not known. */
#include "model/sway_swing.h"
#include "sway_test.h"
#include "unity.h"

static const double FRICTION = 0.9;
static const double G = 9.81;

static sway_vehicle_t vehicle;
static sway_swing_t swing;
static sway_identify_t id;
static sway_margin_model_t model;
static sway_swing_speed_t speed;

void setUp(void)
{
    vehicle = reference_vehicle();
    memset(&id, 0, sizeof id);
    memset(&model, 0, sizeof model);
    model.v_crit_m_s = real(34.0);
    model.v_crit_se_m_s = real(0.5);
    sway_swing_init(&swing, &vehicle);
}

void tearDown(void)
{
}

static void axles_change_v_crit_by(double front, double rear, double trailer_front, double last)
{
    const double exponent[4] = {front, rear, trailer_front, last};
    for (int k = 0; k < 4; k++) {
        model.sensitivity_m_s[SWAY_PARAMETER_CAR_FRONT_STIFFNESS + k] =
            real(exponent[k] * 34.0 / 100.0);
    }
}

/* Every axle has its peak times `share` as its force amplitude in a swing of this size. */
static void see(double swing_rad_s, double share)
{
    for (unsigned k = 0; k < SWAY_AXLE_COUNT; k++) {
        const double force_n = share * value(swing.peak_n[k]);
        id.axle[k].force = sway_phasor_constant(complex_of(force_n * cexp(0.3 * I)));
        id.valid |= (uint32_t)SWAY_VALID_CAR_FRONT << k;
    }
    sway_swing_take(&swing, &id, real(swing_rad_s));
}

static double speed_at(double swing_rad_s)
{
    TEST_ASSERT_TRUE(sway_swing_speed(&swing, &model, real(swing_rad_s), &speed));
    return value(speed.v_crit_m_s);
}

static void peaks_are_shares_of_the_loads_at_rest(void)
{
    const sway_car_t *const car = &vehicle.car;
    const sway_trailer_t *const trailer = &vehicle.trailer;
    const double base = car->front_axle_to_cog_um + car->rear_axle_to_cog_um;
    const double weight = FRICTION * G * car->mass_g / 1000;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, weight * car->rear_axle_to_cog_um / base,
                              value(swing.peak_n[0]));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, weight * car->front_axle_to_cog_um / base,
                              value(swing.peak_n[1]));
    const double tandem = trailer->front_axle_to_cog_um + trailer->rear_axle_to_cog_um;
    const double share = trailer->rear_axle_to_cog_um / tandem;
    const double hung = FRICTION * G * trailer->mass_g / 1000;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, hung * (0.25 + share / 2), value(swing.peak_n[2]));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, hung * (0.75 - share / 2), value(swing.peak_n[3]));
}

/* A centre of gravity ahead of both axles, or behind: at rest one would carry all. */
static void a_load_outside_the_axles_is_carried_by_the_nearer_one(void)
{
    const double hung = FRICTION * G * vehicle.trailer.mass_g / 1000;
    const int32_t place_um[2][2] = {{-100000, 900000}, {900000, -100000}};
    for (int k = 0; k < 2; k++) {
        vehicle.trailer.front_axle_to_cog_um = place_um[k][0];
        vehicle.trailer.rear_axle_to_cog_um = place_um[k][1];
        sway_swing_init(&swing, &vehicle);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, hung * 0.75, value(swing.peak_n[2 + k]));
        TEST_ASSERT_DOUBLE_WITHIN(0.01, hung * 0.25, value(swing.peak_n[3 - k]));
    }
    vehicle.trailer.front_axle_to_cog_um = 0;
    vehicle.trailer.rear_axle_to_cog_um = 0;
    sway_swing_init(&swing, &vehicle);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, hung * 0.75, value(swing.peak_n[2]));
}

static void one_axle_shares_with_the_ball_and_a_car_alone_has_two(void)
{
    vehicle.trailer.axles = 1;
    vehicle.trailer.rear_axle_to_cog_um = 200000;
    vehicle.trailer.hitch_to_cog_um = 3800000;
    sway_swing_init(&swing, &vehicle);
    TEST_ASSERT_TRUE(sway_real_is_zero(swing.peak_n[2]));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, FRICTION * G * vehicle.trailer.mass_g / 1000 * 0.95,
                              value(swing.peak_n[3]));
    vehicle.trailer.axles = 0;
    sway_swing_init(&swing, &vehicle);
    TEST_ASSERT_TRUE(sway_real_is_zero(swing.peak_n[2]));
    TEST_ASSERT_TRUE(sway_real_is_zero(swing.peak_n[3]));
    see(0.05, 0.1);
    axles_change_v_crit_by(0.5, 0, 0, 0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 34.0, speed_at(0.05));
}

static void a_measured_load_replaces_that_at_rest(void)
{
    id.axle[3].load_n = real(7000);
    id.valid = SWAY_VALID_TRAILER_REAR_LOAD;
    sway_swing_take(&swing, &id, real(0.05));
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 6300, value(swing.peak_n[3]));
    TEST_ASSERT_FALSE(sway_swing_speed(&swing, &model, real(0.1), &speed));
}

/* Not before every axle was seen. */
static void nothing_is_reported_of_an_axle_not_seen(void)
{
    TEST_ASSERT_FALSE(sway_swing_speed(&swing, &model, real(0.1), &speed));
    id.valid = SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR | SWAY_VALID_TRAILER_FRONT;
    sway_swing_take(&swing, &id, real(0.05));
    TEST_ASSERT_FALSE(sway_swing_speed(&swing, &model, real(0.1), &speed));
    see(0.05, 0.1);
    TEST_ASSERT_TRUE(sway_swing_speed(&swing, &model, real(0.1), &speed));
}

/* Stiffness of peak tanh(C a / peak) in a harmonic motion, over C. */
static double describing(double x)
{
    double sum = 0;
    for (int k = 0; k < 2000; k++) {
        const double s = sin(2 * M_PI * (k + 0.5) / 2000);
        sum += tanh(x * s) * s;
    }
    return 2 * sum / 2000 / x;
}

/* All tyres alike, v_crit as the root of the stiffness. */
static void v_crit_falls_as_that_of_tyres_that_saturate(void)
{
    axles_change_v_crit_by(0.1, 0.1, 0.1, 0.2);
    for (double seen = 0.05; seen < 0.35; seen += 0.1) {
        for (double now = 0.1; now < 1.6; now += 0.2) {
            setUp();
            axles_change_v_crit_by(0.1, 0.1, 0.1, 0.2);
            see(0.1 * seen, seen * describing(seen));
            const double truth = 34.0 * sqrt(describing(now) / describing(seen));
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * truth, truth, speed_at(0.1 * now));
        }
    }
}

/* Beside the model's error that of y, 60 %. */
static void the_error_grows_with_what_is_assumed(void)
{
    axles_change_v_crit_by(-0.1, 0.3, 0, 0.3);
    see(0.05, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 34.0, speed_at(0.05));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.5, value(speed.se_m_s));
    const double y = (0.25 * 0.25 / 0.05 / 0.05 - 1) * 0.01 / 2;
    const double expected = 34.0 * pow(1 + y, -0.25);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, expected, speed_at(0.25));
    const double assumed = expected * 0.25 * y / (1 + y) * 0.6;
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, hypot(0.5, assumed), value(speed.se_m_s));
    TEST_ASSERT_TRUE(speed_at(0) > 34.0);
}

/* A force beyond the assumed peak does not make a small swing's stiffness infinite. */
static void forces_beyond_the_peak_are_bounded(void)
{
    axles_change_v_crit_by(0.1, 0.1, 0.1, 0.2);
    see(0.2, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 34.0 * 2.0 / sqrt(2.0), speed_at(0));
}

/* What was driven long ago fades; the mean is that of larger swings rather than of many. */
static void old_swings_fade(void)
{
    axles_change_v_crit_by(0.1, 0.1, 0.1, 0.2);
    see(0.02, 0.04);
    for (int k = 0; k < 2000; k++) {
        see(0.2, 0.4);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 34.0, speed_at(0.2));
    for (int k = 0; k < 5000; k++) {
        see(0.02, 0.04);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 34.0, speed_at(0.02));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(peaks_are_shares_of_the_loads_at_rest);
    RUN_TEST(a_load_outside_the_axles_is_carried_by_the_nearer_one);
    RUN_TEST(one_axle_shares_with_the_ball_and_a_car_alone_has_two);
    RUN_TEST(a_measured_load_replaces_that_at_rest);
    RUN_TEST(nothing_is_reported_of_an_axle_not_seen);
    RUN_TEST(v_crit_falls_as_that_of_tyres_that_saturate);
    RUN_TEST(the_error_grows_with_what_is_assumed);
    RUN_TEST(forces_beyond_the_peak_are_bounded);
    RUN_TEST(old_swings_fade);
    return UNITY_END();
}

/* The trailer from the car's own sensors: values that the user does not know, gusts, slices that
 * come too late, answers that cannot be given. */
#include <stdlib.h>

#include "model/sway_trailer.h"
#include "sway_test.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static sway_trailer_watch_t watch;
static int64_t row_us;

void setUp(void)
{
    vehicle = reference_vehicle();
    row_us = 0;
    memset(&watch, 0, sizeof watch);
}

void tearDown(void)
{
}

static void work(void)
{
    while (sway_trailer_cost(&watch) != 0U) {
        sway_trailer_run(&watch);
    }
}

static sway_row_t row_of(double wheel, double speed, double yaw_rate, double acc)
{
    sway_row_t row;
    memset(&row, 0, sizeof row);
    row.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE) |
                     SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED) |
                     SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                     SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC);
    row.time_us = row_us += 10000;
    row.value[SWAY_CHANNEL_STEERING_WHEEL_ANGLE] = (int32_t)lround(wheel * 1e6);
    row.value[SWAY_CHANNEL_SPEED] = (int32_t)lround(speed * 1e3);
    row.value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)lround(yaw_rate * 1e6);
    row.value[SWAY_CHANNEL_CAR_LATERAL_ACC] = (int32_t)lround(acc * 1e6);
    return row;
}

static void push(double wheel, double yaw_rate, double acc)
{
    const sway_row_t row = row_of(wheel, 25.0, yaw_rate, acc);
    sway_trailer_push(&watch, &row);
}

static double se(sway_state_t state)
{
    return value(sway_observer_se(&watch.with, state));
}

static void a_car_that_is_not_known_is_a_typical_one(void)
{
    const double load_front = 1955.0 * 9.81 * 1.383 / (1.302 + 1.383);
    const double load_rear = 1955.0 * 9.81 * 1.302 / (1.302 + 1.383);
    vehicle.car.hitch_to_cog_um = 0;
    vehicle.car.yaw_inertia_gm2 = 0;
    vehicle.car.front_cornering_stiffness_n_per_rad = 0;
    vehicle.car.rear_cornering_stiffness_n_per_rad = 0;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.383 + 1.0, value(watch.with.car.hitch_m));
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, 1955.0 * 1.302 * 1.383, value(watch.with.car.inertia_kgm2));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 13.0 * load_front, value(watch.with.car.front_n_per_rad));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 13.0 * load_rear, value(watch.with.car.rear_n_per_rad));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.35, se(SWAY_STATE_CAR_FRONT));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.35, se(SWAY_STATE_CAR_REAR));
    vehicle = reference_vehicle();
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.08, se(SWAY_STATE_CAR_FRONT));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.08, se(SWAY_STATE_CAR_REAR));
}

static void check_stiffness(bool known, double total, double axle_m)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    const double typical = 12.5;
    const double by_load = known ? total / (1880.0 * 9.81) : typical;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, log(by_load),
                              value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, axle_m, value(watch.with.x[SWAY_STATE_TRAILER_AXLE]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, known ? 0.08 : 0.28, se(SWAY_STATE_TRAILER_STIFFNESS));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.03, se(SWAY_STATE_TRAILER_MASS));
}

static void a_trailers_tyres_that_are_not_known_are_typical_and_open(void)
{
    sway_trailer_t *const trailer = &vehicle.trailer;
    check_stiffness(true, 131200 + 124400, (0.526 * 124400 - 0.124 * 131200) / (131200 + 124400));
    trailer->front_cornering_stiffness_n_per_rad = 0;
    check_stiffness(false, 0, (0.526 - 0.124) / 2);
    trailer->front_cornering_stiffness_n_per_rad = 131200;
    trailer->rear_cornering_stiffness_n_per_rad = 0;
    check_stiffness(false, 0, (0.526 - 0.124) / 2);
    trailer->axles = 1;
    check_stiffness(false, 0, 0.526);
    trailer->rear_cornering_stiffness_n_per_rad = 124400;
    check_stiffness(true, 124400, 0.526);
    trailer->front_cornering_stiffness_n_per_rad = 0; // of an axle that is not there
    check_stiffness(true, 124400, 0.526);
}

/* Yaw rate and acceleration that no vehicle model has: neither observer can explain them. */
static void blow(double yaw_rate, double acc, int rows)
{
    srand(5);
    for (int k = 0; k < rows; k++) {
        const double side = (k / 20) % 2 == 0 ? 1.0 : -1.0;
        push(0.0, side * yaw_rate, -side * acc);
        work();
    }
}

static void a_gust_is_no_proof(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    blow(0.012, 0.35, 1200); // shakes the car, no more than gusts do
    TEST_ASSERT_TRUE(value(watch.with.unfit[0]) > 1.5 || value(watch.with.unfit[1]) > 1.5);
    TEST_ASSERT_TRUE(fabs(value(watch.evidence)) < 10.0);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_UNDECIDED, watch.presence);
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    blow(0.4, 6.0, 1200); // nor does what nobody steered, however large
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_UNDECIDED, watch.presence);
}

/* A swerve every two seconds that a car alone answers with `share` of what its sensors say. */
static void swerve(double share, int rows)
{
    for (int k = 0; k < rows; k++) {
        const double phase = 0.01 * k * 3.0;
        push(0.5 * sin(phase), share * 0.12 * sin(phase - 0.3), share * 3.0 * sin(phase - 0.3));
        work();
    }
}

static void parameters_are_learnt_while_the_driver_steers(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    const double before = value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]);
    const double doubt = se(SWAY_STATE_TRAILER_STIFFNESS);
    blow(0.012, 0.35, 400);
    TEST_ASSERT_TRUE(sway_real_is_zero(watch.with.learning));
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]) == before);
    TEST_ASSERT_TRUE(se(SWAY_STATE_TRAILER_STIFFNESS) >= doubt);
    swerve(1.0, 400);
    TEST_ASSERT_TRUE(value(watch.with.learning) == 0.125 && value(watch.alone.learning) == 0.125);
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]) != before);
}

/* Five seconds after the wheel has come to rest nothing is steered, however hard it was. */
static void a_hard_swerve_is_soon_over(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 1000);
    TEST_ASSERT_TRUE(value(watch.with.learning) == 0.125);
    for (int k = 0; k < 500; k++) {
        push(0.0, 0.0, 0.0);
        work();
    }
    TEST_ASSERT_TRUE(value(watch.steering) < 0.5);
}

/* An estimate beyond its bound is brought back, and what varies with it moves along. */
static void an_estimate_beyond_its_bound_comes_back(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 400);
    watch.with.x[SWAY_STATE_CAR_FRONT] = sway_real_ratio(9, 10); // at most 0.7
    const double front = value(watch.with.x[SWAY_STATE_CAR_FRONT]);
    const double rear = value(watch.with.x[SWAY_STATE_CAR_REAR]);
    const double both =
        value(sway_observer_covariance(&watch.with, SWAY_STATE_CAR_FRONT, SWAY_STATE_CAR_REAR));
    TEST_ASSERT_TRUE(fabs(both) > 0.0);
    swerve(1.0, 4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.7, value(watch.with.x[SWAY_STATE_CAR_FRONT]));
    const double moved = value(watch.with.x[SWAY_STATE_CAR_REAR]) - rear;
    TEST_ASSERT_TRUE(moved * both * (0.7 - front) > 0.0);
}

/* What no car can be, the estimates are not; where neither model fits, nothing says "none". */
static void estimates_stay_where_cars_and_trailers_are(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(-3.0, 3000);
    TEST_ASSERT_TRUE(value(watch.with.unfit[0]) > 16.0 || value(watch.with.unfit[1]) > 16.0);
    TEST_ASSERT_TRUE(watch.presence != SWAY_TRAILER_NONE);
    TEST_ASSERT_DOUBLE_WITHIN(0.701, 0.0, value(watch.with.x[SWAY_STATE_CAR_FRONT]));
    TEST_ASSERT_DOUBLE_WITHIN(0.701, 0.0, value(watch.alone.x[SWAY_STATE_CAR_REAR]));
    TEST_ASSERT_DOUBLE_WITHIN(0.76, 0.25, value(watch.with.x[SWAY_STATE_TRAILER_AXLE]));
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_LENGTH]) < 2.31);
}

/* A trailer of the user's that lies beyond what is usual is not pulled back. */
static void what_the_user_states_is_no_bound(void)
{
    vehicle.trailer.yaw_inertia_gm2 = 200000000; // four times what belongs to its length and mass
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    TEST_ASSERT_TRUE(watch.with.unbound != 0U);
    const double start = value(watch.with.x[SWAY_STATE_TRAILER_GYRATION]);
    TEST_ASSERT_TRUE(start > 0.0);
    blow(0.012, 0.35, 100);
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_GYRATION]) == start);
}

static void slices_that_come_too_late_are_made_up_for(void)
{
    sway_trailer_watch_t prompt;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int k = 0; k < 40; k++) {
        push(0.05 * sin(0.1 * k), 0.02 * sin(0.1 * k - 0.3), 0.5 * sin(0.1 * k - 0.3));
        work();
    }
    prompt = watch;
    setUp();
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int k = 0; k < 40; k++) {
        push(0.05 * sin(0.1 * k), 0.02 * sin(0.1 * k - 0.3), 0.5 * sin(0.1 * k - 0.3));
        sway_trailer_run(&watch); // one slice a row is too few
    }
    work();
    TEST_ASSERT_EQUAL_MEMORY(watch.with.x, prompt.with.x, sizeof prompt.with.x);
    TEST_ASSERT_EQUAL_MEMORY(watch.alone.p, prompt.alone.p, sizeof prompt.alone.p);
    prompt = watch;
    sway_trailer_run(&watch); // nothing to do
    sway_observer_run(&watch.with);
    TEST_ASSERT_EQUAL_MEMORY(&prompt, &watch, sizeof watch);
}

static void the_time_learnt_stops_at_its_end(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    watch.learnt_ms = INT32_MAX / 2 - 1;
    for (int k = 0; k < 12; k++) {
        push(0, 0, 0);
        work();
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MAX / 2 - 1 + 40, watch.learnt_ms);
}

static void model_at(double kmh)
{
    sway_trailer_model_start(&watch, real(kmh / 3.6));
    while (sway_trailer_model_run(&watch)) {
    }
}

static void the_source_is_told_by_what_is_left_of_the_doubt(void)
{
    static const struct {
        double left;
        sway_source_t source;
    } cases[] = {
        {0.85, SWAY_SOURCE_USER}, {0.75, SWAY_SOURCE_PARTLY}, {0.45, SWAY_SOURCE_IDENTIFIED}};
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    model_at(100.0);
    const double start_se = value(watch.start_se);
    for (int i = 0; i < 3; i++) {
        watch.start_se = real(start_se / cases[i].left); // as if so much were left of the doubt
        model_at(100.0);
        TEST_ASSERT_EQUAL_INT(cases[i].source, watch.model.source);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, sway_trailer_model_cost(&watch));
    TEST_ASSERT_FALSE(sway_trailer_model_run(&watch)); // is done already
}

static void roots_that_do_not_settle_are_no_model(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_trailer_model_start(&watch, real(100.0 / 3.6));
    TEST_ASSERT_TRUE(sway_trailer_model_run(&watch));
    watch.count = 30; // sweeps: the most that it may take
    while (sway_trailer_model_run(&watch)) {
    }
    TEST_ASSERT_FALSE(watch.model.has_model);
}

static void a_difference_over_the_end_of_the_range_is_none(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_trailer_model_start(&watch, real(100.0 / 3.6));
    TEST_ASSERT_TRUE(sway_trailer_model_run(&watch));
    watch.next.kind = SWAY_VCRIT_BEYOND_RANGE; // as if a speed were found only where it is moved to
    while (sway_trailer_model_run(&watch)) {
    }
    for (int i = 0; i < SWAY_TRAILER_PARAMETERS; i++) {
        TEST_ASSERT_TRUE(sway_real_is_zero(watch.limit_by[i]));
    }
}

static void the_swing_needs_an_acceleration_and_a_speed(void)
{
    const test_plant_t plant = reference_plant(100.0);
    sway_line_t line;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    plant_line(&plant, &vehicle, &line);
    const double car = cabs(cvalue(line.channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude));
    const double swing = value(sway_trailer_swing(&watch, &line));
    TEST_ASSERT_TRUE(fabs(swing - car) > 0.01 * car);
    line.valid_mask &= ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, car, value(sway_trailer_swing(&watch, &line)));
    plant_line(&plant, &vehicle, &line);
    line.speed_m_s = sway_real_zero();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, car, value(sway_trailer_swing(&watch, &line)));
}

static void the_car_is_reported_as_the_better_observer_has_it(void)
{
    sway_trailer_report_t report;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    watch.alone.x[SWAY_STATE_CAR_FRONT] = real(log(1.25));
    watch.presence = SWAY_TRAILER_NONE;
    sway_trailer_report(&watch, &report);
    TEST_ASSERT_INT_WITHIN(200, 109300 * 5 / 4, report.car_front_n_per_rad.value);
    watch.presence = SWAY_TRAILER_THERE;
    sway_trailer_report(&watch, &report);
    TEST_ASSERT_INT_WITHIN(200, 109300, report.car_front_n_per_rad.value);
}

/* Of now, of the memory, of the start, of their sum: whatever is no covariance, nothing is told. */
static void a_likeness_by_a_covariance_that_is_none_cannot_be_told(void)
{
    sway_trailer_memory_t memory;
    sway_trailer_memory_t sound;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_trailer_remember(&watch, &sound);
    memory = sound;
    for (uint32_t i = 0; i < SWAY_TRAILER_TRIANGLE; i++) {
        memory.covariance[i] = sway_real_int(-1);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &memory)));
    memory = sound; // both know far less of the trailer than the start
    for (uint32_t i = 0; i < SWAY_TRAILER_TRIANGLE; i++) {
        memory.covariance[i] = sway_real_scale(memory.covariance[i], 4);
    }
    for (int i = 0; i < SWAY_OBSERVER_TRIANGLE; i++) {
        watch.with.p[i] = sway_real_scale(watch.with.p[i], 4);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &memory)));
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    watch.doubt[2] = sway_real_zero();
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &sound)));
    for (int i = 0; i < SWAY_OBSERVER_TRIANGLE; i++) {
        watch.with.p[i] = sway_real_int(-1);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &sound)));
}

static void the_car_alone_as_a_model_has_no_trailer(void)
{
    sway_observer_body_t body;
    sway_single_track_t stm;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_observer_body(&watch.alone, &body);
    sway_observer_model(&watch.alone, &body, &stm);
    TEST_ASSERT_FALSE(stm.has_trailer);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 109300,
                              value(stm.body[SWAY_SINGLE_TRACK_CAR].stiffness_n_per_rad[0]));
    TEST_ASSERT_TRUE(sway_real_is_zero(stm.body[SWAY_SINGLE_TRACK_TRAILER].mass_kg));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_car_that_is_not_known_is_a_typical_one);
    RUN_TEST(a_trailers_tyres_that_are_not_known_are_typical_and_open);
    RUN_TEST(a_gust_is_no_proof);
    RUN_TEST(parameters_are_learnt_while_the_driver_steers);
    RUN_TEST(a_hard_swerve_is_soon_over);
    RUN_TEST(an_estimate_beyond_its_bound_comes_back);
    RUN_TEST(estimates_stay_where_cars_and_trailers_are);
    RUN_TEST(what_the_user_states_is_no_bound);
    RUN_TEST(slices_that_come_too_late_are_made_up_for);
    RUN_TEST(the_time_learnt_stops_at_its_end);
    RUN_TEST(the_source_is_told_by_what_is_left_of_the_doubt);
    RUN_TEST(roots_that_do_not_settle_are_no_model);
    RUN_TEST(a_difference_over_the_end_of_the_range_is_none);
    RUN_TEST(the_swing_needs_an_acceleration_and_a_speed);
    RUN_TEST(the_car_is_reported_as_the_better_observer_has_it);
    RUN_TEST(a_likeness_by_a_covariance_that_is_none_cannot_be_told);
    RUN_TEST(the_car_alone_as_a_model_has_no_trailer);
    return UNITY_END();
}

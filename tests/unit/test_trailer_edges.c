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
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, log(by_load),
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
    const double uncertainty = se(SWAY_STATE_TRAILER_STIFFNESS);
    blow(0.012, 0.35, 400);
    TEST_ASSERT_TRUE(sway_real_is_zero(watch.with.learning));
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]) == before);
    TEST_ASSERT_TRUE(se(SWAY_STATE_TRAILER_STIFFNESS) >= uncertainty);
    swerve(1.0, 400);
    /* 3 m/s2 have a mean square of 4.5 */
    TEST_ASSERT_DOUBLE_WITHIN(0.011, 0.125 / (1 + pow(4.5 / 8, 2)), value(watch.with.learning));
    TEST_ASSERT_TRUE(value(watch.alone.learning) == value(watch.with.learning));
    TEST_ASSERT_TRUE(value(watch.with.x[SWAY_STATE_TRAILER_STIFFNESS]) != before);
}

/* Where tyres level off the assumed curve is wrong by as much: what is learnt falls with the
 * square of the acceleration's mean square, as it was before the sample. */
static void beyond_the_linear_range_less_is_learnt(void)
{
    static const double powers[] = {0, 8, 16, 40};
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 400);
    for (int i = 0; i < 4; i++) {
        watch.with.acc_power = real(powers[i]);
        swerve(1.0, 4);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.125 / (1 + pow(powers[i] / 8, 2)),
                                  value(watch.with.learning));
    }
}

/* Five seconds after the wheel has come to rest nothing is steered, however hard it was. */
static void a_hard_swerve_is_soon_over(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 1000);
    TEST_ASSERT_TRUE(value(watch.steering) > 0.5 && value(watch.with.learning) > 0.08);
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

static void the_source_follows_from_what_is_left_of_the_uncertainty(void)
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
        watch.start_se = real(start_se / cases[i].left); // as if so much of it were left
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
    TEST_ASSERT_TRUE(sway_trailer_model_run(&watch));
    TEST_ASSERT_EQUAL(2, watch.step);
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

static double x_of(sway_state_t state)
{
    return value(watch.with.x[state]);
}

/* What is not known at the start is not left over from before; standard errors as sway_trailer.c
 * says them in words. */
static void a_start_is_from_the_users_values_alone(void)
{
    static const double sure[SWAY_TRAILER_UNKNOWNS] = {0.03, 0.015, 0.1, 0.08, 0.05, 1};
    static const double open[SWAY_TRAILER_UNKNOWNS] = {0.4, 0.27, 0.3, 0.28, 0.12, 1};
    const double length = vehicle.trailer.hitch_to_cog_um * 1e-6;
    for (int known = 1; known >= 0; known--) {
        vehicle = reference_vehicle();
        vehicle.trailer.axles = known != 0 ? vehicle.trailer.axles : 0;
        memset(&watch, 0x55, sizeof watch);
        sway_trailer_init(&watch, &vehicle, 0, 10000);
        TEST_ASSERT_FALSE(watch.sensed || watch.busy[0] || watch.busy[1] || watch.has_model);
        TEST_ASSERT_EQUAL(SWAY_TRAILER_UNDECIDED, watch.presence);
        TEST_ASSERT_EQUAL(0, watch.learnt_ms + watch.rows);
        TEST_ASSERT_TRUE(sway_real_is_zero(watch.evidence) && sway_real_is_zero(watch.net));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.01, se(SWAY_STATE_YAW_RATE_OFFSET));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.3, se(SWAY_STATE_ACC_OFFSET));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.05, se(SWAY_STATE_STEERING_OFFSET));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.1, se(SWAY_STATE_CAR_INERTIA));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.05, se(SWAY_STATE_CAR_COG));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.3, x_of(SWAY_STATE_RELAXATION));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.15, se(SWAY_STATE_RELAXATION));
        for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, known != 0 ? sure[i] : open[i],
                                      se((sway_state_t)(SWAY_STATE_TRAILER_MASS + i)));
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, log(known != 0 ? 1880 : 0.8 * 1955),
                                  x_of(SWAY_STATE_TRAILER_MASS));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, log(known != 0 ? 10350 / (1880 * length * length) : 0.22),
                                  x_of(SWAY_STATE_TRAILER_GYRATION));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, log(known != 0 ? length : 4.3),
                                  x_of(SWAY_STATE_TRAILER_LENGTH));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.18, x_of(SWAY_STATE_TRAILER_AXLE));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2690, value(watch.with.car.inertia_kgm2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0 / 15, value(watch.with.car.ratio));
}

/* A row is of use that has the car's four signals, follows another and is fast enough; a sensor of
 * the trailer ends it for good. What was in the making is dropped. */
static void rows_of_no_use_begin_a_pause(void)
{
    static const sway_channel_t own[4] = {SWAY_CHANNEL_STEERING_WHEEL_ANGLE, SWAY_CHANNEL_SPEED,
                                          SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_CAR_LATERAL_ACC};
    static const sway_channel_t others[3] = {
        SWAY_CHANNEL_TRAILER_YAW_RATE, SWAY_CHANNEL_TRAILER_LATERAL_ACC, SWAY_CHANNEL_ARTICULATION};
    for (int i = 0; i < 10; i++) {
        sway_trailer_init(&watch, &vehicle, 0, 10000);
        for (int k = 0; k < 8; k++) {
            push(0.01, 0.02, 0.3);
        }
        TEST_ASSERT_TRUE(watch.busy[0] && watch.busy[1] && watch.alone.moving);
        for (int k = 0; k < 2; k++) {
            push(0.01, 0.02, 0.3);
        }
        TEST_ASSERT_EQUAL(2, watch.rows);
        sway_row_t row = row_of(0.01, i == 8 ? 7.999 : 8, 0.02, 0.3);
        row.valid_mask ^= i < 4 ? SWAY_CHANNEL_BIT(own[i]) : 0U;
        row.valid_mask |= i >= 4 && i < 7 ? SWAY_CHANNEL_BIT(others[i - 4]) : 0U;
        row.restart = i == 7;
        sway_trailer_push(&watch, &row);
        TEST_ASSERT_EQUAL(i == 9 ? 3 : 0, watch.rows);
        TEST_ASSERT_EQUAL(i == 9, watch.busy[0]);
        TEST_ASSERT_EQUAL(i == 9, watch.busy[1]);
        TEST_ASSERT_EQUAL(i == 9, watch.alone.moving);
        TEST_ASSERT_EQUAL(i == 9, watch.with.moving);
        TEST_ASSERT_EQUAL(i >= 4 && i < 7, watch.sensed);
        for (int k = 0; k < 4; k++) {
            TEST_ASSERT_EQUAL(i == 9, watch.sum[k] != 0);
        }
    }
}

/* The acceleration that the wheel asks for, less its two-second mean: its mean square, of which 0.3
 * (m/s^2)^2 is enough to learn with all of an eighth. */
static void the_driver_is_heard_as_far_as_he_steers(void)
{
    double mean = 0, power = 0;
    bool part = false;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int k = 0; k < 200; k++) {
        const double wheel = 0.003 * k * sin(0.2 * k);
        for (int row = 0; row < 4; row++) {
            push(wheel, 0, 0);
        }
        const double asked = round(1e6 * wheel) * 1e-6 / 15 / (1.302 + 1.383) * 625;
        mean += 0.02 * (asked - mean);
        power += 0.02 * (fmin(pow(asked - mean, 2), 4) - power);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, mean, value(watch.asked));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, power, value(watch.steering));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, fmin(power / 0.3, 1) / 8, value(watch.with.learning));
        TEST_ASSERT_DOUBLE_WITHIN(0, value(watch.with.learning), value(watch.alone.learning));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, 25, value(watch.with.now.speed_m_s));
        part = part || (power > 0.1 && power < 0.3);
        TEST_ASSERT_EQUAL(40 * (k + 1), watch.learnt_ms);
    }
    TEST_ASSERT_TRUE(part && power > 0.3);
    watch.learnt_ms = INT32_MAX / 2;
    for (int row = 0; row < 4; row++) {
        push(0, 0, 0);
    }
    TEST_ASSERT_EQUAL(INT32_MAX / 2, watch.learnt_ms);
}

static void both_models_are_asked_beside_the_same_road(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 400);
    watch.with.road = real(0.75);
    watch.alone.road = real(0.25);
    for (int row = 0; row < 4; row++) {
        push(0, 0, 0);
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.75, value(watch.alone.road));
}

/* --- is it there? ------------------------------------------------------------------------------
 */

/* Runs to the slice after which the models are weighed; that slice is left to be run. */
static void run_to_the_last_slice(void)
{
    for (;;) {
        const sway_trailer_watch_t before = watch;
        sway_trailer_run(&watch);
        if (!watch.busy[0] && !watch.busy[1]) {
            watch = before;
            return;
        }
        TEST_ASSERT_EQUAL_DOUBLE(value(before.evidence), value(watch.evidence));
        TEST_ASSERT_EQUAL_DOUBLE(value(before.net), value(watch.net));
    }
}

static void the_evidence_decides_by_its_sum(void)
{
    enum { NEVER, NONE, THERE };
    static const struct {
        double evidence, net, steering, unfit[2];
        int before, after;
    } cases[] = {
        {3, 2, 0.6, {1, 1}, NEVER, NEVER},    {3, 2, 0.497, {1, 1}, NEVER, NEVER},
        {9.5, 2, 0.6, {1, 1}, NEVER, THERE},  {-3, -2, 1.6, {1, 1}, NEVER, NEVER},
        {-3, -2, 1.49, {1, 1}, NEVER, NEVER}, {-9.5, -3, 1.6, {1, 1}, NEVER, NONE},
        {3, 2, 0.6, {30, 1}, NEVER, NEVER},   {3, 2, 0.6, {1, 30}, NEVER, NEVER},
        {29.9, 9, 0.6, {1, 1}, THERE, THERE}, {-29.9, -9, 2, {1, 1}, NONE, NONE},
        {10, 0, 0, {1, 1}, NEVER, THERE},     {9.99, 0, 0, {1, 1}, NEVER, NEVER},
        {-10, 0, 0, {1, 1}, NEVER, NONE},     {-9.99, 0, 0, {1, 1}, NEVER, NEVER},
        {5, 0, 0, {1, 1}, THERE, THERE},      {0, 0, 0, {1, 1}, THERE, NEVER},
        {-5, 0, 0, {1, 1}, THERE, NEVER},     {-5, 0, 0, {1, 1}, NONE, NONE},
        {5, 0, 0, {1, 1}, NONE, NEVER},       {0, 0, 0, {1, 1}, NONE, NONE},
    };
    static const int presence[3] = {SWAY_TRAILER_UNDECIDED, SWAY_TRAILER_NONE, SWAY_TRAILER_THERE};
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    swerve(1.0, 400);
    for (int row = 0; row < 4; row++) {
        push(0.05, 0.02, 0.4);
    }
    run_to_the_last_slice();
    const sway_trailer_watch_t ready = watch;
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        watch = ready;
        watch.evidence = real(cases[c].evidence);
        watch.net = real(cases[c].net);
        watch.steering = real(cases[c].steering);
        watch.presence = (uint8_t)presence[cases[c].before];
        watch.with.unfit[0] = real(cases[c].unfit[0]);
        watch.with.unfit[1] = real(cases[c].unfit[1]);
        sway_trailer_run(&watch);
        TEST_ASSERT_EQUAL(0, sway_trailer_cost(&watch));
        const double gain = value(watch.with.log_likelihood) - value(watch.alone.log_likelihood);
        const double net = cases[c].net + 0.02 * (gain - 0.4 - cases[c].net);
        const bool counts = cases[c].steering >= (net > 0 ? 0.5 : 1.5) && cases[c].unfit[0] < 16 &&
                            cases[c].unfit[1] < 16;
        const double sum = cases[c].evidence + (counts ? net / 2 : 0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, net, value(watch.net));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, fmax(-30, fmin(30, sum)), value(watch.evidence));
        TEST_ASSERT_EQUAL(presence[cases[c].after], watch.presence);
    }
}

static void the_observer_speaks_of_what_it_has_learnt_and_believes(void)
{
    for (int c = 0; c < 24; c++) {
        memset(&watch, 0, sizeof watch);
        watch.configured = c % 2 == 1;
        watch.sensed = c / 2 % 2 == 1;
        watch.learnt_ms = c / 4 % 2;
        watch.presence = (uint8_t)(c / 8);
        const bool believed = watch.presence == SWAY_TRAILER_THERE ||
                              (watch.configured && watch.presence == SWAY_TRAILER_UNDECIDED);
        TEST_ASSERT_EQUAL(believed && !watch.sensed && watch.learnt_ms == 1,
                          sway_trailer_speaks(&watch));
    }
}

/* --- the model ---------------------------------------------------------------------------------
 */

static const sway_state_t MOVING[SWAY_TRAILER_PARAMETERS] = {
    SWAY_STATE_CAR_FRONT,        SWAY_STATE_CAR_REAR,          SWAY_STATE_CAR_INERTIA,
    SWAY_STATE_CAR_COG,          SWAY_STATE_TRAILER_MASS,      SWAY_STATE_TRAILER_LENGTH,
    SWAY_STATE_TRAILER_GYRATION, SWAY_STATE_TRAILER_STIFFNESS, SWAY_STATE_TRAILER_AXLE,
    SWAY_STATE_RELAXATION,
};

enum { STIFF = SWAY_TRAILER_PARAMETERS - 1 };

static double ratio_of(sway_state_t state, double step, double v)
{
    sway_observer_body_t body;
    sway_single_track_t stm;
    sway_single_track_roots_t roots;
    sway_observer_body(&watch.with, &body);
    sway_observer_move(&body, state, real(step));
    sway_observer_model(&watch.with, &body, &stm);
    const sway_single_track_quartic_t quartic = sway_single_track_quartic(&stm, real(v));
    sway_single_track_roots_start(&roots, &quartic);
    for (int k = 0; k < 40 && !sway_single_track_roots_sweep(&roots, &quartic); k++) {
    }
    return value(sway_single_track_damping_ratio(sway_single_track_dominant(&roots)));
}

static double spread_of(const sway_real_t *by)
{
    double sum = 0;
    for (int i = 0; i < SWAY_TRAILER_PARAMETERS; i++) {
        for (int j = 0; j < SWAY_TRAILER_PARAMETERS; j++) {
            sum += value(by[i]) * value(by[j]) *
                   value(sway_observer_covariance(&watch.with, MOVING[i], MOVING[j]));
        }
    }
    return sum;
}

static void a_model_has_the_errors_of_all_that_moves_it(void)
{
    const double v = 100 / 3.6;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_trailer_model_start(&watch, real(v));
    while (watch.step < 3) {
        TEST_ASSERT_TRUE(sway_trailer_model_run(&watch));
    }
    const sway_complex_t s = watch.next.root;
    const double h = 0.01;
    const double complex up =
        cvalue(sway_single_track_characteristic(&watch.stm, complex_of(cvalue(s) + h), real(v)));
    const double complex down =
        cvalue(sway_single_track_characteristic(&watch.stm, complex_of(cvalue(s) - h), real(v)));
    const double complex slope = (up - down) / (2 * h);
    TEST_ASSERT_TRUE(cabs(cvalue(watch.f_s) - slope) < 1e-3 * cabs(slope));
    while (sway_trailer_model_run(&watch)) {
    }
    TEST_ASSERT_TRUE(watch.has_model && watch.model.has_model && watch.model.has_steady);
    for (int i = 0; i < STIFF; i++) {
        const double by = (ratio_of(MOVING[i], 0.004, v) - ratio_of(MOVING[i], -0.004, v)) / 0.008;
        TEST_ASSERT_DOUBLE_WITHIN(0.01 + 0.02 * fabs(by), by, value(watch.ratio_by[i]));
    }
    const double floor = 0.013 * value(watch.model.v_crit_m_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, sqrt(floor * floor + spread_of(watch.limit_by)),
                              value(watch.model.v_crit_se_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, sqrt(spread_of(watch.ratio_by)),
                              value(watch.model.damping_ratio_se));
}

/* Root and limit of the watched combination by Newton with its tyres' lag; result: the limit's
 * frequency. */
static double late(double relaxation_m, double v, double *ratio, double *limit)
{
    sway_single_track_t stm = watch.stm;
    sway_real_t v_crit, omega, d_omega, d_v;
    sway_complex_t s = watch.next.root, f_s, f_v;
    (void)sway_single_track_critical_speed(&stm, &v_crit, &omega);
    for (int i = 0; i < 4; i++) {
        stm.body[i / 2].relaxation_m[i % 2] = real(relaxation_m);
    }
    for (int i = 0; i < 30; i++) {
        for (uint32_t half = 0; half < 2; half++) {
            (void)sway_single_track_slope_s(&stm, s, real(v), half, &f_s);
        }
        const sway_complex_t f = sway_single_track_characteristic(&stm, s, real(v));
        s = sway_complex_sub(s, sway_complex_div(f, f_s));
    }
    *ratio = value(sway_single_track_damping_ratio(s));
    for (int i = 0; i < 30; i++) {
        const sway_complex_t at = {real(0), omega};
        for (uint32_t half = 0; half < 2; half++) {
            (void)sway_single_track_slope_s(&stm, at, v_crit, half, &f_s);
            (void)sway_single_track_slope_v(&stm, at, v_crit, half, &f_v);
        }
        const sway_complex_t f = sway_single_track_characteristic(&stm, at, v_crit);
        TEST_ASSERT_EQUAL(SWAY_OK, sway_single_track_shift(f_s, f_v, f, &d_omega, &d_v));
        v_crit = sway_real_add(v_crit, d_v);
        omega = sway_real_add(omega, d_omega);
    }
    *limit = value(v_crit);
    return value(omega);
}

/* Tyres that lag lower damping and limit, in proportion: at the usual length nearly exact, at twice
 * of it 0.0034 and 0.4 km/h are left. */
static void tyres_that_lag_lower_damping_and_limit(void)
{
    static const struct {
        double length, ratio_off, limit_off;
    } cases[] = {{0, 1e-6, 1e-5}, {0.15, 5e-4, 0.02}, {0.3, 5e-4, 0.03}, {0.6, 4e-3, 0.15}};
    double ratio, limit, first_ratio = 0, first_limit = 0;
    for (int i = 0; i < 4; i++) {
        sway_trailer_init(&watch, &vehicle, 0, 10000);
        watch.with.x[SWAY_STATE_RELAXATION] = real(cases[i].length);
        model_at(100);
        const double omega = late(cases[i].length, 100 / 3.6, &ratio, &limit);
        TEST_ASSERT_DOUBLE_WITHIN(cases[i].ratio_off, ratio, value(watch.model.damping_ratio));
        TEST_ASSERT_DOUBLE_WITHIN(cases[i].limit_off, limit, value(watch.model.v_crit_m_s));
        first_ratio = i == 0 ? ratio : first_ratio;
        first_limit = i == 0 ? limit : first_limit;
        if (i == 2) {
            TEST_ASSERT_DOUBLE_WITHIN(0.004, (ratio - first_ratio) / 0.3,
                                      value(watch.ratio_by[STIFF]));
            TEST_ASSERT_DOUBLE_WITHIN(0.1, (limit - first_limit) / 0.3,
                                      value(watch.limit_by[STIFF]));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, omega, value(watch.next.omega_crit_rad_s));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, value(watch.next.damping_ratio),
                                      value(sway_single_track_damping_ratio(watch.next.root)));
        }
    }
}

/* Nine derivatives in the first model, then three a model in turn; a slice more ends them. */
static void derivatives_are_renewed_in_turn(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int model = 0; model < 5; model++) {
        int slices = 0;
        memset(&watch.next, 0x55, sizeof watch.next);
        watch.count = 9;
        sway_trailer_model_start(&watch, real(100.0 / 3.6));
        TEST_ASSERT_EQUAL(0, watch.step + watch.count + watch.next.kind);
        TEST_ASSERT_TRUE(sway_real_is_zero(watch.next.v_crit_m_s));
        for (bool more = true; more;) {
            const bool is_last = watch.step == 8;
            slices += watch.step == 3;
            more = sway_trailer_model_run(&watch);
            TEST_ASSERT_EQUAL(!is_last, more);
        }
        TEST_ASSERT_EQUAL(model == 0 ? 10 : 4, slices);
        TEST_ASSERT_EQUAL(3 * model % 9, watch.turn);
    }
}

/* All variances together, so that the error is this share of the critical speed. */
static void limit_uncertain_by(double share)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    model_at(100);
    const double limit = value(watch.model.v_crit_m_s);
    const double floor = 0.013 * limit;
    const double now = value(watch.model.v_crit_se_m_s);
    const double factor =
        (share * share * limit * limit - floor * floor) / (now * now - floor * floor);
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int i = 0; i < SWAY_OBSERVER_TRIANGLE; i++) {
        watch.with.p[i] = sway_real_mul(watch.with.p[i], real(factor));
    }
    model_at(100);
}

static void a_limit_too_uncertain_is_not_reported(void)
{
    limit_uncertain_by(0.149);
    TEST_ASSERT_EQUAL(SWAY_VCRIT_FOUND, watch.model.kind);
    TEST_ASSERT_TRUE(watch.model.has_model);
    TEST_ASSERT_FALSE(watch.model.vague);
    limit_uncertain_by(0.151);
    TEST_ASSERT_EQUAL(SWAY_VCRIT_FOUND, watch.model.kind);
    TEST_ASSERT_FALSE(watch.model.has_model);
    TEST_ASSERT_TRUE(watch.model.vague);
    limit_uncertain_by(0.249);
    TEST_ASSERT_EQUAL(SWAY_VCRIT_FOUND, watch.model.kind);
    limit_uncertain_by(0.251);
    TEST_ASSERT_EQUAL(SWAY_VCRIT_NONE, watch.model.kind);
    TEST_ASSERT_FALSE(watch.model.has_model);
}

/* --- what it says ------------------------------------------------------------------------------
 */

static void put(sway_observer_t *observer, sway_state_t state, double now, double error)
{
    observer->x[state] = real(now);
    observer->p[state * (state + 1) / 2 + state] = real(error * error);
}

static void together(sway_observer_t *observer, sway_state_t high, sway_state_t low, double now)
{
    TEST_ASSERT_TRUE(high > low);
    observer->p[high * (high + 1) / 2 + low] = real(now);
}

static void expect_number(sway_trailer_number_t number, double expected, double error)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.55 + 1e-7 * fabs(expected), expected, number.value);
    TEST_ASSERT_DOUBLE_WITHIN(0.55 + 1e-6 * error, error, number.se);
}

/* Errors of logarithms are relative; of a product they are those of the sum of logarithms. */
static void what_is_reported_has_the_errors_of_its_parts(void)
{
    sway_trailer_report_t report;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    memset(watch.with.p, 0, sizeof watch.with.p);
    put(&watch.with, SWAY_STATE_TRAILER_MASS, log(2000), 0.03);
    put(&watch.with, SWAY_STATE_TRAILER_LENGTH, log(5), 0.02);
    put(&watch.with, SWAY_STATE_TRAILER_GYRATION, log(0.2), 0.05);
    put(&watch.with, SWAY_STATE_TRAILER_STIFFNESS, log(12), 0.04);
    put(&watch.with, SWAY_STATE_TRAILER_AXLE, 0.2, 0.03);
    put(&watch.with, SWAY_STATE_FRICTION, 9, 4);
    put(&watch.with, SWAY_STATE_TRAILER_YAW_RATE, -2.5, 1.25);
    put(&watch.with, SWAY_STATE_ARTICULATION, 1.5, 2);
    put(&watch.with, SWAY_STATE_CAR_FRONT, log(1.5), 0.1);
    put(&watch.with, SWAY_STATE_CAR_REAR, log(0.5), 0.2);
    together(&watch.with, SWAY_STATE_TRAILER_LENGTH, SWAY_STATE_TRAILER_MASS, -0.0003);
    together(&watch.with, SWAY_STATE_TRAILER_GYRATION, SWAY_STATE_TRAILER_MASS, 0.0007);
    together(&watch.with, SWAY_STATE_TRAILER_GYRATION, SWAY_STATE_TRAILER_LENGTH, -0.0004);
    together(&watch.with, SWAY_STATE_TRAILER_STIFFNESS, SWAY_STATE_TRAILER_MASS, -0.0006);
    together(&watch.with, SWAY_STATE_TRAILER_AXLE, SWAY_STATE_TRAILER_LENGTH, -0.0002);
    watch.evidence = real(-29.5);
    watch.learnt_ms = 123456;
    watch.with.unfit[0] = real(2.5);
    watch.with.unfit[1] = real(3.75);
    sway_trailer_report(&watch, &report);
    expect_number(report.mass_kg, 2000, 60);
    expect_number(report.hitch_to_cog_mm, 5000, 100);
    expect_number(report.hitch_to_axle_mm, 5200,
                  1000 * sqrt(25 * 0.0004 + 0.0009 + 2 * 5 * -0.0002));
    expect_number(report.yaw_inertia_kgm2, 0.2 * 2000 * 25,
                  1e4 * sqrt(0.0009 + 4 * 0.0004 + 0.0025 - 4 * 0.0003 + 2 * 0.0007 - 4 * 0.0004));
    const double stiffness = 12 * 2000 * 9.81;
    expect_number(report.stiffness_n_per_rad, stiffness,
                  stiffness * sqrt(0.0009 + 0.0016 - 2 * 0.0006));
    expect_number(report.friction_nm, 900, 400);
    expect_number(report.yaw_rate_urad_s, -2500000, 1250000);
    expect_number(report.articulation_urad, 1500000, 2000000);
    expect_number(report.car_front_n_per_rad, 1.5 * 109300, 0.15 * 109300);
    expect_number(report.car_rear_n_per_rad, 0.5 * 185200, 0.1 * 185200);
    TEST_ASSERT_EQUAL(-29500, report.evidence_milli);
    TEST_ASSERT_EQUAL(123456, report.learnt_ms);
    TEST_ASSERT_EQUAL(2500, report.agreement_milli[0]);
    TEST_ASSERT_EQUAL(3750, report.agreement_milli[1]);
    memset(watch.with.p, 0, sizeof watch.with.p);
    watch.with.unfit[0] = watch.with.unfit[1] = sway_real_zero();
    sway_trailer_report(&watch, &report);
    TEST_ASSERT_EQUAL(0, report.agreement_milli[0] + report.agreement_milli[1]);
    TEST_ASSERT_EQUAL(0, report.mass_kg.se + report.friction_nm.se + report.yaw_inertia_kgm2.se);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_car_that_is_not_known_is_a_typical_one);
    RUN_TEST(a_trailers_tyres_that_are_not_known_are_typical_and_open);
    RUN_TEST(a_gust_is_no_proof);
    RUN_TEST(parameters_are_learnt_while_the_driver_steers);
    RUN_TEST(beyond_the_linear_range_less_is_learnt);
    RUN_TEST(a_hard_swerve_is_soon_over);
    RUN_TEST(an_estimate_beyond_its_bound_comes_back);
    RUN_TEST(estimates_stay_where_cars_and_trailers_are);
    RUN_TEST(what_the_user_states_is_no_bound);
    RUN_TEST(slices_that_come_too_late_are_made_up_for);
    RUN_TEST(the_time_learnt_stops_at_its_end);
    RUN_TEST(the_source_follows_from_what_is_left_of_the_uncertainty);
    RUN_TEST(roots_that_do_not_settle_are_no_model);
    RUN_TEST(a_difference_over_the_end_of_the_range_is_none);
    RUN_TEST(the_swing_needs_an_acceleration_and_a_speed);
    RUN_TEST(the_car_is_reported_as_the_better_observer_has_it);
    RUN_TEST(the_car_alone_as_a_model_has_no_trailer);
    RUN_TEST(a_start_is_from_the_users_values_alone);
    RUN_TEST(rows_of_no_use_begin_a_pause);
    RUN_TEST(the_driver_is_heard_as_far_as_he_steers);
    RUN_TEST(both_models_are_asked_beside_the_same_road);
    RUN_TEST(the_evidence_decides_by_its_sum);
    RUN_TEST(the_observer_speaks_of_what_it_has_learnt_and_believes);
    RUN_TEST(a_model_has_the_errors_of_all_that_moves_it);
    RUN_TEST(tyres_that_lag_lower_damping_and_limit);
    RUN_TEST(derivatives_are_renewed_in_turn);
    RUN_TEST(a_limit_too_uncertain_is_not_reported);
    RUN_TEST(what_is_reported_has_the_errors_of_its_parts);
    return UNITY_END();
}

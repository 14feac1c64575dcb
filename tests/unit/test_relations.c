/* Relations between the inputs: on the motion of an exact linear combination every one of them
 * holds, and where the vehicle or a sensor is another one by a little, its residual is what its
 * slope says. */
#include "model/sway_relations.h"
#include <stdio.h>

#include "sway_test.h"
#include "unity.h"

#define SPEED 25.0
#define LAG 0.35
#define PERIOD_US 10000
#define TONES 3

/* Three tones between the harmonics, or one at the fourth. */
static const double complex BETWEEN[TONES] = {-0.05 + 2.9 * I, 4.4 * I, 0.04 + 5.7 * I};
static const double complex FOURTH[TONES] = {4 * 2 * M_PI / 5.12 * I};
static const double complex *s = BETWEEN;

static sway_vehicle_t vehicle; /* as it is believed */
static sway_relations_sums_t sums;
static sway_relations_t relations;

/* Sensors of a drive: bits of channels. */
#define STEERED SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE)
#define CAR                                                                                        \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC))
#define TRAILER                                                                                    \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE) |                                             \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_LATERAL_ACC))
#define ANGLE SWAY_CHANNEL_BIT(SWAY_CHANNEL_ARTICULATION)
#define HITCH SWAY_CHANNEL_BIT(SWAY_CHANNEL_HITCH_FY)
#define CAR_FORCES                                                                                 \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_FRONT_FY) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_REAR_FY))
#define TRAILER_FORCES                                                                             \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_FRONT_FY) |                                             \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_REAR_FY))
#define MOTIONS (STEERED | CAR | TRAILER)
#define ALL (MOTIONS | ANGLE | HITCH | CAR_FORCES | TRAILER_FORCES)

/* What the drive really is: the believed vehicle with one number off by a little. */
typedef struct {
    uint32_t sensors;
    int number; /* sway_unknown_t; -1: none */
    double by;
    double size; /* of the motion */
} truth_t;

void setUp(void)
{
    vehicle = reference_vehicle();
    memset(&sums, 0, sizeof sums);
    s = BETWEEN;
}

void tearDown(void)
{
}

static void one_axle(void)
{
    vehicle.trailer.axles = 1;
    vehicle.trailer.rear_axle_to_cog_um = 201000;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 255600;
}

/* --- drives --------------------------------------------------------------------------------------
 */

static double off(const truth_t *truth, int number)
{
    return truth->number == number ? truth->by : 0;
}

static int32_t times(int32_t value, double factor)
{
    return (int32_t)lround(value * factor);
}

static sway_vehicle_t true_vehicle(const truth_t *truth)
{
    sway_vehicle_t real_one = vehicle;
    const int32_t place = (int32_t)lround(
        1e6 * (off(truth, SWAY_UNKNOWN_TRAILER_PLACE) + off(truth, SWAY_UNKNOWN_CHANGED_PLACE)));
    const int32_t length = (int32_t)lround(1e6 * off(truth, SWAY_UNKNOWN_TRAILER_LENGTH));
    real_one.car.mass_g = times(vehicle.car.mass_g, 1 + off(truth, SWAY_UNKNOWN_CAR_MASS));
    real_one.trailer.mass_g =
        times(vehicle.trailer.mass_g,
              1 + off(truth, SWAY_UNKNOWN_TRAILER_MASS) + off(truth, SWAY_UNKNOWN_CHANGED_MASS));
    real_one.trailer.front_axle_to_cog_um -= place;
    real_one.trailer.rear_axle_to_cog_um += place;
    real_one.trailer.lateral_acc_position_um -= place;
    real_one.trailer.hitch_to_cog_um += length - place;
    return real_one;
}

static void tone(const truth_t *truth, double complex at, sway_line_t *line)
{
    const sway_vehicle_t real_one = true_vehicle(truth);
    const double stiffness[4] = {vehicle.car.front_cornering_stiffness_n_per_rad,
                                 vehicle.car.rear_cornering_stiffness_n_per_rad,
                                 vehicle.trailer.front_cornering_stiffness_n_per_rad,
                                 vehicle.trailer.rear_cornering_stiffness_n_per_rad};
    test_plant_t plant = {.s = at, .v = SPEED};
    for (int axle = 0; axle < 4; axle++) {
        const double lag =
            LAG + off(truth, axle < 2 ? SWAY_UNKNOWN_CAR_LAG : SWAY_UNKNOWN_TRAILER_LAG);
        plant.stiffness[axle] = stiffness[axle] * (1 - at * lag / SPEED) *
                                (1 + off(truth, SWAY_UNKNOWN_STIFFNESS + axle) +
                                 off(truth, SWAY_UNKNOWN_CHANGED_STIFFNESS + axle));
    }
    plant.inertia[0] =
        vehicle.car.yaw_inertia_gm2 / 1e3 * (1 + off(truth, SWAY_UNKNOWN_CAR_INERTIA));
    plant.inertia[1] =
        vehicle.trailer.yaw_inertia_gm2 / 1e3 * (1 + off(truth, SWAY_UNKNOWN_TRAILER_INERTIA));
    plant.friction = 100 * off(truth, SWAY_UNKNOWN_FRICTION) / 8727e-6;
    plant_line(&plant, &real_one, line);
    set_channel(line, SWAY_CHANNEL_ARTICULATION,
                (cvalue(line->channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude) -
                 cvalue(line->channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude)) /
                    at);
}

/* What a sensor shows of the truth in a tone. */
static double complex shown(const truth_t *truth, int sensor, double complex at)
{
    const double bin = 2 * M_PI / (512 * PERIOD_US * 1e-6);
    const double delay = off(truth, 2 * sensor + 1) / (4 * bin);
    const double roll = sensor == SWAY_ORIGIN_CAR_ACC - 1       ? off(truth, SWAY_UNKNOWN_ROLL)
                        : sensor == SWAY_ORIGIN_TRAILER_ACC - 1 ? off(truth, SWAY_UNKNOWN_ROLL + 1)
                                                                : 0;
    return cexp(-at * delay) / (1 + off(truth, 2 * sensor) + roll);
}

static void drive(const truth_t *truth)
{
    static double complex amplitude[TONES][SWAY_RELATIONS_SENSORS];
    for (int n = 0; n < TONES && s[n] != 0; n++) {
        static sway_line_t line;
        tone(truth, s[n], &line);
        for (int i = 0; i < SWAY_RELATIONS_SENSORS; i++) {
            const sway_channel_t channel = sway_origin_of_channel((sway_origin_t)(i + 1));
            const double unit = channel >= SWAY_CHANNEL_HITCH_FX ? 1e3 : 1e6;
            amplitude[n][i] = (line.valid_mask & SWAY_CHANNEL_BIT(channel)) == 0
                                  ? 0
                                  : cvalue(line.channel[channel].amplitude) * unit * truth->size *
                                        shown(truth, i, s[n]);
        }
    }
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = truth->sensors | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
        row.value[SWAY_CHANNEL_SPEED] =
            (int32_t)lround(SPEED * 1e3 / (1 + off(truth, SWAY_UNKNOWN_SPEED)));
        for (int i = 0; i < SWAY_RELATIONS_SENSORS; i++) {
            double value_now = 0;
            for (int n = 0; n < TONES && s[n] != 0; n++) {
                value_now += creal(amplitude[n][i] * cexp(s[n] * (k * PERIOD_US * 1e-6)));
            }
            row.value[sway_origin_of_channel((sway_origin_t)(i + 1))] = (int32_t)lround(value_now);
        }
        TEST_ASSERT_EQUAL(k == SWAY_RELATIONS_ROWS - 1, sway_relations_add(&sums, &row));
    }
    TEST_ASSERT_TRUE(sway_relations_start(&relations, &vehicle, &sums, PERIOD_US));
}

static void run(sway_relation_t relation, uint32_t harmonic)
{
    sway_relations_begin(&relations, relation, harmonic);
    while (sway_relations_run(&relations)) {
    }
}

static uint32_t allowed(void)
{
    uint32_t mask = 0;
    for (int i = 0; i < (int)SWAY_RELATION_COUNT; i++) {
        mask |= sway_relations_allow(&relations, (sway_relation_t)i) ? 1U << i : 0U;
    }
    return mask;
}

/* --- every relation holds, and its slopes are right ----------------------------------------------
 */

#define NUMBERS ((int)SWAY_UNKNOWN_COUNT)

static double step_of(int number)
{
    return number == (int)SWAY_UNKNOWN_FRICTION ? 0.2 : 0.004;
}

static double complex residual[SWAY_RELATION_COUNT][6];
static double size[SWAY_RELATION_COUNT][6];

/* A delay is known by its phase at the harmonic, which is exact for a tone there. */
static bool is_delay(int number)
{
    return number < (int)SWAY_UNKNOWN_SPEED && number % 2 == 1;
}

static uint32_t first(void)
{
    return s == FOURTH ? 4 : SWAY_RELATIONS_FIRST;
}

static uint32_t last(void)
{
    return s == FOURTH ? 4 : SWAY_RELATIONS_LAST;
}

static void expect_relations_to_hold(uint32_t sensors, double motion, double accuracy)
{
    const truth_t exact = {sensors, -1, 0, motion};
    drive(&exact);
    for (int r = 0; r < (int)SWAY_RELATION_COUNT; r++) {
        for (uint32_t h = first(); (allowed() >> r & 1U) != 0 && h <= last(); h++) {
            run((sway_relation_t)r, h);
            size[r][h] = sqrt(value(relations.size_squared));
            residual[r][h] = cvalue(relations.residual);
            TEST_ASSERT_TRUE(size[r][h] > 0);
            TEST_ASSERT_DOUBLE_WITHIN(accuracy, 0, cabs(residual[r][h]) / size[r][h]);
            for (int i = 1; i < (int)SWAY_UNKNOWN_SPEED; i += 2) {
                const double complex gain = cvalue(relations.slope[i - 1]);
                const double complex turned = cvalue(relations.slope[i]) - I * (h / 4.0) * gain;
                TEST_ASSERT_TRUE(cabs(turned) <= 1e-8 * cabs(gain));
            }
        }
    }
}

/* Turns one number of the truth a little: each residual moves as its slope says, or stays. */
static void expect_slope(uint32_t sensors, int number, double motion)
{
    const truth_t truth = {sensors, number, step_of(number), motion};
    drive(&truth);
    for (int r = 0; r < (int)SWAY_RELATION_COUNT; r++) {
        for (uint32_t h = first(); (allowed() >> r & 1U) != 0 && h <= last(); h++) {
            run((sway_relation_t)r, h);
            const double complex moved = cvalue(relations.residual) - residual[r][h];
            const double complex predicted = -step_of(number) * cvalue(relations.slope[number]);
            const double tolerance = 0.01 * cabs(predicted) + 4e-6 / motion * size[r][h];
            if (cabs(moved - predicted) > tolerance) {
                char text[100];
                (void)snprintf(text, sizeof text, "relation %d, harmonic %u, number %d: %g of %g",
                               r, (unsigned)h, number, cabs(moved - predicted), tolerance);
                TEST_FAIL_MESSAGE(text);
            }
        }
    }
}

static void expect_all(uint32_t sensors)
{
    expect_relations_to_hold(sensors, 0.15, 2e-3);
    for (int number = 0; number < NUMBERS; number++) {
        if (number != (int)SWAY_UNKNOWN_FRICTION && !is_delay(number)) {
            expect_slope(sensors, number, 0.15);
        }
    }
    s = FOURTH;
    expect_relations_to_hold(sensors, 0.15, 2e-3);
    for (int number = 1; number < (int)SWAY_UNKNOWN_SPEED; number += 2) {
        expect_slope(sensors, number, 0.15);
    }
    s = BETWEEN;
    /* Dry friction is linear as long as the ball hardly turns. */
    expect_relations_to_hold(sensors, 0.006, 0.01);
    expect_slope(sensors, SWAY_UNKNOWN_FRICTION, 0.006);
}

static void relations_of_motions_hold(void)
{
    expect_all(MOTIONS);
}

static void relations_of_forces_hold(void)
{
    expect_all(ALL);
}

static void relations_with_the_hitch_force_hold(void)
{
    expect_all(MOTIONS | HITCH);
}

static void relations_of_one_axle_hold(void)
{
    one_axle();
    expect_all(MOTIONS | ANGLE);
    expect_all(ALL & ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_FRONT_FY));
}

static void relations_of_an_axle_at_the_centre_of_gravity_hold(void)
{
    vehicle.trailer.front_axle_to_cog_um = 0;
    expect_all(MOTIONS | HITCH);
}

static void relations_of_a_car_alone_hold(void)
{
    vehicle.trailer.axles = 0;
    expect_relations_to_hold(STEERED | CAR | CAR_FORCES, 0.15, 2e-3);
    expect_slope(STEERED | CAR | CAR_FORCES, SWAY_UNKNOWN_CAR_INERTIA, 0.15);
    expect_relations_to_hold(STEERED | CAR, 0.15, 2e-3);
    expect_slope(STEERED | CAR, SWAY_UNKNOWN_STIFFNESS, 0.15);
}

/* --- what is allowed -----------------------------------------------------------------------------
 */

#define R(name) (1U << SWAY_RELATION_##name)

static void expect_allowed(uint32_t sensors, uint32_t expected)
{
    const truth_t truth = {sensors, -1, 0, 0.1};
    drive(&truth);
    TEST_ASSERT_EQUAL_HEX32(expected, allowed());
}

static void inputs_allow_relations(void)
{
    const uint32_t balances = R(CAR_YAW) | R(TRAILER_LATERAL) | R(TRAILER_YAW);
    expect_allowed(STEERED | CAR, R(CAR_YAW));
    expect_allowed(CAR, 0);
    expect_allowed(MOTIONS & ~CAR, 0);
    expect_allowed(CAR | TRAILER, R(HITCH));
    expect_allowed(CAR | TRAILER | ANGLE, R(HITCH) | R(ARTICULATION));
    expect_allowed(MOTIONS, R(HITCH) | balances);
    expect_allowed(MOTIONS | HITCH, R(HITCH) | R(CAR_LATERAL) | balances);
    expect_allowed(TRAILER | HITCH, R(TRAILER_LATERAL) | R(TRAILER_YAW));
    expect_allowed(TRAILER, 0);
    expect_allowed(CAR | CAR_FORCES, R(CAR_YAW) | R(CAR_REAR));
    expect_allowed(STEERED | CAR | CAR_FORCES, R(CAR_YAW) | R(CAR_REAR) | R(CAR_FRONT));
    expect_allowed(ALL, (1U << SWAY_RELATION_COUNT) - 1U);
}

static void the_vehicle_allows_relations(void)
{
    vehicle.car.rear_cornering_stiffness_n_per_rad = 0;
    expect_allowed(STEERED | CAR, 0);
    vehicle = reference_vehicle();
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 0;
    expect_allowed(MOTIONS, R(HITCH) | R(CAR_YAW));
    vehicle = reference_vehicle();
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 0;
    expect_allowed(MOTIONS, R(HITCH) | R(CAR_YAW));
    vehicle = reference_vehicle();
    vehicle.car.yaw_inertia_gm2 = 0;
    expect_allowed(STEERED | CAR, 0);
    vehicle = reference_vehicle();
    one_axle();
    expect_allowed(ALL, (1U << SWAY_RELATION_COUNT) - 1U - R(TRAILER_FRONT));
    vehicle.trailer.axles = 0;
    expect_allowed(ALL, R(CAR_LATERAL) | R(CAR_YAW) | R(CAR_FRONT) | R(CAR_REAR));
}

/* --- windows and harmonics of use ---------------------------------------------------------------
 */

static void quiet_window(int32_t first_speed, int32_t last_speed, int32_t acc)
{
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = MOTIONS | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
        row.value[SWAY_CHANNEL_SPEED] =
            first_speed + (last_speed - first_speed) * k / (SWAY_RELATIONS_ROWS - 1);
        row.value[SWAY_CHANNEL_CAR_LATERAL_ACC] = k == 7 ? acc : 0;
        row.value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] = k == 300 ? -acc : 0;
        (void)sway_relations_add(&sums, &row);
    }
}

static bool starts(void)
{
    return sway_relations_start(&relations, &vehicle, &sums, PERIOD_US);
}

static void a_window_is_of_use_at_speed_unbraked_and_in_the_linear_range(void)
{
    quiet_window(25000, 25000, 0);
    TEST_ASSERT_TRUE(starts());
    quiet_window(8333, 8333, 0);
    TEST_ASSERT_TRUE(starts());
    quiet_window(8332, 8400, 0);
    TEST_ASSERT_FALSE(starts());
    quiet_window(20000, 19000, 0);
    TEST_ASSERT_TRUE(starts());
    quiet_window(20000, 18999, 0);
    TEST_ASSERT_FALSE(starts());
    quiet_window(25000, 25000, 2500000);
    TEST_ASSERT_TRUE(starts());
    quiet_window(25000, 25000, 2500001);
    TEST_ASSERT_FALSE(starts());
    quiet_window(25000, 25000, -2500001);
    TEST_ASSERT_FALSE(starts());
}

static void a_window_needs_the_speed_in_every_row(void)
{
    quiet_window(25000, 25000, 0);
    sums.known &= ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
    TEST_ASSERT_FALSE(starts());
}

static void a_clock_that_starts_again_begins_a_window(void)
{
    sway_row_t row = {.valid_mask = MOTIONS | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
    row.value[SWAY_CHANNEL_SPEED] = 25000;
    quiet_window(25000, 25000, 0);
    for (int k = 0; k < 100; k++) {
        (void)sway_relations_add(&sums, &row);
    }
    row.restart = true;
    TEST_ASSERT_FALSE(sway_relations_add(&sums, &row));
    TEST_ASSERT_EQUAL(1, sums.rows);
}

static void what_was_missing_in_one_row_is_not_known(void)
{
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = MOTIONS | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
        row.valid_mask &= k == 100 ? ~TRAILER : UINT32_MAX;
        row.value[SWAY_CHANNEL_SPEED] = 25000;
        row.value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] = k == 100 ? 9000000 : 0; /* says nothing */
        (void)sway_relations_add(&sums, &row);
    }
    TEST_ASSERT_TRUE(starts());
    TEST_ASSERT_EQUAL_HEX32(R(CAR_YAW), allowed());
}

static void balances_are_asked_where_the_driver_steers(void)
{
    const truth_t truth = {ALL, -1, 0, 0.15};
    drive(&truth);
    sway_relations_begin(&relations, SWAY_RELATION_CAR_YAW, 3);
    TEST_ASSERT_TRUE(sway_relations_is_driven(&relations));
    quiet_window(25000, 25000, 0);
    TEST_ASSERT_TRUE(starts());
    sway_relations_begin(&relations, SWAY_RELATION_CAR_LATERAL, 4);
    TEST_ASSERT_FALSE(sway_relations_is_driven(&relations));
    sway_relations_begin(&relations, SWAY_RELATION_HITCH, 4);
    TEST_ASSERT_TRUE(sway_relations_is_driven(&relations));
}

/* A standing car's signals have no noise here: what is left is what wind and road do unseen, three
 * times, because relations and harmonics are not independent. */
static void variance_holds_wind_road_and_noise(void)
{
    const double omega = 4 * 2 * M_PI / 5.12;
    const struct {
        sway_relation_t relation;
        double unseen, noise;
    } cases[] = {
        {SWAY_RELATION_CAR_YAW, 200 * omega, 0},
        {SWAY_RELATION_TRAILER_YAW, 200 * omega, 0},
        {SWAY_RELATION_TRAILER_LATERAL, 100 * omega, 0},
        {SWAY_RELATION_CAR_FRONT, 100 * omega, 0},
        {SWAY_RELATION_ARTICULATION, 0, sqrt(2 * 3e-4 * 3e-4 + 3e-4 * 3e-4 * omega * omega)},
        {SWAY_RELATION_CAR_LATERAL, 100 * omega,
         omega * sqrt(1955 * 1955 * (0.015 * 0.015 + 1.383 * 1.383 * 9e-8 * omega * omega) +
                      3 * 20.0 * 20.0)},
    };
    const truth_t still = {ALL, -1, 0, 0};
    drive(&still);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        run(cases[i].relation, 4);
        const double noise_squared =
            cases[i].noise > 0 ? cases[i].noise * cases[i].noise : value(relations.noise);
        const double expected = 3 * (cases[i].unseen * cases[i].unseen + noise_squared);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * expected, expected,
                                  value(sway_relations_variance(&relations)));
    }
    const truth_t moving = {ALL, -1, 0, 0.15};
    drive(&moving);
    run(SWAY_RELATION_HITCH, 4);
    const double expected = 3 * (value(relations.noise) + 9e-4 * value(relations.size_squared));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * expected, expected,
                              value(sway_relations_variance(&relations)));
}

static int64_t rounded_2_15(double a)
{
    const long product = lround(32768 * a);
    return product > 32767 ? 32767 : product < -32767 ? -32767 : product;
}

/* A window's sums turn by one sine and cosine, right to the last bit in every row. */
static void sums_turn_by_the_rounded_sine(void)
{
    sway_row_t row = {.valid_mask = ALL | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
    row.value[SWAY_CHANNEL_SPEED] = 25000;
    row.value[SWAY_CHANNEL_CAR_YAW_RATE] = 1;
    const uint32_t source = (uint32_t)SWAY_ORIGIN_CAR_YAW_RATE - 1U;
    for (unsigned k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        int64_t before[2] = {0, 0};
        if (k > 0) {
            memcpy(before, sums.sum[source][0], sizeof before);
        }
        TEST_ASSERT_EQUAL(k + 1 == SWAY_RELATIONS_ROWS, sway_relations_add(&sums, &row));
        const double turn = 2 * M_PI * k / SWAY_RELATIONS_ROWS;
        TEST_ASSERT_EQUAL_INT64(rounded_2_15(cos(turn)), sums.sum[source][0][0] - before[0]);
        TEST_ASSERT_EQUAL_INT64(-rounded_2_15(sin(turn)), sums.sum[source][0][1] - before[1]);
    }
}

/* An accelerometer of the trailer that is not at its centre of gravity. */
static void relations_with_a_sensor_off_the_centre_of_gravity_hold(void)
{
    vehicle.trailer.lateral_acc_position_um = 600000;
    expect_all(MOTIONS | HITCH);
}

/* Dry friction works by the direction of sliding, and is whole at 0.5 deg/s. */
static void sliding_has_the_sign_of_the_articulation_rate(void)
{
    static const int32_t cases[][3] = {/* yaw rates of car and trailer, slide */
                                       {10000, 0, -8727},
                                       {0, 10000, 8727},
                                       {-3000, 3000, 6000},
                                       {3000, -3000, -6000},
                                       {-20000, 20000, 8727}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sway_row_t row = {.valid_mask = UINT32_MAX};
        row.value[SWAY_CHANNEL_CAR_YAW_RATE] = cases[i][0];
        row.value[SWAY_CHANNEL_TRAILER_YAW_RATE] = cases[i][1];
        memset(&sums, 0, sizeof sums);
        (void)sway_relations_add(&sums, &row);
        TEST_ASSERT_EQUAL_INT64(INT64_C(32767) * cases[i][2],
                                sums.sum[SWAY_RELATIONS_SENSORS][0][0]);
    }
}

/* A window with one row beyond the linear range is of no use: of either body, to either side, if
 * that is measured. */
static void one_row_beyond_the_linear_range_spoils_a_window(void)
{
    static const sway_channel_t channels[2] = {SWAY_CHANNEL_CAR_LATERAL_ACC,
                                               SWAY_CHANNEL_TRAILER_LATERAL_ACC};
    static const int32_t limits[4] = {-2500001, -2500000, 2500000, 2500001};
    for (int body = 0; body < 2; body++) {
        for (int i = 0; i < 4; i++) {
            const int32_t acc = limits[i];
            for (int seen = 0; seen < 2; seen++) {
                memset(&sums, 0, sizeof sums);
                for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
                    sway_row_t row = {.valid_mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
                    row.value[SWAY_CHANNEL_SPEED] = 25000;
                    row.value[channels[body]] = k == 7 ? acc : 0;
                    row.valid_mask |= seen != 0 ? CAR | TRAILER : 0U;
                    (void)sway_relations_add(&sums, &row);
                }
                const bool beyond = seen != 0 && (acc > 2500000 || acc < -2500000);
                TEST_ASSERT_EQUAL(!beyond,
                                  sway_relations_start(&relations, &vehicle, &sums, PERIOD_US));
            }
        }
    }
}

/* A steering of so much at the fourth harmonic, nothing else. */
static void steer(double wheel)
{
    memset(&sums, 0, sizeof sums);
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = ALL | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
        row.value[SWAY_CHANNEL_SPEED] = 25000;
        const double now = cos(2 * M_PI * 4 * k / SWAY_RELATIONS_ROWS);
        row.value[SWAY_CHANNEL_STEERING_WHEEL_ANGLE] = (int32_t)lround(1e6 * wheel * now);
        row.value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)lround(1e5 * now);
        (void)sway_relations_add(&sums, &row);
    }
    TEST_ASSERT_TRUE(sway_relations_start(&relations, &vehicle, &sums, PERIOD_US));
}

static void the_amplitude_of_the_wheel_decides_not_its_rate(void)
{
    for (int i = 0; i < 2; i++) {
        steer(i == 0 ? 0.0145 : 0.0155);
        sway_relations_begin(&relations, SWAY_RELATION_CAR_YAW, 4);
        TEST_ASSERT_EQUAL(i == 1, sway_relations_is_driven(&relations));
        sway_relations_begin(&relations, SWAY_RELATION_HITCH, 4);
        TEST_ASSERT_TRUE(sway_relations_is_driven(&relations));
    }
}

/* With all forces measured the yaw rate is in the moments on the car by its inertia alone. */
static void a_part_of_a_residual_is_in_newton_and_metre(void)
{
    steer(0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.1, creal(cvalue(relations.bin[1][3])));
    run(SWAY_RELATION_CAR_YAW, 4);
    const double omega = 4 * 2 * M_PI / 5.12;
    const double moment = vehicle.car.yaw_inertia_gm2 / 1e3 * omega * omega * 0.1;
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * moment, -moment, creal(cvalue(relations.slope[2])));
    /* What is not in the relation does not move it. */
    TEST_ASSERT_EQUAL_DOUBLE(0, cabs(cvalue(relations.slope[SWAY_UNKNOWN_TRAILER_MASS])));
    TEST_ASSERT_EQUAL_DOUBLE(0, cabs(cvalue(relations.slope[SWAY_UNKNOWN_STIFFNESS])));
    const double once = value(sway_relations_variance(&relations));
    run(SWAY_RELATION_CAR_YAW, 4);
    TEST_ASSERT_EQUAL_DOUBLE(once, value(sway_relations_variance(&relations)));
}

/* Dry friction of 100 Nm, sliding to and fro at the fourth harmonic with most of the rate at which
 * it is whole: so much of 100 Nm turns the car back. */
static void friction_is_in_newton_metre(void)
{
    memset(&sums, 0, sizeof sums);
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = ALL | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)};
        row.value[SWAY_CHANNEL_SPEED] = 25000;
        row.value[SWAY_CHANNEL_TRAILER_YAW_RATE] =
            (int32_t)lround(8000 * cos(2 * M_PI * 4 * k / SWAY_RELATIONS_ROWS));
        (void)sway_relations_add(&sums, &row);
    }
    TEST_ASSERT_TRUE(sway_relations_start(&relations, &vehicle, &sums, PERIOD_US));
    run(SWAY_RELATION_CAR_YAW, 4);
    const double expected = -100 * 4 * 2 * M_PI / 5.12 * 8000 / 8727; // its rate: times j omega
    const double complex slope = cvalue(relations.slope[SWAY_UNKNOWN_FRICTION]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(expected), expected, cimag(slope));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(expected), 0, creal(slope));
}

static void what_is_not_there_is_not_used(void)
{
    /* sliding needs both yaw rates */
    const truth_t without_trailer = {STEERED | CAR | HITCH | CAR_FORCES, -1, 0, 0.1};
    drive(&without_trailer);
    run(SWAY_RELATION_CAR_YAW, 4);
    TEST_ASSERT_EQUAL_DOUBLE(0, cabs(cvalue(relations.slope[SWAY_UNKNOWN_FRICTION])));
    const truth_t with_trailer = {ALL, -1, 0, 0.1};
    drive(&with_trailer);
    run(SWAY_RELATION_CAR_YAW, 4);
    TEST_ASSERT_TRUE(cabs(cvalue(relations.slope[SWAY_UNKNOWN_FRICTION])) > 0);
    /* a car alone has no hitch force, whatever the sensor shows */
    run(SWAY_RELATION_CAR_LATERAL, 4);
    TEST_ASSERT_TRUE(cabs(cvalue(relations.slope[2 * (SWAY_ORIGIN_HITCH_FY - 1)])) > 0);
    vehicle.trailer.axles = 0;
    run(SWAY_RELATION_CAR_LATERAL, 4);
    TEST_ASSERT_EQUAL_DOUBLE(0, cabs(cvalue(relations.slope[2 * (SWAY_ORIGIN_HITCH_FY - 1)])));
    vehicle.trailer.axles = 2;
    /* angles alone are no relation, and an axle of which nothing is known is no balance */
    expect_allowed(ANGLE, 0);
    expect_allowed(ANGLE | CAR, 0);
    expect_allowed(ANGLE | TRAILER, 0);
    one_axle();
    vehicle.car.front_cornering_stiffness_n_per_rad = 0;
    expect_allowed(STEERED | CAR | HITCH, 0);
}

/* Without a sensor at the hitch its noise is in no variance: a slice for each term that is there.
 */
static void a_term_that_is_not_there_takes_no_slice(void)
{
    for (int measured = 0; measured < 2; measured++) {
        const truth_t truth = {measured != 0 ? ALL : ALL & ~HITCH, -1, 0, 0.1};
        int slices = 1;
        drive(&truth);
        sway_relations_begin(&relations, SWAY_RELATION_TRAILER_LATERAL, 4);
        while (sway_relations_run(&relations)) {
            slices++;
        }
        /* masses and forces of the car, or the hitch; those of the trailer; the end */
        TEST_ASSERT_EQUAL(measured != 0 ? 5 : 7, slices);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(relations_of_motions_hold);
    RUN_TEST(relations_of_forces_hold);
    RUN_TEST(relations_with_the_hitch_force_hold);
    RUN_TEST(relations_of_one_axle_hold);
    RUN_TEST(relations_of_an_axle_at_the_centre_of_gravity_hold);
    RUN_TEST(relations_of_a_car_alone_hold);
    RUN_TEST(inputs_allow_relations);
    RUN_TEST(the_vehicle_allows_relations);
    RUN_TEST(a_window_is_of_use_at_speed_unbraked_and_in_the_linear_range);
    RUN_TEST(a_window_needs_the_speed_in_every_row);
    RUN_TEST(a_clock_that_starts_again_begins_a_window);
    RUN_TEST(what_was_missing_in_one_row_is_not_known);
    RUN_TEST(balances_are_asked_where_the_driver_steers);
    RUN_TEST(variance_holds_wind_road_and_noise);
    RUN_TEST(sums_turn_by_the_rounded_sine);
    RUN_TEST(relations_with_a_sensor_off_the_centre_of_gravity_hold);
    RUN_TEST(sliding_has_the_sign_of_the_articulation_rate);
    RUN_TEST(one_row_beyond_the_linear_range_spoils_a_window);
    RUN_TEST(the_amplitude_of_the_wheel_decides_not_its_rate);
    RUN_TEST(a_part_of_a_residual_is_in_newton_and_metre);
    RUN_TEST(friction_is_in_newton_metre);
    RUN_TEST(what_is_not_there_is_not_used);
    RUN_TEST(a_term_that_is_not_there_takes_no_slice);
    return UNITY_END();
}

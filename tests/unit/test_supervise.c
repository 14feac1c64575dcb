/* Supervision: numbers within tolerances, and drives of a linear combination with a broken sensor.
 */
#include <stdlib.h>

#include "judge/sway_supervise.h"
#include "sway_test.h"
#include "unity.h"

static int begins = 6000; /* row */

void setUp(void)
{
    begins = 6000;
}

void tearDown(void)
{
}

/* --- numbers within tolerances -------------------------------------------------------------------
 */

#define NUMBERS 3
static int32_t tolerance[NUMBERS];
static sway_real_t found[NUMBERS], slope[NUMBERS], moved[NUMBERS];
static sway_real_t covariance[SWAY_KALMAN_TRIANGLE(NUMBERS)];

static sway_kalman_t three_numbers(void)
{
    sway_kalman_t gauss = {.count = NUMBERS,
                           .tolerance_ppm = tolerance,
                           .value = found,
                           .covariance = covariance,
                           .slope = slope,
                           .moved = moved};
    tolerance[0] = 100000;
    tolerance[1] = 200000;
    tolerance[2] = 50000;
    sway_kalman_reset(&gauss);
    return gauss;
}

static void take(sway_kalman_t *gauss, double a, double b, double residual, double variance)
{
    slope[0] = real(a);
    slope[1] = real(b);
    slope[2] = real(0);
    while (sway_kalman_take(gauss, real(residual), real(variance))) {
    }
}

static void a_relation_moves_numbers_as_kalman_says(void)
{
    sway_kalman_t gauss = three_numbers();
    take(&gauss, 1, 2, 0.1, 0.01);
    const double q = 0.01 + 0.01 * 1 + 0.04 * 4; /* of the innovation */
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.01 * 0.1 / q, value(found[0]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.08 * 0.1 / q, value(found[1]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0, value(found[2]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.01 - 0.0001 / q, value(sway_kalman_covariance(&gauss, 0, 0)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, -0.0008 / q, value(sway_kalman_covariance(&gauss, 1, 0)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.0025, value(sway_kalman_covariance(&gauss, 2, 2)));
}

/* A correction that was broken off is not gone on with. */
static void after_a_reset_a_relation_is_taken_from_its_first_number(void)
{
    sway_kalman_t gauss = three_numbers();
    memset(moved, 0, sizeof moved);
    gauss.row = 2;
    sway_kalman_reset(&gauss);
    take(&gauss, 1, 2, 0.1, 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.01 * 0.1 / 0.18, value(found[0]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.08 * 0.1 / 0.18, value(found[1]));
}

static void what_is_far_off_counts_as_three_errors(void)
{
    sway_kalman_t gauss = three_numbers();
    take(&gauss, 1, 0, -100, 0.01);
    /* Variance of the innovation becomes 100^2/9: gain 0.01 * 9 / 100. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0009, value(found[0]));
}

static void setting_free_is_worth_what_the_tolerance_cost(void)
{
    sway_kalman_t gauss = three_numbers();
    const uint8_t first = 0, second = 1, third = 2;
    for (int i = 0; i < 50; i++) {
        take(&gauss, 1, 0, -0.4, 0.001); /* the number is 0.4: four tolerances */
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 16, value(sway_kalman_worth(&gauss, &first, 1)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, value(sway_kalman_worth(&gauss, &second, 1)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, value(sway_kalman_worth(&gauss, &third, 1)));
    const uint8_t both[2] = {1, 0};
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 16, value(sway_kalman_worth(&gauss, both, 2)));
    sway_real_t free, se;
    sway_kalman_free(&gauss, 0, &free, &se);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.4, value(free));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, sqrt(0.001 / 50), value(se));
    sway_kalman_free(&gauss, 2, &free, &se);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, value(se));
}

static void what_fades_returns_to_its_tolerance_and_not_beyond(void)
{
    sway_kalman_t gauss = three_numbers();
    take(&gauss, 1, 1, 0.3, 0.0001);
    const double kept = value(found[1]);
    for (int i = 0; i < 200; i++) {
        while (sway_kalman_fade(&gauss, 1, 900000)) {
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, value(found[0]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.01, value(sway_kalman_covariance(&gauss, 0, 0)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, value(sway_kalman_covariance(&gauss, 1, 0)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, kept, value(found[1]));
}

/* --- drives --------------------------------------------------------------------------------------
 */

/* Motion of the reference combination, linear, tyres without lag; v_y at the car's COG. */
typedef struct {
    double vy, r, w, theta;
    double a1, a2;   /* at the rear axle of the car; at the trailer's COG */
    double force[4]; /* of the axles */
    double hitch;    /* on the car */
} motion_t;

static const double LEVER[4] = {1.302, -1.383, 0.124, -0.526};

/* `hold`: of the forces of each axle, and the mass of the trailer, what is left of them. */
typedef struct {
    double axle[4], mass;
} hold_t;

static void step(motion_t *m, double v, double wheel, const hold_t *hold, double dt)
{
    const double m1 = 1955, m2 = hold->mass * 1880, i1 = 2690, i2 = 10350, lh = 2.166, l = 5.073;
    const double hitch = m->vy - lh * m->r;
    double *const f = m->force;
    f[0] = hold->axle[0] * 109300 * (wheel / 15 - (m->vy + LEVER[0] * m->r) / v);
    f[1] = hold->axle[1] * -185200 * (m->vy + LEVER[1] * m->r) / v;
    f[2] = hold->axle[2] * 131200 * (m->theta - (hitch - (l - LEVER[2]) * m->w) / v);
    f[3] = hold->axle[3] * 124400 * (m->theta - (hitch - (l - LEVER[3]) * m->w) / v);
    /* Unknowns: v_y', r', w'. The hitch force from the trailer's lateral balance. */
    const double f2 = f[2] + f[3], n2 = f[2] * LEVER[2] + f[3] * LEVER[3];
    double a[3][4] = {
        {m1 + m2, -m2 * lh, -m2 * l, f[0] + f[1] + f2 - (m1 + m2) * v * m->r},
        {-lh * m2, i1 + lh * m2 * lh, lh * m2 * l,
         LEVER[0] * f[0] + LEVER[1] * f[1] - lh * (f2 - m2 * v * m->r)},
        {-l * m2, l * m2 * lh, i2 + l * m2 * l, n2 - l * (f2 - m2 * v * m->r)},
    };
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            const double factor = i == k ? 0 : a[i][k] / a[k][k];
            for (int j = k; j < 4; j++) {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    const double dvy = a[0][3] / a[0][0], dr = a[1][3] / a[1][1], dw = a[2][3] / a[2][2];
    m->a1 = dvy + v * m->r + LEVER[1] * dr;
    m->a2 = dvy + v * m->r - lh * dr - l * dw;
    m->hitch = m1 * (dvy + v * m->r) - f[0] - f[1];
    m->vy += dt * dvy;
    m->r += dt * dr;
    m->theta += dt * (m->w - m->r);
    m->w += dt * dw;
}

enum { NOTHING, GAIN, MORE, SLOW, INVERTED, DELAYED, OFFSET, BOTH_ACC, TYRES, LOAD };

#define MOTIONS 0x1001FU
#define FORCES                                                                                     \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_HITCH_FY) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_FRONT_FY) |       \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_REAR_FY) |                                                  \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_FRONT_FY) |                                             \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_REAR_FY))

static sway_supervise_t supervise;
static sway_vehicle_t vehicle;

static void put_motion(sway_row_t *row, const motion_t *m, double wheel)
{
    row->value[SWAY_CHANNEL_SPEED] = 25000;
    row->value[SWAY_CHANNEL_STEERING_WHEEL_ANGLE] = (int32_t)(1e6 * wheel);
    row->value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)(1e6 * m->r);
    row->value[SWAY_CHANNEL_TRAILER_YAW_RATE] = (int32_t)(1e6 * m->w);
}

static void put_forces(sway_row_t *row, const motion_t *m)
{
    row->value[SWAY_CHANNEL_CAR_LATERAL_ACC] = (int32_t)(1e6 * m->a1);
    row->value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] = (int32_t)(1e6 * m->a2);
    for (int c = SWAY_CHANNEL_CAR_YAW_RATE; c <= SWAY_CHANNEL_TRAILER_LATERAL_ACC; c++) {
        row->value[c] += rand() % 2001 - 1000;
    }
    row->value[SWAY_CHANNEL_HITCH_FY] = (int32_t)(1e3 * m->hitch);
    row->value[SWAY_CHANNEL_CAR_FRONT_FY] = (int32_t)(1e3 * m->force[0]);
    row->value[SWAY_CHANNEL_CAR_REAR_FY] = (int32_t)(1e3 * m->force[1]);
    row->value[SWAY_CHANNEL_TRAILER_FRONT_FY] = (int32_t)(1e3 * m->force[2]);
    row->value[SWAY_CHANNEL_TRAILER_REAR_FY] = (int32_t)(1e3 * m->force[3]);
    if (vehicle.trailer.axles == 1) {
        row->value[SWAY_CHANNEL_TRAILER_REAR_FY] += row->value[SWAY_CHANNEL_TRAILER_FRONT_FY];
    }
}

static void put_fault(sway_row_t *row, int fault, sway_channel_t channel, int32_t late)
{
    const int32_t truth = row->value[channel];
    row->value[channel] = fault == GAIN       ? truth / 2 * 3
                          : fault == MORE     ? truth / 4 * 5
                          : fault == SLOW     ? truth / 10 * 8
                          : fault == INVERTED ? -truth
                          : fault == DELAYED  ? late
                          : fault == OFFSET   ? truth + 2000000
                                              : truth;
    if (fault == BOTH_ACC) {
        row->value[SWAY_CHANNEL_CAR_LATERAL_ACC] += 1000000;
        row->value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] -= 1000000;
    }
}

/* A drive with a swerve every 7 s; from row `begins` on `channel` is broken, or the trailer's tyres
 * hold 0.4 of their force, or it has lost half of its mass. */
static void drive_with(uint32_t sensors, int fault, sway_channel_t channel, int rows)
{
    motion_t m = {0};
    int32_t late[8] = {0};
    const hold_t sound = {{1, 1, 1, 1}, 1};
    hold_t broken = sound;
    broken.axle[2] = broken.axle[3] = fault == TYRES ? 0.4 : 1;
    broken.mass = fault == LOAD ? 0.5 : 1;
    sway_supervise_init(&supervise, &vehicle, 10000);
    srand(5);
    for (int k = 0; k < rows; k++) {
        const int in_swerve = k % 700;
        const double wheel = in_swerve < 80 ? 0.12 * sin(M_PI * in_swerve / 80) : 0;
        sway_row_t row = {.valid_mask = sensors, .present_mask = sensors};
        row.time_us = k * INT64_C(10000);
        put_motion(&row, &m, wheel);
        for (int i = 0; i < 20; i++) {
            step(&m, 25, wheel, k > begins ? &broken : &sound, 0.0005);
        }
        put_forces(&row, &m);
        const int32_t truth = row.value[channel];
        if (k > begins) {
            put_fault(&row, fault, channel, late[k % 8]);
        }
        late[k % 8] = truth;
        sway_supervise_row(&supervise, &row);
        (void)sway_supervise_run(&supervise);
        if (k == begins) {
            TEST_ASSERT_EQUAL(0, supervise.finding.code);
        }
    }
}

static void drive(int fault, sway_channel_t channel)
{
    vehicle = reference_vehicle();
    drive_with(MOTIONS, fault, channel, 20000);
}

static sway_relation_state_t state_of(sway_relation_t relation)
{
    int32_t size, deviation;
    const sway_relation_state_t state =
        sway_supervise_relation(&supervise, relation, &size, &deviation);
    TEST_ASSERT_EQUAL(state != SWAY_RELATION_NOT_ASKED, deviation > 0);
    TEST_ASSERT_TRUE(state != SWAY_RELATION_BREAKS || size > 2 * deviation);
    TEST_ASSERT_TRUE(state != SWAY_RELATION_HOLDS || size < 3 * deviation);
    return state;
}

/* Which relations break together tells what is broken: the trailer's yaw rate is in the motion of
 * the ball and in the lateral balance of the trailer, not in the yaw balance of the car. */
static void relations_break_that_have_the_broken_sensor_in_them(void)
{
    drive(NOTHING, SWAY_CHANNEL_CAR_YAW_RATE);
    TEST_ASSERT_EQUAL(SWAY_RELATION_HOLDS, state_of(SWAY_RELATION_HITCH));
    TEST_ASSERT_EQUAL(SWAY_RELATION_HOLDS, state_of(SWAY_RELATION_CAR_YAW));
    TEST_ASSERT_EQUAL(SWAY_RELATION_HOLDS, state_of(SWAY_RELATION_TRAILER_LATERAL));
    TEST_ASSERT_EQUAL(SWAY_RELATION_HOLDS, state_of(SWAY_RELATION_TRAILER_YAW));
    TEST_ASSERT_EQUAL(SWAY_RELATION_NOT_ASKED, state_of(SWAY_RELATION_ARTICULATION));
    TEST_ASSERT_EQUAL(SWAY_RELATION_NOT_ASKED, state_of(SWAY_RELATION_TRAILER_REAR));
    drive(INVERTED, SWAY_CHANNEL_TRAILER_YAW_RATE);
    TEST_ASSERT_EQUAL(SWAY_RELATION_BREAKS, state_of(SWAY_RELATION_HITCH));
    TEST_ASSERT_EQUAL(SWAY_RELATION_BREAKS, state_of(SWAY_RELATION_TRAILER_LATERAL));
    TEST_ASSERT_EQUAL(SWAY_RELATION_HOLDS, state_of(SWAY_RELATION_CAR_YAW));
}

static void a_healthy_drive_says_nothing(void)
{
    drive(NOTHING, SWAY_CHANNEL_CAR_YAW_RATE);
    TEST_ASSERT_EQUAL(0, supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
    TEST_ASSERT_TRUE(supervise.rounds > 30);
}

static void a_wrong_gain_is_rejected_with_its_size(void)
{
    static const sway_channel_t channels[] = {
        SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_CAR_LATERAL_ACC, SWAY_CHANNEL_TRAILER_YAW_RATE,
        SWAY_CHANNEL_TRAILER_LATERAL_ACC};
    for (int i = 0; i < 4; i++) {
        drive(GAIN, channels[i]);
        TEST_ASSERT_EQUAL(SWAY_FINDING_GAIN + (int32_t)channels[i], supervise.finding.code);
        TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(channels[i]), supervise.rejected_mask);
        TEST_ASSERT_INT_WITHIN(250000, 500000, supervise.finding.size_micro);
    }
}

/* Less than six times what roll adds, but it begins on the way. */
static void a_gain_of_an_accelerometer_that_changes_is_rejected(void)
{
    drive(MORE, SWAY_CHANNEL_CAR_LATERAL_ACC);
    TEST_ASSERT_EQUAL(SWAY_FINDING_GAIN + SWAY_CHANNEL_CAR_LATERAL_ACC, supervise.finding.code);
    drive(MORE, SWAY_CHANNEL_TRAILER_LATERAL_ACC);
    TEST_ASSERT_EQUAL(SWAY_FINDING_GAIN + SWAY_CHANNEL_TRAILER_LATERAL_ACC, supervise.finding.code);
}

static void a_wrong_sign_is_rejected(void)
{
    drive(INVERTED, SWAY_CHANNEL_TRAILER_YAW_RATE);
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE),
                            supervise.rejected_mask);
}

static void a_delay_is_rejected_with_its_size(void)
{
    drive(DELAYED, SWAY_CHANNEL_CAR_YAW_RATE);
    TEST_ASSERT_EQUAL(SWAY_FINDING_DELAY + (int32_t)SWAY_CHANNEL_CAR_YAW_RATE,
                      supervise.finding.code);
    TEST_ASSERT_INT_WITHIN(30000, 80000, supervise.finding.size_micro);
}

static void an_offset_is_reported_and_nothing_left_out(void)
{
    drive(OFFSET, SWAY_CHANNEL_CAR_LATERAL_ACC);
    TEST_ASSERT_EQUAL(SWAY_FINDING_OFFSET + (int32_t)SWAY_CHANNEL_CAR_LATERAL_ACC,
                      supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC), supervise.offset_mask);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
    TEST_ASSERT_INT_WITHIN(600000, 2000000, supervise.finding.size_micro);
}

/* With both accelerations off the other way, either of them and a banked road explain it. */
static void offsets_that_cannot_be_distinguished_are_not_reported(void)
{
    drive(BOTH_ACC, SWAY_CHANNEL_CAR_YAW_RATE);
    TEST_ASSERT_EQUAL(0, supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.offset_mask);
}

static void expect_tyres_lost(void)
{
    TEST_ASSERT_TRUE(supervise.finding.se_micro > 20000 && supervise.finding.se_micro < 150000);
    TEST_ASSERT_INT_WITHIN(2 * supervise.finding.se_micro, -600000, supervise.finding.size_micro);
}

static void changed_tyres_are_reported_with_their_size_and_no_sensor_blamed(void)
{
    vehicle = reference_vehicle();
    drive_with(MOTIONS | FORCES, TYRES, SWAY_CHANNEL_SPEED, 20000);
    TEST_ASSERT_EQUAL(SWAY_FINDING_TRAILER_TYRES, supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
    expect_tyres_lost();
}

/* One axle in the middle of the two, for the forces of both. */
static void changed_tyres_of_one_axle_are_reported(void)
{
    vehicle = reference_vehicle();
    vehicle.trailer.axles = 1;
    vehicle.trailer.rear_axle_to_cog_um = 201000;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 255600;
    drive_with(MOTIONS | (FORCES & ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_FRONT_FY)), TYRES,
               SWAY_CHANNEL_SPEED, 20000);
    TEST_ASSERT_EQUAL(SWAY_FINDING_TRAILER_TYRES, supervise.finding.code);
    expect_tyres_lost();
}

static void a_wrong_speed_is_reported_with_its_size(void)
{
    vehicle = reference_vehicle();
    begins = 0;
    drive_with(MOTIONS | FORCES, SLOW, SWAY_CHANNEL_SPEED, 20000);
    TEST_ASSERT_EQUAL(SWAY_FINDING_SPEED, supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
    TEST_ASSERT_INT_WITHIN(2 * supervise.finding.se_micro, 250000, supervise.finding.size_micro);
    TEST_ASSERT_TRUE(supervise.finding.se_micro < 80000);
}

/* Means of values that no vehicle has do not overflow; nothing is made of them. */
static void absurd_values_do_no_harm(void)
{
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    for (int k = 0; k < 2000; k++) {
        sway_row_t row = {.valid_mask = MOTIONS, .present_mask = MOTIONS};
        row.value[SWAY_CHANNEL_SPEED] = 120000;
        row.value[SWAY_CHANNEL_CAR_YAW_RATE] = k % 2 == 0 ? 5300000 : -5300000;
        row.value[SWAY_CHANNEL_CAR_LATERAL_ACC] = k % 2 == 0 ? -40000000 : 40000000;
        sway_supervise_row(&supervise, &row);
        while (sway_supervise_run(&supervise)) {
        }
    }
    TEST_ASSERT_EQUAL(0, supervise.finding.code);
}

/* A window that fills before the last one is done with is left out, not mixed in. */
static void a_window_that_comes_too_early_is_left_out(void)
{
    vehicle = reference_vehicle();
    drive_with(MOTIONS, NOTHING, SWAY_CHANNEL_SPEED, 511);
    while (sway_supervise_run(&supervise)) {
    }
    for (int k = 0; k < 2 * SWAY_RELATIONS_ROWS; k++) {
        sway_row_t row = {.valid_mask = MOTIONS, .present_mask = MOTIONS};
        row.value[SWAY_CHANNEL_SPEED] = k < 2 ? 25000 : 30000;
        sway_supervise_row(&supervise, &row);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 25, value(supervise.relations.speed_m_s));
    while (sway_supervise_run(&supervise)) {
    }
    TEST_ASSERT_EQUAL(1, supervise.rounds);
}

static void a_load_that_was_left_behind_is_reported(void)
{
    vehicle = reference_vehicle();
    drive_with(MOTIONS | FORCES, LOAD, SWAY_CHANNEL_SPEED, 20000);
    TEST_ASSERT_EQUAL(SWAY_FINDING_LOAD, supervise.finding.code);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
    TEST_ASSERT_TRUE(supervise.finding.se_micro < 400000);
    TEST_ASSERT_INT_WITHIN(2 * supervise.finding.se_micro, 0, supervise.finding.size_micro);
}

/* x' D^-1 x for three numbers that were learnt together, in any order. */
static void three_numbers_set_free_together_are_worth_the_whole_form(void)
{
    static const double learnt[3][3] = {
        {0.006, 0.004, 0.0004}, {0.004, 0.02, -0.001}, {0.0004, -0.001, 0.0012}};
    static const uint8_t orders[3][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
    sway_kalman_t gauss = three_numbers();
    found[0] = real(0.3);
    found[1] = real(-0.2);
    found[2] = real(0.1);
    for (int i = 0, k = 0; i < 3; i++) {
        for (int j = 0; j <= i; j++, k++) {
            covariance[k] = sway_real_sub(covariance[k], real(learnt[i][j]));
        }
    }
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 26.615658, value(sway_kalman_worth(&gauss, orders[k], 3)));
    }
}

/* Also in the middle of a relation, and whatever had gone with what. */
static void a_reset_forgets_everything(void)
{
    sway_kalman_t gauss = three_numbers();
    take(&gauss, 1, 2, 0.1, 0.01);
    TEST_ASSERT_TRUE(value(sway_kalman_covariance(&gauss, 1, 0)) != 0);
    memset(moved, 0, sizeof moved);
    gauss.row = 2;
    sway_kalman_reset(&gauss);
    for (uint32_t i = 0; i < 3U; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0, value(found[i]));
        for (uint32_t j = 0; j < i; j++) {
            TEST_ASSERT_EQUAL_DOUBLE(0, value(sway_kalman_covariance(&gauss, i, j)));
        }
    }
    const double before = value(sway_kalman_covariance(&gauss, 0, 0));
    take(&gauss, 1, 0, 0.1, 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, before / 2, value(sway_kalman_covariance(&gauss, 0, 0)));
}

/* Sensors and changes return to the belief; what the user said of the vehicle stays learnt. */
static void only_sensors_and_changes_are_forgotten(void)
{
    vehicle = reference_vehicle();
    drive_with(MOTIONS, NOTHING, SWAY_CHANNEL_SPEED, 512);
    sway_row_t row = {.valid_mask = MOTIONS, .present_mask = MOTIONS};
    row.value[SWAY_CHANNEL_SPEED] = 25000;
    while (sway_supervise_run(&supervise)) {
    }
    for (int k = 0; k < 512; k++) {
        sway_supervise_row(&supervise, &row);
    }
    for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        supervise.value[i] = real(0.01);
    }
    const sway_supervise_t before = supervise;
    for (int measuring = 0; measuring < 2; measuring++) { /* what is measured is not forgotten */
        supervise = before;
        supervise.measured = 3;
        supervise.measuring = (uint8_t)measuring;
        while (supervise.stage == before.stage) {
            (void)sway_supervise_run(&supervise);
        }
        for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
            const bool changes = i >= SWAY_UNKNOWN_CHANGED_STIFFNESS && i < SWAY_UNKNOWN_ROLL;
            const bool kept = measuring != 0 && (i == 6 || i == 7);
            const bool fades = !kept && (i < SWAY_UNKNOWN_SPEED || changes);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, fades ? 0.0093 : 0.01, value(supervise.value[i]));
        }
    }
}

enum { HOLD = 2 }; /* a stage of sway_supervise.c */

/* --- relations -----------------------------------------------------------------------------------
 */

typedef struct {
    double residual, allowed, size;
} held_t;

/* A window in which the wheel moves at each harmonic, and the rest at some; another one each time.
 */
static void feed_window(int which)
{
    for (int k = 0; k < SWAY_RELATIONS_ROWS; k++) {
        const uint32_t all = MOTIONS | SWAY_CHANNEL_BIT(SWAY_CHANNEL_ARTICULATION);
        sway_row_t row = {.valid_mask = all, .present_mask = all};
        const double turn = 2 * M_PI * k / SWAY_RELATIONS_ROWS;
        double wheel = 0;
        for (int h = SWAY_RELATIONS_FIRST; h <= SWAY_RELATIONS_LAST; h++) {
            wheel += 0.1 * sin(h * (turn + M_PI) + which); /* so that Hann's window adds them */
        }
        row.value[SWAY_CHANNEL_SPEED] = 25000;
        row.value[SWAY_CHANNEL_STEERING_WHEEL_ANGLE] = (int32_t)(1e6 * wheel);
        row.value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)(5e4 * sin(3 * turn + 2 * which));
        row.value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] = (int32_t)(8e5 * cos((2 + which) * turn));
        sway_supervise_row(&supervise, &row);
    }
}

/* What the completed relation says by itself. */
static held_t held_now(void)
{
    const sway_relations_t *const re = &supervise.relations;
    held_t now = {pow(cabs(cvalue(re->residual)), 2), 2 * value(sway_relations_variance(re)),
                  value(re->size_squared)};
    for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        now.allowed += pow(cabs(cvalue(re->slope[i])) * 1e-6 * supervise.tolerance_ppm[i], 2);
    }
    return now;
}

/* Every relation is asked at harmonics 2 to 5 of every window, and held as means over sixteen. */
static void relations_are_asked_at_each_harmonic_and_held_as_means(void)
{
    held_t mean[SWAY_RELATION_COUNT] = {{0, 0, 0}};
    int asked[SWAY_RELATION_COUNT][8] = {{0}};
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    for (int window = 0; window < 3; window++) {
        feed_window(window);
        memset(supervise.score_milli, 0x7F, sizeof supervise.score_milli);
        while (sway_supervise_run(&supervise)) {
            if (supervise.stage != HOLD) {
                continue;
            }
            const int r = supervise.relation;
            held_t *const m = &mean[r];
            const sway_supervise_relation_t *const held = &supervise.held[r];
            const held_t now = held_now();
            const double share = held->state == SWAY_RELATION_NOT_ASKED ? 1 : 1.0 / 16;
            const int before = held->state;
            m->residual += share * (now.residual - m->residual);
            m->allowed += share * (now.allowed - m->allowed);
            m->size += share * (now.size - m->size);
            asked[r][supervise.harmonic]++;
            (void)sway_supervise_run(&supervise);
            TEST_ASSERT_DOUBLE_WITHIN(1e-7 * m->residual, m->residual, value(held->residual));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7 * m->allowed, m->allowed, value(held->allowed));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7 * m->size, m->size, value(held->size));
            TEST_ASSERT_EQUAL(m->residual > 9 * m->allowed ? SWAY_RELATION_BREAKS
                              : before == SWAY_RELATION_NOT_ASKED || m->residual < 4 * m->allowed
                                  ? SWAY_RELATION_HOLDS
                                  : before,
                              held->state);
            (void)sway_supervise_run(&supervise);
            for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
                TEST_ASSERT_EQUAL_DOUBLE(value(supervise.relations.slope[i].re),
                                         value(supervise.slope[i]));
            }
        }
        for (int e = 0; e < SWAY_SUPERVISE_EXPLANATIONS; e++) {
            TEST_ASSERT_TRUE(supervise.score_milli[e] != 0x7F7F7F7F); /* each is weighed anew */
        }
        for (int r = 0; r < SWAY_RELATION_COUNT; r++) {
            const bool is_allowed = sway_relations_allow(&supervise.relations, (sway_relation_t)r);
            for (int h = 0; h < 8; h++) {
                TEST_ASSERT_EQUAL(is_allowed && h >= 2 && h <= 5 ? window + 1 : 0, asked[r][h]);
            }
        }
    }
}

/* One value of a relation: the variance that is believed, and the mean that the innovation joins.
 * Returns the share of the assumed variance that is believed. */
static double expect_share(double *share, int *taken)
{
    const int stage = supervise.stage, r = supervise.relation;
    const double assumed = value(sway_relations_variance(&supervise.relations));
    const double believed = fmin(1, 4.5 * *share);
    while (supervise.stage == stage && supervise.relation == r) {
        (void)sway_supervise_run(&supervise);
    }
    double variance = believed * assumed;
    for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        variance += value(supervise.slope[i]) * value(supervise.moved[i]);
    }
    const double square =
        pow(value(supervise.numbers.gain) / value(supervise.numbers.by_variance), 2);
    variance = fmax(variance, square / 9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 / variance, 1 / variance, value(supervise.numbers.by_variance));
    *taken += *taken < 128 ? 1 : 0;
    *share += (fmin(square / assumed, 4 * *share) - *share) / *taken;
    *share = fmax(*share, 1.0 / 45);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * *share, *share, value(supervise.share[r]));
    TEST_ASSERT_EQUAL(*taken, supervise.taken[r]);
    return believed;
}

/* Windows in which the relations hold, then some in which they do not at all: noise is believed as
 * the innovations show it, between a tenth and all of what is assumed. */
static void noise_is_believed_as_the_innovations_show(void)
{
    enum { REAL = 3, IMAGINARY = 4 }; /* stages of sway_supervise.c */
    double share[SWAY_RELATION_COUNT];
    int taken[SWAY_RELATION_COUNT];
    double least = 1, most = 0;
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    for (int r = 0; r < SWAY_RELATION_COUNT; r++) {
        share[r] = 1.0 / 3;
        taken[r] = 8;
    }
    for (int window = 0; window < 22; window++) {
        feed_window(window % 3);
        do {
            if (supervise.stage == REAL) {
                const double by = window < 18 ? 1e-4 : 1;
                supervise.relations.residual.re = real(by * value(supervise.relations.residual.re));
                supervise.relations.residual.im = real(by * value(supervise.relations.residual.im));
            }
            while (supervise.stage == REAL || supervise.stage == IMAGINARY) {
                const int r = supervise.relation;
                const double believed = expect_share(&share[r], &taken[r]);
                least = fmin(least, believed);
                most = fmax(most, believed);
            }
            supervise.candidate = SWAY_SUPERVISE_EXPLANATIONS; /* nothing is reported */
        } while (sway_supervise_run(&supervise));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.1, least);
    TEST_ASSERT_EQUAL_DOUBLE(1, most);
    TEST_ASSERT_EQUAL(128, taken[SWAY_RELATION_HITCH]);
}

/* Residual over allowance beyond 3: broken; below 2: sound; between: as it was. */
static void a_relation_breaks_and_holds_at_its_limits(void)
{
    static const struct {
        double ratio;
        int before, after;
    } cases[] = {
        {9.5, SWAY_RELATION_HOLDS, SWAY_RELATION_BREAKS},
        {8.5, SWAY_RELATION_HOLDS, SWAY_RELATION_HOLDS},
        {8.5, SWAY_RELATION_BREAKS, SWAY_RELATION_BREAKS},
        {4.5, SWAY_RELATION_BREAKS, SWAY_RELATION_BREAKS},
        {3.5, SWAY_RELATION_BREAKS, SWAY_RELATION_HOLDS},
        {8.5, SWAY_RELATION_NOT_ASKED, SWAY_RELATION_HOLDS},
    };
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        vehicle = reference_vehicle();
        drive_with(MOTIONS, NOTHING, SWAY_CHANNEL_SPEED, 512);
        while (supervise.stage != HOLD) {
            TEST_ASSERT_TRUE(sway_supervise_run(&supervise));
        }
        sway_supervise_relation_t *const held = &supervise.held[supervise.relation];
        const held_t now = held_now();
        held->state = (uint8_t)cases[c].before;
        held->allowed = real(now.allowed);
        supervise.relations.residual = complex_of(sqrt(cases[c].ratio * now.allowed));
        held->residual = real(cases[c].ratio * now.allowed);
        (void)sway_supervise_run(&supervise);
        TEST_ASSERT_EQUAL(cases[c].after, held->state);
    }
}

static void a_relation_is_shown_as_shares_of_its_size(void)
{
    int32_t size = -1, deviation = -1;
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    TEST_ASSERT_EQUAL(SWAY_RELATION_NOT_ASKED,
                      sway_supervise_relation(&supervise, 3, &size, &deviation));
    TEST_ASSERT_EQUAL(0, size);
    TEST_ASSERT_EQUAL(0, deviation);
    supervise.held[3].state = SWAY_RELATION_BREAKS;
    supervise.held[3].residual = real(36);
    supervise.held[3].allowed = real(16);
    supervise.held[3].size = real(4);
    TEST_ASSERT_EQUAL(SWAY_RELATION_BREAKS,
                      sway_supervise_relation(&supervise, 3, &size, &deviation));
    TEST_ASSERT_EQUAL(3000000, size);
    TEST_ASSERT_EQUAL(2000000, deviation);
}

/* Straight on nothing is known of the tyres: balances are not asked; of a sensor that is lost what
 * it had said is forgotten. */
static void what_cannot_be_asked_is_not(void)
{
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    feed_window(0);
    while (sway_supervise_run(&supervise)) {
    }
    TEST_ASSERT_TRUE(supervise.held[SWAY_RELATION_CAR_YAW].state != SWAY_RELATION_NOT_ASKED);
    TEST_ASSERT_TRUE(supervise.held[SWAY_RELATION_HITCH].state != SWAY_RELATION_NOT_ASKED);
    const uint32_t without = MOTIONS & ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    for (int window = 0; window < 2; window++) {
        const uint32_t valid = window == 0 ? without : MOTIONS;
        for (int k = 0; k < 512; k++) {
            sway_row_t row = {.valid_mask = valid, .present_mask = MOTIONS};
            row.value[SWAY_CHANNEL_SPEED] = 25000;
            sway_supervise_row(&supervise, &row);
        }
        supervise.held[SWAY_RELATION_CAR_YAW].state = SWAY_RELATION_NOT_ASKED;
        int undriven = 0;
        while (sway_supervise_run(&supervise)) {
            TEST_ASSERT_TRUE(supervise.relation != SWAY_RELATION_CAR_YAW ||
                             supervise.relations.term == 0U);
            undriven += supervise.relation == SWAY_RELATION_CAR_YAW;
        }
        TEST_ASSERT_EQUAL(4, undriven); /* a slice for each harmonic */
        TEST_ASSERT_EQUAL(SWAY_RELATION_NOT_ASKED, supervise.held[SWAY_RELATION_CAR_YAW].state);
        TEST_ASSERT_EQUAL(window == 0,
                          supervise.held[SWAY_RELATION_HITCH].state == SWAY_RELATION_NOT_ASKED);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_relation_moves_numbers_as_kalman_says);
    RUN_TEST(after_a_reset_a_relation_is_taken_from_its_first_number);
    RUN_TEST(what_is_far_off_counts_as_three_errors);
    RUN_TEST(setting_free_is_worth_what_the_tolerance_cost);
    RUN_TEST(what_fades_returns_to_its_tolerance_and_not_beyond);
    RUN_TEST(relations_break_that_have_the_broken_sensor_in_them);
    RUN_TEST(a_healthy_drive_says_nothing);
    RUN_TEST(a_wrong_gain_is_rejected_with_its_size);
    RUN_TEST(a_gain_of_an_accelerometer_that_changes_is_rejected);
    RUN_TEST(a_wrong_sign_is_rejected);
    RUN_TEST(a_delay_is_rejected_with_its_size);
    RUN_TEST(an_offset_is_reported_and_nothing_left_out);
    RUN_TEST(offsets_that_cannot_be_distinguished_are_not_reported);
    RUN_TEST(changed_tyres_are_reported_with_their_size_and_no_sensor_blamed);
    RUN_TEST(changed_tyres_of_one_axle_are_reported);
    RUN_TEST(a_wrong_speed_is_reported_with_its_size);
    RUN_TEST(absurd_values_do_no_harm);
    RUN_TEST(a_window_that_comes_too_early_is_left_out);
    RUN_TEST(a_load_that_was_left_behind_is_reported);
    RUN_TEST(three_numbers_set_free_together_are_worth_the_whole_form);
    RUN_TEST(a_reset_forgets_everything);
    RUN_TEST(only_sensors_and_changes_are_forgotten);
    RUN_TEST(relations_are_asked_at_each_harmonic_and_held_as_means);
    RUN_TEST(noise_is_believed_as_the_innovations_show);
    RUN_TEST(a_relation_breaks_and_holds_at_its_limits);
    RUN_TEST(a_relation_is_shown_as_shares_of_its_size);
    RUN_TEST(what_cannot_be_asked_is_not);
    return UNITY_END();
}

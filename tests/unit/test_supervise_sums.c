/* Supervision: offsets by the means, against the same filter in double precision; explanations,
 * scores and sizes from numbers that are put in. */
#include "judge/sway_supervise.h"
#include "sway_test.h"
#include "unity.h"

#define MOTIONS 0x1001FU

static sway_supervise_t supervise;
static sway_vehicle_t vehicle;

void setUp(void)
{
}

void tearDown(void)
{
}

/* --- offsets, against the same filter in double precision ----------------------------------------
 */

/* Standard deviations before the drive: offsets since ever and since lately of the yaw rate and the
 * acceleration of each body, and the bank, m/s^2. */
#define OFFSETS SWAY_SUPERVISE_OFFSETS
static const double OFFSET_BEFORE[OFFSETS] = {0.009, 0.25,   0.009, 0.25, 0.0035,
                                              0.12,  0.0035, 0.12,  0.3};

typedef struct {
    double x[OFFSETS], p[OFFSETS][OFFSETS];
} offsets_t;

/* A window of constant motion; every other row is off the other way by `shake`: of the trailer's
 * yaw rate and of the car's acceleration. */
typedef struct {
    double speed, rate[2], acc[2], shake[2];
} leg_t;

static offsets_t believed_offsets(void)
{
    offsets_t all = {{0}, {{0}}};
    for (int i = 0; i < OFFSETS; i++) {
        all.p[i][i] = OFFSET_BEFORE[i] * OFFSET_BEFORE[i];
    }
    return all;
}

static void fade_offsets(offsets_t *all)
{
    for (int i = 0; i < OFFSETS; i++) {
        const double keep = i >= 4 ? 0.95 : 1;
        all->x[i] *= keep;
        for (int j = 0; j < OFFSETS; j++) {
            all->p[i][j] *= keep * (j >= 4 ? 0.95 : 1);
        }
        all->p[i][i] += OFFSET_BEFORE[i] * OFFSET_BEFORE[i] * (1 - keep * keep);
    }
}

static void take_offsets(offsets_t *all, const double *h, double residual, double variance)
{
    double moved[OFFSETS] = {0};
    for (int i = 0; i < OFFSETS; i++) {
        for (int j = 0; j < OFFSETS; j++) {
            moved[i] += all->p[i][j] * h[j];
        }
        variance += h[i] * moved[i];
        residual += h[i] * all->x[i];
    }
    for (int i = 0; i < OFFSETS; i++) {
        for (int j = i; j < OFFSETS; j++) { /* the variance of all is not complete before */
            all->p[i][j] -= moved[i] * moved[j] / fmax(variance, residual * residual / 9);
            all->p[j][i] = all->p[i][j];
        }
        all->x[i] -= moved[i] * residual / fmax(variance, residual * residual / 9);
    }
}

/* What a window says: r2 - r1 = 0, a1 - v r1 = bank, a2 - v r2 = bank. A mean over a swing is off
 * by a part of it; a turn adds what the trailer lags and the bodies roll. */
static void take_leg(offsets_t *all, const leg_t *leg)
{
    const double v = leg->speed;
    const double mean[3] = {leg->rate[1] - leg->rate[0], leg->acc[0] - v * leg->rate[0],
                            leg->acc[1] - v * leg->rate[1]};
    const double spread[3] = {leg->shake[0], leg->shake[1], v * leg->shake[0]};
    const double turn[3] = {0.15 * leg->rate[0], 0.06 * v * leg->rate[0], 0.06 * v * leg->rate[0]};
    const double alone[3] = {0.007, 0.12, 0.12};
    const double h[3][OFFSETS] = {{1, 0, -1, 0, 1, 0, -1, 0, 0},
                                  {v, -1, 0, 0, v, -1, 0, 0, -1},
                                  {0, 0, v, -1, 0, 0, v, -1, -1}};
    fade_offsets(all);
    for (int k = 0; k < 3; k++) {
        take_offsets(all, h[k], mean[k],
                     alone[k] * alone[k] + turn[k] * turn[k] + spread[k] * spread[k] / 11);
    }
}

/* Chi-square of an offset since ever and since lately, both free. */
static double offset_worth(const offsets_t *all, int i)
{
    const double a = OFFSET_BEFORE[i] * OFFSET_BEFORE[i] - all->p[i][i];
    const double b = -all->p[i][i + 4];
    const double d = OFFSET_BEFORE[i + 4] * OFFSET_BEFORE[i + 4] - all->p[i + 4][i + 4];
    const double x = all->x[i], y = all->x[i + 4];
    return (d * x * x - 2 * b * x * y + a * y * y) / (a * d - b * b);
}

static sway_row_t row_of_leg(const leg_t *leg, int k)
{
    const double side = k % 2 == 0 ? 1 : -1;
    sway_row_t row = {.valid_mask = MOTIONS, .present_mask = MOTIONS};
    row.value[SWAY_CHANNEL_SPEED] = (int32_t)lround(1e3 * leg->speed);
    row.value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)lround(1e6 * leg->rate[0]);
    row.value[SWAY_CHANNEL_CAR_LATERAL_ACC] =
        (int32_t)lround(1e6 * (leg->acc[0] + side * leg->shake[1]));
    row.value[SWAY_CHANNEL_TRAILER_YAW_RATE] =
        (int32_t)lround(1e6 * (leg->rate[1] + side * leg->shake[0]));
    row.value[SWAY_CHANNEL_TRAILER_LATERAL_ACC] = (int32_t)lround(1e6 * leg->acc[1]);
    return row;
}

static void feed_leg(offsets_t *all, const leg_t *leg)
{
    for (int k = 0; k < 256; k++) {
        const sway_row_t row = row_of_leg(leg, k);
        sway_supervise_row(&supervise, &row);
    }
    take_leg(all, leg);
}

static void start_offsets(offsets_t *all)
{
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    *all = believed_offsets();
}

static void expect_offsets(const offsets_t *all)
{
    for (uint32_t i = 0; i < OFFSETS; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-7 * OFFSET_BEFORE[i], all->x[i],
                                  value(supervise.offset_value[i]));
        for (uint32_t j = 0; j <= i; j++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-7 * OFFSET_BEFORE[i] * OFFSET_BEFORE[j], all->p[i][j],
                                      value(sway_kalman_covariance(&supervise.offsets, i, j)));
        }
    }
}

static void means_are_taken_as_kalman_says(void)
{
    static const leg_t legs[] = {
        {25, {0.02, 0.03}, {0.4, 0.5}, {0, 0}},       {20, {-0.05, -0.02}, {0.3, -1}, {0.01, 0.3}},
        {30, {0.001, -0.004}, {2, 1}, {0.002, 0}},    {10, {0.3, 0.2}, {-1, 3}, {0, 4}},
        {25, {0, 0.0005}, {-0.1, 0.2}, {0.05, 0.01}}, {33, {-0.1, -0.1}, {-3, -3.3}, {0, 0.5}},
    };
    offsets_t all;
    start_offsets(&all);
    expect_offsets(&all);
    for (int i = 0; i < 6; i++) {
        feed_leg(&all, &legs[i]);
        expect_offsets(&all);
    }
}

/* The flat prior's estimate is that of its offset alone, and the truth within three of its errors;
 * whether it is reported is decided by the worth of the best and the second. */
static int expect_offset(const offsets_t *all, const double *truth)
{
    long best = 0, second = 0;
    int which = 0;
    for (int i = 0; i < 4; i++) {
        const long worth = lround(offset_worth(all, i)) - 6;
        second = worth > best ? best : (worth > second ? worth : second);
        which = worth > best ? i : which;
        best = worth > best ? worth : best;
    }
    const bool is_reported = best > SWAY_SUPERVISE_LIMIT && best - second > SWAY_SUPERVISE_LEAD;
    TEST_ASSERT_EQUAL_HEX32(is_reported ? SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE + which) : 0,
                            supervise.offset_mask);
    if (is_reported) {
        const int l = which + 4;
        const double before = pow(OFFSET_BEFORE[which], 2) + pow(OFFSET_BEFORE[l], 2);
        const double left = all->p[which][which] + all->p[l][l] + 2 * all->p[which][l];
        const double free = before / (before - left), se = sqrt(left * free);
        const double size = (all->x[which] + all->x[l]) * free;
        TEST_ASSERT_EQUAL(SWAY_FINDING_OFFSET + SWAY_CHANNEL_CAR_YAW_RATE + which,
                          supervise.finding.code);
        TEST_ASSERT_DOUBLE_WITHIN(0.6 + 1e-8 * fabs(size) * 1e6, 1e6 * size,
                                  supervise.finding.size_micro);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, 1e6 * se, supervise.finding.se_micro);
        if (truth != NULL) {
            TEST_ASSERT_DOUBLE_WITHIN(3 * se, truth[which], size);
        }
    }
    return (is_reported ? 1 : 0) + (best == SWAY_SUPERVISE_LIMIT ? 2 : 0) +
           (best > SWAY_SUPERVISE_LIMIT && best - second == SWAY_SUPERVISE_LEAD ? 4 : 0);
}

/* An offset that grows from drive to drive, of each sensor: reported from a size on, never before.
 */
static void an_offset_is_reported_from_its_limit_on(void)
{
    int seen = 0;
    for (int sensor = 0; sensor < 4; sensor++) {
        const double unit = sensor % 2 == 0 ? 0.0024 : 0.12;
        int reported = 0;
        for (int k = 0; k < 40; k++) {
            double truth[4] = {0};
            truth[sensor] = k * unit;
            const leg_t leg = {30, {truth[0], truth[2]}, {truth[1], truth[3]}, {0, 0}};
            offsets_t all;
            start_offsets(&all);
            for (int i = 0; i < 8; i++) {
                feed_leg(&all, &leg);
            }
            seen |= expect_offset(&all, truth);
            reported += supervise.offset_mask != 0U;
        }
        TEST_ASSERT_TRUE(reported > 5 && reported < 35);
    }
    TEST_ASSERT_EQUAL(3, seen & 3);
}

/* Beside an offset of the car's acceleration one of the trailer's: from where both may be the one,
 * nothing is reported. */
static void an_offset_is_reported_as_far_as_no_other_may_be_it(void)
{
    int seen = 0;
    for (int k = 0; k < 100; k++) {
        const leg_t leg = {30, {0, 0}, {3.5, -1.8 - 0.015 * k}, {0, 0}};
        offsets_t all;
        start_offsets(&all);
        for (int i = 0; i < 8; i++) {
            feed_leg(&all, &leg);
        }
        seen |= expect_offset(&all, NULL);
    }
    TEST_ASSERT_EQUAL(5, seen & 5);
}

/* In a swing of 10 m/s^2 an offset is known to some m/s^2 only; it is reported all the same, and
 * the finding goes when something else may be it. */
static void an_offset_in_a_swing_is_reported_with_its_error(void)
{
    const double truth[4] = {0, 32, 0, 0};
    const leg_t swing = {30, {0, 0}, {32, 0}, {0, 10}};
    const leg_t both = {30, {0, 0}, {2, -2}, {0, 0}};
    offsets_t all;
    int windows = 0;
    start_offsets(&all);
    while (supervise.offset_mask == 0U && windows < 40) {
        feed_leg(&all, &swing);
        (void)expect_offset(&all, truth);
        windows++;
    }
    TEST_ASSERT_TRUE(supervise.finding.se_micro > 1000000);
    while (supervise.offset_mask != 0U && windows < 200) {
        feed_leg(&all, &both);
        windows++;
    }
    TEST_ASSERT_EQUAL_HEX32(0, supervise.offset_mask);
}

/* A window begins anew with a row that lacks something, follows no other, or is slow. */
static void means_are_of_complete_rows_only(void)
{
    static const sway_channel_t needed[] = {
        SWAY_CHANNEL_SPEED, SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_CAR_LATERAL_ACC,
        SWAY_CHANNEL_TRAILER_YAW_RATE, SWAY_CHANNEL_TRAILER_LATERAL_ACC};
    const leg_t leg = {25, {0.02, 0.03}, {0.4, 0.5}, {0, 0}};
    const sway_row_t good = row_of_leg(&leg, 0);
    offsets_t all;
    start_offsets(&all);
    for (int i = 0; i < 8; i++) {
        sway_row_t row = good;
        row.valid_mask = i < 5 ? SWAY_CHANNEL_BIT(needed[i]) ^ MOTIONS : MOTIONS;
        row.restart = i == 5;
        row.value[SWAY_CHANNEL_SPEED] = i == 6 ? 8332 : 25000;
        sway_supervise_row(&supervise, &good);
        sway_supervise_row(&supervise, &good);
        TEST_ASSERT_EQUAL(2, supervise.rows);
        sway_supervise_row(&supervise, &row);
        TEST_ASSERT_EQUAL(i == 7 ? 3 : 0, supervise.rows);
    }
    sway_row_t slowest = good;
    slowest.valid_mask = MOTIONS & ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    slowest.value[SWAY_CHANNEL_SPEED] = 8333;
    sway_supervise_row(&supervise, &slowest);
    TEST_ASSERT_EQUAL(4, supervise.rows);
}

static void a_row_counts_as_100_m_s2_at_most(void)
{
    const leg_t leg = {25, {0.02, 0.02}, {150, -150}, {0, 0}};
    offsets_t all;
    start_offsets(&all);
    const sway_row_t row = row_of_leg(&leg, 0);
    feed_leg(&all, &leg);
    sway_supervise_row(&supervise, &row); /* the first one of a window */
    TEST_ASSERT_EQUAL_INT64(25000, supervise.sum_speed);
    TEST_ASSERT_EQUAL_INT64(20000, supervise.sum_yaw_rate);
    TEST_ASSERT_EQUAL_INT64(0, supervise.sum[0]);
    TEST_ASSERT_EQUAL_INT64(100000000, supervise.sum[1]);
    TEST_ASSERT_EQUAL_INT64(-100000000, supervise.sum[2]);
}

/* --- explanations, from numbers that are put in --------------------------------------------------
 */

enum { WEIGH = 6 }; /* a stage of sway_supervise.c */
enum { LAST = SWAY_SUPERVISE_EXPLANATIONS - 1, SPEED = SWAY_SUPERVISE_SENSORS, CAR = LAST - 1 };

static void start_numbers(void)
{
    vehicle = reference_vehicle();
    sway_supervise_init(&supervise, &vehicle, 10000);
    supervise.relations.bin_rad_s = real(0.005);
}

static double before_of(int i)
{
    return supervise.tolerance_ppm[i] * 1e-6;
}

static void put_number(int i, double now, double standard_error)
{
    supervise.value[i] = real(now);
    supervise.covariance[i * (i + 1) / 2 + i] = real(standard_error * standard_error);
}

static void put_covariance(int a, int b, double now)
{
    const int high = a < b ? b : a, low = a < b ? a : b;
    supervise.covariance[high * (high + 1) / 2 + low] = real(now);
}

/* The groups of numbers by which the vehicle explains; a sensor by its gain and its phase, an
 * accelerometer by its roll too. */
static const struct {
    int finding, size, number[6];
} GROUPS[] = {
    {SWAY_FINDING_SPEED, 1, {SWAY_UNKNOWN_SPEED}},
    {SWAY_FINDING_CAR_FRONT_TYRES, 1, {SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_AXLE_CAR_FRONT}},
    {SWAY_FINDING_CAR_REAR_TYRES, 1, {SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_AXLE_CAR_REAR}},
    {SWAY_FINDING_TRAILER_TYRES,
     2,
     {SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_AXLE_TRAILER_REAR,
      SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_AXLE_TRAILER_FRONT}},
    {SWAY_FINDING_LOAD, 2, {SWAY_UNKNOWN_CHANGED_PLACE, SWAY_UNKNOWN_CHANGED_MASS}},
    {SWAY_FINDING_FRICTION, 1, {SWAY_UNKNOWN_FRICTION}},
    {SWAY_FINDING_CAR,
     4,
     {SWAY_UNKNOWN_CAR_MASS, SWAY_UNKNOWN_CAR_INERTIA, SWAY_UNKNOWN_STIFFNESS + SWAY_AXLE_CAR_FRONT,
      SWAY_UNKNOWN_STIFFNESS + SWAY_AXLE_CAR_REAR}},
    {SWAY_FINDING_TRAILER,
     6,
     {SWAY_UNKNOWN_TRAILER_MASS, SWAY_UNKNOWN_TRAILER_INERTIA, SWAY_UNKNOWN_TRAILER_PLACE,
      SWAY_UNKNOWN_TRAILER_LENGTH, SWAY_UNKNOWN_STIFFNESS + SWAY_AXLE_TRAILER_FRONT,
      SWAY_UNKNOWN_STIFFNESS + SWAY_AXLE_TRAILER_REAR}},
};

static int group(int explanation, int number[6])
{
    if (explanation < SWAY_SUPERVISE_SENSORS) {
        number[0] = 2 * explanation;
        number[1] = 2 * explanation + 1;
        const bool car = explanation == SWAY_ORIGIN_CAR_ACC - 1;
        const bool trailer = explanation == SWAY_ORIGIN_TRAILER_ACC - 1;
        number[2] = SWAY_UNKNOWN_ROLL + (trailer ? 1 : 0);
        return car || trailer ? 3 : 2;
    }
    memcpy(number, GROUPS[explanation - SWAY_SUPERVISE_SENSORS].number, 6 * sizeof *number);
    return GROUPS[explanation - SWAY_SUPERVISE_SENSORS].size;
}

/* x' (P - S)^-1 x of a group. */
static double chi_square(int size, const int *number)
{
    double m[6][7];
    double sum = 0;
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++) {
            m[i][j] = -value(sway_kalman_covariance(&supervise.numbers, (uint32_t)number[i],
                                                    (uint32_t)number[j]));
        }
        m[i][i] += pow(before_of(number[i]), 2);
        m[i][size] = value(supervise.value[number[i]]);
    }
    for (int k = 0; k < size; k++) {
        for (int i = 0; i < size; i++) {
            const double factor = i == k ? 0 : m[i][k] / m[k][k];
            for (int j = k; j <= size; j++) {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    for (int k = 0; k < size; k++) {
        sum += m[k][size] / m[k][k] * value(supervise.value[number[k]]);
    }
    return sum;
}

static void weigh_all(void)
{
    supervise.stage = WEIGH;
    supervise.explanation = 0;
    while (sway_supervise_run(&supervise)) {
    }
}

static void an_explanation_costs_three_for_every_number(void)
{
    start_numbers();
    weigh_all();
    for (int e = 0; e <= LAST; e++) {
        int number[6];
        TEST_ASSERT_EQUAL(-3000 * group(e, number), supervise.score_milli[e]);
    }
}

static void an_explanation_is_worth_its_chi_square(void)
{
    start_numbers();
    for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        put_number(i, before_of(i) * (i % 3 == 0 ? -5 : 3 + 0.1 * i), 0.6 * before_of(i));
        for (int j = 0; j < i; j++) {
            put_covariance(i, j, before_of(i) * before_of(j) * 0.06 * sin(3 * i + j * j));
        }
    }
    supervise.reported = SPEED;
    double expected[LAST + 1];
    for (int e = 0; e <= LAST; e++) {
        int number[6];
        const int size = group(e, number);
        expected[e] = e == SPEED ? 0 : 1000 * chi_square(size, number) - 3000 * size;
    }
    weigh_all();
    for (int e = 0; e <= LAST; e++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.6, expected[e], supervise.score_milli[e]);
    }
}

static void a_worth_beyond_all_is_a_million(void)
{
    start_numbers();
    put_number(0, 1000, 0.5 * before_of(0));
    weigh_all();
    TEST_ASSERT_EQUAL(1000000000 - 6000, supervise.score_milli[0]);
}

/* One round: the given score of some explanations, too little of all others. The last one is
 * weighed by the numbers. */
static void judge(int a, int32_t score_a, int b, int32_t score_b)
{
    for (int e = 0; e < LAST; e++) {
        supervise.score_milli[e] = -6000;
    }
    supervise.score_milli[a] = score_a;
    supervise.score_milli[b] = score_b;
    supervise.stage = WEIGH;
    supervise.explanation = LAST;
    TEST_ASSERT_TRUE(sway_supervise_run(&supervise));
    TEST_ASSERT_FALSE(sway_supervise_run(&supervise));
}

static uint32_t bit_of_sensor(int e)
{
    return SWAY_CHANNEL_BIT(sway_origin_of_channel((sway_origin_t)(e + 1)));
}

static void a_sensor_is_rejected_when_far_ahead_twice(void)
{
    for (int e = 0; e < SWAY_SUPERVISE_SENSORS; e++) {
        const int other = e == 0 ? 4 : 0;
        start_numbers();
        judge(e, 24001, other, 12001); /* once is not twice, in the first round, too */
        TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
        start_numbers();
        judge(e, 24000, other, 12000);
        judge(e, 24000, other, 12000);
        TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask | supervise.rejected_mask);
        judge(e, 24001, other, 12002); /* ahead by less than twelve: both are suspect if it lasts */
        TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
        judge(e, 24001, other, 12002);
        TEST_ASSERT_EQUAL_HEX32(bit_of_sensor(e) | bit_of_sensor(other), supervise.suspect_mask);
        judge(e, 24001, other, 12001);
        TEST_ASSERT_EQUAL_HEX32(bit_of_sensor(e), supervise.suspect_mask);
        judge(other, 24001, e, 12001); /* another one: not twice in a row */
        judge(e, 24001, other, 12001);
        TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask);
        TEST_ASSERT_EQUAL(7, supervise.rounds);
        judge(e, 24001, other, 12001);
        TEST_ASSERT_EQUAL_HEX32(bit_of_sensor(e), supervise.rejected_mask);
        TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
        TEST_ASSERT_EQUAL(0, supervise.rounds);
        judge(other, 24001, e, 24001); /* judged anew: of a single round nothing is made */
        TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
        TEST_ASSERT_EQUAL_HEX32(bit_of_sensor(e), supervise.rejected_mask);
    }
}

static void what_is_a_finding_no_more_is_not_suspect(void)
{
    start_numbers();
    judge(SPEED, 30000, 3, 29000);
    judge(SPEED, 1000, 3, -6000);
    judge(SPEED, 30000, 3, 29000);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
    judge(SPEED, 30000, 3, 29000);
    TEST_ASSERT_EQUAL_HEX32(bit_of_sensor(3), supervise.suspect_mask);
    judge(SPEED, 1000, 3, -6000);
    TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
}

/* What is shown is the truth over 1 + h; of numbers of which a part p of the variance before was
 * learnt, the flat prior's estimate is 1/p of the value. */
static void expect_sensor(double re, double im, int32_t code, double size, double se)
{
    start_numbers();
    judge(1, 90000, 0, 0);
    const double before[2] = {before_of(2), before_of(3)};
    const double error[2] = {before[0] / sqrt(5), before[1] / sqrt(2)}; /* learnt: 0.8, 0.5 */
    put_number(2, 0.8 * re, error[0]);
    put_number(3, 0.5 * im, error[1]);
    judge(1, 90000, 0, 0);
    TEST_ASSERT_EQUAL(code + (int32_t)SWAY_CHANNEL_CAR_YAW_RATE, supervise.finding.code);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, size, supervise.finding.size_micro);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, se, supervise.finding.se_micro);
    TEST_ASSERT_EQUAL_DOUBLE(0, value(supervise.value[2]));
}

static void gain_and_delay_of_a_sensor_have_their_errors(void)
{
    const double se_gain = 1e6 * 0.01 / sqrt(5) / sqrt(0.8), se_phase = 1e6 * 0.05;
    expect_sensor(-0.8, 0, SWAY_FINDING_GAIN, 4e6, 25 * se_gain);
    expect_sensor(-0.95, 0, SWAY_FINDING_GAIN, 19e6, 400 * se_gain);
    expect_sensor(0, 1, SWAY_FINDING_DELAY, 1e6 * M_PI / 4 / 0.02, se_phase / 0.02);
    expect_sensor(0, -0.125, SWAY_FINDING_DELAY, -1e6 * atan(0.125) / 0.02, se_phase / 0.02);
    expect_sensor(-2, 0.125, SWAY_FINDING_GAIN, 1e6 * (-1 / 1.015625 - 1),
                  se_gain / pow(1.015625, 2));
    /* A quarter of a period: nothing of the truth is in phase; no delay follows from that. */
    expect_sensor(-1, 0.5, SWAY_FINDING_GAIN, -1e6, 0);
}

/* The yaw rate of the car, rejected with a gain of 4/3 and a standard error of 40,000; its numbers
 * are then those of a flat prior, of which 0.8 and 0.5 of the variance were learnt. */
static void reject_yaw_rate(void)
{
    start_numbers();
    judge(1, 90000, 0, 0);
    judge(1, 90000, 0, 0);
    supervise.finding.size_micro = 333333;
    supervise.finding.se_micro = 40000;
}

static void put_measured(double re, double im, double se)
{
    const double before[2] = {before_of(2), before_of(3)};
    const double variance = 1 / (1 / (se * se) + 1 / (before[0] * before[0]));
    const double learnt = 1 - variance / (before[0] * before[0]);
    put_number(2, learnt * re, sqrt(variance));
    put_number(3, 0.5 * im, before[1] / sqrt(2));
}

static void a_rejected_sensor_is_measured_once_more(void)
{
    const uint32_t bit = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE);
    reject_yaw_rate();
    for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        sway_supervise_t anew;
        sway_supervise_init(&anew, &vehicle, 10000);
        const int32_t expected = i == 2 ? 250000 : (i == 3 ? 500000 : anew.tolerance_ppm[i]);
        TEST_ASSERT_EQUAL(expected, supervise.tolerance_ppm[i]);
    }
    for (int round = 1; round <= SWAY_SUPERVISE_MEASURED; round++) {
        TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, sway_supervise_wanted(&supervise));
        /* a gain of 1/(1 + h); the smaller its error, the better */
        put_measured(-0.2, 0, 0.064 / 1.5625 - 0.001 * round);
        judge(4, 90000, 0, 0); /* nothing else is reported meanwhile */
        TEST_ASSERT_EQUAL_HEX32(bit, supervise.rejected_mask);
        TEST_ASSERT_EQUAL(SWAY_FINDING_GAIN + (int32_t)SWAY_CHANNEL_CAR_YAW_RATE,
                          supervise.finding.code);
        const bool better = 64000 - 1562.5 * round < 40000;
        TEST_ASSERT_INT_WITHIN(1, better ? 250000 : 333333, supervise.finding.size_micro);
        TEST_ASSERT_INT_WITHIN(1, better ? 64000 - 1562.5 * round : 40000,
                               supervise.finding.se_micro);
    }
    TEST_ASSERT_EQUAL_HEX32(~bit, sway_supervise_wanted(&supervise));
    TEST_ASSERT_EQUAL(10000, supervise.tolerance_ppm[2]);
    TEST_ASSERT_EQUAL_DOUBLE(0, value(supervise.value[2]));
    judge(4, 90000, 3, 90000); /* a first time: what was so before the report is forgotten */
    TEST_ASSERT_EQUAL_HEX32(0, supervise.suspect_mask);
    judge(4, 90000, 0, 0);
    judge(4, 90000, 0, 0);
    TEST_ASSERT_EQUAL_HEX32(bit | bit_of_sensor(4), supervise.rejected_mask);
    TEST_ASSERT_EQUAL_HEX32(~bit, sway_supervise_wanted(&supervise)); /* the last one is measured */
    supervise.measuring = 0;
    supervise.rejected_mask = UINT32_MAX;
    TEST_ASSERT_EQUAL_HEX32(0, sway_supervise_wanted(&supervise));
}

static void what_says_less_or_something_else_is_no_better_size(void)
{
    reject_yaw_rate();
    put_measured(-0.2, 0, 0.04 / 1.5625); /* as certain */
    judge(0, 0, 4, 0);
    TEST_ASSERT_EQUAL(333333, supervise.finding.size_micro);
    put_measured(0.01, 0.4, 0.01); /* a delay */
    judge(0, 0, 4, 0);
    TEST_ASSERT_EQUAL(333333, supervise.finding.size_micro);
    put_number(2, -0.2, before_of(2)); /* nothing was learnt */
    put_number(3, 0, before_of(3));
    judge(0, 0, 4, 0);
    TEST_ASSERT_EQUAL(333333, supervise.finding.size_micro);
    put_measured(-0.2, 0, 0.039 / 1.5625);
    judge(0, 0, 4, 0);
    TEST_ASSERT_EQUAL(250000, supervise.finding.size_micro);
}

static void a_value_of_the_vehicle_that_differs_is_set_free(void)
{
    int32_t assumed[SWAY_UNKNOWN_COUNT];
    start_numbers();
    memcpy(assumed, supervise.tolerance_ppm, sizeof assumed);
    for (int e = SPEED; e < CAR; e++) {
        int number[6];
        const int size = group(e, number);
        put_number(0, 0.1, 0.01);
        judge(e, 24001, 0, 12001);
        TEST_ASSERT_EQUAL_DOUBLE(0.1, round(1e6 * value(supervise.value[0])) / 1e6);
        judge(e, 24001, 0, 12001);
        TEST_ASSERT_EQUAL(GROUPS[e - SPEED].finding, supervise.finding.code);
        TEST_ASSERT_EQUAL(e, supervise.reported);
        TEST_ASSERT_EQUAL_HEX32(0, supervise.rejected_mask | supervise.suspect_mask);
        TEST_ASSERT_EQUAL_DOUBLE(0, value(supervise.value[0]));
        for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
            bool is_free = false;
            for (int k = 0; k < size; k++) {
                is_free = is_free || number[k] == i;
            }
            const int32_t ten_times = 10 * assumed[i];
            TEST_ASSERT_EQUAL(is_free ? (ten_times > 250000 ? ten_times : 250000) : assumed[i],
                              supervise.tolerance_ppm[i]);
        }
    }
    judge(CAR, 90000, 0, 0);
    judge(CAR, 90000, 0, 0);
    judge(LAST, 90000, 0, 0);
    TEST_ASSERT_EQUAL(CAR - 1, supervise.reported);
}

/* The change on the way and what the belief was off by are one; of two axles it is the mean. */
static void the_size_is_the_sum_of_change_and_belief(void)
{
    static const struct {
        int explanation, axles;
        double size, se;
    } cases[] = {
        /* numbers are 0.01 (i + 1), errors 0.01, covariance of each pair 2e-5 */
        {SPEED + 1, 2, SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_UNKNOWN_STIFFNESS + 2, 2},
        {SPEED + 2, 2, SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_UNKNOWN_STIFFNESS + 4, 2},
        {SPEED + 3, 1, SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_UNKNOWN_STIFFNESS + 8, 2},
        {SPEED + 3, 2, SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_UNKNOWN_STIFFNESS + 7, 4},
        {SPEED + 3, 3, SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_UNKNOWN_STIFFNESS + 8, 2},
        {SPEED + 4, 2, SWAY_UNKNOWN_CHANGED_PLACE + SWAY_UNKNOWN_TRAILER_PLACE + 2, 2},
        {SPEED + 5, 2, SWAY_UNKNOWN_FRICTION + 1, 1},
    };
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        start_numbers();
        for (int i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
            put_number(i, 0.05 * (i + 1), 0.4);
            for (int j = 0; j < i; j++) {
                put_covariance(i, j, 0.02);
            }
        }
        vehicle.trailer.axles = cases[c].axles;
        supervise.reported = (uint8_t)cases[c].explanation;
        judge(0, 0, 0, 0);
        const double n = cases[c].se, parts = n > 2 ? 2 : 1;
        TEST_ASSERT_EQUAL(GROUPS[cases[c].explanation - SPEED].finding, supervise.finding.code);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, 50000 * cases[c].size, supervise.finding.size_micro);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, 1e6 * sqrt(0.16 * n + 0.02 * n * (n - 1)) / parts,
                                  supervise.finding.se_micro);
    }
}

/* Relations are linear in one over the speed: 0.2 of it too little is a fourth of the speed. */
static void a_wrong_speed_is_reported_as_a_ratio(void)
{
    start_numbers();
    put_number(SWAY_UNKNOWN_SPEED, 0.2, 0.016);
    supervise.reported = SPEED;
    judge(0, 0, 0, 0);
    TEST_ASSERT_EQUAL(250000, supervise.finding.size_micro);
    TEST_ASSERT_EQUAL(25000, supervise.finding.se_micro);
    put_number(SWAY_UNKNOWN_SPEED, 0.9, 0.016);
    judge(0, 0, 0, 0);
    TEST_ASSERT_EQUAL(9000000, supervise.finding.size_micro);
    TEST_ASSERT_EQUAL(1600000, supervise.finding.se_micro);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(means_are_taken_as_kalman_says);
    RUN_TEST(an_offset_is_reported_from_its_limit_on);
    RUN_TEST(an_offset_is_reported_as_far_as_no_other_may_be_it);
    RUN_TEST(an_offset_in_a_swing_is_reported_with_its_error);
    RUN_TEST(means_are_of_complete_rows_only);
    RUN_TEST(a_row_counts_as_100_m_s2_at_most);
    RUN_TEST(an_explanation_costs_three_for_every_number);
    RUN_TEST(an_explanation_is_worth_its_chi_square);
    RUN_TEST(a_worth_beyond_all_is_a_million);
    RUN_TEST(a_sensor_is_rejected_when_far_ahead_twice);
    RUN_TEST(what_is_a_finding_no_more_is_not_suspect);
    RUN_TEST(gain_and_delay_of_a_sensor_have_their_errors);
    RUN_TEST(a_rejected_sensor_is_measured_once_more);
    RUN_TEST(what_says_less_or_something_else_is_no_better_size);
    RUN_TEST(a_value_of_the_vehicle_that_differs_is_set_free);
    RUN_TEST(the_size_is_the_sum_of_change_and_belief);
    RUN_TEST(a_wrong_speed_is_reported_as_a_ratio);
    return UNITY_END();
}

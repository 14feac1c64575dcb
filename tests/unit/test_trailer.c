/* The trailer from the car's own sensors: is it there, what is it, is it another one. */
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
}

void tearDown(void)
{
}

/* The plant in double precision: the equations with the hitch force as an unknown of a 4 x 4
 * system, which is not how sway_observer has them. */
typedef struct {
    double lateral, yaw, trailer_yaw, articulation;
} motion_t;

static void solve4(double a[4][5])
{
    for (int i = 0; i < 4; i++) {
        int pivot = i;
        for (int k = i + 1; k < 4; k++) {
            pivot = fabs(a[k][i]) > fabs(a[pivot][i]) ? k : pivot;
        }
        for (int j = 0; j < 5; j++) {
            const double swap = a[i][j];
            a[i][j] = a[pivot][j];
            a[pivot][j] = swap;
        }
        for (int k = 0; k < 4; k++) {
            const double share = k == i ? 0.0 : a[k][i] / a[i][i];
            for (int j = i; j < 5; j++) {
                a[k][j] -= share * a[i][j];
            }
        }
    }
}

static double slope(const sway_vehicle_t *of, bool trailer, const motion_t *m, double wheel,
                    double v, motion_t *rate)
{
    const sway_car_t *c = &of->car;
    const sway_trailer_t *t = &of->trailer;
    const double lf = c->front_axle_to_cog_um * 1e-6, lr = c->rear_axle_to_cog_um * 1e-6;
    const double lh = c->hitch_to_cog_um * 1e-6, l2 = t->hitch_to_cog_um * 1e-6;
    const double af = t->front_axle_to_cog_um * 1e-6, ar = -t->rear_axle_to_cog_um * 1e-6;
    const double delta = wheel / (c->steering_ratio_milli * 1e-3);
    const double ff =
        c->front_cornering_stiffness_n_per_rad * (delta - (m->lateral + lf * m->yaw) / v);
    const double fr = -c->rear_cornering_stiffness_n_per_rad * (m->lateral - lr * m->yaw) / v;
    const double ball = m->lateral - lh * m->yaw;
    double f2f = t->front_cornering_stiffness_n_per_rad *
                 (m->articulation - (ball - (l2 - af) * m->trailer_yaw) / v);
    double f2r = t->rear_cornering_stiffness_n_per_rad *
                 (m->articulation - (ball - (l2 - ar) * m->trailer_yaw) / v);
    double m2 = t->mass_g * 1e-3, i2 = t->yaw_inertia_gm2 * 1e-3;
    if (!trailer) {
        f2f = f2r = 0.0;
        m2 = i2 = 1e-6;
    }
    const double m1 = c->mass_g * 1e-3, i1 = c->yaw_inertia_gm2 * 1e-3;
    double a[4][5] = {/* v_y', r', w', H */
                      {m1, 0, 0, -1, ff + fr - m1 * v * m->yaw},
                      {0, i1, 0, lh, lf * ff - lr * fr},
                      {0, 0, i2, l2, af * f2f + ar * f2r},
                      {m2, -m2 * lh, -m2 * l2, 1, f2f + f2r - m2 * v * m->yaw}};
    solve4(a);
    rate->lateral = a[0][4] / a[0][0];
    rate->yaw = a[1][4] / a[1][1];
    rate->trailer_yaw = a[2][4] / a[2][2];
    rate->articulation = m->trailer_yaw - m->yaw;
    return rate->lateral + v * m->yaw + c->lateral_acc_position_um * 1e-6 * rate->yaw;
}

static double noise(double size)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        sum += rand() / (double)RAND_MAX;
    }
    return sum * size;
}

static void work(void)
{
    while (sway_trailer_cost(&watch) != 0U) {
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(SWAY_SLICE_COST, sway_trailer_cost(&watch));
        sway_trailer_run(&watch);
    }
}

/* Drives `of` with a changing wheel; `mask` are the channels that the rows have. */
static void drive(const sway_vehicle_t *of, bool trailer, double kmh, double seconds, uint32_t mask)
{
    const double v = kmh / 3.6, dt = 0.001;
    motion_t m = {0, 0, 0, 0};
    double acc = 0.0;
    for (int k = 0; k < (int)(seconds * 1000); k++) {
        const double t = k * dt;
        const double wheel = 0.12 * sin(2.6 * t) + 0.1 * sin(4.1 * t + 1.0) * sin(0.3 * t);
        motion_t rate, middle, next;
        (void)slope(of, trailer, &m, wheel, v, &rate);
        middle = (motion_t){m.lateral + 0.5 * dt * rate.lateral, m.yaw + 0.5 * dt * rate.yaw,
                            m.trailer_yaw + 0.5 * dt * rate.trailer_yaw,
                            m.articulation + 0.5 * dt * rate.articulation};
        acc = slope(of, trailer, &middle, wheel, v, &next);
        m = (motion_t){m.lateral + dt * next.lateral, m.yaw + dt * next.yaw,
                       m.trailer_yaw + dt * next.trailer_yaw,
                       m.articulation + dt * next.articulation};
        if (k % 10 == 0) {
            sway_row_t row;
            memset(&row, 0, sizeof row);
            row.valid_mask = mask;
            row.time_us = row_us += 10000;
            row.restart = k == 0;
            row.value[SWAY_CHANNEL_STEERING_WHEEL_ANGLE] = (int32_t)(wheel * 1e6);
            row.value[SWAY_CHANNEL_SPEED] = (int32_t)(v * 1e3);
            row.value[SWAY_CHANNEL_CAR_YAW_RATE] = (int32_t)(1e6 * (m.yaw + noise(0.002)));
            row.value[SWAY_CHANNEL_CAR_LATERAL_ACC] = (int32_t)(1e6 * (acc + noise(0.04)));
            sway_trailer_push(&watch, &row);
            work();
        }
    }
}

#define OWN                                                                                        \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED) |  \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC))

static void model_at(double kmh)
{
    int slices = 1;
    sway_trailer_model_start(&watch, real(kmh / 3.6));
    while (sway_trailer_model_run(&watch)) {
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(SWAY_SLICE_COST, sway_trailer_model_cost(&watch));
        slices++;
    }
    TEST_ASSERT_LESS_THAN_INT(60, slices);
}

static void the_users_vehicle_gives_the_golden_values(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    TEST_ASSERT_FALSE(sway_trailer_speaks(&watch));
    model_at(107.9);
    /* one stiffness in the middle of two forces: 0.1 km/h */
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, watch.model.kind);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_USER, watch.model.source);
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 123.34, 3.6 * value(watch.model.v_crit_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.0689, value(watch.model.damping_ratio));
    /* the sensitivities of the reference with 8 %, 10 %, 3 % and 5 cm: about 10 km/h */
    TEST_ASSERT_DOUBLE_WITHIN(2.5, 10.5, 3.6 * value(watch.model.v_crit_se_m_s));
}

static void nothing_known_of_the_trailer(void)
{
    sway_trailer_report_t report;
    sway_vehicle_t told = vehicle;
    told.trailer.axles = 0;
    srand(1);
    sway_trailer_init(&watch, &told, 0, 10000);
    model_at(100.0);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_NONE, watch.model.kind); // typical values are no statement
    drive(&vehicle, true, 90.0, 40.0, OWN);
    drive(&vehicle, true, 105.0, 40.0, OWN);
    TEST_ASSERT_TRUE(sway_trailer_speaks(&watch));
    model_at(105.0);
    TEST_ASSERT_EQUAL_INT(SWAY_SOURCE_IDENTIFIED, watch.model.source);
    TEST_ASSERT_DOUBLE_WITHIN(3.0, 123.34, 3.6 * value(watch.model.v_crit_m_s));
    TEST_ASSERT_TRUE(value(watch.model.v_crit_se_m_s) < 0.04 * value(watch.model.v_crit_m_s));
    sway_trailer_report(&watch, &report);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_THERE, report.presence);
    TEST_ASSERT_INT_WITHIN(3 * report.mass_kg.se, 1880, report.mass_kg.value);
    TEST_ASSERT_LESS_THAN_INT(600, report.mass_kg.se); // of 620 at the start
    TEST_ASSERT_INT_WITHIN(3 * report.yaw_inertia_kgm2.se, 10350, report.yaw_inertia_kgm2.value);
    TEST_ASSERT_INT_WITHIN(3 * report.hitch_to_axle_mm.se, 5264, report.hitch_to_axle_mm.value);
    TEST_ASSERT_LESS_THAN_INT(350, report.hitch_to_axle_mm.se); // of 1200 at the start
    TEST_ASSERT_INT_WITHIN(3 * report.friction_nm.se + 5, 0, report.friction_nm.value);
}

static void a_car_alone(void)
{
    sway_vehicle_t told = vehicle;
    told.trailer.axles = 0;
    srand(2);
    sway_trailer_init(&watch, &told, 0, 10000);
    drive(&vehicle, false, 90.0, 60.0, OWN);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_NONE, watch.presence);
    TEST_ASSERT_FALSE(sway_trailer_speaks(&watch));
    sway_trailer_init(&watch, &told, 0, 10000); // and one is hung on
    drive(&vehicle, true, 90.0, 60.0, OWN);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_THERE, watch.presence);
}

static void silent_where_the_trailer_is_measured(void)
{
    sway_trailer_report_t report;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    drive(&vehicle, true, 90.0, 2.0, OWN | SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE));
    TEST_ASSERT_EQUAL_INT32(0, watch.learnt_ms);
    TEST_ASSERT_FALSE(sway_trailer_speaks(&watch));
    sway_trailer_report(&watch, &report);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_SENSED, report.presence);
}

static void too_slow_or_without_a_sensor_nothing_is_learnt(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    drive(&vehicle, true, 25.0, 5.0, OWN);
    drive(&vehicle, true, 90.0, 5.0, OWN & ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC));
    TEST_ASSERT_EQUAL_INT32(0, watch.learnt_ms);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_UNDECIDED, watch.presence);
}

static void another_trailer_is_another_one(void)
{
    sway_trailer_memory_t memory;
    sway_vehicle_t told = vehicle;
    sway_vehicle_t other = vehicle;
    told.trailer.axles = 0;
    other.trailer.hitch_to_cog_um = 3600000;
    other.trailer.yaw_inertia_gm2 = 3200000;
    other.trailer.mass_g = 1200000;
    other.trailer.front_cornering_stiffness_n_per_rad = 80000;
    other.trailer.rear_cornering_stiffness_n_per_rad = 80000;
    srand(3);
    sway_trailer_init(&watch, &told, 0, 10000);
    drive(&vehicle, true, 95.0, 40.0, OWN);
    sway_trailer_remember(&watch, &memory);
    sway_trailer_init(&watch, &told, 0, 10000);
    const double doubt = value(sway_observer_se(&watch.with, SWAY_STATE_CAR_REAR));
    sway_trailer_recall(&watch, &memory);
    TEST_ASSERT_TRUE(value(sway_observer_se(&watch.with, SWAY_STATE_CAR_REAR)) < 0.8 * doubt);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, value(sway_trailer_likeness(&watch, &memory)));
    drive(&vehicle, true, 85.0, 40.0, OWN);
    TEST_ASSERT_TRUE(value(sway_trailer_likeness(&watch, &memory)) > 1.0);
    sway_trailer_init(&watch, &told, 0, 10000);
    sway_trailer_recall(&watch, &memory);
    drive(&other, true, 85.0, 40.0, OWN);
    TEST_ASSERT_TRUE(value(sway_trailer_likeness(&watch, &memory)) < -1.0);
}

/* The reconstructed swing is the plant's. */
static void the_swing_of_the_trailer(void)
{
    const test_plant_t plant = reference_plant(100.0);
    sway_line_t line;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    plant_line(&plant, &vehicle, &line);
    const double is = cabs(cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude));
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * is, is, value(sway_trailer_swing(&watch, &line)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_users_vehicle_gives_the_golden_values);
    RUN_TEST(nothing_known_of_the_trailer);
    RUN_TEST(a_car_alone);
    RUN_TEST(silent_where_the_trailer_is_measured);
    RUN_TEST(too_slow_or_without_a_sensor_nothing_is_learnt);
    RUN_TEST(another_trailer_is_another_one);
    RUN_TEST(the_swing_of_the_trailer);
    return UNITY_END();
}

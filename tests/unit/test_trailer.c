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
    /* tyres that lag by 0.3 m: eigenvalues by numpy (roots() of tests/bench/warning_plant.py) */
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 118.63, 3.6 * value(watch.model.v_crit_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.0481, value(watch.model.damping_ratio));
    watch.with.x[SWAY_STATE_RELAXATION] = sway_real_zero();
    model_at(107.9);
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 123.34, 3.6 * value(watch.model.v_crit_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.0689, value(watch.model.damping_ratio));
    /* the sensitivities of the reference with 8 %, 10 %, 3 % and 5 cm: about 10 km/h */
    TEST_ASSERT_DOUBLE_WITHIN(2.5, 10.5, 3.6 * value(watch.model.v_crit_se_m_s));
}

static void nothing_known_of_the_trailer(void)
{
    sway_trailer_report_t report;
    sway_vehicle_t known = vehicle;
    known.trailer.axles = 0;
    srand(1);
    sway_trailer_init(&watch, &known, 0, 10000);
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
    sway_vehicle_t known = vehicle;
    known.trailer.axles = 0;
    srand(2);
    sway_trailer_init(&watch, &known, 0, 10000);
    drive(&vehicle, false, 90.0, 60.0, OWN);
    TEST_ASSERT_EQUAL_INT(SWAY_TRAILER_NONE, watch.presence);
    TEST_ASSERT_FALSE(sway_trailer_speaks(&watch));
    sway_trailer_init(&watch, &known, 0, 10000); // and one is hung on
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
    sway_vehicle_t known = vehicle;
    sway_vehicle_t other = vehicle;
    known.trailer.axles = 0;
    other.trailer.hitch_to_cog_um = 3600000;
    other.trailer.yaw_inertia_gm2 = 3200000;
    other.trailer.mass_g = 1200000;
    other.trailer.front_cornering_stiffness_n_per_rad = 80000;
    other.trailer.rear_cornering_stiffness_n_per_rad = 80000;
    srand(3);
    sway_trailer_init(&watch, &known, 0, 10000);
    drive(&vehicle, true, 95.0, 40.0, OWN);
    sway_trailer_remember(&watch, &memory);
    sway_trailer_init(&watch, &known, 0, 10000);
    const double uncertainty = value(sway_observer_se(&watch.with, SWAY_STATE_CAR_REAR));
    sway_trailer_recall(&watch, &memory);
    TEST_ASSERT_TRUE(value(sway_observer_se(&watch.with, SWAY_STATE_CAR_REAR)) < 0.8 * uncertainty);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, value(sway_trailer_likeness(&watch, &memory)));
    drive(&vehicle, true, 85.0, 40.0, OWN);
    TEST_ASSERT_TRUE(value(sway_trailer_likeness(&watch, &memory)) > 1.0);
    sway_trailer_init(&watch, &known, 0, 10000);
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

/* --- the observer, against the same filter in double precision -----------------------------------
 */

enum { N = SWAY_STATE_COUNT };

typedef struct {
    double front, rear, inertia, cog, relaxation;
    double mass, length, inertia_2, stiffness, axle, friction;
} body_t;

typedef struct {
    double wheel, speed, yaw_rate, acc;
} sample_t;

typedef struct {
    sway_observer_car_t car;
    int n;
    double learning, acc_power, unfit[2], lag[2], road, log_likelihood;
    double x[N], p[N][N];
    sample_t last, now;
} filter_t;

static const int MOTIONS[4] = {SWAY_STATE_LATERAL_SPEED, SWAY_STATE_CAR_YAW_RATE,
                               SWAY_STATE_TRAILER_YAW_RATE, SWAY_STATE_ARTICULATION};

static body_t body_by(const filter_t *f)
{
    const double *const x = f->x;
    const double mass = exp(x[SWAY_STATE_TRAILER_MASS]);
    const double length = exp(x[SWAY_STATE_TRAILER_LENGTH]);
    const body_t b = {value(f->car.front_n_per_rad) * exp(x[SWAY_STATE_CAR_FRONT]),
                      value(f->car.rear_n_per_rad) * exp(x[SWAY_STATE_CAR_REAR]),
                      value(f->car.inertia_kgm2) * exp(x[SWAY_STATE_CAR_INERTIA]),
                      x[SWAY_STATE_CAR_COG],
                      x[SWAY_STATE_RELAXATION],
                      mass,
                      length,
                      mass * length * length * exp(x[SWAY_STATE_TRAILER_GYRATION]),
                      mass * 9.81 * exp(x[SWAY_STATE_TRAILER_STIFFNESS]),
                      x[SWAY_STATE_TRAILER_AXLE],
                      100 * x[SWAY_STATE_FRICTION]};
    return b;
}

/* To the first order in a small step, in place of exp(). */
static void move_body(body_t *b, int state, double step)
{
    const double grown = 1 + step;
    const bool by_mass = state == SWAY_STATE_TRAILER_MASS;
    const bool by_length = state == SWAY_STATE_TRAILER_LENGTH;
    b->front *= state == SWAY_STATE_CAR_FRONT ? grown : 1;
    b->rear *= state == SWAY_STATE_CAR_REAR ? grown : 1;
    b->inertia *= state == SWAY_STATE_CAR_INERTIA ? grown : 1;
    b->cog += state == SWAY_STATE_CAR_COG ? step : 0;
    b->relaxation += state == SWAY_STATE_RELAXATION ? step : 0;
    b->mass *= by_mass ? grown : 1;
    b->length *= by_length ? grown : 1;
    b->inertia_2 *= by_mass || state == SWAY_STATE_TRAILER_GYRATION ? grown : 1;
    b->inertia_2 *= by_length ? grown * grown : 1;
    b->stiffness *= by_mass || state == SWAY_STATE_TRAILER_STIFFNESS ? grown : 1;
    b->axle += state == SWAY_STATE_TRAILER_AXLE ? step : 0;
    b->friction += state == SWAY_STATE_FRICTION ? 100 * step : 0;
}

static double tyre(double linear, double peak)
{
    return linear / (1 + linear * linear / (peak * peak) / 3);
}

/* Rates of the four motions, and the acceleration read; the trailer's place in its own balance
 * gives the force at the ball. */
static void rates_by(const filter_t *f, const body_t *b, const double m[4], double steer,
                     double steering, double v, double out[5])
{
    const sway_observer_car_t *const car = &f->car;
    const double m1 = value(car->mass_kg), d = value(car->half_tandem_m);
    const double lf = value(car->front_m) - b->cog, lr = value(car->rear_m) + b->cog;
    const double lh = value(car->hitch_m) + b->cog, arm = b->length + b->axle;
    const bool trailer = f->n == N;
    double from[5] = {m[0], m[1], m[2], m[3], steer};
    double slip[3] = {0};
    for (int round = 0; round < 2; round++) {
        const double found[3] = {from[4] - (from[0] + lf * from[1]) / v,
                                 -(from[0] - lr * from[1]) / v,
                                 from[3] - (from[0] - lh * from[1] - arm * from[2]) / v};
        for (int i = 0; i < 3; i++) { /* of the second round: of the slips' rates */
            slip[i] = round == 0 ? found[i] : slip[i] - b->relaxation / v * found[i];
        }
        const double ff = tyre(b->front * slip[0], value(car->peak_n[0]));
        const double fr = tyre(b->rear * slip[1], value(car->peak_n[1]));
        const double f2 = tyre(b->stiffness * slip[2], b->mass * 9.81);
        const double opening = m[2] - m[1];
        const double dry = trailer ? b->friction * opening / hypot(opening, 0.01) : 0;
        const double turn = lf * ff - lr * fr + dry;
        const double turn_2 = -b->axle * f2 - dry - b->stiffness * d * d * m[2] / v;
        const double apart =
            (ff + fr) / m1 - lh * turn / b->inertia - b->length * turn_2 / b->inertia_2;
        const double yielding =
            1 / m1 + lh * lh / b->inertia + b->length * b->length / b->inertia_2;
        const double hitch = trailer ? (f2 - b->mass * apart) / (1 + b->mass * yielding) : 0;
        const double acc = (ff + fr + hitch) / m1;
        out[1] = (turn - lh * hitch) / b->inertia;
        out[0] = acc - v * m[1];
        out[2] = trailer ? (turn_2 - b->length * hitch) / b->inertia_2 : 0;
        out[3] = trailer ? opening : 0;
        out[4] = acc + (value(car->acc_m) + b->cog) * out[1];
        memcpy(from, out, 4 * sizeof *out);
        from[4] = steering;
    }
}

static bool is_shift(int state)
{
    return state == SWAY_STATE_YAW_RATE_OFFSET || state == SWAY_STATE_ACC_OFFSET;
}

/* b + dt/2 A (b + dt/3 A b) */
static void mean_over_step(double a[4][4], double dt, double b[4])
{
    double inner[4];
    memcpy(inner, b, sizeof inner);
    for (int order = 3; order >= 2; order--) {
        double next[4];
        for (int i = 0; i < 4; i++) {
            next[i] = b[i];
            for (int k = 0; k < 4; k++) {
                next[i] += dt / order * a[i][k] * inner[k];
            }
        }
        memcpy(inner, next, sizeof inner);
    }
    memcpy(b, inner, sizeof inner);
}

static double wandering(int state)
{
    return state == SWAY_STATE_LATERAL_SPEED                                          ? 1.5e-3
           : state == SWAY_STATE_CAR_YAW_RATE || state == SWAY_STATE_TRAILER_YAW_RATE ? 1.5e-4
           : state == SWAY_STATE_ARTICULATION                                         ? 0
           : state == SWAY_STATE_ACC_OFFSET                                           ? 1e-5
           : state == SWAY_STATE_YAW_RATE_OFFSET                                      ? 1e-8
           : state == SWAY_STATE_STEERING_OFFSET                                      ? 1e-7
                                                                                      : 1e-9;
}

/* F P F' + Q, for a motion that is moved by its mean rate over the step. `by_acc`: derivatives of
 * the acceleration. */
static void predict(filter_t *f, double by_acc[N])
{
    const double dt = value(f->car.step_s), ratio = value(f->car.ratio);
    const double v = (f->now.speed + f->last.speed) / 2;
    const double wheel = (f->now.wheel + f->last.wheel) / 2 + f->x[SWAY_STATE_STEERING_OFFSET];
    const double steering = (f->now.wheel - f->last.wheel) * ratio / dt;
    const double step = 1.0 / 1024;
    const int motions = f->n == N ? 4 : 2;
    const body_t body = body_by(f);
    double m[4], base[5], by[5][N] = {{0}}, a[4][4] = {{0}}, column[4] = {0};
    for (int k = 0; k < 4; k++) {
        m[k] = k < motions ? f->x[MOTIONS[k]] : 0;
    }
    rates_by(f, &body, m, ratio * wheel, steering, v, base);
    for (int i = 0; i < f->n; i++) {
        body_t moved_body = body;
        double moved_m[4], moved[5];
        for (int k = 0; k < 4; k++) {
            moved_m[k] = m[k] + (MOTIONS[k] == i ? step : 0);
        }
        move_body(&moved_body, i, step);
        const double offset = i == SWAY_STATE_STEERING_OFFSET ? step : 0;
        rates_by(f, &moved_body, moved_m, ratio * (wheel + offset), steering, v, moved);
        for (int k = 0; k < 5 && !is_shift(i); k++) {
            by[k][i] = (moved[k] - base[k]) / step;
        }
        by_acc[i] = by[4][i];
    }
    for (int i = 0; i < motions; i++) {
        column[i] = base[i];
        for (int k = 0; k < motions; k++) {
            a[i][k] = by[i][MOTIONS[k]];
        }
    }
    mean_over_step(a, dt, column);
    double transition[N][N] = {{0}}, half[N][N] = {{0}};
    for (int i = 0; i < f->n; i++) {
        transition[i][i] = 1;
    }
    for (int k = 0; k < motions; k++) {
        f->x[MOTIONS[k]] += dt * column[k];
    }
    for (int i = 0; i < f->n; i++) {
        double share[4] = {0};
        for (int k = 0; k < motions; k++) {
            share[k] = by[k][i];
        }
        mean_over_step(a, dt, share);
        for (int k = 0; k < motions; k++) {
            transition[MOTIONS[k]][i] = dt * share[k] + (MOTIONS[k] == i);
        }
    }
    for (int i = 0; i < N * N * N; i++) {
        half[i / N / N][i / N % N] += transition[i / N / N][i % N] * f->p[i % N][i / N % N];
    }
    memset(f->p, 0, sizeof f->p);
    for (int i = 0; i < N * N * N; i++) {
        f->p[i / N / N][i / N % N] += half[i / N / N][i % N] * transition[i / N % N][i % N];
    }
    for (int i = 0; i < f->n; i++) {
        const bool pushed = i == SWAY_STATE_LATERAL_SPEED || i == SWAY_STATE_CAR_YAW_RATE ||
                            i == SWAY_STATE_TRAILER_YAW_RATE;
        f->p[i][i] += wandering(i) * dt * (pushed ? f->road : 1);
    }
}

static bool is_learnt(int state)
{
    return state >= SWAY_STATE_TRAILER_MASS ||
           (state >= SWAY_STATE_CAR_FRONT && state <= SWAY_STATE_RELAXATION);
}

static void take_measured(filter_t *f, const double slope[N], double off, double noise, int which)
{
    const double own = f->acc_power / 8;
    double towards[N] = {0}, s = noise * noise * (1 + own * own);
    for (int i = 0; i < f->n; i++) {
        for (int j = 0; j < f->n; j++) {
            towards[i] += f->p[i][j] * slope[j];
        }
        s += slope[i] * towards[i];
    }
    f->unfit[which] += value(f->car.step_s) / 2 * (off * off / s - f->unfit[which]);
    f->lag[which] += (off - f->lag[which]) / 16;
    const double rough = fmin(31 * f->lag[which] * f->lag[which] / s - 1, 4);
    f->road = fmax(fmin(f->road * (1 + 0.001 * rough), 300), 1.0 / 16);
    s *= pow(fmax(1, f->unfit[which]), 2);
    f->log_likelihood -= (off * off / s + log(s)) / 2;
    for (int i = 0; i < f->n; i++) {
        f->x[i] += towards[i] / s * off * (is_learnt(i) ? f->learning : 1);
        for (int j = 0; j < f->n; j++) {
            f->p[i][j] -=
                towards[i] * towards[j] / s * (is_learnt(i) && is_learnt(j) ? f->learning : 1);
        }
    }
}

static void take_sample_by(filter_t *f, const sample_t *sample)
{
    f->last = f->now;
    f->now = *sample;
    f->log_likelihood = 0;
    double by_acc[N] = {0}, by_yaw[N] = {0}, m[4] = {0}, out[5];
    predict(f, by_acc);
    f->acc_power += value(f->car.step_s) * (sample->acc * sample->acc - f->acc_power);
    by_yaw[SWAY_STATE_CAR_YAW_RATE] = by_yaw[SWAY_STATE_YAW_RATE_OFFSET] = 1;
    take_measured(f, by_yaw,
                  sample->yaw_rate - f->x[SWAY_STATE_CAR_YAW_RATE] -
                      f->x[SWAY_STATE_YAW_RATE_OFFSET],
                  0.002, 0);
    const body_t body = body_by(f);
    const double ratio = value(f->car.ratio);
    for (int k = 0; k < (f->n == N ? 4 : 2); k++) {
        m[k] = f->x[MOTIONS[k]];
    }
    rates_by(f, &body, m, ratio * (sample->wheel + f->x[SWAY_STATE_STEERING_OFFSET]),
             (sample->wheel - f->last.wheel) * ratio / value(f->car.step_s), sample->speed, out);
    by_acc[SWAY_STATE_ACC_OFFSET] = 1;
    take_measured(f, by_acc, sample->acc - out[4] - f->x[SWAY_STATE_ACC_OFFSET], 0.045, 1);
}

static sway_observer_t observer;

static void start_filter(filter_t *f, uint32_t count, double uncertainty)
{
    sway_observer_start_t start;
    memset(&start, 0, sizeof start);
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int i = 0; i < N; i++) {
        start.value[i] = watch.with.x[i];
        start.se[i] = real(uncertainty * value(sway_observer_se(&watch.with, (sway_state_t)i)));
    }
    start.value[SWAY_STATE_LATERAL_SPEED] = real(0.2);
    start.se[SWAY_STATE_LATERAL_SPEED] = real(0.3);
    start.value[SWAY_STATE_CAR_COG] = real(0.05);
    start.value[SWAY_STATE_CAR_REAR] = real(-0.1);
    start.value[SWAY_STATE_FRICTION] = real(1.5);
    start.value[SWAY_STATE_STEERING_OFFSET] = real(0.01);
    memset(&observer, 0x55, sizeof observer);
    sway_observer_init(&observer, &watch.with.car, &start, count);
    memset(f, 0, sizeof *f);
    f->car = watch.with.car;
    f->n = (int)count;
    f->unfit[0] = f->unfit[1] = f->road = 1;
    for (int i = 0; i < f->n; i++) {
        f->x[i] = value(start.value[i]);
        f->p[i][i] = pow(value(start.se[i]), 2);
    }
}

/* The motion starts with the car's yaw rate, also of the trailer. */
static void begin_motion(filter_t *f, const sample_t *sample)
{
    f->now = *sample;
    f->acc_power = sample->acc * sample->acc;
    for (int k = 0; k < (f->n == N ? 4 : 2); k++) {
        for (int i = 0; i < N; i++) {
            f->p[MOTIONS[k]][i] = f->p[i][MOTIONS[k]] = 0;
        }
        f->x[MOTIONS[k]] = k == 1 || k == 2 ? sample->yaw_rate : 0;
        f->p[MOTIONS[k]][MOTIONS[k]] = k == 0 ? 0.09 : 0.0025;
    }
}

static void take_both(filter_t *f, const sample_t *sample)
{
    const sway_observer_sample_t taken = {real(sample->wheel), real(sample->speed),
                                          real(sample->yaw_rate), real(sample->acc)};
    observer.learning = real(f->learning);
    const bool begins = !observer.moving;
    sway_observer_take(&observer, &taken);
    while (sway_observer_cost(&observer) != 0U) {
        sway_observer_run(&observer);
    }
    if (begins) {
        begin_motion(f, sample);
        f->log_likelihood = 0;
    } else {
        take_sample_by(f, sample);
    }
}

static void expect_filter(const filter_t *f, double precision)
{
    for (int i = 0; i < f->n; i++) {
        const double se = sqrt(f->p[i][i]);
        TEST_ASSERT_DOUBLE_WITHIN(precision * se + 1e-8, f->x[i], value(observer.x[i]));
        for (int j = 0; j <= i; j++) {
            const double now = value(sway_observer_covariance(&observer, (uint32_t)i, (uint32_t)j));
            TEST_ASSERT_DOUBLE_WITHIN(precision * se * sqrt(f->p[j][j]), f->p[i][j], now);
        }
    }
    for (int k = 0; k < 2; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(precision * (1 + f->unfit[k]), f->unfit[k],
                                  value(observer.unfit[k]));
        TEST_ASSERT_DOUBLE_WITHIN(precision, f->lag[k], value(observer.lag[k]));
    }
    TEST_ASSERT_DOUBLE_WITHIN(precision * f->road, f->road, value(observer.road));
    TEST_ASSERT_DOUBLE_WITHIN(precision * 10 * (1 + fabs(f->log_likelihood)), f->log_likelihood,
                              value(observer.log_likelihood));
}

static sample_t sample_at(int k, double size)
{
    const sample_t sample = {size * 0.5 * sin(0.12 * k), 25 + 2 * sin(0.05 * k),
                             size * 0.12 * sin(0.12 * k - 0.3) + 0.004 * sin(2.1 * k),
                             size * 3 * sin(0.12 * k - 0.4) + 0.05 * cos(1.7 * k)};
    return sample;
}

static void follow_filter(uint32_t count, double uncertainty, double size, int samples,
                          double precision)
{
    filter_t f;
    start_filter(&f, count, uncertainty);
    expect_filter(&f, 1e-7);
    for (int k = 0; k < samples; k++) {
        const sample_t sample = sample_at(k, size);
        f.learning = k % 3 == 0 ? 0 : 0.125;
        take_both(&f, &sample);
        expect_filter(&f, precision);
        if (k == samples / 2) { /* what was learnt is kept over a pause, the motion is not */
            sway_observer_pause(&observer);
            TEST_ASSERT_EQUAL(0, sway_observer_cost(&observer));
        }
    }
}

static void the_observer_is_the_filter_of_its_equations(void)
{
    follow_filter(SWAY_STATE_COUNT, 1, 1, 40, 1e-4);
    follow_filter(SWAY_STATE_COUNT, 1, 0.3, 40, 1e-4);
    follow_filter(SWAY_STATE_SOLO, 1, 1, 40, 1e-4);
}

/* Where all is certain at the start, the uncertainty is that of what has wandered. */
static void what_is_certain_wanders(void)
{
    follow_filter(SWAY_STATE_COUNT, 0, 0.2, 4, 1e-5);
    follow_filter(SWAY_STATE_SOLO, 0, 0.2, 4, 1e-5);
}

/* Estimates are kept where cars and trailers are: brought back just to the bound, and what varies
 * with them moves along. What starts beyond a bound is not. */
static void estimates_are_brought_back_to_their_bounds(void)
{
    static const struct {
        sway_state_t state;
        double low, high;
    } bounds[] = {
        {SWAY_STATE_CAR_FRONT, -0.7, 0.7},
        {SWAY_STATE_CAR_REAR, -0.7, 0.7},
        {SWAY_STATE_CAR_INERTIA, -0.4, 0.4},
        {SWAY_STATE_CAR_COG, -0.3, 0.3},
        {SWAY_STATE_RELAXATION, 0, 0.8},
        {SWAY_STATE_TRAILER_MASS, 4.605, 9.21},
        {SWAY_STATE_TRAILER_LENGTH, 0.182, 2.303},
        {SWAY_STATE_TRAILER_GYRATION, -3.507, -0.357},
        {SWAY_STATE_TRAILER_STIFFNESS, 1.386, 3.401},
        {SWAY_STATE_TRAILER_AXLE, -0.5, 1},
        {SWAY_STATE_FRICTION, -1, 6},
    };
    const sway_observer_sample_t sample = {real(0), real(25), real(0), real(0)};
    sway_observer_start_t start;
    memset(&start, 0, sizeof start);
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    for (int b = 0; b < 22; b++) {
        const int own = bounds[b / 2].state;
        const double off = b % 2 == 0 ? -0.2 : 0.2;
        const double bound = b % 2 == 0 ? bounds[b / 2].low : bounds[b / 2].high;
        for (int beyond = 0; beyond < 2; beyond++) {
            for (int i = 0; i < N; i++) {
                start.value[i] = watch.with.x[i];
                start.se[i] = real(0.03);
            }
            start.se[own] = real(0.0012); /* a variance of 1.44e-6 */
            start.value[own] = real(beyond != 0 ? bound + off : bound);
            sway_observer_init(&observer, &watch.with.car, &start, N);
            TEST_ASSERT_EQUAL(beyond != 0, observer.unbound != 0U);
            sway_observer_take(&observer, &sample);
            sway_observer_take(&observer, &sample);
            while (observer.step != 7) { /* the last one: nothing is learnt before */
                sway_observer_run(&observer);
            }
            const int other = own == SWAY_STATE_LATERAL_SPEED + 5 ? 6 : 5;
            const int high = own > other ? own : other, low = own > other ? other : own;
            observer.x[own] = real(bound + off);
            observer.p[high * (high + 1) / 2 + low] = real(3e-6);
            observer.p[own * (own + 1) / 2] = real(-2e-6); /* with the first */
            const double variance =
                value(sway_observer_covariance(&observer, (uint32_t)own, (uint32_t)own));
            const double before = value(observer.x[other]), first = value(observer.x[0]);
            const double with_first = value(sway_observer_covariance(&observer, (uint32_t)own, 0));
            sway_observer_run(&observer);
            TEST_ASSERT_EQUAL(0, sway_observer_cost(&observer));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, beyond != 0 ? bound + off : bound,
                                      value(observer.x[own]));
            const double moved = beyond != 0 ? 0 : -off / variance;
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, before + moved * 3e-6, value(observer.x[other]));
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, first + moved * with_first, value(observer.x[0]));
        }
    }
}

static void a_car_alone_has_nothing_of_a_trailer(void)
{
    sway_observer_body_t body;
    sway_single_track_t models[2];
    filter_t f;
    start_filter(&f, SWAY_STATE_SOLO, 1);
    for (int k = 0; k < 5; k++) {
        const sample_t sample = sample_at(k, 1);
        take_both(&f, &sample);
        for (int i = 0; i < N; i++) {
            TEST_ASSERT_EQUAL_DOUBLE(
                0, value(sway_observer_covariance(&observer, SWAY_STATE_SOLO, (uint32_t)i)));
        }
    }
    memset(&body, 0x55, sizeof body);
    sway_observer_body(&observer, &body);
    TEST_ASSERT_TRUE(sway_real_is_zero(body.mass_kg) && sway_real_is_zero(body.length_m));
    TEST_ASSERT_TRUE(sway_real_is_zero(body.axle_m) && sway_real_is_zero(body.friction_nm));
    TEST_ASSERT_TRUE(sway_real_is_zero(body.trailer_inertia_kgm2));
    TEST_ASSERT_TRUE(sway_real_is_zero(body.trailer_n_per_rad));
    memset(&models[0], 0x55, sizeof models[0]);
    memset(&models[1], 0, sizeof models[1]);
    for (int k = 0; k < 2; k++) { /* nothing of a model before is left in it */
        sway_observer_model(&observer, &body, &models[k]);
    }
    TEST_ASSERT_EQUAL_MEMORY(&models[1], &models[0], sizeof models[0]);
}

static int slices_left(void)
{
    int slices = 0;
    for (; sway_observer_cost(&observer) != 0U; slices++) {
        sway_observer_run(&observer);
    }
    return slices;
}

/* A sample that comes before the last one is done with, or a pause, takes its place. */
static void work_that_is_not_done_is_given_up(void)
{
    const sway_observer_sample_t sample = {real(0), real(25), real(0), real(0)};
    filter_t f;
    start_filter(&f, SWAY_STATE_COUNT, 1);
    sway_observer_take(&observer, &sample);
    TEST_ASSERT_EQUAL(0, slices_left());
    sway_observer_take(&observer, &sample);
    const int all = slices_left();
    TEST_ASSERT_TRUE(all > N);
    sway_observer_take(&observer, &sample);
    for (int k = 0; k < 5; k++) {
        sway_observer_run(&observer);
    }
    sway_observer_take(&observer, &sample);
    TEST_ASSERT_EQUAL(all, slices_left());
    sway_observer_take(&observer, &sample);
    sway_observer_run(&observer);
    sway_observer_pause(&observer);
    TEST_ASSERT_EQUAL(0, slices_left());
    sway_observer_take(&observer, &sample);
    TEST_ASSERT_EQUAL(0, slices_left());
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
    RUN_TEST(the_observer_is_the_filter_of_its_equations);
    RUN_TEST(what_is_certain_wanders);
    RUN_TEST(estimates_are_brought_back_to_their_bounds);
    RUN_TEST(a_car_alone_has_nothing_of_a_trailer);
    RUN_TEST(work_that_is_not_done_is_given_up);
    return UNITY_END();
}

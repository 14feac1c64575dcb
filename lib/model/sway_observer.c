// SPDX-License-Identifier: MIT
#include "model/sway_observer.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* Standard errors of one sample (a mean of rows): production sensors, 0.11 deg/s and
 * 0.045 m/s2. */
#define YAW_RATE_SE_URAD_S 2000
#define ACC_SE_UM_S2 45000

/* What road and wind do to the motion, as variance per second: lateral speed (m/s)^2/s, yaw rates
 * (rad/s)^2/s, here on a usual road, times what the innovations say of the present one; and how
 * offsets and parameters wander. Millionths, parameters 1e-9. */
#define WANDER_LATERAL 1500
#define WANDER_YAW 150
#define WANDER_YAW_OFFSET_NANO 10
#define WANDER_ACC_OFFSET 10
#define WANDER_STEERING_NANO 100
#define WANDER_PARAMETER_NANO 1

/* How the road is followed. A mean of 16 innovations has 1/31 of their variance where they are
 * white; of wind and swaths of road it has more, and by so much the road is taken to be larger, a
 * thousandth of it with each innovation (30 s), in bounds. */
#define LAG_SHIFT 4
#define LAG_WHITE 31
#define ROAD_SHARE_PPM 1000
#define ROAD_STEP_MOST 4
#define ROAD_MOST 300
#define ROAD_LEAST_SHIFT (-4)

/* Start of the motion: m/s, rad/s, rad. */
#define START_LATERAL_PPM 300000
#define START_RATE_PPM 50000

/* Acceleration in m/s2, mean square, whose peak is where tyres leave the linear range (4 m/s2). */
#define LINEAR_POWER 8

/* Dry friction has its sign at articulation rates above this, rad/s. */
#define FRICTION_RATE_PPM 10000

/* Step of the differences: 2^-10 of the unit. */
#define DIFFERENCE (-10)

enum {
    STEP_IDLE,
    STEP_COLUMNS,
    STEP_MOVE,
    STEP_SPREAD,
    STEP_COVARIANCE,
    STEP_YAW,
    STEP_ACC,
    STEP_KEEP
};

/* Rows of `by`. */
enum { ROWS_OF_MOTION = 4, ROW_ACC = 4 };
static const uint8_t MOTION[ROWS_OF_MOTION] = {SWAY_STATE_LATERAL_SPEED, SWAY_STATE_CAR_YAW_RATE,
                                               SWAY_STATE_TRAILER_YAW_RATE,
                                               SWAY_STATE_ARTICULATION};

static uint32_t place(uint32_t a, uint32_t b)
{
    return a >= b ? a * (a + 1U) / 2U + b : b * (b + 1U) / 2U + a;
}

static sway_real_t one(void)
{
    return sway_real_int(1);
}

static bool has_trailer(const sway_observer_t *observer)
{
    return observer->count > SWAY_STATE_SOLO;
}

static uint32_t motions(const sway_observer_t *observer)
{
    return has_trailer(observer) ? ROWS_OF_MOTION : 2U;
}

/* --- what the states stand for ---------------------------------------------------------------- */

static sway_real_t grown(sway_real_t value, sway_real_t logarithm)
{
    return MUL(value, sway_real_exp(logarithm));
}

void sway_observer_body(const sway_observer_t *observer, sway_observer_body_t *body)
{
    const sway_observer_car_t *const car = &observer->car;
    const sway_real_t *const x = observer->x;
    memset(body, 0, sizeof *body);
    body->front_n_per_rad = grown(car->front_n_per_rad, x[SWAY_STATE_CAR_FRONT]);
    body->rear_n_per_rad = grown(car->rear_n_per_rad, x[SWAY_STATE_CAR_REAR]);
    body->inertia_kgm2 = grown(car->inertia_kgm2, x[SWAY_STATE_CAR_INERTIA]);
    body->cog_m = x[SWAY_STATE_CAR_COG];
    body->relaxation_m = x[SWAY_STATE_RELAXATION];
    if (!has_trailer(observer)) {
        return;
    }
    body->mass_kg = sway_real_exp(x[SWAY_STATE_TRAILER_MASS]);
    body->length_m = sway_real_exp(x[SWAY_STATE_TRAILER_LENGTH]);
    body->trailer_inertia_kgm2 =
        grown(MUL(body->mass_kg, sway_real_square(body->length_m)), x[SWAY_STATE_TRAILER_GYRATION]);
    body->trailer_n_per_rad =
        grown(MUL(body->mass_kg, sway_real_ratio(981, 100)), x[SWAY_STATE_TRAILER_STIFFNESS]);
    body->axle_m = x[SWAY_STATE_TRAILER_AXLE];
    body->friction_nm = MUL(x[SWAY_STATE_FRICTION], sway_real_int(100));
}

static void grow(sway_real_t *value, sway_real_t step)
{
    *value = ADD(*value, MUL(*value, step));
}

void sway_observer_move(sway_observer_body_t *body, sway_state_t state, sway_real_t step)
{
    switch (state) {
    case SWAY_STATE_CAR_FRONT:
        grow(&body->front_n_per_rad, step);
        break;
    case SWAY_STATE_CAR_REAR:
        grow(&body->rear_n_per_rad, step);
        break;
    case SWAY_STATE_CAR_INERTIA:
        grow(&body->inertia_kgm2, step);
        break;
    case SWAY_STATE_CAR_COG:
        body->cog_m = ADD(body->cog_m, step);
        break;
    case SWAY_STATE_RELAXATION:
        body->relaxation_m = ADD(body->relaxation_m, step);
        break;
    case SWAY_STATE_TRAILER_MASS:
        grow(&body->mass_kg, step);
        grow(&body->trailer_inertia_kgm2, step);
        grow(&body->trailer_n_per_rad, step);
        break;
    case SWAY_STATE_TRAILER_LENGTH:
        grow(&body->length_m, step);
        grow(&body->trailer_inertia_kgm2, step);
        grow(&body->trailer_inertia_kgm2, step);
        break;
    case SWAY_STATE_TRAILER_GYRATION:
        grow(&body->trailer_inertia_kgm2, step);
        break;
    case SWAY_STATE_TRAILER_STIFFNESS:
        grow(&body->trailer_n_per_rad, step);
        break;
    case SWAY_STATE_TRAILER_AXLE:
        body->axle_m = ADD(body->axle_m, step);
        break;
    case SWAY_STATE_FRICTION:
        body->friction_nm = ADD(body->friction_nm, MUL(step, sway_real_int(100)));
        break;
    default:
        break;
    }
}

void sway_observer_model(const sway_observer_t *observer, const sway_observer_body_t *body,
                         sway_single_track_t *stm)
{
    const sway_observer_car_t *const car = &observer->car;
    memset(stm, 0, sizeof *stm);
    sway_single_track_body_t *const front = &stm->body[SWAY_SINGLE_TRACK_CAR];
    front->mass_kg = car->mass_kg;
    front->yaw_inertia_kgm2 = body->inertia_kgm2;
    front->axle_m[0] = SUB(car->front_m, body->cog_m);
    front->axle_m[1] = NEG(ADD(car->rear_m, body->cog_m));
    front->hitch_m = NEG(ADD(car->hitch_m, body->cog_m));
    front->stiffness_n_per_rad[0] = body->front_n_per_rad;
    front->stiffness_n_per_rad[1] = body->rear_n_per_rad;
    stm->has_trailer = has_trailer(observer);
    if (!stm->has_trailer) {
        return;
    }
    sway_single_track_body_t *const trailer = &stm->body[SWAY_SINGLE_TRACK_TRAILER];
    const sway_real_t half = sway_real_scale(body->trailer_n_per_rad, -1);
    trailer->mass_kg = body->mass_kg;
    trailer->yaw_inertia_kgm2 = body->trailer_inertia_kgm2;
    trailer->hitch_m = body->length_m;
    trailer->axle_m[0] = SUB(car->half_tandem_m, body->axle_m);
    trailer->axle_m[1] = NEG(ADD(car->half_tandem_m, body->axle_m));
    trailer->stiffness_n_per_rad[0] = half;
    trailer->stiffness_n_per_rad[1] = half;
}

/* --- equations of motion ---------------------------------------------------------------------- */

/* Motion and inputs of one evaluation. */
typedef struct {
    sway_real_t lateral;
    sway_real_t yaw;
    sway_real_t trailer_yaw;
    sway_real_t articulation;
    sway_real_t steer;    ///< at the road wheel
    sway_real_t steering; ///< its rate
    sway_real_t speed;
    sway_real_t by_speed;
} motion_t;

static motion_t motion_of(const sway_observer_t *observer, sway_real_t wheel, sway_real_t speed)
{
    const sway_real_t *const x = observer->x;
    const sway_real_t turned =
        SUB(observer->now.steering_wheel_rad, observer->last.steering_wheel_rad);
    const motion_t m = {x[SWAY_STATE_LATERAL_SPEED],
                        x[SWAY_STATE_CAR_YAW_RATE],
                        x[SWAY_STATE_TRAILER_YAW_RATE],
                        x[SWAY_STATE_ARTICULATION],
                        MUL(ADD(wheel, x[SWAY_STATE_STEERING_OFFSET]), observer->car.ratio),
                        DIV(MUL(turned, observer->car.ratio), observer->car.step_s),
                        speed,
                        DIV(one(), speed)};
    return m;
}

static void move_motion(const sway_observer_t *observer, motion_t *m, uint32_t state,
                        sway_real_t step)
{
    switch (state) {
    case SWAY_STATE_LATERAL_SPEED:
        m->lateral = ADD(m->lateral, step);
        break;
    case SWAY_STATE_CAR_YAW_RATE:
        m->yaw = ADD(m->yaw, step);
        break;
    case SWAY_STATE_TRAILER_YAW_RATE:
        m->trailer_yaw = ADD(m->trailer_yaw, step);
        break;
    case SWAY_STATE_ARTICULATION:
        m->articulation = ADD(m->articulation, step);
        break;
    case SWAY_STATE_STEERING_OFFSET:
        m->steer = ADD(m->steer, MUL(step, observer->car.ratio));
        break;
    default:
        break;
    }
}

/* What an axle of tyres holds at the slip whose force were `linear`: less, the nearer its peak. */
static sway_real_t held(sway_real_t linear, sway_real_t peak)
{
    const sway_real_t share = sway_real_square(DIV(linear, peak));
    return DIV(linear, ADD(one(), DIV(share, sway_real_int(3))));
}

/* Slips of the axles: front, rear, trailer; or how fast they change. */
typedef struct {
    sway_real_t of[3];
} slips_t;

/* Forces of the trailer: on its tyres, and the moments on it about its COG beside that of H. */
typedef struct {
    sway_real_t tyres;
    sway_real_t turning;  ///< of the tyres, a tandem's own damping, and the friction
    sway_real_t friction; ///< on the car
} trailer_forces_t;

static trailer_forces_t trailer_forces(const sway_observer_t *observer,
                                       const sway_observer_body_t *b, const motion_t *m,
                                       sway_real_t slip)
{
    trailer_forces_t f;
    const sway_real_t opening = SUB(m->trailer_yaw, m->yaw);
    const sway_real_t spread = sway_real_square(observer->car.half_tandem_m);
    const sway_real_t small = sway_real_square(sway_real_micro(FRICTION_RATE_PPM));
    f.tyres = held(MUL(b->trailer_n_per_rad, slip), MUL(b->mass_kg, sway_real_ratio(981, 100)));
    f.friction =
        DIV(MUL(b->friction_nm, opening), sway_real_sqrt(ADD(sway_real_square(opening), small)));
    const sway_real_t scrub =
        MUL(MUL(b->trailer_n_per_rad, spread), MUL(m->trailer_yaw, m->by_speed));
    f.turning = NEG(ADD(MUL(b->axle_m, f.tyres), ADD(f.friction, scrub)));
    return f;
}

/* What the slips come from: motion, or its rates. */
typedef struct {
    sway_real_t lateral;
    sway_real_t yaw;
    sway_real_t trailer_yaw;
    sway_real_t steer;
    sway_real_t articulation;
} sideways_t;

/* From the COG as it is: to the front axle, the rear axle and the ball. */
typedef struct {
    sway_real_t front_m;
    sway_real_t rear_m;
    sway_real_t hitch_m;
} levers_t;

/* Sideways speeds of the axles (of rates: accelerations) by the forward speed, turned. */
static void slips_of(const sway_observer_t *observer, const sway_observer_body_t *b,
                     const levers_t *l, const sideways_t *s, sway_real_t by_v, slips_t *slips)
{
    const sway_real_t at_front = ADD(s->lateral, MUL(l->front_m, s->yaw));
    const sway_real_t at_rear = SUB(s->lateral, MUL(l->rear_m, s->yaw));
    slips->of[0] = SUB(s->steer, MUL(at_front, by_v));
    slips->of[1] = NEG(MUL(at_rear, by_v));
    slips->of[2] = sway_real_zero();
    if (has_trailer(observer)) {
        const sway_real_t at_ball = SUB(s->lateral, MUL(l->hitch_m, s->yaw));
        const sway_real_t across = SUB(at_ball, MUL(ADD(b->length_m, b->axle_m), s->trailer_yaw));
        slips->of[2] = SUB(s->articulation, MUL(across, by_v));
    }
}

/* Rates of the four states of motion, and what the accelerometer reads, for given slips. */
static void rates_at(const sway_observer_t *observer, const sway_observer_body_t *b,
                     const levers_t *l, const motion_t *m, const slips_t *slips, sway_real_t *out)
{
    const sway_observer_car_t *const car = &observer->car;
    const sway_real_t by_inertia = DIV(one(), b->inertia_kgm2);
    const sway_real_t by_mass = DIV(one(), car->mass_kg);
    const sway_real_t front = held(MUL(b->front_n_per_rad, slips->of[0]), car->peak_n[0]);
    const sway_real_t rear = held(MUL(b->rear_n_per_rad, slips->of[1]), car->peak_n[1]);
    sway_real_t side = ADD(front, rear);
    sway_real_t turn = SUB(MUL(l->front_m, front), MUL(l->rear_m, rear));
    out[2] = sway_real_zero();
    out[3] = sway_real_zero();
    if (has_trailer(observer)) {
        const trailer_forces_t f = trailer_forces(observer, b, m, slips->of[2]);
        const sway_real_t by_trailer = DIV(one(), b->mass_kg);
        const sway_real_t lever = DIV(b->length_m, b->trailer_inertia_kgm2);
        turn = ADD(turn, f.friction);
        /* The ball accelerates alike on both sides: that gives H. */
        const sway_real_t yielding =
            ADD(ADD(by_mass, by_trailer),
                ADD(MUL(sway_real_square(l->hitch_m), by_inertia), MUL(b->length_m, lever)));
        const sway_real_t apart =
            ADD(SUB(MUL(f.tyres, by_trailer), MUL(side, by_mass)),
                ADD(MUL(MUL(l->hitch_m, turn), by_inertia), MUL(lever, f.turning)));
        const sway_real_t hitch = DIV(apart, yielding);
        side = ADD(side, hitch);
        turn = SUB(turn, MUL(l->hitch_m, hitch));
        out[2] = SUB(DIV(f.turning, b->trailer_inertia_kgm2), MUL(lever, hitch));
        out[3] = SUB(m->trailer_yaw, m->yaw);
    }
    const sway_real_t acc = MUL(side, by_mass);
    out[1] = MUL(turn, by_inertia);
    out[0] = SUB(acc, MUL(m->speed, m->yaw));
    out[ROW_ACC] = ADD(acc, MUL(ADD(car->acc_m, b->cog_m), out[1]));
}

/* The same with tyres that have to roll until their force follows the slip: it is that of the slip
 * a relaxation length before, at the rate at which the slip changes where they follow at once. */
static void rates(const sway_observer_t *observer, const sway_observer_body_t *b, const motion_t *m,
                  sway_real_t *out)
{
    const sway_observer_car_t *const car = &observer->car;
    const levers_t levers = {SUB(car->front_m, b->cog_m), ADD(car->rear_m, b->cog_m),
                             ADD(car->hitch_m, b->cog_m)};
    const sway_real_t late_s = MUL(b->relaxation_m, m->by_speed);
    sideways_t from = {m->lateral, m->yaw, m->trailer_yaw, m->steer, m->articulation};
    slips_t slips = {{sway_real_zero(), sway_real_zero(), sway_real_zero()}};
    for (uint32_t round = 0; round < 2U; round++) {
        slips_t found;
        slips_of(observer, b, &levers, &from, m->by_speed, &found);
        for (uint32_t i = 0; i < 3U; i++) {
            slips.of[i] = round == 0U ? found.of[i] : SUB(slips.of[i], MUL(late_s, found.of[i]));
        }
        rates_at(observer, b, &levers, m, &slips, out);
        from = (sideways_t){out[0], out[1], out[2], m->steering, out[3]};
    }
}

/* --- what can be ------------------------------------------------------------------------------ */

/* Beyond these there are no cars and trailers: noise is being explained. Car: stiffnesses by a
 * factor of 2, inertia of 1.5, centre of gravity 0.3 m; trailer of 100 to 10,000 kg, 1.2 to 10 m
 * from the ball to its centre of gravity, I / (m l^2) 0.03 to 0.7, stiffness 4 to 30 times the
 * weight, axle -0.5 to 1 m behind it, friction 0 to 600 Nm. In the units of the states. */
static const struct {
    uint8_t state;
    int32_t low_ppm;
    int32_t high_ppm;
} BOUNDS[] = {
    {SWAY_STATE_CAR_FRONT, -700000, 700000},
    {SWAY_STATE_CAR_REAR, -700000, 700000},
    {SWAY_STATE_CAR_INERTIA, -400000, 400000},
    {SWAY_STATE_CAR_COG, -300000, 300000},
    {SWAY_STATE_RELAXATION, 0, 800000},
    {SWAY_STATE_TRAILER_MASS, 4605000, 9210000},
    {SWAY_STATE_TRAILER_LENGTH, 182000, 2303000},
    {SWAY_STATE_TRAILER_GYRATION, -3507000, -357000},
    {SWAY_STATE_TRAILER_STIFFNESS, 1386000, 3401000},
    {SWAY_STATE_TRAILER_AXLE, -500000, 1000000},
    {SWAY_STATE_FRICTION, -1000000, 6000000},
};
enum { BOUND_COUNT = sizeof BOUNDS / sizeof BOUNDS[0] };

/* How far it is from an estimate back to its bound; 0 inside. */
static sway_real_t beyond(const sway_observer_t *observer, uint32_t bound)
{
    const uint32_t state = BOUNDS[bound].state;
    if (state >= observer->count) {
        return sway_real_zero();
    }
    const sway_real_t x = observer->x[state];
    const sway_real_t above = sway_real_max(x, sway_real_micro(BOUNDS[bound].low_ppm));
    return SUB(sway_real_min(above, sway_real_micro(BOUNDS[bound].high_ppm)), x);
}

/* What the user states beyond a bound is not kept by it. */
static void find_unbound(sway_observer_t *observer)
{
    for (uint32_t k = 0; k < BOUND_COUNT; k++) {
        if (!sway_real_is_zero(beyond(observer, k))) {
            observer->unbound |= (uint16_t)(1U << k);
        }
    }
}

/* Moves an estimate, and the others as their covariance says. */
static void pull(sway_observer_t *observer, uint32_t state, sway_real_t off)
{
    const sway_real_t variance = observer->p[place(state, state)];
    const sway_real_t by_variance = DIV(off, sway_real_max(variance, sway_real_micro(1)));
    for (uint32_t i = 0; i < observer->count; i++) {
        observer->x[i] = ADD(observer->x[i], MUL(observer->p[place(i, state)], by_variance));
    }
}

/* Brings estimates back to their bounds. Nothing counts as better known for it. */
static bool step_keep(sway_observer_t *observer)
{
    for (uint32_t k = 0; k < BOUND_COUNT; k++) {
        const sway_real_t off = beyond(observer, k);
        if (!sway_real_is_zero(off) && (observer->unbound & (1U << k)) == 0U) {
            pull(observer, BOUNDS[k].state, off);
        }
    }
    return true;
}

/* --- start ------------------------------------------------------------------------------------ */

static void set_alone(sway_observer_t *observer, uint32_t state, sway_real_t value,
                      sway_real_t variance)
{
    for (uint32_t i = 0; i < observer->count; i++) {
        observer->p[place(state, i)] = sway_real_zero();
    }
    observer->x[state] = value;
    observer->p[place(state, state)] = variance;
}

void sway_observer_init(sway_observer_t *observer, const sway_observer_car_t *car,
                        const sway_observer_start_t *start, uint32_t count)
{
    memset(observer, 0, sizeof *observer);
    observer->count = (uint8_t)count;
    observer->car = *car;
    for (uint32_t i = 0; i < count; i++) {
        set_alone(observer, i, start->value[i], sway_real_square(start->se[i]));
    }
    observer->unfit[0] = one();
    observer->unfit[1] = one();
    observer->road = one();
    find_unbound(observer);
}

void sway_observer_pause(sway_observer_t *observer)
{
    observer->moving = false;
    observer->step = STEP_IDLE;
}

static void start_motion(sway_observer_t *observer)
{
    for (uint32_t k = 0; k < motions(observer); k++) {
        const int32_t se = k == 0U ? START_LATERAL_PPM : START_RATE_PPM;
        set_alone(observer, MOTION[k], sway_real_zero(), sway_real_square(sway_real_micro(se)));
    }
    observer->x[SWAY_STATE_CAR_YAW_RATE] = observer->now.yaw_rate_rad_s;
    observer->x[SWAY_STATE_TRAILER_YAW_RATE] = observer->now.yaw_rate_rad_s;
    observer->acc_power = sway_real_square(observer->now.acc_m_s2);
    observer->moving = true;
}

void sway_observer_take(sway_observer_t *observer, const sway_observer_sample_t *sample)
{
    observer->last = observer->now;
    observer->now = *sample;
    observer->log_likelihood = sway_real_zero();
    if (!observer->moving) {
        start_motion(observer);
        return;
    }
    observer->step = STEP_COLUMNS;
    observer->column = 0;
}

/* --- from one sample to the next -------------------------------------------------------------- */

static sway_real_t middle(sway_real_t a, sway_real_t b)
{
    return sway_real_scale(ADD(a, b), -1);
}

static motion_t motion_between(const sway_observer_t *observer)
{
    return motion_of(observer,
                     middle(observer->now.steering_wheel_rad, observer->last.steering_wheel_rad),
                     middle(observer->now.speed_m_s, observer->last.speed_m_s));
}

/* Derivatives of the rates with respect to one state. */
static void one_column(sway_observer_t *observer, uint32_t state)
{
    const sway_real_t step = sway_real_scale(one(), DIFFERENCE);
    sway_real_t base[5];
    sway_real_t moved[5];
    sway_observer_body_t body = observer->body;
    motion_t m = motion_between(observer);
    memcpy(base, observer->rate, sizeof observer->rate);
    base[ROW_ACC] = observer->scratch[0][0];
    move_motion(observer, &m, state, step);
    sway_observer_move(&body, (sway_state_t)state, step);
    rates(observer, &body, &m, moved);
    for (uint32_t k = 0; k <= ROW_ACC; k++) {
        observer->by[k][state] = sway_real_scale(SUB(moved[k], base[k]), -DIFFERENCE);
    }
}

static bool is_offset(uint32_t state)
{
    return state == SWAY_STATE_YAW_RATE_OFFSET || state == SWAY_STATE_ACC_OFFSET;
}

static bool step_column(sway_observer_t *observer)
{
    const uint32_t state = observer->column;
    if (state == 0U) {
        sway_real_t all[5];
        const motion_t m = motion_between(observer);
        sway_observer_body(observer, &observer->body);
        rates(observer, &observer->body, &m, all);
        memcpy(observer->rate, all, sizeof observer->rate);
        observer->scratch[0][0] = all[ROW_ACC];
    }
    if (is_offset(state)) {
        for (uint32_t k = 0; k <= ROW_ACC; k++) {
            observer->by[k][state] = sway_real_zero();
        }
    } else {
        one_column(observer, state);
    }
    return state + 1U == observer->count;
}

/* y = b + dt/2 A (b + dt/3 A b): the mean of a rate over the step, exact to the third order. */
static void over_step(const sway_real_t a[4][4], uint32_t n, sway_real_t dt, sway_real_t *b)
{
    sway_real_t inner[4];
    memcpy(inner, b, sizeof inner);
    for (int32_t order = 3; order >= 2; order--) {
        sway_real_t next[4] = {{0, 0}};
        const sway_real_t share = DIV(dt, sway_real_int(order));
        for (uint32_t i = 0; i < n; i++) {
            sway_real_t sum = sway_real_zero();
            for (uint32_t k = 0; k < n; k++) {
                sum = ADD(sum, MUL(a[i][k], inner[k]));
            }
            next[i] = ADD(b[i], MUL(share, sum));
        }
        memcpy(inner, next, sizeof inner);
    }
    memcpy(b, inner, sizeof inner);
}

/* Moves the state and makes the transition of the derivatives, in their place. */
static bool step_move(sway_observer_t *observer)
{
    const uint32_t n = motions(observer);
    const sway_real_t dt = observer->car.step_s;
    sway_real_t a[4][4];
    sway_real_t column[4] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t k = 0; k < n; k++) {
            a[i][k] = observer->by[i][MOTION[k]];
        }
    }
    memcpy(column, observer->rate, sizeof column);
    over_step((const sway_real_t(*)[4])a, n, dt, column);
    for (uint32_t k = 0; k < n; k++) {
        observer->x[MOTION[k]] = ADD(observer->x[MOTION[k]], MUL(dt, column[k]));
    }
    for (uint32_t state = 0; state < observer->count; state++) {
        for (uint32_t k = 0; k < n; k++) {
            column[k] = observer->by[k][state];
        }
        over_step((const sway_real_t(*)[4])a, n, dt, column);
        for (uint32_t k = 0; k < n; k++) {
            observer->by[k][state] =
                ADD(MUL(dt, column[k]), sway_real_int(MOTION[k] == state ? 1 : 0));
        }
    }
    return true;
}

/* One row of transition times covariance. */
static bool step_spread(sway_observer_t *observer)
{
    const uint32_t k = observer->column;
    for (uint32_t j = 0; j < observer->count; j++) {
        sway_real_t sum = sway_real_zero();
        for (uint32_t i = 0; i < observer->count; i++) {
            if (!is_offset(i)) {
                sum = ADD(sum, MUL(observer->by[k][i], observer->p[place(i, j)]));
            }
        }
        observer->scratch[k][j] = sum;
    }
    return k + 1U == motions(observer);
}

static sway_real_t wander(uint32_t state)
{
    switch (state) {
    case SWAY_STATE_LATERAL_SPEED:
        return sway_real_micro(WANDER_LATERAL);
    case SWAY_STATE_CAR_YAW_RATE:
    case SWAY_STATE_TRAILER_YAW_RATE:
        return sway_real_micro(WANDER_YAW);
    case SWAY_STATE_ARTICULATION:
        return sway_real_zero();
    case SWAY_STATE_ACC_OFFSET:
        return sway_real_micro(WANDER_ACC_OFFSET);
    case SWAY_STATE_YAW_RATE_OFFSET:
        return DIV(sway_real_micro(WANDER_YAW_OFFSET_NANO), sway_real_int(1000));
    case SWAY_STATE_STEERING_OFFSET:
        return DIV(sway_real_micro(WANDER_STEERING_NANO), sway_real_int(1000));
    default:
        return DIV(sway_real_micro(WANDER_PARAMETER_NANO), sway_real_int(1000));
    }
}

/* By road and wind. */
static bool is_pushed(uint32_t state)
{
    return state == SWAY_STATE_LATERAL_SPEED || state == SWAY_STATE_CAR_YAW_RATE ||
           state == SWAY_STATE_TRAILER_YAW_RATE;
}

static bool step_covariance(sway_observer_t *observer)
{
    const uint32_t n = motions(observer);
    for (uint32_t k = 0; k < n; k++) {
        for (uint32_t j = 0; j < observer->count; j++) {
            observer->p[place(MOTION[k], j)] = observer->scratch[k][j];
        }
    }
    for (uint32_t k = 0; k < n; k++) { // both ways moved: those of motion with each other
        for (uint32_t q = 0; q <= k; q++) {
            sway_real_t sum = sway_real_zero();
            for (uint32_t j = 0; j < observer->count; j++) {
                sum = ADD(sum, MUL(observer->scratch[k][j], observer->by[q][j]));
            }
            observer->p[place(MOTION[k], MOTION[q])] = sum;
        }
    }
    for (uint32_t i = 0; i < observer->count; i++) {
        sway_real_t *const variance = &observer->p[place(i, i)];
        const sway_real_t by = MUL(wander(i), observer->car.step_s);
        *variance = ADD(*variance, is_pushed(i) ? MUL(by, observer->road) : by);
    }
    return true;
}

/* --- corrections ------------------------------------------------------------------------------ */

/* Two-second mean of what innovations are against what they should be: where physics is missing it
 * grows above 1, and the measurement counts for less, by its square: what is left is not white. */
static void follow_unfit(sway_observer_t *observer, uint32_t which, sway_real_t against)
{
    const sway_real_t share = sway_real_scale(observer->car.step_s, -1);
    sway_real_t *const unfit = &observer->unfit[which];
    *unfit = ADD(*unfit, MUL(share, SUB(against, *unfit)));
}

/* How rough the road is and how strong the wind: as much as slow innovations are larger than those
 * of a filter that knows. */
static void follow_road(sway_observer_t *observer, uint32_t which, sway_real_t off,
                        sway_real_t variance)
{
    sway_real_t *const lag = &observer->lag[which];
    *lag = ADD(*lag, sway_real_scale(SUB(off, *lag), -LAG_SHIFT));
    const sway_real_t against =
        DIV(MUL(sway_real_square(*lag), sway_real_int(LAG_WHITE)), variance);
    const sway_real_t step = sway_real_min(SUB(against, one()), sway_real_int(ROAD_STEP_MOST));
    const sway_real_t road =
        ADD(observer->road, MUL(MUL(observer->road, step), sway_real_micro(ROAD_SHARE_PPM)));
    const sway_real_t least = sway_real_scale(one(), ROAD_LEAST_SHIFT);
    observer->road = sway_real_max(sway_real_min(road, sway_real_int(ROAD_MOST)), least);
}

static bool is_parameter(uint32_t state)
{
    return state >= SWAY_STATE_TRAILER_MASS ||
           (state >= SWAY_STATE_CAR_FRONT && state < SWAY_STATE_SOLO);
}

/* Takes a measurement that has `slope` by the states, `off` from what was expected. Of what it
 * tells of the parameters the share `learning` is taken, of value and uncertainty alike: errors of
 * the model and of the road last for several samples, which tell the same. While nothing is learnt
 * parameters keep both (Schmidt's form of the filter: their uncertainty still counts for the
 * motion). */
static void correct(sway_observer_t *observer, const sway_real_t *slope, sway_real_t off,
                    sway_real_t variance, uint32_t which)
{
    sway_real_t *const towards = observer->scratch[0];
    const uint32_t n = observer->count;
    sway_real_t s = variance;
    for (uint32_t i = 0; i < n; i++) {
        sway_real_t sum = sway_real_zero();
        for (uint32_t j = 0; j < n; j++) {
            if (slope[j].m != 0) {
                sum = ADD(sum, MUL(slope[j], observer->p[place(i, j)]));
            }
        }
        towards[i] = sum;
        s = ADD(s, MUL(slope[i], sum));
    }
    const sway_real_t against = DIV(sway_real_square(off), s);
    follow_unfit(observer, which, against);
    follow_road(observer, which, off, s);
    s = MUL(s, sway_real_square(sway_real_max(one(), observer->unfit[which])));
    const sway_real_t by_s = DIV(one(), s);
    const sway_real_t surprise = ADD(MUL(sway_real_square(off), by_s), sway_real_ln(s));
    observer->log_likelihood = SUB(observer->log_likelihood, sway_real_scale(surprise, -1));
    for (uint32_t i = 0; i < n; i++) {
        const sway_real_t gain = MUL(towards[i], by_s);
        const bool slow = is_parameter(i);
        const sway_real_t part = slow ? MUL(gain, observer->learning) : gain;
        observer->x[i] = ADD(observer->x[i], MUL(part, off));
        for (uint32_t j = 0; j <= i; j++) {
            sway_real_t *const p = &observer->p[place(i, j)];
            *p = SUB(*p, MUL(slow && is_parameter(j) ? part : gain, towards[j]));
        }
        sway_real_t *const own = &observer->p[place(i, i)];
        *own = sway_real_max(*own, sway_real_zero());
    }
}

sway_real_t sway_observer_beyond_linear(const sway_observer_t *observer)
{
    return ADD(one(), sway_real_square(DIV(observer->acc_power, sway_real_int(LINEAR_POWER))));
}

static bool step_yaw(sway_observer_t *observer)
{
    sway_real_t *const slope = observer->by[0]; // its transition is not needed any more
    const sway_real_t noise = sway_real_square(sway_real_micro(YAW_RATE_SE_URAD_S));
    const sway_real_t power = sway_real_square(observer->now.acc_m_s2);
    observer->acc_power =
        ADD(observer->acc_power, MUL(observer->car.step_s, SUB(power, observer->acc_power)));
    for (uint32_t i = 0; i < observer->count; i++) {
        const bool is_in = i == SWAY_STATE_CAR_YAW_RATE || i == SWAY_STATE_YAW_RATE_OFFSET;
        slope[i] = sway_real_int(is_in ? 1 : 0);
    }
    const sway_real_t expected =
        ADD(observer->x[SWAY_STATE_CAR_YAW_RATE], observer->x[SWAY_STATE_YAW_RATE_OFFSET]);
    correct(observer, slope, SUB(observer->now.yaw_rate_rad_s, expected),
            MUL(noise, sway_observer_beyond_linear(observer)), 0);
    return true;
}

static bool step_acc(sway_observer_t *observer)
{
    sway_real_t all[5];
    sway_observer_body_t body;
    sway_real_t *const slope = observer->by[ROW_ACC];
    const sway_real_t noise = sway_real_square(sway_real_micro(ACC_SE_UM_S2));
    const motion_t m =
        motion_of(observer, observer->now.steering_wheel_rad, observer->now.speed_m_s);
    sway_observer_body(observer, &body);
    rates(observer, &body, &m, all);
    slope[SWAY_STATE_ACC_OFFSET] = one();
    const sway_real_t expected = ADD(all[ROW_ACC], observer->x[SWAY_STATE_ACC_OFFSET]);
    correct(observer, slope, SUB(observer->now.acc_m_s2, expected),
            MUL(noise, sway_observer_beyond_linear(observer)), 1);
    return true;
}

/* --- slices ----------------------------------------------------------------------------------- */

/* A step returns true when it is done and the next one may begin; else it is called again with the
 * next column. */
typedef bool step_t(sway_observer_t *observer);

static const struct {
    step_t *run;
    uint8_t solo; ///< cost of one call, in the unit of SWAY_SLICE_COST
    uint8_t both;
} STEPS[] = {
    {NULL, 0, 0},          {step_column, 8, 14},     {step_move, 20, 58},
    {step_spread, 20, 50}, {step_covariance, 8, 40}, {step_yaw, 20, 45},
    {step_acc, 30, 60},    {step_keep, 15, 30},
};

uint32_t sway_observer_cost(const sway_observer_t *observer)
{
    return has_trailer(observer) ? STEPS[observer->step].both : STEPS[observer->step].solo;
}

void sway_observer_run(sway_observer_t *observer)
{
    if (observer->step == STEP_IDLE) {
        return;
    }
    if (STEPS[observer->step].run(observer)) {
        observer->step = (uint8_t)(observer->step == STEP_KEEP ? STEP_IDLE : observer->step + 1);
        observer->column = 0;
    } else {
        observer->column++;
    }
}

/* --- what is known ---------------------------------------------------------------------------- */

sway_real_t sway_observer_covariance(const sway_observer_t *observer, uint32_t a, uint32_t b)
{
    return observer->p[place(a, b)];
}

sway_real_t sway_observer_se(const sway_observer_t *observer, sway_state_t state)
{
    return sway_real_sqrt(observer->p[place((uint32_t)state, (uint32_t)state)]);
}

// Steps of WIDTH simulations side by side; included once for each width, with NAME(name).

#include "plant_math.h"

#define FEATURES NAME(features_t)
#define SAMPLE NAME(sample_t)
#define AXLE NAME(axle_t)
#define DAMPERS NAME(dampers_t)
#define RATES NAME(rates_t)
#define LOADS NAME(loads_t)
#define TYRES NAME(tyres_t)
#define CONSTANTS NAME(constants_t)
#define SLIPS NAME(slips_t)
#define INPUTS NAME(inputs_t)
#define STATE NAME(state_t)

/// What any lane of a group uses; the rest is not calculated.
typedef struct {
    bool relaxed, saturated, softens, aligning, rolls, sprung, flexible, playing, aero, sticking,
        banked;
    bool law, swings, bends, times, rubs, stacks; // plant_law.h
    uint32_t shapes;                              // of laws, by their bits
    bool alone, blocks, full;
    bool whole, heaves;               // with what a simulator needs beyond a fit: plant_whole.h
    int moving[PLANT_STATES], states; // those that move, and how many
} FEATURES;

typedef struct {
    V speed, acceleration, steer, series[PLANT_SERIES];
} SAMPLE;

/// What follows from the constants of the lanes.
typedef struct {
    V per_load[4]; // 1/N; 0: the axle is not there
    V axle[4][PLANT_AXLE], drive[PLANT_DRIVE];
    V friction[4];                   // peak friction; 0: tyre linear
    V free;                          // 1: the speed is a state under its controller, 0: prescribed
    V towed;                         // 1 with a trailer, 0 without
    V per_m, a12, a22, per_d22, a33; // of the mass matrix that does not move
    // of each body: height of the sprung mass and of the ball over the roll axis, m; sprung mass
    // times height, kg m; roll stiffness less that of the weight, damping, inertia about the axis
    V height[2], ball[2], lever[2], stiffness[2], damping[2], inertia[2];
    V pull;                               // mass times ball height less `lever`, trailer
    V spring[4], damper[4], geometric[4]; // N of wheel load per rad, rad/s, N
} CONSTANTS;

#include "plant_law.h"
#include "plant_wheels.h"

/// Rates of what lags behind: roll, load transfer, relaxation. `felt` is what the bodies feel.
INLINE void NAME(lags)(const V *x, const V *e, const CONSTANTS *k, const FEATURES *has,
                       const SLIPS *slips, const V *felt, V *dx)
{
    // without springs, roll and load transfer follow the acceleration that the body feels as lags
    // of second order; the roll that steers may be damped otherwise than the load transfer
    for (int body = 0; body < 2 && !has->sprung; body++) {
        const V wt = e[E_ROLL_FREQUENCY_CAR + 2 * body], zt = e[E_ROLL_DAMPING_CAR + 2 * body];
        const V ws = e[E_STEER_FREQUENCY_CAR + 2 * body], zs = e[E_STEER_DAMPING_CAR + 2 * body];
        const int at = X_TRANSFER + body, rate = X_TRANSFER_RATE + body;
        dx[at] = x[rate];
        dx[rate] = wt * (wt * (felt[body] - x[at]) - 2.0 * zt * x[rate]);
        if (has->rolls && !has->whole) {
            const M mask = (e[E_ROLL_STEER_CAR_FRONT] != 0.0) | (e[E_ROLL_STEER_CAR_REAR] != 0.0) |
                           (e[E_ROLL_STEER_TRAILER] != 0.0) | (e[E_LAW_OF_ROLL_CAR] != 0.0) |
                           (e[E_LAW_OF_ROLL_TRAILER] != 0.0) | (e[E_LAW_BY] == BY_ROLL(CAR)) |
                           (e[E_LAW_BY] == BY_ROLL(TRAILER));
            const int roll = X_ROLL + body, turn = X_ROLL_RATE + body;
            const V follow = ws * (ws * (felt[body] - x[roll]) - 2.0 * zs * x[turn]);
            dx[roll] = (V)((M)x[turn] & mask);
            dx[turn] = (V)((M)follow & mask);
        }
    }
    if (has->relaxed) {
        for (int a = 0; a < 4; a++) {
            dx[X_SLIP + a] = NAME(lag_rate)(k->axle[a][A_RELAXATION], slips->angle[a],
                                            x[X_SLIP + a], slips->ahead);
        }
    }
}

/// What acts on the bodies beside their inertia, in their own axes, and the accelerations of the
/// hitch and the trailer that the motion has without any angular or lateral acceleration.
typedef struct {
    V tilt;                 // of gravity on a banked road, m/s2
    V side[2], yaw[2];      // tyres, wind, slope; moment about the body's centre of gravity
    V roll[2];              // about the roll axis: springs, dampers, weight, wind
    V along[2];             // N, lengthwise
    V hitch;                // Nm about the ball, on the car
    V hitch_x, turn;        // m/s2, of the ball in car axes
    V trailer_x, trailer_y; // m/s2, of the trailer in its own axes
    V bent;                 // m/s2, of the trailer past the ball, part of `trailer_y`
    V push;                 // N, lengthwise on all, where the speed is free
} LOADS;

/// Accelerations: of the car's centre of gravity against its axes, of both yaws and both rolls.
typedef struct {
    V side, yaw[2], roll[2];
    V ahead; // m/s2, change of the car's speed
} RATES;

#include "plant_whole.h"

INLINE void NAME(loads)(const V *x, const SAMPLE *now, const V *p, const V *e, const CONSTANTS *k,
                        const FEATURES *has, const SLIPS *slips, const DAMPERS *dampers, AXLE *w,
                        V *f, V *dx, LOADS *to)
{
    const V *ser = now->series;
    const V r1 = x[X_YAW_1], m2 = p[P_TRAILER_MASS];
    V sine, cosine;
    NAME(turn)(has->whole ? slips->steer : now->steer, &sine, &cosine);
    NAME(axles)(x, ser, p, e, k, has, slips, dampers, w, f);
    to->tilt = (V){0};
    if (has->banked) { // ISO 8855: positive with the left side high
        V high, unused;
        NAME(turn)(ser[T_BANK], &high, &unused);
        to->tilt = -GRAVITY * high;
    }
    V wind[2] = {ser[T_FORCE_CAR], ser[T_FORCE_TRAILER]};
    to->yaw[1] = ser[T_MOMENT_TRAILER];
    V moment[2] = {{0}, {0}}; // of what swings
    if (has->aero) {
        const V q = 0.5 * AIR_DENSITY * TRAILER_AREA * slips->speed * slips->speed *
                    NAME(slip)(slips->side * slips->per_speed);
        wind[1] -= q * e[E_AERO_SIDE];
        to->yaw[1] -= q * e[E_AERO_YAW];
    }
    const V rate = x[X_YAW_2] - r1;
    to->hitch = e[E_HITCH_DAMPING] * rate;
    if (has->sticking) {
        to->hitch += e[E_HITCH_FRICTION] * NAME(hyperbolic_tangent)(rate / e[E_HITCH_STICKING]);
    }
    V braking = ser[T_MOMENT_TRAILER]; // what wheels of one side make by their drag
    if (has->law) {
        braking += e[E_LAW_TO_MOMENT_TRAILER] * slips->law;
        to->hitch += e[E_LAW_TO_HITCH] * slips->law;
        wind[0] += e[E_LAW_TO_FORCE_CAR] * slips->law;
        wind[1] += e[E_LAW_TO_FORCE_TRAILER] * slips->law;
        to->yaw[1] += e[E_LAW_TO_MOMENT_TRAILER] * slips->law;
    }
    V swung[2] = {{0}, {0}}; // roll moment of the weight of what swings
    for (int body = 0; body < 2 && has->swings; body++) {
        const V force = NAME(swinging)(x, e, has, body, ser[T_LAW]);
        wind[body] += force;
        moment[body] = force * e[E_MODE_PLACE_CAR + body];
        swung[body] = -GRAVITY * e[E_MODE_MASS_CAR + body] * x[X_MODE + body];
    }
    if (has->alone) {
        to->hitch *= k->towed;
    }
    const V fc = f[0] * cosine;
    const V drag = e[E_LAW_DRAG_TRAILER] * NAME(absolute)(braking);
    const V driven = has->whole ? fc : fc + e[E_FRONT_DRIVE] * (slips->drive + drag) * sine;
    to->side[0] = driven + f[1];
    to->yaw[0] = p[P_CAR_FRONT_AXLE_TO_COG] * driven - p[P_CAR_REAR_AXLE_TO_COG] * f[1];
    to->along[0] = (V){0}, to->along[1] = m2 * slips->sine * to->tilt - slips->drag[1] - drag;
    if (has->whole) {
        NAME(along)(x, ser, k, slips, w, sine, to);
        NAME(lag_forces)(x, k, &to->side[0], &to->yaw[0], dx);
    }
    to->side[0] += wind[0] + p[P_CAR_MASS] * to->tilt;
    to->side[1] = f[2] + f[3] + wind[1] + m2 * slips->cosine * to->tilt;
    to->yaw[0] += ser[T_MOMENT_CAR] + to->hitch;
    if (has->law) {
        to->yaw[0] += e[E_LAW_TO_MOMENT_CAR] * slips->law;
    }
    if (has->swings) {
        to->yaw[0] += moment[0], to->yaw[1] += moment[1];
    }
    to->yaw[1] +=
        p[P_TRAILER_FRONT_AXLE_TO_COG] * f[2] - p[P_TRAILER_REAR_AXLE_TO_COG] * f[3] - to->hitch;
    if (has->aligning) {
        to->yaw[0] += w[0].moment + w[1].moment;
        to->yaw[1] += w[2].moment + w[3].moment;
    }
    const V tilt[2] = {to->tilt, slips->cosine * to->tilt};
    for (int body = 0; body < 2 && has->sprung; body++) {
        to->roll[body] = ser[T_ROLL_MOMENT_CAR + body] - k->stiffness[body] * x[X_ROLL + body] -
                         k->damping[body] * x[X_ROLL_RATE + body] - k->lever[body] * tilt[body] -
                         NAME(where)(k->lever[body], e[E_WIND_HEIGHT_CAR + body]) * wind[body];
        if (has->swings) {
            to->roll[body] += swung[body];
        }
        if (has->heaves) {
            to->roll[body] += dampers->moment[body];
        }
    }
    const V prescribed = has->whole ? (1.0 - k->free) * now->acceleration : now->acceleration;
    to->hitch_x = prescribed - slips->hitch * r1;
    to->turn = slips->ahead * r1;
    to->trailer_y = slips->cosine * to->turn - slips->sine * to->hitch_x;
    to->bent = (V){0};
}

/// Bodies that do not roll: a symmetric system of three.
INLINE void NAME(solve)(const V *x, const V *p, const CONSTANTS *k, const FEATURES *has,
                        const SLIPS *slips, const LOADS *by, RATES *to)
{
    const V s = slips->sine, c = slips->cosine, r2 = x[X_YAW_2];
    const V m2 = p[P_TRAILER_MASS], lh = p[P_CAR_HITCH_TO_COG], lh2 = p[P_TRAILER_HITCH_TO_COG];
    const V a13 = -m2 * c * lh2;
    const V a23 = lh * m2 * c * lh2;
    const V inner = c * (by->side[1] - m2 * by->bent) + s * by->along[1] - m2 * by->turn -
                    m2 * s * lh2 * r2 * r2;
    const V b1 = by->side[0] - p[P_CAR_MASS] * by->turn + inner;
    const V b2 = by->yaw[0] - lh * inner;
    V b3 = by->yaw[1] - lh2 * by->side[1] + lh2 * m2 * by->trailer_y;
    V a33 = k->a33;
    if (has->whole) { // the speed's own equation, eliminated
        const V cross = k->free * m2 * lh2 * s;
        a33 -= cross * cross * k->per_m;
        b3 -= cross * by->push * k->per_m;
    }
    const V d23 = a23 - k->a12 * a13 * k->per_m;
    const V d33 = a33 - a13 * a13 * k->per_m;
    const V g2 = b2 - k->a12 * b1 * k->per_m;
    const V g3 = b3 - a13 * b1 * k->per_m;
    to->yaw[1] = (g3 - d23 * g2 * k->per_d22) / (d33 - d23 * d23 * k->per_d22);
    to->yaw[0] = (g2 - d23 * to->yaw[1]) * k->per_d22;
    to->side = (b1 - k->a12 * to->yaw[0] - a13 * to->yaw[1]) * k->per_m;
    to->roll[0] = to->roll[1] = (V){0};
}

/// Bodies that roll: with phi positive to the right, height h of the sprung mass m_s and e of the
/// ball over the roll axis, the kinetic energy
///   m v_y^2 / 2 - m_s h v_y phi' + (I + m_s h^2) phi'^2 / 2 of each body, and
///   v_y2 = cos(theta) (v_y1 - l_h1 r_1 - e_1 phi_1') - sin(theta) v_x - l_h2 r_2 + e_2 phi_2'
/// give a symmetric system of five, solved by L D L'.
INLINE void NAME(solve_sprung)(const V *x, const V *p, const CONSTANTS *k, const FEATURES *has,
                               const SLIPS *slips, const LOADS *by, RATES *to)
{
    const V s = slips->sine, c = slips->cosine, r2 = x[X_YAW_2];
    const V m2 = p[P_TRAILER_MASS], lh = p[P_CAR_HITCH_TO_COG], lh2 = p[P_TRAILER_HITCH_TO_COG];
    const V e1 = k->ball[0], q = k->pull;
    const V inner = c * (by->side[1] - m2 * by->bent) + s * by->along[1] - m2 * by->turn -
                    m2 * s * lh2 * r2 * r2;
    const V drag = by->side[1] - m2 * by->trailer_y;
    const V turned = c * m2 * lh2;
    V a[5][5], b[5];
    a[0][0] = p[P_CAR_MASS] + m2;
    a[1][0] = k->a12;
    a[1][1] = k->a22;
    a[2][0] = -turned;
    a[2][1] = lh * turned;
    a[2][2] = k->a33;
    a[3][0] = -k->lever[0] - m2 * e1;
    a[3][1] = m2 * lh * e1;
    a[3][2] = e1 * turned;
    a[3][3] = k->inertia[0];
    a[4][0] = c * q;
    a[4][1] = -lh * c * q;
    a[4][2] = -lh2 * q;
    a[4][3] = -e1 * c * q;
    a[4][4] = k->inertia[1];
    b[0] = by->side[0] - p[P_CAR_MASS] * by->turn + inner;
    b[1] = by->yaw[0] - lh * inner;
    b[2] = by->yaw[1] - lh2 * drag;
    b[3] = by->roll[0] + k->lever[0] * by->turn - e1 * inner;
    b[4] = by->roll[1] + k->lever[1] * by->trailer_y + k->ball[1] * drag;
    if (has->whole) { // the speed's own equation, eliminated
        const V yaw = k->free * m2 * lh2 * s, roll = -k->free * s * q;
        a[2][2] -= yaw * yaw * k->per_m;
        a[4][2] -= yaw * roll * k->per_m;
        a[4][4] -= roll * roll * k->per_m;
        b[2] -= yaw * by->push * k->per_m;
        b[4] -= roll * by->push * k->per_m;
    }
    V per[5];
    for (int j = 0; j < 5; j++) {
        per[j] = 1.0 / a[j][j];
        for (int i = j + 1; i < 5; i++) {
            const V factor = a[i][j] * per[j];
            for (int n = j + 1; n <= i; n++) {
                a[i][n] -= factor * a[n][j];
            }
            b[i] -= factor * b[j];
        }
    }
    for (int i = 4; i >= 0; i--) {
        b[i] *= per[i];
        for (int n = i + 1; n < 5; n++) {
            b[i] -= a[n][i] * per[i] * b[n];
        }
    }
    to->side = b[0], to->yaw[0] = b[1], to->yaw[1] = b[2], to->roll[0] = b[3], to->roll[1] = b[4];
}

/// A drawbar that gives way sideways: the trailer passes the ball with the acceleration at which
/// the force there is the drawbar's. That force is linear in it: two trials say how.
INLINE void NAME(bend)(const V *x, const V *e, const V *force, int trial, LOADS *by, V *dx)
{
    const V rigid = by->trailer_y - by->bent;
    by->bent = NAME(all)((double)trial);
    if (trial == RESOLVED) {
        const V share = NAME(drawbar_share)(e);
        const V found = (NAME(drawbar_force)(x, e) - force[0]) / (force[1] - force[0]);
        dx[X_DRAWBAR] = NAME(where)(share, x[X_DRAWBAR_RATE]);
        dx[X_DRAWBAR_RATE] = NAME(where)(share, found);
        by->bent = NAME(where)(share, share * found);
    }
    by->trailer_y = rigid + by->bent;
}

/// Outputs, see plant/lanes.py. `own` are the lateral accelerations of both centres of gravity.
INLINE void NAME(outputs)(const V *x, const V *p, const V *e, const CONSTANTS *k,
                          const FEATURES *has, const SLIPS *slips, const LOADS *by,
                          const RATES *rates, const AXLE *w, const V *f, const V *own, V *out)
{
    const V s = slips->sine, c = slips->cosine;
    const V m2 = p[P_TRAILER_MASS];
    const V px = by->along[1] - m2 * by->trailer_x;
    const V py = by->side[1] - m2 * own[1] + k->lever[1] * rates->roll[1];
    const V sensed = by->tilt * (1.0 - e[E_BANK_UNSENSED]);
    V felt[2] = {own[0] - sensed, own[1] - c * sensed};
    for (int body = 0; body < 2 && has->sprung; body++) {
        V tilted, unused;
        NAME(turn)(x[X_ROLL + body], &tilted, &unused);
        felt[body] += e[E_SENSED_ROLL_CAR + body] * GRAVITY * tilted -
                      e[E_SENSOR_HEIGHT_CAR + body] * rates->roll[body];
        out[O_CAR_ROLL_RATE + body] = x[X_ROLL_RATE + body];
    }
    for (int body = 0; body < 2 && has->swings; body++) {
        felt[body] += e[E_SENSOR_AHEAD_CAR + body] * rates->yaw[body];
    }
    for (int j = 0; j < 4; j++) {
        out[j] = x[j], out[O_SLIP_F + j] = slips->acting[j];
    }
    for (int wheel = 0; wheel < 2; wheel++) {
        out[O_LATERAL_FL + wheel] = w[0].force[wheel];
        out[O_LATERAL_RL + wheel] = w[1].force[wheel];
        out[O_VERTICAL_FL + wheel] = w[0].load[wheel];
        out[O_VERTICAL_RL + wheel] = w[1].load[wheel];
        out[O_TRAILER_LATERAL_FL + wheel] = w[2].force[wheel];
        out[O_TRAILER_LATERAL_RL + wheel] = w[3].force[wheel];
        out[O_TRAILER_VERTICAL_FL + wheel] = w[2].load[wheel];
        out[O_TRAILER_VERTICAL_RL + wheel] = w[3].load[wheel];
    }
    out[O_LATERAL_TF] = f[2], out[O_LATERAL_TR] = f[3];
    out[O_HITCH_X] = c * px - s * py, out[O_HITCH_Y] = s * px + c * py;
    out[O_CAR_ACCELERATION] = felt[0], out[O_TRAILER_ACCELERATION] = felt[1];
    out[O_CAR_YAW_ACCELERATION] = rates->yaw[0], out[O_TRAILER_YAW_ACCELERATION] = rates->yaw[1];
    out[O_CAR_ROLL] = slips->roll[0], out[O_TRAILER_ROLL] = slips->roll[1];
}

/// Derivative of the states, see plant/lanes.py; `out` takes the outputs where `store`.
INLINE void NAME(derivative)(const V *x, const SAMPLE *now, const V *p, const V *e,
                             const CONSTANTS *k, const FEATURES *has, V *dx, bool store, V *out)
{
    const V *ser = now->series;
    SLIPS slips;
    NAME(slips)(x, now, p, e, k, has, &slips, dx);
    DAMPERS dampers;
    if (has->heaves) {
        NAME(dampers)(x, ser, e, k, has, &dampers);
    }
    AXLE w[4];
    V f[4];
    LOADS by;
    NAME(loads)(x, now, p, e, k, has, &slips, &dampers, w, f, dx, &by);
    const V s = slips.sine, c = slips.cosine;
    const V m2 = p[P_TRAILER_MASS], lh2 = p[P_TRAILER_HITCH_TO_COG];
    const V swing = lh2 * x[X_YAW_2] * x[X_YAW_2];
    RATES rates;
    V ay1, ahy, a2y, force[RESOLVED];
    // one place of call, so that the compiler takes each system into the loop once
    for (int trial = has->bends ? 0 : RESOLVED; trial <= RESOLVED; trial++) {
        if (has->bends) {
            NAME(bend)(x, e, force, trial, &by, dx);
        }
        if (has->whole) {
            by.push = by.along[0] + c * by.along[1] - s * (by.side[1] - m2 * by.bent) +
                      p[P_CAR_MASS] * x[X_SIDE] * x[X_YAW_1] - m2 * (by.hitch_x + c * swing);
        }
        if (has->sprung) {
            NAME(solve_sprung)(x, p, k, has, &slips, &by, &rates);
        } else {
            NAME(solve)(x, p, k, has, &slips, &by, &rates);
        }
        rates.ahead = now->acceleration;
        V hitch_x = by.hitch_x;
        if (has->whole) {
            const V free =
                (by.push - m2 * lh2 * s * rates.yaw[1] + s * k->pull * rates.roll[1]) * k->per_m;
            rates.ahead += k->free * (free - now->acceleration);
            hitch_x += k->free * free;
        }
        ay1 = rates.side + by.turn;
        ahy = ay1 - p[P_CAR_HITCH_TO_COG] * rates.yaw[0] - k->ball[0] * rates.roll[0];
        a2y = c * ahy - s * hitch_x - lh2 * rates.yaw[1] + k->ball[1] * rates.roll[1] + by.bent;
        if (trial < RESOLVED) {
            force[trial] = by.side[1] - m2 * a2y + k->lever[1] * rates.roll[1];
        } else {
            by.hitch_x = hitch_x;
        }
    }
    by.trailer_x = c * by.hitch_x + s * ahy + swing;
    // an observer keeps the state near the measured one, so that what is missing shows where and
    // when it acts instead of being carried on (innovation form of the prediction-error method)
    dx[X_SIDE] = rates.side;
    dx[X_YAW_1] = rates.yaw[0] + e[E_OBSERVER_CAR] * (ser[T_MEASURED_CAR] - x[X_YAW_1]);
    dx[X_ARTICULATION] = x[X_YAW_2] - x[X_YAW_1];
    dx[X_YAW_2] = rates.yaw[1] + e[E_OBSERVER_TRAILER] * (ser[T_MEASURED_TRAILER] - x[X_YAW_2]);
    if (has->alone) {
        dx[X_ARTICULATION] *= k->towed;
        dx[X_YAW_2] *= k->towed;
    }
    for (int body = 0; body < 2 && has->sprung; body++) {
        dx[X_ROLL + body] = x[X_ROLL_RATE + body];
        dx[X_ROLL_RATE + body] = rates.roll[body];
    }
    const V felt[2] = {ay1 - by.tilt, a2y - c * by.tilt};
    NAME(lags)(x, e, k, has, &slips, felt, dx);
    if (has->law) {
        const V on_ball = by.side[1] - m2 * a2y + k->lever[1] * rates.roll[1];
        dx[X_LAW] = NAME(felt)(x, e, felt, on_ball, dx[X_LAW]);
        if (has->shapes & KEEP) {
            dx[X_BEHIND] = NAME(remembered)(x, e, dx[X_LAW], dx[X_BEHIND]);
        }
        dx[X_PRESSED] = NAME(pressing)(x, e, felt, on_ball);
    }
    for (int body = 0; body < 2 && has->swings; body++) {
        V base = felt[body] + e[E_MODE_PLACE_CAR + body] * rates.yaw[body];
        if (has->sprung) {
            base += GRAVITY * x[X_ROLL + body] - k->height[body] * rates.roll[body];
        }
        NAME(swing)(x, e, has, body, base, ser[T_LAW], dx);
    }
    if (has->whole) {
        NAME(travel)(x, now, p, k, &slips, &rates, dx);
    }
    if (has->heaves) {
        NAME(heave)(x, e, k, has, &dampers, w, dx);
    }
    if (store) {
        const V own[2] = {ay1, a2y};
        NAME(outputs)(x, p, e, k, has, &slips, &by, &rates, w, f, own, out);
        if (has->whole) {
            NAME(whole_outputs)(x, now, p, e, k, has, &slips, &by, &rates, out);
        }
    }
}

/// What the front one of a body's axles takes of `share`: an axle that is not there carries
/// nothing.
INLINE V NAME(front)(const CONSTANTS *k, int front, V share)
{
    const V kept = NAME(choose)(k->per_load[front + 1] > 0.0, share, NAME(all)(1.0));
    return NAME(where)(k->per_load[front], kept);
}

/// Springs, dampers and inertias of the bodies; one without sprung mass does not roll.
INLINE void NAME(springs)(const V *p, const V *e, CONSTANTS *k)
{
    for (int body = 0; body < 2; body++) {
        const V mass = p[body == 0 ? P_CAR_MASS : P_TRAILER_MASS];
        const V sprung = NAME(where)(mass, e[E_SPRUNG_MASS_CAR + body]);
        const V axis = e[E_ROLL_AXIS_HEIGHT_CAR + body];
        const V k_roll = NAME(where)(sprung, e[E_ROLL_STIFFNESS_CAR + body]);
        const V c_roll = NAME(where)(sprung, e[E_ROLL_DAMPING_RATE_CAR + body]);
        k->height[body] = NAME(where)(sprung, e[E_SPRUNG_HEIGHT_CAR + body]);
        k->lever[body] = sprung * k->height[body];
        k->ball[body] = NAME(where)(sprung, e[E_BALL_HEIGHT_CAR + body]);
        k->stiffness[body] = k_roll - GRAVITY * k->lever[body];
        k->damping[body] = c_roll;
        const V inertia = e[E_ROLL_INERTIA_CAR + body] + k->lever[body] * k->height[body];
        k->inertia[body] = NAME(choose)(sprung > 0.0, inertia, NAME(all)(1.0));
        // the wheels' own weight is carried over at their centres
        const V arm =
            axis + (1.0 - sprung / NAME(most)(mass, NAME(all)(1.0))) * (e[E_WHEEL_RADIUS] - axis);
        const int f = 2 * body;
        const V sprung_front = NAME(front)(k, f, e[E_ROLL_FRONT_SHARE_CAR + body]);
        const V damped_front = NAME(front)(k, f, e[E_ROLL_DAMPING_SHARE_CAR + body]);
        for (int a = f; a < f + 2; a++) {
            const V share = a == f ? sprung_front : 1.0 - sprung_front;
            const V damped = a == f ? damped_front : 1.0 - damped_front;
            const V per_track = NAME(where)(sprung, 1.0 / e[E_TRACK_CAR_FRONT + (a < 3 ? a : 2)]);
            k->spring[a] = share * k_roll * per_track;
            k->damper[a] = damped * c_roll * per_track;
            k->geometric[a] = NAME(where)(k->per_load[a], arm * per_track);
        }
    }
    const V m2 = p[P_TRAILER_MASS], e1 = k->ball[0], e2 = k->ball[1];
    k->pull = m2 * e2 - k->lever[1];
    k->inertia[0] += m2 * e1 * e1;
    k->inertia[1] += e2 * (m2 * e2 - 2.0 * k->lever[1]);
}

/// Dampers of a body whose rebound is harder than their compression, or of which some have lost
/// damping: its roll lifts and drops it.
INLINE void NAME(bouncing)(const plant_lane_t *lane, double *to)
{
    const double *s = lane->scalars;
    for (int a = 0; a < 4; a++, to += PLANT_AXLE) {
        const int body = a / 2, group = a < 3 ? a : 2;
        const double lost[2] = {s[E_DAMPER_LOST_LEFT_CAR_FRONT + a],
                                s[E_DAMPER_LOST_RIGHT_CAR_FRONT + a]};
        const double asymmetry =
            s[E_DAMPER_ASYMMETRY_CAR + body] + s[E_DAMPER_CHANGED_CAR_FRONT + a];
        const double load = lane->body[P_CAR_FRONT_AXLE_LOAD + a];
        const bool healthy = asymmetry == 0.0 && lost[0] == 0.0 && lost[1] == 0.0;
        if (healthy || !(load > 0.0)) {
            continue;
        }
        const double beside = lane->body[P_CAR_FRONT_AXLE_LOAD + (a ^ 1)];
        const double front = beside > 0.0 ? s[E_ROLL_DAMPING_SHARE_CAR + body] : 1.0;
        const double rate = a % 2 == 0 || !(beside > 0.0) ? front : 1.0 - front;
        const double half = 0.5 * s[E_TRACK_CAR_FRONT + group];
        to[A_HALF_TRACK] = half;
        to[A_DAMPER] = rate * s[E_ROLL_DAMPING_RATE_CAR + body] / (2.0 * half * half);
        to[A_DAMPER_LEFT] = 1.0 - lost[0];
        to[A_DAMPER_RIGHT] = 1.0 - lost[1];
        to[A_DAMPER_ASYMMETRY] = asymmetry;
        to[A_HEAVE_MASS] = load / GRAVITY;
        to[A_HEAVE_OMEGA] = s[E_HEAVE_FREQUENCY_CAR_FRONT + group];
        const double zeta = s[E_HEAVE_DAMPING_CAR + body];
        const double whole = to[A_HEAVE_MASS] * to[A_HEAVE_OMEGA];
        // heave is damped by the same dampers, though not as they damp roll: of what they have lost
        // it loses its own share, not theirs, which might leave less than nothing
        const double own = whole > 0.0 ? to[A_DAMPER] / whole - zeta : 0.0;
        to[A_HEAVE_ZETA] = zeta + 0.5 * (lost[0] + lost[1]) * own;
    }
}

/// Values of each axle: its own, or as the scalar slots say.
INLINE void NAME(axle_values)(const plant_lane_t *lane, double *to)
{
    if (lane->axles != NULL) {
        memcpy(to, lane->axles, 4 * PLANT_AXLE * sizeof *to);
        return;
    }
    const double *s = lane->scalars;
    memset(to, 0, 4 * PLANT_AXLE * sizeof *to);
    for (int a = 0; a < 4; a++, to += PLANT_AXLE) {
        const int group = a < 3 ? a : 2;
        to[A_RELAXATION] = s[E_RELAXATION_CAR_FRONT + group];
        to[A_ROLL_STEER] = s[E_ROLL_STEER_CAR_FRONT + group];
        to[A_PEAK_FRICTION_INVERSE] = s[E_PEAK_FRICTION_INVERSE];
        to[A_DEGRESSION] = s[E_DEGRESSION];
    }
    NAME(bouncing)(lane, to - 4 * PLANT_AXLE);
}

/// What any lane uses of the scalar slots `s` and the series.
INLINE void NAME(features)(const plant_lane_t *lane, const double *axles, FEATURES *has)
{
    const double *s = lane->scalars;
    has->flexible |= s[E_STEERING_FLEXIBILITY] != 0.0;
    has->playing |= s[E_FREE_PLAY] > 0.0;
    has->sticking |= s[E_HITCH_FRICTION] != 0.0;
    has->aero |= s[E_AERO_SIDE] != 0.0 || s[E_AERO_YAW] != 0.0;
    for (int a = 0; a < 4; a++) {
        const double *of = axles + PLANT_AXLE * a;
        has->saturated |= of[A_PEAK_FRICTION_INVERSE] > 0.0;
        has->relaxed |= of[A_RELAXATION] > 0.0;
        has->rolls |= of[A_ROLL_STEER] != 0.0;
        has->heaves |= of[A_HEAVE_MASS] > 0.0;
        has->softens |= of[A_SOFTENING] > 0.0;
        has->aligning |= s[E_TRAIL_CAR_FRONT + (a < 3 ? a : 2)] != 0.0;
    }
    has->whole |= lane->whole != NULL;
    has->law |= s[E_LAW_GAIN] != 0.0;
    has->rolls |= s[E_LAW_OF_ROLL_CAR] != 0.0 || s[E_LAW_OF_ROLL_TRAILER] != 0.0;
    has->rolls |= s[E_LAW_BY] == BY_ROLL(CAR) || s[E_LAW_BY] == BY_ROLL(TRAILER);
    has->swings |= s[E_MODE_MASS_CAR] > 0.0 || s[E_MODE_MASS_TRAILER] > 0.0;
    has->bends |= s[E_DRAWBAR_COMPLIANCE] > 0.0;
    has->shapes |= s[E_LAW_GAIN] != 0.0 ? BIT(s[E_LAW_SHAPE]) : 0;
    has->times |= s[E_LAW_BY] > 0.0;
    has->rubs |= s[E_MODE_FRICTION_CAR] != 0.0 || s[E_MODE_FRICTION_TRAILER] != 0.0;
    has->stacks |= s[E_MODE_RUBBING_CAR] != 0.0 || s[E_MODE_RUBBING_TRAILER] != 0.0;
    has->sprung |= s[E_SPRUNG_MASS_CAR] > 0.0 || s[E_SPRUNG_MASS_TRAILER] > 0.0;
    has->alone |= !(lane->body[P_TRAILER_MASS] > 0.0);
    has->banked |= lane->series[T_BANK] != NULL;
    has->blocks |= lane->blocks != NULL;
    has->full |= lane->output != NULL;
}

INLINE void NAME(move)(FEATURES *has, bool moves, int first, int count)
{
    for (int j = first; moves && j < first + count; j++) {
        has->moving[has->states++] = j;
    }
}

/// The states that move: a step leaves the others alone.
INLINE void NAME(states)(FEATURES *has)
{
    has->states = 0;
    NAME(move)(has, true, X_SIDE, 4);
    NAME(move)(has, !has->sprung, X_TRANSFER, 2);
    NAME(move)(has, has->relaxed, X_SLIP, 4);
    NAME(move)(has, !has->sprung, X_TRANSFER_RATE, 2);
    NAME(move)(has, has->sprung || has->rolls, X_ROLL, 4);
    NAME(move)(has, has->heaves, X_HEAVE, 8);
    NAME(move)(has, has->law, X_LAW, 1);
    NAME(move)(has, has->swings, X_MODE, 4);
    NAME(move)(has, has->stacks, X_MODE_KEPT, 2);
    NAME(move)(has, has->bends, X_DRAWBAR, 2);
    NAME(move)(has, has->law, X_BEHIND, 2);
    NAME(move)(has, has->whole, X_LAG, PLANT_STATES - X_LAG);
}

/// Constants of the lanes, and what follows from them.
INLINE void NAME(constants)(plant_lane_t *const *lane, V *p, V *e, CONSTANTS *k, FEATURES *has)
{
    for (int l = 0; l < WIDTH; l++) {
        for (int j = 0; j < PLANT_BODY; j++) {
            p[j][l] = lane[l]->body[j];
        }
        for (int j = 0; j < PLANT_SCALARS; j++) {
            e[j][l] = lane[l]->scalars[j];
        }
        double axles[4 * PLANT_AXLE];
        NAME(axle_values)(lane[l], axles);
        for (int j = 0; j < 4 * PLANT_AXLE; j++) {
            k->axle[j / PLANT_AXLE][j % PLANT_AXLE][l] = axles[j];
        }
        k->drive[D_SHAPE][l] = SHAPE;
        for (int j = 0; j < PLANT_DRIVE && lane[l]->whole != NULL; j++) {
            k->drive[j][l] = lane[l]->whole->drive[j];
        }
        NAME(features)(lane[l], axles, has);
    }
    NAME(states)(has);
    k->free = k->drive[D_FREE_SPEED];
    for (int a = 0; a < 4; a++) {
        const V load = p[P_CAR_FRONT_AXLE_LOAD + a];
        const V mass = p[a < 2 ? P_CAR_MASS : P_TRAILER_MASS];
        const V inverse = k->axle[a][A_PEAK_FRICTION_INVERSE];
        k->friction[a] = NAME(where)(inverse, 1.0 / inverse);
        k->per_load[a] = NAME(where)(mass, NAME(where)(load, 1.0 / load));
    }
    const V m2 = p[P_TRAILER_MASS], lh = p[P_CAR_HITCH_TO_COG], lh2 = p[P_TRAILER_HITCH_TO_COG];
    const V none = {0}, one = none + 1.0;
    k->towed = NAME(choose)(m2 > 0.0, one, none);
    k->per_m = 1.0 / (p[P_CAR_MASS] + m2);
    k->a12 = -m2 * lh;
    k->a22 = p[P_CAR_YAW_INERTIA] + m2 * lh * lh;
    k->per_d22 = 1.0 / (k->a22 - k->a12 * k->a12 * k->per_m);
    k->a33 = NAME(choose)(m2 > 0.0, p[P_TRAILER_YAW_INERTIA] + m2 * lh2 * lh2, one);
    if (has->sprung) {
        NAME(springs)(p, e, k);
    }
}

typedef struct {
    int slots[PLANT_SERIES];
    int count;
    const double *from[PLANT_SERIES + 3][WIDTH];
    int64_t step[PLANT_SERIES + 3][WIDTH];
} INPUTS;

INLINE void NAME(inputs)(plant_lane_t *const *lane, INPUTS *in)
{
    in->count = 0;
    for (int j = 0; j < PLANT_SERIES; j++) {
        bool used = false;
        for (int l = 0; l < WIDTH; l++) {
            used |= lane[l]->series[j] != NULL;
        }
        if (!used) {
            continue;
        }
        for (int l = 0; l < WIDTH; l++) {
            const double *from = lane[l]->series[j];
            in->from[in->count][l] = from != NULL ? from + lane[l]->at : &NEUTRAL;
            in->step[in->count][l] = from != NULL ? 1 : 0;
        }
        in->slots[in->count++] = j;
    }
    for (int l = 0; l < WIDTH; l++) {
        const double *own[3] = {lane[l]->speed, lane[l]->acceleration, lane[l]->steer};
        for (int j = 0; j < 3; j++) {
            in->from[PLANT_SERIES + j][l] = own[j] + lane[l]->at;
        }
    }
}

INLINE void NAME(load)(const INPUTS *in, int64_t sample, SAMPLE *to)
{
    for (int l = 0; l < WIDTH; l++) {
        to->speed[l] = in->from[PLANT_SERIES][l][sample];
        to->acceleration[l] = in->from[PLANT_SERIES + 1][l][sample];
        to->steer[l] = in->from[PLANT_SERIES + 2][l][sample];
    }
    for (int j = 0; j < in->count; j++) {
        V value = {0};
        for (int l = 0; l < WIDTH; l++) {
            value[l] = in->from[j][l][sample * in->step[j][l]];
        }
        to->series[in->slots[j]] = value;
    }
}

/// Outputs of a sample to where the lanes want them.
INLINE void NAME(put)(plant_lane_t *const *lane, int32_t count, const FEATURES *has, M alive,
                      int64_t sample, V *out, V *sums)
{
    for (int j = 0; j < (has->whole ? PLANT_OUTPUTS : PLANT_SUMS); j++) {
        out[j] = (V)((M)out[j] & alive);
    }
    if (has->blocks) {
        for (int j = 0; j < PLANT_SUMS; j++) {
            sums[j] += out[j];
        }
    }
    if (has->full) {
        for (int32_t l = 0; l < count; l++) {
            double *to = lane[l]->output;
            if (to != NULL) {
                const int32_t columns = lane[l]->columns;
                to += (lane[l]->at + sample) * columns;
                for (int32_t j = 0; j < columns; j++) {
                    to[j] = out[lane[l]->column[j]][l];
                }
            }
        }
    }
    if (has->blocks && (lane[0]->at + sample - lane[0]->first) % PLANT_BLOCK == PLANT_BLOCK - 1) {
        for (int32_t l = 0; l < count; l++) {
            double *to = lane[l]->blocks;
            if (to != NULL) {
                to += (lane[l]->at + sample) / PLANT_BLOCK * PLANT_SUMS;
                for (int j = 0; j < PLANT_SUMS; j++) {
                    to[j] = sums[j][l];
                }
            }
        }
        for (int j = 0; j < PLANT_SUMS; j++) {
            sums[j] = (V){0};
        }
    }
}

INLINE void NAME(middle)(const INPUTS *in, const SAMPLE *a, const SAMPLE *b, SAMPLE *to)
{
    to->speed = 0.5 * b->speed + 0.5 * a->speed;
    to->acceleration = 0.5 * b->acceleration + 0.5 * a->acceleration;
    to->steer = 0.5 * b->steer + 0.5 * a->steer;
    for (int j = 0; j < in->count; j++) {
        const int slot = in->slots[j];
        to->series[slot] = 0.5 * b->series[slot] + 0.5 * a->series[slot];
    }
}

INLINE void NAME(keep)(plant_lane_t *const *lane, int32_t count, int64_t sample, const V *x)
{
    for (int32_t l = 0; l < count; l++) {
        if (lane[l]->states != NULL) {
            double *to = lane[l]->states + (lane[l]->at + sample) * PLANT_STATES;
            for (int j = 0; j < PLANT_STATES; j++) {
                to[j] = x[j][l];
            }
        }
    }
}

/// Everything of the lanes while they are stepped.
typedef struct {
    plant_lane_t *lane[WIDTH];
    int32_t count;
    V p[PLANT_BODY], e[PLANT_SCALARS];
    CONSTANTS k;
    V x[PLANT_STATES], dx[PLANT_STATES], tried[PLANT_STATES]; // those of a stage
    V out[PLANT_OUTPUTS], sums[PLANT_SUMS];
    M alive;
    FEATURES has;
    INPUTS in;
    SAMPLE samples[3]; // at the beginning, the middle and the end of a step
} STATE;

INLINE void NAME(begin)(plant_lane_t *const *given, int32_t count, STATE *now)
{
    memset(now, 0, sizeof *now);
    now->count = count;
    for (int l = 0; l < WIDTH; l++) {
        now->lane[l] = given[l < count ? l : 0];
        for (int j = 0; j < PLANT_STATES; j++) {
            now->x[j][l] = now->tried[j][l] = now->lane[l]->state[j];
        }
        for (int j = 0; j < PLANT_SUMS; j++) {
            now->sums[j][l] = now->lane[l]->sums[j];
        }
        now->alive[l] = now->lane[l]->diverged ? 0 : -1;
    }
    NAME(constants)(now->lane, now->p, now->e, &now->k, &now->has);
    NAME(inputs)(now->lane, &now->in);
    NAME(load)(&now->in, 0, &now->samples[0]);
}

INLINE void NAME(end)(STATE *now, int64_t samples)
{
    for (int32_t l = 0; l < now->count; l++) {
        plant_lane_t *lane = now->lane[l];
        for (int j = 0; j < PLANT_STATES; j++) {
            lane->state[j] = now->x[j][l];
        }
        for (int j = 0; j < PLANT_SUMS; j++) {
            lane->sums[j] = now->sums[j][l];
        }
        lane->diverged = now->alive[l] ? 0 : 1;
        lane->at += samples;
    }
}

/// Loads that the motion makes, from its past into the step from sample `i`.
INLINE void NAME(generate)(STATE *now, double step, int64_t i)
{
    for (int32_t l = 0; l < now->count; l++) {
        const plant_lane_t *lane = now->lane[l];
        if (lane->whole == NULL || lane->whole->generator == NULL) {
            continue;
        }
        double load[4];
        const double time = lane->whole->start_s + (double)(lane->at + i) * step;
        generator_loads(lane->whole->generator, time, step, load);
        for (int j = 0; j < 12; j++) {
            now->samples[j / 4].series[T_LOAD_CAR_FRONT + j % 4][l] = load[j % 4];
        }
    }
}

/// Keep what the loads to come are made from.
INLINE void NAME(remember)(STATE *now, double step)
{
    static const int force[4] = {O_LATERAL_FL, O_LATERAL_RL, O_TRAILER_LATERAL_FL,
                                 O_TRAILER_LATERAL_RL};
    static const int load[4] = {O_VERTICAL_FL, O_VERTICAL_RL, O_TRAILER_VERTICAL_FL,
                                O_TRAILER_VERTICAL_RL};
    for (int32_t l = 0; l < now->count; l++) {
        const plant_lane_t *lane = now->lane[l];
        if (lane->whole == NULL || lane->whole->generator == NULL) {
            continue;
        }
        double friction[4];
        for (int a = 0; a < 4; a++) {
            const V carried = now->out[load[a]] + now->out[load[a] + 1];
            const V side = now->out[force[a]] + now->out[force[a] + 1];
            friction[a] = side[l] / (carried[l] > 1.0 ? carried[l] : 1.0);
        }
        generator_remember(lane->whole->generator, step, now->x[X_YAW_1][l], friction);
    }
}

/// The four stages of a step from sample `i`, and the new states. Without a stride only the first.
INLINE void NAME(step)(STATE *now, double step, int32_t stride, int64_t i)
{
    const int *moving = now->has.moving;
    V *tmp = now->tried, total[PLANT_STATES];
    for (int n = 0; n < now->has.states; n++) {
        tmp[moving[n]] = now->x[moving[n]];
        total[n] = (V){0};
    }
    if (now->has.whole) {
        NAME(generate)(now, step, i);
    }
    // one place of call, so that the compiler takes the derivative into the loop once
    for (int stage = 0; stage < 4; stage++) {
        const bool store = stage == 0 || (stage == 2 && stride == 2);
        const SAMPLE *sample = &now->samples[(stage + 1) / 2];
        NAME(derivative)(tmp, sample, now->p, now->e, &now->k, &now->has, now->dx, store, now->out);
        if (store) {
            NAME(put)
            (now->lane, now->count, &now->has, now->alive, stage == 0 ? i : i + 1, now->out,
             now->sums);
        }
        if (stride == 0) {
            return;
        }
        if (stage == 0 && now->has.whole) {
            NAME(remember)(now, step);
        }
        const double weight = stage == 0 || stage == 3 ? 1.0 : 2.0;
        const double ahead = stage == 2 ? step : 0.5 * step;
        for (int n = 0; n < now->has.states; n++) {
            const int j = moving[n];
            total[n] += weight * now->dx[j];
            tmp[j] = now->x[j] + ahead * now->dx[j];
        }
    }
    M bad = {0};
    for (int n = 0; n < now->has.states; n++) {
        const int j = moving[n];
        now->x[j] += step / 6.0 * total[n];
        bad |= ~(NAME(absolute)(now->x[j]) < LIMIT);
    }
    now->alive &= ~bad;
    for (int n = 0; n < now->has.states; n++) {
        now->x[moving[n]] = (V)((M)now->x[moving[n]] & now->alive);
    }
}

/// `steps` steps of `stride` samples of every lane; a stride of 0: only the outputs of the sample.
WIDEST
static void NAME(advance)(plant_lane_t *const *given, int32_t count, double period_s,
                          int32_t stride, int64_t steps)
{
    STATE now;
    NAME(begin)(given, count, &now);
    const double step = period_s * (stride == 2 ? 2.0 : 1.0);
    for (int64_t taken = 0; taken < steps && NAME(any)(now.alive); taken++) {
        const int64_t i = taken * stride;
        NAME(keep)(now.lane, count, i, now.x);
        if (stride > 0) {
            NAME(load)(&now.in, i + stride, &now.samples[2]);
        }
        if (stride == 2) {
            NAME(load)(&now.in, i + 1, &now.samples[1]);
        } else if (stride == 1) {
            NAME(middle)(&now.in, &now.samples[0], &now.samples[2], &now.samples[1]);
        }
        NAME(step)(&now, step, stride, i);
        now.samples[0] = now.samples[2];
    }
    NAME(end)(&now, steps * stride);
}

#undef V
#undef M
#undef FEATURES
#undef SAMPLE
#undef AXLE
#undef DAMPERS
#undef RATES
#undef LOADS
#undef TYRES
#undef CONSTANTS
#undef SLIPS
#undef INPUTS
#undef STATE

// SPDX-License-Identifier: MIT
/// sway_observer: the motion and the unknowns of a combination from the car's own sensors.
///
/// An extended Kalman filter over the single-track model (App. A.2 of the reference, in the form of
/// the hitch force H): steering and speed drive it, yaw rate and lateral acceleration of the car
/// correct it. Beside the motion (lateral speed, yaw rates of both bodies, articulation) it holds
/// what is not known for certain: the car's stiffnesses, inertia and centre of gravity, three
/// sensor offsets, the tyres' relaxation length, and of the trailer mass, length, inertia,
/// stiffness, place of the axle and dry friction at the ball. So the trailer's motion is
/// reconstructed with its uncertainty, and its parameters are identified from whatever the driver
/// does. What the sensors cannot tell stays at its start value with its start error: that is how
/// observability shows, nothing is switched.
///
/// Estimates are kept where cars and trailers can be: without that, wind and road that are no white
/// noise are explained by trailers of 28 m.
///
/// Steering, yaw rate and acceleration hold no mass: all masses are relative to the car's.
///
/// Samples are means over SWAY_OBSERVER_ROWS rows. The equations, positive left, v_y at the car's
/// centre of gravity, F the axle forces, M the moment of friction at the ball on the car:
///     m1 (v_y' + v r) = F_f + F_r + H
///     I1 r'  = l_f F_f - l_r F_r - l_h H + M
///     I2 w'  = -l H - e F_2 - M - C_2 d^2 w / v          e: axle behind the trailer's COG,
///     m2 (v_y' + v r - l_h r' - l w') = F_2 - H          d: half the axle distance of a tandem
///     theta' = w - r
///     F = C a / (1 + (C a / P)^2 / 3), a: slip a relaxation length before, P: load of the axle,
///     what dry roads and most tyres (cubic part of the Magic Formula) have in common
/// H in closed form from them; the rest is arithmetic.
#ifndef SWAY_OBSERVER_H
#define SWAY_OBSERVER_H

#include "model/sway_single_track.h"

/// Rows of the grid in one sample of the observer.
#ifndef SWAY_OBSERVER_ROWS
#define SWAY_OBSERVER_ROWS 4
#endif

/// What the observer estimates. The first SWAY_STATE_SOLO are those of a car alone.
typedef enum {
    SWAY_STATE_LATERAL_SPEED,     ///< m/s, at the COG of the car
    SWAY_STATE_CAR_YAW_RATE,      ///< rad/s
    SWAY_STATE_YAW_RATE_OFFSET,   ///< rad/s
    SWAY_STATE_ACC_OFFSET,        ///< m/s2
    SWAY_STATE_STEERING_OFFSET,   ///< rad at the steering wheel
    SWAY_STATE_CAR_FRONT,         ///< ln of the front stiffness over the believed one
    SWAY_STATE_CAR_REAR,          ///< the same, rear
    SWAY_STATE_CAR_INERTIA,       ///< the same, yaw inertia
    SWAY_STATE_CAR_COG,           ///< m, true COG ahead of the believed one
    SWAY_STATE_RELAXATION,        ///< m, that tyres roll until their force has followed the slip
    SWAY_STATE_TRAILER_YAW_RATE,  ///< rad/s
    SWAY_STATE_ARTICULATION,      ///< rad, psi_trailer - psi_car
    SWAY_STATE_TRAILER_MASS,      ///< ln of kg
    SWAY_STATE_TRAILER_LENGTH,    ///< ln of m, ball to COG
    SWAY_STATE_TRAILER_GYRATION,  ///< ln of I2 / (m2 l^2)
    SWAY_STATE_TRAILER_STIFFNESS, ///< ln of C_2 / (m2 g)
    SWAY_STATE_TRAILER_AXLE,      ///< m, axle (or the middle of two) behind the COG
    SWAY_STATE_FRICTION,          ///< dry friction at the ball, 100 Nm
    SWAY_STATE_COUNT
} sway_state_t;
#define SWAY_STATE_SOLO 10

/// Places in a packed lower triangle.
#define SWAY_OBSERVER_TRIANGLE (SWAY_STATE_COUNT * (SWAY_STATE_COUNT + 1) / 2)

/// Start of the estimates: value and standard error of each state.
typedef struct {
    sway_real_t value[SWAY_STATE_COUNT];
    sway_real_t se[SWAY_STATE_COUNT];
} sway_observer_start_t;

/// One sample, SI units.
typedef struct {
    sway_real_t steering_wheel_rad;
    sway_real_t speed_m_s; ///< > 0
    sway_real_t yaw_rate_rad_s;
    sway_real_t acc_m_s2;
} sway_observer_sample_t;

/// What does not change.
typedef struct {
    sway_real_t mass_kg; ///< of the car
    sway_real_t front_m; ///< l_f, l_r, l_h, of the believed COG
    sway_real_t rear_m;
    sway_real_t hitch_m;
    sway_real_t front_n_per_rad; ///< what the logarithms refer to
    sway_real_t rear_n_per_rad;
    sway_real_t inertia_kgm2;
    sway_real_t ratio; ///< 1 / i_s
    sway_real_t acc_m; ///< accelerometer ahead of the believed COG
    sway_real_t half_tandem_m;
    sway_real_t peak_n[2]; ///< most lateral force of front and rear axle
    sway_real_t step_s;    ///< between two samples
} sway_observer_car_t;

/// The combination that a set of states stands for.
typedef struct {
    sway_real_t front_n_per_rad;
    sway_real_t rear_n_per_rad;
    sway_real_t inertia_kgm2;
    sway_real_t cog_m;
    sway_real_t relaxation_m;
    sway_real_t mass_kg; ///< of the trailer
    sway_real_t length_m;
    sway_real_t trailer_inertia_kgm2;
    sway_real_t trailer_n_per_rad;
    sway_real_t axle_m;
    sway_real_t friction_nm;
} sway_observer_body_t;

typedef struct {
    bool moving;   ///< the motion has been started
    uint8_t count; ///< states: SWAY_STATE_SOLO or SWAY_STATE_COUNT
    uint8_t step;  ///< of the work in progress
    uint8_t column;
    uint16_t unbound; ///< bounds that the start values lie beyond: not kept
    sway_observer_car_t car;
    sway_observer_sample_t now;
    sway_observer_sample_t last;
    sway_real_t learning;       ///< share of a correction that goes to the parameters, 0 to 1
    sway_real_t acc_power;      ///< mean square of the acceleration over a second
    sway_real_t unfit[2];       ///< innovations squared over their variance, two-second mean
    sway_real_t lag[2];         ///< innovations, mean of half a second
    sway_real_t road;           ///< what pushes the motion, by a usual road
    sway_real_t log_likelihood; ///< of the last sample
    sway_real_t x[SWAY_STATE_COUNT];
    sway_real_t p[SWAY_OBSERVER_TRIANGLE]; ///< covariance
    /* Work in progress. */
    sway_observer_body_t body;
    sway_real_t rate[4];                      ///< of the states of motion, and the acceleration
    sway_real_t by[5][SWAY_STATE_COUNT];      ///< derivatives of rates and acceleration; transition
    sway_real_t scratch[4][SWAY_STATE_COUNT]; ///< transition times covariance
} sway_observer_t;

/// Starts from `start`, for `count` states.
void sway_observer_init(sway_observer_t *observer, const sway_observer_car_t *car,
                        const sway_observer_start_t *start, uint32_t count);

/// The motion is not known any more (a gap, a halt); what has been learnt stays.
void sway_observer_pause(sway_observer_t *observer);

/// Takes a sample; the work is done by sway_observer_run().
void sway_observer_take(sway_observer_t *observer, const sway_observer_sample_t *sample);

/// What the next slice costs about, in the unit of SWAY_SLICE_COST; 0: nothing is to be done.
uint32_t sway_observer_cost(const sway_observer_t *observer);

/// One slice.
void sway_observer_run(sway_observer_t *observer);

/// By how much the variance of the present sample is larger for tyres beyond their linear range.
sway_real_t sway_observer_beyond_linear(const sway_observer_t *observer);

/// Standard error of a state.
sway_real_t sway_observer_se(const sway_observer_t *observer, sway_state_t state);

/// Covariance of two states.
sway_real_t sway_observer_covariance(const sway_observer_t *observer, uint32_t a, uint32_t b);

/// The combination that the observer believes in.
void sway_observer_body(const sway_observer_t *observer, sway_observer_body_t *body);

/// Moves `body` as if `state` had grown by `step` (small).
void sway_observer_move(sway_observer_body_t *body, sway_state_t state, sway_real_t step);

/// The same as a single-track model. Without friction: it vanishes beside a large swing.
void sway_observer_model(const sway_observer_t *observer, const sway_observer_body_t *body,
                         sway_single_track_t *stm);

#endif

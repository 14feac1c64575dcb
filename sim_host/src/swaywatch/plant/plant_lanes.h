/// plant_lanes: the plant, several simulations side by side.
///
/// What the slots, constants and outputs are is said by plant/lanes.py, which owns their order.
#ifndef PLANT_LANES_H
#define PLANT_LANES_H

#include <stdint.h>

#define PLANT_BODY 18
#define PLANT_SCALARS 163
#define PLANT_SERIES 33
#define PLANT_OUTPUTS 51
#define PLANT_SUMS 36
#define PLANT_AXLE 13
#define PLANT_DRIVE 9
#define PLANT_GENERATOR_WINDOW 6
#define PLANT_STATES 43
#define PLANT_LAW_STATES 13
#define PLANT_LAW_FELT 3
#define PLANT_BLOCK 10
#define PLANT_LANES 8

/// Constants of the combination; names, units and meaning are in plant/lanes.py.
enum plant_body {
    P_CAR_MASS,
    P_CAR_YAW_INERTIA,
    P_CAR_FRONT_AXLE_TO_COG,
    P_CAR_REAR_AXLE_TO_COG,
    P_CAR_HITCH_TO_COG,
    P_CAR_FRONT_CORNERING_STIFFNESS,
    P_CAR_REAR_CORNERING_STIFFNESS,
    P_TRAILER_MASS,
    P_TRAILER_YAW_INERTIA,
    P_TRAILER_FRONT_AXLE_TO_COG,
    P_TRAILER_REAR_AXLE_TO_COG,
    P_TRAILER_HITCH_TO_COG,
    P_TRAILER_FRONT_CORNERING_STIFFNESS,
    P_TRAILER_REAR_CORNERING_STIFFNESS,
    P_CAR_FRONT_AXLE_LOAD,
    P_CAR_REAR_AXLE_LOAD,
    P_TRAILER_FRONT_AXLE_LOAD,
    P_TRAILER_REAR_AXLE_LOAD,
};
/// Scalar slots.
enum plant_scalar {
    E_STEERING_FLEXIBILITY,
    E_FREE_PLAY,
    E_HITCH_FRICTION,
    E_HITCH_STICKING,
    E_HITCH_DAMPING,
    E_AERO_SIDE,
    E_AERO_YAW,
    E_PEAK_FRICTION_INVERSE,
    E_DEGRESSION,
    E_RELAXATION_CAR_FRONT,
    E_RELAXATION_CAR_REAR,
    E_RELAXATION_TRAILER,
    E_ROLL_STEER_CAR_FRONT,
    E_ROLL_STEER_CAR_REAR,
    E_ROLL_STEER_TRAILER,
    E_TRANSFER_CAR_FRONT,
    E_TRANSFER_CAR_REAR,
    E_TRANSFER_TRAILER_FRONT,
    E_TRANSFER_TRAILER_REAR,
    E_ROLL_GAIN_CAR,
    E_ROLL_GAIN_TRAILER,
    E_ROLL_FREQUENCY_CAR,
    E_ROLL_DAMPING_CAR,
    E_ROLL_FREQUENCY_TRAILER,
    E_ROLL_DAMPING_TRAILER,
    E_STEER_FREQUENCY_CAR,
    E_STEER_DAMPING_CAR,
    E_STEER_FREQUENCY_TRAILER,
    E_STEER_DAMPING_TRAILER,
    E_OBSERVER_CAR,
    E_OBSERVER_TRAILER,
    E_BANK_UNSENSED,
    E_SPRUNG_MASS_CAR,
    E_SPRUNG_MASS_TRAILER,
    E_SPRUNG_HEIGHT_CAR,
    E_SPRUNG_HEIGHT_TRAILER,
    E_ROLL_INERTIA_CAR,
    E_ROLL_INERTIA_TRAILER,
    E_ROLL_STIFFNESS_CAR,
    E_ROLL_STIFFNESS_TRAILER,
    E_ROLL_DAMPING_RATE_CAR,
    E_ROLL_DAMPING_RATE_TRAILER,
    E_ROLL_AXIS_HEIGHT_CAR,
    E_ROLL_AXIS_HEIGHT_TRAILER,
    E_ROLL_FRONT_SHARE_CAR,
    E_ROLL_FRONT_SHARE_TRAILER,
    E_ROLL_DAMPING_SHARE_CAR,
    E_ROLL_DAMPING_SHARE_TRAILER,
    E_TRACK_CAR_FRONT,
    E_TRACK_CAR_REAR,
    E_TRACK_TRAILER,
    E_BALL_HEIGHT_CAR,
    E_BALL_HEIGHT_TRAILER,
    E_WHEEL_RADIUS,
    E_SENSED_ROLL_CAR,
    E_SENSED_ROLL_TRAILER,
    E_SENSOR_HEIGHT_CAR,
    E_SENSOR_HEIGHT_TRAILER,
    E_WIND_HEIGHT_CAR,
    E_WIND_HEIGHT_TRAILER,
    E_TRAIL_CAR_FRONT,
    E_TRAIL_CAR_REAR,
    E_TRAIL_TRAILER,
    E_LAW_GAIN,
    E_LAW_SHAPE,
    E_LAW_BEND,
    E_LAW_LINE,
    E_LAW_OF_SIZE,
    E_LAW_RIGHT_1,
    E_LAW_RIGHT_2,
    E_LAW_RIGHT_3,
    E_LAW_RIGHT_4,
    E_LAW_RIGHT_5,
    E_LAW_LEFT_1,
    E_LAW_LEFT_2,
    E_LAW_LEFT_3,
    E_LAW_LEFT_4,
    E_LAW_LEFT_5,
    E_LAW_SPEED_POWER,
    E_LAW_LAG,
    E_LAW_TRANSIENT,
    E_LAW_OF_ARTICULATION,
    E_LAW_OF_ARTICULATION_RATE,
    E_LAW_OF_YAW_RATE_CAR,
    E_LAW_OF_YAW_RATE_TRAILER,
    E_LAW_OF_SIDESLIP_CAR,
    E_LAW_OF_SIDESLIP_TRAILER,
    E_LAW_OF_STEER,
    E_LAW_OF_ROLL_CAR,
    E_LAW_OF_ROLL_TRAILER,
    E_LAW_OF_HEADING,
    E_LAW_OF_SLIP_CAR_FRONT,
    E_LAW_OF_SLIP_CAR_REAR,
    E_LAW_OF_SLIP_TRAILER,
    E_LAW_OF_LATERAL_ACCELERATION_CAR,
    E_LAW_OF_LATERAL_ACCELERATION_TRAILER,
    E_LAW_OF_HITCH_FORCE,
    E_LAW_BY,
    E_LAW_BY_SIDE,
    E_LAW_BY_BEND,
    E_LAW_TO_HITCH,
    E_LAW_TO_FORCE_CAR,
    E_LAW_TO_FORCE_TRAILER,
    E_LAW_TO_MOMENT_CAR,
    E_LAW_TO_MOMENT_TRAILER,
    E_LAW_TO_SLIP_CAR_FRONT,
    E_LAW_TO_SLIP_CAR_REAR,
    E_LAW_TO_SLIP_TRAILER,
    E_LAW_DRAG_TRAILER,
    E_MODE_MASS_CAR,
    E_MODE_MASS_TRAILER,
    E_MODE_FREQUENCY_CAR,
    E_MODE_FREQUENCY_TRAILER,
    E_MODE_DAMPING_CAR,
    E_MODE_DAMPING_TRAILER,
    E_MODE_GAP_CAR,
    E_MODE_GAP_TRAILER,
    E_MODE_WITHIN_CAR,
    E_MODE_WITHIN_TRAILER,
    E_MODE_OTHER_SIDE_CAR,
    E_MODE_OTHER_SIDE_TRAILER,
    E_MODE_DRAG_CAR,
    E_MODE_DRAG_TRAILER,
    E_MODE_FRICTION_CAR,
    E_MODE_FRICTION_TRAILER,
    E_MODE_RUBBING_CAR,
    E_MODE_RUBBING_TRAILER,
    E_MODE_SLIPS_CAR,
    E_MODE_SLIPS_TRAILER,
    E_MODE_PLACE_CAR,
    E_MODE_PLACE_TRAILER,
    E_SENSOR_AHEAD_CAR,
    E_SENSOR_AHEAD_TRAILER,
    E_DRAWBAR_COMPLIANCE,
    E_DRAWBAR_PLAY,
    E_DRAWBAR_FRICTION,
    E_DRAWBAR_OTHER_SIDE,
    E_DRAG_AREA_CAR,
    E_DRAG_AREA_TRAILER,
    E_FRONT_DRIVE,
    E_PITCH_TRANSFER,
    E_DAMPER_ASYMMETRY_CAR,
    E_DAMPER_ASYMMETRY_TRAILER,
    E_DAMPER_LOST_LEFT_CAR_FRONT,
    E_DAMPER_LOST_LEFT_CAR_REAR,
    E_DAMPER_LOST_LEFT_TRAILER_FRONT,
    E_DAMPER_LOST_LEFT_TRAILER_REAR,
    E_DAMPER_LOST_RIGHT_CAR_FRONT,
    E_DAMPER_LOST_RIGHT_CAR_REAR,
    E_DAMPER_LOST_RIGHT_TRAILER_FRONT,
    E_DAMPER_LOST_RIGHT_TRAILER_REAR,
    E_DAMPER_CHANGED_CAR_FRONT,
    E_DAMPER_CHANGED_CAR_REAR,
    E_DAMPER_CHANGED_TRAILER_FRONT,
    E_DAMPER_CHANGED_TRAILER_REAR,
    E_HEAVE_FREQUENCY_CAR_FRONT,
    E_HEAVE_FREQUENCY_CAR_REAR,
    E_HEAVE_FREQUENCY_TRAILER,
    E_HEAVE_DAMPING_CAR,
    E_HEAVE_DAMPING_TRAILER,
    E_JACKING_CAR,
    E_JACKING_TRAILER,
    E_LOAD_BY_STRUTS,
    E_SLOTS, ///< PLANT_SCALARS
};
/// Slots that are functions of time.
enum plant_series {
    T_STIFFNESS_CAR_FRONT,
    T_STIFFNESS_CAR_REAR,
    T_STIFFNESS_TRAILER_FRONT,
    T_STIFFNESS_TRAILER_REAR,
    T_LOAD_CAR_FRONT,
    T_LOAD_CAR_REAR,
    T_LOAD_TRAILER_FRONT,
    T_LOAD_TRAILER_REAR,
    T_FORCE_CAR,
    T_MOMENT_CAR,
    T_FORCE_TRAILER,
    T_MOMENT_TRAILER,
    T_BANK,
    T_SHIFT_CAR_FRONT,
    T_SHIFT_CAR_REAR,
    T_SHIFT_TRAILER_FRONT,
    T_SHIFT_TRAILER_REAR,
    T_HEAVE_CAR_FRONT,
    T_HEAVE_CAR_REAR,
    T_HEAVE_TRAILER_FRONT,
    T_HEAVE_TRAILER_REAR,
    T_FRICTION,
    T_MEASURED_CAR,
    T_MEASURED_TRAILER,
    T_SLIP_CAR_FRONT,
    T_SLIP_CAR_REAR,
    T_SLIP_TRAILER_FRONT,
    T_SLIP_TRAILER_REAR,
    T_ROLL_MOMENT_CAR,
    T_ROLL_MOMENT_TRAILER,
    T_BRAKE_CAR,
    T_BRAKE_TRAILER,
    T_LAW,
};
/// Outputs.
enum plant_output {
    O_LATERAL_VELOCITY,
    O_CAR_YAW_RATE,
    O_ARTICULATION,
    O_TRAILER_YAW_RATE,
    O_LATERAL_FL,
    O_LATERAL_FR,
    O_LATERAL_RL,
    O_LATERAL_RR,
    O_LATERAL_TF,
    O_LATERAL_TR,
    O_VERTICAL_FL,
    O_VERTICAL_FR,
    O_VERTICAL_RL,
    O_VERTICAL_RR,
    O_HITCH_X,
    O_HITCH_Y,
    O_CAR_ACCELERATION,
    O_TRAILER_ACCELERATION,
    O_CAR_YAW_ACCELERATION,
    O_TRAILER_YAW_ACCELERATION,
    O_CAR_ROLL,
    O_TRAILER_ROLL,
    O_SLIP_F,
    O_SLIP_R,
    O_SLIP_TF,
    O_SLIP_TR,
    O_TRAILER_LATERAL_FL,
    O_TRAILER_LATERAL_FR,
    O_TRAILER_LATERAL_RL,
    O_TRAILER_LATERAL_RR,
    O_TRAILER_VERTICAL_FL,
    O_TRAILER_VERTICAL_FR,
    O_TRAILER_VERTICAL_RL,
    O_TRAILER_VERTICAL_RR,
    O_CAR_ROLL_RATE,
    O_TRAILER_ROLL_RATE,
    O_SPEED,
    O_CAR_ACCELERATION_X,
    O_TRAILER_ACCELERATION_X,
    O_HITCH_MOMENT,
    O_DRIVE_FORCE,
    O_ROAD_WHEEL_ANGLE,
    O_PATH_X,
    O_PATH_Y,
    O_HEADING,
    O_TRAILER_SIDESLIP,
    O_BANK,
    O_SLIP_ANGLE_F,
    O_SLIP_ANGLE_R,
    O_SLIP_ANGLE_TF,
    O_SLIP_ANGLE_TR,
};

/// Values of an axle.
enum plant_axle {
    A_RELAXATION,
    A_PEAK_FRICTION_INVERSE,
    A_DEGRESSION,
    A_ROLL_STEER,
    A_HALF_TRACK,
    A_SOFTENING,
    A_DAMPER,
    A_DAMPER_LEFT,
    A_DAMPER_RIGHT,
    A_DAMPER_ASYMMETRY,
    A_HEAVE_MASS,
    A_HEAVE_OMEGA,
    A_HEAVE_ZETA,
};

/// Values of the whole.
enum plant_drive {
    D_FREE_SPEED,
    D_CONTROL_P,
    D_CONTROL_I,
    D_FEED_FORWARD,
    D_CONTROL_LAG,
    D_FORCE_MAX,
    D_ROLLING_RESISTANCE,
    D_SUSPENSION_LAG,
    D_SHAPE,
};

/// A window of the generator: row of its history, axle, s, s, N per unit, s.
enum plant_generator_value {
    G_REFERENCE,
    G_AXLE,
    G_START,
    G_STOP,
    G_GAIN,
    G_DELAY,
};

/// States; two in a row are car and trailer.
enum plant_state {
    X_SIDE,         ///< m/s
    X_YAW_1,        ///< rad/s
    X_ARTICULATION, ///< rad
    X_YAW_2,        ///< rad/s
    X_TRANSFER,     ///< m/s2, what the load transfer follows without springs
    X_SLIP = 6,     ///< rad, of the four axles
    X_TRANSFER_RATE = 10,
    X_ROLL = 12, ///< rad; without springs m/s2, what the roll that steers follows
    X_ROLL_RATE = 14,
    X_HEAVE = 16, ///< m, over the four axles
    X_HEAVE_RATE = 20,
    X_LAW =
        24, ///< of a law behind its lag, or of what a transient one depends on; rad, the heading;
            ///< how far what a waiting one depends on swings; what is felt, late; what cannot
            ///< go faster than a limit; of an oscillator
    X_MODE = 25, ///< m, to the left, of what swings in the bodies
    X_MODE_RATE = 27,
    X_DRAWBAR = 29,   ///< m, of the trailer past the ball, to the left
    X_DRAWBAR_RATE,   ///< m/s
    X_BEHIND,         ///< what a law depends on, a moment ago: how fast it goes is seen from it;
                      ///< the rate of an oscillator; what a shape that follows what is felt keeps
    X_PRESSED,        ///< what is felt and multiplies a law, late
    X_MODE_KEPT,      ///< m, two: of what rubs in what swings
    X_LAG = 35,       ///< N, Nm: the car's side force and moment behind the suspension's lag
    X_SPEED = 37,     ///< m/s
    X_SPEED_INTEGRAL, ///< m
    X_DRIVE,          ///< N
    X_PLACE,          ///< m, two
    X_HEADING = 42,   ///< rad
};

/// Axle loads that the motion makes (plant_generator.h).
typedef struct {
    const double *windows; ///< rows of PLANT_GENERATOR_WINDOW
    int64_t count;
    double *history; ///< six rows of `length` steps
    int64_t length;
    double mean_time_s, level_time_s;
    double mean[5], level[5];
    int64_t steps; ///< since the start
} plant_generator_t;

/// What a simulator needs beyond a fit.
typedef struct {
    double drive[PLANT_DRIVE];
    double start_s;
    plant_generator_t *generator; ///< or NULL
} plant_whole_t;

/// One simulation of samples `first` to `stop`; all arrays are indexed by the sample of the run.
typedef struct {
    int64_t first; ///< multiple of PLANT_BLOCK
    int64_t stop;  ///< above `first`
    const double *speed;
    const double *acceleration;
    const double *steer;
    const double *series[PLANT_SERIES]; ///< NULL: neutral
    const double *body;
    const double *scalars;
    const double *axles;           ///< four rows of PLANT_AXLE; NULL: as the scalar slots say
    const plant_whole_t *whole;    ///< NULL: a fit's
    double state[PLANT_STATES];    ///< in: at `first`; out: at the last sample
    double *output;                ///< rows of `columns` outputs, or NULL
    int32_t columns;               ///< outputs in a row of `output`
    int32_t column[PLANT_OUTPUTS]; ///< which
    double *blocks;                ///< rows of sums over PLANT_BLOCK samples, or NULL
    double *states;                ///< rows of PLANT_STATES at the samples stepped on, or NULL
    double sums[PLANT_SUMS];       ///< of the block that is open; zero at the start
    int64_t at;                    ///< where the simulation stands
    int64_t diverged;              ///< 1: outputs from `at` on are zero
} plant_lane_t;

/// Runge-Kutta 4 over the lanes, at most PLANT_LANES; a `stride` of 2 takes the middle sample at
/// stage 3. What a lane gives does not depend on the lanes beside it. O(samples).
void plant_lanes(plant_lane_t *lanes, int32_t count, double period_s, int32_t stride);

#endif

// SPDX-License-Identifier: MIT
/// sway_status: everything the core says, in plain integers with their units in the names.
///
/// One status belongs to one estimate (one window of samples); `sequence` counts the estimates. A
/// field is meaningful where its bit of `valid` is set; otherwise it keeps its last valid value
/// (0 before the first) and the bit of `old` is set.
#ifndef SWAY_STATUS_H
#define SWAY_STATUS_H

#include "sway_types.h"

/// Bits of `valid` and `old`.
typedef enum {
    SWAY_VALID_LINE = 1 << 0,           ///< frequency, growth, damping ratio, amplitude
    SWAY_VALID_SPEED = 1 << 1,          ///< speed is known
    SWAY_VALID_MODEL = 1 << 2,          ///< model_*, static values
    SWAY_VALID_CRITICAL_SPEED = 1 << 3, ///< v_crit, margin, sensitivities
    SWAY_VALID_CAR_FRONT = 1 << 4,      ///< slip, force and stiffness of the axle
    SWAY_VALID_CAR_REAR = 1 << 5,
    SWAY_VALID_TRAILER_FRONT = 1 << 6,
    SWAY_VALID_TRAILER_REAR = 1 << 7,
    SWAY_VALID_CAR_FRONT_LOAD = 1 << 8, ///< effective load and what is made of it
    SWAY_VALID_CAR_REAR_LOAD = 1 << 9,
    SWAY_VALID_TRAILER_FRONT_LOAD = 1 << 10,
    SWAY_VALID_TRAILER_REAR_LOAD = 1 << 11,
    SWAY_VALID_CAR_INERTIA = 1 << 12,
    SWAY_VALID_TRAILER_INERTIA_1 = 1 << 13, ///< Eq. 4.20, equal forces
    SWAY_VALID_TRAILER_INERTIA_2 = 1 << 14, ///< Eq. 4.23, equal normalised stiffness
    SWAY_VALID_TRAILER_INERTIA = 1 << 15,   ///< Eq. 4.19 with the best forces there are
    SWAY_VALID_TIME_TO_LIMIT = 1 << 16,
    SWAY_VALID_MARGIN = 1 << 17,       ///< combined damping ratio
    SWAY_VALID_LOWEST_SPEED = 1 << 18, ///< lowest_v_crit_*
    SWAY_VALID_BITS = 19
} sway_valid_t;

/// Quality flags: why the estimate deserves less trust. 0 is good.
typedef enum {
    SWAY_QUALITY_NO_OSCILLATION = 1 << 0, ///< nothing above the noise to identify from
    SWAY_QUALITY_FORCED = 1 << 1,         ///< the driver steers with the oscillation
    SWAY_QUALITY_GAP = 1 << 2,            ///< samples are missing in the window
    SWAY_QUALITY_SPEED_CHANGING = 1 << 3,
    SWAY_QUALITY_NONLINEAR = 1 << 4, ///< beyond the linear range (4 m/s2 or 3f content)
    SWAY_QUALITY_SEEKING = 1 << 5,   ///< no line is locked yet
    SWAY_QUALITY_SLOW = 1 << 6,      ///< speed below 30 km/h
    SWAY_QUALITY_NO_SPEED = 1 << 7,
    SWAY_QUALITY_SINGULAR = 1 << 8,         ///< equations without a solution
    SWAY_QUALITY_MISSING_INPUT = 1 << 9,    ///< an input that the main results need never came
    SWAY_QUALITY_MODEL_DISAGREES = 1 << 10, ///< model and signal damping differ beyond their errors
    SWAY_QUALITY_EQUAL_SPLIT = 1 << 11,     ///< trailer axle forces from the user's stiffness ratio
    SWAY_QUALITY_USER_INERTIA = 1 << 12,    ///< a yaw inertia in the model is the user's
    SWAY_QUALITY_MISFIT = 1 << 13,          ///< not one damped line: a step, an onset, a gust
    SWAY_QUALITY_HITCH = 1 << 14, ///< something rubs at the ball: v_crit is that of a large swing
    SWAY_QUALITY_SMALL_SWING = 1 << 15, ///< v_crit is based on smaller swings than the limit
    SWAY_QUALITY_UNEXPLAINED = 1 << 16, ///< an inertia is complex: its error was made larger
    SWAY_QUALITY_BITS = 17
} sway_quality_t;

typedef enum {
    SWAY_ALARM_OFF, ///< no judgement: too slow, or inputs missing
    SWAY_ALARM_NORMAL,
    SWAY_ALARM_NOTICE,   ///< little margin left: keep the speed
    SWAY_ALARM_WARNING,  ///< undamped or nearly so: slow down
    SWAY_ALARM_CRITICAL, ///< growing and large: intervene
    SWAY_ALARM_COUNT
} sway_alarm_state_t;

/// Reasons of the alarm state, as bits.
typedef enum {
    SWAY_REASON_SMALL_MARGIN = 1 << 0,         ///< v_crit - v below the notice margin
    SWAY_REASON_ABOVE_CRITICAL_SPEED = 1 << 1, ///< v above v_crit beyond its uncertainty
    SWAY_REASON_LOW_DAMPING = 1 << 2,          ///< free oscillation decays slowly
    SWAY_REASON_GROWING = 1 << 3,              ///< free oscillation grows
    SWAY_REASON_LARGE_AMPLITUDE = 1 << 4,
    SWAY_REASON_SHORT_TIME = 1 << 5, ///< time to limit below its threshold
    SWAY_REASON_STATIC = 1 << 6,     ///< above the static critical speed (jackknife)
    SWAY_REASON_BITS = 7
} sway_reason_t;

/// Where the combined damping ratio comes from.
typedef enum {
    SWAY_BELIEF_NONE,
    SWAY_BELIEF_MODEL,  ///< no free oscillation to look at
    SWAY_BELIEF_SIGNAL, ///< no model, or the model contradicts a well measured growth
    SWAY_BELIEF_BOTH    ///< weighted by their variances
} sway_belief_t;

/// Where v_crit comes from.
typedef enum {
    SWAY_SOURCE_NONE,
    SWAY_SOURCE_USER,      ///< the user's stiffnesses
    SWAY_SOURCE_PARTLY,    ///< some axles identified
    SWAY_SOURCE_IDENTIFIED ///< all axles identified
} sway_source_t;

/// What the critical speed search ended with.
typedef enum {
    SWAY_VCRIT_NONE,         ///< not computed
    SWAY_VCRIT_FOUND,        ///< oscillatory limit between 10 and 250 km/h
    SWAY_VCRIT_BEYOND_RANGE, ///< stable up to 250 km/h: v_crit says 250 km/h
    SWAY_VCRIT_BELOW_RANGE,  ///< unstable already at 10 km/h: v_crit says 10 km/h
    SWAY_VCRIT_SINGULAR,
    SWAY_VCRIT_DIVERGENCE ///< the first limit is static (no oscillation)
} sway_vcrit_t;

/// Fault counters; they saturate at UINT32_MAX and never go down.
typedef enum {
    SWAY_FAULT_RANGE,    ///< samples outside their input's range
    SWAY_FAULT_TIME,     ///< timestamps before the last one of the same input
    SWAY_FAULT_INVALID,  ///< samples that the sender marked not valid
    SWAY_FAULT_GAP,      ///< times that an input was silent for too long
    SWAY_FAULT_SINGULAR, ///< estimates dropped because equations had no solution
    SWAY_FAULT_OVERRUN,  ///< estimates begun before the last one had been finished
    SWAY_FAULT_RATE,     ///< times that an input's rate left the nominal one
    SWAY_FAULT_COUNT
} sway_fault_t;

/// What the supervision of the relations has found (sway_supervise). Findings of a sensor are a
/// base and the number of its channel. The size's unit: of a gain, tyres, load, car, trailer, speed
/// 1e-6; of a delay us; of an offset the channel's; of a place um; of friction 1e-4 Nm.
typedef enum {
    SWAY_FINDING_NONE,
    SWAY_FINDING_SPEED,           ///< true over measured speed, less 1
    SWAY_FINDING_CAR_FRONT_TYRES, ///< stiffness over the configured one, less 1
    SWAY_FINDING_CAR_REAR_TYRES,
    SWAY_FINDING_TRAILER_TYRES,
    SWAY_FINDING_LOAD,       ///< of the trailer, changed on the way; size: its COG to the front, um
    SWAY_FINDING_FRICTION,   ///< dry, at the ball
    SWAY_FINDING_CAR,        ///< not the configured one; size: its mass
    SWAY_FINDING_TRAILER,    ///< not the configured one; size: its mass
    SWAY_FINDING_GAIN = 16,  ///< of a sensor; size: measured over true, less 1
    SWAY_FINDING_DELAY = 32, ///< of a sensor
    SWAY_FINDING_OFFSET = 48 ///< of a sensor
} sway_finding_t;

/// How a relation between the inputs holds (sway_supervise).
typedef enum {
    SWAY_RELATION_NOT_ASKED, ///< the inputs do not allow it, or nothing was driven that tells
    SWAY_RELATION_HOLDS,     ///< within what tolerances, noise, road and wind make of it
    SWAY_RELATION_BREAKS     ///< beyond three times of it
} sway_relation_state_t;

/// Parameters of the sensitivities, Eq. 3.44, in this order.
typedef enum {
    SWAY_PARAMETER_CAR_MASS,
    SWAY_PARAMETER_TRAILER_MASS,
    SWAY_PARAMETER_CAR_YAW_INERTIA,
    SWAY_PARAMETER_TRAILER_YAW_INERTIA,
    SWAY_PARAMETER_CAR_FRONT_AXLE,     ///< l_f1
    SWAY_PARAMETER_CAR_REAR_AXLE,      ///< l_r1
    SWAY_PARAMETER_CAR_HITCH,          ///< l_h1
    SWAY_PARAMETER_TRAILER_FRONT_AXLE, ///< l_f2
    SWAY_PARAMETER_TRAILER_REAR_AXLE,  ///< l_r2
    SWAY_PARAMETER_TRAILER_HITCH,      ///< l_h2
    SWAY_PARAMETER_CAR_FRONT_STIFFNESS,
    SWAY_PARAMETER_CAR_REAR_STIFFNESS,
    SWAY_PARAMETER_TRAILER_FRONT_STIFFNESS,
    SWAY_PARAMETER_TRAILER_REAR_STIFFNESS,
    SWAY_PARAMETER_COUNT
} sway_parameter_t;

/// One axle. Errors are standard errors.
typedef struct {
    int32_t cornering_stiffness_n_per_rad; ///< |C|, Eq. 4.9
    int32_t cornering_stiffness_se_n_per_rad;
    int32_t argument_urad; ///< of C; negative: force behind slip
    int32_t argument_se_urad;
    int32_t slip_amplitude_urad; ///< Eq. 4.5-4.7
    int32_t force_amplitude_mn;
    int32_t load_mn;           ///< mean over the window
    int32_t effective_load_mn; ///< Eq. 4.13, with sign of the phase kept
    int32_t effective_load_se_mn;
    int32_t load_harmonic_mn;                   ///< amplitude at 2f
    int32_t load_harmonic_phase_urad;           ///< to lateral force squared, (-pi, pi]
    int32_t normalised_stiffness_milli_per_rad; ///< Eq. 4.16, 1/rad in thousandths
    int32_t lateral_friction_ppm;               ///< Eq. 4.17
} sway_axle_status_t;

typedef struct {
    uint32_t sequence;   ///< counts the estimates
    int64_t time_us;     ///< of the row of the grid that completed this estimate
    int64_t mid_time_us; ///< middle of its window
    int32_t window_ms;   ///< its length
    uint32_t valid;      ///< SWAY_VALID_*
    uint32_t old;        ///< SWAY_VALID_*: not valid now, the value is an earlier one
    uint32_t quality;    ///< SWAY_QUALITY_*

    int32_t speed_mm_s;
    int32_t frequency_uhz; ///< damped frequency of the yaw oscillation
    int32_t frequency_se_uhz;
    int32_t growth_ppm_per_s; ///< 1e-6/s; positive: the oscillation grows
    int32_t growth_se_ppm_per_s;
    int32_t damping_ratio_ppm; ///< from the signals alone, Eq. 3.39
    int32_t damping_ratio_se_ppm;
    int32_t amplitude_urad_s; ///< trailer yaw rate (car yaw rate of a solo car), at mid-window
    int32_t amplitude_se_urad_s;

    int32_t model_damping_ratio_ppm; ///< of the single-track model at this speed
    int32_t model_damping_ratio_se_ppm;
    int32_t model_frequency_uhz;
    int32_t margin_damping_ratio_ppm; ///< combination of signal and model
    int32_t margin_damping_ratio_se_ppm;
    int32_t belief;      ///< sway_belief_t
    int32_t source;      ///< sway_source_t
    int32_t v_crit_kind; ///< sway_vcrit_t
    int32_t v_crit_mm_s;
    int32_t v_crit_se_mm_s;
    int32_t v_crit_swing_urad_s; ///< amplitude of the largest swing that a tyre was seen in
    int32_t margin_mm_s;         ///< v_crit - v
    int32_t sensitivity_mm_s[SWAY_PARAMETER_COUNT]; ///< change of v_crit for +1 %, Eq. 3.44

    int32_t understeer_gradient_urad;             ///< K_u of the car alone, Eq. 3.20
    int32_t combination_understeer_gradient_urad; ///< K_u'' with the trailer, Eq. 3.28
    int32_t characteristic_speed_mm_s; ///< > 0: characteristic; < 0: minus the static critical one
    int32_t yaw_rate_gain_micro_per_s; ///< yaw rate per road-wheel angle, Eq. 3.26, 1e-6/s
    int32_t hitch_angle_gain_ppm;      ///< articulation per road-wheel angle, Eq. 3.33

    sway_axle_status_t axle[SWAY_AXLE_COUNT];

    int32_t car_yaw_inertia_gm2; ///< Eq. 4.18
    int32_t car_yaw_inertia_se_gm2;
    int32_t trailer_yaw_inertia_gm2; ///< Eq. 4.19, best forces
    int32_t trailer_yaw_inertia_se_gm2;
    int32_t trailer_yaw_inertia_1_gm2; ///< method 1, Eq. 4.20
    int32_t trailer_yaw_inertia_2_gm2; ///< method 2, Eq. 4.23
    int32_t car_yaw_inertia_argument_urad;
    int32_t trailer_yaw_inertia_argument_urad;

    uint32_t missing_inputs;  ///< SWAY_CHANNEL_BIT: received before, missing in this judgement
    uint32_t suspect_inputs;  ///< one of these is wrong, or the vehicle differs
    uint32_t rejected_inputs; ///< found wrong, excluded
    int32_t finding;          ///< sway_finding_t: the last one
    int32_t finding_size_micro;
    int32_t finding_se_micro;
#if SWAY_SUPERVISION
    int32_t relation;     ///< sway_relation_t + 256 * sway_relation_state_t; another one each time
    int32_t relation_ppm; ///< its residual over the size of its terms, over about 20 s
    int32_t relation_se_ppm; ///< what tolerances, noise, road and wind make of that: one deviation
#endif
#if SWAY_SWING
    int32_t lowest_v_crit_mm_s; ///< smallest of small swings, of those driven, of the limit
    int32_t lowest_v_crit_se_mm_s;
    int32_t lowest_v_crit_swing_urad_s; ///< the swing that it is of; 0: small
#endif
    int32_t alarm;            ///< sway_alarm_state_t
    uint32_t reasons;         ///< SWAY_REASON_*
    int32_t time_to_limit_ms; ///< until the amplitude reaches the limit at this growth
    uint32_t fault_count[SWAY_FAULT_COUNT];
} sway_status_t;

#endif

// SPDX-License-Identifier: MIT
/// sway_relations: what must hold between the inputs, whatever the driver does.
///
/// Every balance of the bodies and every kinematic relation is a linear equation between the
/// inputs and their derivatives. Weighed with a Hann window times e^(-j omega t) and summed over
/// 512 rows it is one complex equation between amplitudes: the window and its slope are zero at
/// both ends, so by partial integration a derivative is j omega in each bin of the discrete Fourier
/// transform, exactly, for any motion (modulating functions, Shinbrot 1957). No line is needed, no
/// stationarity, no differentiation of noise. Harmonics 2 to 5 of the window are used, 0.4 to 1 Hz
/// at 100 rows a second; their bins leave offsets out. Balances with tyres are taken differentiated
/// once, because slip is known by its derivative r - a/v.
///
/// A relation is built term by term: its residual, the part of every input in it, and its slope to
/// every number that may be wrong (`sway_unknown_t`). Axle forces that are not measured are
/// stiffness times slip; the force at the hitch, where it is not measured, is what the car's
/// lateral balance leaves.
#ifndef SWAY_RELATIONS_H
#define SWAY_RELATIONS_H

#include "arithmetic/sway_real.h"
#include "model/sway_phasor.h"
#include "signal/sway_grid.h"
#include "sway_vehicle.h"

/// Rows of a window, harmonics used, bins kept (from 1 on), sources (those of sway_origin_t from
/// SWAY_ORIGIN_STEERING on, and the direction of the rate of the articulation).
#define SWAY_RELATIONS_ROWS 512
#define SWAY_RELATIONS_FIRST 2
#define SWAY_RELATIONS_LAST 5
#define SWAY_RELATIONS_BINS 6
#define SWAY_RELATIONS_SENSORS 11
#define SWAY_RELATIONS_SOURCES 12

/// Errors of harmonics and relations of a window are not independent: about so many are alike.
#define SWAY_RELATIONS_ALIKE 3

typedef enum {
    SWAY_RELATION_ARTICULATION,    ///< s theta = r2 - r1
    SWAY_RELATION_HITCH,           ///< both bodies accelerate the ball alike
    SWAY_RELATION_CAR_LATERAL,     ///< where the hitch force is measured
    SWAY_RELATION_CAR_YAW,         ///< moments on the car
    SWAY_RELATION_TRAILER_LATERAL, ///< forces on the trailer
    SWAY_RELATION_TRAILER_YAW,     ///< moments on the trailer
    SWAY_RELATION_CAR_FRONT,       ///< measured force of an axle against its slip
    SWAY_RELATION_CAR_REAR,
    SWAY_RELATION_TRAILER_FRONT,
    SWAY_RELATION_TRAILER_REAR,
    SWAY_RELATION_COUNT
} sway_relation_t;

/// What may be wrong. Relative unless a unit is said.
typedef enum {
    /// Two for each sensor from SWAY_ORIGIN_STEERING on: by how much the truth is larger than what
    /// is
    /// measured, and by how much it is ahead, rad at the
    /// fourth harmonic.
    SWAY_UNKNOWN_SENSOR = 0,
    SWAY_UNKNOWN_SPEED = 2 * (SWAY_ORIGIN_ALL - 1), ///< true speed over the measured one, less 1
    SWAY_UNKNOWN_CAR_MASS,
    SWAY_UNKNOWN_CAR_INERTIA,
    SWAY_UNKNOWN_TRAILER_MASS,
    SWAY_UNKNOWN_TRAILER_INERTIA,
    SWAY_UNKNOWN_TRAILER_PLACE,  ///< m, centre of gravity nearer to the hitch
    SWAY_UNKNOWN_TRAILER_LENGTH, ///< m, hitch farther from all else
    SWAY_UNKNOWN_STIFFNESS,      ///< of each axle
    SWAY_UNKNOWN_CAR_LAG = SWAY_UNKNOWN_STIFFNESS + SWAY_AXLE_COUNT, ///< m, relaxation length
    SWAY_UNKNOWN_TRAILER_LAG,
    SWAY_UNKNOWN_FRICTION, ///< 100 Nm, dry, at the ball
    /// The same numbers once more, for what changes on the way.
    SWAY_UNKNOWN_CHANGED_STIFFNESS,
    SWAY_UNKNOWN_CHANGED_MASS = SWAY_UNKNOWN_CHANGED_STIFFNESS + SWAY_AXLE_COUNT,
    SWAY_UNKNOWN_CHANGED_PLACE,
    SWAY_UNKNOWN_ROLL, ///< gain of the accelerometers of car and trailer by the roll of the bodies
    SWAY_UNKNOWN_COUNT = SWAY_UNKNOWN_ROLL + 2
} sway_unknown_t;

/// Sums of a window in the making.
typedef struct {
    uint32_t rows;
    uint32_t known; ///< channels that were valid in every row, SWAY_CHANNEL_SPEED too
    int32_t slowest_mm_s;
    int32_t fastest_mm_s;
    int32_t largest_um_s2; ///< acceleration
    int64_t speed_mm_s;    ///< sum
    int64_t sum[SWAY_RELATIONS_SOURCES][SWAY_RELATIONS_BINS][2];
} sway_relations_sums_t;

typedef struct {
    uint8_t relation; ///< sway_relation_t
    uint8_t harmonic; ///< SWAY_RELATIONS_FIRST to SWAY_RELATIONS_LAST
    uint8_t term;     ///< that comes next
    uint32_t known;   ///< bit of each source
    const sway_vehicle_t *vehicle;
    sway_real_t speed_m_s;
    sway_real_t bin_rad_s; ///< between two bins
    sway_complex_t bin[SWAY_RELATIONS_SOURCES][SWAY_RELATIONS_BINS];
    sway_complex_t part[SWAY_RELATIONS_SOURCES]; ///< of the residual
    sway_real_t noise;                           ///< its variance by the noise of the sensors
    sway_real_t size_squared;                    ///< of the terms
    sway_complex_t residual;
    sway_complex_t slope[SWAY_UNKNOWN_COUNT]; ///< of the residual
} sway_relations_t;

/// Adds a row; true: the window is full.
bool sway_relations_add(sway_relations_sums_t *sums, const sway_row_t *row);

/// Takes a full window over. False: it is of no use, too slow, braking, or beyond the linear range.
/// `vehicle` must stay.
bool sway_relations_start(sway_relations_t *relations, const sway_vehicle_t *vehicle,
                          const sway_relations_sums_t *sums, int32_t sample_period_us);

/// Whether the inputs and the vehicle allow a relation.
bool sway_relations_allow(const sway_relations_t *relations, sway_relation_t relation);

/// Begins with a relation that is allowed, at a harmonic.
void sway_relations_begin(sway_relations_t *relations, sway_relation_t relation, uint32_t harmonic);

/// Whether the relation that was begun can be asked at its harmonic.
bool sway_relations_is_driven(const sway_relations_t *relations);

/// One slice, a term; false: residual and slopes are complete.
bool sway_relations_run(sway_relations_t *relations);

/// Variance of the residual's real part, and of its imaginary one: from the sensors' noise, what
/// the road and the wind do unseen, and what a linear model leaves out; SWAY_RELATIONS_ALIKE times.
sway_real_t sway_relations_variance(const sway_relations_t *relations);

#endif

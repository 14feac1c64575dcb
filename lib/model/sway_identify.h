// SPDX-License-Identifier: MIT
/// sway_identify: slips, forces, stiffnesses, loads and inertias of one estimated line.
///
/// All relations are those of the bodies (ch. 4.4 of the reference) at s = growth + j omega instead
/// of j omega: an amplitude that grows or decays is differentiated exactly. Where forces are not
/// measured they are taken from the balances of the bodies, in this order:
///   - force of the car on the trailer: hitch sensor; else the car's lateral balance with its wheel
///     forces; else both balances of the trailer (its yaw inertia is then the user's);
///   - trailer axles: wheel forces; else the total from the lateral balance, shared by two axles in
///     the ratio of the user's stiffnesses times the measured slips (better than the equal forces
///     of Eq. 4.8; equal stiffnesses where the user's are not known);
///   - car axles: wheel forces; else the car's lateral and yaw balances (the user's yaw inertia).
/// An inertia is identified only where no force was derived from it. Where the trailer's is, so is
/// what rubs or damps at the ball: it makes that inertia complex.
#ifndef SWAY_IDENTIFY_H
#define SWAY_IDENTIFY_H

#include "signal/sway_line.h"
#include "model/sway_phasor.h"
#include "sway_status.h"
#include "sway_vehicle.h"

/// A result with the standard error of its real part (the same as of its imaginary part).
typedef struct {
    sway_complex_t value;
    sway_real_t se;
} sway_estimate_t;

typedef struct {
    bool derived;       ///< the force is from balances: side force of wind and road is in it
    sway_real_t load_n; ///< mean
    sway_real_t effective_load_n; ///< Eq. 4.13, phase against the slip squared
    sway_real_t effective_load_se_n;
    sway_complex_t load_harmonic_n; ///< at 2f, turned back by twice the phase of the force
    sway_estimate_t stiffness;      ///< force / slip, N/rad
    sway_phasor_t slip;             ///< rad, positive: force to the left
    sway_phasor_t force;            ///< N, both wheels
} sway_axle_estimate_t;

/// Whether the build has any channel of a force: without, no inertia can be identified.
#define SWAY_IDENTIFY_FORCES (SWAY_CHANNELS > 7)

typedef struct {
    uint8_t step;
    bool rubs;        ///< something rubs or damps at the ball: damping_nms and its error are known
    uint32_t valid;   ///< SWAY_VALID_* of what is identified
    uint32_t quality; ///< SWAY_QUALITY_*
    const sway_vehicle_t *vehicle;
    const sway_line_t *line;
    sway_real_t speed_m_s;
    sway_real_t damping_nms; ///< moment at the ball over articulation rate in this swing
    sway_real_t damping_se_nms;
    sway_real_t unsure_force_n; ///< what its error puts into forces of the car that are derived
    sway_estimate_t
        freed_inertia[2];            ///< car, trailer: real, without what rubs or damps at the ball
    sway_estimate_t car_inertia;     ///< Eq. 4.18
    sway_estimate_t trailer_inertia; ///< Eq. 4.19 with the forces of `axle`
    sway_estimate_t trailer_inertia_1; ///< method 1, Eq. 4.20: equal axle forces
    sway_estimate_t trailer_inertia_2; ///< method 2, Eq. 4.23: stiffness in proportion to load
    sway_sources_t sources;
    sway_phasor_t s;
    sway_phasor_t hitch;        ///< force of the car on the trailer, trailer axes
    sway_phasor_t hitch_on_car; ///< force of the trailer on the car, car axes
    sway_axle_estimate_t axle[SWAY_AXLE_COUNT];
} sway_identify_t;

/// Begins. SWAY_ERROR_SPEED: speed not known or below 30 km/h; SWAY_ERROR_NO_DATA: the line's flags
/// say that there is no oscillation to identify from; quality says which. `vehicle` and `line` must
/// stay as they are until sway_identify_run() has returned false.
sway_error_t sway_identify_start(sway_identify_t *identify, const sway_vehicle_t *vehicle,
                                 const sway_line_t *line);

/// What the next slice costs about, in the unit of SWAY_SLICE_COST.
uint32_t sway_identify_cost(const sway_identify_t *identify);

/// One slice; true while more is to be done.
bool sway_identify_run(sway_identify_t *identify);

#endif

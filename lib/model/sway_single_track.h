// SPDX-License-Identifier: MIT
/// sway_single_track: the linear single-track model of a car with or without a trailer.
///
/// Corrected model of appendix A.2 of the reference (see DESIGN.md for the errata). Instead of the
/// 4x4 state matrix its characteristic polynomial is used in closed form. With the rigid motions of
/// each body (lateral, yaw) and the hitch force eliminated it is
///
///     f(s, v) = P_car(s, v) Q_trailer(s, v) + P_trailer(s, v) Q_car(s, v)
///     P = m I s^2 + (m sum C x^2 + I sum C) s/v + C_f C_r (x_f - x_r)^2 / v^2 - m sum C x
///     Q = (I + m h^2) s^2 + (sum C d^2) s/v - sum C d,            d = x - h
///
/// where x is the place of an axle and h that of the hitch, ahead of the body's own centre of
/// gravity: P is the body free in yaw and lateral motion, Q the body turning about the hitch. A car
/// without trailer has f = P_car. An axle may have a relaxation length sigma, so that its stiffness
/// is C/(1 + sigma s/v): the argument of an identified stiffness enters the model this way.
#ifndef SWAY_SINGLE_TRACK_H
#define SWAY_SINGLE_TRACK_H

#include "arithmetic/sway_real.h"
#include "sway_status.h"
#include "sway_vehicle.h"

enum { SWAY_SINGLE_TRACK_CAR, SWAY_SINGLE_TRACK_TRAILER };

/// One body in SI units.
typedef struct {
    sway_real_t mass_kg;
    sway_real_t yaw_inertia_kgm2;
    sway_real_t axle_m[2];              ///< ahead of the COG: front, rear
    sway_real_t hitch_m;                ///< ahead of the COG
    sway_real_t stiffness_n_per_rad[2]; ///< of an axle, steady state; 0: no such axle
    sway_real_t relaxation_m[2];        ///< sigma; 0: the force follows the slip at once
} sway_single_track_body_t;

typedef struct {
    bool has_trailer;
    sway_single_track_body_t body[2];
} sway_single_track_t;

/// Coefficients a[k] of s^k; a[3] = a[4] = 0 without trailer. Relaxation is not in them.
typedef struct {
    sway_real_t a[5];
} sway_single_track_quartic_t;

/// The four roots of a quartic (two of a car without trailer) and how far they are found.
typedef struct {
    sway_complex_t root[4];
    int32_t count;
} sway_single_track_roots_t;

/// Steady state, Eq. 3.19-3.35.
typedef struct {
    sway_real_t understeer_gradient_rad;             ///< K_u of the car alone (3.20)
    sway_real_t combination_understeer_gradient_rad; ///< K_u' or K_u'' with the trailer
    sway_real_t effective_wheelbase_m;               ///< L (3.27)
    sway_real_t yaw_rate_gain_1_s;                   ///< yaw rate per road-wheel angle (3.26)
    sway_real_t hitch_angle_gain;                    ///< psi2 - psi1 per road-wheel angle (3.33)
    sway_real_t characteristic_speed_m_s; ///< > 0 where it understeers; < 0: minus critical speed
} sway_single_track_static_t;

/// Limits of the search for a critical speed: 10 and 250 km/h.
sway_real_t sway_single_track_speed_low(void);
sway_real_t sway_single_track_speed_high(void);

/// The user's vehicle. SWAY_ERROR_VEHICLE where sway_vehicle_is_complete() is false.
sway_error_t sway_single_track_from_vehicle(sway_single_track_t *stm,
                                            const sway_vehicle_t *vehicle);

/// f(s, v), relaxation included. v > 0. About 33,000 instructions on a Cortex-M0+.
sway_complex_t sway_single_track_characteristic(const sway_single_track_t *stm, sway_complex_t s,
                                                sway_real_t v);

/// Coefficients of f at v > 0 for steady-state stiffnesses.
sway_single_track_quartic_t sway_single_track_quartic(const sway_single_track_t *stm,
                                                      sway_real_t v);

/// Critical speed of the steady-state stiffnesses. The Hurwitz determinant divided by 1/v^2 is a
/// quadratic in 1/v^2 for this model, so its first zero from low speed needs no iteration.
/// `omega_rad_s` is the frequency at it (0 for SWAY_VCRIT_DIVERGENCE).
sway_vcrit_t sway_single_track_critical_speed(const sway_single_track_t *stm, sway_real_t *v_m_s,
                                              sway_real_t *omega_rad_s);

/// Starts Durand-Kerner iteration for all roots at once.
void sway_single_track_roots_start(sway_single_track_roots_t *roots,
                                   const sway_single_track_quartic_t *quartic);
/// One sweep; true when the roots have settled to 1e-7 of their size.
bool sway_single_track_roots_sweep(sway_single_track_roots_t *roots,
                                   const sway_single_track_quartic_t *quartic);
/// The oscillating root (imaginary part > 0) of the smallest damping ratio; the real root that is
/// furthest right if none oscillates.
sway_complex_t sway_single_track_dominant(const sway_single_track_roots_t *roots);

/// Damping ratio -Re s/|s| (3.39); 0 for s = 0.
sway_real_t sway_single_track_damping_ratio(sway_complex_t s);
/// Its change with the root: (ds_im re - ds_re im) im / |s|^3. A root that does not oscillate has a
/// ratio of 1 or -1 whatever its size.
sway_real_t sway_single_track_damping_change(sway_complex_t s, sway_complex_t ds);

/// df/ds or df/dv at (s, v), a central difference in two slices: with `half` 0 `f` becomes f a
/// little above (false), after that the slope (true).
bool sway_single_track_slope_s(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v,
                               uint32_t half, sway_complex_t *f);
bool sway_single_track_slope_v(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v,
                               uint32_t half, sway_complex_t *f);
/// Change of f for +1 % of a parameter.
sway_complex_t sway_single_track_slope_parameter(const sway_single_track_t *stm, sway_complex_t s,
                                                 sway_real_t v, sway_parameter_t parameter);
/// The parameter exists in this model (trailer, axle present, not 0).
bool sway_single_track_has_parameter(const sway_single_track_t *stm, sway_parameter_t parameter);

/// Speed and frequency changes that keep f(j omega, v) = 0 when f changes by `df`: the solution of
/// f_s j d_omega + f_v d_v = -df. SWAY_ERROR_SINGULAR where there is none.
sway_error_t sway_single_track_shift(sway_complex_t f_s, sway_complex_t f_v, sway_complex_t df,
                                     sway_real_t *d_omega, sway_real_t *d_v);

/// Steady-state cornering at speed v (stiffnesses only). SWAY_ERROR_SINGULAR at a static critical
/// speed or without rear axle stiffness.
sway_error_t sway_single_track_steady_state(const sway_single_track_t *stm, sway_real_t v,
                                            sway_single_track_static_t *result);

#endif

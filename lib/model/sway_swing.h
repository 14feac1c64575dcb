// SPDX-License-Identifier: MIT
/// sway_swing: the critical speed of swings of another size than those that were driven.
///
/// A tyre's force levels off: in a swing its stiffness C (force over slip amplitude) falls with the
/// slip amplitude a as 1/C^2 = 1/C_small^2 + a^2 / (2 peak^2), within 2 % the describing function
/// of peak tanh(C_small a / peak). Force and slip amplitudes grow with the swing A, so in a swing A
///
///     (C_seen / C)^2 = 1 + y,   y = (A^2 - A_seen^2) (F / A)^2 / (2 peak^2),
///
/// F / A is each axle's force amplitude over the swing, learnt from free oscillations. v_crit
/// follows by its sensitivities as a power law, v_crit product (1 + y)^(-e/2), e = 100 * change for
/// +1 % / v_crit: exact where all stiffnesses fall alike.
///
/// The peak is not observable in small swings. It is assumed: 0.9 times the axle's load, measured,
/// or of the vehicle at rest, a tandem's halfway between equal shares and those by its centre of
/// gravity. y may be off by 60 % (friction 0.9 +- 0.15, a tandem's shares, the shape of the curve),
/// of all axles alike; that is in the standard error.
#ifndef SWAY_SWING_H
#define SWAY_SWING_H

#include "model/sway_identify.h"
#include "model/sway_margin.h"

typedef struct {
    sway_real_t peak_n[SWAY_AXLE_COUNT];  ///< 0: there is no such axle
    sway_real_t force_2[SWAY_AXLE_COUNT]; ///< sums over estimates, old ones fading: N^2,
    sway_real_t swing_2[SWAY_AXLE_COUNT]; ///< (rad/s)^2 of the trailer's yaw rate (a solo car's),
    sway_real_t swing_4[SWAY_AXLE_COUNT]; ///< (rad/s)^4
} sway_swing_t;

typedef struct {
    sway_real_t v_crit_m_s;
    sway_real_t se_m_s;
} sway_swing_speed_t;

void sway_swing_init(sway_swing_t *swing, const sway_vehicle_t *vehicle);

/// Takes the axles that an estimate of a free oscillation of this amplitude has identified.
void sway_swing_take(sway_swing_t *swing, const sway_identify_t *identify, sway_real_t swing_rad_s);

/// Critical speed of swings of `swing_rad_s` (0: small ones). `model` has a limit. False: an axle
/// has not been seen in a free oscillation yet.
bool sway_swing_speed(const sway_swing_t *swing, const sway_margin_model_t *model,
                      sway_real_t swing_rad_s, sway_swing_speed_t *speed);

#endif

// SPDX-License-Identifier: MIT
/// sway_quantity: one quantity of the model, filtered over many estimates.
///
/// A scalar Kalman filter for each part: it starts at the user's value with the user's likely
/// error, drifts a little with time, and takes every usable estimate by its variance. Windows
/// overlap 16-fold, so an estimate counts as one of SWAY_QUANTITY_OVERLAP. In a swing that
/// fades an estimate below the value so far counts with its relative error times that value.
///
/// Where the force is made of balances, wind and road are in it, and in the motion, too: force
/// over slip then tends to what would make the swing neither grow nor decay. What began before
/// does not know the wind of now, so such an estimate counts by the share of the swing that the
/// motion before predicts (an instrumental variable), and many of them together leave
/// an error that they have in common.
#ifndef SWAY_QUANTITY_H
#define SWAY_QUANTITY_H

#include "model/sway_identify.h"

/// Estimates that overlap enough to share their noise; those from balances, which count by a
/// share besides.
#define SWAY_QUANTITY_OVERLAP 8
#define SWAY_QUANTITY_OVERLAP_DERIVED 4

/// Of the variance of one estimate from balances whose swing nothing predicted, as a power of 2:
/// what all of them together leave; of others in the square of the share that was not predicted.
#define SWAY_QUANTITY_COMMON (-2)

/// One filtered quantity: complex stiffness of an axle in N/rad, or a yaw inertia in kgm2
/// (imaginary part 0); variances in their squares.
typedef struct {
    bool strange;    ///< the last estimate did not fit
    bool started;    ///< has a value
    bool identified; ///< at least one estimate is in it
    sway_complex_t value;
    sway_real_t variance_re;
    sway_real_t variance_im;
    sway_complex_t s_by_v; ///< 1/m, of the last estimate: what the imaginary part belongs to
    int64_t time_us;       ///< of the last prediction
} sway_quantity_t;

/// Starts from the user's value (0: none), its relative standard error, and that of its lag.
void sway_quantity_start(sway_quantity_t *quantity, sway_real_t value, int32_t re_ppm,
                         int32_t im_ppm);

/// Lets time go on: the true value may have drifted, by so much of it in the root of a second.
void sway_quantity_drift(sway_quantity_t *quantity, int64_t time_us, int32_t re_ppm,
                         int32_t im_ppm);

/// Takes an estimate made at complex frequency over speed `s_by_v`, in 1/m. `predicted`: NULL, or
/// where it comes from balances, the share of its swing that was predicted, 0..1. Where two
/// in a row are farther off than drift explains, the value so far grows less certain with each.
void sway_quantity_take(sway_quantity_t *quantity, const sway_estimate_t *estimate,
                        sway_complex_t s_by_v, const sway_real_t *predicted);

#endif

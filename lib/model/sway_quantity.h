// SPDX-License-Identifier: MIT
/// sway_quantity: one quantity of the model, filtered over many estimates.
///
/// A scalar Kalman filter for each part: it starts at the user's value with the user's likely
/// error, drifts a little with time, and takes every usable estimate by its variance. Windows
/// overlap 16-fold, so an estimate counts as one of SWAY_QUANTITY_OVERLAP. In a swing that
/// fades an estimate below the value so far counts with its relative error times that value.
#ifndef SWAY_QUANTITY_H
#define SWAY_QUANTITY_H

#include "model/sway_identify.h"

/// Estimates that overlap enough to share their noise.
#define SWAY_QUANTITY_OVERLAP 8

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

/// Takes an estimate made at complex frequency over speed `s_by_v`, in 1/m. Where two in a row are
/// farther off than drift explains, the value so far grows less certain with each of them.
void sway_quantity_take(sway_quantity_t *quantity, const sway_estimate_t *estimate,
                        sway_complex_t s_by_v);

#endif

// SPDX-License-Identifier: MIT
/// sway_change: does a damped line go through the whole window unchanged?
///
/// A step or an onset within the window is fitted by some damped line too, with a growth that is
/// not there. If amplitude or phase change at a block by the complex factor 1 + m in all channels
/// alike, the residuals r of all channels, turned back by their lines, add up behind it:
///     score = sum over channels 1/variance sum over blocks behind of r times the line
///     m = score / information,  chi-square of 2 degrees of freedom = |score|^2 / information
/// (score test). The information is that of a change behind the block, less what amplitude, phase,
/// growth and frequency of the line take up of it. Changes are looked for at nine blocks, closer
/// together at the ends of the window.
#ifndef SWAY_CHANGE_H
#define SWAY_CHANGE_H

#include "signal/sway_fit.h"

/// Places where a change is looked for.
#define SWAY_CHANGE_PLACES 9

/// Sums over the channels, all 0 before the first.
typedef struct {
    sway_real_t weight;                      ///< |line|^2 over the variance
    sway_complex_t part[SWAY_CHANGE_PLACES]; ///< from a place to the next: residual times the line
                                             ///< over the variance, a quarter turn later (im)
} sway_change_sums_t;

/// Adds a channel whose line is Re(line z): its residuals, |residual| < 2^29, 0 where there is no
/// data, and the variance of a block.
void sway_change_add(sway_change_sums_t *sums, const sway_fit_basis_t *basis, sway_complex_t line,
                     sway_real_t variance, const int32_t *residual);

/// The block before which the clearest break lies, 1..blocks; 0 where there is none. A break is a
/// change by more than a tenth with a chi-square above 20 (5e-5 in noise).
uint32_t sway_change_find(const sway_change_sums_t *sums, const sway_fit_basis_t *basis);

#endif

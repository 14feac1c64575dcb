// SPDX-License-Identifier: MIT
/// sway_residual: what the residuals of a fit say, besides their size.
#ifndef SWAY_RESIDUAL_H
#define SWAY_RESIDUAL_H

#include "arithmetic/sway_real.h"

/// Bits of the blocks more than 6 robust standard deviations off (an impulse, a wrong value):
/// beyond 9 medians of the magnitude. n = 1..SWAY_FIT_BLOCKS; |residual| < 2^29.
uint64_t sway_residual_outliers(const int32_t *residual, uint32_t n);

/// (1 + rho) / (1 - rho) where neighbours correlate by rho > 0.35, which white noise does not
/// reach, else 1: by that much a slow disturbance has more power near the line than on average.
/// `squares` is the sum of the squares.
sway_real_t sway_residual_inflation(const int32_t *residual, uint32_t n, sway_real_t squares);

#endif

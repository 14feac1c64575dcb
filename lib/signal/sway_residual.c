// SPDX-License-Identifier: MIT
#include "signal/sway_residual.h"

#include "signal/sway_fit.h"
#include "arithmetic/sway_int64.h"

static int32_t median_magnitude(const int32_t *x, uint32_t n)
{
    int32_t sorted[SWAY_FIT_BLOCKS];
    sorted[0] = 0; // of no blocks
    for (uint32_t i = 0; i < n; i++) {
        const int32_t value = x[i] < 0 ? -x[i] : x[i];
        uint32_t at = i;
        for (; at > 0U && sorted[at - 1U] > value; at--) {
            sorted[at] = sorted[at - 1U];
        }
        sorted[at] = value;
    }
    return sorted[n / 2U];
}

/* Whether more than half of the blocks reach a ninth of the largest: then the median does, and no
 * block is off. Saves sorting nearly always. */
static bool is_even(const int32_t *residual, uint32_t n)
{
    int32_t largest = 0;
    uint32_t reach = 0;
    for (uint32_t b = 0; b < n; b++) {
        const int32_t size = residual[b] < 0 ? -residual[b] : residual[b];
        largest = size > largest ? size : largest;
    }
    const int32_t ninth = (int32_t)(((uint32_t)largest + 8U) / 9U);
    for (uint32_t b = 0; b < n; b++) {
        const int32_t size = residual[b] < 0 ? -residual[b] : residual[b];
        reach += size >= ninth ? 1U : 0U;
    }
    return 2U * reach > n;
}

uint64_t sway_residual_outliers(const int32_t *residual, uint32_t n)
{
    uint64_t wrong = 0;
    if (is_even(residual, n)) {
        return 0;
    }
    const int64_t limit = 9 * (int64_t)median_magnitude(residual, n) + 2; // 1.48 * 6
    for (uint32_t b = 0; b < n; b++) {
        if (residual[b] > limit || residual[b] < -limit) {
            wrong |= UINT64_C(1) << b;
        }
    }
    return wrong;
}

sway_real_t sway_residual_inflation(const int32_t *residual, uint32_t n, sway_real_t squares)
{
    const int64_t sum = sway_int64_dot(residual + 1, residual, n - 1U);
    const sway_real_t one = sway_real_int(1);
    const sway_real_t rho =
        sway_real_min(sway_real_div(sway_real(sum, 0), squares), sway_real_ratio(95, 100));
    if (sway_real_less(rho, sway_real_ratio(35, 100))) {
        return one;
    }
    return sway_real_div(sway_real_add(one, rho), sway_real_sub(one, rho));
}

// SPDX-License-Identifier: MIT
#include "model/sway_kalman.h"

#include "arithmetic/sway_real_ops.h"

/* Less of a tolerance's variance than this, x 1e-6, is nothing learnt. */
#define LEARNT_PPM 2000

static size_t place(uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b;
    const uint32_t high = a < b ? b : a;
    return (size_t)high * (high + 1U) / 2U + low;
}

static sway_real_t prior(const sway_kalman_t *gauss, uint32_t i)
{
    return sway_real_square(sway_real_micro(gauss->tolerance_ppm[i]));
}

void sway_kalman_reset(sway_kalman_t *gauss)
{
    for (uint32_t i = 0; i < gauss->count; i++) {
        gauss->value[i] = sway_real_zero();
        for (uint32_t j = 0; j < i; j++) {
            gauss->covariance[place(i, j)] = sway_real_zero();
        }
        gauss->covariance[place(i, i)] = prior(gauss, i);
    }
    gauss->row = 0;
}

static bool fades(uint64_t fading, uint32_t i)
{
    return (fading >> i & 1U) != 0U;
}

static void fade_row(sway_kalman_t *gauss, uint32_t i, uint64_t fading, sway_real_t keep)
{
    const bool own = fades(fading, i);
    for (uint32_t j = 0; j <= i; j++) {
        sway_real_t *const c = &gauss->covariance[place(i, j)];
        *c = own ? MUL(*c, keep) : *c;
        *c = fades(fading, j) ? MUL(*c, keep) : *c;
    }
    if (own) {
        const sway_real_t lost = SUB(sway_real_int(1), sway_real_square(keep));
        sway_real_t *const c = &gauss->covariance[place(i, i)];
        *c = ADD(*c, MUL(prior(gauss, i), lost));
        gauss->value[i] = MUL(gauss->value[i], keep);
    }
}

bool sway_kalman_fade(sway_kalman_t *gauss, uint64_t fading, int32_t keep_ppm)
{
    const sway_real_t keep = sway_real_micro(keep_ppm);
    uint32_t products = 0;
    while (gauss->row < gauss->count && products < SWAY_KALMAN_CHUNK) {
        fade_row(gauss, gauss->row, fading, keep);
        gauss->row++;
        products += gauss->row;
    }
    const bool more = gauss->row < gauss->count;
    gauss->row = more ? gauss->row : 0U;
    return more;
}

/* --- a relation --------------------------------------------------------------------------------
 */

static uint32_t move_row(sway_kalman_t *gauss, uint32_t i)
{
    sway_real_t sum = sway_real_zero();
    uint32_t products = 0;
    for (uint32_t j = 0; j < gauss->count; j++) {
        const sway_real_t c = gauss->covariance[place(i, j)];
        if (!sway_real_is_zero(gauss->slope[j]) && !sway_real_is_zero(c)) {
            sum = ADD(sum, MUL(c, gauss->slope[j]));
            products++;
        }
    }
    gauss->moved[i] = sum;
    return products + 4U;
}

static void weigh(sway_kalman_t *gauss, sway_real_t residual, sway_real_t variance)
{
    sway_real_t innovation = residual;
    for (uint32_t i = 0; i < gauss->count; i++) {
        if (!sway_real_is_zero(gauss->slope[i])) {
            variance = ADD(variance, MUL(gauss->slope[i], gauss->moved[i]));
            innovation = ADD(innovation, MUL(gauss->slope[i], gauss->value[i]));
        }
    }
    /* What is off by more than three standard errors is a gust, or a fault that will be seen again:
     * it counts as three. */
    variance = sway_real_max(variance, DIV(sway_real_square(innovation), sway_real_int(9)));
    gauss->by_variance = DIV(sway_real_int(1), variance);
    gauss->gain = MUL(innovation, gauss->by_variance);
}

static uint32_t correct_row(sway_kalman_t *gauss, uint32_t i)
{
    const sway_real_t moved = gauss->moved[i];
    if (sway_real_is_zero(moved)) {
        return 1U;
    }
    const sway_real_t share = MUL(moved, gauss->by_variance);
    for (uint32_t j = 0; j <= i; j++) {
        if (!sway_real_is_zero(gauss->moved[j])) {
            sway_real_t *const c = &gauss->covariance[place(i, j)];
            *c = SUB(*c, MUL(share, gauss->moved[j]));
        }
    }
    gauss->value[i] = SUB(gauss->value[i], MUL(moved, gauss->gain));
    return i + 4U;
}

bool sway_kalman_take(sway_kalman_t *gauss, sway_real_t residual, sway_real_t variance)
{
    const uint32_t n = gauss->count;
    uint32_t products = 0;
    while (gauss->row < n && products < SWAY_KALMAN_CHUNK) {
        products += move_row(gauss, gauss->row);
        gauss->row++;
        if (gauss->row == n) {
            weigh(gauss, residual, variance);
            products += n;
        }
    }
    while (gauss->row >= n && gauss->row < 2U * n && products < SWAY_KALMAN_CHUNK) {
        products += correct_row(gauss, gauss->row - n);
        gauss->row++;
    }
    const bool more = gauss->row < 2U * n;
    gauss->row = more ? gauss->row : 0U;
    return more;
}

/* --- what it is worth --------------------------------------------------------------------------
 */

static bool is_learnt(const sway_kalman_t *gauss, uint32_t i)
{
    const sway_real_t before = prior(gauss, i);
    const sway_real_t left = SUB(before, gauss->covariance[place(i, i)]);
    return sway_real_less(MUL(before, sway_real_micro(LEARNT_PPM)), left);
}

/* x' (P - S)^-1 x by elimination; directions in which nothing was learnt are left out. */
sway_real_t sway_kalman_worth(const sway_kalman_t *gauss, const uint8_t *group, uint32_t size)
{
    sway_real_t m[SWAY_KALMAN_GROUP][SWAY_KALMAN_GROUP];
    sway_real_t x[SWAY_KALMAN_GROUP];
    sway_real_t worth = sway_real_zero();
    for (uint32_t i = 0; i < size; i++) {
        x[i] = gauss->value[group[i]];
        for (uint32_t j = 0; j < size; j++) {
            m[i][j] = NEG(gauss->covariance[place(group[i], group[j])]);
        }
        m[i][i] = ADD(m[i][i], prior(gauss, group[i]));
    }
    for (uint32_t k = 0; k < size; k++) {
        const sway_real_t least = MUL(prior(gauss, group[k]), sway_real_micro(LEARNT_PPM));
        if (sway_real_less(m[k][k], least)) {
            continue;
        }
        worth = ADD(worth, DIV(sway_real_square(x[k]), m[k][k]));
        for (uint32_t i = k + 1U; i < size; i++) {
            const sway_real_t factor = DIV(m[i][k], m[k][k]);
            x[i] = SUB(x[i], MUL(factor, x[k]));
            for (uint32_t j = k + 1U; j < size; j++) {
                m[i][j] = SUB(m[i][j], MUL(factor, m[k][j]));
            }
        }
    }
    return worth;
}

void sway_kalman_free(const sway_kalman_t *gauss, uint32_t index, sway_real_t *value,
                      sway_real_t *se)
{
    *value = gauss->value[index];
    *se = sway_real_zero();
    if (is_learnt(gauss, index)) {
        const sway_real_t before = prior(gauss, index);
        const sway_real_t variance = gauss->covariance[place(index, index)];
        const sway_real_t free = DIV(before, SUB(before, variance));
        *value = MUL(*value, free);
        *se = sway_real_sqrt(MUL(variance, free));
    }
}

sway_real_t sway_kalman_covariance(const sway_kalman_t *gauss, uint32_t a, uint32_t b)
{
    return gauss->covariance[place(a, b)];
}

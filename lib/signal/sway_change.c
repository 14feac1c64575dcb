// SPDX-License-Identifier: MIT
#include "signal/sway_change.h"

#include "arithmetic/sway_int64.h"

/* Parts of a window, shorter at its ends. Behind each but the last is a place. */
#define PARTS (SWAY_CHANGE_PLACES + 1U)

/* sum + a b */
SWAY_INLINE sway_real_t mac(sway_real_t sum, sway_real_t a, sway_real_t b)
{
    return sway_real_add(sum, sway_real_mul(a, b));
}

/* First block behind the part. */
static uint32_t part_end(const sway_fit_basis_t *basis, uint32_t part)
{
    static const uint8_t end_16[PARTS] = {1, 2, 4, 6, 8, 10, 12, 14, 15, 16};
    return end_16[part] * basis->blocks / 16U;
}

void sway_change_add(sway_change_sums_t *sums, const sway_fit_basis_t *basis, sway_complex_t line,
                     sway_real_t variance, const int32_t *residual)
{
    const sway_complex_t weighted =
        sway_complex_scale(line, sway_real_div(sway_real_int(1), variance));
    sums->weight = mac(mac(sums->weight, line.re, weighted.re), line.im, weighted.im);
    for (uint32_t place = 0; place < SWAY_CHANGE_PLACES; place++) {
        sway_complex_t *const sum = &sums->part[place];
        const uint32_t b = part_end(basis, place);
        const uint32_t n = part_end(basis, place + 1U) - b;
        /* below 8 * 2^29 * 2^28 */
        const int64_t re = sway_int64_dot(residual + b, basis->column[0] + b, n);
        const int64_t im = sway_int64_dot(residual + b, basis->column[1] + b, n);
        const sway_real_t by_re = sway_real(re, -SWAY_FIT_BITS);
        const sway_real_t by_im = sway_real(im, -SWAY_FIT_BITS);
        sum->re = mac(mac(sum->re, weighted.re, by_re), weighted.im, by_im);
        sum->im =
            sway_real_sub(mac(sum->im, weighted.re, by_im), sway_real_mul(weighted.im, by_re));
    }
}

/* Moments about the middle of the window, each block weighted by |z|^2: sums of weight, weight tau
 * in Q24 more, weight tau^2 in Q24 more. */
typedef struct {
    int64_t sum[3];
} moments_t;

static moments_t moments_of(const sway_fit_basis_t *basis, uint32_t first, uint32_t last)
{
    moments_t moments = {{0, 0, 0}};
    for (uint32_t b = first; b < last; b++) {
        const int32_t re = basis->column[0][b];
        const int32_t im = basis->column[1][b];
        const int32_t tau = basis->column[3][b] / 16; // Q24
        const int32_t weight = (int32_t)((sway_int64_product(re, re) + sway_int64_product(im, im)) /
                                         (INT64_C(1) << SWAY_FIT_BITS));
        const int64_t turned = sway_int64_product(weight, tau); // below 2^29 * 2^24
        moments.sum[0] += weight;
        moments.sum[1] += turned;
        moments.sum[2] += sway_int64_product((int32_t)(turned / (INT64_C(1) << 24)), tau);
    }
    return moments;
}

static void add_moments(const moments_t *moments, sway_real_t *total)
{
    total[0] = sway_real_add(total[0], sway_real(moments->sum[0], -SWAY_FIT_BITS));
    total[1] = sway_real_add(total[1], sway_real(moments->sum[1], -SWAY_FIT_BITS - 24));
    total[2] = sway_real_add(total[2], sway_real(moments->sum[2], -SWAY_FIT_BITS - 24));
}

/* Information on a change where `tail` begins, for unit weight of the channels: what amplitude and
 * phase, growth and frequency do not take up. */
static sway_real_t change_information(const sway_real_t *tail, const sway_real_t *all)
{
    const sway_real_t det = sway_real_sub(sway_real_mul(all[0], all[2]), sway_real_square(all[1]));
    const sway_real_t mixed = sway_real_mul(sway_real_mul(tail[0], tail[1]), all[1]);
    const sway_real_t taken = sway_real_sub(
        mac(sway_real_mul(sway_real_square(tail[0]), all[2]), sway_real_square(tail[1]), all[0]),
        sway_real_scale(mixed, 1));
    return sway_real_sub(tail[0], sway_real_div(taken, det));
}

uint32_t sway_change_find(const sway_change_sums_t *sums, const sway_fit_basis_t *basis)
{
    const sway_real_t weight = sway_real_scale(sums->weight, -1);
    const sway_real_t none = sway_real_zero();
    sway_real_t all[3] = {none, none, none};
    sway_real_t tail[3] = {none, none, none};
    sway_complex_t score = sway_complex(none, none);
    sway_real_t clearest = sway_real_int(20);
    uint32_t found = 0;
    moments_t moments[PARTS];
    moments_t whole = {{0, 0, 0}};
    for (uint32_t part = 0; part < PARTS; part++) {
        const uint32_t first = part > 0U ? part_end(basis, part - 1U) : 0U;
        moments[part] = moments_of(basis, first, part_end(basis, part));
        for (int i = 0; i < 3; i++) {
            whole.sum[i] += moments[part].sum[i];
        }
    }
    add_moments(&whole, all);
    for (uint32_t part = PARTS - 1U; part > 0U; part--) {
        add_moments(&moments[part], tail);
        score = sway_complex_add(score, sums->part[part - 1U]);
        const sway_real_t information = sway_real_mul(weight, change_information(tail, all));
        const sway_real_t norm = sway_complex_norm(score);
        const sway_real_t chi_2 = sway_real_div(norm, information);
        const sway_real_t tenth =
            sway_real_mul(sway_real_square(information), sway_real_ratio(1, 100));
        if (sway_real_less(clearest, chi_2) && sway_real_less(tenth, norm)) {
            clearest = chi_2;
            found = part_end(basis, part);
        }
    }
    return found;
}

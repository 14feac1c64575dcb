// SPDX-License-Identifier: MIT
#include "signal/sway_fit.h"

#include "arithmetic/sway_int64.h"

#define ONE_Q28 (INT32_C(1) << SWAY_FIT_BITS)

typedef sway_fit_q30_t q30_t;

static q30_t q30_product(q30_t a, q30_t b)
{
    const q30_t product = {
        sway_int64_round(sway_int64_product(a.re, b.re) - sway_int64_product(a.im, b.im)),
        sway_int64_round(sway_int64_product(a.re, b.im) + sway_int64_product(a.im, b.re))};
    return product;
}

static void put(sway_fit_basis_t *basis, uint32_t column, uint32_t block, q30_t z)
{
    basis->column[column][block] = z.re / 4;
    basis->column[column + 1U][block] = -z.im / 4;
}

static void fill_block(sway_fit_basis_t *basis, uint32_t block, q30_t z, bool harmonics)
{
    /* tau in Q30: (2 b - n + 1) / (n - 1) */
    const int32_t span = (int32_t)basis->blocks - 1;
    const int32_t tau =
        (2 * (int32_t)block - span) * (int32_t)((UINT32_C(1) << 30) / (uint32_t)span);
    const q30_t tau_z = {sway_int64_q30(z.re, tau), sway_int64_q30(z.im, tau)};
    put(basis, 0, block, z);
    basis->column[SWAY_FIT_MEAN][block] = ONE_Q28;
    basis->column[3][block] = tau / 4;
    put(basis, SWAY_FIT_TAU_RE, block, tau_z);
    if (harmonics) {
        const q30_t z2 = q30_product(z, z);
        put(basis, 4, block, z2);
        put(basis, 6, block, q30_product(z2, z));
    }
}

static q30_t to_q30(sway_complex_t z)
{
    const q30_t result = {(int32_t)sway_real_to_int64(z.re, 30),
                          (int32_t)sway_real_to_int64(z.im, 30)};
    return result;
}

/* Columns 6 and 7 are a tone of constant size, from the same end as the line. */
static void begin_tone(sway_fit_walk_t *walk, sway_real_t half, sway_real_t omega)
{
    const sway_real_t forward = walk->backward ? sway_real_neg(omega) : omega;
    walk->has_tone = omega.m != 0;
    if (walk->has_tone) {
        walk->tone_step = to_q30(sway_complex_unit(forward));
        walk->tone = to_q30(sway_complex_unit(sway_real_neg(sway_real_mul(forward, half))));
    }
}

void sway_fit_begin(sway_fit_basis_t *basis, uint32_t blocks, const sway_fit_pole_t *pole)
{
    /* From the end where |z| = 1 towards the other, so that |z| only falls. The angle at u blocks
     * from the middle is omega u + chirp u^2 / 2: the first step turns by
     * +-omega - chirp (half - 1/2), every step by chirp more than the one before. */
    sway_fit_walk_t *const walk = &basis->walk;
    walk->backward = sway_real_sign(pole->growth) > 0;
    walk->is_bent = pole->chirp.m != 0;
    walk->done = 0;
    const sway_real_t half = sway_real_ratio((int32_t)blocks - 1, 2);
    const sway_real_t short_half = sway_real_ratio((int32_t)blocks - 2, 2);
    const sway_real_t decay = sway_real_neg(sway_real_abs(pole->growth));
    const sway_real_t omega = walk->backward ? sway_real_neg(pole->omega) : pole->omega;
    const sway_real_t bow = sway_real_scale(sway_real_mul(half, pole->chirp), -1);
    const sway_real_t start = sway_real_mul(half, sway_real_sub(bow, omega));
    const sway_real_t first = sway_real_sub(omega, sway_real_mul(pole->chirp, short_half));
    const sway_real_t fall = sway_real_exp(decay);
    walk->bend = to_q30(sway_complex_unit(pole->chirp));
    walk->step = to_q30(sway_complex_scale(sway_complex_unit(first), fall));
    walk->z = to_q30(sway_complex_unit(start));
    begin_tone(walk, half, pole->forced);
    basis->blocks = blocks;
    basis->scale = sway_real_exp(sway_real_mul(decay, half));
}

bool sway_fit_columns(sway_fit_basis_t *basis, uint32_t count, bool harmonics)
{
    sway_fit_walk_t *const walk = &basis->walk;
    for (; count > 0U && walk->done < basis->blocks; count--) {
        const uint32_t block = walk->backward ? basis->blocks - 1U - walk->done : walk->done;
        fill_block(basis, block, walk->z, harmonics);
        walk->z = q30_product(walk->z, walk->step);
        walk->step = walk->is_bent ? q30_product(walk->step, walk->bend) : walk->step;
        if (walk->has_tone) {
            put(basis, 6, block, walk->tone);
            walk->tone = q30_product(walk->tone, walk->tone_step);
        }
        walk->done++;
    }
    return walk->done < basis->blocks;
}

/* The product with the column of ones. */
static sway_real_t sum_of(const int32_t *data, uint32_t n)
{
    int64_t sum = 0;
    for (uint32_t b = 0; b < n; b++) {
        sum += data[b];
    }
    return sway_real(sum, 0);
}

sway_real_t sway_fit_product(const sway_fit_basis_t *basis, uint32_t column, const int32_t *data)
{
    if (column == SWAY_FIT_MEAN) {
        return sum_of(data, basis->blocks);
    }
    /* below 64 * 2^28 * 2^28 = 2^62 */
    return sway_real(sway_int64_dot(basis->column[column], data, basis->blocks), -SWAY_FIT_BITS);
}

/* A row of the lower triangle: entries 0..i. */
static uint32_t row_of(uint32_t i)
{
    return i * (i + 1U) / 2U;
}

static void gram_entry(sway_fit_basis_t *basis, uint32_t i, uint32_t j)
{
    const sway_real_t sum = sway_fit_product(basis, i, basis->column[j]);
    basis->gram[row_of(i) + j] = sway_real_scale(sum, -SWAY_FIT_BITS);
}

void sway_fit_gram(sway_fit_basis_t *basis, uint32_t first, uint32_t last)
{
    for (uint32_t i = first; i <= last; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            gram_entry(basis, i, j);
        }
        gram_entry(basis, SWAY_FIT_TAU_RE, i);
        gram_entry(basis, SWAY_FIT_TAU_IM, i);
    }
    if (first == 0U) {
        gram_entry(basis, SWAY_FIT_TAU_RE, SWAY_FIT_TAU_RE);
        gram_entry(basis, SWAY_FIT_TAU_IM, SWAY_FIT_TAU_RE);
        gram_entry(basis, SWAY_FIT_TAU_IM, SWAY_FIT_TAU_IM);
    }
}

void sway_fit_pin_slope(sway_fit_basis_t *basis)
{
    sway_real_t *slope = &basis->gram[row_of(SWAY_FIT_SLOPE) + SWAY_FIT_SLOPE];
    *slope = sway_real_scale(*slope, 40);
}

/* first - a[0] b[0] - .. - a[n-1] b[n-1] */
static sway_real_t less_products(sway_real_t first, const sway_real_t *a, const sway_real_t *b,
                                 uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        first = sway_real_sub(first, sway_real_mul(a[i], b[i]));
    }
    return first;
}

void sway_fit_factor(sway_fit_basis_t *basis, uint32_t first, uint32_t last)
{
    for (uint32_t i = first; i <= last; i++) {
        sway_real_t *row = &basis->gram[row_of(i)];
        sway_real_t scaled[SWAY_FIT_LINEAR]; // L[i][j] d[j]
        for (uint32_t j = 0; j < i; j++) {
            const sway_real_t *above = &basis->gram[row_of(j)];
            scaled[j] = less_products(row[j], scaled, above, j);
            row[j] = sway_real_mul(scaled[j], above[j]);
        }
        row[i] = sway_real_div(sway_real_int(1), less_products(row[i], scaled, row, i));
    }
}

void sway_fit_solve(const sway_fit_basis_t *basis, uint32_t n, const sway_real_t *right,
                    sway_real_t *x)
{
    for (uint32_t i = 0; i < n; i++) {
        x[i] = less_products(right[i], &basis->gram[row_of(i)], x, i);
    }
    for (uint32_t i = n; i-- > 0U;) {
        sway_real_t sum = sway_real_mul(x[i], basis->gram[row_of(i) + i]);
        for (uint32_t k = i + 1U; k < n; k++) {
            sum = sway_real_sub(sum, sway_real_mul(basis->gram[row_of(k) + i], x[k]));
        }
        x[i] = sum;
    }
}

sway_real_t sway_fit_dot(const sway_real_t *a, const sway_real_t *b, uint32_t n)
{
    sway_real_t sum = sway_real_mul(a[0], b[0]);
    for (uint32_t i = 1; i < n; i++) {
        sum = sway_real_add(sum, sway_real_mul(a[i], b[i]));
    }
    return sum;
}

void sway_fit_cross(sway_fit_system_t *system, const sway_fit_basis_t *basis, uint32_t n)
{
    const sway_real_t *re = &basis->gram[row_of(SWAY_FIT_TAU_RE)];
    const sway_real_t *im = &basis->gram[row_of(SWAY_FIT_TAU_IM)];
    system->n = n;
    sway_fit_solve(basis, n, re, system->cross[0]);
    sway_fit_solve(basis, n, im, system->cross[1]);
    system->schur[0] = sway_real_sub(re[SWAY_FIT_TAU_RE], sway_fit_dot(re, system->cross[0], n));
    system->schur[1] = sway_real_sub(im[SWAY_FIT_TAU_RE], sway_fit_dot(im, system->cross[0], n));
    system->schur[2] = sway_real_sub(im[SWAY_FIT_TAU_IM], sway_fit_dot(im, system->cross[1], n));
}

static void unit_column(const sway_fit_basis_t *basis, uint32_t n, uint32_t index, sway_real_t *x)
{
    for (uint32_t i = 0; i < n; i++) {
        x[i] = sway_real_int(i == index ? 1 : 0);
    }
    sway_fit_solve(basis, n, x, x);
}

void sway_fit_variance(sway_fit_system_t *system, const sway_fit_basis_t *basis)
{
    sway_real_t x[SWAY_FIT_LINEAR];
    unit_column(basis, system->n, 0, x);
    system->variance[0] = x[0];
    system->variance[1] = x[1];
    unit_column(basis, system->n, 1, x);
    system->variance[2] = x[1];
}

void sway_fit_second_variance(sway_fit_system_t *system, const sway_fit_basis_t *basis)
{
    sway_real_t x[SWAY_FIT_LINEAR];
    unit_column(basis, system->n, 4, x);
    const sway_real_t first = x[4];
    unit_column(basis, system->n, 5, x);
    system->second_variance = sway_real_scale(sway_real_add(first, x[5]), -1);
}

/* Columns in Q24 and parameters with 4 fractional bits: 8 terms of at most 2^(24 + 35) stay below
 * 2^62. Parameters beyond 2^31 (nearly dependent columns) are clipped. */
#define MODEL_FRACTION 4
#define MODEL_LIMIT (INT64_C(1) << (31 + MODEL_FRACTION))
#define MODEL_BOUND (INT64_C(1) << 28)

static int64_t clip(int64_t value, int64_t limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

void sway_fit_model(const sway_fit_basis_t *basis, const sway_real_t *parameter, uint32_t n,
                    uint64_t blocks, int32_t *model)
{
    int64_t p[SWAY_FIT_LINEAR];
    for (uint32_t i = 0; i < n; i++) {
        p[i] = clip(sway_real_to_int64(parameter[i], MODEL_FRACTION), MODEL_LIMIT);
    }
    for (uint32_t b = 0; b < basis->blocks; b++) {
        if (((blocks >> b) & 1U) == 0U) {
            continue;
        }
        int64_t sum = p[SWAY_FIT_MEAN] * (ONE_Q28 / 16);
        for (uint32_t i = 0; i < n; i++) {
            sum += i == SWAY_FIT_MEAN ? 0 : p[i] * (basis->column[i][b] / 16);
        }
        model[b] = (int32_t)clip(sum / (INT64_C(1) << (24 + MODEL_FRACTION)), MODEL_BOUND);
    }
}

int32_t sway_fit_center(const int64_t *sums, uint32_t n, int32_t *data, int64_t *mean)
{
    int64_t total = 0;
    for (uint32_t b = 0; b < n; b++) {
        total += sums[b];
    }
    *mean = sway_int64_divide(total, (int64_t)n);
    int64_t largest = 0;
    for (uint32_t b = 0; b < n; b++) {
        const int64_t rest = sums[b] - *mean;
        const int64_t size = rest < 0 ? -rest : rest;
        largest = size > largest ? size : largest;
    }
    int32_t shift = 0;
    while ((largest >> shift) >= (INT32_C(1) << 27) - 1) {
        shift++;
    }
    for (uint32_t b = 0; b < n; b++) {
        const int64_t rest = sums[b] - *mean;
        const int32_t size = (int32_t)((rest < 0 ? -rest : rest) >> shift);
        data[b] = rest < 0 ? -size : size;
    }
    return shift;
}

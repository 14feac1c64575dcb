// SPDX-License-Identifier: MIT
#include "signal/sway_line.h"

#include <string.h>

#include "signal/sway_residual.h"
#include "arithmetic/sway_int64.h"

#define MAX_PASSES 8U
/* Passes kept for a changed model. */
#define REFIT_PASSES 4U
#define MAX_REFITS 3U
/* Rounds of filling missing blocks in one pass. */
#define FILL_ROUNDS 3U
/* Blocks for which a slice makes the columns. */
#define COLUMN_BLOCKS 24U
/* |growth| from the middle to the end of the window: e^4 = 55. */
#define MAX_EXPONENT 4
/* A channel with less than 3/5 of its blocks is not used. */
#define MAX_MISSING_FIFTHS 2U

enum {
    STATE_IDLE,
    STATE_SUMS,
    STATE_SPEED,
    STATE_BEGIN,
    STATE_COLUMNS,
    STATE_FACTORS,
    STATE_GRAM,
    STATE_SYSTEM,
    STATE_GRAM_HARMONICS,
    STATE_GRAM_THIRD,
    STATE_FACTOR_HARMONICS,
    STATE_CROSS_HARMONICS,
    STATE_VARIANCE_HARMONICS,
    STATE_SECOND_VARIANCE,
    STATE_CHANNELS,
    STATE_FILL,
    STATE_NORMAL,
    STATE_SECOND,
    STATE_RESIDUALS,
    STATE_NOISE,
    STATE_RESULT,
    STATE_STEP,
    STATE_CHANGE,
    STATE_COUNT
};

/* sum + a b */
SWAY_INLINE sway_real_t mac(sway_real_t sum, sway_real_t a, sway_real_t b)
{
    return sway_real_add(sum, sway_real_mul(a, b));
}

static uint32_t count_bits(uint64_t mask)
{
    uint32_t n = 0;
    for (; mask != 0U; mask &= mask - 1U) {
        n++;
    }
    return n;
}

/* Rows per block: at most SWAY_FIT_BLOCKS blocks, few rows left over at the old end. */
static uint32_t block_rows(uint32_t window)
{
    const uint32_t least = (window + SWAY_FIT_BLOCKS - 1U) / SWAY_FIT_BLOCKS;
    uint32_t best = least;
    for (uint32_t m = least; m < least + 4U && window / m >= SWAY_FIT_BLOCKS / 2U; m++) {
        if (window % m < window % best) {
            best = m;
        }
        if (window % best <= window / 128U) {
            break;
        }
    }
    return best;
}

sway_error_t sway_line_start(sway_line_job_t *job, const sway_line_config_t *config,
                             const sway_ring_t *ring, uint32_t window, sway_real_t omega_rad_s,
                             sway_line_t *line)
{
    if (job == NULL || config == NULL || ring == NULL || line == NULL ||
        config->sample_period_us <= 0 || window < SWAY_WINDOW_MIN || window > SWAY_WINDOW_MAX ||
        omega_rad_s.m <= 0) {
        return SWAY_ERROR_ARGUMENT;
    }
    if (ring->filled < window) {
        return SWAY_ERROR_NO_DATA;
    }
    const sway_real_t row_s = sway_real_micro(config->sample_period_us);
    memset(line, 0, sizeof *line);
    job->line = line;
    job->config = *config;
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        job->data[c].harmonics = (config->harmonics_mask & SWAY_CHANNEL_BIT(c)) != 0U;
        job->data[c].missing = 0;
        job->data[c].lost = 0;
    }
    job->state = STATE_SUMS;
    job->channel = 0;
    job->passes_left = MAX_PASSES;
    job->refits = 0;
    job->final = false;
    job->changed = false;
    job->converged = false;
    job->broken = false;
    job->head = ring->head;
    job->block = block_rows(window);
    job->basis.blocks = window / job->block;
    const uint32_t rows = job->basis.blocks * job->block;
    job->half_s = sway_real_mul(row_s, sway_real_ratio((int32_t)(rows - job->block), 2));
    job->line->window_samples = (int32_t)rows;
    job->line->mid_time_us =
        ring->newest_time_us - (int64_t)(rows - 1U) * config->sample_period_us / 2;
    job->line->omega_rad_s = omega_rad_s;
    job->line->valid_mask =
        ring->present_mask & config->result_mask & (SWAY_CHANNEL_BIT(SWAY_CHANNELS) - 1U);
    return SWAY_OK;
}

uint32_t sway_line_harmonics(const sway_line_job_t *job)
{
    uint32_t mask = 0;
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        mask |= job->data[c].harmonics ? SWAY_CHANNEL_BIT(c) : 0U;
    }
    return mask;
}

/* ---- block sums -------------------------------------------------------------------------- */

static uint32_t oldest_slot(const sway_line_job_t *job)
{
    return (job->head - (uint32_t)job->line->window_samples) & (SWAY_RING_SAMPLES - 1U);
}

static void sum_channel(sway_line_job_t *job, const sway_ring_t *ring, uint32_t channel)
{
    const uint32_t blocks = job->basis.blocks;
    sway_line_data_t *data = &job->data[channel];
    int64_t sums[SWAY_FIT_BLOCKS];
    data->missing = sway_ring_sums(ring, channel, job->head, job->block, blocks, sums);
    data->shift = sway_fit_center(sums, blocks, data->sum, &data->removed);
    data->lost = count_bits(data->missing);
    if (5U * data->lost > MAX_MISSING_FIFTHS * blocks) {
        job->line->valid_mask &= ~SWAY_CHANNEL_BIT(channel);
    }
}

/* RMS of the block means about their mean and slope, in SI units. */
static sway_real_t rms_about_line(const sway_line_job_t *job, sway_channel_t channel)
{
    const sway_line_data_t *data = &job->data[channel];
    const int32_t n = (int32_t)job->basis.blocks;
    int64_t squares = 0;
    int64_t moment = 0;
    for (int32_t b = 0; b < n; b++) {
        const int64_t x = data->sum[b]; // below 2^27
        squares += x * x;
        moment += x * (2 * b - n + 1);
    }
    const sway_real_t spread = sway_real_ratio(n * (n * n - 1), 3); // sum of (2b - n + 1)^2
    const sway_real_t slope = sway_real_div(sway_real_square(sway_real(moment, 0)), spread);
    const sway_real_t rest = sway_real_sub(sway_real(squares, 0), slope);
    const sway_real_t rms = sway_real_sqrt(sway_real_div(rest, sway_real_int(n)));
    const sway_real_t mean = sway_real_div(rms, sway_real_int((int32_t)job->block));
    return sway_real_mul(sway_real_scale(mean, data->shift), sway_line_unit(channel));
}

static uint32_t after_sums(sway_line_job_t *job)
{
    const uint32_t steering = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    if ((job->line->valid_mask & steering) != 0U) {
        const sway_real_t quiet = sway_real_micro(job->config.steering_quiet_urad);
        if (sway_real_less(quiet, rms_about_line(job, SWAY_CHANNEL_STEERING_WHEEL_ANGLE))) {
            job->line->flags |= SWAY_LINE_FORCED;
        }
    }
    job->used_mask = job->line->valid_mask & job->config.channel_mask;
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        if ((job->used_mask & SWAY_CHANNEL_BIT(c)) != 0U && job->data[c].lost > 0U) {
            job->line->flags |= SWAY_LINE_GAP;
        }
    }
    return STATE_SPEED;
}

static uint32_t run_sums(sway_line_job_t *job, const sway_ring_t *ring)
{
    const uint32_t wanted = ring->present_mask & job->config.result_mask;
    while (job->channel < SWAY_CHANNELS && (wanted & SWAY_CHANNEL_BIT(job->channel)) == 0U) {
        job->channel++;
    }
    if (job->channel < SWAY_CHANNELS) {
        sum_channel(job, ring, job->channel);
        job->channel++;
    }
    return job->channel < SWAY_CHANNELS ? STATE_SUMS : after_sums(job);
}

static uint32_t run_speed(sway_line_job_t *job, const sway_ring_t *ring)
{
    const int32_t n = job->line->window_samples;
    uint32_t slot = oldest_slot(job);
    int64_t sum = 0;
    int64_t moment = 0; // below 2^13 * 2^17 * 2^14
    uint32_t known = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t speed_mm_s = (int32_t)(ring->speed[slot] / 2U);
        sum += speed_mm_s;
        moment += (int64_t)speed_mm_s * (2 * i - n + 1);
        known += ring->speed[slot] & 1U;
        slot = (slot + 1U) & (SWAY_RING_SAMPLES - 1U);
    }
    if (4U * known < 3U * (uint32_t)n) {
        return STATE_BEGIN;
    }
    /* slope per row = 2 moment / (n (n^2 - 1) / 3) */
    const sway_real_t per_row =
        sway_real_div(sway_real(6 * moment, 0), sway_real((int64_t)n * (n * n - 1), 0));
    const sway_real_t total = sway_real(sum, 0);
    job->line->speed_m_s = sway_real_div(total, sway_real_int(1000 * n));
    job->line->speed_slope_m_s2 = sway_real_div(sway_real_mul(per_row, sway_real_int(1000)),
                                                sway_real_int(job->config.sample_period_us));
    const sway_real_t change = sway_real_abs(sway_real_mul(per_row, sway_real_int(n)));
    const sway_real_t allowed =
        sway_real_mul(sway_real_div(total, sway_real_int(n)),
                      sway_real_ratio(job->config.speed_change_milli, 1000));
    if (sway_real_less(allowed, change)) {
        job->line->flags |= SWAY_LINE_SPEED_CHANGING;
    }
    return STATE_BEGIN;
}

/* ---- columns and their systems ------------------------------------------------------------ */

static sway_real_t per_block(const sway_line_job_t *job, sway_real_t per_s)
{
    const sway_real_t block_s =
        sway_real_micro((int64_t)job->config.sample_period_us * (int32_t)job->block);
    return sway_real_mul(per_s, block_s);
}

static bool needs_harmonics(const sway_line_job_t *job)
{
    bool any = job->final || job->config.forced_rad_s.m != 0;
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        any = any || (job->data[c].harmonics && (job->used_mask & SWAY_CHANNEL_BIT(c)) != 0U);
    }
    return any;
}

/* Sum over a block of e^(s t) by its value at the middle: sinh(s T m / 2) / sinh(s T / 2). */
static sway_complex_t sinh_complex(sway_real_t re, sway_real_t im)
{
    sway_real_t s;
    sway_real_t c;
    sway_real_sincos(im, &s, &c);
    const sway_real_t up = sway_real_exp(re);
    const sway_real_t down = sway_real_exp(sway_real_neg(re));
    return sway_complex(sway_real_scale(sway_real_mul(sway_real_sub(up, down), c), -1),
                        sway_real_scale(sway_real_mul(sway_real_add(up, down), s), -1));
}

static sway_complex_t block_factor(const sway_line_job_t *job, int32_t harmonic)
{
    const sway_real_t times = sway_real_ratio(harmonic, 2 * (int32_t)job->block);
    const sway_real_t re = sway_real_mul(per_block(job, job->line->growth_1_s), times);
    const sway_real_t im = sway_real_mul(per_block(job, job->line->omega_rad_s), times);
    const sway_real_t m = sway_real_int((int32_t)job->block);
    return sway_complex_div(sinh_complex(sway_real_mul(re, m), sway_real_mul(im, m)),
                            sinh_complex(re, im));
}

static uint32_t run_begin(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    memset(&job->normal, 0, sizeof job->normal);
    job->channel = 0;
    const sway_real_t per_s2 = per_block(job, job->config.chirp_rad_s2);
    const sway_fit_pole_t pole = {.growth = per_block(job, job->line->growth_1_s),
                                  .omega = per_block(job, job->line->omega_rad_s),
                                  .chirp = per_block(job, per_s2),
                                  .forced = per_block(job, job->config.forced_rad_s)};
    sway_fit_begin(&job->basis, job->basis.blocks, &pole);
    return STATE_COLUMNS;
}

static uint32_t run_columns(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    if (sway_fit_columns(&job->basis, COLUMN_BLOCKS, needs_harmonics(job))) {
        return STATE_COLUMNS;
    }
    return job->final ? STATE_FACTORS : STATE_GRAM;
}

static uint32_t run_factors(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    for (int i = 0; i < 2; i++) {
        job->factor[i] = block_factor(job, i + 1);
        job->factor_size[i] = sway_complex_abs(job->factor[i]);
    }
    return STATE_GRAM;
}

static uint32_t run_gram(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_gram(&job->basis, 0, SWAY_FIT_SLOPE);
    if (job->config.level) {
        sway_fit_pin_slope(&job->basis);
    }
    return STATE_SYSTEM;
}

static uint32_t run_system(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_factor(&job->basis, 0, 3);
    sway_fit_cross(&job->system[0], &job->basis, 4);
    sway_fit_variance(&job->system[0], &job->basis);
    return needs_harmonics(job) ? STATE_GRAM_HARMONICS : STATE_CHANNELS;
}

static uint32_t run_gram_harmonics(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_gram(&job->basis, 4, 5);
    return STATE_GRAM_THIRD;
}

static uint32_t run_gram_third(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_gram(&job->basis, 6, 7);
    return STATE_FACTOR_HARMONICS;
}

static uint32_t run_factor_harmonics(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_factor(&job->basis, 4, 7);
    return STATE_CROSS_HARMONICS;
}

static uint32_t run_cross_harmonics(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_cross(&job->system[1], &job->basis, SWAY_FIT_LINEAR);
    return job->final ? STATE_VARIANCE_HARMONICS : STATE_CHANNELS;
}

static uint32_t run_variance_harmonics(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_variance(&job->system[1], &job->basis);
    return STATE_SECOND_VARIANCE;
}

static uint32_t run_second_variance(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_fit_second_variance(&job->system[1], &job->basis);
    memset(&job->sums, 0, sizeof job->sums);
    return STATE_CHANNELS;
}

/* ---- one channel -------------------------------------------------------------------------- */

static sway_real_t sum_of_squares(const int32_t *x, uint32_t n)
{
    return sway_real(sway_int64_dot(x, x, n), 0); // 64 * 2^56
}

/* Blocks that are data, less the parameters fitted to them. */
static int32_t freedom(const sway_line_job_t *job, const sway_line_data_t *data, uint32_t n)
{
    const uint32_t shared = count_bits(job->used_mask) == 1U ? 2U : 0U;
    const int32_t rest =
        (int32_t)job->basis.blocks - (int32_t)count_bits(data->missing) - (int32_t)(n + shared);
    return rest < 4 ? 4 : rest;
}

/* Variance of a block: at least that of rounding, and what 31 bits resolve. For few degrees of
 * freedom the variance of Student's t over that of the normal distribution is put in, so that
 * standard errors mean what they say. */
/* What the windows' missing part costs in the error of growth, at the most: that of a window that
 * is shorter by as much, (whole / present)^3. */
static sway_real_t cost_of_gaps(const sway_line_job_t *job, const sway_line_data_t *data)
{
    const int32_t blocks = (int32_t)job->basis.blocks;
    const sway_real_t ratio = sway_real_ratio(blocks, blocks - (int32_t)data->lost);
    return sway_real_mul(sway_real_square(ratio), ratio);
}

static sway_real_t block_variance(const sway_line_job_t *job, const sway_line_data_t *data,
                                  uint32_t n, sway_real_t rest, sway_real_t total)
{
    const int32_t degrees = freedom(job, data, n);
    const int32_t blocks = (int32_t)job->basis.blocks;
    const int32_t present = blocks - (int32_t)count_bits(data->missing);
    const sway_real_t whole = sway_real_mul(rest, sway_real_ratio(blocks, present));
    const sway_real_t variance = sway_real_div(whole, sway_real_int(degrees - 2));
    const sway_real_t rounding =
        sway_real_scale(sway_real_ratio((int32_t)job->block, 12), -2 * data->shift);
    const sway_real_t least = sway_real_max(rounding, sway_real_ratio(1, 12));
    const sway_real_t result =
        sway_real_max(sway_real_max(variance, least), sway_real_scale(total, -32));
    return data->lost == 0U ? result : sway_real_mul(result, cost_of_gaps(job, data));
}

/* Of the columns that the channel's model has. */
static const sway_fit_system_t *system_of(const sway_line_job_t *job)
{
    return &job->system[job->columns == 4U ? 0 : 1];
}

static void channel_products(const sway_line_job_t *job, const sway_line_data_t *data, uint32_t n,
                             sway_real_t *product)
{
    for (uint32_t i = 0; i < n; i++) {
        product[i] = sway_fit_product(&job->basis, i, data->sum);
    }
}

/* Puts the model where there is no data: the least squares of the whole are then those of the data
 * alone. Corrects the products; returns the largest change. */
static int32_t fill_missing(const sway_line_job_t *job, sway_line_data_t *data, uint32_t n,
                            sway_real_t *product)
{
    const int32_t limit = (INT32_C(1) << 27) - 1;
    int32_t model[SWAY_FIT_BLOCKS];
    int64_t change[SWAY_FIT_LINEAR] = {0}; // below 64 * 2^28 * 2^28
    int32_t largest = 0;
    sway_fit_model(&job->basis, data->parameter, n, data->missing, model);
    for (uint32_t b = 0; b < job->basis.blocks; b++) {
        if (((data->missing >> b) & 1U) == 0U) {
            continue;
        }
        const int32_t x = model[b] > limit ? limit : model[b] < -limit ? -limit : model[b];
        const int32_t step = x - data->sum[b];
        const int32_t size = step < 0 ? -step : step;
        data->sum[b] = x;
        largest = size > largest ? size : largest;
        for (uint32_t i = 0; i < n; i++) {
            change[i] += sway_int64_product(step, job->basis.column[i][b]);
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        product[i] = sway_real_add(product[i], sway_real(change[i], -SWAY_FIT_BITS));
    }
    return largest;
}

static void solve_channel(const sway_line_job_t *job, sway_line_data_t *data, uint32_t n,
                          sway_real_t *product)
{
    channel_products(job, data, n, product);
    sway_fit_solve(&job->basis, n, product, data->parameter);
}

/* a^T S b of a 2x2 symmetric S. */
static sway_real_t form(const sway_real_t *s, sway_complex_t a, sway_complex_t b)
{
    const sway_real_t mixed = sway_real_add(sway_real_mul(a.re, b.im), sway_real_mul(a.im, b.re));
    const sway_real_t diagonal =
        mac(sway_real_mul(sway_real_mul(a.re, b.re), s[0]), sway_real_mul(a.im, b.im), s[2]);
    return mac(diagonal, mixed, s[1]);
}

/* The derivative of the model is re * column 8 + im * column 9. */
static sway_complex_t by_growth(const sway_line_data_t *data)
{
    return sway_complex(data->parameter[0], data->parameter[1]);
}

static sway_complex_t by_omega(const sway_line_data_t *data)
{
    return sway_complex(sway_real_neg(data->parameter[1]), data->parameter[0]);
}

static void add_normal(sway_line_job_t *job, const sway_line_data_t *data, uint32_t n,
                       const sway_real_t *product, sway_real_t variance)
{
    const sway_fit_system_t *system = system_of(job);
    sway_line_normal_t *normal = &job->normal;
    const sway_real_t weight = sway_real_div(sway_real_int(1), variance);
    const sway_complex_t g = by_growth(data);
    const sway_complex_t o = by_omega(data);
    const sway_real_t re =
        sway_real_sub(product[SWAY_FIT_TAU_RE], sway_fit_dot(system->cross[0], product, n));
    const sway_real_t im =
        sway_real_sub(product[SWAY_FIT_TAU_IM], sway_fit_dot(system->cross[1], product, n));
    normal->growth_growth = mac(normal->growth_growth, weight, form(system->schur, g, g));
    normal->growth_omega = mac(normal->growth_omega, weight, form(system->schur, g, o));
    normal->omega_omega = mac(normal->omega_omega, weight, form(system->schur, o, o));
    const sway_real_t right_g = mac(sway_real_mul(g.re, re), g.im, im);
    const sway_real_t right_o = mac(sway_real_mul(o.re, re), o.im, im);
    normal->growth_right = mac(normal->growth_right, weight, right_g);
    normal->omega_right = mac(normal->omega_right, weight, right_o);
}

/* The part at 2f from the full model, whether or not the fit uses it. */
static void measure_second(sway_line_job_t *job, uint32_t channel, sway_real_t variance,
                           sway_real_t *product)
{
    sway_line_data_t *data = &job->data[channel];
    sway_line_channel_t *result = &job->line->channel[channel];
    sway_real_t full[SWAY_FIT_LINEAR];
    for (uint32_t i = 4; i < SWAY_FIT_LINEAR && job->columns == 4U; i++) {
        product[i] = sway_fit_product(&job->basis, i, data->sum);
    }
    sway_fit_solve(&job->basis, SWAY_FIT_LINEAR, product, full);
    const sway_real_t spread = sway_real_mul(variance, job->system[1].second_variance);
    const sway_real_t second = sway_real_add(sway_real_square(full[4]), sway_real_square(full[5]));
    const sway_real_t third = sway_real_add(sway_real_square(full[6]), sway_real_square(full[7]));
    const sway_real_t largest =
        job->config.forced_rad_s.m != 0 ? second : sway_real_max(second, third);
    result->second = sway_complex(full[4], full[5]);
    result->second_se = sway_real_sqrt(spread);
    /* In at 5 standard errors, out below 3. */
    const sway_real_t enter = sway_real_mul(spread, sway_real_int(25));
    const sway_real_t leave = sway_real_mul(spread, sway_real_int(9));
    if (!data->harmonics && sway_real_less(enter, largest)) {
        data->harmonics = true;
        job->changed = true;
    } else if (data->harmonics && sway_real_less(largest, leave)) {
        data->harmonics = false;
    }
}

static uint32_t columns_of(const sway_line_job_t *job, const sway_line_data_t *data)
{
    return data->harmonics || job->config.forced_rad_s.m != 0 ? SWAY_FIT_LINEAR : 4U;
}

static uint32_t next_channel(sway_line_job_t *job)
{
    const uint32_t mask = job->final ? job->line->valid_mask : job->used_mask;
    job->channel++;
    while (job->channel < SWAY_CHANNELS && (mask & SWAY_CHANNEL_BIT(job->channel)) == 0U) {
        job->channel++;
    }
    return job->channel < SWAY_CHANNELS ? STATE_CHANNELS : STATE_STEP;
}

static uint32_t run_channel(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    const uint32_t c = job->channel;
    const uint32_t mask = job->final ? job->line->valid_mask : job->used_mask;
    if ((mask & SWAY_CHANNEL_BIT(c)) == 0U) {
        return next_channel(job);
    }
    sway_line_data_t *data = &job->data[c];
    job->columns = columns_of(job, data);
    solve_channel(job, data, job->columns, job->product);
    job->rounds_left = job->columns == 4U ? FILL_ROUNDS : 1U;
    return data->missing != 0U ? STATE_FILL : STATE_NORMAL;
}

static uint32_t run_fill(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_line_data_t *data = &job->data[job->channel];
    if (fill_missing(job, data, job->columns, job->product) < 4) {
        return STATE_NORMAL;
    }
    sway_fit_solve(&job->basis, job->columns, job->product, data->parameter);
    job->rounds_left--;
    return job->rounds_left > 0U ? STATE_FILL : STATE_NORMAL;
}

static uint32_t run_normal(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    const uint32_t n = job->columns;
    sway_line_data_t *data = &job->data[job->channel];
    sway_real_t *product = job->product;
    product[SWAY_FIT_TAU_RE] = sway_fit_product(&job->basis, SWAY_FIT_TAU_RE, data->sum);
    product[SWAY_FIT_TAU_IM] = sway_fit_product(&job->basis, SWAY_FIT_TAU_IM, data->sum);
    const sway_real_t total = sum_of_squares(data->sum, job->basis.blocks);
    const sway_real_t rest = sway_real_sub(total, sway_fit_dot(data->parameter, product, n));
    job->variance = block_variance(job, data, n, rest, total);
    if ((job->used_mask & SWAY_CHANNEL_BIT(job->channel)) != 0U) {
        add_normal(job, data, n, product, job->variance);
    }
    return job->final ? STATE_SECOND : next_channel(job);
}

static uint32_t run_second(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    measure_second(job, job->channel, job->variance, job->product);
    return STATE_RESIDUALS;
}

/* ---- residual and result of a channel ------------------------------------------------------ */

/* Outliers are taken out, at most a fifth of the window; more than that is no impulse. */
static void reject_outliers(sway_line_job_t *job, sway_line_data_t *data, const int32_t *residual)
{
    const uint32_t n = job->basis.blocks;
    const uint64_t wrong = sway_residual_outliers(residual, n) & ~data->missing;
    if (wrong != 0U && 5U * (count_bits(wrong | data->missing) - data->lost) <= n) {
        data->missing |= wrong;
        job->changed = true;
    }
}

/* Variance of the amplitude in the direction of the unit vector e: noise and the share of the
 * common growth and omega. */
static sway_real_t variance_along(const sway_line_job_t *job, const sway_line_data_t *data,
                                  sway_real_t variance, sway_complex_t e)
{
    const sway_fit_system_t *system = system_of(job);
    const sway_complex_t g = by_growth(data);
    const sway_complex_t o = by_omega(data);
    const sway_real_t re = mac(sway_real_mul(e.re, system->cross[0][0]), e.im, system->cross[0][1]);
    const sway_real_t im = mac(sway_real_mul(e.re, system->cross[1][0]), e.im, system->cross[1][1]);
    const sway_complex_t q = sway_complex(mac(sway_real_mul(re, g.re), im, g.im),
                                          mac(sway_real_mul(re, o.re), im, o.im));
    return mac(form(job->covariance, q, q), variance, form(system->variance, e, e));
}

static void put_result(sway_line_job_t *job, uint32_t channel, sway_real_t variance)
{
    const sway_line_data_t *data = &job->data[channel];
    sway_line_channel_t *result = &job->line->channel[channel];
    const sway_real_t unit = sway_real_scale(sway_line_unit((sway_channel_t)channel), data->shift);
    const sway_complex_t a = sway_complex(data->parameter[0], data->parameter[1]);
    const sway_real_t size = sway_complex_abs(a);
    const sway_complex_t none = sway_complex(sway_real_int(1), sway_real_zero());
    const sway_complex_t along =
        size.m == 0 ? none : sway_complex(sway_real_div(a.re, size), sway_real_div(a.im, size));
    const sway_complex_t across = sway_complex(sway_real_neg(along.im), along.re);
    const sway_real_t se = sway_real_sqrt(variance_along(job, data, variance, along));
    const sway_real_t se_across = sway_real_sqrt(variance_along(job, data, variance, across));
    const sway_complex_t factor = job->factor[0];
    const sway_real_t scale = sway_real_mul(job->basis.scale, unit);
    const sway_real_t gain = sway_real_div(scale, job->factor_size[0]);
    result->amplitude = sway_complex_div(sway_complex_scale(a, scale), factor);
    result->amplitude_se = sway_real_mul(se, gain);
    result->phase_se_rad = sway_real_div(se_across, size);
    const sway_complex_t factor_2 = job->factor[1];
    const sway_real_t scale_2 = sway_real_mul(job->basis.scale, scale);
    const sway_real_t gain_2 = sway_real_div(scale_2, job->factor_size[1]);
    result->second = sway_complex_div(sway_complex_scale(result->second, scale_2), factor_2);
    result->second_se = sway_real_mul(result->second_se, gain_2);
    const sway_real_t rows = sway_real_int((int32_t)job->block);
    const sway_real_t mean = sway_real_add(sway_real_scale(data->parameter[2], data->shift),
                                           sway_real(data->removed, 0));
    result->mean =
        sway_real_mul(sway_real_div(mean, rows), sway_line_unit((sway_channel_t)channel));
}

static uint32_t run_residuals(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    const sway_line_data_t *data = &job->data[job->channel];
    int32_t *residual = job->residual;
    sway_fit_model(&job->basis, data->parameter, job->columns, UINT64_MAX, residual);
    for (uint32_t b = 0; b < job->basis.blocks; b++) {
        residual[b] = data->sum[b] - residual[b]; // below 2^28 + 2^27
        residual[b] = ((data->missing >> b) & 1U) != 0U ? 0 : residual[b];
    }
    return STATE_NOISE;
}

/* What a channel knows of omega, and whether its residual is noise. */
static void add_share(sway_line_job_t *job, const sway_line_data_t *data, sway_real_t blow)
{
    const sway_complex_t o = by_omega(data);
    const sway_fit_system_t *system = system_of(job);
    const sway_real_t share = sway_real_div(form(system->schur, o, o), job->variance);
    const sway_real_t line =
        sway_real_mul(sway_real_square(job->basis.scale),
                      sway_complex_norm(sway_complex(data->parameter[0], data->parameter[1])));
    job->normal.inflated = mac(job->normal.inflated, share, blow);
    /* correlated by more than 0.5, and more than 5 % of the line */
    if (sway_real_less(sway_real_int(3), blow) &&
        sway_real_less(sway_real_mul(line, sway_real_ratio(125, 100000)), job->variance)) {
        job->normal.misfit = sway_real_add(job->normal.misfit, share);
    }
    job->normal.all = sway_real_add(job->normal.all, share);
    sway_change_add(&job->sums, &job->basis, by_growth(data), job->variance, job->residual);
}

static uint32_t run_noise(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    const uint32_t c = job->channel;
    const uint32_t n = job->basis.blocks;
    const sway_line_data_t *data = &job->data[c];
    const sway_real_t squares = sum_of_squares(job->residual, n);
    const sway_real_t blow = sway_residual_inflation(job->residual, n, squares);
    job->variance = block_variance(job, data, job->columns, squares, sway_real_zero());
    if ((job->used_mask & SWAY_CHANNEL_BIT(c)) != 0U) {
        add_share(job, data, blow);
    }
    const sway_real_t unit = sway_real_scale(sway_line_unit((sway_channel_t)c), data->shift);
    job->line->channel[c].noise_rms = sway_real_mul(
        unit, sway_real_sqrt(sway_real_div(job->variance, sway_real_int((int32_t)job->block))));
    job->variance = sway_real_mul(job->variance, blow);
    return STATE_RESULT;
}

static uint32_t run_result(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    put_result(job, job->channel, job->variance);
    reject_outliers(job, &job->data[job->channel], job->residual);
    return next_channel(job);
}

/* ---- common parameters --------------------------------------------------------------------- */

static sway_real_t clamp(sway_real_t value, sway_real_t low, sway_real_t high)
{
    return sway_real_max(low, sway_real_min(value, high));
}

/* rad/s of a percentage of a frequency */
static sway_real_t hertz(int32_t mhz, int32_t percent)
{
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    return sway_real_mul(turn, sway_real_ratio(mhz * percent, 100000));
}

/* The solution of the normal equations; false where they have none. */
static bool solve_step(sway_line_job_t *job, sway_real_t *growth, sway_real_t *omega)
{
    const sway_line_normal_t *n = &job->normal;
    const sway_real_t product = sway_real_mul(n->growth_growth, n->omega_omega);
    const sway_real_t det = sway_real_sub(product, sway_real_square(n->growth_omega));
    if (sway_real_less(det, sway_real_scale(product, -20)) || det.m <= 0) {
        return false;
    }
    job->covariance[0] = sway_real_div(n->omega_omega, det);
    job->covariance[1] = sway_real_neg(sway_real_div(n->growth_omega, det));
    job->covariance[2] = sway_real_div(n->growth_growth, det);
    *growth =
        mac(sway_real_mul(job->covariance[0], n->growth_right), job->covariance[1], n->omega_right);
    *omega =
        mac(sway_real_mul(job->covariance[1], n->growth_right), job->covariance[2], n->omega_right);
    return true;
}

/* A step is small when it, or what it leaves behind, is below 1/`part` of the standard error, or
 * below 1e-7 rad at the window's end. Gauss-Newton on a good model leaves less than 16 times the
 * square of the step (in rad); where the model is not good, the last pass finds out. */
static bool is_small_one(sway_real_t step, sway_real_t variance, int32_t part, bool foresee)
{
    const sway_real_t bound =
        sway_real_max(sway_real_div(variance, sway_real_int(part * part)),
                      sway_real_div(sway_real_int(1), sway_real(INT64_C(100000000000000), 0)));
    const sway_real_t step_2 = sway_real_square(step);
    return sway_real_less(step_2, bound) ||
           (foresee && sway_real_less(sway_real_scale(sway_real_square(step_2), 8), bound));
}

static bool is_small(const sway_line_job_t *job, sway_real_t growth, sway_real_t omega,
                     int32_t part, bool foresee)
{
    return is_small_one(growth, job->covariance[0], part, foresee) &&
           is_small_one(omega, job->covariance[2], part, foresee);
}

static void take_step(sway_line_job_t *job, sway_real_t growth, sway_real_t omega)
{
    const sway_real_t size =
        sway_real_sqrt(sway_real_add(sway_real_square(growth), sway_real_square(omega)));
    const sway_real_t longest = sway_real_ratio(8, 10);
    if (sway_real_less(longest, size)) {
        const sway_real_t cut = sway_real_div(longest, size);
        growth = sway_real_mul(growth, cut);
        omega = sway_real_mul(omega, cut);
    }
    const sway_real_t steepest = sway_real_div(sway_real_int(MAX_EXPONENT), job->half_s);
    const sway_real_t new_growth =
        sway_real_add(job->line->growth_1_s, sway_real_div(growth, job->half_s));
    const sway_real_t new_omega =
        sway_real_add(job->line->omega_rad_s, sway_real_div(omega, job->half_s));
    job->line->growth_1_s = clamp(new_growth, sway_real_neg(steepest), steepest);
    job->line->omega_rad_s = clamp(new_omega, hertz(job->config.frequency_min_mhz, 70),
                                   hertz(job->config.frequency_max_mhz, 130));
}

static bool stands_out(const sway_line_job_t *job)
{
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        const sway_line_channel_t *channel = &job->line->channel[c];
        const sway_real_t bar =
            sway_real_mul(sway_real_square(channel->amplitude_se), sway_real_int(64));
        if ((job->used_mask & SWAY_CHANNEL_BIT(c)) != 0U &&
            sway_real_less(bar, sway_complex_norm(channel->amplitude))) {
            return true;
        }
    }
    return false;
}

static bool second_is_large(const sway_line_channel_t *channel)
{
    const sway_real_t second = sway_complex_norm(channel->second);
    const sway_real_t bar =
        sway_real_mul(sway_complex_norm(channel->amplitude), sway_real_ratio(225, 10000));
    const sway_real_t noise =
        sway_real_mul(sway_real_square(channel->second_se), sway_real_int(25));
    return sway_real_less(bar, second) && sway_real_less(noise, second);
}

/* The line stands out, lies in the band, is known to a tenth and turns at least once. */
static bool is_oscillation(const sway_line_job_t *job)
{
    const sway_real_t omega = job->line->omega_rad_s;
    const sway_real_t tenth = sway_real_mul(omega, sway_real_ratio(1, 10));
    const sway_real_t turn = sway_real_mul(omega, job->half_s); // pi for a whole one
    return stands_out(job) && !sway_real_less(omega, hertz(job->config.frequency_min_mhz, 100)) &&
           !sway_real_less(hertz(job->config.frequency_max_mhz, 100), omega) &&
           !sway_real_less(tenth, job->line->omega_se_rad_s) &&
           !sway_real_less(turn, sway_real_pi());
}

static bool is_nonlinear(const sway_line_job_t *job)
{
    static const sway_channel_t yaw[] = {SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_TRAILER_YAW_RATE};
    bool any = false;
    for (int i = 0; i < 2; i++) {
        any = any || ((job->used_mask & SWAY_CHANNEL_BIT(yaw[i])) != 0U &&
                      second_is_large(&job->line->channel[yaw[i]]));
    }
    return any;
}

static void finish(sway_line_job_t *job)
{
    sway_line_t *line = job->line;
    const sway_line_normal_t *normal = &job->normal;
    const sway_real_t blow = sway_real_div(normal->inflated, normal->all);
    const sway_real_t growth_2 = sway_real_mul(job->covariance[0], blow);
    const sway_real_t omega_2 = sway_real_mul(job->covariance[2], blow);
    line->growth_se_1_s = sway_real_div(sway_real_sqrt(growth_2), job->half_s);
    line->omega_se_rad_s = sway_real_div(sway_real_sqrt(omega_2), job->half_s);
    line->flags |= is_oscillation(job) ? 0U : SWAY_LINE_NO_OSCILLATION;
    line->flags |= job->converged ? 0U : SWAY_LINE_NOT_CONVERGED;
    line->flags |= is_nonlinear(job) ? SWAY_LINE_NONLINEAR : 0U;
    /* by channels that make up more than half of what is known of omega */
    const bool misfit = sway_real_less(normal->all, sway_real_scale(normal->misfit, 1));
    line->flags |= misfit ? SWAY_LINE_MISFIT : 0U;
}

static uint32_t fail(sway_line_job_t *job)
{
    job->line->flags |= SWAY_LINE_NO_OSCILLATION | SWAY_LINE_NOT_CONVERGED;
    return STATE_IDLE;
}

static uint32_t run_final_step(sway_line_job_t *job, sway_real_t growth, sway_real_t omega)
{
    const bool settled = is_small(job, growth, omega, 5, false);
    job->converged = settled || is_small(job, growth, omega, 2, false);
    if ((job->changed || !settled) && job->refits < MAX_REFITS) {
        take_step(job, growth, omega);
        job->refits++;
        job->changed = false;
        job->final = false;
        job->passes_left = REFIT_PASSES;
        return STATE_BEGIN;
    }
    finish(job);
    return STATE_CHANGE;
}

static uint32_t run_change(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    const uint32_t block = sway_change_find(&job->sums, &job->basis);
    job->broken = block > 0U;
    if (job->broken) {
        const int64_t halves = 2 * (int64_t)block - (int64_t)job->basis.blocks;
        job->line->flags |= SWAY_LINE_MISFIT;
        job->change_time_us = job->line->mid_time_us +
                              halves * (int64_t)job->block * job->config.sample_period_us / 2;
    }
    return STATE_IDLE;
}

static uint32_t run_step(sway_line_job_t *job, const sway_ring_t *ring)
{
    (void)ring;
    sway_real_t growth;
    sway_real_t omega;
    if (!solve_step(job, &growth, &omega)) {
        return fail(job);
    }
    if (job->final) {
        return run_final_step(job, growth, omega);
    }
    const bool done = is_small(job, growth, omega, 10, true);
    take_step(job, growth, omega);
    job->passes_left--;
    job->final = done || job->passes_left == 0U;
    return STATE_BEGIN;
}

/* With four columns these two take less. */
enum { COST_CHANNEL_OF_4 = 8, COST_RESIDUALS_OF_4 = 22 };

typedef struct {
    uint32_t (*run)(sway_line_job_t *, const sway_ring_t *);
    uint8_t cost; // about, see SWAY_SLICE_COST
} slice_t;

static const slice_t SLICES[STATE_COUNT] = {
    [STATE_SUMS] = {run_sums, 16},
    [STATE_SPEED] = {run_speed, 31},
    [STATE_BEGIN] = {run_begin, 13},
    [STATE_COLUMNS] = {run_columns, 27},
    [STATE_FACTORS] = {run_factors, 27},
    [STATE_GRAM] = {run_gram, 29},
    [STATE_SYSTEM] = {run_system, 17},
    [STATE_GRAM_HARMONICS] = {run_gram_harmonics, 23},
    [STATE_GRAM_THIRD] = {run_gram_third, 29},
    [STATE_FACTOR_HARMONICS] = {run_factor_harmonics, 25},
    [STATE_CROSS_HARMONICS] = {run_cross_harmonics, 24},
    [STATE_VARIANCE_HARMONICS] = {run_variance_harmonics, 19},
    [STATE_SECOND_VARIANCE] = {run_second_variance, 14},
    [STATE_CHANNELS] = {run_channel, 20},
    [STATE_FILL] = {run_fill, 25},
    [STATE_NORMAL] = {run_normal, 14},
    [STATE_SECOND] = {run_second, 16},
    [STATE_RESIDUALS] = {run_residuals, 38},
    [STATE_NOISE] = {run_noise, 22},
    [STATE_RESULT] = {run_result, 18},
    [STATE_STEP] = {run_step, 10},
    [STATE_CHANGE] = {run_change, 33},
};

uint32_t sway_line_cost(const sway_line_job_t *job)
{
    if (job->state >= STATE_COUNT) {
        return 0U;
    }
    if (job->state == STATE_CHANNELS && columns_of(job, &job->data[job->channel]) == 4U) {
        return COST_CHANNEL_OF_4;
    }
    if (job->state == STATE_RESIDUALS && job->columns == 4U) {
        return COST_RESIDUALS_OF_4;
    }
    return SLICES[job->state].cost;
}

bool sway_line_run(sway_line_job_t *job, const sway_ring_t *ring)
{
    if (job->state == STATE_IDLE || job->state >= STATE_COUNT) {
        return false;
    }
    job->state = SLICES[job->state].run(job, ring);
    return job->state != STATE_IDLE;
}

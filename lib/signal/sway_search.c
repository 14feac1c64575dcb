// SPDX-License-Identifier: MIT
#include "signal/sway_search.h"

#include <stddef.h>
#include <string.h>

#include "signal/sway_fit.h"
#include "arithmetic/sway_int64.h"

#include "_kiss_fft_guts.h"

#if !defined(FIXED_POINT) || FIXED_POINT != 32
#error "sway_search needs kissfft with -DFIXED_POINT=32"
#endif

/* The buffers of sway_search_t are what kissfft takes them for. */
typedef char state_fits[sizeof(struct kiss_fft_state) + (SWAY_SEARCH_POINTS - 1) * 8U <=
                                sizeof(((sway_search_t *)0)->state)
                            ? 1
                            : -1];
typedef char complex_fits[sizeof(kiss_fft_cpx) == sizeof(int64_t) ? 1 : -1];

/* 2^31 cos(2 pi i / 64) for any i, from a quarter turn. */
static int32_t cosine(uint32_t i)
{
    static const int32_t quarter[SWAY_SEARCH_POINTS / 4 + 1] = {
        2147483647, 2137142927, 2106220352, 2055013723, 1984016189, 1893911494,
        1785567396, 1660027308, 1518500250, 1362349204, 1193077991, 1012316784,
        821806413,  623381598,  418953276,  210490206,  0};
    const uint32_t at = i % SWAY_SEARCH_POINTS;
    const uint32_t half = at <= SWAY_SEARCH_POINTS / 2U ? at : SWAY_SEARCH_POINTS - at;
    return half <= SWAY_SEARCH_POINTS / 4U ? quarter[half]
                                           : -quarter[SWAY_SEARCH_POINTS / 2U - half];
}

/* As kiss_fft_alloc() does, with integers: 64 points are three stages of radix 4. */
static void make_state(sway_search_t *search)
{
    static const int factors[] = {4, 16, 4, 4, 4, 1};
    struct kiss_fft_state *state = (struct kiss_fft_state *)(void *)search->state;
    state->nfft = SWAY_SEARCH_POINTS;
    state->inverse = 0;
    memcpy(state->factors, factors, sizeof factors);
    for (uint32_t i = 0; i < SWAY_SEARCH_POINTS; i++) {
        state->twiddles[i].r = cosine(i);
        state->twiddles[i].i = cosine(i + SWAY_SEARCH_POINTS / 4U); // -sin
    }
}

sway_error_t sway_search_start(sway_search_t *search, const sway_search_config_t *config,
                               const sway_ring_t *ring)
{
    if (search == NULL || config == NULL || ring == NULL || config->sample_period_us <= 0 ||
        config->frequency_min_mhz <= 0 || config->frequency_max_mhz <= config->frequency_min_mhz) {
        return SWAY_ERROR_ARGUMENT;
    }
    const uint32_t rows = ring->filled < SWAY_WINDOW_MAX ? ring->filled : SWAY_WINDOW_MAX;
    if (rows < SWAY_WINDOW_MIN) {
        return SWAY_ERROR_NO_DATA;
    }
    make_state(search);
    search->config = *config;
    search->pending_mask =
        config->channel_mask & ring->present_mask & (SWAY_CHANNEL_BIT(SWAY_CHANNELS) - 1U);
    search->block = (rows + SWAY_SEARCH_POINTS - 1U) / SWAY_SEARCH_POINTS;
    search->points = rows / search->block;
    search->head = ring->head;
    search->loaded = 0;
    search->transformed = false;
    memset(search->power, 0, sizeof search->power);
    return SWAY_OK;
}

/* Least-squares slope times (n^2 - 1) n / 3 is the moment; takes the line out of the data. */
static void take_slope_out(int32_t *data, int64_t n)
{
    int64_t moment = 0;
    for (int64_t b = 0; b < n; b++) {
        moment += data[b] * (2 * b - n + 1);
    }
    const int64_t slope = sway_int64_divide(3 * moment, n * (n * n - 1));
    for (int64_t b = 0; b < n; b++) {
        data[b] -= (int32_t)(slope * (2 * b - n + 1));
    }
}

/* Largest shift by which all data stay below 2^SWAY_SEARCH_BITS. */
static int32_t headroom(const int32_t *data, uint32_t n)
{
    int32_t largest = 1;
    for (uint32_t b = 0; b < n; b++) {
        const int32_t size = data[b] < 0 ? -data[b] : data[b];
        largest = size > largest ? size : largest;
    }
    int32_t shift = 0;
    while (largest < (INT32_C(1) << (SWAY_SEARCH_BITS - 1))) {
        largest *= 2;
        shift++;
    }
    return shift;
}

/* Puts a channel, windowed, into the real (part 0) or imaginary (part 1) half of the input. */
static void load_channel(sway_search_t *search, const sway_ring_t *ring, uint32_t channel,
                         uint32_t part)
{
    int64_t *sums = search->output; // free until the input is transformed
    int32_t data[SWAY_SEARCH_POINTS];
    int64_t mean;
    kiss_fft_cpx *input = (kiss_fft_cpx *)(void *)search->input;
    const uint32_t n = search->points;
    (void)sway_ring_sums(ring, channel, search->head, search->block, n, sums);
    (void)sway_fit_center(sums, n, data, &mean);
    take_slope_out(data, (int64_t)n);
    const int32_t gain = INT32_C(1) << headroom(data, n);
    /* Hann: (1 - cos(2 pi (b + 1/2) / n)) / 2, the cosine by turning a Q30 pointer. */
    const sway_real_t turn =
        sway_real_div(sway_real_scale(sway_real_pi(), 1), sway_real_int((int32_t)n));
    const sway_complex_t step = sway_complex_unit(turn);
    const sway_complex_t at = sway_complex_unit(sway_real_scale(turn, -1));
    const int32_t step_re = (int32_t)sway_real_to_int64(step.re, 30);
    const int32_t step_im = (int32_t)sway_real_to_int64(step.im, 30);
    int32_t re = (int32_t)sway_real_to_int64(at.re, 30);
    int32_t im = (int32_t)sway_real_to_int64(at.im, 30);
    for (uint32_t b = 0; b < n; b++) {
        const int32_t weight = (INT32_C(1) << 29) - re / 2;
        const int32_t value = sway_int64_q30(data[b] * gain, weight);
        if (part == 0U) {
            input[b].r = value;
        } else {
            input[b].i = value;
        }
        const int32_t next = sway_int64_q30(re, step_re) - sway_int64_q30(im, step_im);
        im = sway_int64_q30(re, step_im) + sway_int64_q30(im, step_re);
        re = next;
    }
}

static uint64_t norm(int64_t re, int64_t im)
{
    return (uint64_t)(re * re) + (uint64_t)(im * im);
}

/* Adds the power of one of the two real channels, scaled to a total of 2^22..2^23. */
static void add_power(sway_search_t *search, int sign)
{
    const kiss_fft_cpx *z = (const kiss_fft_cpx *)(const void *)search->output;
    uint64_t power[SWAY_SEARCH_POINTS / 2];
    uint64_t total = 0;
    for (uint32_t k = 0; k < SWAY_SEARCH_POINTS / 2U; k++) {
        const kiss_fft_cpx a = z[k];
        const kiss_fft_cpx b = z[(SWAY_SEARCH_POINTS - k) % SWAY_SEARCH_POINTS];
        /* Z[k] +- conj(Z[N-k]), below 2^31 each: a quarter, so that 32 of them can be added */
        power[k] = norm(((int64_t)a.r + sign * (int64_t)b.r) / 4,
                        ((int64_t)a.i - sign * (int64_t)b.i) / 4);
        total += k > 0U ? power[k] : 0U;
    }
    int32_t shift = 0;
    while ((total >> shift) >= (UINT64_C(1) << 23)) {
        shift++;
    }
    for (uint32_t k = 0; k < SWAY_SEARCH_POINTS / 2U; k++) {
        const uint64_t scaled = power[k] >> shift;
        search->power[k] += scaled < (UINT64_C(1) << 24) ? (uint32_t)scaled : UINT32_C(1) << 24;
    }
}

static void add_powers(sway_search_t *search)
{
    add_power(search, 1);
    if (search->loaded == 2U) {
        add_power(search, -1);
    }
    search->loaded = 0;
    search->transformed = false;
}

static uint32_t take_channel(sway_search_t *search)
{
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        if ((search->pending_mask & SWAY_CHANNEL_BIT(c)) != 0U) {
            search->pending_mask &= ~SWAY_CHANNEL_BIT(c);
            return c;
        }
    }
    return SWAY_CHANNELS;
}

bool sway_search_run(sway_search_t *search, const sway_ring_t *ring)
{
    const uint32_t loaded = search->loaded;
    if (search->transformed) {
        add_powers(search);
        return search->pending_mask != 0U;
    }
    if (loaded < 2U) {
        const uint32_t channel = take_channel(search);
        if (channel < SWAY_CHANNELS) {
            if (loaded == 0U) {
                memset(search->input, 0, sizeof search->input);
            }
            load_channel(search, ring, channel, loaded);
            search->loaded = loaded + 1U;
            return true;
        }
        if (loaded == 0U) {
            return false;
        }
    }
    kiss_fft((kiss_fft_cfg)(void *)search->state, (const kiss_fft_cpx *)(void *)search->input,
             (kiss_fft_cpx *)(void *)search->output);
    search->transformed = true;
    return true;
}

sway_real_t sway_search_offset(sway_real_t below, sway_real_t middle, sway_real_t above)
{
    const sway_real_t r = sway_real_div(sway_real_sub(above, below), middle);
    const sway_real_t r2 = sway_real_scale(sway_real_mul(r, r), 2);
    const sway_real_t root = sway_real_sqrt(sway_real_add(sway_real_int(9), r2));
    const sway_real_t x =
        sway_real_div(sway_real_scale(r, 2), sway_real_add(sway_real_int(3), root));
    const sway_real_t limit = sway_real_ratio(6, 10);
    return sway_real_max(sway_real_neg(limit), sway_real_min(x, limit));
}

/* The bin that a frequency falls into. */
static uint32_t bin_of(const sway_search_t *search, int32_t mhz)
{
    const int64_t period_us =
        (int64_t)search->config.sample_period_us * search->block * SWAY_SEARCH_POINTS;
    const int64_t bin = sway_int64_divide((int64_t)mhz * period_us + 500000000, 1000000000);
    const int64_t last = SWAY_SEARCH_POINTS / 2 - 2;
    return (uint32_t)(bin < 1 ? 1 : bin > last ? last : bin);
}

static sway_real_t magnitude_at(const sway_search_t *search, uint32_t k)
{
    return sway_real_sqrt(sway_real(search->power[k], 0));
}

bool sway_search_result(const sway_search_t *search, sway_real_t *omega_rad_s)
{
    uint32_t best = bin_of(search, search->config.frequency_min_mhz);
    const uint32_t last = bin_of(search, search->config.frequency_max_mhz);
    for (uint32_t k = best + 1U; k <= last; k++) {
        best = search->power[k] > search->power[best] ? k : best;
    }
    if (search->power[best] == 0U) {
        return false;
    }
    const sway_real_t x =
        sway_search_offset(magnitude_at(search, best - 1U), magnitude_at(search, best),
                           magnitude_at(search, best + 1U));
    const sway_real_t bins = sway_real_add(sway_real_int((int32_t)best), x);
    const int64_t span_us =
        (int64_t)search->config.sample_period_us * search->block * SWAY_SEARCH_POINTS;
    const sway_real_t span_s = sway_real_micro(span_us);
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    *omega_rad_s = sway_real_div(sway_real_mul(turn, bins), span_s);
    return true;
}

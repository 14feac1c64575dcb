// SPDX-License-Identifier: MIT
#include "signal/sway_spectrum.h"

#include <string.h>

#include "arithmetic/sway_int64.h"

/* Bounds of one slice: table entries (two Taylor series each) and rows (channels x bins products).
 */
#define TABLE_SLICE 4U
#define ROW_SLICE 3U

sway_error_t sway_spectrum_init(sway_spectrum_t *spectrum, uint32_t window)
{
    if (spectrum == NULL || window < SWAY_WINDOW_MIN || window > SWAY_WINDOW_MAX) {
        return SWAY_ERROR_ARGUMENT;
    }
    memset(spectrum->re, 0, sizeof spectrum->re);
    memset(spectrum->im, 0, sizeof spectrum->im);
    spectrum->window = window;
    spectrum->phase = 0;
    spectrum->covered = 0;
    spectrum->tabled = 0;
    return SWAY_OK;
}

static bool has_table(const sway_spectrum_t *spectrum)
{
    return spectrum->tabled > spectrum->window / 2U;
}

/* Adds `x` at position `phase` of the window's period to all bins of a channel. */
static void add_sample(sway_spectrum_t *spectrum, uint32_t channel, uint32_t phase, int32_t x)
{
    int64_t *re = spectrum->re[channel];
    int64_t *im = spectrum->im[channel];
    uint32_t at = 0;
    for (uint32_t k = 0; k <= SWAY_BINS; k++) {
        re[k] += sway_int64_product(x, sway_spectrum_cosine(spectrum, at));
        im[k] += sway_int64_product(x, sway_spectrum_sine(spectrum, at));
        at += phase;
        if (at >= spectrum->window) {
            at -= spectrum->window;
        }
    }
}

void sway_spectrum_push(sway_spectrum_t *spectrum, const sway_ring_t *ring)
{
    const uint32_t phase = spectrum->phase;
    spectrum->phase = phase + 1U < spectrum->window ? phase + 1U : 0U;
    if (!has_table(spectrum)) {
        return;
    }
    const uint32_t newest = sway_ring_slot(ring, 0);
    const bool full = spectrum->covered == spectrum->window;
    const uint32_t leaving = sway_ring_slot(ring, spectrum->window);
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        const int32_t old = full ? ring->sample[c][leaving] : 0;
        const int32_t step = ring->sample[c][newest] - old; // below 2^28
        if (step != 0) {
            add_sample(spectrum, c, phase, step);
        }
    }
    if (!full) {
        spectrum->covered += 1U;
    }
}

static void make_table(sway_spectrum_t *spectrum)
{
    const sway_real_t step =
        sway_real_div(sway_real_scale(sway_real_pi(), 1), sway_real_int((int32_t)spectrum->window));
    for (uint32_t i = 0; i < TABLE_SLICE && !has_table(spectrum); i++) {
        const uint32_t at = spectrum->tabled;
        sway_real_t s;
        sway_real_t c;
        sway_real_sincos(sway_real_mul(step, sway_real_int((int32_t)at)), &s, &c);
        spectrum->cosine[at] = (int32_t)sway_real_to_int64(c, SWAY_TWIDDLE_BITS);
        spectrum->sine[at] = -(int32_t)sway_real_to_int64(s, SWAY_TWIDDLE_BITS);
        spectrum->tabled = at + 1U;
    }
}

bool sway_spectrum_run(sway_spectrum_t *spectrum, const sway_ring_t *ring)
{
    if (!has_table(spectrum)) {
        make_table(spectrum);
        return true;
    }
    for (uint32_t i = 0; i < ROW_SLICE && spectrum->covered < spectrum->window; i++) {
        const uint32_t age = spectrum->covered; // the newest has age 0 and phase - 1
        const uint32_t back = (age + 1U) % spectrum->window;
        const uint32_t phase = (spectrum->phase + spectrum->window - back) % spectrum->window;
        const uint32_t slot = sway_ring_slot(ring, age);
        for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
            add_sample(spectrum, c, phase, ring->sample[c][slot]);
        }
        spectrum->covered += 1U;
    }
    return spectrum->covered < spectrum->window;
}

bool sway_spectrum_ready(const sway_spectrum_t *spectrum)
{
    return spectrum->window > 0U && spectrum->covered == spectrum->window;
}

sway_complex_t sway_spectrum_bin(const sway_spectrum_t *spectrum, sway_channel_t channel,
                                 uint32_t k)
{
    const uint32_t at = k * spectrum->phase % spectrum->window;
    const sway_complex_t sum =
        sway_complex(sway_real(spectrum->re[channel][k], -SWAY_TWIDDLE_BITS),
                     sway_real(spectrum->im[channel][k], -SWAY_TWIDDLE_BITS));
    const sway_complex_t turn =
        sway_complex(sway_real(sway_spectrum_cosine(spectrum, at), -SWAY_TWIDDLE_BITS),
                     sway_real(-sway_spectrum_sine(spectrum, at), -SWAY_TWIDDLE_BITS));
    return sway_complex_mul(sum, turn);
}

sway_complex_t sway_spectrum_hann(const sway_spectrum_t *spectrum, sway_channel_t channel,
                                  uint32_t k)
{
    const sway_complex_t below = sway_spectrum_bin(spectrum, channel, k - 1U);
    const sway_complex_t above = sway_spectrum_bin(spectrum, channel, k + 1U);
    const sway_complex_t middle = sway_spectrum_bin(spectrum, channel, k);
    const sway_complex_t sides = sway_complex_add(below, above);
    const sway_real_t half = sway_real_ratio(1, 2);
    return sway_complex_scale(sway_complex_sub(middle, sway_complex_scale(sides, half)), half);
}

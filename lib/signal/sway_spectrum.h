// SPDX-License-Identifier: MIT
/// sway_spectrum: modulated sliding DFT of every channel, in exact integers.
///
/// Bin k of channel c over the newest N rows (rectangular window) is the sum of x[s] w[k s mod N],
/// w[i] = exp(-2 pi j i / N) rounded once to SWAY_TWIDDLE_BITS. A row enters and, N rows later,
/// leaves with the same factor, so one product (x_new - x_old) w per part updates the sum, and the
/// sum is at every instant bit for bit the one computed afresh from the window: no drift, whatever
/// the number of rows. (Modulated form: Duda, IEEE Signal Processing Magazine 27(6), 2010.)
///
/// No overflow: |x| < 2^27, |w| <= 2^SWAY_TWIDDLE_BITS, N <= SWAY_RING_SAMPLES, and
/// 27 + SWAY_TWIDDLE_BITS + log2(SWAY_RING_SAMPLES) = 62 bits and a sign (tests/proofs).
///
/// The Hann window is applied to the sums: H[k] = X[k] / 2 - (X[k-1] + X[k+1]) / 4.
#ifndef SWAY_SPECTRUM_H
#define SWAY_SPECTRUM_H

#include "arithmetic/sway_real.h"
#include "signal/sway_ring.h"

/// Bits of the twiddle factors: 35 - log2(SWAY_RING_SAMPLES); 26 for 512 rows.
#define SWAY_TWIDDLE_BITS                                                                          \
    (SWAY_RING_SAMPLES <= 64     ? 29                                                              \
     : SWAY_RING_SAMPLES <= 128  ? 28                                                              \
     : SWAY_RING_SAMPLES <= 256  ? 27                                                              \
     : SWAY_RING_SAMPLES <= 512  ? 26                                                              \
     : SWAY_RING_SAMPLES <= 1024 ? 25                                                              \
     : SWAY_RING_SAMPLES <= 2048 ? 24                                                              \
     : SWAY_RING_SAMPLES <= 4096 ? 23                                                              \
                                 : 22)

typedef struct {
    uint32_t window;  ///< N
    uint32_t phase;   ///< row number of the next row, modulo N
    uint32_t covered; ///< newest rows that are in the sums; ready when equal to N
    uint32_t tabled;  ///< entries of the table that are made, N/2 + 1 in the end
    int64_t re[SWAY_CHANNELS][SWAY_BINS + 1];
    int64_t im[SWAY_CHANNELS][SWAY_BINS + 1];
    int32_t cosine[SWAY_RING_SAMPLES / 2 + 1]; ///< w of the present window, entries 0 .. N/2:
    int32_t sine[SWAY_RING_SAMPLES / 2 + 1];   ///< the others mirror them
} sway_spectrum_t;

/// Real and imaginary part of w[at], at < N, when the table is made.
static inline int32_t sway_spectrum_cosine(const sway_spectrum_t *spectrum, uint32_t at)
{
    return spectrum->cosine[2U * at > spectrum->window ? spectrum->window - at : at];
}

static inline int32_t sway_spectrum_sine(const sway_spectrum_t *spectrum, uint32_t at)
{
    return 2U * at > spectrum->window ? -spectrum->sine[spectrum->window - at] : spectrum->sine[at];
}

/// Empty sums over `window` rows (SWAY_WINDOW_MIN..SWAY_WINDOW_MAX, else SWAY_ERROR_ARGUMENT).
/// The sums fill from the ring by sway_spectrum_run().
sway_error_t sway_spectrum_init(sway_spectrum_t *spectrum, uint32_t window);

/// Takes the row that was just pushed into `ring`: one product per channel, bin and part.
void sway_spectrum_push(sway_spectrum_t *spectrum, const sway_ring_t *ring);

/// One bounded slice of filling the sums from the ring (table entries or rows); true while more is
/// to be done. Between slices, sway_spectrum_push() goes on as ever.
bool sway_spectrum_run(sway_spectrum_t *spectrum, const sway_ring_t *ring);

/// The sums are those of the newest `window` rows.
bool sway_spectrum_ready(const sway_spectrum_t *spectrum);

/// Bin k (0..SWAY_BINS) of a channel, phase counted from the first row of the window, in sample
/// units times rows: a line a cos(2 pi k s/N + phi) gives N a/2 exp(j phi) for k > 0.
sway_complex_t sway_spectrum_bin(const sway_spectrum_t *spectrum, sway_channel_t channel,
                                 uint32_t k);

/// Hann-windowed bin k (1..SWAY_BINS-1), scaled as sway_spectrum_bin() halved.
sway_complex_t sway_spectrum_hann(const sway_spectrum_t *spectrum, sway_channel_t channel,
                                  uint32_t k);

#endif

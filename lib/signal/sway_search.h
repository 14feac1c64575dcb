// SPDX-License-Identifier: MIT
/// sway_search: finds the dominant line over the whole ring, with kissfft in fixed point.
///
/// The rows in the ring are summed to at most SWAY_SEARCH_POINTS points, mean and slope are taken
/// out, a Hann window is applied, and two channels share one complex transform. The powers of the
/// channels, each divided by its own total, add up; the highest point in the band is the line, its
/// place between the points by the closed form x = 4 r / (3 + sqrt(9 + 4 r^2)) of the Hann window.
///
/// kissfft overflows without a word at full scale. It divides by the radix at every stage, so an
/// output is at most sqrt(2) times the largest part of its input: every input here is below
/// 2^SWAY_SEARCH_BITS, one bit less than that needs.
#ifndef SWAY_SEARCH_H
#define SWAY_SEARCH_H

#include "arithmetic/sway_real.h"
#include "signal/sway_ring.h"

#define SWAY_SEARCH_POINTS 64
#define SWAY_SEARCH_BITS 29

typedef struct {
    uint32_t channel_mask;
    int32_t sample_period_us;
    int32_t frequency_min_mhz;
    int32_t frequency_max_mhz;
} sway_search_config_t;

typedef struct {
    sway_search_config_t config;
    uint32_t pending_mask; ///< channels still to be transformed
    uint32_t loaded;       ///< channels in the input: 0..2
    bool transformed;      ///< the output is there
    uint32_t block;        ///< rows in a point
    uint32_t points;       ///< points with data
    uint32_t head;         ///< ring slot after the newest row when the search began
    int64_t state[33 + SWAY_SEARCH_POINTS]; ///< state of kissfft
    int64_t input[SWAY_SEARCH_POINTS];      ///< complex numbers of kissfft
    int64_t output[SWAY_SEARCH_POINTS];
    uint32_t power[SWAY_SEARCH_POINTS / 2];
} sway_search_t;

/// Starts a search over the rows that the ring holds now. SWAY_ERROR_NO_DATA: fewer rows than
/// SWAY_WINDOW_MIN. SWAY_ERROR_ARGUMENT: null or an empty band.
sway_error_t sway_search_start(sway_search_t *search, const sway_search_config_t *config,
                               const sway_ring_t *ring);

/// One slice: one channel is loaded, one pair transformed, or its power added. True while more is
/// to be done.
bool sway_search_run(sway_search_t *search, const sway_ring_t *ring);

/// Angular frequency of the highest point in the band. False: there is no power in the band.
bool sway_search_result(const sway_search_t *search, sway_real_t *omega_rad_s);

/// Place of a line between the bins of a Hann window from three neighbouring magnitudes:
/// offset from the middle one in bins, clipped to +-0.6. Closed form of the dissertation's App.
/// A.3.
sway_real_t sway_search_offset(sway_real_t below, sway_real_t middle, sway_real_t above);

#endif

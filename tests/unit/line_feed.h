/* Shared by the tests of the estimator's parts: a ring with a damped tone. */
#ifndef LINE_FEED_H
#define LINE_FEED_H

#include "signal/sway_line.h"
#include "sway_test.h"

/* A uniform number in [-1, 1) and the next seed. */
static inline double next_noise(uint32_t *seed)
{
    *seed = *seed * 1664525U + 1013904223U;
    return (*seed >> 8) / 8388608.0 - 1.0;
}

/* Rows of 10 ms of channels 1 and 2: of the first amplitude times a damped cosine, and noise of
 * +-`noise`; the second is 0. */
static inline void fill_tone(sway_ring_t *ring, uint32_t *seed, int rows, double hertz,
                             double growth, double amplitude, double noise)
{
    sway_ring_clear(ring);
    for (int k = 0; k < rows; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        const double t = k * 0.01;
        const double n = noise * next_noise(seed);
        row.time_us = 10000 * (int64_t)k;
        row.present_mask = row.valid_mask = SWAY_CHANNEL_BIT(1) | SWAY_CHANNEL_BIT(2);
        row.value[1] =
            (int32_t)lround(1e6 * (amplitude * exp(growth * t) * cos(2 * M_PI * hertz * t) + n));
        sway_ring_push(ring, &row);
    }
}

static inline sway_line_config_t line_config(void)
{
    const sway_line_config_t result = {.channel_mask = SWAY_CHANNEL_BIT(1) | SWAY_CHANNEL_BIT(2),
                                       .sample_period_us = 10000,
                                       .frequency_min_mhz = 250,
                                       .frequency_max_mhz = 2000,
                                       .steering_quiet_urad = 17453,
                                       .speed_change_milli = 50,
                                       .result_mask = UINT32_MAX};
    return result;
}

#endif

/// sway_seek: finds the dominant line over the whole ring, with kissfft in fixed point.
///
/// The ring is summed to SWAY_SEEK_POINTS / 2 points, mean and slope are taken out, a Hann window
/// and zero padding applied; two channels share one complex transform. The powers of the channels,
/// each divided by its own total, add up; the highest point in the band is the line.
/// kissfft scales by 1/N and overflows without a word at full scale: every input here is
/// scaled to below 2^SWAY_SEEK_BITS, one bit of headroom beyond what the sum of two channels needs.
#ifndef SWAY_SEEK_H
#define SWAY_SEEK_H

#include "sway_real.h"
#include "sway_ring.h"

#define SWAY_SEEK_POINTS 256
#define SWAY_SEEK_BITS 29

typedef struct {
    uint32_t channel_mask;
    int32_t sample_period_us;
    int32_t frequency_min_mhz;
    int32_t frequency_max_mhz;
} sway_seek_config_t;

typedef struct {
    sway_seek_config_t config;
    uint32_t pending_mask;  ///< channels still to be transformed
    uint32_t block;         ///< rows in a point
    uint32_t points;        ///< points with data
    uint32_t head;          ///< ring slot after the newest row when the search began
    int32_t buffer[2 * SWAY_SEEK_POINTS];
    uint32_t power[SWAY_SEEK_POINTS / 2];
    sway_real_t frequency_hz;
    bool found;
} sway_seek_t;

/// Starts a search over the rows that the ring holds now. SWAY_ERROR_NO_DATA: fewer rows than one
/// oscillation at frequency_min_mhz or than SWAY_WINDOW_MIN.
sway_error_t sway_seek_start(sway_seek_t *seek, const sway_seek_config_t *config,
                             const sway_ring_t *ring);

/// One slice: one pair of channels (one 256-point transform). True while more is to be done.
bool sway_seek_run(sway_seek_t *seek, const sway_ring_t *ring);

/// Frequency of the highest point in the band, interpolated, in Hz. False: nothing stands out.
bool sway_seek_result(const sway_seek_t *seek, sway_real_t *frequency_hz);

#endif

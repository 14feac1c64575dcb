// SPDX-License-Identifier: MIT
/// sway_track: holds the dominant line: ring, sliding spectrum, search and estimates in one loop.
///
/// Push every row of the grid, then call sway_track_run() for work of a fixed cost per row,
/// reported by sway_track_cost(): each call is one bounded slice. Every window/16 rows an estimate
/// starts, or when the last one is done; its result replaces the last one and `sequence` counts up.
/// A break of the line (a step, an onset) that one window has shown clearly is in all windows until
/// it has left them, though a damped line may fit some of them well: they are all flagged.
/// Where the frequency has changed over the last window by more than 4 standard errors, the
/// estimate takes that change as known (a chirp), so that a drifting line is not misread.
#ifndef SWAY_TRACK_H
#define SWAY_TRACK_H

#include "signal/sway_line.h"
#include "signal/sway_search.h"
#include "signal/sway_spectrum.h"

/// Slices per row that let every estimate end before the next starts, where nobody counts costs.
#define SWAY_TRACK_SLICES 24

typedef struct {
    int32_t sample_period_us;    ///< of the grid
    int32_t window_cycles_milli; ///< window length in oscillations x 1000: 1500..6000
    int32_t frequency_min_mhz;   ///< band of the line, millihertz: 100..10000
    int32_t frequency_max_mhz;
    uint32_t channel_mask; ///< channels that take part in frequency and growth
    int32_t
        steering_quiet_urad;    ///< RMS of the steering wheel about its mean and slope, above which
                                ///< the motion counts as forced
    int32_t speed_change_milli; ///< change of speed over a window, of its mean x 1000, that flags
} sway_track_config_t;

/// Memory of what is done one after the other; between two estimates it is the caller's.
typedef union {
    sway_search_t search;
    sway_line_job_t job;
} sway_track_work_t;

/// Good estimates that are kept to see how the frequency changes; a power of two.
#define SWAY_TRACK_HISTORY 16

typedef struct {
    bool locked;
    bool spectrum_first; ///< a row has come since the sums were filled by a slice
    bool free;           ///< the line was there while the steering was quiet
    uint32_t state;
    sway_channel_t pilot; ///< the clearest channel, while a line is lost
    uint32_t sequence;
    uint32_t rows_to_hop;    ///< rows until the next estimate is due
    uint32_t lost;           ///< estimates in a row that held no line
    uint32_t harmonics_mask; ///< channels that had 2f and 3f in their last model
    uint32_t past_count;     ///< since the line was found
    sway_track_work_t *work;
    sway_track_config_t config;
    int64_t change_time_us;   ///< windows that begin earlier hold a break of the line
    sway_real_t forced_rad_s; ///< the driver's tone, found for the estimate that follows; or 0
    sway_real_t omega_rad_s;  ///< start of the next estimate
    sway_real_t past_omega[SWAY_TRACK_HISTORY];
    sway_real_t past_se[SWAY_TRACK_HISTORY];
    int64_t past_us[SWAY_TRACK_HISTORY];
    sway_line_t line; ///< latest result, or the one in the making
    sway_spectrum_t spectrum;
    sway_ring_t ring;
} sway_track_t;

/// 2 oscillations, 0.25..2 Hz, all channels except the steering wheel, 1 deg, 5 %.
sway_track_config_t sway_track_default(int32_t sample_period_us);

/// `work` is used while sway_track_run() has more to do. Neither it nor `track` may be moved
/// afterwards. SWAY_ERROR_ARGUMENT for a null pointer or a value out of range.
sway_error_t sway_track_init(sway_track_t *track, const sway_track_config_t *config,
                             sway_track_work_t *work);

/// Takes one row of the grid. A row with `restart` empties the ring.
void sway_track_push(sway_track_t *track, const sway_row_t *row);

/// What the next slice costs about, in the unit of SWAY_SLICE_COST; 0: nothing is pending.
uint32_t sway_track_cost(const sway_track_t *track);

/// One bounded slice of pending work; true while more is pending.
bool sway_track_run(sway_track_t *track);

/// The latest result and how many there have been. It stays as it is until sway_track_run() goes on
/// with the next estimate. Before the first, flags hold
/// SWAY_LINE_STARTING | SWAY_LINE_SEEKING.
const sway_line_t *sway_track_line(const sway_track_t *track);
uint32_t sway_track_sequence(const sway_track_t *track);

#endif

/// core_feed: whole recordings into sway_core_t, without a Python call for each sample.
#ifndef CORE_FEED_H
#define CORE_FEED_H

#include <stddef.h>

#include "sway_node.h"

/// Samples of one input in order of time; `next` is where the feed goes on.
typedef struct {
    int32_t input; ///< sway_input_t
    size_t count;
    size_t next;
    const int64_t *time_us;
    const int32_t *value;
} core_feed_t;

/// Feeds the samples of all feeds before `until_us`, merged by time (at equal times in the order
/// of the feeds), running the core's slices after each time, and copies every new status.
///
/// Returns the number of statuses written to `status`; stops early when `room` is used up (call
/// again to go on). `*done` says that every sample before `until_us` has been fed.
size_t core_feed(sway_core_t *core, core_feed_t *feeds, size_t feed_count, int64_t until_us,
                 sway_status_t *status, size_t room, bool *done);

/// SWAY_VERSION of the core inside.
uint32_t core_version(void);

/// Writes rolling counters (one for each identifier, from 0) and CRCs into `count` frames whose
/// data lie `width` bytes apart.
void core_protect(const uint32_t *can_id, uint8_t *data, size_t width, size_t count);

/// Gives the frames from `*next` on to the node, and writes the status frames that become due with
/// the time of the frame that caused them. Returns their number; stops early when `room` is used up
/// (call again to go on), `*next` == `count` at the end.
size_t core_replay(sway_node_t *node, const int64_t *time_us, const uint32_t *can_id,
                   const uint8_t *length, const uint8_t *data, size_t width, size_t count,
                   size_t *next, int64_t *out_time_us, uint32_t *out_id, uint8_t *out_data,
                   size_t room);

/// Memory of core_window(); contents are private.
typedef struct {
    sway_ring_t ring;
    sway_line_job_t job;
    sway_line_t line;
} core_window_t;

/// What core_window() found; rates in 1/s and rad/s, amplitudes and noise in the samples' unit.
typedef struct {
    int32_t error; ///< sway_error_t
    uint32_t flags;
    uint32_t rows; ///< the newest ones that were used
    double omega_rad_s;
    double omega_se_rad_s;
    double growth_1_s;
    double growth_se_1_s;
    double amplitude_re[SWAY_CHANNELS - 1]; ///< at the middle of the rows that were used
    double amplitude_im[SWAY_CHANNELS - 1];
    double mean[SWAY_CHANNELS - 1];
    double noise_rms[SWAY_CHANNELS - 1];
} core_line_t;

/// One estimate of sway_line over a window of its own: `sample` holds `rows` rows of `channels`
/// (1..SWAY_CHANNELS - 1) values, |value| below 2^27, of which those in `used_mask` (bit 0: the
/// first) share frequency and growth; the others are only read at that line. `omega_rad_s` is
/// where the search begins;
/// `level`: as in sway_line_config_t.
void core_window(core_window_t *memory, const int32_t *sample, uint32_t rows, uint32_t channels,
                 uint32_t used_mask, int32_t sample_period_us, double omega_rad_s, bool level,
                 core_line_t *found);

#endif

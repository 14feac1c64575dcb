/// core_feed: whole recordings into sway_core_t, without a Python call for each sample.
#ifndef CORE_FEED_H
#define CORE_FEED_H

#include <stddef.h>

#include "sway_core.h"

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

#endif

// SPDX-License-Identifier: MIT
/// sway_ring: the newest SWAY_RING_SAMPLES rows of the grid.
#ifndef SWAY_RING_H
#define SWAY_RING_H

#include "signal/sway_grid.h"

/// Longest window: the ring less the rows that may arrive while a job reads it in slices.
#define SWAY_WINDOW_MAX (SWAY_RING_SAMPLES - 16)
/// Shortest window.
#define SWAY_WINDOW_MIN 32

typedef struct {
    uint32_t head;   ///< slot of the next row
    uint32_t filled; ///< rows held, at most SWAY_RING_SAMPLES
    uint32_t present_mask;
    int64_t newest_time_us;
    uint32_t speed[SWAY_RING_SAMPLES]; ///< twice the speed in mm/s, plus 1 where it is valid
    uint16_t valid[SWAY_RING_SAMPLES]; ///< valid_mask of the channels
    int32_t sample[SWAY_CHANNELS][SWAY_RING_SAMPLES];
} sway_ring_t;

void sway_ring_clear(sway_ring_t *ring);

/// Takes one row. Values beyond SWAY_SAMPLE_LIMIT are clipped and marked not valid.
void sway_ring_push(sway_ring_t *ring, const sway_row_t *row);

/// Sums of `block` rows of a channel each, `blocks` of them, ending before slot `head`.
/// blocks <= 64, blocks * block <= SWAY_RING_SAMPLES. Returns a bit per block with a row not valid.
uint64_t sway_ring_sums(const sway_ring_t *ring, uint32_t channel, uint32_t head, uint32_t block,
                        uint32_t blocks, int64_t *sums);

/// Slot of the row `age` rows before the newest (age 0). age < SWAY_RING_SAMPLES; rows that were
/// never filled read 0 and not valid.
static inline uint32_t sway_ring_slot(const sway_ring_t *ring, uint32_t age)
{
    return (ring->head - 1U - age) & (SWAY_RING_SAMPLES - 1U);
}

#endif

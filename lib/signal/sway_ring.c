// SPDX-License-Identifier: MIT
#include "signal/sway_ring.h"

#include <string.h>

void sway_ring_clear(sway_ring_t *ring)
{
    memset(ring, 0, sizeof *ring);
}

void sway_ring_push(sway_ring_t *ring, const sway_row_t *row)
{
    const uint32_t slot = ring->head;
    uint32_t valid = row->valid_mask;
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        int32_t value = row->value[c];
        if (value >= SWAY_SAMPLE_LIMIT || value <= -SWAY_SAMPLE_LIMIT) {
            value = value > 0 ? SWAY_SAMPLE_LIMIT - 1 : 1 - SWAY_SAMPLE_LIMIT;
            valid &= ~SWAY_CHANNEL_BIT(c);
        }
        ring->sample[c][slot] = value;
    }
    ring->speed[slot] =
        2U * (uint32_t)row->value[SWAY_CHANNEL_SPEED] + ((valid >> SWAY_CHANNEL_SPEED) & 1U);
    ring->valid[slot] = (uint16_t)(valid & UINT16_MAX);
    ring->present_mask = row->present_mask;
    ring->newest_time_us = row->time_us;
    ring->head = (slot + 1U) & (SWAY_RING_SAMPLES - 1U);
    if (ring->filled < SWAY_RING_SAMPLES) {
        ring->filled += 1U;
    }
}

uint64_t sway_ring_sums(const sway_ring_t *ring, uint32_t channel, uint32_t head, uint32_t block,
                        uint32_t blocks, int64_t *sums)
{
    uint32_t slot = (head - blocks * block) & (SWAY_RING_SAMPLES - 1U);
    uint64_t missing = 0;
    for (uint32_t b = 0; b < blocks; b++) {
        int64_t sum = 0;
        uint32_t valid = SWAY_CHANNEL_BIT(channel);
        for (uint32_t i = 0; i < block; i++) {
            sum += ring->sample[channel][slot];
            valid &= ring->valid[slot];
            slot = (slot + 1U) & (SWAY_RING_SAMPLES - 1U);
        }
        sums[b] = sum;
        if (valid == 0U) {
            missing |= UINT64_C(1) << b;
        }
    }
    return missing;
}

/// sway_bit_timing: divides a CAN controller's clock into the segments of a bit.
#ifndef SWAY_BIT_TIMING_H
#define SWAY_BIT_TIMING_H

#include <stdbool.h>
#include <stdint.h>

/// What a controller can do; all in time quanta, the synchronisation segment of one not counted.
typedef struct {
    uint32_t prescaler_max;
    uint32_t segment1_max; ///< propagation and phase 1 together
    uint32_t segment2_max;
    uint32_t jump_max;
} sway_bit_limits_t;

/// The values themselves; most controllers want each less one in their registers.
typedef struct {
    uint32_t prescaler;
    uint32_t segment1;
    uint32_t segment2;
    uint32_t jump;
} sway_bit_timing_t;

/// The exact division of `clock_hz` into `bit_rate` (at 8 to 80 quanta a bit, the most there are)
/// whose sample point is nearest to `sample_point_milli` (875 is CANopen's). False: there is no
/// exact one. Bounded: at most 73 steps.
bool sway_bit_timing(uint32_t clock_hz, uint32_t bit_rate, uint32_t sample_point_milli,
                     const sway_bit_limits_t *limits, sway_bit_timing_t *timing);

#endif

// SPDX-License-Identifier: MIT
/// sway_grid: from samples that arrive whenever their message does to one even row per period.
///
/// Every input is interpolated linearly between its own two neighbouring samples, so messages need
/// not be synchronous and their rates may differ; the wheels of an axle are added to one channel.
/// A span between two samples longer than `max_gap_us` is filled and marked not valid.
///
/// What is wrong with an input is counted, makes its rows not valid (and so marks the estimates
/// whose window holds them), and stops nothing else: a value out of range, a timestamp that goes
/// back or jumps, silence, a rate that is not the nominal one.
///
/// A row is handed out when every live input has passed its time, or at the latest when any input
/// is `max_wait_us` ahead of it. Only timestamps decide, never the speed of the machine.
/// Memory is the caller's; no function allocates or waits.
#ifndef SWAY_GRID_H
#define SWAY_GRID_H

#include "sway_types.h"

/// Rows that can wait for late inputs. A power of two; max_wait_us <= (rows - 2) periods.
#ifndef SWAY_GRID_ROWS
#define SWAY_GRID_ROWS 16
#endif
#if SWAY_GRID_ROWS < 8 || SWAY_GRID_ROWS > 64 || (SWAY_GRID_ROWS & (SWAY_GRID_ROWS - 1)) != 0
#error "SWAY_GRID_ROWS: 8, 16, 32 or 64"
#endif

/// |value| of a channel is below this: two wheels of 50e6 mN are 1e8 < 2^27.
#define SWAY_SAMPLE_BITS 27
#define SWAY_SAMPLE_LIMIT (INT32_C(1) << SWAY_SAMPLE_BITS)

/// Largest magnitude of a timestamp: 2^60 us.
#define SWAY_GRID_TIME_LIMIT (INT64_C(1) << 60)

typedef struct {
    int32_t sample_period_us; ///< 1000..100000
    int32_t max_gap_us;       ///< longest span between two samples that counts as data
    int32_t max_speed_gap_us; ///< the same for SWAY_INPUT_SPEED
    int32_t max_wait_us;      ///< how long a row waits for a late input
    /// Nominal time between two samples of an input, 1000..100000; 0: any. An input whose intervals
    /// are off by more than 6 % in the mean of about 64 is not valid until they are within 4 %;
    /// whole multiples (lost or slower messages) and less than 3/4 of it are not judged.
    int32_t input_period_us;
    /// Age of an input's value when its message is stamped, by place; subtracted from its
    /// timestamps. us, +-500000.
    int32_t delay_us[SWAY_INPUT_PLACES];
} sway_grid_config_t;

/// One row of the grid.
typedef struct {
    bool restart;          ///< this row does not follow the one before
    uint32_t valid_mask;   ///< SWAY_CHANNEL_BIT; a clear bit: value is filled in
    uint32_t present_mask; ///< channels whose inputs have all been seen ever
    int64_t time_us;
    int32_t value[SWAY_CHANNEL_COUNT + 1]; ///< by sway_channel_t, speed last; units of the inputs
} sway_row_t;

/// Counters of what was wrong with the input; they never go down.
typedef struct {
    uint32_t out_of_range;
    uint32_t time_backward;
    uint32_t gaps;     ///< spans longer than max_gap_us; counted while an input is silent
    uint32_t invalid;  ///< values that the sender marked not valid
    uint32_t late;     ///< samples that came after their row had been handed out
    uint32_t restarts; ///< jumps of the clock
    uint32_t off_rate; ///< times that an input's rate left the nominal one
} sway_grid_faults_t;

typedef struct {
    int64_t time_us;
    int32_t value;
    int16_t drift;          ///< mean deviation from input_period_us or its multiples, 2 us
    bool seen : 1;          ///< has had a sample ever
    bool timed : 1;         ///< the value is of time_us; else the grid started then
    bool usable : 1;        ///< the value is one to interpolate from
    bool stamp_refused : 1; ///< the last stamp was refused: the next row is not data yet
    bool silent : 1;        ///< this gap has been counted
    bool off_rate : 1;
} sway_grid_input_t;

typedef struct {
    bool suspected;
    bool running;
    bool restart;
    uint32_t refused;     ///< refusals for time in a row
    uint32_t next_slot;   ///< where the next row to hand out is
    int64_t next_time_us; ///< its time
    int64_t newest_time_us;
    int64_t suspect_us; ///< a stamp far ahead that waits for a second one
    sway_grid_faults_t faults;
    sway_grid_config_t config;
    uint32_t filled[SWAY_GRID_ROWS]; ///< bit per place: has a value
    uint32_t valid[SWAY_GRID_ROWS];  ///< bit per place: that value is data
    sway_grid_input_t input[SWAY_INPUT_PLACES];
    int32_t row[SWAY_GRID_ROWS][SWAY_INPUT_PLACES];
} sway_grid_t;

/// period, max_gap 60 ms (20 Hz with jitter), speed gap 500 ms, wait 100 ms, no delays, any rate.
sway_grid_config_t sway_grid_default(int32_t sample_period_us);

/// SWAY_ERROR_ARGUMENT for a value out of range. Clears everything, the counters too.
sway_error_t sway_grid_init(sway_grid_t *grid, const sway_grid_config_t *config);

/// One sample. Refused, counted, and the span around it is not data: SWAY_ERROR_RANGE;
/// SWAY_ERROR_TIME for a stamp before the last one of this input, 1 s behind the rows, or 0.5 s
/// ahead of all others while no second one agrees. After 16 refusals in a row for being old the
/// clock counts as restarted. SWAY_ERROR_ARGUMENT: no such input, or |time_us| beyond
/// SWAY_GRID_TIME_LIMIT. A sample of the same time replaces the one before for what follows. Take
/// the rows that became ready with sway_grid_next_row() before the next call. Nothing but its range
/// is looked at where the build does not keep the input. Cost: at most SWAY_GRID_ROWS
/// interpolations.
sway_error_t sway_grid_input(sway_grid_t *grid, sway_input_t input, int64_t time_us, int32_t value);

/// The sender says that this input has no valid value at `time_us`.
void sway_grid_invalid(sway_grid_t *grid, sway_input_t input, int64_t time_us);

/// The next row, if it is ready. Call until false.
bool sway_grid_next_row(sway_grid_t *grid, sway_row_t *row);

/// Range of an input: -limit..limit (0..limit for speed and wheel loads).
int32_t sway_grid_limit(sway_input_t input);

#endif

// SPDX-License-Identifier: MIT
/// sway_core: samples in, status out. The only interface that ports and tools need.
///
///     sway_core_config_t config;
///     sway_core_defaults(&config);
///     config.vehicle = my_vehicle;
///     sway_core_init(&core, &config);
///     ... for every decoded signal: sway_core_input(&core, input, time_us, value);
///     ... while (sway_core_run(&core)) {}
///     sway_core_status(&core)->alarm
///
/// All memory is in sway_core_t, which the caller owns; nothing is allocated, nothing is shared
/// between two cores. Not re-entrant: one core belongs to one thread (or interrupt level).
///
/// The way of the data: sway_grid (even rows) -> sway_track (ring, sliding spectrum, search, damped
/// line) -> sway_identify (slips, forces, stiffnesses, loads, inertias) -> sway_margin
/// (single-track model sway_single_track, combination with the signals) -> sway_alarm ->
/// sway_status_t.
#ifndef SWAY_CORE_H
#define SWAY_CORE_H

#include "judge/sway_judge.h"
#include "judge/sway_supervise.h"
#include "signal/sway_grid.h"
#include "model/sway_identify.h"
#include "model/sway_margin.h"
#include "model/sway_swing.h"
#include "model/sway_trailer.h"
#include "sway_status.h"
#include "signal/sway_track.h"
#include "sway_vehicle.h"

SWAY_C_BEGIN

/// Every bit of sway_core_config_t.trailer_assumed.
#define SWAY_ASSUMED_ALL 31

typedef struct {
    sway_vehicle_t vehicle;
    int32_t sample_period_us;    ///< of the grid: 10000 (5000 .. 20000)
    int32_t window_cycles_milli; ///< window in oscillations x 1000: 1700 (1500 .. 6000)
    int32_t input_delay_us[SWAY_INPUT_COUNT]; ///< known delay of each input: its timestamps are
                                              ///< that much too late; +-500000
    /// Nominal time between two samples of an input: 10000, the cycle of all messages of
    /// swaywatch.dbc (1000 .. 100000; 0: any). See sway_grid_config_t.
    int32_t input_period_us;
    sway_alarm_config_t alarm;
    /// Values of the trailer that are typical ones, because nobody knows them: bits 1 << i for
    /// mass, hitch_to_cog, yaw inertia, stiffnesses, places of the axles. See sway_trailer_init().
    int32_t trailer_assumed;
} sway_core_config_t;

/// Memory of what is done one after the other: while the track has nothing to do, the last estimate
/// is identified in it.
typedef union {
    sway_track_work_t track;
    sway_identify_t identify;
} sway_core_work_t;

/// Holds pointers into itself: must not be moved or copied after sway_core_init().
typedef struct {
    uint8_t slices_due; ///< of the row that was taken last
    uint8_t stage;
    uint8_t part;          ///< of the status that is written next
    bool fed;              ///< samples have come: a row may be ready
    bool identified;       ///< work.identify holds results of this line
    bool modelled;         ///< margin holds results of this line
    bool supervise_due;    ///< in this row
    bool watched;          ///< the car's own sensors say more of the model: watch holds it
    uint32_t sequence;     ///< of the last line taken
    uint32_t seen_mask;    ///< channels that have ever come
    uint32_t missing_mask; ///< of those, missing in a row since the last estimate
    uint32_t singular;
    uint32_t overrun;
    int32_t speed_mm_s;
    int64_t time_us;       ///< of the newest row that is being worked on
    int64_t speed_time_us; ///< of the newest valid speed
    int64_t input_us;      ///< of the newest sample
    sway_core_config_t config;
    sway_judge_t judge;
    sway_status_t status;
    sway_margin_t margin;
#if SWAY_TRAILER
    sway_trailer_watch_t watch;
#endif
#if SWAY_SUPERVISION
    sway_supervise_t supervise;
#endif
#if SWAY_SWING
    sway_swing_t swing;
#endif
    sway_grid_t grid;
    sway_track_t track;
    sway_core_work_t work;
} sway_core_t;

/// A configuration with every field at its default and no vehicle (which init will refuse).
void sway_core_defaults(sway_core_config_t *config);

/// Resets everything, fault counters included. SWAY_ERROR_ARGUMENT for a null pointer, a sample
/// period, window, delay, threshold or set of assumed values out of range; SWAY_ERROR_VEHICLE for a
/// vehicle that sway_vehicle_check() refuses. On error `core` is not usable.
sway_error_t sway_core_init(sway_core_t *core, const sway_core_config_t *config);

/// One sample of one input in the unit of sway_input_t. SWAY_ERROR_RANGE and SWAY_ERROR_TIME are
/// counted and the sample is dropped; everything else goes on unharmed. Short, about 1,000
/// instructions, if sway_core_run() has been called until false since the last sample of another
/// time; if not, what is due is done first, with the same results.
sway_error_t sway_core_input(sway_core_t *core, sway_input_t input, int64_t time_us, int32_t value);

/// The sender says that it has no valid value now. Counted; the grid marks a gap there.
void sway_core_invalid(sway_core_t *core, sway_input_t input, int64_t time_us);

/// One slice of the work that is due, of at most SWAY_SLICE_COST; false: nothing was due. Every row
/// of the grid makes up to SWAY_SLICES_PER_ROW slices due, and they are done before anything newer
/// is looked at: results depend on the samples and their timestamps only, never on when this is
/// called. Slices are nearly equal in cost while an estimate is being made, and none is longer.
bool sway_core_run(sway_core_t *core);

/// The newest status; valid for the life of the core, changes only inside sway_core_run() (and the
/// fault counters inside sway_core_input()). Whole whenever sway_core_run() has returned false.
const sway_status_t *sway_core_status(const sway_core_t *core);

#if SWAY_TRAILER
/// What the car's own sensors tell of the trailer, for its report and its memory.
const sway_trailer_watch_t *sway_core_trailer(const sway_core_t *core);
#endif

SWAY_C_END

#endif

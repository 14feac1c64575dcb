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
#ifndef SWAY_CORE_H
#define SWAY_CORE_H

#include "sway_alarm.h"
#include "sway_status.h"
#include "sway_types.h"
#include "sway_vehicle.h"

typedef struct {
    sway_vehicle_t vehicle;
    int32_t sample_period_us;                 ///< of the grid: 10000 (5000 .. 20000)
    int32_t input_delay_us[SWAY_INPUT_COUNT]; ///< known delay of each input: timestamps of its
                                              ///< samples are that much too late, 0 .. 500000
    sway_alarm_config_t alarm;
} sway_core_config_t;

typedef struct {
    sway_core_config_t config;
    sway_status_t status;
} sway_core_t;

/// A configuration with every field at its default and no vehicle (which init will refuse).
void sway_core_defaults(sway_core_config_t *config);

/// Resets everything, fault counters included. SWAY_ERROR_ARGUMENT for a null pointer, a sample
/// period or a delay out of range; SWAY_ERROR_VEHICLE for a vehicle that sway_vehicle_check()
/// refuses. On error `core` is not usable.
sway_error_t sway_core_init(sway_core_t *core, const sway_core_config_t *config);

/// One sample of one input in the unit of sway_input_t. SWAY_ERROR_RANGE and SWAY_ERROR_TIME are
/// counted and the sample is dropped; everything else goes on unharmed. Constant time.
sway_error_t sway_core_input(sway_core_t *core, sway_input_t input, int64_t time_us, int32_t value);

/// The sender says that it has no valid value now. Counted; the grid marks a gap there.
void sway_core_invalid(sway_core_t *core, sway_input_t input, int64_t time_us);

/// One bounded slice of the work that is due (at most about 90,000 instructions on a Cortex-M0+).
/// True: more is due. What becomes due depends on the timestamps of the samples only, so results
/// do not depend on when or how often this is called, as long as it is called until it returns
/// false after every sample or every few samples.
bool sway_core_run(sway_core_t *core);

/// The newest status; valid for the life of the core, changes only inside sway_core_run() (and the
/// fault counters inside sway_core_input()).
const sway_status_t *sway_core_status(const sway_core_t *core);

#endif

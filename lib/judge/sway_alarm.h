// SPDX-License-Identifier: MIT
/// sway_alarm: from margin and growth to one of five states, with hysteresis and reasons.
///
/// A state is entered at once and left downwards only when nothing has asked for it for `hold_ms`.
/// Growth seen in the signals alone, against or without a model, must last one oscillation before
/// it warns: a gust that builds up an oscillation looks like growth for as long. A speed above the
/// critical one warns beyond 1.5 standard errors; at once beyond `confidence_milli` of them where
/// the swing has reached the limit amplitude, however it came there.
#ifndef SWAY_ALARM_H
#define SWAY_ALARM_H

#include "judge/sway_evidence.h"
#include "sway_status.h"

/// Thresholds; sway_alarm_defaults() gives the ones that the warning campaign was run with.
typedef struct {
    int32_t notice_margin_mm_s;       ///< v_crit - v below this: notice
    int32_t margin_hysteresis_mm_s;   ///< and back above this much more
    int32_t notice_damping_ratio_ppm; ///< free oscillation damped less than this: notice
    int32_t damping_hysteresis_ppm;
    int32_t minimum_amplitude_urad_s; ///< trailer yaw rate below which nothing alarms by growth
    int32_t large_amplitude_urad_s;   ///< growing above this: critical
    int32_t limit_amplitude_urad_s;   ///< what time_to_limit counts down to
    int32_t critical_time_ms;         ///< time to limit below this while growing: critical
    int32_t hold_ms;                  ///< a state is left downwards only after this time
    int32_t minimum_speed_mm_s;       ///< off below (30 km/h: 8333)
    int32_t confidence_milli; ///< standard errors, x 1000, by which damping must be negative
} sway_alarm_config_t;

/// What one estimate says.
typedef struct {
    int64_t time_us;
    int32_t speed_mm_s;      ///< newest; -1: not known
    bool has_critical_speed; ///< an oscillatory or static limit was found
    bool is_below_range;     ///< instead: by the model it is unstable at any speed
    bool is_static;          ///< that limit is static
    bool is_identified;      ///< from identified stiffnesses
    int32_t v_crit_mm_s;
    int32_t v_crit_se_mm_s;
    sway_evidence_t model;   ///< damping ratio of the model at this speed
    sway_evidence_t damping; ///< combined
    sway_belief_t belief;
    bool has_swing; ///< `amplitude_rad_s` is meaningful: there is a line, free or forced
    sway_real_t amplitude_rad_s; ///< trailer yaw rate at `mid_time_us`
    bool has_oscillation;        ///< its growth is evidence, and the fields below are meaningful
    sway_real_t growth_1_s;
    sway_real_t growth_se_1_s;
    sway_real_t omega_rad_s;
    int64_t mid_time_us;
} sway_alarm_input_t;

typedef struct {
    sway_alarm_config_t config;
    sway_alarm_state_t state;
    uint32_t reasons;
    int32_t time_to_limit_ms; ///< -1: not growing
    int64_t asked_us;         ///< when the present state was last asked for
    int64_t last_us;
    int64_t growing_us; ///< how long the signals have been growing without a break
} sway_alarm_t;

void sway_alarm_defaults(sway_alarm_config_t *config);

/// SWAY_ERROR_ARGUMENT for a threshold that is negative.
sway_error_t sway_alarm_init(sway_alarm_t *alarm, const sway_alarm_config_t *config);

/// The clock has started again at `time_us`: the state is held from now on, growth begins anew.
void sway_alarm_restart(sway_alarm_t *alarm, int64_t time_us);

/// Takes one estimate; state, reasons and time_to_limit_ms are the result.
void sway_alarm_update(sway_alarm_t *alarm, const sway_alarm_input_t *input);

#endif

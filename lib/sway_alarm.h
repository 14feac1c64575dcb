/// sway_alarm: from margin and growth to one of five states, with hysteresis and reasons.
#ifndef SWAY_ALARM_H
#define SWAY_ALARM_H

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
} sway_alarm_config_t;

void sway_alarm_defaults(sway_alarm_config_t *config);

#endif

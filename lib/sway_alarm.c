#include "sway_alarm.h"

void sway_alarm_defaults(sway_alarm_config_t *config)
{
    config->notice_margin_mm_s = 2778;
    config->margin_hysteresis_mm_s = 556;
    config->notice_damping_ratio_ppm = 50000;
    config->damping_hysteresis_ppm = 15000;
    config->minimum_amplitude_urad_s = 17453;
    config->large_amplitude_urad_s = 139626;
    config->limit_amplitude_urad_s = 261799;
    config->critical_time_ms = 3000;
    config->hold_ms = 2000;
    config->minimum_speed_mm_s = 8333;
}

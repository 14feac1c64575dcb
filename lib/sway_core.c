#include "sway_core.h"

#include <string.h>

void sway_core_defaults(sway_core_config_t *config)
{
    memset(config, 0, sizeof *config);
    config->sample_period_us = 10000;
    sway_alarm_defaults(&config->alarm);
}

static bool config_is_in_range(const sway_core_config_t *config)
{
    bool good = config->sample_period_us >= 5000 && config->sample_period_us <= 20000;
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        good = good && config->input_delay_us[i] >= 0 && config->input_delay_us[i] <= 500000;
    }
    return good;
}

sway_error_t sway_core_init(sway_core_t *core, const sway_core_config_t *config)
{
    if (core == NULL || config == NULL || !config_is_in_range(config)) {
        return SWAY_ERROR_ARGUMENT;
    }
    const sway_error_t error = sway_vehicle_check(&config->vehicle, NULL);
    if (error != SWAY_OK) {
        return error;
    }
    memset(core, 0, sizeof *core);
    core->config = *config;
    return SWAY_OK;
}

sway_error_t sway_core_input(sway_core_t *core, sway_input_t input, int64_t time_us, int32_t value)
{
    (void)value;
    (void)time_us;
    if (core == NULL || (unsigned)input >= (unsigned)SWAY_INPUT_COUNT) {
        return SWAY_ERROR_ARGUMENT;
    }
    return SWAY_OK;
}

void sway_core_invalid(sway_core_t *core, sway_input_t input, int64_t time_us)
{
    (void)input;
    (void)time_us;
    core->status.fault_count[SWAY_FAULT_INVALID]++;
}

bool sway_core_run(sway_core_t *core)
{
    (void)core;
    return false;
}

const sway_status_t *sway_core_status(const sway_core_t *core)
{
    return &core->status;
}

// SPDX-License-Identifier: MIT
#include "judge/sway_alarm.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

void sway_alarm_defaults(sway_alarm_config_t *config)
{
    config->notice_margin_mm_s = 2778;
    config->margin_hysteresis_mm_s = 556;
    config->notice_damping_ratio_ppm = 50000;
    config->damping_hysteresis_ppm = 15000;
    config->minimum_amplitude_urad_s = 43633;
    config->large_amplitude_urad_s = 139626;
    config->limit_amplitude_urad_s = 261799;
    config->critical_time_ms = 3000;
    config->hold_ms = 2000;
    config->minimum_speed_mm_s = 8333;
    config->confidence_milli = 750;
}

sway_error_t sway_alarm_init(sway_alarm_t *alarm, const sway_alarm_config_t *config)
{
    const int32_t all[] = {
        config->notice_margin_mm_s,
        config->margin_hysteresis_mm_s,
        config->notice_damping_ratio_ppm,
        config->damping_hysteresis_ppm,
        config->minimum_amplitude_urad_s,
        config->large_amplitude_urad_s,
        config->limit_amplitude_urad_s,
        config->critical_time_ms,
        config->hold_ms,
        config->minimum_speed_mm_s,
        config->confidence_milli,
    };
    for (unsigned i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (all[i] < 0) {
            return SWAY_ERROR_ARGUMENT;
        }
    }
    memset(alarm, 0, sizeof *alarm);
    alarm->config = *config;
    alarm->time_to_limit_ms = -1;
    return SWAY_OK;
}

/* Estimates farther apart than this do not follow each other: they come every window/16. */
#define PAUSE_US 1000000

/* What the model leaves out (roll, air, saturation) in the damping ratio, at the least. */
#define MODEL_FLOOR_PPM 5000

/* Standard errors by which a speed has to be above the critical one to warn. */
#define SURE_MILLI 1500

static sway_real_t micro(int32_t value)
{
    return sway_real_micro(value);
}

static bool sees_signal(const sway_alarm_input_t *input)
{
    return input->has_oscillation &&
           (input->belief == SWAY_BELIEF_SIGNAL || input->belief == SWAY_BELIEF_BOTH);
}

/* Amplitude carried on from mid-window to now. */
static sway_real_t amplitude_now(const sway_alarm_input_t *input)
{
    const sway_real_t age = sway_real_micro(input->time_us - input->mid_time_us);
    return MUL(input->amplitude_rad_s, sway_real_exp(MUL(input->growth_1_s, age)));
}

static int32_t time_to_limit(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    if (!input->has_oscillation || sway_real_sign(input->growth_1_s) <= 0) {
        return -1;
    }
    const sway_real_t ratio =
        sway_real_div(micro(alarm->config.limit_amplitude_urad_s), amplitude_now(input));
    const sway_real_t seconds = sway_real_div(sway_real_ln(ratio), input->growth_1_s);
    return sway_real_to_int(seconds, 1000, 0, 3600000);
}

/* How long the free oscillation has been growing, beyond one standard error, without a break. */
static void follow_growth(sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    /* What happened in a pause nobody knows. */
    const int64_t since = alarm->last_us == 0 ? 0 : input->time_us - alarm->last_us;
    const bool follows = since >= 0 && since <= PAUSE_US;
    const bool grows = sees_signal(input) &&
                       sway_real_less(input->growth_se_1_s, input->growth_1_s) &&
                       sway_real_compare(input->amplitude_rad_s,
                                         micro(alarm->config.minimum_amplitude_urad_s)) >= 0;
    alarm->last_us = input->time_us;
    alarm->growing_us = grows && follows ? alarm->growing_us + since : 0;
}

/* One oscillation in microseconds. */
static int64_t period_us(const sway_alarm_input_t *input)
{
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    return sway_real_to_int(sway_real_div(turn, input->omega_rad_s), 1000000, 0, INT32_MAX);
}

static bool is_growing(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    if (alarm->growing_us <= 0) {
        return false;
    }
    const sway_real_t sure = sway_real_ratio(alarm->config.confidence_milli, 1000);
    const sway_real_t bound = sway_real_add(input->damping.ratio, MUL(sure, input->damping.se));
    if (sway_real_sign(bound) >= 0) {
        return false;
    }
    return input->belief == SWAY_BELIEF_BOTH || alarm->growing_us >= period_us(input);
}

/* Without a critical speed: what the model says of the damping here. */
static bool is_undamped(const sway_alarm_input_t *input, int32_t sure_milli)
{
    const sway_real_t se = ADD(input->model.se, micro(MODEL_FLOOR_PPM));
    const sway_real_t bound = ADD(input->model.ratio, MUL(sway_real_ratio(sure_milli, 1000), se));
    return input->model.usable && sway_real_sign(bound) < 0;
}

/* What a user's stiffness alone says does not warn. */
static bool is_above_critical(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    const sway_real_t limit = micro(alarm->config.limit_amplitude_urad_s);
    const bool at_limit = input->has_swing && sway_real_compare(input->amplitude_rad_s, limit) >= 0;
    const int32_t sure_milli = at_limit ? alarm->config.confidence_milli : SURE_MILLI;
    const int64_t excess_mm_s = (int64_t)input->speed_mm_s - input->v_crit_mm_s;
    if (!input->is_identified || input->is_below_range) {
        return input->is_identified && is_undamped(input, sure_milli);
    }
    return excess_mm_s * 1000 > (int64_t)sure_milli * input->v_crit_se_mm_s;
}

static uint32_t speed_reasons(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    const sway_alarm_config_t *const config = &alarm->config;
    const bool noticed = (alarm->reasons & SWAY_REASON_SMALL_MARGIN) != 0U;
    const int64_t margin = (int64_t)input->v_crit_mm_s - input->speed_mm_s;
    const int64_t least =
        (int64_t)config->notice_margin_mm_s + (noticed ? config->margin_hysteresis_mm_s : 0);
    uint32_t reasons = 0;
    if (!input->has_critical_speed && !input->is_below_range) {
        return 0;
    }
    if (margin < least) {
        reasons |= SWAY_REASON_SMALL_MARGIN;
    }
    if (is_above_critical(alarm, input)) {
        reasons |= SWAY_REASON_ABOVE_CRITICAL_SPEED;
        if (input->is_static) {
            reasons |= SWAY_REASON_STATIC;
        }
    }
    return reasons;
}

static uint32_t signal_reasons(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    const sway_alarm_config_t *const config = &alarm->config;
    const bool noticed = (alarm->reasons & SWAY_REASON_LOW_DAMPING) != 0U;
    const int64_t limit_ppm =
        (int64_t)config->notice_damping_ratio_ppm + (noticed ? config->damping_hysteresis_ppm : 0);
    uint32_t reasons = 0;
    if (!sees_signal(input)) {
        return 0;
    }
    const bool visible =
        sway_real_compare(input->amplitude_rad_s, micro(config->minimum_amplitude_urad_s)) >= 0;
    if (visible && sway_real_less(input->damping.ratio, sway_real_micro(limit_ppm))) {
        reasons |= SWAY_REASON_LOW_DAMPING;
    }
    if (!is_growing(alarm, input)) {
        return reasons;
    }
    reasons |= SWAY_REASON_GROWING;
    if (sway_real_less(micro(config->large_amplitude_urad_s), amplitude_now(input))) {
        reasons |= SWAY_REASON_LARGE_AMPLITUDE;
    }
    if (alarm->time_to_limit_ms < config->critical_time_ms) { // it is known where it grows
        reasons |= SWAY_REASON_SHORT_TIME;
    }
    return reasons;
}

static sway_alarm_state_t state_for(uint32_t reasons)
{
    if ((reasons & (SWAY_REASON_LARGE_AMPLITUDE | SWAY_REASON_SHORT_TIME)) != 0U) {
        return SWAY_ALARM_CRITICAL;
    }
    if ((reasons & (SWAY_REASON_GROWING | SWAY_REASON_ABOVE_CRITICAL_SPEED)) != 0U) {
        return SWAY_ALARM_WARNING;
    }
    if ((reasons & (SWAY_REASON_SMALL_MARGIN | SWAY_REASON_LOW_DAMPING)) != 0U) {
        return SWAY_ALARM_NOTICE;
    }
    return SWAY_ALARM_NORMAL;
}

static bool is_off(const sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    return input->speed_mm_s < alarm->config.minimum_speed_mm_s ||
           input->belief == SWAY_BELIEF_NONE;
}

void sway_alarm_restart(sway_alarm_t *alarm, int64_t time_us)
{
    alarm->asked_us = time_us;
    alarm->last_us = time_us;
    alarm->growing_us = 0;
}

void sway_alarm_update(sway_alarm_t *alarm, const sway_alarm_input_t *input)
{
    follow_growth(alarm, input);
    alarm->time_to_limit_ms = time_to_limit(alarm, input);
    uint32_t reasons = 0;
    sway_alarm_state_t asked = SWAY_ALARM_OFF;
    if (!is_off(alarm, input)) {
        reasons = speed_reasons(alarm, input) | signal_reasons(alarm, input);
        asked = state_for(reasons);
    }
    const int64_t hold_us = (int64_t)alarm->config.hold_ms * 1000;
    if (asked >= alarm->state || input->time_us - alarm->asked_us >= hold_us) {
        alarm->state = asked;
        alarm->asked_us = input->time_us;
        alarm->reasons = reasons;
    } else {
        alarm->reasons |= reasons; // the state that is held, and what came since
    }
}

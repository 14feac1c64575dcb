#include "sway_core.h"

#include <string.h>

#include "sway_publish.h"

/* A speed older than this is not known any more. */
#define SPEED_OLD_US 1000000

/* What is being done with the newest line. */
enum { STAGE_IDLE, STAGE_IDENTIFY, STAGE_MODEL, STAGE_PUBLISH };

void sway_core_defaults(sway_core_config_t *config)
{
    memset(config, 0, sizeof *config);
    config->sample_period_us = 10000;
    config->window_cycles_milli = 1700;
    config->input_period_us = 10000;
    sway_alarm_defaults(&config->alarm);
}

static sway_error_t init_parts(sway_core_t *core, const sway_core_config_t *config)
{
    sway_grid_config_t grid = sway_grid_default(config->sample_period_us);
    sway_track_config_t track = sway_track_default(config->sample_period_us);
    for (int i = 0; i < (int)SWAY_INPUT_COUNT; i++) {
        grid.delay_us[i] = config->input_delay_us[i];
    }
    grid.max_wait_us = config->sample_period_us * 10;
    grid.input_period_us = config->input_period_us;
    track.window_cycles_milli = config->window_cycles_milli;
    if (sway_grid_init(&core->grid, &grid) != SWAY_OK ||
        sway_track_init(&core->track, &track) != SWAY_OK) {
        return SWAY_ERROR_ARGUMENT;
    }
    sway_margin_init(&core->margin, &config->vehicle);
    return sway_alarm_init(&core->alarm, &config->alarm);
}

sway_error_t sway_core_init(sway_core_t *core, const sway_core_config_t *config)
{
    if (core == NULL || config == NULL || config->sample_period_us < 5000 ||
        config->sample_period_us > 20000) {
        return SWAY_ERROR_ARGUMENT;
    }
    const sway_error_t error = sway_vehicle_check(&config->vehicle, NULL);
    if (error != SWAY_OK) {
        return error;
    }
    memset(core, 0, sizeof *core);
    core->config = *config;
    core->speed_mm_s = -1;
    core->status.time_to_limit_ms = -1;
    return init_parts(core, config);
}

/* --- samples ---------------------------------------------------------------------------------- */

static void copy_faults(sway_core_t *core)
{
    uint32_t *const fault = core->status.fault_count;
    fault[SWAY_FAULT_RANGE] = core->grid.faults.out_of_range;
    fault[SWAY_FAULT_TIME] = core->grid.faults.time_backward;
    fault[SWAY_FAULT_INVALID] = core->grid.faults.invalid;
    fault[SWAY_FAULT_GAP] = core->grid.faults.gaps;
    fault[SWAY_FAULT_SINGULAR] = core->singular;
    fault[SWAY_FAULT_OVERRUN] = core->overrun;
    fault[SWAY_FAULT_RATE] = core->grid.faults.off_rate;
}

/* Rows are taken from the grid as soon as they are ready: what they hold must not depend on when
 * their slices run. */
static void take_rows(sway_core_t *core)
{
    sway_tick_t tick;
    while (sway_grid_tick(&core->grid, &tick)) {
        while (core->rows == SWAY_CORE_ROWS) {
            (void)sway_core_run(core);
        }
        core->row[(core->first + core->rows) % SWAY_CORE_ROWS] = tick;
        core->rows++;
    }
    copy_faults(core);
}

sway_error_t sway_core_input(sway_core_t *core, sway_input_t input, int64_t time_us, int32_t value)
{
    if (core == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    const sway_error_t error = sway_grid_input(&core->grid, input, time_us, value);
    take_rows(core);
    return error;
}

void sway_core_invalid(sway_core_t *core, sway_input_t input, int64_t time_us)
{
    if (core != NULL) {
        sway_grid_invalid(&core->grid, input, time_us);
        take_rows(core);
    }
}

/* --- one line to one status ------------------------------------------------------------------- */

static int32_t speed_now(const sway_core_t *core)
{
    return core->time_us - core->speed_time_us > SPEED_OLD_US ? -1 : core->speed_mm_s;
}

static void count(uint32_t *counter)
{
    *counter += *counter < UINT32_MAX ? 1U : 0U;
}

static void begin_model(sway_core_t *core)
{
    const int32_t speed = speed_now(core);
    const sway_identify_t *const identify = core->identified ? &core->identify : NULL;
    core->modelled = false;
    core->stage = STAGE_PUBLISH;
    if (speed < 0) {
        return;
    }
    const sway_real_t speed_m_s = sway_real_ratio(speed, 1000);
    if (sway_margin_start(&core->margin, identify, core->line.mid_time_us, speed_m_s) == SWAY_OK) {
        core->modelled = true;
        core->stage = STAGE_MODEL;
    }
}

static void begin_line(sway_core_t *core)
{
    const uint32_t sequence = sway_track_sequence(&core->track);
    if (sequence == core->sequence) {
        return;
    }
    if (sequence - core->sequence > 1U) {
        count(&core->overrun);
    }
    core->sequence = sequence;
    core->line = *sway_track_line(&core->track);
    core->identified =
        sway_identify_start(&core->identify, &core->config.vehicle, &core->line) == SWAY_OK;
    if (core->identified) {
        core->stage = STAGE_IDENTIFY;
    } else {
        begin_model(core);
    }
}

static bool line_is_usable(const sway_core_t *core)
{
    const uint32_t bad = SWAY_QUALITY_NO_OSCILLATION | SWAY_QUALITY_SEEKING;
    return (core->identify.quality & bad) == 0U;
}

static sway_channel_t yaw_channel(const sway_core_t *core)
{
    return core->config.vehicle.trailer.axles == 0 ? SWAY_CHANNEL_CAR_YAW_RATE
                                                   : SWAY_CHANNEL_TRAILER_YAW_RATE;
}

static bool has_inputs(const sway_core_t *core)
{
    return (core->line.valid_mask & SWAY_CHANNEL_BIT(yaw_channel(core))) != 0U;
}

static sway_real_t amplitude(const sway_core_t *core)
{
    return sway_complex_abs(core->line.channel[yaw_channel(core)].amplitude);
}

/* Yaw rate that the wheel's movement at the line would cause if it were slow. */
static sway_real_t steered(const sway_core_t *core)
{
    const uint32_t bit = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    const sway_margin_model_t *const model = &core->margin.model;
    if ((core->line.valid_mask & bit) == 0U || !model->has_steady) {
        return sway_real_int(0);
    }
    const sway_complex_t wheel = core->line.channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude;
    const sway_real_t ratio = sway_real_ratio(1000, core->config.vehicle.car.steering_ratio_milli);
    const sway_real_t gain = sway_real_abs(model->steady.yaw_rate_gain_1_s);
    return sway_real_mul(sway_real_mul(sway_complex_abs(wheel), ratio), gain);
}

/* Damping ratio that the free oscillation shows. */
static sway_margin_damping_t signal_damping(const sway_core_t *core)
{
    const uint32_t bad = SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP;
    sway_margin_damping_t damping;
    sway_line_damping(&core->line, &damping.ratio, &damping.se);
    damping.se = sway_margin_signal_se(&core->unrest, damping.se, amplitude(core), steered(core));
    damping.usable =
        line_is_usable(core) && (core->identify.quality & bad) == 0U && has_inputs(core);
    return damping;
}

static sway_margin_damping_t model_damping(const sway_core_t *core)
{
    const sway_margin_model_t *const model = &core->margin.model;
    const sway_margin_damping_t damping = {model->damping_ratio, model->damping_ratio_se,
                                           core->modelled && model->has_model};
    return damping;
}

static uint32_t quality_of(const sway_core_t *core, bool disagrees)
{
    uint32_t quality = core->identify.quality;
    if (speed_now(core) < 0) {
        quality |= SWAY_QUALITY_NO_SPEED;
    } else if (speed_now(core) < core->config.alarm.minimum_speed_mm_s) {
        quality |= SWAY_QUALITY_SLOW;
    }
    if (line_is_usable(core) && !has_inputs(core)) {
        quality |= SWAY_QUALITY_MISSING_INPUT;
    }
    if (core->modelled && core->margin.model.kind == SWAY_VCRIT_SINGULAR) {
        quality |= SWAY_QUALITY_SINGULAR;
    }
    return quality | (disagrees ? (uint32_t)SWAY_QUALITY_MODEL_DISAGREES : 0U);
}

static void raise_alarm(sway_core_t *core, const sway_publish_t *from)
{
    const sway_margin_model_t *const model = &core->margin.model;
    const sway_line_t *const line = &core->line;
    sway_alarm_input_t input;
    memset(&input, 0, sizeof input);
    input.time_us = from->time_us;
    input.speed_mm_s = from->speed_mm_s;
    input.has_critical_speed = core->modelled && (model->kind == SWAY_VCRIT_FOUND ||
                                                  model->kind == SWAY_VCRIT_BELOW_RANGE ||
                                                  model->kind == SWAY_VCRIT_DIVERGENCE);
    input.is_static = model->kind == SWAY_VCRIT_DIVERGENCE;
    input.is_identified = model->source == SWAY_SOURCE_IDENTIFIED;
    input.v_crit_mm_s = core->status.v_crit_mm_s;
    input.v_crit_se_mm_s = core->status.v_crit_se_mm_s;
    input.damping = from->combined;
    input.belief = from->belief;
    input.has_oscillation = from->signal.usable;
    if (from->signal.usable) {
        input.growth_1_s = line->growth_1_s;
        input.growth_se_1_s = line->growth_se_1_s;
        input.omega_rad_s = line->omega_rad_s;
        input.amplitude_rad_s = amplitude(core);
        input.mid_time_us = line->mid_time_us;
    }
    sway_alarm_update(&core->alarm, &input);
    core->status.alarm = (int32_t)core->alarm.state;
    core->status.reasons = core->alarm.reasons;
    core->status.time_to_limit_ms = core->alarm.time_to_limit_ms;
    core->status.valid |= core->alarm.time_to_limit_ms >= 0 ? SWAY_VALID_TIME_TO_LIMIT : 0U;
}

/* Every free swing teaches how disturbed it is, also one that is not a single damped line. */
static void learn(sway_core_t *core, const sway_margin_damping_t *combined)
{
    const uint32_t bad = SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP;
    sway_real_t ratio;
    sway_real_t se;
    if (line_is_usable(core) && (core->identify.quality & bad) == 0U && has_inputs(core) &&
        combined->usable) {
        sway_line_damping(&core->line, &ratio, &se);
        sway_margin_learn_unrest(&core->unrest, core->time_us,
                                 sway_real_sub(ratio, combined->ratio), amplitude(core),
                                 steered(core));
    }
}

static void publish(sway_core_t *core)
{
    bool disagrees;
    sway_publish_t from;
    memset(&from, 0, sizeof from);
    const sway_margin_damping_t model = model_damping(core);
    from.line = line_is_usable(core) ? &core->line : NULL;
    from.identify = core->identified ? &core->identify : NULL;
    from.model = core->modelled ? &core->margin.model : NULL;
    from.time_us = core->time_us;
    from.speed_mm_s = speed_now(core);
    from.is_solo = core->config.vehicle.trailer.axles == 0;
    from.signal = signal_damping(core);
    from.belief = sway_margin_combine(&model, &from.signal, &from.combined, &disagrees);
    from.quality = quality_of(core, disagrees);
    learn(core, &from.combined);
    if ((from.quality & SWAY_QUALITY_SINGULAR) != 0U) {
        count(&core->singular);
    }
    core->status.window_ms = core->line.window_samples * (core->config.sample_period_us / 100) / 10;
    sway_publish(&core->status, &from);
    raise_alarm(core, &from);
    copy_faults(core);
    core->status.sequence++;
}

static void margin_slice(sway_core_t *core)
{
    switch (core->stage) {
    case STAGE_IDENTIFY:
        if (!sway_identify_run(&core->identify)) {
            begin_model(core);
        }
        break;
    case STAGE_MODEL:
        if (!sway_margin_run(&core->margin)) {
            core->stage = STAGE_PUBLISH;
        }
        break;
    case STAGE_PUBLISH:
        publish(core);
        core->stage = STAGE_IDLE;
        break;
    default:
        begin_line(core);
        break;
    }
}

/* --- slices ----------------------------------------------------------------------------------- */

static void begin_row(sway_core_t *core)
{
    const sway_tick_t *const tick = &core->row[core->first];
    sway_track_push(&core->track, tick);
    core->time_us = tick->time_us;
    if ((tick->valid_mask & SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)) != 0U) {
        core->speed_mm_s = tick->value[SWAY_CHANNEL_SPEED];
        core->speed_time_us = tick->time_us;
    }
    core->first = (core->first + 1U) % SWAY_CORE_ROWS;
    core->rows--;
    core->slices_due = SWAY_CORE_LINE_SLICES + SWAY_CORE_MARGIN_SLICES;
}

bool sway_core_run(sway_core_t *core)
{
    if (core->slices_due > 0U) {
        core->slices_due--;
        if (core->slices_due >= SWAY_CORE_MARGIN_SLICES) {
            (void)sway_track_run(&core->track);
        } else {
            margin_slice(core);
        }
    } else if (core->rows > 0U) {
        begin_row(core);
    }
    return core->slices_due > 0U || core->rows > 0U;
}

const sway_status_t *sway_core_status(const sway_core_t *core)
{
    return &core->status;
}

// SPDX-License-Identifier: MIT
#include "sway_core.h"

#include <string.h>

#include "core/sway_publish.h"

/* A speed older than this is not known any more. */
#define SPEED_OLD_US 1000000

/* What is being done with the newest line. */
enum { STAGE_IDLE, STAGE_IDENTIFY, STAGE_BEGIN_MODEL, STAGE_MODEL, STAGE_WATCH, STAGE_PUBLISH };

/* Costs of the core's own slices: see SWAY_SLICE_COST. */
enum { COST_ROW = 12, COST_BEGIN_MODEL = 32, COST_PART = 15, COST_PUBLISH = 40 };

/* --- the trailer from the car's own sensors ----------------------------------------------------
 */

#if SWAY_TRAILER
static void watch_init(sway_core_t *core)
{
    sway_trailer_init(&core->watch, &core->config.vehicle, (uint32_t)core->config.trailer_assumed,
                      core->config.sample_period_us);
}

static bool watch_begin(sway_core_t *core, sway_real_t speed_m_s)
{
    if (!sway_trailer_speaks(&core->watch)) {
        return false;
    }
    sway_trailer_model_start(&core->watch, speed_m_s);
    return true;
}

static sway_real_t watch_swing(const sway_core_t *core, const sway_line_t *line)
{
    return sway_trailer_speaks(&core->watch)
               ? sway_trailer_swing(&core->watch, line)
               : sway_complex_abs(line->channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude);
}

#define WATCH_PUSH(core, row) sway_trailer_push(&(core)->watch, row)
#define WATCH_COST(core) sway_trailer_cost(&(core)->watch)
#define WATCH_RUN(core) sway_trailer_run(&(core)->watch)
#define WATCH_MODEL_COST(core) sway_trailer_model_cost(&(core)->watch)
#define WATCH_MODEL_RUN(core) sway_trailer_model_run(&(core)->watch)
#define WATCH_MODEL(core) (&(core)->watch.model)
#else
static void watch_init(sway_core_t *core)
{
    (void)core;
}

static bool watch_begin(sway_core_t *core, sway_real_t speed_m_s)
{
    (void)core;
    (void)speed_m_s;
    return false;
}

static sway_real_t watch_swing(const sway_core_t *core, const sway_line_t *line)
{
    (void)core;
    return sway_complex_abs(line->channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude);
}

#define WATCH_PUSH(core, row)
#define WATCH_COST(core) 0U
#define WATCH_RUN(core)
#define WATCH_MODEL_COST(core) 0U
#define WATCH_MODEL_RUN(core) false
#define WATCH_MODEL(core) (&(core)->margin.model)
#endif

/* --- start -------------------------------------------------------------------------------------
 */

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
        const uint32_t place = sway_input_place((sway_input_t)i);
        if (place < SWAY_INPUT_PLACES) {
            grid.delay_us[place] = config->input_delay_us[i];
        }
    }
    const int32_t rows = SWAY_GRID_ROWS - 2 < 10 ? SWAY_GRID_ROWS - 2 : 10;
    grid.max_wait_us = config->sample_period_us * rows;
    grid.input_period_us = config->input_period_us;
    track.window_cycles_milli = config->window_cycles_milli;
    if (sway_grid_init(&core->grid, &grid) != SWAY_OK ||
        sway_track_init(&core->track, &track, &core->work.track) != SWAY_OK) {
        return SWAY_ERROR_ARGUMENT;
    }
    sway_margin_init(&core->margin, &config->vehicle);
    watch_init(core);
    return sway_alarm_init(&core->alarm, &config->alarm);
}

sway_error_t sway_core_init(sway_core_t *core, const sway_core_config_t *config)
{
    if (core == NULL || config == NULL || config->sample_period_us < 5000 ||
        config->sample_period_us > 20000 || config->trailer_assumed < 0 ||
        config->trailer_assumed > SWAY_ASSUMED_ALL) {
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

/* Rows have to be worked on before newer samples come: what they hold must not depend on when
 * their slices run. */
static void catch_up(sway_core_t *core, int64_t time_us)
{
    if (time_us != core->input_us) {
        while (sway_core_run(core)) {
        }
        core->input_us = time_us;
    }
    core->fed = true;
}

sway_error_t sway_core_input(sway_core_t *core, sway_input_t input, int64_t time_us, int32_t value)
{
    if (core == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    catch_up(core, time_us);
    const sway_error_t error = sway_grid_input(&core->grid, input, time_us, value);
    copy_faults(core);
    return error;
}

void sway_core_invalid(sway_core_t *core, sway_input_t input, int64_t time_us)
{
    if (core != NULL) {
        catch_up(core, time_us);
        sway_grid_invalid(&core->grid, input, time_us);
        copy_faults(core);
    }
}

/* --- one line to one status ------------------------------------------------------------------- */

static const sway_line_t *line_of(const sway_core_t *core)
{
    return sway_track_line(&core->track);
}

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
    const sway_identify_t *const identify = core->identified ? &core->work.identify : NULL;
    core->modelled = false;
    core->watched = false;
    core->stage = STAGE_PUBLISH;
    if (speed < 0) {
        return;
    }
    const sway_real_t speed_m_s = sway_real_ratio(speed, 1000);
    if (watch_begin(core, speed_m_s)) {
        core->watched = true;
        core->stage = STAGE_WATCH;
        return;
    }
    if (sway_margin_start(&core->margin, identify, line_of(core)->mid_time_us, speed_m_s) ==
        SWAY_OK) {
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
    core->identified =
        sway_identify_start(&core->work.identify, &core->config.vehicle, line_of(core)) == SWAY_OK;
    core->stage = core->identified ? STAGE_IDENTIFY : STAGE_BEGIN_MODEL;
}

static bool line_is_usable(const sway_core_t *core)
{
    const uint32_t bad = SWAY_QUALITY_NO_OSCILLATION | SWAY_QUALITY_SEEKING;
    return (core->work.identify.quality & bad) == 0U;
}

/* The channel whose amplitude is judged: the trailer's yaw rate where it is measured. */
static sway_channel_t yaw_channel(const sway_core_t *core)
{
    const uint32_t trailer = SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    const bool measured = (line_of(core)->valid_mask & trailer) != 0U;
    return core->config.vehicle.trailer.axles > 0 && measured ? SWAY_CHANNEL_TRAILER_YAW_RATE
                                                              : SWAY_CHANNEL_CAR_YAW_RATE;
}

static bool has_inputs(const sway_core_t *core)
{
    return (line_of(core)->valid_mask & SWAY_CHANNEL_BIT(yaw_channel(core))) != 0U;
}

/* Yaw rate of the trailer at the line, measured or reconstructed from the car's motion. */
static sway_real_t amplitude(const sway_core_t *core)
{
    const sway_channel_t yaw = yaw_channel(core);
    return yaw == SWAY_CHANNEL_TRAILER_YAW_RATE
               ? sway_complex_abs(line_of(core)->channel[yaw].amplitude)
               : watch_swing(core, line_of(core));
}

/* What the line and the motion are judged by. */
static const sway_margin_model_t *model_of(const sway_core_t *core)
{
    return core->watched ? WATCH_MODEL(core) : &core->margin.model;
}

/* Yaw rate that the wheel's movement at the line would cause if it were slow. */
static sway_real_t steered(const sway_core_t *core)
{
    const uint32_t bit = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    const sway_margin_model_t *const model = model_of(core);
    if ((line_of(core)->valid_mask & bit) == 0U || !model->has_steady) {
        return sway_real_zero();
    }
    const sway_complex_t wheel =
        line_of(core)->channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude;
    const sway_real_t ratio = sway_real_ratio(1000, core->config.vehicle.car.steering_ratio_milli);
    const sway_real_t gain = sway_real_abs(model->steady.yaw_rate_gain_1_s);
    return sway_real_mul(sway_real_mul(sway_complex_abs(wheel), ratio), gain);
}

/* Damping ratio that the free oscillation shows. */
static sway_evidence_t signal_damping(const sway_core_t *core)
{
    const uint32_t bad = SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP;
    sway_evidence_t damping;
    sway_line_damping(line_of(core), &damping.ratio, &damping.se);
    damping.se =
        sway_disturbance_se(&core->disturbance, damping.se, amplitude(core), steered(core));
    damping.usable =
        line_is_usable(core) && (core->work.identify.quality & bad) == 0U && has_inputs(core);
    return damping;
}

static sway_evidence_t model_damping(const sway_core_t *core)
{
    const sway_margin_model_t *const model = model_of(core);
    const sway_evidence_t damping = {model->damping_ratio, model->damping_ratio_se,
                                     core->modelled && model->has_model};
    return damping;
}

static uint32_t quality_of(const sway_core_t *core, bool disagrees)
{
    uint32_t quality = core->work.identify.quality;
    if (speed_now(core) < 0) {
        quality |= SWAY_QUALITY_NO_SPEED;
    } else if (speed_now(core) < core->config.alarm.minimum_speed_mm_s) {
        quality |= SWAY_QUALITY_SLOW;
    }
    if (line_is_usable(core) && !has_inputs(core)) {
        quality |= SWAY_QUALITY_MISSING_INPUT;
    }
    if (core->modelled && model_of(core)->kind == SWAY_VCRIT_SINGULAR) {
        quality |= SWAY_QUALITY_SINGULAR;
    }
    return quality | (disagrees ? (uint32_t)SWAY_QUALITY_MODEL_DISAGREES : 0U);
}

static void raise_alarm(sway_core_t *core, const sway_publish_t *from)
{
    const sway_margin_model_t *const model = model_of(core);
    const sway_line_t *const line = line_of(core);
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
    input.has_swing = line_is_usable(core) && has_inputs(core);
    input.has_oscillation = from->signal.usable;
    if (input.has_swing) {
        input.amplitude_rad_s = amplitude(core);
    }
    if (from->signal.usable) {
        input.growth_1_s = line->growth_1_s;
        input.growth_se_1_s = line->growth_se_1_s;
        input.omega_rad_s = line->omega_rad_s;
        input.mid_time_us = line->mid_time_us;
    }
    sway_alarm_update(&core->alarm, &input);
    core->status.alarm = (int32_t)core->alarm.state;
    core->status.reasons = core->alarm.reasons;
    core->status.time_to_limit_ms = core->alarm.time_to_limit_ms;
    core->status.valid |= core->alarm.time_to_limit_ms >= 0 ? SWAY_VALID_TIME_TO_LIMIT : 0U;
}

/* Every free swing teaches how disturbed it is, also one that is not a single damped line. */
static void learn(sway_core_t *core, const sway_evidence_t *combined)
{
    const uint32_t bad = SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP;
    sway_real_t ratio;
    sway_real_t se;
    if (line_is_usable(core) && (core->work.identify.quality & bad) == 0U && has_inputs(core) &&
        combined->usable) {
        sway_line_damping(line_of(core), &ratio, &se);
        sway_disturbance_learn(&core->disturbance, core->time_us,
                               sway_real_sub(ratio, combined->ratio), amplitude(core),
                               steered(core));
    }
}

SWAY_NOINLINE void publish(sway_core_t *core)
{
    bool disagrees;
    sway_publish_t from;
    memset(&from, 0, sizeof from);
    const sway_evidence_t model = model_damping(core);
    from.line = line_is_usable(core) ? line_of(core) : NULL;
    from.identify = core->identified ? &core->work.identify : NULL;
    from.model = core->modelled ? model_of(core) : NULL;
    from.time_us = core->time_us;
    from.speed_mm_s = speed_now(core);
    from.has_swing = line_is_usable(core) && has_inputs(core);
    if (from.has_swing) {
        const sway_line_channel_t *const channel = &line_of(core)->channel[yaw_channel(core)];
        from.swing_rad_s = amplitude(core);
        from.swing_se_rad_s =
            sway_real_mul(channel->amplitude_se,
                          sway_real_div(from.swing_rad_s, sway_complex_abs(channel->amplitude)));
    }
    from.signal = signal_damping(core);
    from.belief = sway_evidence_combine(&model, &from.signal, &from.combined, &disagrees);
    from.quality = quality_of(core, disagrees);
    learn(core, &from.combined);
    if ((from.quality & SWAY_QUALITY_SINGULAR) != 0U) {
        count(&core->singular);
    }
    core->status.window_ms = (int32_t)((uint32_t)line_of(core)->window_samples *
                                       ((uint32_t)core->config.sample_period_us / 100U) / 10U);
    sway_publish(&core->status, &from);
    raise_alarm(core, &from);
    copy_faults(core);
    core->status.sequence++;
}

/* The parts of an estimate come out within one row, so that nobody sees half of them. */
static void publish_part(sway_core_t *core)
{
    if (core->part < SWAY_PUBLISH_PARTS) {
        if (core->identified) {
            sway_publish_part(&core->status, &core->work.identify, core->part);
        }
        core->part++;
    } else {
        publish(core);
        core->part = 0;
        core->stage = STAGE_IDLE;
    }
}

/* --- slices ----------------------------------------------------------------------------------- */

static uint32_t publish_cost(const sway_core_t *core)
{
    if (core->part == 0U && core->slices_due < SWAY_PUBLISH_PARTS) {
        return 0; // not in what is left of this row
    }
    return core->part < SWAY_PUBLISH_PARTS ? (core->identified ? COST_PART : 1U) : COST_PUBLISH;
}

/* What the next slice costs, in SWAY_SLICE_COST's unit; 0: there is nothing to do. */
static uint32_t next_cost(const sway_core_t *core)
{
    if (WATCH_COST(core) != 0U) {
        return WATCH_COST(core);
    }
    switch (core->stage) {
    case STAGE_IDENTIFY:
        return sway_identify_cost(&core->work.identify);
    case STAGE_BEGIN_MODEL:
        return COST_BEGIN_MODEL;
    case STAGE_MODEL:
        return sway_margin_cost(&core->margin);
    case STAGE_WATCH:
        return WATCH_MODEL_COST(core);
    case STAGE_PUBLISH:
        return publish_cost(core);
    default:
        return sway_track_cost(&core->track);
    }
}

static void run_next(sway_core_t *core)
{
    if (WATCH_COST(core) != 0U) {
        WATCH_RUN(core);
        return;
    }
    switch (core->stage) {
    case STAGE_IDENTIFY:
        if (!sway_identify_run(&core->work.identify)) {
            core->stage = STAGE_BEGIN_MODEL;
        }
        break;
    case STAGE_BEGIN_MODEL:
        begin_model(core);
        break;
    case STAGE_MODEL:
        if (!sway_margin_run(&core->margin)) {
            core->stage = STAGE_PUBLISH;
        }
        break;
    case STAGE_WATCH:
        if (!WATCH_MODEL_RUN(core)) {
            core->modelled = true;
            core->stage = STAGE_PUBLISH;
        }
        break;
    case STAGE_PUBLISH:
        publish_part(core);
        break;
    default:
        (void)sway_track_run(&core->track);
        begin_line(core);
        break;
    }
}

static bool begin_row(sway_core_t *core)
{
    sway_row_t tick;
    if (!sway_grid_tick(&core->grid, &tick)) {
        return false;
    }
    sway_track_push(&core->track, &tick);
    WATCH_PUSH(core, &tick);
    core->time_us = tick.time_us;
    if ((tick.valid_mask & SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)) != 0U) {
        core->speed_mm_s = tick.value[SWAY_CHANNEL_SPEED];
        core->speed_time_us = tick.time_us;
    }
    core->slices_due = SWAY_SLICES_PER_ROW;
    return true;
}

bool sway_core_run(sway_core_t *core)
{
    uint32_t spent = 0;
    if (core->slices_due == 0U) {
        if (!core->fed || !begin_row(core)) {
            core->fed = false;
            return false;
        }
        spent = COST_ROW;
    }
    core->slices_due--;
    for (;;) {
        const uint32_t cost = next_cost(core);
        if (cost == 0U) {
            core->slices_due = 0; // the row has no more to do
            break;
        }
        if (spent + cost > SWAY_SLICE_COST) {
            break;
        }
        spent += cost;
        run_next(core);
    }
    return true;
}

const sway_status_t *sway_core_status(const sway_core_t *core)
{
    return &core->status;
}

#if SWAY_TRAILER
const sway_trailer_watch_t *sway_core_trailer(const sway_core_t *core)
{
    return &core->watch;
}
#endif

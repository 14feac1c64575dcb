// SPDX-License-Identifier: MIT
#include "sway_core.h"

#include <string.h>

#include "core/sway_publish.h"

/* A speed older than this is not known any more. */
#define SPEED_OLD_US 1000000
#define SLOWEST_MM_S 8334 // 30 km/h, as sway_margin_start() asks for

/* What is being done with the newest line. */
enum { STAGE_IDLE, STAGE_IDENTIFY, STAGE_BEGIN_MODEL, STAGE_MODEL, STAGE_WATCH, STAGE_PUBLISH };

/* Costs of the core's own slices: see SWAY_SLICE_COST. */
enum { COST_ROW = 12, COST_BEGIN_MODEL = 48, COST_PART = 15, COST_PUBLISH = 40 };

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
    return sway_trailer_speaks(&core->watch) ? sway_trailer_swing(&core->watch, line)
                                             : sway_real_zero();
}

#define WATCH_PUSH(core, row) sway_trailer_push(&(core)->watch, row)
#define WATCH_COST(core) sway_trailer_cost(&(core)->watch)
#define WATCH_RUN(core) sway_trailer_run(&(core)->watch)
#define WATCH_MODEL_COST(core) sway_trailer_model_cost(&(core)->watch)
#define WATCH_MODEL_RUN(core) sway_trailer_model_run(&(core)->watch)
#define WATCH_MODEL(core) (&(core)->watch.model)
#define WATCH_SPEAKS(core) sway_trailer_speaks(&(core)->watch)
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
    (void)line;
    return sway_real_zero();
}

#define WATCH_PUSH(core, row)
#define WATCH_COST(core) 0U
#define WATCH_RUN(core)
#define WATCH_MODEL_COST(core) 0U
#define WATCH_MODEL_RUN(core) false
#define WATCH_MODEL(core) (&(core)->margin.model)
#define WATCH_SPEAKS(core) false
#endif

/* --- supervision of the relations --------------------------------------------------------------
 */

#if SWAY_SUPERVISION
static void supervise_row(sway_core_t *core, sway_row_t *row)
{
    const uint32_t valid = row->valid_mask;
    row->valid_mask = valid & sway_supervise_wanted(&core->supervise);
    sway_supervise_row(&core->supervise, row);
    row->valid_mask = valid & ~core->supervise.rejected_mask;
}

static void supervise_publish(sway_core_t *core)
{
    const sway_supervise_t *const supervise = &core->supervise;
    sway_status_t *const status = &core->status;
    status->suspect_inputs = supervise->suspect_mask | supervise->offset_mask;
    status->rejected_inputs = supervise->rejected_mask;
    status->missing_inputs &= ~supervise->rejected_mask;
    status->finding = supervise->finding.code;
    status->finding_size_micro = supervise->finding.size_micro;
    status->finding_se_micro = supervise->finding.se_micro;
    const uint32_t relation = status->sequence % (uint32_t)SWAY_RELATION_COUNT;
    const sway_relation_state_t state = sway_supervise_relation(
        supervise, (sway_relation_t)relation, &status->relation_ppm, &status->relation_se_ppm);
    status->relation = (int32_t)relation + 256 * (int32_t)state;
}

#define SUPERVISE_INIT(core)                                                                       \
    sway_supervise_init(&(core)->supervise, &(core)->config.vehicle,                               \
                        (core)->config.sample_period_us)
#define SUPERVISE_RUN(core) sway_supervise_run(&(core)->supervise)
#else
#define supervise_row(core, row)
#define supervise_publish(core)
#define SUPERVISE_INIT(core)
#define SUPERVISE_RUN(core) false
#endif

/* --- critical speed over the swing -------------------------------------------------------------
 */

#if SWAY_SWING
/* A swing is of a held line; where nothing was identified, no axle is valid. */
static void swing_take(sway_core_t *core, const sway_judgement_t *judgement)
{
    if (judgement->has_swing && (judgement->quality & SWAY_QUALITY_FORCED) == 0U) {
        sway_swing_take(&core->swing, &core->work.identify, judgement->swing_rad_s);
    }
}

static void swing_lower(sway_status_t *status, const sway_swing_speed_t *speed,
                        int32_t swing_urad_s)
{
    const int32_t v_crit_mm_s = sway_real_to_int(speed->v_crit_m_s, 1000, 0, INT32_MAX);
    if (v_crit_mm_s < status->lowest_v_crit_mm_s) {
        status->lowest_v_crit_mm_s = v_crit_mm_s;
        status->lowest_v_crit_se_mm_s = sway_real_to_int(speed->se_m_s, 1000, 0, INT32_MAX);
        status->lowest_v_crit_swing_urad_s = swing_urad_s;
    }
}

/* The trailer known from the car's own sensors has no forces of axles. */
static void swing_publish(sway_core_t *core, const sway_judgement_t *judgement)
{
    sway_status_t *const status = &core->status;
    const sway_margin_model_t *const model = &core->margin.model;
    const int32_t limit_urad_s = core->config.alarm.limit_amplitude_urad_s;
    sway_swing_speed_t small;
    sway_swing_speed_t limit;
    swing_take(core, judgement);
    if ((status->valid & SWAY_VALID_CRITICAL_SPEED) == 0U || core->watched ||
        !sway_swing_speed(&core->swing, model, sway_real_zero(), &small)) {
        return;
    }
    (void)sway_swing_speed(&core->swing, model, sway_real_micro(limit_urad_s), &limit);
    status->valid |= SWAY_VALID_LOWEST_SPEED;
    status->old &= ~(uint32_t)SWAY_VALID_LOWEST_SPEED;
    status->lowest_v_crit_mm_s = status->v_crit_mm_s;
    status->lowest_v_crit_se_mm_s = status->v_crit_se_mm_s;
    status->lowest_v_crit_swing_urad_s = status->v_crit_swing_urad_s;
    swing_lower(status, &small, 0);
    swing_lower(status, &limit, limit_urad_s);
}

#define SWING_INIT(core) sway_swing_init(&(core)->swing, &(core)->config.vehicle)
#else
#define swing_publish(core, judgement)
#define SWING_INIT(core)
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
    SWING_INIT(core);
    watch_init(core);
    SUPERVISE_INIT(core);
    return sway_judge_init(&core->judge, &config->vehicle, &config->alarm);
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
    /* unknown is below zero: too slow for either */
    const sway_real_t speed_m_s = sway_real_ratio(speed, 1000);
    if (speed >= SLOWEST_MM_S && watch_begin(core, speed_m_s)) {
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

/* The line of this estimate, if one is held. */
static const sway_line_t *held_line(const sway_core_t *core)
{
    const uint32_t bad = SWAY_QUALITY_NO_OSCILLATION | SWAY_QUALITY_SEEKING;
    return (core->work.identify.quality & bad) == 0U ? line_of(core) : NULL;
}

/* What the line and the motion are judged by. */
static const sway_margin_model_t *model_of(const sway_core_t *core)
{
    return core->watched ? WATCH_MODEL(core) : &core->margin.model;
}

SWAY_NOINLINE void publish(sway_core_t *core)
{
    sway_status_t *const status = &core->status;
    const sway_judge_evidence_t evidence = {.time_us = core->time_us,
                                            .speed_mm_s = speed_now(core),
                                            .seen_mask = core->seen_mask,
                                            .missing_mask = core->missing_mask,
                                            .quality = core->work.identify.quality,
                                            .line = line_of(core),
                                            .model = model_of(core),
                                            .modelled = core->modelled,
                                            .has_reconstruction = WATCH_SPEAKS(core),
                                            .reconstructed_rad_s =
                                                watch_swing(core, line_of(core))};
    sway_judgement_t judgement;
    sway_judge_take(&core->judge, &evidence, &judgement);
    const sway_publish_t from = {.line = held_line(core),
                                 .identify = core->identified ? &core->work.identify : NULL,
                                 .model = core->modelled ? model_of(core) : NULL,
                                 .time_us = core->time_us,
                                 .speed_mm_s = evidence.speed_mm_s,
                                 .judgement = &judgement,
                                 .alarm = &core->judge.alarm};
    if ((judgement.quality & SWAY_QUALITY_SINGULAR) != 0U) {
        count(&core->singular);
    }
    status->window_ms = (int32_t)((uint32_t)line_of(core)->window_samples *
                                  ((uint32_t)core->config.sample_period_us / 100U) / 10U);
    sway_publish(status, &from);
    supervise_publish(core);
    swing_publish(core, &judgement);
    copy_faults(core);
    core->missing_mask = 0;
    status->sequence++;
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
        return 0; // not in the remaining channels of this row
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

/* The clock has started again: what is known of the vehicle stays, everything that has a time
 * begins anew. The track empties itself with the row. */
static void restart(sway_core_t *core, int64_t time_us)
{
    core->stage = STAGE_IDLE;
    core->part = 0;
    core->identified = false;
    core->modelled = false;
    core->watched = false;
    core->sequence = sway_track_sequence(&core->track);
    core->speed_time_us = time_us - SPEED_OLD_US - 1;
    sway_judge_restart(&core->judge, time_us);
}

static bool begin_row(sway_core_t *core)
{
    sway_row_t row;
    if (!sway_grid_next_row(&core->grid, &row)) {
        return false;
    }
    if (row.restart) {
        restart(core, row.time_us);
    }
    supervise_row(core, &row);
    sway_track_push(&core->track, &row);
    WATCH_PUSH(core, &row);
    core->time_us = row.time_us;
    core->seen_mask = row.present_mask;
    core->missing_mask |= row.present_mask & ~row.valid_mask;
    if ((row.valid_mask & SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)) != 0U) {
        core->speed_mm_s = row.value[SWAY_CHANNEL_SPEED];
        core->speed_time_us = row.time_us;
    }
    core->slices_due = SWAY_SLICES_PER_ROW;
    core->supervise_due = true;
    return true;
}

bool sway_core_run(sway_core_t *core)
{
    uint32_t spent = 0;
    if (core->slices_due == 0U && core->supervise_due) {
        core->supervise_due = false;
        if (SUPERVISE_RUN(core)) {
            return true;
        }
    }
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

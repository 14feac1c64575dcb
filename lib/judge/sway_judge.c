// SPDX-License-Identifier: MIT
#include "judge/sway_judge.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* Without a held line, a speed that is gone for longer than this has no information any more. With
 * one, the combination still moves: nothing sways that stands. */
#define SPEED_MEMORY_US 10000000

/* A forced line tells of the free one only if the hand explains little of it: a standard error of
 * the damping ratio above this is no evidence. */
#define FORCED_SE_PPM 100000

#define NOT_HELD ((uint32_t)SWAY_QUALITY_NO_OSCILLATION | (uint32_t)SWAY_QUALITY_SEEKING)

/* What can stand in for the yaw rate of the trailer, the best first; and before anything is learnt,
 * how much of it goes with 1 of them, in 1/1000 (median of combinations near their limit: half of
 * them within 6 % of it). */
static const struct {
    sway_channel_t channel;
    int32_t swing_by_milli;
} STANDIN[SWAY_JUDGE_STANDINS] = {
    {SWAY_CHANNEL_CAR_YAW_RATE, 1900},
    {SWAY_CHANNEL_ARTICULATION, 4000},
    {SWAY_CHANNEL_TRAILER_LATERAL_ACC, 51},
    {SWAY_CHANNEL_CAR_LATERAL_ACC, 66},
};

sway_error_t sway_judge_init(sway_judge_t *judge, const sway_vehicle_t *vehicle,
                             const sway_alarm_config_t *alarm)
{
    memset(judge, 0, sizeof *judge);
    judge->is_solo = vehicle->trailer.axles == 0;
    judge->steering_ratio_milli = vehicle->car.steering_ratio_milli;
    judge->last_speed_mm_s = -1;
    for (int i = 0; i < SWAY_JUDGE_STANDINS; i++) {
        judge->swing_by[i] = sway_real_ratio(STANDIN[i].swing_by_milli, 1000);
    }
    return sway_alarm_init(&judge->alarm, alarm);
}

void sway_judge_restart(sway_judge_t *judge, int64_t time_us)
{
    judge->last_speed_us = time_us;
    sway_disturbance_restart(&judge->disturbance, time_us);
    sway_alarm_restart(&judge->alarm, time_us);
}

/* What is seen of the motion. */
typedef struct {
    bool has_swing;
    bool hand_known;
    sway_real_t swing_rad_s;
    sway_real_t swing_se_rad_s;
    sway_real_t steered_rad_s;
} seen_t;

/* --- how large the swing is --------------------------------------------------------------------
 */

static sway_channel_t yaw_channel(const sway_judge_t *judge)
{
    return judge->is_solo ? SWAY_CHANNEL_CAR_YAW_RATE : SWAY_CHANNEL_TRAILER_YAW_RATE;
}

static bool has_channel(const sway_line_t *line, sway_channel_t channel)
{
    return (uint32_t)channel < SWAY_CHANNELS &&
           (line->valid_mask & SWAY_CHANNEL_BIT(channel)) != 0U;
}

static sway_real_t size_of(const sway_line_t *line, sway_channel_t channel)
{
    return sway_complex_abs(line->channel[channel].amplitude);
}

/* A quarter of the way to what is seen now. */
static void learn_standins(sway_judge_t *judge, const sway_line_t *line, sway_real_t swing)
{
    for (uint32_t i = 0; i < SWAY_JUDGE_STANDINS; i++) {
        const sway_channel_t channel = STANDIN[i].channel;
        if (channel != yaw_channel(judge) && has_channel(line, channel)) {
            const sway_real_t size = size_of(line, channel);
            const sway_real_t noise = sway_real_scale(line->channel[channel].amplitude_se, 3);
            if (sway_real_less(noise, size)) { // by 8 standard errors
                const sway_real_t change = SUB(DIV(swing, size), judge->swing_by[i]);
                judge->swing_by[i] = ADD(judge->swing_by[i], sway_real_scale(change, -2));
            }
        }
    }
}

/* A swing that a channel tells, with that channel's relative error. */
static void tell_swing(seen_t *seen, const sway_line_channel_t *channel, sway_real_t swing)
{
    seen->has_swing = true;
    seen->swing_rad_s = swing;
    seen->swing_se_rad_s =
        MUL(swing, DIV(channel->amplitude_se, sway_complex_abs(channel->amplitude)));
}

/* Amplitude of the trailer's yaw rate: measured, reconstructed, or from a motion that stands in. */
static void find_swing(sway_judge_t *judge, const sway_judge_evidence_t *evidence, seen_t *seen)
{
    const sway_line_t *const line = evidence->line;
    const sway_channel_t yaw = yaw_channel(judge);
    if ((evidence->quality & NOT_HELD) != 0U) {
        return;
    }
    if (has_channel(line, yaw)) {
        tell_swing(seen, &line->channel[yaw], size_of(line, yaw));
        learn_standins(judge, line, seen->swing_rad_s);
        return;
    }
    if (evidence->has_reconstruction && has_channel(line, SWAY_CHANNEL_CAR_YAW_RATE)) {
        tell_swing(seen, &line->channel[SWAY_CHANNEL_CAR_YAW_RATE], evidence->reconstructed_rad_s);
        return;
    }
    for (uint32_t i = 0; i < SWAY_JUDGE_STANDINS && !seen->has_swing; i++) {
        const sway_channel_t channel = STANDIN[i].channel;
        if (has_channel(line, channel)) {
            tell_swing(seen, &line->channel[channel],
                       MUL(size_of(line, channel), judge->swing_by[i]));
        }
    }
}

/* --- evidence ----------------------------------------------------------------------------------
 */

/* Yaw rate that the wheel's movement at the line would cause if it were slow; false: not known. */
static bool find_steered(const sway_judge_t *judge, const sway_judge_evidence_t *evidence,
                         sway_real_t *steered)
{
    *steered = sway_real_zero();
    if (!has_channel(evidence->line, SWAY_CHANNEL_STEERING_WHEEL_ANGLE)) {
        return true; // nobody has seen a hand
    }
    if (!evidence->model->has_steady) {
        return (evidence->quality & SWAY_QUALITY_FORCED) == 0U;
    }
    const sway_real_t wheel = size_of(evidence->line, SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    const sway_real_t ratio = sway_real_ratio(1000, judge->steering_ratio_milli);
    const sway_real_t gain = sway_real_abs(evidence->model->steady.yaw_rate_gain_1_s);
    *steered = MUL(MUL(wheel, ratio), gain);
    return true;
}

/* Damping ratio that the line shows. */
static sway_evidence_t line_evidence(const sway_judge_t *judge,
                                     const sway_judge_evidence_t *evidence, const seen_t *seen)
{
    sway_evidence_t damping;
    memset(&damping, 0, sizeof damping);
    if (!seen->has_swing || !seen->hand_known) {
        return damping;
    }
    const bool forced = (evidence->quality & SWAY_QUALITY_FORCED) != 0U;
    sway_line_damping(evidence->line, &damping.ratio, &damping.se);
    damping.se = sway_disturbance_se(&judge->disturbance, damping.se, seen->swing_rad_s,
                                     seen->steered_rad_s);
    damping.usable = !forced || sway_real_less(damping.se, sway_real_micro(FORCED_SE_PPM));
    return damping;
}

static sway_evidence_t model_evidence(const sway_judge_evidence_t *evidence)
{
    const sway_margin_model_t *const model = evidence->model;
    const sway_evidence_t damping = {model->damping_ratio, model->damping_ratio_se,
                                     evidence->modelled && model->has_model,
                                     evidence->has_reconstruction};
    return damping;
}

/* Every free swing teaches how disturbed it is, also one that is not a single damped line. */
static void learn(sway_judge_t *judge, const sway_judge_evidence_t *evidence, const seen_t *seen,
                  const sway_evidence_t *combined)
{
    const uint32_t bad = SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP;
    sway_real_t ratio;
    sway_real_t se;
    if (seen->has_swing && combined->usable && (evidence->quality & bad) == 0U) {
        sway_line_damping(evidence->line, &ratio, &se);
        sway_disturbance_learn(&judge->disturbance, evidence->time_us, SUB(ratio, combined->ratio),
                               seen->swing_rad_s, seen->steered_rad_s);
    }
}

/* --- judgement ---------------------------------------------------------------------------------
 */

bool sway_judge_has_limit(const sway_margin_model_t *model)
{
    return model->kind == SWAY_VCRIT_FOUND || model->kind == SWAY_VCRIT_DIVERGENCE;
}

/* Newest speed, or the last one while it still says something. */
static int32_t speed_for_alarm(sway_judge_t *judge, const sway_judge_evidence_t *evidence,
                               bool has_swing)
{
    if (evidence->speed_mm_s >= 0) {
        judge->last_speed_mm_s = evidence->speed_mm_s;
        judge->last_speed_us = evidence->time_us;
    }
    const bool remembered = evidence->time_us - judge->last_speed_us < SPEED_MEMORY_US;
    if (has_swing && judge->last_speed_mm_s < 0) {
        return INT32_MAX; // it never came; a swing is no swing of standing
    }
    return has_swing || remembered ? judge->last_speed_mm_s : -1;
}

/* Missing now, or for so long in the window that the line was made without them. */
static uint32_t missing_inputs(const sway_judge_evidence_t *evidence)
{
    const uint32_t used = evidence->line->valid_mask | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
    const uint32_t unused = evidence->line->valid_mask != 0U ? evidence->seen_mask & ~used : 0U;
    return evidence->missing_mask | unused;
}

static uint32_t quality_of(const sway_judge_t *judge, const sway_judge_evidence_t *evidence)
{
    uint32_t quality = evidence->quality;
    if (evidence->speed_mm_s < 0) {
        quality |= SWAY_QUALITY_NO_SPEED;
    } else if (evidence->speed_mm_s < judge->alarm.config.minimum_speed_mm_s) {
        quality |= SWAY_QUALITY_SLOW;
    }
    const bool held = (quality & NOT_HELD) == 0U;
    const sway_line_t *const line = evidence->line;
    if (held && !has_channel(line, yaw_channel(judge)) &&
        !has_channel(line, SWAY_CHANNEL_CAR_YAW_RATE)) {
        quality |= SWAY_QUALITY_MISSING_INPUT;
    }
    if (evidence->modelled && evidence->model->kind == SWAY_VCRIT_SINGULAR) {
        quality |= SWAY_QUALITY_SINGULAR;
    }
    return quality;
}

static int32_t millimetre(sway_real_t metre)
{
    return sway_real_to_int(metre, 1000, 0, INT32_MAX);
}

static void raise_alarm(sway_judge_t *judge, const sway_judge_evidence_t *evidence,
                        const seen_t *seen, const sway_judgement_t *judgement)
{
    const sway_margin_model_t *const model = evidence->model;
    const sway_line_t *const line = evidence->line;
    const bool counts = evidence->modelled && !model->vague;
    const sway_alarm_input_t input = {
        .time_us = evidence->time_us,
        .speed_mm_s = speed_for_alarm(judge, evidence, seen->has_swing),
        .has_critical_speed = counts && sway_judge_has_limit(model),
        .is_below_range = counts && model->kind == SWAY_VCRIT_BELOW_RANGE,
        .is_static = model->kind == SWAY_VCRIT_DIVERGENCE,
        .is_identified = model->source == SWAY_SOURCE_IDENTIFIED,
        .v_crit_mm_s = millimetre(model->v_crit_m_s),
        .v_crit_se_mm_s = millimetre(model->v_crit_se_m_s),
        .model = model_evidence(evidence),
        .damping = judgement->combined,
        .belief = judgement->belief,
        .has_swing = seen->has_swing,
        .amplitude_rad_s = seen->swing_rad_s,
        .has_oscillation = judgement->signal.usable,
        .growth_1_s = line->growth_1_s,
        .growth_se_1_s = line->growth_se_1_s,
        .omega_rad_s = line->omega_rad_s,
        .mid_time_us = line->mid_time_us,
    };
    sway_alarm_update(&judge->alarm, &input);
}

void sway_judge_take(sway_judge_t *judge, const sway_judge_evidence_t *evidence,
                     sway_judgement_t *judgement)
{
    const sway_evidence_t model = model_evidence(evidence);
    bool disagrees;
    seen_t seen;
    memset(&seen, 0, sizeof seen);
    find_swing(judge, evidence, &seen);
    judgement->has_swing = seen.has_swing;
    judgement->swing_rad_s = seen.swing_rad_s;
    judgement->swing_se_rad_s = seen.swing_se_rad_s;
    seen.hand_known = find_steered(judge, evidence, &seen.steered_rad_s);
    judgement->signal = line_evidence(judge, evidence, &seen);
    judgement->belief =
        sway_evidence_combine(&model, &judgement->signal, &judgement->combined, &disagrees);
    judgement->quality = quality_of(judge, evidence);
    judgement->quality |= disagrees ? (uint32_t)SWAY_QUALITY_MODEL_DISAGREES : 0U;
    judgement->missing_mask = missing_inputs(evidence);
    learn(judge, evidence, &seen, &judgement->combined);
    raise_alarm(judge, evidence, &seen, judgement);
}

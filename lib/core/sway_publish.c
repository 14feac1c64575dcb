// SPDX-License-Identifier: MIT
#include "core/sway_publish.h"

#include <limits.h>
#include <stddef.h>

static int32_t integer(sway_real_t a, int32_t scale)
{
    return sway_real_to_int(a, scale, -INT32_MAX, INT32_MAX);
}

static int32_t hertz_micro(sway_real_t rad_s)
{
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    return integer(sway_real_div(rad_s, turn), 1000000);
}

static void put_line(sway_status_t *status, const sway_publish_t *from)
{
    const sway_line_t *const line = from->line;
    sway_real_t ratio;
    sway_real_t se;
    status->mid_time_us = line->mid_time_us;
    status->frequency_uhz = hertz_micro(line->omega_rad_s);
    status->frequency_se_uhz = hertz_micro(line->omega_se_rad_s);
    status->growth_ppm_per_s = integer(line->growth_1_s, 1000000);
    status->growth_se_ppm_per_s = integer(line->growth_se_1_s, 1000000);
    sway_line_damping(line, &ratio, &se);
    status->damping_ratio_ppm = integer(ratio, 1000000);
    status->damping_ratio_se_ppm = integer(se, 1000000);
    if (from->judgement->has_swing) {
        status->amplitude_urad_s = integer(from->judgement->swing_rad_s, 1000000);
        status->amplitude_se_urad_s = integer(from->judgement->swing_se_rad_s, 1000000);
    }
}

static void put_axle(sway_axle_status_t *axle, const sway_axle_estimate_t *estimate)
{
    const sway_real_t size = sway_complex_abs(estimate->stiffness.value);
    const sway_real_t force = sway_complex_abs(estimate->force.value);
    axle->cornering_stiffness_n_per_rad = integer(size, 1);
    axle->cornering_stiffness_se_n_per_rad = integer(estimate->stiffness.se, 1);
    axle->argument_urad = integer(sway_complex_arg(estimate->stiffness.value), 1000000);
    axle->argument_se_urad = integer(sway_real_div(estimate->stiffness.se, size), 1000000);
    axle->slip_amplitude_urad = integer(sway_complex_abs(estimate->slip.value), 1000000);
    axle->force_amplitude_mn = integer(force, 1000);
}

static void put_load(sway_axle_status_t *axle, const sway_axle_estimate_t *estimate)
{
    const sway_real_t size = sway_complex_abs(estimate->stiffness.value);
    const sway_real_t force = sway_complex_abs(estimate->force.value);
    axle->load_mn = integer(estimate->load_n, 1000);
    axle->effective_load_mn = integer(estimate->effective_load_n, 1000);
    axle->effective_load_se_mn = integer(estimate->effective_load_se_n, 1000);
    axle->load_harmonic_mn = integer(sway_complex_abs(estimate->load_harmonic_n), 1000);
    axle->load_harmonic_phase_urad = integer(sway_complex_arg(estimate->load_harmonic_n), 1000000);
    axle->normalised_stiffness_milli_per_rad =
        integer(sway_real_div(size, estimate->effective_load_n), 1000);
    axle->lateral_friction_ppm = integer(sway_real_div(force, estimate->effective_load_n), 1000000);
}

static void put_inertia(int32_t *inertia_gm2, int32_t *argument_urad,
                        const sway_estimate_t *estimate)
{
    *inertia_gm2 = integer(sway_complex_abs(estimate->value), 1000);
    if (argument_urad != NULL) {
        *argument_urad = integer(sway_complex_arg(estimate->value), 1000000);
    }
}

static void put_inertias(sway_status_t *status, const sway_identify_t *id)
{
    if ((id->valid & SWAY_VALID_CAR_INERTIA) != 0U) {
        put_inertia(&status->car_yaw_inertia_gm2, &status->car_yaw_inertia_argument_urad,
                    &id->car_inertia);
        status->car_yaw_inertia_se_gm2 = integer(id->car_inertia.se, 1000);
    }
    if ((id->valid & SWAY_VALID_TRAILER_INERTIA) != 0U) {
        put_inertia(&status->trailer_yaw_inertia_gm2, &status->trailer_yaw_inertia_argument_urad,
                    &id->trailer_inertia);
        status->trailer_yaw_inertia_se_gm2 = integer(id->trailer_inertia.se, 1000);
    }
    if ((id->valid & SWAY_VALID_TRAILER_INERTIA_1) != 0U) {
        put_inertia(&status->trailer_yaw_inertia_1_gm2, NULL, &id->trailer_inertia_1);
    }
    if ((id->valid & SWAY_VALID_TRAILER_INERTIA_2) != 0U) {
        put_inertia(&status->trailer_yaw_inertia_2_gm2, NULL, &id->trailer_inertia_2);
    }
}

void sway_publish_part(sway_status_t *status, const sway_identify_t *id, uint32_t part)
{
    if (part >= (uint32_t)SWAY_AXLE_COUNT) {
        put_inertias(status, id);
        return;
    }
    if ((id->valid & ((uint32_t)SWAY_VALID_CAR_FRONT << part)) != 0U) {
        put_axle(&status->axle[part], &id->axle[part]);
    }
    if ((id->valid & ((uint32_t)SWAY_VALID_CAR_FRONT_LOAD << part)) != 0U) {
        put_load(&status->axle[part], &id->axle[part]);
    }
}

static void put_steady(sway_status_t *status, const sway_single_track_static_t *steady)
{
    status->understeer_gradient_urad = integer(steady->understeer_gradient_rad, 1000000);
    status->combination_understeer_gradient_urad =
        integer(steady->combination_understeer_gradient_rad, 1000000);
    status->characteristic_speed_mm_s = integer(steady->characteristic_speed_m_s, 1000);
    status->yaw_rate_gain_micro_per_s = integer(steady->yaw_rate_gain_1_s, 1000000);
    status->hitch_angle_gain_ppm = integer(steady->hitch_angle_gain, 1000000);
}

static void put_critical(sway_status_t *status, const sway_publish_t *from)
{
    const sway_margin_model_t *const model = from->model;
    status->v_crit_mm_s = integer(model->v_crit_m_s, 1000);
    status->v_crit_se_mm_s = integer(model->v_crit_se_m_s, 1000);
    if (status->v_crit_swing_urad_s < from->alarm->config.limit_amplitude_urad_s) {
        status->quality |= SWAY_QUALITY_SMALL_SWING;
    }
    for (int i = 0; i < (int)SWAY_PARAMETER_COUNT; i++) {
        status->sensitivity_mm_s[i] = integer(model->sensitivity_m_s[i], 1000);
    }
    if (from->speed_mm_s >= 0) {
        status->margin_mm_s = status->v_crit_mm_s - from->speed_mm_s;
    }
}

static uint32_t put_model(sway_status_t *status, const sway_publish_t *from)
{
    const sway_margin_model_t *const model = from->model;
    uint32_t valid = 0;
    status->source = (int32_t)model->source;
    status->v_crit_kind = (int32_t)model->kind;
    if (model->has_model) {
        valid |= SWAY_VALID_MODEL;
        status->model_damping_ratio_ppm = integer(model->damping_ratio, 1000000);
        status->model_damping_ratio_se_ppm = integer(model->damping_ratio_se, 1000000);
        status->model_frequency_uhz = hertz_micro(model->root.im);
    }
    if (model->has_steady) {
        put_steady(status, &model->steady);
    }
    if (sway_judge_has_limit(model)) {
        valid |= SWAY_VALID_CRITICAL_SPEED;
        put_critical(status, from);
    }
    return valid;
}

#define TYRES                                                                                      \
    ((uint32_t)SWAY_VALID_CAR_FRONT | (uint32_t)SWAY_VALID_CAR_REAR |                              \
     (uint32_t)SWAY_VALID_TRAILER_FRONT | (uint32_t)SWAY_VALID_TRAILER_REAR)

/* No line is held: what came out of it is not to be used, however it looks. */
#define NOTHING_HELD ((uint32_t)SWAY_QUALITY_NO_OSCILLATION | (uint32_t)SWAY_QUALITY_SEEKING)

void sway_publish(sway_status_t *status, const sway_publish_t *from)
{
    const uint32_t ever = status->valid | status->old;
    uint32_t valid = 0;
    status->time_us = from->time_us;
    status->quality = from->judgement->quality;
    status->belief = (int32_t)from->judgement->belief;
    if (from->speed_mm_s >= 0) {
        valid |= SWAY_VALID_SPEED;
        status->speed_mm_s = from->speed_mm_s;
    }
    if (from->line != NULL) {
        valid |= SWAY_VALID_LINE;
        put_line(status, from);
    }
    if (from->identify != NULL && (from->judgement->quality & NOTHING_HELD) == 0U) {
        valid |= from->identify->valid;
        if ((valid & TYRES) != 0U && status->amplitude_urad_s > status->v_crit_swing_urad_s) {
            status->v_crit_swing_urad_s = status->amplitude_urad_s;
        }
    }
    if (from->model != NULL) {
        valid |= put_model(status, from);
    }
    if (from->judgement->belief != SWAY_BELIEF_NONE) {
        valid |= SWAY_VALID_MARGIN;
        status->margin_damping_ratio_ppm = integer(from->judgement->combined.ratio, 1000000);
        status->margin_damping_ratio_se_ppm = integer(from->judgement->combined.se, 1000000);
    }
    status->missing_inputs = from->judgement->missing_mask;
    status->alarm = (int32_t)from->alarm->state;
    status->reasons = from->alarm->reasons;
    status->time_to_limit_ms = from->alarm->time_to_limit_ms;
    valid |= from->alarm->time_to_limit_ms >= 0 ? SWAY_VALID_TIME_TO_LIMIT : 0U;
    status->valid = valid;
    status->old = ever & ~valid;
}

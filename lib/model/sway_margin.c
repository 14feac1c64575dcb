// SPDX-License-Identifier: MIT
#include "model/sway_margin.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

enum { ROOT_SWEEPS_MAX = 30, NEWTON_MAX = 25 };

/* Relative standard errors of the user's values: stiffness, its lag (see sway_quantity_start()),
 * inertia; and how fast the true values may drift, per square root of a second.
 */
#define USER_STIFFNESS_PPM 100000
#define USER_LAG_PPM 40000
#define USER_INERTIA_PPM 70000
#define DRIFT_STIFFNESS_PPM 2000
#define DRIFT_LAG_PPM 500
#define DRIFT_INERTIA_PPM 1000

/* A swing is carried on with no more damping than this. */
#define DAMPING_MOST_PERCENT 20

void sway_margin_init(sway_margin_t *margin, const sway_vehicle_t *vehicle)
{
    memset(margin, 0, sizeof *margin);
    margin->vehicle = *vehicle;
    const int32_t stiffness[SWAY_AXLE_COUNT] = {
        vehicle->car.front_cornering_stiffness_n_per_rad,
        vehicle->car.rear_cornering_stiffness_n_per_rad,
        vehicle->trailer.axles == 2 ? vehicle->trailer.front_cornering_stiffness_n_per_rad : 0,
        vehicle->trailer.axles > 0 ? vehicle->trailer.rear_cornering_stiffness_n_per_rad : 0,
    };
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        sway_quantity_start(&margin->stiffness[axle], sway_real_int(stiffness[axle]),
                            USER_STIFFNESS_PPM, USER_LAG_PPM);
    }
    const int32_t trailer = vehicle->trailer.axles > 0 ? vehicle->trailer.yaw_inertia_gm2 : 0;
    sway_quantity_start(&margin->inertia[0], sway_real_ratio(vehicle->car.yaw_inertia_gm2, 1000),
                        USER_INERTIA_PPM, 0);
    sway_quantity_start(&margin->inertia[1], sway_real_ratio(trailer, 1000), USER_INERTIA_PPM, 0);
}

/* --- estimates into the filters --------------------------------------------------------------- */

/* An earlier swing carried on to now, by its own frequency and the damping so far: nothing of it
 * may be of this window, whose wind would be in it. The result is the share of this swing that is
 * so predicted, 0..1. A hand that moves the wheel is no wind: all of a forced swing counts. */
static sway_real_t predicted_share(sway_margin_t *margin, const sway_identify_t *id,
                                   int64_t time_us)
{
    const sway_line_t *const line = id->line;
    const uint32_t trailer = line->valid_mask & SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    const sway_channel_t yaw =
        trailer != 0U ? SWAY_CHANNEL_TRAILER_YAW_RATE : SWAY_CHANNEL_CAR_YAW_RATE;
    const sway_real_t one = sway_real_int(1);
    const sway_margin_past_t now = {time_us, line->omega_rad_s, line->channel[yaw].amplitude};
    const sway_margin_past_t past = margin->past[margin->past_next];
    margin->past[margin->past_next] = now;
    margin->past_next = (uint8_t)((margin->past_next + 1U) % SWAY_MARGIN_PAST);
    if ((line->flags & SWAY_LINE_FORCED) != 0U) {
        return one;
    }
    const sway_real_t angle = MUL(past.omega_rad_s, sway_real_micro(time_us - past.time_us));
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    if (sway_real_sign(angle) <= 0 || sway_real_less(turn, angle)) {
        return sway_real_zero();
    }
    const sway_real_t least = sway_real_max(margin->model.damping_ratio, sway_real_zero());
    const sway_real_t damping = sway_real_min(least, sway_real_ratio(DAMPING_MOST_PERCENT, 100));
    const sway_real_t left = sway_real_exp(NEG(MUL(damping, angle)));
    const sway_complex_t carried = sway_complex_mul(past.swing, sway_complex_unit(angle));
    const sway_real_t share = MUL(left, sway_complex_div(carried, now.swing).re);
    return sway_real_max(sway_real_min(share, one), sway_real_zero());
}

/* Windows with missing samples or that are not one damped line are taken, too: their standard
 * errors are larger for it, and hold (seen with the warning campaign). */
static void take_estimates(sway_margin_t *margin, const sway_identify_t *id, int64_t time_us)
{
    const sway_real_t predicted = predicted_share(margin, id, time_us);
    const sway_complex_t s = id->s.value;
    const sway_complex_t s_by_v = {DIV(s.re, id->speed_m_s), DIV(s.im, id->speed_m_s)};
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        const sway_axle_estimate_t *const estimate = &id->axle[axle];
        if ((id->valid & ((uint32_t)SWAY_VALID_CAR_FRONT << (uint32_t)axle)) != 0U) {
            sway_quantity_take(&margin->stiffness[axle], &estimate->stiffness, s_by_v,
                               estimate->derived ? &predicted : NULL);
        }
    }
    const uint32_t bit[2] = {SWAY_VALID_CAR_INERTIA, SWAY_VALID_TRAILER_INERTIA};
    for (int body = 0; body < 2; body++) {
        if ((id->valid & bit[body]) != 0U) {
            sway_quantity_take(&margin->inertia[body], &id->freed_inertia[body], s_by_v, NULL);
        }
    }
}

/* --- into the model --------------------------------------------------------------------------- */

/* C0 and sigma of C = C0/(1 + sigma z) at z = s/v; sigma is 0 in a model that was just made. */
static void set_axle(sway_single_track_body_t *body, int axle, const sway_quantity_t *state)
{
    const sway_complex_t c = state->value;
    const sway_real_t lag = DIV(sway_real_neg(c.im), c.re);
    const sway_real_t below = SUB(state->s_by_v.im, MUL(lag, state->s_by_v.re));
    body->stiffness_n_per_rad[axle] = c.re;
    if (state->identified && sway_real_sign(below) > 0) {
        const sway_real_t sigma = DIV(lag, below);
        const sway_complex_t one = {sway_real_int(1), sway_real_zero()};
        const sway_complex_t delay =
            sway_complex_add(one, sway_complex_scale(state->s_by_v, sigma));
        body->relaxation_m[axle] = sigma;
        body->stiffness_n_per_rad[axle] = sway_complex_mul(c, delay).re;
    }
}

/* Whether the user or the estimates so far have given all that the model is made of. */
static bool is_known(const sway_margin_t *margin)
{
    const sway_quantity_t *const stiffness = margin->stiffness;
    const int32_t axles = margin->vehicle.trailer.axles;
    const bool car = margin->inertia[0].started && stiffness[0].started && stiffness[1].started;
    const bool trailer = margin->vehicle.car.hitch_to_cog_um != 0 && margin->inertia[1].started &&
                         stiffness[3].started && (axles != 2 || stiffness[2].started);
    return car && (axles == 0 || trailer);
}

static bool build_model(sway_margin_t *margin)
{
    sway_vehicle_t vehicle = margin->vehicle;
    const bool trailer = vehicle.trailer.axles > 0;
    const bool tandem = vehicle.trailer.axles == 2;
    if (!is_known(margin)) {
        return false;
    }
    /* Whatever the user did not give is replaced below. */
    vehicle.car.yaw_inertia_gm2 = 1000000;
    vehicle.car.front_cornering_stiffness_n_per_rad = 1000;
    vehicle.car.rear_cornering_stiffness_n_per_rad = 1000;
    vehicle.trailer.front_cornering_stiffness_n_per_rad = tandem ? 1000 : 0;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = trailer ? 1000 : 0;
    if (sway_single_track_from_vehicle(&margin->stm, &vehicle) != SWAY_OK) {
        return false;
    }
    for (int body = 0; body < 2; body++) {
        margin->stm.body[body].yaw_inertia_kgm2 = margin->inertia[body].value.re;
    }
    return true;
}

static sway_source_t source_of(const sway_margin_t *margin)
{
    int wanted = 0;
    int identified = 0;
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        wanted += margin->stiffness[axle].started ? 1 : 0;
        identified += margin->stiffness[axle].identified ? 1 : 0;
    }
    if (identified == 0) {
        return SWAY_SOURCE_USER;
    }
    return identified < wanted ? SWAY_SOURCE_PARTLY : SWAY_SOURCE_IDENTIFIED;
}

sway_error_t sway_margin_start(sway_margin_t *margin, const sway_identify_t *identify,
                               int64_t time_us, sway_real_t speed_m_s)
{
    if (sway_real_less(speed_m_s, sway_real_ratio(30000, 3600))) {
        return SWAY_ERROR_SPEED;
    }
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        sway_quantity_drift(&margin->stiffness[axle], time_us, DRIFT_STIFFNESS_PPM, DRIFT_LAG_PPM);
    }
    for (int body = 0; body < 2; body++) {
        sway_quantity_drift(&margin->inertia[body], time_us, DRIFT_INERTIA_PPM, 0);
    }
    if (identify != NULL) {
        take_estimates(margin, identify, time_us);
    }
    if (!build_model(margin)) {
        return SWAY_ERROR_VEHICLE;
    }
    memset(&margin->next, 0, sizeof margin->next);
    margin->next.source = source_of(margin);
    margin->speed_m_s = speed_m_s;
    margin->step = 0;
    margin->count = 0;
    return SWAY_OK;
}

/* --- steps of a computation ------------------------------------------------------------------- */

/* A step returns true when it is done and the next one may begin. */
typedef bool step_t(sway_margin_t *margin);

static bool step_axles(sway_margin_t *margin)
{
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        if (margin->stiffness[axle].started) {
            set_axle(&margin->stm.body[axle / 2], axle % 2, &margin->stiffness[axle]);
        }
    }
    return true;
}

/* The last roots are the start of the next; turned a little, so that a pair that was conjugate may
 * become two real roots. */
static bool step_quartic(sway_margin_t *margin)
{
    margin->quartic = sway_single_track_quartic(&margin->stm, margin->speed_m_s);
    if (!margin->model.has_model) {
        sway_single_track_roots_start(&margin->roots, &margin->quartic);
        return true;
    }
    const sway_complex_t turn = {sway_real_int(1), sway_real_ratio(1, 200)};
    for (int k = 0; k < margin->roots.count; k++) {
        margin->roots.root[k] = sway_complex_mul(margin->roots.root[k], turn);
    }
    return true;
}

static bool step_roots(sway_margin_t *margin)
{
    const bool settled = sway_single_track_roots_sweep(&margin->roots, &margin->quartic);
    if (!settled && margin->count < ROOT_SWEEPS_MAX) {
        return false;
    }
    margin->next.root = sway_single_track_dominant(&margin->roots);
    margin->next.has_model = settled;
    return true;
}

static bool has_lag(const sway_margin_t *margin)
{
    const sway_single_track_body_t *const body = margin->stm.body;
    return !sway_real_is_zero(body[0].relaxation_m[0]) ||
           !sway_real_is_zero(body[0].relaxation_m[1]) ||
           !sway_real_is_zero(body[1].relaxation_m[0]) ||
           !sway_real_is_zero(body[1].relaxation_m[1]);
}

static bool is_small(sway_complex_t step, sway_real_t size)
{
    const sway_real_t bound =
        MUL(sway_real_square(size),
            sway_real_div(sway_real_int(1), sway_real(INT64_C(1000000000000), 0)));
    return sway_real_compare(sway_complex_norm(step), bound) <= 0;
}

/* Newton on f(s, v) = 0 at the present speed. */
static bool step_root_slope(sway_margin_t *margin)
{
    return sway_single_track_slope_s(&margin->stm, margin->next.root, margin->speed_m_s,
                                     margin->count, &margin->f_s);
}

static bool step_root(sway_margin_t *margin)
{
    if (!margin->next.has_model || !has_lag(margin)) {
        return true;
    }
    const sway_complex_t root = margin->next.root;
    const sway_complex_t f =
        sway_single_track_characteristic(&margin->stm, root, margin->speed_m_s);
    const sway_complex_t step = sway_complex_div(f, margin->f_s);
    /* A root that has far to go is not the one that was meant: lags change it little. */
    const sway_real_t fifth = sway_real_ratio(1, 25);
    const bool wild = sway_real_less(MUL(sway_complex_norm(root), fifth), sway_complex_norm(step));
    if (wild || margin->count >= NEWTON_MAX) {
        margin->next.has_model = false;
        return true;
    }
    margin->next.root = sway_complex_sub(root, step);
    return is_small(step, sway_complex_abs(root));
}

static bool step_critical(sway_margin_t *margin)
{
    sway_margin_model_t *const next = &margin->next;
    next->kind =
        sway_single_track_critical_speed(&margin->stm, &next->v_crit_m_s, &next->omega_crit_rad_s);
    next->damping_ratio = sway_single_track_damping_ratio(next->root);
    if (next->kind == SWAY_VCRIT_FOUND && margin->model.kind == SWAY_VCRIT_FOUND &&
        has_lag(margin)) { // nearer than what the lags are left out of
        next->v_crit_m_s = margin->model.v_crit_m_s;
        next->omega_crit_rad_s = margin->model.omega_crit_rad_s;
    }
    next->has_steady =
        sway_single_track_steady_state(&margin->stm, margin->speed_m_s, &next->steady) == SWAY_OK;
    return true;
}

/* A limit with derivatives: oscillatory, or static at s = 0. */
static bool critical_is_wanted(const sway_margin_t *margin)
{
    return margin->next.kind == SWAY_VCRIT_FOUND || margin->next.kind == SWAY_VCRIT_DIVERGENCE;
}

/* Lags move an oscillatory limit only. */
static bool limit_is_moved(const sway_margin_t *margin)
{
    return margin->next.kind == SWAY_VCRIT_FOUND && has_lag(margin);
}

static sway_complex_t at_limit(const sway_margin_t *margin)
{
    const sway_complex_t s = {sway_real_zero(), margin->next.omega_crit_rad_s};
    return s;
}

static bool step_critical_slope_s(sway_margin_t *margin)
{
    return !critical_is_wanted(margin) ||
           sway_single_track_slope_s(&margin->stm, at_limit(margin), margin->next.v_crit_m_s,
                                     margin->count, &margin->f_s);
}

static bool step_critical_slope_v(sway_margin_t *margin)
{
    return !critical_is_wanted(margin) ||
           sway_single_track_slope_v(&margin->stm, at_limit(margin), margin->next.v_crit_m_s,
                                     margin->count, &margin->f_v);
}

static sway_real_t limited(sway_real_t step, sway_real_t limit)
{
    return sway_real_max(sway_real_min(step, limit), sway_real_neg(limit));
}

/* Two-dimensional Newton in frequency and speed with the lags in the model. */
static bool step_critical_newton(sway_margin_t *margin)
{
    sway_margin_model_t *const next = &margin->next;
    if (!limit_is_moved(margin)) {
        return true;
    }
    const sway_complex_t f =
        sway_single_track_characteristic(&margin->stm, at_limit(margin), next->v_crit_m_s);
    sway_real_t d_omega;
    sway_real_t d_v;
    if (sway_single_track_shift(margin->f_s, margin->f_v, f, &d_omega, &d_v) != SWAY_OK ||
        margin->count >= NEWTON_MAX) {
        next->kind = SWAY_VCRIT_SINGULAR;
        return true;
    }
    const sway_real_t tenth = sway_real_ratio(1, 10);
    next->v_crit_m_s = ADD(next->v_crit_m_s, limited(d_v, MUL(next->v_crit_m_s, tenth)));
    next->omega_crit_rad_s =
        ADD(next->omega_crit_rad_s, limited(d_omega, MUL(next->omega_crit_rad_s, tenth)));
    const sway_complex_t step = {d_v, sway_real_zero()};
    if (margin->count == 0) {
        margin->far =
            sway_real_less(sway_real_ratio(1, 50), sway_real_abs(DIV(d_v, next->v_crit_m_s)));
    }
    return is_small(step, next->v_crit_m_s);
}

/* After the lags: a limit that has left the range of the search. */
static bool step_critical_range(sway_margin_t *margin)
{
    sway_margin_model_t *const next = &margin->next;
    if (limit_is_moved(margin)) {
        if (sway_real_less(next->v_crit_m_s, sway_single_track_speed_low())) {
            next->v_crit_m_s = sway_single_track_speed_low();
            next->kind = SWAY_VCRIT_BELOW_RANGE;
        } else if (sway_real_less(sway_single_track_speed_high(), next->v_crit_m_s)) {
            next->v_crit_m_s = sway_single_track_speed_high();
            next->kind = SWAY_VCRIT_BEYOND_RANGE;
        }
    }
    return true;
}

/* Slopes once more at the limit that was found, if it was far from where the search began. */
static bool step_limit_slope_s(sway_margin_t *margin)
{
    return !(margin->far && limit_is_moved(margin)) || step_critical_slope_s(margin);
}

static bool step_limit_slope_v(sway_margin_t *margin)
{
    return !(margin->far && limit_is_moved(margin)) || step_critical_slope_v(margin);
}

/* Relative variances (1 % = 1) of the filtered quantity behind a parameter; 0 where it is fixed. */
static void parameter_variance(const sway_margin_t *margin, sway_parameter_t parameter,
                               sway_real_t *re, sway_real_t *im)
{
    const sway_quantity_t *state = NULL;
    if (parameter >= SWAY_PARAMETER_CAR_FRONT_STIFFNESS) {
        state = &margin->stiffness[parameter - SWAY_PARAMETER_CAR_FRONT_STIFFNESS];
    } else if (parameter == SWAY_PARAMETER_CAR_YAW_INERTIA) {
        state = &margin->inertia[0];
    } else if (parameter == SWAY_PARAMETER_TRAILER_YAW_INERTIA) {
        state = &margin->inertia[1];
    }
    *re = sway_real_zero();
    *im = sway_real_zero();
    if (state != NULL && state->started) {
        const sway_real_t percent = DIV(sway_real_int(10000), sway_real_square(state->value.re));
        *re = MUL(state->variance_re, percent);
        *im = MUL(state->variance_im, percent);
    }
}

static sway_complex_t times_j(sway_complex_t a)
{
    const sway_complex_t turned = {sway_real_neg(a.im), a.re};
    return turned;
}

/* The parameter of this slice; false when all that are due have been done. */
static bool due(sway_margin_t *margin, sway_parameter_t *parameter)
{
    const int many = margin->complete ? SWAY_MARGIN_TURN : (int)SWAY_PARAMETER_COUNT;
    *parameter =
        (sway_parameter_t)(((uint32_t)margin->turn + margin->count) % SWAY_PARAMETER_COUNT);
    return (int)margin->count < many;
}

/* Derivatives of v_crit to one parameter, Eq. 3.44. */
static bool step_sensitivity(sway_margin_t *margin)
{
    sway_parameter_t parameter;
    if (!due(margin, &parameter) || !critical_is_wanted(margin)) {
        return true;
    }
    sway_complex_t *const result = &margin->limit_per_percent[parameter];
    result->re = sway_real_zero();
    result->im = sway_real_zero();
    if (sway_single_track_has_parameter(&margin->stm, parameter)) {
        const sway_complex_t df = sway_single_track_slope_parameter(
            &margin->stm, at_limit(margin), margin->next.v_crit_m_s, parameter);
        sway_real_t d_omega;
        (void)sway_single_track_shift(margin->f_s, margin->f_v, df, &d_omega, &result->re);
        (void)sway_single_track_shift(margin->f_s, margin->f_v, times_j(df), &d_omega, &result->im);
    }
    return false;
}

/* Derivative of the dominant root at the present speed: ds = -df/f_s. */
static bool step_root_derivative(sway_margin_t *margin)
{
    sway_parameter_t parameter;
    sway_real_t re;
    sway_real_t im;
    if (!due(margin, &parameter) || !margin->next.has_model) {
        return true;
    }
    parameter_variance(margin, parameter, &re, &im);
    sway_complex_t ds = {sway_real_zero(), sway_real_zero()};
    if (!sway_real_is_zero(re)) { // then it is in the model: step_axles() has put it there
        const sway_complex_t df = sway_single_track_slope_parameter(&margin->stm, margin->next.root,
                                                                    margin->speed_m_s, parameter);
        ds = sway_complex_div(df, margin->f_s);
    }
    margin->root_per_percent[parameter] = ds;
    return false;
}

/* Errors from the variances of the filtered quantities. */
static bool step_errors(sway_margin_t *margin)
{
    sway_margin_model_t *const next = &margin->next;
    sway_real_t limit = sway_real_zero();
    sway_real_t damping = sway_real_zero();
    for (int i = 0; i < (int)SWAY_PARAMETER_COUNT; i++) {
        const sway_complex_t by = margin->limit_per_percent[i];
        const sway_complex_t ds = margin->root_per_percent[i];
        sway_real_t re;
        sway_real_t im;
        parameter_variance(margin, (sway_parameter_t)i, &re, &im);
        limit = ADD(limit, ADD(MUL(re, sway_real_square(by.re)), MUL(im, sway_real_square(by.im))));
        damping = ADD(
            damping,
            ADD(MUL(re, sway_real_square(sway_single_track_damping_change(next->root, ds))),
                MUL(im,
                    sway_real_square(sway_single_track_damping_change(next->root, times_j(ds))))));
        next->sensitivity_m_s[i] = by.re;
    }
    next->v_crit_se_m_s = critical_is_wanted(margin) ? sway_real_sqrt(limit) : sway_real_zero();
    /* Where two roots meet the derivatives have no bound; the ratio has. */
    next->damping_ratio_se = sway_real_min(sway_real_sqrt(damping), sway_real_int(1));
    if (margin->complete) {
        margin->turn =
            (uint8_t)((margin->turn + (uint32_t)SWAY_MARGIN_TURN) % SWAY_PARAMETER_COUNT);
    }
    margin->complete = next->has_model && critical_is_wanted(margin);
    return true;
}

/* What a slice of a step costs about, see SWAY_SLICE_COST. */
static const struct {
    step_t *run;
    uint8_t cost;
} STEPS[] = {
    {step_axles, 8},
    {step_quartic, 14},
    {step_roots, 34},
    {step_root_slope, 28},
    {step_root, 30},
    {step_root_derivative, 43},
    {step_critical, 26},
    {step_critical_slope_s, 28},
    {step_critical_slope_v, 25},
    {step_critical_newton, 29},
    {step_critical_range, 2},
    {step_limit_slope_s, 28},
    {step_limit_slope_v, 25},
    {step_sensitivity, 43},
    {step_errors, 17},
};

enum { STEP_COUNT = sizeof STEPS / sizeof STEPS[0] };

uint32_t sway_margin_cost(const sway_margin_t *margin)
{
    return margin->step < STEP_COUNT ? STEPS[margin->step].cost : 1U;
}

bool sway_margin_run(sway_margin_t *margin)
{
    if (margin->step >= STEP_COUNT) {
        return false;
    }
    if (STEPS[margin->step].run(margin)) {
        margin->step++;
        margin->count = 0;
    } else {
        margin->count++;
    }
    if (margin->step < STEP_COUNT) {
        return true;
    }
    margin->model = margin->next;
    return false;
}

// SPDX-License-Identifier: MIT
#include "model/sway_identify.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

static const sway_channel_t LOAD_OF[SWAY_AXLE_COUNT] = {
    SWAY_CHANNEL_CAR_FRONT_FZ, SWAY_CHANNEL_CAR_REAR_FZ, SWAY_CHANNEL_TRAILER_FRONT_FZ,
    SWAY_CHANNEL_TRAILER_REAR_FZ};

static const sway_origin_t FORCE_OF[SWAY_AXLE_COUNT] = {
    SWAY_ORIGIN_CAR_FRONT_FY, SWAY_ORIGIN_CAR_REAR_FY, SWAY_ORIGIN_TRAILER_FRONT_FY,
    SWAY_ORIGIN_TRAILER_REAR_FY};

/* Line flags that leave nothing to identify from. */
#define NO_LINE (SWAY_LINE_NO_OSCILLATION | SWAY_LINE_SEEKING | SWAY_LINE_NOT_CONVERGED)

static sway_real_t metre(int32_t micrometre)
{
    return sway_real_micro(micrometre);
}

static bool has_channel(const sway_line_t *line, sway_channel_t channel)
{
    return (int)channel < (int)SWAY_CHANNELS &&
           (line->valid_mask & SWAY_CHANNEL_BIT(channel)) != 0U;
}

static sway_phasor_t measured(const sway_identify_t *id, sway_origin_t from)
{
    const sway_channel_t channel = sway_origin_of_channel(from);
    if (!has_channel(id->line, channel)) {
        return sway_phasor_unknown();
    }
    return sway_phasor_measured(id->line->channel[channel].amplitude, from);
}

static uint32_t quality_of(uint32_t line_flags)
{
    static const struct {
        uint32_t line;
        uint32_t quality;
    } table[] = {
        {SWAY_LINE_NO_OSCILLATION, SWAY_QUALITY_NO_OSCILLATION},
        {SWAY_LINE_FORCED, SWAY_QUALITY_FORCED},
        {SWAY_LINE_GAP, SWAY_QUALITY_GAP},
        {SWAY_LINE_SPEED_CHANGING, SWAY_QUALITY_SPEED_CHANGING},
        {SWAY_LINE_NONLINEAR, SWAY_QUALITY_NONLINEAR},
        {SWAY_LINE_SEEKING, SWAY_QUALITY_SEEKING},
        {SWAY_LINE_STARTING, SWAY_QUALITY_SEEKING},
        {SWAY_LINE_NOT_CONVERGED, SWAY_QUALITY_SEEKING},
        {SWAY_LINE_MISFIT, SWAY_QUALITY_MISFIT},
    };
    uint32_t quality = 0;
    for (unsigned i = 0; i < sizeof table / sizeof table[0]; i++) {
        if ((line_flags & table[i].line) != 0U) {
            quality |= table[i].quality;
        }
    }
    return quality;
}

static void set_variances(sway_identify_t *id)
{
    const sway_line_t *const line = id->line;
    for (int i = SWAY_ORIGIN_STEERING; i < (int)SWAY_ORIGIN_COUNT; i++) {
        const sway_channel_t channel = sway_origin_of_channel((sway_origin_t)i);
        if (has_channel(line, channel)) {
            const sway_real_t se = line->channel[channel].amplitude_se;
            id->sources.variance[i] = MUL(se, se);
        }
    }
    const sway_real_t both = ADD(MUL(line->omega_se_rad_s, line->omega_se_rad_s),
                                 MUL(line->growth_se_1_s, line->growth_se_1_s));
    id->sources.variance[SWAY_ORIGIN_S] = sway_real_scale(both, -1);
}

static uint32_t speed_quality(sway_real_t speed_m_s)
{
    if (sway_real_sign(speed_m_s) <= 0) {
        return SWAY_QUALITY_NO_SPEED;
    }
    return sway_real_less(speed_m_s, sway_real_ratio(30000, 3600)) ? SWAY_QUALITY_SLOW : 0U;
}

sway_error_t sway_identify_start(sway_identify_t *id, const sway_vehicle_t *vehicle,
                                 const sway_line_t *line)
{
    memset(id, 0, sizeof *id);
    id->vehicle = vehicle;
    id->line = line;
    id->quality = quality_of(line->flags);
    id->speed_m_s = line->speed_m_s;
    const uint32_t speed = speed_quality(line->speed_m_s);
    if (speed != 0U) {
        id->quality |= speed;
        return SWAY_ERROR_SPEED;
    }
    id->valid = SWAY_VALID_SPEED;
    if ((line->flags & NO_LINE) != 0U) {
        return SWAY_ERROR_NO_DATA;
    }
    const sway_complex_t s = {line->growth_1_s, line->omega_rad_s};
    id->s = sway_phasor_measured(s, SWAY_ORIGIN_S);
    set_variances(id);
    return SWAY_OK;
}

/* --- slips, Eq. 4.5-4.7 ----------------------------------------------------------------------- */

/* Slip of an axle `ahead` metres ahead of the accelerometer: (r - a/v)/s - r ahead/v. */
static sway_phasor_t slip_of(const sway_identify_t *id, sway_origin_t yaw_rate, sway_origin_t acc,
                             sway_real_t ahead)
{
    const sway_real_t by_v = DIV(sway_real_int(1), id->speed_m_s);
    const sway_phasor_t r = measured(id, yaw_rate);
    const sway_phasor_t a = measured(id, acc);
    sway_phasor_t slip = r;
    sway_phasor_add_scaled(&slip, &a, NEG(by_v));
    sway_phasor_divide(&slip, &id->s);
    sway_phasor_add_scaled(&slip, &r, NEG(MUL(ahead, by_v)));
    return slip;
}

static void car_slips(sway_identify_t *id)
{
    const sway_car_t *const car = &id->vehicle->car;
    const sway_real_t sensor = metre(car->lateral_acc_position_um);
    const sway_real_t front = SUB(metre(car->front_axle_to_cog_um), sensor);
    const sway_real_t rear = SUB(metre(-car->rear_axle_to_cog_um), sensor);
    const sway_phasor_t steering = measured(id, SWAY_ORIGIN_STEERING);
    sway_phasor_t *const slip = &id->axle[SWAY_AXLE_CAR_FRONT].slip;
    *slip = slip_of(id, SWAY_ORIGIN_CAR_YAW_RATE, SWAY_ORIGIN_CAR_ACC, front);
    sway_phasor_add_scaled(slip, &steering, sway_real_ratio(1000, car->steering_ratio_milli));
    id->axle[SWAY_AXLE_CAR_REAR].slip =
        slip_of(id, SWAY_ORIGIN_CAR_YAW_RATE, SWAY_ORIGIN_CAR_ACC, rear);
}

static void trailer_slips(sway_identify_t *id)
{
    const sway_trailer_t *const trailer = &id->vehicle->trailer;
    const sway_real_t sensor = metre(trailer->lateral_acc_position_um);
    const sway_real_t front = SUB(metre(trailer->front_axle_to_cog_um), sensor);
    const sway_real_t rear = SUB(metre(-trailer->rear_axle_to_cog_um), sensor);
    if (trailer->axles == 2) {
        id->axle[SWAY_AXLE_TRAILER_FRONT].slip =
            slip_of(id, SWAY_ORIGIN_TRAILER_YAW_RATE, SWAY_ORIGIN_TRAILER_ACC, front);
    }
    if (trailer->axles > 0) {
        id->axle[SWAY_AXLE_TRAILER_REAR].slip =
            slip_of(id, SWAY_ORIGIN_TRAILER_YAW_RATE, SWAY_ORIGIN_TRAILER_ACC, rear);
    }
}

/* --- forces, Eq. 4.8 and balances ------------------------------------------------------------- */

/* Acceleration of the COG from an accelerometer `ahead` metres ahead of it, times the mass. */
static sway_phasor_t inertia_force(const sway_identify_t *id, sway_origin_t yaw_rate,
                                   sway_origin_t acc, sway_real_t ahead, int32_t mass_g)
{
    sway_phasor_t turn = measured(id, yaw_rate);
    sway_phasor_multiply(&turn, &id->s);
    sway_phasor_t force = measured(id, acc);
    sway_phasor_add_scaled(&force, &turn, NEG(ahead));
    sway_phasor_scale(&force, sway_real_ratio(mass_g, 1000));
    return force;
}

static sway_phasor_t car_inertia_force(const sway_identify_t *id)
{
    const sway_car_t *const car = &id->vehicle->car;
    return inertia_force(id, SWAY_ORIGIN_CAR_YAW_RATE, SWAY_ORIGIN_CAR_ACC,
                         metre(car->lateral_acc_position_um), car->mass_g);
}

static sway_phasor_t trailer_inertia_force(const sway_identify_t *id)
{
    const sway_trailer_t *const trailer = &id->vehicle->trailer;
    return inertia_force(id, SWAY_ORIGIN_TRAILER_YAW_RATE, SWAY_ORIGIN_TRAILER_ACC,
                         metre(trailer->lateral_acc_position_um), trailer->mass_g);
}

static sway_phasor_t yaw_moment(const sway_identify_t *id, sway_origin_t yaw_rate,
                                int32_t inertia_gm2)
{
    sway_phasor_t moment = measured(id, yaw_rate);
    sway_phasor_multiply(&moment, &id->s);
    sway_phasor_scale(&moment, sway_real_ratio(inertia_gm2, 1000));
    return moment;
}

/* Of the trailer against the car. */
static sway_phasor_t articulation_rate(const sway_identify_t *id)
{
    const sway_phasor_t car = measured(id, SWAY_ORIGIN_CAR_YAW_RATE);
    sway_phasor_t rate = measured(id, SWAY_ORIGIN_TRAILER_YAW_RATE);
    sway_phasor_add_scaled(&rate, &car, sway_real_int(-1));
    return rate;
}

/* Lateral part of the pull along the car's axis as the trailer sees it: Fx theta. */
static sway_phasor_t pull_sideways(const sway_identify_t *id)
{
    sway_phasor_t angle = measured(id, SWAY_ORIGIN_ARTICULATION);
    if (!angle.known) {
        angle = articulation_rate(id);
        sway_phasor_divide(&angle, &id->s);
    }
    if (!angle.known || !has_channel(id->line, SWAY_CHANNEL_HITCH_FX)) {
        const sway_complex_t nothing = {{0, 0}, {0, 0}};
        return sway_phasor_constant(nothing);
    }
    sway_phasor_scale(&angle, id->line->channel[SWAY_CHANNEL_HITCH_FX].mean);
    return angle;
}

static sway_phasor_t difference(const sway_phasor_t *a, const sway_phasor_t *b)
{
    sway_phasor_t result = *a;
    sway_phasor_add_scaled(&result, b, sway_real_int(-1));
    return result;
}

static bool measures_force(const sway_identify_t *id, sway_axle_t axle)
{
    return has_channel(id->line, sway_origin_of_channel(FORCE_OF[axle]));
}

static bool car_forces_measured(const sway_identify_t *id)
{
    return SWAY_IDENTIFY_FORCES && measures_force(id, SWAY_AXLE_CAR_FRONT) &&
           measures_force(id, SWAY_AXLE_CAR_REAR);
}

static bool trailer_forces_measured(const sway_identify_t *id)
{
    return SWAY_IDENTIFY_FORCES && measures_force(id, SWAY_AXLE_TRAILER_REAR) &&
           (id->vehicle->trailer.axles == 1 || measures_force(id, SWAY_AXLE_TRAILER_FRONT));
}

/* Weights of the two axles' slips in their shares of a total force. */
typedef struct {
    sway_real_t front;
    sway_real_t rear;
} weights_t;

static weights_t user_weights(const sway_identify_t *id)
{
    const sway_trailer_t *const trailer = &id->vehicle->trailer;
    weights_t weights = {sway_real_int(1), sway_real_int(1)};
    if (trailer->front_cornering_stiffness_n_per_rad != 0 &&
        trailer->rear_cornering_stiffness_n_per_rad != 0) {
        weights.front = sway_real_ratio(trailer->front_cornering_stiffness_n_per_rad, 100000);
        weights.rear = sway_real_ratio(trailer->rear_cornering_stiffness_n_per_rad, 100000);
    }
    return weights;
}

/* Shares of the trailer's axles in `total`: force_f : force_r = w_f slip_f : w_r slip_r. */
static void share_force(const sway_identify_t *id, const sway_phasor_t *total, weights_t weights,
                        sway_phasor_t *front, sway_phasor_t *rear)
{
    sway_phasor_t below = id->axle[SWAY_AXLE_TRAILER_REAR].slip;
    sway_phasor_scale(&below, weights.rear);
    *rear = below;
    sway_phasor_add_scaled(&below, &id->axle[SWAY_AXLE_TRAILER_FRONT].slip, weights.front);
    sway_phasor_multiply(rear, total);
    sway_phasor_divide(rear, &below);
    *front = difference(total, rear);
}

/* Force of the car on the trailer from the trailer's two balances and its user's inertia:
 * (w_f a_f + w_r a_r) c + H = m a and (w_f a_f l_f - w_r a_r l_r) c + H l_h = I s r.
 * Forces of axles that are not computed yet serve as scratch: targets have little stack. */
static void hitch_from_balances(sway_identify_t *id)
{
    const sway_trailer_t *const trailer = &id->vehicle->trailer;
    const weights_t weights = user_weights(id);
    const sway_real_t hitch = metre(trailer->hitch_to_cog_um);
    const sway_real_t b_f = SUB(hitch, metre(trailer->front_axle_to_cog_um));
    const sway_real_t b_r = ADD(hitch, metre(trailer->rear_axle_to_cog_um));
    sway_phasor_t *const sum = &id->axle[SWAY_AXLE_TRAILER_FRONT].force;
    sway_phasor_t *const about_hitch = &id->axle[SWAY_AXLE_TRAILER_REAR].force;
    sway_phasor_t *const total = &id->axle[SWAY_AXLE_CAR_FRONT].force;
    *sum = id->axle[SWAY_AXLE_TRAILER_REAR].slip;
    sway_phasor_scale(sum, weights.rear);
    *about_hitch = *sum;
    sway_phasor_scale(about_hitch, b_r);
    if (trailer->axles == 2) {
        const sway_phasor_t *const front = &id->axle[SWAY_AXLE_TRAILER_FRONT].slip;
        sway_phasor_add_scaled(sum, front, weights.front);
        sway_phasor_add_scaled(about_hitch, front, MUL(weights.front, b_f));
    }
    id->hitch = trailer_inertia_force(id);
    *total = yaw_moment(id, SWAY_ORIGIN_TRAILER_YAW_RATE, trailer->yaw_inertia_gm2);
    sway_phasor_scale(total, sway_real_int(-1));
    sway_phasor_add_scaled(total, &id->hitch, hitch);
    sway_phasor_multiply(total, sum); // c times the sum of weighted slips
    sway_phasor_divide(total, about_hitch);
    sway_phasor_add_scaled(&id->hitch, total, sway_real_int(-1));
}

/* Force of the trailer on the car in car axes, from what is measured at the hitch or on the car. */
static sway_phasor_t hitch_on_car_measured(const sway_identify_t *id)
{
    sway_phasor_t force = measured(id, SWAY_ORIGIN_HITCH_FY);
    if (!force.known && car_forces_measured(id)) {
        const sway_phasor_t front = measured(id, SWAY_ORIGIN_CAR_FRONT_FY);
        const sway_phasor_t rear = measured(id, SWAY_ORIGIN_CAR_REAR_FY);
        force = car_inertia_force(id);
        sway_phasor_add_scaled(&force, &front, sway_real_int(-1));
        sway_phasor_add_scaled(&force, &rear, sway_real_int(-1));
    }
    return force;
}

static void find_hitch(sway_identify_t *id)
{
    if (id->vehicle->trailer.axles == 0) {
        const sway_complex_t nothing = {{0, 0}, {0, 0}};
        id->hitch_on_car = sway_phasor_constant(nothing);
        return;
    }
    const sway_phasor_t pull = pull_sideways(id);
    id->hitch_on_car = hitch_on_car_measured(id);
    if (id->hitch_on_car.known) {
        id->hitch = difference(&pull, &id->hitch_on_car);
        return;
    }
    if (trailer_forces_measured(id)) {
        id->hitch = trailer_inertia_force(id);
        for (int axle = SWAY_AXLE_TRAILER_FRONT; axle <= (int)SWAY_AXLE_TRAILER_REAR; axle++) {
            if (axle == (int)SWAY_AXLE_TRAILER_REAR || id->vehicle->trailer.axles == 2) {
                const sway_phasor_t force = measured(id, FORCE_OF[axle]);
                sway_phasor_add_scaled(&id->hitch, &force, sway_real_int(-1));
            }
        }
    } else {
        hitch_from_balances(id);
        id->quality |= SWAY_QUALITY_USER_INERTIA;
    }
    id->hitch_on_car = difference(&pull, &id->hitch);
}

static void trailer_forces(sway_identify_t *id)
{
    sway_phasor_t *const front = &id->axle[SWAY_AXLE_TRAILER_FRONT].force;
    sway_phasor_t *const rear = &id->axle[SWAY_AXLE_TRAILER_REAR].force;
    *front = sway_phasor_unknown();
    *rear = sway_phasor_unknown();
    if (id->vehicle->trailer.axles == 0) {
        return;
    }
    if (trailer_forces_measured(id)) {
        *front = measured(id, SWAY_ORIGIN_TRAILER_FRONT_FY);
        *rear = measured(id, SWAY_ORIGIN_TRAILER_REAR_FY);
        return;
    }
    const sway_phasor_t inertia = trailer_inertia_force(id);
    const sway_phasor_t total = difference(&inertia, &id->hitch);
    if (id->vehicle->trailer.axles == 1) {
        *rear = total;
        return;
    }
    share_force(id, &total, user_weights(id), front, rear);
    id->quality |= SWAY_QUALITY_EQUAL_SPLIT;
}

static void car_forces(sway_identify_t *id)
{
    const sway_car_t *const car = &id->vehicle->car;
    sway_phasor_t *const front = &id->axle[SWAY_AXLE_CAR_FRONT].force;
    sway_phasor_t *const rear = &id->axle[SWAY_AXLE_CAR_REAR].force;
    if (car_forces_measured(id)) {
        *front = measured(id, SWAY_ORIGIN_CAR_FRONT_FY);
        *rear = measured(id, SWAY_ORIGIN_CAR_REAR_FY);
        return;
    }
    if (car->yaw_inertia_gm2 == 0) {
        *front = sway_phasor_unknown();
        *rear = sway_phasor_unknown();
        return;
    }
    const sway_real_t l_f = metre(car->front_axle_to_cog_um);
    const sway_real_t l_r = metre(car->rear_axle_to_cog_um);
    const sway_real_t by_base = DIV(sway_real_int(1), ADD(l_f, l_r));
    const sway_phasor_t inertia = car_inertia_force(id);
    const sway_phasor_t total = difference(&inertia, &id->hitch_on_car);
    sway_phasor_t moment = yaw_moment(id, SWAY_ORIGIN_CAR_YAW_RATE, car->yaw_inertia_gm2);
    sway_phasor_add_scaled(&moment, &id->hitch_on_car, metre(car->hitch_to_cog_um));
    if (SWAY_IDENTIFY_FORCES && id->rubs) {
        const sway_phasor_t rate = articulation_rate(id);
        sway_phasor_add_scaled(&moment, &rate, NEG(id->damping_nms));
        const sway_real_t unsure = MUL(id->damping_se_nms, sway_complex_abs(rate.value));
        id->unsure_force_n = MUL(unsure, by_base);
    }
    *front = moment;
    sway_phasor_add_scaled(front, &total, l_r);
    sway_phasor_scale(front, by_base);
    *rear = difference(&total, front);
    id->quality |= SWAY_QUALITY_USER_INERTIA;
}

/* --- stiffness, loads ------------------------------------------------------------------------- */

/* Known well enough to be used: error below a half. */
static bool is_certain(const sway_estimate_t *stiffness)
{
    return sway_real_compare(sway_real_scale(stiffness->se, 1),
                             sway_complex_abs(stiffness->value)) <= 0;
}

/* What a tyre can have: an argument below 45 deg, 1 to 5000 kN/rad. */
static bool is_plausible(const sway_estimate_t *stiffness)
{
    const sway_complex_t c = stiffness->value;
    const sway_real_t size = sway_complex_abs(c);
    return sway_real_less(sway_real_abs(c.im), c.re) && sway_real_less(sway_real_int(1000), size) &&
           sway_real_less(size, sway_real_int(5000000));
}

/* No force where there is slip: surely below what a tyre can have. */
static bool is_none(const sway_estimate_t *stiffness)
{
    const sway_real_t most =
        ADD(sway_complex_abs(stiffness->value), sway_real_scale(stiffness->se, 1));
    return sway_real_less(most, sway_real_int(1000));
}

static sway_estimate_t estimate_of(const sway_identify_t *id, const sway_phasor_t *phasor)
{
    const sway_estimate_t estimate = {phasor->value, sway_phasor_se(phasor, &id->sources)};
    return estimate;
}

/* Side wind, banking and the like that a balance takes for tyre force, in the band of the line. */
#define UNSEEN_FORCE_N 100

static bool force_is_derived(const sway_identify_t *id, sway_axle_t axle)
{
    return !(axle <= SWAY_AXLE_CAR_REAR ? car_forces_measured(id) : trailer_forces_measured(id));
}

/* Error of a sum. */
static sway_real_t both(sway_real_t a, sway_real_t b)
{
    return sway_real_sqrt(ADD(MUL(a, a), MUL(b, b)));
}

static void add_unseen_force(sway_estimate_t *stiffness, sway_complex_t slip, sway_real_t force_n)
{
    stiffness->se = both(stiffness->se, DIV(force_n, sway_complex_abs(slip)));
}

static void axle_stiffness(sway_identify_t *id, sway_axle_t axle)
{
    sway_axle_estimate_t *const estimate = &id->axle[axle];
    sway_phasor_t stiffness = estimate->force;
    sway_phasor_divide(&stiffness, &estimate->slip);
    estimate->stiffness = estimate_of(id, &stiffness);
    estimate->derived = force_is_derived(id, axle);
    if (estimate->derived) {
        const bool hitch = has_channel(id->line, SWAY_CHANNEL_HITCH_FY);
        const bool car = axle <= SWAY_AXLE_CAR_REAR;
        add_unseen_force(&estimate->stiffness, estimate->slip.value,
                         !hitch ? sway_real_int(UNSEEN_FORCE_N)
                                : (car ? id->unsure_force_n : sway_real_zero()));
    }
    const bool certain =
        stiffness.known && (is_certain(&estimate->stiffness) || is_none(&estimate->stiffness));
    if (certain && is_plausible(&estimate->stiffness)) {
        id->valid |= (uint32_t)SWAY_VALID_CAR_FRONT << (uint32_t)axle;
    } else if (certain || (estimate->force.known && estimate->slip.known && !stiffness.known)) {
        id->quality |= SWAY_QUALITY_SINGULAR; // no slip to divide by, or no tyre does that
    }
}

/* z turned back by twice the phase of `reference`: z conj(u)^2, u = reference/|reference|; 0 where
 * there is none to turn by. */
static sway_complex_t against_square(sway_complex_t z, sway_complex_t reference)
{
    const sway_complex_t turned =
        sway_complex_mul(sway_complex_conj(reference), sway_complex_conj(reference));
    const sway_real_t norm = sway_complex_norm(reference);
    const sway_complex_t product = sway_complex_mul(z, turned);
    return sway_complex(DIV(product.re, norm), DIV(product.im, norm));
}

/* Force = zeta slip load: at the line the load's 2f part adds half of itself, turned by the slip's
 * phase (4.11-4.13); its sign, and so +90 and -90 deg, is in the phase. */
static void axle_load(sway_identify_t *id, sway_axle_t axle)
{
    const sway_channel_t channel = LOAD_OF[axle];
    sway_axle_estimate_t *const estimate = &id->axle[axle];
    const uint32_t axle_bit = (uint32_t)SWAY_VALID_CAR_FRONT << (uint32_t)axle;
    if (!has_channel(id->line, channel) || (id->valid & axle_bit) == 0U) {
        return;
    }
    const sway_line_channel_t *const load = &id->line->channel[channel];
    estimate->load_n = load->mean;
    estimate->load_harmonic_n = against_square(load->second, estimate->force.value);
    sway_complex_t effective = against_square(load->second, estimate->slip.value);
    effective = sway_complex_scale(effective, sway_real_scale(sway_real_int(1), -1));
    effective.re = ADD(effective.re, load->mean);
    estimate->effective_load_n = sway_complex_abs(effective);
    const sway_real_t mean_variance =
        DIV(MUL(load->noise_rms, load->noise_rms), sway_real_int(id->line->window_samples));
    const sway_real_t half_se = sway_real_scale(load->second_se, -1);
    estimate->effective_load_se_n = sway_real_sqrt(ADD(mean_variance, MUL(half_se, half_se)));
    if (sway_real_sign(load->mean) > 0) {
        id->valid |= (uint32_t)SWAY_VALID_CAR_FRONT_LOAD << (uint32_t)axle;
    }
}

/* --- yaw inertias ----------------------------------------------------------------------------- */

/* Divides by s r of a body. A moment becomes kg m2, real where nothing but the body's inertia takes
 * it up. */
static void over_yaw_acceleration(const sway_identify_t *id, sway_phasor_t *moment,
                                  sway_origin_t yaw_rate)
{
    sway_phasor_t turn = measured(id, yaw_rate);
    sway_phasor_multiply(&turn, &id->s);
    sway_phasor_divide(moment, &turn);
}

/* Marked valid where its error is below a fifth of it. */
static sway_estimate_t inertia_from(sway_identify_t *id, const sway_phasor_t *inertia, uint32_t bit)
{
    const sway_estimate_t estimate = estimate_of(id, inertia);
    const sway_real_t bound = DIV(inertia->value.re, sway_real_int(5));
    if (inertia->known && sway_real_less(estimate.se, bound)) {
        id->valid |= bit;
    }
    return estimate;
}

/* An imaginary part beyond three of its errors is something that acts on the body and is not in its
 * balance: that much the real part may be wrong, too. */
static void add_unexplained(sway_identify_t *id, sway_estimate_t *inertia)
{
    const sway_real_t im = sway_real_abs(inertia->value.im);
    if (sway_real_less(ADD(sway_real_scale(inertia->se, 1), inertia->se), im)) {
        inertia->se = im;
        id->quality |= SWAY_QUALITY_UNEXPLAINED;
    }
    inertia->value.im = sway_real_zero();
}

/* Share of the trailer's inertia that looks like something at the ball and is not (roll, places of
 * sensors): 3 %, as a power of 2. */
#define LOOKS_LIKE_RUBBING (-5)

/* The trailer's inertia without what rubs or damps at the ball. A moment c times the articulation
 * rate looks like an inertia of c g, g = rate / (s r); of the inertia itself only the real part is
 * there, so the imaginary part gives c. That holds for dry friction, too: in a swing it acts like
 * a damper of 4 M / (pi rate), which a larger swing has less of. A moment that drives is not
 * friction. */
static void free_trailer(sway_identify_t *id, sway_phasor_t *inertia)
{
    sway_estimate_t *const freed = &id->freed_inertia[1];
    *freed = id->trailer_inertia;
    sway_phasor_t by = articulation_rate(id);
    over_yaw_acceleration(id, &by, SWAY_ORIGIN_TRAILER_YAW_RATE);
    if (by.known && sway_real_sign(by.value.im) != 0) {
        const sway_real_t by_im = sway_real_abs(by.value.im);
        const sway_real_t c = DIV(inertia->value.im, by.value.im);
        const sway_real_t im = MUL(c, by_im);
        sway_phasor_add_scaled(inertia, &by, NEG(c));
        const sway_estimate_t estimate = estimate_of(id, inertia);
        const sway_real_t like = sway_real_scale(estimate.value.re, LOOKS_LIKE_RUBBING);
        if (sway_real_less(ADD(sway_real_scale(estimate.se, 1), like), im)) {
            id->quality |= SWAY_QUALITY_HITCH;
        }
        if (sway_real_less(NEG(sway_real_scale(estimate.se, 1)), im)) {
            id->rubs = true;
            id->damping_nms = c;
            id->damping_se_nms = DIV(estimate.se, by_im);
            /* What is left is real; its error is that of both parts. */
            freed->value = estimate.value;
            freed->se = MUL(id->damping_se_nms, sway_complex_abs(by.value));
        }
    }
    add_unexplained(id, freed);
}

/* The car's, with the trailer's c. */
static void free_car(sway_identify_t *id, sway_phasor_t *inertia)
{
    sway_estimate_t *const freed = &id->freed_inertia[0];
    *freed = id->car_inertia;
    if (id->rubs) {
        sway_phasor_t by = articulation_rate(id);
        over_yaw_acceleration(id, &by, SWAY_ORIGIN_CAR_YAW_RATE);
        sway_phasor_add_scaled(inertia, &by, id->damping_nms);
        *freed = estimate_of(id, inertia);
        const sway_real_t unsure = MUL(id->damping_se_nms, sway_complex_abs(by.value));
        freed->se = both(freed->se, unsure);
    }
    add_unexplained(id, freed);
}

static void car_inertia(sway_identify_t *id)
{
    const sway_car_t *const car = &id->vehicle->car;
    if (!car_forces_measured(id)) {
        return;
    }
    sway_phasor_t moment = id->axle[SWAY_AXLE_CAR_FRONT].force;
    sway_phasor_scale(&moment, metre(car->front_axle_to_cog_um));
    sway_phasor_add_scaled(&moment, &id->axle[SWAY_AXLE_CAR_REAR].force,
                           metre(-car->rear_axle_to_cog_um));
    sway_phasor_add_scaled(&moment, &id->hitch_on_car, metre(-car->hitch_to_cog_um));
    over_yaw_acceleration(id, &moment, SWAY_ORIGIN_CAR_YAW_RATE);
    id->car_inertia = inertia_from(id, &moment, SWAY_VALID_CAR_INERTIA);
    free_car(id, &moment);
}

/* With these forces of the axles. */
static sway_phasor_t trailer_inertia_with(const sway_identify_t *id, const sway_phasor_t *front,
                                          const sway_phasor_t *rear)
{
    const sway_trailer_t *const trailer = &id->vehicle->trailer;
    sway_phasor_t moment = id->hitch;
    sway_phasor_scale(&moment, metre(trailer->hitch_to_cog_um));
    sway_phasor_add_scaled(&moment, rear, metre(-trailer->rear_axle_to_cog_um));
    if (trailer->axles == 2) {
        sway_phasor_add_scaled(&moment, front, metre(trailer->front_axle_to_cog_um));
    }
    over_yaw_acceleration(id, &moment, SWAY_ORIGIN_TRAILER_YAW_RATE);
    return moment;
}

/* The hitch force was made with the user's inertia: it cannot give it back. */
static bool trailer_inertia_is_open(const sway_identify_t *id)
{
    return SWAY_IDENTIFY_FORCES && id->vehicle->trailer.axles > 0 &&
           (has_channel(id->line, SWAY_CHANNEL_HITCH_FY) || car_forces_measured(id) ||
            trailer_forces_measured(id));
}

static void trailer_inertia(sway_identify_t *id)
{
    if (trailer_inertia_is_open(id)) {
        sway_phasor_t inertia = trailer_inertia_with(id, &id->axle[SWAY_AXLE_TRAILER_FRONT].force,
                                                     &id->axle[SWAY_AXLE_TRAILER_REAR].force);
        id->trailer_inertia = inertia_from(id, &inertia, SWAY_VALID_TRAILER_INERTIA);
        free_trailer(id, &inertia);
    }
}

static sway_phasor_t trailer_total(const sway_identify_t *id)
{
    const sway_phasor_t inertia = trailer_inertia_force(id);
    return difference(&inertia, &id->hitch);
}

static void trailer_inertia_method_1(sway_identify_t *id)
{
    if (trailer_inertia_is_open(id) && id->vehicle->trailer.axles == 2) {
        sway_phasor_t half = trailer_total(id);
        sway_phasor_scale(&half, sway_real_scale(sway_real_int(1), -1));
        const sway_phasor_t inertia = trailer_inertia_with(id, &half, &half);
        id->trailer_inertia_1 = inertia_from(id, &inertia, SWAY_VALID_TRAILER_INERTIA_1);
    }
}

static void trailer_inertia_method_2(sway_identify_t *id)
{
    if (trailer_inertia_is_open(id) && id->vehicle->trailer.axles == 2) {
        const weights_t static_loads = {metre(id->vehicle->trailer.rear_axle_to_cog_um),
                                        metre(id->vehicle->trailer.front_axle_to_cog_um)};
        const sway_phasor_t total = trailer_total(id);
        sway_phasor_t front;
        sway_phasor_t rear;
        share_force(id, &total, static_loads, &front, &rear);
        const sway_phasor_t inertia = trailer_inertia_with(id, &front, &rear);
        id->trailer_inertia_2 = inertia_from(id, &inertia, SWAY_VALID_TRAILER_INERTIA_2);
    }
}

static void axle_step(sway_identify_t *id, int step)
{
    const sway_axle_t axle = (sway_axle_t)(step / 2);
    if (step % 2 == 0) {
        axle_stiffness(id, axle);
    } else {
        axle_load(id, axle);
    }
}

static const struct {
    void (*run)(sway_identify_t *);
    uint8_t cost; // about, see SWAY_SLICE_COST
} STEPS[] = {
    {car_slips, 27},
    {trailer_slips, 25},
    {find_hitch, 44},
    {trailer_forces, 40},
    {trailer_inertia, 44},
    {car_forces, 40},
    {car_inertia, 44},
    {trailer_inertia_method_1, 44},
    {trailer_inertia_method_2, 44},
};

#define COST_STIFFNESS 25
#define COST_LOAD 25

enum { STEP_COUNT = sizeof STEPS / sizeof STEPS[0], ALL = STEP_COUNT + 2 * SWAY_AXLE_COUNT };

uint32_t sway_identify_cost(const sway_identify_t *id)
{
    if (id->step < STEP_COUNT) {
        return STEPS[id->step].cost;
    }
    return (id->step - STEP_COUNT) % 2 == 0 ? COST_STIFFNESS : COST_LOAD;
}

bool sway_identify_run(sway_identify_t *id)
{
    if (id->step < STEP_COUNT) {
        STEPS[id->step].run(id);
    } else if (id->step < ALL) {
        axle_step(id, id->step - STEP_COUNT);
    }
    if (id->step < ALL) {
        id->step++;
    }
    return id->step < ALL;
}

// SPDX-License-Identifier: MIT
#include "model/sway_trailer.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* Below this the slips are large and the single-track model is not meant. mm/s */
#define SPEED_LOW_MM_S 8000

/* Time between two samples of the observers. */
#define SAMPLE_US 40000

/* What a car's missing physics lets a trailer win with each sample, in 1/1000 nat; samples that
 * tell the same; bounds of the evidence, and where it decides (odds of 1 to 22,000), x 1. */
#define TOLL_MILLI 400
#define ALIKE 2
#define EVIDENCE_MOST 30
#define EVIDENCE_SURE 10

/* Steering speaks, wind and road do not: lateral acceleration, mean square, that the steering asks
 * for (speed squared times angle by wheelbase). From the first on every sample counts fully for the
 * parameters, from the second on for a trailer, from the third on against one: a trailer hardly
 * shows in gentle driving. (m/s2)^2 x 100 */
#define LEARNING_POWER_PERCENT 30
#define THERE_POWER_PERCENT 50
#define NONE_POWER_PERCENT 150

/* Of what the samples tell of the parameters an eighth counts while the driver steers, else in
 * proportion to that square: errors of model and road last for as many samples (measured:
 * normalised squared errors of the parameters, over drawn vehicles and drives, are then 1 to 2).
 * Beyond the linear range it is less by the square of the acceleration's mean square: so grows the
 * variance of what the assumed tyre curve is wrong by, and that error lasts, too. */
#define LEARNING_SHIFT 3

/* More than this of it does not count, that a hard swerve is over after 4 s, too. (m/s2)^2 */
#define STEERING_POWER_MOST 4

/* Innovations squared over their variance, above which a model proves nothing. */
#define UNFIT_MOST 16

/* Standard errors of a user's values: stiffness 8 %, inertia 10 %, mass 3 %, lengths 5 cm (by about
 * 4 m), axle 5 cm; of the car's stiffness where it is not known; of typical values. */
enum { SURE_STIFFNESS = 80000, SURE_INERTIA = 100000, SURE_MASS = 30000, SURE_LENGTH = 15000 };
enum { SURE_PLACE = 50000, OPEN_STIFFNESS = 350000, FRICTION_SE = 1000000 };

static const struct {
    int32_t sure_ppm;
    int32_t open_ppm;
} UNCERTAINTY[SWAY_TRAILER_UNKNOWNS] = {
    {SURE_MASS, 400000},      {SURE_LENGTH, 270000}, {SURE_INERTIA, 300000},
    {SURE_STIFFNESS, 280000}, {SURE_PLACE, 120000},  {FRICTION_SE, FRICTION_SE},
};

/* Typical: stiffness 13 times the load, mass of the trailer by the car's, length, I / (m l^2), 12.5
 * times the load, axle behind the centre of gravity; the ball behind the rear axle. */
#define TYPICAL_BY_LOAD 13
#define TYPICAL_MASS_PPM 800000
#define TYPICAL_LENGTH_UM 4300000
#define TYPICAL_GYRATION_PPM 220000
#define TYPICAL_STIFFNESS_PPM 12500000
#define TYPICAL_AXLE_UM 180000
#define TYPICAL_OVERHANG_UM 1000000
#define RELAXATION_UM 300000
#define RELAXATION_SE_UM 150000

/* What the single-track model leaves out (roll, air, lags) in the critical speed, at the least. */
#define MODEL_FLOOR_PPM 13000

/* Derivatives that are renewed each time, after the first. */
#define TURN 3

/* A model whose critical speed is less certain than the first is no evidence of the damping, and
 * raises no notice. Less certain than the second it is not given: more than half of the variance
 * that a trailer of typical values starts with (about 0.35 squared) is still there. */
#define EVIDENCE_PPM 150000
#define REPORTED_PPM 250000

/* Step of the differences. */
#define DIFFERENCE (-9)

enum { ROOT_SWEEPS_MAX = 30 };

static const uint8_t PARAMETER[SWAY_TRAILER_PARAMETERS] = {
    SWAY_STATE_CAR_FRONT,        SWAY_STATE_CAR_REAR,          SWAY_STATE_CAR_INERTIA,
    SWAY_STATE_CAR_COG,          SWAY_STATE_TRAILER_MASS,      SWAY_STATE_TRAILER_LENGTH,
    SWAY_STATE_TRAILER_GYRATION, SWAY_STATE_TRAILER_STIFFNESS, SWAY_STATE_TRAILER_AXLE,
    SWAY_STATE_RELAXATION,
};

/* The last of them has derivatives of its own. */
#define STIFF_PARAMETERS (SWAY_TRAILER_PARAMETERS - 1)

static sway_real_t micro(int64_t value)
{
    return sway_real_micro(value);
}

/* --- start ------------------------------------------------------------------------------------ */

static sway_real_t load_share(const sway_car_t *car, int32_t other_um)
{
    const int32_t base = car->front_axle_to_cog_um + car->rear_axle_to_cog_um;
    const sway_real_t weight = MUL(sway_real_ratio(car->mass_g, 1000), sway_real_ratio(981, 100));
    return MUL(weight, sway_real_ratio(other_um, base));
}

static sway_real_t stiffness_of(int32_t believed, sway_real_t load)
{
    return believed != 0 ? sway_real_int(believed) : MUL(load, sway_real_int(TYPICAL_BY_LOAD));
}

static void set_car(sway_observer_car_t *to, const sway_vehicle_t *vehicle, int32_t rows_us)
{
    const sway_car_t *const car = &vehicle->car;
    const int32_t hitch = car->hitch_to_cog_um != 0
                              ? car->hitch_to_cog_um
                              : car->rear_axle_to_cog_um + TYPICAL_OVERHANG_UM;
    memset(to, 0, sizeof *to);
    to->mass_kg = sway_real_ratio(car->mass_g, 1000);
    to->front_m = micro(car->front_axle_to_cog_um);
    to->rear_m = micro(car->rear_axle_to_cog_um);
    to->hitch_m = micro(hitch);
    to->front_n_per_rad = stiffness_of(car->front_cornering_stiffness_n_per_rad,
                                       load_share(car, car->rear_axle_to_cog_um));
    to->rear_n_per_rad = stiffness_of(car->rear_cornering_stiffness_n_per_rad,
                                      load_share(car, car->front_axle_to_cog_um));
    to->inertia_kgm2 = car->yaw_inertia_gm2 != 0 ? sway_real_ratio(car->yaw_inertia_gm2, 1000)
                                                 : MUL(to->mass_kg, MUL(to->front_m, to->rear_m));
    to->ratio = sway_real_ratio(1000, car->steering_ratio_milli);
    to->acc_m = micro(car->lateral_acc_position_um);
    to->peak_n[0] = load_share(car, car->rear_axle_to_cog_um);
    to->peak_n[1] = load_share(car, car->front_axle_to_cog_um);
    to->step_s = micro(rows_us);
    if (vehicle->trailer.axles == 2) {
        to->half_tandem_m = sway_real_scale(micro((int64_t)vehicle->trailer.front_axle_to_cog_um +
                                                  vehicle->trailer.rear_axle_to_cog_um),
                                            -1);
    }
}

static void set_car_start(sway_observer_start_t *start, const sway_car_t *car)
{
    memset(start, 0, sizeof *start);
    start->se[SWAY_STATE_YAW_RATE_OFFSET] = micro(10000);
    start->se[SWAY_STATE_ACC_OFFSET] = micro(300000);
    start->se[SWAY_STATE_STEERING_OFFSET] = micro(50000);
    start->se[SWAY_STATE_CAR_FRONT] =
        micro(car->front_cornering_stiffness_n_per_rad != 0 ? SURE_STIFFNESS : OPEN_STIFFNESS);
    start->se[SWAY_STATE_CAR_REAR] =
        micro(car->rear_cornering_stiffness_n_per_rad != 0 ? SURE_STIFFNESS : OPEN_STIFFNESS);
    start->se[SWAY_STATE_CAR_INERTIA] = micro(SURE_INERTIA);
    start->se[SWAY_STATE_CAR_COG] = micro(SURE_PLACE);
    start->value[SWAY_STATE_RELAXATION] = micro(RELAXATION_UM);
    start->se[SWAY_STATE_RELAXATION] = micro(RELAXATION_SE_UM);
}

static void set_typical(sway_observer_start_t *start, const sway_car_t *car)
{
    sway_real_t *const x = start->value;
    x[SWAY_STATE_TRAILER_MASS] =
        sway_real_ln(MUL(sway_real_ratio(car->mass_g, 1000), micro(TYPICAL_MASS_PPM)));
    x[SWAY_STATE_TRAILER_LENGTH] = sway_real_ln(micro(TYPICAL_LENGTH_UM));
    x[SWAY_STATE_TRAILER_GYRATION] = sway_real_ln(micro(TYPICAL_GYRATION_PPM));
    x[SWAY_STATE_TRAILER_STIFFNESS] = sway_real_ln(micro(TYPICAL_STIFFNESS_PPM));
    x[SWAY_STATE_TRAILER_AXLE] = micro(TYPICAL_AXLE_UM);
}

/* The user's trailer; a tandem as one axle in the middle of its forces. */
static void set_believed(sway_observer_start_t *start, const sway_vehicle_t *vehicle)
{
    const sway_trailer_t *const trailer = &vehicle->trailer;
    sway_real_t *const x = start->value;
    const sway_real_t mass = sway_real_ratio(trailer->mass_g, 1000);
    const sway_real_t length = micro(trailer->hitch_to_cog_um);
    const sway_real_t square = MUL(mass, sway_real_square(length));
    const bool tandem = trailer->axles == 2;
    int32_t front = tandem ? trailer->front_cornering_stiffness_n_per_rad : 0;
    int32_t rear = trailer->rear_cornering_stiffness_n_per_rad;
    x[SWAY_STATE_TRAILER_MASS] = sway_real_ln(mass);
    x[SWAY_STATE_TRAILER_LENGTH] = sway_real_ln(length);
    x[SWAY_STATE_TRAILER_GYRATION] =
        sway_real_ln(DIV(sway_real_ratio(trailer->yaw_inertia_gm2, 1000), square));
    if (rear != 0 && (!tandem || front != 0)) {
        const sway_real_t weight = MUL(mass, sway_real_ratio(981, 100));
        x[SWAY_STATE_TRAILER_STIFFNESS] = sway_real_ln(DIV(sway_real_int(front + rear), weight));
    } else {
        front = tandem ? 1 : 0;
        rear = 1;
    }
    const sway_real_t ahead = MUL(micro(trailer->front_axle_to_cog_um), sway_real_int(front));
    const sway_real_t behind = MUL(micro(trailer->rear_axle_to_cog_um), sway_real_int(rear));
    x[SWAY_STATE_TRAILER_AXLE] = DIV(SUB(behind, ahead), sway_real_int(front + rear));
}

static uint32_t open_values(const sway_vehicle_t *vehicle, uint32_t assumed)
{
    const sway_trailer_t *const trailer = &vehicle->trailer;
    if (trailer->axles == 0) {
        return UINT32_MAX;
    }
    const bool stiff = trailer->rear_cornering_stiffness_n_per_rad != 0 &&
                       (trailer->axles == 1 || trailer->front_cornering_stiffness_n_per_rad != 0);
    const uint32_t bit = 1U << (SWAY_STATE_TRAILER_STIFFNESS - SWAY_STATE_TRAILER_MASS);
    return assumed | (stiff ? 0U : bit);
}

void sway_trailer_init(sway_trailer_watch_t *trailer, const sway_vehicle_t *vehicle,
                       uint32_t assumed, int32_t sample_period_us)
{
    sway_observer_car_t car;
    sway_observer_start_t start;
    memset(trailer, 0, sizeof *trailer);
    trailer->configured = vehicle->trailer.axles > 0;
    trailer->rows_due = (uint8_t)(SAMPLE_US / sample_period_us);
    set_car(&car, vehicle, (int32_t)trailer->rows_due * sample_period_us);
    set_car_start(&start, &vehicle->car);
    set_typical(&start, &vehicle->car);
    if (trailer->configured) {
        set_believed(&start, vehicle);
    }
    const uint32_t open = open_values(vehicle, assumed);
    for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
        start.se[SWAY_STATE_TRAILER_MASS + i] =
            micro((open & (1U << i)) != 0U ? UNCERTAINTY[i].open_ppm : UNCERTAINTY[i].sure_ppm);
    }
    for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
        trailer->start[i] = start.value[SWAY_STATE_TRAILER_MASS + i];
        trailer->start_error[i] = start.se[SWAY_STATE_TRAILER_MASS + i];
    }
    sway_observer_init(&trailer->alone, &car, &start, SWAY_STATE_SOLO);
    sway_observer_init(&trailer->with, &car, &start, SWAY_STATE_COUNT);
}

/* --- samples ---------------------------------------------------------------------------------- */

static const uint8_t CHANNEL[4] = {SWAY_CHANNEL_STEERING_WHEEL_ANGLE, SWAY_CHANNEL_SPEED,
                                   SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_CAR_LATERAL_ACC};
#define OWN_MASK                                                                                   \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED) |  \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) | SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC))
#define TRAILER_MASK                                                                               \
    (SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE) |                                             \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_LATERAL_ACC) |                                          \
     SWAY_CHANNEL_BIT(SWAY_CHANNEL_ARTICULATION))

static void pause(sway_trailer_watch_t *trailer)
{
    sway_observer_pause(&trailer->alone);
    sway_observer_pause(&trailer->with);
    trailer->busy[0] = false;
    trailer->busy[1] = false;
    trailer->rows = 0;
    memset(trailer->sum, 0, sizeof trailer->sum);
}

static void follow(const sway_trailer_watch_t *trailer, sway_real_t *mean, sway_real_t now)
{
    const sway_real_t share = sway_real_scale(trailer->with.car.step_s, -1);
    *mean = ADD(*mean, MUL(share, SUB(now, *mean)));
}

/* How much the driver steers: the lateral acceleration asked for, its two-second mean square. What
 * is to be learnt for it. */
static sway_real_t find_steering(sway_trailer_watch_t *trailer, const sway_observer_sample_t *now)
{
    const sway_observer_t *const with = &trailer->with;
    const sway_real_t base = ADD(with->car.front_m, with->car.rear_m);
    const sway_real_t steer = DIV(MUL(now->steering_wheel_rad, with->car.ratio), base);
    const sway_real_t asked = MUL(steer, sway_real_square(now->speed_m_s));
    follow(trailer, &trailer->asked, asked);
    const sway_real_t square = sway_real_min(sway_real_square(SUB(asked, trailer->asked)),
                                             sway_real_int(STEERING_POWER_MOST));
    follow(trailer, &trailer->steering, square);
    const sway_real_t share = DIV(trailer->steering, sway_real_ratio(LEARNING_POWER_PERCENT, 100));
    const sway_real_t part =
        sway_real_scale(sway_real_min(share, sway_real_int(1)), -LEARNING_SHIFT);
    return DIV(part, sway_observer_beyond_linear(with));
}

static void take_sample(sway_trailer_watch_t *trailer)
{
    sway_real_t mean[4];
    for (uint32_t i = 0; i < 4U; i++) {
        mean[i] = DIV(micro(trailer->sum[i]), sway_real_int(trailer->rows_due));
        trailer->sum[i] = 0;
    }
    const sway_observer_sample_t sample = {mean[0], MUL(mean[1], sway_real_int(1000)), mean[2],
                                           mean[3]};
    trailer->rows = 0;
    trailer->with.learning = find_steering(trailer, &sample);
    trailer->alone.learning = trailer->with.learning;
    trailer->alone.road = trailer->with.road; // both are asked beside the same road
    sway_observer_take(&trailer->alone, &sample);
    sway_observer_take(&trailer->with, &sample);
    trailer->busy[0] = sway_observer_cost(&trailer->alone) != 0U;
    trailer->busy[1] = sway_observer_cost(&trailer->with) != 0U;
    trailer->learnt_ms += trailer->learnt_ms < INT32_MAX / 2 ? SAMPLE_US / 1000 : 0;
}

void sway_trailer_push(sway_trailer_watch_t *trailer, const sway_row_t *row)
{
    trailer->sensed = trailer->sensed || (row->valid_mask & TRAILER_MASK) != 0U;
    const bool whole = (row->valid_mask & OWN_MASK) == OWN_MASK;
    if (trailer->sensed || !whole || row->restart ||
        row->value[SWAY_CHANNEL_SPEED] < SPEED_LOW_MM_S) {
        pause(trailer);
        return;
    }
    for (uint32_t i = 0; i < 4U; i++) {
        trailer->sum[i] += row->value[CHANNEL[i]];
    }
    trailer->rows++;
    if (trailer->rows >= trailer->rows_due) {
        while (sway_trailer_cost(trailer) != 0U) { // where slices were too few for the last one
            sway_trailer_run(trailer);
        }
        take_sample(trailer);
    }
}

/* --- is it there? ----------------------------------------------------------------------------- */

static void weigh(sway_trailer_watch_t *trailer)
{
    const sway_real_t gain = SUB(trailer->with.log_likelihood, trailer->alone.log_likelihood);
    const sway_real_t most = sway_real_int(EVIDENCE_MOST);
    const sway_real_t *const unfit = trailer->with.unfit;
    const sway_real_t surprise = sway_real_max(unfit[0], unfit[1]);
    follow(trailer, &trailer->net, SUB(gain, sway_real_ratio(TOLL_MILLI, 1000)));
    sway_real_t step = DIV(trailer->net, sway_real_int(ALIKE));
    const int32_t least = sway_real_sign(step) > 0 ? THERE_POWER_PERCENT : NONE_POWER_PERCENT;
    if (sway_real_less(trailer->steering, sway_real_ratio(least, 100)) ||
        sway_real_less(sway_real_int(UNFIT_MOST), surprise)) {
        step = sway_real_zero();
    }
    trailer->evidence = sway_real_max(sway_real_min(ADD(trailer->evidence, step), most), NEG(most));
    if (sway_real_compare(trailer->evidence, sway_real_int(EVIDENCE_SURE)) >= 0) {
        trailer->presence = SWAY_TRAILER_THERE;
    } else if (sway_real_compare(trailer->evidence, sway_real_int(-EVIDENCE_SURE)) <= 0) {
        trailer->presence = SWAY_TRAILER_NONE;
    } else if ((trailer->presence == SWAY_TRAILER_THERE) !=
               (sway_real_sign(trailer->evidence) > 0)) {
        trailer->presence = SWAY_TRAILER_UNDECIDED; // it has turned round
    }
}

uint32_t sway_trailer_cost(const sway_trailer_watch_t *trailer)
{
    if (trailer->busy[0]) {
        return sway_observer_cost(&trailer->alone);
    }
    return trailer->busy[1] ? sway_observer_cost(&trailer->with) : 0U;
}

void sway_trailer_run(sway_trailer_watch_t *trailer)
{
    const uint32_t which = trailer->busy[0] ? 0U : 1U;
    sway_observer_t *const observer = which == 0U ? &trailer->alone : &trailer->with;
    if (!trailer->busy[which]) {
        return;
    }
    sway_observer_run(observer);
    trailer->busy[which] = sway_observer_cost(observer) != 0U;
    if (which == 1U && !trailer->busy[1]) {
        weigh(trailer);
    }
}

bool sway_trailer_speaks(const sway_trailer_watch_t *trailer)
{
    const bool believed = trailer->configured ? trailer->presence != SWAY_TRAILER_NONE
                                              : trailer->presence == SWAY_TRAILER_THERE;
    return !trailer->sensed && believed && trailer->learnt_ms > 0;
}

/* --- the model -------------------------------------------------------------------------------- */

void sway_trailer_model_start(sway_trailer_watch_t *trailer, sway_real_t speed_m_s)
{
    memset(&trailer->next, 0, sizeof trailer->next);
    trailer->speed_m_s = speed_m_s;
    trailer->step = 0;
    trailer->count = 0;
}

static bool step_limit(sway_trailer_watch_t *trailer)
{
    sway_margin_model_t *const next = &trailer->next;
    sway_observer_body_t body;
    sway_observer_body(&trailer->with, &body);
    sway_observer_model(&trailer->with, &body, &trailer->stm);
    next->kind =
        sway_single_track_critical_speed(&trailer->stm, &next->v_crit_m_s, &next->omega_crit_rad_s);
    next->has_steady =
        sway_single_track_steady_state(&trailer->stm, trailer->speed_m_s, &next->steady) == SWAY_OK;
    trailer->quartic = sway_single_track_quartic(&trailer->stm, trailer->speed_m_s);
    sway_single_track_roots_start(&trailer->roots, &trailer->quartic);
    return true;
}

static bool step_roots(sway_trailer_watch_t *trailer)
{
    const bool settled = sway_single_track_roots_sweep(&trailer->roots, &trailer->quartic);
    if (!settled && trailer->count < ROOT_SWEEPS_MAX) {
        return false;
    }
    trailer->next.root = sway_single_track_dominant(&trailer->roots);
    trailer->next.has_model = settled;
    return true;
}

static bool step_slope(sway_trailer_watch_t *trailer)
{
    return sway_single_track_slope_s(&trailer->stm, trailer->next.root, trailer->speed_m_s,
                                     trailer->count, &trailer->f_s);
}

/* What one parameter does to the critical speed and to the damping ratio. */
static bool step_derivative(sway_trailer_watch_t *trailer)
{
    const uint32_t many = trailer->complete ? TURN : STIFF_PARAMETERS;
    const uint32_t which = ((uint32_t)trailer->turn + trailer->count) % STIFF_PARAMETERS;
    const sway_real_t step = sway_real_scale(sway_real_int(1), DIFFERENCE);
    sway_observer_body_t body;
    sway_single_track_t moved;
    sway_real_t v;
    sway_real_t omega;
    if (trailer->count >= many) {
        trailer->turn = (uint8_t)((trailer->turn + many) % STIFF_PARAMETERS);
        trailer->complete = true;
        return true;
    }
    sway_observer_body(&trailer->with, &body);
    sway_observer_move(&body, (sway_state_t)PARAMETER[which], step);
    sway_observer_model(&trailer->with, &body, &moved);
    const sway_vcrit_t kind = sway_single_track_critical_speed(&moved, &v, &omega);
    if (kind == trailer->next.kind) {
        trailer->limit_by[which] = sway_real_scale(SUB(v, trailer->next.v_crit_m_s), -DIFFERENCE);
    }
    const sway_complex_t df =
        sway_single_track_characteristic(&moved, trailer->next.root, trailer->speed_m_s);
    const sway_complex_t ds = sway_complex_div(df, trailer->f_s);
    trailer->ratio_by[which] =
        sway_real_scale(sway_single_track_damping_change(trailer->next.root, ds), -DIFFERENCE);
    trailer->ratio_by[which] = NEG(trailer->ratio_by[which]);
    return false;
}

/* --- tyres that lag: in proportion to their relaxation length --------------------------------- */

static sway_real_t share_of(const sway_trailer_watch_t *trailer)
{
    return DIV(trailer->with.x[SWAY_STATE_RELAXATION], micro(RELAXATION_UM));
}

/* The model has lags from here on, until the next one begins. */
static bool step_late_root(sway_trailer_watch_t *trailer)
{
    sway_margin_model_t *const next = &trailer->next;
    for (uint32_t i = 0; i < 4U; i++) {
        trailer->stm.body[i / 2U].relaxation_m[i % 2U] = micro(RELAXATION_UM);
    }
    const sway_complex_t f =
        sway_single_track_characteristic(&trailer->stm, next->root, trailer->speed_m_s);
    const sway_complex_t ds = sway_complex_div(f, trailer->f_s);
    trailer->ratio_by[STIFF_PARAMETERS] =
        DIV(NEG(sway_single_track_damping_change(next->root, ds)), micro(RELAXATION_UM));
    next->root = sway_complex_sub(next->root, sway_complex_scale(ds, share_of(trailer)));
    next->damping_ratio = sway_single_track_damping_ratio(next->root);
    return true;
}

static sway_complex_t at_limit(const sway_trailer_watch_t *trailer)
{
    const sway_complex_t s = {sway_real_zero(), trailer->next.omega_crit_rad_s};
    return s;
}

static bool step_late_slope_s(sway_trailer_watch_t *trailer)
{
    return sway_single_track_slope_s(&trailer->stm, at_limit(trailer), trailer->next.v_crit_m_s,
                                     trailer->count, &trailer->f_s);
}

static bool step_late_slope_v(sway_trailer_watch_t *trailer)
{
    return sway_single_track_slope_v(&trailer->stm, at_limit(trailer), trailer->next.v_crit_m_s,
                                     trailer->count, &trailer->f_v);
}

/* Lags move an oscillatory limit only; two steps of Newton with the same slopes. 0.3 m lower it by
 * 3.5 %. */
static bool step_late_limit(sway_trailer_watch_t *trailer)
{
    sway_margin_model_t *const next = &trailer->next;
    sway_real_t *const by = &trailer->limit_by[STIFF_PARAMETERS];
    sway_real_t d_omega = sway_real_zero();
    sway_real_t d_v = sway_real_zero();
    if (trailer->count == 0U) {
        *by = sway_real_zero();
    }
    if (next->kind != SWAY_VCRIT_FOUND) {
        return true;
    }
    const sway_real_t low = sway_single_track_speed_low();
    const sway_real_t v = sway_real_max(ADD(next->v_crit_m_s, *by), low);
    const sway_complex_t f = sway_single_track_characteristic(&trailer->stm, at_limit(trailer), v);
    (void)sway_single_track_shift(trailer->f_s, trailer->f_v, f, &d_omega, &d_v);
    next->omega_crit_rad_s = ADD(next->omega_crit_rad_s, d_omega);
    *by = ADD(*by, d_v);
    if (trailer->count == 0U) {
        return false;
    }
    next->v_crit_m_s = sway_real_max(ADD(next->v_crit_m_s, MUL(*by, share_of(trailer))), low);
    *by = DIV(*by, micro(RELAXATION_UM));
    return true;
}

/* --- errors ----------------------------------------------------------------------------------- */

/* Variance of a sum of states, each with its weight. */
static sway_real_t variance_of(const sway_observer_t *observer, const uint8_t *state,
                               const sway_real_t *weight, uint32_t n)
{
    sway_real_t sum = sway_real_zero();
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t j = 0; j < n; j++) {
            const sway_real_t both = sway_observer_covariance(observer, state[i], state[j]);
            sum = ADD(sum, MUL(MUL(weight[i], weight[j]), both));
        }
    }
    return sway_real_max(sum, sway_real_zero());
}

static sway_real_t spread(const sway_trailer_watch_t *trailer, const sway_real_t *by)
{
    return variance_of(&trailer->with, PARAMETER, by, SWAY_TRAILER_PARAMETERS);
}

/* The user's until half of the uncertainty is gone. */
static sway_source_t source_of(const sway_trailer_watch_t *trailer, sway_real_t se)
{
    const sway_real_t left = MUL(trailer->start_se, sway_real_ratio(8, 10));
    if (sway_real_less(se, sway_real_scale(trailer->start_se, -1))) {
        return SWAY_SOURCE_IDENTIFIED;
    }
    return sway_real_less(se, left) ? SWAY_SOURCE_PARTLY : SWAY_SOURCE_USER;
}

static bool step_errors(sway_trailer_watch_t *trailer)
{
    sway_margin_model_t *const next = &trailer->next;
    const sway_real_t limit = spread(trailer, trailer->limit_by);
    const sway_real_t ratio = spread(trailer, trailer->ratio_by);
    const sway_real_t floor = sway_real_square(MUL(next->v_crit_m_s, micro(MODEL_FLOOR_PPM)));
    if (sway_real_is_zero(trailer->start_se)) {
        trailer->start_se = sway_real_sqrt(limit);
    }
    next->source = source_of(trailer, sway_real_sqrt(limit));
    next->v_crit_se_m_s = sway_real_sqrt(ADD(floor, limit));
    next->damping_ratio_se = sway_real_sqrt(ratio);
    next->vague = sway_real_less(MUL(next->v_crit_m_s, micro(EVIDENCE_PPM)), next->v_crit_se_m_s);
    next->has_model = next->has_model && !next->vague;
    if (sway_real_less(MUL(next->v_crit_m_s, micro(REPORTED_PPM)), next->v_crit_se_m_s)) {
        next->kind = SWAY_VCRIT_NONE;
    }
    trailer->model = *next;
    trailer->has_model = true;
    return true;
}

typedef bool step_t(sway_trailer_watch_t *trailer);

static const struct {
    step_t *run;
    uint8_t cost;
} STEPS[] = {{step_limit, 60},        {step_roots, 30},      {step_slope, 40},
             {step_derivative, 60},   {step_late_root, 40},  {step_late_slope_s, 40},
             {step_late_slope_v, 40}, {step_late_limit, 50}, {step_errors, 50}};
enum { STEP_COUNT = sizeof STEPS / sizeof STEPS[0] };

uint32_t sway_trailer_model_cost(const sway_trailer_watch_t *trailer)
{
    return trailer->step < STEP_COUNT ? STEPS[trailer->step].cost : 1U;
}

bool sway_trailer_model_run(sway_trailer_watch_t *trailer)
{
    if (trailer->step >= STEP_COUNT) {
        return false;
    }
    if (STEPS[trailer->step].run(trailer)) {
        trailer->step++;
        trailer->count = 0;
    } else {
        trailer->count++;
    }
    return trailer->step < STEP_COUNT;
}

/* --- what it says ----------------------------------------------------------------------------- */

/* With the ball's acceleration a_h the trailer turns with r2 = (m h s + K / v) a_h / Q(s, v). */
sway_real_t sway_trailer_swing(const sway_trailer_watch_t *trailer, const sway_line_t *line)
{
    const sway_observer_car_t *const car = &trailer->with.car;
    const sway_complex_t s = {line->growth_1_s, line->omega_rad_s};
    const sway_complex_t yaw = line->channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude;
    const sway_complex_t acc = line->channel[SWAY_CHANNEL_CAR_LATERAL_ACC].amplitude;
    const uint32_t both = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                          SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC);
    if ((line->valid_mask & both) != both || sway_real_sign(line->speed_m_s) <= 0) {
        return sway_complex_abs(yaw);
    }
    sway_observer_body_t b;
    sway_observer_body(&trailer->with, &b);
    const sway_real_t by_v = DIV(sway_real_int(1), line->speed_m_s);
    const sway_real_t arm = ADD(b.length_m, b.axle_m);
    const sway_real_t turning = MUL(b.trailer_n_per_rad, arm);
    const sway_real_t inertia =
        ADD(b.trailer_inertia_kgm2, MUL(b.mass_kg, sway_real_square(b.length_m)));
    sway_complex_t ball = sway_complex_mul(s, yaw);
    ball = sway_complex_sub(acc, sway_complex_scale(ball, ADD(car->acc_m, car->hitch_m)));
    sway_complex_t above = sway_complex_scale(s, MUL(b.mass_kg, b.length_m));
    above.re = ADD(above.re, MUL(turning, by_v));
    sway_complex_t below = sway_complex_scale(sway_complex_mul(s, s), inertia);
    below = sway_complex_add(below, sway_complex_scale(s, MUL(MUL(turning, arm), by_v)));
    below.re = ADD(below.re, turning);
    return sway_complex_abs(sway_complex_div(sway_complex_mul(above, ball), below));
}

/* Value and error of a logarithm's number. */
static sway_trailer_number_t number(sway_real_t value, sway_real_t relative, int32_t scale)
{
    const sway_trailer_number_t result = {
        sway_real_to_int(value, scale, -INT32_MAX, INT32_MAX),
        sway_real_to_int(sway_real_abs(MUL(value, relative)), scale, 0, INT32_MAX)};
    return result;
}

static sway_trailer_number_t plain(sway_real_t value, sway_real_t se, int32_t scale)
{
    const sway_trailer_number_t result = {sway_real_to_int(value, scale, -INT32_MAX, INT32_MAX),
                                          sway_real_to_int(se, scale, 0, INT32_MAX)};
    return result;
}

static sway_real_t se_of(const sway_observer_t *observer, const uint8_t *state,
                         const sway_real_t *weight, uint32_t n)
{
    return sway_real_sqrt(variance_of(observer, state, weight, n));
}

static void report_trailer(const sway_observer_t *with, sway_trailer_report_t *report)
{
    const sway_real_t one = sway_real_int(1);
    sway_observer_body_t b;
    sway_observer_body(with, &b);
    static const uint8_t INERTIA[3] = {SWAY_STATE_TRAILER_MASS, SWAY_STATE_TRAILER_GYRATION,
                                       SWAY_STATE_TRAILER_LENGTH};
    static const uint8_t STIFFNESS[2] = {SWAY_STATE_TRAILER_MASS, SWAY_STATE_TRAILER_STIFFNESS};
    static const uint8_t AXLE[2] = {SWAY_STATE_TRAILER_AXLE, SWAY_STATE_TRAILER_LENGTH};
    const sway_real_t powers[3] = {one, one, sway_real_int(2)};
    const sway_real_t places[2] = {one, b.length_m};
    report->mass_kg = number(b.mass_kg, sway_observer_se(with, SWAY_STATE_TRAILER_MASS), 1);
    report->hitch_to_cog_mm =
        number(b.length_m, sway_observer_se(with, SWAY_STATE_TRAILER_LENGTH), 1000);
    report->hitch_to_axle_mm = plain(ADD(b.length_m, b.axle_m), se_of(with, AXLE, places, 2), 1000);
    report->yaw_inertia_kgm2 = number(b.trailer_inertia_kgm2, se_of(with, INERTIA, powers, 3), 1);
    report->stiffness_n_per_rad = number(b.trailer_n_per_rad, se_of(with, STIFFNESS, powers, 2), 1);
    report->friction_nm =
        plain(with->x[SWAY_STATE_FRICTION], sway_observer_se(with, SWAY_STATE_FRICTION), 100);
    report->yaw_rate_urad_s = plain(with->x[SWAY_STATE_TRAILER_YAW_RATE],
                                    sway_observer_se(with, SWAY_STATE_TRAILER_YAW_RATE), 1000000);
    report->articulation_urad = plain(with->x[SWAY_STATE_ARTICULATION],
                                      sway_observer_se(with, SWAY_STATE_ARTICULATION), 1000000);
}

void sway_trailer_report(const sway_trailer_watch_t *trailer, sway_trailer_report_t *report)
{
    const sway_observer_t *const best =
        trailer->presence == SWAY_TRAILER_NONE ? &trailer->alone : &trailer->with;
    sway_observer_body_t b;
    report->presence = trailer->sensed ? SWAY_TRAILER_SENSED : trailer->presence;
    report->evidence_milli = sway_real_to_int(trailer->evidence, 1000, -INT32_MAX, INT32_MAX);
    report->learnt_ms = trailer->learnt_ms;
    for (uint32_t i = 0; i < 2U; i++) {
        report->agreement_milli[i] = sway_real_to_int(best->unfit[i], 1000, 0, INT32_MAX);
    }
    sway_observer_body(best, &b);
    report->car_front_n_per_rad =
        number(b.front_n_per_rad, sway_observer_se(best, SWAY_STATE_CAR_FRONT), 1);
    report->car_rear_n_per_rad =
        number(b.rear_n_per_rad, sway_observer_se(best, SWAY_STATE_CAR_REAR), 1);
    report_trailer(&trailer->with, report);
}

/* --- the same as last time? ------------------------------------------------------------------- */

/* Car first, then trailer. */
static uint32_t state_of(uint32_t unknown)
{
    return unknown < SWAY_TRAILER_CAR ? SWAY_STATE_CAR_FRONT + unknown
                                      : SWAY_STATE_TRAILER_MASS + unknown - SWAY_TRAILER_CAR;
}

static uint32_t corner(uint32_t i, uint32_t j)
{
    return i * (i + 1U) / 2U + j;
}

void sway_trailer_remember(const sway_trailer_watch_t *trailer, sway_trailer_memory_t *memory)
{
    for (uint32_t i = 0; i < SWAY_TRAILER_MEMORY; i++) {
        memory->value[i] = trailer->with.x[state_of(i)];
        for (uint32_t j = 0; j <= i; j++) {
            memory->covariance[corner(i, j)] =
                sway_observer_covariance(&trailer->with, state_of(i), state_of(j));
        }
    }
}

static void recall_car(sway_observer_t *observer, const sway_trailer_memory_t *memory)
{
    for (uint32_t i = 0; i < SWAY_TRAILER_CAR; i++) {
        observer->x[state_of(i)] = memory->value[i];
        for (uint32_t j = 0; j <= i; j++) {
            observer->p[corner(state_of(i), state_of(j))] = memory->covariance[corner(i, j)];
        }
    }
}

void sway_trailer_recall(sway_trailer_watch_t *trailer, const sway_trailer_memory_t *memory)
{
    recall_car(&trailer->alone, memory);
    recall_car(&trailer->with, memory);
}

enum { MEMORY = SWAY_TRAILER_MEMORY };

/* Cholesky's factor in the place of a covariance; the logarithm of its determinant. False: it is
 * none. */
static bool factorise(sway_real_t *c, sway_real_t *logarithm)
{
    sway_real_t sum = sway_real_zero();
    for (uint32_t i = 0; i < MEMORY; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            sway_real_t left = c[corner(i, j)];
            for (uint32_t k = 0; k < j; k++) {
                left = SUB(left, MUL(c[corner(i, k)], c[corner(j, k)]));
            }
            if (i == j && sway_real_sign(left) <= 0) {
                return false;
            }
            c[corner(i, j)] = i == j ? sway_real_sqrt(left) : DIV(left, c[corner(j, j)]);
        }
        sum = ADD(sum, sway_real_ln(c[corner(i, i)]));
    }
    *logarithm = sway_real_scale(sum, 1);
    return true;
}

/* The inverse of the factor, in its place. */
static void turn_round(sway_real_t *factor)
{
    for (uint32_t j = 0; j < MEMORY; j++) {
        factor[corner(j, j)] = DIV(sway_real_int(1), factor[corner(j, j)]);
        for (uint32_t i = j + 1U; i < MEMORY; i++) {
            sway_real_t sum = sway_real_zero();
            for (uint32_t k = j; k < i; k++) {
                sum = ADD(sum, MUL(factor[corner(i, k)], factor[corner(k, j)]));
            }
            factor[corner(i, j)] = NEG(DIV(sum, factor[corner(i, i)]));
        }
    }
}

/* What is weighed: sums of inverse covariances, of these times values, and a logarithm. */
typedef struct {
    sway_real_t inverse[SWAY_TRAILER_TRIANGLE];
    sway_real_t towards[MEMORY];
    sway_real_t sum;
} weighed_t;

/* Adds (or takes off) a normal distribution: `work` is its covariance, `value` its mean, seen from
 * where it is now. */
static bool add_normal(weighed_t *to, sway_real_t *work, const sway_real_t *value, int32_t sign)
{
    sway_real_t logarithm;
    const sway_real_t one = sway_real_int(sign);
    sway_real_t square = sway_real_zero();
    if (!factorise(work, &logarithm)) {
        return false;
    }
    turn_round(work);
    for (uint32_t k = 0; k < MEMORY; k++) { // row k of the inverse factor
        sway_real_t along = sway_real_zero();
        for (uint32_t i = 0; i <= k; i++) {
            along = ADD(along, MUL(work[corner(k, i)], value[i]));
        }
        square = ADD(square, sway_real_square(along));
        for (uint32_t i = 0; i <= k; i++) {
            const sway_real_t part = MUL(one, work[corner(k, i)]);
            to->towards[i] = ADD(to->towards[i], MUL(part, along));
            for (uint32_t j = 0; j <= i; j++) {
                to->inverse[corner(i, j)] =
                    ADD(to->inverse[corner(i, j)], MUL(part, work[corner(k, j)]));
            }
        }
    }
    to->sum = SUB(to->sum, MUL(one, ADD(logarithm, square)));
    return true;
}

/* The car as remembered, the trailer as it was at the start. */
static void forget_trailer(const sway_trailer_watch_t *trailer, const sway_trailer_memory_t *memory,
                           sway_trailer_memory_t *start)
{
    *start = *memory;
    for (uint32_t i = SWAY_TRAILER_CAR; i < MEMORY; i++) {
        for (uint32_t j = 0; j < i; j++) {
            start->covariance[corner(i, j)] = sway_real_zero();
        }
        start->value[i] = trailer->start[i - SWAY_TRAILER_CAR];
        start->covariance[corner(i, i)] =
            sway_real_square(trailer->start_error[i - SWAY_TRAILER_CAR]);
    }
}

static bool add_memory(weighed_t *to, sway_trailer_memory_t *memory, const sway_real_t *from,
                       int32_t sign)
{
    for (uint32_t i = 0; i < MEMORY; i++) {
        memory->value[i] = SUB(memory->value[i], from[i]);
    }
    return add_normal(to, memory->covariance, memory->value, sign);
}

/* What is known now holds what the drive has shown and the start: the drive is as probable with the
 * remembered trailer as the integral of now times memory by start. */
sway_real_t sway_trailer_likeness(const sway_trailer_watch_t *trailer,
                                  const sway_trailer_memory_t *memory)
{
    sway_real_t from[MEMORY];
    sway_trailer_memory_t work;
    weighed_t all;
    sway_real_t logarithm;
    memset(&all, 0, sizeof all);
    sway_trailer_remember(trailer, &work);
    memcpy(from, work.value, sizeof from);
    bool known = add_memory(&all, &work, from, 1);
    work = *memory;
    known = known && add_memory(&all, &work, from, 1);
    forget_trailer(trailer, memory, &work);
    known = known && add_memory(&all, &work, from, -1) && factorise(all.inverse, &logarithm);
    if (!known) {
        return sway_real_zero();
    }
    for (uint32_t i = 0; i < MEMORY; i++) { // forward substitution
        for (uint32_t k = 0; k < i; k++) {
            all.towards[i] = SUB(all.towards[i], MUL(all.inverse[corner(i, k)], all.towards[k]));
        }
        all.towards[i] = DIV(all.towards[i], all.inverse[corner(i, i)]);
        all.sum = ADD(all.sum, sway_real_square(all.towards[i]));
    }
    return sway_real_scale(SUB(all.sum, logarithm), -1);
}

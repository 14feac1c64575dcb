// SPDX-License-Identifier: MIT
#include "model/sway_relations.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"
#include "signal/sway_line.h"

/* Relaxation length of a usual tyre, which its tolerance is around. */
#define USUAL_LAG_MM 350

/* What a linear model of rigid bodies leaves out, in each term. */
#define LEFT_OUT_PPM 30000

/* Wind and road on a body, as an amplitude in the band of a harmonic: N, Nm. */
#define UNSEEN_FORCE_N 100
#define UNSEEN_MOMENT_NM 200

/* Fields of use: slowest, spread of the speed over a window, largest acceleration. */
#define SLOWEST_MM_S 8333
#define SPREAD_OF_SPEED 20
#define LINEAR_UM_S2 2500000

/* Amplitude of the steering wheel at a harmonic from which the driver is what moves the vehicle. */
#define STEERED_URAD 15000

/* Articulation rate at which dry friction is whole. */
#define SLIDING_URAD_S 8727

/* Terms of a relation. Forces of axles are the measured ones, where there are any; TYRE is
 * stiffness times slip. */
enum {
    TERM_CAR_FORCE,
    TERM_CAR_TURN,
    TERM_TRAILER_FORCE,
    TERM_TRAILER_TURN,
    TERM_HITCH,
    TERM_FORCE,
    TERM_TYRE = TERM_FORCE + SWAY_AXLE_COUNT,
    TERM_KINEMATIC = TERM_TYRE + SWAY_AXLE_COUNT,
    TERM_FRICTION,
    TERM_COUNT
};

/* How much of a term is in the relation, and how that grows with place and length of the trailer.
 */
typedef struct {
    sway_real_t lever;
    sway_real_t by_place;
    sway_real_t by_length;
} part_t;

/* Places of the sources. */
enum {
    WHEEL = SWAY_ORIGIN_STEERING - 1,
    RATE_1 = SWAY_ORIGIN_CAR_YAW_RATE - 1,
    ACC_1 = SWAY_ORIGIN_CAR_ACC - 1,
    RATE_2 = SWAY_ORIGIN_TRAILER_YAW_RATE - 1,
    ACC_2 = SWAY_ORIGIN_TRAILER_ACC - 1,
    ANGLE = SWAY_ORIGIN_ARTICULATION - 1,
    HITCH = SWAY_ORIGIN_HITCH_FY - 1,
    FORCE = SWAY_ORIGIN_CAR_FRONT_FY - 1,
    SLIDING = SWAY_RELATIONS_SENSORS
};

/* Noise of each source's amplitude in a window, SI x 1e-6: several times what a sensor of a
 * production car has. */
static const int32_t NOISE_MICRO[SWAY_RELATIONS_SENSORS] = {
    1000,                                   // steering wheel
    300,                                    // car: yaw rate
    15000,                                  // lateral acceleration
    300,                                    // trailer: yaw rate
    15000,                                  // lateral acceleration
    300,                                    // articulation
    20000000,                               // hitch
    20000000, 20000000, 20000000, 20000000, // axles
};

#define BIT(source) ((uint32_t)1U << (uint32_t)(source))
#define CAR_MOTION (BIT(RATE_1) | BIT(ACC_1))
#define TRAILER_MOTION (BIT(RATE_2) | BIT(ACC_2))

static sway_real_t metre(int32_t micrometre)
{
    return sway_real_micro(micrometre);
}

static bool knows(const sway_relations_t *re, uint32_t sources)
{
    return (re->known & sources) == sources;
}

static sway_channel_t channel_of(uint32_t source)
{
    return sway_origin_of_channel((sway_origin_t)(source + 1U));
}

static uint32_t force_source(uint32_t axle)
{
    return (uint32_t)FORCE + axle;
}

/* --- sums of a window --------------------------------------------------------------------------
 */

/* Sine of a quarter turn, 128 steps, x 2^15. */
static const int16_t SINE[129] = {
    0,     402,   804,   1206,  1608,  2009,  2411,  2811,  3212,  3612,  4011,  4410,  4808,
    5205,  5602,  5998,  6393,  6787,  7180,  7571,  7962,  8351,  8740,  9127,  9512,  9896,
    10279, 10660, 11039, 11417, 11793, 12167, 12540, 12910, 13279, 13646, 14010, 14373, 14733,
    15091, 15447, 15800, 16151, 16500, 16846, 17190, 17531, 17869, 18205, 18538, 18868, 19195,
    19520, 19841, 20160, 20475, 20788, 21097, 21403, 21706, 22006, 22302, 22595, 22884, 23170,
    23453, 23732, 24008, 24279, 24548, 24812, 25073, 25330, 25583, 25833, 26078, 26320, 26557,
    26791, 27020, 27246, 27467, 27684, 27897, 28106, 28311, 28511, 28707, 28899, 29086, 29269,
    29448, 29622, 29792, 29957, 30118, 30274, 30425, 30572, 30715, 30853, 30986, 31114, 31238,
    31357, 31471, 31581, 31686, 31786, 31881, 31972, 32058, 32138, 32214, 32286, 32352, 32413,
    32470, 32522, 32568, 32610, 32647, 32679, 32706, 32729, 32746, 32758, 32766, 32767,
};

static int32_t sine(uint32_t step)
{
    const uint32_t s = step % SWAY_RELATIONS_ROWS;
    const uint32_t half = s % 256U;
    const int32_t value = SINE[half <= 128U ? half : 256U - half];
    return s < 256U ? value : -value;
}

static void begin_window(sway_relations_sums_t *sums)
{
    memset(sums, 0, sizeof *sums);
    sums->known = UINT32_MAX;
    sums->slowest_mm_s = INT32_MAX;
}

static void add_value(sway_relations_sums_t *sums, uint32_t source, int32_t value)
{
    for (uint32_t bin = 0; bin < SWAY_RELATIONS_BINS; bin++) {
        const uint32_t step = (bin + 1U) * sums->rows;
        sums->sum[source][bin][0] += (int64_t)value * sine(step + 128U);
        sums->sum[source][bin][1] -= (int64_t)value * sine(step);
    }
}

static int32_t larger(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

bool sway_relations_add(sway_relations_sums_t *sums, const sway_row_t *row)
{
    const int32_t speed = row->value[SWAY_CHANNEL_SPEED];
    if (sums->rows == 0U || sums->rows == SWAY_RELATIONS_ROWS || row->restart) {
        begin_window(sums);
    }
    sums->known &= row->valid_mask;
    for (uint32_t source = 0; source < SWAY_RELATIONS_SENSORS; source++) {
        const sway_channel_t channel = channel_of(source);
        if ((sums->known & SWAY_CHANNEL_BIT(channel)) != 0U) {
            add_value(sums, source, row->value[channel]);
        }
    }
    const int32_t rate =
        row->value[SWAY_CHANNEL_TRAILER_YAW_RATE] - row->value[SWAY_CHANNEL_CAR_YAW_RATE];
    const int32_t slide = rate > SLIDING_URAD_S    ? SLIDING_URAD_S
                          : rate < -SLIDING_URAD_S ? -SLIDING_URAD_S
                                                   : rate;
    add_value(sums, SLIDING, slide);
    sums->speed_mm_s += speed;
    sums->slowest_mm_s = speed < sums->slowest_mm_s ? speed : sums->slowest_mm_s;
    sums->fastest_mm_s = larger(sums->fastest_mm_s, speed);
    for (uint32_t body = 0; body < 2U; body++) {
        const sway_channel_t channel =
            body == 0U ? SWAY_CHANNEL_CAR_LATERAL_ACC : SWAY_CHANNEL_TRAILER_LATERAL_ACC;
        const int32_t acc = row->value[channel];
        const bool seen = (row->valid_mask & SWAY_CHANNEL_BIT(channel)) != 0U;
        sums->largest_um_s2 =
            seen ? larger(sums->largest_um_s2, acc < 0 ? -acc : acc) : sums->largest_um_s2;
    }
    sums->rows++;
    return sums->rows == SWAY_RELATIONS_ROWS;
}

bool sway_relations_start(sway_relations_t *re, const sway_vehicle_t *vehicle,
                          const sway_relations_sums_t *sums, int32_t sample_period_us)
{
    const bool has_speed = (sums->known & SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED)) != 0U;
    if (!has_speed || sums->slowest_mm_s < SLOWEST_MM_S || sums->largest_um_s2 > LINEAR_UM_S2 ||
        (sums->fastest_mm_s - sums->slowest_mm_s) * SPREAD_OF_SPEED > sums->fastest_mm_s) {
        return false;
    }
    re->vehicle = vehicle;
    re->known = 0;
    re->speed_m_s =
        MUL(sway_real(sums->speed_mm_s, 0), sway_real_ratio(1, 1000 * SWAY_RELATIONS_ROWS));
    re->bin_rad_s = DIV(sway_real_scale(sway_real_pi(), 1),
                        MUL(sway_real_micro(sample_period_us), sway_real_int(SWAY_RELATIONS_ROWS)));
    for (uint32_t source = 0; source < SWAY_RELATIONS_SOURCES; source++) {
        const bool slide = source == (uint32_t)SLIDING;
        const sway_real_t unit =
            slide ? sway_real_ratio(1, SLIDING_URAD_S) : sway_line_unit(channel_of(source));
        const bool known = slide ? knows(re, BIT(RATE_1) | BIT(RATE_2))
                                 : (sums->known & SWAY_CHANNEL_BIT(channel_of(source))) != 0U;
        re->known |= known ? BIT(source) : 0U;
        for (uint32_t bin = 0; bin < SWAY_RELATIONS_BINS; bin++) {
            const sway_real_t scale = sway_real_scale(unit, -15 - 8); // an amplitude: 2/rows
            const int64_t *const sum = sums->sum[source][bin];
            re->bin[source][bin] =
                sway_complex(MUL(sway_real(sum[0], 0), scale), MUL(sway_real(sum[1], 0), scale));
        }
    }
    return true;
}

/* Amplitude of a source's derivative of this order at the harmonic: bins around it, each turned by
 * j omega as often, put together to a Hann window. */
static sway_complex_t amplitude(const sway_relations_t *re, uint32_t source, uint32_t order)
{
    sway_complex_t sum = {{0, 0}, {0, 0}};
    for (int32_t side = -1; side <= 1; side++) {
        const int32_t bin = (int32_t)re->harmonic + side;
        const sway_real_t omega = MUL(re->bin_rad_s, sway_real_int(bin));
        sway_complex_t x = re->bin[source][bin - 1];
        for (uint32_t k = 0; k < order; k++) {
            x = sway_complex(NEG(MUL(x.im, omega)), MUL(x.re, omega));
        }
        x.re = side == 0 ? x.re : sway_real_scale(NEG(x.re), -1);
        x.im = side == 0 ? x.im : sway_real_scale(NEG(x.im), -1);
        sum = sway_complex_add(sum, x);
    }
    return sum;
}

/* --- what is allowed ---------------------------------------------------------------------------
 */

static int32_t stiffness(const sway_relations_t *re, uint32_t axle)
{
    const sway_car_t *const car = &re->vehicle->car;
    const sway_trailer_t *const trailer = &re->vehicle->trailer;
    const int32_t of[SWAY_AXLE_COUNT] = {
        car->front_cornering_stiffness_n_per_rad, car->rear_cornering_stiffness_n_per_rad,
        trailer->axles == 2 ? trailer->front_cornering_stiffness_n_per_rad : 0,
        trailer->axles > 0 ? trailer->rear_cornering_stiffness_n_per_rad : 0};
    return of[axle];
}

static bool knows_slip(const sway_relations_t *re, uint32_t axle)
{
    const uint32_t wheel = axle == (uint32_t)SWAY_AXLE_CAR_FRONT ? BIT(WHEEL) : 0U;
    const uint32_t motion = axle < (uint32_t)SWAY_AXLE_TRAILER_FRONT ? CAR_MOTION : TRAILER_MOTION;
    return stiffness(re, axle) > 0 && knows(re, motion | wheel);
}

static bool knows_force(const sway_relations_t *re, uint32_t axle)
{
    const bool none = axle == (uint32_t)SWAY_AXLE_TRAILER_FRONT && re->vehicle->trailer.axles != 2;
    return none || knows(re, BIT(force_source(axle))) || knows_slip(re, axle);
}

static bool measures_hitch(const sway_relations_t *re)
{
    return re->vehicle->trailer.axles == 0 || knows(re, BIT(HITCH));
}

static bool knows_car(const sway_relations_t *re)
{
    return knows(re, CAR_MOTION) && knows_force(re, SWAY_AXLE_CAR_FRONT) &&
           knows_force(re, SWAY_AXLE_CAR_REAR);
}

static bool knows_trailer(const sway_relations_t *re)
{
    return re->vehicle->trailer.axles > 0 && knows(re, TRAILER_MOTION) &&
           knows_force(re, SWAY_AXLE_TRAILER_FRONT) && knows_force(re, SWAY_AXLE_TRAILER_REAR) &&
           (measures_hitch(re) || knows_car(re));
}

bool sway_relations_allow(const sway_relations_t *re, sway_relation_t relation)
{
    const bool has_trailer = re->vehicle->trailer.axles > 0;
    const uint32_t axle = (uint32_t)relation - (uint32_t)SWAY_RELATION_CAR_FRONT;
    switch (relation) {
    case SWAY_RELATION_ARTICULATION:
        return has_trailer && knows(re, BIT(RATE_1) | BIT(RATE_2) | BIT(ANGLE));
    case SWAY_RELATION_HITCH:
        return has_trailer && knows(re, CAR_MOTION | TRAILER_MOTION);
    case SWAY_RELATION_CAR_LATERAL:
        return knows_car(re) && measures_hitch(re);
    case SWAY_RELATION_CAR_YAW:
        return knows_car(re) && re->vehicle->car.yaw_inertia_gm2 > 0;
    case SWAY_RELATION_TRAILER_LATERAL:
    case SWAY_RELATION_TRAILER_YAW:
        return knows_trailer(re);
    default:
        return knows(re, BIT(force_source(axle))) && knows_slip(re, axle);
    }
}

/* --- terms -------------------------------------------------------------------------------------
 */

static void add_slope(sway_relations_t *re, uint32_t number, sway_complex_t value, sway_real_t by)
{
    re->slope[number] = sway_complex_add(re->slope[number], sway_complex_scale(value, by));
}

/* Adds `by` times a derivative of a source to a term, and with the term's lever to the residual. */
static void add(sway_relations_t *re, sway_complex_t *term, uint32_t source, uint32_t order,
                sway_real_t by, const part_t *part)
{
    const sway_complex_t value = sway_complex_scale(amplitude(re, source, order), by);
    const sway_real_t omega = MUL(re->bin_rad_s, sway_real_int(re->harmonic));
    sway_real_t noise = MUL(MUL(by, part->lever), sway_real_micro(NOISE_MICRO[source]));
    for (uint32_t k = 0; k < order; k++) {
        noise = MUL(noise, omega);
    }
    *term = sway_complex_add(*term, value);
    re->part[source] = sway_complex_add(re->part[source], sway_complex_scale(value, part->lever));
    re->noise = ADD(re->noise, sway_real_square(noise));
}

/* The term is complete. */
static void close_term(sway_relations_t *re, sway_complex_t term, const part_t *part)
{
    re->size_squared =
        ADD(re->size_squared, MUL(sway_real_square(part->lever), sway_complex_norm(term)));
    add_slope(re, SWAY_UNKNOWN_TRAILER_PLACE, term, part->by_place);
    add_slope(re, SWAY_UNKNOWN_CHANGED_PLACE, term, part->by_place);
    add_slope(re, SWAY_UNKNOWN_TRAILER_LENGTH, term, part->by_length);
}

static const sway_complex_t NOTHING = {{0, 0}, {0, 0}};

static void term_force_of_mass(sway_relations_t *re, bool trailer, const part_t *part)
{
    const sway_vehicle_t *const v = re->vehicle;
    const sway_real_t mass = sway_real_ratio(trailer ? v->trailer.mass_g : v->car.mass_g, 1000);
    const sway_real_t place =
        metre(trailer ? v->trailer.lateral_acc_position_um : v->car.lateral_acc_position_um);
    const uint32_t rate = trailer ? RATE_2 : RATE_1;
    sway_complex_t force = NOTHING;
    add(re, &force, trailer ? ACC_2 : ACC_1, 1, mass, part);
    add(re, &force, rate, 2, NEG(MUL(mass, place)), part);
    close_term(re, force, part);
    add_slope(re, trailer ? SWAY_UNKNOWN_TRAILER_MASS : SWAY_UNKNOWN_CAR_MASS, force, part->lever);
    if (trailer) { // the accelerometer stays where it is
        const sway_complex_t turn = amplitude(re, rate, 2);
        add_slope(re, SWAY_UNKNOWN_CHANGED_MASS, force, part->lever);
        add_slope(re, SWAY_UNKNOWN_TRAILER_PLACE, turn, MUL(part->lever, mass));
        add_slope(re, SWAY_UNKNOWN_CHANGED_PLACE, turn, MUL(part->lever, mass));
    }
}

static void term_turn(sway_relations_t *re, bool trailer, const part_t *part)
{
    const sway_vehicle_t *const v = re->vehicle;
    const int32_t inertia = trailer ? v->trailer.yaw_inertia_gm2 : v->car.yaw_inertia_gm2;
    sway_complex_t moment = NOTHING;
    add(re, &moment, trailer ? RATE_2 : RATE_1, 2, sway_real_ratio(inertia, 1000), part);
    close_term(re, moment, part);
    add_slope(re, trailer ? SWAY_UNKNOWN_TRAILER_INERTIA : SWAY_UNKNOWN_CAR_INERTIA, moment,
              part->lever);
}

static void term_measured(sway_relations_t *re, uint32_t source, const part_t *part)
{
    sway_complex_t force = NOTHING;
    add(re, &force, source, 1, sway_real_int(1), part);
    close_term(re, force, part);
}

/* Where an axle is, ahead of its body's accelerometer. */
static sway_real_t ahead(const sway_relations_t *re, uint32_t axle)
{
    const sway_car_t *const car = &re->vehicle->car;
    const sway_trailer_t *const trailer = &re->vehicle->trailer;
    const int32_t place[SWAY_AXLE_COUNT] = {
        car->front_axle_to_cog_um - car->lateral_acc_position_um,
        -car->rear_axle_to_cog_um - car->lateral_acc_position_um,
        trailer->front_axle_to_cog_um - trailer->lateral_acc_position_um,
        -trailer->rear_axle_to_cog_um - trailer->lateral_acc_position_um};
    return metre(place[axle]);
}

/* Force of an axle, differentiated `order` times more than once: stiffness times
 * r - (a + ahead r')/v + wheel'/i; `by_speed`: what of it is divided by the speed, with the other
 * sign. */
static sway_complex_t add_tyre(sway_relations_t *re, uint32_t axle, uint32_t order, sway_real_t c,
                               const part_t *part, sway_complex_t *by_speed)
{
    const bool trailer = axle >= (uint32_t)SWAY_AXLE_TRAILER_FRONT;
    const sway_real_t by_v = NEG(DIV(c, re->speed_m_s));
    sway_complex_t force = NOTHING;
    add(re, &force, trailer ? ACC_2 : ACC_1, order, by_v, part);
    add(re, &force, trailer ? RATE_2 : RATE_1, order + 1U, MUL(by_v, ahead(re, axle)), part);
    *by_speed = force;
    add(re, &force, trailer ? RATE_2 : RATE_1, order, c, part);
    if (axle == (uint32_t)SWAY_AXLE_CAR_FRONT) {
        const sway_real_t ratio = sway_real_ratio(1000, re->vehicle->car.steering_ratio_milli);
        add(re, &force, WHEEL, order + 1U, MUL(c, ratio), part);
    }
    return force;
}

static void term_tyre(sway_relations_t *re, uint32_t axle, const part_t *part)
{
    const sway_real_t c = sway_real_int(stiffness(re, axle));
    const sway_real_t lag = NEG(MUL(c, DIV(sway_real_ratio(USUAL_LAG_MM, 1000), re->speed_m_s)));
    sway_complex_t by_speed;
    sway_complex_t late_by_speed;
    sway_complex_t force = add_tyre(re, axle, 0, c, part, &by_speed);
    const sway_complex_t late = add_tyre(re, axle, 1, lag, part, &late_by_speed);
    force = sway_complex_add(force, late);
    close_term(re, force, part);
    add_slope(re, (uint32_t)SWAY_UNKNOWN_STIFFNESS + axle, force, part->lever);
    add_slope(re, (uint32_t)SWAY_UNKNOWN_CHANGED_STIFFNESS + axle, force, part->lever);
    by_speed = sway_complex_add(by_speed, sway_complex_add(late, late_by_speed)); // late: twice
    add_slope(re, SWAY_UNKNOWN_SPEED, by_speed, NEG(part->lever));
    add_slope(re, axle < 2U ? SWAY_UNKNOWN_CAR_LAG : SWAY_UNKNOWN_TRAILER_LAG, late,
              MUL(part->lever, sway_real_ratio(1000, USUAL_LAG_MM)));
}

static void term_kinematic(sway_relations_t *re, const part_t *part)
{
    const sway_vehicle_t *const v = re->vehicle;
    const sway_real_t one = sway_real_int(1);
    const sway_real_t minus = sway_real_int(-1);
    sway_complex_t sum = NOTHING;
    if (re->relation == (uint8_t)SWAY_RELATION_ARTICULATION) {
        add(re, &sum, ANGLE, 1, one, part);
        close_term(re, sum, part);
        add(re, &sum, RATE_1, 0, one, part);
        add(re, &sum, RATE_2, 0, minus, part);
        return;
    }
    const sway_real_t car = metre(v->car.hitch_to_cog_um + v->car.lateral_acc_position_um);
    const sway_real_t trailer =
        metre(v->trailer.lateral_acc_position_um - v->trailer.hitch_to_cog_um);
    add(re, &sum, ACC_1, 0, one, part);
    add(re, &sum, RATE_1, 1, NEG(car), part);
    close_term(re, sum, part);
    add(re, &sum, ACC_2, 0, minus, part);
    add(re, &sum, RATE_2, 1, trailer, part);
    add_slope(re, SWAY_UNKNOWN_TRAILER_LENGTH, amplitude(re, RATE_2, 1), minus);
}

/* Dry friction turns the car with the trailer: a moment in the direction of the angle's rate. */
static void term_friction(sway_relations_t *re, const part_t *part)
{
    if (knows(re, BIT(SLIDING))) {
        add_slope(re, SWAY_UNKNOWN_FRICTION, amplitude(re, SLIDING, 1),
                  MUL(part->lever, sway_real_int(100)));
    }
}

/* --- levers ------------------------------------------------------------------------------------
 */

/* Lever of a term as the relation is written down, the hitch force as a term of its own. */
static part_t plain_part(const sway_relations_t *re, uint32_t term)
{
    const sway_car_t *const car = &re->vehicle->car;
    const sway_trailer_t *const trailer = &re->vehicle->trailer;
    const sway_real_t one = sway_real_int(1);
    const sway_real_t minus = sway_real_int(-1);
    part_t part = {sway_real_zero(), sway_real_zero(), sway_real_zero()};
    const uint32_t axle = term - TERM_FORCE;
    switch (re->relation) {
    case SWAY_RELATION_CAR_LATERAL:
        part.lever = term == TERM_CAR_FORCE ? one : part.lever;
        part.lever = axle < 2U || term == TERM_HITCH ? minus : part.lever;
        break;
    case SWAY_RELATION_CAR_YAW:
        part.lever = term == TERM_CAR_TURN ? one : part.lever;
        part.lever = axle == 0U ? metre(-car->front_axle_to_cog_um) : part.lever;
        part.lever = axle == 1U ? metre(car->rear_axle_to_cog_um) : part.lever;
        part.lever = term == TERM_HITCH ? metre(car->hitch_to_cog_um) : part.lever;
        part.lever = term == TERM_FRICTION ? minus : part.lever;
        break;
    case SWAY_RELATION_TRAILER_LATERAL:
        part.lever = term == TERM_TRAILER_FORCE || term == TERM_HITCH ? one : part.lever;
        part.lever = axle == 2U || axle == 3U ? minus : part.lever;
        break;
    case SWAY_RELATION_TRAILER_YAW:
        part.lever = term == TERM_TRAILER_TURN || term == TERM_FRICTION ? one : part.lever;
        part.lever = axle == 2U ? metre(-trailer->front_axle_to_cog_um) : part.lever;
        part.lever = axle == 3U ? metre(trailer->rear_axle_to_cog_um) : part.lever;
        part.lever = term == TERM_HITCH ? metre(trailer->hitch_to_cog_um) : part.lever;
        part.by_place = axle == 2U || axle == 3U ? one : part.by_place;
        part.by_place = term == TERM_HITCH ? minus : part.by_place;
        part.by_length = term == TERM_HITCH ? one : part.by_length;
        break;
    case SWAY_RELATION_ARTICULATION:
    case SWAY_RELATION_HITCH:
        part.lever = term == TERM_KINEMATIC ? one : part.lever;
        break;
    default: {
        const uint32_t own = (uint32_t)re->relation - (uint32_t)SWAY_RELATION_CAR_FRONT;
        part.lever = axle == own ? one : part.lever;
        part.lever = term == TERM_TYRE + own ? minus : part.lever;
        break;
    }
    }
    return part;
}

static void add_part(part_t *part, const part_t *more, bool negative)
{
    part->lever = negative ? SUB(part->lever, more->lever) : ADD(part->lever, more->lever);
    part->by_place =
        negative ? SUB(part->by_place, more->by_place) : ADD(part->by_place, more->by_place);
    part->by_length =
        negative ? SUB(part->by_length, more->by_length) : ADD(part->by_length, more->by_length);
}

/* Where the hitch force is not measured, the car's lateral balance stands in its place: m a - F. */
static part_t part_of(const sway_relations_t *re, uint32_t term)
{
    part_t part = plain_part(re, term);
    if (!measures_hitch(re)) {
        const part_t hitch = plain_part(re, TERM_HITCH);
        if (term == TERM_CAR_FORCE) {
            add_part(&part, &hitch, false);
        } else if (term == TERM_FORCE || term == TERM_FORCE + 1) {
            add_part(&part, &hitch, true);
        } else if (term == TERM_HITCH) {
            add_part(&part, &hitch, true);
        }
    }
    return part;
}

static bool is_nothing(const part_t *part)
{
    return sway_real_is_zero(part->lever) && sway_real_is_zero(part->by_place);
}

static void axle_term(sway_relations_t *re, uint32_t axle, const part_t *part)
{
    if (knows(re, BIT(force_source(axle)))) {
        term_measured(re, force_source(axle), part);
    } else if (knows_slip(re, axle)) {
        term_tyre(re, axle, part);
    }
}

static void run_term(sway_relations_t *re, uint32_t term, const part_t *part)
{
    switch (term) {
    case TERM_CAR_FORCE:
    case TERM_TRAILER_FORCE:
        term_force_of_mass(re, term == TERM_TRAILER_FORCE, part);
        break;
    case TERM_CAR_TURN:
    case TERM_TRAILER_TURN:
        term_turn(re, term == TERM_TRAILER_TURN, part);
        break;
    case TERM_HITCH:
        if (re->vehicle->trailer.axles > 0) {
            term_measured(re, HITCH, part);
        }
        break;
    case TERM_KINEMATIC:
        term_kinematic(re, part);
        break;
    case TERM_FRICTION:
        term_friction(re, part);
        break;
    default:
        if (term < TERM_TYRE) {
            axle_term(re, term - TERM_FORCE, part);
        } else {
            term_tyre(re, term - TERM_TYRE, part);
        }
        break;
    }
}

/* A sensor that is off moves the residual by its own part of it. */
static void finish(sway_relations_t *re)
{
    re->residual = NOTHING;
    for (uint32_t source = 0; source < SWAY_RELATIONS_SENSORS; source++) {
        const sway_complex_t part = re->part[source];
        re->residual = sway_complex_add(re->residual, part);
        re->slope[2U * source] = part;
        /* A delay: its phase grows with the frequency. */
        const sway_real_t turn = sway_real_scale(sway_real_int(re->harmonic), -2);
        re->slope[2U * source + 1U] = sway_complex(NEG(MUL(part.im, turn)), MUL(part.re, turn));
    }
    re->slope[SWAY_UNKNOWN_ROLL] = re->part[ACC_1];
    re->slope[SWAY_UNKNOWN_ROLL + 1] = re->part[ACC_2];
}

void sway_relations_begin(sway_relations_t *re, sway_relation_t relation, uint32_t harmonic)
{
    re->relation = (uint8_t)relation;
    re->harmonic = (uint8_t)harmonic;
    re->term = 0;
    re->noise = sway_real_zero();
    re->size_squared = sway_real_zero();
    memset(re->part, 0, sizeof re->part);
    memset(re->slope, 0, sizeof re->slope);
}

/* Motion that wind and road have caused goes with the very forces that a balance does not see, and
 * would make all masses and stiffnesses look small; so balances are asked where the driver steers.
 */
bool sway_relations_is_driven(const sway_relations_t *re)
{
    const bool kinematic = re->relation <= (uint8_t)SWAY_RELATION_HITCH;
    const sway_real_t wheel = sway_complex_abs(amplitude(re, WHEEL, 0));
    return kinematic || sway_real_less(sway_real_micro(STEERED_URAD), wheel);
}

bool sway_relations_run(sway_relations_t *re)
{
    bool done = false;
    while (!done && re->term < TERM_COUNT) {
        const part_t part = part_of(re, re->term);
        done = !is_nothing(&part);
        if (done) {
            run_term(re, re->term, &part);
        }
        re->term++;
    }
    if (re->term < TERM_COUNT) {
        return true;
    }
    finish(re);
    return false;
}

sway_real_t sway_relations_variance(const sway_relations_t *re)
{
    const sway_real_t left_out = sway_real_square(sway_real_micro(LEFT_OUT_PPM));
    const sway_real_t omega = MUL(re->bin_rad_s, sway_real_int(re->harmonic));
    sway_real_t unseen = MUL(sway_real_int(UNSEEN_FORCE_N), omega);
    if (re->relation == (uint8_t)SWAY_RELATION_CAR_YAW ||
        re->relation == (uint8_t)SWAY_RELATION_TRAILER_YAW) {
        unseen = MUL(sway_real_int(UNSEEN_MOMENT_NM), omega);
    } else if (re->relation <= (uint8_t)SWAY_RELATION_HITCH) {
        unseen = sway_real_zero();
    }
    const sway_real_t one =
        ADD(ADD(re->noise, sway_real_square(unseen)), MUL(left_out, re->size_squared));
    return MUL(one, sway_real_int(SWAY_RELATIONS_ALIKE));
}

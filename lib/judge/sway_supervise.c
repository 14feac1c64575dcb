// SPDX-License-Identifier: MIT
#include "judge/sway_supervise.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

enum { STAGE_IDLE, STAGE_TERMS, STAGE_HOLD, STAGE_REAL, STAGE_IMAGINARY, STAGE_FADE, STAGE_WEIGH };

/* Tolerances of the values: ratios in ppm, lengths in micrometres, friction in 100 uNm. */
static const int32_t TOLERANCE[SWAY_UNKNOWN_COUNT] = {
    30000,  50000, // steering wheel: gain; 10 ms of delay, as the phase of 0.8 Hz
    10000,  50000, // yaw rate of the car
    15000,  50000, // its acceleration
    10000,  50000, // yaw rate of the trailer
    15000,  50000, // its acceleration
    20000,  50000, // articulation
    30000,  50000, // hitch
    30000,  50000,  30000,  50000,  30000, 50000, 30000, 50000, // axles
    5000,                                                       // speed
    3000,   100000,                 // car: mass (all others are relative to it), yaw inertia
    30000,  100000,                 // trailer
    50000,  30000,                  // its place and length
    120000, 120000, 120000, 120000, // stiffnesses
    250000, 250000,                 // relaxation lengths
    200000,                         // friction
    25000,  25000,  25000,  25000,  // changes on the way: stiffnesses
    20000,  10000,                  // mass, place
    40000,  40000,                  // accelerometers roll with their bodies, throughout a drive
};

/* What is forgotten: sensors and changes; a drive long the rest. Two in a hundred of a number in a
 * round of about a second. */
#define KEEP_PPM 930000
#define FADING                                                                                     \
    ((UINT64_C(1) << SWAY_UNKNOWN_SPEED) - 1U + (UINT64_C(63) << SWAY_UNKNOWN_CHANGED_STIFFNESS))

/* Explanations by the vehicle, which come after those by each sensor: the first, the fourth. */
#define EXPLAIN_SPEED SWAY_SUPERVISE_SENSORS
#define EXPLAIN_TRAILER_TYRES (SWAY_SUPERVISE_SENSORS + 3)

/* From here on the user's values as a whole, which are never reported: in hours of driving the
 * effects of wind and road make them look wrong. They only keep a sensor from being blamed for
 * them. */
#define EXPLAIN_CAR (SWAY_SUPERVISE_SENSORS + 6)

/* Tolerance of a value found to differ, at least ten times the assumed one. */
#define LIFTED_PPM 250000

/* Explanations by the vehicle. */
static const struct {
    uint8_t finding;
    uint8_t size;
    uint8_t group[SWAY_KALMAN_GROUP];
} BY_VEHICLE[] = {
    {SWAY_FINDING_SPEED, 1, {SWAY_UNKNOWN_SPEED}},
    {SWAY_FINDING_CAR_FRONT_TYRES, 1, {SWAY_UNKNOWN_CHANGED_STIFFNESS}},
    {SWAY_FINDING_CAR_REAR_TYRES, 1, {SWAY_UNKNOWN_CHANGED_STIFFNESS + 1}},
    {SWAY_FINDING_TRAILER_TYRES,
     2,
     {SWAY_UNKNOWN_CHANGED_STIFFNESS + 3, SWAY_UNKNOWN_CHANGED_STIFFNESS + 2}},
    {SWAY_FINDING_LOAD, 2, {SWAY_UNKNOWN_CHANGED_PLACE, SWAY_UNKNOWN_CHANGED_MASS}},
    {SWAY_FINDING_FRICTION, 1, {SWAY_UNKNOWN_FRICTION}},
    {SWAY_FINDING_CAR,
     4,
     {SWAY_UNKNOWN_CAR_MASS, SWAY_UNKNOWN_CAR_INERTIA, SWAY_UNKNOWN_STIFFNESS,
      SWAY_UNKNOWN_STIFFNESS + 1}},
    {SWAY_FINDING_TRAILER,
     6,
     {SWAY_UNKNOWN_TRAILER_MASS, SWAY_UNKNOWN_TRAILER_INERTIA, SWAY_UNKNOWN_TRAILER_PLACE,
      SWAY_UNKNOWN_TRAILER_LENGTH, SWAY_UNKNOWN_STIFFNESS + 2, SWAY_UNKNOWN_STIFFNESS + 3}},
};

/* Numbers of the means: offsets of the four motions since ever and since lately, and the bank. */
static const sway_channel_t MOTION[4] = {SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_CAR_LATERAL_ACC,
                                         SWAY_CHANNEL_TRAILER_YAW_RATE,
                                         SWAY_CHANNEL_TRAILER_LATERAL_ACC};
enum { OFFSET_LATELY = 4, OFFSET_BANK = 8 };
static const int32_t OFFSET_TOLERANCE[SWAY_SUPERVISE_OFFSETS] = {
    9000, 250000, 9000, 250000, 3500, 120000, 3500, 120000, 300000};
#define OFFSET_FADING UINT64_C(0x1F0)
#define OFFSET_KEEP_PPM 950000

/* Share of a relation's assumed variance that its innovations show: a mean of the last values, to
 * begin with as if so many had been as assumed. A value counts as four times the mean at most, so
 * that a fault does not soon pass as noise; believed are 1.5 times the mean, at least a tenth of
 * what is assumed, and never more than that. */
enum { TAKEN_FIRST = 8, TAKEN_MOST = 128 };
#define BELIEVED sway_real_ratio(3 * SWAY_RELATIONS_ALIKE, 2)
#define SHARE_LEAST sway_real_ratio(2, 30 * SWAY_RELATIONS_ALIKE)

/* Rows in a mean. */
#define MEAN_ROWS 256

static void reset_numbers(sway_supervise_t *su)
{
    memcpy(su->tolerance_ppm, TOLERANCE, sizeof TOLERANCE);
    sway_kalman_reset(&su->numbers);
    for (uint32_t i = 0; i < (uint32_t)SWAY_RELATION_COUNT; i++) {
        su->share[i] = sway_real_ratio(1, SWAY_RELATIONS_ALIKE);
        su->taken[i] = (uint8_t)TAKEN_FIRST;
    }
    su->candidate = (uint8_t)SWAY_SUPERVISE_EXPLANATIONS;
    su->reported = (uint8_t)SWAY_SUPERVISE_EXPLANATIONS;
    su->unresolved = false;
    su->rounds = 0;
}

void sway_supervise_init(sway_supervise_t *su, const sway_vehicle_t *vehicle,
                         int32_t sample_period_us)
{
    memset(su, 0, sizeof *su);
    su->sample_period_us = sample_period_us;
    su->vehicle = vehicle;
    su->numbers.count = SWAY_UNKNOWN_COUNT;
    su->numbers.tolerance_ppm = su->tolerance_ppm;
    su->numbers.value = su->value;
    su->numbers.covariance = su->covariance;
    su->numbers.slope = su->slope;
    su->numbers.moved = su->moved;
    su->offsets.count = SWAY_SUPERVISE_OFFSETS;
    su->offsets.tolerance_ppm = OFFSET_TOLERANCE;
    su->offsets.value = su->offset_value;
    su->offsets.covariance = su->offset_covariance;
    su->offsets.slope = su->offset_slope;
    su->offsets.moved = su->offset_moved;
    sway_kalman_reset(&su->offsets);
    reset_numbers(su);
}

/* --- offsets -----------------------------------------------------------------------------------
 */

/* So few numbers are taken in one slice. */
#if 2 * SWAY_SUPERVISE_OFFSETS * (SWAY_SUPERVISE_OFFSETS + 5) > SWAY_KALMAN_CHUNK
#error "SWAY_SUPERVISE_OFFSETS: more than one slice of sway_kalman"
#endif

/* Of r2 - r1 = 0, a1 - v r1 = bank, a2 - v r2 = bank, in micro-units. */
static void take_means(sway_supervise_t *su)
{
    static const int32_t base_micro[3] = {7000, 120000, 120000};
    static const uint8_t sensor[3][2] = {{2, 0}, {1, 0}, {3, 2}};
    const sway_real_t by_rows = sway_real_ratio(1, MEAN_ROWS);
    const sway_real_t speed = MUL(sway_real(su->sum_speed, 0), DIV(by_rows, sway_real_int(1000)));
    const sway_real_t turn =
        sway_real_abs(MUL(sway_real(su->sum_yaw_rate, 0), MUL(by_rows, sway_real_micro(1))));
    for (uint32_t k = 0; k < 3U; k++) {
        const sway_real_t mean = MUL(sway_real(su->sum[k], 0), by_rows);
        const sway_real_t power = MUL(sway_real(su->sum_of_squares[k], 0), by_rows);
        const sway_real_t spread = SUB(power, sway_real_square(mean));
        const sway_real_t arm = k == 0U ? sway_real_int(1) : speed;
        /* In a swing the mean over a window is a third of its spread; a turn adds what the trailer
         * lags and the bodies roll. */
        const sway_real_t bend = MUL(MUL(turn, arm), sway_real_ratio(k == 0U ? 15 : 6, 100));
        const sway_real_t still =
            MUL(sway_real_square(sway_real_micro(1)), DIV(spread, sway_real_int(11)));
        const sway_real_t variance =
            ADD(ADD(sway_real_square(sway_real_micro(base_micro[k])), sway_real_square(bend)),
                sway_real_max(still, sway_real_zero()));
        for (uint32_t i = 0; i < SWAY_SUPERVISE_OFFSETS; i++) {
            su->offset_slope[i] = sway_real_zero();
        }
        for (uint32_t late = 0; late <= OFFSET_LATELY; late += OFFSET_LATELY) {
            su->offset_slope[sensor[k][0] + late] = sway_real_int(-1);
            su->offset_slope[sensor[k][1] + late] = arm;
        }
        su->offset_slope[OFFSET_BANK] = sway_real_int(k == 0U ? 0 : -1);
        (void)sway_kalman_take(&su->offsets, MUL(mean, sway_real_micro(1)), variance);
    }
}

static int32_t integer(sway_real_t a, int32_t scale)
{
    return sway_real_to_int(a, scale, -INT32_MAX, INT32_MAX);
}

/* The offset that is worth most, if it is a finding ahead of the others. */
static void weigh_offsets(sway_supervise_t *su)
{
    int32_t best = 0;
    int32_t second = 0;
    uint32_t which = 0;
    for (uint32_t i = 0; i < 4U; i++) {
        const uint8_t group[2] = {(uint8_t)i, (uint8_t)(i + OFFSET_LATELY)};
        const int32_t worth = integer(sway_kalman_worth(&su->offsets, group, 2), 1) - 6;
        second = worth > best ? best : (worth > second ? worth : second);
        which = worth > best ? i : which;
        best = worth > best ? worth : best;
    }
    su->offset_mask = 0;
    if (best > SWAY_SUPERVISE_LIMIT && best - second > SWAY_SUPERVISE_LEAD) {
        const uint32_t late = which + OFFSET_LATELY;
        const sway_kalman_t *const all = &su->offsets;
        const sway_real_t variance = ADD(
            ADD(sway_kalman_covariance(all, which, which), sway_kalman_covariance(all, late, late)),
            sway_real_scale(sway_kalman_covariance(all, which, late), 1));
        const sway_real_t before = ADD(sway_real_square(sway_real_micro(OFFSET_TOLERANCE[which])),
                                       sway_real_square(sway_real_micro(OFFSET_TOLERANCE[late])));
        const sway_real_t free = DIV(before, SUB(before, variance)); // with a flat prior
        const sway_real_t offset = ADD(su->offset_value[which], su->offset_value[late]);
        su->offset_mask = SWAY_CHANNEL_BIT(MOTION[which]);
        su->finding.code = SWAY_FINDING_OFFSET + (int32_t)MOTION[which];
        su->finding.size_micro = integer(MUL(offset, free), 1000000);
        su->finding.se_micro = integer(sway_real_sqrt(MUL(variance, free)), 1000000);
    }
}

static int64_t clipped(int64_t value)
{
    const int64_t most = 100000000;
    return value > most ? most : (value < -most ? -most : value);
}

static void take_row_of_means(sway_supervise_t *su, const sway_row_t *row)
{
    const uint32_t needed = SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED) | SWAY_CHANNEL_BIT(MOTION[0]) |
                            SWAY_CHANNEL_BIT(MOTION[1]) | SWAY_CHANNEL_BIT(MOTION[2]) |
                            SWAY_CHANNEL_BIT(MOTION[3]);
    const int64_t speed = row->value[SWAY_CHANNEL_SPEED];
    if (row->restart || (row->valid_mask & needed) != needed || speed < 8333) {
        su->rows = 0;
        return;
    }
    if (su->rows == 0U) {
        memset(su->sum, 0, sizeof su->sum);
        memset(su->sum_of_squares, 0, sizeof su->sum_of_squares);
        su->sum_yaw_rate = 0;
        su->sum_speed = 0;
    }
    const int64_t rate = row->value[MOTION[0]];
    const int64_t rate_2 = row->value[MOTION[2]];
    const int64_t off[3] = {clipped(rate_2 - rate),
                            clipped(row->value[MOTION[1]] - speed * rate / 1000),
                            clipped(row->value[MOTION[3]] - speed * rate_2 / 1000)};
    for (uint32_t k = 0; k < 3U; k++) {
        su->sum[k] += off[k];
        su->sum_of_squares[k] += off[k] * off[k];
    }
    su->sum_yaw_rate += rate;
    su->sum_speed += speed;
    su->rows++;
    if (su->rows == MEAN_ROWS) {
        su->rows = 0;
        (void)sway_kalman_fade(&su->offsets, OFFSET_FADING, OFFSET_KEEP_PPM);
        take_means(su);
        weigh_offsets(su);
    }
}

/* --- relations ---------------------------------------------------------------------------------
 */

static sway_channel_t channel_of(uint32_t sensor)
{
    return sway_origin_of_channel((sway_origin_t)(sensor + 1U));
}

uint32_t sway_supervise_wanted(const sway_supervise_t *su)
{
    const uint32_t measured = su->measuring != 0U ? SWAY_CHANNEL_BIT(channel_of(su->measured)) : 0U;
    return ~su->rejected_mask | measured;
}

void sway_supervise_row(sway_supervise_t *su, const sway_row_t *row)
{
    take_row_of_means(su, row);
    if (sway_relations_add(&su->sums, row) && su->stage == STAGE_IDLE &&
        sway_relations_start(&su->relations, su->vehicle, &su->sums, su->sample_period_us)) {
        su->relation = 0;
        su->harmonic = SWAY_RELATIONS_FIRST - 1;
        su->stage = STAGE_FADE;
    }
}

/* A sixteenth of the way: four harmonics in each of four windows. */
static void fold(sway_real_t *mean, sway_real_t now, bool first)
{
    *mean = first ? now : ADD(*mean, sway_real_scale(SUB(now, *mean), -4));
}

/* State of the completed relation, by the tolerances before the drive. */
static void follow_relation(sway_supervise_t *su)
{
    const sway_relations_t *const re = &su->relations;
    sway_supervise_relation_t *const held = &su->held[su->relation];
    const bool first = held->state == (uint8_t)SWAY_RELATION_NOT_ASKED;
    sway_real_t allowed = sway_real_scale(sway_relations_variance(re), 1);
    for (uint32_t i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
        const sway_real_t tolerance = sway_real_square(sway_real_micro(TOLERANCE[i]));
        allowed = ADD(allowed, MUL(sway_complex_norm(re->slope[i]), tolerance));
    }
    fold(&held->residual, sway_complex_norm(re->residual), first);
    fold(&held->allowed, allowed, first);
    fold(&held->size, re->size_squared, first);
    if (sway_real_less(MUL(held->allowed, sway_real_int(9)), held->residual)) {
        held->state = (uint8_t)SWAY_RELATION_BREAKS;
    } else if (first || sway_real_less(held->residual, sway_real_scale(held->allowed, 2))) {
        held->state = (uint8_t)SWAY_RELATION_HOLDS;
    }
}

sway_relation_state_t sway_supervise_relation(const sway_supervise_t *su, sway_relation_t relation,
                                              int32_t *size_ppm, int32_t *deviation_ppm)
{
    const sway_supervise_relation_t *const held = &su->held[relation];
    *size_ppm = 0;
    *deviation_ppm = 0;
    if (held->state != (uint8_t)SWAY_RELATION_NOT_ASKED) {
        *size_ppm = integer(sway_real_sqrt(DIV(held->residual, held->size)), 1000000);
        *deviation_ppm = integer(sway_real_sqrt(DIV(held->allowed, held->size)), 1000000);
    }
    return (sway_relation_state_t)held->state;
}

/* The next harmonic of a relation, or the first one of the next relation that is allowed. */
static void next_relation(sway_supervise_t *su)
{
    su->harmonic++;
    if (su->harmonic > SWAY_RELATIONS_LAST) {
        su->harmonic = SWAY_RELATIONS_FIRST;
        su->relation++;
    }
    while (su->relation < SWAY_RELATION_COUNT &&
           !sway_relations_allow(&su->relations, (sway_relation_t)su->relation)) {
        su->held[su->relation].state = (uint8_t)SWAY_RELATION_NOT_ASKED;
        su->relation++;
    }
    su->explanation = 0;
    su->stage = STAGE_WEIGH;
    if (su->relation < SWAY_RELATION_COUNT) {
        sway_relations_begin(&su->relations, (sway_relation_t)su->relation, su->harmonic);
        su->stage = STAGE_TERMS;
    }
}

static sway_real_t believed_variance(const sway_supervise_t *su)
{
    const sway_real_t share = MUL(su->share[su->relation], BELIEVED);
    const sway_real_t assumed = sway_relations_variance(&su->relations);
    return sway_real_less(share, sway_real_int(1)) ? MUL(assumed, share) : assumed;
}

/* The value that was taken last joins the mean. */
static void learn_share(sway_supervise_t *su)
{
    sway_real_t *const share = &su->share[su->relation];
    uint8_t *const taken = &su->taken[su->relation];
    const sway_real_t innovation = DIV(su->numbers.gain, su->numbers.by_variance);
    const sway_real_t most = sway_real_scale(*share, 2);
    sway_real_t now = DIV(sway_real_square(innovation), sway_relations_variance(&su->relations));
    now = sway_real_less(now, most) ? now : most;
    *taken = (uint8_t)(*taken < TAKEN_MOST ? *taken + 1 : TAKEN_MOST);
    now = ADD(*share, DIV(SUB(now, *share), sway_real_int(*taken)));
    *share = sway_real_max(now, SHARE_LEAST);
}

static void take(sway_supervise_t *su, bool imaginary)
{
    const sway_relations_t *const re = &su->relations;
    if (su->numbers.row == 0U) {
        for (uint32_t i = 0; i < SWAY_UNKNOWN_COUNT; i++) {
            su->slope[i] = imaginary ? re->slope[i].im : re->slope[i].re;
        }
    }
    const sway_complex_t residual = re->residual;
    if (sway_kalman_take(&su->numbers, imaginary ? residual.im : residual.re,
                         believed_variance(su))) {
        return;
    }
    learn_share(su);
    if (imaginary) {
        next_relation(su);
    } else {
        su->stage = STAGE_IMAGINARY;
    }
}

/* --- what is the matter ------------------------------------------------------------------------
 */

/* A sensor by its gain and its phase, an accelerometer by its roll too. */
static uint32_t group_of(uint32_t explanation, uint8_t group[SWAY_KALMAN_GROUP])
{
    if (explanation < SWAY_SUPERVISE_SENSORS) {
        const sway_channel_t channel = channel_of(explanation);
        const bool on_trailer = channel == SWAY_CHANNEL_TRAILER_LATERAL_ACC;
        group[0] = (uint8_t)(2U * explanation);
        group[1] = (uint8_t)(2U * explanation + 1U);
        group[2] = (uint8_t)(SWAY_UNKNOWN_ROLL + (on_trailer ? 1 : 0));
        return on_trailer || channel == SWAY_CHANNEL_CAR_LATERAL_ACC ? 3U : 2U;
    }
    memcpy(group, BY_VEHICLE[explanation - SWAY_SUPERVISE_SENSORS].group, SWAY_KALMAN_GROUP);
    return BY_VEHICLE[explanation - SWAY_SUPERVISE_SENSORS].size;
}

/* Gain or delay of a sensor: what it shows is the truth over 1 + h. */
static sway_finding_report_t size_of_sensor(const sway_supervise_t *su, uint32_t sensor)
{
    sway_finding_report_t found = {0, 0, 0};
    sway_complex_t h;
    sway_real_t se;
    sway_real_t se_turn;
    sway_kalman_free(&su->numbers, 2U * sensor, &h.re, &se);
    sway_kalman_free(&su->numbers, 2U * sensor + 1U, &h.im, &se_turn);
    h.re = ADD(h.re, sway_real_int(1));
    const sway_real_t gain = DIV(h.re, sway_complex_norm(h));
    const sway_real_t turn = sway_complex_arg(h);
    const sway_real_t off = sway_real_abs(SUB(gain, sway_real_int(1)));
    if (sway_real_less(off, sway_real_abs(turn)) && sway_real_sign(h.re) > 0) {
        const sway_real_t by_omega = DIV(sway_real_ratio(1, 4), su->relations.bin_rad_s);
        found.code = SWAY_FINDING_DELAY;
        found.size_micro = integer(MUL(turn, by_omega), 1000000);
        found.se_micro = integer(MUL(se_turn, by_omega), 1000000);
    } else {
        found.code = SWAY_FINDING_GAIN;
        found.size_micro = integer(SUB(gain, sway_real_int(1)), 1000000);
        found.se_micro = integer(MUL(se, sway_real_square(gain)), 1000000);
    }
    found.code += (int32_t)channel_of(sensor);
    return found;
}

/* Numbers are estimated anew, these with a flat prior: the others had been bent to take their
 * place. */
static void lift(sway_supervise_t *su, const uint8_t *group, uint32_t size)
{
    memcpy(su->tolerance_ppm, TOLERANCE, sizeof TOLERANCE);
    for (uint32_t k = 0; k < size; k++) {
        const int32_t ten_times = 10 * TOLERANCE[group[k]];
        su->tolerance_ppm[group[k]] = ten_times > LIFTED_PPM ? ten_times : LIFTED_PPM;
    }
    sway_kalman_reset(&su->numbers);
}

static void report_sensor(sway_supervise_t *su, uint32_t sensor)
{
    const uint8_t group[2] = {(uint8_t)(2U * sensor), (uint8_t)(2U * sensor + 1U)};
    su->finding = size_of_sensor(su, sensor);
    su->rejected_mask |= SWAY_CHANNEL_BIT(channel_of(sensor));
    su->suspect_mask = 0;
    reset_numbers(su);
    su->measured = (uint8_t)sensor;
    su->measuring = (uint8_t)SWAY_SUPERVISE_MEASURED;
    lift(su, group, 2);
}

/* A sensor is reported at the first moment at which it is far enough off, which chance helps, and
 * from values that have partly faded: what the rounds after it say is free of both, and counts once
 * it is the more certain. */
static void measure_sensor(sway_supervise_t *su)
{
    const sway_finding_report_t now = size_of_sensor(su, su->measured);
    if (now.code == su->finding.code && now.se_micro > 0 && now.se_micro < su->finding.se_micro) {
        su->finding = now;
    }
    su->measuring--;
    if (su->measuring == 0U) {
        reset_numbers(su);
    }
}

static void report_vehicle(sway_supervise_t *su, uint32_t explanation)
{
    uint8_t group[SWAY_KALMAN_GROUP];
    const uint32_t size = group_of(explanation, group);
    lift(su, group, size);
    su->reported = (uint8_t)explanation;
}

/* Numbers whose sum over `parts` is the reported size: the change during the drive and what
 * the belief was off by are one to the user; of a trailer's two axles it is the mean. */
static uint32_t numbers_of_size(const sway_supervise_t *su, uint8_t number[4], uint32_t *parts)
{
    static const uint8_t configured[] = {0,
                                         SWAY_UNKNOWN_STIFFNESS,
                                         SWAY_UNKNOWN_STIFFNESS + 1,
                                         SWAY_UNKNOWN_STIFFNESS + 3,
                                         SWAY_UNKNOWN_TRAILER_PLACE,
                                         0};
    uint8_t group[SWAY_KALMAN_GROUP];
    (void)group_of(su->reported, group);
    const bool axles =
        su->reported == (uint8_t)EXPLAIN_TRAILER_TYRES && su->vehicle->trailer.axles == 2;
    *parts = axles ? 2U : 1U;
    number[0] = group[0];
    number[1] = configured[su->reported - SWAY_SUPERVISE_SENSORS];
    number[2] = group[1];
    number[3] = SWAY_UNKNOWN_STIFFNESS + 2;
    return axles ? 4U : (number[1] != 0U ? 2U : 1U);
}

static void follow_vehicle(sway_supervise_t *su)
{
    uint8_t number[4];
    uint32_t parts;
    sway_real_t value = sway_real_zero();
    sway_real_t variance = sway_real_zero();
    if (su->reported >= SWAY_SUPERVISE_EXPLANATIONS) {
        return;
    }
    const uint32_t count = numbers_of_size(su, number, &parts);
    for (uint32_t i = 0; i < count; i++) {
        value = ADD(value, su->value[number[i]]);
        for (uint32_t j = 0; j < count; j++) {
            variance = ADD(variance, sway_kalman_covariance(&su->numbers, number[i], number[j]));
        }
    }
    sway_real_t share = sway_real_ratio(1, (int32_t)parts);
    value = MUL(value, share);
    if (su->reported == (uint8_t)EXPLAIN_SPEED) { // relations are linear in 1 / speed
        const sway_real_t rest = SUB(sway_real_int(1), value);
        value = DIV(value, rest);
        share = DIV(sway_real_int(1), sway_real_square(rest));
    }
    su->finding.code = BY_VEHICLE[su->reported - SWAY_SUPERVISE_SENSORS].finding;
    su->finding.size_micro = integer(value, 1000000);
    su->finding.se_micro = integer(MUL(sway_real_sqrt(variance), share), 1000000);
}

static void weigh_one(sway_supervise_t *su)
{
    uint8_t group[SWAY_KALMAN_GROUP];
    const uint32_t size = group_of(su->explanation, group);
    su->score_milli[su->explanation] =
        su->explanation == su->reported
            ? 0
            : sway_real_to_int(sway_kalman_worth(&su->numbers, group, size), 1000, 0, 1000000000) -
                  3000 * (int32_t)size;
    su->explanation++;
}

/* Sensors among the explanations that are as good as the best one. */
static uint32_t suspect_sensors(const sway_supervise_t *su, int32_t best_milli)
{
    uint32_t mask = 0;
    for (uint32_t i = 0; i < SWAY_SUPERVISE_SENSORS; i++) {
        if (su->score_milli[i] > best_milli - 1000 * SWAY_SUPERVISE_LEAD) {
            mask |= SWAY_CHANNEL_BIT(channel_of(i));
        }
    }
    return mask;
}

static void judge_explanations(sway_supervise_t *su)
{
    if (su->measuring != 0U) {
        measure_sensor(su);
        return;
    }
    uint32_t best = 0;
    for (uint32_t i = 1; i < SWAY_SUPERVISE_EXPLANATIONS; i++) {
        best = su->score_milli[i] > su->score_milli[best] ? i : best;
    }
    const int32_t most = su->score_milli[best];
    bool ahead = most > 1000 * SWAY_SUPERVISE_LIMIT;
    const bool finding = ahead;
    for (uint32_t i = 0; i < SWAY_SUPERVISE_EXPLANATIONS; i++) {
        ahead = ahead && (i == best || su->score_milli[i] <= most - 1000 * SWAY_SUPERVISE_LEAD);
    }
    const bool again = ahead && su->candidate == best;
    su->candidate = (uint8_t)(ahead ? best : SWAY_SUPERVISE_EXPLANATIONS);
    su->suspect_mask = finding && su->unresolved ? suspect_sensors(su, most) : 0U;
    su->unresolved = finding;
    su->rounds++;
    if (again && best < SWAY_SUPERVISE_SENSORS) {
        report_sensor(su, best);
    } else if (again && best < EXPLAIN_CAR) {
        report_vehicle(su, best);
    }
    follow_vehicle(su);
}

/* Numbers of the sensor that is being measured, which do not fade. */
static uint64_t lasting(const sway_supervise_t *su)
{
    return su->measuring != 0U ? UINT64_C(3) << (2U * su->measured) : 0U;
}

bool sway_supervise_run(sway_supervise_t *su)
{
    switch (su->stage) {
    case STAGE_FADE:
        if (!sway_kalman_fade(&su->numbers, FADING & ~lasting(su), KEEP_PPM)) {
            next_relation(su);
        }
        return true;
    case STAGE_TERMS:
        if (su->relations.term == 0U && !sway_relations_is_driven(&su->relations)) {
            next_relation(su);
        } else if (!sway_relations_run(&su->relations)) {
            su->stage = STAGE_HOLD;
        }
        return true;
    case STAGE_HOLD:
        follow_relation(su);
        su->stage = STAGE_REAL;
        return true;
    case STAGE_REAL:
    case STAGE_IMAGINARY:
        take(su, su->stage == STAGE_IMAGINARY);
        return true;
    case STAGE_WEIGH:
        weigh_one(su);
        if (su->explanation == SWAY_SUPERVISE_EXPLANATIONS) {
            su->stage = STAGE_IDLE;
            judge_explanations(su);
        }
        return true;
    default:
        return false;
    }
}

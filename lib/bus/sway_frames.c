// SPDX-License-Identifier: MIT
#include "bus/sway_frames.h"

#include <stddef.h>
#include <string.h>

#include "arithmetic/sway_int64.h"
#include "bus/sway_e2e.h"
#include "swaywatch_dbc.h"

#define NOT_AVAILABLE UINT16_C(0xFFFF)
#define NOT_AVAILABLE_SIGNED UINT16_C(0x8000)
#define CENTIDEGREE_NRAD_MILLI INT64_C(174532925199) // 0.01 deg in 1e-9 urad
#define NANO INT64_C(1000000000)

/* --- integers ----------------------------------------------------------------------------------
 */

static int64_t ratio(int64_t value, int64_t numerator, int64_t denominator)
{
    const int64_t product = value * numerator;
    const int64_t half = product < 0 ? -(denominator / 2) : denominator / 2;
    return sway_int64_divide(product + half, denominator);
}

static int64_t clip(int64_t value, int64_t low, int64_t high)
{
    return value < low ? low : (value > high ? high : value);
}

/* Raw values by values of the status. */
enum {
    PER_1,
    PER_10,
    PER_20,
    PER_100,
    PER_1000,
    PER_4000,
    PER_5000,
    PER_20000,
    CENTI_KMH,   // of mm/s
    CENTIDEGREE, // of microradian
    FLAGS        // a bit each: all 16 of them may be set
};

static const struct {
    int64_t numerator;
    int64_t denominator;
} UNITS[] = {
    [PER_1] = {1, 1},       [PER_10] = {1, 10},
    [PER_20] = {1, 20},     [PER_100] = {1, 100},
    [PER_1000] = {1, 1000}, [PER_4000] = {1, 4000},
    [PER_5000] = {1, 5000}, [PER_20000] = {1, 20000},
    [CENTI_KMH] = {9, 25},  [CENTIDEGREE] = {NANO, CENTIDEGREE_NRAD_MILLI},
};

/* 16 bits of a frame: at most its range's end, which is not the code for "not available". */
static uint16_t raw_word(int32_t value, uint8_t unit, bool is_signed)
{
    const int64_t raw = ratio(value, UNITS[unit].numerator, UNITS[unit].denominator);
    const int64_t low = is_signed ? INT16_MIN + 1 : 0;
    return (uint16_t)clip(raw, low, low + (UINT16_MAX - 1));
}

static uint16_t count_u16(uint32_t count)
{
    return count > UINT16_MAX ? UINT16_MAX : (uint16_t)count;
}

static uint8_t count_u8(uint32_t count)
{
    return count > UINT8_MAX ? UINT8_MAX : (uint8_t)count;
}

static uint8_t bit(uint32_t word, uint32_t mask)
{
    return (word & mask) != 0U ? 1U : 0U;
}

static int32_t from_decidegree(int32_t raw)
{
    return (int32_t)ratio(raw, 10 * CENTIDEGREE_NRAD_MILLI, NANO);
}

static int32_t from_centidegree(int32_t raw)
{
    return (int32_t)ratio(raw, CENTIDEGREE_NRAD_MILLI, NANO);
}

static int32_t from_acc(int32_t raw)
{
    return raw * 2000;
}

static int32_t from_newton(int32_t raw)
{
    return raw * 1000;
}

/* --- identifiers -------------------------------------------------------------------------------
 */

static const uint16_t input_id[SWAY_MESSAGE_COUNT] = {
    SWAYWATCH_DBC_SWAY_STEERING_FRAME_ID,         SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID,
    SWAYWATCH_DBC_SWAY_CAR_MOTION_FRAME_ID,       SWAYWATCH_DBC_SWAY_TRAILER_MOTION_FRAME_ID,
    SWAYWATCH_DBC_SWAY_ARTICULATION_FRAME_ID,     SWAYWATCH_DBC_SWAY_HITCH_FORCES_FRAME_ID,
    SWAYWATCH_DBC_SWAY_CAR_WHEEL_FL_FRAME_ID,     SWAYWATCH_DBC_SWAY_CAR_WHEEL_FR_FRAME_ID,
    SWAYWATCH_DBC_SWAY_CAR_WHEEL_RL_FRAME_ID,     SWAYWATCH_DBC_SWAY_CAR_WHEEL_RR_FRAME_ID,
    SWAYWATCH_DBC_SWAY_TRAILER_WHEEL_FL_FRAME_ID, SWAYWATCH_DBC_SWAY_TRAILER_WHEEL_FR_FRAME_ID,
    SWAYWATCH_DBC_SWAY_TRAILER_WHEEL_RL_FRAME_ID, SWAYWATCH_DBC_SWAY_TRAILER_WHEEL_RR_FRAME_ID};

sway_message_t sway_frames_find(uint32_t can_id)
{
    uint32_t found = 0U;
    while (found < (uint32_t)SWAY_MESSAGE_COUNT && input_id[found] != can_id) {
        found++;
    }
    return (sway_message_t)found;
}

uint32_t sway_frames_input_id(sway_message_t message)
{
    return input_id[message];
}

sway_message_t sway_frames_message_of(sway_input_t input)
{
    static const uint8_t of_motion[] = {SWAY_MESSAGE_STEERING,       SWAY_MESSAGE_CAR_MOTION,
                                        SWAY_MESSAGE_CAR_MOTION,     SWAY_MESSAGE_TRAILER_MOTION,
                                        SWAY_MESSAGE_TRAILER_MOTION, SWAY_MESSAGE_ARTICULATION,
                                        SWAY_MESSAGE_HITCH_FORCES,   SWAY_MESSAGE_HITCH_FORCES};
    if (input == SWAY_INPUT_SPEED) {
        return SWAY_MESSAGE_SPEED;
    }
    if (input < SWAY_INPUT_CAR_FY_FL) {
        return (sway_message_t)of_motion[input];
    }
    const uint32_t number = (uint32_t)input - (uint32_t)SWAY_INPUT_CAR_FY_FL;
    const uint32_t first = input < SWAY_INPUT_TRAILER_FY_FL ? SWAY_MESSAGE_CAR_WHEEL_FL
                                                            : SWAY_MESSAGE_TRAILER_WHEEL_FL;
    return (sway_message_t)(first + number % 4U);
}

/* --- what comes in -----------------------------------------------------------------------------
 */

static void sample(sway_sample_t *to, sway_input_t input, uint8_t validity, int32_t value)
{
    to->input = input;
    to->value = value;
    to->valid = validity == SWAYWATCH_DBC_SWAY_STEERING_STEERING_WHEEL_ANGLE_VALIDITY_VALID_CHOICE;
}

static uint32_t decode_steering(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_steering_t m;
    (void)swaywatch_dbc_sway_steering_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_STEERING_WHEEL_ANGLE, m.steering_wheel_angle_validity,
           from_decidegree(m.steering_wheel_angle));
    return 1U;
}

static uint32_t decode_speed(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_speed_t m;
    (void)swaywatch_dbc_sway_speed_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_SPEED, m.vehicle_speed_validity,
           (int32_t)ratio(m.vehicle_speed, 25, 9));
    return 1U;
}

static uint32_t decode_car_motion(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_car_motion_t m;
    (void)swaywatch_dbc_sway_car_motion_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_CAR_YAW_RATE, m.car_yaw_rate_validity,
           from_centidegree(m.car_yaw_rate));
    sample(&to[1], SWAY_INPUT_CAR_LATERAL_ACC, m.car_lateral_acc_validity,
           from_acc(m.car_lateral_acc));
    return 2U;
}

static uint32_t decode_trailer_motion(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_trailer_motion_t m;
    (void)swaywatch_dbc_sway_trailer_motion_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_TRAILER_YAW_RATE, m.trailer_yaw_rate_validity,
           from_centidegree(m.trailer_yaw_rate));
    sample(&to[1], SWAY_INPUT_TRAILER_LATERAL_ACC, m.trailer_lateral_acc_validity,
           from_acc(m.trailer_lateral_acc));
    return 2U;
}

static uint32_t decode_articulation(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_articulation_t m;
    (void)swaywatch_dbc_sway_articulation_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_ARTICULATION, m.articulation_angle_validity,
           from_centidegree(m.articulation_angle));
    return 1U;
}

static uint32_t decode_hitch_forces(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_hitch_forces_t m;
    (void)swaywatch_dbc_sway_hitch_forces_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], SWAY_INPUT_HITCH_FX, m.hitch_forces_validity, from_newton(m.hitch_fx));
    sample(&to[1], SWAY_INPUT_HITCH_FY, m.hitch_forces_validity, from_newton(m.hitch_fy));
    return 2U;
}

static uint32_t decode_wheel(uint32_t wheel, const uint8_t *data, sway_sample_t *to)
{
    static const struct {
        sway_input_t fy;
        sway_input_t fz;
    } inputs[] = {{SWAY_INPUT_CAR_FY_FL, SWAY_INPUT_CAR_FZ_FL},
                  {SWAY_INPUT_CAR_FY_FR, SWAY_INPUT_CAR_FZ_FR},
                  {SWAY_INPUT_CAR_FY_RL, SWAY_INPUT_CAR_FZ_RL},
                  {SWAY_INPUT_CAR_FY_RR, SWAY_INPUT_CAR_FZ_RR},
                  {SWAY_INPUT_TRAILER_FY_FL, SWAY_INPUT_TRAILER_FZ_FL},
                  {SWAY_INPUT_TRAILER_FY_FR, SWAY_INPUT_TRAILER_FZ_FR},
                  {SWAY_INPUT_TRAILER_FY_RL, SWAY_INPUT_TRAILER_FZ_RL},
                  {SWAY_INPUT_TRAILER_FY_RR, SWAY_INPUT_TRAILER_FZ_RR}};
    struct swaywatch_dbc_sway_car_wheel_fl_t m;
    (void)swaywatch_dbc_sway_car_wheel_fl_unpack(&m, data, SWAY_E2E_LENGTH);
    sample(&to[0], inputs[wheel].fy, m.car_wheel_fl_fy_validity, from_newton(m.car_wheel_fl_fy));
    sample(&to[1], inputs[wheel].fz, m.car_wheel_fl_fz_validity, from_newton(m.car_wheel_fl_fz));
    return 2U;
}

uint32_t sway_frames_decode(sway_message_t message, const uint8_t *data, sway_sample_t *samples)
{
    static uint32_t (*const decode[])(const uint8_t *, sway_sample_t *) = {
        decode_steering,       decode_speed,        decode_car_motion,
        decode_trailer_motion, decode_articulation, decode_hitch_forces};
    return message < SWAY_MESSAGE_CAR_WHEEL_FL
               ? decode[message](data, samples)
               : decode_wheel((uint32_t)message - (uint32_t)SWAY_MESSAGE_CAR_WHEEL_FL, data,
                              samples);
}

/* --- what goes out -----------------------------------------------------------------------------
 */

static uint8_t estimate(const sway_status_t *s)
{
    return (uint8_t)(s->sequence & 0x0FU);
}

static bool valid(const sway_status_t *s, uint32_t mask)
{
    return (s->valid & mask) != 0U;
}

static void encode_alarm(const sway_frames_source_t *source, uint8_t *data)
{
    const sway_status_t *s = source->status;
    const bool off = source->blind;
    const uint32_t reasons = off ? 0U : s->reasons;
    const uint32_t lacking = s->missing_inputs | s->suspect_inputs | s->rejected_inputs;
    const bool timed = !off && valid(s, SWAY_VALID_TIME_TO_LIMIT);
    const struct swaywatch_dbc_sway_alarm_t m = {
        .alarm_estimate = estimate(s),
        .alarm_state = off ? (uint8_t)SWAY_ALARM_OFF : (uint8_t)s->alarm,
        .critical_speed_source = (uint8_t)s->source,
        .damping_source = (uint8_t)s->belief,
        .critical_speed_kind = (uint8_t)s->v_crit_kind,
        .reason_small_margin = bit(reasons, SWAY_REASON_SMALL_MARGIN),
        .reason_above_critical_speed = bit(reasons, SWAY_REASON_ABOVE_CRITICAL_SPEED),
        .reason_low_damping = bit(reasons, SWAY_REASON_LOW_DAMPING),
        .reason_growing = bit(reasons, SWAY_REASON_GROWING),
        .reason_large_amplitude = bit(reasons, SWAY_REASON_LARGE_AMPLITUDE),
        .reason_short_time = bit(reasons, SWAY_REASON_SHORT_TIME),
        .reason_static = bit(reasons, SWAY_REASON_STATIC),
        .inputs_lost = source->inputs_lost ? 1U : 0U,
        .judgement_degraded = lacking != 0U ? 1U : 0U,
        .time_to_limit = timed ? raw_word(s->time_to_limit_ms, PER_10, false) : NOT_AVAILABLE,
    };
    (void)swaywatch_dbc_sway_alarm_pack(data, &m, SWAY_E2E_LENGTH);
}

/* --- three words and the number of the estimate ---------------------------------------------- */

typedef struct {
    uint32_t valid;  // bits that have to be set; those of the first axle
    uint16_t offset; // of the int32_t in the status; that of the first axle
    uint8_t unit;
    bool is_signed;
} word_t;

enum {
    KIND_AXLES = SWAY_OUTPUT_STIFFNESS - SWAY_OUTPUT_MARGIN,
    KIND_INERTIA = KIND_AXLES + 3,
    KIND_JUDGEMENT // findings and relations behind it
};

#define OF(field) (uint16_t) offsetof(sway_status_t, field)

/* By kind of output: those before the axles, three of an axle, the inertias. */
static const word_t WORDS[][3] = {
    {{SWAY_VALID_CRITICAL_SPEED, OF(v_crit_mm_s), CENTI_KMH, false},
     {SWAY_VALID_CRITICAL_SPEED, OF(v_crit_se_mm_s), CENTI_KMH, false},
     {SWAY_VALID_CRITICAL_SPEED | SWAY_VALID_SPEED, OF(margin_mm_s), CENTI_KMH, true}},
    {{SWAY_VALID_MARGIN, OF(margin_damping_ratio_ppm), PER_100, true},
     {SWAY_VALID_MARGIN, OF(margin_damping_ratio_se_ppm), PER_100, false},
     {SWAY_VALID_MODEL, OF(model_damping_ratio_ppm), PER_100, true}},
    {{SWAY_VALID_LINE, OF(damping_ratio_ppm), PER_100, true},
     {SWAY_VALID_LINE, OF(damping_ratio_se_ppm), PER_100, false},
     {SWAY_VALID_LINE, OF(growth_ppm_per_s), PER_1000, true}},
    {{SWAY_VALID_LINE, OF(frequency_uhz), PER_100, false},
     {SWAY_VALID_LINE, OF(frequency_se_uhz), PER_10, false},
     {SWAY_VALID_LINE, OF(amplitude_urad_s), CENTIDEGREE, false}},
    {{SWAY_VALID_MODEL, OF(model_frequency_uhz), PER_100, false},
     {SWAY_VALID_MODEL, OF(model_damping_ratio_se_ppm), PER_100, false},
     {SWAY_VALID_SPEED, OF(speed_mm_s), CENTI_KMH, false}},
    {{SWAY_VALID_CAR_FRONT, OF(axle[0].cornering_stiffness_n_per_rad), PER_20, false},
     {SWAY_VALID_CAR_FRONT, OF(axle[0].cornering_stiffness_se_n_per_rad), PER_20, false},
     {SWAY_VALID_CAR_FRONT, OF(axle[0].argument_urad), CENTIDEGREE, true}},
    {{SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].effective_load_mn), PER_4000, true},
     {SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].effective_load_se_mn), PER_4000, false},
     {SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].load_harmonic_mn), PER_4000, false}},
    {{SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].normalised_stiffness_milli_per_rad), PER_1, false},
     {SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].lateral_friction_ppm), PER_100, false},
     {SWAY_VALID_CAR_FRONT_LOAD, OF(axle[0].load_harmonic_phase_urad), CENTIDEGREE, true}},
    {{SWAY_VALID_CAR_INERTIA, OF(car_yaw_inertia_gm2), PER_5000, false},
     {SWAY_VALID_TRAILER_INERTIA, OF(trailer_yaw_inertia_gm2), PER_20000, false},
     {SWAY_VALID_TRAILER_INERTIA, OF(trailer_yaw_inertia_se_gm2), PER_20000, false}},
    {{0U, OF(missing_inputs), FLAGS, false},
     {0U, OF(suspect_inputs), FLAGS, false},
     {0U, OF(rejected_inputs), FLAGS, false}},
#if SWAY_SUPERVISION
    {{0U, OF(finding), PER_1, false},
     {0U, OF(finding_size_micro), PER_1000, true},
     {0U, OF(finding_se_micro), PER_1000, false}},
    {{0U, OF(relation), PER_1, false},
     {0U, OF(relation_ppm), PER_1000, false},
     {0U, OF(relation_se_ppm), PER_1000, false}},
#endif
#if SWAY_SWING
    {{SWAY_VALID_LOWEST_SPEED, OF(lowest_v_crit_mm_s), CENTI_KMH, false},
     {SWAY_VALID_LOWEST_SPEED, OF(lowest_v_crit_se_mm_s), CENTI_KMH, false},
     {SWAY_VALID_LOWEST_SPEED, OF(lowest_v_crit_swing_urad_s), CENTIDEGREE, false}},
#endif
};

static uint16_t word_of(const sway_status_t *s, const word_t *word, uint32_t axle)
{
    const uint8_t *const field = (const uint8_t *)s + word->offset;
    const uint32_t needed = word->valid << axle;
    int32_t value;
    if ((s->valid & needed) != needed) {
        return word->is_signed ? NOT_AVAILABLE_SIGNED : NOT_AVAILABLE;
    }
    (void)memcpy(&value, field + axle * sizeof s->axle[0], sizeof value);
    return word->unit == FLAGS ? (uint16_t)value : raw_word(value, word->unit, word->is_signed);
}

/* All of them lie in their frames as in that of the oscillation. */
static void encode_words(sway_output_t output, const sway_status_t *s, uint8_t *data)
{
    const uint32_t behind = (uint32_t)output - (uint32_t)SWAY_OUTPUT_STIFFNESS;
    uint32_t kind = (uint32_t)output - (uint32_t)SWAY_OUTPUT_MARGIN;
    uint32_t axle = 0U;
    if (output == SWAY_OUTPUT_INERTIA) {
        kind = KIND_INERTIA;
    } else if (output >= SWAY_OUTPUT_JUDGEMENT) {
        kind = (uint32_t)KIND_JUDGEMENT + ((uint32_t)output - (uint32_t)SWAY_OUTPUT_JUDGEMENT);
    } else if (output >= SWAY_OUTPUT_STIFFNESS) {
        kind = (uint32_t)KIND_AXLES + behind / (uint32_t)SWAY_AXLE_COUNT;
        axle = behind % (uint32_t)SWAY_AXLE_COUNT;
    }
    const word_t *const words = WORDS[kind];
    const struct swaywatch_dbc_sway_oscillation_t m = {
        .oscillation_estimate = estimate(s),
        .frequency = word_of(s, &words[0], axle),
        .frequency_error = word_of(s, &words[1], axle),
        .amplitude = word_of(s, &words[2], axle),
    };
    (void)swaywatch_dbc_sway_oscillation_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_quality(const sway_status_t *s, uint8_t *data)
{
    const struct swaywatch_dbc_sway_quality_t m = {
        .quality_no_oscillation = bit(s->quality, SWAY_QUALITY_NO_OSCILLATION),
        .quality_forced = bit(s->quality, SWAY_QUALITY_FORCED),
        .quality_gap = bit(s->quality, SWAY_QUALITY_GAP),
        .quality_speed_changing = bit(s->quality, SWAY_QUALITY_SPEED_CHANGING),
        .quality_nonlinear = bit(s->quality, SWAY_QUALITY_NONLINEAR),
        .quality_seeking = bit(s->quality, SWAY_QUALITY_SEEKING),
        .quality_slow = bit(s->quality, SWAY_QUALITY_SLOW),
        .quality_no_speed = bit(s->quality, SWAY_QUALITY_NO_SPEED),
        .quality_singular = bit(s->quality, SWAY_QUALITY_SINGULAR),
        .quality_missing_input = bit(s->quality, SWAY_QUALITY_MISSING_INPUT),
        .quality_model_disagrees = bit(s->quality, SWAY_QUALITY_MODEL_DISAGREES),
        .quality_equal_split = bit(s->quality, SWAY_QUALITY_EQUAL_SPLIT),
        .quality_user_inertia = bit(s->quality, SWAY_QUALITY_USER_INERTIA),
        .quality_misfit = bit(s->quality, SWAY_QUALITY_MISFIT),
        .quality_hitch = bit(s->quality, SWAY_QUALITY_HITCH),
        .quality_small_swing = bit(s->quality, SWAY_QUALITY_SMALL_SWING),
        .quality_unexplained = bit(s->quality, SWAY_QUALITY_UNEXPLAINED),
        .window_length = (uint16_t)clip(s->window_ms, 0, UINT16_MAX),
        .estimate_number = (uint16_t)(s->sequence & 0xFFFFU),
    };
    (void)swaywatch_dbc_sway_quality_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_faults_samples(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_samples_t m = {
        .fault_range = count_u16(source->status->fault_count[SWAY_FAULT_RANGE]),
        .fault_time = count_u16(source->status->fault_count[SWAY_FAULT_TIME]),
        .fault_invalid = count_u16(source->status->fault_count[SWAY_FAULT_INVALID]),
    };
    (void)swaywatch_dbc_sway_faults_samples_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_faults_estimates(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_estimates_t m = {
        .fault_gap = count_u16(source->status->fault_count[SWAY_FAULT_GAP]),
        .fault_singular = count_u16(source->status->fault_count[SWAY_FAULT_SINGULAR]),
        .fault_overrun = count_u8(source->status->fault_count[SWAY_FAULT_OVERRUN]),
        .fault_rate = count_u8(source->status->fault_count[SWAY_FAULT_RATE]),
    };
    (void)swaywatch_dbc_sway_faults_estimates_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_faults_frames(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_frames_t m = {
        .fault_crc = count_u16(source->frame_fault[SWAY_FRAME_FAULT_CRC]),
        .fault_lost = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LOST]),
        .fault_repeated = count_u16(source->frame_fault[SWAY_FRAME_FAULT_REPEATED]),
    };
    (void)swaywatch_dbc_sway_faults_frames_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_faults_order(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_order_t m = {
        .fault_late = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LATE]),
        .fault_length = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LENGTH]),
        .fault_timeout = count_u16(source->frame_fault[SWAY_FRAME_FAULT_TIMEOUT]),
    };
    (void)swaywatch_dbc_sway_faults_order_pack(data, &m, SWAY_E2E_LENGTH);
}

static void encode_inputs(const sway_frames_source_t *source, uint8_t *data)
{
    const uint8_t *state = source->message_state;
    const struct swaywatch_dbc_sway_inputs_t m = {
        .input_steering = state[SWAY_MESSAGE_STEERING],
        .input_speed = state[SWAY_MESSAGE_SPEED],
        .input_car_motion = state[SWAY_MESSAGE_CAR_MOTION],
        .input_trailer_motion = state[SWAY_MESSAGE_TRAILER_MOTION],
        .input_articulation = state[SWAY_MESSAGE_ARTICULATION],
        .input_hitch_forces = state[SWAY_MESSAGE_HITCH_FORCES],
        .input_car_wheel_fl = state[SWAY_MESSAGE_CAR_WHEEL_FL],
        .input_car_wheel_fr = state[SWAY_MESSAGE_CAR_WHEEL_FR],
        .input_car_wheel_rl = state[SWAY_MESSAGE_CAR_WHEEL_RL],
        .input_car_wheel_rr = state[SWAY_MESSAGE_CAR_WHEEL_RR],
        .input_trailer_wheel_fl = state[SWAY_MESSAGE_TRAILER_WHEEL_FL],
        .input_trailer_wheel_fr = state[SWAY_MESSAGE_TRAILER_WHEEL_FR],
        .input_trailer_wheel_rl = state[SWAY_MESSAGE_TRAILER_WHEEL_RL],
        .input_trailer_wheel_rr = state[SWAY_MESSAGE_TRAILER_WHEEL_RR],
        .fault_stuck = count_u8(source->frame_fault[SWAY_FRAME_FAULT_STUCK]),
        .fault_frozen = count_u8(source->frame_fault[SWAY_FRAME_FAULT_FROZEN]),
    };
    (void)swaywatch_dbc_sway_inputs_pack(data, &m, SWAY_E2E_LENGTH);
}

uint32_t sway_frames_output_id(sway_output_t output)
{
    return (uint32_t)SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID + (uint32_t)output;
}

void sway_frames_encode(sway_output_t output, const sway_frames_source_t *source, uint8_t *data)
{
    static void (*const last[])(const sway_frames_source_t *, uint8_t *) = {
        encode_faults_samples, encode_faults_estimates, encode_faults_frames, encode_faults_order,
        encode_inputs};
    if (output == SWAY_OUTPUT_ALARM) {
        encode_alarm(source, data);
    } else if (output <= SWAY_OUTPUT_INERTIA || output >= SWAY_OUTPUT_JUDGEMENT) {
        encode_words(output, source->status, data);
    } else if (output == SWAY_OUTPUT_QUALITY) {
        encode_quality(source->status, data);
    } else {
        last[output - SWAY_OUTPUT_FAULTS_SAMPLES](source, data);
    }
}

#include "sway_frames.h"

#include <string.h>

#include "sway_wide.h"
#include "swaywatch_dbc.h"

#define NOT_AVAILABLE_U16 UINT16_MAX
#define NOT_AVAILABLE_S16 INT16_MIN
#define CENTIDEGREE_NRAD_MILLI INT64_C(174532925199) // 0.01 deg in 1e-9 urad
#define NANO INT64_C(1000000000)

/* --- integers ----------------------------------------------------------------------------------
 */

static int64_t ratio(int64_t value, int64_t numerator, int64_t denominator)
{
    const int64_t product = value * numerator;
    const int64_t half = product < 0 ? -(denominator / 2) : denominator / 2;
    return sway_wide_divide(product + half, denominator);
}

static int64_t clip(int64_t value, int64_t low, int64_t high)
{
    return value < low ? low : (value > high ? high : value);
}

static uint16_t raw_u16(bool valid, int64_t value, int64_t numerator, int64_t denominator)
{
    return valid ? (uint16_t)clip(ratio(value, numerator, denominator), 0, UINT16_MAX - 1)
                 : NOT_AVAILABLE_U16;
}

static int16_t raw_s16(bool valid, int64_t value, int64_t numerator, int64_t denominator)
{
    return valid ? (int16_t)clip(ratio(value, numerator, denominator), INT16_MIN + 1, INT16_MAX)
                 : NOT_AVAILABLE_S16;
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

static int16_t to_centidegree(bool valid, int32_t urad)
{
    return raw_s16(valid, urad, NANO, CENTIDEGREE_NRAD_MILLI);
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
    (void)swaywatch_dbc_sway_steering_unpack(&m, data, 8U);
    sample(&to[0], SWAY_INPUT_STEERING_WHEEL_ANGLE, m.steering_wheel_angle_validity,
           from_decidegree(m.steering_wheel_angle));
    return 1U;
}

static uint32_t decode_speed(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_speed_t m;
    (void)swaywatch_dbc_sway_speed_unpack(&m, data, 8U);
    sample(&to[0], SWAY_INPUT_SPEED, m.vehicle_speed_validity,
           (int32_t)ratio(m.vehicle_speed, 25, 9));
    return 1U;
}

static uint32_t decode_car_motion(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_car_motion_t m;
    (void)swaywatch_dbc_sway_car_motion_unpack(&m, data, 8U);
    sample(&to[0], SWAY_INPUT_CAR_YAW_RATE, m.car_yaw_rate_validity,
           from_centidegree(m.car_yaw_rate));
    sample(&to[1], SWAY_INPUT_CAR_LATERAL_ACC, m.car_lateral_acc_validity,
           from_acc(m.car_lateral_acc));
    return 2U;
}

static uint32_t decode_trailer_motion(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_trailer_motion_t m;
    (void)swaywatch_dbc_sway_trailer_motion_unpack(&m, data, 8U);
    sample(&to[0], SWAY_INPUT_TRAILER_YAW_RATE, m.trailer_yaw_rate_validity,
           from_centidegree(m.trailer_yaw_rate));
    sample(&to[1], SWAY_INPUT_TRAILER_LATERAL_ACC, m.trailer_lateral_acc_validity,
           from_acc(m.trailer_lateral_acc));
    return 2U;
}

static uint32_t decode_articulation(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_articulation_t m;
    (void)swaywatch_dbc_sway_articulation_unpack(&m, data, 8U);
    sample(&to[0], SWAY_INPUT_ARTICULATION, m.articulation_angle_validity,
           from_centidegree(m.articulation_angle));
    return 1U;
}

static uint32_t decode_hitch_forces(const uint8_t *data, sway_sample_t *to)
{
    struct swaywatch_dbc_sway_hitch_forces_t m;
    (void)swaywatch_dbc_sway_hitch_forces_unpack(&m, data, 8U);
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
    (void)swaywatch_dbc_sway_car_wheel_fl_unpack(&m, data, 8U);
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
    const bool off = source->inputs_lost;
    const uint32_t reasons = off ? 0U : s->reasons;
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
        .inputs_lost = off ? 1U : 0U,
        .time_to_limit = raw_u16(timed, s->time_to_limit_ms, 1, 10),
    };
    (void)swaywatch_dbc_sway_alarm_pack(data, &m, 8U);
}

static void encode_margin(const sway_status_t *s, uint8_t *data)
{
    const bool found = valid(s, SWAY_VALID_CRITICAL_SPEED);
    const struct swaywatch_dbc_sway_margin_t m = {
        .margin_estimate = estimate(s),
        .critical_speed = raw_u16(found, s->v_crit_mm_s, 9, 25),
        .critical_speed_error = raw_u16(found, s->v_crit_se_mm_s, 9, 25),
        .speed_margin = raw_s16(found && valid(s, SWAY_VALID_SPEED), s->margin_mm_s, 9, 25),
    };
    (void)swaywatch_dbc_sway_margin_pack(data, &m, 8U);
}

static void encode_damping(const sway_status_t *s, uint8_t *data)
{
    const bool known = valid(s, SWAY_VALID_MARGIN);
    const struct swaywatch_dbc_sway_damping_t m = {
        .damping_estimate = estimate(s),
        .damping_ratio = raw_s16(known, s->margin_damping_ratio_ppm, 1, 100),
        .damping_ratio_error = raw_u16(known, s->margin_damping_ratio_se_ppm, 1, 100),
        .model_damping_ratio =
            raw_s16(valid(s, SWAY_VALID_MODEL), s->model_damping_ratio_ppm, 1, 100),
    };
    (void)swaywatch_dbc_sway_damping_pack(data, &m, 8U);
}

static void encode_signal_damping(const sway_status_t *s, uint8_t *data)
{
    const bool line = valid(s, SWAY_VALID_LINE);
    const struct swaywatch_dbc_sway_signal_damping_t m = {
        .signal_damping_estimate = estimate(s),
        .signal_damping_ratio = raw_s16(line, s->damping_ratio_ppm, 1, 100),
        .signal_damping_ratio_error = raw_u16(line, s->damping_ratio_se_ppm, 1, 100),
        .growth = raw_s16(line, s->growth_ppm_per_s, 1, 1000),
    };
    (void)swaywatch_dbc_sway_signal_damping_pack(data, &m, 8U);
}

static void encode_oscillation(const sway_status_t *s, uint8_t *data)
{
    const bool line = valid(s, SWAY_VALID_LINE);
    const struct swaywatch_dbc_sway_oscillation_t m = {
        .oscillation_estimate = estimate(s),
        .frequency = raw_u16(line, s->frequency_uhz, 1, 100),
        .frequency_error = raw_u16(line, s->frequency_se_uhz, 1, 10),
        .amplitude = raw_u16(line, s->amplitude_urad_s, NANO, CENTIDEGREE_NRAD_MILLI),
    };
    (void)swaywatch_dbc_sway_oscillation_pack(data, &m, 8U);
}

static void encode_model(const sway_status_t *s, uint8_t *data)
{
    const bool model = valid(s, SWAY_VALID_MODEL);
    const struct swaywatch_dbc_sway_model_t m = {
        .model_estimate = estimate(s),
        .model_frequency = raw_u16(model, s->model_frequency_uhz, 1, 100),
        .model_damping_ratio_error = raw_u16(model, s->model_damping_ratio_se_ppm, 1, 100),
        .used_speed = raw_u16(valid(s, SWAY_VALID_SPEED), s->speed_mm_s, 9, 25),
    };
    (void)swaywatch_dbc_sway_model_pack(data, &m, 8U);
}

static void encode_stiffness(const sway_status_t *s, uint32_t axle, uint8_t *data)
{
    const sway_axle_status_t *a = &s->axle[axle];
    const bool known = valid(s, (uint32_t)SWAY_VALID_CAR_FRONT << axle);
    const struct swaywatch_dbc_sway_stiffness_car_front_t m = {
        .stiffness_car_front_estimate = estimate(s),
        .stiffness_car_front = raw_u16(known, a->cornering_stiffness_n_per_rad, 1, 20),
        .stiffness_error_car_front = raw_u16(known, a->cornering_stiffness_se_n_per_rad, 1, 20),
        .stiffness_argument_car_front = to_centidegree(known, a->argument_urad),
    };
    (void)swaywatch_dbc_sway_stiffness_car_front_pack(data, &m, 8U);
}

static void encode_load(const sway_status_t *s, uint32_t axle, uint8_t *data)
{
    const sway_axle_status_t *a = &s->axle[axle];
    const bool known = valid(s, (uint32_t)SWAY_VALID_CAR_FRONT_LOAD << axle);
    const struct swaywatch_dbc_sway_load_car_front_t m = {
        .load_car_front_estimate = estimate(s),
        .effective_load_car_front = raw_s16(known, a->effective_load_mn, 1, 4000),
        .effective_load_error_car_front = raw_u16(known, a->effective_load_se_mn, 1, 4000),
        .load_harmonic_car_front = raw_u16(known, a->load_harmonic_mn, 1, 4000),
    };
    (void)swaywatch_dbc_sway_load_car_front_pack(data, &m, 8U);
}

static void encode_tyre(const sway_status_t *s, uint32_t axle, uint8_t *data)
{
    const sway_axle_status_t *a = &s->axle[axle];
    const bool known = valid(s, (uint32_t)SWAY_VALID_CAR_FRONT_LOAD << axle);
    const struct swaywatch_dbc_sway_tyre_car_front_t m = {
        .tyre_car_front_estimate = estimate(s),
        .normalised_stiffness_car_front =
            raw_u16(known, a->normalised_stiffness_milli_per_rad, 1, 1),
        .lateral_friction_car_front = raw_u16(known, a->lateral_friction_ppm, 1, 100),
        .load_harmonic_phase_car_front = to_centidegree(known, a->load_harmonic_phase_urad),
    };
    (void)swaywatch_dbc_sway_tyre_car_front_pack(data, &m, 8U);
}

static void encode_inertia(const sway_status_t *s, uint8_t *data)
{
    const bool car = valid(s, SWAY_VALID_CAR_INERTIA);
    const bool trailer = valid(s, SWAY_VALID_TRAILER_INERTIA);
    const struct swaywatch_dbc_sway_inertia_t m = {
        .inertia_estimate = estimate(s),
        .car_yaw_inertia = raw_u16(car, s->car_yaw_inertia_gm2, 1, 5000),
        .trailer_yaw_inertia = raw_u16(trailer, s->trailer_yaw_inertia_gm2, 1, 20000),
        .trailer_yaw_inertia_error = raw_u16(trailer, s->trailer_yaw_inertia_se_gm2, 1, 20000),
    };
    (void)swaywatch_dbc_sway_inertia_pack(data, &m, 8U);
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
        .window_length = (uint16_t)clip(s->window_ms, 0, UINT16_MAX),
        .estimate_number = (uint16_t)(s->sequence & 0xFFFFU),
    };
    (void)swaywatch_dbc_sway_quality_pack(data, &m, 8U);
}

static void encode_faults_samples(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_samples_t m = {
        .fault_range = count_u16(source->status->fault_count[SWAY_FAULT_RANGE]),
        .fault_time = count_u16(source->status->fault_count[SWAY_FAULT_TIME]),
        .fault_invalid = count_u16(source->status->fault_count[SWAY_FAULT_INVALID]),
    };
    (void)swaywatch_dbc_sway_faults_samples_pack(data, &m, 8U);
}

static void encode_faults_estimates(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_estimates_t m = {
        .fault_gap = count_u16(source->status->fault_count[SWAY_FAULT_GAP]),
        .fault_singular = count_u16(source->status->fault_count[SWAY_FAULT_SINGULAR]),
        .fault_overrun = count_u8(source->status->fault_count[SWAY_FAULT_OVERRUN]),
        .fault_rate = count_u8(source->status->fault_count[SWAY_FAULT_RATE]),
    };
    (void)swaywatch_dbc_sway_faults_estimates_pack(data, &m, 8U);
}

static void encode_faults_frames(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_frames_t m = {
        .fault_crc = count_u16(source->frame_fault[SWAY_FRAME_FAULT_CRC]),
        .fault_lost = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LOST]),
        .fault_repeated = count_u16(source->frame_fault[SWAY_FRAME_FAULT_REPEATED]),
    };
    (void)swaywatch_dbc_sway_faults_frames_pack(data, &m, 8U);
}

static void encode_faults_order(const sway_frames_source_t *source, uint8_t *data)
{
    const struct swaywatch_dbc_sway_faults_order_t m = {
        .fault_late = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LATE]),
        .fault_length = count_u16(source->frame_fault[SWAY_FRAME_FAULT_LENGTH]),
        .fault_timeout = count_u16(source->frame_fault[SWAY_FRAME_FAULT_TIMEOUT]),
    };
    (void)swaywatch_dbc_sway_faults_order_pack(data, &m, 8U);
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
    (void)swaywatch_dbc_sway_inputs_pack(data, &m, 8U);
}

uint32_t sway_frames_output_id(sway_output_t output)
{
    return (uint32_t)SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID + (uint32_t)output;
}

static void encode_axle(uint32_t index, const sway_status_t *s, uint8_t *data)
{
    const uint32_t axle = index % (uint32_t)SWAY_AXLE_COUNT;
    switch (index / (uint32_t)SWAY_AXLE_COUNT) {
    case 0:
        encode_stiffness(s, axle, data);
        break;
    case 1:
        encode_load(s, axle, data);
        break;
    default:
        encode_tyre(s, axle, data);
        break;
    }
}

void sway_frames_encode(sway_output_t output, const sway_frames_source_t *source, uint8_t *data)
{
    static void (*const first[])(const sway_status_t *, uint8_t *) = {
        encode_margin, encode_damping, encode_signal_damping, encode_oscillation, encode_model};
    static void (*const last[])(const sway_frames_source_t *, uint8_t *) = {
        encode_faults_samples, encode_faults_estimates, encode_faults_frames, encode_faults_order,
        encode_inputs};
    (void)memset(data, 0, 8U);
    if (output == SWAY_OUTPUT_ALARM) {
        encode_alarm(source, data);
    } else if (output < SWAY_OUTPUT_STIFFNESS) {
        first[output - SWAY_OUTPUT_MARGIN](source->status, data);
    } else if (output < SWAY_OUTPUT_INERTIA) {
        encode_axle((uint32_t)output - (uint32_t)SWAY_OUTPUT_STIFFNESS, source->status, data);
    } else if (output == SWAY_OUTPUT_INERTIA) {
        encode_inertia(source->status, data);
    } else if (output == SWAY_OUTPUT_QUALITY) {
        encode_quality(source->status, data);
    } else {
        last[output - SWAY_OUTPUT_FAULTS_SAMPLES](source, data);
    }
}

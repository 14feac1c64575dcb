/* The codec against dbc/swaywatch.dbc, typed here a second time: bits, units, ends, "not
 * available". tests/host/test_codec.py holds the same functions to the file itself. */
#include <stddef.h>
#include <string.h>

#include "bus/sway_frames.h"
#include "unity.h"

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

static sway_status_t status;
static uint8_t state[SWAY_MESSAGE_COUNT];
static uint32_t frame_fault[SWAY_FRAME_FAULT_COUNT];
static sway_frames_source_t source;

void setUp(void)
{
    memset(&status, 0, sizeof status);
    memset(state, 0, sizeof state);
    memset(frame_fault, 0, sizeof frame_fault);
    source = (sway_frames_source_t){&status, state, frame_fault, false, false};
}

void tearDown(void)
{
}

/* A frame as one little-endian word. */
static uint64_t word(const uint8_t *data)
{
    uint64_t all = 0;
    for (unsigned i = 0; i < 8; i++) {
        all |= (uint64_t)data[i] << (8 * i);
    }
    return all;
}

static void put(uint8_t *data, unsigned start, unsigned length, uint64_t value)
{
    for (unsigned i = 0; i < length; i++) {
        const unsigned bit = start + i;
        data[bit / 8] = (uint8_t)((data[bit / 8] & ~(1U << (bit % 8))) |
                                  ((unsigned)(value >> i) & 1U) << (bit % 8));
    }
}

/* value * numerator / denominator to the nearest integer, halves away from zero. */
static int64_t scaled(int64_t value, int64_t numerator, int64_t denominator)
{
    const int64_t size = (value < 0 ? -value : value) * numerator;
    const int64_t rounded = (2 * size + denominator) / (2 * denominator);
    return value < 0 ? -rounded : rounded;
}

/* --- what comes in -----------------------------------------------------------------------------
 */

typedef struct {
    sway_message_t message;
    sway_input_t input;
    unsigned start, validity;
    bool is_signed;
    int64_t numerator, denominator; /* raw to the unit of the input */
} signal_in_t;

#define CENTIDEGREE 174532925199, 1000000000

#define FY_OF(wheel)                                                                               \
    ((wheel) < 4 ? SWAY_INPUT_CAR_FY_FL + (wheel) : SWAY_INPUT_TRAILER_FY_FL + (wheel)-4)
#define WHEEL(wheel)                                                                               \
    {SWAY_MESSAGE_CAR_WHEEL_FL + (wheel), FY_OF(wheel), 16, 12, true, 1000, 1},                    \
    {                                                                                              \
        SWAY_MESSAGE_CAR_WHEEL_FL + (wheel), FY_OF(wheel) + 4, 32, 14, false, 1000, 1              \
    }

/* In the order in which a frame's samples are reported. */
static const signal_in_t signals_in[] = {
    {SWAY_MESSAGE_STEERING, SWAY_INPUT_STEERING_WHEEL_ANGLE, 16, 12, true, 1745329251994,
     1000000000},
    {SWAY_MESSAGE_SPEED, SWAY_INPUT_SPEED, 16, 12, false, 25, 9},
    {SWAY_MESSAGE_CAR_MOTION, SWAY_INPUT_CAR_YAW_RATE, 16, 12, true, CENTIDEGREE},
    {SWAY_MESSAGE_CAR_MOTION, SWAY_INPUT_CAR_LATERAL_ACC, 32, 14, true, 2000, 1},
    {SWAY_MESSAGE_TRAILER_MOTION, SWAY_INPUT_TRAILER_YAW_RATE, 16, 12, true, CENTIDEGREE},
    {SWAY_MESSAGE_TRAILER_MOTION, SWAY_INPUT_TRAILER_LATERAL_ACC, 32, 14, true, 2000, 1},
    {SWAY_MESSAGE_ARTICULATION, SWAY_INPUT_ARTICULATION, 16, 12, true, CENTIDEGREE},
    {SWAY_MESSAGE_HITCH_FORCES, SWAY_INPUT_HITCH_FX, 16, 12, true, 1000, 1},
    {SWAY_MESSAGE_HITCH_FORCES, SWAY_INPUT_HITCH_FY, 32, 12, true, 1000, 1},
    WHEEL(0),
    WHEEL(1),
    WHEEL(2),
    WHEEL(3),
    WHEEL(4),
    WHEEL(5),
    WHEEL(6),
    WHEEL(7),
};

static const uint32_t id_in[SWAY_MESSAGE_COUNT] = {0x120, 0x121, 0x122, 0x123, 0x124, 0x125, 0x130,
                                                   0x131, 0x132, 0x133, 0x134, 0x135, 0x136, 0x137};

static void identifiers_in_are_those_of_the_dbc(void)
{
    int found = 0;
    for (uint32_t id = 0; id < 0x800; id++) {
        const sway_message_t m = sway_frames_find(id);
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_COUNT, sway_frames_find(id | 0x80000000U));
        TEST_ASSERT_EQUAL(SWAY_MESSAGE_COUNT, sway_frames_find(id | 0x10000U));
        if (m != SWAY_MESSAGE_COUNT) {
            TEST_ASSERT_EQUAL_HEX32(id, id_in[m]);
            TEST_ASSERT_EQUAL_HEX32(id, sway_frames_input_id(m));
            found++;
        }
    }
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_COUNT, found);
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_COUNT, sway_frames_find(UINT32_MAX));
}

/* Which of the samples of its message signal number `i` is. */
static uint32_t place(size_t i)
{
    return i > 0 && signals_in[i - 1].message == signals_in[i].message ? 1U : 0U;
}

static uint32_t samples_of(sway_message_t message)
{
    uint32_t n = 0;
    for (size_t i = 0; i < LENGTH(signals_in); i++) {
        n += signals_in[i].message == message;
    }
    return n;
}

static void expect_sample(size_t i, const uint8_t *data, int64_t value, bool valid)
{
    sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
    const uint32_t n = sway_frames_decode(signals_in[i].message, data, samples);
    TEST_ASSERT_EQUAL_UINT32(samples_of(signals_in[i].message), n);
    TEST_ASSERT_EQUAL(signals_in[i].input, samples[place(i)].input);
    TEST_ASSERT_EQUAL_INT32(value, samples[place(i)].value);
    TEST_ASSERT_EQUAL(valid, samples[place(i)].valid);
}

/* Every 97th raw value, both ends, those around zero and around the change of sign; what else is in
 * the frame, all zeros or all ones but for the validity, does not matter. */
static void every_raw_value_comes_in_with_its_unit(void)
{
    for (size_t i = 0; i < LENGTH(signals_in); i++) {
        const signal_in_t *s = &signals_in[i];
        for (uint32_t raw = 0; raw <= 0xFFFFU; raw++) {
            if (raw % 97 != 0 && ((raw + 3) & 0x7FFFU) > 6) {
                continue;
            }
            const int64_t number = s->is_signed && raw > 0x7FFFU ? (int64_t)raw - 0x10000 : raw;
            const int64_t value = scaled(number, s->numerator, s->denominator);
            for (unsigned rest = 0; rest < 2; rest++) {
                uint8_t data[8];
                memset(data, rest ? 0xFF : 0, 8);
                put(data, s->start, 16, raw);
                put(data, 12, 4, 0);
                expect_sample(i, data, value, true);
            }
        }
    }
}

static void only_validity_zero_is_valid(void)
{
    for (size_t i = 0; i < LENGTH(signals_in); i++) {
        for (unsigned code = 0; code < 4; code++) {
            uint8_t data[8] = {0};
            put(data, signals_in[i].validity, 2, code);
            expect_sample(i, data, 0, code == 0);
            put(data, 12, 4, ~0U);
            put(data, signals_in[i].validity, 2, code); /* the other one says "not valid" */
            expect_sample(i, data, 0, code == 0);
        }
    }
}

/* --- what goes out -----------------------------------------------------------------------------
 */

typedef struct {
    sway_output_t output;
    unsigned start;
    bool is_signed;
    size_t field;                   /* int32_t of the status */
    int64_t numerator, denominator; /* of its unit to raw */
    uint32_t valid;                 /* all of these bits are needed */
} signal_out_t;

#define OF(name) offsetof(sway_status_t, name)
#define AXLE(k, name)                                                                              \
    (offsetof(sway_status_t, axle) + (k) * sizeof(sway_axle_status_t) +                            \
     offsetof(sway_axle_status_t, name))
#define LINE SWAY_VALID_LINE
#define MODEL SWAY_VALID_MODEL
#define VCRIT SWAY_VALID_CRITICAL_SPEED
#define RATIO SWAY_VALID_MARGIN
#define TRAILER SWAY_VALID_TRAILER_INERTIA
#define TO_CENTIDEGREE 1000000000, 174532925199
#define STIFF(k) (1U << (4 + (k)))
#define LOAD(k) (1U << (8 + (k)))
#define AXLE_SIGNALS(k)                                                                            \
    {SWAY_OUTPUT_STIFFNESS + (k),                                                                  \
     16,                                                                                           \
     false,                                                                                        \
     AXLE(k, cornering_stiffness_n_per_rad),                                                       \
     1,                                                                                            \
     20,                                                                                           \
     STIFF(k)},                                                                                    \
        {SWAY_OUTPUT_STIFFNESS + (k),                                                              \
         32,                                                                                       \
         false,                                                                                    \
         AXLE(k, cornering_stiffness_se_n_per_rad),                                                \
         1,                                                                                        \
         20,                                                                                       \
         STIFF(k)},                                                                                \
        {SWAY_OUTPUT_STIFFNESS + (k), 48, true, AXLE(k, argument_urad), TO_CENTIDEGREE, STIFF(k)}, \
        {SWAY_OUTPUT_LOAD + (k), 16, true, AXLE(k, effective_load_mn), 1, 4000, LOAD(k)},          \
        {SWAY_OUTPUT_LOAD + (k), 32, false, AXLE(k, effective_load_se_mn), 1, 4000, LOAD(k)},      \
        {SWAY_OUTPUT_LOAD + (k), 48, false, AXLE(k, load_harmonic_mn), 1, 4000, LOAD(k)},          \
        {SWAY_OUTPUT_TYRE + (k),                                                                   \
         16,                                                                                       \
         false,                                                                                    \
         AXLE(k, normalised_stiffness_milli_per_rad),                                              \
         1,                                                                                        \
         1,                                                                                        \
         LOAD(k)},                                                                                 \
        {SWAY_OUTPUT_TYRE + (k), 32, false, AXLE(k, lateral_friction_ppm), 1, 100, LOAD(k)},       \
    {                                                                                              \
        SWAY_OUTPUT_TYRE + (k), 48, true, AXLE(k, load_harmonic_phase_urad), TO_CENTIDEGREE,       \
            LOAD(k)                                                                                \
    }

static const signal_out_t signals_out[] = {
    {SWAY_OUTPUT_ALARM, 48, false, OF(time_to_limit_ms), 1, 10, SWAY_VALID_TIME_TO_LIMIT},
    {SWAY_OUTPUT_MARGIN, 16, false, OF(v_crit_mm_s), 9, 25, VCRIT},
    {SWAY_OUTPUT_MARGIN, 32, false, OF(v_crit_se_mm_s), 9, 25, VCRIT},
    {SWAY_OUTPUT_MARGIN, 48, true, OF(margin_mm_s), 9, 25, VCRIT | SWAY_VALID_SPEED},
    {SWAY_OUTPUT_DAMPING, 16, true, OF(margin_damping_ratio_ppm), 1, 100, RATIO},
    {SWAY_OUTPUT_DAMPING, 32, false, OF(margin_damping_ratio_se_ppm), 1, 100, RATIO},
    {SWAY_OUTPUT_DAMPING, 48, true, OF(model_damping_ratio_ppm), 1, 100, MODEL},
    {SWAY_OUTPUT_SIGNAL_DAMPING, 16, true, OF(damping_ratio_ppm), 1, 100, LINE},
    {SWAY_OUTPUT_SIGNAL_DAMPING, 32, false, OF(damping_ratio_se_ppm), 1, 100, LINE},
    {SWAY_OUTPUT_SIGNAL_DAMPING, 48, true, OF(growth_ppm_per_s), 1, 1000, LINE},
    {SWAY_OUTPUT_OSCILLATION, 16, false, OF(frequency_uhz), 1, 100, LINE},
    {SWAY_OUTPUT_OSCILLATION, 32, false, OF(frequency_se_uhz), 1, 10, LINE},
    {SWAY_OUTPUT_OSCILLATION, 48, false, OF(amplitude_urad_s), TO_CENTIDEGREE, LINE},
    {SWAY_OUTPUT_MODEL, 16, false, OF(model_frequency_uhz), 1, 100, MODEL},
    {SWAY_OUTPUT_MODEL, 32, false, OF(model_damping_ratio_se_ppm), 1, 100, MODEL},
    {SWAY_OUTPUT_MODEL, 48, false, OF(speed_mm_s), 9, 25, SWAY_VALID_SPEED},
    AXLE_SIGNALS(0),
    AXLE_SIGNALS(1),
    AXLE_SIGNALS(2),
    AXLE_SIGNALS(3),
    {SWAY_OUTPUT_INERTIA, 16, false, OF(car_yaw_inertia_gm2), 1, 5000, SWAY_VALID_CAR_INERTIA},
    {SWAY_OUTPUT_INERTIA, 32, false, OF(trailer_yaw_inertia_gm2), 1, 20000, TRAILER},
    {SWAY_OUTPUT_INERTIA, 48, false, OF(trailer_yaw_inertia_se_gm2), 1, 20000, TRAILER},
    {SWAY_OUTPUT_SWING, 16, false, OF(lowest_v_crit_mm_s), 9, 25, SWAY_VALID_LOWEST_SPEED},
    {SWAY_OUTPUT_SWING, 32, false, OF(lowest_v_crit_se_mm_s), 9, 25, SWAY_VALID_LOWEST_SPEED},
    {SWAY_OUTPUT_SWING, 48, false, OF(lowest_v_crit_swing_urad_s), TO_CENTIDEGREE,
     SWAY_VALID_LOWEST_SPEED},
};

static void identifiers_out_follow_each_other(void)
{
    TEST_ASSERT_EQUAL(29, SWAY_OUTPUT_COUNT);
    for (uint32_t output = 0; output < SWAY_OUTPUT_COUNT; output++) {
        TEST_ASSERT_EQUAL_HEX32(0x1A0 + output, sway_frames_output_id((sway_output_t)output));
    }
}

static void set_field(size_t offset, int32_t value)
{
    memcpy((char *)&status + offset, &value, sizeof value);
}

/* Expects raw in its place, and everything else of the frame as in `base`. */
static void expect_out(const signal_out_t *s, const uint8_t *base, uint64_t raw)
{
    uint8_t data[8], expected[8];
    memset(data, 0xA5, 8);
    sway_frames_encode(s->output, &source, data);
    memcpy(expected, base, 8);
    put(expected, s->start, 16, raw);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, data, 8);
}

static uint64_t raw_of(const signal_out_t *s, int64_t value)
{
    const int64_t low = s->is_signed ? -32767 : 0;
    const int64_t high = s->is_signed ? 32767 : 65534;
    const int64_t raw = scaled(value, s->numerator, s->denominator);
    return (uint64_t)(raw < low ? low : (raw > high ? high : raw)) & 0xFFFFU;
}

static int32_t clip32(int64_t value)
{
    return (int32_t)(value < INT32_MIN ? INT32_MIN : (value > INT32_MAX ? INT32_MAX : value));
}

/* Around every rounding step near 0 and both ends, beyond the ends, and at those of int32_t. */
static void every_value_goes_out_with_its_unit_and_its_ends(void)
{
    static const int32_t raws[] = {-40000, -32768, -32767, -32766, -1234, -2,    -1,
                                   0,      1,      2,      77,     1234,  32766, 32767,
                                   32768,  40000,  65533,  65534,  65535, 65536, 70000};
    for (size_t i = 0; i < LENGTH(signals_out); i++) {
        const signal_out_t *s = &signals_out[i];
        uint8_t base[8];
        setUp();
        status.valid = s->valid;
        sway_frames_encode(s->output, &source, base);
        for (size_t k = 0; k < LENGTH(raws); k++) {
            const int64_t middle = scaled(raws[k], s->denominator, s->numerator);
            const int64_t half = scaled(1, s->denominator, 2 * s->numerator);
            for (int64_t step = -2; step <= 2; step++) {
                const int64_t near[] = {middle + step, middle + half + step, middle - half + step};
                for (size_t n = 0; n < 3; n++) {
                    const int32_t value = clip32(near[n]);
                    set_field(s->field, value);
                    expect_out(s, base, raw_of(s, value));
                }
            }
        }
        set_field(s->field, INT32_MAX);
        expect_out(s, base, raw_of(s, INT32_MAX));
        set_field(s->field, INT32_MIN);
        expect_out(s, base, raw_of(s, INT32_MIN));
    }
}

/* A value without all of its bits of `valid` is reported as not available, whatever it is; the bits
 * of others do not help. */
static void values_that_are_not_valid_are_not_available(void)
{
    for (size_t i = 0; i < LENGTH(signals_out); i++) {
        const signal_out_t *s = &signals_out[i];
        const uint64_t none = s->is_signed ? 0x8000U : 0xFFFFU;
        set_field(s->field, 1234567);
        for (unsigned bit = 0; bit <= SWAY_VALID_BITS; bit++) {
            uint8_t base[8];
            status.valid = ~0U & ~(bit < SWAY_VALID_BITS ? 1U << bit : 0U);
            sway_frames_encode(s->output, &source, base);
            const bool missing = bit < SWAY_VALID_BITS && (s->valid >> bit & 1U) != 0U;
            expect_out(s, base, missing ? none : raw_of(s, 1234567));
        }
        set_field(s->field, 0);
        status.valid = 0;
    }
}

static void every_signal_of_a_frame_is_tested(void)
{
    int count[SWAY_OUTPUT_COUNT] = {0};
    for (size_t i = 0; i < LENGTH(signals_out); i++) {
        count[signals_out[i].output]++;
    }
    TEST_ASSERT_EQUAL(1, count[SWAY_OUTPUT_ALARM]);
    for (int output = SWAY_OUTPUT_MARGIN; output <= SWAY_OUTPUT_INERTIA; output++) {
        TEST_ASSERT_EQUAL(3, count[output]);
    }
    TEST_ASSERT_EQUAL(3, count[SWAY_OUTPUT_SWING]);
}

/* CRC and counter are left to sway_e2e; the estimate's number modulo 16 goes with all that belongs
 * to an estimate, so that a receiver can put its frames together. */
static void frames_of_one_estimate_carry_its_number(void)
{
    for (uint32_t sequence = 0; sequence < 40; sequence++) {
        status.sequence = sequence + 0xFFFF0000U;
        for (int output = 0; output < SWAY_OUTPUT_COUNT; output++) {
            uint8_t data[8];
            memset(data, 0xFF, 8);
            sway_frames_encode((sway_output_t)output, &source, data);
            TEST_ASSERT_EQUAL_HEX8(0, data[0]);
            TEST_ASSERT_EQUAL_HEX8(0, data[1] & 0x0F);
            const bool with = output <= SWAY_OUTPUT_INERTIA || output >= SWAY_OUTPUT_JUDGEMENT;
            TEST_ASSERT_EQUAL(with ? sequence % 16 : 0, data[1] >> 4);
        }
    }
}

static uint64_t word_of(sway_output_t output)
{
    uint8_t data[9];
    memset(data, 0xA5, 9);
    sway_frames_encode(output, &source, data);
    TEST_ASSERT_EQUAL_HEX8(0xA5, data[8]); /* writes 8 bytes, no more */
    return word(data);
}

#define NO_TIME (UINT64_C(0xFFFF) << 48)

static void alarm_says_state_sources_and_reasons(void)
{
    TEST_ASSERT_EQUAL_HEX64(NO_TIME, word_of(SWAY_OUTPUT_ALARM));
    for (int k = 0; k < 8; k++) {
        setUp();
        status.alarm = k < SWAY_ALARM_COUNT ? k : 0;
        TEST_ASSERT_EQUAL_HEX64(NO_TIME | (uint64_t)status.alarm << 16, word_of(SWAY_OUTPUT_ALARM));
        setUp();
        status.source = k % 4;
        TEST_ASSERT_EQUAL_HEX64(NO_TIME | (uint64_t)(k % 4) << 19, word_of(SWAY_OUTPUT_ALARM));
        setUp();
        status.belief = k % 4;
        TEST_ASSERT_EQUAL_HEX64(NO_TIME | (uint64_t)(k % 4) << 21, word_of(SWAY_OUTPUT_ALARM));
        setUp();
        status.v_crit_kind = k % 6;
        TEST_ASSERT_EQUAL_HEX64(NO_TIME | (uint64_t)(k % 6) << 23, word_of(SWAY_OUTPUT_ALARM));
    }
    for (int k = 0; k < SWAY_REASON_BITS; k++) {
        setUp();
        status.reasons = 1U << k;
        TEST_ASSERT_EQUAL_HEX64(NO_TIME | UINT64_C(1) << (26 + k), word_of(SWAY_OUTPUT_ALARM));
    }
}

/* Without the inputs there is no judgement: state off, no reason, no time; where the figures came
 * from stays reported. */
static void alarm_is_off_where_nothing_is_left(void)
{
    status.alarm = SWAY_ALARM_CRITICAL;
    status.reasons = (1U << SWAY_REASON_BITS) - 1U;
    status.source = SWAY_SOURCE_IDENTIFIED;
    status.belief = SWAY_BELIEF_SIGNAL;
    status.v_crit_kind = SWAY_VCRIT_DIVERGENCE;
    status.valid = ~0U;
    status.time_to_limit_ms = 1000;
    const uint64_t origin = UINT64_C(3) << 19 | UINT64_C(2) << 21 | UINT64_C(5) << 23;
    TEST_ASSERT_EQUAL_HEX64(origin | UINT64_C(4) << 16 | UINT64_C(0x7F) << 26 | UINT64_C(100) << 48,
                            word_of(SWAY_OUTPUT_ALARM));
    source.inputs_lost = true;
    TEST_ASSERT_EQUAL_HEX64(origin | UINT64_C(4) << 16 | UINT64_C(0x7F) << 26 | UINT64_C(1) << 33 |
                                UINT64_C(100) << 48,
                            word_of(SWAY_OUTPUT_ALARM));
    source.blind = true;
    TEST_ASSERT_EQUAL_HEX64(origin | UINT64_C(1) << 33 | NO_TIME, word_of(SWAY_OUTPUT_ALARM));
}

/* A trailer whose tyres are 22 % softer than configured, and by how much that is known. */
static void a_finding_is_reported_with_its_size_and_error(void)
{
    TEST_ASSERT_EQUAL_HEX64(0, word_of(SWAY_OUTPUT_FINDING));
    status.sequence = 6;
    status.finding = SWAY_FINDING_TRAILER_TYRES;
    status.finding_size_micro = -220400;
    status.finding_se_micro = 30500;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(31) << 48 | UINT64_C(0xFF24) << 32 | 4U << 16 | 6U << 12,
                            word_of(SWAY_OUTPUT_FINDING));
}

static void a_relation_is_reported_with_its_state(void)
{
    TEST_ASSERT_EQUAL_HEX64(0, word_of(SWAY_OUTPUT_RELATION));
    status.sequence = 7;
    status.relation = (int32_t)SWAY_RELATION_BREAKS * 256 + 5;
    status.relation_ppm = 312600;
    status.relation_se_ppm = 41400;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(41) << 48 | UINT64_C(313) << 32 | 0x205U << 16 | 7U << 12,
                            word_of(SWAY_OUTPUT_RELATION));
}

static void what_the_judgement_lacks_is_reported(void)
{
    TEST_ASSERT_EQUAL_HEX64(0, word_of(SWAY_OUTPUT_JUDGEMENT));
    status.sequence = 5;
    status.missing_inputs = 0x8001;
    status.suspect_inputs = 0x0102;
    status.rejected_inputs = 0x1000;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x1000010280010000) | 5U << 12,
                            word_of(SWAY_OUTPUT_JUDGEMENT));
    const uint64_t degraded = UINT64_C(1) << 34;
    TEST_ASSERT_EQUAL_HEX64(degraded, word_of(SWAY_OUTPUT_ALARM) & degraded);
    status.missing_inputs = 0;
    TEST_ASSERT_EQUAL_HEX64(degraded, word_of(SWAY_OUTPUT_ALARM) & degraded);
    status.suspect_inputs = 0;
    TEST_ASSERT_EQUAL_HEX64(degraded, word_of(SWAY_OUTPUT_ALARM) & degraded);
    status.rejected_inputs = 0;
    TEST_ASSERT_EQUAL_HEX64(0, word_of(SWAY_OUTPUT_ALARM) & degraded);
}

static void quality_says_flags_window_and_number(void)
{
    for (int k = 0; k < SWAY_QUALITY_BITS; k++) {
        status.quality = 1U << k;
        TEST_ASSERT_EQUAL_HEX64(UINT64_C(1) << (12 + k), word_of(SWAY_OUTPUT_QUALITY));
    }
    status.quality = 0;
    static const int32_t window_ms[][2] = {
        {-1, 0},        {0, 0},         {1, 1},         {12345, 12345},
        {65534, 65534}, {65535, 65535}, {65536, 65535}, {INT32_MAX, 65535}};
    for (size_t i = 0; i < LENGTH(window_ms); i++) {
        status.window_ms = window_ms[i][0];
        TEST_ASSERT_EQUAL_HEX64((uint64_t)window_ms[i][1] << 32, word_of(SWAY_OUTPUT_QUALITY));
    }
    status.window_ms = 0;
    status.sequence = 0x54321;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x4321) << 48, word_of(SWAY_OUTPUT_QUALITY));
    status.sequence = 0xFFFFFFFF;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xFFFF) << 48, word_of(SWAY_OUTPUT_QUALITY));
}

/* One counter, its place; held at the end of its field. */
static void expect_count(uint32_t *counter, sway_output_t output, unsigned start, unsigned length)
{
    const uint32_t most = length == 8 ? 255 : 65535;
    const uint32_t counts[] = {0,        1,        most - 1, most,      most + 1,
                               most * 2, 0x10001U, 0x100U,   UINT32_MAX};
    for (size_t i = 0; i < LENGTH(counts); i++) {
        const uint64_t reported = counts[i] < most ? counts[i] : most;
        *counter = counts[i];
        TEST_ASSERT_EQUAL_HEX64(reported << start, word_of(output));
    }
    *counter = 0;
}

static void fault_counters_are_reported_and_held_at_their_ends(void)
{
    uint32_t *sample = status.fault_count;
    expect_count(&sample[SWAY_FAULT_RANGE], SWAY_OUTPUT_FAULTS_SAMPLES, 16, 16);
    expect_count(&sample[SWAY_FAULT_TIME], SWAY_OUTPUT_FAULTS_SAMPLES, 32, 16);
    expect_count(&sample[SWAY_FAULT_INVALID], SWAY_OUTPUT_FAULTS_SAMPLES, 48, 16);
    expect_count(&sample[SWAY_FAULT_GAP], SWAY_OUTPUT_FAULTS_ESTIMATES, 16, 16);
    expect_count(&sample[SWAY_FAULT_SINGULAR], SWAY_OUTPUT_FAULTS_ESTIMATES, 32, 16);
    expect_count(&sample[SWAY_FAULT_OVERRUN], SWAY_OUTPUT_FAULTS_ESTIMATES, 48, 8);
    expect_count(&sample[SWAY_FAULT_RATE], SWAY_OUTPUT_FAULTS_ESTIMATES, 56, 8);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_CRC], SWAY_OUTPUT_FAULTS_FRAMES, 16, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_LOST], SWAY_OUTPUT_FAULTS_FRAMES, 32, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_REPEATED], SWAY_OUTPUT_FAULTS_FRAMES, 48, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_LATE], SWAY_OUTPUT_FAULTS_ORDER, 16, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_LENGTH], SWAY_OUTPUT_FAULTS_ORDER, 32, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_TIMEOUT], SWAY_OUTPUT_FAULTS_ORDER, 48, 16);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_STUCK], SWAY_OUTPUT_INPUTS, 48, 8);
    expect_count(&frame_fault[SWAY_FRAME_FAULT_FROZEN], SWAY_OUTPUT_INPUTS, 56, 8);
}

static void states_of_the_inputs_are_reported_in_their_order(void)
{
    for (unsigned m = 0; m < SWAY_MESSAGE_COUNT; m++) {
        for (uint8_t value = 0; value < 4; value++) {
            state[m] = value;
            TEST_ASSERT_EQUAL_HEX64((uint64_t)value << (16 + 2 * m), word_of(SWAY_OUTPUT_INPUTS));
        }
        state[m] = 0;
    }
}

/* Any of the three is enough to degrade a judgement, and the last input is one as well. */
static void each_kind_of_lack_degrades(void)
{
    uint32_t *const lacks[] = {&status.missing_inputs, &status.suspect_inputs,
                               &status.rejected_inputs};
    const uint64_t degraded = UINT64_C(1) << 34;
    for (unsigned i = 0; i < 3U; i++) {
        static const uint32_t flags[] = {0xC000, 0xFFFE, 0xFFFF}; // 0xFFFF: all, no code
        for (unsigned k = 0; k < LENGTH(flags); k++) {
            *lacks[i] = flags[k];
            TEST_ASSERT_EQUAL_HEX64(degraded, word_of(SWAY_OUTPUT_ALARM) & degraded);
            TEST_ASSERT_EQUAL_HEX64((uint64_t)flags[k] << (16U + 16U * i),
                                    word_of(SWAY_OUTPUT_JUDGEMENT));
        }
        *lacks[i] = 0;
    }
}

static void large_errors_are_reported_up_to_65(void)
{
    status.finding_se_micro = 40000000;
    status.relation_ppm = 50000000;
    status.relation_se_ppm = 60000000;
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(40000) << 48, word_of(SWAY_OUTPUT_FINDING));
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(60000) << 48 | UINT64_C(50000) << 32,
                            word_of(SWAY_OUTPUT_RELATION));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(identifiers_in_are_those_of_the_dbc);
    RUN_TEST(every_raw_value_comes_in_with_its_unit);
    RUN_TEST(only_validity_zero_is_valid);
    RUN_TEST(identifiers_out_follow_each_other);
    RUN_TEST(every_value_goes_out_with_its_unit_and_its_ends);
    RUN_TEST(values_that_are_not_valid_are_not_available);
    RUN_TEST(every_signal_of_a_frame_is_tested);
    RUN_TEST(frames_of_one_estimate_carry_its_number);
    RUN_TEST(alarm_says_state_sources_and_reasons);
    RUN_TEST(alarm_is_off_where_nothing_is_left);
    RUN_TEST(a_finding_is_reported_with_its_size_and_error);
    RUN_TEST(a_relation_is_reported_with_its_state);
    RUN_TEST(what_the_judgement_lacks_is_reported);
    RUN_TEST(quality_says_flags_window_and_number);
    RUN_TEST(fault_counters_are_reported_and_held_at_their_ends);
    RUN_TEST(states_of_the_inputs_are_reported_in_their_order);
    RUN_TEST(each_kind_of_lack_degrades);
    RUN_TEST(large_errors_are_reported_up_to_65);
    return UNITY_END();
}

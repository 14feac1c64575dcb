/* A car's own bus: what a map may say, and what is read by it. */
#include <string.h>

#include "bus/sway_map.h"
#include "reference_vehicle.h"
#include "unity.h"

#define YAW_ID 0x3A1U
#define SPEED_ID 0x7FFU

static sway_node_t node;
static sway_map_t map;
static sway_map_listen_t listening;
static uint8_t data[8];

/* Yaw rate: 12 bits, Motorola, signed, 0.05 deg/s, in a protected frame of 6 bytes; lateral
 * acceleration beside it: 16 bits, Intel, 0.01 m/s2 from -300; speed in a bare frame. */
void setUp(void)
{
    sway_core_config_t config;
    sway_core_defaults(&config);
    config.vehicle = reference_vehicle();
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_init(&node, &config));
    memset(&map, 0, sizeof map);
    map.version = SWAY_MAP_VERSION;
    map.messages = 2;
    map.signals = 3;
    map.message[0] = (sway_map_message_t){.can_id = YAW_ID,
                                          .length = 6,
                                          .crc_byte = 5,
                                          .crc_start = 0xFF,
                                          .crc_final = 0xFF,
                                          .crc_prefix = 0x1234,
                                          .crc_prefix_size = 2,
                                          .counter = {.start = 32, .length = 4}};
    map.message[1] =
        (sway_map_message_t){.can_id = SPEED_ID, .length = 2, .crc_byte = SWAY_MAP_NONE};
    map.signal[0] =
        (sway_map_signal_t){.message = 0,
                            .input = SWAY_INPUT_CAR_YAW_RATE,
                            .field = {.start = 3, .length = 12, .is_big_endian = 1, .is_signed = 1},
                            .numerator = 872665,
                            .denominator = 1000,
                            .raw_low = -2047,
                            .raw_high = 2047};
    map.signal[1] = (sway_map_signal_t){.message = 0,
                                        .input = SWAY_INPUT_CAR_LATERAL_ACC,
                                        .field = {.start = 16, .length = 16},
                                        .numerator = 10000,
                                        .denominator = 1,
                                        .offset = -300000000,
                                        .raw_high = 0xFFFE};
    map.signal[2] = (sway_map_signal_t){.message = 1,
                                        .input = SWAY_INPUT_SPEED,
                                        .field = {.start = 0, .length = 16},
                                        .numerator = 25,
                                        .denominator = 9,
                                        .raw_high = 30000};
    listening = (sway_map_listen_t){.map = &map};
    memset(data, 0, sizeof data);
    data[2] = 0x30; /* no acceleration */
    data[3] = 0x75;
}

void tearDown(void)
{
}

/* CRC-8 SAE J1850, bit by bit. */
static uint8_t crc_byte(uint8_t crc, uint8_t byte)
{
    unsigned r = crc ^ (unsigned)byte;
    for (int bit = 0; bit < 8; bit++) {
        r = (r << 1 ^ ((r & 0x80U) != 0 ? 0x1DU : 0U)) & 0xFFU;
    }
    return (uint8_t)r;
}

static void protect(uint8_t counter)
{
    data[4] = counter;
    uint8_t crc = crc_byte(crc_byte(0xFF, 0x34), 0x12);
    for (int i = 0; i < 5; i++) {
        crc = crc_byte(crc, data[i]);
    }
    data[5] = (uint8_t)(crc ^ 0xFF);
}

static sway_error_t send(uint32_t id, uint8_t dlc)
{
    static int64_t now = 1000000;
    now += 10000;
    return sway_map_receive(&listening, &node, now, id, dlc, data);
}

static uint32_t place_of(sway_input_t input)
{
    return sway_input_place(input);
}

static int32_t heard(sway_input_t input)
{
    const sway_node_watch_t *w = &node.watch[place_of(input)];
    TEST_ASSERT_TRUE(w->started);
    return w->value;
}

static void fields_of_both_orders_are_read(void)
{
    data[0] = 0xAF; /* 1111 1000 0001: -127, behind four foreign bits */
    data[1] = 0x81;
    data[2] = 0x90; /* 30096: 0.96 m/s2 */
    data[3] = 0x75;
    protect(1);
    TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    TEST_ASSERT_EQUAL(-110828, heard(SWAY_INPUT_CAR_YAW_RATE)); /* -6.35 deg/s */
    TEST_ASSERT_EQUAL(960000, heard(SWAY_INPUT_CAR_LATERAL_ACC));
    data[0] = 0x10;
    data[1] = 0x81;
    protect(2);
    TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    TEST_ASSERT_EQUAL(112574, heard(SWAY_INPUT_CAR_YAW_RATE));
    data[0] = 0x10;
    data[1] = 0x27;
    TEST_ASSERT_EQUAL(SWAY_OK, send(SPEED_ID, 8));
    TEST_ASSERT_EQUAL(27778, heard(SWAY_INPUT_SPEED)); /* 100 km/h */
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_SPEED));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_CAR_MOTION));
}

static void what_its_sender_has_not_is_not_heard(void)
{
    data[0] = 0x31;
    data[1] = 0x75;
    TEST_ASSERT_EQUAL(SWAY_OK, send(SPEED_ID, 2)); /* 30001 */
    map.signal[2].raw_low = 5;
    memset(data, 0, sizeof data);
    TEST_ASSERT_EQUAL(SWAY_OK, send(SPEED_ID, 2));
    TEST_ASSERT_FALSE(node.watch[place_of(SWAY_INPUT_SPEED)].started);
    TEST_ASSERT_EQUAL(2, sway_core_status(&node.core)->fault_count[SWAY_FAULT_INVALID]);
}

static void damaged_repeated_and_short_frames_are_counted(void)
{
    protect(7);
    TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, send(YAW_ID, 6));
    data[0] ^= 0x10U;
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, send(YAW_ID, 6));
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, send(YAW_ID, 5));
    TEST_ASSERT_EQUAL(SWAY_ERROR_FRAME, send(YAW_ID, 9));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_REPEATED));
    TEST_ASSERT_EQUAL(1, sway_node_fault(&node, SWAY_FRAME_FAULT_CRC));
    TEST_ASSERT_EQUAL(2, sway_node_fault(&node, SWAY_FRAME_FAULT_LENGTH));
}

static void a_value_beyond_all_is_refused_by_the_core(void)
{
    map.signal[2].numerator = INT32_MAX;
    map.signal[2].denominator = 1;
    data[1] = 0x10;
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SPEED_ID, 2));
    TEST_ASSERT_EQUAL(INT32_MAX, heard(SWAY_INPUT_SPEED));
    map.signal[2].numerator = -INT32_MAX;
    TEST_ASSERT_EQUAL(SWAY_ERROR_RANGE, send(SPEED_ID, 2));
    TEST_ASSERT_EQUAL(INT32_MIN, heard(SWAY_INPUT_SPEED));
}

/* One sensor of a message that is frozen marks it, also where the other one comes apart. */
static void a_frozen_sensor_is_seen_beside_the_other(void)
{
    node.watch[place_of(SWAY_INPUT_CAR_LATERAL_ACC)].frozen = true;
    node.watch[place_of(SWAY_INPUT_TRAILER_YAW_RATE)].frozen = true;
    sway_sample_t sample = {.input = SWAY_INPUT_CAR_YAW_RATE, .value = 1, .valid = true};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_sample(&node, 5000, &sample));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_STUCK, sway_node_message_state(&node, SWAY_MESSAGE_CAR_MOTION));
    sample.input = SWAY_INPUT_CAR_LATERAL_ACC; /* it moves again */
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_sample(&node, 6000, &sample));
    TEST_ASSERT_EQUAL(SWAY_MESSAGE_GOOD, sway_node_message_state(&node, SWAY_MESSAGE_CAR_MOTION));
}

static void our_own_frames_are_still_heard(void)
{
    const uint32_t id = sway_frames_input_id(SWAY_MESSAGE_TRAILER_MOTION);
    sway_e2e_protect(id, 0, data);
    TEST_ASSERT_EQUAL(SWAY_OK, send(id, 8));
    TEST_ASSERT_EQUAL(SWAY_ERROR_UNKNOWN_ID, send(0x456, 8));
}

static void every_input_has_its_message(void)
{
    sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
    uint32_t inputs = 0;
    for (uint32_t m = 0; m < (uint32_t)SWAY_MESSAGE_COUNT; m++) {
        const uint32_t count = sway_frames_decode((sway_message_t)m, data, samples);
        for (uint32_t i = 0; i < count; i++) {
            TEST_ASSERT_EQUAL(m, sway_frames_message_of(samples[i].input));
            inputs++;
        }
    }
    TEST_ASSERT_EQUAL(SWAY_INPUT_COUNT, inputs);
    TEST_ASSERT_EQUAL(SWAY_INPUT_COUNT, SWAY_MAP_SIGNALS);
}

/* With `word` made `value` the check points to `index`. */
static void expect(uint32_t index, uint32_t *word, uint32_t value)
{
    const uint32_t before = *word;
    uint32_t where = 0;
    *word = value;
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_map_check(&map, &where));
    TEST_ASSERT_EQUAL(index, where);
    *word = before;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
}

static void a_wrong_word_is_found(void)
{
    expect(SWAY_MAP_NONE, &map.version, 2);
    expect(SWAY_MAP_NONE, &map.messages, 0);
    expect(SWAY_MAP_NONE, &map.messages, SWAY_MAP_MESSAGES + 1);
    expect(SWAY_MAP_NONE, &map.signals, 0);
    expect(SWAY_MAP_NONE, &map.signals, SWAY_MAP_SIGNALS + 1);
    sway_map_message_t *m = &map.message[0];
    expect(0, &m->can_id, 0x800);
    expect(0, &m->can_id, sway_frames_input_id(SWAY_MESSAGE_SPEED));
    expect(0, &m->can_id, sway_frames_output_id(SWAY_OUTPUT_ALARM));
    expect(1, &map.message[1].can_id, YAW_ID);
    expect(1, &map.message[1].length, 0);
    expect(0, &m->length, 0);
    expect(0, &m->length, 9);
    expect(0, &m->crc_byte, 6);
    expect(0, &m->crc_start, 256);
    expect(0, &m->crc_final, 256);
    expect(0, &m->crc_prefix, 65536);
    expect(0, &m->crc_prefix_size, 3);
    expect(0, &m->counter.start, 64);
    expect(0, &m->counter.start, 46);
    expect(0, &m->counter.length, 32);
    expect(0, &m->counter.is_big_endian, 2);
    expect(0, &m->counter.is_signed, 2);
    sway_map_signal_t *s = &map.signal[1];
    const uint32_t at = SWAY_MAP_MESSAGES + 1;
    expect(at, &s->message, 2);
    expect(at, &s->input, (uint32_t)SWAY_INPUT_COUNT);
    expect(at, &s->input, (uint32_t)SWAY_INPUT_CAR_YAW_RATE);
    expect(at, &s->field.length, 0);
    expect(at, &s->field.start, 60);
    expect(at, (uint32_t *)&s->numerator, 0);
    expect(at, (uint32_t *)&s->denominator, 0);
    expect(at, (uint32_t *)&s->raw_high, 0);
}

/* What just fits is taken: fields up to the last bit, frames of 1 and 8 bytes, the largest prefix.
 */
static void what_just_fits_is_taken(void)
{
    uint32_t where;
    sway_map_field_t *const field = &map.signal[2].field;
    *field = (sway_map_field_t){.start = 3, .length = 12, .is_big_endian = 1};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where)); /* the last bit of byte 1 */
    expect(SWAY_MAP_MESSAGES + 2, &field->length, 13);
    *field = (sway_map_field_t){.start = 7, .length = 16, .is_big_endian = 1};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
    map.message[1].length = 8;
    *field = (sway_map_field_t){.start = 48, .length = 16};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
    expect(SWAY_MAP_MESSAGES + 2, &field->start, 49);
    *field = (sway_map_field_t){.start = 0, .length = 31};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
    expect(SWAY_MAP_MESSAGES + 2, &field->length, 32);
    map.message[1].length = 1;
    *field = (sway_map_field_t){.start = 0, .length = 8};
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
    map.message[0].crc_prefix = UINT16_MAX;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
}

static void neither_our_frames_nor_one_twice(void)
{
    uint32_t where;
    const uint32_t last = sway_frames_output_id((sway_output_t)(SWAY_OUTPUT_COUNT - 1));
    expect(0, &map.message[0].can_id, last);
    map.message[0].can_id = last + 1U;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
    map.messages = 3;
    map.message[2] = (sway_map_message_t){.can_id = 0x300, .length = 8, .crc_byte = SWAY_MAP_NONE};
    expect(2, &map.message[2].can_id, SPEED_ID);
    expect(SWAY_MAP_MESSAGES + 2, &map.signal[2].input, SWAY_INPUT_CAR_LATERAL_ACC);
    expect(SWAY_MAP_MESSAGES, &map.signal[0].field.start, 64);
    map.messages = 2; /* the third is there, but not among those that count */
    expect(SWAY_MAP_MESSAGES + 2, &map.signal[2].message, 2);
}

static void a_map_may_be_full(void)
{
    uint32_t where;
    map.messages = SWAY_MAP_MESSAGES;
    map.signals = SWAY_MAP_SIGNALS;
    for (uint32_t i = 0; i < SWAY_MAP_MESSAGES; i++) {
        map.message[i] =
            (sway_map_message_t){.can_id = 0x300 + i, .length = 8, .crc_byte = SWAY_MAP_NONE};
    }
    for (uint32_t i = 0; i < SWAY_MAP_SIGNALS; i++) {
        map.signal[i] = (sway_map_signal_t){.message = i % SWAY_MAP_MESSAGES,
                                            .input = i,
                                            .field = {.start = i, .length = 8},
                                            .numerator = 1,
                                            .denominator = 1,
                                            .raw_high = 255};
    }
    TEST_ASSERT_EQUAL(SWAY_OK, sway_map_check(&map, &where));
}

static void a_positive_value_with_its_second_bit_is_positive(void)
{
    data[0] = 0x04; /* 0100 0100 1100: 1100 */
    data[1] = 0x4C;
    protect(1);
    TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    TEST_ASSERT_EQUAL(959932, heard(SWAY_INPUT_CAR_YAW_RATE)); /* 1100 * 0.05 deg/s */
}

/* Every value of a byte has its part in the CRC. */
static void every_byte_is_protected(void)
{
    for (unsigned byte = 0; byte < 256; byte++) {
        data[1] = (uint8_t)byte;
        protect((uint8_t)(byte % 16U));
        TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    }
}

/* To the nearest, half away from zero; the first and the last value that its sender has count. */
static void values_are_rounded_to_the_nearest(void)
{
    static const int32_t cases[][4] = {/* raw, numerator, denominator, value */
                                       {1, 1, 2, 1},  {1, -1, 2, -1}, {1, 2, 5, 0},
                                       {1, 3, 5, 1},  {1, 3, 6, 1},   {1, -3, 6, -1},
                                       {1, -2, 5, 0}, {3, 1, 2, 2},   {0, 1, 2, 0}};
    map.signal[2].input = SWAY_INPUT_ARTICULATION;
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        map.signal[2].numerator = cases[i][1];
        map.signal[2].denominator = cases[i][2];
        map.signal[2].raw_low = cases[i][0] - (int32_t)(i % 2U);
        map.signal[2].raw_high = map.signal[2].raw_low + 1;
        memset(data, 0, sizeof data);
        data[0] = (uint8_t)cases[i][0];
        TEST_ASSERT_EQUAL(SWAY_OK, send(SPEED_ID, 2));
        TEST_ASSERT_EQUAL(cases[i][3], heard(SWAY_INPUT_ARTICULATION));
    }
    TEST_ASSERT_EQUAL(0, sway_core_status(&node.core)->fault_count[SWAY_FAULT_INVALID]);
}

static void nothing_but_its_signals_is_heard(void)
{
    protect(1);
    TEST_ASSERT_EQUAL(SWAY_OK, send(YAW_ID, 6));
    for (uint32_t place = 0; place < SWAY_INPUT_PLACES; place++) {
        TEST_ASSERT_EQUAL(place == place_of(SWAY_INPUT_CAR_YAW_RATE) ||
                              place == place_of(SWAY_INPUT_CAR_LATERAL_ACC),
                          node.watch[place].started);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(fields_of_both_orders_are_read);
    RUN_TEST(what_its_sender_has_not_is_not_heard);
    RUN_TEST(damaged_repeated_and_short_frames_are_counted);
    RUN_TEST(a_value_beyond_all_is_refused_by_the_core);
    RUN_TEST(a_frozen_sensor_is_seen_beside_the_other);
    RUN_TEST(our_own_frames_are_still_heard);
    RUN_TEST(every_input_has_its_message);
    RUN_TEST(a_wrong_word_is_found);
    RUN_TEST(what_just_fits_is_taken);
    RUN_TEST(neither_our_frames_nor_one_twice);
    RUN_TEST(a_map_may_be_full);
    RUN_TEST(a_positive_value_with_its_second_bit_is_positive);
    RUN_TEST(every_byte_is_protected);
    RUN_TEST(values_are_rounded_to_the_nearest);
    RUN_TEST(nothing_but_its_signals_is_heard);
    return UNITY_END();
}

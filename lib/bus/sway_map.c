// SPDX-License-Identifier: MIT
#include "bus/sway_map.h"

#include "arithmetic/sway_int64.h"

#define FRAME_BITS 64U
#define ID_MAX 0x7FFU

/* --- check -------------------------------------------------------------------------------------
 */

/* Bytes that hold a field; 0: it does not fit a frame. */
static uint32_t bytes_of(const sway_map_field_t *f)
{
    if (f->start >= FRAME_BITS || f->length == 0U || f->length >= 32U || f->is_big_endian > 1U ||
        f->is_signed > 1U) {
        return 0U;
    }
    /* in the order in which big-endian fields run: bit 7 of byte 0 first */
    const uint32_t first = f->is_big_endian != 0U ? (f->start ^ 7U) : f->start;
    const uint32_t end = first + f->length;
    return end > FRAME_BITS ? 0U : (end + 7U) / 8U;
}

static bool is_field(const sway_map_field_t *f, uint32_t length)
{
    const uint32_t bytes = bytes_of(f);
    return bytes != 0U && bytes <= length;
}

static bool is_crc(const sway_map_message_t *m)
{
    return m->crc_byte == SWAY_MAP_NONE ||
           (m->crc_byte < m->length && m->crc_start <= UINT8_MAX && m->crc_final <= UINT8_MAX &&
            m->crc_prefix <= UINT16_MAX && m->crc_prefix_size <= 2U);
}

/* Neither read nor sent by ourselves. */
static bool is_foreign(uint32_t can_id)
{
    bool is_sent = false;
    for (uint32_t i = 0U; i < (uint32_t)SWAY_OUTPUT_COUNT; i++) {
        is_sent = is_sent || sway_frames_output_id((sway_output_t)i) == can_id;
    }
    return can_id <= ID_MAX && sway_frames_find(can_id) == SWAY_MESSAGE_COUNT && !is_sent;
}

static bool is_message(const sway_map_t *map, uint32_t index)
{
    const sway_map_message_t *m = &map->message[index];
    bool is_good = is_foreign(m->can_id) && m->length >= 1U && m->length <= 8U && is_crc(m) &&
                   (m->counter.length == 0U || is_field(&m->counter, m->length));
    for (uint32_t i = 0U; i < index; i++) {
        is_good = is_good && map->message[i].can_id != m->can_id;
    }
    return is_good;
}

static bool is_signal(const sway_map_t *map, uint32_t index)
{
    const sway_map_signal_t *s = &map->signal[index];
    bool is_good = s->message < map->messages && s->input < (uint32_t)SWAY_INPUT_COUNT &&
                   s->numerator != 0 && s->denominator > 0 && s->raw_low < s->raw_high;
    is_good = is_good && is_field(&s->field, map->message[s->message].length);
    for (uint32_t i = 0U; i < index; i++) {
        is_good = is_good && map->signal[i].input != s->input;
    }
    return is_good;
}

sway_error_t sway_map_check(const sway_map_t *map, uint32_t *where)
{
    *where = SWAY_MAP_NONE;
    if (map->version != SWAY_MAP_VERSION || map->messages == 0U ||
        map->messages > SWAY_MAP_MESSAGES || map->signals == 0U ||
        map->signals > SWAY_MAP_SIGNALS) {
        return SWAY_ERROR_ARGUMENT;
    }
    for (uint32_t i = 0U; i < map->messages; i++) {
        if (!is_message(map, i)) {
            *where = i;
            return SWAY_ERROR_ARGUMENT;
        }
    }
    for (uint32_t i = 0U; i < map->signals; i++) {
        if (!is_signal(map, i)) {
            *where = SWAY_MAP_MESSAGES + i;
            return SWAY_ERROR_ARGUMENT;
        }
    }
    return SWAY_OK;
}

/* --- frames ------------------------------------------------------------------------------------
 */

static uint32_t bit(const uint8_t *data, uint32_t number)
{
    return ((uint32_t)data[number / 8U] >> (number % 8U)) & 1U;
}

static int32_t raw_value(const sway_map_field_t *f, const uint8_t *data)
{
    uint32_t value = 0U;
    uint32_t at = f->start ^ 7U;
    for (uint32_t i = 0U; i < f->length; i++) {
        if (f->is_big_endian != 0U) {
            value = (value << 1) | bit(data, at ^ 7U);
            at++;
        } else {
            value |= bit(data, f->start + i) << i;
        }
    }
    const int32_t whole = (int32_t)value; // at most 31 bits
    const bool is_negative = f->is_signed != 0U && (value >> (f->length - 1U)) != 0U;
    return is_negative ? (int32_t)((int64_t)whole - ((int64_t)1 << f->length)) : whole;
}

/* CRC-8 of polynomial 0x1D: SAE J1850, AUTOSAR E2E profile 1 */
static const uint8_t table[16] = {0x00, 0x1D, 0x3A, 0x27, 0x74, 0x69, 0x4E, 0x53,
                                  0xE8, 0xF5, 0xD2, 0xCF, 0x9C, 0x81, 0xA6, 0xBB};

static bool is_crc_right(const sway_map_message_t *m, uint8_t dlc, const uint8_t *data)
{
    if (m->crc_byte == SWAY_MAP_NONE) {
        return true;
    }
    uint8_t crc = (uint8_t)m->crc_start;
    for (uint32_t i = 0U; i < m->crc_prefix_size; i++) {
        crc = sway_e2e_crc_byte(table, crc, (uint8_t)((m->crc_prefix >> (8U * i)) & 0xFFU));
    }
    for (uint32_t i = 0U; i < dlc; i++) {
        if (i != m->crc_byte) {
            crc = sway_e2e_crc_byte(table, crc, data[i]);
        }
    }
    return data[m->crc_byte] == (uint8_t)(crc ^ (uint8_t)m->crc_final);
}

static bool is_new(sway_map_listen_t *listen, uint32_t index, const uint8_t *data)
{
    const sway_map_field_t *counter = &listen->map->message[index].counter;
    if (counter->length == 0U) {
        return true;
    }
    const uint32_t now = (uint32_t)raw_value(counter, data) + 1U;
    const bool is_other = now != listen->counter[index];
    listen->counter[index] = now;
    return is_other;
}

static sway_error_t refuse(sway_node_t *node, int64_t time_us, sway_frame_fault_t kind)
{
    sway_node_refuse(node, time_us, kind);
    return SWAY_ERROR_FRAME;
}

static void decode(const sway_map_signal_t *s, const uint8_t *data, sway_sample_t *to)
{
    const int32_t raw = raw_value(&s->field, data);
    const int64_t product = (int64_t)raw * s->numerator;
    const int64_t half = product < 0 ? -(int64_t)(s->denominator / 2) : s->denominator / 2;
    const int64_t value = sway_int64_divide(product + half, s->denominator) + s->offset;
    to->input = (sway_input_t)s->input;
    to->valid = raw >= s->raw_low && raw <= s->raw_high;
    to->value = value > INT32_MAX ? INT32_MAX : (value < INT32_MIN ? INT32_MIN : (int32_t)value);
}

static sway_error_t use(const sway_map_t *map, uint32_t index, sway_node_t *node, int64_t time_us,
                        const uint8_t *data)
{
    sway_error_t result = SWAY_OK;
    for (uint32_t i = 0U; i < map->signals; i++) {
        if (map->signal[i].message == index) {
            sway_sample_t sample;
            decode(&map->signal[i], data, &sample);
            const sway_error_t error = sway_node_sample(node, time_us, &sample);
            result = error != SWAY_OK ? error : result;
        }
    }
    return result;
}

sway_error_t sway_map_receive(sway_map_listen_t *listen, sway_node_t *node, int64_t time_us,
                              uint32_t can_id, uint8_t dlc, const uint8_t *data)
{
    const sway_map_t *map = listen->map;
    uint32_t i = 0U;
    while (i < map->messages && map->message[i].can_id != can_id) {
        i++;
    }
    if (i == map->messages) {
        return sway_node_receive(node, time_us, can_id, dlc, data);
    }
    if (dlc < map->message[i].length || dlc > 8U) {
        return refuse(node, time_us, SWAY_FRAME_FAULT_LENGTH);
    }
    if (!is_crc_right(&map->message[i], dlc, data)) {
        return refuse(node, time_us, SWAY_FRAME_FAULT_CRC);
    }
    if (!is_new(listen, i, data)) {
        return refuse(node, time_us, SWAY_FRAME_FAULT_REPEATED);
    }
    return use(map, i, node, time_us, data);
}

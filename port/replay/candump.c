#include "candump.h"

#include <string.h>

#define SECONDS_MAX INT64_C(100000000000)

static const char digits[] = "0123456789ABCDEF";

static int nibble(char c)
{
    if (c >= '0' && c <= '9') {
        return c - '0';
    }
    if (c >= 'A' && c <= 'F') {
        return c - 'A' + 10;
    }
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Seconds with up to six decimals as microseconds; NULL: not a number. */
static const char *parse_time(const char *at, int64_t *time_us)
{
    int64_t value = 0;
    int decimals = -1;
    for (; *at != ')'; at++) {
        if (*at == '.' && decimals < 0) {
            decimals = 0;
        } else if (*at >= '0' && *at <= '9' && decimals < 6 &&
                   (decimals >= 0 || value < SECONDS_MAX)) {
            value = value * 10 + (*at - '0');
            decimals += decimals >= 0 ? 1 : 0;
        } else {
            return NULL;
        }
    }
    for (decimals = decimals < 0 ? 0 : decimals; decimals < 6; decimals++) {
        value *= 10;
    }
    *time_us = value;
    return at + 1;
}

static const char *parse_id(const char *at, uint16_t *id)
{
    uint32_t value = 0;
    int count = 0;
    for (; nibble(*at) >= 0 && count < 4; at++, count++) {
        value = value * 16U + (uint32_t)nibble(*at);
    }
    *id = (uint16_t)value;
    return count == 3 && value <= 0x7FFU && *at == '#' ? at + 1 : NULL;
}

static bool parse_data(const char *at, sway_port_frame_t *frame)
{
    uint8_t count = 0;
    while (nibble(at[0]) >= 0 && nibble(at[1]) >= 0 && count < 8U) {
        frame->data[count] = (uint8_t)(nibble(at[0]) * 16 + nibble(at[1]));
        count++;
        at += 2;
    }
    frame->dlc = count;
    return *at == '\0' || *at == '\n' || *at == '\r' || *at == ' ';
}

bool candump_parse(const char *line, sway_port_frame_t *frame)
{
    sway_port_frame_t result = {0};
    const char *at = line;
    if (*at != '(' || (at = parse_time(at + 1, &result.time_us)) == NULL || *at != ' ') {
        return false;
    }
    at = strchr(at + 1, ' '); // the interface's name is not needed here
    if (at == NULL || (at = parse_id(at + 1, &result.id)) == NULL || !parse_data(at, &result)) {
        return false;
    }
    *frame = result;
    return true;
}

static char *format_number(char *at, uint32_t value, int width)
{
    char text[12];
    int count = 0;
    do {
        text[count++] = digits[value % 10U];
        value /= 10U;
    } while (value != 0U || count < width);
    while (count > 0) {
        *at++ = text[--count];
    }
    return at;
}

size_t candump_format(const sway_port_frame_t *frame, char *line)
{
    char *at = line;
    *at++ = '(';
    at = format_number(at, (uint32_t)(frame->time_us / 1000000), 1);
    *at++ = '.';
    at = format_number(at, (uint32_t)(frame->time_us % 1000000), 6);
    memcpy(at, ") can0 ", 7);
    at += 7;
    for (int shift = 8; shift >= 0; shift -= 4) {
        *at++ = digits[((uint32_t)frame->id >> shift) & 15U];
    }
    *at++ = '#';
    for (uint8_t i = 0; i < frame->dlc && i < 8U; i++) {
        *at++ = digits[frame->data[i] >> 4];
        *at++ = digits[frame->data[i] & 15U];
    }
    *at++ = '\n';
    *at = '\0';
    return (size_t)(at - line);
}

// SPDX-License-Identifier: MIT
/// sway_map: the ECU's inputs from a car's own bus: which bits of which frame are which input.
///
///     sway_map_check(&map, &where);          // once
///     sway_map_listen_t listen = {.map = &map};
///     on every frame:  sway_map_receive(&listen, &node, time_us, can_id, dlc, data);
///
/// Frames that the map does not name go to sway_node_receive(): those of dbc/swaywatch.dbc are
/// still heard. A map consists of 32-bit words only, little-endian in files; `swaywatch map` makes
/// it from a DBC and a signals.toml.
///
/// Bits are numbered as in a DBC: bit 0 is the least of byte 0; `start` is the least significant
/// bit of a little-endian (Intel) field and the most significant one of a big-endian (Motorola)
/// field.
#ifndef SWAY_MAP_H
#define SWAY_MAP_H

#include "sway_node.h"

SWAY_C_BEGIN

#define SWAY_MAP_VERSION 1U
#define SWAY_MAP_MESSAGES 16U
#define SWAY_MAP_SIGNALS 25U ///< SWAY_INPUT_COUNT
#define SWAY_MAP_NONE UINT32_MAX

/// Bits of a frame.
typedef struct {
    uint32_t start;
    uint32_t length;        ///< 1 to 31; 0: there is none (a counter)
    uint32_t is_big_endian; ///< 0 or 1
    uint32_t is_signed;     ///< 0 or 1
} sway_map_field_t;

/// A frame of the car's bus.
typedef struct {
    uint32_t can_id;          ///< 11 bits, none that we read or send
    uint32_t length;          ///< least number of bytes, 1 to 8
    uint32_t crc_byte;        ///< SWAY_MAP_NONE: no CRC. CRC-8 of polynomial 0x1D over all others
    uint32_t crc_start;       ///< 0 to 255
    uint32_t crc_final;       ///< exclusive or at the end, 0 to 255
    uint32_t crc_prefix;      ///< bytes that come first (AUTOSAR's data ID), low one first
    uint32_t crc_prefix_size; ///< 0 to 2 of them
    sway_map_field_t counter; ///< a frame with the counter of the one before is not used
} sway_map_message_t;

/// An input in it: raw * numerator / denominator + offset, in the unit of the input.
typedef struct {
    uint32_t message; ///< index
    uint32_t input;   ///< sway_input_t
    sway_map_field_t field;
    int32_t numerator;   ///< not 0
    int32_t denominator; ///< above 0
    int32_t offset;
    int32_t raw_low; ///< beyond these the sender has no value
    int32_t raw_high;
} sway_map_signal_t;

typedef struct {
    uint32_t version; ///< SWAY_MAP_VERSION
    uint32_t messages;
    uint32_t signals;
    sway_map_message_t message[SWAY_MAP_MESSAGES];
    sway_map_signal_t signal[SWAY_MAP_SIGNALS];
} sway_map_t;

/// What is remembered while listening; all zero but the map at the start.
typedef struct {
    const sway_map_t *map;
    uint32_t counter[SWAY_MAP_MESSAGES]; ///< of the frame before, plus 1
} sway_map_listen_t;

/// SWAY_OK, or SWAY_ERROR_ARGUMENT: `*where` is then the message that is wrong, or
/// SWAY_MAP_MESSAGES plus the signal, or SWAY_MAP_NONE: version or counts. O(signals squared).
sway_error_t sway_map_check(const sway_map_t *map, uint32_t *where);

/// One frame, as sway_node_receive() takes it and with its errors. The map must have passed
/// sway_map_check(). Faults are counted in the node: length, CRC, repeated.
sway_error_t sway_map_receive(sway_map_listen_t *listen, sway_node_t *node, int64_t time_us,
                              uint32_t can_id, uint8_t dlc, const uint8_t *data);

SWAY_C_END

#endif

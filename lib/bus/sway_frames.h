// SPDX-License-Identifier: MIT
/// sway_frames: what dbc/swaywatch.dbc says, between bytes of frames and the core's integers.
///
/// Bits are taken apart and put together by the codec that is generated from the DBC; this file
/// holds the tables of identifiers and units. Messages that are alike (eight wheels; all outputs
/// that are three words of 16 bits) share the codec of one; a test compares their layouts in the
/// DBC.
///
/// Units, raw value to core: exact integer ratios, rounded to nearest, halves away from zero.
///   0.1 deg        -> urad     1745329251994 / 10^9      (pi/180 to 12 digits)
///   0.01 deg[/s]   -> urad[/s]  174532925199 / 10^9
///   0.002 m/s2     -> um/s2    2000
///   0.01 km/h      -> mm/s     25 / 9
///   1 N            -> mN       1000
#ifndef SWAY_FRAMES_H
#define SWAY_FRAMES_H

#include "sway_status.h"
#include "sway_types.h"

/// Messages that the ECU reads, in the order of the states in the frame SwayInputs.
typedef enum {
    SWAY_MESSAGE_STEERING,
    SWAY_MESSAGE_SPEED,
    SWAY_MESSAGE_CAR_MOTION,
    SWAY_MESSAGE_TRAILER_MOTION,
    SWAY_MESSAGE_ARTICULATION,
    SWAY_MESSAGE_HITCH_FORCES,
    SWAY_MESSAGE_CAR_WHEEL_FL,
    SWAY_MESSAGE_CAR_WHEEL_FR,
    SWAY_MESSAGE_CAR_WHEEL_RL,
    SWAY_MESSAGE_CAR_WHEEL_RR,
    SWAY_MESSAGE_TRAILER_WHEEL_FL,
    SWAY_MESSAGE_TRAILER_WHEEL_FR,
    SWAY_MESSAGE_TRAILER_WHEEL_RL,
    SWAY_MESSAGE_TRAILER_WHEEL_RR,
    SWAY_MESSAGE_COUNT
} sway_message_t;

/// State of such a message, as in the DBC's value tables.
typedef enum {
    SWAY_MESSAGE_NEVER, ///< not received yet
    SWAY_MESSAGE_GOOD,
    SWAY_MESSAGE_TIMED_OUT, ///< stays away
    SWAY_MESSAGE_STUCK      ///< its counter does not move, or a sensor in it is frozen
} sway_message_state_t;

/// Messages that the ECU sends, in the order of their identifiers from 0x1A0.
typedef enum {
    SWAY_OUTPUT_ALARM,
    SWAY_OUTPUT_MARGIN,
    SWAY_OUTPUT_DAMPING,
    SWAY_OUTPUT_SIGNAL_DAMPING,
    SWAY_OUTPUT_OSCILLATION,
    SWAY_OUTPUT_MODEL,
    SWAY_OUTPUT_STIFFNESS,                                      ///< one for each axle
    SWAY_OUTPUT_LOAD = SWAY_OUTPUT_STIFFNESS + SWAY_AXLE_COUNT, ///< one for each axle
    SWAY_OUTPUT_TYRE = SWAY_OUTPUT_LOAD + SWAY_AXLE_COUNT,      ///< one for each axle
    SWAY_OUTPUT_INERTIA = SWAY_OUTPUT_TYRE + SWAY_AXLE_COUNT,
    SWAY_OUTPUT_QUALITY,
    SWAY_OUTPUT_FAULTS_SAMPLES,
    SWAY_OUTPUT_FAULTS_ESTIMATES,
    SWAY_OUTPUT_FAULTS_FRAMES,
    SWAY_OUTPUT_FAULTS_ORDER,
    SWAY_OUTPUT_INPUTS,
    SWAY_OUTPUT_JUDGEMENT, ///< with each estimate, and those below
#if SWAY_SUPERVISION
    SWAY_OUTPUT_FINDING,
    SWAY_OUTPUT_RELATION, ///< another relation each time
#endif
#if SWAY_SWING
    SWAY_OUTPUT_SWING,
#endif
    SWAY_OUTPUT_COUNT
} sway_output_t;

/// Faults of received frames since start; each saturates at UINT32_MAX and never goes down.
typedef enum {
    SWAY_FRAME_FAULT_CRC,      ///< wrong CRC, or the counter that is never sent
    SWAY_FRAME_FAULT_LOST,     ///< missing when the next one came
    SWAY_FRAME_FAULT_REPEATED, ///< the counter of the frame before
    SWAY_FRAME_FAULT_LATE,     ///< older than the frame before; was counted as lost then
    SWAY_FRAME_FAULT_LENGTH,   ///< not 8 bytes
    SWAY_FRAME_FAULT_TIMEOUT,  ///< times that a message stayed away beyond the limit
    SWAY_FRAME_FAULT_STUCK,    ///< times that a counter was found stuck
    SWAY_FRAME_FAULT_FROZEN,   ///< times that a sensor was found frozen
    SWAY_FRAME_FAULT_UNKNOWN,  ///< identifiers that are not ours (no fault on a shared bus)
    SWAY_FRAME_FAULT_COUNT
} sway_frame_fault_t;

/// One decoded signal.
typedef struct {
    sway_input_t input;
    int32_t value; ///< in the unit of the input
    bool valid;    ///< false: the sender says that it has none
} sway_sample_t;

#define SWAY_FRAME_SAMPLES_MAX 2U

/// What the frames say beyond the status.
typedef struct {
    const sway_status_t *status;
    const uint8_t *message_state; ///< SWAY_MESSAGE_COUNT of sway_message_state_t
    const uint32_t *frame_fault;  ///< SWAY_FRAME_FAULT_COUNT
    bool inputs_lost;             ///< a message that the judgement wants is not good
    bool blind;                   ///< nothing is left to judge by: the alarm is off
} sway_frames_source_t;

/// The message of an identifier (11 bits; anything else is not ours), or SWAY_MESSAGE_COUNT.
sway_message_t sway_frames_find(uint32_t can_id);

/// The identifier of a message.
uint32_t sway_frames_input_id(sway_message_t message);

/// The message that carries an input.
sway_message_t sway_frames_message_of(sway_input_t input);

/// The signals of a frame of 8 bytes; returns how many (1 or SWAY_FRAME_SAMPLES_MAX). CRC and
/// counter are not looked at. Constant time.
uint32_t sway_frames_decode(sway_message_t message, const uint8_t *data, sway_sample_t *samples);

/// The identifier of an output.
uint32_t sway_frames_output_id(sway_output_t output);

/// Packs an output into 8 bytes, CRC and counter still 0. Values that are not valid now are sent as
/// the DBC's "not available", values beyond a signal's range as its end.
void sway_frames_encode(sway_output_t output, const sway_frames_source_t *source, uint8_t *data);

#endif

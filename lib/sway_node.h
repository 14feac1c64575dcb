// SPDX-License-Identifier: MIT
/// sway_node: the ECU as the bus sees it: frames in, status frames out.
///
///     sway_node_init(&node, &config);
///     on every frame received:  sway_node_receive(&node, time_us, can_id, dlc, data);
///     then:                     while (sway_node_run(&node)) {}
///     then:                     while (sway_node_transmit(&node, &id, &dlc, data)) { send }
///
/// Receiving is short; the work is in sway_node_run(), in slices of at most SWAY_SLICE_COST. Other
/// things may be done between any two calls, as long as they come in this order.
///
/// Everything is driven by the timestamps of the frames, so the same frames give the same status
/// frames on every machine, live or replayed. A port that can see the bus go silent calls
/// sway_node_time() now and then, so that timeouts are reported even if no frame comes.
///
/// A frame is used only if its length, CRC and counter are right. What is wrong is counted by kind
/// (`sway_frame_fault_t`), never silently dropped, and the next good frame is used again.
///
/// All memory is in sway_node_t, which the caller owns. Not re-entrant.
#ifndef SWAY_NODE_H
#define SWAY_NODE_H

#include "sway_core.h"
#include "bus/sway_e2e.h"
#include "bus/sway_frames.h"

SWAY_C_BEGIN

/// A message that stays away for longer than this has timed out: ten cycles at 100 Hz.
#ifndef SWAY_NODE_TIMEOUT_US
#define SWAY_NODE_TIMEOUT_US 100000
#endif
#if SWAY_NODE_TIMEOUT_US < 10000 || SWAY_NODE_TIMEOUT_US > 1000000
#error "SWAY_NODE_TIMEOUT_US: 10000 to 1000000"
#endif

/// Up to this much silence of a message its missing frames are counted exactly (sway_e2e_step).
#define SWAY_NODE_COUNT_LIMIT_US 1000000

/// The alarm is sent at least this often; states and fault counters every tenth time.
#ifndef SWAY_NODE_HEARTBEAT_US
#define SWAY_NODE_HEARTBEAT_US 100000
#endif
#if SWAY_NODE_HEARTBEAT_US < 10000 || SWAY_NODE_HEARTBEAT_US > 1000000
#error "SWAY_NODE_HEARTBEAT_US: 10000 to 1000000"
#endif

/// Equal counters in a row that make a stuck one.
#define SWAY_NODE_STUCK_REPEATS 3U

/// A sensor is frozen when its value has not changed in the least for this long while the yaw rates
/// moved, steps of SWAY_NODE_TRAVEL_STEP taken together, by SWAY_NODE_FROZEN_TRAVEL. Watched are
/// yaw rates, accelerations, articulation and lateral forces; a steering wheel may be held still.
#define SWAY_NODE_FROZEN_US 1000000
#define SWAY_NODE_FROZEN_TRAVEL_URAD_S 349066 ///< 20 deg/s
#define SWAY_NODE_TRAVEL_STEP_URAD_S 8727     ///< 0.5 deg/s, above the noise of a yaw rate sensor

/// What is remembered of one message.
typedef struct {
    sway_e2e_t e2e;
    int64_t accepted_us; ///< timestamp of the last frame that was used
    uint8_t state;       ///< sway_message_state_t
    uint8_t repeats;     ///< equal counters in a row
} sway_node_message_t;

/// What is remembered of one input to find it frozen.
typedef struct {
    int64_t since_us; ///< when the value came first
    int64_t travel;   ///< sway_node_t::travel_urad_s then
    int32_t value;
    bool started;
    bool frozen;
} sway_node_watch_t;

typedef struct {
    bool started;
    bool is_due;       ///< sway_node_run() may have something to do
    uint8_t behind;    ///< times in a row that lay far behind the newest
    uint32_t pending;  ///< outputs due, bit = sway_output_t
    uint32_t sequence; ///< of the estimate that was sent last
    uint32_t heartbeats;
    uint32_t accepted;    ///< frames that were used; saturates
    int32_t alarm_sent;   ///< what the last alarm frame said, lost inputs too
    int64_t time_us;      ///< newest time seen
    int64_t heartbeat_us; ///< when the next heartbeat is due
    int64_t travel_urad_s;
    int32_t travel_anchor_urad_s[2];
    uint32_t frame_fault[SWAY_FRAME_FAULT_COUNT];
    uint8_t message_state[SWAY_MESSAGE_COUNT]; ///< as it was sent last
    uint8_t counter[SWAY_OUTPUT_COUNT];        ///< of the next frame of each output
    sway_node_message_t message[SWAY_MESSAGE_COUNT];
    sway_node_watch_t watch[SWAY_INPUT_PLACES];
    sway_core_t core;
} sway_node_t;

/// Resets everything, fault counters included. Errors as sway_core_init(); `node` is not usable
/// then.
sway_error_t sway_node_init(sway_node_t *node, const sway_core_config_t *config);

/// One frame from the bus: `time_us` when it was received (any epoch, never going back by more than
/// the bus's own jitter), `can_id` its identifier (of 11 bits; with bit 31 set for one of 29 bits,
/// none of which is ours), `dlc` its length in bytes, `data` that many bytes. Decodes, checks and
/// stores. If sway_node_run() has not been called until false since the last frame, what is due is
/// done first: the results are the same, only this call is long then.
///
/// SWAY_OK: used. SWAY_ERROR_UNKNOWN_ID: not ours. SWAY_ERROR_FRAME: wrong length, CRC or counter.
/// SWAY_ERROR_RANGE or SWAY_ERROR_TIME: one of its samples was refused by the core. All are
/// counted; none harms what comes after.
sway_error_t sway_node_receive(sway_node_t *node, int64_t time_us, uint32_t can_id, uint8_t dlc,
                               const uint8_t *data);

/// One sample that did not come in a frame of ours (sway_map), as sway_node_receive() otherwise.
/// The message that would carry it counts as received, the frame as used.
sway_error_t sway_node_sample(sway_node_t *node, int64_t time_us, const sway_sample_t *sample);

/// Counts a fault of a frame that is not ours.
void sway_node_refuse(sway_node_t *node, int64_t time_us, sway_frame_fault_t kind);

/// One slice of the work that the last frame has made due; false: nothing was.
bool sway_node_run(sway_node_t *node);

/// Bus time goes on without a frame: finds messages that have timed out and lets the heartbeat
/// beat. Times before the newest one are ignored.
void sway_node_time(sway_node_t *node, int64_t time_us);

/// The next status frame that is due: true, with its identifier, length (8) and 8 bytes; false:
/// none is due. Call until false when sway_node_run() has returned false.
bool sway_node_transmit(sway_node_t *node, uint32_t *can_id, uint8_t *dlc, uint8_t *data);

/// Count of one fault of frames since start.
uint32_t sway_node_fault(const sway_node_t *node, sway_frame_fault_t fault);

/// State of one message.
sway_message_state_t sway_node_message_state(const sway_node_t *node, sway_message_t message);

/// True where a message that the judgement wants (speed, car motion, and trailer motion if there is
/// a trailer) is not good. The alarm continues with the remaining inputs, and is off only where no
/// motion comes.
bool sway_node_inputs_lost(const sway_node_t *node);

SWAY_C_END

#endif

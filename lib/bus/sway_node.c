// SPDX-License-Identifier: MIT
#include "sway_node.h"

#include <string.h>

#include "arithmetic/sway_int64.h"

#define OUTPUT_BIT(output) ((uint32_t)1U << (uint32_t)(output))
#define HEARTBEATS_PER_REPORT 10U
#define BEHIND_TO_RESTART 20U
#define ALARM_NEVER_SENT (-1)
#define ALARM_INPUTS_LOST 0x10

/* With each estimate goes everything from the alarm to the quality flags, and from the judgement
 * on. */
#define ESTIMATE_OUTPUTS                                                                           \
    ((OUTPUT_BIT(SWAY_OUTPUT_COUNT) - OUTPUT_BIT(SWAY_OUTPUT_JUDGEMENT)) |                         \
     (OUTPUT_BIT(SWAY_OUTPUT_FAULTS_SAMPLES) - 1U))
#define REPORT_OUTPUTS (OUTPUT_BIT(SWAY_OUTPUT_JUDGEMENT) - OUTPUT_BIT(SWAY_OUTPUT_FAULTS_SAMPLES))

static void count(uint32_t *counter, uint32_t by)
{
    *counter = *counter > UINT32_MAX - by ? UINT32_MAX : *counter + by;
}

static void fault(sway_node_t *node, sway_frame_fault_t kind)
{
    count(&node->frame_fault[kind], 1U);
}

sway_error_t sway_node_init(sway_node_t *node, const sway_core_config_t *config)
{
    if (node == NULL || config == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    (void)memset(node, 0, sizeof(*node));
    node->alarm_sent = ALARM_NEVER_SENT;
    return sway_core_init(&node->core, config);
}

/* --- time: timeouts and what is due ------------------------------------------------------------
 */

static void find_timeouts(sway_node_t *node)
{
    for (uint32_t i = 0U; i < (uint32_t)SWAY_MESSAGE_COUNT; i++) {
        sway_node_message_t *m = &node->message[i];
        if (m->state == (uint8_t)SWAY_MESSAGE_GOOD &&
            node->time_us - m->accepted_us > SWAY_NODE_TIMEOUT_US) {
            m->state = (uint8_t)SWAY_MESSAGE_TIMED_OUT;
            fault(node, SWAY_FRAME_FAULT_TIMEOUT);
        }
    }
}

static void beat(sway_node_t *node)
{
    if (node->time_us < node->heartbeat_us) {
        return;
    }
    const int64_t beats =
        1 + sway_int64_divide(node->time_us - node->heartbeat_us, SWAY_NODE_HEARTBEAT_US);
    node->heartbeat_us += beats * SWAY_NODE_HEARTBEAT_US;
    node->pending |= OUTPUT_BIT(SWAY_OUTPUT_ALARM);
    node->heartbeats++;
    if (node->heartbeats % HEARTBEATS_PER_REPORT == 0U) {
        node->pending |= REPORT_OUTPUTS;
    }
}

/* So many times in a row, all far behind, are no jitter and no single wrong stamp. */
static bool clock_restarted(sway_node_t *node, int64_t time_us)
{
    const bool behind = node->time_us - time_us > SWAY_NODE_TIMEOUT_US;
    node->behind = behind ? (uint8_t)(node->behind + 1U) : 0U;
    return node->behind >= BEHIND_TO_RESTART;
}

static void restart_clock(sway_node_t *node, int64_t time_us)
{
    node->behind = 0U;
    node->time_us = time_us;
    node->heartbeat_us = time_us;
    for (uint32_t i = 0U; i < (uint32_t)SWAY_MESSAGE_COUNT; i++) {
        node->message[i].accepted_us = time_us;
    }
    for (uint32_t i = 0U; i < SWAY_INPUT_PLACES; i++) {
        node->watch[i].since_us = time_us;
    }
}

static void advance(sway_node_t *node, int64_t time_us)
{
    if (!node->started) {
        node->started = true;
        node->time_us = time_us;
        node->heartbeat_us = time_us;
    }
    if (time_us > node->time_us) {
        node->time_us = time_us;
        node->behind = 0U;
    } else if (clock_restarted(node, time_us)) {
        restart_clock(node, time_us);
    }
    find_timeouts(node);
    beat(node);
}

static bool is_good(const sway_node_t *node, sway_message_t message)
{
    return node->message[message].state == (uint8_t)SWAY_MESSAGE_GOOD;
}

/* The core judges from the remaining inputs, as long as any motion signal arrives. */
static bool is_blind(const sway_node_t *node)
{
    return !is_good(node, SWAY_MESSAGE_CAR_MOTION) && !is_good(node, SWAY_MESSAGE_TRAILER_MOTION) &&
           !is_good(node, SWAY_MESSAGE_ARTICULATION);
}

static int32_t alarm_now(const sway_node_t *node)
{
    const int32_t state =
        is_blind(node) ? (int32_t)SWAY_ALARM_OFF : sway_core_status(&node->core)->alarm;
    return state | (sway_node_inputs_lost(node) ? ALARM_INPUTS_LOST : 0);
}

/* Estimates and changes are sent at once. */
static void find_news(sway_node_t *node)
{
    const uint32_t sequence = sway_core_status(&node->core)->sequence;
    if (sequence != node->sequence) {
        node->sequence = sequence;
        node->pending |= ESTIMATE_OUTPUTS;
    }
    if (alarm_now(node) != node->alarm_sent) {
        node->pending |= OUTPUT_BIT(SWAY_OUTPUT_ALARM);
    }
    for (uint32_t i = 0U; i < (uint32_t)SWAY_MESSAGE_COUNT; i++) {
        if (node->message[i].state != node->message_state[i]) {
            node->pending |= OUTPUT_BIT(SWAY_OUTPUT_INPUTS);
        }
    }
}

bool sway_node_run(sway_node_t *node)
{
    if (!node->is_due) {
        return false;
    }
    node->is_due = sway_core_run(&node->core);
    if (sway_core_status(&node->core)->sequence != node->sequence) {
        find_news(node);
    }
    return node->is_due;
}

void sway_node_time(sway_node_t *node, int64_t time_us)
{
    while (sway_node_run(node)) {
    }
    advance(node, time_us);
    find_news(node);
}

/* --- frozen sensors ----------------------------------------------------------------------------
 */

static bool is_watched(sway_input_t input)
{
    const bool motion = input >= SWAY_INPUT_CAR_YAW_RATE && input <= SWAY_INPUT_ARTICULATION;
    const bool car_fy = input >= SWAY_INPUT_CAR_FY_FL && input <= SWAY_INPUT_CAR_FY_RR;
    const bool trailer_fy = input >= SWAY_INPUT_TRAILER_FY_FL && input <= SWAY_INPUT_TRAILER_FY_RR;
    return motion || car_fy || trailer_fy || input == SWAY_INPUT_HITCH_FY;
}

static void travel(sway_node_t *node, sway_input_t input, int32_t value)
{
    if (input == SWAY_INPUT_CAR_YAW_RATE || input == SWAY_INPUT_TRAILER_YAW_RATE) {
        int32_t *anchor = &node->travel_anchor_urad_s[input == SWAY_INPUT_TRAILER_YAW_RATE];
        const int32_t step = value > *anchor ? value - *anchor : *anchor - value;
        if (step >= SWAY_NODE_TRAVEL_STEP_URAD_S) {
            node->travel_urad_s += step;
            *anchor = value;
        }
    }
}

static bool is_frozen(sway_node_t *node, const sway_sample_t *sample, int64_t time_us)
{
    sway_node_watch_t *w = &node->watch[sway_input_place(sample->input)];
    if (!w->started || sample->value != w->value) {
        travel(node, sample->input, sample->value);
        w->started = true;
        w->frozen = false;
        w->value = sample->value;
        w->since_us = time_us;
        w->travel = node->travel_urad_s;
    } else if (!w->frozen && is_watched(sample->input) &&
               time_us - w->since_us >= SWAY_NODE_FROZEN_US &&
               node->travel_urad_s - w->travel >= SWAY_NODE_FROZEN_TRAVEL_URAD_S) {
        w->frozen = true;
        fault(node, SWAY_FRAME_FAULT_FROZEN);
    }
    return w->frozen;
}

/* --- frames in ---------------------------------------------------------------------------------
 */

/* True where the counter says that this frame is new; counts what is wrong otherwise. */
static bool is_new(sway_node_t *node, sway_node_message_t *m, int64_t time_us, uint8_t counter)
{
    const int32_t steps = sway_e2e_step(&m->e2e, counter, time_us, SWAY_NODE_COUNT_LIMIT_US);
    if (steps > 0) {
        count(&node->frame_fault[SWAY_FRAME_FAULT_LOST], (uint32_t)(steps - 1));
        m->repeats = 0U;
        return true;
    }
    if (steps < 0) {
        fault(node, SWAY_FRAME_FAULT_LATE);
        return false;
    }
    fault(node, SWAY_FRAME_FAULT_REPEATED);
    if (m->repeats < UINT8_MAX) {
        m->repeats++;
    }
    if (m->repeats == SWAY_NODE_STUCK_REPEATS) {
        m->state = (uint8_t)SWAY_MESSAGE_STUCK;
        fault(node, SWAY_FRAME_FAULT_STUCK);
    }
    return false;
}

static sway_error_t feed(sway_node_t *node, int64_t time_us, const sway_sample_t *sample)
{
    if (!sample->valid || is_frozen(node, sample, time_us)) {
        sway_core_invalid(&node->core, sample->input, time_us);
        return SWAY_OK;
    }
    return sway_core_input(&node->core, sample->input, time_us, sample->value);
}

/* Uses samples of a message; `frozen`: so is a sensor of it that is not among them. */
static sway_error_t take(sway_node_t *node, sway_message_t message, int64_t time_us,
                         const sway_sample_t *samples, uint32_t length, bool frozen)
{
    sway_error_t result = SWAY_OK;
    for (uint32_t i = 0U; i < length; i++) {
        const uint32_t place = sway_input_place(samples[i].input);
        if (place == SWAY_INPUT_PLACES) {
            continue; // the build has no use for it
        }
        const sway_error_t error = feed(node, time_us, &samples[i]);
        result = error != SWAY_OK ? error : result;
        frozen = frozen || node->watch[place].frozen;
    }
    node->message[message].accepted_us = time_us;
    node->message[message].state = (uint8_t)(frozen ? SWAY_MESSAGE_STUCK : SWAY_MESSAGE_GOOD);
    count(&node->accepted, 1U);
    node->is_due = true;
    return result;
}

static sway_error_t use(sway_node_t *node, sway_message_t message, int64_t time_us,
                        const uint8_t *data)
{
    sway_sample_t samples[SWAY_FRAME_SAMPLES_MAX];
    const uint32_t length = sway_frames_decode(message, data, samples);
    return take(node, message, time_us, samples, length, false);
}

static sway_error_t judge(sway_node_t *node, int64_t time_us, uint32_t can_id, uint8_t dlc,
                          const uint8_t *data)
{
    const sway_message_t message = sway_frames_find(can_id);
    if (message == SWAY_MESSAGE_COUNT) {
        fault(node, SWAY_FRAME_FAULT_UNKNOWN);
        return SWAY_ERROR_UNKNOWN_ID;
    }
    if (dlc != SWAY_E2E_LENGTH) {
        fault(node, SWAY_FRAME_FAULT_LENGTH);
        return SWAY_ERROR_FRAME;
    }
    if (!sway_e2e_check(can_id, data)) {
        fault(node, SWAY_FRAME_FAULT_CRC);
        return SWAY_ERROR_FRAME;
    }
    if (!is_new(node, &node->message[message], time_us, data[1] & 0x0FU)) {
        return SWAY_ERROR_FRAME;
    }
    return use(node, message, time_us, data);
}

sway_error_t sway_node_receive(sway_node_t *node, int64_t time_us, uint32_t can_id, uint8_t dlc,
                               const uint8_t *data)
{
    while (sway_node_run(node)) {
    }
    advance(node, time_us);
    const sway_error_t result = judge(node, time_us, can_id, dlc, data);
    find_news(node);
    return result;
}

/* Another sensor of the message that would carry `input`. */
static bool is_frozen_beside(const sway_node_t *node, sway_input_t input)
{
    const sway_message_t message = sway_frames_message_of(input);
    bool frozen = false;
    for (uint32_t place = 0U; place < SWAY_INPUT_PLACES; place++) {
        const sway_input_t other =
            place == SWAY_PLACE_OF_SPEED ? SWAY_INPUT_SPEED : (sway_input_t)place;
        frozen = frozen || (node->watch[place].frozen && other != input &&
                            sway_frames_message_of(other) == message);
    }
    return frozen;
}

sway_error_t sway_node_sample(sway_node_t *node, int64_t time_us, const sway_sample_t *sample)
{
    while (sway_node_run(node)) {
    }
    advance(node, time_us);
    const sway_error_t result = take(node, sway_frames_message_of(sample->input), time_us, sample,
                                     1U, is_frozen_beside(node, sample->input));
    find_news(node);
    return result;
}

void sway_node_refuse(sway_node_t *node, int64_t time_us, sway_frame_fault_t kind)
{
    sway_node_time(node, time_us);
    fault(node, kind);
}

/* --- frames out --------------------------------------------------------------------------------
 */

static void encode(sway_node_t *node, sway_output_t output, uint8_t *data)
{
    for (uint32_t i = 0U; output == SWAY_OUTPUT_INPUTS && i < (uint32_t)SWAY_MESSAGE_COUNT; i++) {
        node->message_state[i] = node->message[i].state;
    }
    if (output == SWAY_OUTPUT_ALARM) {
        node->alarm_sent = alarm_now(node);
    }
    const sway_frames_source_t source = {.status = sway_core_status(&node->core),
                                         .message_state = node->message_state,
                                         .frame_fault = node->frame_fault,
                                         .inputs_lost = sway_node_inputs_lost(node),
                                         .blind = is_blind(node)};
    sway_frames_encode(output, &source, data);
}

bool sway_node_transmit(sway_node_t *node, uint32_t *can_id, uint8_t *dlc, uint8_t *data)
{
    uint32_t output = 0U;
    while (output < (uint32_t)SWAY_OUTPUT_COUNT && (node->pending & OUTPUT_BIT(output)) == 0U) {
        output++;
    }
    if (output == (uint32_t)SWAY_OUTPUT_COUNT) {
        return false;
    }
    node->pending &= ~OUTPUT_BIT(output);
    *can_id = sway_frames_output_id((sway_output_t)output);
    *dlc = (uint8_t)SWAY_E2E_LENGTH;
    encode(node, (sway_output_t)output, data);
    sway_e2e_protect(*can_id, node->counter[output], data);
    node->counter[output] = sway_e2e_next(node->counter[output]);
    return true;
}

/* --- what ports ask ----------------------------------------------------------------------------
 */

uint32_t sway_node_fault(const sway_node_t *node, sway_frame_fault_t kind)
{
    return node->frame_fault[kind];
}

sway_message_state_t sway_node_message_state(const sway_node_t *node, sway_message_t message)
{
    return (sway_message_state_t)node->message[message].state;
}

bool sway_node_inputs_lost(const sway_node_t *node)
{
    const bool trailer = node->core.config.vehicle.trailer.axles > 0;
    return !is_good(node, SWAY_MESSAGE_SPEED) || !is_good(node, SWAY_MESSAGE_CAR_MOTION) ||
           (trailer && !is_good(node, SWAY_MESSAGE_TRAILER_MOTION));
}

#include "sway_ecu.h"

#include <string.h>

#include "arithmetic/sway_real.h"
#include "swaywatch_dbc.h"

#define RETAINED_MARK UINT32_C(0x53574159)
#define CANARY UINT32_C(0x5AFEC0DE)
#define REPORT_RUNNING_US 1000000
#define REPORT_SAFE_US 100000
#define ID_REQUEST SWAYWATCH_DBC_SWAY_PARAMETER_REQUEST_FRAME_ID
#define ID_REPLY SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID
#define ID_REPORT SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID
#define ID_ACCESS SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID
#define ID_TRAILER SWAYWATCH_DBC_SWAY_TRAILER_FRAME_ID
#define ACCESS_US 100000
#define TRAILER_US 1000000
#define KEEP_US 10000000 // between two looks whether something is worth keeping
#define KEEP_MOST 20U    // between two power-ups
#define SPEED_AGE_US 500000

enum {
    COMMAND_READ,
    COMMAND_WRITE,
    COMMAND_APPLY,
    COMMAND_STORE,
    COMMAND_DISCARD,
    COMMAND_VERSION,
    COMMAND_OPEN
};
typedef enum {
    RESULT_DONE,
    RESULT_NO_INDEX,
    RESULT_REFUSED,
    RESULT_NOT_STORED,
    RESULT_NO_COMMAND,
    RESULT_LOCKED,
    RESULT_MOVING,
    RESULT_FORGED,
    RESULT_WORN
} result_t;
enum { ACCESS_LOCKED, ACCESS_OPEN, ACCESS_NO_KEY };

/* What a request says and, from `number` on, what its reply will. */
typedef struct {
    uint8_t command;
    uint32_t number;
    int32_t value;
    const uint8_t *proof; ///< the bytes of number and value
} request_t;

/* --- retained memory ------------------------------------------------------------------------- */

static uint32_t retained_check(const sway_ecu_retained_t *retained)
{
    const uint32_t restarts = retained->restarts; // turned: each of its bits counts
    return RETAINED_MARK ^ retained->cause ^ (retained->address * 3U) ^
           (restarts << 24 | restarts >> 8);
}

static bool retained_is_good(const sway_ecu_retained_t *retained)
{
    return retained->check == retained_check(retained);
}

void sway_ecu_note_fault(sway_ecu_retained_t *retained, uint32_t cause, uint32_t address)
{
    if (!retained_is_good(retained)) {
        retained->restarts = 0U;
    }
    retained->cause = cause;
    retained->address = address;
    if (retained->restarts < 255U) {
        retained->restarts += 1U;
    }
    retained->check = retained_check(retained);
}

/* --- self-test ------------------------------------------------------------------------------- */

static bool is_near(sway_real_t value, int32_t micro)
{
    return sway_real_to_int(value, 1000000, INT32_MIN, INT32_MAX) == micro;
}

sway_ecu_cause_t sway_ecu_self_test(void)
{
    const sway_real_t third = sway_real_ratio(1, 3);
    const sway_real_t two = sway_real_int(2);
    const bool arithmetic =
        is_near(sway_real_exp(third), 1395612) && is_near(sway_real_sqrt(two), 1414214) &&
        is_near(sway_real_atan2(third, two), 165149) && is_near(sway_real_ln(two), 693147) &&
        is_near(sway_real_sub(sway_real_mul(third, two), two), -1333333);
    const bool checksum = sway_block_crc32(0, "123456789", 9) == UINT32_C(0xCBF43926);
    return arithmetic && checksum ? SWAY_ECU_NO_CAUSE : SWAY_ECU_ARITHMETIC;
}

/* --- frames ---------------------------------------------------------------------------------- */

/* All frames of the ECU's own have one layout: beside CRC and counter half a byte, 16 bits and 32
 * bits. That takes less flash than the codec, by which the tests read and write the same frames. */
static void compose(sway_port_frame_t *frame, uint16_t id, uint8_t *counter, uint32_t nibble,
                    uint32_t half, uint32_t word)
{
    frame->id = id;
    frame->dlc = 8;
    frame->data[1] = (uint8_t)(nibble << 4);
    for (unsigned i = 0; i < 2U; i++) {
        frame->data[2U + i] = (uint8_t)(half >> (8U * i));
    }
    for (unsigned i = 0; i < 4U; i++) {
        frame->data[4U + i] = (uint8_t)(word >> (8U * i));
    }
    sway_e2e_protect(id, *counter, frame->data);
    *counter = sway_e2e_next(*counter);
}

static void send(sway_ecu_t *ecu, sway_port_frame_t *frame)
{
    frame->time_us = ecu->now_us;
    if (ecu->port.send(ecu->port.context, frame)) {
        ecu->frames_sent += 1U;
    } else {
        ecu->outgoing = *frame;
        ecu->outgoing_waits = true;
    }
}

/* Two senders of one message have two counters. A stuck counter looks the same; either is reported
 * in the second in which it happens. */
static bool is_doubled(sway_ecu_t *ecu)
{
    const uint32_t before = ecu->doubled;
    ecu->doubled = sway_node_fault(&ecu->node, SWAY_FRAME_FAULT_REPEATED);
    return ecu->doubled - before >= SWAY_ECU_DOUBLED_FRAMES;
}

static uint32_t cause_now(sway_ecu_t *ecu)
{
    if (ecu->state == SWAY_ECU_SAFE) {
        return (uint32_t)ecu->cause;
    }
    if (is_doubled(ecu)) {
        return SWAY_ECU_DOUBLED;
    }
    return ecu->notice != SWAY_ECU_NO_CAUSE ? (uint32_t)ecu->notice : ecu->retained->cause;
}

static void send_report(sway_ecu_t *ecu)
{
    const bool safe = ecu->state == SWAY_ECU_SAFE;
    sway_port_frame_t frame;
    compose(&frame, ID_REPORT, &ecu->report_counter, (uint32_t)ecu->state,
            cause_now(ecu) | ecu->retained->restarts << 8, ecu->retained->address);
    ecu->report_due_us = ecu->now_us + (safe ? REPORT_SAFE_US : REPORT_RUNNING_US);
    send(ecu, &frame);
}

static uint32_t held(uint32_t count)
{
    return count < UINT16_MAX ? count : UINT16_MAX;
}

static void send_access(sway_ecu_t *ecu)
{
    sway_port_frame_t frame;
    uint32_t state = ACCESS_NO_KEY;
    if (ecu->port.key != NULL) {
        state = sway_access_is_open(&ecu->access, ecu->now_us) ? ACCESS_OPEN : ACCESS_LOCKED;
    }
    compose(&frame, ID_ACCESS, &ecu->access_counter, state, held(ecu->requests_refused),
            held(ecu->access.forged) | (uint32_t)ecu->access.stores << 16);
    ecu->access_due_us = ecu->now_us + ACCESS_US;
    ecu->access_news = false;
    send(ecu, &frame);
}

/* --- start ----------------------------------------------------------------------------------- */

void sway_ecu_fail(sway_ecu_t *ecu, sway_ecu_cause_t cause)
{
    if (ecu->state != SWAY_ECU_SAFE) {
        ecu->state = SWAY_ECU_SAFE;
        ecu->cause = cause;
        ecu->report_due_us = ecu->now_us;
    }
}

void sway_ecu_warn(sway_ecu_t *ecu, sway_ecu_cause_t cause)
{
    ecu->notice = cause;
    ecu->report_due_us = ecu->now_us;
}

const sway_core_config_t *sway_ecu_config(const sway_ecu_t *ecu)
{
    return &ecu->node.core.config;
}

bool sway_ecu_gave_up(const sway_ecu_retained_t *retained)
{
    return retained_is_good(retained) && retained->restarts >= SWAY_ECU_RESTARTS_MAX;
}

#if SWAY_REMEMBER
static void remember_restart(sway_ecu_t *ecu)
{
    if (ecu->keep != NULL) {
        sway_remember_restart(&ecu->remember, &ecu->node.core.watch, sway_ecu_config(ecu));
    }
}
#else
static void remember_restart(sway_ecu_t *ecu)
{
    (void)ecu;
}
#endif

/* With the staged values, which must be in their ranges. */
static void start_node(sway_ecu_t *ecu)
{
    ecu->state = SWAY_ECU_RUNNING;
    ecu->doubled = 0U;
    if (sway_node_init(&ecu->node, &ecu->staged) != SWAY_OK) {
        sway_ecu_fail(ecu, (sway_ecu_cause_t)(SWAY_ECU_BLOCK + SWAY_BLOCK_REFUSED));
        return;
    }
    remember_restart(ecu);
}

static bool is_staged_good(const sway_ecu_t *ecu)
{
    return sway_block_offender(&ecu->staged) == SWAY_BLOCK_WORDS;
}

#if SWAY_MAP
void sway_ecu_listen(sway_ecu_t *ecu, sway_ecu_listen_t listen, void *context)
{
    ecu->listen = listen;
    ecu->listen_context = context;
}
#endif

static void hear(sway_ecu_t *ecu, const sway_port_frame_t *frame)
{
#if SWAY_MAP
    if (ecu->listen != NULL) {
        ecu->listen(ecu->listen_context, &ecu->node, frame);
        return;
    }
#endif
    (void)sway_node_receive(&ecu->node, frame->time_us, frame->id, frame->dlc, frame->data);
}

sway_error_t sway_ecu_start(sway_ecu_t *ecu, const sway_port_t *port, sway_ecu_retained_t *retained,
                            const uint8_t *block, size_t block_size)
{
    if (ecu == NULL || port == NULL || retained == NULL || port->receive == NULL ||
        port->send == NULL || port->time_us == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    (void)memset(ecu, 0, sizeof *ecu);
    ecu->port = *port;
    ecu->retained = retained;
    ecu->canary = CANARY;
    if (!retained_is_good(retained)) {
        (void)memset(retained, 0, sizeof *retained);
        retained->check = retained_check(retained);
    }
    ecu->now_us = port->time_us(port->context);
    ecu->frame_us = ecu->now_us;
    ecu->report_due_us = ecu->now_us;
    sway_core_defaults(&ecu->staged);
    sway_block_result_t result =
        sway_block_read(block, block_size, &ecu->staged, &ecu->block_sequence);
    if (result == SWAY_BLOCK_OK && !is_staged_good(ecu)) {
        result = SWAY_BLOCK_REFUSED;
    }
    const sway_ecu_cause_t cause = sway_ecu_self_test();
    if (cause != SWAY_ECU_NO_CAUSE) {
        sway_ecu_fail(ecu, cause);
    } else if (sway_ecu_gave_up(retained)) {
        sway_ecu_fail(ecu, SWAY_ECU_RESTARTS);
    } else if (result != SWAY_BLOCK_OK) {
        sway_ecu_fail(ecu, (sway_ecu_cause_t)(SWAY_ECU_BLOCK + (int)result));
    } else {
        start_node(ecu);
    }
    return SWAY_OK;
}

/* --- parameters over CAN --------------------------------------------------------------------- */

/* A safe state for want of parameters ends with good ones; any other stays. */
static bool may_apply(const sway_ecu_t *ecu)
{
    return ecu->state == SWAY_ECU_RUNNING ||
           ((int)ecu->cause >= (int)SWAY_ECU_BLOCK && (int)ecu->cause < (int)SWAY_ECU_RESTARTS);
}

/* Where the ECU watches, new values make it begin anew: only where there is nothing to watch. A
 * speed that is not known is none that stands still. */
static bool is_standing(const sway_ecu_t *ecu)
{
    const sway_core_t *core = &ecu->node.core;
    return ecu->state == SWAY_ECU_SAFE ||
           (sway_node_message_state(&ecu->node, SWAY_MESSAGE_SPEED) == SWAY_MESSAGE_GOOD &&
            core->speed_mm_s >= 0 && core->speed_mm_s <= SWAY_ECU_STANDSTILL_MM_S &&
            ecu->now_us - core->speed_time_us <= SPEED_AGE_US);
}

static uint32_t pair(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8;
}

static result_t open_session(sway_ecu_t *ecu, request_t *request)
{
    const uint8_t *c = ecu->access.challenge;
    if (ecu->port.key == NULL || !may_apply(ecu)) {
        return RESULT_LOCKED;
    }
    if (!is_standing(ecu)) {
        return RESULT_MOVING;
    }
    const uint32_t random = ecu->port.random == NULL ? 0U : ecu->port.random(ecu->port.context);
    sway_access_open(&ecu->access, ecu->port.key, ecu->now_us, ecu->block_sequence, random);
    request->number = pair(c);
    request->value = (int32_t)(pair(c + 2) | pair(c + 4) << 16);
    ecu->access_news = true;
    return RESULT_DONE;
}

static result_t store(sway_ecu_t *ecu, const uint8_t *block)
{
    if (ecu->access.stores >= SWAY_ACCESS_STORES_MAX ||
        ecu->block_sequence >= SWAY_ACCESS_SEQUENCE_MAX) {
        return RESULT_WORN;
    }
    if (ecu->port.store == NULL) {
        return RESULT_NOT_STORED;
    }
    ecu->access.stores++; // an erasure that fails wears, too
    if (!ecu->port.store(ecu->port.context, block, SWAY_BLOCK_SIZE)) {
        return RESULT_NOT_STORED;
    }
    ecu->block_sequence += 1U;
    return RESULT_DONE;
}

/* Of a session's last request: proof, then state, then values; the reply names the first word that
 * is out of its range. */
SWAY_NOINLINE result_t change(sway_ecu_t *ecu, request_t *request)
{
    sway_access_message_t message = {.command = request->command};
    ecu->access_news = true;
    sway_block_write(&ecu->staged, ecu->block_sequence + 1U, message.block);
    if (!sway_access_close(&ecu->access, ecu->port.key, &message, sizeof message, request->proof)) {
        return RESULT_FORGED;
    }
    if (!is_standing(ecu)) {
        return RESULT_MOVING;
    }
    const uint32_t offender = sway_block_offender(&ecu->staged);
    if (!may_apply(ecu) || sway_block_get(&ecu->staged, offender, &request->value) == SWAY_OK) {
        request->number = offender;
        return RESULT_REFUSED;
    }
    request->number = 0U;
    request->value = 0;
    start_node(ecu);
    return request->command == COMMAND_STORE ? store(ecu, message.block) : RESULT_DONE;
}

static void discard(sway_ecu_t *ecu)
{
    if (ecu->state == SWAY_ECU_RUNNING) {
        ecu->staged = *sway_ecu_config(ecu);
    } else {
        sway_core_defaults(&ecu->staged);
    }
}

static result_t obey_in_session(sway_ecu_t *ecu, request_t *request)
{
    if (!sway_access_is_open(&ecu->access, ecu->now_us)) {
        return RESULT_LOCKED;
    }
    if (request->command == COMMAND_WRITE) {
        return sway_block_set(&ecu->staged, request->number, request->value) == SWAY_OK
                   ? RESULT_DONE
                   : RESULT_NO_INDEX;
    }
    if (request->command == COMMAND_DISCARD) {
        discard(ecu);
        return RESULT_DONE;
    }
    return change(ecu, request);
}

static result_t obey(sway_ecu_t *ecu, request_t *request)
{
    switch (request->command) {
    case COMMAND_READ:
        return sway_block_get(&ecu->staged, request->number, &request->value) == SWAY_OK
                   ? RESULT_DONE
                   : RESULT_NO_INDEX;
    case COMMAND_VERSION:
        request->value = (int32_t)(SWAY_BLOCK_VERSION | ecu->block_sequence << 16);
        return RESULT_DONE;
    case COMMAND_OPEN:
        return open_session(ecu, request);
    default:
        return request->command < COMMAND_OPEN ? obey_in_session(ecu, request) : RESULT_NO_COMMAND;
    }
}

static void refuse(sway_ecu_t *ecu)
{
    ecu->requests_refused += 1U;
    ecu->access_news = true;
}

sway_ecu_change_t sway_ecu_calibrate(sway_ecu_t *ecu, const sway_core_config_t *config)
{
    if (ecu->state == SWAY_ECU_RUNNING) {
        sway_node_time(&ecu->node, ecu->now_us); // whether the speed is still there
    }
    if (sway_block_offender(config) != SWAY_BLOCK_WORDS) {
        return SWAY_ECU_OUT_OF_RANGE;
    }
    if (!may_apply(ecu) || !is_standing(ecu)) {
        return SWAY_ECU_NOT_NOW;
    }
    ecu->staged = *config;
    start_node(ecu);
    return SWAY_ECU_CHANGED;
}

void sway_ecu_refuse(sway_ecu_t *ecu)
{
    refuse(ecu);
}

/* A request that came twice is obeyed once. */
static bool is_fresh(sway_ecu_t *ecu, const uint8_t *data)
{
    const uint16_t mark = (uint16_t)(data[0] | (data[1] & 15U) << 8 | 0x8000U);
    const bool is_new = mark != ecu->last_request;
    ecu->last_request = mark;
    return is_new;
}

static void answer(sway_ecu_t *ecu, const sway_port_frame_t *frame)
{
    const uint8_t *data = frame->data;
    if (frame->dlc != 8U || !sway_e2e_check(frame->id, data) || !is_fresh(ecu, data) ||
        ecu->reply_waits) {
        refuse(ecu);
        return;
    }
    if (ecu->state == SWAY_ECU_RUNNING) {
        sway_node_time(&ecu->node, ecu->now_us); // whether the speed is still there
    }
    request_t request = {.command = data[1] >> 4, .proof = data + 2};
    request.number = pair(data + 2);
    request.value = (int32_t)(pair(data + 4) | pair(data + 6) << 16);
    const result_t result = obey(ecu, &request);
    if (result != RESULT_DONE) {
        refuse(ecu);
    }
    compose(&ecu->reply, ID_REPLY, &ecu->reply_counter, (uint32_t)result, request.number,
            (uint32_t)request.value);
    ecu->reply_waits = true;
}

/* --- the trailer remembered ------------------------------------------------------------------- */

#if SWAY_REMEMBER

static bool remembers(const sway_ecu_t *ecu)
{
    return ecu->keep != NULL && ecu->state == SWAY_ECU_RUNNING;
}

void sway_ecu_remember(sway_ecu_t *ecu, sway_ecu_keep_t keep, const uint8_t *record, size_t size)
{
    ecu->keep = keep;
    ecu->trailer_due_us = ecu->now_us;
    sway_remember_begin(&ecu->remember, record, size, sway_ecu_config(ecu));
    if (remembers(ecu)) {
        remember_restart(ecu);
    }
}

/* A write that fails wears, too. */
void sway_ecu_leave(sway_ecu_t *ecu)
{
    uint8_t record[SWAY_REMEMBER_SIZE];
    if (!remembers(ecu) || ecu->remember.writes >= KEEP_MOST ||
        !sway_remember_wants(&ecu->remember, &ecu->node.core.watch, record)) {
        return;
    }
    if (ecu->keep(ecu->port.context, record, sizeof record)) {
        sway_remember_kept(&ecu->remember, &ecu->node.core.watch);
    } else {
        ecu->remember.writes++;
    }
}

/* By the times of frames alone, when all work of the frames before is done. */
static void remember(sway_ecu_t *ecu)
{
    if (!remembers(ecu)) {
        return;
    }
    (void)sway_remember_look(&ecu->remember, &ecu->node.core.watch);
    if (ecu->now_us >= ecu->keep_due_us && is_standing(ecu)) {
        ecu->keep_due_us = ecu->now_us + KEEP_US;
        sway_ecu_leave(ecu);
    }
}

static bool give_trailer(sway_ecu_t *ecu)
{
    const sway_remember_t *const known = &ecu->remember;
    const sway_trailer_watch_t *const watch = &ecu->node.core.watch;
    sway_port_frame_t frame;
    if (!remembers(ecu) || ecu->now_us < ecu->trailer_due_us) {
        return false;
    }
    const int32_t likeness = sway_real_to_int(known->likeness, 100, -INT16_MAX, INT16_MAX);
    compose(&frame, ID_TRAILER, &ecu->trailer_counter, (uint32_t)sway_remember_state(known, watch),
            (uint32_t)likeness & 0xFFFFU,
            held((uint32_t)watch->learnt_ms / 1000U) | (uint32_t)known->writes << 16);
    ecu->trailer_due_us = ecu->now_us + TRAILER_US;
    send(ecu, &frame);
    return true;
}

#else

static void remember(sway_ecu_t *ecu)
{
    (void)ecu;
}

static bool give_trailer(sway_ecu_t *ecu)
{
    (void)ecu;
    return false;
}

#endif

/* --- running --------------------------------------------------------------------------------- */

static void take(sway_ecu_t *ecu, const sway_port_frame_t *frame)
{
    ecu->now_us = frame->time_us;
    ecu->frame_us = frame->time_us;
    ecu->frames_received += 1U;
    if (frame->id == ID_REQUEST) {
        answer(ecu, frame);
    } else if (ecu->state == SWAY_ECU_RUNNING) {
        hear(ecu, frame);
        remember(ecu);
    }
}

/* One frame that is due: a reply, of the node, else a report. */
static bool give(sway_ecu_t *ecu)
{
    sway_port_frame_t frame;
    uint32_t id = 0;
    if (ecu->outgoing_waits) {
        return false;
    }
    if (ecu->reply_waits) {
        ecu->reply_waits = false;
        send(ecu, &ecu->reply);
        return true;
    }
    if (ecu->state == SWAY_ECU_RUNNING &&
        sway_node_transmit(&ecu->node, &id, &frame.dlc, frame.data)) {
        frame.id = (uint16_t)id;
        send(ecu, &frame);
        return true;
    }
    if (ecu->now_us >= ecu->report_due_us) {
        send_report(ecu);
        return true;
    }
    if (ecu->access_news && ecu->now_us >= ecu->access_due_us) {
        send_access(ecu);
        return true;
    }
    return give_trailer(ecu);
}

static bool work(sway_ecu_t *ecu)
{
    return ecu->state == SWAY_ECU_RUNNING && sway_node_run(&ecu->node);
}

static void offer_again(sway_ecu_t *ecu)
{
    if (ecu->outgoing_waits && ecu->port.send(ecu->port.context, &ecu->outgoing)) {
        ecu->outgoing_waits = false;
        ecu->frames_sent += 1U;
    }
}

/* A silent bus still has its timeouts and heartbeats. As long as frames come, only their own times
 * count, so that a recording gives the same answer on every machine. */
static void idle(sway_ecu_t *ecu, int64_t now_us)
{
    if (now_us < ecu->frame_us + SWAY_NODE_TIMEOUT_US) {
        return;
    }
    ecu->now_us = now_us > ecu->now_us ? now_us : ecu->now_us;
    if (ecu->state == SWAY_ECU_RUNNING) {
        sway_node_time(&ecu->node, ecu->now_us);
    }
}

bool sway_ecu_poll(sway_ecu_t *ecu)
{
    if (ecu->canary != CANARY || ecu->retained == NULL) {
        return false; // no longer sound: the watchdog is not served and will restart the ECU
    }
    if (ecu->port.alive != NULL) {
        ecu->port.alive(ecu->port.context);
    }
    offer_again(ecu);
    if (work(ecu) || give(ecu)) {
        return true;
    }
    sway_port_frame_t frame;
    if (ecu->port.receive(ecu->port.context, &frame)) {
        take(ecu, &frame);
        return true;
    }
    idle(ecu, ecu->port.time_us(ecu->port.context));
    return give(ecu);
}

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

enum {
    COMMAND_READ,
    COMMAND_WRITE,
    COMMAND_APPLY,
    COMMAND_STORE,
    COMMAND_DISCARD,
    COMMAND_VERSION
};
enum { RESULT_DONE, RESULT_NO_INDEX, RESULT_REFUSED, RESULT_NOT_STORED, RESULT_NO_COMMAND };

/* --- retained memory ------------------------------------------------------------------------- */

static uint32_t retained_check(const sway_ecu_retained_t *retained)
{
    return RETAINED_MARK ^ retained->cause ^ (retained->address * 3U) ^ (retained->restarts << 24);
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

void sway_ecu_fault_frame(sway_port_frame_t *frame, sway_ecu_state_t state, uint32_t cause,
                          uint32_t address, uint32_t restarts, uint8_t counter)
{
    const struct swaywatch_dbc_sway_fault_report_t report = {
        .ecu_state = (uint8_t)state,
        .fault_cause = (uint8_t)cause,
        .fault_restarts = (uint8_t)restarts,
        .fault_address = address,
    };
    frame->id = ID_REPORT;
    frame->dlc = 8;
    (void)swaywatch_dbc_sway_fault_report_pack(frame->data, &report, sizeof frame->data);
    sway_e2e_protect(frame->id, counter, frame->data);
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

static void send_report(sway_ecu_t *ecu)
{
    const bool safe = ecu->state == SWAY_ECU_SAFE;
    const bool has_notice = ecu->notice != SWAY_ECU_NO_CAUSE;
    const uint32_t cause = safe         ? (uint32_t)ecu->cause
                           : has_notice ? (uint32_t)ecu->notice
                                        : ecu->retained->cause;
    sway_port_frame_t frame;
    sway_ecu_fault_frame(&frame, ecu->state, cause, ecu->retained->address, ecu->retained->restarts,
                         ecu->report_counter);
    ecu->report_counter = sway_e2e_next(ecu->report_counter);
    ecu->report_due_us = ecu->now_us + (safe ? REPORT_SAFE_US : REPORT_RUNNING_US);
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

static bool start_node(sway_ecu_t *ecu, const sway_core_config_t *config)
{
    ecu->state = SWAY_ECU_RUNNING;
    if (sway_node_init(&ecu->node, config) != SWAY_OK) {
        sway_ecu_fail(ecu, (sway_ecu_cause_t)(SWAY_ECU_BLOCK + SWAY_BLOCK_REFUSED));
    }
    return ecu->state == SWAY_ECU_RUNNING;
}

sway_error_t sway_ecu_start(sway_ecu_t *ecu, const sway_port_t *port, sway_ecu_retained_t *retained,
                            const uint8_t *block, size_t block_size)
{
    if (ecu == NULL || port == NULL || retained == NULL || port->receive == NULL ||
        port->send == NULL || port->time_us == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    memset(ecu, 0, sizeof *ecu);
    ecu->port = *port;
    ecu->retained = retained;
    ecu->canary = CANARY;
    if (!retained_is_good(retained)) {
        memset(retained, 0, sizeof *retained);
        retained->check = retained_check(retained);
    }
    ecu->now_us = port->time_us(port->context);
    ecu->frame_us = ecu->now_us;
    ecu->report_due_us = ecu->now_us;
    sway_core_defaults(&ecu->config);
    const sway_block_result_t result =
        sway_block_read(block, block_size, &ecu->config, &ecu->block_sequence);
    ecu->staged = ecu->config;
    const sway_ecu_cause_t cause = sway_ecu_self_test();
    if (cause != SWAY_ECU_NO_CAUSE) {
        sway_ecu_fail(ecu, cause);
    } else if (retained->restarts > SWAY_ECU_RESTARTS_MAX) {
        sway_ecu_fail(ecu, SWAY_ECU_RESTARTS);
    } else if (result != SWAY_BLOCK_OK) {
        sway_ecu_fail(ecu, (sway_ecu_cause_t)(SWAY_ECU_BLOCK + (int)result));
    } else {
        (void)start_node(ecu, &ecu->config);
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

static uint8_t apply(sway_ecu_t *ecu)
{
    if (!may_apply(ecu)) {
        return RESULT_REFUSED;
    }
    const bool was_running = ecu->state == SWAY_ECU_RUNNING;
    if (start_node(ecu, &ecu->staged)) {
        ecu->config = ecu->staged;
        return RESULT_DONE;
    }
    if (was_running) {
        (void)start_node(ecu, &ecu->config);
    }
    return RESULT_REFUSED;
}

SWAY_NOINLINE uint8_t store(sway_ecu_t *ecu)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    const uint8_t result = apply(ecu);
    if (result != RESULT_DONE) {
        return result;
    }
    sway_block_write(&ecu->config, ecu->block_sequence + 1U, block);
    if (ecu->port.store == NULL || !ecu->port.store(ecu->port.context, block, sizeof block)) {
        return RESULT_NOT_STORED;
    }
    ecu->block_sequence += 1U;
    return RESULT_DONE;
}

/* Names the word that is out of its range; where none is, the ECU's state forbids new values. */
static uint8_t explain(const sway_ecu_t *ecu, uint8_t result, uint32_t *index, int32_t *value)
{
    if (result == RESULT_REFUSED) {
        const uint32_t offender = sway_block_offender(&ecu->staged);
        *index = sway_block_get(&ecu->staged, offender, value) == SWAY_OK ? offender : *index;
    }
    return result;
}

static uint8_t obey(sway_ecu_t *ecu, uint8_t command, uint32_t *number, int32_t *value)
{
    const uint32_t index = *number;
    switch (command) {
    case COMMAND_READ:
        return sway_block_get(&ecu->staged, index, value) == SWAY_OK ? RESULT_DONE
                                                                     : RESULT_NO_INDEX;
    case COMMAND_WRITE:
        return sway_block_set(&ecu->staged, index, *value) == SWAY_OK ? RESULT_DONE
                                                                      : RESULT_NO_INDEX;
    case COMMAND_APPLY:
        return explain(ecu, apply(ecu), number, value);
    case COMMAND_STORE:
        return explain(ecu, store(ecu), number, value);
    case COMMAND_DISCARD:
        ecu->staged = ecu->config;
        return RESULT_DONE;
    case COMMAND_VERSION:
        *value = (int32_t)(SWAY_BLOCK_VERSION | ecu->block_sequence << 16);
        return RESULT_DONE;
    default:
        return RESULT_NO_COMMAND;
    }
}

static void answer(sway_ecu_t *ecu, const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_parameter_request_t request;
    if (frame->dlc != 8U || !sway_e2e_check(frame->id, frame->data) ||
        swaywatch_dbc_sway_parameter_request_unpack(&request, frame->data, frame->dlc) != 0) {
        ecu->requests_refused += 1U;
        return;
    }
    int32_t value = request.parameter_value;
    uint32_t index = request.parameter_index;
    const uint8_t result = obey(ecu, request.parameter_command, &index, &value);
    if (result != RESULT_DONE) {
        ecu->requests_refused += 1U;
    }
    const struct swaywatch_dbc_sway_parameter_reply_t reply = {
        .parameter_result = result,
        .parameter_reply_index = (uint16_t)index,
        .parameter_reply_value = value,
    };
    sway_port_frame_t out = {.id = ID_REPLY, .dlc = 8};
    (void)swaywatch_dbc_sway_parameter_reply_pack(out.data, &reply, sizeof out.data);
    sway_e2e_protect(ID_REPLY, ecu->reply_counter, out.data);
    ecu->reply_counter = sway_e2e_next(ecu->reply_counter);
    send(ecu, &out);
}

/* --- running --------------------------------------------------------------------------------- */

static void take(sway_ecu_t *ecu, const sway_port_frame_t *frame)
{
    ecu->now_us = frame->time_us;
    ecu->frame_us = frame->time_us;
    ecu->frames_received += 1U;
    if (frame->id == ID_REQUEST) {
        answer(ecu, frame);
    } else if (ecu->state == SWAY_ECU_RUNNING) {
        (void)sway_node_receive(&ecu->node, frame->time_us, frame->id, frame->dlc, frame->data);
    }
}

/* One frame that is due: of the node, else the report. */
static bool give(sway_ecu_t *ecu)
{
    sway_port_frame_t frame;
    uint32_t id = 0;
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
    return false;
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
    if (ecu->outgoing_waits) {
        idle(ecu, ecu->port.time_us(ecu->port.context));
        return false;
    }
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

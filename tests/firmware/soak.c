/* soak: hours of driving in simulated time through the ECU, with a fault a minute.
 *
 *   soak MINUTES REPORT.md    the ECU on the host; the report is a table of what was counted
 *   soak --write RECORDING EXPECTED    the same drive, a fault every 4 s, as a candump file for
 * the emulated machines, and the counters that they must end with
 *
 * A combination sways without end at 0.656 Hz and 90 km/h. Faults take turns; each lasts a second
 * or more, then everything is right again. Checked without pause:
 *   - every fault counter ends at exactly the number that was injected (a model of the sender,
 * which knows what it did to each frame, says what a receiver has to count), on the ECU and on the
 * bus;
 *   - counters never go down;
 *   - every status frame has a right CRC and a counter one up from the last of its kind, also while
 *     the bus has no room;
 *   - no value is marked valid and wrong: frequency and damping against those of the drive;
 *   - no alarm judgement while speed or yaw rates have been away for longer than the timeout;
 *   - at the end of each period, long after its fault, estimates are valid again;
 *   - no hang: each 10 ms end after a bounded number of polls.
 * Prints what was wrong and exits with 1, or one line and 0. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "candump.h"
#include "sway_ecu.h"
#include "swaywatch_dbc.h"

#define TICK_US 10000
#define POLLS_MAX 2000
#define FIRST_STATUS 0x1A0
#define STATUS_COUNT 32
#define ID_REQUEST SWAYWATCH_DBC_SWAY_PARAMETER_REQUEST_FRAME_ID
#define TURN (SWAY_E2E_COUNTER_MAX + 1)
#define FREQUENCY_HZ (43000.0 / 65536.0)
#define NEVER INT64_MIN
#define CAR_MOTION 1 // of the senders: speed, car, trailer, steering
#define TRAILER_MOTION 2
#define AN_ESTIMATE_US 500000 // a window's sixteenth and the work on it, with room

typedef enum {
    FAULT_CRC,
    FAULT_LOST,
    FAULT_REPEATED,
    FAULT_LATE,
    FAULT_NOT_AVAILABLE,
    FAULT_RANGE,
    FAULT_LENGTH,
    FAULT_FOREIGN,
    FAULT_SILENT_MESSAGE,
    FAULT_REQUEST,
    /* Not in a recording: they are of the bus or of the processor, or take too long. */
    FAULT_SILENT_BUS,
    FAULT_FROZEN,
    FAULT_NO_ROOM,
    FAULT_RESTART,
    FAULT_KINDS,
    FAULT_RECORDED = FAULT_SILENT_BUS,
    FAULT_NONE = FAULT_KINDS
} fault_t;

static const char *const fault_name[FAULT_KINDS] = {"wrong CRC",
                                                    "frames lost",
                                                    "frames repeated",
                                                    "frames out of order",
                                                    "values not available",
                                                    "values out of range",
                                                    "wrong length",
                                                    "foreign identifier",
                                                    "one message silent",
                                                    "parameter requests, good and bad",
                                                    "bus silent",
                                                    "sensor frozen",
                                                    "no room to send",
                                                    "restart by a fault"};

/* What a receiver has to count. The first ones are those of sway_frame_fault_t. */
enum { COUNT_RANGE = SWAY_FRAME_FAULT_COUNT, COUNT_INVALID, COUNT_REFUSED, COUNTS };
static const char *const count_name[COUNTS] = {
    "CRC",   "lost",   "repeated", "late",  "length",  "timeout",
    "stuck", "frozen", "unknown",  "range", "invalid", "requests refused"};

/* A sender, and what a receiver knows of it. */
typedef struct {
    uint16_t id;
    uint8_t samples;
    int64_t sent;  // frames so far; one more for each new counter
    int64_t heard; // number of the last one taken; -1: none
    int64_t heard_us;
    int64_t good_us;
    uint32_t repeats;
    bool has_held; // sent after the next one
    sway_port_frame_t held;
    int64_t held_number;
} sender_t;

typedef struct {
    sway_port_frame_t queue[64];
    unsigned head;
    unsigned tail;
    int64_t now_us;
    int64_t period_us;
    int64_t begin_us; // of the fault within its period
    int64_t length_us;
    int64_t kinds;
    sender_t sender[4];
    uint64_t injected[FAULT_KINDS];
    uint64_t expected[COUNTS];
    uint64_t counted[COUNTS]; // before the last restart
    uint64_t status_frames;
    uint64_t values_checked;
    uint32_t valid_when_settled;
    uint32_t replies_wanted;
    uint32_t replies;
    uint32_t reports_of_fault;
    uint32_t wrong;
    int8_t last_counter[STATUS_COUNT];
    sway_port_frame_t last_frame[STATUS_COUNT];
    uint32_t random;
    FILE *recording;
} soak_t;

static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static soak_t soak;

static void wrong(const char *what)
{
    if (soak.wrong++ < 10U) {
        printf("soak: %s at %.2f s\n", what, (double)soak.now_us / 1e6);
    }
}

static uint32_t next_random(void)
{
    soak.random = soak.random * 1664525U + 1013904223U;
    return soak.random >> 8;
}

static bool chance(uint32_t one_in)
{
    return next_random() % one_in == 0U;
}

static int32_t noise(int32_t size)
{
    return (int32_t)(next_random() % (uint32_t)(2 * size + 1)) - size;
}

static int64_t in_period(void)
{
    return soak.now_us % soak.period_us;
}

/* A frozen sensor is found only after the yaw rates have moved enough. */
static fault_t fault_now(void)
{
    const fault_t kind = (fault_t)(soak.now_us / soak.period_us % soak.kinds);
    const int64_t length_us = kind == FAULT_FROZEN ? 7000000 : soak.length_us;
    const int64_t since_us = in_period() - soak.begin_us;
    return since_us >= 0 && since_us < length_us ? kind : FAULT_NONE;
}

/* --- what a receiver has to count --------------------------------------------------------------
 */

static void count(int what, int64_t by)
{
    soak.expected[what] += (uint64_t)by;
}

/* Frames between two that were taken. A receiver has only a counter of 15: after a long silence it
 * knows the missing ones modulo 15. */
static int64_t missing(int64_t steps, int64_t elapsed_us)
{
    if (elapsed_us <= SWAY_NODE_COUNT_LIMIT_US) {
        return steps - 1;
    }
    const int64_t rest = steps % TURN;
    return rest == 0 ? 0 : rest - 1;
}

static void expect_samples(const sender_t *sender, fault_t fault)
{
    if (fault == FAULT_NOT_AVAILABLE) {
        count(COUNT_INVALID, sender->samples);
    } else if (fault == FAULT_RANGE) {
        count(COUNT_RANGE, 1);
    }
}

/* A whole frame of ours, number `number`, reaches the receiver. */
static void expect(sender_t *sender, int64_t number, int64_t time_us, fault_t fault)
{
    const int64_t steps = sender->heard < 0 ? 1 : number - sender->heard;
    if (steps < 0) {
        count(SWAY_FRAME_FAULT_LATE, 1);
        return;
    }
    if (steps == 0) {
        sender->repeats++;
        count(SWAY_FRAME_FAULT_REPEATED, 1);
        count(SWAY_FRAME_FAULT_STUCK, sender->repeats == SWAY_NODE_STUCK_REPEATS);
        sender->heard_us = time_us;
        return;
    }
    if (sender->heard >= 0) {
        const bool is_stuck = sender->repeats >= SWAY_NODE_STUCK_REPEATS;
        count(SWAY_FRAME_FAULT_LOST, missing(steps, time_us - sender->heard_us));
        count(SWAY_FRAME_FAULT_TIMEOUT,
              !is_stuck && time_us - sender->good_us > SWAY_NODE_TIMEOUT_US);
    }
    sender->repeats = 0U;
    sender->heard = number;
    sender->heard_us = time_us;
    sender->good_us = time_us;
    expect_samples(sender, fault);
}

/* --- the drive -------------------------------------------------------------------------------- */

/* cos of a phase in 1/65536 turns, in 1/32768. */
static int32_t cosine(uint32_t phase)
{
    return (int32_t)lround(32768.0 * cos((double)phase * 9.58737992428525768573e-05));
}

static void put16(uint8_t *bytes, int32_t value)
{
    bytes[0] = (uint8_t)((uint32_t)value & 255U);
    bytes[1] = (uint8_t)((uint32_t)value >> 8 & 255U);
}

static void deliver(sway_port_frame_t frame)
{
    char line[CANDUMP_LINE];
    if (soak.recording != NULL) {
        (void)candump_format(&frame, line);
        fputs(line, soak.recording);
    } else {
        soak.queue[soak.head++ % 64U] = frame;
    }
}

/* Changes a frame; false: the receiver takes it for no frame of ours. */
static bool spoil(sway_port_frame_t *frame, fault_t fault)
{
    switch (fault) {
    case FAULT_CRC:
        frame->data[0] ^= 0x5AU;
        count(SWAY_FRAME_FAULT_CRC, 1);
        return false;
    case FAULT_LENGTH:
        frame->dlc = 7;
        count(SWAY_FRAME_FAULT_LENGTH, 1);
        return false;
    case FAULT_FOREIGN:
        frame->id = 0x13F; // passes the filters of the machines
        count(SWAY_FRAME_FAULT_UNKNOWN, 1);
        return false;
    case FAULT_NOT_AVAILABLE:
        frame->data[1] = (uint8_t)(frame->data[1] | 0x50U); // both validities
        sway_e2e_protect(frame->id, (uint8_t)(frame->data[1] & 15U), frame->data);
        return true;
    case FAULT_RANGE:
        put16(frame->data + 2, 60000); // 600 km/h
        sway_e2e_protect(frame->id, (uint8_t)(frame->data[1] & 15U), frame->data);
        return true;
    default:
        return true;
    }
}

/* Which frames a fault strikes: one in four, or all of those it is about. */
static bool is_struck(int which, fault_t fault)
{
    switch (fault) {
    case FAULT_NONE:
    case FAULT_FROZEN:
    case FAULT_REQUEST:
    case FAULT_NO_ROOM:
    case FAULT_RESTART:
        return false;
    case FAULT_SILENT_BUS:
        return true;
    case FAULT_SILENT_MESSAGE:
        return which == 2;
    case FAULT_RANGE:
        return which == 0 && chance(4);
    default:
        return chance(4);
    }
}

static void deliver_held(sender_t *sender, int64_t time_us)
{
    if (sender->has_held) {
        sender->has_held = false;
        sender->held.time_us = time_us;
        expect(sender, sender->held_number, time_us, FAULT_NONE);
        deliver(sender->held);
    }
}

/* One frame: 0 speed, 1 car, 2 trailer, 3 steering. */
static void give(int which, int32_t first, int32_t second)
{
    sender_t *sender = &soak.sender[which];
    const fault_t fault = fault_now();
    const bool struck = is_struck(which, fault);
    const int64_t number = sender->sent;
    sway_port_frame_t frame = {.time_us = soak.now_us + 300 * which, .id = sender->id, .dlc = 8};
    put16(frame.data + 2, first);
    put16(frame.data + 4, second);
    sway_e2e_protect(frame.id, (uint8_t)(number % TURN), frame.data);
    soak.injected[fault] += struck ? 1U : 0U;
    sender->sent += struck && fault == FAULT_REPEATED ? 0 : 1;
    if (struck && (fault == FAULT_LOST || fault >= FAULT_SILENT_MESSAGE)) {
        return;
    }
    if (struck && fault == FAULT_LATE && !sender->has_held) {
        sender->has_held = true;
        sender->held = frame;
        sender->held_number = number;
        return;
    }
    if (!struck || spoil(&frame, fault)) {
        expect(sender, number, frame.time_us, struck ? fault : FAULT_NONE);
    }
    deliver(frame);
    deliver_held(sender, frame.time_us + 100);
}

/* A reading of the configuration, or a request that nobody may obey. */
static void request(void)
{
    static uint8_t counter;
    if (fault_now() != FAULT_REQUEST || !chance(4)) {
        return;
    }
    sway_port_frame_t frame = {.time_us = soak.now_us + 1500, .id = ID_REQUEST, .dlc = 8};
    frame.data[4] = 7;
    const bool is_bad = chance(2);
    frame.data[1] = is_bad ? 1U << 4 : 0U; // write, or read
    sway_e2e_protect(frame.id, counter, frame.data);
    counter = sway_e2e_next(counter);
    frame.data[0] = (uint8_t)(frame.data[0] ^ (is_bad ? 0x11U : 0U));
    soak.injected[FAULT_REQUEST]++;
    soak.replies_wanted += is_bad ? 0U : 1U;
    count(COUNT_REFUSED, is_bad);
    deliver(frame);
}

static void drive(void)
{
    static int32_t frozen[2];
    const uint32_t phase = (uint32_t)(soak.now_us / 1000 * 43 % 65536);
    const int32_t car = cosine(phase) / 164; // 2 deg/s
    int32_t trailer = cosine(phase + 4000U) / 82 + noise(5);
    int32_t acceleration = car + noise(5);
    const fault_t fault = fault_now();
    if (fault == FAULT_FROZEN && in_period() > soak.begin_us) {
        trailer = frozen[0];
        acceleration = frozen[1];
        soak.injected[fault]++;
    }
    frozen[0] = trailer;
    frozen[1] = acceleration;
    /* By the time of their stamps: the order on the bus. */
    give(0, 9000 + noise(3), 0);
    give(1, car + noise(5), car * 2 + noise(5));
    give(2, trailer, acceleration);
    give(3, noise(1), 0);
    request();
}

/* --- the ECU's port ----------------------------------------------------------------------------
 */

static bool port_receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (soak.tail == soak.head) {
        return false;
    }
    *frame = soak.queue[soak.tail++ % 64U];
    return true;
}

static int64_t port_time_us(void *context)
{
    (void)context;
    return soak.now_us;
}

/* Whether a message that came before has stayed away for longer than `longest_us`. */
static bool is_lost(int which, int64_t longest_us)
{
    const int64_t good_us = soak.sender[which].good_us;
    return good_us != NEVER && soak.now_us - good_us > longest_us;
}

/* Without any motion there is nothing to judge; on what is left of it a judgement goes on, and says
 * so from the first estimate that misses an input. */
static void check_alarm(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_alarm_t alarm;
    (void)swaywatch_dbc_sway_alarm_unpack(&alarm, frame->data, frame->dlc);
    if (alarm.alarm_state == SWAY_ALARM_OFF) {
        return;
    }
    const int64_t timed_out_us = SWAY_NODE_TIMEOUT_US + 2 * TICK_US;
    if (is_lost(CAR_MOTION, timed_out_us) && is_lost(TRAILER_MOTION, timed_out_us)) {
        wrong("a judgement without motion");
    }
    for (int i = 0; i <= TRAILER_MOTION; i++) {
        if (is_lost(i, timed_out_us + AN_ESTIMATE_US) && alarm.judgement_degraded == 0U) {
            wrong("a judgement that does not say what it misses");
        }
    }
}

/* A value is wrong where it is marked valid and is further from the truth than six of its own
 * standard errors and 2 % (frequency), 0.02 (damping ratio). */
static void check_value(const char *what, double value, double error, double truth, double slack)
{
    soak.values_checked++;
    if (fabs(value - truth) > 6.0 * error && fabs(value - truth) > slack) {
        printf("soak: %s %.4f +- %.4f, truth %.4f\n", what, value, error, truth);
        wrong("a wrong value that is marked valid");
    }
}

static void check_oscillation(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_oscillation_t line;
    (void)swaywatch_dbc_sway_oscillation_unpack(&line, frame->data, frame->dlc);
    if (line.frequency != UINT16_MAX) {
        soak.valid_when_settled += in_period() > soak.period_us * 5 / 6 ? 1U : 0U;
        check_value("frequency", line.frequency * 1e-4, line.frequency_error * 1e-5, FREQUENCY_HZ,
                    0.02 * FREQUENCY_HZ);
    }
}

static void check_damping(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_signal_damping_t damping;
    (void)swaywatch_dbc_sway_signal_damping_unpack(&damping, frame->data, frame->dlc);
    if (damping.signal_damping_ratio != INT16_MIN) {
        check_value("damping ratio", damping.signal_damping_ratio * 1e-4,
                    damping.signal_damping_ratio_error * 1e-4, 0.0, 0.02);
    }
}

static void check_status(const sway_port_frame_t *frame)
{
    const unsigned which = frame->id - FIRST_STATUS;
    int8_t *last = &soak.last_counter[which];
    const int8_t counter = (int8_t)(frame->data[1] & 15U);
    soak.status_frames++;
    if (!sway_e2e_check(frame->id, frame->data) ||
        (*last >= 0 && counter != (int8_t)sway_e2e_next((uint8_t)*last))) {
        wrong("a status frame with a wrong CRC or counter");
    }
    *last = counter;
    soak.last_frame[which] = *frame;
    if (frame->id == SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID) {
        check_alarm(frame);
    } else if (frame->id == SWAYWATCH_DBC_SWAY_OSCILLATION_FRAME_ID) {
        check_oscillation(frame);
    } else if (frame->id == SWAYWATCH_DBC_SWAY_SIGNAL_DAMPING_FRAME_ID) {
        check_damping(frame);
    }
}

static void check_report(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_fault_report_t report;
    const uint32_t doubled = sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_REPEATED);
    static uint32_t doubled_before;
    const uint32_t new_ones = doubled - (doubled_before <= doubled ? doubled_before : 0U);
    const uint32_t wanted =
        new_ones >= SWAY_ECU_DOUBLED_FRAMES ? (uint32_t)SWAY_ECU_DOUBLED : retained.cause;
    doubled_before = doubled;
    (void)swaywatch_dbc_sway_fault_report_unpack(&report, frame->data, frame->dlc);
    if (report.ecu_state != SWAY_ECU_RUNNING || report.fault_cause != wanted ||
        report.fault_restarts != retained.restarts) {
        wrong("a wrong report of the ECU's health");
    }
    soak.reports_of_fault += report.fault_cause != 0U ? 1U : 0U;
}

/* It never goes down and never says more than what was refused. */
static void check_access(const sway_port_frame_t *frame)
{
    static uint16_t before;
    struct swaywatch_dbc_sway_access_t said;
    (void)swaywatch_dbc_sway_access_unpack(&said, frame->data, frame->dlc);
    if (!sway_e2e_check(frame->id, frame->data) || said.access_refused > ecu.requests_refused ||
        (said.access_refused < before && ecu.requests_refused >= before) || said.access_forged) {
        wrong("a wrong report of refused requests");
    }
    before = said.access_refused;
}

static bool port_send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (fault_now() == FAULT_NO_ROOM && chance(2)) {
        soak.injected[FAULT_NO_ROOM]++;
        return false;
    }
    if (frame->id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
        check_report(frame);
    } else if (frame->id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID) {
        soak.replies++;
    } else if (frame->id == SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID) {
        check_access(frame);
    } else if (frame->id >= FIRST_STATUS && frame->id < FIRST_STATUS + STATUS_COUNT) {
        check_status(frame);
    } else {
        wrong("a frame that is none of ours");
    }
    return true;
}

/* --- counters ----------------------------------------------------------------------------------
 */

static uint64_t counter_now(int which)
{
    const sway_status_t *status = sway_core_status(&ecu.node.core);
    switch (which) {
    case COUNT_RANGE:
        return status->fault_count[SWAY_FAULT_RANGE];
    case COUNT_INVALID:
        return status->fault_count[SWAY_FAULT_INVALID];
    case COUNT_REFUSED:
        return ecu.requests_refused;
    default:
        return sway_node_fault(&ecu.node, (sway_frame_fault_t)which);
    }
}

static void check_counters(void)
{
    static uint64_t before[COUNTS];
    for (int i = 0; i < COUNTS; i++) {
        const uint64_t now = soak.counted[i] + counter_now(i);
        if (now < before[i]) {
            wrong("a counter that went down");
        }
        before[i] = now;
    }
}

/* The frozen sensor: two signals found each time, and from then on each of their samples refused,
 * which is 2 x 100 a second for a part of the time that the sensor was frozen. */
static void settle_frozen(void)
{
    static uint64_t frozen_before;
    static uint64_t invalid_before;
    const fault_t kind = (fault_t)(soak.now_us / soak.period_us % soak.kinds);
    if (in_period() == 0) {
        frozen_before =
            soak.counted[SWAY_FRAME_FAULT_FROZEN] + counter_now(SWAY_FRAME_FAULT_FROZEN);
        invalid_before = soak.counted[COUNT_INVALID] + counter_now(COUNT_INVALID);
    }
    if (kind != FAULT_FROZEN || in_period() != soak.period_us - TICK_US) {
        return;
    }
    const uint64_t found =
        soak.counted[SWAY_FRAME_FAULT_FROZEN] + counter_now(SWAY_FRAME_FAULT_FROZEN);
    const uint64_t invalid = soak.counted[COUNT_INVALID] + counter_now(COUNT_INVALID);
    const uint64_t refused = invalid - invalid_before;
    if (found - frozen_before != 2U || refused < 200U || refused > 1200U) {
        wrong("a frozen sensor that was not found in time");
    }
    count(SWAY_FRAME_FAULT_FROZEN, 2);
    count(COUNT_INVALID, (int64_t)refused);
}

static bool start(void)
{
    static uint8_t block[SWAY_BLOCK_SIZE];
    sway_core_config_t config;
    const sway_port_t port = {.receive = port_receive, .send = port_send, .time_us = port_time_us};
    sway_core_defaults(&config);
    config.vehicle.car = (sway_car_t){1955000, 2690000, 1302000,  1383000, 2166000, 109300,
                                      185200,  9674000, 10204000, 15000,   0};
    config.vehicle.trailer = (sway_trailer_t){2,      1880000, 10350000, 124000,  526000, 5073000,
                                              131200, 124400,  9226000,  8517000, 0};
    sway_block_write(&config, 1, block);
    memset(soak.last_counter, -1, sizeof soak.last_counter);
    return sway_ecu_start(&ecu, &port, &retained, block, sizeof block) == SWAY_OK &&
           ecu.state == SWAY_ECU_RUNNING;
}

/* A fault handler has noted a fault and restarted the processor; a period later power is cycled. */
static void restart_sometimes(void)
{
    const fault_t kind = (fault_t)(soak.now_us / soak.period_us % soak.kinds);
    if (kind == FAULT_RESTART && in_period() == soak.begin_us) {
        for (int i = 0; i < COUNTS; i++) {
            soak.counted[i] += counter_now(i);
        }
        for (int i = 0; i < 4; i++) {
            soak.sender[i].heard = -1;
            soak.sender[i].good_us = NEVER;
        }
        soak.injected[kind]++;
        sway_ecu_note_fault(&retained, 4, 0x1234);
        if (!start()) {
            wrong("no restart");
        }
    }
    if (in_period() == 0 && retained.restarts > 0U) {
        memset(&retained, 0, sizeof retained);
        if (soak.reports_of_fault < soak.injected[FAULT_RESTART]) {
            wrong("a fault that was not reported");
        }
    }
}

static void check_settled(void)
{
    if (in_period() != soak.period_us - TICK_US) {
        return;
    }
    if (soak.valid_when_settled == 0U) {
        wrong("no valid estimate long after a fault");
    }
    soak.valid_when_settled = 0U;
}

/* --- programs ----------------------------------------------------------------------------------
 */

static void prepare(int64_t period_us, int64_t length_us, int64_t kinds)
{
    static const uint16_t ids[4] = {
        SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, SWAYWATCH_DBC_SWAY_CAR_MOTION_FRAME_ID,
        SWAYWATCH_DBC_SWAY_TRAILER_MOTION_FRAME_ID, SWAYWATCH_DBC_SWAY_STEERING_FRAME_ID};
    static const uint8_t samples[4] = {1, 2, 2, 1};
    soak.random = 1;
    soak.period_us = period_us;
    soak.begin_us = period_us / 3;
    soak.length_us = length_us;
    soak.kinds = kinds;
    for (int i = 0; i < 4; i++) {
        soak.sender[i].id = ids[i];
        soak.sender[i].samples = samples[i];
        soak.sender[i].heard = -1;
        soak.sender[i].good_us = NEVER;
    }
}

static void tick(void)
{
    restart_sometimes();
    settle_frozen();
    drive();
    int polls = 0;
    while ((sway_ecu_poll(&ecu) || soak.head != soak.tail) && polls < POLLS_MAX) {
        polls++;
    }
    if (polls >= POLLS_MAX) {
        wrong("10 ms that do not end");
    }
    if (soak.now_us % 1000000 == 0) {
        check_counters();
    }
    check_settled();
}

static void check_ends(void)
{
    for (int i = 0; i < COUNTS; i++) {
        const uint64_t counted = soak.counted[i] + counter_now(i);
        if (counted != soak.expected[i]) {
            printf("soak: %s: %lu counted, %lu injected\n", count_name[i], (unsigned long)counted,
                   (unsigned long)soak.expected[i]);
            soak.wrong++;
        }
    }
    if (soak.replies != soak.replies_wanted) {
        wrong("requests without a reply, or replies without a request");
    }
}

/* The frames tell what the ECU has counted since it was started, as far as they can count. */
static void check_frames(void)
{
    struct swaywatch_dbc_sway_faults_frames_t frames;
    struct swaywatch_dbc_sway_faults_order_t order;
    struct swaywatch_dbc_sway_inputs_t inputs;
    const sway_port_frame_t *last = soak.last_frame - FIRST_STATUS;
    (void)swaywatch_dbc_sway_faults_frames_unpack(
        &frames, last[SWAYWATCH_DBC_SWAY_FAULTS_FRAMES_FRAME_ID].data, 8);
    (void)swaywatch_dbc_sway_faults_order_unpack(
        &order, last[SWAYWATCH_DBC_SWAY_FAULTS_ORDER_FRAME_ID].data, 8);
    (void)swaywatch_dbc_sway_inputs_unpack(&inputs, last[SWAYWATCH_DBC_SWAY_INPUTS_FRAME_ID].data,
                                           8);
    const uint32_t reported[] = {frames.fault_crc,   frames.fault_lost,  frames.fault_repeated,
                                 order.fault_late,   order.fault_length, order.fault_timeout,
                                 inputs.fault_stuck, inputs.fault_frozen};
    for (int i = 0; i < (int)(sizeof reported / sizeof reported[0]); i++) {
        const uint64_t most = i < 6 ? 65535U : 255U;
        const uint64_t now = counter_now(i);
        if (reported[i] != (now > most ? most : now)) {
            printf("soak: %s: the bus says %lu, the ECU %lu\n", count_name[i],
                   (unsigned long)reported[i], (unsigned long)now);
            soak.wrong++;
        }
    }
}

static void write_report(FILE *file, long minutes)
{
    fprintf(file,
            "**`make soak`**: %.1f simulated hours of driving, a fault each minute: "
            "%lu status frames, %lu values that were marked valid, %lu wrong or missing\n\n",
            (double)minutes / 60.0, (unsigned long)soak.status_frames,
            (unsigned long)soak.values_checked, (unsigned long)soak.wrong);
    fputs("| fault | times | | counter of the ECU | counted | injected "
          "|\n|---|---|---|---|---|---|\n",
          file);
    const int rows = (int)FAULT_KINDS > (int)COUNTS ? (int)FAULT_KINDS : (int)COUNTS;
    for (int i = 0; i < rows; i++) {
        if (i < (int)FAULT_KINDS) {
            fprintf(file, "| %s | %lu | ", fault_name[i], (unsigned long)soak.injected[i]);
        } else {
            fputs("| | | ", file);
        }
        if (i < (int)COUNTS) {
            fprintf(file, "| %s | %lu | %lu |\n", count_name[i],
                    (unsigned long)(soak.counted[i] + counter_now(i)),
                    (unsigned long)soak.expected[i]);
        } else {
            fputs("| | | |\n", file);
        }
    }
}

static int run(long minutes, const char *path)
{
    const int64_t end_us = minutes * INT64_C(60000000);
    prepare(60000000, 2500000, FAULT_KINDS);
    if (!start()) {
        puts("soak: the ECU does not start");
        return 1;
    }
    for (soak.now_us = 0; soak.now_us < end_us; soak.now_us += TICK_US) {
        tick();
    }
    check_ends();
    check_frames();
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        printf("soak: cannot write %s\n", path);
        return 1;
    }
    write_report(file, minutes);
    fclose(file);
    printf("soak: %ld simulated minutes, %ld faults, %lu status frames, %lu valid values checked, "
           "%lu wrong\n",
           minutes, minutes, (unsigned long)soak.status_frames, (unsigned long)soak.values_checked,
           (unsigned long)soak.wrong);
    return soak.wrong > 0U ? 1 : 0;
}

/* A frozen sensor is not found within a few seconds, and what it makes a receiver count depends on
 * when it is found: it comes in the long soak only. */
static int write_recording(const char *recording, const char *expected)
{
    const int64_t first_us = INT64_C(1000000000);
    FILE *file = fopen(expected, "w");
    soak.recording = fopen(recording, "w");
    if (file == NULL || soak.recording == NULL) {
        puts("soak: cannot write the recording");
        return 1;
    }
    prepare(4000000, 700000, FAULT_RECORDED);
    for (soak.now_us = first_us; soak.now_us < first_us + FAULT_RECORDED * soak.period_us;
         soak.now_us += TICK_US) {
        drive();
    }
    for (int i = 0; i < COUNTS; i++) {
        fprintf(file, "%s %lu\n", count_name[i], (unsigned long)soak.expected[i]);
    }
    return fclose(soak.recording) == 0 && fclose(file) == 0 ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "--write") == 0) {
        return write_recording(argv[2], argv[3]);
    }
    if (argc == 3 && atol(argv[1]) > 0) {
        return run(atol(argv[1]), argv[2]);
    }
    puts("soak: wanted MINUTES REPORT.md, or --write RECORDING EXPECTED");
    return 2;
}

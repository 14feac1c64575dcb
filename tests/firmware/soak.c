/* soak: hours of driving in simulated time through the ECU, with a fault a minute.
 *
 * soak MINUTES: the same ECU program as on the targets, on the host. A
 * combination sways without end at 0.66 Hz; each minute brings one fault for some seconds, in turn:
 * wrong CRCs, lost frames, repeated frames, a sensor that says "not available", silence of one
 * message, silence of the bus, wrong lengths, foreign identifiers. Checked without pause:
 *   - every status frame has a right CRC and a counter one up from the last of its kind;
 *   - counters of faults never go down, and count what was injected;
 *   - no alarm judgement while speed or yaw rates have been away for longer than the timeout;
 *   - between faults, ten seconds after one, estimates are valid again.
 * Prints one line and exits with 0, or 1 with what was wrong. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sway_ecu.h"
#include "swaywatch_dbc.h"

#define PERIOD_US 10000
#define MINUTE_US INT64_C(60000000)
#define FAULT_START_US INT64_C(20000000)
#define FAULT_US INT64_C(3000000)
#define SETTLED_US INT64_C(50000000)
#define ID_ALARM SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID
#define ID_OSCILLATION SWAYWATCH_DBC_SWAY_OSCILLATION_FRAME_ID
#define FIRST_STATUS 0x1A0
#define STATUS_COUNT 32

typedef enum {
    FAULT_CRC,
    FAULT_LOST,
    FAULT_REPEATED,
    FAULT_NOT_AVAILABLE,
    FAULT_SILENT_MESSAGE,
    FAULT_SILENT_BUS,
    FAULT_LENGTH,
    FAULT_FOREIGN,
    FAULT_KINDS
} fault_t;

typedef struct {
    sway_port_frame_t queue[16];
    unsigned head;
    unsigned tail;
    int64_t now_us;
    uint8_t counter[4];
    uint32_t injected[FAULT_KINDS];
    uint32_t status_frames;
    uint32_t estimates_when_settled;
    uint32_t wrong;
    int8_t last_counter[STATUS_COUNT];
    int64_t good_us[3]; // last good frame of speed, car motion, trailer motion
    uint32_t random;
} soak_t;

static sway_ecu_t ecu;
static soak_t soak;

static void wrong(const char *what)
{
    if (soak.wrong++ < 5U) {
        printf("soak: %s at %ld s\n", what, (long)(soak.now_us / 1000000));
    }
}

/* --- the port --------------------------------------------------------------------------------- */

static bool port_receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (soak.tail == soak.head) {
        return false;
    }
    *frame = soak.queue[soak.tail++ % 16U];
    return true;
}

static int64_t port_time_us(void *context)
{
    (void)context;
    return soak.now_us;
}

static bool inputs_are_lost(void)
{
    bool lost = false;
    for (int i = 0; i < 3; i++) {
        lost = lost || soak.now_us - soak.good_us[i] > SWAY_NODE_TIMEOUT_US + 2 * PERIOD_US;
    }
    return lost;
}

static void check_alarm(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_alarm_t alarm;
    (void)swaywatch_dbc_sway_alarm_unpack(&alarm, frame->data, frame->dlc);
    if (inputs_are_lost() && alarm.alarm_state != SWAY_ALARM_OFF) {
        wrong("a judgement without inputs");
    }
}

static bool port_send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (frame->id < FIRST_STATUS || frame->id >= FIRST_STATUS + STATUS_COUNT) {
        return true;
    }
    soak.status_frames++;
    int8_t *last = &soak.last_counter[frame->id - FIRST_STATUS];
    const int8_t counter = (int8_t)(frame->data[1] & 15U);
    if (!sway_e2e_check(frame->id, frame->data) ||
        (*last >= 0 && counter != (int8_t)sway_e2e_next((uint8_t)*last))) {
        wrong("a status frame with a wrong CRC or counter");
    }
    *last = counter;
    if (frame->id == ID_ALARM) {
        check_alarm(frame);
    }
    if (frame->id == ID_OSCILLATION && soak.now_us % MINUTE_US > SETTLED_US) {
        soak.estimates_when_settled++;
    }
    return true;
}

/* --- the drive -------------------------------------------------------------------------------- */

/* cos of a phase in 1/65536 turns, in 1/32768: a parabola and its correction, 0.1 % off. */
static int32_t cosine(uint32_t phase)
{
    const int32_t x = (int32_t)((phase + 16384U) & 65535U);
    const int32_t half = x & 32767;
    const int32_t y = (int32_t)((int64_t)half * (32768 - half) / 8192);
    const int32_t z = y + (int32_t)((int64_t)(y - 32768) * y / 32768 * 29 / 128);
    return x < 32768 ? z : -z;
}

static int32_t noise(int32_t size)
{
    soak.random = soak.random * 1664525U + 1013904223U;
    return (int32_t)(soak.random >> 16) % (2 * size + 1) - size;
}

static bool chance(uint32_t one_in)
{
    soak.random = soak.random * 1664525U + 1013904223U;
    return (soak.random >> 8) % one_in == 0U;
}

static fault_t fault_now(void)
{
    const int64_t in_minute = soak.now_us % MINUTE_US;
    const bool active = in_minute >= FAULT_START_US && in_minute < FAULT_START_US + FAULT_US;
    return active ? (fault_t)(soak.now_us / MINUTE_US % FAULT_KINDS) : FAULT_KINDS;
}

static void queue(sway_port_frame_t frame)
{
    soak.queue[soak.head++ % 16U] = frame;
}

static void put16(uint8_t *bytes, int32_t value)
{
    bytes[0] = (uint8_t)((uint32_t)value & 255U);
    bytes[1] = (uint8_t)((uint32_t)value >> 8 & 255U);
}

static void spoil(sway_port_frame_t *frame, int which, fault_t fault)
{
    switch (fault) {
    case FAULT_CRC:
        frame->data[0] ^= 0x5AU;
        break;
    case FAULT_NOT_AVAILABLE:
        frame->data[1] = (uint8_t)(frame->data[1] | 0x50U); // both validities "not available"
        sway_e2e_protect(frame->id, (uint8_t)(frame->data[1] & 15U), frame->data);
        break;
    case FAULT_LENGTH:
        frame->dlc = 7;
        break;
    case FAULT_FOREIGN:
        frame->id = 0x7FF;
        break;
    default:
        break;
    }
    soak.injected[fault]++;
    (void)which;
}

/* One frame: 0 speed, 1 car, 2 trailer, 3 steering. */
static void give(int which, uint16_t id, int32_t first, int32_t second)
{
    const fault_t fault = fault_now();
    sway_port_frame_t frame = {.time_us = soak.now_us + 300 * which, .id = id, .dlc = 8};
    put16(frame.data + 2, first);
    put16(frame.data + 4, second);
    sway_e2e_protect(id, soak.counter[which], frame.data);
    const bool is_hit = fault != FAULT_KINDS && (fault >= FAULT_SILENT_MESSAGE || chance(4));
    if (fault != FAULT_REPEATED || !is_hit) {
        soak.counter[which] = sway_e2e_next(soak.counter[which]);
    }
    const bool is_silent = is_hit && (fault == FAULT_LOST || fault == FAULT_SILENT_BUS ||
                                      (fault == FAULT_SILENT_MESSAGE && which == 2));
    if (is_hit && (fault != FAULT_SILENT_MESSAGE || which == 2)) {
        spoil(&frame, which, fault);
    }
    if (!is_silent) {
        const bool is_good =
            !is_hit || fault == FAULT_NOT_AVAILABLE || fault == FAULT_SILENT_MESSAGE;
        if (which < 3 && is_good) {
            soak.good_us[which] = soak.now_us;
        }
        queue(frame);
    }
}

static void drive(void)
{
    const uint32_t phase = (uint32_t)(soak.now_us / 1000 * 43 % 65536); // 0.656 Hz
    const int32_t car = cosine(phase) / 164;                            // 2 deg/s
    const int32_t trailer = cosine(phase + 4000U) / 82;                 // 4 deg/s
    give(3, SWAYWATCH_DBC_SWAY_STEERING_FRAME_ID, noise(1), 0);
    give(0, SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, 9000 + noise(3), 0);
    give(1, SWAYWATCH_DBC_SWAY_CAR_MOTION_FRAME_ID, car + noise(5), car * 2 + noise(5));
    give(2, SWAYWATCH_DBC_SWAY_TRAILER_MOTION_FRAME_ID, trailer + noise(5), car + noise(5));
}

/* --- checks ----------------------------------------------------------------------------------- */

static void check_counters(void)
{
    static uint32_t before[SWAY_FRAME_FAULT_COUNT];
    for (int i = 0; i < (int)SWAY_FRAME_FAULT_COUNT; i++) {
        const uint32_t now = sway_node_fault(&ecu.node, (sway_frame_fault_t)i);
        if (now < before[i]) {
            wrong("a counter that went down");
        }
        before[i] = now;
    }
}

static void check_count(sway_frame_fault_t counter, fault_t fault, const char *name)
{
    if (sway_node_fault(&ecu.node, counter) != soak.injected[fault]) {
        printf("soak: %s: %lu counted, %lu injected\n", name,
               (unsigned long)sway_node_fault(&ecu.node, counter),
               (unsigned long)soak.injected[fault]);
        soak.wrong++;
    }
}

static bool start(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    static sway_ecu_retained_t retained;
    sway_core_config_t config;
    const sway_port_t port = {.receive = port_receive, .send = port_send, .time_us = port_time_us};
    sway_core_defaults(&config);
    config.vehicle.car = (sway_car_t){1955000, 2690000, 1302000,  1383000, 2166000, 109300,
                                      185200,  9674000, 10204000, 15000,   0};
    config.vehicle.trailer = (sway_trailer_t){2,      1880000, 10350000, 124000,  526000, 5073000,
                                              131200, 124400,  9226000,  8517000, 0};
    sway_block_write(&config, 1, block);
    memset(soak.last_counter, -1, sizeof soak.last_counter);
    soak.random = 1;
    return sway_ecu_start(&ecu, &port, &retained, block, sizeof block) == SWAY_OK &&
           ecu.state == SWAY_ECU_RUNNING;
}

int main(int argc, char **argv)
{
    const int64_t end_us = (argc > 1 ? atol(argv[1]) : 8) * MINUTE_US;
    if (!start()) {
        puts("soak: the ECU does not start");
        return 1;
    }
    for (soak.now_us = 0; soak.now_us < end_us; soak.now_us += PERIOD_US) {
        drive();
        while (sway_ecu_poll(&ecu)) {
        }
        if (soak.now_us % 1000000 == 0) {
            check_counters();
        }
    }
    const uint32_t minutes = (uint32_t)(end_us / MINUTE_US);
    check_count(SWAY_FRAME_FAULT_CRC, FAULT_CRC, "wrong CRC");
    check_count(SWAY_FRAME_FAULT_LENGTH, FAULT_LENGTH, "wrong length");
    check_count(SWAY_FRAME_FAULT_UNKNOWN, FAULT_FOREIGN, "foreign identifier");
    if (soak.estimates_when_settled < minutes * 20U) {
        wrong("too few estimates after a fault");
    }
    if (ecu.state != SWAY_ECU_RUNNING) {
        wrong("the ECU left its running state");
    }
    printf("soak: %lu simulated minutes, %lu faults injected in frames, %lu status frames, %lu "
           "estimates 30 s after a fault or later, %lu wrong\n",
           (unsigned long)minutes,
           (unsigned long)(soak.injected[0] + soak.injected[1] + soak.injected[2] +
                           soak.injected[3] + soak.injected[4] + soak.injected[5] +
                           soak.injected[6] + soak.injected[7]),
           (unsigned long)soak.status_frames, (unsigned long)soak.estimates_when_settled,
           (unsigned long)soak.wrong);
    return soak.wrong > 0U ? 1 : 0;
}

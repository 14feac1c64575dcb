/* The CAN controller in the Zynq UltraScale+ (UG1085 chapter "CAN Controller"; the one of the
 * Zynq-7000 is the same). */
#include "can.h"

#include "sway_bit_timing.h"
#include "sway_registers.h"

enum {
    SRR = 0x00,
    BRPR = 0x08,
    BTR = 0x0C,
    ECR = 0x10,
    ESR = 0x14,
    SR = 0x18,
    ISR = 0x1C,
    IER = 0x20,
    ICR = 0x24,
    TSR = 0x28,
    TX_ID = 0x30,
    TX_DLC = 0x34,
    TX_DATA1 = 0x38,
    TX_DATA2 = 0x3C,
    RX_ID = 0x50,
    RX_DLC = 0x54,
    RX_DATA1 = 0x58,
    RX_DATA2 = 0x5C,
    AFR = 0x60,
    AFMR1 = 0x64,
    AFIR1 = 0x68
};

#define SRR_RESET 1U
#define SRR_ENABLE 2U
#define SR_CONFIG (1U << 0)
#define SR_TX_FULL (1U << 10)
#define SR_ERROR_WARNING (1U << 6)
#define SR_ERROR_STATE(status) (((status) >> 7) & 3U)
#define ESTAT_BUS_OFF 2U
#define ESTAT_PASSIVE 3U
#define INT_RX_OVERFLOW (1U << 6)
#define INT_RX_NOT_EMPTY (1U << 7)
#define INT_ERROR (1U << 8)
#define INT_BUS_OFF (1U << 9)
#define INT_HANDLED (INT_RX_OVERFLOW | INT_RX_NOT_EMPTY | INT_ERROR | INT_BUS_OFF)
#define TSR_CLEAR 1U
#define STAMP_MASK 0xFFFFU
#define ID_SHIFT 21U
#define ID_REMOTE (1U << 20)
#define ID_EXTENDED (1U << 19)
#define DLC_SHIFT 28U

#define START_POLLS 10000U
#define FIFO_FRAMES 64U

static uint32_t get(const can_t *can, uintptr_t offset)
{
    return sway_register_read(can->config.base + offset);
}

static void put(const can_t *can, uintptr_t offset, uint32_t value)
{
    sway_register_write(can->config.base + offset, value);
}

/* --- start ----------------------------------------------------------------------------------- */

static bool reset_controller(const can_t *can)
{
    put(can, SRR, SRR_RESET);
    for (uint32_t polls = 0; polls < START_POLLS; polls++) {
        if ((get(can, SR) & SR_CONFIG) != 0U) {
            return true;
        }
    }
    return false;
}

static bool set_timing(const can_t *can)
{
    static const sway_bit_limits_t limits = {
        .prescaler_max = 256, .segment1_max = 16, .segment2_max = 8, .jump_max = 4};
    sway_bit_timing_t timing;
    if (!sway_bit_timing(can->config.clock_hz, can->config.bit_rate, can->config.sample_point_milli,
                         &limits, &timing)) {
        return false;
    }
    put(can, BRPR, timing.prescaler - 1U);
    put(can, BTR, (timing.jump - 1U) << 7 | (timing.segment2 - 1U) << 4 | (timing.segment1 - 1U));
    return true;
}

/* A filter is changed while it is off, as all are after a reset. The masks ask for plain data
 * frames with 11-bit ids. */
static void set_filters(const can_t *can)
{
    for (uint32_t i = 0; i < can->config.filters; i++) {
        const can_filter_t *filter = &can->config.filter[i];
        put(can, AFMR1 + 8U * i, (uint32_t)filter->mask << ID_SHIFT | ID_REMOTE | ID_EXTENDED);
        put(can, AFIR1 + 8U * i, (uint32_t)filter->wanted << ID_SHIFT);
    }
    put(can, AFR, (1U << can->config.filters) - 1U);
}

/* No interrupt between the two: a frame would be stamped by one clock and timed by the other. */
static void restart_stamps(can_t *can)
{
    const uint32_t enabled = get(can, IER);
    put(can, IER, 0U);
    put(can, TSR, TSR_CLEAR);
    can->stamp_origin_ns = can->config.time_ns();
    put(can, IER, enabled);
}

/* The reset has left normal mode and no old causes. */
static bool join(can_t *can)
{
    if (!reset_controller(can) || !set_timing(can)) {
        return false;
    }
    set_filters(can);
    put(can, IER, INT_HANDLED);
    put(can, SRR, SRR_ENABLE);
    restart_stamps(can);
    can->bus_off = false;
    return true;
}

bool can_start(can_t *can, const can_config_t *config)
{
    return can_prepare(can, config) && join(can);
}

/* --- receiving ------------------------------------------------------------------------------- */

/* The frame's own stamp is 16 bits of the controller's clock; the processor's clock tells how often
 * it has turned over since it was cleared. */
static int64_t stamp_ns(const can_t *can, uint32_t stamp, int64_t now_ns)
{
    const int64_t hz = (int64_t)can->config.clock_hz;
    const int64_t turn_ns = (int64_t)(STAMP_MASK + 1U) * 1000000000 / hz;
    const int64_t first_ns = can->stamp_origin_ns + (int64_t)stamp * 1000000000 / hz;
    return now_ns > first_ns ? first_ns + (now_ns - first_ns) / turn_ns * turn_ns : now_ns;
}

static void unpack(uint8_t *data, uint32_t word)
{
    for (uint32_t i = 0; i < 4U; i++) {
        data[i] = (uint8_t)(word >> (24U - 8U * i));
    }
}

static uint32_t pack(const uint8_t *data)
{
    return (uint32_t)data[0] << 24 | (uint32_t)data[1] << 16 | (uint32_t)data[2] << 8 | data[3];
}

static void take_frame(can_t *can)
{
    const uint32_t id = get(can, RX_ID); // reading it moves the FIFO on
    const uint32_t dlc = get(can, RX_DLC);
    const uint32_t data1 = get(can, RX_DATA1);
    const uint32_t data2 = get(can, RX_DATA2);
    if ((id & (ID_REMOTE | ID_EXTENDED)) != 0U) {
        can->counters.remote_frames += 1U;
        return;
    }
    sway_port_frame_t frame;
    frame.time_us = stamp_ns(can, dlc & STAMP_MASK, can->config.time_ns()) / 1000;
    frame.id = (uint16_t)(id >> ID_SHIFT);
    frame.dlc = (uint8_t)((dlc >> DLC_SHIFT) > 8U ? 8U : dlc >> DLC_SHIFT);
    unpack(frame.data, data1);
    unpack(frame.data + 4, data2);
    can_put(can, &frame);
}

static void count_errors(can_t *can)
{
    const uint32_t errors = get(can, ESR);
    can->counters.crc_errors += errors & 1U;
    can->counters.form_errors += (errors >> 1) & 1U;
    can->counters.stuff_errors += (errors >> 2) & 1U;
    can->counters.bit_errors += (errors >> 3) & 1U;
    can->counters.ack_errors += (errors >> 4) & 1U;
    put(can, ESR, errors); // written ones clear
}

/* In reset until can_service() joins again: nothing half-sent is sent late. */
static void leave_bus(can_t *can)
{
    (void)reset_controller(can);
    can_note_bus_off(can);
}

void can_interrupt(can_t *can)
{
    uint32_t cause = get(can, ISR) & INT_HANDLED;
    if ((cause & INT_ERROR) != 0U) {
        count_errors(can);
    }
    if ((cause & INT_RX_OVERFLOW) != 0U) {
        can->counters.overflows += 1U;
    }
    put(can, ICR, cause & ~INT_RX_NOT_EMPTY);
    for (uint32_t i = 0; i < FIFO_FRAMES && (cause & INT_RX_NOT_EMPTY) != 0U; i++) {
        take_frame(can);
        put(can, ICR, INT_RX_NOT_EMPTY); // comes back at once if there is more
        cause = get(can, ISR);
    }
    if ((cause & INT_BUS_OFF) != 0U) {
        leave_bus(can);
    }
}

bool can_wants_interrupt(const can_t *can)
{
    return (get(can, ISR) & get(can, IER)) != 0U;
}

void can_service(can_t *can)
{
    const int64_t now_ns = can->config.time_ns();
    if (can->bus_off) {
        if (now_ns >= can->restart_ns) {
            (void)join(can);
        }
        return;
    }
    /* Half a turn of the stamp counter at most, so that a turn is never miscounted by drift. */
    const int64_t half_turn_ns = INT64_C(32768) * 1000000000 / (int64_t)can->config.clock_hz;
    if (now_ns - can->stamp_origin_ns > half_turn_ns && !can_wants_interrupt(can)) {
        restart_stamps(can);
    }
}

/* --- sending and state ----------------------------------------------------------------------- */

bool can_send(can_t *can, const sway_port_frame_t *frame)
{
    if (can->bus_off || (get(can, SR) & SR_TX_FULL) != 0U) {
        return false;
    }
    put(can, TX_ID, (uint32_t)frame->id << ID_SHIFT);
    put(can, TX_DLC, (uint32_t)frame->dlc << DLC_SHIFT);
    put(can, TX_DATA1, pack(frame->data));
    put(can, TX_DATA2, pack(frame->data + 4)); // this one sends it
    can->counters.sent += 1U;
    return true;
}

can_state_t can_state(const can_t *can)
{
    const uint32_t status = get(can, SR);
    if (can->bus_off || SR_ERROR_STATE(status) == ESTAT_BUS_OFF) {
        return CAN_BUS_OFF;
    }
    if (SR_ERROR_STATE(status) == ESTAT_PASSIVE) {
        return CAN_PASSIVE;
    }
    return (status & SR_ERROR_WARNING) != 0U ? CAN_WARNING : CAN_ACTIVE;
}

uint32_t can_transmit_errors(const can_t *can)
{
    return get(can, ECR) & 0xFFU;
}

uint32_t can_receive_errors(const can_t *can)
{
    return (get(can, ECR) >> 8) & 0xFFU;
}

/* The FDCAN of the STM32G4 (RM0440 chapter "FD controller area network"), in classic CAN: three
 * frames deep each way, in a message RAM that the hardware has divided up itself. Its time stamps
 * count TIM3, which board.c lets count microseconds. */
#include "can.h"

#include "stm32g474.h"
#include "sway_bit_timing.h"
#include "sway_registers.h"

enum {
    CCCR = 0x18,
    NBTP = 0x1C,
    TSCC = 0x20,
    TSCV = 0x24,
    ECR = 0x40,
    PSR = 0x44,
    IR = 0x50,
    IE = 0x54,
    ILS = 0x58,
    ILE = 0x5C,
    RXGFC = 0x80,
    RXF0S = 0x90,
    RXF0A = 0x94,
    TXBC = 0xC0,
    TXFQS = 0xC4,
    TXBAR = 0xCC
};

/* Message RAM of FDCAN1, in bytes from its start. */
#define RAM_FILTERS 0x000U
#define RAM_RX_FIFO 0x0B0U
#define RAM_TX 0x278U
#define ELEMENT 72U ///< bytes of an element: two words and room for 64 bytes of data
#define FIFO_FRAMES 3U

#define CCCR_INIT (1U << 0)
#define CCCR_CHANGE (1U << 1)
#define CCCR_STANDBY (1U << 4)
#define CCCR_STANDBY_ACK (1U << 3)
#define TSCC_EXTERNAL 2U
#define FILTER_MASK (2U << 30)
#define FILTER_TO_FIFO0 (1U << 27)
#define RXGFC_REJECT_REMOTE 3U
#define RXGFC_REJECT_OTHERS ((2U << 4) | (2U << 2))
#define RXGFC_ONLY_STANDARD (2U << 2)
#define RXGFC_COUNT(count) ((uint32_t)(count) << 16)
#define INT_RX_NEW (1U << 0)
#define INT_RX_LOST (1U << 2)
#define INT_BUS_OFF (1U << 19)
#define INT_PROTOCOL_ERROR (1U << 21)
#define INT_HANDLED (INT_RX_NEW | INT_RX_LOST | INT_BUS_OFF | INT_PROTOCOL_ERROR)
#define FILL_LEVEL(status) ((status)&15U)
#define INDEX(status) (((status) >> 8) & 3U)
#define PUT_INDEX(status) (((status) >> 16) & 3U)
#define TX_FULL (1U << 21)
#define ID_EXTENDED (1U << 30)
#define ID_REMOTE (1U << 29)
#define ID_SHIFT 18U
#define DLC_SHIFT 16U
#define STAMP_MASK 0xFFFFU
#define PSR_PASSIVE (1U << 5)
#define PSR_WARNING (1U << 6)
#define PSR_BUS_OFF (1U << 7)

#define START_POLLS 10000U

static uint32_t get(const can_t *can, uintptr_t offset)
{
    return sway_register_read(can->config.base + offset);
}

static void put(const can_t *can, uintptr_t offset, uint32_t value)
{
    sway_register_write(can->config.base + offset, value);
}

/* --- start ----------------------------------------------------------------------------------- */

static bool wait_for(const can_t *can, uint32_t mask, uint32_t wanted)
{
    for (uint32_t polls = 0; polls < START_POLLS; polls++) {
        if ((get(can, CCCR) & mask) == wanted) {
            return true;
        }
    }
    return false;
}

/* Off the bus, with its configuration open. */
static bool stop(const can_t *can)
{
    put(can, CCCR, get(can, CCCR) & ~CCCR_STANDBY);
    if (!wait_for(can, CCCR_STANDBY_ACK, 0U)) {
        return false;
    }
    put(can, CCCR, CCCR_INIT);
    if (!wait_for(can, CCCR_INIT, CCCR_INIT)) {
        return false;
    }
    put(can, CCCR, CCCR_INIT | CCCR_CHANGE);
    return wait_for(can, CCCR_CHANGE, CCCR_CHANGE);
}

static bool set_timing(const can_t *can)
{
    static const sway_bit_limits_t limits = {
        .prescaler_max = 512, .segment1_max = 256, .segment2_max = 128, .jump_max = 128};
    sway_bit_timing_t timing;
    if (!sway_bit_timing(can->config.clock_hz, can->config.bit_rate, can->config.sample_point_milli,
                         &limits, &timing)) {
        return false;
    }
    put(can, NBTP,
        (timing.jump - 1U) << 25 | (timing.prescaler - 1U) << 16 | (timing.segment1 - 1U) << 8 |
            (timing.segment2 - 1U));
    return true;
}

static void set_filters(const can_t *can)
{
    for (uint32_t i = 0; i < can->config.filters; i++) {
        const can_filter_t *filter = &can->config.filter[i];
        sway_register_write(STM32_FDCAN1_RAM + RAM_FILTERS + 4U * i,
                            FILTER_MASK | FILTER_TO_FIFO0 | (uint32_t)filter->wanted << 16 |
                                filter->mask);
    }
    const uint32_t others = can->config.filters > 0U ? RXGFC_REJECT_OTHERS : RXGFC_ONLY_STANDARD;
    put(can, RXGFC, RXGFC_COUNT(can->config.filters) | others | RXGFC_REJECT_REMOTE);
}

static bool configure(const can_t *can)
{
    if (!stop(can) || !set_timing(can)) {
        return false;
    }
    set_filters(can);
    put(can, TSCC, TSCC_EXTERNAL);
    put(can, TXBC, 0U); // a FIFO: frames leave in the order they came
    put(can, IR, UINT32_MAX);
    put(can, ILS, 0U);
    put(can, IE, INT_HANDLED);
    put(can, ILE, 1U);
    put(can, CCCR, 0U); // classic frames only; joins the bus after 11 recessive bits
    return wait_for(can, CCCR_INIT, 0U);
}

bool can_start(can_t *can, const can_config_t *config)
{
    return can_prepare(can, config) && configure(can);
}

/* --- receiving ------------------------------------------------------------------------------- */

/* The stamp is 16 bits of the microseconds; `now` too, so the difference is the frame's age. */
static int64_t stamp_us(const can_t *can, uint32_t stamp)
{
    const uint32_t age_us = (get(can, TSCV) - stamp) & STAMP_MASK;
    return can->config.time_ns() / 1000 - (int64_t)age_us;
}

static void unpack(uint8_t *data, uint32_t word)
{
    for (uint32_t i = 0; i < 4U; i++) {
        data[i] = (uint8_t)(word >> (8U * i));
    }
}

static uint32_t pack(const uint8_t *data)
{
    return (uint32_t)data[3] << 24 | (uint32_t)data[2] << 16 | (uint32_t)data[1] << 8 | data[0];
}

static void take_frame(can_t *can, uint32_t index)
{
    const uintptr_t element = STM32_FDCAN1_RAM + RAM_RX_FIFO + ELEMENT * (uintptr_t)index;
    const uint32_t id = sway_register_read(element);
    const uint32_t control = sway_register_read(element + 4U);
    if ((id & (ID_EXTENDED | ID_REMOTE)) != 0U) {
        can->counters.remote_frames += 1U;
        return;
    }
    const uint32_t dlc = (control >> DLC_SHIFT) & 15U;
    sway_port_frame_t frame;
    frame.time_us = stamp_us(can, control & STAMP_MASK);
    frame.id = (uint16_t)((id >> ID_SHIFT) & 0x7FFU);
    frame.dlc = (uint8_t)(dlc > 8U ? 8U : dlc);
    unpack(frame.data, sway_register_read(element + 8U));
    unpack(frame.data + 4, sway_register_read(element + 12U));
    can_put(can, &frame);
}

/* What went wrong last; reading it clears it. 0: nothing, 7: nothing since it was read. */
static void count_error(can_t *can)
{
    uint32_t *const counter[8] = {NULL,
                                  &can->counters.stuff_errors,
                                  &can->counters.form_errors,
                                  &can->counters.ack_errors,
                                  &can->counters.bit_errors,
                                  &can->counters.bit_errors,
                                  &can->counters.crc_errors,
                                  NULL};
    uint32_t *const hit = counter[get(can, PSR) & 7U];
    if (hit != NULL) {
        *hit += 1U;
    }
}

void can_interrupt(can_t *can)
{
    const uint32_t cause = get(can, IR) & INT_HANDLED;
    put(can, IR, cause); // written ones clear; a frame that comes now sets it again
    if ((cause & INT_PROTOCOL_ERROR) != 0U) {
        count_error(can);
    }
    if ((cause & INT_RX_LOST) != 0U) {
        can->counters.overflows += 1U;
    }
    uint32_t status = get(can, RXF0S);
    for (uint32_t i = 0; i < FIFO_FRAMES && FILL_LEVEL(status) > 0U; i++) {
        take_frame(can, INDEX(status));
        put(can, RXF0A, INDEX(status));
        status = get(can, RXF0S);
    }
    if ((cause & INT_BUS_OFF) != 0U && (get(can, PSR) & PSR_BUS_OFF) != 0U) {
        can_note_bus_off(can); // the controller has set INIT itself
    }
}

bool can_wants_interrupt(const can_t *can)
{
    return (get(can, IR) & get(can, IE)) != 0U;
}

/* Set up anew, which also empties the transmit FIFO: what was due before the bus-off is old. */
void can_service(can_t *can)
{
    if (can->bus_off && can->config.time_ns() >= can->restart_ns) {
        can->bus_off = false;
        if (!configure(can)) {
            can_note_bus_off(can);
        }
    }
}

/* --- sending and state ----------------------------------------------------------------------- */

bool can_send(can_t *can, const sway_port_frame_t *frame)
{
    const uint32_t status = get(can, TXFQS);
    if (can->bus_off || (status & TX_FULL) != 0U) {
        return false;
    }
    const uintptr_t element = STM32_FDCAN1_RAM + RAM_TX + ELEMENT * (uintptr_t)PUT_INDEX(status);
    sway_register_write(element, (uint32_t)frame->id << ID_SHIFT);
    sway_register_write(element + 4U, (uint32_t)frame->dlc << DLC_SHIFT);
    sway_register_write(element + 8U, pack(frame->data));
    sway_register_write(element + 12U, pack(frame->data + 4));
    put(can, TXBAR, 1U << PUT_INDEX(status));
    can->counters.sent += 1U;
    return true;
}

can_state_t can_state(const can_t *can)
{
    const uint32_t status = get(can, PSR);
    if (can->bus_off || (status & PSR_BUS_OFF) != 0U) {
        return CAN_BUS_OFF;
    }
    if ((status & PSR_PASSIVE) != 0U) {
        return CAN_PASSIVE;
    }
    return (status & PSR_WARNING) != 0U ? CAN_WARNING : CAN_ACTIVE;
}

uint32_t can_transmit_errors(const can_t *can)
{
    return get(can, ECR) & 0xFFU;
}

uint32_t can_receive_errors(const can_t *can)
{
    return (get(can, ECR) >> 8) & 0x7FU;
}

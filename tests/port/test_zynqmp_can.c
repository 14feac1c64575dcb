/* port/zynqmp_r5/can.c against a model of the controller's registers, after UG1085: what the
 * emulator cannot do (bus errors, error counters, bus-off, interrupts) is run here. */
#include "can.h"
#include "port_test.h"
#include "sway_registers.h"

#define BASE 0xFF070000U
#define CLOCK_HZ 24000000U
#define FIFO 64U
#define RECOVERY_NS (INT64_C(128) * 11 * 2000)

enum {
    SRR = 0x00,
    MSR = 0x04,
    BRPR = 0x08,
    BTR = 0x0C,
    ECR = 0x10,
    ESR = 0x14,
    SR = 0x18,
    ISR = 0x1C,
    IER = 0x20,
    ICR = 0x24,
    TSR = 0x28,
    TXFIFO = 0x30,
    RXFIFO = 0x50,
    AFR = 0x60
};
#define INT_RXOFLW (1U << 6)
#define INT_RXNEMP (1U << 7)
#define INT_ERROR (1U << 8)
#define INT_BSOFF (1U << 9)

typedef struct {
    uint32_t word[4];
} message_t;

static uint32_t plain[0x84 / 4];
static message_t rx[FIFO];
static message_t tx[FIFO];
static uint32_t rx_count;
static uint32_t tx_count;
static message_t rx_held; // what reading the identifier has taken out
static int64_t now_ns;
static int64_t stamp_zero_ns;
static bool is_dead;
static unsigned enabled_in_stamp_restart;
static unsigned stamp_restarts;
static uint32_t late_cause; // comes between the driver's first look at ISR and its answer
static unsigned babbled;    // frames that come while the handler runs

static can_t can;

/* --- the model -------------------------------------------------------------------------------- */

static void reset_model(void)
{
    memset(plain, 0, sizeof plain);
    plain[SR / 4] = 1U; // configuration mode
    plain[ISR / 4] = 0U;
    rx_count = tx_count = 0U;
    stamp_zero_ns = now_ns;
}

static bool is_on(void)
{
    return (plain[SRR / 4] & 2U) != 0U;
}

uint32_t sway_register_read(uintptr_t address)
{
    const uintptr_t at = address - BASE;
    TEST_ASSERT_TRUE(at < sizeof plain && at % 4U == 0U);
    if (at == SR) {
        const uint32_t full = tx_count == FIFO ? 1U << 10 : 0U;
        return is_dead ? 0U : plain[SR / 4] | full;
    }
    if (at == ISR) {
        const uint32_t seen = plain[ISR / 4];
        plain[ISR / 4] |= late_cause;
        late_cause = 0U;
        return seen;
    }
    if (at == RXFIFO) {
        TEST_ASSERT_TRUE_MESSAGE(rx_count > 0U, "read from an empty FIFO");
        rx_held = rx[0];
        memmove(rx, rx + 1, (FIFO - 1U) * sizeof rx[0]);
        rx_count--;
    }
    if (at >= RXFIFO && at < AFR) {
        return rx_held.word[(at - RXFIFO) / 4U];
    }
    return plain[at / 4];
}

static void write_enable(uint32_t value)
{
    if ((value & 1U) != 0U) {
        reset_model();
        return;
    }
    plain[SRR / 4] = value;
    plain[SR / 4] = (value & 2U) != 0U ? 1U << 3 | 1U << 7 : 1U; // normal mode, error active
}

static void write_fifo(uintptr_t at, uint32_t value)
{
    TEST_ASSERT_TRUE_MESSAGE(tx_count < FIFO, "write to a full FIFO");
    tx[tx_count].word[(at - TXFIFO) / 4U] = value;
    tx_count += at == TXFIFO + 12U;
}

void sway_register_write(uintptr_t address, uint32_t value)
{
    const uintptr_t at = address - BASE;
    TEST_ASSERT_TRUE(at < sizeof plain && at % 4U == 0U);
    if (at == SRR) {
        write_enable(value);
    } else if (at == ICR) {
        plain[ISR / 4] &= ~value;
        if (babbled > 0U && rx_count < FIFO) {
            rx[rx_count++] = rx_held;
            babbled--;
        }
        plain[ISR / 4] |= rx_count > 0U ? INT_RXNEMP : 0U;
    } else if (at == ESR) {
        plain[ESR / 4] &= ~value;
    } else if (at == TSR) {
        stamp_zero_ns = now_ns;
        stamp_restarts++;
        enabled_in_stamp_restart += plain[IER / 4] != 0U;
    } else if (at == BRPR || at == BTR || at == MSR) {
        TEST_ASSERT_FALSE_MESSAGE(is_on(), "configured while it runs");
        plain[at / 4] = value;
    } else if (at > AFR && at <= AFR + 0x20U) {
        const unsigned filter = (unsigned)(at - AFR - 4U) / 8U;
        TEST_ASSERT_FALSE_MESSAGE(plain[AFR / 4] >> filter & 1U, "filter changed while in use");
        plain[at / 4] = value;
    } else if (at >= TXFIFO && at < TXFIFO + 16U) {
        write_fifo(at, value);
    } else {
        plain[at / 4] = value;
    }
}

static bool passes(uint32_t id)
{
    for (unsigned i = 0; i < 4U; i++) {
        const uint32_t mask = plain[(AFR + 4U + 8U * i) / 4U];
        const uint32_t wanted = plain[(AFR + 8U + 8U * i) / 4U];
        if ((plain[AFR / 4] >> i & 1U) != 0U && (id & mask) == (wanted & mask)) {
            return true;
        }
    }
    return plain[AFR / 4] == 0U;
}

static bool bus_frame_of(uint16_t id, uint8_t first, uint32_t flags, uint32_t dlc)
{
    const uint32_t word = (uint32_t)id << 21 | flags;
    if (!is_on() || !passes(word)) {
        return false;
    }
    if (rx_count == FIFO) {
        plain[ISR / 4] |= INT_RXOFLW;
        return false;
    }
    const uint64_t ticks = (uint64_t)(now_ns - stamp_zero_ns) * (CLOCK_HZ / 1000000U) / 1000U;
    rx[rx_count++] = (message_t){
        {word, dlc << 28 | (ticks & 0xFFFFU), (uint32_t)first << 24 | 0x010203U, 0x04050607U}};
    plain[ISR / 4] |= INT_RXNEMP;
    return true;
}

static bool bus_frame(uint16_t id, uint8_t first, uint32_t flags)
{
    return bus_frame_of(id, first, flags, 8U);
}

static void bus_error(uint32_t bits)
{
    plain[ESR / 4] |= bits;
    plain[ISR / 4] |= INT_ERROR;
}

static void bus_counters(uint32_t transmit, uint32_t receive)
{
    const bool passive = transmit > 127U || receive > 127U;
    const uint32_t state = transmit > 255U ? 2U : (passive ? 3U : 1U);
    plain[ECR / 4] = (transmit & 255U) | (receive & 255U) << 8;
    plain[SR / 4] = (plain[SR / 4] & ~(7U << 6)) | state << 7 |
                    (transmit > 95U || receive > 95U ? 1U << 6 : 0U);
    plain[ISR / 4] |= transmit > 255U ? INT_BSOFF : 0U;
}

static int64_t time_ns(void)
{
    return now_ns;
}

/* --- tests ------------------------------------------------------------------------------------ */

void setUp(void)
{
    now_ns = INT64_C(5000000000);
    is_dead = false;
    enabled_in_stamp_restart = stamp_restarts = 0U;
    late_cause = babbled = 0U;
    reset_model();
}

void tearDown(void)
{
}

static can_config_t config_of(void)
{
    const can_config_t config = {.base = BASE,
                                 .clock_hz = CLOCK_HZ,
                                 .bit_rate = 500000,
                                 .sample_point_milli = 875,
                                 .filter = {{0x120, 0x7E0}, {0x6E0, 0x7FF}},
                                 .filters = 2,
                                 .time_ns = time_ns};
    return config;
}

static void start(void)
{
    const can_config_t config = config_of();
    TEST_ASSERT_TRUE(can_start(&can, &config));
}

static void serve(void)
{
    while (can_wants_interrupt(&can)) {
        can_interrupt(&can);
    }
}

static void test_start_sets_timing_and_joins(void)
{
    start();
    const uint32_t prescaler = plain[BRPR / 4] + 1U;
    const uint32_t segment1 = (plain[BTR / 4] & 15U) + 1U;
    const uint32_t segment2 = (plain[BTR / 4] >> 4 & 7U) + 1U;
    TEST_ASSERT_EQUAL_UINT32(500000, CLOCK_HZ / prescaler / (1U + segment1 + segment2));
    TEST_ASSERT_EQUAL_UINT32(875, 1000U * (1U + segment1) / (1U + segment1 + segment2));
    TEST_ASSERT_TRUE(is_on());
    TEST_ASSERT_EQUAL(CAN_ACTIVE, can_state(&can));
}

/* The registers whole. UG1085: BRPR is the prescaler less 1 in 8 bits, BTR the two segments less 1
 * in 4 and 3 bits, and the jump less 1 in 2 bits from bit 7 on. */
static void expect_timing(uint32_t clock_hz, uint32_t sample_point_milli, uint32_t prescaler,
                          uint32_t segment1, uint32_t segment2, uint32_t jump)
{
    can_config_t config = config_of();
    config.clock_hz = clock_hz;
    config.sample_point_milli = sample_point_milli;
    TEST_ASSERT_TRUE(can_start(&can, &config));
    TEST_ASSERT_EQUAL_UINT32(prescaler - 1U, plain[BRPR / 4]);
    TEST_ASSERT_EQUAL_HEX32((jump - 1U) << 7 | (segment2 - 1U) << 4 | (segment1 - 1U),
                            plain[BTR / 4]);
}

static void test_timing_fills_the_registers_and_no_more(void)
{
    expect_timing(CLOCK_HZ, 875, 3, 13, 2, 2);
    expect_timing(25U * 500000U, 680, 1, 16, 8, 4);          // the most quanta there are
    expect_timing(26U * 500000U, 692, 2, 8, 4, 4);           // one more does not go, neither in
    expect_timing(26U * 500000U, 654, 2, 8, 4, 4);           // the first segment nor the second
    expect_timing(23U * 256U * 500000U, 875, 256, 16, 6, 4); // 23 is a prime
    can_config_t config = config_of();
    config.bit_rate = 100000;
    config.clock_hz = 23U * 257U * config.bit_rate;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

static void test_start_refuses_what_cannot_be(void)
{
    can_config_t config = config_of();
    config.bit_rate = 333333;
    TEST_ASSERT_FALSE(can_start(&can, &config));
    config = config_of();
    config.filters = CAN_FILTERS + 1U;
    TEST_ASSERT_FALSE(can_start(&can, &config));
    config = config_of();
    is_dead = true;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

static void test_filters(void)
{
    start();
    for (uint16_t id = 0; id < 0x800U; id++) {
        const bool ours = (id >= 0x120U && id <= 0x13FU) || id == 0x6E0U;
        TEST_ASSERT_EQUAL(ours, bus_frame(id, 0, 0));
        TEST_ASSERT_FALSE(bus_frame(id, 0, 1U << 19));
        TEST_ASSERT_FALSE(bus_frame(id, 0, 1U << 20));
        serve();
    }
    TEST_ASSERT_EQUAL_UINT32(33, can.counters.received);
}

/* A filter that the program does not have stays as the reset left it. */
static void test_no_filter_too_many_is_written(void)
{
    start();
    for (unsigned i = 2; i < 4U; i++) {
        TEST_ASSERT_EQUAL_HEX32(0, plain[(AFR + 4U + 8U * i) / 4U]);
        TEST_ASSERT_EQUAL_HEX32(0, plain[(AFR + 8U + 8U * i) / 4U]);
    }
    TEST_ASSERT_EQUAL_HEX32(3, plain[AFR / 4]);
}

static void test_remote_frames_are_dropped_and_counted(void)
{
    can_config_t config = config_of();
    config.filters = 0;
    TEST_ASSERT_TRUE(can_start(&can, &config));
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 1U << 20));
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 1U << 19));
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
    serve();
    TEST_ASSERT_EQUAL_UINT32(2, can.counters.remote_frames);
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.received);
}

static void test_interrupt_empties_a_full_fifo_once(void)
{
    start();
    for (unsigned i = 0; i < FIFO + 2U; i++) {
        TEST_ASSERT_EQUAL(i < FIFO, bus_frame((uint16_t)(0x120U + i % 32U), (uint8_t)i, 0));
    }
    TEST_ASSERT_TRUE(can_wants_interrupt(&can));
    can_interrupt(&can); // one call
    TEST_ASSERT_FALSE(can_wants_interrupt(&can));
    TEST_ASSERT_EQUAL_UINT32(FIFO, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.overflows);
    for (unsigned i = 0; i < FIFO; i++) {
        sway_port_frame_t frame;
        const uint8_t wanted[8] = {(uint8_t)i, 1, 2, 3, 4, 5, 6, 7};
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        TEST_ASSERT_EQUAL_HEX16(0x120U + i % 32U, frame.id);
        TEST_ASSERT_EQUAL_UINT8(8, frame.dlc);
        TEST_ASSERT_EQUAL_MEMORY(wanted, frame.data, 8);
    }
}

/* A bus that is faster than the handler gets one FIFO full a call, not the whole processor. */
static void test_interrupt_ends_on_a_bus_that_does_not(void)
{
    start();
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
    babbled = 3U * FIFO;
    can_interrupt(&can);
    TEST_ASSERT_EQUAL_UINT32(FIFO, can.counters.received);
}

/* What comes after the handler has looked waits for its next call. */
static void test_interrupt_leaves_a_later_cause_alone(void)
{
    start();
    bus_error(1U);
    late_cause = INT_RXOFLW;
    can_interrupt(&can);
    TEST_ASSERT_EQUAL_UINT32(0, can.counters.overflows);
    serve();
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.overflows);
}

static void test_lengths(void)
{
    start();
    for (uint32_t dlc = 0; dlc < 16U; dlc++) {
        sway_port_frame_t frame;
        TEST_ASSERT_TRUE(bus_frame_of(0x120, 0, 0, dlc));
        serve();
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        TEST_ASSERT_EQUAL_UINT8(dlc < 8U ? dlc : 8U, frame.dlc);
    }
}

static void test_interrupt_without_a_cause_is_harmless(void)
{
    start();
    can_interrupt(&can);
    TEST_ASSERT_EQUAL_UINT32(0, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(0, can.counters.bus_offs);
}

static void test_ring_that_is_full_counts_what_is_lost(void)
{
    start();
    for (unsigned i = 0; i < CAN_RING + 5U; i++) {
        TEST_ASSERT_TRUE(bus_frame(0x120, (uint8_t)i, 0));
        serve();
    }
    TEST_ASSERT_EQUAL_UINT32(CAN_RING, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(5, can.counters.overflows);
    sway_port_frame_t frame;
    TEST_ASSERT_TRUE(can_receive(&can, &frame));
    TEST_ASSERT_EQUAL_UINT8(0, frame.data[0]);
    TEST_ASSERT_TRUE(bus_frame(0x120, 77, 0)); // there is room again
    serve();
    TEST_ASSERT_EQUAL_UINT32(CAN_RING + 1U, can.counters.received);
}

/* The controller's 16 bits turn over every 2.7 ms; frames are stamped right however long the bus
 * was silent and however late the interrupt. */
static void test_stamps(void)
{
    start();
    for (int i = 0; i < 3000; i++) {
        now_ns += INT64_C(1000000) + i * INT64_C(7919);
        can_service(&can);
        now_ns += (i % 13) * INT64_C(100000);
        const int64_t came_ns = now_ns;
        TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
        now_ns += (i % 50) * INT64_C(10000);
        serve();
        sway_port_frame_t frame;
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        TEST_ASSERT_INT64_WITHIN(1, came_ns / 1000, frame.time_us);
    }
    TEST_ASSERT_EQUAL_UINT(0, enabled_in_stamp_restart);
}

static int64_t stamp_of_a_frame(void)
{
    sway_port_frame_t frame = {0};
    serve();
    TEST_ASSERT_TRUE(can_receive(&can, &frame));
    return frame.time_us;
}

/* From the first moment on, before anyone has called can_service(). */
static void test_stamps_are_right_after_the_start(void)
{
    now_ns = INT64_C(7000123000);
    start();
    now_ns += 300000;
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
    now_ns += 500000;
    TEST_ASSERT_INT64_WITHIN(1, INT64_C(7000423), stamp_of_a_frame());
}

/* The program has not come to can_service() for a second, which is 400 turns of the 16 bits. A turn
 * is 2730666.67 ns, of which the driver drops the fraction: 0.27 us in 400. */
static void test_stamps_are_right_after_many_turns(void)
{
    start();
    now_ns += INT64_C(400) * 65536 * 1000 / 24 + 1000000;
    const int64_t came_ns = now_ns;
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
    now_ns += 30000;
    TEST_ASSERT_EQUAL_INT64((came_ns - 267) / 1000, stamp_of_a_frame());
}

/* The stamps begin anew when they are more than half a turn old, but not under a frame that still
 * has to be timed by them. */
static void test_stamps_begin_anew_after_half_a_turn(void)
{
    const int64_t half_turn_ns = INT64_C(32768) * 1000 / 24;
    start();
    const unsigned before = stamp_restarts;
    now_ns += half_turn_ns;
    can_service(&can);
    TEST_ASSERT_EQUAL_UINT(before, stamp_restarts);
    now_ns += 1;
    can_service(&can);
    TEST_ASSERT_EQUAL_UINT(before + 1U, stamp_restarts);
    now_ns += half_turn_ns + 1;
    const int64_t came_ns = now_ns;
    TEST_ASSERT_TRUE(bus_frame(0x120, 0, 0));
    can_service(&can);
    TEST_ASSERT_EQUAL_UINT(before + 1U, stamp_restarts);
    TEST_ASSERT_INT64_WITHIN(1, came_ns / 1000, stamp_of_a_frame());
}

static void test_sending(void)
{
    start();
    for (unsigned i = 0; i < FIFO + 3U; i++) {
        const sway_port_frame_t frame = {.id = (uint16_t)(0x1A0U + i % 16U),
                                         .dlc = 8,
                                         .data = {(uint8_t)i, 1, 2, 3, 4, 5, 6, 7}};
        TEST_ASSERT_EQUAL(i < FIFO, can_send(&can, &frame));
    }
    TEST_ASSERT_EQUAL_UINT32(FIFO, can.counters.sent);
    for (unsigned i = 0; i < FIFO; i++) {
        TEST_ASSERT_EQUAL_HEX32((0x1A0U + i % 16U) << 21, tx[i].word[0]);
        TEST_ASSERT_EQUAL_HEX32(8U << 28, tx[i].word[1]);
        TEST_ASSERT_EQUAL_HEX32(i << 24 | 0x010203U, tx[i].word[2]);
        TEST_ASSERT_EQUAL_HEX32(0x04050607U, tx[i].word[3]);
    }
}

static void test_errors_are_counted_by_kind(void)
{
    start();
    for (uint32_t kind = 0; kind < 5U; kind++) {
        for (uint32_t i = 0; i <= kind; i++) {
            bus_error(1U << kind);
            serve();
        }
    }
    bus_error(1U | 1U << 4); // two at once
    serve();
    TEST_ASSERT_EQUAL_UINT32(2, can.counters.crc_errors);
    TEST_ASSERT_EQUAL_UINT32(2, can.counters.form_errors);
    TEST_ASSERT_EQUAL_UINT32(3, can.counters.stuff_errors);
    TEST_ASSERT_EQUAL_UINT32(4, can.counters.bit_errors);
    TEST_ASSERT_EQUAL_UINT32(6, can.counters.ack_errors);
    TEST_ASSERT_EQUAL_HEX32(0, plain[ESR / 4]);
}

static void test_error_counters_and_states(void)
{
    start();
    bus_counters(96, 7);
    TEST_ASSERT_EQUAL(CAN_WARNING, can_state(&can));
    TEST_ASSERT_EQUAL_UINT32(96, can_transmit_errors(&can));
    TEST_ASSERT_EQUAL_UINT32(7, can_receive_errors(&can));
    bus_counters(0, 128);
    TEST_ASSERT_EQUAL(CAN_PASSIVE, can_state(&can));
    TEST_ASSERT_EQUAL_UINT32(128, can_receive_errors(&can));
    bus_counters(256, 0);
    TEST_ASSERT_EQUAL(CAN_BUS_OFF, can_state(&can));
}

static int64_t recovery_ns(void)
{
    bus_counters(256, 0);
    serve();
    TEST_ASSERT_TRUE(can.bus_off);
    TEST_ASSERT_FALSE(is_on()); // held in reset: nothing old is sent
    const int64_t start_ns = now_ns;
    const sway_port_frame_t frame = {.id = 0x1A0, .dlc = 8};
    TEST_ASSERT_FALSE(can_send(&can, &frame));
    while (can.bus_off) {
        TEST_ASSERT_EQUAL(CAN_BUS_OFF, can_state(&can));
        now_ns += 10000;
        can_service(&can);
    }
    TEST_ASSERT_TRUE(is_on());
    TEST_ASSERT_EQUAL(CAN_ACTIVE, can_state(&can));
    TEST_ASSERT_TRUE(can_send(&can, &frame));
    return now_ns - start_ns;
}

static void test_bus_off_waits_longer_each_time_until_a_frame_comes(void)
{
    start();
    int64_t wanted = RECOVERY_NS;
    for (uint32_t i = 1; i <= 12U; i++) {
        TEST_ASSERT_INT64_WITHIN(10000, wanted, recovery_ns());
        TEST_ASSERT_EQUAL_UINT32(i, can.counters.bus_offs);
        wanted = wanted * 2 > 1000000000 ? 1000000000 : wanted * 2;
    }
    TEST_ASSERT_TRUE(bus_frame(0x121, 0, 0)); // filters are set again
    TEST_ASSERT_FALSE(bus_frame(0x140, 0, 0));
    serve();
    TEST_ASSERT_INT64_WITHIN(10000, RECOVERY_NS, recovery_ns());
}

static void test_bus_off_ends_when_its_time_has_come(void)
{
    start();
    bus_counters(256, 0);
    serve();
    now_ns += RECOVERY_NS - 1;
    can_service(&can);
    TEST_ASSERT_TRUE(can.bus_off);
    now_ns += 1;
    can_service(&can);
    TEST_ASSERT_FALSE(can.bus_off);
}

static void test_bus_off_with_a_dead_controller_goes_on_trying(void)
{
    start();
    bus_counters(256, 0);
    serve();
    is_dead = true;
    now_ns += 2 * RECOVERY_NS;
    can_service(&can);
    TEST_ASSERT_TRUE(can.bus_off);
    is_dead = false;
    can_service(&can);
    TEST_ASSERT_FALSE(can.bus_off);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_start_sets_timing_and_joins);
    RUN_TEST(test_timing_fills_the_registers_and_no_more);
    RUN_TEST(test_start_refuses_what_cannot_be);
    RUN_TEST(test_filters);
    RUN_TEST(test_no_filter_too_many_is_written);
    RUN_TEST(test_remote_frames_are_dropped_and_counted);
    RUN_TEST(test_interrupt_empties_a_full_fifo_once);
    RUN_TEST(test_interrupt_ends_on_a_bus_that_does_not);
    RUN_TEST(test_interrupt_leaves_a_later_cause_alone);
    RUN_TEST(test_lengths);
    RUN_TEST(test_interrupt_without_a_cause_is_harmless);
    RUN_TEST(test_ring_that_is_full_counts_what_is_lost);
    RUN_TEST(test_stamps);
    RUN_TEST(test_stamps_are_right_after_the_start);
    RUN_TEST(test_stamps_are_right_after_many_turns);
    RUN_TEST(test_stamps_begin_anew_after_half_a_turn);
    RUN_TEST(test_sending);
    RUN_TEST(test_errors_are_counted_by_kind);
    RUN_TEST(test_error_counters_and_states);
    RUN_TEST(test_bus_off_waits_longer_each_time_until_a_frame_comes);
    RUN_TEST(test_bus_off_ends_when_its_time_has_come);
    RUN_TEST(test_bus_off_with_a_dead_controller_goes_on_trying);
    return UNITY_END();
}

/* port/stm32g4 against a model of the registers: clocks, CAN driver, flash, watchdog, and the
 * whole program with its parameters. None of this has run on the part itself. */
#include "board.h"
#include "flash.h"
#include "model_stm32g4.h"
#include "port_test.h"
#include "program.h"
#include "stm32g474.h"
#include "sway_registers.h"

#define BIT_NS 2000
#define RECOVERY_US (128 * 11 * BIT_NS / 1000)

static can_t can;
static sway_ecu_retained_t retained;

void setUp(void)
{
    model_flash_new();
    memcpy(model_flash + 2U * STM32_FLASH_PAGE, test_key, sizeof test_key);
    memset(&retained, 0, sizeof retained);
    model_nmi = program_nmi;
    model_power_on();
}

void tearDown(void)
{
}

static sway_port_frame_t frame_of(uint16_t id, uint8_t first)
{
    const sway_port_frame_t frame = {.id = id, .dlc = 8, .data = {first, 1, 2, 3, 4, 5, 6, 7}};
    return frame;
}

static can_config_t driver_config(void)
{
    const can_config_t config = {.base = STM32_FDCAN1,
                                 .clock_hz = BOARD_HSE_HZ,
                                 .bit_rate = 500000,
                                 .sample_point_milli = 875,
                                 .filter = {{0x120, 0x7E0}, {0x6E0, 0x7FF}},
                                 .filters = 2,
                                 .time_ns = board_time_ns};
    return config;
}

static void start_driver(void)
{
    const can_config_t config = driver_config();
    TEST_ASSERT_TRUE(board_start());
    board_enable_interrupts();
    TEST_ASSERT_TRUE(can_start(&can, &config));
}

static void serve(void)
{
    while (model_wants_interrupt()) {
        can_interrupt(&can);
    }
}

static void take(uint16_t id, uint8_t first)
{
    const sway_port_frame_t frame = frame_of(id, first);
    TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
    serve();
}

/* --- clocks, pins, watchdog ------------------------------------------------------------------- */

static void test_clock_is_168_mhz_and_counts_microseconds(void)
{
    TEST_ASSERT_TRUE(board_start());
    TEST_ASSERT_EQUAL_UINT32(BOARD_CPU_HZ, model_cpu_hz());
    const int64_t before = board_time_ns();
    model_wait_us(12345);
    TEST_ASSERT_EQUAL_INT64(12345000, board_time_ns() - before);
    /* Pins 11 and 12 are of the CAN controller, the others as they were. */
    TEST_ASSERT_EQUAL_HEX32(0xAABFFFFF, model_read(STM32_GPIOA + GPIO_MODER));
    TEST_ASSERT_EQUAL_HEX32(0xFFF99FFF, model_read(STM32_GPIOA + GPIO_AFRH));
    TEST_ASSERT_EQUAL_HEX32(RCC_CCIPR_CLK48_MASK, model_read(STM32_RCC + RCC_CCIPR));
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_RCC + RCC_CFGR) & RCC_CFGR_HPRE_MASK);
    TEST_ASSERT_EQUAL_HEX32(4U | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN,
                            model_read(STM32_FLASH + FLASH_ACR));
    for (unsigned i = 0; i < 2U; i++) { // counters run through, in microseconds
        const uintptr_t timer = i == 0U ? STM32_TIM2 : STM32_TIM3;
        TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, model_read(timer + TIM_ARR) | (i ? 0xFFFF0000U : 0U));
    }
    board_enable_interrupts(); // a tick of the counter's, with its interrupt
    TEST_ASSERT_EQUAL_UINT32(7, model_read(CORTEX_SYST_CSR));
    TEST_ASSERT_EQUAL_UINT32(BOARD_CPU_HZ / 1000U - 1U, model_read(CORTEX_SYST_RVR));
    (void)board_random();
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_RCC + RCC_CCIPR));
}

static void test_clock_runs_on_over_its_32_bits(void)
{
    TEST_ASSERT_TRUE(board_start());
    const int64_t start = board_time_ns();
    int64_t waited = 0;
    while (waited < INT64_C(3) << 32) {
        model_wait_us(1000000007);
        waited += 1000000007;
        TEST_ASSERT_EQUAL_INT64(waited * 1000, board_time_ns() - start);
    }
}

static void test_dead_clocks_are_found(void)
{
    bool *const part[] = {&model_dead_crystal, &model_dead_pll, &model_dead_wait_states};
    for (unsigned i = 0; i < sizeof part / sizeof part[0]; i++) {
        model_power_on();
        *part[i] = true;
        TEST_ASSERT_FALSE(board_start());
    }
}

/* Without its oscillator or its noise there is no random number, and nobody waits for ever. */
static void test_dead_noise_is_no_number(void)
{
    TEST_ASSERT_TRUE(board_start());
    TEST_ASSERT_TRUE(board_random() != 0U);
    model_dead_noise = true;
    TEST_ASSERT_EQUAL_UINT32(0, board_random());
    model_power_on();
    TEST_ASSERT_TRUE(board_start());
    model_dead_hsi48 = true;
    TEST_ASSERT_EQUAL_UINT32(0, board_random());
}

static void test_restart_is_asked_of_the_processor(void)
{
    TEST_ASSERT_TRUE(board_start());
    TEST_ASSERT_FALSE(model_wants_restart());
    board_restart();
    TEST_ASSERT_TRUE(model_wants_restart());
}

static void test_watchdog_wants_half_a_second(void)
{
    TEST_ASSERT_TRUE(board_start());
    board_start_watchdog();
    model_wait_us(499000);
    TEST_ASSERT_FALSE(model_watchdog_bit());
    board_serve_watchdog();
    model_wait_us(500000);
    TEST_ASSERT_FALSE(model_watchdog_bit());
    model_wait_us(1);
    TEST_ASSERT_TRUE(model_watchdog_bit());
    model_restart();
    TEST_ASSERT_TRUE(board_was_watchdog());
    TEST_ASSERT_FALSE(board_was_watchdog());
}

/* --- CAN driver ------------------------------------------------------------------------------- */

/* The register whole: jump, prescaler, first and second segment, each less 1, from bits 25, 16, 8
 * and 0 on (RM0440, FDCAN_NBTP). The jump is as long as the second segment. */
static void test_bit_timing(void)
{
    can_config_t config = driver_config();
    start_driver();
    TEST_ASSERT_EQUAL_HEX32(5U << 25 | 0U << 16 | 40U << 8 | 5U, model_read(STM32_FDCAN1 + 0x1C));
    config.bit_rate = 50000;
    config.clock_hz = config.bit_rate * 73U * 512U; // 73 is a prime: 512 is the only divisor
    TEST_ASSERT_TRUE(can_start(&can, &config));
    TEST_ASSERT_EQUAL_HEX32(8U << 25 | 511U << 16 | 62U << 8 | 8U, model_read(STM32_FDCAN1 + 0x1C));
    config.clock_hz = config.bit_rate * 79U * 513U;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

static void test_impossible_bit_rate_is_refused(void)
{
    can_config_t config;
    start_driver();
    config = can.config;
    config.bit_rate = 333333;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

static void test_dead_controller_is_found(void)
{
    can_config_t config;
    start_driver();
    config = can.config;
    model_dead_can = true;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

/* Whatever a boot loader has left in the controller. */
static void test_start_takes_over_a_used_controller(void)
{
    enum { CCCR = 0x18, IR = 0x50, ILS = 0x58, TXBC = 0xC0 };
    const can_config_t config = driver_config();
    start_driver();
    sway_register_write(STM32_FDCAN1 + CCCR, 3U);
    sway_register_write(STM32_FDCAN1 + TXBC, 1U << 24); // by identifier, not by age
    sway_register_write(STM32_FDCAN1 + ILS, UINT32_MAX);
    model_bus_error(2);
    sway_register_write(STM32_FDCAN1 + CCCR, 0x11U); // asleep
    TEST_ASSERT_TRUE(can_start(&can, &config));
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_FDCAN1 + CCCR));
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_FDCAN1 + TXBC));
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_FDCAN1 + ILS));
    TEST_ASSERT_EQUAL_HEX32(0, model_read(STM32_FDCAN1 + IR));
    model_stuck_standby = true;
    TEST_ASSERT_FALSE(can_start(&can, &config));
}

/* One filter is one: the words of the others are somebody else's, and nothing else passes. */
static void test_one_filter_is_one(void)
{
    can_config_t config = driver_config();
    start_driver();
    config.filters = 1;
    sway_register_write(STM32_FDCAN1_RAM + 4U, 0xA5A5A5A5U);
    TEST_ASSERT_TRUE(can_start(&can, &config));
    TEST_ASSERT_EQUAL_HEX32(0xA5A5A5A5U, model_read(STM32_FDCAN1_RAM + 4U));
    for (uint16_t id = 0; id < 0x800U; id++) {
        const sway_port_frame_t frame = frame_of(id, 0);
        TEST_ASSERT_EQUAL(id >= 0x120U && id <= 0x13FU, model_bus_frame(&frame, false, false));
        serve();
    }
}

/* The controller refuses them; where it does not, the driver does. */
static void test_remote_and_long_frames_are_dropped_and_counted(void)
{
    enum { CCCR = 0x18, RXGFC = 0x80 };
    const sway_port_frame_t frame = frame_of(0x120, 0);
    start_driver();
    sway_register_write(STM32_FDCAN1 + CCCR, 3U);
    sway_register_write(STM32_FDCAN1 + RXGFC, 0U); // takes everything
    sway_register_write(STM32_FDCAN1 + CCCR, 0U);
    for (unsigned i = 1; i < 4U; i++) {
        TEST_ASSERT_TRUE(model_bus_frame(&frame, (i & 1U) != 0U, (i & 2U) != 0U));
        serve();
        TEST_ASSERT_EQUAL_UINT32(i, can.counters.remote_frames);
    }
    TEST_ASSERT_EQUAL_UINT32(0, can.counters.received);
}

static void test_lengths(void)
{
    start_driver();
    for (uint8_t dlc = 0; dlc < 16U; dlc++) {
        sway_port_frame_t frame = frame_of(0x120, 0);
        frame.dlc = dlc;
        TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
        serve();
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        TEST_ASSERT_EQUAL_UINT8(dlc < 8U ? dlc : 8U, frame.dlc);
    }
}

/* A bus that is faster than the handler gets one FIFO full a call, not the whole processor. */
static void test_interrupt_ends_on_a_bus_that_does_not(void)
{
    const sway_port_frame_t frame = frame_of(0x120, 0);
    start_driver();
    TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
    model_bus_babbles = 10;
    can_interrupt(&can);
    TEST_ASSERT_EQUAL_UINT32(3, can.counters.received);
}

/* Asked by what runs without an interrupt controller. A frame that was sent is no cause. */
static void test_interrupt_is_wanted_for_what_is_handled(void)
{
    sway_port_frame_t frame = frame_of(0x1A0, 0);
    start_driver();
    TEST_ASSERT_FALSE(can_wants_interrupt(&can));
    TEST_ASSERT_TRUE(can_send(&can, &frame));
    TEST_ASSERT_TRUE(model_bus_sent(&frame));
    TEST_ASSERT_FALSE(can_wants_interrupt(&can));
    frame = frame_of(0x120, 0);
    TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
    TEST_ASSERT_TRUE(can_wants_interrupt(&can));
    can_interrupt(&can);
    TEST_ASSERT_FALSE(can_wants_interrupt(&can));
}

static void test_filters_take_what_is_ours(void)
{
    start_driver();
    for (uint16_t id = 0; id < 0x800U; id++) {
        const sway_port_frame_t frame = frame_of(id, 0);
        const bool ours = (id >= 0x120U && id <= 0x13FU) || id == 0x6E0U;
        TEST_ASSERT_EQUAL(ours, model_bus_frame(&frame, false, false));
        TEST_ASSERT_FALSE(model_bus_frame(&frame, true, false));
        TEST_ASSERT_FALSE(model_bus_frame(&frame, false, true));
        serve();
    }
    TEST_ASSERT_EQUAL_UINT32(33, can.counters.received);
}

static void test_no_filters_take_all_standard_frames(void)
{
    start_driver();
    can_config_t config = can.config;
    config.filters = 0;
    TEST_ASSERT_TRUE(can_start(&can, &config));
    const sway_port_frame_t frame = frame_of(0x7FF, 0);
    TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
    TEST_ASSERT_FALSE(model_bus_frame(&frame, true, false));
}

static void test_frames_arrive_whole_and_in_order(void)
{
    start_driver();
    for (unsigned i = 0; i < 3U; i++) {
        const sway_port_frame_t frame = frame_of((uint16_t)(0x120U + i), (uint8_t)(0xA0U + i));
        TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
    }
    serve();
    for (unsigned i = 0; i < 3U; i++) {
        sway_port_frame_t frame;
        TEST_ASSERT_TRUE(can_receive(&can, &frame));
        const sway_port_frame_t wanted = frame_of((uint16_t)(0x120U + i), (uint8_t)(0xA0U + i));
        TEST_ASSERT_EQUAL_HEX16(wanted.id, frame.id);
        TEST_ASSERT_EQUAL_UINT8(8, frame.dlc);
        TEST_ASSERT_EQUAL_MEMORY(wanted.data, frame.data, 8);
    }
    sway_port_frame_t none;
    TEST_ASSERT_FALSE(can_receive(&can, &none));
}

static void test_lost_frames_are_counted(void)
{
    start_driver();
    for (unsigned i = 0; i < 5U; i++) {
        const sway_port_frame_t frame = frame_of(0x120, (uint8_t)i);
        TEST_ASSERT_EQUAL(i < 3U, model_bus_frame(&frame, false, false));
    }
    serve();
    TEST_ASSERT_EQUAL_UINT32(3, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.overflows);
    for (unsigned i = 0; i < CAN_RING; i++) {
        take(0x121, (uint8_t)i);
    }
    TEST_ASSERT_EQUAL_UINT32(CAN_RING, can.counters.received);
    TEST_ASSERT_EQUAL_UINT32(4, can.counters.overflows);
}

/* The stamp is when the frame came, however late the interrupt and whatever turns over. */
static void test_stamps_are_those_of_the_frames(void)
{
    start_driver();
    for (int i = 0; i < 3000; i++) {
        model_wait_us(40009);
        const int64_t came_us = board_time_ns() / 1000;
        const sway_port_frame_t frame = frame_of(0x120, 0);
        TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
        model_wait_us(i % 700);
        serve();
        sway_port_frame_t got;
        TEST_ASSERT_TRUE(can_receive(&can, &got));
        TEST_ASSERT_EQUAL_INT64(came_us, got.time_us);
    }
}

static void test_sending_keeps_the_order_and_says_when_full(void)
{
    start_driver();
    model_bus_is_busy = true;
    for (unsigned i = 0; i < 5U; i++) {
        const sway_port_frame_t frame = frame_of((uint16_t)(0x1A0U + i), (uint8_t)i);
        TEST_ASSERT_EQUAL(i < 3U, can_send(&can, &frame));
    }
    model_bus_is_busy = false;
    for (unsigned i = 0; i < 3U; i++) {
        sway_port_frame_t sent;
        TEST_ASSERT_TRUE(model_bus_sent(&sent));
        const sway_port_frame_t wanted = frame_of((uint16_t)(0x1A0U + i), (uint8_t)i);
        TEST_ASSERT_EQUAL_HEX16(wanted.id, sent.id);
        TEST_ASSERT_EQUAL_UINT8(8, sent.dlc);
        TEST_ASSERT_EQUAL_MEMORY(wanted.data, sent.data, 8);
    }
    TEST_ASSERT_EQUAL_UINT32(3, can.counters.sent);
}

static void test_errors_are_counted_by_kind(void)
{
    start_driver();
    for (uint32_t code = 1; code <= 6U; code++) {
        for (uint32_t i = 0; i < code; i++) {
            model_bus_error(code);
            serve();
        }
    }
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.stuff_errors);
    TEST_ASSERT_EQUAL_UINT32(2, can.counters.form_errors);
    TEST_ASSERT_EQUAL_UINT32(3, can.counters.ack_errors);
    TEST_ASSERT_EQUAL_UINT32(4 + 5, can.counters.bit_errors);
    TEST_ASSERT_EQUAL_UINT32(6, can.counters.crc_errors);
}

static void test_error_counters_and_states(void)
{
    start_driver();
    TEST_ASSERT_EQUAL(CAN_ACTIVE, can_state(&can));
    model_bus_counters(96, 100);
    TEST_ASSERT_EQUAL(CAN_WARNING, can_state(&can));
    TEST_ASSERT_EQUAL_UINT32(96, can_transmit_errors(&can));
    TEST_ASSERT_EQUAL_UINT32(100, can_receive_errors(&can));
    model_bus_counters(128, 0);
    TEST_ASSERT_EQUAL(CAN_PASSIVE, can_state(&can));
    model_bus_counters(256, 0);
    TEST_ASSERT_EQUAL(CAN_BUS_OFF, can_state(&can));
}

/* Time from a bus-off until the driver has joined again. */
static int64_t recovery_us(void)
{
    model_bus_counters(256, 0);
    serve();
    const int64_t start = model_time_us();
    const sway_port_frame_t frame = frame_of(0x1A0, 0);
    TEST_ASSERT_FALSE(can_send(&can, &frame));
    while (can.bus_off) {
        TEST_ASSERT_EQUAL(CAN_BUS_OFF, can_state(&can));
        model_wait_us(10);
        can_service(&can);
    }
    model_bus_counters(0, 0);
    TEST_ASSERT_EQUAL(CAN_ACTIVE, can_state(&can));
    TEST_ASSERT_TRUE(can_send(&can, &frame));
    return model_time_us() - start;
}

static void test_bus_off_waits_longer_each_time_until_a_frame_comes(void)
{
    start_driver();
    int64_t wanted = RECOVERY_US;
    for (uint32_t i = 1; i <= 12U; i++) {
        TEST_ASSERT_INT64_WITHIN(10, wanted, recovery_us());
        TEST_ASSERT_EQUAL_UINT32(i, can.counters.bus_offs);
        wanted = wanted * 2 > 1000000 ? 1000000 : wanted * 2;
    }
    take(0x120, 0);
    TEST_ASSERT_INT64_WITHIN(10, RECOVERY_US, recovery_us());
}

/* Reported once, when it begins: not by another cause while it lasts, nor by its end. */
static void test_bus_off_is_reported_once(void)
{
    start_driver();
    model_bus_counters(256, 0);
    serve();
    model_bus_error(1);
    serve();
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.bus_offs);
    model_wait_us(RECOVERY_US - 1);
    can_service(&can);
    TEST_ASSERT_TRUE(can.bus_off);
    model_wait_us(1);
    can_service(&can);
    TEST_ASSERT_FALSE(can.bus_off);
    serve();
    TEST_ASSERT_FALSE(can.bus_off);
    TEST_ASSERT_EQUAL_UINT32(1, can.counters.bus_offs);
}

static void test_bus_off_with_a_dead_controller_goes_on_trying(void)
{
    start_driver();
    model_bus_counters(256, 0);
    serve();
    model_dead_can = true;
    model_wait_us(RECOVERY_US);
    can_service(&can);
    TEST_ASSERT_TRUE(can.bus_off);
    model_dead_can = false;
    model_wait_us(2 * RECOVERY_US);
    can_service(&can);
    TEST_ASSERT_FALSE(can.bus_off);
}

/* --- flash ------------------------------------------------------------------------------------ */

static void test_flash_erases_and_writes(void)
{
    uint8_t bytes[21];
    for (unsigned i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i + 1U);
    }
    memset(model_flash, 0, sizeof model_flash);
    TEST_ASSERT_TRUE(flash_erase(1));
    TEST_ASSERT_EQUAL_HEX8(0, model_flash[STM32_FLASH_PAGE - 1U]);
    TEST_ASSERT_EQUAL_HEX8(0xFF, model_flash[STM32_FLASH_PAGE]);
    TEST_ASSERT_TRUE(flash_write(1, 8, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_MEMORY(bytes, model_flash + STM32_FLASH_PAGE + 8, sizeof bytes);
    TEST_ASSERT_EQUAL_HEX8(0xFF, model_flash[STM32_FLASH_PAGE + 8U + sizeof bytes]);
    TEST_ASSERT_EQUAL_HEX32(FLASH_CR_LOCK, model_read(STM32_FLASH + FLASH_CR) & FLASH_CR_LOCK);
}

/* What the data cache held before it was erased or written is not read again, and the cache goes on
 * as it was. */
static void test_flash_is_read_as_it_was_written(void)
{
    const uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    uint8_t got[8];
    TEST_ASSERT_TRUE(board_start());
    const uint32_t access = model_read(STM32_FLASH + FLASH_ACR);
    for (unsigned i = 0; i < 2U; i++) {
        TEST_ASSERT_TRUE(flash_erase(0));
        TEST_ASSERT_TRUE(flash_read(0, got, sizeof got));
        TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, got, sizeof got);
        TEST_ASSERT_TRUE(flash_write(0, 0, bytes, sizeof bytes));
        TEST_ASSERT_TRUE(flash_read(0, got, sizeof got));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, got, sizeof bytes);
        TEST_ASSERT_EQUAL_HEX32(access, model_read(STM32_FLASH + FLASH_ACR));
    }
}

static void test_flash_says_what_it_cannot(void)
{
    const uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    TEST_ASSERT_FALSE(flash_erase(128));
    TEST_ASSERT_FALSE(flash_write(128, 0, bytes, 8));
    TEST_ASSERT_FALSE(flash_write(0, 4, bytes, 8));
    TEST_ASSERT_FALSE(flash_write(0, STM32_FLASH_PAGE, bytes, 8));
    TEST_ASSERT_TRUE(flash_write(0, 0, bytes, 8));
    TEST_ASSERT_FALSE(flash_write(0, 0, bytes, 8)); // not erased
    TEST_ASSERT_TRUE(flash_erase(0));               // the error before does not stay
    model_write_protected = true;
    TEST_ASSERT_FALSE(flash_erase(0));
    model_write_protected = false;
    model_dead_flash = true;
    TEST_ASSERT_FALSE(flash_erase(0));
    TEST_ASSERT_FALSE(flash_write(0, 8, bytes, 8));
}

/* --- the whole program ------------------------------------------------------------------------ */

static sway_port_frame_t last_sent;

static bool pass(void)
{
    sway_port_frame_t sent;
    while (model_wants_interrupt()) {
        program_can_interrupt();
    }
    const bool busy = program_pass();
    while (model_bus_sent(&sent)) {
        last_sent = sent;
    }
    return busy;
}

/* The car stands; the request needs to know. */
static void stand(int frames)
{
    static uint8_t counter;
    for (int i = 0; i < frames; i++) {
        sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
        sway_e2e_protect(frame.id, counter, frame.data);
        counter = sway_e2e_next(counter);
        model_wait_us(10000);
        TEST_ASSERT_TRUE(model_bus_frame(&frame, false, false));
        while (pass()) {
        }
    }
}

static struct swaywatch_dbc_sway_parameter_reply_t say(sway_port_frame_t request)
{
    stand(1);
    model_wait_us(1000);
    memset(&last_sent, 0, sizeof last_sent);
    TEST_ASSERT_TRUE(model_bus_frame(&request, false, false));
    for (int i = 0; i < 100; i++) {
        sway_port_frame_t sent;
        while (model_wants_interrupt()) {
            program_can_interrupt();
        }
        (void)program_pass();
        while (model_bus_sent(&sent)) {
            if (sent.id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID) {
                return reply_of(&sent);
            }
        }
    }
    TEST_FAIL_MESSAGE("no reply");
    return reply_of(&last_sent);
}

static struct swaywatch_dbc_sway_parameter_reply_t ask(uint8_t command, uint16_t index,
                                                       int32_t value)
{
    return say(request_frame(command, index, value));
}

static struct swaywatch_dbc_sway_parameter_reply_t open_session(void)
{
    stand(30);
    const struct swaywatch_dbc_sway_parameter_reply_t opened = ask(OPEN, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(DONE, opened.parameter_result);
    return opened;
}

static uint8_t store(struct swaywatch_dbc_sway_parameter_reply_t opened)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&program_ecu()->staged, program_ecu()->block_sequence + 1U, block);
    return say(proof_frame(STORE, test_key, opened, block)).parameter_result;
}

/* A session that changes the car's mass. */
static uint8_t store_mass(int32_t mass_g)
{
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    TEST_ASSERT_EQUAL_UINT8(DONE, ask(WRITE, 0, mass_g).parameter_result);
    return store(opened);
}

static int32_t mass_in_use(void)
{
    return sway_ecu_config(program_ecu())->vehicle.car.mass_g;
}

static struct swaywatch_dbc_sway_fault_report_t report(void)
{
    for (int i = 0; i < 1000; i++) {
        sway_port_frame_t sent;
        model_wait_us(10000);
        (void)program_pass();
        while (model_bus_sent(&sent)) {
            if (sent.id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
                return report_of(&sent);
            }
        }
    }
    TEST_FAIL_MESSAGE("no report");
    return report_of(&last_sent);
}

static void write_all(const sway_core_config_t *config)
{
    for (uint16_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        int32_t value = 0;
        (void)sway_block_get(config, i, &value);
        TEST_ASSERT_EQUAL_UINT8(0, ask(WRITE, i, value).parameter_result);
    }
}

static void test_program_takes_parameters_and_keeps_them(void)
{
    sway_core_config_t config = good_config();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_EMPTY, report().fault_cause);
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    write_all(&config);
    TEST_ASSERT_EQUAL_UINT8(DONE, store(opened));
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RUNNING, report().ecu_state);
    model_restart();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, program_ecu()->state);
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(program_ecu()), sizeof config);
    TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
}

#define STORE_STEPS (1 + (int)((SWAY_BLOCK_SIZE + 7U) / 8U))

static void two_blocks(void)
{
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    setUp();
    sway_block_write(&config, 1, block);
    memcpy(model_flash, block, sizeof block);
    sway_block_write(&config, 2, block);
    memcpy(model_flash + STM32_FLASH_PAGE, block, sizeof block);
}

/* Power comes back: the ECU runs with `mass_g`, no NMI has restarted it, and it says whether what
 * is in its flash was cut. */
static void check_after_power(int32_t mass_g, int reports_cut)
{
    model_power_on();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_FALSE(model_nmi_restarts());
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, program_ecu()->state);
    TEST_ASSERT_EQUAL_INT32(mass_g, mass_in_use());
    TEST_ASSERT_EQUAL_UINT8(reports_cut ? SWAY_ECU_STORE_CUT : 0, report().fault_cause);
}

/* Whenever the power goes and whatever it leaves of the word or page that it cut, the next start
 * has the old parameters or the new ones, whole, and says when a store was cut. Then the next store
 * is cut, too, at every step, and after that one works. */
static void test_power_cut_at_every_step_of_two_stores(void)
{
    for (int leaves = MODEL_CUT_BEFORE; leaves <= MODEL_CUT_AFTER; leaves++) {
        for (int cut = 0; cut < STORE_STEPS; cut++) {
            for (int again = cut % 5; again < STORE_STEPS; again += 5) {
                const bool all = leaves == MODEL_CUT_AFTER;
                const bool first = all && cut == STORE_STEPS - 1; // its last word was written
                const bool second = all && again == STORE_STEPS - 1;
                two_blocks();
                TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
                model_cut_leaves = (model_cut_t)leaves;
                model_cut_after = cut;
                (void)store_mass(2000000);
                TEST_ASSERT_TRUE(model_power_is_off());
                const bool untouched = cut == 0 && leaves == MODEL_CUT_BEFORE;
                check_after_power(first ? 2000000 : 1955000, !first && !untouched);
                model_cut_leaves = (model_cut_t)leaves;
                model_cut_after = again;
                (void)store_mass(2100000);
                const bool still = again == 0 && leaves == MODEL_CUT_BEFORE;
                check_after_power(second  ? 2100000
                                  : first ? 2000000
                                          : 1955000,
                                  !second && !(still && (untouched || first)));
                TEST_ASSERT_EQUAL_UINT8(DONE, store_mass(2200000));
                check_after_power(2200000, false);
            }
        }
    }
}

/* What a torn word did before it was dealt with: NMI, restart, NMI. The model does see it. */
static void test_an_nmi_that_nobody_expects_is_a_fault(void)
{
    TEST_ASSERT_FALSE(program_nmi());
    two_blocks();
    model_nmi = NULL;
    model_flash_tear(64);
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_TRUE(model_nmi_restarts());
}

/* Only a wrong double word, and only while flash_read() reads, is one that somebody expects. */
static void test_an_nmi_of_another_part_or_time_is_a_fault(void)
{
    uint8_t bytes[8];
    TEST_ASSERT_TRUE(board_start());
    model_other_nmi = true;
    TEST_ASSERT_TRUE(flash_read(0, bytes, sizeof bytes));
    TEST_ASSERT_TRUE(model_nmi_restarts());
    model_power_on();
    TEST_ASSERT_TRUE(board_start());
    TEST_ASSERT_TRUE(flash_read(0, bytes, sizeof bytes));
    model_flash_tear(64);
    (void)sway_register_read(STM32_FLASH_BANK2 + 64U);
    TEST_ASSERT_TRUE(model_nmi_restarts());
}

/* A word of each block goes bad in service, and all words of both. */
static void test_torn_words_are_survived_anywhere(void)
{
    for (uint32_t at = 0; at < SWAY_BLOCK_SIZE; at += 8U) {
        two_blocks();
        model_flash_tear(STM32_FLASH_PAGE + at);
        check_after_power(1955000, true);
        model_flash_tear(at);
        model_power_on();
        TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
        TEST_ASSERT_FALSE(model_nmi_restarts());
        TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, program_ecu()->state);
        const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
        sway_core_config_t config = good_config();
        write_all(&config);
        TEST_ASSERT_EQUAL_UINT8(DONE, store(opened));
        check_after_power(1955000, true); // the other page is still torn
        TEST_ASSERT_EQUAL_UINT8(DONE, store_mass(1800000));
        check_after_power(1800000, false);
    }
}

static void test_a_torn_or_missing_key_locks(void)
{
    two_blocks();
    model_flash_tear(2U * STM32_FLASH_PAGE + 8U);
    check_after_power(1955000, false);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(OPEN, 0, 0).parameter_result);
    two_blocks();
    memset(model_flash + 2U * STM32_FLASH_PAGE, 0xFF, sizeof test_key);
    check_after_power(1955000, false);
    TEST_ASSERT_EQUAL_UINT8(LOCKED, ask(OPEN, 0, 0).parameter_result);
}

/* Where faults do not end, the flash that may make them is left alone. */
static void test_after_too_many_faults_the_flash_is_not_read(void)
{
    two_blocks();
    for (unsigned i = 0; i < SWAY_ECU_RESTARTS_MAX; i++) {
        sway_ecu_note_fault(&retained, 2, 0);
    }
    model_nmi = NULL;
    model_flash_tear(0);
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_FALSE(model_nmi_restarts());
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_RESTARTS, report().fault_cause);
    TEST_ASSERT_EQUAL(SWAY_ECU_NO_CAUSE, program_ecu()->notice);
}

/* One byte that is written makes a key of a page, whichever it is. */
static void test_any_byte_makes_a_key(void)
{
    for (unsigned i = 0; i < sizeof test_key; i++) {
        two_blocks();
        memset(model_flash + 2U * STM32_FLASH_PAGE, 0xFF, sizeof test_key);
        model_flash[2U * STM32_FLASH_PAGE + i] = 0xFEU;
        check_after_power(1955000, false);
        (void)open_session();
    }
}

static void test_program_listens_to_its_own_frames(void)
{
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    for (uint16_t id = 0; id < 0x800U; id++) {
        const sway_port_frame_t frame = frame_of(id, 0);
        const bool ours = (id >= 0x120U && id <= 0x13FU) || id == 0x6E0U;
        TEST_ASSERT_EQUAL(ours, model_bus_frame(&frame, false, false));
        (void)pass();
    }
}

/* The ECU's time is that of the frames' stamps, after 24 minutes, too. */
static void test_program_and_frames_have_one_clock(void)
{
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    for (int i = 0; i < 3600; i++) {
        model_wait_us(400000);
        (void)pass();
    }
    TEST_ASSERT_EQUAL_INT64(board_time_ns() / 1000, program_ecu()->now_us);
}

static void test_challenges_hold_the_generator_s_noise(void)
{
    int32_t value[2];
    for (int i = 0; i < 2; i++) {
        two_blocks();
        if (i == 1) {
            TEST_ASSERT_TRUE(board_start());
            (void)board_random();
            (void)board_random();
        }
        model_power_on();
        TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
        value[i] = open_session().parameter_reply_value;
    }
    TEST_ASSERT_TRUE(value[0] != value[1]);
}

static void test_first_store_cut_leaves_the_safe_state(void)
{
    sway_core_config_t config = good_config();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    const struct swaywatch_dbc_sway_parameter_reply_t opened = open_session();
    write_all(&config);
    model_cut_after = 3;
    TEST_ASSERT_EQUAL_UINT8(NOT_STORED, store(opened));
    model_power_on();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, program_ecu()->state);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_CRC, report().fault_cause);
}

static unsigned reports_in(int ms)
{
    unsigned count = 0;
    for (int i = 0; i < ms; i++) {
        sway_port_frame_t sent;
        model_wait_us(1000);
        (void)program_pass();
        while (model_bus_sent(&sent)) {
            count += sent.id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID;
        }
    }
    return count;
}

/* At once, and then every second as ever; after a restart, too. */
static void test_program_reports_bus_off(void)
{
    for (int start = 0; start < 2; start++) {
        two_blocks();
        TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
        TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
        model_bus_counters(256, 0);
        while (model_wants_interrupt()) {
            program_can_interrupt();
        }
        model_wait_us(RECOVERY_US);
        (void)program_pass();
        model_bus_counters(0, 0);
        TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BUS_OFF, report().fault_cause);
        TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, program_ecu()->state);
        TEST_ASSERT_UINT_WITHIN(1, 10, reports_in(10000));
    }
}

static void test_program_serves_the_watchdog_and_reports_it(void)
{
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    for (int i = 0; i < 100; i++) {
        model_wait_us(400000);
        (void)pass();
    }
    TEST_ASSERT_FALSE(model_watchdog_bit());
    model_wait_us(600000); // the program hangs
    TEST_ASSERT_TRUE(model_watchdog_bit());
    model_restart();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_EQUAL_UINT32(1, retained.restarts);
    TEST_ASSERT_EQUAL_UINT32(SWAY_ECU_WATCHDOG, retained.cause);
    TEST_ASSERT_EQUAL_HEX32(0, retained.address);
}

static void test_failed_checks_and_dead_parts_end_safe(void)
{
    two_blocks();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_IMAGE));
    const struct swaywatch_dbc_sway_fault_report_t said = report();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_SAFE, said.ecu_state);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_IMAGE, said.fault_cause);
    model_power_on();
    model_dead_crystal = true;
    TEST_ASSERT_FALSE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    model_power_on();
    model_dead_can = true;
    TEST_ASSERT_FALSE(program_start(&retained, SWAY_ECU_NO_CAUSE));
}

/* Up to the last double word of a page, and not beyond. */
static void test_flash_is_written_to_the_end_of_a_page(void)
{
    const uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    TEST_ASSERT_TRUE(board_start());
    TEST_ASSERT_TRUE(flash_erase(1));
    TEST_ASSERT_TRUE(flash_write(1, STM32_FLASH_PAGE - 8U, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, model_flash + 2U * STM32_FLASH_PAGE - 8U, sizeof bytes);
    TEST_ASSERT_FALSE(flash_write(1, STM32_FLASH_PAGE, bytes, sizeof bytes));
    TEST_ASSERT_FALSE(flash_write(1, STM32_FLASH_PAGE - 7U, bytes, 7));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_clock_is_168_mhz_and_counts_microseconds);
    RUN_TEST(test_clock_runs_on_over_its_32_bits);
    RUN_TEST(test_dead_clocks_are_found);
    RUN_TEST(test_dead_noise_is_no_number);
    RUN_TEST(test_restart_is_asked_of_the_processor);
    RUN_TEST(test_watchdog_wants_half_a_second);
    RUN_TEST(test_bit_timing);
    RUN_TEST(test_impossible_bit_rate_is_refused);
    RUN_TEST(test_dead_controller_is_found);
    RUN_TEST(test_start_takes_over_a_used_controller);
    RUN_TEST(test_one_filter_is_one);
    RUN_TEST(test_remote_and_long_frames_are_dropped_and_counted);
    RUN_TEST(test_lengths);
    RUN_TEST(test_interrupt_ends_on_a_bus_that_does_not);
    RUN_TEST(test_interrupt_is_wanted_for_what_is_handled);
    RUN_TEST(test_filters_take_what_is_ours);
    RUN_TEST(test_no_filters_take_all_standard_frames);
    RUN_TEST(test_frames_arrive_whole_and_in_order);
    RUN_TEST(test_lost_frames_are_counted);
    RUN_TEST(test_stamps_are_those_of_the_frames);
    RUN_TEST(test_sending_keeps_the_order_and_says_when_full);
    RUN_TEST(test_errors_are_counted_by_kind);
    RUN_TEST(test_error_counters_and_states);
    RUN_TEST(test_bus_off_waits_longer_each_time_until_a_frame_comes);
    RUN_TEST(test_bus_off_is_reported_once);
    RUN_TEST(test_bus_off_with_a_dead_controller_goes_on_trying);
    RUN_TEST(test_flash_erases_and_writes);
    RUN_TEST(test_flash_is_read_as_it_was_written);
    RUN_TEST(test_flash_says_what_it_cannot);
    RUN_TEST(test_program_takes_parameters_and_keeps_them);
    RUN_TEST(test_power_cut_at_every_step_of_two_stores);
    RUN_TEST(test_an_nmi_that_nobody_expects_is_a_fault);
    RUN_TEST(test_an_nmi_of_another_part_or_time_is_a_fault);
    RUN_TEST(test_torn_words_are_survived_anywhere);
    RUN_TEST(test_a_torn_or_missing_key_locks);
    RUN_TEST(test_after_too_many_faults_the_flash_is_not_read);
    RUN_TEST(test_any_byte_makes_a_key);
    RUN_TEST(test_program_listens_to_its_own_frames);
    RUN_TEST(test_program_and_frames_have_one_clock);
    RUN_TEST(test_challenges_hold_the_generator_s_noise);
    RUN_TEST(test_first_store_cut_leaves_the_safe_state);
    RUN_TEST(test_program_reports_bus_off);
    RUN_TEST(test_program_serves_the_watchdog_and_reports_it);
    RUN_TEST(test_failed_checks_and_dead_parts_end_safe);
    RUN_TEST(test_flash_is_written_to_the_end_of_a_page);
    return UNITY_END();
}

#include "program.h"

#include "board.h"
#include "flash.h"
#include "stm32g474.h"
#include "sway_store.h"

static sway_ecu_t ecu;
static can_t can;
static uint32_t bus_offs_told;
static uint8_t key[SWAY_SIPHASH_KEY];

#define KEY_PAGE 2U
#define TRAILER_PAGE 3U

const sway_ecu_t *program_ecu(void)
{
    return &ecu;
}

const can_t *program_can(void)
{
    return &can;
}

/* --- parameters: the first two pages of the second bank; the key is in the third, the trailer
 * remembered in the fourth and fifth ------------------------------------------------------------
 */

static bool store_read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    (void)context;
    return flash_read(slot, bytes, size);
}

/* An erased page is no key. */
static bool read_key(void)
{
    bool is_written = false;
    const bool is_read = flash_read(KEY_PAGE, key, sizeof key);
    for (size_t i = 0; i < sizeof key; i++) {
        is_written = is_written || key[i] != 0xFFU;
    }
    return is_read && is_written;
}

static bool store_erase(void *context, uint32_t slot)
{
    (void)context;
    return flash_erase(slot);
}

static bool store_write(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)context;
    return flash_write(slot, 0U, block, size);
}

static sway_store_t parameters(void)
{
    const sway_store_t store = {.size = SWAY_BLOCK_SIZE,
                                .check = sway_block_check,
                                .read = store_read,
                                .erase = store_erase,
                                .write = store_write};
    return store;
}

static bool trailer_read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    return store_read(context, TRAILER_PAGE + slot, bytes, size);
}

static bool trailer_erase(void *context, uint32_t slot)
{
    return store_erase(context, TRAILER_PAGE + slot);
}

static bool trailer_write(void *context, uint32_t slot, const uint8_t *record, size_t size)
{
    return store_write(context, TRAILER_PAGE + slot, record, size);
}

static sway_store_t trailer(void)
{
    const sway_store_t store = {.size = SWAY_REMEMBER_SIZE,
                                .check = sway_remember_check,
                                .read = trailer_read,
                                .erase = trailer_erase,
                                .write = trailer_write};
    return store;
}

/* --- the ECU's port --------------------------------------------------------------------------- */

static bool port_receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    return can_receive(&can, frame);
}

static bool port_send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    return can_send(&can, frame);
}

static int64_t port_time_us(void *context)
{
    (void)context;
    return board_time_ns() / 1000;
}

static bool port_store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    const sway_store_t store = parameters();
    return sway_store_write(&store, block, size);
}

static bool port_keep(void *context, const uint8_t *record, size_t size)
{
    (void)context;
    const sway_store_t store = trailer();
    return sway_store_write(&store, record, size);
}

static uint32_t port_random(void *context)
{
    (void)context;
    return board_random();
}

static void port_alive(void *context)
{
    (void)context;
    board_serve_watchdog();
}

/* --- start and loop --------------------------------------------------------------------------- */

static bool start_can(void)
{
    const can_config_t config = {
        .base = STM32_FDCAN1,
        .clock_hz = BOARD_HSE_HZ,
        .bit_rate = PROGRAM_BIT_RATE,
        .sample_point_milli = PROGRAM_SAMPLE_POINT_MILLI,
        .filter = {{.wanted = 0x120, .mask = 0x7E0}, {.wanted = 0x6E0, .mask = 0x7FF}},
        .filters = 2,
        .time_ns = board_time_ns};
    return can_start(&can, &config);
}

/* One that a power cut damaged is learnt again: no reason for a warning. */
static void recall_trailer(void)
{
    uint8_t record[SWAY_REMEMBER_SIZE];
    const sway_store_t store = trailer();
    (void)sway_store_find(&store, record);
    sway_ecu_remember(&ecu, port_keep, record, sizeof record);
}

bool program_start(sway_ecu_retained_t *retained, sway_ecu_cause_t check)
{
    const sway_store_t store = parameters();
    uint8_t block[SWAY_BLOCK_SIZE] = {0};
    bool interrupted = false;
    if (board_was_watchdog()) {
        sway_ecu_note_fault(retained, SWAY_ECU_WATCHDOG, 0U);
    }
    if (!board_start() || !start_can()) {
        return false;
    }
    bus_offs_told = 0U;
    const bool may_read = !sway_ecu_gave_up(retained);
    const sway_port_t port = {.receive = port_receive,
                              .send = port_send,
                              .time_us = port_time_us,
                              .store = port_store,
                              .alive = port_alive,
                              .random = port_random,
                              .key = may_read && read_key() ? key : NULL};
    if (may_read) {
        interrupted = sway_store_find(&store, block);
    }
    (void)sway_ecu_start(&ecu, &port, retained, block, sizeof block);
    if (may_read) {
        recall_trailer();
    }
    if (check != SWAY_ECU_NO_CAUSE) {
        sway_ecu_fail(&ecu, check);
    }
    if (interrupted) {
        sway_ecu_warn(&ecu, SWAY_ECU_STORE_CUT);
    }
    board_start_watchdog();
    board_enable_interrupts();
    return true;
}

bool program_pass(void)
{
    can_service(&can);
    if (can.counters.bus_offs != bus_offs_told && !can.bus_off) {
        bus_offs_told = can.counters.bus_offs;
        sway_ecu_warn(&ecu, SWAY_ECU_BUS_OFF);
    }
    return sway_ecu_poll(&ecu);
}

bool program_nmi(void)
{
    return flash_nmi();
}

void program_can_interrupt(void)
{
    can_interrupt(&can);
}

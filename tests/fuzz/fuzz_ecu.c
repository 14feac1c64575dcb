/* Fuzzer of the whole ECU: parameter requests with right CRC, sessions with right and wrong proofs,
 * speeds, flash that is damaged or cut, a bus without room, restarts. Whatever happens, an ECU that
 * runs has values in their ranges, and only a holder of the key has changed them. */
#include "fuzz.h"
#include "port_test.h"
#include "sway_store.h"

static uint8_t page[SWAY_STORE_SLOTS][SWAY_BLOCK_SIZE];
static int64_t now_us;
static bool no_room;
static int power_left;
static sway_port_frame_t inbox;
static bool has_frame;
static sway_ecu_t ecu;
static struct swaywatch_dbc_sway_parameter_reply_t opened;
static bool was_proved;

static bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    const bool is_there = has_frame;
    has_frame = false;
    *frame = inbox;
    return is_there;
}

static bool send_frame(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    require(frame->dlc == 8U && sway_e2e_check(frame->id, frame->data));
    if (!no_room && frame->id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID) {
        struct swaywatch_dbc_sway_parameter_reply_t reply;
        swaywatch_dbc_sway_parameter_reply_unpack(&reply, frame->data, 8);
        opened = ecu.access.is_open ? reply : opened;
    }
    return !no_room;
}

static int64_t time_us(void *context)
{
    (void)context;
    return now_us;
}

static bool power(void)
{
    power_left -= power_left > 0 ? 1 : 0;
    return power_left != 0;
}

static bool page_read(void *context, uint32_t slot, uint8_t *to, size_t size)
{
    (void)context;
    memcpy(to, page[slot], size);
    return page[slot][0] != 0xECU;
}

static bool page_erase(void *context, uint32_t slot)
{
    (void)context;
    memset(page[slot], power() ? 0xFF : 0xEC, sizeof page[slot]);
    return power_left != 0;
}

static bool page_write(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)context;
    for (size_t i = 0; i < size && power(); i++) {
        page[slot][i] &= block[i];
    }
    return power_left != 0;
}

static const sway_store_t flash = {.size = SWAY_BLOCK_SIZE,
                                   .check = sway_block_check,
                                   .read = page_read,
                                   .erase = page_erase,
                                   .write = page_write};

static bool store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    require(was_proved);
    return sway_store_write(&flash, block, size);
}

static const sway_port_t port = {
    .receive = receive, .send = send_frame, .time_us = time_us, .store = store, .key = test_key};

static void restart(sway_ecu_retained_t *retained)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    power_left = -1;
    (void)sway_store_find(&flash, block);
    require(sway_ecu_start(&ecu, &port, retained, block, sizeof block) == SWAY_OK);
}

static void check(const sway_core_config_t *before, bool may_change)
{
    if (ecu.state == SWAY_ECU_RUNNING) {
        require(sway_block_offender(sway_ecu_config(&ecu)) == SWAY_BLOCK_WORDS);
        require(may_change || memcmp(before, sway_ecu_config(&ecu), sizeof *before) == 0);
    }
    require(ecu.access.stores <= SWAY_ACCESS_STORES_MAX);
}

static void settle(void)
{
    for (int i = 0; sway_ecu_poll(&ecu); i++) {
        require(i < 100000);
    }
}

static void give(sway_port_frame_t frame)
{
    inbox = frame;
    inbox.time_us = now_us;
    has_frame = true;
    settle();
}

static void prove(uint8_t command)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
    was_proved = true;
    give(proof_frame(command, test_key, opened, block));
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static sway_ecu_retained_t retained;
    bytes_t from = {bytes, size};
    const sway_core_config_t config = good_config();
    uint8_t counter = 0;
    memset(page, 0xFF, sizeof page);
    memset(&retained, 0, sizeof retained);
    memset(&opened, 0, sizeof opened);
    now_us = 1000;
    no_room = has_frame = false;
    sway_block_write(&config, 1, page[0]);
    restart(&retained);
    while (from.left > 0U) {
        const uint32_t what = take(&from, 1);
        const sway_core_config_t before = *sway_ecu_config(&ecu);
        const bool was_safe = ecu.state == SWAY_ECU_SAFE;
        was_proved = false;
        now_us += (int64_t)(take(&from, 1) + 1U) * 100;
        switch (what % 8U) {
        case 0:
        case 1: /* any request: whoever has no key, has no proof either */
            give(request_frame((uint8_t)take(&from, 1), (uint16_t)take(&from, 1),
                               (int32_t)take(&from, 4)));
            break;
        case 2: { /* speed, standing more often than not */
            const uint32_t to = take(&from, 1);
            for (int i = 0; i < 25; i++) {
                sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
                frame.data[3] = to > 200U ? (uint8_t)to : 0U;
                sway_e2e_protect(frame.id, counter, frame.data);
                counter = sway_e2e_next(counter);
                now_us += 10000;
                give(frame);
            }
            break;
        }
        case 3:
            give(request_frame(OPEN, 0, 0));
            break;
        case 4:
            power_left = what & 0x80U ? (int)(what >> 3) * 20 + 1 : -1;
            prove(what & 8U ? STORE : APPLY);
            break;
        case 5: /* power goes */
            restart(&retained);
            continue;
        case 6:
            no_room = (what & 8U) != 0U;
            page[what >> 7][take(&from, 1) % SWAY_BLOCK_SIZE] ^= (uint8_t)(what & 16U);
            settle();
            break;
        default: /* the processor faults */
            sway_ecu_note_fault(&retained, what, what);
            retained.restarts = what & 8U ? 0U : retained.restarts;
            sway_ecu_note_fault(&retained, what, what);
            restart(&retained);
            continue;
        }
        check(&before, was_proved || was_safe);
    }
    return 0;
}

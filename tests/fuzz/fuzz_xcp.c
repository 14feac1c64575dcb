/* Fuzzer of the XCP slave before the ECU: any commands, addresses inside the memory that it shows
 * and just outside, sessions with right and wrong keys, DAQ lists, speeds, a bus without room.
 * Whatever happens, only a holder of the key changes a parameter, every parameter is in its range,
 * counters never go down and every poll ends. */
#include "fuzz.h"
#include "port_test.h"
#include "sway_xcp.h"

#define REQUEST 0x6E4
#define REPLY 0x6E5
#define ECU_AT 0x20000000U
#define WORKING_AT 0x30000000U

static int64_t now_us;
static bool no_room;
static sway_port_frame_t inbox;
static bool has_frame;
static sway_port_frame_t answer;
static bool has_answer;
static uint8_t counter;
static bool was_unlocked;
static sway_xcp_t xcp;
static sway_ecu_t ecu;

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
    if (frame->id == REPLY) {
        require(frame->dlc >= 1U && frame->dlc <= 8U);
        const bool is_answer = frame->data[0] >= 0xFEU;
        answer = is_answer && !no_room ? *frame : answer;
        has_answer = has_answer || (is_answer && !no_room);
    } else {
        require(frame->dlc == 8U && sway_e2e_check(frame->id, frame->data));
    }
    return !no_room;
}

static int64_t time_us(void *context)
{
    (void)context;
    return now_us;
}

static const sway_port_t board = {
    .receive = receive, .send = send_frame, .time_us = time_us, .key = test_key};

static void settle(void)
{
    for (int i = 0; sway_xcp_poll(&xcp) || has_frame; i++) {
        require(i < 100000);
    }
}

static void give(sway_port_frame_t frame)
{
    inbox = frame;
    inbox.time_us = now_us;
    has_frame = true;
    has_answer = false;
    settle();
}

static void command(const uint8_t *bytes, uint32_t size)
{
    sway_port_frame_t frame = {.id = REQUEST, .dlc = (uint8_t)size};
    memcpy(frame.data, bytes, size);
    give(frame);
}

/* Half a second of it, that it is known. */
static void speed(uint8_t high)
{
    for (int i = 0; i < 50; i++) {
        sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
        frame.data[3] = high;
        sway_e2e_protect(frame.id, counter, frame.data);
        counter = sway_e2e_next(counter);
        now_us += 10000;
        give(frame);
    }
}

/* With the key of the port, or with one bit of the answer wrong. */
static void unlock(bool right)
{
    static const uint8_t get_seed[] = {0xF8, 0, 1};
    uint8_t reply[8] = {0xF7, 6};
    uint8_t message[8] = {0, 0, 0, 0, 0, 0, 0xF7, 0};
    command(get_seed, sizeof get_seed);
    if (!has_answer || answer.data[0] != 0xFFU || answer.dlc != 8U) {
        return;
    }
    memcpy(message, answer.data + 2, 6);
    const uint64_t key = sway_siphash(test_key, message, sizeof message) ^ (right ? 0U : 1U);
    for (unsigned i = 0; i < 6U; i++) {
        reply[2U + i] = (uint8_t)(key >> (8U * i));
    }
    was_unlocked = was_unlocked || right;
    command(reply, sizeof reply);
    require(right || !has_answer || answer.data[0] == 0xFEU || !xcp.is_connected);
}

/* SET_MTA, SHORT_UPLOAD or WRITE_DAQ at an address in or about the memory of the A2L file. */
static void addressed(bytes_t *from)
{
    static const uint8_t code[4] = {0xF6, 0xF4, 0xE1, 0xE1};
    const uint32_t what = take(from, 1);
    const uint32_t base = (what & 4U) != 0U ? ECU_AT : WORKING_AT;
    const uint32_t reach = (what & 4U) != 0U ? (uint32_t)sizeof ecu : (uint32_t)sizeof xcp.working;
    const uint32_t size = what >> 4;
    uint32_t address = base + take(from, 3) % (reach + 16U) - 8U;
    address -= (what & 8U) != 0U ? address % 4U : 0U; // parameters are whole words
    uint8_t bytes[8] = {code[what & 3U], (uint8_t)((what & 3U) == 1U ? size : 0xFFU)};
    if ((what & 3U) >= 2U) {
        bytes[2] = (uint8_t)size;
    }
    memcpy(bytes + 4, &address, sizeof address);
    command(bytes, sizeof bytes);
}

/* A list of one frame, as a master makes it. */
static void start_list(uint8_t event)
{
    const uint8_t steps[][8] = {{0xD6},
                                {0xD5, 0, 1, 0},
                                {0xD4, 0, 0, 0, 1},
                                {0xD3, 0, 0, 0, 0, 1},
                                {0xE2, 0, 0, 0, 0, 0},
                                {0xE1, 0xFF, 4, 0, 0, 0, 0, 0x30},
                                {0xE0, 0, 0, 0, event, 0, 1, 0},
                                {0xDE, 1, 0, 0}};
    static const uint8_t size[] = {1, 4, 5, 6, 6, 8, 8, 4};
    for (unsigned i = 0; i < sizeof size; i++) {
        command(steps[i], size[i]);
    }
}

/* Word by word: whether they fit together is asked when the ECU is to run with them. */
static bool is_in_range(const sway_core_config_t *config)
{
    bool good = true;
    for (uint32_t word = 0; word < SWAY_BLOCK_WORDS; word++) {
        int32_t low = 0;
        int32_t high = 0;
        int32_t value = 0;
        bool may_be_zero = false;
        require(sway_block_range(word, &low, &high, &may_be_zero) == SWAY_OK &&
                sway_block_get(config, word, &value) == SWAY_OK);
        good = good && ((value >= low && value <= high) || (value == 0 && may_be_zero));
    }
    return good;
}

static void start(void)
{
    static sway_ecu_retained_t retained;
    const sway_xcp_config_t at = {REQUEST, REPLY, ECU_AT, WORKING_AT};
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&config, 1, block);
    memset(&retained, 0, sizeof retained);
    memset(&answer, 0, sizeof answer);
    now_us = 1000;
    no_room = has_frame = has_answer = was_unlocked = false;
    counter = 0;
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &at);
    require(sway_ecu_start(&ecu, &port, &retained, block, sizeof block) == SWAY_OK);
    sway_xcp_start(&xcp);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    bytes_t from = {bytes, size};
    start();
    while (from.left > 0U) {
        const sway_core_config_t used = *sway_ecu_config(&ecu);
        const sway_core_config_t working = xcp.working;
        const uint32_t refused = xcp.refused;
        const uint32_t what = take(&from, 1);
        uint8_t raw[8];
        now_us += (int64_t)(what >> 4) * 500;
        switch (what % 8U) {
        case 0:
        case 1: /* any command */
        case 2:
            raw[0] = (uint8_t)(0xC0U | take(&from, 1));
            for (unsigned i = 1; i < 8U; i++) {
                raw[i] = (uint8_t)take(&from, 1);
            }
            command(raw, 1U + (what >> 5));
            break;
        case 3:
            addressed(&from);
            break;
        case 4:
            unlock((what & 0xF0U) != 0U);
            break;
        case 5: /* standing more often than not */
            speed(what >= 0xC0U ? (uint8_t)take(&from, 1) : 0U);
            break;
        case 6: /* time passes: events of lists, silence of the master */
            for (uint32_t i = take(&from, 1); i > 0U; i--) {
                now_us += (what & 8U) != 0U ? 100000 : 1000;
                settle();
            }
            break;
        default:
            if ((what & 8U) != 0U) {
                start_list((uint8_t)(what >> 6));
            } else {
                no_room = (what & 16U) != 0U;
                raw[0] = 0xFF; // CONNECT
                raw[1] = 0;
                command(raw, 2U);
            }
            break;
        }
        require(xcp.refused >= refused);
        require(is_in_range(&xcp.working));
        require(sway_block_offender(sway_ecu_config(&ecu)) == SWAY_BLOCK_WORDS);
        require(was_unlocked || (memcmp(&working, &xcp.working, sizeof working) == 0 &&
                                 memcmp(&used, sway_ecu_config(&ecu), sizeof used) == 0));
    }
    return 0;
}

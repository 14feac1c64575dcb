/* port/xcp: sessions, locks, memory, pages, DAQ lists. What a master of others sees of it is in
 * tests/host/test_xcp.py and tests/hil/test_xcp.py. */
#include "port_test.h"
#include "sway_xcp.h"

#define REQUEST 0x6E4
#define REPLY 0x6E5
#define ECU_AT 0x20000000U
#define WORKING_AT 0x30000000U
#define SPEED_KNOWN_US 100000 // a frame of the speed comes at least every 100 ms

static sway_xcp_t xcp;
static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static sway_port_frame_t inbox;
static bool has_inbox;
static bool is_endless;
static bool no_room;
static sway_port_frame_t sent[512];
static unsigned sent_count;
static int64_t now_us;
static uint8_t speed_counter;

static bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    *frame = inbox;
    const bool was_there = has_inbox;
    has_inbox = is_endless;
    return was_there;
}

static bool send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (!no_room && sent_count < sizeof sent / sizeof sent[0]) {
        sent[sent_count++] = *frame;
    }
    return !no_room;
}

static int64_t time_us(void *context)
{
    (void)context;
    return now_us;
}

static void begin(const uint8_t *key)
{
    const sway_port_t board = {.receive = receive, .send = send, .time_us = time_us, .key = key};
    const sway_xcp_config_t at = {REQUEST, REPLY, ECU_AT, WORKING_AT};
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&config, 1, block);
    memset(&retained, 0, sizeof retained);
    has_inbox = is_endless = no_room = false;
    sent_count = 0;
    now_us = 0;
    speed_counter = 0;
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &at);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, block, sizeof block));
    sway_xcp_start(&xcp);
}

void setUp(void)
{
    begin(test_key);
}

void tearDown(void)
{
}

static void hand_over(sway_port_frame_t frame)
{
    now_us += 10000;
    frame.time_us = now_us;
    inbox = frame;
    has_inbox = true;
    for (int i = 0; i < 500 && (sway_xcp_poll(&xcp) || has_inbox); i++) {
    }
}

static void speed(uint16_t centi_kmh)
{
    sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_SPEED_FRAME_ID, .dlc = 8};
    frame.data[2] = (uint8_t)centi_kmh;
    frame.data[3] = (uint8_t)(centi_kmh >> 8);
    sway_e2e_protect(frame.id, speed_counter, frame.data);
    speed_counter = sway_e2e_next(speed_counter);
    hand_over(frame);
}

/* The slave's answer to a command; NULL: none. */
static const sway_port_frame_t *ask(unsigned size, const uint8_t *command)
{
    sway_port_frame_t frame = {.id = REQUEST, .dlc = (uint8_t)size};
    memcpy(frame.data, command, size);
    sent_count = 0;
    hand_over(frame);
    for (unsigned i = 0; i < sent_count; i++) {
        if (sent[i].id == REPLY && sent[i].data[0] >= 0xFEU) {
            return &sent[i];
        }
    }
    return NULL;
}

#define ASK(...) ask(sizeof((uint8_t[]){__VA_ARGS__}), (const uint8_t[]){__VA_ARGS__})
#define ADDRESS(a)                                                                                 \
    (uint8_t)(a), (uint8_t)((a) >> 8), (uint8_t)((a) >> 16), (uint8_t)((uint32_t)(a) >> 24)

#define GOOD(...)                                                                                  \
    do {                                                                                           \
        const sway_port_frame_t *answer_ = ASK(__VA_ARGS__);                                       \
        TEST_ASSERT_NOT_NULL(answer_);                                                             \
        TEST_ASSERT_EQUAL_HEX8(0xFF, answer_->data[0]);                                            \
    } while (0)
#define REFUSED(code, ...)                                                                         \
    do {                                                                                           \
        const sway_port_frame_t *answer_ = ASK(__VA_ARGS__);                                       \
        TEST_ASSERT_NOT_NULL(answer_);                                                             \
        TEST_ASSERT_EQUAL_HEX8(0xFE, answer_->data[0]);                                            \
        TEST_ASSERT_EQUAL_HEX8(code, answer_->data[1]);                                            \
        TEST_ASSERT_EQUAL_UINT8(2, answer_->dlc);                                                  \
    } while (0)
#define CONNECT() GOOD(0xFF, 0)

static void unlock(void)
{
    uint8_t command[8] = {0xF7, 6};
    uint8_t message[8] = {0, 0, 0, 0, 0, 0, 0xF7, 0};
    const sway_port_frame_t *seed = ASK(0xF8, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(6, seed->data[1]);
    TEST_ASSERT_EQUAL_UINT8(8, seed->dlc);
    memcpy(message, seed->data + 2, 6);
    const uint64_t key = sway_siphash(test_key, message, sizeof message);
    for (unsigned i = 0; i < 6; i++) {
        command[2 + i] = (uint8_t)(key >> (8U * i));
    }
    const sway_port_frame_t *told = ask(8, command);
    TEST_ASSERT_EQUAL_HEX8(0xFF, told->data[0]);
    TEST_ASSERT_EQUAL_HEX8(0, told->data[1]);
    TEST_ASSERT_EQUAL_UINT8(2, told->dlc);
}

/* --- sessions --------------------------------------------------------------------------------- */

static void test_it_is_silent_until_it_is_connected(void)
{
    TEST_ASSERT_NULL(ASK(0xFD));
    TEST_ASSERT_NULL(ASK(0xFC));
    const uint8_t resources = ASK(0xFF, 0)->data[1];
    TEST_ASSERT_EQUAL_HEX8(0x05, resources);
    GOOD(0xFD);
    GOOD(0xFE);
    TEST_ASSERT_NULL(ASK(0xFD));
}

static void test_commands_that_are_none(void)
{
    CONNECT();
    REFUSED(0x00, 0xFC);          // that is how SYNCH is answered
    REFUSED(0x20, 0xF9, 1, 0, 0); // nothing is stored
    REFUSED(0x20, 0xD2);          // nor programmed
    REFUSED(0x20, 0x00);
    REFUSED(0x21, 0xF6, 0, 0, 0); // too short
    REFUSED(0x21, 0xF0, 4, 1, 2); // shorter than it says
    REFUSED(0x22, 0xF8, 0, 2);    // no such resource
    TEST_ASSERT_NULL(ask(0, (const uint8_t *)""));
    TEST_ASSERT_EQUAL_UINT32(3, ecu.requests_refused);
}

/* A master that does not stop gets a few answers a call, and none of its commands is a frame of the
 * car's. */
static void test_commands_without_end_end(void)
{
    CONNECT();
    inbox = (sway_port_frame_t){.id = REQUEST, .dlc = 1, .data = {0xFD}};
    sent_count = 0;
    has_inbox = is_endless = true;
    const uint32_t before = ecu.frames_received;
    (void)sway_xcp_poll(&xcp);
    TEST_ASSERT_TRUE(sent_count > 0U && sent_count <= SWAY_XCP_FRAMES_MAX + 1U);
    TEST_ASSERT_EQUAL_UINT32(before, ecu.frames_received);
}

static void test_a_port_without_a_key_cannot_be_calibrated(void)
{
    begin(NULL);
    CONNECT();
    REFUSED(0x24, 0xF8, 0, 1);
    REFUSED(0x29, 0xF7, 6, 1, 2, 3, 4, 5, 6);
    REFUSED(0x25, 0xEB, 0x83, 0, 1);
    REFUSED(0x25, 0xE4, 0, 0, 0, 1);
    REFUSED(0x25, 0xF0, 4, 0, 0, 0, 0);
    GOOD(0xF8, 0, 4); // DAQ is not locked: a seed of no bytes
}

static void test_a_wrong_key_ends_the_connection_and_is_told(void)
{
    CONNECT();
    GOOD(0xF8, 0, 1);
    REFUSED(0x25, 0xF7, 6, 1, 2, 3, 4, 5, 6);
    TEST_ASSERT_EQUAL_UINT32(1, ecu.access.forged);
    unsigned told = 0;
    for (unsigned i = 0; i < sent_count; i++) {
        told += sent[i].id == SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID;
    }
    TEST_ASSERT_EQUAL_UINT(1, told);
    TEST_ASSERT_NULL(ASK(0xFD));
    CONNECT();
    REFUSED(0x29, 0xF7, 6, 1, 2, 3, 4, 5, 6); // a seed serves once
}

static void test_the_lock_closes_again_after_its_time(void)
{
    CONNECT();
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xF8, 0, 1)->data[1]); // open: no seed
    now_us += SWAY_ACCESS_SESSION_US;
    TEST_ASSERT_EQUAL_HEX8(0x01, ASK(0xFD)->data[2]);
    REFUSED(0x25, 0xEB, 0x02, 0, 1);
    unlock();
    CONNECT(); // locks, too
    REFUSED(0x25, 0xEB, 0x02, 0, 1);
}

static void test_what_it_says_of_itself(void)
{
    CONNECT();
    const uint8_t length = ASK(0xFA, 1)->data[4];
    TEST_ASSERT_EQUAL_UINT8(9, length);
    TEST_ASSERT_EQUAL_STRING_LEN("swaywat", &ASK(0xF5, 7)->data[1], 7);
    TEST_ASSERT_EQUAL_STRING_LEN("ch", &ASK(0xF5, 2)->data[1], 2);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xFA, 2)->data[4]); // no path
    TEST_ASSERT_EQUAL_UINT8(5, ASK(0xD7, 0, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_STRING_LEN("10 ms", &ASK(0xF5, 5)->data[1], 5);
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xD7, 0, 1, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("10 ms", &ASK(0xF5, 5)->data[1], 5);
    TEST_ASSERT_EQUAL_HEX8(0x93, ASK(0xDA)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x34, ASK(0xD9)->data[5]);
}

static unsigned stores;
static unsigned lives;

static bool store(void *context, const uint8_t *block, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    TEST_ASSERT_NOT_NULL(block);
    TEST_ASSERT_EQUAL_size_t(SWAY_BLOCK_SIZE, size);
    return ++stores == 1U;
}

static void alive(void *context)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    lives++;
}

static uint32_t noise(void *context)
{
    TEST_ASSERT_EQUAL_PTR(&stores, context);
    return 42U;
}

static void test_the_rest_of_the_port_is_passed_on(void)
{
    const sway_port_t board = {.receive = receive,
                               .send = send,
                               .time_us = time_us,
                               .store = store,
                               .alive = alive,
                               .random = noise,
                               .key = test_key,
                               .context = &stores};
    const uint8_t block[SWAY_BLOCK_SIZE] = {0};
    const sway_xcp_config_t at = xcp.config;
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &at);
    TEST_ASSERT_TRUE(port.store(port.context, block, sizeof block));
    TEST_ASSERT_FALSE(port.store(port.context, block, sizeof block));
    port.alive(port.context);
    TEST_ASSERT_EQUAL_UINT(1, lives);
    TEST_ASSERT_EQUAL_UINT32(42, port.random(port.context));
    TEST_ASSERT_EQUAL_PTR(test_key, port.key);
}

/* --- memory and pages ------------------------------------------------------------------------- */

static void test_memory_ends_where_the_ecu_ends(void)
{
    const uint32_t end = ECU_AT + (uint32_t)sizeof ecu;
    CONNECT();
    GOOD(0xF4, 4, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xF4, 1, 0, 0, ADDRESS(end - 1U));
    REFUSED(0x24, 0xF4, 2, 0, 0, ADDRESS(end - 1U));
    REFUSED(0x24, 0xF4, 1, 0, 0, ADDRESS(ECU_AT - 1U));
    REFUSED(0x24, 0xF4, 1, 0, 1, ADDRESS(200U)); // behind the texts
    REFUSED(0x24, 0xF4, 1, 0, 2, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF4, 0, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF4, 8, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF3, 0, 0, 0, ADDRESS(0U));
    REFUSED(0x24, 0xE1, 0xFF, 4, 0, ADDRESS(0U));
    REFUSED(0x22, 0xE1, 0xFF, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xE1, 0xFF, 8, 0, ADDRESS(ECU_AT));
    REFUSED(0x22, 0xF8, 1, 1); // a seed has one part
    REFUSED(0x22, 0xF3, 0, 0, 0, ADDRESS(0xFFFFFFFFU));
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    GOOD(0xF3, 0, 0, 0, ADDRESS(4U));
    GOOD(0xF6, 0, 0, 0, ADDRESS(end));
    REFUSED(0x24, 0xF3, 0, 0, 0, ADDRESS(4U));
}

static void write_mass(uint32_t grams, uint8_t wanted)
{
    const uint32_t at = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, vehicle.trailer.mass_g);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    const sway_port_frame_t *told = ASK(0xF0, 4, ADDRESS(grams));
    TEST_ASSERT_EQUAL_HEX8(wanted, told->data[0] == 0xFF ? 0xFF : told->data[1]);
}

static int32_t used_mass(void)
{
    return sway_ecu_config(&ecu)->vehicle.trailer.mass_g;
}

static void test_pages(void)
{
    CONNECT();
    unlock();
    write_mass(2000000, 0x23); // the master sees page 0
    GOOD(0xEB, 0x02, 0, 1);
    write_mass(49999, 0x22);
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 2U));
    REFUSED(0x22, 0xF0, 4, 0, 0, 0, 0); // half of two words
    GOOD(0xF6, 0, 0, 0, ADDRESS(ECU_AT));
    REFUSED(0x23, 0xF0, 4, 0, 0, 0, 0);
    write_mass(2000000, 0xFF);
    REFUSED(0x24, 0xEB, 0x01, 0, 1); // speed not known
    speed(0);
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL_INT32(2000000, used_mass());
    write_mass(2100000, 0x10); // busy: begun anew, the speed has not come yet
    now_us = xcp.changed_us + SPEED_KNOWN_US - 20001; // each command is 10 ms later
    write_mass(2100000, 0x10);
    now_us = xcp.changed_us + SPEED_KNOWN_US - 20000;
    write_mass(2100000, 0x24); // it has not come at all
    speed(0);
    write_mass(2100000, 0xFF);
    TEST_ASSERT_EQUAL_INT32(2100000, used_mass());
    speed(0);
    GOOD(0xE4, 0, 0, 0, 1); // the reference into the page that is used
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    speed(5000);
    write_mass(2000000, 0x10);
    now_us += 200000;
    speed(5000);
    write_mass(2000000, 0x24); // moves
    TEST_ASSERT_EQUAL_INT32(1880000, used_mass());
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 1, 0)->data[3]);
    REFUSED(0x24, 0xEB, 0x81, 0, 0);
}

static void test_pages_that_are_none(void)
{
    CONNECT();
    unlock();
    REFUSED(0x28, 0xEB, 0x02, 1, 0);
    REFUSED(0x26, 0xEB, 0x02, 0, 2);
    REFUSED(0x27, 0xEB, 0x00, 0, 1);
    REFUSED(0x28, 0xEA, 1, 1);
    REFUSED(0x27, 0xEA, 3, 0);
    speed(0);
    GOOD(0xE8, 0, 0, 1, 0);
    REFUSED(0x28, 0xE4, 1, 0, 0, 1);
    REFUSED(0x26, 0xE4, 0, 1, 0, 0); // page 0 is read only
    REFUSED(0x28, 0xE8, 0, 1, 0, 0);
    REFUSED(0x22, 0xE8, 0, 0, 2, 0);
    REFUSED(0x22, 0xE8, 2, 0, 0, 0);
    REFUSED(0x28, 0xE7, 0, 1, 0);
    REFUSED(0x26, 0xE7, 0, 0, 2);
    TEST_ASSERT_EQUAL_HEX8(0x0F, ASK(0xE7, 0, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x3F, ASK(0xE7, 0, 0, 1)->data[1]);
    TEST_ASSERT_EQUAL_UINT8(2, ASK(0xE8, 1, 0, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xE9)->data[1]);
}

static void test_a_page_without_a_vehicle_is_filled_word_by_word(void)
{
    const sway_core_config_t good = good_config();
    uint8_t nothing[SWAY_BLOCK_SIZE] = {0};
    const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &xcp.port, &xcp.config);
    const sway_port_t board = {
        .receive = receive, .send = send, .time_us = time_us, .key = test_key};
    xcp.port = board;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_ecu_start(&ecu, &port, &retained, nothing, sizeof nothing));
    xcp.config = (sway_xcp_config_t){REQUEST, REPLY, ECU_AT, WORKING_AT};
    sway_xcp_start(&xcp);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    CONNECT();
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    REFUSED(0x22, 0xEB, 0x01, 0, 1);
    for (uint32_t i = 0; i < SWAY_BLOCK_WORDS; i++) {
        int32_t value = 0;
        (void)sway_block_get(&good, i, &value);
        const uint32_t word = (uint32_t)value;
        GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 4U * i));
        GOOD(0xF0, 4, ADDRESS(word));
    }
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

static void test_what_the_parameter_frames_apply_is_the_new_reference(void)
{
    CONNECT();
    speed(0);
    sway_core_config_t other = good_config();
    other.vehicle.trailer.mass_g = 1700000;
    TEST_ASSERT_EQUAL(SWAY_ECU_CHANGED, sway_ecu_calibrate(&ecu, &other));
    GOOD(0xFD);
    TEST_ASSERT_EQUAL_INT32(1700000, xcp.reference.vehicle.trailer.mass_g);
    TEST_ASSERT_EQUAL_INT32(1700000, xcp.working.vehicle.trailer.mass_g);
}

/* --- DAQ -------------------------------------------------------------------------------------- */

/* One list of one entry: the ECU's count of frames received. */
static void allocate(void)
{
    const uint32_t at = ECU_AT + (uint32_t)offsetof(sway_ecu_t, frames_received);
    GOOD(0xD6);
    GOOD(0xD5, 0, 1, 0);
    GOOD(0xD4, 0, 0, 0, 1);
    GOOD(0xD3, 0, 0, 0, 0, 1);
    GOOD(0xE2, 0, 0, 0, 0, 0);
    GOOD(0xE1, 0xFF, 4, 0, ADDRESS(at));
}

static unsigned samples(void)
{
    unsigned count = 0;
    for (unsigned i = 0; i < sent_count; i++) {
        count += sent[i].id == REPLY && sent[i].data[0] == 0;
    }
    return count;
}

static void test_a_list_is_sampled_every_10_ms(void)
{
    CONNECT();
    allocate();
    REFUSED(0x22, 0xDF, 0, 1, 0);    // there is one list
    allocate();                      // the old ones are given back
    GOOD(0xE0, 0, 0, 0, 1, 0, 2, 0); // event 1, every second time
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xDE, 1, 0, 0)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x40, ASK(0xFD)->data[1]);
    TEST_ASSERT_EQUAL_HEX8(0x40, ASK(0xDF, 0, 0, 0)->data[1]);
    REFUSED(0x11, 0xE0, 0, 0, 0, 1, 0, 1, 0);
    sent_count = 0;
    for (int i = 0; i < 20; i++) {
        speed(0);
    }
    TEST_ASSERT_EQUAL_UINT(10, samples());
    GOOD(0xDE, 0, 0, 0);
    sent_count = 0;
    speed(0);
    TEST_ASSERT_EQUAL_UINT(0, samples());
}

static void test_selected_lists_start_together_with_time_stamps(void)
{
    CONNECT();
    allocate();
    REFUSED(0x27, 0xE0, 2, 0, 0, 1, 0, 1, 0); // no stimulation
    REFUSED(0x22, 0xE0, 0, 0, 0, 3, 0, 1, 0);
    GOOD(0xE0, 0x10, 0, 0, 2, 0, 1, 0);
    REFUSED(0x2A, 0xDE, 2, 0, 0); // 4 bytes of time and 4 are too many
    GOOD(0xE0, 0, 0, 0, 2, 0, 1, 0);
    GOOD(0xDE, 2, 0, 0);
    GOOD(0xDD, 1);
    sent_count = 0;
    for (int i = 0; i < 30; i++) {
        speed(0);
    }
    TEST_ASSERT_EQUAL_UINT(3, samples());
    GOOD(0xDE, 2, 0, 0);
    GOOD(0xDD, 2);
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&xcp.daq));
    GOOD(0xDD, 0);
    REFUSED(0x27, 0xDD, 3);
    REFUSED(0x27, 0xDE, 3, 0, 0);
    REFUSED(0x22, 0xDE, 1, 1, 0);
    GOOD(0xDC);
}

static void test_lists_are_made_in_order_and_within_their_memory(void)
{
    CONNECT();
    REFUSED(0x29, 0xD4, 0, 0, 0, 1);
    GOOD(0xD6);
    REFUSED(0x30, 0xD5, 0, (uint8_t)(SWAY_XCP_LISTS + 1U), 0);
    GOOD(0xD5, 0, 2, 0);
    REFUSED(0x29, 0xD5, 0, 2, 0);
    REFUSED(0x29, 0xD3, 0, 0, 0, 0, 1);
    REFUSED(0x22, 0xD4, 0, 2, 0, 1);
    REFUSED(0x30, 0xD4, 0, 0, 0, (uint8_t)(SWAY_XCP_ODTS + 1U));
    GOOD(0xD4, 0, 0, 0, 1);
    REFUSED(0x29, 0xD4, 0, 0, 0, 1);
    REFUSED(0x22, 0xD3, 0, 0, 0, 1, 1);
    REFUSED(0x30, 0xD3, 0, 0, 0, 0, (uint8_t)(SWAY_XCP_ENTRIES + 1U));
    GOOD(0xD3, 0, 0, 0, 0, 2);
    REFUSED(0x29, 0xD3, 0, 0, 0, 0, 2);
    REFUSED(0x29, 0xD4, 0, 1, 0, 1);
    REFUSED(0x29, 0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT)); // no pointer yet
    REFUSED(0x22, 0xE2, 0, 0, 0, 0, 2);
    REFUSED(0x22, 0xE2, 0, 1, 0, 0, 0);
    GOOD(0xE2, 0, 0, 0, 0, 1);
    REFUSED(0x22, 0xE1, 3, 1, 0, ADDRESS(ECU_AT)); // single bits
    REFUSED(0x24, 0xE1, 0xFF, 4, 0, ADDRESS(0U));
    GOOD(0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT));
    REFUSED(0x29, 0xE1, 0xFF, 4, 0, ADDRESS(ECU_AT));
    GOOD(0xE0, 0, 0, 0, 1, 0, 1, 0);
    REFUSED(0x2A, 0xDE, 1, 0, 0); // entry 0 was never written
    REFUSED(0x22, 0xE3, 0, 9, 0);
    GOOD(0xE3, 0, 0, 0);
    REFUSED(0x22, 0xDF, 0, 9, 0);
    REFUSED(0x22, 0xD7, 0, 3, 0);
}

static void test_samples_without_room_are_left_out_whole_and_told(void)
{
    CONNECT();
    allocate();
    GOOD(0xE0, 0, 0, 0, 1, 0, 1, 0);
    GOOD(0xDE, 1, 0, 0);
    no_room = true;
    for (unsigned i = 0; i < SWAY_XCP_QUEUE + 10U; i++) {
        speed(0);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(10, xcp.daq.left_out);
    no_room = false;
    sent_count = 0;
    speed(0);
    speed(0);
    bool is_told = false;
    for (unsigned i = 0; i < sent_count; i++) {
        is_told |= sent[i].id == REPLY && sent[i].data[0] == 0xFD && sent[i].data[1] == 0x06;
    }
    TEST_ASSERT_TRUE(is_told);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT(SWAY_XCP_QUEUE, samples());
    GOOD(0xFE); // ends it
    sent_count = 0;
    speed(0);
    TEST_ASSERT_EQUAL_UINT(0, samples());
}

static void test_an_answer_that_waits_is_sent_first(void)
{
    CONNECT();
    no_room = true;
    TEST_ASSERT_NULL(ASK(0xFD));
    TEST_ASSERT_NULL(ASK(0xDA)); // is not listened to: the master has to wait for its answer
    no_room = false;
    sent_count = 0;
    hand_over((sway_port_frame_t){.id = 0x7FF, .dlc = 1});
    TEST_ASSERT_EQUAL_UINT16(REPLY, sent[0].id);
    TEST_ASSERT_EQUAL_UINT8(6, sent[0].dlc); // of GET_STATUS
    GOOD(0xDA);
}

/* --- every answer, byte by byte -----------------------------------------------------------------
 */

static void expect_answer(unsigned size, const uint8_t *expected, const sway_port_frame_t *answer)
{
    TEST_ASSERT_NOT_NULL(answer);
    TEST_ASSERT_EQUAL_UINT8(size, answer->dlc);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, answer->data, size);
    TEST_ASSERT_EQUAL_INT64(now_us, answer->time_us);
}

static void test_answers_are_those_of_the_standard(void)
{
    static const struct {
        uint8_t size, command[8], length, answer[8];
    } cases[] = {
        {2, {0xFF, 0}, 8, {0xFF, 0x05, 0, 8, 8, 0, 1, 1}},
        {1, {0xFD}, 6, {0xFF, 0, 1}},
        {2, {0xFA, 1}, 8, {0xFF, 0, 0, 0, 9}},
        {2, {0xF5, 7}, 8, {0xFF, 's', 'w', 'a', 'y', 'w', 'a', 't'}},
        {2, {0xF5, 2}, 3, {0xFF, 'c', 'h'}},
        {2, {0xFA, 0}, 8, {0xFF, 0, 0, 0, 9}},
        {2, {0xF5, 1}, 2, {0xFF, 's'}},
        {1, {0xE9}, 3, {0xFF, 1}},
        {5, {0xE8, 0, 0, 0, 0}, 8, {0xFF, 0, 0, 0, ADDRESS(WORKING_AT)}},
        {5, {0xE8, 0, 0, 1, 0}, 8, {0xFF, 0, 0, 0, ADDRESS(sizeof(sway_core_config_t))}},
        {5, {0xE8, 1, 0, 0, 0}, 6, {0xFF, 2}},
        {4, {0xE7, 0, 0, 1}, 3, {0xFF, 0x3F}},
        {3, {0xEA, 1, 0}, 4, {0xFF}},
        {3, {0xEA, 2, 0}, 4, {0xFF}},
        {1, {0xDA}, 8, {0xFF, 0x93, 0, 0, SWAY_XCP_EVENTS}},
        {1, {0xD9}, 8, {0xFF, 1, 7, 1, 0, 0x34, 1}},
        {4, {0xD7, 0, 0, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 12, 0, 6}},
        {2, {0xF5, 7}, 8, {0xFF, 'n', 'e', 'w', ' ', 'e', 's', 't'}},
        {4, {0xD7, 0, 1, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 5, 10, 6}},
        {2, {0xF5, 5}, 6, {0xFF, '1', '0', ' ', 'm', 's'}},
        {4, {0xD7, 0, 2, 0}, 7, {0xFF, 0x84, SWAY_XCP_LISTS, 6, 100, 6}},
        {2, {0xF5, 6}, 7, {0xFF, '1', '0', '0', ' ', 'm', 's'}},
        {3, {0xF8, 0, 4}, 2, {0xFF}},
        {1, {0xD6}, 1, {0xFF}},
        {4, {0xD5, 0, 2, 0}, 1, {0xFF}},
        {1, {0xDA}, 8, {0xFF, 0x93, 2, 0, SWAY_XCP_EVENTS}},
        {5, {0xD4, 0, 0, 0, 2}, 1, {0xFF}},
        {5, {0xD4, 0, 1, 0, 1}, 1, {0xFF}},
        {6, {0xD3, 0, 1, 0, 0, 1}, 1, {0xFF}},
        {6, {0xE2, 0, 1, 0, 0, 0}, 1, {0xFF}},
        {8, {0xE1, 0xFF, 7, 0, ADDRESS(ECU_AT)}, 1, {0xFF}},
        {8, {0xE0, 0, 1, 0, 2, 0, 3, 0}, 1, {0xFF}},
        {4, {0xDF, 0, 1, 0}, 8, {0xFF, 0, 0, 0, 2, 0, 3}},
        {4, {0xDE, 1, 1, 0}, 2, {0xFF, 2}},
        {1, {0xFD}, 6, {0xFF, 0x40, 1}},
        {4, {0xDF, 0, 1, 0}, 8, {0xFF, 0x40, 0, 0, 2, 0, 3}},
        {2, {0xDD, 0}, 1, {0xFF}},
        {1, {0xFE}, 1, {0xFF}},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        expect_answer(cases[i].length, cases[i].answer, ask(cases[i].size, cases[i].command));
    }
    CONNECT();
    const sway_port_frame_t *clock = ASK(0xDC);
    const uint8_t told[8] = {0xFF, 0, 0, 0, ADDRESS(now_us)};
    expect_answer(8, told, clock);
}

/* Memory is what is there, a checksum its CRC-32, and each goes on where the last one ended. */
static void test_memory_is_what_is_there(void)
{
    uint8_t expected[8] = {0xFF};
    CONNECT();
    ecu.access.forged = 0x11223344U;
    const uint32_t at = ECU_AT + (uint32_t)offsetof(sway_ecu_t, access.forged);
    memcpy(expected + 1, &ecu.access.forged, 4);
    expect_answer(5, expected, ASK(0xF4, 4, 0, 0, ADDRESS(at)));
    const uint8_t *const page = (const uint8_t *)&xcp.reference;
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + 4U));
    const uint32_t crc = sway_block_crc32(0, page + 4, 8);
    const uint8_t sum[8] = {0xFF, 9, 0, 0, ADDRESS(crc)};
    expect_answer(8, sum, ASK(0xF3, 0, 0, 0, ADDRESS(8U)));
    memcpy(expected + 1, page + 12, 4);
    expect_answer(5, expected, ASK(0xF5, 4));
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT));
    GOOD(0xF3, 0, 0, 0, ADDRESS(sizeof(sway_core_config_t)));
    REFUSED(0x24, 0xF4, 1, 0, 1, ADDRESS(32U)); // right behind the texts
    GOOD(0xF4, 1, 0, 1, ADDRESS(31U));
}

static void test_words_are_downloaded_one_after_the_other(void)
{
    const uint32_t at = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, alarm.critical_time_ms);
    CONNECT();
    REFUSED(0x25, 0xF0, 1, 0);
    unlock();
    GOOD(0xEB, 0x02, 0, 1);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    GOOD(0xF0, 4, ADDRESS(2500U));
    GOOD(0xF0, 4, ADDRESS(1500U));
    TEST_ASSERT_EQUAL_INT32(2500, xcp.working.alarm.critical_time_ms);
    TEST_ASSERT_EQUAL_INT32(1500, xcp.working.alarm.hold_ms);
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    REFUSED(0x22, 0xF0, 2, 0, 0);
    REFUSED(0x22, 0xF0, 2, 0xC4, 0x09); // half a word, whose number is in range
    REFUSED(0x22, 0xF0, 4, ADDRESS(0U));
    GOOD(0xF0, 4, ADDRESS(500U)); // the limits themselves are taken
    GOOD(0xF6, 0, 0, 0, ADDRESS(at));
    GOOD(0xF0, 4, ADDRESS(20000U));
    const uint32_t period = WORKING_AT + (uint32_t)offsetof(sway_core_config_t, input_period_us);
    GOOD(0xF6, 0, 0, 0, ADDRESS(period));
    REFUSED(0x22, 0xF0, 4, ADDRESS(999U));
    GOOD(0xF0, 4, ADDRESS(0U)); // of any rate
    GOOD(0xF6, 0, 0, 0, ADDRESS(WORKING_AT + sizeof(sway_core_config_t)));
    REFUSED(0x23, 0xF0, 4, 0, 0, 0, 0);
}

static void test_each_page_is_set_by_itself(void)
{
    CONNECT();
    unlock();
    speed(0);
    GOOD(0xEB, 0x01, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 2, 0)->data[3]);
    speed(0);
    GOOD(0xEB, 0x01, 0, 0);
    GOOD(0xEB, 0x02, 0, 1);
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 1, 0)->data[3]);
    TEST_ASSERT_EQUAL_UINT8(1, ASK(0xEA, 2, 0)->data[3]);
    REFUSED(0x26, 0xE4, 0, 1, 0, 1);
    REFUSED(0x26, 0xE4, 0, 0, 0, 0);
    CONNECT(); // the master sees what the ECU uses
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 2, 0)->data[3]);
}

/* To the microsecond; and a seed of before a connection opens nothing. */
static void test_a_lock_is_open_for_its_time(void)
{
    CONNECT();
    unlock();
    const int64_t end_us = xcp.unlocked_us + SWAY_ACCESS_SESSION_US;
    now_us = end_us - 10001;
    TEST_ASSERT_EQUAL_HEX8(0, ASK(0xFD)->data[2]);
    now_us = end_us - 10000;
    TEST_ASSERT_EQUAL_HEX8(1, ASK(0xFD)->data[2]);
    GOOD(0xF8, 0, 1);
    TEST_ASSERT_TRUE(xcp.access.is_open);
    GOOD(0xFE);
    CONNECT();
    REFUSED(0x29, 0xF7, 6);
    const uint32_t refused = xcp.refused;
    REFUSED(0x20, 0x00);
    TEST_ASSERT_EQUAL_UINT32(refused + 1U, xcp.refused);
}

static void test_the_reference_is_what_the_ecu_runs_with(void)
{
    memset(&xcp, 0xA5, sizeof xcp);
    begin(test_key);
    TEST_ASSERT_NULL(ASK(0xFD)); // not connected
    ecu.staged.alarm.hold_ms = 9999;
    sway_xcp_start(&xcp);
    TEST_ASSERT_EQUAL_INT32(sway_ecu_config(&ecu)->alarm.hold_ms, xcp.reference.alarm.hold_ms);
    CONNECT();
    unlock();
    speed(0);
    GOOD(0xEB, 0x01, 0, 1);
    speed(0);
    sway_core_config_t other = good_config();
    other.vehicle.trailer.mass_g = 1700000;
    TEST_ASSERT_EQUAL(SWAY_ECU_CHANGED, sway_ecu_calibrate(&ecu, &other));
    TEST_ASSERT_EQUAL_UINT8(0, ASK(0xEA, 1, 0)->data[3]);
}

/* --- DAQ lists by themselves ------------------------------------------------------------------ */

static sway_xcp_daq_t daq;
static const uint8_t bytes[] = {10, 11, 12, 13, 14, 15, 16, 17, 18, 19};

static void expect_packet(unsigned size, const uint8_t *expected)
{
    const sway_xcp_packet_t *const packet = sway_xcp_daq_next(&daq);
    TEST_ASSERT_NOT_NULL(packet);
    TEST_ASSERT_EQUAL_UINT8(size, packet->size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, packet->data, size);
    sway_xcp_daq_sent(&daq);
}

#define PACKET(...) expect_packet(sizeof((uint8_t[]){__VA_ARGS__}), (const uint8_t[]){__VA_ARGS__})
#define OK(call) TEST_ASSERT_EQUAL(SWAY_XCP_OK, call)

static void enter(uint32_t list, uint32_t odt, uint32_t entry, const uint8_t *from, uint32_t size)
{
    OK(sway_xcp_daq_point(&daq, list, odt, entry));
    OK(sway_xcp_daq_write(&daq, from, size));
}

static void sent_all(void)
{
    while (daq.queue_length > 0U) {
        sway_xcp_daq_sent(&daq);
    }
}

/* List 0: two ODTs, of two entries and one; list 1: one of two. */
static void two_lists(void)
{
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, 2));
    OK(sway_xcp_daq_odts(&daq, 0, 2));
    OK(sway_xcp_daq_odts(&daq, 1, 1));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 2));
    OK(sway_xcp_daq_entries(&daq, 0, 1, 1));
    OK(sway_xcp_daq_entries(&daq, 1, 0, 2));
    enter(0, 0, 0, bytes, 1);
    OK(sway_xcp_daq_write(&daq, bytes + 2, 2)); // the pointer goes on
    enter(0, 1, 0, bytes + 4, 3);
    enter(1, 0, 0, bytes + 7, 1);
    enter(1, 0, 1, bytes + 8, 2);
}

static void test_samples_hold_what_was_entered(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_mode(&daq, 1, SWAY_XCP_MODE_TIMESTAMP, 2, 1));
    OK(sway_xcp_daq_start(&daq, 1, 0));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    TEST_ASSERT_TRUE(sway_xcp_daq_is_running(&daq));
    sway_xcp_daq_sample(&daq, 0, 0x01020304);
    PACKET(0, 10, 12, 13);
    PACKET(1, 14, 15, 16);
    PACKET(2, 4, 3, 2, 1, 17, 18, 19);
    TEST_ASSERT_NULL(sway_xcp_daq_next(&daq));
    OK(sway_xcp_daq_start(&daq, 0, 0));
    TEST_ASSERT_TRUE(sway_xcp_daq_is_running(&daq)); // the second one
    OK(sway_xcp_daq_start(&daq, 0, 1));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq));
}

/* Every 10 ms, whatever the steps of the clock; anew after a pause and where it is set back. */
static void test_events_come_by_the_clock(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 1, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    static const int64_t times_us[][2] = {
        /* now, sampled */
        {5000, 1},  {9999, 0},   {10000, 1},  {14999, 0},  {18000, 0},  {26000, 1},
        {29999, 0}, {30000, 1},  {90000, 1},  {99999, 0},  {100000, 1}, {50000, 1},
        {59999, 0}, {60000, 1},  {60001, 0},  {70000, 1},  {89999, 1},  {90001, 1},
        {99999, 0}, {100000, 1}, {120000, 1}, {120001, 0}, {129999, 0}, {130000, 1}};
    for (unsigned i = 0; i < sizeof times_us / sizeof times_us[0]; i++) {
        sway_xcp_daq_sample(&daq, 0, times_us[i][0]);
        char text[20];
        (void)snprintf(text, sizeof text, "%d us", (int)times_us[i][0]);
        TEST_ASSERT_EQUAL_MESSAGE(times_us[i][1], daq.queue_length, text);
        sent_all();
    }
}

static void test_an_event_of_100_ms_and_a_list_that_is_stopped(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    OK(sway_xcp_daq_mode(&daq, 1, 0, 2, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    for (int64_t i = 0; i < 100; i++) { // more events than a countdown has numbers
        for (int64_t part = 0; part < 10; part++) {
            sway_xcp_daq_sample(&daq, 0, i * 100000 + part * 10000);
            TEST_ASSERT_EQUAL_UINT32(part == 0, daq.queue_length);
            sent_all();
        }
    }
}

static void test_every_odt_of_a_list_is_asked(void)
{
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    enter(0, 1, 0, bytes, 8);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0));
    enter(0, 1, 0, bytes, 7);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, 1));
    OK(sway_xcp_daq_odts(&daq, 0, 1));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 1));
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // nothing entered
}

static void test_an_estimate_is_an_event_when_it_is_new(void)
{
    static const uint32_t numbers[][2] = {{0, 0}, {1, 1}, {1, 0}, {2, 1}, {0, 0}, {1, 1}};
    two_lists();
    OK(sway_xcp_daq_mode(&daq, 1, 0, SWAY_XCP_EVENT_ESTIMATE, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    for (unsigned i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        sway_xcp_daq_sample(&daq, numbers[i][0], 1000 * (int64_t)i);
        TEST_ASSERT_EQUAL_UINT32(numbers[i][1], daq.queue_length);
        sent_all();
    }
    daq.left_out = 7;
    sway_xcp_daq_free(&daq); // neither what was lost nor which estimate was the last is forgotten
    TEST_ASSERT_EQUAL_UINT32(7, daq.left_out);
    TEST_ASSERT_EQUAL_UINT32(1, daq.sequence);
}

/* Up to the last list, ODT, entry and byte, and not one more. */
static void test_all_of_the_memory_can_be_used(void)
{
    memset(&daq, 0, sizeof daq);
    sway_xcp_daq_free(&daq);
    OK(sway_xcp_daq_lists(&daq, SWAY_XCP_LISTS));
    OK(sway_xcp_daq_odts(&daq, 0, 3));
    TEST_ASSERT_EQUAL(SWAY_XCP_NO_MEMORY, sway_xcp_daq_odts(&daq, 1, SWAY_XCP_ODTS - 2U));
    OK(sway_xcp_daq_odts(&daq, 1, SWAY_XCP_ODTS - 3U));
    OK(sway_xcp_daq_entries(&daq, 0, 0, 3));
    OK(sway_xcp_daq_entries(&daq, 0, 2, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_NO_MEMORY, sway_xcp_daq_entries(&daq, 1, 0, SWAY_XCP_ENTRIES - 3U));
    OK(sway_xcp_daq_entries(&daq, 1, 0, SWAY_XCP_ENTRIES - 4U));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_point(&daq, SWAY_XCP_LISTS, 0, 0));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_point(&daq, 0, 3, 0));
    TEST_ASSERT_EQUAL(SWAY_XCP_RANGE, sway_xcp_daq_mode(&daq, SWAY_XCP_LISTS, 0, 1, 1));
    enter(0, 2, 0, bytes, 7);
    enter(0, 0, 0, bytes, 3);
    enter(0, 0, 1, bytes, 2);
    OK(sway_xcp_daq_mode(&daq, 0, 0, 1, 1));
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // one is missing
    enter(0, 0, 2, bytes, 3);
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // a byte too many
    enter(0, 0, 2, bytes, 2);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    sway_xcp_daq_sample(&daq, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(3, daq.queue_length);
    OK(sway_xcp_daq_synch(&daq, 0));
    two_lists();
    TEST_ASSERT_EQUAL(SWAY_XCP_DAQ_CONFIG, sway_xcp_daq_start(&daq, 1, 0)); // no prescaler
}

static void test_the_queue_keeps_its_order_and_tells_what_it_lost(void)
{
    uint8_t number = 0;
    two_lists();
    enter(1, 0, 0, &number, 1);
    OK(sway_xcp_daq_mode(&daq, 1, 0, 1, 1));
    OK(sway_xcp_daq_start(&daq, 1, 1));
    int64_t now = 0;
    for (unsigned i = 0; i < 3U * SWAY_XCP_QUEUE; i++, now += 10000) {
        number = (uint8_t)i;
        sway_xcp_daq_sample(&daq, 0, now);
        if (i >= 5U) {
            PACKET(2, (uint8_t)(i - 5U), 18, 19);
        }
    }
    for (unsigned i = 0; i < SWAY_XCP_QUEUE - 5U; i++, now += 10000) {
        sway_xcp_daq_sample(&daq, 0, now);
    }
    TEST_ASSERT_EQUAL_UINT32(SWAY_XCP_QUEUE, daq.queue_length);
    TEST_ASSERT_EQUAL_UINT32(0, daq.left_out);
    sway_xcp_daq_sample(&daq, 0, now);
    TEST_ASSERT_EQUAL_UINT32(1, daq.left_out);
    OK(sway_xcp_daq_start(&daq, 0, 1));
    sway_xcp_daq_sent(&daq);
    sway_xcp_daq_sample(&daq, 0, now); // told once
    TEST_ASSERT_EQUAL_UINT32(SWAY_XCP_QUEUE, daq.queue_length);
    sway_xcp_daq_sent(&daq);
    sway_xcp_daq_sample(&daq, 0, now);
    for (unsigned i = 0; i < SWAY_XCP_QUEUE - 2U; i++) {
        sway_xcp_daq_sent(&daq);
    }
    PACKET(0xFD, 0x06);
    TEST_ASSERT_NULL(sway_xcp_daq_next(&daq));
}

static void test_selected_lists_and_no_others_are_started_and_stopped(void)
{
    two_lists();
    for (uint32_t list = 0; list < 2U; list++) {
        OK(sway_xcp_daq_mode(&daq, list, 0, 1, 1));
    }
    OK(sway_xcp_daq_start(&daq, 2, 1));
    OK(sway_xcp_daq_synch(&daq, 1));
    TEST_ASSERT_FALSE((daq.list[0].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    TEST_ASSERT_TRUE((daq.list[1].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    OK(sway_xcp_daq_start(&daq, 1, 0));
    OK(sway_xcp_daq_start(&daq, 2, 1));
    OK(sway_xcp_daq_synch(&daq, 2));
    TEST_ASSERT_TRUE((daq.list[0].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    TEST_ASSERT_FALSE((daq.list[1].mode & SWAY_XCP_MODE_RUNNING) != 0U);
    OK(sway_xcp_daq_start(&daq, 1, 1));
    OK(sway_xcp_daq_synch(&daq, 0));
    TEST_ASSERT_FALSE(sway_xcp_daq_is_running(&daq));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_is_silent_until_it_is_connected);
    RUN_TEST(test_commands_that_are_none);
    RUN_TEST(test_commands_without_end_end);
    RUN_TEST(test_a_port_without_a_key_cannot_be_calibrated);
    RUN_TEST(test_a_wrong_key_ends_the_connection_and_is_told);
    RUN_TEST(test_the_lock_closes_again_after_its_time);
    RUN_TEST(test_what_it_says_of_itself);
    RUN_TEST(test_the_rest_of_the_port_is_passed_on);
    RUN_TEST(test_memory_ends_where_the_ecu_ends);
    RUN_TEST(test_pages);
    RUN_TEST(test_pages_that_are_none);
    RUN_TEST(test_a_page_without_a_vehicle_is_filled_word_by_word);
    RUN_TEST(test_what_the_parameter_frames_apply_is_the_new_reference);
    RUN_TEST(test_a_list_is_sampled_every_10_ms);
    RUN_TEST(test_selected_lists_start_together_with_time_stamps);
    RUN_TEST(test_lists_are_made_in_order_and_within_their_memory);
    RUN_TEST(test_samples_without_room_are_left_out_whole_and_told);
    RUN_TEST(test_an_answer_that_waits_is_sent_first);
    RUN_TEST(test_answers_are_those_of_the_standard);
    RUN_TEST(test_memory_is_what_is_there);
    RUN_TEST(test_words_are_downloaded_one_after_the_other);
    RUN_TEST(test_each_page_is_set_by_itself);
    RUN_TEST(test_a_lock_is_open_for_its_time);
    RUN_TEST(test_the_reference_is_what_the_ecu_runs_with);
    RUN_TEST(test_samples_hold_what_was_entered);
    RUN_TEST(test_events_come_by_the_clock);
    RUN_TEST(test_an_event_of_100_ms_and_a_list_that_is_stopped);
    RUN_TEST(test_every_odt_of_a_list_is_asked);
    RUN_TEST(test_an_estimate_is_an_event_when_it_is_new);
    RUN_TEST(test_all_of_the_memory_can_be_used);
    RUN_TEST(test_the_queue_keeps_its_order_and_tells_what_it_lost);
    RUN_TEST(test_selected_lists_and_no_others_are_started_and_stopped);
    return UNITY_END();
}

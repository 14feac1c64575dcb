#include "sway_xcp.h"

#include <string.h>

#define VERSION 0x01U ///< of protocol and transport layer: 1.x
#define RESOURCE_CALIBRATION 0x01U
#define RESOURCE_DAQ 0x04U
#define SESSION_DAQ_RUNNING 0x40U
#define UNLOCK 0xF7U
#define CTO 8U
#define WORD 4U
#define DYNAMIC_WITH_STAMPS 0x11U // lists made by the master, time stamps
#define OVERLOAD_BY_EVENT 0x80U
#define STAMPS_1_US 0x34U // 4 bytes, steps of a microsecond
#define UNIT_1_MS 6U
#define CRC_32 0x09U
#define PAGE_ECU 0x01U
#define PAGE_XCP 0x02U
#define PAGE_ALL 0x80U
#define MEMORY_TEXTS 1U
#define SPEED_KNOWN_US 100000

/* What can be uploaded by extension 1; places and lengths in `texts`. */
static const char texts[] = "swaywatch"
                            "new estimate"
                            "10 ms"
                            "100 ms";
#define TEXT_NAME 0U
#define TEXT_NAME_SIZE 9U
typedef struct {
    uint8_t at;
    uint8_t size;
    uint8_t period_ms;
} event_t;
static const event_t event_of[SWAY_XCP_EVENTS] = {{9, 12, 0}, {21, 5, 10}, {26, 6, 100}};

/* Frames are as long as their last value: the bytes behind a command are 0. */
typedef struct {
    const uint8_t *in;
    uint8_t *out; ///< 0xFF first, zeros
    uint8_t size; ///< of the answer
} exchange_t;

/* --- numbers in the processor's byte order ---------------------------------------------------- */

static uint32_t get16(const uint8_t *from)
{
    uint16_t value;
    (void)memcpy(&value, from, sizeof value);
    return value;
}

static uint32_t get32(const uint8_t *from)
{
    uint32_t value;
    (void)memcpy(&value, from, sizeof value);
    return value;
}

static void put16(uint8_t *to, uint32_t value)
{
    const uint16_t half = (uint16_t)value;
    (void)memcpy(to, &half, sizeof half);
}

static void put32(uint8_t *to, uint32_t value)
{
    (void)memcpy(to, &value, sizeof value);
}

static bool is_big_endian(void)
{
    static const uint8_t one[2] = {0U, 1U};
    return get16(one) == 1U;
}

/* --- memory ----------------------------------------------------------------------------------- */

static bool is_inside(uint32_t address, uint32_t size, uint32_t first, size_t length)
{
    const uint32_t offset = address - first;
    return address >= first && offset <= length && size <= length - offset;
}

static const uint8_t *page(const sway_xcp_t *xcp, uint8_t number)
{
    return (const uint8_t *)(number == (uint8_t)SWAY_XCP_PAGE_WORKING ? &xcp->working
                                                                      : &xcp->reference);
}

const uint8_t *sway_xcp_memory(const sway_xcp_t *xcp, uint8_t extension, uint32_t address,
                               uint32_t size)
{
    if (extension == MEMORY_TEXTS) {
        return is_inside(address, size, 0U, sizeof texts - 1U) ? (const uint8_t *)&texts[address]
                                                               : NULL;
    }
    const sway_xcp_config_t *const at = &xcp->config;
    if (extension != 0U) {
        return NULL;
    }
    if (is_inside(address, size, at->working_address, sizeof xcp->working)) {
        return page(xcp, xcp->xcp_page) + (address - at->working_address);
    }
    return is_inside(address, size, at->ecu_address, sizeof *xcp->ecu)
               ? (const uint8_t *)xcp->ecu + (address - at->ecu_address)
               : NULL;
}

/* --- session ---------------------------------------------------------------------------------- */

static void forget(sway_xcp_t *xcp)
{
    sway_xcp_daq_free(&xcp->daq);
    xcp->is_connected = false;
    xcp->is_unlocked = false;
    xcp->access.is_open = false;
}

static bool is_unlocked(const sway_xcp_t *xcp)
{
    return xcp->is_unlocked && xcp->ecu->now_us - xcp->unlocked_us < SWAY_ACCESS_SESSION_US;
}

/* What the parameter frames applied meanwhile is the new reference. */
static void follow(sway_xcp_t *xcp)
{
    const sway_core_config_t *const used = sway_ecu_config(xcp->ecu);
    if (memcmp(used, page(xcp, xcp->ecu_page), sizeof *used) != 0 &&
        xcp->ecu->state == SWAY_ECU_RUNNING) {
        sway_xcp_start(xcp);
    }
}

static sway_xcp_result_t connect(sway_xcp_t *xcp, exchange_t *x)
{
    forget(xcp);
    xcp->is_connected = true;
    xcp->xcp_page = xcp->ecu_page;
    x->out[1] = RESOURCE_CALIBRATION | RESOURCE_DAQ;
    x->out[2] = is_big_endian() ? 1U : 0U;
    x->out[3] = CTO;
    put16(&x->out[4], CTO);
    x->out[6] = VERSION;
    x->out[7] = VERSION;
    x->size = 8U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t disconnect(sway_xcp_t *xcp, exchange_t *x)
{
    (void)x;
    forget(xcp);
    return SWAY_XCP_OK;
}

static uint8_t protection(const sway_xcp_t *xcp)
{
    return (uint8_t)(is_unlocked(xcp) ? 0U : RESOURCE_CALIBRATION);
}

static sway_xcp_result_t get_status(sway_xcp_t *xcp, exchange_t *x)
{
    x->out[1] = sway_xcp_daq_is_running(&xcp->daq) ? SESSION_DAQ_RUNNING : 0U;
    x->out[2] = protection(xcp);
    x->size = 6U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t synchronise(sway_xcp_t *xcp, exchange_t *x)
{
    (void)xcp;
    (void)x;
    return SWAY_XCP_SYNCH;
}

static sway_xcp_result_t get_id(sway_xcp_t *xcp, exchange_t *x)
{
    x->size = 8U;
    if (x->in[1] <= 1U) { // text, name of the A2L file; of others there is none
        xcp->memory = MEMORY_TEXTS;
        xcp->address = TEXT_NAME;
        put32(&x->out[4], TEXT_NAME_SIZE);
    }
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_seed(sway_xcp_t *xcp, exchange_t *x)
{
    const sway_port_t *const port = &xcp->port;
    x->size = 2U;
    if (x->in[1] != 0U || x->in[2] != RESOURCE_CALIBRATION) {
        return x->in[2] == RESOURCE_DAQ ? SWAY_XCP_OK : SWAY_XCP_RANGE; // DAQ: no seed, not locked
    }
    if (is_unlocked(xcp)) {
        return SWAY_XCP_OK;
    }
    if (port->key == NULL) {
        return SWAY_XCP_DENIED;
    }
    sway_access_open(&xcp->access, port->key, xcp->ecu->now_us, xcp->ecu->block_sequence,
                     port->random == NULL ? xcp->refused : port->random(port->context));
    x->out[1] = (uint8_t)SWAY_ACCESS_PROOF;
    (void)memcpy(&x->out[2], xcp->access.challenge, SWAY_ACCESS_PROOF);
    x->size = 8U;
    return SWAY_XCP_OK;
}

/* A wrong key ends the connection, as the standard wants it. */
static sway_xcp_result_t unlock(sway_xcp_t *xcp, exchange_t *x)
{
    sway_access_message_t message = {.command = UNLOCK};
    if (!sway_access_is_open(&xcp->access, xcp->ecu->now_us)) {
        return SWAY_XCP_SEQUENCE;
    }
    if (x->in[1] != SWAY_ACCESS_PROOF ||
        !sway_access_close(&xcp->access, xcp->port.key, &message, SWAY_ACCESS_HEAD, &x->in[2])) {
        xcp->ecu->access.forged++;
        forget(xcp);
        return SWAY_XCP_LOCKED;
    }
    xcp->is_unlocked = true;
    xcp->unlocked_us = xcp->ecu->now_us;
    x->size = 2U; // and a protection of 0: nothing is locked any more
    return SWAY_XCP_OK;
}

/* --- memory transfer -------------------------------------------------------------------------- */

static sway_xcp_result_t set_address(sway_xcp_t *xcp, exchange_t *x)
{
    xcp->memory = x->in[3];
    xcp->address = get32(&x->in[4]);
    return SWAY_XCP_OK;
}

static sway_xcp_result_t upload(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t size = x->in[1];
    const uint8_t *const from = sway_xcp_memory(xcp, xcp->memory, xcp->address, size);
    if (size == 0U || size >= CTO) {
        return SWAY_XCP_RANGE;
    }
    if (from == NULL) {
        return SWAY_XCP_DENIED;
    }
    (void)memcpy(&x->out[1], from, size);
    xcp->address += size;
    x->size = (uint8_t)(1U + size);
    return SWAY_XCP_OK;
}

static sway_xcp_result_t short_upload(sway_xcp_t *xcp, exchange_t *x)
{
    (void)set_address(xcp, x);
    return upload(xcp, x);
}

/* Of the parameters: whether a page is the one that the master knows. */
static sway_xcp_result_t build_checksum(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t size = get32(&x->in[4]);
    const uint8_t *const from = sway_xcp_memory(xcp, xcp->memory, xcp->address, size);
    if (size == 0U || size > sizeof xcp->working) {
        return SWAY_XCP_RANGE;
    }
    if (from == NULL) {
        return SWAY_XCP_DENIED;
    }
    x->out[1] = CRC_32;
    put32(&x->out[4], sway_block_crc32(0U, from, size));
    xcp->address += size;
    x->size = 8U;
    return SWAY_XCP_OK;
}

/* --- calibration ------------------------------------------------------------------------------ */

/* Having begun anew, the ECU does not know its speed until the next frame: then the master shall
 * ask again. */
static sway_xcp_result_t calibrate(sway_xcp_t *xcp, const sway_core_config_t *wanted)
{
    const bool is_anew = xcp->has_changed && xcp->ecu->now_us - xcp->changed_us < SPEED_KNOWN_US;
    switch (sway_ecu_calibrate(xcp->ecu, wanted)) {
    case SWAY_ECU_CHANGED:
        xcp->has_changed = true;
        xcp->changed_us = xcp->ecu->now_us;
        return SWAY_XCP_OK;
    case SWAY_ECU_OUT_OF_RANGE:
        return SWAY_XCP_RANGE;
    default:
        return is_anew ? SWAY_XCP_BUSY : SWAY_XCP_DENIED;
    }
}

/* By itself: whether the words fit together is asked when the ECU is to run with them. */
static bool is_in_range(const sway_core_config_t *wanted, uint32_t word)
{
    int32_t low = 0;
    int32_t high = 0;
    int32_t value = 0;
    bool may_be_zero = false;
    return sway_block_range(word, &low, &high, &may_be_zero) == SWAY_OK &&
           sway_block_get(wanted, word, &value) == SWAY_OK &&
           ((value >= low && value <= high) || (value == 0 && may_be_zero));
}

static sway_xcp_result_t download(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t at = xcp->address - xcp->config.working_address;
    if (!is_unlocked(xcp)) {
        return SWAY_XCP_LOCKED;
    }
    if (xcp->memory != 0U || at >= sizeof xcp->working) {
        return SWAY_XCP_WRITE_PROTECTED;
    }
    if (x->in[1] != WORD || at % WORD != 0U) {
        return SWAY_XCP_RANGE; // half a word has no range
    }
    if (xcp->xcp_page != (uint8_t)SWAY_XCP_PAGE_WORKING) {
        return SWAY_XCP_WRITE_PROTECTED;
    }
    sway_core_config_t wanted = xcp->working;
    (void)memcpy((uint8_t *)&wanted + at, &x->in[2], WORD);
    if (!is_in_range(&wanted, at / WORD)) {
        return SWAY_XCP_RANGE;
    }
    if (xcp->ecu_page == (uint8_t)SWAY_XCP_PAGE_WORKING) {
        const sway_xcp_result_t result = calibrate(xcp, &wanted);
        if (result != SWAY_XCP_OK) {
            return result;
        }
    }
    xcp->working = wanted;
    xcp->address += WORD;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t set_page(sway_xcp_t *xcp, exchange_t *x)
{
    const uint8_t mode = x->in[1];
    const uint8_t wanted = x->in[3];
    if (x->in[2] != 0U && (mode & PAGE_ALL) == 0U) {
        return SWAY_XCP_NO_SEGMENT;
    }
    if (wanted >= (uint8_t)SWAY_XCP_PAGES) {
        return SWAY_XCP_NO_PAGE;
    }
    if ((mode & (PAGE_ECU | PAGE_XCP)) == 0U) {
        return SWAY_XCP_NO_MODE;
    }
    if (!is_unlocked(xcp)) {
        return SWAY_XCP_LOCKED;
    }
    if ((mode & PAGE_ECU) != 0U && wanted != xcp->ecu_page) {
        const sway_xcp_result_t result = calibrate(
            xcp, wanted == (uint8_t)SWAY_XCP_PAGE_WORKING ? &xcp->working : &xcp->reference);
        if (result != SWAY_XCP_OK) {
            return result;
        }
        xcp->ecu_page = wanted;
    }
    if ((mode & PAGE_XCP) != 0U) {
        xcp->xcp_page = wanted;
    }
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_page(sway_xcp_t *xcp, exchange_t *x)
{
    x->size = 4U;
    if (x->in[2] != 0U) {
        return SWAY_XCP_NO_SEGMENT;
    }
    if (x->in[1] != PAGE_ECU && x->in[1] != PAGE_XCP) {
        return SWAY_XCP_NO_MODE;
    }
    x->out[3] = x->in[1] == PAGE_ECU ? xcp->ecu_page : xcp->xcp_page;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t copy_page(sway_xcp_t *xcp, exchange_t *x)
{
    if (x->in[1] != 0U || x->in[3] != 0U) {
        return SWAY_XCP_NO_SEGMENT;
    }
    if (x->in[2] != (uint8_t)SWAY_XCP_PAGE_REFERENCE ||
        x->in[4] != (uint8_t)SWAY_XCP_PAGE_WORKING) {
        return SWAY_XCP_NO_PAGE;
    }
    if (!is_unlocked(xcp)) {
        return SWAY_XCP_LOCKED;
    }
    if (xcp->ecu_page == (uint8_t)SWAY_XCP_PAGE_WORKING) {
        const sway_xcp_result_t result = calibrate(xcp, &xcp->reference);
        if (result != SWAY_XCP_OK) {
            return result;
        }
    }
    xcp->working = xcp->reference;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_paging(sway_xcp_t *xcp, exchange_t *x)
{
    (void)xcp;
    x->out[1] = 1U; // one segment, which cannot be frozen
    x->size = 3U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_segment(sway_xcp_t *xcp, exchange_t *x)
{
    x->size = 8U;
    if (x->in[2] != 0U) {
        return SWAY_XCP_NO_SEGMENT;
    }
    if (x->in[1] == 0U) {
        put32(&x->out[4],
              x->in[3] == 0U ? xcp->config.working_address : (uint32_t)sizeof xcp->working);
        return x->in[3] <= 1U ? SWAY_XCP_OK : SWAY_XCP_RANGE;
    }
    if (x->in[1] == 1U) {
        x->out[1] = (uint8_t)SWAY_XCP_PAGES;
        x->size = 6U;
        return SWAY_XCP_OK;
    }
    return SWAY_XCP_RANGE; // no mappings
}

static sway_xcp_result_t get_page_info(sway_xcp_t *xcp, exchange_t *x)
{
    (void)xcp;
    x->size = 3U;
    if (x->in[2] != 0U) {
        return SWAY_XCP_NO_SEGMENT;
    }
    if (x->in[3] >= (uint8_t)SWAY_XCP_PAGES) {
        return SWAY_XCP_NO_PAGE;
    }
    x->out[1] = x->in[3] == (uint8_t)SWAY_XCP_PAGE_WORKING ? 0x3FU : 0x0FU; // all may; not written
    return SWAY_XCP_OK;
}

/* --- DAQ -------------------------------------------------------------------------------------- */

static sway_xcp_result_t clear_list(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_start(&xcp->daq, 0U, get16(&x->in[2]));
}

static sway_xcp_result_t set_pointer(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_point(&xcp->daq, get16(&x->in[2]), x->in[4], x->in[5]);
}

static sway_xcp_result_t write_entry(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t size = x->in[2];
    const uint8_t *const from = sway_xcp_memory(xcp, x->in[3], get32(&x->in[4]), size);
    if (x->in[1] != 0xFFU || size == 0U || size > SWAY_XCP_ODT_BYTES) {
        return SWAY_XCP_RANGE; // no single bits
    }
    return from == NULL ? SWAY_XCP_DENIED : sway_xcp_daq_write(&xcp->daq, from, size);
}

static sway_xcp_result_t set_list_mode(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_mode(&xcp->daq, get16(&x->in[2]), x->in[1], get16(&x->in[4]), x->in[6]);
}

static sway_xcp_result_t get_list_mode(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t list = get16(&x->in[2]);
    if (list >= xcp->daq.lists) {
        return SWAY_XCP_RANGE;
    }
    x->out[1] = xcp->daq.list[list].mode;
    put16(&x->out[4], xcp->daq.list[list].event);
    x->out[6] = xcp->daq.list[list].prescaler;
    x->size = 8U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t start_list(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t list = get16(&x->in[2]);
    const sway_xcp_result_t result = sway_xcp_daq_start(&xcp->daq, x->in[1], list);
    if (result == SWAY_XCP_OK) {
        x->out[1] = xcp->daq.list[list].first;
        x->size = 2U;
    }
    return result;
}

static sway_xcp_result_t start_selected(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_synch(&xcp->daq, x->in[1]);
}

static sway_xcp_result_t get_clock(sway_xcp_t *xcp, exchange_t *x)
{
    put32(&x->out[4], (uint32_t)xcp->ecu->now_us);
    x->size = 8U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_daq_info(sway_xcp_t *xcp, exchange_t *x)
{
    x->out[1] = DYNAMIC_WITH_STAMPS | OVERLOAD_BY_EVENT | 0x02U; // prescaler
    put16(&x->out[2], xcp->daq.lists);
    put16(&x->out[4], (uint32_t)SWAY_XCP_EVENTS);
    x->size = 8U; // no list of its own; frames begin with their absolute number
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_resolution(sway_xcp_t *xcp, exchange_t *x)
{
    (void)xcp;
    x->out[1] = 1U;
    x->out[2] = (uint8_t)SWAY_XCP_ODT_BYTES;
    x->out[3] = 1U;
    x->out[5] = STAMPS_1_US;
    put16(&x->out[6], 1U);
    x->size = 8U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t get_event(sway_xcp_t *xcp, exchange_t *x)
{
    const uint32_t event = get16(&x->in[2]);
    if (event >= (uint32_t)SWAY_XCP_EVENTS) {
        return SWAY_XCP_RANGE;
    }
    xcp->memory = MEMORY_TEXTS;
    xcp->address = event_of[event].at;
    x->out[1] = 0x84U; // for DAQ; all lists of an event are of one moment
    x->out[2] = (uint8_t)SWAY_XCP_LISTS;
    x->out[3] = event_of[event].size;
    x->out[4] = event_of[event].period_ms;
    x->out[5] = UNIT_1_MS;
    x->size = 7U;
    return SWAY_XCP_OK;
}

static sway_xcp_result_t free_lists(sway_xcp_t *xcp, exchange_t *x)
{
    (void)x;
    sway_xcp_daq_free(&xcp->daq);
    return SWAY_XCP_OK;
}

static sway_xcp_result_t allocate_lists(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_lists(&xcp->daq, get16(&x->in[2]));
}

static sway_xcp_result_t allocate_odts(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_odts(&xcp->daq, get16(&x->in[2]), x->in[4]);
}

static sway_xcp_result_t allocate_entries(sway_xcp_t *xcp, exchange_t *x)
{
    return sway_xcp_daq_entries(&xcp->daq, get16(&x->in[2]), x->in[4], x->in[5]);
}

/* --- commands --------------------------------------------------------------------------------- */

typedef struct {
    uint8_t code;
    uint8_t size; ///< of the command, at least
    sway_xcp_result_t (*obey)(sway_xcp_t *xcp, exchange_t *x);
} command_t;

static const command_t commands[] = {
    {0xFF, 2, connect},        {0xFE, 1, disconnect},     {0xFD, 1, get_status},
    {0xFC, 1, synchronise},    {0xFA, 2, get_id},         {0xF8, 3, get_seed},
    {UNLOCK, 2, unlock},       {0xF6, 8, set_address},    {0xF5, 2, upload},
    {0xF4, 8, short_upload},   {0xF3, 8, build_checksum}, {0xF0, 3, download},
    {0xEB, 4, set_page},       {0xEA, 3, get_page},       {0xE9, 1, get_paging},
    {0xE8, 5, get_segment},    {0xE7, 4, get_page_info},  {0xE4, 5, copy_page},
    {0xE3, 4, clear_list},     {0xE2, 6, set_pointer},    {0xE1, 8, write_entry},
    {0xE0, 8, set_list_mode},  {0xDF, 4, get_list_mode},  {0xDE, 4, start_list},
    {0xDD, 2, start_selected}, {0xDC, 1, get_clock},      {0xDA, 1, get_daq_info},
    {0xD9, 1, get_resolution}, {0xD7, 4, get_event},      {0xD6, 1, free_lists},
    {0xD5, 4, allocate_lists}, {0xD4, 5, allocate_odts},  {0xD3, 6, allocate_entries},
};

static const command_t *find(uint8_t code)
{
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        if (commands[i].code == code) {
            return &commands[i];
        }
    }
    return NULL;
}

static sway_xcp_result_t obey(sway_xcp_t *xcp, const sway_port_frame_t *frame, exchange_t *x)
{
    const command_t *const command = find(frame->data[0]);
    if (command == NULL) {
        return SWAY_XCP_UNKNOWN;
    }
    /* A download says itself how long it is. */
    const bool is_whole = frame->dlc >= command->size &&
                          (command->obey != download || frame->dlc >= 2U + frame->data[1]);
    return is_whole ? command->obey(xcp, x) : SWAY_XCP_SYNTAX;
}

static void answer(sway_xcp_t *xcp, const sway_port_frame_t *frame)
{
    uint8_t in[CTO] = {0};
    (void)memcpy(in, frame->data, frame->dlc < CTO ? frame->dlc : CTO);
    if (frame->dlc == 0U || xcp->reply_waits || (!xcp->is_connected && in[0] != 0xFFU)) {
        return; // as long as it is not connected the slave is silent
    }
    sway_port_frame_t *const reply = &xcp->reply;
    (void)memset(reply, 0, sizeof *reply);
    exchange_t x = {.in = in, .out = reply->data, .size = 1U};
    xcp->ecu->now_us = frame->time_us > xcp->ecu->now_us ? frame->time_us : xcp->ecu->now_us;
    follow(xcp);
    const sway_xcp_result_t result = obey(xcp, frame, &x);
    if (result != SWAY_XCP_OK) {
        (void)memset(reply->data, 0, sizeof reply->data);
        reply->data[0] = 0xFEU;
        reply->data[1] = (uint8_t)result;
        x.size = 2U;
        xcp->refused++;
        if (result != SWAY_XCP_SYNCH && result != SWAY_XCP_UNKNOWN && result != SWAY_XCP_BUSY) {
            sway_ecu_refuse(xcp->ecu);
        }
    } else {
        reply->data[0] = 0xFFU;
    }
    reply->dlc = x.size;
    xcp->reply_waits = true;
}

/* --- between port and ECU --------------------------------------------------------------------- */

static bool put(sway_xcp_t *xcp, sway_port_frame_t *frame)
{
    frame->id = xcp->config.reply_id;
    frame->time_us = xcp->ecu->now_us;
    return xcp->port.send(xcp->port.context, frame);
}

static bool flush(sway_xcp_t *xcp)
{
    if (xcp->reply_waits) {
        xcp->reply_waits = !put(xcp, &xcp->reply);
    }
    const sway_xcp_packet_t *packet = sway_xcp_daq_next(&xcp->daq);
    while (packet != NULL && !xcp->reply_waits) {
        sway_port_frame_t frame = {.dlc = packet->size};
        (void)memcpy(frame.data, packet->data, sizeof frame.data);
        if (!put(xcp, &frame)) {
            return false;
        }
        sway_xcp_daq_sent(&xcp->daq);
        packet = sway_xcp_daq_next(&xcp->daq);
    }
    return !xcp->reply_waits;
}

static bool receive(void *context, sway_port_frame_t *frame)
{
    sway_xcp_t *const xcp = context;
    for (uint32_t i = 0; i < SWAY_XCP_FRAMES_MAX; i++) {
        if (!xcp->port.receive(xcp->port.context, frame)) {
            return false;
        }
        if (frame->id != xcp->config.request_id) {
            return true;
        }
        answer(xcp, frame);
        (void)flush(xcp);
    }
    return false;
}

static bool pass_on(void *context, const sway_port_frame_t *frame)
{
    sway_xcp_t *const xcp = context;
    return xcp->port.send(xcp->port.context, frame);
}

static int64_t time_us(void *context)
{
    const sway_xcp_t *const xcp = context;
    return xcp->port.time_us(xcp->port.context);
}

static bool store(void *context, const uint8_t *block, size_t size)
{
    const sway_xcp_t *const xcp = context;
    return xcp->port.store(xcp->port.context, block, size);
}

static void alive(void *context)
{
    const sway_xcp_t *const xcp = context;
    xcp->port.alive(xcp->port.context);
}

static uint32_t noise(void *context)
{
    const sway_xcp_t *const xcp = context;
    return xcp->port.random(xcp->port.context);
}

sway_port_t sway_xcp_attach(sway_xcp_t *xcp, sway_ecu_t *ecu, const sway_port_t *below,
                            const sway_xcp_config_t *config)
{
    (void)memset(xcp, 0, sizeof *xcp);
    xcp->ecu = ecu;
    xcp->port = *below;
    xcp->config = *config;
    const sway_port_t port = {.receive = receive,
                              .send = pass_on,
                              .time_us = time_us,
                              .store = below->store == NULL ? NULL : store,
                              .alive = below->alive == NULL ? NULL : alive,
                              .random = below->random == NULL ? NULL : noise,
                              .key = below->key,
                              .context = xcp};
    return port;
}

void sway_xcp_start(sway_xcp_t *xcp)
{
    xcp->reference =
        xcp->ecu->state == SWAY_ECU_RUNNING ? *sway_ecu_config(xcp->ecu) : xcp->ecu->staged;
    xcp->working = xcp->reference;
    xcp->ecu_page = (uint8_t)SWAY_XCP_PAGE_REFERENCE;
}

bool sway_xcp_poll(sway_xcp_t *xcp)
{
    const bool did = sway_ecu_poll(xcp->ecu);
    sway_xcp_daq_sample(&xcp->daq, sway_core_status(&xcp->ecu->node.core)->sequence,
                        xcp->ecu->now_us);
    (void)flush(xcp);
    return did;
}

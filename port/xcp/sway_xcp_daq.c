#include "sway_xcp_daq.h"

#include <string.h>

#define EVENT_PACKET 0xFDU
#define EV_DAQ_OVERLOAD 0x06U
#define TIMESTAMP_BYTES 4U

/* What may be allocated next. */
#define STEP_LISTS 1U
#define STEP_ODTS 2U
#define STEP_ENTRIES 3U
/* Modes of starting a list, and all that are selected. */
#define LIST_STOP 0U
#define LIST_START 1U
#define LIST_SELECT 2U
#define ALL_STOP 0U
#define SELECTED_START 1U
#define SELECTED_STOP 2U

static const int64_t period_us[SWAY_XCP_EVENTS] = {0, 10000, 100000};

void sway_xcp_daq_free(sway_xcp_daq_t *daq)
{
    const uint32_t left_out = daq->left_out;
    const uint32_t sequence = daq->sequence;
    (void)memset(daq, 0, sizeof *daq);
    daq->left_out = left_out;
    daq->sequence = sequence;
    daq->step = STEP_LISTS;
}

/* --- allocation ------------------------------------------------------------------------------- */

static bool may_allocate(const sway_xcp_daq_t *daq, uint8_t step)
{
    return daq->step == step || daq->step + 1U == step;
}

sway_xcp_result_t sway_xcp_daq_lists(sway_xcp_daq_t *daq, uint32_t count)
{
    if (daq->step != STEP_LISTS || daq->lists != 0U) {
        return SWAY_XCP_SEQUENCE;
    }
    if (count > SWAY_XCP_LISTS) {
        return SWAY_XCP_NO_MEMORY;
    }
    daq->lists = (uint8_t)count;
    return SWAY_XCP_OK;
}

sway_xcp_result_t sway_xcp_daq_odts(sway_xcp_daq_t *daq, uint32_t list, uint32_t count)
{
    if (!may_allocate(daq, STEP_ODTS) || daq->lists == 0U) {
        return SWAY_XCP_SEQUENCE;
    }
    if (list >= daq->lists) {
        return SWAY_XCP_RANGE;
    }
    if (daq->list[list].odts != 0U) {
        return SWAY_XCP_SEQUENCE;
    }
    if (count > SWAY_XCP_ODTS - (uint32_t)daq->odts) {
        return SWAY_XCP_NO_MEMORY;
    }
    daq->step = STEP_ODTS;
    daq->list[list].first = daq->odts;
    daq->list[list].odts = (uint8_t)count;
    daq->odts = (uint8_t)(daq->odts + count);
    return SWAY_XCP_OK;
}

/* The ODT of a list, NULL where there is none. */
static sway_xcp_odt_t *odt_of(sway_xcp_daq_t *daq, uint32_t list, uint32_t odt)
{
    if (list >= daq->lists || odt >= daq->list[list].odts) {
        return NULL;
    }
    return &daq->odt_of[daq->list[list].first + odt];
}

sway_xcp_result_t sway_xcp_daq_entries(sway_xcp_daq_t *daq, uint32_t list, uint32_t odt,
                                       uint32_t count)
{
    if (!may_allocate(daq, STEP_ENTRIES)) {
        return SWAY_XCP_SEQUENCE;
    }
    sway_xcp_odt_t *const at = odt_of(daq, list, odt);
    if (at == NULL) {
        return SWAY_XCP_RANGE;
    }
    if ((daq->list[list].mode & SWAY_XCP_MODE_RUNNING) != 0U) {
        return SWAY_XCP_BUSY_DAQ; // it would send entries that nobody wrote
    }
    if (at->entries != 0U) {
        return SWAY_XCP_SEQUENCE;
    }
    if (count > SWAY_XCP_ENTRIES - (uint32_t)daq->entries) {
        return SWAY_XCP_NO_MEMORY;
    }
    daq->step = STEP_ENTRIES;
    at->first = daq->entries;
    at->entries = (uint8_t)count;
    daq->entries = (uint8_t)(daq->entries + count);
    return SWAY_XCP_OK;
}

/* --- configuration ---------------------------------------------------------------------------- */

bool sway_xcp_daq_is_running(const sway_xcp_daq_t *daq)
{
    for (uint32_t i = 0; i < daq->lists; i++) {
        if ((daq->list[i].mode & SWAY_XCP_MODE_RUNNING) != 0U) {
            return true;
        }
    }
    return false;
}

sway_xcp_result_t sway_xcp_daq_point(sway_xcp_daq_t *daq, uint32_t list, uint32_t odt,
                                     uint32_t entry)
{
    const sway_xcp_odt_t *const at = odt_of(daq, list, odt);
    if (at == NULL || entry >= at->entries) {
        return SWAY_XCP_RANGE;
    }
    daq->has_pointer = true;
    daq->odt = (uint8_t)(daq->list[list].first + odt);
    daq->entry = (uint8_t)entry;
    return SWAY_XCP_OK;
}

sway_xcp_result_t sway_xcp_daq_write(sway_xcp_daq_t *daq, const uint8_t *from, uint32_t size)
{
    if (!daq->has_pointer || daq->entry >= daq->odt_of[daq->odt].entries) {
        return SWAY_XCP_SEQUENCE;
    }
    if (sway_xcp_daq_is_running(daq)) {
        return SWAY_XCP_BUSY_DAQ;
    }
    sway_xcp_entry_t *const entry = &daq->entry_of[daq->odt_of[daq->odt].first + daq->entry];
    entry->from = from;
    entry->size = (uint8_t)size;
    daq->entry++;
    return SWAY_XCP_OK;
}

sway_xcp_result_t sway_xcp_daq_mode(sway_xcp_daq_t *daq, uint32_t list, uint32_t mode,
                                    uint32_t event, uint32_t prescaler)
{
    if (list >= daq->lists || event >= (uint32_t)SWAY_XCP_EVENTS || prescaler == 0U) {
        return SWAY_XCP_RANGE;
    }
    if ((mode & ~(uint32_t)SWAY_XCP_MODE_TIMESTAMP) != 0U) {
        return SWAY_XCP_NO_MODE; // stimulation, frames without numbers
    }
    sway_xcp_list_t *const l = &daq->list[list];
    if ((l->mode & SWAY_XCP_MODE_RUNNING) != 0U) {
        return SWAY_XCP_BUSY_DAQ;
    }
    l->mode = (uint8_t)mode;
    l->event = (uint8_t)event;
    l->prescaler = (uint8_t)prescaler;
    return SWAY_XCP_OK;
}

/* --- starting --------------------------------------------------------------------------------- */

static uint32_t room(const sway_xcp_list_t *list, uint32_t odt)
{
    const bool stamped = odt == 0U && (list->mode & SWAY_XCP_MODE_TIMESTAMP) != 0U;
    return SWAY_XCP_ODT_BYTES - (stamped ? TIMESTAMP_BYTES : 0U);
}

/* Every entry was written, and each ODT fits into its frame. */
static bool is_whole(const sway_xcp_daq_t *daq, const sway_xcp_list_t *list)
{
    for (uint32_t i = 0; i < list->odts; i++) {
        const sway_xcp_odt_t *const odt = &daq->odt_of[list->first + i];
        uint32_t size = 0;
        for (uint32_t k = 0; k < odt->entries; k++) {
            const sway_xcp_entry_t *const entry = &daq->entry_of[odt->first + k];
            size += entry->from == NULL ? SWAY_XCP_ODT_BYTES + 1U : entry->size;
        }
        if (size > room(list, i)) {
            return false;
        }
    }
    return list->odts != 0U && list->prescaler != 0U;
}

static bool is_selected(const sway_xcp_list_t *list)
{
    return (list->mode & SWAY_XCP_MODE_SELECTED) != 0U;
}

static void run(sway_xcp_list_t *list)
{
    list->mode |= SWAY_XCP_MODE_RUNNING;
    list->countdown = 1U;
}

static void stop(sway_xcp_list_t *list)
{
    list->mode &= SWAY_XCP_MODE_TIMESTAMP;
}

sway_xcp_result_t sway_xcp_daq_start(sway_xcp_daq_t *daq, uint32_t mode, uint32_t list)
{
    if (list >= daq->lists) {
        return SWAY_XCP_RANGE;
    }
    sway_xcp_list_t *const l = &daq->list[list];
    if (mode == LIST_STOP) {
        stop(l);
        return SWAY_XCP_OK;
    }
    if (mode > LIST_SELECT) {
        return SWAY_XCP_NO_MODE;
    }
    if (!is_whole(daq, l)) {
        return SWAY_XCP_DAQ_CONFIG;
    }
    if (mode == LIST_START) {
        run(l);
    } else {
        l->mode |= SWAY_XCP_MODE_SELECTED;
    }
    return SWAY_XCP_OK;
}

sway_xcp_result_t sway_xcp_daq_synch(sway_xcp_daq_t *daq, uint32_t mode)
{
    if (mode > SELECTED_STOP) {
        return SWAY_XCP_NO_MODE;
    }
    for (uint32_t i = 0; i < daq->lists; i++) { // their entries may have changed since
        if (mode == SELECTED_START && is_selected(&daq->list[i]) && !is_whole(daq, &daq->list[i])) {
            return SWAY_XCP_DAQ_CONFIG;
        }
    }
    for (uint32_t i = 0; i < daq->lists; i++) {
        sway_xcp_list_t *const l = &daq->list[i];
        const bool was_selected = is_selected(l);
        if (mode == ALL_STOP || was_selected) {
            stop(l);
        }
        if (mode == SELECTED_START && was_selected) {
            run(l);
        }
    }
    return SWAY_XCP_OK;
}

/* --- sampling --------------------------------------------------------------------------------- */

static sway_xcp_packet_t *enqueue(sway_xcp_daq_t *daq)
{
    const uint32_t at = ((uint32_t)daq->queue_at + daq->queue_length) % SWAY_XCP_QUEUE;
    daq->queue_length++;
    return &daq->queue[at];
}

static void fill(const sway_xcp_daq_t *daq, uint32_t odt, uint32_t skipped, sway_xcp_packet_t *to)
{
    uint32_t size = 1U + skipped;
    for (uint32_t k = 0; k < daq->odt_of[odt].entries; k++) {
        const sway_xcp_entry_t *const entry = &daq->entry_of[daq->odt_of[odt].first + k];
        (void)memcpy(&to->data[size], entry->from, entry->size);
        size += entry->size;
    }
    to->data[0] = (uint8_t)odt;
    to->size = (uint8_t)size;
}

static void sample(sway_xcp_daq_t *daq, const sway_xcp_list_t *list, uint32_t stamp)
{
    if (list->odts > SWAY_XCP_QUEUE - (uint32_t)daq->queue_length) {
        daq->left_out++;
        daq->is_overloaded = true;
        return;
    }
    for (uint32_t i = 0; i < list->odts; i++) {
        sway_xcp_packet_t *const packet = enqueue(daq);
        const uint32_t skipped = SWAY_XCP_ODT_BYTES - room(list, i);
        (void)memcpy(&packet->data[1], &stamp, skipped);
        fill(daq, (uint32_t)list->first + i, skipped, packet);
    }
}

static bool is_due(sway_xcp_daq_t *daq, uint32_t event, bool is_new, int64_t now_us)
{
    if (event == (uint32_t)SWAY_XCP_EVENT_ESTIMATE) {
        return is_new;
    }
    int64_t *const due_us = &daq->due_us[event];
    const int64_t period = period_us[event];
    if (now_us < *due_us && *due_us - now_us <= period) {
        return false;
    }
    *due_us += period;
    if (*due_us <= now_us || *due_us - now_us > period) {
        *due_us = now_us + period; // the first time, or after a pause
    }
    return true;
}

static void raise_event(sway_xcp_daq_t *daq, uint32_t event, uint32_t stamp)
{
    for (uint32_t i = 0; i < daq->lists; i++) {
        sway_xcp_list_t *const list = &daq->list[i];
        if (list->event != event || (list->mode & SWAY_XCP_MODE_RUNNING) == 0U) {
            continue;
        }
        list->countdown--;
        if (list->countdown == 0U) {
            list->countdown = list->prescaler;
            sample(daq, list, stamp);
        }
    }
}

void sway_xcp_daq_sample(sway_xcp_daq_t *daq, uint32_t sequence, int64_t now_us)
{
    const bool is_new = sequence != daq->sequence && sequence != 0U; // 0: begun anew
    daq->sequence = sequence;
    for (uint32_t event = 0; event < (uint32_t)SWAY_XCP_EVENTS; event++) {
        if (is_due(daq, event, is_new, now_us)) {
            raise_event(daq, event, (uint32_t)now_us);
        }
    }
    if (daq->is_overloaded && daq->queue_length < SWAY_XCP_QUEUE) {
        sway_xcp_packet_t *const packet = enqueue(daq);
        packet->size = 2U;
        packet->data[0] = EVENT_PACKET;
        packet->data[1] = EV_DAQ_OVERLOAD;
        daq->is_overloaded = false;
    }
}

const sway_xcp_packet_t *sway_xcp_daq_next(const sway_xcp_daq_t *daq)
{
    return daq->queue_length == 0U ? NULL : &daq->queue[daq->queue_at];
}

void sway_xcp_daq_sent(sway_xcp_daq_t *daq)
{
    daq->queue_at = (uint16_t)((daq->queue_at + 1U) % SWAY_XCP_QUEUE);
    daq->queue_length--;
}

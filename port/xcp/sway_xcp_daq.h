/// sway_xcp_daq: dynamic DAQ lists of the XCP slave: what is sampled when, and frames that wait.
#ifndef SWAY_XCP_DAQ_H
#define SWAY_XCP_DAQ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Sizes: lists, ODTs (frames) of all lists, entries of all ODTs, frames that wait to be sent.
#ifndef SWAY_XCP_LISTS
#define SWAY_XCP_LISTS 4U
#endif
#ifndef SWAY_XCP_ODTS
#define SWAY_XCP_ODTS 32U
#endif
#ifndef SWAY_XCP_ENTRIES
#define SWAY_XCP_ENTRIES 96U
#endif
#ifndef SWAY_XCP_QUEUE
#define SWAY_XCP_QUEUE 48U
#endif
#if SWAY_XCP_LISTS < 1 || SWAY_XCP_LISTS > 32 || SWAY_XCP_ODTS < 1 || SWAY_XCP_ODTS > 250 ||       \
    SWAY_XCP_ENTRIES < 1 || SWAY_XCP_ENTRIES > 255 || SWAY_XCP_QUEUE < 1 || SWAY_XCP_QUEUE > 1000
#error "SWAY_XCP_LISTS 1 to 32, ODTS 1 to 250, ENTRIES 1 to 255, QUEUE 1 to 1000"
#endif

#define SWAY_XCP_ODT_BYTES 7U ///< of a frame, behind its number

/// Answers to a command: an error code of the standard, or SWAY_XCP_OK.
typedef enum {
    SWAY_XCP_SYNCH = 0x00,
    SWAY_XCP_BUSY = 0x10,     ///< ask again
    SWAY_XCP_BUSY_DAQ = 0x11, ///< DAQ is running
    SWAY_XCP_UNKNOWN = 0x20,
    SWAY_XCP_SYNTAX = 0x21,
    SWAY_XCP_RANGE = 0x22,
    SWAY_XCP_WRITE_PROTECTED = 0x23,
    SWAY_XCP_DENIED = 0x24,
    SWAY_XCP_LOCKED = 0x25,
    SWAY_XCP_NO_PAGE = 0x26,
    SWAY_XCP_NO_MODE = 0x27,
    SWAY_XCP_NO_SEGMENT = 0x28,
    SWAY_XCP_SEQUENCE = 0x29,
    SWAY_XCP_DAQ_CONFIG = 0x2A,
    SWAY_XCP_NO_MEMORY = 0x30,
    SWAY_XCP_OK = 0xFF
} sway_xcp_result_t;

/// Events that a list can be sampled by.
typedef enum {
    SWAY_XCP_EVENT_ESTIMATE, ///< each new estimate, before its status frames are sent
    SWAY_XCP_EVENT_10_MS,
    SWAY_XCP_EVENT_100_MS,
    SWAY_XCP_EVENTS
} sway_xcp_event_t;

/// Mode bits of a list.
#define SWAY_XCP_MODE_SELECTED 0x01U
#define SWAY_XCP_MODE_TIMESTAMP 0x10U
#define SWAY_XCP_MODE_RUNNING 0x40U

typedef struct {
    const uint8_t *from;
    uint8_t size;
} sway_xcp_entry_t;

typedef struct {
    uint8_t first; ///< entry
    uint8_t entries;
} sway_xcp_odt_t;

typedef struct {
    uint8_t mode;
    uint8_t event;
    uint8_t prescaler;
    uint8_t countdown;
    uint8_t first; ///< ODT, and number of the list's first frame
    uint8_t odts;
} sway_xcp_list_t;

typedef struct {
    uint8_t size;
    uint8_t data[8];
} sway_xcp_packet_t;

typedef struct {
    uint8_t step; ///< what may be allocated next
    uint8_t lists;
    uint8_t odts;
    uint8_t entries;
    bool has_pointer;
    uint8_t odt;   ///< that the pointer is at
    uint8_t entry; ///< of it
    bool is_overloaded;
    uint16_t queue_at;
    uint16_t queue_length;
    uint32_t sequence; ///< of the last estimate sampled
    uint32_t left_out; ///< samples without room in the queue; never goes down
    int64_t due_us[SWAY_XCP_EVENTS];
    sway_xcp_list_t list[SWAY_XCP_LISTS];
    sway_xcp_odt_t odt_of[SWAY_XCP_ODTS];
    sway_xcp_entry_t entry_of[SWAY_XCP_ENTRIES];
    sway_xcp_packet_t queue[SWAY_XCP_QUEUE];
} sway_xcp_daq_t;

/// Forgets all lists and what waits.
void sway_xcp_daq_free(sway_xcp_daq_t *daq);
/// FREE_DAQ is sway_xcp_daq_free(); then, in this order, the numbers of lists, of their ODTs, of
/// their entries. SWAY_XCP_SEQUENCE, SWAY_XCP_RANGE, SWAY_XCP_NO_MEMORY; SWAY_XCP_BUSY_DAQ: entries
/// of a list that runs.
sway_xcp_result_t sway_xcp_daq_lists(sway_xcp_daq_t *daq, uint32_t count);
sway_xcp_result_t sway_xcp_daq_odts(sway_xcp_daq_t *daq, uint32_t list, uint32_t count);
sway_xcp_result_t sway_xcp_daq_entries(sway_xcp_daq_t *daq, uint32_t list, uint32_t odt,
                                       uint32_t count);
/// Where the next entry is written.
sway_xcp_result_t sway_xcp_daq_point(sway_xcp_daq_t *daq, uint32_t list, uint32_t odt,
                                     uint32_t entry);
/// Writes it and goes on to the next of the ODT.
sway_xcp_result_t sway_xcp_daq_write(sway_xcp_daq_t *daq, const uint8_t *from, uint32_t size);
sway_xcp_result_t sway_xcp_daq_mode(sway_xcp_daq_t *daq, uint32_t list, uint32_t mode,
                                    uint32_t event, uint32_t prescaler);
/// Stops (0), starts (1) or selects (2) a list. A list that does not fit its frames is refused.
sway_xcp_result_t sway_xcp_daq_start(sway_xcp_daq_t *daq, uint32_t mode, uint32_t list);
/// Stops all (0), starts (1) or stops (2) those selected. None is started where one of them does
/// not fit its frames any more.
sway_xcp_result_t sway_xcp_daq_synch(sway_xcp_daq_t *daq, uint32_t mode);
bool sway_xcp_daq_is_running(const sway_xcp_daq_t *daq);

/// Samples the lists whose event is due; `sequence` counts the estimates.
void sway_xcp_daq_sample(sway_xcp_daq_t *daq, uint32_t sequence, int64_t now_us);
/// The frame that has waited longest, NULL: none. It is taken off by sway_xcp_daq_sent().
const sway_xcp_packet_t *sway_xcp_daq_next(const sway_xcp_daq_t *daq);
void sway_xcp_daq_sent(sway_xcp_daq_t *daq);

#endif

/// can_bus: a SocketCAN interface that may go away and come back.
///
/// Frames are stamped by the kernel. Nothing is lost without being counted: what the kernel dropped
/// for want of room (SO_RXQ_OVFL), what could not be sent, error frames by their class, states of
/// the controller, times the interface was down.
#ifndef SWAY_CAN_BUS_H
#define SWAY_CAN_BUS_H

#include <linux/can.h>
#include <stdbool.h>
#include <stdint.h>

#include "sway_port.h"

#define CAN_BUS_BATCH 64U
#define CAN_BUS_QUEUE 256U

/// Classes of error frames, in the order of their bits in linux/can/error.h.
typedef enum {
    CAN_BUS_TX_TIMEOUT,
    CAN_BUS_ARBITRATION_LOST,
    CAN_BUS_CONTROLLER,
    CAN_BUS_PROTOCOL,
    CAN_BUS_TRANSCEIVER,
    CAN_BUS_NO_ACK,
    CAN_BUS_BUS_OFF,
    CAN_BUS_BUS_ERROR,
    CAN_BUS_RESTARTED,
    CAN_BUS_COUNTERS,
    CAN_BUS_CLASSES
} can_bus_class_t;

/// Never go down.
typedef struct {
    uint64_t received;     ///< data frames with 11-bit identifiers
    uint64_t foreign;      ///< 29-bit identifiers and remote frames, not used
    uint64_t error_frames; ///< of any class
    uint64_t error_class[CAN_BUS_CLASSES];
    uint64_t kernel_lost; ///< frames that the kernel dropped before we read them
    uint64_t sent;
    uint64_t send_retries; ///< times that the kernel had no room for a frame (ENOBUFS)
    uint64_t send_lost;    ///< status frames given up: queue full, interface down
    uint64_t downs;        ///< times that the interface went down or away
    uint64_t clock_back;   ///< stamps set forward because they would have run backwards
    uint64_t clock_set;    ///< times that the clock of day was found set
    uint64_t stamped_here; ///< frames whose stamp fitted no clock: they have the time of reading
} can_bus_counts_t;

typedef enum { CAN_BUS_UP, CAN_BUS_DOWN } can_bus_link_t;

typedef struct {
    const char *name;
    int socket; ///< negative: the interface is away, it is looked for again and again
    can_bus_link_t link;
    int64_t to_monotonic_us; ///< from the clock of day, which stamps, to CLOCK_MONOTONIC
    int64_t before_set_us;   ///< the same before the clock of day was set
    int64_t reading_us;      ///< that the shortest comparison of the two took
    int64_t drained_us;      ///< when nothing waited to be read: what is read next came later
    int64_t last_us;         ///< newest stamp given out
    uint32_t overflow;       ///< the kernel's counter at the last frame
    int64_t look_us;         ///< when to look for the interface again
    struct can_frame batch[CAN_BUS_BATCH];
    int64_t batch_us[CAN_BUS_BATCH];
    unsigned batch_at;
    unsigned batch_end;
    sway_port_frame_t queue[CAN_BUS_QUEUE]; ///< to be sent
    unsigned queue_at;
    unsigned queue_length;
    bool queue_waits; ///< the kernel had no room
    can_bus_counts_t counts;
} can_bus_t;

/// Opens `name` (which must outlive the bus). False: `errno` says why; EAFNOSUPPORT means a kernel
/// without CAN, ENODEV no such interface.
bool can_bus_open(can_bus_t *bus, const char *name);
void can_bus_close(can_bus_t *bus);

/// Next received data frame with an 11-bit identifier; false: none now.
bool can_bus_receive(can_bus_t *bus, sway_port_frame_t *frame);
/// Queues a frame; when the queue is full, its oldest frame is given up and counted.
void can_bus_send(can_bus_t *bus, const sway_port_frame_t *frame);
/// Sends what is queued as far as the kernel takes it, and looks for a lost interface.
void can_bus_work(can_bus_t *bus);

/// The clock of the stamps: microseconds of CLOCK_MONOTONIC.
int64_t can_bus_time_us(void);
/// Name of a class, for messages.
const char *can_bus_class_name(can_bus_class_t class);

#endif

/// can: what every register-level driver of a CAN controller offers to the port on top of it.
///
/// A driver implements can_start() to can_receive_errors(); port/can.c has what is the same for
/// all: the ring between interrupt and program, and the waiting time after a bus-off.
///
/// can_interrupt() belongs into the interrupt of the controller; it moves frames from the
/// controller's FIFO into a ring and counts errors. Everything else is called from one thread.
/// Nothing waits for the controller except can_start() and can_service(), for a bounded time.
#ifndef SWAY_CAN_H
#define SWAY_CAN_H

#include "sway_port.h"

#define CAN_RING 128U ///< frames; a power of two. 128 frames of 8 bytes last 28 ms at 500 kbit/s
#define CAN_FILTERS 4U

/// A frame is accepted if (id & mask) == (wanted & mask) for one of the filters.
typedef struct {
    uint16_t wanted;
    uint16_t mask;
} can_filter_t;

typedef struct {
    uintptr_t base;
    uint32_t clock_hz; ///< of the controller
    uint32_t bit_rate;
    uint32_t sample_point_milli;
    can_filter_t filter[CAN_FILTERS];
    uint32_t filters;         ///< how many there are; 0: accept everything
    int64_t (*time_ns)(void); ///< the clock that frames are stamped by
} can_config_t;

typedef enum { CAN_ACTIVE, CAN_WARNING, CAN_PASSIVE, CAN_BUS_OFF } can_state_t;

/// Counters; none ever goes down.
typedef struct {
    uint32_t received;
    uint32_t sent;
    uint32_t overflows; ///< frames lost because the FIFO or the ring was full (at least)
    uint32_t ack_errors;
    uint32_t bit_errors;
    uint32_t stuff_errors;
    uint32_t form_errors;
    uint32_t crc_errors;
    uint32_t bus_offs;
    uint32_t remote_frames; ///< remote or 29-bit frames: dropped
} can_counters_t;

typedef struct {
    can_config_t config;
    sway_port_frame_t ring[CAN_RING];
    volatile uint32_t head; ///< written by can_interrupt()
    volatile uint32_t tail; ///< written by can_receive()
    can_counters_t counters;
    int64_t stamp_origin_ns; ///< when the controller's time stamp counter was 0
    int64_t restart_ns;      ///< when to go back to the bus after a bus-off
    int64_t backoff_ns;
    volatile bool bus_off;
} can_t;

/// Resets the controller, sets timing, filters and interrupts, and joins the bus. False: the bit
/// rate cannot be made from the clock, or the controller does not answer.
bool can_start(can_t *can, const can_config_t *config);
/// The interrupt's handler; harmless when there is nothing to do. Bounded: one FIFO full a call.
void can_interrupt(can_t *can);
/// True where the controller asks for its interrupt (for a machine without an interrupt
/// controller).
bool can_wants_interrupt(const can_t *can);
/// Call now and then (each pass of the main loop): rejoins the bus after a bus-off, at first after
/// the 128 times 11 bits that the standard wants, then after twice as long each time up to 1 s. A
/// frame that is received ends the doubling.
void can_service(can_t *can);
/// False: the transmit FIFO is full or the controller is off the bus.
bool can_send(can_t *can, const sway_port_frame_t *frame);
can_state_t can_state(const can_t *can);
/// The standard's two error counters.
uint32_t can_transmit_errors(const can_t *can);
uint32_t can_receive_errors(const can_t *can);

/* --- port/can.c ------------------------------------------------------------------------------ */

/// The oldest frame received; false: none.
bool can_receive(can_t *can, sway_port_frame_t *frame);
/// For drivers. Clears everything and takes over `config`; false: it cannot be right.
bool can_prepare(can_t *can, const can_config_t *config);
/// For drivers: a frame into the ring, or an overflow counted.
void can_put(can_t *can, const sway_port_frame_t *frame);
/// For drivers: the controller has left the bus. Counts it, sets `bus_off` and when to come back.
void can_note_bus_off(can_t *can);

#endif

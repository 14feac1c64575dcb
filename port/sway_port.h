/// sway_port: all that swaywatch wants of a machine: frames in, frames out, the time.
///
/// Fill a sway_port_t with your functions and hand it to sway_ecu_start(); call sway_ecu_poll()
/// from your main loop or from one task of an RTOS. See port/README.md for the steps.
///
/// Every function gets `context` back, never blocks, and is only called from the thread that calls
/// sway_ecu_start() and sway_ecu_poll(). None of them is called from an interrupt.
#ifndef SWAY_PORT_H
#define SWAY_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// A classic CAN data frame with an 11-bit identifier.
typedef struct {
    int64_t time_us; ///< when it was received; any origin, but never running backwards
    uint16_t id;     ///< 0 .. 0x7FF
    uint8_t dlc;     ///< 0 .. 8
    uint8_t data[8];
} sway_port_frame_t;

typedef struct {
    /// The oldest frame received and not yet fetched; false: none. Stamp it where it is received
    /// (controller or interrupt), not here: the estimates are only as good as the stamps.
    bool (*receive)(void *context, sway_port_frame_t *frame);
    /// Queues a frame; false: no room, it will be offered again. `time_us` is that of the frame
    /// whose reception made it due.
    bool (*send)(void *context, const sway_port_frame_t *frame);
    /// The clock that stamps the frames, in microseconds.
    int64_t (*time_us)(void *context);
    /// Optional (NULL: parameters cannot be stored): writes the parameter block to memory that
    /// keeps it without power. True: it was written and read back.
    bool (*store)(void *context, const uint8_t *block, size_t size);
    /// Optional: serves the watchdog. Called once in each sway_ecu_poll(), only while the
    /// program's own state is sound.
    void (*alive)(void *context);
    /// Optional: 32 random bits of the hardware, for the challenges of sway_access. Without it they
    /// are predictable by the time of the request, and one that was answered before can be had
    /// again after a power cycle.
    uint32_t (*random)(void *context);
    /// Key of sway_access, SWAY_SIPHASH_KEY bytes, each ECU its own. NULL: no parameter can be
    /// changed over CAN.
    const uint8_t *key;
    void *context;
} sway_port_t;

#endif

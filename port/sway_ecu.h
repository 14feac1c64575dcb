/// sway_ecu: the program of an ECU around sway_node: start-up checks, parameters over CAN, safe
/// state, fault reports. The same on every port; nothing here knows a processor.
///
///     static sway_ecu_t ecu;
///     sway_ecu_start(&ecu, &port, &retained, flash_block, flash_block_size);
///     for (;;) {
///         sway_ecu_poll(&ecu);
///     }
///
/// Frames of its own, in dbc/swaywatch.dbc: SwayParameterRequest is answered by SwayParameterReply;
/// SwayFaultReport goes out at start, every second while running and every 100 ms in the safe
/// state; SwayTrailer, where the ECU remembers its trailer, every second; SwayAccess says who tried
/// to change parameters, at most every 100 ms.
#ifndef SWAY_ECU_H
#define SWAY_ECU_H

#include "sway_access.h"
#include "sway_block.h"
#include "sway_node.h"
#include "sway_port.h"
#include "sway_remember.h"

/// In the safe state there is no estimate, no status frame and no alarm: only SwayFaultReport.
/// While running, outputs are marked not valid by sway_node until the estimates are.
typedef enum { SWAY_ECU_RUNNING, SWAY_ECU_SAFE } sway_ecu_state_t;

/// Why the ECU restarted or stays in the safe state. Numbers below 16 are the processor's own
/// exception numbers, as the port reports them.
typedef enum {
    SWAY_ECU_NO_CAUSE = 0,
    SWAY_ECU_WATCHDOG = 16,
    SWAY_ECU_BUS_OFF = 17,    ///< the CAN controller left the bus and came back
    SWAY_ECU_ARITHMETIC = 32, ///< self-test: a known answer came out wrong
    SWAY_ECU_MEMORY = 33,     ///< self-test: RAM does not hold what is written
    SWAY_ECU_IMAGE = 34,      ///< self-test: the program's CRC is wrong
    SWAY_ECU_BLOCK = 48,      ///< 48 + sway_block_result_t: no usable parameters
    SWAY_ECU_STORE_CUT = 56,  ///< power went while parameters were stored: the ones before are used
    SWAY_ECU_RESTARTS = 64,   ///< faulted again and again: stays safe until power is cycled
    SWAY_ECU_STATE = 65,      ///< the program's own state was overwritten
    SWAY_ECU_CONTROLLER = 66, ///< clock or CAN controller did not start
    SWAY_ECU_DOUBLED = 67,    ///< frames come with a counter that was there: a second sender
} sway_ecu_cause_t;

/// Restarts by faults after which the ECU stays in the safe state.
#define SWAY_ECU_RESTARTS_MAX 5U
/// Parameters are changed below this speed only.
#define SWAY_ECU_STANDSTILL_MM_S 500
/// Frames with a counter that was there, in a second, that make SWAY_ECU_DOUBLED.
#define SWAY_ECU_DOUBLED_FRAMES 10U

/// Memory that survives a reset (not a power cycle): place it where start-up code does not clear
/// it. A checksum tells a first start from a restart.
typedef struct {
    uint32_t cause;
    uint32_t address; ///< where it happened
    uint32_t restarts;
    uint32_t check;
} sway_ecu_retained_t;

/// What frames other than parameter requests mean: sway_node_receive(), or a port's own
/// sway_map_receive().
typedef void (*sway_ecu_listen_t)(void *context, sway_node_t *node, const sway_port_frame_t *frame);

/// Keeps a record of SWAY_REMEMBER_SIZE bytes without power; true: it was written and read back.
typedef bool (*sway_ecu_keep_t)(void *context, const uint8_t *record, size_t size);

typedef struct {
    bool outgoing_waits;
    bool reply_waits;
    bool access_news; ///< SwayAccess has something to say
    uint8_t report_counter;
    uint8_t reply_counter;
    uint8_t access_counter;
    uint16_t last_request; ///< CRC and counter of the request before
    sway_ecu_state_t state;
    sway_ecu_cause_t cause;  ///< of the safe state
    sway_ecu_cause_t notice; ///< reported while running, if there is one
    sway_ecu_retained_t *retained;
    uint32_t block_sequence;
    uint32_t frames_received; ///< never go down, any of the three
    uint32_t frames_sent;
    uint32_t requests_refused; ///< wrong CRC, length, command, value or proof, or sent twice
    uint32_t doubled;          ///< frames with a counter that was there, at the last report
    int64_t now_us;
    int64_t frame_us; ///< of the last frame received
    int64_t report_due_us;
    int64_t access_due_us;
    sway_access_t access;
    sway_port_t port;
    sway_port_frame_t outgoing; ///< refused by port.send, offered again
    sway_port_frame_t reply;    ///< waits for `outgoing`
    sway_core_config_t staged;  ///< being changed over CAN; those in use: sway_ecu_config()
    sway_node_t node;
#if SWAY_MAP
    sway_ecu_listen_t listen; ///< NULL: frames of dbc/swaywatch.dbc only
    void *listen_context;
#endif
#if SWAY_REMEMBER
    uint8_t trailer_counter;
    sway_ecu_keep_t keep; ///< NULL: no trailer is remembered
    int64_t trailer_due_us;
    int64_t keep_due_us;
    sway_remember_t remember;
#endif
    uint32_t canary;
} sway_ecu_t;

/// Checks the arithmetic and the parameters, then starts the node. `retained` as above; `block`
/// may be NULL or empty flash. An ECU without usable parameters is in the safe state and takes
/// parameters over CAN. SWAY_ERROR_ARGUMENT for a null pointer, else SWAY_OK: a failed check is
/// not an error of the call, it is the safe state.
sway_error_t sway_ecu_start(sway_ecu_t *ecu, const sway_port_t *port, sway_ecu_retained_t *retained,
                            const uint8_t *block, size_t block_size);

#if SWAY_MAP
/// Listens to a car's own bus from now on: `listen` gets every frame but the parameter requests.
void sway_ecu_listen(sway_ecu_t *ecu, sway_ecu_listen_t listen, void *context);
#endif

#if SWAY_REMEMBER
/// Remembers the trailer from now on: after sway_ecu_start(). `record` is what `keep` was given
/// last, NULL or anything else: nothing is remembered. `keep` gets port.context and is called at
/// standstill only, and by sway_ecu_leave(). SwayTrailer goes out every second.
void sway_ecu_remember(sway_ecu_t *ecu, sway_ecu_keep_t keep, const uint8_t *record, size_t size);

/// The ignition goes off: keeps what is worth it.
void sway_ecu_leave(sway_ecu_t *ecu);
#endif

/// Enters the safe state for a fault that the port's own start-up checks found.
void sway_ecu_fail(sway_ecu_t *ecu, sway_ecu_cause_t cause);

/// Tells `cause` in SwayFaultReport from now on, at once the first time; the ECU goes on running.
void sway_ecu_warn(sway_ecu_t *ecu, sway_ecu_cause_t cause);

/// How a change of the parameters ended.
typedef enum {
    SWAY_ECU_CHANGED,
    SWAY_ECU_OUT_OF_RANGE, ///< see sway_block_offender()
    SWAY_ECU_NOT_NOW,      ///< not at standstill, or in a safe state that parameters do not end
} sway_ecu_change_t;

/// Runs with other parameters from now on, estimator and counters anew; nothing is stored. For what
/// has checked who asks (sway_xcp); range, state and standstill are checked here.
sway_ecu_change_t sway_ecu_calibrate(sway_ecu_t *ecu, const sway_core_config_t *config);

/// Counts a request that was refused elsewhere, for SwayAccess.
void sway_ecu_refuse(sway_ecu_t *ecu);

/// The parameters that the ECU runs with; nothing but zeros where it never had any.
const sway_core_config_t *sway_ecu_config(const sway_ecu_t *ecu);

/// True where so many faults restarted the ECU that it stays safe whatever its flash holds: a port
/// leaves flash alone that may itself be what faults.
bool sway_ecu_gave_up(const sway_ecu_retained_t *retained);

/// Does one thing, the first of these that is due: one slice of work (at most SWAY_SLICE_COST), one
/// frame sent, one frame received. While the port refuses to send, receiving goes on. False: there
/// was nothing to do, the caller may sleep until the next frame.
bool sway_ecu_poll(sway_ecu_t *ecu);

/// For fault handlers: writes down what happened; reset the processor afterwards. Uses no stack to
/// speak of, no other state, and may be called at any time.
void sway_ecu_note_fault(sway_ecu_retained_t *retained, uint32_t cause, uint32_t address);

/// Known answers of the arithmetic and of the checksums: SWAY_ECU_NO_CAUSE if all came out right.
sway_ecu_cause_t sway_ecu_self_test(void);

#endif

/// sway_xcp: an XCP slave on CAN (ASAM MCD-1 XCP 1.1) around an ECU, so that INCA, CANape, pyxcp
/// and other masters measure and calibrate it by its A2L file (`swaywatch a2l`).
///
/// It stands between the port and the ECU: it takes its own frames out of what the port receives
/// and hands on everything else. An ECU without it has no byte of it.
///
///     static sway_xcp_t xcp;
///     static sway_ecu_t ecu;
///     const sway_xcp_config_t config = {.request_id = 0x6E4, .reply_id = 0x6E5, ...};
///     const sway_port_t port = sway_xcp_attach(&xcp, &ecu, &board, &config);
///     sway_ecu_start(&ecu, &port, &retained, block, size);
///     sway_xcp_start(&xcp);
///     for (;;) {
///         sway_xcp_poll(&xcp); // instead of sway_ecu_poll(&ecu)
///     }
///
/// **Measuring.** All of sway_ecu_t can be read, and nothing else: polled, or by DAQ lists at each
/// new estimate, every 10 ms or every 100 ms, with time stamps if asked for. What a list sends was
/// read at one moment. A sample for which the queue has no room is left out whole and reported
/// (EV_DAQ_OVERLOAD).
///
/// **Calibrating.** The parameters are one segment with two pages: 0 holds what the ECU was started
/// with and is read only, 1 is the working page. A value is written as its whole word and refused
/// where it is out of its range (sway_block_offender). It counts from the moment when the ECU is
/// set to page 1, or at once if it is there: then the estimator starts anew, so both are refused
/// unless the vehicle stands still, as over the parameter frames. Nothing is ever stored: for that
/// there are the parameter frames, whose proof covers every value.
///
/// **Locked.** Whatever changes something wants seed and key first: the key is the lowest six bytes
/// of SipHash-2-4(key of the port, seed, 0xF7, 0). It lasts SWAY_ACCESS_SESSION_US. A port without
/// a key cannot be calibrated. Refusals are counted and reported in SwayAccess.
///
/// Numbers are in the byte order of the processor, as CONNECT says.
#ifndef SWAY_XCP_H
#define SWAY_XCP_H

#include "sway_ecu.h"
#include "sway_xcp_daq.h"

/// XCP frames taken in one poll, at most.
#define SWAY_XCP_FRAMES_MAX 8U

typedef enum {
    SWAY_XCP_PAGE_REFERENCE, ///< what the ECU was started with
    SWAY_XCP_PAGE_WORKING,
    SWAY_XCP_PAGES
} sway_xcp_page_t;

typedef struct {
    uint16_t request_id; ///< of the master's frames (CRO)
    uint16_t reply_id;   ///< of the slave's frames (CRM, DTO)
    /// Where the A2L file says that these two begin: on 32-bit machines simply their addresses.
    uint32_t ecu_address;
    uint32_t working_address; ///< of sway_xcp_t::working
} sway_xcp_config_t;

typedef struct {
    bool is_connected;
    bool is_unlocked;
    bool reply_waits;
    bool has_changed; ///< the ECU's parameters, at changed_us
    uint8_t xcp_page; ///< sway_xcp_page_t that the master sees
    uint8_t ecu_page; ///< that the ECU runs with
    uint8_t memory;   ///< address extension of the memory transfer address
    uint32_t address; ///< memory transfer address
    uint32_t refused; ///< commands answered with an error; never goes down
    int64_t unlocked_us;
    int64_t changed_us;
    sway_xcp_config_t config;
    sway_port_t port; ///< the one below
    sway_ecu_t *ecu;
    sway_access_t access;
    sway_port_frame_t reply;
    sway_core_config_t working; ///< page 1; the A2L's parameters are here
    sway_core_config_t reference;
    sway_xcp_daq_t daq;
} sway_xcp_t;

/// The port to start the ECU with. `below` is copied; all three stay in use.
sway_port_t sway_xcp_attach(sway_xcp_t *xcp, sway_ecu_t *ecu, const sway_port_t *below,
                            const sway_xcp_config_t *config);

/// Takes over the parameters of the ECU, once it has been started.
void sway_xcp_start(sway_xcp_t *xcp);

/// sway_ecu_poll(), then samples that are due and frames that wait. False: nothing to do.
bool sway_xcp_poll(sway_xcp_t *xcp);

/// Memory at an address of the A2L file, NULL where `size` bytes of it may not be read. Extension 0
/// is the ECU and the page of the parameters that the master sees, 1 the slave's own texts.
const uint8_t *sway_xcp_memory(const sway_xcp_t *xcp, uint8_t extension, uint32_t address,
                               uint32_t size);

#endif

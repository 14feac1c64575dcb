// SPDX-License-Identifier: MIT
/// sway_e2e: end-to-end protection of frames on the bus, AUTOSAR E2E profile 2.
///
/// Byte 0 of a protected frame is a CRC, the low half of byte 1 a rolling counter, 0 to 15. The CRC
/// is CRC-8H2F (polynomial 0x2F, start 0xFF, inverted at the end; 0xDF for "123456789") over bytes
/// 1 to 7 and then the data ID, which is not sent. A message's DataIDList holds the low byte of its
/// CAN identifier 16 times: no two messages of dbc/swaywatch.dbc share it, so a frame under the
/// identifier of another one fails like a corrupted one; and entries that went with the counter
/// would let some errors of two and three bits in the counter pass.
#ifndef SWAY_E2E_H
#define SWAY_E2E_H

#include <stdbool.h>
#include <stdint.h>

#define SWAY_E2E_LENGTH 8U         ///< bytes of a protected frame
#define SWAY_E2E_COUNTER_MAX 15    ///< the counter's last value before 0
#define SWAY_E2E_LEARN_MIN 8       ///< frames in order before the period is relied on
#define SWAY_E2E_LEARN_MAX 16      ///< frames that the period is smoothed over
#define SWAY_E2E_PERIOD_MIN_US 500 ///< a shorter period is not relied on

/// What a receiver remembers of one identifier. All zero is its state before the first frame.
typedef struct {
    int64_t time_us;   ///< of the last frame that was not late
    int32_t period_us; ///< between frames, smoothed
    uint8_t counter;   ///< of that frame
    uint8_t learned;   ///< frames that period_us was learned from, up to SWAY_E2E_LEARN_MAX
    bool started;
} sway_e2e_t;

/// One byte more under a CRC-8. `remainders`: of the 16 numbers of four bits, with as many zeros
/// behind them, by its polynomial. Constant time.
uint8_t sway_e2e_crc_byte(const uint8_t *remainders, uint8_t crc, uint8_t byte);

/// CRC of a frame of 8 bytes; byte 0 is not looked at. Constant time.
uint8_t sway_e2e_crc(uint32_t can_id, const uint8_t *data);

/// Writes `counter` (0 .. SWAY_E2E_COUNTER_MAX) and then the CRC into `data` of 8 bytes.
void sway_e2e_protect(uint32_t can_id, uint8_t counter, uint8_t *data);

/// The counter after `counter`.
uint8_t sway_e2e_next(uint8_t counter);

/// True where the CRC is right.
bool sway_e2e_check(uint32_t can_id, const uint8_t *data);

/// Steps from the last frame to this one: 1 next in order (and for the first frame ever), n > 1:
/// n - 1 frames are missing, 0: the same frame again or a stuck counter, n < 0: older than the last
/// one by -n, late or out of order.
///
/// The counter alone tells steps modulo 16. Where it shows a gap, the time since the last frame, in
/// periods, picks the number that fits best, so up to `limit_us` of silence every missing frame is
/// counted even over several turns of the counter. A frame that is next by its counter is taken for
/// the next one whenever it comes: senders pause, and a loss of exactly 16 looks the same. Of two
/// numbers that fit equally well the larger is reported. Before the period is known the steps
/// nearest to 0 are reported; beyond `limit_us` the smallest positive number that fits the counter,
/// and 1 for an equal counter, as its sender was silent, not stuck. Time that goes back counts as
/// no time.
int32_t sway_e2e_step(sway_e2e_t *e2e, uint8_t counter, int64_t time_us, int32_t limit_us);

#endif

/// sway_access: who may change the parameters over CAN.
///
/// A session is opened with a challenge, six bytes that never come twice; `apply` and `store` end
/// it and carry six bytes that only a holder of the key can make:
///
///     SipHash-2-4(key, challenge, command, 0, block)      its lowest six bytes, lowest first
///
/// `block` is the parameter block that the ECU would store now (sway_block_write of the staged
/// values, with the stored block's sequence number plus one). So every value is covered; what was
/// staged by somebody else in between, recorded from another session, or meant for another state
/// of the flash is refused. What this is against and what not: port/README.md, "Who may write".
#ifndef SWAY_ACCESS_H
#define SWAY_ACCESS_H

#include "sway_block.h"
#include "sway_siphash.h"

#define SWAY_ACCESS_PROOF 6U ///< bytes of a challenge and of a proof
/// A session that is not used up ends after this time.
#define SWAY_ACCESS_SESSION_US 30000000
/// Blocks stored between two starts of power, and in the life of the flash (two pages of 10,000
/// erasures each, half of them kept in reserve).
#define SWAY_ACCESS_STORES_MAX 20U
#define SWAY_ACCESS_SEQUENCE_MAX 10000U

/// Challenge, command, zero, block: what is authenticated.
typedef struct {
    uint8_t challenge[SWAY_ACCESS_PROOF];
    uint8_t command;
    uint8_t zero;
    uint8_t block[SWAY_BLOCK_SIZE];
} sway_access_message_t;

#define SWAY_ACCESS_HEAD offsetof(sway_access_message_t, block)

typedef struct {
    bool is_open;
    uint8_t stores; ///< since power came on
    uint8_t challenge[SWAY_ACCESS_PROOF];
    uint32_t forged; ///< proofs that were wrong
    int64_t opened_us;
} sway_access_t;

/// Opens a session. The challenge is new with every `now_us`, `sequence` and `random`.
void sway_access_open(sway_access_t *access, const uint8_t *key, int64_t now_us, uint32_t sequence,
                      uint32_t random);
bool sway_access_is_open(const sway_access_t *access, int64_t now_us);
/// Ends the session; true where `proof` belongs to it and to the first `size` bytes of `message`,
/// of which the first six are filled in here: all of it, or SWAY_ACCESS_HEAD without a block.
bool sway_access_close(sway_access_t *access, const uint8_t *key, sway_access_message_t *message,
                       size_t size, const uint8_t *proof);

#endif

/// sway_store: a record (the parameter block, the trailer remembered) in two pages of flash, so
/// that a power cut at any moment leaves one that is whole.
///
/// A new block always goes into the page that does not hold the newest good one. After a cut
/// between erasing and writing, or in the middle of writing, the old block is still there; it is
/// used, and the next start reports that a store was interrupted.
#ifndef SWAY_STORE_H
#define SWAY_STORE_H

#include <stdbool.h>

#include "sway_remember.h"

#define SWAY_STORE_SLOTS 2U
#if SWAY_REMEMBER
#define SWAY_STORE_SIZE_MAX                                                                        \
    (SWAY_BLOCK_SIZE > SWAY_REMEMBER_SIZE ? SWAY_BLOCK_SIZE : SWAY_REMEMBER_SIZE)
#else
#define SWAY_STORE_SIZE_MAX SWAY_BLOCK_SIZE
#endif

typedef struct {
    /// Bytes of a record, at most SWAY_STORE_SIZE_MAX; is it whole, and its sequence number.
    size_t size;
    sway_block_result_t (*check)(const uint8_t *record, size_t size, uint32_t *sequence);
    /// `size` bytes from the start of a slot. False: the memory says that they are damaged (an ECC
    /// error after a power cut while it was written), whatever they look like.
    bool (*read)(void *context, uint32_t slot, uint8_t *bytes, size_t size);
    /// All bytes of the slot are 0xFF afterwards; false: the flash says it did not work.
    bool (*erase)(void *context, uint32_t slot);
    /// Writes `size` bytes to the start of an erased slot.
    bool (*write)(void *context, uint32_t slot, const uint8_t *block, size_t size);
    void *context;
} sway_store_t;

/// Reads the newest good record to `block`, store->size bytes; where there is none a damaged
/// one, so that sway_ecu_start() can say what is wrong with it, else an empty slot. True: a store
/// was not finished, and what was read is the block from before it.
bool sway_store_find(const sway_store_t *store, uint8_t *block);

/// Writes a record of store->size bytes and reads it back. False: nothing was stored, the old
/// block is still there.
bool sway_store_write(const sway_store_t *store, const uint8_t *block, size_t size);

#endif

#include "sway_store.h"

#include <string.h>

#define NONE SWAY_STORE_SLOTS

typedef struct {
    sway_block_result_t result;
    uint32_t sequence;
} slot_t;

/* A page that the memory itself reports as damaged is not used, even where it looks intact. */
static slot_t look(const sway_store_t *store, uint32_t number, uint8_t *block)
{
    slot_t slot = {SWAY_BLOCK_EMPTY, 0U};
    const bool is_read = store->read(store->context, number, block, store->size);
    slot.result = store->check(block, store->size, &slot.sequence);
    if (!is_read && slot.result == SWAY_BLOCK_OK) {
        block[store->size - 1U] ^= 1U;
        slot.result = SWAY_BLOCK_CRC;
    }
    return slot;
}

static bool is_erased(const sway_store_t *store, uint32_t number, uint8_t *block)
{
    bool erased = store->read(store->context, number, block, store->size);
    for (size_t i = 0; i < store->size; i++) {
        erased = erased && block[i] == 0xFFU;
    }
    return erased;
}

/* Which slot holds the newest good block; sequence numbers may turn over. */
static uint32_t newest(const slot_t *slot)
{
    const bool first = slot[0].result == SWAY_BLOCK_OK;
    const bool second = slot[1].result == SWAY_BLOCK_OK;
    if (first && second) {
        return (int32_t)(slot[1].sequence - slot[0].sequence) > 0 ? 1U : 0U;
    }
    return first ? 0U : (second ? 1U : NONE);
}

bool sway_store_find(const sway_store_t *store, uint8_t *block)
{
    const slot_t slot[SWAY_STORE_SLOTS] = {look(store, 0U, block), look(store, 1U, block)};
    const uint32_t best = newest(slot);
    bool was_cut = false;
    uint32_t chosen = best;
    if (best != NONE) {
        /* Whoever stored the second block or a later one has left the one before it, too. */
        const uint32_t other = 1U - best;
        was_cut = slot[other].result != SWAY_BLOCK_OK &&
                  (slot[best].sequence > 1U || !is_erased(store, other, block));
    } else {
        chosen = (uint32_t)(slot[0].result == SWAY_BLOCK_EMPTY);
    }
    (void)look(store, chosen, block);
    return was_cut;
}

bool sway_store_write(const sway_store_t *store, const uint8_t *block, size_t size)
{
    uint8_t found[SWAY_STORE_SIZE_MAX];
    const slot_t slot[SWAY_STORE_SLOTS] = {look(store, 0U, found), look(store, 1U, found)};
    const uint32_t target = (uint32_t)(newest(slot) == 0U);
    if (size != store->size || !store->erase(store->context, target) ||
        !is_erased(store, target, found)) {
        return false;
    }
    return store->write(store->context, target, block, size) &&
           store->read(store->context, target, found, size) && memcmp(found, block, size) == 0;
}

#include "sway_store.h"

#include <string.h>

#define NONE SWAY_STORE_SLOTS

typedef struct {
    sway_block_result_t result;
    uint32_t sequence;
} slot_t;

static slot_t look(const uint8_t *block)
{
    sway_core_config_t config;
    slot_t slot = {SWAY_BLOCK_EMPTY, 0U};
    slot.result = sway_block_read(block, SWAY_BLOCK_SIZE, &config, &slot.sequence);
    return slot;
}

static bool is_erased(const uint8_t *block)
{
    for (size_t i = 0; i < SWAY_BLOCK_SIZE; i++) {
        if (block[i] != 0xFFU) {
            return false;
        }
    }
    return true;
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

const uint8_t *sway_store_find(const sway_store_t *store, bool *interrupted)
{
    const slot_t slot[SWAY_STORE_SLOTS] = {look(store->slot[0]), look(store->slot[1])};
    const uint32_t best = newest(slot);
    bool was_cut = false;
    uint32_t chosen = best;
    if (best != NONE) {
        /* Whoever stored the second block or a later one has left the one before it, too. */
        const uint32_t other = 1U - best;
        was_cut = slot[other].result != SWAY_BLOCK_OK &&
                  (slot[best].sequence > 1U || !is_erased(store->slot[other]));
    } else {
        chosen = slot[0].result == SWAY_BLOCK_EMPTY ? 1U : 0U;
    }
    if (interrupted != NULL) {
        *interrupted = was_cut;
    }
    return store->slot[chosen];
}

bool sway_store_write(const sway_store_t *store, const uint8_t *block, size_t size)
{
    const slot_t slot[SWAY_STORE_SLOTS] = {look(store->slot[0]), look(store->slot[1])};
    const uint32_t target = newest(slot) == 0U ? 1U : 0U;
    if (size != SWAY_BLOCK_SIZE || !store->erase(store->context, target) ||
        !is_erased(store->slot[target])) {
        return false;
    }
    return store->write(store->context, target, block, size) &&
           memcmp(store->slot[target], block, size) == 0;
}

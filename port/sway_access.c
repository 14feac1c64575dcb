#include "sway_access.h"

#include <string.h>

typedef char sway_access_no_padding[sizeof(sway_access_message_t) == 8U + SWAY_BLOCK_SIZE ? 1 : -1];

static void put(uint8_t *bytes, uint64_t value, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        bytes[i] = (uint8_t)(value >> (8U * i));
    }
}

void sway_access_open(sway_access_t *access, const uint8_t *key, int64_t now_us, uint32_t sequence,
                      uint32_t random)
{
    uint8_t moment[16];
    put(moment, (uint64_t)now_us, 8U);
    put(moment + 8, sequence, 4U);
    put(moment + 12, random, 4U);
    put(access->challenge, sway_siphash(key, moment, sizeof moment), SWAY_ACCESS_PROOF);
    access->opened_us = now_us;
    access->is_open = true;
}

bool sway_access_is_open(const sway_access_t *access, int64_t now_us)
{
    return access->is_open && now_us - access->opened_us < SWAY_ACCESS_SESSION_US;
}

/* All six bytes are compared, whichever differs: the time tells nothing. */
bool sway_access_close(sway_access_t *access, const uint8_t *key, sway_access_message_t *message,
                       size_t size, const uint8_t *proof)
{
    uint8_t wanted[SWAY_ACCESS_PROOF];
    uint8_t difference = 0;
    (void)memcpy(message->challenge, access->challenge, sizeof access->challenge);
    put(wanted, sway_siphash(key, (const uint8_t *)message, size), SWAY_ACCESS_PROOF);
    for (unsigned i = 0; i < SWAY_ACCESS_PROOF; i++) {
        difference |= (uint8_t)(wanted[i] ^ proof[i]);
    }
    access->is_open = false;
    access->forged += difference != 0U;
    return difference == 0U;
}

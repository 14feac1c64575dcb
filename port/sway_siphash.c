#include "sway_siphash.h"

#define WORD 8U

static uint64_t word_at(const uint8_t *bytes, size_t count)
{
    uint64_t word = 0;
    for (size_t i = count; i > 0U; i--) {
        word = word << 8 | bytes[i - 1U];
    }
    return word;
}

static uint64_t turn(uint64_t word, unsigned by)
{
    return word << by | word >> (64U - by);
}

/* Half a round on (a, b) and (c, d), then the pairs change partners: two make a SipRound. */
static void half(uint64_t *v, unsigned left, unsigned right)
{
    v[0] += v[1];
    v[2] += v[3];
    v[1] = turn(v[1], left) ^ v[0];
    v[3] = turn(v[3], right) ^ v[2];
    v[0] = turn(v[0], 32U);
    const uint64_t kept = v[0];
    v[0] = v[2];
    v[2] = kept;
}

static void rounds(uint64_t *v, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        half(v, 13U, 16U);
        half(v, 17U, 21U);
    }
}

uint64_t sway_siphash(const uint8_t *key, const uint8_t *bytes, size_t size)
{
    const uint64_t k0 = word_at(key, WORD);
    const uint64_t k1 = word_at(key + WORD, WORD);
    uint64_t v[4] = {k0 ^ UINT64_C(0x736F6D6570736575), k1 ^ UINT64_C(0x646F72616E646F6D),
                     k0 ^ UINT64_C(0x6C7967656E657261), k1 ^ UINT64_C(0x7465646279746573)};
    for (size_t at = 0;; at += WORD) {
        const size_t left = size - at;
        const uint64_t word = left >= WORD ? word_at(bytes + at, WORD)
                                           : word_at(bytes + at, left) | (uint64_t)size << 56;
        v[3] ^= word;
        rounds(v, 2U);
        v[0] ^= word;
        if (left < WORD) {
            break;
        }
    }
    v[2] ^= 0xFFU;
    rounds(v, 4U);
    return v[0] ^ v[1] ^ v[2] ^ v[3];
}

#include "sway_siphash.h"

#define WORD 8U

/* A 64-bit word is two of 32 bits, the lower first: small processors shift nothing longer. */
typedef uint32_t word_t[2];

static uint32_t part_at(const uint8_t *bytes, size_t left)
{
    uint32_t part = 0;
    for (size_t i = left < 4U ? left : 4U; i > 0U; i--) {
        part = part << 8 | bytes[i - 1U];
    }
    return part;
}

/* a += b, then b = (b turned left) ^ a */
static void mix(word_t a, word_t b, unsigned left)
{
    const uint32_t low = b[0];
    const uint32_t high = b[1];
    a[0] += low;
    a[1] += high + (a[0] < low ? 1U : 0U);
    b[0] = (low << left | high >> (32U - left)) ^ a[0];
    b[1] = (high << left | low >> (32U - left)) ^ a[1];
}

/* Half of a SipRound; the first and third word then change places, the first turned by 32 bits. */
static void half(word_t *v, unsigned left, unsigned right)
{
    mix(v[0], v[1], left);
    mix(v[2], v[3], right);
    for (unsigned i = 0; i < 2U; i++) {
        const uint32_t kept = v[0][i];
        v[0][i] = v[2][i];
        v[2][i] = kept;
    }
    const uint32_t low = v[2][0];
    v[2][0] = v[2][1];
    v[2][1] = low;
}

static void rounds(word_t *v, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        half(v, 13U, 16U);
        half(v, 17U, 21U);
    }
}

uint64_t sway_siphash(const uint8_t *key, const uint8_t *bytes, size_t size)
{
    static const uint8_t start[33] = "uespemosmodnarodarenegylsetybdet";
    word_t v[4];
    for (unsigned i = 0; i < 8U; i++) {
        v[i / 2U][i % 2U] = part_at(start + 4U * i, 4U) ^ part_at(key + 4U * (i % 4U), 4U);
    }
    for (size_t left = size;; bytes += WORD, left -= WORD) {
        word_t word = {part_at(bytes, left), left > 4U ? part_at(bytes + 4, left - 4U) : 0U};
        word[1] |= left < WORD ? (uint32_t)size << 24 : 0U;
        v[3][0] ^= word[0];
        v[3][1] ^= word[1];
        rounds(v, 2U);
        v[0][0] ^= word[0];
        v[0][1] ^= word[1];
        if (left < WORD) {
            break;
        }
    }
    v[2][0] ^= 0xFFU;
    rounds(v, 4U);
    return (uint64_t)(v[0][1] ^ v[1][1] ^ v[2][1] ^ v[3][1]) << 32 |
           (v[0][0] ^ v[1][0] ^ v[2][0] ^ v[3][0]);
}

/// sway_siphash: SipHash-2-4 (Aumasson and Bernstein, INDOCRYPT 2012), a keyed 64-bit checksum for
/// short messages: without the 128-bit key nobody can make or predict it.
#ifndef SWAY_SIPHASH_H
#define SWAY_SIPHASH_H

#include <stddef.h>
#include <stdint.h>

#define SWAY_SIPHASH_KEY 16U ///< bytes of a key

/// The same on every machine, whatever its byte order.
uint64_t sway_siphash(const uint8_t *key, const uint8_t *bytes, size_t size);

#endif

/// sway_wide: exact 32 x 32 -> 64 bit products.
///
/// An ARMv6-M has no such instruction, and its compiler calls a 64 x 64 bit routine instead; four
/// 16-bit products take half as long. The result is the same.
#ifndef SWAY_WIDE_H
#define SWAY_WIDE_H

#include <stdint.h>

#if defined(__ARM_ARCH_6M__)
static inline uint64_t sway_wide_unsigned(uint32_t a, uint32_t b)
{
    const uint32_t a_low = a & 0xFFFFU;
    const uint32_t a_high = a >> 16;
    const uint32_t b_low = b & 0xFFFFU;
    const uint32_t b_high = b >> 16;
    const uint32_t low = a_low * b_low;
    const uint32_t first = a_high * b_low;
    const uint32_t middle = first + (low >> 16); // below 2^32: (2^16-1)^2 + 2^16 - 1
    const uint32_t second = a_low * b_high + (middle & 0xFFFFU);
    const uint32_t high = a_high * b_high + (middle >> 16) + (second >> 16);
    return ((uint64_t)high << 32) | (second << 16) | (low & 0xFFFFU);
}
#else
static inline uint64_t sway_wide_unsigned(uint32_t a, uint32_t b)
{
    return (uint64_t)a * b;
}
#endif

static inline int64_t sway_wide(int32_t a, int32_t b)
{
#if defined(__ARM_ARCH_6M__)
    /* two's complement: a negative factor counts 2^32 too much */
    const uint64_t product = sway_wide_unsigned((uint32_t)a, (uint32_t)b);
    const uint32_t excess = (a < 0 ? (uint32_t)b : 0U) + (b < 0 ? (uint32_t)a : 0U);
    return (int64_t)(product - ((uint64_t)excess << 32));
#else
    return (int64_t)a * b;
#endif
}

/// value / 2^30, rounded; |value| <= 2^61. Made positive first: right shifts of negative numbers
/// are not portable.
static inline int32_t sway_wide_round(int64_t value)
{
    const uint64_t positive = (uint64_t)(value + (INT64_C(1) << 62) + (INT64_C(1) << 29));
    return (int32_t)((int64_t)(positive >> 30) - (INT64_C(1) << 32));
}

/// a * b / 2^30, rounded, for |b| <= 2^30.
static inline int32_t sway_wide_q30(int32_t a, int32_t b)
{
    return sway_wide_round(sway_wide(a, b));
}

#endif

// SPDX-License-Identifier: MIT
/// sway_int64: exact 32 x 32 -> 64 bit products, and quotients of 64 bits.
///
/// An ARMv6-M has no such instruction, and its compiler calls a 64 x 64 bit routine instead; four
/// 16-bit products take half as long. The result is the same.
#ifndef SWAY_INT64_H
#define SWAY_INT64_H

#include <stdint.h>

#include "sway_config.h"

#if defined(__ARM_ARCH_6M__)
SWAY_INLINE uint64_t sway_int64_product_unsigned(uint32_t a, uint32_t b)
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
SWAY_INLINE uint64_t sway_int64_product_unsigned(uint32_t a, uint32_t b)
{
    return (uint64_t)a * b;
}
#endif

SWAY_INLINE int64_t sway_int64_product(int32_t a, int32_t b)
{
#if defined(__ARM_ARCH_6M__)
    /* two's complement: a negative factor counts 2^32 too much */
    const uint64_t product = sway_int64_product_unsigned((uint32_t)a, (uint32_t)b);
    const uint32_t excess = (a < 0 ? (uint32_t)b : 0U) + (b < 0 ? (uint32_t)a : 0U);
    return (int64_t)(product - ((uint64_t)excess << 32));
#else
    return (int64_t)a * b;
#endif
}

/// value / divisor, rounded towards 0, for |value| and |divisor| < 2^63, divisor not 0. Takes a
/// tenth of the flash of the compilers' own division and as long: about 20 instructions for each
/// bit of the quotient. So 64-bit words are divided nowhere else.
int64_t sway_int64_divide(int64_t value, int64_t divisor);

/// Sum of a[i] b[i], |a| and |b| < 2^29, exact as long as it is below 2^63.
SWAY_INLINE int64_t sway_int64_dot(const int32_t *a, const int32_t *b, uint32_t n)
{
#if defined(__ARM_ARCH_6M__) && defined(__GNUC__)
    /* The innermost loop of the estimator, a fifth of all it does. Compilers spill half of it to
     * the stack: 41 instructions a product instead of 22. */
    const int32_t *const end = a + n;
    uint32_t low = 0;
    uint32_t high = 0;
    if (n == 0U) {
        return 0;
    }
    __asm__(".syntax unified\n"
            "1: ldmia %[a]!, {r3}\n"
            "ldmia %[b]!, {r4}\n"
            "uxth r5, r3\n"
            "uxth r6, r4\n"
            "asrs r3, r3, #16\n"
            "asrs r4, r4, #16\n"
            "mov r8, r3\n"
            "muls r3, r6, r3\n" // upper a, lower b
            "muls r6, r5, r6\n" // lower parts
            "muls r5, r4, r5\n" // lower a, upper b
            "adds r3, r3, r5\n"
            "mov r5, r8\n"
            "muls r4, r5, r4\n" // upper parts
            "adds %[high], %[high], r4\n"
            "lsls r5, r3, #16\n"
            "asrs r3, r3, #16\n"
            "movs r4, #0\n"
            "adds r6, r6, r5\n"
            "adcs %[high], %[high], r3\n"
            "adds %[low], %[low], r6\n"
            "adcs %[high], %[high], r4\n"
            "cmp %[a], %[end]\n"
            "bne 1b\n"
            : [a] "+l"(a), [b] "+l"(b), [low] "+l"(low), [high] "+l"(high)
            : [end] "h"(end)
            : "r3", "r4", "r5", "r6", "r8", "cc", "memory");
    return (int64_t)(((uint64_t)high << 32) | low);
#else
    int64_t sum = 0;
    for (uint32_t i = 0; i < n; i++) {
        sum += (int64_t)a[i] * b[i];
    }
    return sum;
#endif
}

/// value / 2^30, rounded; |value| <= 2^61. Made positive first: right shifts of negative numbers
/// are not portable.
SWAY_INLINE int32_t sway_int64_round(int64_t value)
{
    const uint64_t positive = (uint64_t)(value + (INT64_C(1) << 62) + (INT64_C(1) << 29));
    return (int32_t)((int64_t)(positive >> 30) - (INT64_C(1) << 32));
}

/// a * b / 2^30, rounded, for |b| <= 2^30.
SWAY_INLINE int32_t sway_int64_q30(int32_t a, int32_t b)
{
    return sway_int64_round(sway_int64_product(a, b));
}

#endif

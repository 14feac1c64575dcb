// SPDX-License-Identifier: MIT
#include "arithmetic/sway_real.h"

#include <limits.h>

#include "arithmetic/sway_int64.h"

/* Mantissas are worked on as magnitudes in unsigned words: shifts of negative numbers are not
 * defined alike everywhere, and symmetric rounding keeps f(-x) = -f(x). */

#define MANTISSA_BITS 31
#define Q31_ONE (INT64_C(1) << 31)
#define TOP UINT32_C(0x80000000)
#define ZERO ((sway_real_word_t)0)

typedef sway_real_word_t word_t;

static uint32_t magnitude(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

/* Zeros above the highest bit of a word that is not 0. */
static uint32_t leading_zeros(uint32_t word)
{
#if defined(__GNUC__)
    return (uint32_t)__builtin_clz(word);
#else
    uint32_t zeros = 31;
    for (uint32_t step = 16; step > 0U; step /= 2U) {
        if ((word >> step) != 0U) {
            word >>= step;
            zeros -= step;
        }
    }
    return zeros;
#endif
}

static word_t beyond_range(bool negative, int32_t exponent)
{
    sway_real_t largest = {INT32_MAX, SWAY_REAL_EXPONENT_MAX};
    if (exponent < 0) {
        return ZERO;
    }
    largest.m = negative ? -INT32_MAX : INT32_MAX;
    return sway_real_to_word(largest);
}

SWAY_INLINE word_t assemble(bool negative, uint32_t mantissa, int32_t exponent)
{
    return ((word_t)(uint32_t)exponent << 32) | (negative ? 0U - mantissa : mantissa);
}

/* Mantissa in [2^30, 2^31) and exponent, which may be out of range, to a number. */
SWAY_INLINE word_t ranged(bool negative, uint32_t mantissa, int32_t exponent)
{
    if ((uint32_t)(exponent + SWAY_REAL_EXPONENT_MAX) > 2U * SWAY_REAL_EXPONENT_MAX) {
        return beyond_range(negative, exponent);
    }
    return assemble(negative, mantissa, exponent);
}

/* The same where the rounding may have reached 2^31. */
SWAY_INLINE word_t finish(bool negative, uint32_t mantissa, int32_t exponent)
{
    if (mantissa == TOP) {
        mantissa >>= 1;
        exponent += 1;
    }
    return ranged(negative, mantissa, exponent);
}

/* 32 bits, the highest one set, and the exponent of the last: rounded to 31. */
static word_t halve(bool negative, uint32_t mantissa, int32_t exponent)
{
    return finish(negative, (mantissa >> 1) + (mantissa & 1U), exponent + 1);
}

static word_t pack(bool negative, uint32_t high, uint32_t low, int32_t exponent)
{
    if (high == 0U) {
        if (low == 0U) {
            return ZERO;
        }
        const uint32_t zeros = leading_zeros(low);
        return halve(negative, low << zeros, exponent - (int32_t)zeros);
    }
    const uint32_t zeros = leading_zeros(high);
    const uint32_t from_low = zeros > 0U ? low >> (32U - zeros) : 0U;
    return halve(negative, (high << zeros) | from_low, exponent + 32 - (int32_t)zeros);
}

word_t sway_real_word(int64_t value, int32_t exponent)
{
    const uint64_t mag = value < 0 ? UINT64_C(0) - (uint64_t)value : (uint64_t)value;
    return pack(value < 0, (uint32_t)(mag >> 32), (uint32_t)mag, exponent);
}

word_t sway_real_word_int(int32_t value)
{
    return pack(value < 0, 0U, magnitude(value), 0);
}

word_t sway_real_word_micro(int64_t value)
{
    return sway_real_word_div(sway_real_word(value, 0), sway_real_word_int(1000000));
}

word_t sway_real_word_ratio(int32_t numerator, int32_t denominator)
{
    return sway_real_word_div(sway_real_word_int(numerator), sway_real_word_int(denominator));
}

/* |a| + |b| for a.e = b.e + distance, distance 0..32. */
static word_t add_magnitudes(sway_real_t a, uint32_t small, uint32_t distance)
{
    const uint32_t high = magnitude(a.m) + (distance < 32U ? small >> distance : 0U);
    if (high >= TOP) {
        return ranged(a.m < 0, (high >> 1) + (high & 1U), a.e + 1); // high < 2^32 - 1
    }
    /* here distance > 0: two mantissas of one exponent add up to 2^31 or more */
    const uint32_t round = (small >> (distance - 1U)) & 1U;
    return finish(a.m < 0, high + round, a.e);
}

/* |a| - |b| for a.e = b.e + distance, distance 0..32, with the sign of a. */
static word_t subtract_magnitudes(sway_real_t a, uint32_t small, uint32_t distance)
{
    const uint32_t big = magnitude(a.m);
    if (distance == 0U) {
        return big >= small ? pack(a.m < 0, 0U, big - small, a.e)
                            : pack(a.m >= 0, 0U, small - big, a.e);
    }
    const uint32_t below = distance < 32U ? small << (32U - distance) : small;
    const uint32_t above = distance < 32U ? small >> distance : 0U;
    const uint32_t low = 0U - below;
    const uint32_t high = big - above - (below != 0U ? 1U : 0U);
    if (high >= TOP / 2U) { // less than `big`, of the same exponent: always a number
        return assemble(a.m < 0, high + (low >> 31), a.e);
    }
    if (high >= TOP / 4U) { // always so for distance > 1; then a.e - 1 is in range, as b.e is
        const uint32_t mantissa = (high << 1) + (low >> 31) + ((low >> 30) & 1U);
        return mantissa == TOP ? assemble(a.m < 0, TOP / 2U, a.e)
                               : assemble(a.m < 0, mantissa, a.e - 1);
    }
    return pack(a.m < 0, high, low, a.e - 32);
}

word_t sway_real_word_add(word_t first, word_t second)
{
    sway_real_t a = sway_real_of_word(first);
    sway_real_t b = sway_real_of_word(second);
    if (a.m == 0) {
        return second;
    }
    if (b.m == 0) {
        return first;
    }
    if (a.e < b.e) {
        const sway_real_t swap = a;
        a = b;
        b = swap;
    }
    const uint32_t distance = (uint32_t)(a.e - b.e);
    if (distance > 32U) {
        return sway_real_to_word(a);
    }
    const uint32_t small = magnitude(b.m);
    return (a.m ^ b.m) >= 0 ? add_magnitudes(a, small, distance)
                            : subtract_magnitudes(a, small, distance);
}

word_t sway_real_word_sub(word_t a, word_t b)
{
    return sway_real_word_add(a, (b & ~(word_t)UINT32_MAX) | (0U - (uint32_t)b));
}

word_t sway_real_word_mul(word_t first, word_t second)
{
    const sway_real_t a = sway_real_of_word(first);
    const sway_real_t b = sway_real_of_word(second);
    if (a.m == 0 || b.m == 0) {
        return ZERO;
    }
    const uint64_t product = sway_int64_product_unsigned(magnitude(a.m), magnitude(b.m));
    const uint32_t high = (uint32_t)(product >> 32); // 2^28 .. 2^30
    const uint32_t low = (uint32_t)product;
    const bool negative = (a.m ^ b.m) < 0;
    if (high >= (UINT32_C(1) << 29)) {
        const uint32_t mantissa = (high << 1) + (low >> 31) + ((low >> 30) & 1U);
        return ranged(negative, mantissa, a.e + b.e + 31); // of (2^31 - 1)^2 at most
    }
    return finish(negative, (high << 2) + (low >> 30) + ((low >> 29) & 1U), a.e + b.e + 30);
}

/* a 2^32 / b, rounded down, for 2^30 <= a < b < 2^31. */
static uint32_t fraction(uint32_t a, uint32_t b)
{
#if defined(__ARM_ARCH_6M__) // has no division at all: bit by bit
    uint32_t quotient = 0;
    for (int bits = 0; bits < 32; bits += 4) {
        for (int bit = 0; bit < 4; bit++) {
            quotient <<= 1;
            a <<= 1;
            if (a >= b) {
                a -= b;
                quotient += 1U;
            }
        }
    }
    return quotient;
#else
    return (uint32_t)(((uint64_t)a << 32) / b);
#endif
}

word_t sway_real_word_div(word_t first, word_t second)
{
    const sway_real_t a = sway_real_of_word(first);
    const sway_real_t b = sway_real_of_word(second);
    if (a.m == 0 || b.m == 0) {
        return ZERO;
    }
    const uint32_t above = magnitude(a.m);
    const uint32_t below = magnitude(b.m);
    const bool negative = (a.m ^ b.m) < 0;
    if (above < below) {
        return halve(negative, fraction(above, below), a.e - b.e - 32);
    }
    /* 1 + (a - b) / b, of which the last bit is cut off */
    const uint32_t rest = fraction(above - below, below) >> 1;
    return halve(negative, rest | TOP, a.e - b.e - 31);
}

word_t sway_real_word_scale(word_t word, int32_t shift)
{
    const sway_real_t a = sway_real_of_word(word);
    return a.m == 0 ? ZERO : ranged(a.m < 0, magnitude(a.m), a.e + shift);
}

/* Root of value = high 2^32 + low, rounded down, for high >= 2^30: its upper half from `high`, the
 * lower one by one division (Zimmermann, INRIA RR-3805). */
static uint32_t integer_sqrt(uint32_t high, uint32_t low)
{
    uint32_t root = UINT32_C(1) << 30; // as the first step would leave it
    uint32_t rest = high - root;
    for (uint32_t bit = UINT32_C(1) << 28; bit != 0U; bit >>= 2) {
        if (rest >= root + bit) {
            rest -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    /* (rest 2^16 + upper half of low) / (2 root), both halved: rest <= 2 root < 2^17 */
    const uint32_t half = (rest << 15) | (low >> 17);
    const uint32_t lower = half / root;
    const uint64_t left = ((uint64_t)(half % root) << 17) | (low & UINT32_C(0x1FFFF));
    const uint64_t square = (uint64_t)lower * lower;
    return (root << 16) + lower - (left < square ? 1U : 0U);
}

word_t sway_real_word_sqrt(word_t word)
{
    const sway_real_t a = sway_real_of_word(word);
    if (a.m <= 0) {
        return ZERO;
    }
    const uint32_t odd = (uint32_t)a.e & 1U;
    return halve(false, integer_sqrt((uint32_t)a.m << odd, 0U), (a.e - (int32_t)odd) / 2 - 16);
}

/* Horner's rule in Q31 for |y| < 1: c[0] + y (c[1] + y (...)); coefficients in Q31, |.| < 2^32. */
static int64_t horner_q31(int64_t y, const int64_t *c, int count)
{
    int64_t sum = c[count - 1];
    for (int i = count - 2; i >= 0; i--) {
        sum = c[i] + sum * y / Q31_ONE;
    }
    return sum;
}

/* a * 2^31 as an integer, for |a| < 2^31. */
static int64_t to_q31(sway_real_t a)
{
    return sway_real_to_int64(a, 31);
}

word_t sway_real_word_exp(word_t word)
{
    static const int64_t taylor[] = {INT64_C(2147483648),
                                     INT64_C(2147483648),
                                     INT64_C(1073741824),
                                     357913941,
                                     89478485,
                                     17895697,
                                     2982616,
                                     426088,
                                     53261,
                                     5918,
                                     592};
    const sway_real_t log2_e = {1549082005, -30};
    const sway_real_t ln_2 = {1488522236, -31};
    const sway_real_t limit = sway_real_int(60000);
    sway_real_t a = sway_real_of_word(word);
    if (sway_real_compare(sway_real_abs(a), limit) > 0) {
        a = a.m < 0 ? sway_real_neg(limit) : limit;
    }
    const int32_t octaves = (int32_t)sway_real_to_int64(sway_real_mul(a, log2_e), 0);
    const sway_real_t rest = sway_real_sub(a, sway_real_mul(sway_real_int(octaves), ln_2));
    return sway_real_word(horner_q31(to_q31(rest), taylor, 11), octaves - 31);
}

word_t sway_real_word_ln(word_t word)
{
    const sway_real_t ln_2 = {1488522236, -31};
    const sway_real_t a = sway_real_of_word(word);
    if (a.m <= 0) {
        return ZERO;
    }
    /* a = x 2^k with x in [0.75, 1.5); a linear start, then two Newton steps of exp(y) = x. */
    sway_real_t x = {a.m, -MANTISSA_BITS};
    int32_t octaves = a.e + MANTISSA_BITS;
    if (a.m < 1610612736) {
        x.e += 1;
        octaves -= 1;
    }
    sway_real_t y = sway_real_sub(x, sway_real_int(1));
    for (int step = 0; step < 4; step++) {
        const sway_real_t ratio = sway_real_mul(x, sway_real_exp(sway_real_neg(y)));
        y = sway_real_add(y, sway_real_sub(ratio, sway_real_int(1)));
    }
    return sway_real_to_word(sway_real_add(y, sway_real_mul(sway_real_int(octaves), ln_2)));
}

void sway_real_sincos(sway_real_t a, sway_real_t *sine, sway_real_t *cosine)
{
    static const int64_t sin_taylor[] = {
        INT64_C(2147483648), -357913941, 17895697, -426088, 5918, -54};
    static const int64_t cos_taylor[] = {
        INT64_C(2147483648), -1073741824, 89478485, -2982616, 53261, -592, 4};
    const sway_real_t two_by_pi = {1367130551, -31};
    const sway_real_t half_pi = {1686629713, -30};
    const sway_real_t half_pi_rest = {1121027178, -64}; // what half_pi lacks: 6.0771e-11
    if (sway_real_compare(sway_real_abs(a), sway_real_scale(sway_real_int(1), 20)) >= 0) {
        *sine = sway_real_zero();
        *cosine = sway_real_int(1);
        return;
    }
    const int32_t quadrant = (int32_t)sway_real_to_int64(sway_real_mul(a, two_by_pi), 0);
    const sway_real_t turns = sway_real_int(quadrant);
    sway_real_t rest = sway_real_sub(a, sway_real_mul(turns, half_pi));
    rest = sway_real_sub(rest, sway_real_mul(turns, half_pi_rest));
    const int64_t y = to_q31(rest);
    const int64_t y2 = y * y / Q31_ONE;
    const sway_real_t s = sway_real_mul(rest, sway_real(horner_q31(y2, sin_taylor, 6), -31));
    const sway_real_t c = sway_real(horner_q31(y2, cos_taylor, 7), -31);
    switch ((uint32_t)quadrant & 3U) {
    case 0:
        *sine = s;
        *cosine = c;
        break;
    case 1:
        *sine = c;
        *cosine = sway_real_neg(s);
        break;
    case 2:
        *sine = sway_real_neg(s);
        *cosine = sway_real_neg(c);
        break;
    default:
        *sine = sway_real_neg(c);
        *cosine = s;
        break;
    }
}

word_t sway_real_word_atan2(word_t above, word_t along_x)
{
    const sway_real_t y = sway_real_of_word(above);
    const sway_real_t x = sway_real_of_word(along_x);
    const sway_real_t ax = sway_real_abs(x);
    const sway_real_t ay = sway_real_abs(y);
    const bool steep = sway_real_less(ax, ay);
    if (ax.m == 0 && ay.m == 0) {
        return ZERO;
    }
    const sway_real_t big = steep ? ay : ax;
    const sway_real_t small = steep ? ax : ay;
    const sway_real_t t = sway_real_div(small, big);
    /* Start within 4e-3 of atan t, then one turn by the angle that is left. */
    const sway_real_t one = sway_real_int(1);
    const sway_real_t bend = sway_real_mul(sway_real_ratio(273, 1000), sway_real_sub(one, t));
    sway_real_t angle = sway_real_mul(t, sway_real_add(sway_real_scale(sway_real_pi(), -2), bend));
    sway_real_t s;
    sway_real_t c;
    sway_real_sincos(angle, &s, &c);
    const sway_real_t across = sway_real_sub(sway_real_mul(t, c), s);
    const sway_real_t along = sway_real_add(c, sway_real_mul(t, s));
    const sway_real_t d = sway_real_div(across, along);
    const sway_real_t cubic =
        sway_real_div(sway_real_mul(d, sway_real_mul(d, d)), sway_real_int(3));
    angle = sway_real_add(angle, sway_real_sub(d, cubic));
    if (steep) {
        angle = sway_real_sub(sway_real_scale(sway_real_pi(), -1), angle);
    }
    if (x.m < 0) {
        angle = sway_real_sub(sway_real_pi(), angle);
    }
    return sway_real_to_word(y.m < 0 ? sway_real_neg(angle) : angle);
}

int sway_real_compare(sway_real_t a, sway_real_t b)
{
    const int sa = sway_real_sign(a);
    const int sb = sway_real_sign(b);
    if (sa != sb) {
        return sa < sb ? -1 : 1;
    }
    if (sa == 0) {
        return 0;
    }
    if (a.e != b.e) {
        return (a.e < b.e) == (sa > 0) ? -1 : 1;
    }
    return (a.m > b.m) - (a.m < b.m);
}

word_t sway_real_word_min(word_t a, word_t b)
{
    return sway_real_less(sway_real_of_word(b), sway_real_of_word(a)) ? b : a;
}

word_t sway_real_word_max(word_t a, word_t b)
{
    return sway_real_less(sway_real_of_word(a), sway_real_of_word(b)) ? b : a;
}

int64_t sway_real_to_int64(sway_real_t a, int32_t shift)
{
    const int32_t exponent = a.e + shift;
    uint64_t mag = magnitude(a.m);
    if (a.m == 0 || exponent < -32) {
        return 0;
    }
    if (exponent > 31) {
        mag = UINT64_C(1) << 62;
    } else if (exponent >= 0) {
        mag <<= exponent;
    } else {
        mag = (mag >> -exponent) + ((mag >> (-exponent - 1)) & 1U);
    }
    return a.m < 0 ? -(int64_t)mag : (int64_t)mag;
}

int32_t sway_real_to_int(sway_real_t a, int32_t scale, int32_t low, int32_t high)
{
    const int64_t value = sway_real_to_int64(sway_real_mul(a, sway_real_int(scale)), 0);
    if (value < low) {
        return low;
    }
    return value > high ? high : (int32_t)value;
}

sway_complex_t sway_complex_add(sway_complex_t a, sway_complex_t b)
{
    return sway_complex(sway_real_add(a.re, b.re), sway_real_add(a.im, b.im));
}

sway_complex_t sway_complex_sub(sway_complex_t a, sway_complex_t b)
{
    return sway_complex(sway_real_sub(a.re, b.re), sway_real_sub(a.im, b.im));
}

sway_complex_t sway_complex_mul(sway_complex_t a, sway_complex_t b)
{
    return sway_complex(sway_real_sub(sway_real_mul(a.re, b.re), sway_real_mul(a.im, b.im)),
                        sway_real_add(sway_real_mul(a.re, b.im), sway_real_mul(a.im, b.re)));
}

sway_complex_t sway_complex_scale(sway_complex_t a, sway_real_t factor)
{
    return sway_complex(sway_real_mul(a.re, factor), sway_real_mul(a.im, factor));
}

sway_complex_t sway_complex_conj(sway_complex_t a)
{
    return sway_complex(a.re, sway_real_neg(a.im));
}

sway_complex_t sway_complex_div(sway_complex_t a, sway_complex_t b)
{
    const sway_real_t norm = sway_complex_norm(b);
    const sway_complex_t product = sway_complex_mul(a, sway_complex_conj(b));
    return sway_complex(sway_real_div(product.re, norm), sway_real_div(product.im, norm));
}

word_t sway_complex_word_norm(word_t re, word_t im)
{
    return sway_real_word_add(sway_real_word_mul(re, re), sway_real_word_mul(im, im));
}

word_t sway_complex_word_abs(word_t re, word_t im)
{
    return sway_real_word_sqrt(sway_complex_word_norm(re, im));
}

sway_complex_t sway_complex_unit(sway_real_t angle)
{
    sway_complex_t result;
    sway_real_sincos(angle, &result.im, &result.re);
    return result;
}

#include "sway_real.h"

#include <limits.h>

#include "sway_wide.h"

/* Mantissas are worked on as magnitudes in unsigned words: shifts of negative numbers are not
 * defined alike everywhere, and symmetric rounding keeps f(-x) = -f(x). */

#define MANTISSA_BITS 31
#define Q31_ONE (UINT64_C(1) << 31)

static uint32_t magnitude(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

static int32_t bit_length_32(uint32_t word)
{
    int32_t length = 0;
    for (int32_t step = 16; step > 0; step /= 2) {
        if ((word >> step) != 0U) {
            word >>= step;
            length += step;
        }
    }
    return length + (int32_t)(word != 0U);
}

static int32_t bit_length(uint64_t value)
{
    const uint32_t high = (uint32_t)(value >> 32);
    return high != 0U ? 32 + bit_length_32(high) : bit_length_32((uint32_t)value);
}

static sway_real_t pack(bool negative, uint64_t mag, int32_t exponent)
{
    sway_real_t result = {0, 0};
    if (mag == 0U) {
        return result;
    }
    const int32_t shift = bit_length(mag) - MANTISSA_BITS;
    if (shift > 0) {
        mag = (mag >> shift) + ((mag >> (shift - 1)) & 1U);
        exponent += shift;
        if (mag == Q31_ONE) {
            mag >>= 1;
            exponent += 1;
        }
    } else if (shift < 0) {
        mag <<= -shift;
        exponent += shift;
    }
    if (exponent < -SWAY_REAL_EXPONENT_MAX) {
        return result;
    }
    if (exponent > SWAY_REAL_EXPONENT_MAX) {
        mag = Q31_ONE - 1U;
        exponent = SWAY_REAL_EXPONENT_MAX;
    }
    result.m = negative ? -(int32_t)mag : (int32_t)mag;
    result.e = exponent;
    return result;
}

sway_real_t sway_real(int64_t value, int32_t exponent)
{
    const uint64_t mag = value < 0 ? UINT64_C(0) - (uint64_t)value : (uint64_t)value;
    return pack(value < 0, mag, exponent);
}

sway_real_t sway_real_int(int64_t value)
{
    return sway_real(value, 0);
}

sway_real_t sway_real_ratio(int64_t numerator, int64_t denominator)
{
    return sway_real_div(sway_real_int(numerator), sway_real_int(denominator));
}

/* Mantissa in [2^30, 2^31] (the rounding may have reached the top) and exponent to a number. */
static sway_real_t finish(bool negative, uint32_t mantissa, int32_t exponent)
{
    if (mantissa == (uint32_t)Q31_ONE) {
        mantissa >>= 1;
        exponent += 1;
    }
    if (exponent > SWAY_REAL_EXPONENT_MAX || exponent < -SWAY_REAL_EXPONENT_MAX) {
        return pack(negative, mantissa, exponent);
    }
    const sway_real_t result = {negative ? -(int32_t)mantissa : (int32_t)mantissa, exponent};
    return result;
}

/* |a| + |b| for a.e = b.e + distance, distance 0..32. */
static sway_real_t add_magnitudes(sway_real_t a, sway_real_t b, uint32_t distance)
{
    const uint32_t small = magnitude(b.m);
    const uint32_t high = magnitude(a.m) + (distance < 32U ? small >> distance : 0U);
    if (high >= (uint32_t)Q31_ONE) {
        return finish(a.m < 0, (high >> 1) + (high & 1U), a.e + 1);
    }
    /* here distance > 0: two mantissas of one exponent add up to 2^31 or more */
    const uint32_t round = (small >> (distance - 1U)) & 1U;
    return finish(a.m < 0, high + round, a.e);
}

sway_real_t sway_real_add(sway_real_t a, sway_real_t b)
{
    if (a.m == 0) {
        return b;
    }
    if (b.m == 0) {
        return a;
    }
    if (a.e < b.e) {
        const sway_real_t swap = a;
        a = b;
        b = swap;
    }
    const int32_t distance = a.e - b.e;
    if (distance > 32) {
        return a;
    }
    if ((a.m < 0) == (b.m < 0)) {
        return add_magnitudes(a, b, (uint32_t)distance);
    }
    const uint64_t big = (uint64_t)magnitude(a.m) << 32;
    const uint64_t small = ((uint64_t)magnitude(b.m) << 32) >> distance;
    const int32_t exponent = a.e - 32;
    return big >= small ? pack(a.m < 0, big - small, exponent)
                        : pack(b.m < 0, small - big, exponent);
}

sway_real_t sway_real_neg(sway_real_t a)
{
    a.m = -a.m; // never INT32_MIN: |m| < 2^31
    return a;
}

sway_real_t sway_real_sub(sway_real_t a, sway_real_t b)
{
    return sway_real_add(a, sway_real_neg(b));
}

sway_real_t sway_real_mul(sway_real_t a, sway_real_t b)
{
    if (a.m == 0 || b.m == 0) {
        const sway_real_t zero = {0, 0};
        return zero;
    }
    const uint64_t product = sway_wide_unsigned(magnitude(a.m), magnitude(b.m));
    const uint32_t high = (uint32_t)(product >> 32); // 2^28 .. 2^30
    const uint32_t low = (uint32_t)product;
    const bool negative = (a.m < 0) != (b.m < 0);
    if (high >= (UINT32_C(1) << 29)) {
        const uint32_t mantissa = (high << 1) + (low >> 31) + ((low >> 30) & 1U);
        return finish(negative, mantissa, a.e + b.e + 31);
    }
    return finish(negative, (high << 2) + (low >> 30) + ((low >> 29) & 1U), a.e + b.e + 30);
}

sway_real_t sway_real_div(sway_real_t a, sway_real_t b)
{
    if (b.m == 0) {
        return b;
    }
    const uint64_t quotient = ((uint64_t)magnitude(a.m) << 32) / magnitude(b.m);
    return pack((a.m < 0) != (b.m < 0), quotient, a.e - b.e - 32);
}

sway_real_t sway_real_abs(sway_real_t a)
{
    return a.m < 0 ? sway_real_neg(a) : a;
}

sway_real_t sway_real_scale(sway_real_t a, int32_t shift)
{
    return pack(a.m < 0, magnitude(a.m), a.e + shift);
}

static uint32_t integer_sqrt(uint64_t value)
{
    uint64_t root = 0;
    for (uint64_t bit = UINT64_C(1) << 62; bit != 0U; bit >>= 2) {
        if (value >= root + bit) {
            value -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return (uint32_t)root;
}

sway_real_t sway_real_sqrt(sway_real_t a)
{
    if (a.m <= 0) {
        const sway_real_t zero = {0, 0};
        return zero;
    }
    const int32_t odd = a.e % 2 != 0 ? 1 : 0;
    return pack(false, integer_sqrt((uint64_t)(uint32_t)a.m << (32 + odd)), (a.e - odd) / 2 - 16);
}

/* Horner's rule in Q31 for |y| < 1: c[0] + y (c[1] + y (...)); coefficients in Q31, |.| < 2^32. */
static int64_t horner_q31(int64_t y, const int64_t *c, int count)
{
    int64_t sum = c[count - 1];
    for (int i = count - 2; i >= 0; i--) {
        sum = c[i] + sum * y / (int64_t)Q31_ONE;
    }
    return sum;
}

/* a * 2^31 as an integer, for |a| < 2^31. */
static int64_t to_q31(sway_real_t a)
{
    return sway_real_to_int64(a, 31);
}

sway_real_t sway_real_exp(sway_real_t a)
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
    if (sway_real_compare(sway_real_abs(a), limit) > 0) {
        a = a.m < 0 ? sway_real_neg(limit) : limit;
    }
    const int64_t octaves = sway_real_to_int64(sway_real_mul(a, log2_e), 0);
    const sway_real_t rest = sway_real_sub(a, sway_real_mul(sway_real_int(octaves), ln_2));
    return sway_real(horner_q31(to_q31(rest), taylor, 11), (int32_t)octaves - 31);
}

sway_real_t sway_real_ln(sway_real_t a)
{
    const sway_real_t ln_2 = {1488522236, -31};
    if (a.m <= 0) {
        const sway_real_t zero = {0, 0};
        return zero;
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
    return sway_real_add(y, sway_real_mul(sway_real_int(octaves), ln_2));
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
        *sine = sway_real_int(0);
        *cosine = sway_real_int(1);
        return;
    }
    const int64_t quadrant = sway_real_to_int64(sway_real_mul(a, two_by_pi), 0);
    const sway_real_t turns = sway_real_int(quadrant);
    sway_real_t rest = sway_real_sub(a, sway_real_mul(turns, half_pi));
    rest = sway_real_sub(rest, sway_real_mul(turns, half_pi_rest));
    const int64_t y = to_q31(rest);
    const int64_t y2 = y * y / (int64_t)Q31_ONE;
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

sway_real_t sway_real_atan2(sway_real_t y, sway_real_t x)
{
    const sway_real_t ax = sway_real_abs(x);
    const sway_real_t ay = sway_real_abs(y);
    const bool steep = sway_real_less(ax, ay);
    if (ax.m == 0 && ay.m == 0) {
        return ax;
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
    return y.m < 0 ? sway_real_neg(angle) : angle;
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

bool sway_real_less(sway_real_t a, sway_real_t b)
{
    return sway_real_compare(a, b) < 0;
}

bool sway_real_is_zero(sway_real_t a)
{
    return a.m == 0;
}

int sway_real_sign(sway_real_t a)
{
    return (a.m > 0) - (a.m < 0);
}

sway_real_t sway_real_min(sway_real_t a, sway_real_t b)
{
    return sway_real_less(b, a) ? b : a;
}

sway_real_t sway_real_max(sway_real_t a, sway_real_t b)
{
    return sway_real_less(a, b) ? b : a;
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

sway_real_t sway_real_pi(void)
{
    const sway_real_t pi = {1686629713, -29};
    return pi;
}

sway_complex_t sway_complex(sway_real_t re, sway_real_t im)
{
    const sway_complex_t result = {re, im};
    return result;
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

sway_real_t sway_complex_norm(sway_complex_t a)
{
    return sway_real_add(sway_real_mul(a.re, a.re), sway_real_mul(a.im, a.im));
}

sway_real_t sway_complex_abs(sway_complex_t a)
{
    return sway_real_sqrt(sway_complex_norm(a));
}

sway_real_t sway_complex_arg(sway_complex_t a)
{
    return sway_real_atan2(a.im, a.re);
}

sway_complex_t sway_complex_unit(sway_real_t angle)
{
    sway_complex_t result;
    sway_real_sincos(angle, &result.im, &result.re);
    return result;
}

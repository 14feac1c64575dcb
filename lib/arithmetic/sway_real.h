// SPDX-License-Identifier: MIT
/// sway_real: numbers with a 31-bit mantissa and their own exponent, in integers only.
///
/// The sliding sums of swaywatch are exact integers. What follows them (least squares, roots of the
/// single-track model, ratios of lines) spans many decades; a fixed binary point would either
/// overflow or lose digits there. A `sway_real_t` is m * 2^e with 2^30 <= |m| < 2^31, or zero: a
/// relative resolution of 4.7e-10 everywhere, the same bits on every machine, no float, no heap.
///
/// Every operation rounds to nearest (ties away from zero) and is total: it has a defined result
/// for every input, listed with it. Exponents saturate at +-SWAY_REAL_EXPONENT_MAX; underflow is
/// zero. All functions are pure and of constant complexity.
#ifndef SWAY_REAL_H
#define SWAY_REAL_H

#include <stdbool.h>
#include <stdint.h>

#include "sway_config.h"

#define SWAY_REAL_EXPONENT_MAX 100000

typedef struct {
    int32_t m; ///< mantissa, 0 or 2^30 <= |m| < 2^31
    int32_t e; ///< exponent of two; 0 where m is 0
} sway_real_t;

/// A complex number, rectangular.
typedef struct {
    sway_real_t re;
    sway_real_t im;
} sway_complex_t;

/// A number in one 64-bit word, mantissa below, exponent above. This is how numbers come back from
/// functions: an ARM returns a word in registers but every structure through memory, which would
/// make each sum and product half as slow again.
typedef uint64_t sway_real_word_t;

SWAY_INLINE sway_real_word_t sway_real_to_word(sway_real_t a)
{
    return ((uint64_t)(uint32_t)a.e << 32) | (uint32_t)a.m;
}

SWAY_INLINE sway_real_t sway_real_of_word(sway_real_word_t word)
{
    sway_real_t a;
    a.m = (int32_t)(uint32_t)word;
    a.e = (int32_t)(uint32_t)(word >> 32);
    return a;
}

/// The arithmetic itself; use the functions without `word` below.
sway_real_word_t sway_real_word(int64_t value, int32_t exponent);
sway_real_word_t sway_real_word_int(int32_t value);
sway_real_word_t sway_real_word_micro(int64_t value);
sway_real_word_t sway_real_word_ratio(int32_t numerator, int32_t denominator);
sway_real_word_t sway_real_word_add(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_real_word_sub(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_real_word_mul(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_real_word_div(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_real_word_scale(sway_real_word_t a, int32_t shift);
sway_real_word_t sway_real_word_sqrt(sway_real_word_t a);
sway_real_word_t sway_real_word_exp(sway_real_word_t a);
sway_real_word_t sway_real_word_ln(sway_real_word_t a);
sway_real_word_t sway_real_word_atan2(sway_real_word_t y, sway_real_word_t x);
sway_real_word_t sway_real_word_min(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_real_word_max(sway_real_word_t a, sway_real_word_t b);
sway_real_word_t sway_complex_word_norm(sway_real_word_t re, sway_real_word_t im);
sway_real_word_t sway_complex_word_abs(sway_real_word_t re, sway_real_word_t im);

/// value * 2^exponent, rounded to 31 bits.
SWAY_INLINE sway_real_t sway_real(int64_t value, int32_t exponent)
{
    return sway_real_of_word(sway_real_word(value, exponent));
}

/// 0.
SWAY_INLINE sway_real_t sway_real_zero(void)
{
    return sway_real_of_word(0);
}

/// The integer `value`, exact; sway_real(value, 0) for one of 64 bits.
SWAY_INLINE sway_real_t sway_real_int(int32_t value)
{
    return sway_real_of_word(sway_real_word_int(value));
}

/// `value` millionths: of microradian, rad; of microseconds, s.
SWAY_INLINE sway_real_t sway_real_micro(int64_t value)
{
    return sway_real_of_word(sway_real_word_micro(value));
}

/// numerator / denominator; 0 for a denominator of 0. E.g. sway_real_ratio(981, 100) = 9.81.
SWAY_INLINE sway_real_t sway_real_ratio(int32_t numerator, int32_t denominator)
{
    return sway_real_of_word(sway_real_word_ratio(numerator, denominator));
}

SWAY_INLINE sway_real_t sway_real_add(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_add(sway_real_to_word(a), sway_real_to_word(b)));
}

SWAY_INLINE sway_real_t sway_real_sub(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_sub(sway_real_to_word(a), sway_real_to_word(b)));
}

SWAY_INLINE sway_real_t sway_real_mul(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_mul(sway_real_to_word(a), sway_real_to_word(b)));
}

SWAY_INLINE sway_real_t sway_real_square(sway_real_t a)
{
    return sway_real_mul(a, a);
}

/// a / b; 0 where b is 0 (callers that can meet it test first).
SWAY_INLINE sway_real_t sway_real_div(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_div(sway_real_to_word(a), sway_real_to_word(b)));
}

SWAY_INLINE sway_real_t sway_real_neg(sway_real_t a)
{
    a.m = -a.m; // never INT32_MIN: |m| < 2^31
    return a;
}

SWAY_INLINE sway_real_t sway_real_abs(sway_real_t a)
{
    a.m = a.m < 0 ? -a.m : a.m;
    return a;
}

/// a * 2^shift, exact.
SWAY_INLINE sway_real_t sway_real_scale(sway_real_t a, int32_t shift)
{
    return sway_real_of_word(sway_real_word_scale(sway_real_to_word(a), shift));
}

/// Square root; 0 for a <= 0.
SWAY_INLINE sway_real_t sway_real_sqrt(sway_real_t a)
{
    return sway_real_of_word(sway_real_word_sqrt(sway_real_to_word(a)));
}

/// e^a, relative error below 1e-8 for |a| < 20; |a| is clipped to 60000.
SWAY_INLINE sway_real_t sway_real_exp(sway_real_t a)
{
    return sway_real_of_word(sway_real_word_exp(sway_real_to_word(a)));
}

/// Natural logarithm; 0 for a <= 0. Absolute error below 3e-8.
SWAY_INLINE sway_real_t sway_real_ln(sway_real_t a)
{
    return sway_real_of_word(sway_real_word_ln(sway_real_to_word(a)));
}

/// Sine and cosine of `a` in rad; |a| < 2^20, beyond it phase is lost and (0, 1) is returned.
/// Absolute error below 5e-9 for |a| < 8.
void sway_real_sincos(sway_real_t a, sway_real_t *sine, sway_real_t *cosine);

/// Angle of (x, y) in (-pi, pi]; 0 for (0, 0). Absolute error below 2e-9.
SWAY_INLINE sway_real_t sway_real_atan2(sway_real_t y, sway_real_t x)
{
    return sway_real_of_word(sway_real_word_atan2(sway_real_to_word(y), sway_real_to_word(x)));
}

/// -1, 0 or 1 as a < b, a == b, a > b.
int sway_real_compare(sway_real_t a, sway_real_t b);

SWAY_INLINE bool sway_real_less(sway_real_t a, sway_real_t b)
{
    return sway_real_compare(a, b) < 0;
}

SWAY_INLINE bool sway_real_is_zero(sway_real_t a)
{
    return a.m == 0;
}

/// -1, 0 or 1.
SWAY_INLINE int sway_real_sign(sway_real_t a)
{
    return (a.m > 0) - (a.m < 0);
}

SWAY_INLINE sway_real_t sway_real_min(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_min(sway_real_to_word(a), sway_real_to_word(b)));
}

SWAY_INLINE sway_real_t sway_real_max(sway_real_t a, sway_real_t b)
{
    return sway_real_of_word(sway_real_word_max(sway_real_to_word(a), sway_real_to_word(b)));
}

/// a * scale rounded to the nearest integer, clipped to [low, high].
/// E.g. sway_real_to_int(rad, 1000000, INT32_MIN, INT32_MAX) gives microradian.
int32_t sway_real_to_int(sway_real_t a, int32_t scale, int32_t low, int32_t high);
/// a * 2^shift rounded to the nearest integer, clipped to +-(2^62).
int64_t sway_real_to_int64(sway_real_t a, int32_t shift);

/// pi, to 31 bits.
SWAY_INLINE sway_real_t sway_real_pi(void)
{
    sway_real_t pi;
    pi.m = 1686629713;
    pi.e = -29;
    return pi;
}

SWAY_INLINE sway_complex_t sway_complex(sway_real_t re, sway_real_t im)
{
    sway_complex_t result;
    result.re = re;
    result.im = im;
    return result;
}

sway_complex_t sway_complex_add(sway_complex_t a, sway_complex_t b);
sway_complex_t sway_complex_sub(sway_complex_t a, sway_complex_t b);
sway_complex_t sway_complex_mul(sway_complex_t a, sway_complex_t b);
sway_complex_t sway_complex_scale(sway_complex_t a, sway_real_t factor);
sway_complex_t sway_complex_conj(sway_complex_t a);
/// a / b; 0 where b is 0.
sway_complex_t sway_complex_div(sway_complex_t a, sway_complex_t b);
/// |a|^2 and |a|.
SWAY_INLINE sway_real_t sway_complex_norm(sway_complex_t a)
{
    return sway_real_of_word(
        sway_complex_word_norm(sway_real_to_word(a.re), sway_real_to_word(a.im)));
}

SWAY_INLINE sway_real_t sway_complex_abs(sway_complex_t a)
{
    return sway_real_of_word(
        sway_complex_word_abs(sway_real_to_word(a.re), sway_real_to_word(a.im)));
}

/// Argument in (-pi, pi].
SWAY_INLINE sway_real_t sway_complex_arg(sway_complex_t a)
{
    return sway_real_atan2(a.im, a.re);
}

/// e^(j angle), angle in rad.
sway_complex_t sway_complex_unit(sway_real_t angle);

#endif

/* Tests of sway_real against double precision, on random numbers of many decades. */
#include <limits.h>
#include <math.h>
#include <stdint.h>

#include "arithmetic/sway_real.h"
#include "arithmetic/sway_int64.h"
#include "unity.h"

#define TRIALS 20000

static uint64_t state = 88172645463325252U;

void setUp(void)
{
}

void tearDown(void)
{
}

static uint64_t random_bits(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

/* Random mantissa, random exponent within +-spread. */
static sway_real_t random_real(int spread)
{
    const int64_t mantissa = (int64_t)(int32_t)(random_bits() >> 32);
    return sway_real(mantissa, (int32_t)(random_bits() % (unsigned)(2 * spread + 1)) - spread - 31);
}

static void assert_normal(sway_real_t x)
{
    if (x.m == 0) {
        TEST_ASSERT_EQUAL_INT32(0, x.e);
        return;
    }
    const int64_t size = x.m < 0 ? -(int64_t)x.m : x.m;
    TEST_ASSERT_TRUE(size >= (INT64_C(1) << 30) && size < (INT64_C(1) << 31));
}

/* Half a unit of the 31-bit mantissa, and what double itself rounds. */
static void assert_close(double expected, sway_real_t x)
{
    assert_normal(x);
    TEST_ASSERT_DOUBLE_WITHIN(fabs(expected) * (ldexp(1.0, -31) + 1e-15), expected, to_double(x));
}

static void test_add_mul_div_round_to_nearest(void)
{
    for (int i = 0; i < TRIALS; i++) {
        const sway_real_t a = random_real(20);
        const sway_real_t b = random_real(20);
        assert_close(to_double(a) + to_double(b), sway_real_add(a, b));
        assert_close(to_double(a) - to_double(b), sway_real_sub(a, b));
        assert_close(to_double(a) * to_double(b), sway_real_mul(a, b));
    }
}

static void test_division_is_within_one_unit(void)
{
    for (int i = 0; i < TRIALS; i++) {
        const sway_real_t a = random_real(20);
        const sway_real_t b = random_real(20);
        if (b.m == 0) {
            continue;
        }
        const double expected = to_double(a) / to_double(b);
        const sway_real_t quotient = sway_real_div(a, b);
        assert_normal(quotient);
        TEST_ASSERT_DOUBLE_WITHIN(fabs(expected) * ldexp(1.0, -30), expected, to_double(quotient));
    }
}

static void test_sums_of_neighbouring_exponents_and_cancellation(void)
{
    for (int32_t distance = 0; distance <= 40; distance++) {
        for (int i = 0; i < 500; i++) {
            const sway_real_t a = sway_real((int64_t)(random_bits() >> 33) | (1 << 30), 0);
            sway_real_t b = sway_real((int64_t)(random_bits() >> 33) | (1 << 30), -distance);
            b = (random_bits() & 1U) != 0U ? b : sway_real_neg(b);
            assert_close(to_double(a) + to_double(b), sway_real_add(a, b));
            assert_close(to_double(b) - to_double(a), sway_real_sub(b, a));
        }
    }
    const sway_real_t one = sway_real_int(1);
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_sub(one, one)));
}

static void test_roots_and_transcendental_functions(void)
{
    for (int i = 0; i < TRIALS; i++) {
        const sway_real_t a = sway_real_abs(random_real(20));
        TEST_ASSERT_DOUBLE_WITHIN(sqrt(to_double(a)) * 1e-9, sqrt(to_double(a)),
                                  to_double(sway_real_sqrt(a)));
        const sway_real_t x = sway_real((int64_t)(int32_t)random_bits(), -28); // +-8
        sway_real_t s;
        sway_real_t c;
        sway_real_sincos(x, &s, &c);
        TEST_ASSERT_DOUBLE_WITHIN(5e-9, sin(to_double(x)), to_double(s));
        TEST_ASSERT_DOUBLE_WITHIN(5e-9, cos(to_double(x)), to_double(c));
        const double power = exp(to_double(x));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8 * power, power, to_double(sway_real_exp(x)));
        TEST_ASSERT_DOUBLE_WITHIN(3e-8, log(to_double(a)), to_double(sway_real_ln(a)));
        const sway_real_t y = random_real(5);
        const sway_real_t z = random_real(5);
        TEST_ASSERT_DOUBLE_WITHIN(2e-9, atan2(to_double(y), to_double(z)),
                                  to_double(sway_real_atan2(y, z)));
    }
}

static void test_every_operation_is_total(void)
{
    const sway_real_t zero = sway_real_int(0);
    const sway_real_t huge = sway_real(1, SWAY_REAL_EXPONENT_MAX);
    const sway_real_t tiny = sway_real(1, -SWAY_REAL_EXPONENT_MAX + 30);
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_div(huge, zero)));
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_mul(tiny, tiny)));
    assert_normal(sway_real_mul(huge, huge));
    assert_normal(sway_real_add(huge, huge));
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_sqrt(sway_real_int(-4))));
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_ln(zero)));
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_real_atan2(zero, zero)));
    assert_normal(sway_real_exp(huge));
    TEST_ASSERT_TRUE(to_double(sway_real(INT64_MIN, 0)) == -ldexp(1.0, 63));
    TEST_ASSERT_EQUAL_INT64(-(INT64_C(1) << 62), sway_real_to_int64(sway_real_neg(huge), 0));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, sway_real_to_int(huge, 1, INT32_MIN, INT32_MAX));
}

static void test_comparison_orders_as_double_does(void)
{
    for (int i = 0; i < TRIALS; i++) {
        const sway_real_t a = random_real(3);
        const sway_real_t b = (i & 7) == 0 ? a : random_real(3);
        const double x = to_double(a);
        const double y = to_double(b);
        TEST_ASSERT_EQUAL_INT((x > y) - (x < y), sway_real_compare(a, b));
    }
}

static void test_wide_products(void)
{
    static const int32_t edges[] = {0, 1, -1, 65535, 65536, -65536, INT32_MAX, INT32_MIN};
    for (unsigned i = 0; i < 8; i++) {
        for (unsigned k = 0; k < 8; k++) {
            TEST_ASSERT_EQUAL_INT64((int64_t)edges[i] * edges[k],
                                    sway_int64_product(edges[i], edges[k]));
        }
    }
    for (int i = 0; i < TRIALS; i++) {
        const int32_t a = (int32_t)(random_bits() >> 32);
        const int32_t b = (int32_t)(random_bits() >> 32) / 2;
        TEST_ASSERT_EQUAL_INT64((int64_t)a * b, sway_int64_product(a, b));
        TEST_ASSERT_INT64_WITHIN(1, llround(ldexp((double)a * b, -30)), sway_int64_q30(a, b));
    }
}

static void test_wide_quotients(void)
{
    static const int64_t ends[] = {0, 1, -1, 2, 3, -7, INT32_MAX, INT32_MIN, INT64_MAX, -INT64_MAX};
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        for (size_t j = 1; j < sizeof ends / sizeof ends[0]; j++) {
            TEST_ASSERT_EQUAL_INT64(ends[i] / ends[j], sway_int64_divide(ends[i], ends[j]));
        }
    }
    for (int i = 0; i < TRIALS; i++) {
        const int64_t value = (int64_t)(random_bits() >> (random_bits() % 63U + 1U));
        const int64_t divisor = (int64_t)(random_bits() >> (random_bits() % 63U + 1U)) + 1;
        TEST_ASSERT_EQUAL_INT64(value / divisor, sway_int64_divide(value, divisor));
        TEST_ASSERT_EQUAL_INT64(-(value / divisor), sway_int64_divide(value, -divisor));
    }
}

/* Past the largest exponent the largest number with the sign, below the smallest 0, in each of the
 * operations, by one step of the exponent. */
static void test_every_operation_ends_at_the_range(void)
{
    const sway_real_t largest = {INT32_MAX, SWAY_REAL_EXPONENT_MAX};
    const sway_real_t smallest = {1 << 30, -SWAY_REAL_EXPONENT_MAX};
    const sway_real_t next = {(1 << 30) + 1, -SWAY_REAL_EXPONENT_MAX};
    const sway_real_t most = {1 << 30, SWAY_REAL_EXPONENT_MAX};
    for (int k = 0; k < 2; k++) {
        /* Not the loop's own variable: gcc 12 strides through sign * INT32_MAX in its ivopts, by
         * more than an int holds, and takes the overflow that it made for ours. */
        const int sign = k == 0 ? -1 : 1;
        const sway_real_t one = sway_real_int(sign);
        const sway_real_t big = sway_real_mul(one, largest);
        const sway_real_t small = sway_real_mul(one, smallest);
        const sway_real_t half = sway_real_ratio(1, 2);
        const sway_real_t huge[] = {sway_real_add(big, big),
                                    sway_real_mul(big, sway_real_int(2)),
                                    sway_real_mul(big, sway_real_ratio(3, 2)),
                                    sway_real_div(big, half),
                                    sway_real_div(big, sway_real_ratio(2, 3)),
                                    sway_real_scale(big, 1),
                                    sway_real_add(big, sway_real_scale(big, -31)),
                                    sway_real_add(big, sway_real_scale(big, -32)),
                                    sway_real((int64_t)sign * INT64_MAX, SWAY_REAL_EXPONENT_MAX),
                                    sway_real(sign, SWAY_REAL_EXPONENT_MAX + 31)};
        for (unsigned i = 0; i < sizeof huge / sizeof huge[0]; i++) {
            TEST_ASSERT_EQUAL_INT32(sign * INT32_MAX, huge[i].m);
            TEST_ASSERT_EQUAL_INT32(SWAY_REAL_EXPONENT_MAX, huge[i].e);
        }
        const sway_real_t none[] = {sway_real_mul(small, half),
                                    sway_real_mul(small, sway_real_ratio(9, 10)),
                                    sway_real_div(small, sway_real_int(2)),
                                    sway_real_div(small, sway_real_ratio(3, 2)),
                                    sway_real_scale(small, -1),
                                    sway_real_sub(sway_real_mul(one, next), small),
                                    sway_real(sign, -SWAY_REAL_EXPONENT_MAX + 29)};
        for (unsigned i = 0; i < sizeof none / sizeof none[0]; i++) {
            TEST_ASSERT_EQUAL_INT32(0, none[i].m);
        }
        /* what just stays in: nothing is lost by the range */
        const sway_real_t kept = sway_real_sub(sway_real_mul(one, most), sway_real_int(sign));
        TEST_ASSERT_EQUAL_INT32(sign * INT32_C(0x40000000), kept.m);
        TEST_ASSERT_EQUAL_INT32(SWAY_REAL_EXPONENT_MAX, kept.e);
        const sway_real_t half_bit = {-sign * (1 << 30), 5 - 32}; // rounds away
        const sway_real_t exact = {sign * (1 << 30), 5};
        TEST_ASSERT_EQUAL_INT32(exact.m, sway_real_add(exact, half_bit).m);
        TEST_ASSERT_EQUAL_INT32(exact.e, sway_real_add(exact, half_bit).e);
        const sway_real_t quarter = {sign * ((1 << 30) + (1 << 29)), -SWAY_REAL_EXPONENT_MAX};
        TEST_ASSERT_EQUAL_INT32(0, sway_real_sub(quarter, small).m); // one octave below the range
    }
}

static void test_functions_beyond_their_arguments(void)
{
    sway_real_t sine;
    sway_real_t cosine;
    for (int sign = -1; sign <= 1; sign += 2) {
        sway_real_sincos(sway_real_scale(sway_real_int(sign), 20), &sine, &cosine);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, to_double(sine));
        TEST_ASSERT_EQUAL_DOUBLE(1.0, to_double(cosine));
    }
    TEST_ASSERT_TRUE(sway_real_compare(sway_real_exp(sway_real_int(70000)),
                                       sway_real_exp(sway_real_int(60000))) == 0);
    TEST_ASSERT_TRUE(sway_real_compare(sway_real_exp(sway_real_int(-70000)),
                                       sway_real_exp(sway_real_int(-60000))) == 0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, M_PI / 2,
                              to_double(sway_real_atan2(sway_real_int(3), sway_real_zero())));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, M_PI,
                              to_double(sway_real_atan2(sway_real_zero(), sway_real_int(-3))));
    TEST_ASSERT_EQUAL_INT64(0, sway_int64_divide(5, 0));
    TEST_ASSERT_EQUAL_INT64(0, sway_int64_divide(INT64_MIN, 0));
    TEST_ASSERT_EQUAL_INT64(INT64_MIN, sway_int64_divide(INT64_MIN, 1));
}

static void expect_exact(int32_t m, int32_t e, sway_real_t found)
{
    TEST_ASSERT_EQUAL_INT32(m, found.m);
    TEST_ASSERT_EQUAL_INT32(e, found.e);
}

/* The 31 bits nearest to an integer of any number of bits, all that are cut off counted. */
static void test_whole_numbers_are_rounded_to_the_nearest(void)
{
    for (int bits = 1; bits < 64; bits++) {
        for (int k = 0; k < 200; k++) {
            const int64_t whole =
                (int64_t)((random_bits() >> (64 - bits)) | (UINT64_C(1) << (bits - 1)));
            const sway_real_t x = sway_real(whole, 0);
            assert_normal(x);
            const int64_t unit = x.e > 0 ? INT64_C(1) << x.e : 1;
            const int64_t back = x.e > 0 ? x.m * unit : (int64_t)x.m >> -x.e;
            const int64_t off = whole > back ? whole - back : back - whole;
            TEST_ASSERT_TRUE(2 * off <= unit || (off == 0 && x.e <= 0));
        }
    }
}

/* Differences whose exact value lies just beside the middle of two numbers. */
static void test_differences_round_by_their_last_bits(void)
{
    const int32_t half = INT32_C(1) << 30;
    /* 2^30 - (2^30 + 1) / 2^32: a little more than a quarter below. */
    const sway_real_t one = {half, 0}, beside = {half + 1, -32};
    expect_exact(INT32_MAX, -1, sway_real_sub(one, beside));
    const sway_real_t exactly = {half, -32}; /* just a quarter: the middle, away from zero */
    expect_exact(half, 0, sway_real_sub(one, exactly));
    /* 2^31 - (2^31 - 1): nothing is left but the last bit. */
    const sway_real_t two = {half, 1}, less = {INT32_MAX, 0};
    expect_exact(half, -30, sway_real_sub(two, less));
    /* 2^30 + 1/4, from numbers two octaves apart. */
    const sway_real_t big = {half + (half >> 2) + 1, 0}, small = {half + 3, -2};
    expect_exact(half, 0, sway_real_sub(big, small));
    expect_exact(-half, 0, sway_real_sub(small, big));
}

static void test_a_zero_has_no_exponent_and_no_sign(void)
{
    const sway_real_t zero = sway_real_zero();
    expect_exact(0, 0, sway_real_scale(zero, 5));
    expect_exact(0, 0, sway_real_sub(zero, zero));
    TEST_ASSERT_EQUAL_INT(0, sway_real_compare(zero, sway_real_neg(zero)));
}

/* Roots of squares are exact. */
static void test_roots_of_squares_are_exact(void)
{
    for (int32_t n = 1; n < 32768; n++) {
        const sway_real_t root = sway_real_sqrt(sway_real_int(n * n));
        TEST_ASSERT_EQUAL_DOUBLE(n, to_double(root));
    }
    /* A little less than half a unit above a number: (2^31 + 1)^2 - 1 and (2^32 - 1)^2 - 1. */
    const sway_real_t even = {(INT32_C(1) << 30) + 1, 0}, odd = {INT32_MAX, 1};
    expect_exact(INT32_C(1) << 30, -15, sway_real_sqrt(even));
    expect_exact(INT32_MAX, -15, sway_real_sqrt(odd));
}

static void test_integers_are_clipped_beyond_62_bits(void)
{
    const sway_real_t x = {INT32_MAX, 0};
    const sway_real_t minus = {-INT32_MAX, 0};
    TEST_ASSERT_EQUAL_INT64((int64_t)INT32_MAX << 31, sway_real_to_int64(x, 31));
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 62, sway_real_to_int64(x, 32));
    TEST_ASSERT_EQUAL_INT64(-(INT64_C(1) << 62), sway_real_to_int64(minus, 32));
    TEST_ASSERT_EQUAL_INT64(INT32_MAX, sway_real_to_int64(x, 0));
    TEST_ASSERT_EQUAL_INT64(1, sway_real_to_int64(x, -31)); /* 1 - 2^-31 */
    TEST_ASSERT_EQUAL_INT64(0, sway_real_to_int64(x, -32)); /* a little below 1/2 */
    for (int32_t shift = -33; shift > -200; shift--) {
        TEST_ASSERT_EQUAL_INT64(0, sway_real_to_int64(x, shift));
        TEST_ASSERT_EQUAL_INT64(0, sway_real_to_int64(minus, shift));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_add_mul_div_round_to_nearest);
    RUN_TEST(test_division_is_within_one_unit);
    RUN_TEST(test_sums_of_neighbouring_exponents_and_cancellation);
    RUN_TEST(test_roots_and_transcendental_functions);
    RUN_TEST(test_every_operation_is_total);
    RUN_TEST(test_comparison_orders_as_double_does);
    RUN_TEST(test_wide_products);
    RUN_TEST(test_wide_quotients);
    RUN_TEST(test_every_operation_ends_at_the_range);
    RUN_TEST(test_functions_beyond_their_arguments);
    RUN_TEST(test_whole_numbers_are_rounded_to_the_nearest);
    RUN_TEST(test_differences_round_by_their_last_bits);
    RUN_TEST(test_a_zero_has_no_exponent_and_no_sign);
    RUN_TEST(test_roots_of_squares_are_exact);
    RUN_TEST(test_integers_are_clipped_beyond_62_bits);
    return UNITY_END();
}

/* Residuals against the definitions: blocks beyond 9 medians, correlation of neighbours. */
#include <stdlib.h>

#include "signal/sway_fit.h"
#include "signal/sway_residual.h"
#include "sway_test.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static int ascending(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Beyond 9 medians of the magnitude (the upper one of an even number), and 2 for rounding. */
static uint64_t expected_outliers(const int32_t *residual, uint32_t n)
{
    int32_t size[SWAY_FIT_BLOCKS];
    uint64_t wrong = 0;
    for (uint32_t i = 0; i < n; i++) {
        size[i] = abs(residual[i]);
    }
    qsort(size, n, sizeof size[0], ascending);
    for (uint32_t i = 0; i < n; i++) {
        wrong |= (uint64_t)(llabs(residual[i]) > INT64_C(9) * size[n / 2] + 2) << i;
    }
    return wrong;
}

static void expect_outliers(const int32_t *residual, uint32_t n)
{
    int32_t *exact = malloc(n * sizeof *exact); /* a sanitizer watches both ends */
    TEST_ASSERT_NOT_NULL(exact);
    memcpy(exact, residual, n * sizeof *exact);
    TEST_ASSERT_EQUAL_HEX64(expected_outliers(residual, n), sway_residual_outliers(exact, n));
    free(exact);
}

static void blocks_beyond_nine_medians_are_found(void)
{
    static const int32_t scales[] = {1, 3, 20, 1000, 50000000};
    srand(3);
    for (int trial = 0; trial < 20000; trial++) {
        int32_t residual[SWAY_FIT_BLOCKS];
        const uint32_t n = 1U + (uint32_t)rand() % SWAY_FIT_BLOCKS;
        const int32_t scale = scales[rand() % 5];
        for (uint32_t i = 0; i < n; i++) {
            residual[i] = rand() % (2 * scale + 1) - scale;
            residual[i] *= rand() % 10 == 0 ? rand() % 11 : 1;
        }
        expect_outliers(residual, n);
    }
}

/* One block at the limit, one step either way; of both signs, in every place. */
static void the_limit_itself_is_no_outlier(void)
{
    for (uint32_t at = 0; at < 5; at++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            for (int32_t size = 91; size <= 93; size++) {
                int32_t residual[5] = {10, -10, 10, -10, 10};
                residual[at] = sign * size;
                TEST_ASSERT_EQUAL_HEX64(size > 92 ? UINT64_C(1) << at : 0,
                                        sway_residual_outliers(residual, 5));
            }
        }
    }
    const int32_t zeros[3] = {0, 2, 0}, three[3] = {0, 3, 0};
    TEST_ASSERT_EQUAL_HEX64(0, sway_residual_outliers(zeros, 3));
    TEST_ASSERT_EQUAL_HEX64(2, sway_residual_outliers(three, 3));
    const int32_t one = 1000;
    TEST_ASSERT_EQUAL_HEX64(0, sway_residual_outliers(&one, 1));
}

static double inflation(const int32_t *residual, uint32_t n, double *rho)
{
    double squares = 0, products = 0;
    for (uint32_t i = 0; i < n; i++) {
        squares += (double)residual[i] * residual[i];
        products += i > 0 ? (double)residual[i] * residual[i - 1] : 0;
    }
    *rho = products / squares;
    return value(sway_residual_inflation(residual, n, real(squares)));
}

/* Noise with a memory: x = memory x + noise. */
static void neighbours_that_correlate_inflate_the_error(void)
{
    static const double memory[] = {-0.9, 0, 0.2, 0.3, 0.4, 0.5, 0.8, 0.95, 0.999};
    srand(5);
    unsigned inflated = 0, plain = 0;
    for (size_t m = 0; m < sizeof memory / sizeof memory[0]; m++) {
        for (int trial = 0; trial < 50; trial++) {
            int32_t residual[SWAY_FIT_BLOCKS];
            double x = 0, rho;
            for (uint32_t i = 0; i < SWAY_FIT_BLOCKS; i++) {
                x = memory[m] * x + rand() % 2001 - 1000;
                residual[i] = (int32_t)(100 * x);
            }
            const double found = inflation(residual, SWAY_FIT_BLOCKS, &rho);
            if (fabs(rho - 0.35) > 1e-6) {
                const double held = rho > 0.95 ? 0.95 : rho;
                const double expected = rho > 0.35 ? (1 + held) / (1 - held) : 1;
                TEST_ASSERT_DOUBLE_WITHIN(1e-5 * expected, expected, found);
                inflated += rho > 0.35;
                plain += rho <= 0.35;
            }
        }
    }
    TEST_ASSERT_TRUE(inflated > 100 && plain > 100);
}

/* A level of 7 products; its sum of squares makes the correlation just below and above the bounds.
 */
static void the_bounds_of_the_correlation_hold(void)
{
    const int32_t level[8] = {1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000};
    const struct {
        double rho, expected;
    } cases[] = {
        {0.3499, 1}, {0.3501, 1.3501 / 0.6499}, {0.9499, 1.9499 / 0.0501}, {0.9501, 39}, {1.5, 39}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const sway_real_t squares = real(7e6 / cases[i].rho);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * cases[i].expected, cases[i].expected,
                                  value(sway_residual_inflation(level, 8, squares)));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(blocks_beyond_nine_medians_are_found);
    RUN_TEST(the_limit_itself_is_no_outlier);
    RUN_TEST(neighbours_that_correlate_inflate_the_error);
    RUN_TEST(the_bounds_of_the_correlation_hold);
    return UNITY_END();
}

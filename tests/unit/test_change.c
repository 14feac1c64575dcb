/* Breaks within a window: where they are found, and from which chi-square and size on, against the
 * sums of sway_change.h in double precision. */
#include <math.h>
#include <string.h>

#include "signal/sway_change.h"
#include "unity.h"

#define BLOCKS 64
#define LINE 3e4
#define PHASE 1.5707963267948966
#define PLACES SWAY_CHANGE_PLACES

static const int places[PLACES] = {4, 8, 16, 24, 32, 40, 48, 56, 60};  // in sixteenths of 64 blocks
static const int behind[PLACES] = {8, 16, 24, 32, 40, 48, 56, 60, 64}; // it surely lies before
static sway_fit_basis_t basis;
static int32_t residual[BLOCKS];

/* An undamped line of four blocks to the period. */
void setUp(void)
{
    memset(&basis, 0, sizeof basis);
    basis.blocks = BLOCKS;
    for (int b = 0; b < BLOCKS; b++) {
        basis.column[0][b] = (int32_t)lrint(ldexp(cos(PHASE * b), SWAY_FIT_BITS));
        basis.column[1][b] = (int32_t)lrint(ldexp(-sin(PHASE * b), SWAY_FIT_BITS));
        basis.column[3][b] = (int32_t)lrint(ldexp((2.0 * b - BLOCKS + 1) / (BLOCKS - 1), 28));
    }
}

void tearDown(void)
{
}

static double tau(int b)
{
    return (2.0 * b - BLOCKS + 1) / (BLOCKS - 1);
}

/* The line is larger by `size` from the block on, less what amplitude and growth take up of it. */
static void break_at(int place, double size)
{
    double mean = 0, slope = 0, squares = 0;
    for (int b = 0; b < BLOCKS; b++) {
        mean += (b >= place) / (double)BLOCKS;
        slope += (b >= place) * tau(b);
        squares += tau(b) * tau(b);
    }
    for (int b = 0; b < BLOCKS; b++) {
        const double change = size * ((b >= place) - mean - slope / squares * tau(b));
        residual[b] = (int32_t)lrint(LINE * change * cos(PHASE * b));
    }
}

/* Chi-square and size of the change before a block, for a variance of the blocks. */
static double chi_2_of(int place, double variance, double *size)
{
    double all[3] = {0, 0, 0}, tail[3] = {0, 0, 0}, re = 0, im = 0;
    for (int b = 0; b < BLOCKS; b++) {
        for (int i = 0; i < 3; i++) {
            all[i] += pow(tau(b), i);
            tail[i] += b >= place ? pow(tau(b), i) : 0;
        }
        re += b >= place ? residual[b] * cos(PHASE * b) * LINE / variance : 0;
        im += b >= place ? residual[b] * sin(PHASE * b) * LINE / variance : 0;
    }
    const double taken =
        (tail[0] * tail[0] * all[2] + tail[1] * tail[1] * all[0] - 2 * tail[0] * tail[1] * all[1]) /
        (all[0] * all[2] - all[1] * all[1]);
    const double information = LINE * LINE / variance / 2 * (tail[0] - taken);
    *size = hypot(re, im) / information;
    return (re * re + im * im) / information;
}

static int found_with(double variance)
{
    const sway_real_t none = sway_real_zero();
    sway_change_sums_t sums;
    memset(&sums, 0, sizeof sums);
    sway_change_add(&sums, &basis, sway_complex(sway_real_int((int32_t)LINE), none),
                    sway_real_int((int32_t)lrint(variance)), residual);
    return (int)sway_change_find(&sums, &basis);
}

static int expected_with(double variance)
{
    double clearest = 20, size = 0;
    int found = 0;
    for (int k = PLACES - 1; k >= 0; k--) {
        const double chi_2 = chi_2_of(places[k], lrint(variance), &size);
        if (chi_2 > clearest && size > 0.1) {
            clearest = chi_2;
            found = behind[k];
        }
    }
    return found;
}

static void test_a_break_is_found_where_it_is_and_from_20_on(void)
{
    for (int k = 0; k < PLACES; k++) {
        double size = 0;
        break_at(places[k], 0.5);
        const double chi_2 = chi_2_of(places[k], 1e8, &size) * 1e8; // for a variance of 1
        TEST_ASSERT_EQUAL_INT(behind[k], found_with(chi_2 / 1000));
        TEST_ASSERT_EQUAL_INT(behind[k], found_with(chi_2 / 20.3));
        TEST_ASSERT_EQUAL_INT(0, found_with(chi_2 / 19.7));
    }
}

/* However clear it is. */
static void test_a_break_is_more_than_a_tenth(void)
{
    for (int k = 0; k < PLACES; k++) {
        for (int above = 0; above < 2; above++) {
            double size = 0;
            break_at(places[k], 0.5);
            (void)chi_2_of(places[k], 1e8, &size);
            break_at(places[k], 0.5 * sqrt(above ? 0.01004 : 0.00996) / size);
            TEST_ASSERT_EQUAL_INT(expected_with(1e4), found_with(1e4));
            if (above) {
                TEST_ASSERT_EQUAL_INT(behind[k], found_with(1e4));
            } else {
                TEST_ASSERT_TRUE(found_with(1e4) != behind[k]);
            }
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_break_is_found_where_it_is_and_from_20_on);
    RUN_TEST(test_a_break_is_more_than_a_tenth);
    return UNITY_END();
}

/* Tests of sway_spectrum: the sliding sums are the fresh sums, bit for bit. */
#include <math.h>
#include <string.h>

#include "signal/sway_spectrum.h"
#include "unity.h"

static sway_ring_t ring;
static sway_spectrum_t spectrum;
static uint32_t seed;

void setUp(void)
{
    seed = 1;
    sway_ring_clear(&ring);
    memset(&spectrum, 0, sizeof spectrum);
}

void tearDown(void)
{
}

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

/* Any value that a channel can hold, the limits more often than chance. */
static int32_t random_sample(void)
{
    seed = seed * 1664525U + 1013904223U;
    const uint32_t kind = seed >> 28;
    if (kind < 2U) {
        return kind == 0U ? SWAY_SAMPLE_LIMIT - 1 : 1 - SWAY_SAMPLE_LIMIT;
    }
    return (int32_t)(seed >> 4) - SWAY_SAMPLE_LIMIT > -SWAY_SAMPLE_LIMIT
               ? ((int32_t)(seed >> 4) - SWAY_SAMPLE_LIMIT)
               : 0;
}

static void push_random(void)
{
    sway_row_t tick;
    memset(&tick, 0, sizeof tick);
    tick.valid_mask = UINT32_MAX;
    for (int c = 0; c < SWAY_CHANNELS; c++) {
        tick.value[c] = random_sample();
    }
    sway_ring_push(&ring, &tick);
    sway_spectrum_push(&spectrum, &ring);
}

/* Twiddle factors that belong to the row of an age. */
static uint32_t phase_of(uint32_t age)
{
    const uint32_t back = (age + 1U) % spectrum.window;
    return (spectrum.phase + spectrum.window - back) % spectrum.window;
}

static void assert_sums_are_fresh(void)
{
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        for (uint32_t k = 0; k <= SWAY_BINS; k++) {
            int64_t re = 0;
            int64_t im = 0;
            for (uint32_t age = 0; age < spectrum.window; age++) {
                const int64_t x = ring.sample[c][sway_ring_slot(&ring, age)];
                const uint32_t at = k * phase_of(age) % spectrum.window;
                re += x * sway_spectrum_cosine(&spectrum, at);
                im += x * sway_spectrum_sine(&spectrum, at);
            }
            TEST_ASSERT_EQUAL_INT64(re, spectrum.re[c][k]);
            TEST_ASSERT_EQUAL_INT64(im, spectrum.im[c][k]);
        }
    }
}

static void finish_filling(void)
{
    int slices = 0;
    while (sway_spectrum_run(&spectrum, &ring)) {
        TEST_ASSERT_TRUE(++slices < 1000);
    }
    TEST_ASSERT_TRUE(sway_spectrum_ready(&spectrum));
}

static void test_sliding_sums_equal_fresh_sums(void)
{
    static const uint32_t windows[] = {SWAY_WINDOW_MIN, 33, 257, 300, SWAY_WINDOW_MAX};
    for (unsigned i = 0; i < 5; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, windows[i]));
        for (int row = 0; row < 700; row++) {
            push_random();
        }
        finish_filling();
        assert_sums_are_fresh();
        for (int row = 0; row < 1500; row++) {
            push_random();
        }
        assert_sums_are_fresh();
    }
}

static void test_rows_may_come_while_the_sums_fill(void)
{
    for (int row = 0; row < 600; row++) {
        sway_row_t tick;
        memset(&tick, 0, sizeof tick);
        tick.value[3] = random_sample();
        sway_ring_push(&ring, &tick);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, 300));
    while (sway_spectrum_run(&spectrum, &ring)) {
        push_random();
    }
    assert_sums_are_fresh();
    push_random();
    assert_sums_are_fresh();
}

static void test_largest_samples_do_not_overflow(void)
{
    /* every sample at the limit with the sign of its twiddle factor: the largest possible sum */
    const uint32_t window = SWAY_WINDOW_MAX;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, window));
    finish_filling();
    for (uint32_t row = 0; row < 3U * window; row++) {
        const uint32_t at = 1U * spectrum.phase % window;
        sway_row_t tick;
        memset(&tick, 0, sizeof tick);
        for (int c = 0; c < SWAY_CHANNELS; c++) {
            const int32_t factor = c % 2 == 0 ? sway_spectrum_cosine(&spectrum, at)
                                              : sway_spectrum_sine(&spectrum, at);
            tick.value[c] = factor < 0 ? 1 - SWAY_SAMPLE_LIMIT : SWAY_SAMPLE_LIMIT - 1;
        }
        sway_ring_push(&ring, &tick);
        sway_spectrum_push(&spectrum, &ring);
    }
    assert_sums_are_fresh();
    TEST_ASSERT_TRUE(spectrum.re[0][1] > (INT64_C(1) << 60));
}

static void test_bins_of_a_known_line(void)
{
    const uint32_t window = 256;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, window));
    finish_filling();
    for (int row = 0; row < 1000; row++) {
        sway_row_t tick;
        memset(&tick, 0, sizeof tick);
        /* the window begins at row 1000 - 256 = 744 with phase 0.5 */
        tick.value[2] =
            (int32_t)lround(1e7 + 1e6 * cos(2.0 * M_PI * 2.0 * (row - 744) / 256 + 0.5));
        sway_ring_push(&ring, &tick);
        sway_spectrum_push(&spectrum, &ring);
    }
    const sway_complex_t x = sway_spectrum_bin(&spectrum, SWAY_CHANNEL_CAR_LATERAL_ACC, 2);
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 128e6 * cos(0.5), to_double(x.re));
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 128e6 * sin(0.5), to_double(x.im));
    const sway_complex_t h = sway_spectrum_hann(&spectrum, SWAY_CHANNEL_CAR_LATERAL_ACC, 2);
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 64e6 * cos(0.5), to_double(h.re));
    const sway_complex_t mean = sway_spectrum_bin(&spectrum, SWAY_CHANNEL_CAR_LATERAL_ACC, 0);
    TEST_ASSERT_DOUBLE_WITHIN(300.0, 256e7, to_double(mean.re));
}

static void test_hann_bins_are_those_of_the_windowed_samples(void)
{
    const int window = 300;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, (uint32_t)window));
    finish_filling();
    for (int row = 0; row < 900; row++) { // the window begins where the table does
        sway_row_t tick;
        memset(&tick, 0, sizeof tick);
        tick.value[1] = (int32_t)lround(1e7 + 1e6 * exp(0.002 * row) * cos(0.047 * row));
        sway_ring_push(&ring, &tick);
        sway_spectrum_push(&spectrum, &ring);
    }
    for (uint32_t k = 1; k < SWAY_BINS; k++) {
        double re = 0;
        double im = 0;
        for (int n = 0; n < window; n++) {
            const uint32_t slot = sway_ring_slot(&ring, (uint32_t)(window - 1 - n));
            const double turn = 2.0 * M_PI * n / window;
            const double x = 0.5 * (1.0 - cos(turn)) * ring.sample[1][slot];
            re += x * cos(turn * k);
            im -= x * sin(turn * k);
        }
        const sway_complex_t h = sway_spectrum_hann(&spectrum, SWAY_CHANNEL_CAR_YAW_RATE, k);
        TEST_ASSERT_DOUBLE_WITHIN(300.0, re, to_double(h.re));
        TEST_ASSERT_DOUBLE_WITHIN(300.0, im, to_double(h.im));
    }
}

static void test_filling_comes_in_even_slices_and_ends_at_the_window(void)
{
    TEST_ASSERT_FALSE(sway_spectrum_ready(&spectrum)); // without a window
    for (int row = 0; row < 600; row++) {
        push_random();
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, 300));
    uint32_t most = 0;
    int slices = 0;
    bool more = true;
    while (more) {
        const uint32_t before = spectrum.tabled + spectrum.covered;
        TEST_ASSERT_FALSE(sway_spectrum_ready(&spectrum));
        more = sway_spectrum_run(&spectrum, &ring);
        const uint32_t done = spectrum.tabled + spectrum.covered - before;
        most = done > most ? done : most;
        slices++;
    }
    TEST_ASSERT_EQUAL_UINT32(151, spectrum.tabled);
    TEST_ASSERT_EQUAL_UINT32(300, spectrum.covered);
    TEST_ASSERT_TRUE_MESSAGE(most <= 64U && slices <= 150, "as even as it can be");
}

static void test_windows_out_of_range_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(&spectrum, SWAY_WINDOW_MIN - 1U));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(&spectrum, SWAY_WINDOW_MAX + 1U));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(NULL, 100));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sliding_sums_equal_fresh_sums);
    RUN_TEST(test_rows_may_come_while_the_sums_fill);
    RUN_TEST(test_largest_samples_do_not_overflow);
    RUN_TEST(test_bins_of_a_known_line);
    RUN_TEST(test_hann_bins_are_those_of_the_windowed_samples);
    RUN_TEST(test_filling_comes_in_even_slices_and_ends_at_the_window);
    RUN_TEST(test_windows_out_of_range_are_refused);
    return UNITY_END();
}

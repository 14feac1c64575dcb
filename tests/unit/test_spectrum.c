/* Tests of sway_spectrum: the sliding sums are the fresh sums, bit for bit; and of sway_search: its
 * powers are those of the windowed sums. */
#include <math.h>
#include <string.h>

#include "signal/sway_search.h"
#include "signal/sway_spectrum.h"
#include "line_feed.h"
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
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 128e6 * cos(0.5), value(x.re));
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 128e6 * sin(0.5), value(x.im));
    const sway_complex_t h = sway_spectrum_hann(&spectrum, SWAY_CHANNEL_CAR_LATERAL_ACC, 2);
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 64e6 * cos(0.5), value(h.re));
    const sway_complex_t mean = sway_spectrum_bin(&spectrum, SWAY_CHANNEL_CAR_LATERAL_ACC, 0);
    TEST_ASSERT_DOUBLE_WITHIN(300.0, 256e7, value(mean.re));
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
        TEST_ASSERT_DOUBLE_WITHIN(300.0, re, value(h.re));
        TEST_ASSERT_DOUBLE_WITHIN(300.0, im, value(h.im));
    }
}

static void test_filling_comes_in_even_slices_and_ends_at_the_window(void)
{
    TEST_ASSERT_FALSE(sway_spectrum_ready(&spectrum)); // without a window
    for (int row = 0; row < 600; row++) {
        push_random();
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, 300));
    uint32_t most[2] = {0, 0}; // of the table, of the rows
    int slices = 0;
    bool more = true;
    while (more) {
        const uint32_t tabled = spectrum.tabled;
        const uint32_t covered = spectrum.covered;
        TEST_ASSERT_FALSE(sway_spectrum_ready(&spectrum));
        more = sway_spectrum_run(&spectrum, &ring);
        most[0] = spectrum.tabled - tabled > most[0] ? spectrum.tabled - tabled : most[0];
        most[1] = spectrum.covered - covered > most[1] ? spectrum.covered - covered : most[1];
        slices++;
    }
    TEST_ASSERT_EQUAL_UINT32(151, spectrum.tabled);
    TEST_ASSERT_EQUAL_UINT32(300, spectrum.covered);
    TEST_ASSERT_EQUAL_UINT32(4, most[0]);
    TEST_ASSERT_EQUAL_UINT32(3, most[1]);
    TEST_ASSERT_EQUAL_INT(38 + 100, slices); // 151 by 4, 300 by 3
}

/* Whatever the memory held; and of rows that grow by the least there is. */
static void test_sums_begin_anew_and_miss_no_step_of_one(void)
{
    memset(&spectrum, 0xFF, sizeof spectrum);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&spectrum, 100));
    TEST_ASSERT_FALSE(sway_spectrum_ready(&spectrum));
    finish_filling();
    for (uint32_t k = 0; k < 100U; k++) {
        const double turn = 2.0 * M_PI * k / 100;
        const double one = ldexp(1, SWAY_TWIDDLE_BITS);
        TEST_ASSERT_DOUBLE_WITHIN(1, one * cos(turn), sway_spectrum_cosine(&spectrum, k));
        TEST_ASSERT_DOUBLE_WITHIN(1, -one * sin(turn), sway_spectrum_sine(&spectrum, k));
    }
    assert_sums_are_fresh();
    for (int32_t k = 0; k < 250; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        for (int c = 0; c < SWAY_CHANNELS; c++) {
            row.value[c] = k % 2 == 0 ? c % 3 : 1; // from the row 100 before: steps of 0 and 1
            row.value[c] += k / 100;
        }
        sway_ring_push(&ring, &row);
        sway_spectrum_push(&spectrum, &ring);
    }
    assert_sums_are_fresh();
}

static void test_windows_out_of_range_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(&spectrum, SWAY_WINDOW_MIN - 1U));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(&spectrum, SWAY_WINDOW_MAX + 1U));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_spectrum_init(NULL, 100));
}

/* --- the search ---------------------------------------------------------------------------------
 */

static sway_search_t search;

static void a_search_takes_the_least_of_everything(void)
{
    sway_search_config_t least = {.channel_mask = SWAY_CHANNEL_BIT(1),
                                  .sample_period_us = 1,
                                  .frequency_min_mhz = 1,
                                  .frequency_max_mhz = 2};
    fill_tone(&ring, &seed, SWAY_WINDOW_MIN, 1, 0, 0.1, 0);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_search_start(&search, &least, &ring));
    fill_tone(&ring, &seed, SWAY_WINDOW_MIN - 1, 1, 0, 0.1, 0);
    TEST_ASSERT_EQUAL(SWAY_ERROR_NO_DATA, sway_search_start(&search, &least, &ring));
}

/* Powers that are put in, of a window of one second: a bin is a Hertz. */
static double found_hz(int32_t min_mhz, int32_t max_mhz)
{
    sway_real_t omega = sway_real_zero();
    search.config.sample_period_us = 15625;
    search.config.frequency_min_mhz = min_mhz;
    search.config.frequency_max_mhz = max_mhz;
    search.block = 1;
    TEST_ASSERT_TRUE(sway_search_result(&search, &omega));
    return value(omega) / (2 * M_PI);
}

/* The largest one of the band, to half a bin; of equals the lowest; what may be beyond it is not
 * looked for beyond three fifths. */
static void the_largest_power_of_the_band_is_found(void)
{
    memset(&search, 0, sizeof search);
    for (int k = 1; k < SWAY_SEARCH_POINTS / 2; k++) {
        search.power[k] = 100;
    }
    search.power[2] = search.power[9] = 10000;
    search.power[5] = search.power[7] = 8100;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2, found_hz(2499, 8000));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 5, found_hz(2500, 8000));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 5, found_hz(2500, 8499));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 9, found_hz(2500, 8500));
    search.power[1] = 20000;
    search.power[0] = 100;
    const double beside = found_hz(100, 8000);
    TEST_ASSERT_TRUE(beside > 1 && beside < 1.6);
    search.power[SWAY_SEARCH_POINTS / 2 - 1] = 1 << 24;
    search.power[SWAY_SEARCH_POINTS / 2 - 2] = 30000;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 30.6, found_hz(100, 50000));
}

/* Between bins of a Hann window a tone of amplitude 1 is seen as sinc(d) / (1 - d^2). */
static double hann(double d)
{
    return fabs(d) < 1e-9 ? 1 : sin(M_PI * d) / (M_PI * d) / (1 - d * d);
}

static void a_tone_between_bins_is_where_hanns_window_says(void)
{
    for (double x = -0.45; x < 0.46; x += 0.09) {
        TEST_ASSERT_DOUBLE_WITHIN(
            1e-5, x,
            value(sway_search_offset(real(hann(1 + x)), real(hann(x)), real(hann(1 - x)))));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.6, value(sway_search_offset(real(0), real(1), real(5))));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.6, value(sway_search_offset(real(5), real(1), real(0))));
}

/* One channel: it is read, transformed, added; then nothing is left. Two are transformed at once.
 */
static void a_search_is_as_many_slices_as_it_needs(void)
{
    sway_search_config_t how = {.channel_mask = SWAY_CHANNEL_BIT(1),
                                .sample_period_us = 10000,
                                .frequency_min_mhz = 250,
                                .frequency_max_mhz = 2000};
    for (int channels = 1; channels < 3; channels++) {
        how.channel_mask = channels == 1 ? 2U : 6U;
        fill_tone(&ring, &seed, 256, 1, 0, 0.1, 0.001);
        TEST_ASSERT_EQUAL(SWAY_OK, sway_search_start(&search, &how, &ring));
        for (int slice = 0; slice < channels + 1; slice++) {
            TEST_ASSERT_TRUE(sway_search_run(&search, &ring));
        }
        TEST_ASSERT_FALSE(sway_search_run(&search, &ring));
        TEST_ASSERT_FALSE(sway_search_run(&search, &ring));
    }
}

/* The power of a search, against the sum over the points of what a window of Hann's leaves of
 * them. */
static void expect_powers(uint32_t points, uint32_t block)
{
    double x[SWAY_SEARCH_POINTS], total = 0, found = 0;
    double expected[SWAY_SEARCH_POINTS / 2];
    double mean = 0, moment = 0, spread = 0;
    const uint32_t first = ring.filled - points * block;
    for (uint32_t b = 0; b < points; b++) {
        x[b] = 0;
        for (uint32_t k = 0; k < block; k++) {
            x[b] += ring.sample[1][first + b * block + k];
        }
        mean += x[b] / points;
    }
    for (uint32_t b = 0; b < points; b++) {
        const double at = b - (points - 1) / 2.0;
        moment += at * x[b];
        spread += at * at;
    }
    for (uint32_t b = 0; b < points; b++) {
        x[b] -= mean + (b - (points - 1) / 2.0) * moment / spread;
        x[b] *= (1 - cos(2 * M_PI * (b + 0.5) / points)) / 2;
    }
    for (int k = 0; k < SWAY_SEARCH_POINTS / 2; k++) {
        double re = 0, im = 0;
        for (uint32_t b = 0; b < points; b++) {
            re += x[b] * cos(2 * M_PI * k * b / SWAY_SEARCH_POINTS);
            im += x[b] * sin(2 * M_PI * k * b / SWAY_SEARCH_POINTS);
        }
        expected[k] = re * re + im * im;
        total += k > 0 ? expected[k] : 0;
        found += k > 0 ? search.power[k] : 0;
    }
    TEST_ASSERT_TRUE(found > (1 << 22) - 32 && found < 1 << 23);
    for (int k = 0; k < SWAY_SEARCH_POINTS / 2; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(3e-6 * found + 2, fmin(expected[k] / total * found, 1 << 24),
                                  search.power[k]);
    }
}

static void the_powers_are_those_of_the_windowed_sums(void)
{
    const sway_search_config_t how = {.channel_mask = SWAY_CHANNEL_BIT(1),
                                      .sample_period_us = 10000,
                                      .frequency_min_mhz = 250,
                                      .frequency_max_mhz = 2000};
    static const double hertz[5] = {0.7, 3.1, 1.9, 6.6, 0.25}; /* the last one is a slow bend */
    static const int rows[5] = {256, 300, 192, 256, 200};
    for (int c = 0; c < 5; c++) {
        fill_tone(&ring, &seed, rows[c], hertz[c], -0.2, 25, c == 3 ? 1 : 0);
        TEST_ASSERT_EQUAL(SWAY_OK, sway_search_start(&search, &how, &ring));
        while (sway_search_run(&search, &ring)) {
        }
        const uint32_t block = ((uint32_t)rows[c] + 63U) / 64U;
        expect_powers((uint32_t)rows[c] / block, block);
    }
}

/* What is left of a channel whose blows at both ends lift the rest off its mean: nearly all of it
 * is the window's own mean, four times the other bins, and held at 2^24. */
static void the_power_of_the_mean_is_bounded(void)
{
    const sway_search_config_t how = {.channel_mask = SWAY_CHANNEL_BIT(1),
                                      .sample_period_us = 10000,
                                      .frequency_min_mhz = 250,
                                      .frequency_max_mhz = 2000};
    int bounded = 0;
    for (int width = 1; width < 7; width++) {
        sway_ring_clear(&ring);
        for (int k = 0; k < 256; k++) {
            sway_row_t row;
            memset(&row, 0, sizeof row);
            row.present_mask = row.valid_mask = SWAY_CHANNEL_BIT(1);
            row.value[1] = k < 4 * width || k >= 256 - 4 * width ? -1000000 : 1000;
            sway_ring_push(&ring, &row);
        }
        TEST_ASSERT_EQUAL(SWAY_OK, sway_search_start(&search, &how, &ring));
        while (sway_search_run(&search, &ring)) {
        }
        bounded += search.power[0] == 1U << 24 ? 1 : 0;
        TEST_ASSERT_TRUE(search.power[0] <= 1U << 24);
    }
    TEST_ASSERT_TRUE(bounded > 1);
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
    RUN_TEST(test_sums_begin_anew_and_miss_no_step_of_one);
    RUN_TEST(test_windows_out_of_range_are_refused);
    RUN_TEST(a_search_takes_the_least_of_everything);
    RUN_TEST(the_largest_power_of_the_band_is_found);
    RUN_TEST(a_tone_between_bins_is_where_hanns_window_says);
    RUN_TEST(a_search_is_as_many_slices_as_it_needs);
    RUN_TEST(the_powers_are_those_of_the_windowed_sums);
    RUN_TEST(the_power_of_the_mean_is_bounded);
    return UNITY_END();
}

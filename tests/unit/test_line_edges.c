/* The bounds of an estimate, each from either side: a job's state is put in where a drive would
 * have to be found that ends just there. */
#include "line_feed.h"
#include "unity.h"

/* As in sway_line.c. */
enum { NORMAL = 16, NOISE = 19, STEP = 21 };

static sway_line_job_t job;
static sway_line_t line;
static sway_ring_t ring;
static sway_line_config_t how;

void setUp(void)
{
    memset(&job, 0, sizeof job);
    memset(&line, 0, sizeof line);
    sway_ring_clear(&ring);
    how = line_config();
}

void tearDown(void)
{
}

static void estimate(uint32_t window, double start_hz)
{
    TEST_ASSERT_EQUAL(SWAY_OK,
                      sway_line_start(&job, &how, &ring, window, real(2 * M_PI * start_hz), &line));
    while (sway_line_run(&job, &ring)) {
    }
}

/* --- blocks and channels ------------------------------------------------------------------------
 */

/* The shortest blocks, of four lengths, that lose at most 1/128 of the window; else those that lose
 * least. */
static void blocks_lose_few_rows(void)
{
    uint32_t seed = 3;
    fill_tone(&ring, &seed, SWAY_WINDOW_MAX, 0.7, 0, 0.1, 0.001);
    for (uint32_t window = SWAY_WINDOW_MIN; window <= SWAY_WINDOW_MAX; window++) {
        const uint32_t shortest = (uint32_t)ceil(window / (double)SWAY_FIT_BLOCKS);
        uint32_t least = window, expected = 0;
        for (uint32_t rows = shortest + 4U; rows-- > shortest;) {
            const bool enough = window / rows >= SWAY_FIT_BLOCKS / 2U || rows == shortest;
            least = enough && window % rows < least ? window % rows : least;
        }
        for (uint32_t rows = shortest; expected == 0U; rows++) {
            const bool few = window % rows <= window / 128U || window % rows == least;
            expected = few ? rows : 0U;
        }
        TEST_ASSERT_EQUAL(SWAY_OK, sway_line_start(&job, &how, &ring, window, real(4.4), &line));
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected, job.block, "rows in a block");
    }
}

/* A tone with its second harmonic and a gap of 30 rows in one channel, which alone takes part. */
static void one_channel(uint32_t channel)
{
    sway_ring_clear(&ring);
    for (int k = 0; k < 320; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        const double t = k * 0.01;
        row.time_us = 10000 * (int64_t)k;
        row.present_mask = row.valid_mask = SWAY_CHANNEL_BIT(channel);
        row.valid_mask = k >= 100 && k < 130 ? 0U : row.valid_mask;
        row.value[channel] =
            (int32_t)lround(1e5 * cos(4.4 * t) + 1.2e4 * cos(8.8 * t + 1) + 1e3 * cos(2.5 * k * k));
        sway_ring_push(&ring, &row);
    }
    how.channel_mask = SWAY_CHANNEL_BIT(channel);
    how.harmonics_mask = SWAY_CHANNEL_BIT(channel);
    how.steering_quiet_urad = INT32_MAX;
    estimate(320, 0.7);
}

/* The first channel is one like the others: gap and harmonics count. */
static void a_line_is_the_same_in_every_channel(void)
{
    one_channel(1);
    const sway_line_t first = line;
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_GAP, first.flags);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 4.4, value(first.omega_rad_s));
    for (uint32_t channel = 0; channel < SWAY_CHANNEL_HITCH_FX; channel++) {
        one_channel(channel);
        TEST_ASSERT_EQUAL_HEX32(first.flags, line.flags);
        TEST_ASSERT_EQUAL_MEMORY(&first.omega_rad_s, &line.omega_rad_s, sizeof line.omega_rad_s);
        TEST_ASSERT_EQUAL_MEMORY(&first.growth_1_s, &line.growth_1_s, sizeof line.growth_1_s);
        TEST_ASSERT_EQUAL_MEMORY(&first.channel[1], &line.channel[channel], sizeof line.channel[1]);
    }
}

/* Three quarters of the rows, to the row. */
static void a_speed_needs_three_quarters_of_its_rows(void)
{
    for (int known = 191; known <= 192; known++) {
        sway_ring_clear(&ring);
        for (int k = 0; k < 256; k++) {
            sway_row_t row;
            memset(&row, 0, sizeof row);
            row.present_mask = row.valid_mask = 2U;
            row.valid_mask |= k < known ? SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED) : 0U;
            row.value[1] = (int32_t)lround(1e5 * cos(0.044 * k));
            row.value[SWAY_CHANNEL_SPEED] = 20000;
            sway_ring_push(&ring, &row);
        }
        estimate(256, 0.7);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, known == 192 ? 20 : 0, value(line.speed_m_s));
    }
}

static void a_vehicle_that_stands_has_a_speed_of_0(void)
{
    for (int k = 0; k < 256; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        row.present_mask = row.valid_mask = 2U | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
        row.value[1] = (int32_t)lround(1e5 * cos(0.044 * k));
        sway_ring_push(&ring, &row);
    }
    estimate(256, 0.7);
    TEST_ASSERT_TRUE(sway_real_is_zero(line.speed_m_s));
    TEST_ASSERT_TRUE(sway_real_is_zero(line.speed_slope_m_s2));
    TEST_ASSERT_BITS_LOW(SWAY_LINE_SPEED_CHANGING, line.flags);
}

/* A channel of zeros: what is known of its amplitude is limited by the rounding of its samples, of
 * a variance of 1/12, over as many rows as the window has. */
static void what_is_0_is_known_to_its_rounding(void)
{
    uint32_t seed = 5;
    fill_tone(&ring, &seed, 300, 1, 0, 0.1, 0.001);
    estimate(300, 1);
    TEST_ASSERT_TRUE(sway_real_is_zero(line.channel[2].amplitude.re));
    const double se = 1e-6 * sqrt(2.0 / 300 / 12);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * se, se, value(line.channel[2].amplitude_se));
}

/* --- a block's variance --------------------------------------------------------------------------
 */

/* Of residuals whose squares add up to `squares`, by a model without columns. */
static double variance_of(double squares, uint32_t blocks, uint64_t missing, int32_t shift,
                          uint32_t rows)
{
    memset(&job, 0, sizeof job);
    job.line = &line;
    job.state = NORMAL;
    job.channel = 1;
    job.columns = SWAY_FIT_LINEAR;
    job.used_mask = 2U;
    job.block = rows;
    job.basis.blocks = blocks;
    job.data[1].sum[0] = (int32_t)lround(sqrt(squares));
    job.data[1].missing = missing;
    job.data[1].shift = shift;
    (void)sway_line_run(&job, &ring);
    return value(job.variance);
}

/* By the degrees of freedom less 2, as the variance of Student's t has them, of which there are 4
 * at least. Eight columns and the two that the channel has alone are taken off. */
static void few_blocks_leave_four_degrees_of_freedom(void)
{
    const double s = 1e8;
    TEST_ASSERT_DOUBLE_WITHIN(1, s / 20, variance_of(s, 32, 0, 0, 1));
    TEST_ASSERT_DOUBLE_WITHIN(1, s * 17 / 16 / 4, variance_of(s, 17, 1, 0, 1));
    TEST_ASSERT_DOUBLE_WITHIN(1, s * 17 / 14 / 2, variance_of(s, 17, 7, 0, 1));
    TEST_ASSERT_DOUBLE_WITHIN(1, s * 17 / 13 / 2, variance_of(s, 17, 15, 0, 1));
    TEST_ASSERT_DOUBLE_WITHIN(1, s * 17 / 11 / 2, variance_of(s, 17, 63, 0, 1));
}

/* A sum of `rows` rounded samples has rows/12, in units of 2^shift; as a rounded number itself it
 * has 1/12. */
static void a_variance_is_that_of_rounding_at_least(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 5 / 12.0, variance_of(0, 32, 0, 0, 5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 20 / 12.0 / 4, variance_of(0, 32, 0, 1, 20));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 1 / 12.0, variance_of(0, 32, 0, 3, 5));
}

/* --- what the residual says ----------------------------------------------------------------------
 */

/* A residual that is correlated: all blocks 1000. Whether it counts as a misfit beside a line whose
 * power is `times` what 5 % of it allow. */
static bool is_misfit(double times)
{
    memset(&job, 0, sizeof job);
    job.line = &line;
    job.channel = 1;
    job.columns = 4U;
    job.used_mask = 6U;
    job.block = 1;
    job.basis.blocks = 64;
    job.basis.scale = real(1);
    job.system[0].schur[0] = job.system[0].schur[2] = real(1);
    for (int b = 0; b < 64; b++) {
        job.residual[b] = 1000;
    }
    const double variance = 64e6 / (60 - 2);
    job.data[1].parameter[0] = real(sqrt(variance / 125e-5 * times));
    job.state = NOISE;
    (void)sway_line_run(&job, &ring);
    return !sway_real_is_zero(job.normal.misfit);
}

static void a_misfit_is_more_than_five_percent_of_the_line(void)
{
    TEST_ASSERT_TRUE(is_misfit(1 - 4e-6));
    TEST_ASSERT_FALSE(is_misfit(1 + 4e-6));
}

/* --- the step ------------------------------------------------------------------------------------
 */

/* The last pass with normal equations of these numbers; true: it has ended with a result. */
static bool ends(double growth_growth, double omega_omega, double growth_omega, double right_g,
                 double right_o)
{
    memset(&job, 0, sizeof job);
    job.line = &line;
    job.config = how;
    job.state = STEP;
    job.final = true;
    job.half_s = real(1.5);
    job.normal.growth_growth = real(growth_growth);
    job.normal.omega_omega = real(omega_omega);
    job.normal.growth_omega = real(growth_omega);
    job.normal.growth_right = real(right_g);
    job.normal.omega_right = real(right_o);
    job.normal.inflated = job.normal.all = real(1);
    line.flags = 0;
    line.omega_rad_s = real(4.4);
    (void)sway_line_run(&job, &ring);
    return (line.flags & SWAY_LINE_NOT_CONVERGED) == 0U && job.refits == 0U;
}

/* Growth and omega are apart where the determinant is more than 2^-20 of its product. */
static void equations_that_are_nearly_one_have_no_solution(void)
{
    const double e = ldexp(1, -20);
    TEST_ASSERT_TRUE(ends(1e4, 1e4, 1e4 * sqrt(1 - 1.05 * e), 0, 0));
    TEST_ASSERT_FALSE(ends(1e4, 1e4, 1e4 * sqrt(1 - 0.95 * e), 0, 0));
    TEST_ASSERT_FALSE(ends(1e4, 1e4, 2e4, 0, 0));
    TEST_ASSERT_FALSE(ends(0, 0, 0, 0, 0));
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_NO_OSCILLATION | SWAY_LINE_NOT_CONVERGED, line.flags);
    TEST_ASSERT_FALSE(sway_line_run(&job, &ring));
}

/* However well growth and omega are known, 1e-7 rad at the window's end is settled. */
static void a_step_of_a_tenth_of_a_microradian_is_small(void)
{
    const double sharp = 1e20;
    TEST_ASSERT_TRUE(ends(sharp, sharp, 0, 0.99e-7 * sharp, 0));
    TEST_ASSERT_TRUE(ends(sharp, sharp, 0, 0, -0.99e-7 * sharp));
    TEST_ASSERT_FALSE(ends(sharp, sharp, 0, 1.01e-7 * sharp, 0));
    TEST_ASSERT_FALSE(ends(sharp, sharp, 0, 0, 1.01e-7 * sharp));
}

/* --- what a result is called ---------------------------------------------------------------------
 */

static void put(uint32_t channel, double amplitude, double se, double second, double second_se)
{
    line.channel[channel].amplitude = sway_complex(real(0.6 * amplitude), real(-0.8 * amplitude));
    line.channel[channel].amplitude_se = real(se);
    line.channel[channel].second = sway_complex(real(-0.8 * second), real(0.6 * second));
    line.channel[channel].second_se = real(second_se);
}

/* Flags of a last pass whose result is in `line`, at this omega, known to this. */
static uint32_t flags_of(double omega, double omega_se, uint32_t used_mask)
{
    memset(&job, 0, sizeof job);
    job.line = &line;
    job.config = how;
    job.state = STEP;
    job.final = true;
    job.used_mask = used_mask;
    job.half_s = real(1.5);
    job.normal.growth_growth = job.normal.omega_omega = real(1 / pow(1.5 * omega_se, 2));
    job.normal.inflated = job.normal.all = real(1);
    line.flags = 0;
    line.omega_rad_s = real(omega);
    (void)sway_line_run(&job, &ring);
    return line.flags;
}

static void a_line_stands_out_by_eight_standard_errors(void)
{
    const uint32_t none = SWAY_LINE_NO_OSCILLATION;
    put(1, 8.01, 1, 0, 1);
    put(2, 7.99, 1, 0, 1);
    TEST_ASSERT_BITS_LOW(none, flags_of(4.4, 0.1, 6));
    TEST_ASSERT_BITS_LOW(none, flags_of(4.4, 0.1, 2));
    TEST_ASSERT_BITS_HIGH(none, flags_of(4.4, 0.1, 4)); // the other one does not take part
    put(SWAY_CHANNELS - 1U, 8.01, 1, 0, 1);
    TEST_ASSERT_BITS_LOW(none, flags_of(4.4, 0.1, 1U << (SWAY_CHANNELS - 1U)));
}

/* In the band from 0.25 to 2 Hz, which turns once at least (pi in half the window). */
static void a_line_is_in_its_band_and_known_to_a_tenth(void)
{
    const uint32_t none = SWAY_LINE_NO_OSCILLATION;
    const double hz = 2 * M_PI;
    put(1, 10, 1, 0, 1);
    how.frequency_min_mhz = 500;
    TEST_ASSERT_BITS_LOW(none, flags_of(hz * 0.5 * 1.0001, 0.1, 2));
    TEST_ASSERT_BITS_HIGH(none, flags_of(hz * 0.5 * 0.9999, 0.1, 2));
    TEST_ASSERT_BITS_LOW(none, flags_of(hz * 2 * 0.9999, 0.1, 2));
    TEST_ASSERT_BITS_HIGH(none, flags_of(hz * 2 * 1.0001, 0.1, 2));
    TEST_ASSERT_BITS_LOW(none, flags_of(4.4, 0.4399, 2));
    TEST_ASSERT_BITS_HIGH(none, flags_of(4.4, 0.4401, 2));
}

/* 2f is more than 15 % of a yaw rate that takes part, and known to be there by 5 standard errors.
 */
static void a_swing_is_nonlinear_from_15_percent_on(void)
{
    const uint32_t bent = SWAY_LINE_NONLINEAR;
    static const uint32_t yaw[] = {SWAY_CHANNEL_CAR_YAW_RATE, SWAY_CHANNEL_TRAILER_YAW_RATE};
    for (int k = 0; k < 2; k++) {
        const uint32_t mask = SWAY_CHANNEL_BIT(yaw[k]);
        memset(&line, 0, sizeof line);
        put(yaw[k], 10, 1, 1.5 * (1 + 2e-5), 0.1);
        TEST_ASSERT_BITS_HIGH(bent, flags_of(4.4, 0.1, mask));
        TEST_ASSERT_BITS_LOW(bent, flags_of(4.4, 0.1, 0xFFFFU & ~mask));
        put(yaw[k], 10, 1, 1.5 * (1 - 2e-5), 0.1);
        TEST_ASSERT_BITS_LOW(bent, flags_of(4.4, 0.1, mask));
        put(yaw[k], 10, 1, 2, 0.399);
        TEST_ASSERT_BITS_HIGH(bent, flags_of(4.4, 0.1, mask));
        put(yaw[k], 10, 1, 2, 0.401);
        TEST_ASSERT_BITS_LOW(bent, flags_of(4.4, 0.1, mask));
    }
    memset(&line, 0, sizeof line);
    put(SWAY_CHANNEL_CAR_LATERAL_ACC, 10, 1, 5, 0.1);
    TEST_ASSERT_BITS_LOW(bent, flags_of(4.4, 0.1, 0xFFFFU));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(blocks_lose_few_rows);
    RUN_TEST(a_line_is_the_same_in_every_channel);
    RUN_TEST(a_speed_needs_three_quarters_of_its_rows);
    RUN_TEST(a_vehicle_that_stands_has_a_speed_of_0);
    RUN_TEST(what_is_0_is_known_to_its_rounding);
    RUN_TEST(few_blocks_leave_four_degrees_of_freedom);
    RUN_TEST(a_variance_is_that_of_rounding_at_least);
    RUN_TEST(a_misfit_is_more_than_five_percent_of_the_line);
    RUN_TEST(equations_that_are_nearly_one_have_no_solution);
    RUN_TEST(a_step_of_a_tenth_of_a_microradian_is_small);
    RUN_TEST(a_line_stands_out_by_eight_standard_errors);
    RUN_TEST(a_line_is_in_its_band_and_known_to_a_tenth);
    RUN_TEST(a_swing_is_nonlinear_from_15_percent_on);
    return UNITY_END();
}

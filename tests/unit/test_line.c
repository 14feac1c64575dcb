/* Tests of sway_track, sway_line, sway_search and sway_fit on signals whose line is known. */
#include <math.h>
#include <string.h>

#include "signal/sway_track.h"
#include "unity.h"

#define F_HZ 0.67

static sway_track_t track;
static sway_track_work_t work;
static sway_row_t tick;
static int next_row;
static uint32_t seed;

static sway_line_t latest; /* estimate that was finished last */

/* One slice; sway_track_line() holds an estimate until the next one begins. */
static bool run_slice(void)
{
    const uint32_t before = sway_track_sequence(&track);
    const bool more = sway_track_run(&track);
    if (sway_track_sequence(&track) != before) {
        latest = *sway_track_line(&track);
    }
    return more;
}

void setUp(void)
{
    const sway_track_config_t config = sway_track_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
    latest = *sway_track_line(&track);
    memset(&tick, 0, sizeof tick);
    tick.present_mask = 0x1EU;
    tick.valid_mask = 0x1EU;
    next_row = 0;
    seed = 7;
}

void tearDown(void)
{
}

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

static double hz(const sway_line_t *line)
{
    return to_double(line->omega_rad_s) / (2.0 * M_PI);
}

/* Near to normal, standard deviation 1. */
static double noise(void)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        seed = seed * 1664525U + 1013904223U;
        sum += (double)(seed >> 8) / 16777216.0;
    }
    return sum;
}

typedef double (*signal_t)(double t_s, int channel);

/* The next `rows` rows of the signal, in micro-units, into channels 1..4. */
static void feed(signal_t signal, int rows)
{
    for (int i = 0; i < rows; i++, next_row++) {
        tick.time_us = (int64_t)next_row * 10000;
        for (int c = 1; c <= 4; c++) {
            tick.value[c] = (int32_t)lround(1e6 * signal(next_row * 0.01, c));
        }
        sway_track_push(&track, &tick);
        for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
            (void)run_slice();
        }
        tick.restart = false;
    }
}

static double phase_of(double t)
{
    return 2.0 * M_PI * F_HZ * t;
}

static double damped(double t, int channel)
{
    return 0.3 * channel + 0.1 * channel * exp(-0.1 * t) * cos(phase_of(t) + channel);
}

static double steady(double t, int channel)
{
    return 0.1 * channel * cos(phase_of(t) + channel);
}

static double noisy(double t, int channel)
{
    return steady(t, channel) + 0.001 * channel * noise();
}

static double still(double t, int channel)
{
    (void)t;
    return 0.01 * channel;
}

static double only_noise(double t, int channel)
{
    (void)t;
    return 0.001 * channel * noise();
}

static double with_second(double t, int channel)
{
    return steady(t, channel) + 0.02 * channel * cos(2.0 * phase_of(t) + 0.7);
}

static double with_impulses(double t, int channel)
{
    const int row = (int)lround(t * 100.0);
    return noisy(t, channel) + ((row + 31 * channel) % 150 == 0 ? 0.2 * channel : 0.0);
}

static double faster(double t, int channel)
{
    return 0.1 * channel * cos(2.0 * M_PI * 1.1 * t);
}

static void test_noise_free_damped_line_in_four_channels(void)
{
    feed(damped, 600);
    const sway_line_t *line = &latest;
    const double mid = (double)line->mid_time_us * 1e-6;
    TEST_ASSERT_EQUAL_HEX32(0, line->flags);
    TEST_ASSERT_EQUAL_HEX32(0x1E, line->valid_mask);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, F_HZ, hz(line));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -0.1, to_double(line->growth_1_s));
    for (int c = 1; c <= 4; c++) {
        const sway_line_channel_t *part = &line->channel[c];
        const double re = to_double(part->amplitude.re);
        const double im = to_double(part->amplitude.im);
        const double phase = remainder(phase_of(mid) + c - atan2(im, re), 2.0 * M_PI);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * c, 0.1 * c * exp(-0.1 * mid), hypot(re, im));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, phase);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.3 * c, to_double(part->mean));
    }
}

static void test_damping_ratio(void)
{
    feed(damped, 600);
    sway_real_t ratio;
    sway_real_t se;
    sway_line_damping(&latest, &ratio, &se);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.1 / hypot(0.1, 2.0 * M_PI * F_HZ), to_double(ratio));
    TEST_ASSERT_TRUE(to_double(se) > 0.0 && to_double(se) < 1e-4);
}

static void test_standard_errors_and_noise_are_of_the_right_size(void)
{
    feed(noisy, 1000);
    const sway_line_t *line = &latest;
    /* Bound of a steady line for four channels of 40 dB: 24 sigma^2 / (A^2 N^3) / 4, a little more
     * for the trend. */
    const double n = line->window_samples;
    const double bound = sqrt(24.0 * 1e-4 / (n * n * n) / 4.0) * 100.0;
    const double se = to_double(line->omega_se_rad_s);
    TEST_ASSERT_TRUE(se > 0.8 * bound && se < 2.0 * bound);
    TEST_ASSERT_TRUE(fabs(hz(line) - F_HZ) * 2.0 * M_PI < 4.0 * se);
    for (int c = 1; c <= 4; c++) {
        const double rms = to_double(line->channel[c].noise_rms);
        TEST_ASSERT_TRUE(rms > 0.6e-3 * c && rms < 1.5e-3 * c);
    }
}

static void test_no_motion_and_noise_are_no_oscillation(void)
{
    static const signal_t signals[] = {still, only_noise};
    for (int i = 0; i < 2; i++) {
        setUp();
        feed(signals[i], 600);
        const sway_line_t *line = &latest;
        TEST_ASSERT_TRUE(sway_track_sequence(&track) > 10U);
        TEST_ASSERT_TRUE((line->flags & SWAY_LINE_NO_OSCILLATION) != 0U);
        TEST_ASSERT_TRUE((line->flags & SWAY_LINE_SEEKING) != 0U);
    }
}

static void test_a_line_that_ends_is_lost_and_another_found(void)
{
    feed(steady, 600);
    TEST_ASSERT_EQUAL_HEX32(0, latest.flags);
    feed(only_noise, 600);
    TEST_ASSERT_TRUE((latest.flags & SWAY_LINE_SEEKING) != 0U);
    feed(faster, 800);
    TEST_ASSERT_EQUAL_HEX32(0, latest.flags);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.1, hz(&latest));
}

static void test_second_harmonic_is_measured_and_reported(void)
{
    feed(with_second, 900);
    const sway_line_t *line = &latest;
    const double mid = (double)line->mid_time_us * 1e-6;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, F_HZ, hz(line));
    TEST_ASSERT_TRUE((line->flags & SWAY_LINE_NONLINEAR) != 0U);
    for (int c = 1; c <= 4; c++) {
        const double re = to_double(line->channel[c].second.re);
        const double im = to_double(line->channel[c].second.im);
        const double phase = remainder(2.0 * phase_of(mid) + 0.7 - atan2(im, re), 2.0 * M_PI);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * c, 0.02 * c, hypot(re, im));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, phase);
    }
}

static void test_impulses_are_taken_out(void)
{
    feed(with_impulses, 1200);
    const sway_line_t *line = &latest;
    TEST_ASSERT_EQUAL_HEX32(0, line->flags & ~(uint32_t)SWAY_LINE_NONLINEAR);
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, F_HZ, hz(line));
}

static void test_a_gap_is_reported_and_does_not_bias(void)
{
    feed(noisy, 800);
    tick.valid_mask = 0x16U; // channel 3 fails for 300 ms, its value stands still
    for (int i = 0; i < 30; i++, next_row++) {
        tick.time_us = (int64_t)next_row * 10000;
        sway_track_push(&track, &tick);
        for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
            (void)run_slice();
        }
    }
    tick.valid_mask = 0x1EU;
    feed(noisy, 150);
    const sway_line_t *line = &latest;
    const double mid = (double)line->mid_time_us * 1e-6;
    TEST_ASSERT_TRUE((line->flags & SWAY_LINE_GAP) != 0U);
    TEST_ASSERT_TRUE((line->valid_mask & 8U) != 0U);
    const double re = to_double(line->channel[3].amplitude.re);
    const double im = to_double(line->channel[3].amplitude.im);
    const double se = to_double(line->channel[3].amplitude_se);
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * se, 0.3, hypot(re, im));
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, remainder(phase_of(mid) + 3 - atan2(im, re), 2.0 * M_PI));
}

static void test_a_channel_that_stays_silent_is_left_out(void)
{
    tick.valid_mask = 0x0EU;
    feed(noisy, 800);
    const sway_line_t *line = &latest;
    TEST_ASSERT_EQUAL_HEX32(0x0E, line->valid_mask);
    TEST_ASSERT_EQUAL_HEX32(0, line->flags); // nothing is missing in what is used
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, F_HZ, hz(line));
}

static void test_steering_marks_the_motion_as_forced(void)
{
    tick.present_mask = 0x1FU;
    tick.valid_mask = 0x1FU;
    for (int i = 0; i < 800; i++) {
        tick.value[0] = (int32_t)lround(300000.0 * sin(0.05 * i));
        feed(noisy, 1);
    }
    TEST_ASSERT_TRUE((latest.flags & SWAY_LINE_FORCED) != 0U);
    tick.value[0] = 400000; // held at an angle: quiet
    feed(noisy, 600);
    TEST_ASSERT_EQUAL_HEX32(0, latest.flags);
}

static void test_a_tone_of_the_driver_is_taken_apart(void)
{
    feed(noisy, 800);
    tick.present_mask = 0x1FU;
    tick.valid_mask = 0x1FU;
    int apart = 0;
    for (int i = 0; i < 1000; i++, next_row++) {
        const double t = next_row * 0.01;
        const double drive = cos(2.0 * M_PI * 0.5 * t);
        tick.time_us = (int64_t)next_row * 10000;
        tick.value[0] = (int32_t)lround(2e5 * drive);
        for (int c = 1; c <= 4; c++) {
            tick.value[c] = (int32_t)lround(1e6 * (noisy(t, c) + 0.05 * c * drive));
        }
        const uint32_t before = sway_track_sequence(&track);
        sway_track_push(&track, &tick);
        for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
            (void)run_slice();
        }
        const sway_line_t *line = &latest;
        if (sway_track_sequence(&track) != before &&
            (line->flags & SWAY_LINE_STEERING_MODELLED) != 0U && i > 500) {
            apart++;
            TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_STEERING_MODELLED | SWAY_LINE_FORCED, line->flags);
            TEST_ASSERT_DOUBLE_WITHIN(3e-3, F_HZ, hz(line));
            TEST_ASSERT_DOUBLE_WITHIN(2e-2, 0.0, to_double(line->growth_1_s));
        }
    }
    TEST_ASSERT_TRUE(apart > 10);
}

static void test_speed_and_its_slope(void)
{
    tick.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
    for (int i = 0; i < 800; i++) {
        tick.value[SWAY_CHANNEL_SPEED] = 20000 + 10 * i; // 1 m/s2
        feed(noisy, 1);
    }
    const sway_line_t *line = &latest;
    const double mid_row = (double)line->mid_time_us * 1e-4;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 20.0 + 0.01 * mid_row, to_double(line->speed_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.0, to_double(line->speed_slope_m_s2));
    TEST_ASSERT_TRUE((line->flags & SWAY_LINE_SPEED_CHANGING) != 0U);
}

static void test_ratio_with_a_known_delay(void)
{
    feed(damped, 600);
    sway_line_ratio_t ratio;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_line_ratio(&latest, SWAY_CHANNEL_TRAILER_YAW_RATE,
                                                   SWAY_CHANNEL_CAR_YAW_RATE, 20000, &ratio));
    /* channel 3 over channel 1: gain 3, 2 rad ahead; 20 ms older than it says. */
    const double angle = atan2(to_double(ratio.ratio.im), to_double(ratio.ratio.re));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 2.0 + phase_of(0.02), angle);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 3.0 * exp(-0.1 * 0.02),
                              hypot(to_double(ratio.ratio.re), to_double(ratio.ratio.im)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, to_double(ratio.coherence));
    TEST_ASSERT_EQUAL_INT(
        SWAY_ERROR_NO_DATA,
        sway_line_ratio(&latest, SWAY_CHANNEL_HITCH_FY, SWAY_CHANNEL_CAR_YAW_RATE, 0, &ratio));
    TEST_ASSERT_EQUAL_INT(
        SWAY_ERROR_ARGUMENT,
        sway_line_ratio(NULL, SWAY_CHANNEL_HITCH_FY, SWAY_CHANNEL_CAR_YAW_RATE, 0, &ratio));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_line_ratio(&latest, 1, 1, 0, NULL));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_ratio(&latest, SWAY_CHANNELS, 1, 0, &ratio));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_ratio(&latest, 1, SWAY_CHANNELS, 0, &ratio));
    latest.channel[1].amplitude = sway_complex(sway_real_int(0), sway_real_int(0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SINGULAR, sway_line_ratio(&latest, 2, 1, 0, &ratio));
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_line_ratio(&latest, 1, 2, 0, &ratio));
}

static void test_units_of_the_channels(void)
{
    for (int c = 0; c < (int)SWAY_CHANNEL_COUNT; c++) {
        const double per = c >= SWAY_CHANNEL_HITCH_FX ? 1e-3 : 1e-6;
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 * per, per, to_double(sway_line_unit((sway_channel_t)c)));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1e-6, to_double(sway_line_unit(SWAY_CHANNEL_SPEED)));
}

static double step_s;
static double step_by;

static double stepped(double t, int c)
{
    return noisy(t, c) * (t > step_s ? step_by : 1.0);
}

static void test_a_step_is_reported_from_its_entry_until_it_has_left(void)
{
    static const double by[] = {0.6, 1.5, 3.0};
    for (int k = 0; k < 12; k++) {
        int unmarked = 0;
        int marked = 0;
        uint32_t sequence = 0;
        setUp();
        step_s = 7.0 + 0.1 * k;
        step_by = by[k % 3];
        for (int i = 0; i < 1500; i++) {
            feed(stepped, 1);
            const sway_line_t *line = &latest;
            const double half_s = 0.005 * line->window_samples;
            const double from_mid_s = step_s - 1e-6 * (double)line->mid_time_us;
            if (sway_track_sequence(&track) != sequence && i > 500) {
                sequence = sway_track_sequence(&track);
                const bool flagged =
                    (line->flags & (SWAY_LINE_MISFIT | SWAY_LINE_NOT_CONVERGED)) != 0U;
                if (from_mid_s < 0.65 * half_s && from_mid_s > -0.9 * half_s) {
                    unmarked += flagged ? 0 : 1;
                    marked += flagged ? 1 : 0;
                } else if (fabs(from_mid_s) > 1.3 * half_s) {
                    TEST_ASSERT_EQUAL_HEX32(0, line->flags);
                }
            }
        }
        TEST_ASSERT_EQUAL_INT(0, unmarked);
        TEST_ASSERT_TRUE(marked >= 10);
    }
}

static void test_a_restart_of_the_grid_forgets_the_past(void)
{
    feed(noisy, 600);
    tick.restart = true;
    feed(noisy, 40);
    TEST_ASSERT_TRUE((latest.flags & SWAY_LINE_SEEKING) != 0U);
    TEST_ASSERT_TRUE(track.ring.filled == 40U);
    feed(noisy, 560);
    TEST_ASSERT_EQUAL_HEX32(0, latest.flags);
}

static void test_result_does_not_depend_on_how_often_it_runs(void)
{
    static sway_line_t lines[2];
    for (int k = 0; k < 2; k++) {
        setUp();
        for (int i = 0; i < 900; i++) {
            feed(noisy, 1);
            while (k == 1 && run_slice()) {
            }
        }
        lines[k] = latest;
    }
    TEST_ASSERT_EQUAL_INT64(lines[0].mid_time_us, lines[1].mid_time_us);
    TEST_ASSERT_EQUAL_INT32(lines[0].omega_rad_s.m, lines[1].omega_rad_s.m);
    TEST_ASSERT_EQUAL_MEMORY(&lines[0].channel[3].amplitude, &lines[1].channel[3].amplitude,
                             sizeof(sway_complex_t));
}

/* Samples at a period of their own, with jitter, through the grid. */
static void feed_through_grid(int64_t period_us, int64_t jitter_us, int samples)
{
    static sway_grid_t grid;
    const sway_grid_config_t config = sway_grid_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
    for (int i = 0; i < samples; i++) {
        const int64_t at = i * period_us + (int64_t)(jitter_us * (1.0 + tanh(noise())));
        const double x = noisy((double)at * 1e-6, SWAY_CHANNEL_TRAILER_YAW_RATE);
        (void)sway_grid_input(&grid, SWAY_INPUT_TRAILER_YAW_RATE, at, (int32_t)lround(1e6 * x));
        while (sway_grid_next_row(&grid, &tick)) {
            sway_track_push(&track, &tick);
            for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
                (void)run_slice();
            }
        }
    }
}

static void test_rates_other_than_the_grid_do_no_harm(void)
{
    static const int64_t periods_us[] = {9091, 11111, 20000, 50000}; // +10 %, -10 %, 50 and 20 Hz
    for (int k = 0; k < 4; k++) {
        setUp();
        feed_through_grid(periods_us[k], periods_us[k] / 20, (int)(10000000 / periods_us[k]));
        const sway_line_t *line = &latest;
        const double error = 2.0 * M_PI * (hz(line) - F_HZ);
        TEST_ASSERT_EQUAL_HEX32(0, line->flags);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * to_double(line->omega_se_rad_s), 0.0, error);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, error);
    }
}

static void test_full_scale_in_every_channel(void)
{
    tick.present_mask = 0xFFFFU;
    tick.valid_mask = 0xFFFFU;
    for (int i = 0; i < 700; i++, next_row++) {
        tick.time_us = (int64_t)next_row * 10000;
        for (int c = 0; c < SWAY_CHANNELS; c++) {
            tick.value[c] = (int32_t)lround(1.342e8 * cos(phase_of(i * 0.01) + 0.1 * c));
        }
        sway_track_push(&track, &tick);
        for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
            (void)run_slice();
        }
    }
    const sway_line_t *line = &latest;
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_FORCED, line->flags);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, F_HZ, hz(line));
}

static void test_search_finds_lines_over_the_band(void)
{
    static sway_search_t seek;
    const sway_search_config_t config = {0x1E, 10000, 250, 2000};
    for (int k = 0; k < 12; k++) {
        setUp();
        const double f = 0.4 + 0.12 * k;
        sway_real_t omega;
        for (int i = 0; i < 512; i++) {
            tick.value[1] = (int32_t)lround(5e6 + 1e5 * cos(2.0 * M_PI * f * i * 0.01 + k));
            sway_ring_push(&track.ring, &tick);
        }
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_search_start(&seek, &config, &track.ring));
        while (sway_search_run(&seek, &track.ring)) {
        }
        TEST_ASSERT_TRUE(sway_search_result(&seek, &omega));
        TEST_ASSERT_DOUBLE_WITHIN(0.03, f, to_double(omega) / (2.0 * M_PI));
    }
}

/* The band reaches above what the rows resolve: the last point with two neighbours is the end. */
static void test_search_stays_in_its_spectrum(void)
{
    static sway_search_t seek;
    const sway_search_config_t config = {0x02, 40000, 100, 10000};
    for (int point = 4; point < SWAY_SEARCH_POINTS / 2; point++) {
        setUp();
        sway_real_t omega;
        const double step_hz = 1 / (0.04 * SWAY_RING_SAMPLES);
        for (int i = 0; i < SWAY_RING_SAMPLES; i++) {
            tick.value[1] = (int32_t)lround(1e6 * cos(2 * M_PI * point * step_hz * i * 0.04 + 1));
            sway_ring_push(&track.ring, &tick);
        }
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_search_start(&seek, &config, &track.ring));
        while (sway_search_run(&seek, &track.ring)) {
        }
        TEST_ASSERT_TRUE(sway_search_result(&seek, &omega));
        const double found_hz = to_double(omega) / (2 * M_PI);
        if (point < SWAY_SEARCH_POINTS / 2 - 1) {
            TEST_ASSERT_DOUBLE_WITHIN(0.1 * step_hz, point * step_hz, found_hz);
        } else {
            TEST_ASSERT_TRUE(found_hz < (point - 0.3) * step_hz);
        }
    }
}

static void test_a_gap_of_the_steering_wheel_is_no_gap_of_the_line(void)
{
    tick.present_mask = 0x1FU;
    tick.valid_mask = 0x1FU;
    feed(noisy, 600);
    tick.valid_mask = 0x1EU;
    feed(noisy, 30);
    tick.valid_mask = 0x1FU;
    feed(noisy, 100);
    TEST_ASSERT_EQUAL_HEX32(0, latest.flags);
}

/* One and a quarter swing that dies out, on a slope: with `level` the slope is not fitted. */
static double growth_of_one_swing(double slope, bool level)
{
    static sway_line_job_t job;
    const sway_line_config_t config = {10000,      2, 250,    2000,   0,    0,
                                       UINT32_MAX, 0, {0, 0}, {0, 0}, level};
    sway_line_t line;
    sway_ring_clear(&track.ring);
    for (int i = 0; i < 110; i++) {
        const double t = 0.01 * i;
        tick.time_us = (int64_t)i * 10000;
        tick.value[1] = (int32_t)lround(1e6 * (exp(-2.5 * t) * cos(7.3 * t) + slope * t + 0.3));
        sway_ring_push(&track.ring, &tick);
    }
    TEST_ASSERT_EQUAL_INT(
        SWAY_OK, sway_line_start(&job, &config, &track.ring, 110, sway_real_int(7), &line));
    while (sway_line_run(&job, &track.ring)) {
    }
    TEST_ASSERT_EQUAL_HEX32(0, line.flags & SWAY_LINE_NOT_CONVERGED);
    return to_double(line.growth_1_s);
}

static void test_a_level_model_has_no_slope(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -2.5, growth_of_one_swing(0.0, false));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -2.5, growth_of_one_swing(0.0, true));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -2.5, growth_of_one_swing(0.1, false));
    /* what is not in the model goes into the line */
    TEST_ASSERT_TRUE(fabs(growth_of_one_swing(0.1, true) + 2.5) > 0.05);
}

static void test_bad_arguments_are_refused(void)
{
    sway_track_config_t config = sway_track_default(10000);
    config.window_cycles_milli = 1000;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config, &work));
    config = sway_track_default(10000);
    config.frequency_max_mhz = config.frequency_min_mhz;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config, &work));
    config = sway_track_default(999);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config, &work));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(NULL, &config, &work));
    const sway_line_config_t line = {10000,      2, 250,    2000,   0,    0,
                                     UINT32_MAX, 0, {0, 0}, {0, 0}, false};
    const sway_real_t omega = sway_real_int(4);
    static sway_line_job_t job;
    sway_line_t result;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &line, &track.ring, 8, omega, &result));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_NO_DATA,
                          sway_line_start(&job, &line, &track.ring, 300, omega, &result));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_line_start(&job, &line, &track.ring, 300,
                                                               sway_real_int(0), &result));
    TEST_ASSERT_FALSE(sway_line_run(&job, &track.ring));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_noise_free_damped_line_in_four_channels);
    RUN_TEST(test_a_level_model_has_no_slope);
    RUN_TEST(test_damping_ratio);
    RUN_TEST(test_standard_errors_and_noise_are_of_the_right_size);
    RUN_TEST(test_no_motion_and_noise_are_no_oscillation);
    RUN_TEST(test_a_line_that_ends_is_lost_and_another_found);
    RUN_TEST(test_second_harmonic_is_measured_and_reported);
    RUN_TEST(test_impulses_are_taken_out);
    RUN_TEST(test_a_gap_is_reported_and_does_not_bias);
    RUN_TEST(test_a_channel_that_stays_silent_is_left_out);
    RUN_TEST(test_steering_marks_the_motion_as_forced);
    RUN_TEST(test_a_tone_of_the_driver_is_taken_apart);
    RUN_TEST(test_speed_and_its_slope);
    RUN_TEST(test_ratio_with_a_known_delay);
    RUN_TEST(test_units_of_the_channels);
    RUN_TEST(test_a_step_is_reported_from_its_entry_until_it_has_left);
    RUN_TEST(test_a_restart_of_the_grid_forgets_the_past);
    RUN_TEST(test_result_does_not_depend_on_how_often_it_runs);
    RUN_TEST(test_rates_other_than_the_grid_do_no_harm);
    RUN_TEST(test_full_scale_in_every_channel);
    RUN_TEST(test_search_finds_lines_over_the_band);
    RUN_TEST(test_search_stays_in_its_spectrum);
    RUN_TEST(test_a_gap_of_the_steering_wheel_is_no_gap_of_the_line);
    RUN_TEST(test_bad_arguments_are_refused);
    return UNITY_END();
}

/* Arguments and configurations that are refused, one by one; estimates that do not end well. */
#include <math.h>
#include <string.h>

#include "signal/sway_track.h"
#include "line_feed.h"
#include "unity.h"

/* As in sway_track.c. */
enum { TRACK_IDLE, TRACK_SEARCH, TRACK_LINE, TRACK_TONE_SEARCH, TRACK_TONE, TRACK_HELD };

static sway_track_t track;
static sway_track_work_t work;
static sway_track_config_t config;
static sway_line_job_t job;
static sway_line_t line;
static sway_ring_t ring;
static sway_search_t search;

void setUp(void)
{
    config = sway_track_default(10000);
    memset(&job, 0, sizeof job);
    memset(&line, 0, sizeof line);
    memset(&work, 0, sizeof work);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
}

void tearDown(void)
{
}

static void fill(int rows, double hertz, double growth, double amplitude, double noise)
{
    uint32_t seed = 9;
    fill_tone(&ring, &seed, rows, hertz, growth, amplitude, noise);
}

/* The line from `start_hz`, the job left at its end. */
static void estimate(uint32_t window, double start_hz)
{
    const sway_line_config_t how = line_config();
    TEST_ASSERT_EQUAL_INT(
        SWAY_OK, sway_line_start(&job, &how, &ring, window, real(2 * M_PI * start_hz), &line));
    while (sway_line_run(&job, &ring)) {
    }
}

/* --- refused ---------------------------------------------------------------------------------- */

static void refuse_track(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config, &work));
    config = sway_track_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
}

static void a_track_refuses_each_wrong_value(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(NULL, &config, &work));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, NULL, &work));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config, NULL));
    config.sample_period_us = 999;
    refuse_track();
    config.sample_period_us = 100001;
    refuse_track();
    config.window_cycles_milli = 1499;
    refuse_track();
    config.window_cycles_milli = 6001;
    refuse_track();
    config.frequency_min_mhz = 99;
    refuse_track();
    config.frequency_max_mhz = 10001;
    refuse_track();
    config.frequency_min_mhz = config.frequency_max_mhz;
    refuse_track();
    config.channel_mask = 0;
    refuse_track();
    config.steering_quiet_urad = -1;
    refuse_track();
    config.speed_change_milli = -1;
    refuse_track();
    config.frequency_min_mhz = 100; // the ends themselves are taken
    config.frequency_max_mhz = 10000;
    config.window_cycles_milli = 1500;
    config.sample_period_us = 1000;
    config.steering_quiet_urad = 0;
    config.speed_change_milli = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
    config.window_cycles_milli = 6000;
    config.sample_period_us = 100000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
}

static void a_line_refuses_each_wrong_value(void)
{
    sway_line_config_t how = line_config();
    const sway_real_t omega = real(4.2);
    fill(300, 0.67, 0.0, 0.1, 0.001);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(NULL, &how, &ring, 200, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, NULL, &ring, 200, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, NULL, 200, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, &ring, 200, omega, NULL));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, &ring, SWAY_WINDOW_MIN - 1, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, &ring, SWAY_WINDOW_MAX + 1, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, &ring, 200, sway_real_zero(), &line));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_NO_DATA,
                          sway_line_start(&job, &how, &ring, 301, omega, &line));
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_line_start(&job, &how, &ring, 300, omega, &line));
    how.sample_period_us = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_line_start(&job, &how, &ring, 200, omega, &line));
    job.state = 200; // of a job that was never started
    TEST_ASSERT_EQUAL_UINT32(0U, sway_line_cost(&job));
    TEST_ASSERT_FALSE(sway_line_run(&job, &ring));
}

static void a_search_refuses_each_wrong_value(void)
{
    const sway_search_config_t good = {.channel_mask = 2U,
                                       .sample_period_us = 10000,
                                       .frequency_min_mhz = 250,
                                       .frequency_max_mhz = 2000};
    sway_search_config_t how = good;
    fill(300, 0.67, 0.0, 0.1, 0.001);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(NULL, &how, &ring));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(&search, NULL, &ring));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(&search, &how, NULL));
    how.sample_period_us = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(&search, &how, &ring));
    how = good;
    how.frequency_min_mhz = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(&search, &how, &ring));
    how = good;
    how.frequency_max_mhz = 250;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_search_start(&search, &how, &ring));
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_search_start(&search, &good, &ring));
}

/* --- what is no oscillation ------------------------------------------------------------------- */

static void what_lies_below_the_band_is_no_oscillation(void)
{
    fill(500, 0.235, 0.0, 0.1, 0.0005);
    estimate(480, 0.25);
    TEST_ASSERT_TRUE(value(line.omega_rad_s) < 2 * M_PI * 0.25);
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_NO_OSCILLATION, line.flags);
    fill(500, 0.27, 0.0, 0.1, 0.0005);
    estimate(480, 0.25);
    TEST_ASSERT_BITS_LOW(SWAY_LINE_NO_OSCILLATION, line.flags);
}

static void what_is_not_known_to_a_tenth_is_no_oscillation(void)
{
    fill(120, 1.1, 8.0, 0.2 * exp(-9.6), 0.001); // all of it in the last turn
    estimate(120, 1.1);
    TEST_ASSERT_TRUE(value(sway_complex_abs(line.channel[1].amplitude)) >
                     8.0 * value(line.channel[1].amplitude_se));
    TEST_ASSERT_TRUE(value(line.omega_se_rad_s) > 0.1 * value(line.omega_rad_s));
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_NO_OSCILLATION, line.flags);
}

static void a_channel_that_is_dead_does_not_stand_out(void)
{
    fill(300, 0.67, 0.0, 0.0, 0.0); // two channels of zeros: no amplitude, and no error of it
    estimate(280, 0.67);
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_NO_OSCILLATION, line.flags);
}

/* --- the model where there is no data --------------------------------------------------------- */

static void a_model_without_bounds_is_clipped(void)
{
    sway_real_t parameter[SWAY_FIT_LINEAR];
    int32_t model[SWAY_FIT_BLOCKS];
    fill(300, 0.67, 0.0, 0.1, 0.001);
    estimate(280, 0.67);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int i = 0; i < (int)SWAY_FIT_LINEAR; i++) {
            parameter[i] = sway_real_zero();
        }
        parameter[0] = sway_real_scale(sway_real_int(sign), 60);
        sway_fit_model(&job.basis, parameter, 4, UINT64_MAX, model);
        for (uint32_t b = 0; b < job.basis.blocks; b++) {
            TEST_ASSERT_TRUE(model[b] <= (1 << 28) && model[b] >= -(1 << 28));
        }
    }
}

/* Where rows are missing the model is put; however wild it is, the sums keep their bound. */
static void a_wild_model_of_missing_rows_is_clipped(void)
{
    const sway_line_config_t how = line_config();
    const int32_t bound = (1 << 27) - 1;
    for (int sign = -1; sign <= 1; sign += 2) {
        int32_t largest = 0;
        sway_ring_clear(&ring);
        for (int k = 0; k < 300; k++) {
            sway_row_t row;
            memset(&row, 0, sizeof row);
            row.time_us = 10000 * (int64_t)k;
            row.present_mask = SWAY_CHANNEL_BIT(1);
            row.valid_mask = k >= 100 && k < 120 ? 0U : SWAY_CHANNEL_BIT(1);
            row.value[1] = (int32_t)lround(1e5 * cos(2 * M_PI * 0.0067 * k));
            sway_ring_push(&ring, &row);
        }
        TEST_ASSERT_EQUAL_INT(
            SWAY_OK, sway_line_start(&job, &how, &ring, 280, real(2 * M_PI * 0.67), &line));
        bool more = true;
        while (more) {
            job.data[1].parameter[0] = sway_real_scale(sway_real_int(sign), 40);
            more = sway_line_run(&job, &ring);
            for (uint32_t b = 0; b < job.basis.blocks; b++) {
                const int32_t size =
                    job.data[1].sum[b] < 0 ? -job.data[1].sum[b] : job.data[1].sum[b];
                largest = size > largest ? size : largest;
            }
        }
        TEST_ASSERT_EQUAL_INT32(bound, largest);
    }
}

/* --- what the track does with a tone of the steering wheel ------------------------------------ */

/* A locked track whose estimate of a tone has just been finished. */
static void finish_tone(double tone_hz, double growth, uint64_t missing, uint32_t flags)
{
    setUp();
    track.locked = true;
    track.free = true;
    track.omega_rad_s = real(2 * M_PI * 0.67);
    track.state = TRACK_TONE;
    track.line.omega_rad_s = real(2 * M_PI * tone_hz);
    track.line.growth_1_s = real(growth);
    track.line.flags = flags;
    work.job.half_s = real(1.2);
    work.job.data[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].missing = missing;
    TEST_ASSERT_TRUE(sway_track_run(&track)); // the job is idle: it has ended
    TEST_ASSERT_EQUAL_INT(TRACK_HELD, track.state);
}

static void a_tone_counts_where_it_is_whole_apart_and_steady(void)
{
    finish_tone(0.9, 0.0, 0U, 0U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2 * M_PI * 0.9, value(track.forced_rad_s));
    finish_tone(0.9, 0.0, 0U, SWAY_LINE_MISFIT);
    TEST_ASSERT_EQUAL_INT32(0, track.forced_rad_s.m);
    finish_tone(0.9, 0.0, 4U, 0U);
    TEST_ASSERT_EQUAL_INT32(0, track.forced_rad_s.m);
    finish_tone(0.7, 0.0, 0U, 0U);
    TEST_ASSERT_EQUAL_INT32(0, track.forced_rad_s.m);
    finish_tone(0.9, 0.1, 0U, 0U);
    TEST_ASSERT_EQUAL_INT32(0, track.forced_rad_s.m);
}

static void finish_line(double of_tone, uint32_t flags)
{
    setUp();
    track.locked = true;
    track.free = true;
    track.state = TRACK_LINE;
    track.line.flags = flags;
    track.line.valid_mask = SWAY_CHANNEL_BIT(1);
    track.line.channel[1].amplitude.re = real(0.1);
    track.line.channel[1].amplitude_se = real(0.001);
    track.line.omega_rad_s = real(4.2);
    track.line.window_samples = 250;
    work.job.basis.scale = sway_real_int(1);
    work.job.data[1].parameter[0] = real(0.8); // of size 1
    work.job.data[1].parameter[1] = real(0.6);
    work.job.data[1].parameter[6] = real(of_tone);
    (void)sway_track_run(&track);
}

static void a_tone_that_is_larger_than_the_line_beside_it_takes_its_place(void)
{
    finish_line(0.9, SWAY_LINE_STEERING_MODELLED);
    TEST_ASSERT_TRUE(track.locked && track.free);
    finish_line(2.0, SWAY_LINE_STEERING_MODELLED);
    TEST_ASSERT_FALSE(track.locked || track.free);
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_SEEKING, track.line.flags);
    finish_line(2.0, 0U);
    TEST_ASSERT_TRUE(track.locked && track.free);
}

static void push_rows(int rows, double hertz)
{
    for (int k = 0; k < rows; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        row.time_us = 10000 * (int64_t)k;
        row.valid_mask = row.present_mask = SWAY_CHANNEL_BIT(0) | SWAY_CHANNEL_BIT(1);
        row.value[0] = row.value[1] = (int32_t)lround(1e5 * cos(2 * M_PI * hertz * 0.01 * k));
        sway_track_push(&track, &row);
    }
}

static void without_rows_for_a_tone_the_line_is_held_alone(void)
{
    track.locked = true; // nothing in the ring: no search of the steering wheel can begin
    track.free = true;
    track.omega_rad_s = real(4.2);
    track.line.flags = SWAY_LINE_FORCED;
    track.rows_to_hop = 0;
    (void)sway_track_run(&track);
    TEST_ASSERT_EQUAL_INT(TRACK_HELD, track.state);
}

/* A search over `rows` rows of a tone of the steering wheel for a line of `hertz`. */
static void search_tone(int rows, double tone_hz, double hertz)
{
    setUp();
    push_rows(rows, tone_hz);
    track.locked = true;
    track.free = true;
    track.omega_rad_s = real(2 * M_PI * hertz);
    track.line.flags = SWAY_LINE_FORCED;
    track.rows_to_hop = 0;
    (void)sway_track_run(&track);
    TEST_ASSERT_EQUAL_INT(TRACK_TONE_SEARCH, track.state);
    for (int slice = 0; slice < 200 && track.state == TRACK_TONE_SEARCH; slice++) {
        (void)sway_track_run(&track);
    }
}

static void a_tone_is_estimated_where_the_search_finds_it(void)
{
    search_tone(300, 0.67, 0.67);
    TEST_ASSERT_EQUAL_INT(TRACK_TONE, track.state);
    search_tone(300, 0.0, 0.67); // the wheel stands still
    TEST_ASSERT_EQUAL_INT(TRACK_HELD, track.state);
    search_tone(200, 0.67, 0.3); // fewer rows than the line's own window
    TEST_ASSERT_EQUAL_INT(TRACK_HELD, track.state);
}

static void a_window_too_short_for_any_estimate_starts_none(void)
{
    config.sample_period_us = 20000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
    push_rows(SWAY_WINDOW_MIN - 2, 2.0); // nearly all that is wanted, and fewer than any line needs
    track.locked = true;
    track.omega_rad_s = real(2 * M_PI * 3.0);
    track.state = TRACK_HELD;
    (void)sway_track_run(&track);
    TEST_ASSERT_EQUAL_INT(TRACK_IDLE, track.state);
    TEST_ASSERT_BITS_HIGH(SWAY_LINE_STARTING, track.line.flags);
}

/* --- the drift of the frequency --------------------------------------------------------------- */

static void a_drift_of_more_than_a_radian_is_not_believed(void)
{
    for (int fast = 0; fast < 2; fast++) {
        setUp();
        push_rows(300, 0.67);
        track.locked = true;
        track.omega_rad_s = real(4.2);
        track.past_count = SWAY_TRACK_HISTORY;
        for (int k = 0; k < (int)SWAY_TRACK_HISTORY; k++) {
            track.past_omega[k] = real(4.2 + (fast != 0 ? 1.0 : 0.02) * k);
            track.past_se[k] = real(0.001);
            track.past_us[k] = 300000 * (int64_t)k;
        }
        track.state = TRACK_HELD;
        (void)sway_track_run(&track);
        TEST_ASSERT_EQUAL_INT(TRACK_LINE, track.state);
        TEST_ASSERT_EQUAL_INT(fast, work.job.config.chirp_rad_s2.m == 0);
    }
}

/* Columns are those of a damped, bent oscillation, from whichever end, made in any portions. */
static void columns_are_those_of_a_bent_oscillation(void)
{
    static const double growth[] = {-0.03, 0.05, 0};
    static sway_fit_basis_t basis;
    for (int k = 0; k < 3; k++) {
        for (uint32_t portion = 1; portion <= 50U; portion += 7U) {
            const sway_fit_pole_t pole = {.growth = real(growth[k]),
                                          .omega = real(0.4),
                                          .chirp = real(k == 2 ? 0 : 0.004),
                                          .forced = real(0.25)};
            memset(&basis, 0x5A, sizeof basis);
            sway_fit_begin(&basis, 50, &pole);
            uint32_t calls = 1;
            while (sway_fit_columns(&basis, portion, false)) {
                calls++;
            }
            TEST_ASSERT_EQUAL_UINT32((50U + portion - 1U) / portion, calls);
            for (int b = 0; b < 50; b++) {
                const double u = b - 24.5;
                const double angle = value(pole.omega) * u + value(pole.chirp) * u * u / 2;
                const double size =
                    268435456 * exp(value(pole.growth) * u - fabs(value(pole.growth)) * 24.5);
                TEST_ASSERT_DOUBLE_WITHIN(100, size * cos(angle), basis.column[0][b]);
                TEST_ASSERT_DOUBLE_WITHIN(100, -size * sin(angle), basis.column[1][b]);
                TEST_ASSERT_DOUBLE_WITHIN(100, 268435456 * cos(0.25 * u), basis.column[6][b]);
                TEST_ASSERT_DOUBLE_WITHIN(100, -268435456 * sin(0.25 * u), basis.column[7][b]);
            }
        }
    }
}

/* Clipped to its sign, and only where it is asked for. */
static void a_model_is_clipped_to_either_side_where_it_is_asked_for(void)
{
    static sway_fit_basis_t basis;
    basis.blocks = 3;
    for (int sign = -1; sign <= 1; sign += 2) {
        int32_t model[3] = {7, 7, 7};
        sway_real_t parameter[4];
        memset(parameter, 0, sizeof parameter);
        parameter[SWAY_FIT_MEAN] = sway_real(sign, 40);
        sway_fit_model(&basis, parameter, 4, 2, model);
        TEST_ASSERT_EQUAL_INT32(7, model[0]);
        TEST_ASSERT_EQUAL_INT32(sign * (1 << 28), model[1]);
        TEST_ASSERT_EQUAL_INT32(7, model[2]);
        parameter[SWAY_FIT_MEAN] = sway_real(sign * 1000, 0);
        sway_fit_model(&basis, parameter, 4, 5, model);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, model[0]);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, model[2]);
    }
}

/* By what is left of the largest one without the mean, wherever it is and of either sign. */
static void sums_are_scaled_by_the_largest_that_is_left_of_them(void)
{
    for (int at = 0; at < 4; at++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            int64_t sums[4];
            int32_t data[4];
            int64_t mean;
            for (int b = 0; b < 4; b++) {
                sums[b] = (INT64_C(1) << 40) + (b == at ? sign * (INT64_C(1) << 32) : 0);
            }
            const int32_t shift = sway_fit_center(sums, 4, data, &mean);
            TEST_ASSERT_EQUAL_INT32(5, shift); // three quarters of 2^32 in 27 bits
            TEST_ASSERT_EQUAL_INT64((INT64_C(1) << 40) + sign * (INT64_C(1) << 30), mean);
            for (int b = 0; b < 4; b++) {
                TEST_ASSERT_EQUAL_INT32(sign * (b == at ? 3 : -1) * (1 << 25), data[b]);
            }
            for (int b = 0; b < 4; b++) {
                sums[b] = (INT64_C(1) << 40) + (b == at ? 3 * sign : -sign);
            }
            TEST_ASSERT_EQUAL_INT32(0, sway_fit_center(sums, 4, data, &mean));
        }
    }
}

/* Below 2^27 - 1 they stay as they are, of either sign; from there on they are halved. */
static void sums_of_27_bits_stay_as_they_are(void)
{
    const int64_t bound = (INT64_C(1) << 27) - 1;
    for (int64_t size = bound - 1; size <= bound; size++) {
        const int64_t sums[2] = {size, -size};
        int32_t data[2];
        int64_t mean;
        const int32_t shift = size == bound ? 1 : 0;
        TEST_ASSERT_EQUAL_INT32(shift, sway_fit_center(sums, 2, data, &mean));
        TEST_ASSERT_EQUAL_INT32(size / (1 + shift), data[0]);
        TEST_ASSERT_EQUAL_INT32(-size / (1 + shift), data[1]);
    }
}

/* --- the line's other fields --------------------------------------------------------------------
 */

/* 256 rows: channel 1 swings, the wheel moves by `ramp` in all and swings by `swing` rad, the speed
 * goes evenly from `from` to `to` m/s; `unknown` of each 64 rows have no speed. */
static void fill_drive(double ramp, double swing, double from, double to, int unknown)
{
    sway_ring_clear(&ring);
    for (int k = 0; k < 256; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        const double t = k * 0.01;
        row.time_us = 10000 * (int64_t)k;
        row.valid_mask = SWAY_CHANNEL_BIT(0) | SWAY_CHANNEL_BIT(1);
        row.present_mask = row.valid_mask;
        row.value[0] = (int32_t)lround(
            1e6 * (0.3 + ramp * k / 255 + swing * sin(2 * M_PI * 5 * (k + 0.5) / 256)));
        row.value[1] = (int32_t)lround(1e5 * cos(2 * M_PI * 0.67 * t));
        row.value[SWAY_CHANNEL_SPEED] = (int32_t)lround(1e3 * (from + (to - from) * k / 255));
        row.valid_mask |= k % 64 < unknown ? 0U : SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
        sway_ring_push(&ring, &row);
    }
}

/* A turn is not the driver's swing, however far; a swing of the wheel by more than a degree (rms of
 * what a straight line leaves) is. */
static void a_wheel_that_swings_forces_and_one_that_turns_does_not(void)
{
    static const double drives[][3] = {/* ramp, swing, forced */
                                       {0, 0, 0},      {3, 0, 0},      {-3, 0, 0},
                                       {0, 0.0242, 0}, {0, 0.0266, 1}, {3, 0.0242, 0},
                                       {-3, 0.0266, 1}};
    for (unsigned i = 0; i < sizeof drives / sizeof drives[0]; i++) {
        fill_drive(drives[i][0], drives[i][1], 25, 25, 0);
        estimate(256, 0.67);
        TEST_ASSERT_EQUAL(drives[i][2] != 0, (line.flags & SWAY_LINE_FORCED) != 0U);
    }
    const sway_line_config_t blind = {.channel_mask = SWAY_CHANNEL_BIT(1),
                                      .sample_period_us = 10000,
                                      .frequency_min_mhz = 250,
                                      .frequency_max_mhz = 2000,
                                      .steering_quiet_urad = 17453,
                                      .speed_change_milli = 50,
                                      .result_mask = SWAY_CHANNEL_BIT(1)};
    TEST_ASSERT_EQUAL_INT(SWAY_OK,
                          sway_line_start(&job, &blind, &ring, 256, real(2 * M_PI * 0.67), &line));
    while (sway_line_run(&job, &ring)) {
    }
    TEST_ASSERT_EQUAL_HEX32(SWAY_CHANNEL_BIT(1), line.valid_mask); // nobody has asked for the wheel
    TEST_ASSERT_EQUAL_HEX32(0, line.flags & SWAY_LINE_FORCED);
}

static void the_speed_is_its_mean_with_its_slope(void)
{
    fill_drive(0, 0, 20, 30, 0);
    estimate(256, 0.67);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 25, value(line.speed_m_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10 / 2.55, value(line.speed_slope_m_s2));
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int more = 0; more < 2; more++) { // 5 % over the window
            const double half = sign * (more != 0 ? 0.635 : 0.615);
            fill_drive(0, 0, 25 - half, 25 + half, 0);
            estimate(256, 0.67);
            TEST_ASSERT_EQUAL(more, (line.flags & SWAY_LINE_SPEED_CHANGING) != 0U);
        }
    }
    for (int unknown = 16; unknown <= 17; unknown++) { // three quarters are enough
        fill_drive(0, 0, 25, 25, unknown);
        estimate(256, 0.67);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, unknown == 16 ? 25 : 0, value(line.speed_m_s));
    }
}

/* Nothing of an estimate is needed for the next one, nor of what was in the memory. */
static void a_job_begins_anew(void)
{
    static sway_line_t clean;
    fill(300, 0.67, -0.2, 0.1, 0.01);
    memset(&job, 0, sizeof job);
    estimate(300, 0.6);
    clean = line;
    memset(&job, 0x5A, sizeof job);
    memset(&line, 0x5A, sizeof line);
    estimate(300, 0.6);
    TEST_ASSERT_EQUAL_HEX32(clean.flags, line.flags);
    TEST_ASSERT_EQUAL_MEMORY(&clean.omega_rad_s, &line.omega_rad_s, sizeof line.omega_rad_s);
    TEST_ASSERT_EQUAL_MEMORY(&clean.growth_1_s, &line.growth_1_s, sizeof line.growth_1_s);
    TEST_ASSERT_EQUAL_MEMORY(&clean.channel[1], &line.channel[1], sizeof line.channel[1]);
    TEST_ASSERT_EQUAL_INT32(clean.window_samples, line.window_samples);
}

/* At least 3/5 of a channel's blocks; what is missing in one that takes part is a gap. */
static void a_channel_needs_three_fifths_of_its_blocks(void)
{
    for (int more = 0; more < 2; more++) {
        fill(300, 0.67, 0, 0.1, 0.001); // 60 blocks of 5 rows
        for (uint32_t k = 0; k < 24U + (uint32_t)more; k++) {
            ring.valid[(10U + 5U * k) & (SWAY_RING_SAMPLES - 1U)] &= (uint16_t)~SWAY_CHANNEL_BIT(1);
        }
        estimate(300, 0.67);
        TEST_ASSERT_EQUAL_UINT32(5, job.block);
        TEST_ASSERT_EQUAL_HEX32(more == 0 ? SWAY_CHANNEL_BIT(1) | SWAY_CHANNEL_BIT(2)
                                          : SWAY_CHANNEL_BIT(2),
                                line.valid_mask);
        TEST_ASSERT_EQUAL(more == 0, (line.flags & SWAY_LINE_GAP) != 0U);
    }
}

/* --- the track, from values that are put in ------------------------------------------------------
 */

static void a_default_is_quiet_to_a_degree_and_steady_to_a_twentieth(void)
{
    TEST_ASSERT_EQUAL((int32_t)floor(1e6 * M_PI / 180), config.steering_quiet_urad);
    TEST_ASSERT_EQUAL(1000 / 20, config.speed_change_milli);
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_STARTING | SWAY_LINE_SEEKING, track.line.flags);
}

/* What a track has seen before a row that does not follow, it has not seen. */
static void a_restart_leaves_nothing_of_before(void)
{
    sway_row_t row;
    memset(&row, 0, sizeof row);
    row.present_mask = row.valid_mask = SWAY_CHANNEL_BIT(1);
    sway_track_push(&track, &row);
    memset(&track.spectrum, 0x11, sizeof track.spectrum);
    track.state = TRACK_LINE;
    track.locked = track.free = true;
    track.lost = 2;
    track.past_count = 3;
    track.rows_to_hop = 0;
    track.harmonics_mask = 6;
    track.change_time_us = 5;
    row.restart = true;
    sway_track_push(&track, &row);
    static const sway_spectrum_t empty;
    TEST_ASSERT_EQUAL_MEMORY(&empty, &track.spectrum, sizeof empty);
    TEST_ASSERT_EQUAL(TRACK_IDLE, track.state);
    TEST_ASSERT_FALSE(track.locked || track.free);
    TEST_ASSERT_EQUAL(0, track.lost + track.past_count + track.harmonics_mask);
    TEST_ASSERT_EQUAL(1, track.ring.filled);
    TEST_ASSERT_TRUE(track.rows_to_hop > 0U && track.change_time_us == INT64_MIN);
}

static void a_search_without_rows_is_given_up(void)
{
    fill(20, 0.7, 0, 0.1, 0.001);
    track.ring = ring;
    track.line.valid_mask = 6;
    track.sequence = 7;
    TEST_ASSERT_EQUAL(0, sway_track_cost(&track));
    TEST_ASSERT_FALSE(sway_track_run(&track)); /* not yet */
    track.rows_to_hop = 1;
    TEST_ASSERT_EQUAL(0, sway_track_cost(&track));
    track.rows_to_hop = 0;
    TEST_ASSERT_TRUE(sway_track_cost(&track) > 0U);
    TEST_ASSERT_FALSE(sway_track_run(&track));
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_STARTING | SWAY_LINE_SEEKING, track.line.flags);
    TEST_ASSERT_EQUAL(0, track.line.valid_mask);
    TEST_ASSERT_EQUAL(8, sway_track_sequence(&track));
}

/* Starts the line that is held, of 200 rows where it turns once a second. */
static void start_held(int rows)
{
    fill(rows, 1, 0, 0.1, 0.001);
    track.ring = ring;
    track.locked = true;
    track.omega_rad_s = real(2 * M_PI);
    track.state = TRACK_HELD;
    (void)sway_track_run(&track);
}

static void a_line_needs_seven_tenths_of_its_window(void)
{
    start_held(139);
    TEST_ASSERT_EQUAL(TRACK_IDLE, track.state);
    start_held(140);
    TEST_ASSERT_EQUAL(TRACK_LINE, track.state);
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_STARTING, track.line.flags & SWAY_LINE_STARTING);
    start_held(200);
    TEST_ASSERT_EQUAL(TRACK_LINE, track.state);
    TEST_ASSERT_EQUAL_HEX32(0, track.line.flags & SWAY_LINE_STARTING);
}

/* A drift is known beyond four standard errors, and below a bow of one radian at the ends. */
static void a_drift_is_known_that_stands_out_and_bends_little(void)
{
    static const struct {
        double change, se;
        bool known;
    } cases[] = {{0.41, 0.07, true}, {-0.41, 0.07, true}, {0.39, 0.07, false}, {1.9, 0.01, true},
                 {2.1, 0.01, false}, {-1.9, 0.01, true},  {-2.1, 0.01, false}, {0, 0, false}};
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        for (int k = 0; k < SWAY_TRACK_HISTORY; k++) {
            track.past_omega[k] = real(6 + cases[c].change * k / (double)(SWAY_TRACK_HISTORY - 1));
            track.past_se[k] = real(cases[c].se);
            track.past_us[k] = 2000000 * (int64_t)k / (SWAY_TRACK_HISTORY - 1);
        }
        track.past_count = SWAY_TRACK_HISTORY;
        start_held(200); /* a second to each side */
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, cases[c].known ? cases[c].change / 2 : 0,
                                  value(work.job.config.chirp_rad_s2));
    }
    track.past_count = SWAY_TRACK_HISTORY - 1;
    start_held(200);
    TEST_ASSERT_EQUAL_DOUBLE(0, value(work.job.config.chirp_rad_s2));
}

static void put_channel(int channel, double size, double se)
{
    track.line.channel[channel].amplitude = sway_complex(real(size), sway_real_zero());
    track.line.channel[channel].amplitude_se = real(se);
}

static sway_channel_t pilot_of(uint32_t valid, uint32_t used)
{
    track.line.valid_mask = valid;
    track.config.channel_mask = used;
    track.state = TRACK_IDLE;
    track.rows_to_hop = 0;
    track.locked = true;
    track.lost = 1;
    track.pilot = SWAY_CHANNEL_COUNT;
    (void)sway_track_run(&track);
    TEST_ASSERT_EQUAL(TRACK_HELD, track.state);
    return track.pilot;
}

/* Of the channels that are valid and used the one that stands out most, however little. */
static void the_pilot_is_the_clearest_channel(void)
{
    for (int c = 0; c < SWAY_CHANNELS; c++) {
        put_channel(c, 0.5, 1);
    }
    put_channel(0, 3, 1);
    put_channel(2, 6, 1);
    put_channel(3, 8, 2);
    put_channel(4, 9, 1);
    TEST_ASSERT_EQUAL(4, pilot_of(31, 31));
    TEST_ASSERT_EQUAL(2, pilot_of(15, 31));
    TEST_ASSERT_EQUAL(2, pilot_of(31, 15));
    TEST_ASSERT_EQUAL(3, pilot_of(11, 9 + 2));
    TEST_ASSERT_EQUAL(0, pilot_of(3, 3));
    TEST_ASSERT_EQUAL(1, pilot_of(2, 31));
    TEST_ASSERT_EQUAL(1, pilot_of(3, 2));
    TEST_ASSERT_EQUAL(0, pilot_of(1, 31));
    TEST_ASSERT_EQUAL(0, pilot_of(0, 31)); /* none: the first */
    track.lost = 0;
    track.pilot = SWAY_CHANNEL_COUNT;
    track.state = TRACK_IDLE;
    (void)sway_track_run(&track);
    TEST_ASSERT_EQUAL(SWAY_CHANNEL_COUNT, track.pilot); /* while it is held none is asked for */
}

/* A driven line that had been free is looked at for the driver's tone. */
static void a_tone_is_sought_beside_a_free_line_that_is_driven(void)
{
    for (int c = 0; c < 4; c++) {
        fill(300, 1, 0, 0.1, 0.001);
        track.ring = ring;
        track.locked = true;
        track.lost = 0;
        track.state = TRACK_IDLE;
        track.rows_to_hop = 0;
        track.free = c % 2 == 1;
        track.line.flags = c / 2 == 1 ? SWAY_LINE_FORCED : SWAY_LINE_GAP;
        (void)sway_track_run(&track);
        TEST_ASSERT_EQUAL(c == 3 ? TRACK_TONE_SEARCH : TRACK_HELD, track.state);
    }
}

/* The job is done: what its line says is taken. */
static void end_line(int state, uint32_t flags, double omega, double growth)
{
    memset(&work.job, 0, sizeof work.job);
    work.job.half_s = real(2);
    track.state = (uint8_t)state;
    track.line.flags = flags;
    track.line.omega_rad_s = real(omega);
    track.line.growth_1_s = real(growth);
    track.line.window_samples = 400;
    track.line.mid_time_us = 10000000;
    (void)sway_track_run(&track);
}

/* Over the window (4 s) a quarter of a turn from the line, and a tenth of growth at most. */
static void a_tone_counts_that_is_clean_steady_and_apart(void)
{
    static const struct {
        double apart, growth;
        uint32_t flags;
        bool counts;
    } cases[] = {
        {0.40, 0, 0, true},
        {0.38, 0, 0, false},
        {-0.40, 0, 0, true},
        {-0.38, 0, 0, false},
        {0.5, 0.024, 0, true},
        {0.5, 0.0261, 0, false},
        {0.5, -0.024, 0, true},
        {0.5, -0.0261, 0, false},
        {0.5, 0, SWAY_LINE_MISFIT, false},
        {0.5, 0.0235, 0, true},
        {0.5, 0, SWAY_LINE_NOT_CONVERGED, false},
        {0.5, 0, SWAY_LINE_NO_OSCILLATION, false},
        {0.5, 0, SWAY_LINE_FORCED, true},
    };
    track.locked = true;
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        track.omega_rad_s = real(6);
        track.forced_rad_s = sway_real_zero();
        end_line(TRACK_TONE, cases[c].flags, 6 + cases[c].apart, cases[c].growth);
        TEST_ASSERT_EQUAL(TRACK_HELD, track.state);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, cases[c].counts ? 6 + cases[c].apart : 0,
                                  value(track.forced_rad_s));
    }
}

static void a_line_that_is_taken_tells_whether_it_is_free(void)
{
    track.sequence = 4;
    end_line(TRACK_LINE, 0, 6, 0);
    TEST_ASSERT_TRUE(track.locked && track.free);
    TEST_ASSERT_EQUAL(5, track.sequence);
    TEST_ASSERT_TRUE(track.past_count == 1U && track.lost == 0U);
    TEST_ASSERT_DOUBLE_WITHIN(1, 2 * 100 * 2 * M_PI / 6, track.spectrum.window);
    end_line(TRACK_LINE, SWAY_LINE_FORCED, 6, 0);
    TEST_ASSERT_TRUE(track.free); /* it was */
    TEST_ASSERT_EQUAL(0, track.past_count);
    end_line(TRACK_LINE, 0, 6, 0);
    track.free = false;
    end_line(TRACK_LINE, SWAY_LINE_FORCED, 6, 0);
    TEST_ASSERT_FALSE(track.free);
    for (int k = 0; track.locked; k++) { /* lost after some estimates without a line */
        TEST_ASSERT_TRUE(k < 10);
        track.free = true;
        track.past_count = 3;
        end_line(TRACK_LINE, SWAY_LINE_NO_OSCILLATION, 6, 0);
    }
    TEST_ASSERT_FALSE(track.free);
    TEST_ASSERT_EQUAL(0, track.past_count);
    TEST_ASSERT_EQUAL_HEX32(SWAY_LINE_SEEKING, track.line.flags & SWAY_LINE_SEEKING);
}

/* The sliding window follows when it is off by more than a sixteenth. */
static void the_sliding_window_follows_by_sixteenths(void)
{
    static const struct {
        uint32_t have;
        bool stays;
    } cases[] = {{200, true},  {188, true},  {212, true}, {187, false},
                 {213, false}, {100, false}, {300, false}};
    for (unsigned c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        TEST_ASSERT_EQUAL(SWAY_OK, sway_spectrum_init(&track.spectrum, cases[c].have));
        end_line(TRACK_LINE, 0, 2 * M_PI, 0);
        TEST_ASSERT_EQUAL(cases[c].stays ? cases[c].have : 200, track.spectrum.window);
    }
    TEST_ASSERT_EQUAL(SWAY_OK, sway_spectrum_init(&track.spectrum, 150)); /* exactly a sixteenth */
    end_line(TRACK_LINE, 0, 2 * M_PI * 200 / 160, 0);
    TEST_ASSERT_EQUAL(150, track.spectrum.window);
}

/* --- a line's job --------------------------------------------------------------------------------
 */

static void a_job_keeps_nothing_of_the_one_before(void)
{
    sway_line_config_t how = line_config();
    fill(300, 1, 0, 0.1, 0.001);
    memset(&job, 0xFF, sizeof job);
    TEST_ASSERT_EQUAL(SWAY_OK, sway_line_start(&job, &how, &ring, 200, real(6), &line));
    TEST_ASSERT_FALSE(job.converged || job.broken || job.final || job.changed);
    for (int c = 0; c < SWAY_CHANNELS; c++) {
        TEST_ASSERT_TRUE(job.data[c].missing == 0U && job.data[c].lost == 0U);
    }
    how.sample_period_us = 1;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_line_start(&job, &how, &ring, 200, real(6), &line));
}

static void a_state_that_is_none_costs_and_does_nothing(void)
{
    for (unsigned state = 23; state < 256U; state++) { /* as many as sway_line.c has */
        memset(&job, 0, sizeof job);
        job.state = (uint8_t)state;
        TEST_ASSERT_EQUAL(0, sway_line_cost(&job));
        TEST_ASSERT_FALSE(sway_line_run(&job, &ring));
        TEST_ASSERT_EQUAL(state, job.state);
    }
}

/* 192 rows with a wheel that is turned evenly by `turned` and swings by `swing`, at a speed that
 * grows by 960 mm/s. */
static uint32_t flags_of(double turned, double swing, int32_t mean_mm_s)
{
    const sway_line_config_t how = line_config();
    sway_ring_clear(&ring);
    for (int k = 0; k < 192; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        row.time_us = 10000 * (int64_t)k;
        row.valid_mask = 3U | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
        row.present_mask = row.valid_mask;
        row.value[0] = (int32_t)lround(
            1e6 * (turned * (k - 95.5) / 192 + swing * cos(2 * M_PI * (k - 95.5) / 96)));
        row.value[1] = (int32_t)lround(1e5 * sin(0.07 * k));
        row.value[SWAY_CHANNEL_SPEED] = (mean_mm_s * 2 - 955 + 10 * k) / 2;
        sway_ring_push(&ring, &row);
    }
    TEST_ASSERT_EQUAL(SWAY_OK, sway_line_start(&job, &how, &ring, 192, real(6), &line));
    for (int slice = 0; slice < 20 && sway_line_run(&job, &ring); slice++) {
    }
    return line.flags;
}

/* A wheel that is only turned, however far, does not swing: a degree about its line is quiet. */
static void a_wheel_is_quiet_about_its_line(void)
{
    const double degree = M_PI / 180;
    const uint32_t forced = SWAY_LINE_FORCED;
    TEST_ASSERT_EQUAL_HEX32(0, flags_of(0.5, 0, 20000) & forced);
    TEST_ASSERT_EQUAL_HEX32(0, flags_of(-2, 0, 20000) & forced);
    TEST_ASSERT_EQUAL_HEX32(0, flags_of(0, 1.40 * degree, 20000) & forced); /* rms: by root 2 */
    TEST_ASSERT_EQUAL_HEX32(forced, flags_of(0, 1.50 * degree, 20000) & forced);
}

static void a_speed_changes_from_its_twentieth_on(void)
{
    const uint32_t changing = SWAY_LINE_SPEED_CHANGING;
    TEST_ASSERT_EQUAL_HEX32(0, flags_of(0, 0, 19212) & changing);
    TEST_ASSERT_EQUAL_HEX32(changing, flags_of(0, 0, 19190) & changing);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_track_refuses_each_wrong_value);
    RUN_TEST(a_line_refuses_each_wrong_value);
    RUN_TEST(a_search_refuses_each_wrong_value);
    RUN_TEST(what_lies_below_the_band_is_no_oscillation);
    RUN_TEST(what_is_not_known_to_a_tenth_is_no_oscillation);
    RUN_TEST(a_channel_that_is_dead_does_not_stand_out);
    RUN_TEST(a_model_without_bounds_is_clipped);
    RUN_TEST(a_wild_model_of_missing_rows_is_clipped);
    RUN_TEST(a_tone_counts_where_it_is_whole_apart_and_steady);
    RUN_TEST(a_tone_that_is_larger_than_the_line_beside_it_takes_its_place);
    RUN_TEST(without_rows_for_a_tone_the_line_is_held_alone);
    RUN_TEST(a_tone_is_estimated_where_the_search_finds_it);
    RUN_TEST(a_window_too_short_for_any_estimate_starts_none);
    RUN_TEST(a_drift_of_more_than_a_radian_is_not_believed);
    RUN_TEST(columns_are_those_of_a_bent_oscillation);
    RUN_TEST(a_model_is_clipped_to_either_side_where_it_is_asked_for);
    RUN_TEST(sums_are_scaled_by_the_largest_that_is_left_of_them);
    RUN_TEST(sums_of_27_bits_stay_as_they_are);
    RUN_TEST(a_wheel_that_swings_forces_and_one_that_turns_does_not);
    RUN_TEST(the_speed_is_its_mean_with_its_slope);
    RUN_TEST(a_job_begins_anew);
    RUN_TEST(a_channel_needs_three_fifths_of_its_blocks);
    RUN_TEST(a_default_is_quiet_to_a_degree_and_steady_to_a_twentieth);
    RUN_TEST(a_restart_leaves_nothing_of_before);
    RUN_TEST(a_search_without_rows_is_given_up);
    RUN_TEST(a_line_needs_seven_tenths_of_its_window);
    RUN_TEST(a_drift_is_known_that_stands_out_and_bends_little);
    RUN_TEST(the_pilot_is_the_clearest_channel);
    RUN_TEST(a_tone_is_sought_beside_a_free_line_that_is_driven);
    RUN_TEST(a_tone_counts_that_is_clean_steady_and_apart);
    RUN_TEST(a_line_that_is_taken_tells_whether_it_is_free);
    RUN_TEST(the_sliding_window_follows_by_sixteenths);
    RUN_TEST(a_job_keeps_nothing_of_the_one_before);
    RUN_TEST(a_state_that_is_none_costs_and_does_nothing);
    RUN_TEST(a_wheel_is_quiet_about_its_line);
    RUN_TEST(a_speed_changes_from_its_twentieth_on);
    return UNITY_END();
}

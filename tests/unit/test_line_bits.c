/* Every bit that the estimator says of a recording in which everything happens. Integer arithmetic
 * gives the same bits on every machine, so a change of these sums is a change of the results: it
 * must be meant, and then the sums below are to be replaced by those that the test prints. */
#include <stdio.h>
#include <string.h>

#include "signal/sway_track.h"
#include "unity.h"

static sway_track_t track;
static sway_track_work_t work;
static sway_row_t tick;
static int64_t next_row;
static uint32_t seed;
static uint64_t sum;
static int estimates;
static uint32_t flags; ///< seen in any

/* Two oscillators in Q24, turned and grown by integers in Q30: the sway and the driver. */
typedef struct {
    int64_t re;
    int64_t im;
} pointer_t;

static pointer_t sway;
static pointer_t driver;

static void turn(pointer_t *p, int64_t c, int64_t s)
{
    const int64_t half = INT64_C(1) << 29;
    const int64_t re = p->re * c - p->im * s + half;
    const int64_t im = p->re * s + p->im * c + half;
    p->re = re >= 0 ? re >> 30 : -(-re >> 30);
    p->im = im >= 0 ? im >> 30 : -(-im >> 30);
}

static int32_t noise(int32_t size)
{
    seed = seed * 1664525U + 1013904223U;
    const int32_t first = (int32_t)(seed >> 16) - 32768;
    seed = seed * 1664525U + 1013904223U;
    return (int32_t)((int64_t)(first + (int32_t)(seed >> 16) - 32768) * size / 65536);
}

static void add(uint64_t value)
{
    for (int byte = 0; byte < 8; byte++) {
        sum = (sum ^ ((value >> (8 * byte)) & 0xFFU)) * UINT64_C(1099511628211);
    }
}

static void add_real(sway_real_t x)
{
    add((uint64_t)(int64_t)x.m);
    add(x.m == 0 ? 0U : (uint64_t)(int64_t)x.e);
}

static void add_line(const sway_line_t *line)
{
    sway_real_t damping;
    sway_real_t se;
    add((uint64_t)line->mid_time_us);
    add((uint64_t)(int64_t)line->window_samples);
    add(line->flags);
    flags |= line->flags;
    add(line->valid_mask);
    add_real(line->omega_rad_s);
    add_real(line->growth_1_s);
    if ((line->flags & (SWAY_LINE_SEEKING | SWAY_LINE_NO_OSCILLATION)) != 0U) {
        return;
    }
    add_real(line->omega_se_rad_s);
    add_real(line->growth_se_1_s);
    add_real(line->speed_m_s);
    add_real(line->speed_slope_m_s2);
    sway_line_damping(line, &damping, &se);
    add_real(damping);
    add_real(se);
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        const sway_line_channel_t *channel = &line->channel[c];
        sway_line_ratio_t ratio;
        if ((line->valid_mask & SWAY_CHANNEL_BIT(c)) == 0U) {
            continue;
        }
        add_real(channel->amplitude.re);
        add_real(channel->amplitude.im);
        add_real(channel->amplitude_se);
        add_real(channel->phase_se_rad);
        add_real(channel->second.re);
        add_real(channel->second.im);
        add_real(channel->second_se);
        add_real(channel->mean);
        add_real(channel->noise_rms);
        if (sway_line_ratio(line, (sway_channel_t)c, SWAY_CHANNEL_TRAILER_YAW_RATE, 7000, &ratio) ==
            SWAY_OK) {
            add_real(ratio.ratio.re);
            add_real(ratio.ratio.im);
            add_real(ratio.se);
            add_real(ratio.coherence);
        }
    }
}

/* What the next rows hold. */
typedef struct {
    int rows;
    int64_t turn_re; ///< Q30: growth and frequency of the sway
    int64_t turn_im;
    int32_t scale;    ///< of the sway, 1/16
    int32_t drive;    ///< of the driver's tone, urad
    int32_t second;   ///< of 2f, 1/256 of the square
    int32_t noise;    ///< micro-units
    int32_t slope;    ///< of the speed, mm/s a row
    uint32_t valid;   ///< channels that are data
    uint32_t impulse; ///< one row in so many; 0: none
    uint64_t expected;
} part_t;

static void make_row(const part_t *part, int row)
{
    tick.time_us = next_row * 10000;
    tick.valid_mask = part->valid | SWAY_CHANNEL_BIT(SWAY_CHANNEL_SPEED);
    turn(&sway, part->turn_re, part->turn_im);
    turn(&driver, 1073211997, 33727046); // 0.5 Hz
    const int64_t second = (sway.re * sway.re - sway.im * sway.im) >> 24;
    for (int c = 0; c < SWAY_CHANNELS; c++) {
        const int64_t line = c % 3 == 0 ? sway.re : c % 3 == 1 ? sway.im : sway.re - sway.im;
        int64_t value = line * part->scale * (c + 1) / 4096 + second * part->second / 65536;
        value += driver.re * part->drive / (INT64_C(1) << 24) * (c == 0 ? 8 : 1);
        value += 30000 * (c - 5) + (int64_t)c * row * 20;
        value = c == 0 ? driver.re * part->drive / (INT64_C(1) << 21) : value;
        const bool hit = part->impulse != 0U && (row + 17 * c) % (int)part->impulse == 5;
        tick.value[c] = (int32_t)value + noise(part->noise * (1 + c % 4)) + (hit ? 400000 : 0);
    }
    tick.value[SWAY_CHANNEL_SPEED] = 25000 + part->slope * row;
}

static void run_part(const part_t *part)
{
    for (int row = 0; row < part->rows; row++, next_row++) {
        uint32_t sequence = sway_track_sequence(&track);
        make_row(part, row);
        sway_track_push(&track, &tick);
        tick.restart = false;
        bool more = true;
        while (more) {
            more = sway_track_run(&track);
            if (sway_track_sequence(&track) != sequence) {
                sequence = sway_track_sequence(&track);
                add_line(sway_track_line(&track));
                estimates++;
            }
        }
    }
}

void setUp(void)
{
    const sway_track_config_t config = sway_track_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
    memset(&tick, 0, sizeof tick);
    tick.present_mask = 0x1FFFFU;
    next_row = -300; // times below zero too
    seed = 11;
    sum = UINT64_C(14695981039346656037);
    estimates = 0;
    flags = 0;
    sway.re = 1 << 24;
    sway.im = 0;
    driver = sway;
}

void tearDown(void)
{
}

#define ALL 0xFFFFU
#define HZ_0_67 1072790529, 45188327
#define GROWING 1073863856, 45233537 /* 0.67 Hz, 0.1 1/s */
#define FALLING 1070647092, 45098040 /* 0.67 Hz, -0.2 1/s */
#define HZ_0_9 1072025501, 60686314

static const part_t parts[] = {
    {500, HZ_0_67, 0, 0, 0, 800, 0, ALL, 0, UINT64_C(0xB1BCC0CC42EDACCC)},  // nothing there
    {900, HZ_0_67, 16, 0, 0, 800, 0, ALL, 0, UINT64_C(0xAB708A20093BAB4C)}, // an onset, then a line
    {300, GROWING, 16, 0, 0, 800, 3, ALL, 0, UINT64_C(0x7C35360FEA65D05B)}, // it grows
    {300, FALLING, 16, 0, 0, 800, -20, ALL, 0,
     UINT64_C(0x98FAA978B315A1BF)}, // it decays, speed falls
    {500, HZ_0_67, 16, 0, 4000, 800, 0, ALL, 0, UINT64_C(0x7E42F99F3C99D37F)}, // with 2f
    {500, HZ_0_67, 16, 0, 0, 800, 0, ALL, 90, UINT64_C(0x45D75A1EB8B2D22B)},   // impulses
    {30, HZ_0_67, 16, 0, 0, 800, 0, 0xFFF0U, 0,
     UINT64_C(0xFC9AD2AE85704A3B)}, // a gap in four channels
    {400, HZ_0_67, 16, 0, 0, 800, 0, ALL, 0, UINT64_C(0x98FB38645F266DBE)}, //
    {300, HZ_0_67, 26, 0, 0, 800, 0, ALL, 0, UINT64_C(0xE19684AB219AA147)}, // a step
    {500, HZ_0_67, 26, 0, 0, 800, 0, 0xFF77U, 0,
     UINT64_C(0xE41685E10B55A856)}, // two channels silent
    {1200, HZ_0_67, 26, 30000, 0, 800, 0, ALL, 0,
     UINT64_C(0x8B461CEAA3612A9D)}, // the driver steers at 0.5 Hz
    {600, HZ_0_67, 16, 0, 0, 40000, 0, ALL, 0, UINT64_C(0x4A0FFE973CE4018E)}, // much noise
    {600, HZ_0_9, 16, 0, 0, 800, 0, ALL, 0, UINT64_C(0x989261782A1A864F)},    // another frequency
    {500, HZ_0_9, 0, 0, 0, 800, 0, ALL, 0, UINT64_C(0x9AC33E1BE3709460)},     // it is lost
};

static void test_all_bits_of_a_recording(void)
{
    bool equal = true;
    for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        run_part(&parts[i]);
        if (sum != parts[i].expected) {
            printf("part %u: 0x%016llX\n", i, (unsigned long long)sum);
            equal = false;
        }
    }
    TEST_ASSERT_TRUE(estimates > 300);
    TEST_ASSERT_EQUAL_HEX32(0x3FF, flags); // all of them
    TEST_ASSERT_TRUE_MESSAGE(equal, "the results have changed");
}

static void test_all_bits_of_a_drifting_line(void)
{
    /* frequency falls from 0.75 Hz by 0.006 Hz/s: the chirp becomes known */
    int64_t c = 1072549836;
    int64_t s = 50580166;
    for (int i = 0; i < 150; i++) {
        const part_t part = {10, c, s, 16, 0, 0, 60, 0, ALL, 0, 0};
        run_part(&part);
        c += 1793; // |c + js| stays 1 to about 1e-5
        s -= 40439;
    }
    TEST_ASSERT_TRUE(estimates > 50);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x13041C24F106AB1D), sum);
}

/* One estimate of what is in the ring, with a job's memory as `before` left it. */
static uint64_t bits_of_a_window(const sway_line_config_t *config, uint32_t window,
                                 sway_real_t omega_rad_s, int before)
{
    static sway_line_job_t job;
    static sway_line_t line;
    sum = UINT64_C(14695981039346656037);
    memset(&job, before, sizeof job);
    memset(&line, before, sizeof line);
    add((uint64_t)sway_line_start(&job, config, &track.ring, window, omega_rad_s, &line));
    do {
        add(sway_line_cost(&job)); // how the work is shared out is part of what is promised
    } while (sway_line_run(&job, &track.ring));
    add_line(&line);
    add(sway_line_harmonics(&job));
    estimates++;
    return sum;
}

/* Windows of every length, with every wish, of data with gaps, steps, blows and numbers at the end
 * of their range. What was in the job's memory before makes no difference. */
static void test_all_bits_of_single_windows(void)
{
    uint64_t all = 0;
    for (unsigned i = 0; i < 240U; i++) {
        const part_t part = {.rows = 40,
                             .turn_re = i % 7U < 4U ? 1072790529 : 1072025501,
                             .turn_im = i % 7U < 4U ? 45188327 : 60686314,
                             .scale = (int32_t)(i % 24U),
                             .drive = i % 11U == 3U ? 30000 : 0,
                             .second = i % 5U == 2U ? 4000 : 0,
                             .noise = i % 3U == 0U ? 800 : (int32_t)(i % 13U * 40U),
                             .slope = (int32_t)(i % 9U) - 4,
                             .valid = i % 17U == 5U   ? 0xFFF0U
                                      : i % 17U == 6U ? 0xFF77U
                                                      : 0xFFFFU,
                             .impulse = i % 19U == 0U ? 23U : 0U};
        const sway_line_config_t config = {
            .sample_period_us = i % 4U == 1U ? 20000 : 10000,
            .channel_mask = i % 6U == 1U ? 0x0FF6U : 0xFFFEU,
            .frequency_min_mhz = 300 + (int32_t)(i % 3U) * 100,
            .frequency_max_mhz = 1500 - (int32_t)(i % 5U) * 150,
            .steering_quiet_urad = 5000,
            .speed_change_milli = 100 - (int32_t)(i % 4U) * 20,
            .result_mask = 0xFFFFU,
            .harmonics_mask = i % 10U < 3U ? 0x3FF2U : 0U,
            .forced_rad_s = i % 12U == 3U ? sway_real_ratio(3142, 1000) : sway_real_zero(),
            .chirp_rad_s2 = i % 8U == 4U ? sway_real_ratio(20, 1000) : sway_real_zero(),
            .level = i % 14U == 7U};
        for (int row = 0; row < part.rows; row++, next_row++) {
            make_row(&part, row);
            if (i % 20U == 9U && row > 35) { // at the end of what a ring can hold, and beyond
                tick.value[1] = SWAY_SAMPLE_LIMIT - 1 + row % 3;
                tick.value[2] = 1 - SWAY_SAMPLE_LIMIT - row % 3;
            }
            sway_ring_push(&track.ring, &tick);
        }
        if (track.ring.filled < SWAY_WINDOW_MAX) {
            continue;
        }
        const uint32_t lengths = SWAY_WINDOW_MAX - SWAY_WINDOW_MIN + 1;
        const uint32_t window = SWAY_WINDOW_MIN + (i % 3U == 0U ? i % 40U : i * 97U % lengths);
        const sway_real_t omega = sway_real_ratio(3600 + (int32_t)(i % 16U) * 130, 1000);
        const uint64_t bits = bits_of_a_window(&config, window, omega, 0);
        TEST_ASSERT_EQUAL_HEX64(bits, bits_of_a_window(&config, window, omega, 0xA5));
        all = (all ^ bits) * UINT64_C(1099511628211);
    }
    TEST_ASSERT_TRUE(estimates > 300);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xDDFAF3CBDF1974C4), all);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_all_bits_of_a_recording);
    RUN_TEST(test_all_bits_of_a_drifting_line);
    RUN_TEST(test_all_bits_of_single_windows);
    return UNITY_END();
}

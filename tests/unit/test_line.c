/* Tests of sway_track, sway_line and what is under them, on signals of known frequency. */
#include <math.h>
#include <string.h>

#include "sway_track.h"
#include "unity.h"

static sway_track_t track;

void setUp(void)
{
    const sway_track_config_t config = sway_track_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config));
}

void tearDown(void)
{
}

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

typedef double (*signal_t)(double t_s, int channel);

/* Rows from..to of the signal, in micro-units, into channels 1..4. */
static void feed(signal_t signal, int from, int to)
{
    sway_tick_t tick;
    memset(&tick, 0, sizeof tick);
    tick.present_mask = 0x1EU;
    tick.valid_mask = 0x1EU;
    for (int i = from; i < to; i++) {
        tick.time_us = (int64_t)i * 10000;
        for (int c = 1; c <= 4; c++) {
            tick.value[c] = (int32_t)lround(1e6 * signal(i * 0.01, c));
        }
        sway_track_push(&track, &tick);
        for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
            (void)sway_track_run(&track);
        }
    }
}

static double damped(double t, int channel)
{
    return 0.3 * channel + 0.1 * channel * exp(-0.1 * t) * cos(2.0 * M_PI * 0.67 * t + channel);
}

static void test_noise_free_damped_line_in_four_channels(void)
{
    feed(damped, 0, 600);
    const sway_line_t *line = sway_track_line(&track);
    const double mid = (double)line->mid_time_us * 1e-6;
    TEST_ASSERT_EQUAL_HEX32(0, line->flags);
    TEST_ASSERT_EQUAL_HEX32(0x1E, line->valid_mask);
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 2.0 * M_PI * 0.67, to_double(line->omega_rad_s));
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, -0.1, to_double(line->growth_1_s));
    for (int c = 1; c <= 4; c++) {
        const sway_line_channel_t *part = &line->channel[c];
        const double re = to_double(part->amplitude.re);
        const double im = to_double(part->amplitude.im);
        const double phase = remainder(2.0 * M_PI * 0.67 * mid + c - atan2(im, re), 2.0 * M_PI);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * c, 0.1 * c * exp(-0.1 * mid), hypot(re, im));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, phase);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.3 * c, to_double(part->mean));
    }
}

static double still(double t, int channel)
{
    (void)t;
    return 0.01 * channel;
}

static void test_no_motion_is_no_oscillation(void)
{
    feed(still, 0, 600);
    const sway_line_t *line = sway_track_line(&track);
    TEST_ASSERT_TRUE(sway_track_sequence(&track) > 10U);
    TEST_ASSERT_TRUE((line->flags & SWAY_LINE_NO_OSCILLATION) != 0U);
    TEST_ASSERT_TRUE((line->flags & SWAY_LINE_SEEKING) != 0U);
}

static void test_bad_configuration_is_refused(void)
{
    sway_track_config_t config = sway_track_default(10000);
    config.window_cycles_milli = 1000;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(&track, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_track_init(NULL, &config));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_noise_free_damped_line_in_four_channels);
    RUN_TEST(test_no_motion_is_no_oscillation);
    RUN_TEST(test_bad_configuration_is_refused);
    return UNITY_END();
}

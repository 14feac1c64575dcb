/* The track where a line is lost: where the sliding spectrum sees it, and when the next estimate
 * begins. */
#include <math.h>
#include <string.h>

#include "signal/sway_track.h"
#include "sway_test.h"
#include "unity.h"

/* As in sway_track.c. */
enum { TRACK_IDLE, TRACK_SEARCH, TRACK_LINE, TRACK_TONE_SEARCH, TRACK_TONE, TRACK_HELD };

/* Rows of the sliding window; bin k is at k / 2 Hz. */
enum { WINDOW = 200 };

static sway_track_t track;
static sway_track_work_t work;

void setUp(void)
{
    const sway_track_config_t config = sway_track_default(10000);
    memset(&work, 0, sizeof work);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_track_init(&track, &config, &work));
}

void tearDown(void)
{
}

/* A held line that is lost for one estimate; all sums of the spectrum are there, over a tone of so
 * many turns in the window. */
static void lose(double turns)
{
    setUp();
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_spectrum_init(&track.spectrum, WINDOW));
    for (int k = 0; k < 2 * WINDOW; k++) {
        sway_row_t row;
        memset(&row, 0, sizeof row);
        row.time_us = 10000 * (int64_t)k;
        row.valid_mask = row.present_mask = SWAY_CHANNEL_BIT(1);
        row.value[1] = (int32_t)lround(1e5 * cos(2 * M_PI * turns * k / WINDOW));
        sway_track_push(&track, &row);
    }
    while (sway_spectrum_run(&track.spectrum, &track.ring)) {
    }
    TEST_ASSERT_TRUE(sway_spectrum_ready(&track.spectrum));
    track.spectrum_first = false;
    track.pilot = SWAY_CHANNEL_CAR_YAW_RATE;
    track.locked = true;
    track.lost = 1;
    track.omega_rad_s = real(2 * M_PI);
    track.state = TRACK_HELD;
}

/* Leaves large numbers where a function called next has its variables: what reads one that it has
 * not written decides by these. */
static int32_t leave_large_numbers(void)
{
    volatile sway_real_t left[256];
    for (int i = 0; i < 256; i++) {
        left[i].m = INT32_C(1) << 30;
        left[i].e = 1000;
    }
    return left[255].m;
}

/* The next estimate begins at the largest bin of those that have one on either side, moved by what
 * these say: of a whole number of turns not at all, but for one turn, of which only the upper one
 * counts: half as large, by 4 r / (3 + sqrt(9 + 4 r^2)) for r = 1/2. */
static void a_lost_line_is_looked_for_where_the_spectrum_sees_it(void)
{
    for (int turns = 1; turns <= (int)SWAY_BINS - 2; turns++) {
        lose(turns);
        TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 30, leave_large_numbers());
        TEST_ASSERT_TRUE(sway_track_run(&track));
        TEST_ASSERT_EQUAL_INT(TRACK_LINE, track.state);
        const double bin = turns == 1 ? 1 + 2 / (3 + sqrt(10)) : turns;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2 * M_PI * bin / 2, value(track.line.omega_rad_s));
    }
    lose(2.25);
    TEST_ASSERT_TRUE(sway_track_run(&track));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 2 * M_PI * 2.25 / 2, value(track.line.omega_rad_s));
}

/* The last bin has no neighbour above: what is seen there is looked for beside it, as far up as an
 * offset goes. */
static void the_last_bin_is_no_place_of_a_line(void)
{
    lose((int)SWAY_BINS - 1);
    TEST_ASSERT_TRUE(sway_track_run(&track));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2 * M_PI * (SWAY_BINS - 2 + 0.6) / 2,
                              value(track.line.omega_rad_s));
}

/* Where a hop of rows came in while the estimate was made, the next one is due at once; else there
 * is nothing to do until it is. */
static void an_estimate_that_is_due_is_more_to_do(void)
{
    for (uint32_t rows_to_hop = 0; rows_to_hop < 2U; rows_to_hop++) {
        setUp();
        track.locked = true;
        track.state = TRACK_LINE; // its job has ended
        track.line.flags = SWAY_LINE_NO_OSCILLATION;
        track.rows_to_hop = rows_to_hop;
        TEST_ASSERT_EQUAL(rows_to_hop == 0U, sway_track_run(&track));
        TEST_ASSERT_EQUAL_INT(TRACK_IDLE, track.state);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_lost_line_is_looked_for_where_the_spectrum_sees_it);
    RUN_TEST(the_last_bin_is_no_place_of_a_line);
    RUN_TEST(an_estimate_that_is_due_is_more_to_do);
    return UNITY_END();
}

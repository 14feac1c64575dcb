/* What ties the parts of the core together: beginning, time, slices, what is left out and reported.
 */
#include <stdlib.h>

#include "core/sway_publish.h"
#include "core_feed.h"
#include "unity.h"

#define BIT(channel) SWAY_CHANNEL_BIT(SWAY_CHANNEL_##channel)
#define ALL UINT32_MAX
#define YAW (BIT(TRAILER_YAW_RATE) | BIT(CAR_YAW_RATE))
#define SECOND_US INT64_C(1000000)

static sway_core_t core;
static sway_core_t other;
static sway_core_config_t config;
static test_plant_t plant;
static sway_line_t line;

/* A free swing of the reference combination at 100 km/h; the wheel is held. */
void setUp(void)
{
    sway_core_defaults(&config);
    config.vehicle = reference_vehicle();
    plant = reference_plant(100);
    plant_line(&plant, &config.vehicle, &line);
    line.channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude = complex_of(0);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
}

void tearDown(void)
{
}

static int32_t sample(unsigned signal, int64_t time_us)
{
    const sway_line_channel_t *const channel = &line.channel[SIGNALS[signal].channel];
    const double complex turned = cvalue(channel->amplitude) * cexp(plant.s * (time_us * 1e-6));
    return (int32_t)lround(creal(turned) * SIGNALS[signal].scale);
}

/* One sample of each input of the channels in `mask`, of what is at `time_us`. */
static void put(sway_core_t *c, int64_t time_us, uint32_t mask)
{
    if ((mask & BIT(SPEED)) != 0U) {
        (void)sway_core_input(c, SWAY_INPUT_SPEED, time_us, (int32_t)lround(plant.v * 1e3));
    }
    for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
        if ((mask & SWAY_CHANNEL_BIT(SIGNALS[i].channel)) != 0U) {
            (void)sway_core_input(c, SIGNALS[i].input, time_us, sample(i, time_us));
        }
    }
}

/* From `from_s` until before `to_s`, 100 times a second. */
static void drive(sway_core_t *c, double from_s, double to_s, uint32_t mask)
{
    for (int64_t t = llround(from_s * 100); t < llround(to_s * 100); t++) {
        put(c, 10000 * t, mask);
        drain(c);
    }
}

/* As drive(), until one more estimate is out; its status. Fails after 2 s. */
static const sway_status_t *next_estimate(double *at_s, uint32_t mask)
{
    const uint32_t before = sway_core_status(&core)->sequence;
    for (int k = 0; k < 200 && sway_core_status(&core)->sequence == before; k++) {
        drive(&core, *at_s, *at_s + 0.01, mask);
        *at_s += 0.01;
    }
    TEST_ASSERT_EQUAL_UINT32(before + 1U, sway_core_status(&core)->sequence);
    return sway_core_status(&core);
}

/* --- beginning ---------------------------------------------------------------------------------
 */

static void the_defaults_are_those_that_are_documented(void)
{
    sway_core_config_t expected;
    memset(&expected, 0, sizeof expected);
    expected.sample_period_us = 10000;
    expected.window_cycles_milli = 1700;
    expected.input_period_us = 10000;
    sway_alarm_defaults(&expected.alarm);
    memset(&config, 0xA5, sizeof config);
    sway_core_defaults(&config);
    TEST_ASSERT_EQUAL_MEMORY(&expected, &config, sizeof config);
}

static void before_the_first_estimate_nothing_is_said(void)
{
    sway_status_t expected;
    memset(&expected, 0, sizeof expected);
    expected.time_to_limit_ms = -1;
    memset(&core, 0xA5, sizeof core);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    TEST_ASSERT_EQUAL_MEMORY(&expected, sway_core_status(&core), sizeof expected);
    TEST_ASSERT_FALSE(sway_core_run(&core));
    drive(&core, 0, 0.1, YAW);
    TEST_ASSERT_EQUAL_MEMORY(&expected, sway_core_status(&core), sizeof expected);
}

static void a_core_that_is_used_again_is_new(void)
{
    memset(&other, 0, sizeof other);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&other, &config));
    drive(&core, 0, 4, ALL);
    sway_core_invalid(&core, SWAY_INPUT_HITCH_FX, 4 * SECOND_US);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    drive(&core, 0, 4, ALL);
    drive(&other, 0, 4, ALL);
    TEST_ASSERT_TRUE(sway_core_status(&other)->sequence > 10);
    TEST_ASSERT_EQUAL_MEMORY(sway_core_status(&other), sway_core_status(&core),
                             sizeof(sway_status_t));
}

/* 1.5, 1.7 and 2.5 oscillations of 1.496 s, in blocks of rows. */
static void a_window_is_as_long_as_its_oscillations(void)
{
    static const int32_t period_us[] = {5000, 10000, 20000, 12500};
    static const int32_t cycles_milli[] = {1500, 1700, 2500, 2500};
    for (int i = 0; i < 4; i++) {
        config.sample_period_us = period_us[i];
        config.window_cycles_milli = cycles_milli[i];
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
        drive(&core, 0, 6, YAW | BIT(SPEED));
        const double window_ms = cycles_milli[i] * 2 * M_PI / cimag(plant.s);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, sway_core_status(&core)->valid);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * window_ms, window_ms, sway_core_status(&core)->window_ms);
        TEST_ASSERT_EQUAL_INT32(sway_track_line(&core.track)->window_samples * period_us[i] / 1000,
                                sway_core_status(&core)->window_ms);
    }
}

/* Stamps that are too late by what is known of them are as good as right ones. */
static void a_known_delay_is_taken_out_of_each_input(void)
{
    static const int64_t late_us[] = {30000,  -20000, 0, 50000, 10000, 0,
                                      -40000, 20000,  0, 30000, 0};
    for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
        config.input_delay_us[SIGNALS[i].input] = (int32_t)late_us[i];
    }
    config.input_delay_us[SWAY_INPUT_SPEED] = -30000;
    line.channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude = complex_of(0.05);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&other, &config));
    for (int64_t t = SECOND_US; t < 6 * SECOND_US; t += 10000) {
        const int32_t mm_s = (int32_t)lround(plant.v * 1e3);
        (void)sway_core_input(&core, SWAY_INPUT_SPEED, t, mm_s);
        (void)sway_core_input(&other, SWAY_INPUT_SPEED, t - 30000, mm_s);
        drain(&core);
        drain(&other);
        for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
            (void)sway_core_input(&core, SIGNALS[i].input, t, sample(i, t));
            (void)sway_core_input(&other, SIGNALS[i].input, t + late_us[i], sample(i, t));
            drain(&core);
            drain(&other);
        }
    }
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE | SWAY_VALID_SPEED | SWAY_VALID_CAR_REAR,
                          sway_core_status(&core)->valid);
    TEST_ASSERT_EQUAL_MEMORY(sway_core_status(&core), sway_core_status(&other),
                             sizeof(sway_status_t));
}

/* --- time --------------------------------------------------------------------------------------
 */

/* Ten rows, and no longer than that. */
static void a_late_input_is_waited_for(void)
{
    for (int32_t period_us = 5000; period_us <= 10000; period_us += 5000) {
        int64_t longest_us = 0;
        config.sample_period_us = period_us;
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
        drive(&core, 0, 1, YAW);
        for (int64_t t = SECOND_US; t < SECOND_US + SECOND_US / 4; t += 10000) {
            put(&core, t, BIT(CAR_YAW_RATE));
            drain(&core);
            longest_us = t - core.time_us > longest_us ? t - core.time_us : longest_us;
        }
        TEST_ASSERT_EQUAL_INT64(10 * period_us, longest_us);
    }
}

static void without_a_speed_none_is_known_from_the_first_estimate_on(void)
{
    double at_s = 0;
    const sway_status_t *status = next_estimate(&at_s, YAW);
    TEST_ASSERT_TRUE(status->time_us < SECOND_US);
    while (at_s < 4) {
        TEST_ASSERT_BITS_LOW(SWAY_VALID_SPEED, status->valid);
        TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_NO_SPEED, status->quality);
        status = next_estimate(&at_s, YAW);
    }
}

/* Half a second is no gap in a speed yet, and what rows had last counts for one more. */
static void a_speed_is_known_for_a_second_after_the_last_row_with_one(void)
{
    double at_s = 3;
    int known = 0, unknown = 0;
    drive(&core, 0, 3, ALL);
    while (at_s < 6) {
        const sway_status_t *const status = next_estimate(&at_s, ~BIT(SPEED));
        const bool recent = status->time_us <= 3 * SECOND_US - 10000 + 3 * SECOND_US / 2;
        TEST_ASSERT_EQUAL(recent, (status->valid & SWAY_VALID_SPEED) != 0U);
        TEST_ASSERT_TRUE(recent || (status->quality & SWAY_QUALITY_NO_SPEED) != 0U);
        TEST_ASSERT_EQUAL_INT32(27778, status->speed_mm_s);
        known += recent ? 1 : 0;
        unknown += recent ? 0 : 1;
    }
    TEST_ASSERT_TRUE(known > 3 && unknown > 3);
}

/* Of what was known before the clock began again there is no speed, and no estimate. */
static void expect_nothing_old_after(double again_s)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    uint8_t idle = core.stage;
    double at_s = 100;
    drive(&core, 90, 100, ALL);
    for (int k = 0; k < 100 && core.stage == idle; k++) { // until an estimate is on its way
        drive(&core, at_s, at_s + 0.01, ALL);
        at_s += 0.01;
    }
    TEST_ASSERT_TRUE(core.stage != idle);
    const uint32_t sequence = sway_core_status(&core)->sequence;
    const int64_t before_us = core.time_us;
    at_s = again_s;
    while (llabs(core.time_us - before_us) < SECOND_US && at_s < again_s + 1) {
        drive(&core, at_s, at_s + 0.01, ~BIT(SPEED));
        at_s += 0.01;
    }
    TEST_ASSERT_TRUE(llabs(core.time_us - before_us) > SECOND_US);
    drive(&core, at_s, at_s + 0.1, ~BIT(SPEED));
    at_s += 0.1;
    TEST_ASSERT_EQUAL_UINT32(sequence, sway_core_status(&core)->sequence);
    for (const double until_s = at_s + 3; at_s < until_s;) {
        const sway_status_t *const status = next_estimate(&at_s, ~BIT(SPEED));
        TEST_ASSERT_BITS_LOW(SWAY_VALID_SPEED | SWAY_VALID_MODEL, status->valid);
        TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_NO_SPEED, status->quality);
    }
}

static void a_clock_that_starts_again_has_no_speed_and_no_estimate_yet(void)
{
    expect_nothing_old_after(10);
    expect_nothing_old_after(4000);
}

/* A sender that says "not valid" is heard: it is counted, and its time goes on. */
static void an_input_that_is_not_valid_lets_time_go_on(void)
{
    drive(&core, 0, 0.5, YAW);
    const int64_t before_us = core.time_us;
    for (int64_t t = 500000; t < 600000; t += 10000) {
        const uint32_t count = sway_core_status(&core)->fault_count[SWAY_FAULT_INVALID];
        sway_core_invalid(&core, SWAY_INPUT_CAR_YAW_RATE, t);
        TEST_ASSERT_EQUAL_UINT32(count + 1U,
                                 sway_core_status(&core)->fault_count[SWAY_FAULT_INVALID]);
        sway_core_invalid(&core, SWAY_INPUT_TRAILER_YAW_RATE, t);
        drain(&core);
    }
    TEST_ASSERT_EQUAL_INT64(before_us + 100000, core.time_us);
}

/* Samples of one time are taken together; before a newer one comes what they made ready is done. */
static void what_is_due_is_done_before_a_newer_sample(void)
{
    int64_t t = 500000;
    drive(&core, 0, 0.5, YAW);
    for (; t < 600000; t += 10000) {
        const int64_t done_us = core.time_us;
        put(&core, t, YAW); // this makes a row ready
        put(&core, t, BIT(HITCH_FX));
        TEST_ASSERT_EQUAL_INT64(done_us, core.time_us);
        if (t == 550000) {
            sway_core_invalid(&core, SWAY_INPUT_SPEED, t + 1);
        } else {
            put(&core, t + 1, BIT(SPEED));
        }
        TEST_ASSERT_EQUAL_INT64(done_us + 10000, core.time_us);
    }
}

static void a_refused_sample_is_counted_at_once(void)
{
    const uint32_t *const fault = sway_core_status(&core)->fault_count;
    drive(&core, 0, 0.5, YAW);
    for (uint32_t i = 1; i <= 3; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                              sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, 500000, INT32_MAX));
        TEST_ASSERT_EQUAL_UINT32(i, fault[SWAY_FAULT_RANGE]);
        TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                              sway_core_input(&core, SWAY_INPUT_TRAILER_YAW_RATE, 100000, 0));
        TEST_ASSERT_EQUAL_UINT32(i, fault[SWAY_FAULT_TIME]);
    }
}

/* --- slices ------------------------------------------------------------------------------------
 */

/* Where several rows are ready at once, they are all worked on before it says that nothing is due.
 */
static void false_means_that_nothing_is_due(void)
{
    config.input_period_us = 0;
    config.sample_period_us = 5000;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    for (int64_t t = 0; t < 30 * SECOND_US; t += 40000) {
        put(&core, t, ALL);
        if (t > 0) {
            TEST_ASSERT_TRUE(sway_core_run(&core)); // a row is ready
        }
        drain(&core);
        TEST_ASSERT_TRUE(core.time_us > t - 10000);
        const int64_t done_us = core.time_us;
        TEST_ASSERT_FALSE(sway_core_run(&core));
        drain(&core);
        TEST_ASSERT_EQUAL_INT64(done_us, core.time_us);
    }
    TEST_ASSERT_TRUE(core.supervise.rounds > 0U);
}

/* Nobody sees half of an estimate: between two, only fault counters move. Without one of these
 * inputs estimates often end in the last slice of a row. */
static void a_status_changes_as_a_whole(void)
{
    static const uint32_t without[] = {0, BIT(CAR_YAW_RATE), BIT(CAR_LATERAL_ACC)};
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
        sway_status_t last = *sway_core_status(&core);
        for (int64_t t = 0; t < 8 * SECOND_US; t += 10000) {
            put(&core, t, ALL & ~without[i]);
            drain(&core);
            const sway_status_t now = *sway_core_status(&core);
            if (now.sequence == last.sequence) {
                memcpy(last.fault_count, now.fault_count, sizeof last.fault_count);
                TEST_ASSERT_EQUAL_MEMORY(&last, &now, sizeof now);
            }
            last = now;
        }
        TEST_ASSERT_TRUE(last.sequence > 20);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_REAR, last.valid);
    }
}

/* A row makes so many slices due and one for the supervision, which has it last; a row without work
 * is done with one. */
static void a_row_has_its_slices_and_the_supervision_one_more(void)
{
    static sway_supervise_t before;
    int most = 0;
    for (int64_t t = 0; t < 30 * SECOND_US; t += 10000) {
        put(&core, t, ALL);
        int slices = 0, supervised = 0, last_supervised = 0;
        bool busy = false;
        while (sway_core_run(&core)) {
            slices++;
            if (slices > 1 && memcmp(&before, &core.supervise, sizeof before) != 0) {
                supervised++;
                last_supervised = slices;
            }
            busy = slices == 1 ? core.supervise.stage != 0U : busy; // with the row's sums
            before = core.supervise;
        }
        TEST_ASSERT_EQUAL_INT(t > 0 && busy ? 1 : 0, supervised);
        TEST_ASSERT_TRUE(supervised == 0 || last_supervised == slices);
        TEST_ASSERT_TRUE(t >= 100000 || slices <= 1 + supervised);
        most = slices - supervised > most ? slices - supervised : most;
    }
    TEST_ASSERT_EQUAL_INT(SWAY_SLICES_PER_ROW, most);
    TEST_ASSERT_TRUE(core.supervise.rounds > 0U);
}

/* A search takes slices of full cost: none is in the slice that takes the row, and one in each
 * after it. */
static void no_slice_is_longer_than_it_may_be(void)
{
    static sway_core_work_t before;
    int rows = 0;
    for (int64_t t = 0; t < SECOND_US; t += 10000) {
        put(&core, t, ALL);
        const bool searches = sway_track_cost(&core.track) == SWAY_SLICE_COST;
        before = core.work;
        if (sway_core_run(&core) && searches) {
            TEST_ASSERT_EQUAL_MEMORY(&before, &core.work, sizeof before);
            TEST_ASSERT_TRUE(sway_core_run(&core));
            TEST_ASSERT_TRUE(memcmp(&before, &core.work, sizeof before) != 0);
            rows++;
        }
        drain(&core);
    }
    TEST_ASSERT_TRUE(rows > 3);
}

/* Reporting an estimate takes two thirds of a slice and each of its five parts a quarter: there is
 * room for one part beside it. */
static void an_estimate_is_reported_in_a_slice_that_has_room_for_it(void)
{
    int reported = 0;
    for (int64_t t = 0; t < 5 * SECOND_US; t += 10000) {
        bool more = true;
        put(&core, t, ALL);
        while (more) {
            const uint32_t sequence = sway_core_status(&core)->sequence;
            const uint32_t part = core.part;
            more = sway_core_run(&core);
            if (core.identified && sway_core_status(&core)->sequence != sequence) {
                TEST_ASSERT_TRUE(part + 1U >= SWAY_PUBLISH_PARTS);
                reported++;
            }
        }
    }
    TEST_ASSERT_TRUE(reported > 10);
}

/* --- what is missing, wrong, suspect -----------------------------------------------------------
 */

static void what_has_come_and_is_gone_is_missing_until_it_is_back(void)
{
    const uint32_t fx = BIT(HITCH_FX);
    double at_s = 5;
    drive(&core, 0, 5, ALL & ~fx);
    TEST_ASSERT_EQUAL_HEX32(0, sway_core_status(&core)->missing_inputs); // it has never come
    drive(&core, 5, 10, ALL);
    TEST_ASSERT_EQUAL_HEX32(0, sway_core_status(&core)->missing_inputs);
    drive(&core, 10, 11, ALL & ~fx);
    TEST_ASSERT_EQUAL_HEX32(fx, sway_core_status(&core)->missing_inputs);
    drive(&core, 11, 16, ALL);
    TEST_ASSERT_EQUAL_HEX32(0, sway_core_status(&core)->missing_inputs);
    at_s = 16;
    drive(&core, at_s, at_s + 0.1, ALL & ~BIT(SPEED)); // a speed that is gone for long, once
    drive(&core, at_s + 0.1, at_s + 1, ALL);
    TEST_ASSERT_EQUAL_HEX32(0, sway_core_status(&core)->missing_inputs);
}

/* What an estimate adds to the counters is in its own status. */
static void a_fault_of_an_estimate_is_counted_with_it(void)
{
    double at_s = 0;
    uint32_t expected = 0;
    plant.stiffness[0] = 6e6; // no tyre has that
    plant_line(&plant, &config.vehicle, &line);
    while (at_s < 6) {
        const sway_status_t *const status = next_estimate(&at_s, ALL);
        expected += (status->quality & SWAY_QUALITY_SINGULAR) != 0U ? 1U : 0U;
        TEST_ASSERT_EQUAL_UINT32(expected, status->fault_count[SWAY_FAULT_SINGULAR]);
    }
    TEST_ASSERT_TRUE(expected > 5);
    TEST_ASSERT_EQUAL_UINT32(0, sway_core_status(&core)->fault_count[SWAY_FAULT_OVERRUN]);
    core.sequence -= 2U;
    drive(&core, at_s, at_s + 0.5, ALL);
    TEST_ASSERT_EQUAL_UINT32(1, sway_core_status(&core)->fault_count[SWAY_FAULT_OVERRUN]);
}

static void a_rejected_sensor_is_left_out_and_is_not_missing(void)
{
    drive(&core, 0, 6, YAW | BIT(SPEED));
    const double trailer = sway_core_status(&core)->amplitude_urad_s;
    drive(&core, 6, 6.01, YAW | BIT(SPEED));
    core.supervise.rejected_mask = BIT(TRAILER_YAW_RATE);
    drive(&core, 6.01, 9.5, YAW | BIT(SPEED)); // until it has left the window
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_EQUAL_HEX32(BIT(TRAILER_YAW_RATE), status->rejected_inputs);
    TEST_ASSERT_EQUAL_HEX32(0, status->missing_inputs);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, status->valid);
    TEST_ASSERT_EQUAL_HEX32(BIT(CAR_YAW_RATE), sway_track_line(&core.track)->valid_mask);
    TEST_ASSERT_TRUE(trailer > 0 && status->amplitude_urad_s > 0); // by the car's yaw rate
}

/* The estimate is without it, the relations are not while its size is measured. */
static void a_sensor_that_is_measured_is_in_the_relations_alone(void)
{
    drive(&core, 0, 1, YAW | BIT(SPEED));
    core.supervise.rejected_mask = BIT(TRAILER_YAW_RATE);
    core.supervise.measured = 3;
    core.supervise.measuring = 200;
    core.supervise.sums.rows = 0;
    drive(&core, 1, 9, YAW | BIT(SPEED)); // until it has left the window of the estimate
    TEST_ASSERT_BITS_HIGH(BIT(TRAILER_YAW_RATE), core.supervise.sums.known);
    TEST_ASSERT_EQUAL_HEX32(BIT(CAR_YAW_RATE), sway_track_line(&core.track)->valid_mask);
    core.supervise.measuring = 0;
    core.supervise.sums.rows = 0;
    drive(&core, 9, 10, YAW | BIT(SPEED));
    TEST_ASSERT_BITS_LOW(BIT(TRAILER_YAW_RATE), core.supervise.sums.known);
    TEST_ASSERT_BITS_HIGH(BIT(CAR_YAW_RATE), core.supervise.sums.known);
}

static void what_the_supervision_says_is_reported(void)
{
    double at_s = 1;
    drive(&core, 0, at_s, YAW);
    core.supervise.suspect_mask = BIT(CAR_YAW_RATE) | BIT(HITCH_FY);
    core.supervise.offset_mask = BIT(HITCH_FY) | BIT(TRAILER_YAW_RATE);
    core.supervise.finding.code = SWAY_FINDING_FRICTION;
    core.supervise.finding.size_micro = 12345;
    core.supervise.finding.se_micro = 678;
    const sway_status_t *const status = next_estimate(&at_s, YAW);
    TEST_ASSERT_EQUAL_HEX32(YAW | BIT(HITCH_FY), status->suspect_inputs);
    TEST_ASSERT_EQUAL_HEX32(0, status->rejected_inputs);
    TEST_ASSERT_EQUAL_INT32(SWAY_FINDING_FRICTION, status->finding);
    TEST_ASSERT_EQUAL_INT32(12345, status->finding_size_micro);
    TEST_ASSERT_EQUAL_INT32(678, status->finding_se_micro);
}

/* Another one each time, so that all are reported in ten estimates; each with its own numbers. */
static void one_relation_after_the_other_is_reported(void)
{
    double at_s = 0;
    uint32_t reported = 0;
    for (int i = 0; i < 2 * (int)SWAY_RELATION_COUNT; i++) {
        for (int r = 0; r < (int)SWAY_RELATION_COUNT; r++) {
            core.supervise.held[r].state =
                (uint8_t)(r % 2 == 0 ? SWAY_RELATION_BREAKS : SWAY_RELATION_HOLDS);
            core.supervise.held[r].size = real(4);
            core.supervise.held[r].residual = real(4e-6 * r * r);
            core.supervise.held[r].allowed = real(1e-6);
        }
        const sway_status_t *const status = next_estimate(&at_s, YAW);
        const int32_t relation = status->relation % 256;
        const bool breaks = relation % 2 == 0;
        TEST_ASSERT_INT_WITHIN(SWAY_RELATION_COUNT / 2, SWAY_RELATION_COUNT / 2, relation);
        TEST_ASSERT_EQUAL_INT(breaks ? SWAY_RELATION_BREAKS : SWAY_RELATION_HOLDS,
                              status->relation / 256);
        TEST_ASSERT_INT_WITHIN(1, 1000 * relation, status->relation_ppm);
        TEST_ASSERT_INT_WITHIN(1, 500, status->relation_se_ppm);
        TEST_ASSERT_BITS_LOW(i < (int)SWAY_RELATION_COUNT ? 1U << relation : 0U, reported);
        reported |= 1U << relation;
    }
    TEST_ASSERT_EQUAL_HEX32((1U << SWAY_RELATION_COUNT) - 1U, reported);
}

/* Straight on for a minute, and the car's accelerometer shows 2 m/s2. */
static void an_offset_is_found_on_the_way(void)
{
    for (int64_t t = 0; t < 60 * SECOND_US; t += 10000) {
        (void)sway_core_input(&core, SWAY_INPUT_SPEED, t, 25000);
        for (unsigned i = 0; i < 5; i++) {
            const int32_t off = SIGNALS[i].input == SWAY_INPUT_CAR_LATERAL_ACC ? 2000000 : 0;
            (void)sway_core_input(&core, SIGNALS[i].input, t, off);
        }
        drain(&core);
    }
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_EQUAL_INT32(SWAY_FINDING_OFFSET + (int32_t)SWAY_CHANNEL_CAR_LATERAL_ACC,
                            status->finding);
    TEST_ASSERT_INT_WITHIN(600000, 2000000, status->finding_size_micro);
    TEST_ASSERT_EQUAL_HEX32(BIT(CAR_LATERAL_ACC), status->suspect_inputs);
    TEST_ASSERT_EQUAL_HEX32(0, status->rejected_inputs);
}

/* --- whose model it is -------------------------------------------------------------------------
 */

/* Least damped root of the reference combination at this speed, as a damping ratio in 1e-6; its
 * tyres lag by this length, for which Newton goes on from the root without. */
static int32_t late_damping_at(double v, double relaxation_m)
{
    sway_single_track_t stm;
    sway_single_track_roots_t roots;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&stm, &config.vehicle));
    const sway_single_track_quartic_t quartic = sway_single_track_quartic(&stm, real(v));
    sway_single_track_roots_start(&roots, &quartic);
    for (int i = 0; i < 100; i++) {
        (void)sway_single_track_roots_sweep(&roots, &quartic);
    }
    sway_complex_t s = sway_single_track_dominant(&roots);
    for (int i = 0; i < 4; i++) {
        stm.body[i / 2].relaxation_m[i % 2] = real(relaxation_m);
    }
    for (int i = 0; i < 20; i++) {
        sway_complex_t slope;
        (void)sway_single_track_slope_s(&stm, s, real(v), 0, &slope);
        (void)sway_single_track_slope_s(&stm, s, real(v), 1, &slope);
        const sway_complex_t f = sway_single_track_characteristic(&stm, s, real(v));
        s = sway_complex_sub(s, sway_complex_div(f, slope));
    }
    return (int32_t)lround(1e6 * value(sway_single_track_damping_ratio(s)));
}

static int32_t damping_at(double v)
{
    return late_damping_at(v, 0.0);
}

/* Nothing is identified from yaw rates: the model is the user's, as exact as it is given. */
static void a_model_is_that_of_the_speed_that_is_driven(void)
{
    plant.v = 20;
    drive(&core, 0, 5, YAW | BIT(SPEED));
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_MODEL, sway_core_status(&core)->valid);
    TEST_ASSERT_INT_WITHIN(10, damping_at(20), sway_core_status(&core)->model_damping_ratio_ppm);
    plant.v = 30;
    drive(&core, 5, 7, YAW | BIT(SPEED));
    TEST_ASSERT_INT_WITHIN(10, damping_at(30), sway_core_status(&core)->model_damping_ratio_ppm);
    TEST_ASSERT_TRUE(damping_at(20) > damping_at(20.02) + 50);
}

/* With the car's own sensors the model is the observer's, at the speed that is driven; from the
 * moment a sensor of the trailer is heard it is that of what is identified. */
static void a_model_is_the_observers_until_the_trailer_is_heard(void)
{
    const uint32_t own = BIT(STEERING_WHEEL_ANGLE) | BIT(CAR_YAW_RATE) | BIT(CAR_LATERAL_ACC);
    const sway_status_t *const status = sway_core_status(&core);
    drive(&core, 0, 6, own | BIT(SPEED));
    const double lag_m = value(core.watch.with.x[SWAY_STATE_RELAXATION]); // as the observer has it
    TEST_ASSERT_TRUE(core.watched);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_MODEL, status->valid);
    TEST_ASSERT_INT_WITHIN(20000, late_damping_at(plant.v, lag_m), status->model_damping_ratio_ppm);
    plant.v = 20;
    drive(&core, 6, 8, own | BIT(SPEED));
    TEST_ASSERT_INT_WITHIN(20000, late_damping_at(20, lag_m), status->model_damping_ratio_ppm);
    TEST_ASSERT_TRUE(damping_at(20) > damping_at(100 / 3.6) + 50000);
    plant.v = 25;
    drive(&core, 8, 11, own | BIT(SPEED) | BIT(TRAILER_YAW_RATE));
    TEST_ASSERT_FALSE(core.watched);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_MODEL | SWAY_VALID_CRITICAL_SPEED, status->valid);
    TEST_ASSERT_INT_WITHIN(1, lround(1e6 * value(core.margin.model.damping_ratio)),
                           status->model_damping_ratio_ppm);
    TEST_ASSERT_INT_WITHIN(1, lround(1e3 * value(core.margin.model.v_crit_m_s)),
                           status->v_crit_mm_s);
    TEST_ASSERT_TRUE(fabs(value(core.watch.model.damping_ratio) -
                          value(core.margin.model.damping_ratio)) > 1e-4);
}

/* 30 km/h are 8333.3 mm/s. A parked car has no damping, whether its trailer is heard or not. */
static void below_30_km_h_there_is_no_model(void)
{
    const uint32_t masks[] = {BIT(STEERING_WHEEL_ANGLE) | BIT(CAR_YAW_RATE) | BIT(CAR_LATERAL_ACC) |
                                  BIT(SPEED),
                              YAW | BIT(SPEED)};
    const sway_status_t *const status = sway_core_status(&core);
    for (unsigned i = 0; i < 2; i++) {
        setUp();
        drive(&core, 0, 6, masks[i]);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_MODEL | SWAY_VALID_MARGIN, status->valid);
        double at_s = 6;
        const double slow[] = {8.333, 2, 0.1, 0};
        for (unsigned k = 0; k < 4; k++) {
            plant.v = slow[k];
            drive(&core, at_s, at_s + 3, masks[i]);
            at_s += 3;
            TEST_ASSERT_BITS_LOW(SWAY_VALID_MODEL | SWAY_VALID_CRITICAL_SPEED, status->valid);
        }
        plant.v = 8.334;
        drive(&core, at_s, at_s + 3, masks[i]);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_MODEL, status->valid);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_defaults_are_those_that_are_documented);
    RUN_TEST(before_the_first_estimate_nothing_is_said);
    RUN_TEST(a_core_that_is_used_again_is_new);
    RUN_TEST(a_window_is_as_long_as_its_oscillations);
    RUN_TEST(a_known_delay_is_taken_out_of_each_input);
    RUN_TEST(a_late_input_is_waited_for);
    RUN_TEST(without_a_speed_none_is_known_from_the_first_estimate_on);
    RUN_TEST(a_speed_is_known_for_a_second_after_the_last_row_with_one);
    RUN_TEST(a_clock_that_starts_again_has_no_speed_and_no_estimate_yet);
    RUN_TEST(an_input_that_is_not_valid_lets_time_go_on);
    RUN_TEST(what_is_due_is_done_before_a_newer_sample);
    RUN_TEST(a_refused_sample_is_counted_at_once);
    RUN_TEST(false_means_that_nothing_is_due);
    RUN_TEST(a_status_changes_as_a_whole);
    RUN_TEST(a_row_has_its_slices_and_the_supervision_one_more);
    RUN_TEST(no_slice_is_longer_than_it_may_be);
    RUN_TEST(an_estimate_is_reported_in_a_slice_that_has_room_for_it);
    RUN_TEST(what_has_come_and_is_gone_is_missing_until_it_is_back);
    RUN_TEST(a_fault_of_an_estimate_is_counted_with_it);
    RUN_TEST(a_rejected_sensor_is_left_out_and_is_not_missing);
    RUN_TEST(a_sensor_that_is_measured_is_in_the_relations_alone);
    RUN_TEST(what_the_supervision_says_is_reported);
    RUN_TEST(one_relation_after_the_other_is_reported);
    RUN_TEST(an_offset_is_found_on_the_way);
    RUN_TEST(a_model_is_that_of_the_speed_that_is_driven);
    RUN_TEST(a_model_is_the_observers_until_the_trailer_is_heard);
    RUN_TEST(below_30_km_h_there_is_no_model);
    return UNITY_END();
}

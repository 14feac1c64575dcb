/* The whole core on computed signals: a free oscillation of the linear reference combination. */
#include "core_feed.h"
#include "unity.h"

static sway_core_t core;
static sway_core_t other;
static sway_core_config_t config;

void setUp(void)
{
    sway_core_defaults(&config);
    config.vehicle = reference_vehicle();
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
}

void tearDown(void)
{
}

static void noise_free_stiffnesses_within_the_goals(void)
{
    static const double complex s[] = {-0.1 + 4.2 * I, 0.05 + 4.0 * I, -0.3 + 5.0 * I};
    for (unsigned trial = 0; trial < 3; trial++) {
        test_plant_t plant = reference_plant(100);
        sway_line_t line;
        plant.s = s[trial];
        for (int axle = 0; axle < 4; axle++) {
            plant.stiffness[axle] *= cexp(-I * 0.02 * (axle + 1));
        }
        plant_line(&plant, &config.vehicle, &line);
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
        feed(&core, &line, &plant, 0, 8, -1);
        const sway_status_t *const status = sway_core_status(&core);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE | SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR |
                                  SWAY_VALID_TRAILER_REAR | SWAY_VALID_CAR_INERTIA |
                                  SWAY_VALID_TRAILER_INERTIA,
                              status->valid);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, cimag(plant.s), status->frequency_uhz * 1e-6 * 2 * M_PI);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, creal(plant.s), status->growth_ppm_per_s * 1e-6);
        for (int axle = 0; axle < 2; axle++) {
            const sway_axle_status_t *const a = &status->axle[axle];
            TEST_ASSERT_DOUBLE_WITHIN(
                0.003, 1, a->cornering_stiffness_n_per_rad / cabs(plant.stiffness[axle]));
            TEST_ASSERT_DOUBLE_WITHIN(0.3 * M_PI / 180, carg(plant.stiffness[axle]),
                                      a->argument_urad * 1e-6);
        }
        /* The trailer's axles share their force by the user's ratio: their mean is exact. */
        const double sum = status->axle[2].cornering_stiffness_n_per_rad +
                           status->axle[3].cornering_stiffness_n_per_rad;
        TEST_ASSERT_DOUBLE_WITHIN(0.003, 1, sum / (131200 + 124400));
        TEST_ASSERT_DOUBLE_WITHIN(26.9, 2690, status->car_yaw_inertia_gm2 * 1e-3);
        TEST_ASSERT_DOUBLE_WITHIN(103.5, 10350, status->trailer_yaw_inertia_gm2 * 1e-3);
    }
}

static void results_do_not_depend_on_when_slices_run(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&other, &config));
    feed(&core, &line, &plant, 0, 6, -1);
    feed(&other, &line, &plant, 0, 6, 1); // starved: the rest is made up for at the next rows
    drain(&other);
    TEST_ASSERT_TRUE(sway_core_status(&core)->sequence > 10);
    TEST_ASSERT_EQUAL_MEMORY(sway_core_status(&core), sway_core_status(&other),
                             sizeof(sway_status_t));
}

static void bad_samples_are_counted_and_harm_nothing(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&other, &config));
    feed(&core, &line, &plant, 0, 5, -1);
    feed(&other, &line, &plant, 0, 2.5, -1);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE, sway_core_input(&other, SWAY_INPUT_SPEED, 3490000, -1));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_RANGE,
                          sway_core_input(&other, SWAY_INPUT_CAR_YAW_RATE, 3490000, INT32_MIN));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_TIME,
                          sway_core_input(&other, SWAY_INPUT_CAR_YAW_RATE, 2000000, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT,
                          sway_core_input(&other, SWAY_INPUT_COUNT, 3490000, 0));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_input(NULL, SWAY_INPUT_SPEED, 0, 0));
    feed(&other, &line, &plant, 2.5, 5, -1);
    const uint32_t *const fault = sway_core_status(&other)->fault_count;
    TEST_ASSERT_EQUAL_UINT32(2, fault[SWAY_FAULT_RANGE]);
    TEST_ASSERT_EQUAL_UINT32(1, fault[SWAY_FAULT_TIME]);
    TEST_ASSERT_EQUAL_INT32(sway_core_status(&core)->v_crit_mm_s,
                            sway_core_status(&other)->v_crit_mm_s);
    TEST_ASSERT_EQUAL_INT32(sway_core_status(&core)->axle[1].cornering_stiffness_n_per_rad,
                            sway_core_status(&other)->axle[1].cornering_stiffness_n_per_rad);
}

/* What is done wrong with the car's yaw rate from 6 to 7 s of ten. */
typedef enum { OUT_OF_RANGE, TIME_GOING_BACK, RATE_OFF, SILENT } wrong_t;

static sway_error_t feed_wrong(wrong_t wrong, int64_t time_us, int32_t right)
{
    const int64_t into_us = time_us - 6000000;
    if (into_us < 0 || into_us >= 1000000 || wrong == SILENT) {
        const bool silent = into_us >= 0 && into_us < 1000000;
        return silent ? SWAY_OK : sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, time_us, right);
    }
    if (wrong == OUT_OF_RANGE) {
        return sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, time_us, 6000000);
    }
    if (wrong == TIME_GOING_BACK) {
        return sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, 5500000 - into_us / 10, right);
    }
    const int64_t slow_us = 6000000 + into_us / 10 * 11; // ten samples in the time of eleven
    return slow_us >= 7000000 ? SWAY_OK
                              : sway_core_input(&core, SWAY_INPUT_CAR_YAW_RATE, slow_us, right);
}

static void each_wrong_input_is_counted_marks_the_estimate_and_stops_nothing(void)
{
    static const sway_fault_t fault[] = {SWAY_FAULT_RANGE, SWAY_FAULT_TIME, SWAY_FAULT_RATE,
                                         SWAY_FAULT_GAP};
    for (int wrong = OUT_OF_RANGE; wrong <= SILENT; wrong++) {
        uint32_t marked = 0;
        uint32_t unmarked = 0;
        uint32_t sequence = 0;
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
        for (int64_t t = 0; t < 11000000; t += 10000) {
            const double angle = 4.2 * (double)t * 1e-6;
            const int32_t yaw = (int32_t)lround(1e5 * cos(angle));
            TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_input(&core, SWAY_INPUT_SPEED, t, 25000));
            TEST_ASSERT_EQUAL_INT(SWAY_OK,
                                  sway_core_input(&core, SWAY_INPUT_TRAILER_YAW_RATE, t, yaw));
            (void)feed_wrong((wrong_t)wrong, t, yaw);
            drain(&core);
            const sway_status_t *const status = sway_core_status(&core);
            if (status->sequence != sequence && t > 4000000) {
                TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, status->valid);
                TEST_ASSERT_INT_WITHIN(200, 668451, status->frequency_uhz);
                /* from 0.9 s, when the mean of the rate tells, to the window's end */
                const bool within = t > 6900000 && t < 8500000;
                const bool clear = t < 6000000 || t > 10300000;
                /* a gap in what is used, or too much of it to be used */
                const bool flagged = (status->quality & SWAY_QUALITY_GAP) != 0U ||
                                     status->missing_inputs == 1U << SWAY_CHANNEL_CAR_YAW_RATE;
                marked += within && flagged ? 1U : 0U;
                unmarked += within && !flagged ? 1U : 0U;
                TEST_ASSERT_TRUE(!clear || !flagged);
            }
            sequence = status->sequence;
        }
        TEST_ASSERT_TRUE(marked >= 8U);
        TEST_ASSERT_EQUAL_UINT32(0, unmarked);
        TEST_ASSERT_TRUE(sway_core_status(&core)->fault_count[fault[wrong]] >= 1U);
    }
}

static void too_slow_keeps_the_last_result_marked_old(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    feed(&core, &line, &plant, 0, 6, -1);
    const sway_status_t before = *sway_core_status(&core);
    const uint32_t results = SWAY_VALID_CRITICAL_SPEED | SWAY_VALID_CAR_REAR | SWAY_VALID_MODEL;
    TEST_ASSERT_BITS_HIGH(results, before.valid);
    plant.v = 5;
    feed(&core, &line, &plant, 6, 10, -1);
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_TRUE(status->sequence > before.sequence);
    TEST_ASSERT_BITS_HIGH(results, status->old);
    TEST_ASSERT_BITS_LOW(results, status->valid);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_SLOW, status->quality);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, status->alarm);
    TEST_ASSERT_INT32_WITHIN(2000, before.v_crit_mm_s, status->v_crit_mm_s);
    plant.v = 0;
    feed(&core, &line, &plant, 10, 14, -1);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, sway_core_status(&core)->alarm);
    TEST_ASSERT_BITS_HIGH(results, sway_core_status(&core)->old);
}

/* Six seconds of a good line, six of `changed`, which no tyre can do: the last stiffnesses that
 * were valid are kept to the bit and marked old, the reason is said and counted, the model goes on.
 */
static void expect_old_stiffnesses(const sway_line_t *good, const sway_line_t *changed,
                                   const test_plant_t *plant)
{
    const uint32_t axles = SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    feed(&core, good, plant, 0, 6, -1);
    const sway_status_t before = *sway_core_status(&core);
    sway_status_t last = before;
    TEST_ASSERT_BITS_HIGH(axles, before.valid);
    for (int k = 0; k < 60; k++) {
        feed(&core, changed, plant, 6 + 0.1 * k, 6 + 0.1 * (k + 1), -1);
        const sway_status_t *const now = sway_core_status(&core);
        for (int axle = 0; axle < 2; axle++) {
            if ((now->valid & ((uint32_t)SWAY_VALID_CAR_FRONT << (unsigned)axle)) != 0U) {
                last.axle[axle] = now->axle[axle];
            }
        }
    }
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_TRUE(status->sequence > before.sequence + 5);
    TEST_ASSERT_BITS_LOW(axles, status->valid);
    TEST_ASSERT_BITS_HIGH(axles, status->old);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_SINGULAR, status->quality);
    TEST_ASSERT_TRUE(status->fault_count[SWAY_FAULT_SINGULAR] > 0U);
    TEST_ASSERT_EQUAL_MEMORY(&last.axle[0], &status->axle[0], sizeof status->axle[0]);
    TEST_ASSERT_EQUAL_MEMORY(&last.axle[1], &status->axle[1], sizeof status->axle[1]);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_CRITICAL_SPEED, status->valid);
    TEST_ASSERT_INT32_WITHIN(1000, before.v_crit_mm_s, status->v_crit_mm_s);
}

static void no_slip_to_divide_by_keeps_the_last_result_marked_old(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    sway_line_t changed = line;
    for (int i = SWAY_CHANNEL_STEERING_WHEEL_ANGLE; i <= (int)SWAY_CHANNEL_CAR_LATERAL_ACC; i++) {
        changed.channel[i].amplitude = complex_of(0);
    }
    expect_old_stiffnesses(&line, &changed, &plant);
}

static void zero_and_impossible_stiffness_keep_the_last_result_marked_old(void)
{
    static const double complex turn[] = {0, I, -1}; // no force, a quarter turn early, against it
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    for (unsigned trial = 0; trial < 3; trial++) {
        sway_line_t changed = line;
        for (int i = SWAY_CHANNEL_CAR_FRONT_FY; i <= (int)SWAY_CHANNEL_CAR_REAR_FY; i++) {
            changed.channel[i].amplitude =
                complex_of(cvalue(line.channel[i].amplitude) * turn[trial]);
        }
        expect_old_stiffnesses(&line, &changed, &plant);
    }
}

static void a_standing_vehicle_says_nothing(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    for (int i = 0; i < (int)SWAY_CHANNELS; i++) {
        line.channel[i].amplitude = complex_of(0);
    }
    plant.v = 0;
    feed(&core, &line, &plant, 0, 6, -1);
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_BITS_LOW(SWAY_VALID_CRITICAL_SPEED | SWAY_VALID_CAR_REAR | SWAY_VALID_LINE,
                         status->valid);
    TEST_ASSERT_EQUAL_UINT32(0, status->old);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, status->alarm);
}

static void bad_configurations_are_refused(void)
{
    sway_core_config_t bad = config;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, NULL));
    bad.sample_period_us = 1000;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &bad));
    bad = config;
    bad.window_cycles_milli = 500;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &bad));
    bad = config;
    bad.input_delay_us[SWAY_INPUT_CAR_YAW_RATE] = 600000;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &bad));
    bad = config;
    bad.alarm.hold_ms = -5;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &bad));
    bad = config;
    bad.vehicle.car.mass_g = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_core_init(&core, &bad));
    sway_core_defaults(&bad);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_core_init(&core, &bad));
}

static void sample_periods_from_5_to_20_ms_are_taken(void)
{
    static const int32_t period_us[][2] = {{4999, 0}, {5000, 1}, {20000, 1}, {20001, 0}};
    for (size_t i = 0; i < sizeof period_us / sizeof period_us[0]; i++) {
        config.sample_period_us = period_us[i][0];
        TEST_ASSERT_EQUAL_INT(period_us[i][1] ? SWAY_OK : SWAY_ERROR_ARGUMENT,
                              sway_core_init(&core, &config));
    }
}

/* Only what `mask` names of a line, from 0 to 6 s. */
static const sway_status_t *run_with(sway_line_t line, const test_plant_t *plant, uint32_t mask,
                                     bool with_speed)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    for (int k = 0; k < 600; k++) {
        const int64_t time_us = 1000000 + 10000 * (int64_t)k;
        if (with_speed || k < 200) {
            (void)sway_core_input(&core, SWAY_INPUT_SPEED, time_us,
                                  (int32_t)lround(plant->v * 1e3));
        }
        for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
            const sway_line_channel_t *const channel = &line.channel[SIGNALS[i].channel];
            const double x = creal(cvalue(channel->amplitude) * cexp(plant->s * 0.01 * k));
            if ((mask & SWAY_CHANNEL_BIT(SIGNALS[i].channel)) != 0U) {
                (void)sway_core_input(&core, SIGNALS[i].input, time_us,
                                      (int32_t)lround(x * SIGNALS[i].scale));
            }
        }
        drain(&core);
    }
    TEST_ASSERT_TRUE(sway_core_status(&core)->sequence > 10);
    return sway_core_status(&core);
}

/* The trailer's yaw rate of a combination or the car's; the car's of a solo car. */
static void a_yaw_rate_that_swings_is_needed(void)
{
    const uint32_t car = SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE);
    const uint32_t trailer = SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    for (int axles = 0; axles <= 2; axles += 2) {
        config.vehicle.trailer.axles = axles;
        const sway_status_t *status = run_with(line, &plant, car, true);
        TEST_ASSERT_BITS_LOW(SWAY_QUALITY_MISSING_INPUT, status->quality);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, status->valid);
        TEST_ASSERT_NOT_EQUAL(0, status->amplitude_urad_s);
    }
    const sway_status_t *status = run_with(line, &plant, trailer, true);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_MISSING_INPUT, status->quality);
    config.vehicle.trailer.axles = 0;
    status = run_with(line, &plant, trailer, true);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_MISSING_INPUT, status->quality);
    TEST_ASSERT_EQUAL_INT32(0, status->amplitude_urad_s);
}

/* 4 s without a speed: no model at an old one, and no judgement. */
static void a_speed_that_stays_away_is_not_known(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    const sway_status_t *status = run_with(line, &plant, line.valid_mask, true);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_SPEED | SWAY_VALID_CRITICAL_SPEED, status->valid);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_NO_SPEED | SWAY_QUALITY_SLOW, status->quality);
    status = run_with(line, &plant, line.valid_mask, false);
    TEST_ASSERT_BITS_LOW(SWAY_VALID_SPEED | SWAY_VALID_CRITICAL_SPEED, status->valid);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_NO_SPEED, status->quality);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_SLOW, status->quality);
    TEST_ASSERT_EQUAL_INT(SWAY_ALARM_OFF, status->alarm);
}

/* A hand that moves the wheel a little makes the signal's damping less certain; nothing else of
 * the two runs differs, as no axle is identified from yaw rates alone. */
static void steering_takes_certainty_from_the_signal(void)
{
    const uint32_t mask = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE) |
                          SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                          SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_YAW_RATE);
    static const double wheel_rad[] = {0, 0.01, 0.02};
    int32_t se_ppm[3];
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    for (int k = 0; k < 3; k++) {
        line.channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude = complex_of(wheel_rad[k]);
        const sway_status_t *status = run_with(line, &plant, mask, true);
        TEST_ASSERT_BITS_LOW(SWAY_QUALITY_FORCED, status->quality);
        TEST_ASSERT_EQUAL_INT(SWAY_BELIEF_BOTH, status->belief);
        se_ppm[k] = status->margin_damping_ratio_se_ppm;
    }
    TEST_ASSERT_TRUE(se_ppm[1] > se_ppm[0]);
    TEST_ASSERT_TRUE(se_ppm[2] > se_ppm[1]);
}

/* 20 deg/s and growing: the limit of 15 deg/s lies behind. */
static void a_swing_beyond_the_limit_has_no_time_left(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant.s = 0.05 + 4.2 * I;
    plant_line(&plant, &config.vehicle, &line);
    const double size = cabs(cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude));
    for (int i = 0; i < (int)SWAY_CHANNELS; i++) {
        line.channel[i].amplitude = complex_of(cvalue(line.channel[i].amplitude) * 0.35 / size);
    }
    const uint32_t wheel = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    const sway_status_t *status = run_with(line, &plant, line.valid_mask & ~wheel, true);
    TEST_ASSERT_EQUAL_INT32(0, status->time_to_limit_ms);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TIME_TO_LIMIT, status->valid);
    plant.s = -0.1 + 4.2 * I;
    status = run_with(line, &plant, line.valid_mask & ~wheel, true);
    TEST_ASSERT_EQUAL_INT32(-1, status->time_to_limit_ms);
    TEST_ASSERT_BITS_LOW(SWAY_VALID_TIME_TO_LIMIT, status->valid);
}

/* A free swing of `degrees`/s of the trailer at 0 s, the wheel held, from 0 s to `to_s`. What
 * `stop` names falls silent at 4 s, if `flickers` for 0.4 s of each second. Returns the highest
 * alarm of the last 4 s. */
static int32_t swing(double degrees, double growth, double to_s, uint32_t stop, bool flickers)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    int32_t highest = 0;
    plant.s = growth + 4.2 * I;
    plant_line(&plant, &config.vehicle, &line);
    line.channel[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].amplitude = complex_of(0);
    const double size = cabs(cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude));
    for (int k = 0; k < (int)lround(100 * to_s); k++) {
        const int64_t time_us = 1000000 + 10000 * (int64_t)k;
        const double complex e = cexp(plant.s * 0.01 * k) * degrees * M_PI / 180 / size;
        const uint32_t out = k >= 400 && (!flickers || k % 100 < 40) ? stop : 0U;
        if ((out & 1U << SWAY_CHANNEL_SPEED) == 0U) {
            (void)sway_core_input(&core, SWAY_INPUT_SPEED, time_us, (int32_t)lround(plant.v * 1e3));
        }
        for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
            const double x = creal(cvalue(line.channel[SIGNALS[i].channel].amplitude) * e);
            if ((out & 1U << SIGNALS[i].channel) == 0U) {
                (void)sway_core_input(&core, SIGNALS[i].input, time_us,
                                      (int32_t)lround(x * SIGNALS[i].scale));
            }
        }
        drain(&core);
        const int32_t alarm = sway_core_status(&core)->alarm;
        highest = k > 100 * to_s - 400 && alarm > highest ? alarm : highest;
    }
    return highest;
}

static int32_t alarm_without(uint32_t stop, bool flickers)
{
    setUp();
    return swing(1, 0.25, 12, stop, flickers);
}

/* The swing is there in whatever is left. */
static void no_input_that_falls_silent_silences_the_alarm(void)
{
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_CRITICAL, alarm_without(0, false));
    for (uint32_t channel = 0; channel <= SWAY_CHANNEL_SPEED; channel++) {
        for (int flickers = 0; flickers < 2; flickers++) {
            const int32_t alarm = alarm_without(1U << channel, flickers != 0);
            TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_CRITICAL, alarm);
        }
    }
    const uint32_t forces = UINT32_MAX << SWAY_CHANNEL_HITCH_FX & ~(1U << SWAY_CHANNEL_SPEED);
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_CRITICAL, alarm_without(forces, false));
    const uint32_t trailer =
        1U << SWAY_CHANNEL_TRAILER_YAW_RATE | 1U << SWAY_CHANNEL_TRAILER_LATERAL_ACC;
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_CRITICAL, alarm_without(trailer, false));
}

/* A clock that starts again while the alarm is on: nothing of the old time is left. */
static void a_clock_that_starts_again_begins_anew(void)
{
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_CRITICAL, swing(1, 0.25, 12, 0, false));
    const int64_t before_us = sway_core_status(&core)->time_us;
    TEST_ASSERT_EQUAL_INT32(SWAY_ALARM_NORMAL, swing(10, -0.4, 11, 0, false));
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_TRUE(status->time_us < before_us);
    TEST_ASSERT_TRUE(status->time_us > 10000000);
    TEST_ASSERT_EQUAL_UINT32(0, status->missing_inputs);
}

/* Steering, yaw rate, acceleration and speed of the car alone: the trailer is reconstructed, and
 * what is said of the margin is the observer's. */
static void the_cars_own_sensors_are_enough(void)
{
    const uint32_t own = SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE) |
                         SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_YAW_RATE) |
                         SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_LATERAL_ACC);
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    const sway_status_t *const status = run_with(line, &plant, own, true);
    TEST_ASSERT_TRUE(sway_trailer_speaks(sway_core_trailer(&core)));
    TEST_ASSERT_TRUE(sway_core_trailer(&core)->has_model);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE, status->valid);
    TEST_ASSERT_INT_WITHIN(3000, 123340 * 1000 / 3600, status->v_crit_mm_s);
}

static void wrong_calls_are_refused_or_do_nothing(void)
{
    config.trailer_assumed = -1;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &config));
    config.trailer_assumed = SWAY_ASSUMED_ALL + 1;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, &config));
    config.trailer_assumed = SWAY_ASSUMED_ALL;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_ARGUMENT, sway_core_init(&core, NULL));
    sway_core_invalid(NULL, SWAY_INPUT_SPEED, 0);
}

static void a_counter_of_singular_estimates_stays_at_its_end(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant.stiffness[0] = 6e6; // no tyre has that
    plant_line(&plant, &config.vehicle, &line);
    core.singular = UINT32_MAX - 1U;
    feed(&core, &line, &plant, 0, 6, -1);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, core.singular);
}

/* The core takes every estimate of its track; should one ever be skipped, it is counted. */
static void an_estimate_that_is_skipped_is_counted(void)
{
    test_plant_t plant = reference_plant(100);
    sway_line_t line;
    plant_line(&plant, &config.vehicle, &line);
    feed(&core, &line, &plant, 0, 5, -1);
    TEST_ASSERT_EQUAL_UINT32(0, sway_core_status(&core)->fault_count[SWAY_FAULT_OVERRUN]);
    core.sequence -= 2U;
    feed(&core, &line, &plant, 5, 6, -1);
    TEST_ASSERT_EQUAL_UINT32(1, sway_core_status(&core)->fault_count[SWAY_FAULT_OVERRUN]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(noise_free_stiffnesses_within_the_goals);
    RUN_TEST(results_do_not_depend_on_when_slices_run);
    RUN_TEST(bad_samples_are_counted_and_harm_nothing);
    RUN_TEST(each_wrong_input_is_counted_marks_the_estimate_and_stops_nothing);
    RUN_TEST(too_slow_keeps_the_last_result_marked_old);
    RUN_TEST(no_slip_to_divide_by_keeps_the_last_result_marked_old);
    RUN_TEST(zero_and_impossible_stiffness_keep_the_last_result_marked_old);
    RUN_TEST(a_standing_vehicle_says_nothing);
    RUN_TEST(bad_configurations_are_refused);
    RUN_TEST(sample_periods_from_5_to_20_ms_are_taken);
    RUN_TEST(a_yaw_rate_that_swings_is_needed);
    RUN_TEST(a_speed_that_stays_away_is_not_known);
    RUN_TEST(steering_takes_certainty_from_the_signal);
    RUN_TEST(a_swing_beyond_the_limit_has_no_time_left);
    RUN_TEST(no_input_that_falls_silent_silences_the_alarm);
    RUN_TEST(a_clock_that_starts_again_begins_anew);
    RUN_TEST(the_cars_own_sensors_are_enough);
    RUN_TEST(wrong_calls_are_refused_or_do_nothing);
    RUN_TEST(a_counter_of_singular_estimates_stays_at_its_end);
    RUN_TEST(an_estimate_that_is_skipped_is_counted);
    return UNITY_END();
}

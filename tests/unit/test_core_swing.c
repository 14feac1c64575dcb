/* The smallest critical speed over the size of the swing, as the core tells it: against the formula
 * in sway_swing.h worked out in double precision from what was driven. */
#include "core_feed.h"
#include "unity.h"

static sway_core_t core;
static sway_core_config_t config;
static test_plant_t plant;
static sway_line_t line;

#define LOWEST ((uint32_t)SWAY_VALID_LOWEST_SPEED)
#define LIMIT_RAD_S 0.2618

void setUp(void)
{
    sway_core_defaults(&config);
    config.vehicle = reference_vehicle();
    config.alarm.limit_amplitude_urad_s = 261800;
}

void tearDown(void)
{
}

/* The motion that goes on by itself at the critical speed, whose trailer turns by `swing_rad_s`:
 * the steering that plant_line() needs is nothing beside it. */
static void free_swing(double swing_rad_s)
{
    sway_single_track_t stm;
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&stm, &config.vehicle));
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(&stm, &v, &omega));
    plant = reference_plant(3.6 * value(v));
    plant.s = I * value(omega);
    plant_line(&plant, &config.vehicle, &line);
    const double now = cabs(cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude));
    for (unsigned c = 0; c < SWAY_CHANNELS; c++) {
        sway_complex_t *const amplitude = &line.channel[c].amplitude;
        *amplitude = complex_of(cvalue(*amplitude) * swing_rad_s / now);
    }
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
}

static void drive(double from_s, double to_s)
{
    feed(&core, &line, &plant, from_s, to_s, -1);
}

/* Peaks of the axles at rest, N: shares by the centre of gravity, a tandem's halfway to equal. */
static void peaks(double peak_n[4])
{
    const sway_car_t *const car = &config.vehicle.car;
    const sway_trailer_t *const trailer = &config.vehicle.trailer;
    const double m1 = 0.9 * 9.81 * car->mass_g / 1e3, m2 = 0.9 * 9.81 * trailer->mass_g / 1e3;
    const double front = car->front_axle_to_cog_um, rear = car->rear_axle_to_cog_um;
    const double f = trailer->front_axle_to_cog_um, r = trailer->rear_axle_to_cog_um;
    peak_n[0] = m1 * rear / (front + rear);
    peak_n[1] = m1 * front / (front + rear);
    peak_n[2] = m2 * (0.25 + 0.5 * r / (f + r));
    peak_n[3] = m2 * (0.25 + 0.5 * f / (f + r));
}

/* v_crit of swings of `wanted` and its error, m/s; `driven`: of the trailer's yaw rate, rad/s. */
static double expected(const double peak_n[4], double driven, double wanted, double *se)
{
    const sway_margin_model_t *const model = &core.margin.model;
    const double v = value(model->v_crit_m_s);
    double fall = 0, slope = 0;
    for (int k = 0; k < 4; k++) {
        const double force = sway_core_status(&core)->axle[k].force_amplitude_mn * 1e-3 / driven;
        const double y = (wanted * wanted - driven * driven) * pow(force / peak_n[k], 2) / 2;
        const double e =
            100 * value(model->sensitivity_m_s[SWAY_PARAMETER_CAR_FRONT_STIFFNESS + k]) / v;
        fall += e / 2 * log(1 + y);
        slope += e / 2 * y / (1 + y);
    }
    *se = hypot(value(model->v_crit_se_m_s), 0.6 * v * exp(-fall) * slope);
    return v * exp(-fall);
}

static void expect_lowest(double v_m_s, double se_m_s, int32_t swing_urad_s)
{
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_BITS_HIGH(LOWEST | SWAY_VALID_CRITICAL_SPEED | SWAY_VALID_LINE, status->valid);
    TEST_ASSERT_DOUBLE_WITHIN(0.6 + 2e-4 * 1e3 * v_m_s, 1e3 * v_m_s, status->lowest_v_crit_mm_s);
    TEST_ASSERT_DOUBLE_WITHIN(0.6 + 2e-4 * 1e3 * se_m_s, 1e3 * se_m_s,
                              status->lowest_v_crit_se_mm_s);
    TEST_ASSERT_EQUAL_INT32(swing_urad_s, status->lowest_v_crit_swing_urad_s);
}

/* A small swing is driven, the limit is far: the tyres have levelled off there. */
static void a_larger_swing_has_a_lower_critical_speed(void)
{
    double peak_n[4], se;
    free_swing(0.06);
    peaks(peak_n);
    drive(0, 8);
    const double v = expected(peak_n, 0.06, LIMIT_RAD_S, &se);
    TEST_ASSERT_TRUE(1e3 * v < sway_core_status(&core)->v_crit_mm_s - 1000.0);
    TEST_ASSERT_TRUE(se > 1.0);
    expect_lowest(v, se, 261800);
    for (int k = 0; k < 10; k++) {
        drive(8 + 0.3 * k, 8.3 + 0.3 * k);
        TEST_ASSERT_BITS_HIGH(LOWEST, sway_core_status(&core)->valid);
        TEST_ASSERT_BITS_LOW(LOWEST, sway_core_status(&core)->old);
    }
}

/* The limit is the swing that is driven: it is reported with what was measured, as measured. */
static void where_none_is_lower_it_is_that_of_the_swing_driven(void)
{
    config.alarm.limit_amplitude_urad_s = 99990;
    free_swing(0.1);
    drive(0, 8);
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_INT_WITHIN(5, 100000, status->v_crit_swing_urad_s);
    TEST_ASSERT_BITS_HIGH(LOWEST, status->valid);
    TEST_ASSERT_EQUAL_INT32(status->v_crit_mm_s, status->lowest_v_crit_mm_s);
    TEST_ASSERT_EQUAL_INT32(status->v_crit_se_mm_s, status->lowest_v_crit_se_mm_s);
    TEST_ASSERT_EQUAL_INT32(status->v_crit_swing_urad_s, status->lowest_v_crit_swing_urad_s);
}

/* Of a car whose front tyres alone level off, a small swing is the worst. */
static void small_swings_may_have_the_lowest(void)
{
    double peak_n[4], se;
    free_swing(0.1);
    peaks(peak_n);
    for (int k = 0; k < 4; k++) {
        peak_n[k] *= k == 0 ? 0.15 : 20;
        core.swing.peak_n[k] = real(peak_n[k]);
    }
    drive(0, 8);
    TEST_ASSERT_TRUE(value(core.margin.model.sensitivity_m_s[SWAY_PARAMETER_CAR_FRONT_STIFFNESS]) <
                     0);
    const double v = expected(peak_n, 0.1, 0, &se);
    TEST_ASSERT_TRUE(1e3 * v < sway_core_status(&core)->v_crit_mm_s - 10.0);
    expect_lowest(v, se, 0);
}

/* The wheel moves: what the tyres do then is not the trailer's swing. */
static void a_forced_swing_tells_nothing(void)
{
    free_swing(0.06);
    set_channel(&line, SWAY_CHANNEL_STEERING_WHEEL_ANGLE, 0.2);
    for (int k = 0; k < 20; k++) {
        drive(0.4 * k, 0.4 * (k + 1));
        TEST_ASSERT_BITS_LOW(LOWEST, sway_core_status(&core)->valid);
    }
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_FORCED, sway_core_status(&core)->quality);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_REAR | SWAY_VALID_CRITICAL_SPEED,
                          sway_core_status(&core)->valid);
    set_channel(&line, SWAY_CHANNEL_STEERING_WHEEL_ANGLE, 0);
    drive(8, 13);
    TEST_ASSERT_BITS_HIGH(LOWEST, sway_core_status(&core)->valid);
}

/* Without forces no axle is seen, though the user's model has a critical speed. */
static void axles_that_were_not_seen_tell_nothing(void)
{
    free_swing(0.06);
    for (int64_t t = 0; t < 800; t++) {
        const double complex e = cexp(plant.s * 0.01 * (double)t);
        const double yaw = creal(cvalue(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude) * e);
        (void)sway_core_input(&core, SWAY_INPUT_SPEED, 10000 * t, (int32_t)lround(plant.v * 1e3));
        (void)sway_core_input(&core, SWAY_INPUT_TRAILER_YAW_RATE, 10000 * t,
                              (int32_t)lround(yaw * 1e6));
        drain(&core);
        TEST_ASSERT_BITS_LOW(LOWEST, sway_core_status(&core)->valid | sway_core_status(&core)->old);
    }
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_LINE | SWAY_VALID_CRITICAL_SPEED,
                          sway_core_status(&core)->valid);
}

/* Too slow for a model: there is nothing to scale, the last value is an old one. */
static void without_a_critical_speed_there_is_no_lowest(void)
{
    free_swing(0.06);
    drive(0, 8);
    const sway_status_t before = *sway_core_status(&core);
    TEST_ASSERT_BITS_HIGH(LOWEST, before.valid);
    plant.v = 5;
    drive(8, 12);
    const sway_status_t *const status = sway_core_status(&core);
    TEST_ASSERT_BITS_LOW(LOWEST | SWAY_VALID_CRITICAL_SPEED, status->valid);
    TEST_ASSERT_BITS_HIGH(LOWEST | SWAY_VALID_CRITICAL_SPEED, status->old);
    TEST_ASSERT_INT_WITHIN(before.lowest_v_crit_mm_s / 20, before.lowest_v_crit_mm_s,
                           status->lowest_v_crit_mm_s);
}

/* The car is configured alone, its axles have been seen, and its own sensors tell of a trailer: the
 * critical speed is the observer's, which knows no forces of axles. */
static void a_trailer_found_by_the_car_has_no_lowest(void)
{
    free_swing(0.06);
    const sway_trailer_watch_t learnt = core.watch;
    uint32_t watched = 0;
    config.vehicle.trailer.axles = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_core_init(&core, &config));
    core.watch = learnt; // as after a long drive with this trailer
    for (int64_t t = 0; t < 1000; t++) {
        const double complex e = cexp(plant.s * 0.01 * (double)t);
        (void)sway_core_input(&core, SWAY_INPUT_SPEED, 10000 * t, (int32_t)lround(plant.v * 1e3));
        for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
            const sway_input_t input = SIGNALS[i].input;
            if (input != SWAY_INPUT_TRAILER_YAW_RATE && input != SWAY_INPUT_TRAILER_LATERAL_ACC &&
                input != SWAY_INPUT_HITCH_FX && input != SWAY_INPUT_HITCH_FY) {
                const double x = creal(cvalue(line.channel[SIGNALS[i].channel].amplitude) * e);
                (void)sway_core_input(&core, input, 10000 * t,
                                      (int32_t)lround(x * SIGNALS[i].scale));
            }
        }
        drain(&core);
        TEST_ASSERT_BITS_LOW(LOWEST, sway_core_status(&core)->valid);
        watched += (sway_core_status(&core)->valid & SWAY_VALID_CRITICAL_SPEED) != 0U ? 1U : 0U;
    }
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_CAR_FRONT | SWAY_VALID_CAR_REAR,
                          sway_core_status(&core)->valid);
    TEST_ASSERT_TRUE(core.watched && watched > 100U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_larger_swing_has_a_lower_critical_speed);
    RUN_TEST(where_none_is_lower_it_is_that_of_the_swing_driven);
    RUN_TEST(small_swings_may_have_the_lowest);
    RUN_TEST(a_forced_swing_tells_nothing);
    RUN_TEST(axles_that_were_not_seen_tell_nothing);
    RUN_TEST(without_a_critical_speed_there_is_no_lowest);
    RUN_TEST(a_trailer_found_by_the_car_has_no_lowest);
    return UNITY_END();
}

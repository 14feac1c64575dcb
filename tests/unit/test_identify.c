/* Identification on lines of an exact linear combination: what was put in comes back. */
#include "sway_test.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static sway_line_t line;
static sway_identify_t id;

void setUp(void)
{
    vehicle = reference_vehicle();
}

void tearDown(void)
{
}

static void identify(void)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_identify_start(&id, &vehicle, &line));
    int slices = 1;
    while (sway_identify_run(&id)) {
        slices++;
    }
    TEST_ASSERT_LESS_THAN_INT(20, slices);
    TEST_ASSERT_FALSE(sway_identify_run(&id));
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_SPEED, id.valid);
}

static void drop(sway_channel_t channel)
{
    line.valid_mask &= ~SWAY_CHANNEL_BIT(channel);
}

static void drop_forces(void)
{
    for (int channel = SWAY_CHANNEL_HITCH_FX; channel < (int)SWAY_CHANNEL_COUNT; channel++) {
        drop((sway_channel_t)channel);
    }
}

static void expect_stiffness(const double complex truth[4], unsigned axles, double tolerance)
{
    for (unsigned axle = 0; axle < 4; axle++) {
        const bool valid = (id.valid & ((uint32_t)SWAY_VALID_CAR_FRONT << axle)) != 0;
        TEST_ASSERT_EQUAL_INT((axles >> axle) & 1U, valid);
        if (valid) {
            const double complex ratio = cvalue(id.axle[axle].stiffness.value) / truth[axle];
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, 1, creal(ratio));
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, 0, cimag(ratio));
        }
    }
}

static void stiffnesses_come_back_at_every_s(void)
{
    test_plant_t plant = reference_plant(100);
    const double complex s[] = {4.2 * I, -0.5 + 4.2 * I, 0.3 + 4 * I, -1 + 6 * I, 2.5 * I};
    for (unsigned i = 0; i < sizeof s / sizeof s[0]; i++) {
        plant.s = s[i];
        plant_line(&plant, &vehicle, &line);
        identify();
        expect_stiffness(plant.stiffness, 15, 2e-6);
        TEST_ASSERT_DOUBLE_WITHIN(0.03, 2690, value(id.car_inertia.value.re));
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia.value.re));
        TEST_ASSERT_BITS(SWAY_QUALITY_EQUAL_SPLIT | SWAY_QUALITY_USER_INERTIA, 0, id.quality);
    }
}

static void arguments_of_the_stiffness_come_back(void)
{
    test_plant_t plant = reference_plant(100);
    for (int axle = 0; axle < 4; axle++) {
        plant.stiffness[axle] *= (0.8 + 0.1 * axle) * cexp(-I * 0.05 * (axle + 1));
    }
    plant_line(&plant, &vehicle, &line);
    identify();
    expect_stiffness(plant.stiffness, 15, 2e-6);
}

static void a_trailer_without_wheel_forces_is_split_by_the_users_ratio(void)
{
    test_plant_t plant = reference_plant(100);
    plant.pull = 700;
    plant.stiffness[2] *= 0.9;
    plant.stiffness[3] *= 0.9;
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_TRAILER_FRONT_FY);
    drop(SWAY_CHANNEL_TRAILER_REAR_FY);
    identify();
    expect_stiffness(plant.stiffness, 15, 2e-6);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia.value.re));
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_EQUAL_SPLIT, id.quality);
    /* The text's two methods with the same data: close, not equal. */
    TEST_ASSERT_DOUBLE_WITHIN(1500, 10350, value(id.trailer_inertia_1.value.re));
    TEST_ASSERT_DOUBLE_WITHIN(2500, 10350, value(id.trailer_inertia_2.value.re));
    TEST_ASSERT_TRUE(fabs(value(id.trailer_inertia_1.value.re) - 10350) > 1);
}

static void methods_1_and_2_are_exact_where_their_assumptions_hold(void)
{
    test_plant_t plant = reference_plant(100);
    /* Method 2: stiffness in proportion to the static loads lr2 : lf2. */
    plant.stiffness[2] = 255600 * 0.526 / 0.65;
    plant.stiffness[3] = 255600 * 0.124 / 0.65;
    plant_line(&plant, &vehicle, &line);
    identify();
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_INERTIA_2, id.valid);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia_2.value.re));
    /* Method 1: equal forces. */
    plant = reference_plant(100);
    for (int pass = 0; pass < 20; pass++) {
        plant_line(&plant, &vehicle, &line);
        identify();
        plant.stiffness[3] *= cvalue(id.axle[2].force.value) / cvalue(id.axle[3].force.value);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 10350, value(id.trailer_inertia_1.value.re));
}

static void without_force_sensors_the_balances_give_the_stiffnesses(void)
{
    test_plant_t plant = reference_plant(100);
    for (int axle = 0; axle < 4; axle++) {
        plant.stiffness[axle] *= axle < 2 ? 0.8 + 0.3 * axle : 0.85;
    }
    plant_line(&plant, &vehicle, &line);
    drop_forces();
    identify();
    expect_stiffness(plant.stiffness, 15, 5e-6);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_USER_INERTIA | SWAY_QUALITY_EQUAL_SPLIT, id.quality);
    TEST_ASSERT_BITS(SWAY_VALID_CAR_INERTIA | SWAY_VALID_TRAILER_INERTIA, 0, id.valid);
    TEST_ASSERT_BITS(SWAY_VALID_TRAILER_INERTIA_1 | SWAY_VALID_TRAILER_INERTIA_2, 0, id.valid);
}

static void hitch_sensor_alone_is_enough_for_the_car(void)
{
    test_plant_t plant = reference_plant(90);
    plant_line(&plant, &vehicle, &line);
    drop_forces();
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_HITCH_FY);
    identify();
    expect_stiffness(plant.stiffness, 15, 2e-6);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_INERTIA, id.valid);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_USER_INERTIA, id.quality); // of the car
}

static void car_wheel_forces_alone_are_enough_for_the_trailer(void)
{
    test_plant_t plant = reference_plant(90);
    plant_line(&plant, &vehicle, &line);
    drop_forces();
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_FRONT_FY);
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_REAR_FY);
    identify();
    expect_stiffness(plant.stiffness, 15, 2e-6);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_INERTIA | SWAY_VALID_CAR_INERTIA, id.valid);
}

static void solo_car_and_single_axle(void)
{
    test_plant_t plant = reference_plant(100);
    vehicle.trailer.axles = 1;
    plant_line(&plant, &vehicle, &line);
    identify();
    expect_stiffness(plant.stiffness, 11, 2e-6);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia.value.re));
    TEST_ASSERT_BITS(SWAY_VALID_TRAILER_INERTIA_1 | SWAY_VALID_TRAILER_INERTIA_2, 0, id.valid);

    vehicle.trailer.axles = 0;
    plant_line(&plant, &vehicle, &line);
    identify();
    expect_stiffness(plant.stiffness, 3, 2e-6);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 2690, value(id.car_inertia.value.re));
    drop_forces();
    identify();
    expect_stiffness(plant.stiffness, 3, 2e-6);
}

static void accelerometers_may_sit_anywhere(void)
{
    test_plant_t plant = reference_plant(100);
    vehicle.car.lateral_acc_position_um = 900000;
    vehicle.trailer.lateral_acc_position_um = 4000000;
    plant_line(&plant, &vehicle, &line);
    identify();
    expect_stiffness(plant.stiffness, 15, 2e-6);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia.value.re));
}

static void missing_sensors_switch_off_exactly_what_needs_them(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_CAR_LATERAL_ACC);
    identify();
    expect_stiffness(plant.stiffness, 12, 2e-6);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_SINGULAR, id.quality); // not known is not singular
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_STEERING_WHEEL_ANGLE);
    identify();
    expect_stiffness(plant.stiffness, 14, 2e-6);
    plant_line(&plant, &vehicle, &line);
    drop(SWAY_CHANNEL_TRAILER_YAW_RATE);
    identify();
    expect_stiffness(plant.stiffness, 3, 2e-6);
    TEST_ASSERT_BITS_HIGH(SWAY_VALID_CAR_INERTIA, id.valid);
}

/* The load of the car's rear axle swings with twice the line: all round the circle. */
static void effective_load_for_every_phase(void)
{
    for (int degree = -180; degree < 180; degree += 15) {
        const double zeta = 18.15, mean = 10204, amplitude = 900;
        const double phase = degree * M_PI / 180;
        test_plant_t plant = reference_plant(110);
        /* Force = zeta slip load: the line sees zeta (mean + amplitude/2 e^(j phase to slip^2)). */
        const double complex effective = mean + 0.5 * amplitude * cexp(I * phase);
        plant.stiffness[1] = zeta * effective;
        plant_line(&plant, &vehicle, &line);
        identify();
        const double complex slip = cvalue(id.axle[1].slip.value);
        const double complex unit = slip / cabs(slip);
        set_channel(&line, SWAY_CHANNEL_CAR_REAR_FZ, 0);
        line.channel[SWAY_CHANNEL_CAR_REAR_FZ].mean = real(mean);
        line.channel[SWAY_CHANNEL_CAR_REAR_FZ].second =
            complex_of(amplitude * cexp(I * phase) * unit * unit);
        identify();
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_CAR_REAR_LOAD, id.valid);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, cabs(effective), value(id.axle[1].effective_load_n));
        TEST_ASSERT_DOUBLE_WITHIN(0.01, mean, value(id.axle[1].load_n));
        const double complex harmonic = cvalue(id.axle[1].load_harmonic_n);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, amplitude, cabs(harmonic));
        /* Against the force squared: the force leads the slip by the argument of the stiffness. */
        const double difference = carg(harmonic * cexp(-I * (phase - 2 * carg(effective))));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0, difference);
        const double complex c = cvalue(id.axle[1].stiffness.value);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, zeta, cabs(c) / value(id.axle[1].effective_load_n));
        if (degree == 90 || degree == -90) {
            TEST_ASSERT_TRUE(carg(c) * degree > 0);
            TEST_ASSERT_TRUE(cimag(harmonic) * degree > 0);
        }
    }
}

static void errors_of_all(double amplitude_se)
{
    for (int c = 0; c < (int)SWAY_CHANNELS; c++) {
        line.channel[c].amplitude_se = real(amplitude_se);
    }
}

/* A moment of 4 M / (pi rate) times the articulation rate is what friction does to a line. It comes
 * back, and the inertias as they are without it; Eq. 4.18-4.19 as they stand are far off. */
static void what_rubs_at_the_ball_is_no_inertia(void)
{
    const double complex s[] = {4.2 * I, -0.5 + 4.2 * I, 0.3 + 4 * I};
    for (unsigned i = 0; i < sizeof s / sizeof s[0]; i++) {
        test_plant_t plant = reference_plant(100);
        plant.s = s[i];
        plant.friction = 6000;
        plant_line(&plant, &vehicle, &line);
        identify();
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 6000, value(id.damping_nms));
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 2690, value(id.freed_inertia[0].value.re));
        TEST_ASSERT_DOUBLE_WITHIN(0.5, 10350, value(id.freed_inertia[1].value.re));
        TEST_ASSERT_TRUE(cabs(cvalue(id.car_inertia.value) - 2690) > 1000);
        TEST_ASSERT_TRUE(cabs(cvalue(id.trailer_inertia.value) - 10350) > 1000);
        TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_HITCH, id.quality);
        drop(SWAY_CHANNEL_CAR_FRONT_FY); // then it is in the forces of the car's axles
        drop(SWAY_CHANNEL_CAR_REAR_FY);
        identify();
        expect_stiffness(plant.stiffness, 15, 1e-5);
    }
}

/* Its error is in the inertias and in forces that are made with it. */
static void the_error_of_what_rubs_is_in_all_that_is_freed_of_it(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    errors_of_all(0);
    line.channel[SWAY_CHANNEL_TRAILER_REAR_FY].amplitude_se = real(50);
    identify();
    TEST_ASSERT_TRUE(value(id.freed_inertia[1].se) > 1.001 * value(id.trailer_inertia.se));
    TEST_ASSERT_TRUE(value(id.freed_inertia[1].se) < 2 * value(id.trailer_inertia.se));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0, value(id.car_inertia.se));
    TEST_ASSERT_TRUE(value(id.freed_inertia[0].se) > 10);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_HITCH, id.quality);
    drop(SWAY_CHANNEL_CAR_FRONT_FY);
    drop(SWAY_CHANNEL_CAR_REAR_FY);
    identify();
    TEST_ASSERT_TRUE(value(id.unsure_force_n) > 1);
    for (int axle = SWAY_AXLE_CAR_FRONT; axle <= (int)SWAY_AXLE_CAR_REAR; axle++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * value(id.unsure_force_n), value(id.unsure_force_n),
                                  cabs(cvalue(id.axle[axle].slip.value)) *
                                      value(id.axle[axle].stiffness.se));
    }
}

/* A moment that drives is nothing that rubs: the inertias stay as they are, and their error grows
 * by what they cannot have. Without the car's yaw rate nobody knows. */
static void what_is_not_friction_is_an_error(void)
{
    test_plant_t plant = reference_plant(100);
    plant.friction = -3000;
    plant_line(&plant, &vehicle, &line);
    errors_of_all(1e-5);
    identify();
    TEST_ASSERT_FALSE(id.rubs);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_UNEXPLAINED, id.quality);
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_HITCH, id.quality);
    TEST_ASSERT_DOUBLE_WITHIN(1, value(id.trailer_inertia.value.re),
                              value(id.freed_inertia[1].value.re));
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * fabs(value(id.trailer_inertia.value.im)),
                              fabs(value(id.trailer_inertia.value.im)),
                              value(id.freed_inertia[1].se));
    for (int body = 0; body < 2; body++) {
        TEST_ASSERT_EQUAL_DOUBLE(0, value(id.freed_inertia[body].value.im));
        TEST_ASSERT_TRUE(value(id.freed_inertia[body].se) > 100);
    }
    plant.friction = 0;
    plant_line(&plant, &vehicle, &line);
    errors_of_all(1e-5);
    identify();
    TEST_ASSERT_BITS_LOW(SWAY_QUALITY_UNEXPLAINED, id.quality);
    drop(SWAY_CHANNEL_CAR_YAW_RATE);
    identify();
    TEST_ASSERT_FALSE(id.rubs);
    TEST_ASSERT_DOUBLE_WITHIN(1, 10350, value(id.freed_inertia[1].value.re));
    plant_line(&plant, &vehicle, &line); // a ball that does not turn tells nothing
    line.channel[SWAY_CHANNEL_CAR_YAW_RATE] = line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE];
    identify();
    TEST_ASSERT_FALSE(id.rubs);
}

/* What drives is unexplained beyond three errors of the inertia, and nothing that rubs from two on;
 * what rubs is said beyond two errors and a thirty-second of the inertia. Errors grow with those of
 * the channels, so these place the motion at a chosen number of errors. */
static void what_acts_at_the_ball_is_judged_by_its_errors(void)
{
    test_plant_t plant = reference_plant(100);
    plant.friction = -3000;
    plant_line(&plant, &vehicle, &line);
    errors_of_all(1e-5);
    identify();
    const double drives = fabs(value(id.trailer_inertia.value.im));
    const double drives_se = value(id.trailer_inertia.se);
    const double errors[] = {2.8, 3.2};
    for (int k = 0; k < 2; k++) {
        errors_of_all(1e-5 * drives / drives_se / errors[k]);
        identify();
        TEST_ASSERT_FALSE(id.rubs);
        const double expected = k == 0 ? drives / 2.8 : drives;
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * expected, expected, value(id.freed_inertia[1].se));
    }
    plant.friction = 6000;
    plant_line(&plant, &vehicle, &line);
    errors_of_all(1e-5);
    identify();
    const double by_im = drives / 3000; // of a moment of 1 Nms
    const double rubs = 6000 * by_im;
    const double rubs_se = value(id.damping_se_nms) * by_im;
    const double like = value(id.freed_inertia[1].value.re) / 32;
    TEST_ASSERT_TRUE(like < 0.6 * rubs);
    for (int k = 0; k < 2; k++) {
        const double wanted_se = ((k == 0 ? 0.9 : 1.1) * rubs - like) / 2;
        errors_of_all(1e-5 * wanted_se / rubs_se);
        identify();
        TEST_ASSERT_TRUE(id.rubs);
        TEST_ASSERT_EQUAL_INT(k == 0, (id.quality & SWAY_QUALITY_HITCH) != 0);
    }
    /* Where the car turns more than the trailer the articulation has the other sign. */
    plant_line(&plant, &vehicle, &line);
    line.channel[SWAY_CHANNEL_CAR_YAW_RATE].amplitude =
        sway_complex_scale(line.channel[SWAY_CHANNEL_TRAILER_YAW_RATE].amplitude, real(2));
    errors_of_all(1);
    identify();
    TEST_ASSERT_TRUE(id.rubs);
}

static void bad_lines_are_refused(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    line.flags = SWAY_LINE_NO_OSCILLATION;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_NO_DATA, sway_identify_start(&id, &vehicle, &line));
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_NO_OSCILLATION, id.quality);
    line.flags = 0;
    line.speed_m_s = sway_real_int(0);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SPEED, sway_identify_start(&id, &vehicle, &line));
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_NO_SPEED, id.quality);
    line.speed_m_s = sway_real_int(8);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SPEED, sway_identify_start(&id, &vehicle, &line));
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_SLOW, id.quality);
    TEST_ASSERT_EQUAL_UINT32(0, id.valid);
}

static void no_slip_gives_no_stiffness(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    for (int channel = 0; channel < (int)SWAY_CHANNEL_HITCH_FX; channel++) {
        line.channel[channel].amplitude = complex_of(0);
    }
    identify();
    expect_stiffness(plant.stiffness, 0, 0);
    TEST_ASSERT_BITS_HIGH(SWAY_QUALITY_SINGULAR, id.quality);
    TEST_ASSERT_BITS(SWAY_VALID_CAR_INERTIA | SWAY_VALID_TRAILER_INERTIA, 0, id.valid);
}

static uint64_t state = 88172645463325252ULL;

static double gauss(void)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        sum += (double)(state >> 11) / 9007199254740992.0;
    }
    return sum;
}

/* Errors of the results over many draws of the amplitudes' errors are those that are stated. */
static void standard_errors_are_those_of_the_scatter(void)
{
    test_plant_t plant = reference_plant(110);
    const double se[] = {2e-3, 4e-4, 8e-2, 4e-4, 8e-2, 2e-3, 20, 80, 80, 120, 120};
    const sway_channel_t channel[] = {SWAY_CHANNEL_STEERING_WHEEL_ANGLE,
                                      SWAY_CHANNEL_CAR_YAW_RATE,
                                      SWAY_CHANNEL_CAR_LATERAL_ACC,
                                      SWAY_CHANNEL_TRAILER_YAW_RATE,
                                      SWAY_CHANNEL_TRAILER_LATERAL_ACC,
                                      SWAY_CHANNEL_ARTICULATION,
                                      SWAY_CHANNEL_HITCH_FX,
                                      SWAY_CHANNEL_HITCH_FY,
                                      SWAY_CHANNEL_CAR_FRONT_FY,
                                      SWAY_CHANNEL_CAR_REAR_FY,
                                      SWAY_CHANNEL_TRAILER_REAR_FY};
    for (int forces = 0; forces < 2; forces++) {
        double squares[6] = {0};
        double stated[6] = {0};
        const int draws = 400;
        for (int draw = 0; draw < draws; draw++) {
            plant_line(&plant, &vehicle, &line);
            drop(SWAY_CHANNEL_TRAILER_FRONT_FY);
            drop(SWAY_CHANNEL_TRAILER_REAR_FY);
            if (forces == 0) {
                drop_forces();
            }
            for (int i = 0; i < 11; i++) {
                sway_line_channel_t *const c = &line.channel[channel[i]];
                c->amplitude_se = real(se[i]);
                c->amplitude = complex_of(cvalue(c->amplitude) + se[i] * (gauss() + I * gauss()));
            }
            line.omega_se_rad_s = real(0.003);
            line.growth_se_1_s = real(0.003);
            line.omega_rad_s = real(cimag(plant.s) + 0.003 * gauss());
            line.growth_1_s = real(creal(plant.s) + 0.003 * gauss());
            identify();
            for (int axle = 0; axle < 4; axle++) {
                const double complex error =
                    cvalue(id.axle[axle].stiffness.value) - plant.stiffness[axle];
                squares[axle] += 0.5 * creal(error * conj(error)) / draws;
                /* Without force sensors 100 N of unseen force are in the statement. */
                const double unseen =
                    forces == 0 ? 100 / cabs(cvalue(id.axle[axle].slip.value)) : 0;
                const double se = value(id.axle[axle].stiffness.se);
                stated[axle] += (se * se - unseen * unseen) / draws;
            }
            const sway_estimate_t *const inertia[2] = {&id.car_inertia, &id.trailer_inertia};
            for (int body = 0; body < 2; body++) {
                const double complex error = cvalue(inertia[body]->value) - plant.inertia[body];
                squares[4 + body] += 0.5 * creal(error * conj(error)) / draws;
                stated[4 + body] += pow(value(inertia[body]->se), 2) / draws;
            }
        }
        for (int i = 0; i < (forces == 0 ? 4 : 6); i++) {
            TEST_ASSERT_DOUBLE_WITHIN(0.12, 1, sqrt(squares[i] / stated[i]));
        }
    }
}

/* Neither hitch nor car forces: the wheels of the trailer are enough, of one axle as of two. */
static void trailer_wheel_forces_alone_are_enough_for_the_car(void)
{
    for (int axles = 1; axles <= 2; axles++) {
        test_plant_t plant = reference_plant(90);
        vehicle.trailer.axles = axles;
        plant_line(&plant, &vehicle, &line);
        drop_forces();
        line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_REAR_FY);
        if (axles == 2) {
            line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_TRAILER_FRONT_FY);
        }
        identify();
        expect_stiffness(plant.stiffness, axles == 2 ? 15 : 11, 5e-6);
    }
}

/* Of the mean by the noise of a window, of half the harmonic by its own error. */
static void errors_of_the_effective_load_add_by_their_squares(void)
{
    test_plant_t plant = reference_plant(110);
    for (int with = 0; with < 4; with++) {
        const double noise = with & 1 ? 600 : 0, second_se = with & 2 ? 80 : 0;
        plant_line(&plant, &vehicle, &line);
        line.window_samples = 400;
        set_channel(&line, SWAY_CHANNEL_TRAILER_REAR_FZ, 0);
        line.channel[SWAY_CHANNEL_TRAILER_REAR_FZ].mean = real(7000);
        line.channel[SWAY_CHANNEL_TRAILER_REAR_FZ].noise_rms = real(noise);
        line.channel[SWAY_CHANNEL_TRAILER_REAR_FZ].second_se = real(second_se);
        identify();
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, hypot(noise / 20, second_se / 2),
                                  value(id.axle[3].effective_load_se_n));
    }
}

static void a_load_is_positive(void)
{
    static const double mean[] = {-5000, -0.001, 0, 0.001, 5000};
    test_plant_t plant = reference_plant(110);
    for (int k = 0; k < 5; k++) {
        plant_line(&plant, &vehicle, &line);
        set_channel(&line, SWAY_CHANNEL_CAR_FRONT_FZ, 0);
        line.channel[SWAY_CHANNEL_CAR_FRONT_FZ].mean = real(mean[k]);
        identify();
        TEST_ASSERT_EQUAL(mean[k] > 0, (id.valid & SWAY_VALID_CAR_FRONT_LOAD) != 0U);
    }
}

/* Measured forces of the car's axles stand by themselves, whatever inertias the user believes in.
 */
static void measured_forces_do_not_need_the_users_inertias(void)
{
    test_plant_t plant = reference_plant(90);
    plant_line(&plant, &vehicle, &line);
    drop_forces();
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_FRONT_FY);
    line.valid_mask |= SWAY_CHANNEL_BIT(SWAY_CHANNEL_CAR_REAR_FY);
    errors_of_all(0);
    vehicle.car.yaw_inertia_gm2 = 4000000;
    vehicle.trailer.yaw_inertia_gm2 = 20000000;
    identify();
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 2690, value(id.car_inertia.value.re));
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 10350, value(id.trailer_inertia.value.re));
    TEST_ASSERT_EQUAL_DOUBLE(0, value(id.axle[SWAY_AXLE_CAR_FRONT].stiffness.se));
    TEST_ASSERT_EQUAL_DOUBLE(0, value(id.axle[SWAY_AXLE_CAR_REAR].stiffness.se));
}

static void a_car_alone_has_no_trailer_whatever_its_sensors_show(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    vehicle.trailer.axles = 0;
    identify();
    TEST_ASSERT_FALSE(id.axle[SWAY_AXLE_TRAILER_FRONT].slip.known);
    TEST_ASSERT_FALSE(id.axle[SWAY_AXLE_TRAILER_REAR].slip.known);
    TEST_ASSERT_BITS(SWAY_VALID_TRAILER_INERTIA | SWAY_VALID_TRAILER_INERTIA_1 |
                         SWAY_VALID_TRAILER_INERTIA_2,
                     0, id.valid);
}

/* What growth and frequency are off by is in the stiffness as its derivative says. */
static void errors_of_the_line_are_in_the_stiffness(void)
{
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    errors_of_all(0);
    const double se = 0.05;
    line.omega_se_rad_s = real(se);
    line.growth_se_1_s = real(se);
    identify();
    const double stated = value(id.axle[SWAY_AXLE_CAR_REAR].stiffness.se);
    const double complex before = cvalue(id.axle[SWAY_AXLE_CAR_REAR].stiffness.value);
    line.omega_rad_s = real(cimag(plant.s) + 1e-3);
    identify();
    const double moved = cabs(cvalue(id.axle[SWAY_AXLE_CAR_REAR].stiffness.value) - before);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * stated, moved * se / 1e-3, stated);
}

/* An inertia is valid with an error below a fifth of it. */
static void an_inertia_is_valid_below_an_error_of_a_fifth(void)
{
    static const double share[] = {0.18, 0.22};
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    errors_of_all(0);
    line.channel[SWAY_CHANNEL_CAR_FRONT_FY].amplitude_se = real(1);
    identify();
    const double of_1_n = value(id.car_inertia.se);
    for (int i = 0; i < 2; i++) {
        line.channel[SWAY_CHANNEL_CAR_FRONT_FY].amplitude_se = real(share[i] * 2690 / of_1_n);
        identify();
        TEST_ASSERT_EQUAL(i == 0, (id.valid & SWAY_VALID_CAR_INERTIA) != 0U);
        TEST_ASSERT_BITS_HIGH(SWAY_VALID_TRAILER_INERTIA, id.valid);
    }
}

/* No force at all where there is slip is reported, if it is sure: with twice its error below
 * 1 kN/rad. */
static void no_force_where_there_is_slip_is_reported(void)
{
    static const double se[] = {450, 550};
    test_plant_t plant = reference_plant(100);
    plant_line(&plant, &vehicle, &line);
    errors_of_all(0);
    identify();
    const double slip = cabs(cvalue(id.axle[SWAY_AXLE_CAR_FRONT].slip.value));
    set_channel(&line, SWAY_CHANNEL_CAR_FRONT_FY, 0);
    for (int i = 0; i < 2; i++) {
        line.channel[SWAY_CHANNEL_CAR_FRONT_FY].amplitude_se = real(se[i] * slip);
        identify();
        TEST_ASSERT_BITS(SWAY_VALID_CAR_FRONT, 0, id.valid);
        TEST_ASSERT_EQUAL(i == 0, (id.quality & SWAY_QUALITY_SINGULAR) != 0U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(stiffnesses_come_back_at_every_s);
    RUN_TEST(arguments_of_the_stiffness_come_back);
    RUN_TEST(a_trailer_without_wheel_forces_is_split_by_the_users_ratio);
    RUN_TEST(methods_1_and_2_are_exact_where_their_assumptions_hold);
    RUN_TEST(without_force_sensors_the_balances_give_the_stiffnesses);
    RUN_TEST(hitch_sensor_alone_is_enough_for_the_car);
    RUN_TEST(car_wheel_forces_alone_are_enough_for_the_trailer);
    RUN_TEST(solo_car_and_single_axle);
    RUN_TEST(accelerometers_may_sit_anywhere);
    RUN_TEST(missing_sensors_switch_off_exactly_what_needs_them);
    RUN_TEST(effective_load_for_every_phase);
    RUN_TEST(what_rubs_at_the_ball_is_no_inertia);
    RUN_TEST(the_error_of_what_rubs_is_in_all_that_is_freed_of_it);
    RUN_TEST(what_is_not_friction_is_an_error);
    RUN_TEST(what_acts_at_the_ball_is_judged_by_its_errors);
    RUN_TEST(bad_lines_are_refused);
    RUN_TEST(no_slip_gives_no_stiffness);
    RUN_TEST(standard_errors_are_those_of_the_scatter);
    RUN_TEST(trailer_wheel_forces_alone_are_enough_for_the_car);
    RUN_TEST(errors_of_the_effective_load_add_by_their_squares);
    RUN_TEST(a_load_is_positive);
    RUN_TEST(measured_forces_do_not_need_the_users_inertias);
    RUN_TEST(a_car_alone_has_no_trailer_whatever_its_sensors_show);
    RUN_TEST(errors_of_the_line_are_in_the_stiffness);
    RUN_TEST(an_inertia_is_valid_below_an_error_of_a_fifth);
    RUN_TEST(no_force_where_there_is_slip_is_reported);
    return UNITY_END();
}

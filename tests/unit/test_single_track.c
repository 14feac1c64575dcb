/* The single-track model against the golden values of the reference, recomputed in double precision
 * by an independent eigenvalue solver (numpy) from the corrected matrices of appendix A.2. */
#include "sway_test.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static sway_single_track_t reference_model(void)
{
    sway_single_track_t stm;
    const sway_vehicle_t vehicle = reference_vehicle();
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&stm, &vehicle));
    return stm;
}

/* Routh-Hurwitz: every root of the polynomial has a negative real part. */
static bool is_stable(const sway_single_track_quartic_t *quartic)
{
    double a[5];
    bool positive = true;
    for (int k = 4; k >= 0; k--) {
        a[k] = value(quartic->a[k]);
        positive = positive && (a[k] > 0.0 || (k > 2 && a[4] == 0.0)); // solo: a quadratic
    }
    const double hurwitz = a[1] * (a[2] * a[3] - a[4] * a[1]) - a[0] * a[3] * a[3];
    return positive && (a[4] == 0.0 || hurwitz > 0.0);
}

static sway_single_track_roots_t roots_at(const sway_single_track_t *stm, double kmh, int *sweeps)
{
    const sway_single_track_quartic_t quartic = sway_single_track_quartic(stm, real(kmh / 3.6));
    sway_single_track_roots_t roots;
    sway_single_track_roots_start(&roots, &quartic);
    *sweeps = 1;
    while (!sway_single_track_roots_sweep(&roots, &quartic) && *sweeps < 50) {
        (*sweeps)++;
    }
    return roots;
}

static void critical_speed_of_the_reference(void)
{
    const sway_single_track_t stm = reference_model();
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 123.3397, value(v) * 3.6);
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.6721, value(omega) / (2 * M_PI));
    const sway_complex_t s = {sway_real_int(0), omega};
    const sway_complex_t f = sway_single_track_characteristic(&stm, s, v);
    const sway_single_track_quartic_t quartic = sway_single_track_quartic(&stm, v);
    TEST_ASSERT_TRUE(value(sway_complex_abs(f)) < 1e-6 * fabs(value(quartic.a[0])));
}

static void critical_speed_of_table_5_1(void)
{
    sway_single_track_t stm = reference_model();
    sway_real_t v;
    sway_real_t omega;
    stm.body[SWAY_SINGLE_TRACK_CAR].stiffness_n_per_rad[0] = sway_real_int(109200);
    stm.body[SWAY_SINGLE_TRACK_CAR].stiffness_n_per_rad[1] = sway_real_int(184900);
    stm.body[SWAY_SINGLE_TRACK_TRAILER].stiffness_n_per_rad[0] = sway_real_int(134200);
    stm.body[SWAY_SINGLE_TRACK_TRAILER].stiffness_n_per_rad[1] = sway_real_int(123400);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 123.028, value(v) * 3.6);
}

static void modes_at_five_speeds(void)
{
    static const double golden[5][5] = {
        {80, 0.2520, 0.6478, 0.9178, 0.5180},    {100, 0.1115, 0.6659, 0.8840, 0.5385},
        {107.9, 0.0689, 0.6690, 0.8712, 0.5448}, {117.3, 0.0250, 0.6712, 0.8565, 0.5513},
        {140, -0.0587, 0.6729, 0.8240, 0.5638},
    };
    const sway_single_track_t stm = reference_model();
    for (int i = 0; i < 5; i++) {
        int sweeps;
        const sway_single_track_roots_t roots = roots_at(&stm, golden[i][0], &sweeps);
        TEST_ASSERT_LESS_THAN_INT(20, sweeps);
        const sway_complex_t s = sway_single_track_dominant(&roots);
        TEST_ASSERT_DOUBLE_WITHIN(0.0001, golden[i][1], value(sway_single_track_damping_ratio(s)));
        TEST_ASSERT_DOUBLE_WITHIN(0.0001, golden[i][2], value(s.im) / (2 * M_PI));
        bool other = false;
        for (int k = 0; k < 4; k++) {
            const double ratio = value(sway_single_track_damping_ratio(roots.root[k]));
            const double hertz = value(roots.root[k].im) / (2 * M_PI);
            other =
                other || (fabs(ratio - golden[i][3]) < 1e-4 && fabs(hertz - golden[i][4]) < 1e-4);
        }
        TEST_ASSERT_TRUE(other);
        const sway_single_track_quartic_t quartic =
            sway_single_track_quartic(&stm, real(golden[i][0] / 3.6));
        TEST_ASSERT_EQUAL_INT(golden[i][1] > 0, is_stable(&quartic));
    }
}

static sway_complex_t slope_s(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v)
{
    sway_complex_t f;
    TEST_ASSERT_FALSE(sway_single_track_slope_s(stm, s, v, 0, &f));
    TEST_ASSERT_TRUE(sway_single_track_slope_s(stm, s, v, 1, &f));
    return f;
}

static sway_complex_t slope_v(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v)
{
    sway_complex_t f;
    TEST_ASSERT_FALSE(sway_single_track_slope_v(stm, s, v, 0, &f));
    TEST_ASSERT_TRUE(sway_single_track_slope_v(stm, s, v, 1, &f));
    return f;
}

static double sensitivity(const sway_single_track_t *stm, sway_parameter_t parameter)
{
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(stm, &v, &omega));
    const sway_complex_t s = {sway_real_int(0), omega};
    sway_real_t d_omega;
    sway_real_t d_v;
    TEST_ASSERT_EQUAL_INT(
        SWAY_OK, sway_single_track_shift(slope_s(stm, s, v), slope_v(stm, s, v),
                                         sway_single_track_slope_parameter(stm, s, v, parameter),
                                         &d_omega, &d_v));
    return value(d_v) * 3.6;
}

static void sensitivities_of_the_reference(void)
{
    static const double golden[SWAY_PARAMETER_COUNT] = {0.188,  -0.216, 0.140,  -0.721, 0.064,
                                                        0.844,  -0.767, -0.062, 0.284,  1.452,
                                                        -0.156, 0.440,  0.005,  0.334};
    const sway_single_track_t stm = reference_model();
    for (int i = 0; i < (int)SWAY_PARAMETER_COUNT; i++) {
        TEST_ASSERT_TRUE(sway_single_track_has_parameter(&stm, (sway_parameter_t)i));
        const double found = sensitivity(&stm, (sway_parameter_t)i);
        TEST_ASSERT_DOUBLE_WITHIN(fmax(0.03 * fabs(golden[i]), 0.005), golden[i], found);
    }
}

static void steady_state_of_the_reference(void)
{
    static const double golden[3][3] = {
        {10, 3.35706, -1.99922}, {20, 4.98953, -1.37428}, {30, 5.24074, -0.83228}};
    const sway_single_track_t stm = reference_model();
    for (int i = 0; i < 3; i++) {
        sway_single_track_static_t result;
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_steady_state(
                                           &stm, sway_real_int((int)golden[i][0]), &result));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, golden[i][1], value(result.yaw_rate_gain_1_s));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, golden[i][2], value(result.hitch_angle_gain));
    }
}

static void understeer_gradients_as_in_3_20_and_3_27_to_3_29(void)
{
    const sway_single_track_t stm = reference_model();
    sway_single_track_static_t result;
    TEST_ASSERT_EQUAL_INT(SWAY_OK,
                          sway_single_track_steady_state(&stm, sway_real_int(20), &result));
    const double m1 = 1955, m2 = 1880, g = 9.81, lf1 = 1.302, lr1 = 1.383, l1 = 2.685, lhr1 = 0.783;
    const double lf2 = 0.124, lr2 = 0.526, l2 = 0.65, lhf2 = 4.949;
    const double cf1 = 109300, cr1 = 185200, cf2 = 131200, cr2 = 124400;
    const double ku1 = m1 * g / l1 * (lr1 / cf1 - lf1 / cr1);
    const double common =
        (cf1 * (l1 + lhr1) + cr1 * lhr1) / (cf1 * cr1 * l1 * (cf2 * lhf2 + cr2 * (l2 + lhf2)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, ku1, value(result.understeer_gradient_rad));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, l1 - cf2 * cr2 * l2 * l2 * common,
                              value(result.effective_wheelbase_m));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, ku1 - m2 * g * (cr2 * lr2 - cf2 * lf2) * common,
                              value(result.combination_understeer_gradient_rad));
    TEST_ASSERT_TRUE(value(result.characteristic_speed_m_s) > 0);
}

static void a_trailer_with_one_axle(void)
{
    sway_vehicle_t vehicle = reference_vehicle();
    vehicle.trailer.axles = 1;
    vehicle.trailer.rear_axle_to_cog_um = 211000;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 255600;
    sway_single_track_t stm;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&stm, &vehicle));
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 124.2759, value(v) * 3.6);
    int sweeps;
    const sway_single_track_roots_t roots = roots_at(&stm, value(v) * 3.6, &sweeps);
    TEST_ASSERT_DOUBLE_WITHIN(
        1e-5, 0, value(sway_single_track_damping_ratio(sway_single_track_dominant(&roots))));
    TEST_ASSERT_FALSE(
        sway_single_track_has_parameter(&stm, SWAY_PARAMETER_TRAILER_FRONT_STIFFNESS));
    sway_single_track_static_t result;
    TEST_ASSERT_EQUAL_INT(SWAY_OK,
                          sway_single_track_steady_state(&stm, sway_real_int(20), &result));
    /* Eq. 3.22-3.24 */
    const double delta =
        1880 * 9.81 / (0.211 + 5.073) * 0.211 / 2.685 * (0.783 / 109300 + (2.685 + 0.783) / 185200);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, delta,
                              value(result.understeer_gradient_rad) -
                                  value(result.combination_understeer_gradient_rad));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.685, value(result.effective_wheelbase_m));
}

static void a_car_without_trailer(void)
{
    sway_vehicle_t vehicle = reference_vehicle();
    memset(&vehicle.trailer, 0, sizeof vehicle.trailer);
    sway_single_track_t stm;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&stm, &vehicle));
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BEYOND_RANGE,
                          sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 250, value(v) * 3.6);
    int sweeps;
    const sway_single_track_roots_t roots = roots_at(&stm, 100, &sweeps);
    TEST_ASSERT_EQUAL_INT(2, roots.count);
    const sway_complex_t s = sway_single_track_dominant(&roots);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.7145, value(sway_single_track_damping_ratio(s)));

    /* An oversteering car diverges at sqrt(-l g / K_u) and not before. */
    stm.body[SWAY_SINGLE_TRACK_CAR].stiffness_n_per_rad[1] = sway_real_int(80000);
    sway_single_track_static_t result;
    TEST_ASSERT_EQUAL_INT(SWAY_OK,
                          sway_single_track_steady_state(&stm, sway_real_int(20), &result));
    const double critical = sqrt(-2.685 * 9.81 / value(result.understeer_gradient_rad));
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_DIVERGENCE,
                          sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, critical, value(v));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -critical, value(result.characteristic_speed_m_s));
    const sway_single_track_quartic_t below =
        sway_single_track_quartic(&stm, real(critical * 0.999));
    const sway_single_track_quartic_t above =
        sway_single_track_quartic(&stm, real(critical * 1.001));
    TEST_ASSERT_TRUE(is_stable(&below));
    TEST_ASSERT_FALSE(is_stable(&above));
}

static void speeds_outside_the_search(void)
{
    sway_single_track_t stm = reference_model();
    sway_real_t v;
    sway_real_t omega;
    /* Very stiff tyres, light trailer far ahead of its axles: stable to 250 km/h. */
    stm.body[SWAY_SINGLE_TRACK_TRAILER].mass_kg = sway_real_int(300);
    stm.body[SWAY_SINGLE_TRACK_TRAILER].yaw_inertia_kgm2 = sway_real_int(300);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BEYOND_RANGE,
                          sway_single_track_critical_speed(&stm, &v, &omega));
    /* A trailer of absurd inertia: unstable below 10 km/h. */
    stm = reference_model();
    stm.body[SWAY_SINGLE_TRACK_TRAILER].yaw_inertia_kgm2 = sway_real_int(1500000);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BELOW_RANGE,
                          sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 10, value(v) * 3.6);
    stm.body[SWAY_SINGLE_TRACK_TRAILER].stiffness_n_per_rad[1] = sway_real_int(0);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_SINGULAR, sway_single_track_critical_speed(&stm, &v, &omega));
    sway_single_track_static_t result;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SINGULAR,
                          sway_single_track_steady_state(&stm, sway_real_int(20), &result));
}

/* No speed at all at which the swing neither grows nor decays: no limit, and no frequency of one.
 */
static void a_determinant_that_is_never_zero_is_no_limit(void)
{
    sway_single_track_t stm = reference_model();
    sway_real_t v;
    sway_real_t omega;
    stm.body[0].mass_kg = real(3900);
    stm.body[1].mass_kg = real(1730);
    stm.body[0].yaw_inertia_kgm2 = real(3962);
    stm.body[1].yaw_inertia_kgm2 = real(15577);
    stm.body[0].axle_m[0] = real(1.018);
    stm.body[0].axle_m[1] = real(-1.044);
    stm.body[0].hitch_m = real(-1.711);
    stm.body[1].hitch_m = real(7.249);
    stm.body[0].stiffness_n_per_rad[0] = real(209747);
    stm.body[0].stiffness_n_per_rad[1] = real(217425);
    stm.body[1].stiffness_n_per_rad[0] = real(99581);
    stm.body[1].stiffness_n_per_rad[1] = real(186351);
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_BEYOND_RANGE,
                          sway_single_track_critical_speed(&stm, &v, &omega));
    TEST_ASSERT_TRUE(value(v) == value(sway_single_track_speed_high()));
    TEST_ASSERT_TRUE(sway_real_is_zero(omega));
    for (double kmh = 10; kmh < 250; kmh += 0.5) {
        const sway_single_track_quartic_t quartic =
            sway_single_track_quartic(&stm, real(kmh / 3.6));
        TEST_ASSERT_TRUE(is_stable(&quartic));
    }
}

static void the_closed_form_limit_is_the_first_change_of_stability(void)
{
    uint32_t random = 12345;
    for (int trial = 0; trial < 300; trial++) {
        sway_single_track_t stm = reference_model();
        sway_real_t *const field[] = {
            &stm.body[0].mass_kg,
            &stm.body[1].mass_kg,
            &stm.body[0].yaw_inertia_kgm2,
            &stm.body[1].yaw_inertia_kgm2,
            &stm.body[0].axle_m[0],
            &stm.body[0].axle_m[1],
            &stm.body[0].hitch_m,
            &stm.body[1].hitch_m,
            &stm.body[0].stiffness_n_per_rad[0],
            &stm.body[0].stiffness_n_per_rad[1],
            &stm.body[1].stiffness_n_per_rad[0],
            &stm.body[1].stiffness_n_per_rad[1],
        };
        for (unsigned i = 0; i < sizeof field / sizeof field[0]; i++) {
            random = random * 1664525U + 1013904223U;
            *field[i] =
                sway_real_mul(*field[i], sway_real_ratio(500 + (random >> 16) % 1500, 1000));
        }
        sway_real_t v;
        sway_real_t omega;
        const sway_vcrit_t kind = sway_single_track_critical_speed(&stm, &v, &omega);
        double first = 10;
        for (; first < 250; first += 0.5) {
            const sway_single_track_quartic_t quartic =
                sway_single_track_quartic(&stm, real(first / 3.6));
            if (!is_stable(&quartic)) {
                break;
            }
        }
        const double found = value(v) * 3.6;
        TEST_ASSERT_TRUE_MESSAGE(kind != SWAY_VCRIT_SINGULAR, "no critical speed");
        TEST_ASSERT_DOUBLE_WITHIN(0.51, first, found);
    }
}

static void relaxation_lowers_the_critical_speed(void)
{
    /* Rear axle of the car with a relaxation length of 0.7 m: 111.83 km/h from an independent
     * state-space model with the extra state. */
    sway_single_track_t stm = reference_model();
    stm.body[SWAY_SINGLE_TRACK_CAR].relaxation_m[1] = sway_real_ratio(7, 10);
    sway_real_t v;
    sway_real_t omega;
    TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_FOUND, sway_single_track_critical_speed(&stm, &v, &omega));
    for (int step = 0; step < 10; step++) {
        const sway_complex_t s = {sway_real_int(0), omega};
        sway_real_t d_omega;
        sway_real_t d_v;
        TEST_ASSERT_EQUAL_INT(SWAY_OK,
                              sway_single_track_shift(slope_s(&stm, s, v), slope_v(&stm, s, v),
                                                      sway_single_track_characteristic(&stm, s, v),
                                                      &d_omega, &d_v));
        omega = sway_real_add(omega, d_omega);
        v = sway_real_add(v, d_v);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 111.83, value(v) * 3.6);
}

/* The Hurwitz determinant of a stable low speed needs no check but of the slow root: random
 * positive masses and stiffnesses, axles and balls anywhere. */
static void at_low_speed_only_the_slow_root_can_be_unstable(void)
{
    uint32_t seed = 1;
    int ahead = 0;
    for (int trial = 0; trial < 2000; trial++) {
        sway_single_track_t stm = reference_model();
        double x[14];
        for (int k = 0; k < 14; k++) {
            seed = seed * 1664525U + 1013904223U;
            x[k] = (seed >> 8) / 16777216.0;
        }
        for (int b = 0; b < 2; b++) {
            stm.body[b].mass_kg = real(300 + 3000 * x[b]);
            stm.body[b].yaw_inertia_kgm2 = real(500 + 9000 * x[2 + b]);
            for (int axle = 0; axle < 2; axle++) {
                stm.body[b].axle_m[axle] = real(4 * x[4 + 2 * b + axle] - 2);
                stm.body[b].stiffness_n_per_rad[axle] = real(2e4 + 2e5 * x[8 + 2 * b + axle]);
            }
            stm.body[b].hitch_m = real((b == 0 ? -4 : 4) * x[12 + b]);
        }
        sway_real_t v, omega;
        const sway_vcrit_t kind = sway_single_track_critical_speed(&stm, &v, &omega);
        const sway_single_track_quartic_t quartic = sway_single_track_quartic(&stm, real(0.02));
        const bool below = kind == SWAY_VCRIT_BELOW_RANGE && value(omega) == 0.0;
        TEST_ASSERT_TRUE(is_stable(&quartic) || kind == SWAY_VCRIT_BELOW_RANGE);
        if (below && !is_stable(&quartic)) {
            TEST_ASSERT_TRUE(value(v) == value(sway_single_track_speed_low()));
            ahead++;
        }
    }
    TEST_ASSERT_TRUE(ahead > 20); // such as an axle ahead of its ball
}

static void what_has_no_answer_is_singular(void)
{
    sway_single_track_t stm = reference_model();
    sway_single_track_static_t steady;
    sway_real_t d_omega;
    sway_real_t d_v;
    sway_single_track_roots_t roots;
    stm.body[SWAY_SINGLE_TRACK_TRAILER].axle_m[0] = real(7.0); // both ahead of the ball at 5.073 m
    stm.body[SWAY_SINGLE_TRACK_TRAILER].axle_m[1] = real(6.0);
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SINGULAR,
                          sway_single_track_steady_state(&stm, real(25), &steady));
    const sway_complex_t f_s = {sway_real_int(1), sway_real_int(2)};
    const sway_complex_t parallel = {sway_real_int(-4), sway_real_int(2)}; // twice j f_s
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_SINGULAR,
                          sway_single_track_shift(f_s, parallel, f_s, &d_omega, &d_v));
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_shift(f_s, f_s, f_s, &d_omega, &d_v));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -1.0, value(d_v)); // df = 1 f_v is undone
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, value(d_omega));
    sway_single_track_quartic_t quartic = {{sway_real_zero(), sway_real_int(6), sway_real_int(11),
                                            sway_real_int(6), sway_real_int(1)}};
    sway_single_track_roots_start(&roots, &quartic); // s (s + 1) (s + 2) (s + 3)
    for (int sweep = 0; sweep < 60 && !sway_single_track_roots_sweep(&roots, &quartic); sweep++) {
    }
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        sum += value(roots.root[k].re);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -6.0, sum);
}

static void an_axle_without_stiffness_has_no_lag(void)
{
    sway_single_track_t stm = reference_model();
    const sway_complex_t s = {real(-0.1), real(4.2)};
    stm.body[SWAY_SINGLE_TRACK_TRAILER].stiffness_n_per_rad[0] = sway_real_zero();
    const double complex without = cvalue(sway_single_track_characteristic(&stm, s, real(25)));
    stm.body[SWAY_SINGLE_TRACK_TRAILER].relaxation_m[0] = real(0.5);
    const double complex with = cvalue(sway_single_track_characteristic(&stm, s, real(25)));
    TEST_ASSERT_TRUE(without == with);
}

static void a_vehicle_that_is_not_whole_has_no_model(void)
{
    sway_single_track_t stm;
    sway_vehicle_t vehicle = reference_vehicle();
    vehicle.car.yaw_inertia_gm2 = 0; // may be 0, but not here
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_single_track_from_vehicle(&stm, &vehicle));
    vehicle = reference_vehicle();
    vehicle.car.mass_g = 1;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_single_track_from_vehicle(&stm, &vehicle));
}

static void an_axle_without_stiffness_has_no_critical_speed(void)
{
    sway_single_track_t stm = reference_model();
    sway_real_t v, omega;
    for (int axle = 0; axle < 3; axle++) {
        stm = reference_model();
        stm.body[axle / 2].stiffness_n_per_rad[axle == 2 ? 1 : axle] = sway_real_zero();
        TEST_ASSERT_EQUAL_INT(SWAY_VCRIT_SINGULAR,
                              sway_single_track_critical_speed(&stm, &v, &omega));
    }
}

static void a_vehicle_out_of_range_is_named(void)
{
    sway_vehicle_t vehicle = reference_vehicle();
    const sway_vehicle_range_t *offender;
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_vehicle_check(&vehicle, &offender));
    TEST_ASSERT_NULL(offender);
    size_t count;
    const sway_vehicle_range_t *const ranges = sway_vehicle_ranges(&count);
    for (size_t i = 0; i < count; i++) {
        for (int side = 0; side < 2; side++) {
            vehicle = reference_vehicle();
            int32_t wrong = side == 0 ? ranges[i].low - 1 : ranges[i].high + 1;
            if (wrong == 0 && ranges[i].may_be_zero) {
                wrong = -1;
            }
            memcpy((char *)&vehicle + ranges[i].offset, &wrong, sizeof wrong);
            TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_vehicle_check(&vehicle, &offender));
            TEST_ASSERT_EQUAL_PTR(&ranges[i], offender);
        }
    }
    vehicle = reference_vehicle();
    vehicle.trailer.rear_axle_to_cog_um = -vehicle.trailer.front_axle_to_cog_um;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_vehicle_check(&vehicle, &offender));
    TEST_ASSERT_EQUAL_STRING("trailer.rear_axle_to_cog", sway_vehicle_name(offender)->key);
    sway_single_track_t stm;
    vehicle = reference_vehicle();
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 0;
    TEST_ASSERT_EQUAL_INT(SWAY_ERROR_VEHICLE, sway_single_track_from_vehicle(&stm, &vehicle));
}

/* The least damped oscillation, else the rightmost real root; a pair that hardly has an imaginary
 * part is a real one. In whatever order they come. */
static void the_dominant_root_is_the_least_damped_oscillation(void)
{
    static const struct {
        double complex root[4];
        int dominant;
    } cases[] = {
        {{-1 + 4 * I, -1 - 4 * I, -0.5 + 3 * I, -0.5 - 3 * I}, 2},
        {{-0.5 + 3 * I, -0.5 - 3 * I, -1 + 4 * I, -1 - 4 * I}, 0},
        {{2, -3, -1 + 4 * I, -1 - 4 * I}, 2}, /* a real one does not swing, however it grows */
        {{-1 + 4 * I, -1 - 4 * I, 2, -3}, 0},
        {{-3, -2, -1, -4}, 2},
        {{-1, -2, -3, -4}, 0},
        {{-4, -3, 1, -2}, 2},
        {{-1 - 4 * I, -1 + 4 * I, -2, -3}, 1},
        {{-1 + 1e-5 * I, -1 - 1e-5 * I, -2, -0.5}, 3},
        {{-1e-6 + 1e-3 * I, -1e-6 - 1e-3 * I, -2, -0.5}, 0}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sway_single_track_roots_t roots = {.count = 4};
        for (int k = 0; k < 4; k++) {
            roots.root[k] = complex_of(cases[i].root[k]);
        }
        const double complex found = cvalue(sway_single_track_dominant(&roots));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, creal(cases[i].root[cases[i].dominant]), creal(found));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, cimag(cases[i].root[cases[i].dominant]), cimag(found));
    }
    const sway_single_track_roots_t double_root = {
        {complex_of(-1 + 1e-6 * I), complex_of(-1 - 1e-6 * I)}, 2};
    TEST_ASSERT_EQUAL_DOUBLE(0, cimag(cvalue(sway_single_track_dominant(&double_root))));
}

static void a_model_of_a_vehicle_has_no_lag_whatever_was_in_its_memory(void)
{
    const sway_vehicle_t vehicle = reference_vehicle();
    sway_single_track_t dirty;
    sway_single_track_t clean;
    memset(&dirty, 0x5A, sizeof dirty);
    memset(&clean, 0, sizeof clean);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&dirty, &vehicle));
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_single_track_from_vehicle(&clean, &vehicle));
    for (int body = 0; body < 2; body++) {
        for (int axle = 0; axle < 2; axle++) {
            TEST_ASSERT_EQUAL_DOUBLE(0, value(dirty.body[body].relaxation_m[axle]));
        }
    }
    const sway_complex_t s = complex_of(-0.3 + 4 * I);
    TEST_ASSERT_EQUAL_DOUBLE(0,
                             cabs(cvalue(sway_single_track_characteristic(&dirty, s, real(30))) -
                                  cvalue(sway_single_track_characteristic(&clean, s, real(30)))));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(critical_speed_of_the_reference);
    RUN_TEST(critical_speed_of_table_5_1);
    RUN_TEST(modes_at_five_speeds);
    RUN_TEST(sensitivities_of_the_reference);
    RUN_TEST(steady_state_of_the_reference);
    RUN_TEST(understeer_gradients_as_in_3_20_and_3_27_to_3_29);
    RUN_TEST(a_trailer_with_one_axle);
    RUN_TEST(a_car_without_trailer);
    RUN_TEST(speeds_outside_the_search);
    RUN_TEST(a_determinant_that_is_never_zero_is_no_limit);
    RUN_TEST(the_closed_form_limit_is_the_first_change_of_stability);
    RUN_TEST(relaxation_lowers_the_critical_speed);
    RUN_TEST(at_low_speed_only_the_slow_root_can_be_unstable);
    RUN_TEST(what_has_no_answer_is_singular);
    RUN_TEST(an_axle_without_stiffness_has_no_lag);
    RUN_TEST(a_vehicle_that_is_not_whole_has_no_model);
    RUN_TEST(an_axle_without_stiffness_has_no_critical_speed);
    RUN_TEST(a_vehicle_out_of_range_is_named);
    RUN_TEST(the_dominant_root_is_the_least_damped_oscillation);
    RUN_TEST(a_model_of_a_vehicle_has_no_lag_whatever_was_in_its_memory);
    return UNITY_END();
}

/* Phasors against numbers: the value of every operation, and its slope in every source. */
#include "model/sway_phasor.h"
#include "sway_test.h"
#include "unity.h"

static double complex amplitude[SWAY_ORIGIN_COUNT];

void setUp(void)
{
    for (int i = 0; i < SWAY_ORIGIN_COUNT; i++) {
        amplitude[i] = (1 + 0.3 * i) * cexp(I * (0.4 + 0.7 * i));
    }
}

void tearDown(void)
{
}

static sway_phasor_t source(int i)
{
    return sway_phasor_measured(complex_of(amplitude[i]), (sway_origin_t)i);
}

typedef enum { ADD, ADD_SCALED, SCALE, MULTIPLY, DIVIDE, DIVIDE_BY_ITSELF, OPERATIONS } operation_t;

/* ((x0 + x1) ... ) in numbers: f of all sources, each operation on operands of several sources. */
static double complex number(operation_t operation)
{
    double complex a = amplitude[0], b = amplitude[1];
    for (int i = 2; i < SWAY_ORIGIN_COUNT; i++) {
        *(i % 2 ? &a : &b) += amplitude[i];
    }
    b += a; /* sources that are in both operands */
    switch (operation) {
    case ADD:
        return a + b;
    case ADD_SCALED:
        return a + 0.37 * b;
    case SCALE:
        return -2.5 * b;
    case MULTIPLY:
        return a * b;
    case DIVIDE:
        return a / b;
    default:
        return a / a;
    }
}

static sway_phasor_t phasor(operation_t operation)
{
    sway_phasor_t a = source(0), b = source(1);
    for (int i = 2; i < SWAY_ORIGIN_COUNT; i++) {
        const sway_phasor_t x = source(i);
        sway_phasor_add(i % 2 ? &a : &b, &x);
    }
    sway_phasor_add(&b, &a);
    switch (operation) {
    case ADD:
        sway_phasor_add(&a, &b);
        return a;
    case ADD_SCALED:
        sway_phasor_add_scaled(&a, &b, real(0.37));
        return a;
    case SCALE:
        sway_phasor_scale(&b, real(-2.5));
        return b;
    case MULTIPLY:
        sway_phasor_multiply(&a, &b);
        return a;
    case DIVIDE:
        sway_phasor_divide(&a, &b);
        return a;
    default:
        b = a;
        sway_phasor_divide(&a, &b);
        return a;
    }
}

static void expect_near(double complex expected, sway_complex_t found, double tolerance)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, creal(expected), creal(cvalue(found)));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, cimag(expected), cimag(cvalue(found)));
}

static void every_operation_has_its_value_and_its_slopes(void)
{
    const double h = 1e-6;
    for (int operation = 0; operation < OPERATIONS; operation++) {
        const sway_phasor_t found = phasor((operation_t)operation);
        TEST_ASSERT_TRUE(found.known);
        expect_near(number((operation_t)operation), found.value, 1e-6);
        for (int i = 0; i < SWAY_ORIGIN_COUNT; i++) {
            amplitude[i] += h;
            const double complex above = number((operation_t)operation);
            amplitude[i] -= 2 * h;
            const double complex below = number((operation_t)operation);
            amplitude[i] += h;
            expect_near((above - below) / (2 * h), found.slope[i], 1e-5);
        }
    }
}

static void a_source_has_slope_one_in_itself_and_a_constant_none(void)
{
    for (int i = 0; i < SWAY_ORIGIN_COUNT; i++) {
        const sway_phasor_t x = source(i);
        const sway_phasor_t c = sway_phasor_constant(complex_of(amplitude[i]));
        for (int k = 0; k < SWAY_ORIGIN_COUNT; k++) {
            expect_near(i == k, x.slope[k], 0);
            expect_near(0, c.slope[k], 0);
        }
        expect_near(amplitude[i], x.value, 1e-7);
        expect_near(amplitude[i], c.value, 1e-7);
        TEST_ASSERT_TRUE(x.known && c.known);
    }
}

/* Root of the sum of |slope|^2 times variance: 2 a + 3 b with errors 0.5 and 0.25. */
static void errors_add_by_their_squares(void)
{
    for (int i = 0; i < SWAY_ORIGIN_COUNT; i++) {
        for (int k = 0; k < SWAY_ORIGIN_COUNT; k++) {
            if (k == i) {
                continue;
            }
            sway_sources_t sources;
            for (int n = 0; n < SWAY_ORIGIN_COUNT; n++) {
                sources.variance[n] = real(n == i ? 0.25 : (n == k ? 0.0625 : 100));
            }
            sway_phasor_t a = source(i);
            const sway_phasor_t b = source(k);
            sway_phasor_scale(&a, real(-2));
            sway_phasor_add_scaled(&a, &b, real(3));
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, hypot(2 * 0.5, 3 * 0.25),
                                      value(sway_phasor_se(&a, &sources)));
        }
    }
    const sway_phasor_t constant = sway_phasor_constant(complex_of(5));
    sway_sources_t sources;
    for (int n = 0; n < SWAY_ORIGIN_COUNT; n++) {
        sources.variance[n] = real(100);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0, 0, value(sway_phasor_se(&constant, &sources)));
}

static void what_is_made_of_something_unknown_is_unknown(void)
{
    void (*const operations[])(sway_phasor_t *, const sway_phasor_t *) = {
        sway_phasor_add, sway_phasor_multiply, sway_phasor_divide};
    for (size_t i = 0; i < sizeof operations / sizeof operations[0]; i++) {
        for (int given = 0; given < 4; given++) {
            sway_phasor_t a = source(1), b = source(2);
            a.known = (given & 1) != 0;
            b.known = (given & 2) != 0;
            operations[i](&a, &b);
            TEST_ASSERT_EQUAL(given == 3, a.known);
        }
    }
    TEST_ASSERT_FALSE(sway_phasor_unknown().known);
    sway_phasor_t a = source(1);
    const sway_phasor_t zero = sway_phasor_constant(complex_of(0));
    sway_phasor_divide(&a, &zero);
    TEST_ASSERT_FALSE(a.known);
    a = source(1);
    const sway_phasor_t imaginary = sway_phasor_constant(complex_of(2 * I)); /* not zero */
    sway_phasor_divide(&a, &imaginary);
    TEST_ASSERT_TRUE(a.known);
    expect_near(amplitude[1] / (2 * I), a.value, 1e-6);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_operation_has_its_value_and_its_slopes);
    RUN_TEST(a_source_has_slope_one_in_itself_and_a_constant_none);
    RUN_TEST(errors_add_by_their_squares);
    RUN_TEST(what_is_made_of_something_unknown_is_unknown);
    return UNITY_END();
}

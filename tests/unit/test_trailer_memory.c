/* A trailer remembered from drive to drive: what is recalled, and whether it is the same as last
 * time. */
#include "model/sway_trailer.h"
#include "sway_test.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static sway_trailer_watch_t watch;

void setUp(void)
{
    vehicle = reference_vehicle();
    memset(&watch, 0, sizeof watch);
}

void tearDown(void)
{
}

enum { KEPT = SWAY_TRAILER_MEMORY, CAR = SWAY_TRAILER_CAR };

static uint32_t kept_state(uint32_t i)
{
    return i < CAR ? SWAY_STATE_CAR_FRONT + i : SWAY_STATE_TRAILER_MASS + i - CAR;
}

/* A memory with covariances of all with all, values off the start by some of its errors. */
static sway_trailer_memory_t made_memory(double scale, double off)
{
    sway_trailer_memory_t memory;
    sway_trailer_remember(&watch, &memory);
    double error[KEPT];
    for (int i = 0; i < KEPT; i++) {
        error[i] = sqrt(value(memory.covariance[i * (i + 1) / 2 + i]));
    }
    for (int i = 0; i < KEPT; i++) {
        memory.value[i] = real(value(memory.value[i]) + off * error[i] * sin(1 + 2 * i));
        for (int j = 0; j <= i; j++) {
            memory.covariance[i * (i + 1) / 2 + j] =
                real(scale * error[i] * error[j] * (i == j ? 1 : 0.08 * cos(i + 3 * j)));
        }
    }
    return memory;
}

static void a_recalled_car_is_that_of_the_memory(void)
{
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    const sway_trailer_watch_t before = watch;
    const sway_trailer_memory_t memory = made_memory(0.5, 1);
    sway_trailer_recall(&watch, &memory);
    for (int which = 0; which < 2; which++) {
        const sway_observer_t *const now = which == 0 ? &watch.alone : &watch.with;
        for (uint32_t i = 0; i < CAR; i++) {
            TEST_ASSERT_EQUAL_DOUBLE(value(memory.value[i]), value(now->x[kept_state(i)]));
            for (uint32_t j = 0; j <= i; j++) {
                TEST_ASSERT_EQUAL_DOUBLE(
                    value(memory.covariance[i * (i + 1) / 2 + j]),
                    value(sway_observer_covariance(now, kept_state(i), kept_state(j))));
            }
        }
    }
    for (uint32_t i = CAR; i < KEPT; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(value(before.with.x[kept_state(i)]),
                                 value(watch.with.x[kept_state(i)]));
    }
}

/* Adds sign times the inverse of a covariance, and that times the mean; what is returned is
 * log det + mean' inverse mean. */
static double add_information(double sum[KEPT][KEPT], double towards[KEPT],
                              double covariance[KEPT][KEPT], const double *mean, double sign)
{
    double m[KEPT][2 * KEPT] = {{0}};
    double result = 0;
    for (int i = 0; i < KEPT; i++) {
        for (int j = 0; j < KEPT; j++) {
            m[i][j] = covariance[i][j];
        }
        m[i][KEPT + i] = 1;
    }
    for (int k = 0; k < KEPT; k++) {
        const double pivot = m[k][k];
        result += log(pivot);
        for (int j = 0; j < 2 * KEPT; j++) {
            m[k][j] /= pivot;
        }
        for (int i = 0; i < KEPT; i++) {
            const double factor = i == k ? 0 : m[i][k];
            for (int j = 0; j < 2 * KEPT; j++) {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    for (int i = 0; i < KEPT; i++) {
        for (int j = 0; j < KEPT; j++) {
            sum[i][j] += sign * m[i][KEPT + j];
            towards[i] += sign * m[i][KEPT + j] * mean[j];
            result += mean[i] * m[i][KEPT + j] * mean[j];
        }
    }
    return result;
}

static void unpack(const sway_trailer_memory_t *memory, double covariance[KEPT][KEPT],
                   double mean[KEPT])
{
    for (int i = 0; i < KEPT; i++) {
        mean[i] = value(memory->value[i]) - value(watch.with.x[kept_state((uint32_t)i)]);
        for (int j = 0; j <= i; j++) {
            covariance[i][j] = value(memory->covariance[i * (i + 1) / 2 + j]);
            covariance[j][i] = covariance[i][j];
        }
    }
}

/* Logarithm of the integral of now times memory by start, all normal: in double precision. */
static double expected_likeness(const sway_trailer_memory_t *memory)
{
    double inverse[KEPT][KEPT] = {{0}}, unused[KEPT][KEPT] = {{0}}, towards[KEPT] = {0};
    double covariance[KEPT][KEPT], mean[KEPT], none[KEPT] = {0};
    sway_trailer_memory_t now;
    sway_trailer_remember(&watch, &now);
    unpack(&now, covariance, mean);
    double sum = -add_information(inverse, towards, covariance, mean, 1);
    unpack(memory, covariance, mean);
    sum -= add_information(inverse, towards, covariance, mean, 1);
    for (int i = CAR; i < KEPT; i++) {
        for (int j = 0; j < i; j++) {
            covariance[i][j] = covariance[j][i] = 0;
        }
        covariance[i][i] = pow(value(watch.start_error[i - CAR]), 2);
        mean[i] = value(watch.start[i - CAR]) - value(watch.with.x[kept_state((uint32_t)i)]);
    }
    sum += add_information(inverse, towards, covariance, mean, -1);
    const double both = add_information(unused, none, inverse, towards, 1);
    /* log det + t' inverse t, of which the first is taken off. */
    double quadratic = 0;
    for (int i = 0; i < KEPT; i++) {
        quadratic += none[i] * towards[i];
    }
    return (sum - (both - quadratic) + quadratic) / 2;
}

static void a_likeness_is_the_logarithm_of_the_integral(void)
{
    static const double share[3] = {0.5, 0.25, 0.7};
    static const double off[3] = {0.5, 0.2, 1.5};
    for (int c = 0; c < 3; c++) {
        sway_trailer_init(&watch, &vehicle, 0, 10000);
        const sway_trailer_memory_t memory = made_memory(share[c], off[c]);
        const sway_trailer_memory_t now = made_memory(0.4, -0.3);
        for (uint32_t i = 0; i < KEPT; i++) {
            watch.with.x[kept_state(i)] = now.value[i];
            for (uint32_t j = 0; j <= i; j++) {
                const uint32_t high = kept_state(i);
                watch.with.p[high * (high + 1) / 2 + kept_state(j)] =
                    now.covariance[i * (i + 1) / 2 + j];
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, expected_likeness(&memory),
                                  value(sway_trailer_likeness(&watch, &memory)));
    }
}

/* Of now, of the memory, of the start, of their sum: whatever is no covariance, nothing is
 * reported. */
static void a_likeness_by_a_covariance_that_is_none_is_not_reported(void)
{
    sway_trailer_memory_t memory;
    sway_trailer_memory_t sound;
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    sway_trailer_remember(&watch, &sound);
    memory = sound;
    for (uint32_t i = 0; i < SWAY_TRAILER_TRIANGLE; i++) {
        memory.covariance[i] = sway_real_int(-1);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &memory)));
    memory = sound; // both know far less of the trailer than the start
    for (uint32_t i = 0; i < SWAY_TRAILER_TRIANGLE; i++) {
        memory.covariance[i] = sway_real_scale(memory.covariance[i], 4);
    }
    for (int i = 0; i < SWAY_OBSERVER_TRIANGLE; i++) {
        watch.with.p[i] = sway_real_scale(watch.with.p[i], 4);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &memory)));
    sway_trailer_init(&watch, &vehicle, 0, 10000);
    watch.start_error[2] = sway_real_zero();
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &sound)));
    for (int i = 0; i < SWAY_OBSERVER_TRIANGLE; i++) {
        watch.with.p[i] = sway_real_int(-1);
    }
    TEST_ASSERT_TRUE(sway_real_is_zero(sway_trailer_likeness(&watch, &sound)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_recalled_car_is_that_of_the_memory);
    RUN_TEST(a_likeness_is_the_logarithm_of_the_integral);
    RUN_TEST(a_likeness_by_a_covariance_that_is_none_is_not_reported);
    return UNITY_END();
}

/* Ranges of the user's vehicle data: both ends of each, zero, and what must fit together. */
#include <string.h>

#include "sway_vehicle.h"
#include "unity.h"

static sway_vehicle_t vehicle;
static const sway_vehicle_range_t *offender;

/* A combination whose lengths fit together at both ends of every range. */
void setUp(void)
{
    vehicle = (sway_vehicle_t){
        {1955000, 2690000, 1302000, 1383000, 2166000, 109300, 185200, 0, 0, 15000, -1383000},
        {2, 1880000, 10350000, 124000, 526000, 5073000, 131200, 124400, 0, 0, 0},
    };
    offender = NULL;
}

void tearDown(void)
{
}

/* Ends in SI units. */
static const struct {
    const char *name;
    double low, high;
    int32_t scale;
    bool may_be_zero;
} ranges[] = {
    {"car.mass", 300, 60000, 1000, false},
    {"car.yaw_inertia", 100, 1000000, 1000, true},
    {"car.front_axle_to_cog", 0.1, 10, 1000000, false},
    {"car.rear_axle_to_cog", 0.1, 10, 1000000, false},
    {"car.hitch_to_cog", 0.1, 15, 1000000, true},
    {"car.front_cornering_stiffness", 1000, 2000000, 1, true},
    {"car.rear_cornering_stiffness", 1000, 2000000, 1, true},
    {"car.front_axle_load", 100, 500000, 1000, true},
    {"car.rear_axle_load", 100, 500000, 1000, true},
    {"car.steering_ratio", 1, 60, 1000, false},
    {"car.lateral_acceleration_position", -15, 15, 1000000, true},
    {"trailer.axles", 0, 2, 1, true},
    {"trailer.mass", 50, 60000, 1000, false},
    {"trailer.yaw_inertia", 10, 2000000, 1000, false},
    {"trailer.front_axle_to_cog", -10, 10, 1000000, true},
    {"trailer.rear_axle_to_cog", -10, 10, 1000000, true},
    {"trailer.hitch_to_cog", 0.5, 15, 1000000, false},
    {"trailer.front_cornering_stiffness", 1000, 2000000, 1, true},
    {"trailer.rear_cornering_stiffness", 1000, 2000000, 1, true},
    {"trailer.front_axle_load", 100, 500000, 1000, true},
    {"trailer.rear_axle_load", 100, 500000, 1000, true},
    {"trailer.lateral_acceleration_position", -15, 15, 1000000, true},
};

static void set(const sway_vehicle_range_t *range, int64_t value)
{
    const int32_t small = (int32_t)value;
    memcpy((char *)&vehicle + range->offset, &small, sizeof small);
    TEST_ASSERT_EQUAL_INT32(small, sway_vehicle_value(&vehicle, range));
}

/* Is this value of one field allowed? The wheelbase, which has no entry of its own, is kept. */
static bool allowed(const sway_vehicle_range_t *range, int64_t value)
{
    setUp();
    if (strcmp(sway_vehicle_name(range)->key, "trailer.front_axle_to_cog") == 0) {
        vehicle.trailer.rear_axle_to_cog_um = value < 0 ? 10000000 : 526000;
        vehicle.trailer.front_axle_to_cog_um = 1000000;
    } else if (strcmp(sway_vehicle_name(range)->key, "trailer.rear_axle_to_cog") == 0) {
        vehicle.trailer.front_axle_to_cog_um = 10000000;
        vehicle.trailer.hitch_to_cog_um = 15000000;
    }
    set(range, value);
    const sway_error_t error = sway_vehicle_check(&vehicle, &offender);
    TEST_ASSERT_EQUAL(error != SWAY_OK, offender != NULL);
    if (offender != NULL) {
        TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, error);
        TEST_ASSERT_EQUAL_STRING(sway_vehicle_name(range)->key, sway_vehicle_name(offender)->key);
    }
    return error == SWAY_OK;
}

static void both_ends_of_every_range_are_allowed_and_no_more(void)
{
    size_t count;
    const sway_vehicle_range_t *table = sway_vehicle_ranges(&count);
    TEST_ASSERT_EQUAL(sizeof ranges / sizeof ranges[0], count);
    for (size_t i = 0; i < count; i++) {
        const double scale = ranges[i].scale;
        const int64_t low = (int64_t)(ranges[i].low * scale + (ranges[i].low < 0 ? -0.5 : 0.5));
        const int64_t high = (int64_t)(ranges[i].high * scale + 0.5);
        const bool has_base =
            strstr(sway_vehicle_name(&table[i])->key, "trailer.front_axle_to") != NULL ||
            strstr(sway_vehicle_name(&table[i])->key, "trailer.rear_axle_to") != NULL;
        TEST_ASSERT_EQUAL_STRING(ranges[i].name, sway_vehicle_name(&table[i])->key);
        TEST_ASSERT_EQUAL_INT32(ranges[i].scale, sway_vehicle_name(&table[i])->scale);
        TEST_ASSERT_EQUAL(ranges[i].may_be_zero, table[i].may_be_zero);
        TEST_ASSERT_FALSE(allowed(&table[i], low - 1));
        TEST_ASSERT_FALSE(allowed(&table[i], high + 1));
        TEST_ASSERT_FALSE(allowed(&table[i], INT32_MIN));
        TEST_ASSERT_FALSE(allowed(&table[i], INT32_MAX));
        TEST_ASSERT_TRUE(allowed(&table[i], high));
        TEST_ASSERT_EQUAL_INT32(low, table[i].low);
        if (!has_base) { /* at its low end there would be no wheelbase */
            TEST_ASSERT_TRUE(allowed(&table[i], low));
        }
        if (low > 0) {
            TEST_ASSERT_EQUAL(ranges[i].may_be_zero, allowed(&table[i], 0));
            TEST_ASSERT_FALSE(allowed(&table[i], -low));
        } else {
            TEST_ASSERT_TRUE(allowed(&table[i], 0));
        }
    }
}

static void every_field_has_its_own_range(void)
{
    size_t count;
    const sway_vehicle_range_t *table = sway_vehicle_ranges(&count);
    TEST_ASSERT_EQUAL(sizeof vehicle / sizeof(int32_t), count);
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL(i * sizeof(int32_t), table[i].offset);
    }
}

/* Without a trailer its fields do not count; an axle too many is reported before all else. */
static void fields_of_no_trailer_are_ignored(void)
{
    vehicle.trailer.axles = 0;
    vehicle.trailer.mass_g = 0;
    vehicle.trailer.rear_axle_to_cog_um = INT32_MIN;
    TEST_ASSERT_EQUAL(SWAY_OK, sway_vehicle_check(&vehicle, &offender));
    TEST_ASSERT_NULL(offender);
    vehicle.car.mass_g = 0;
    vehicle.trailer.axles = 3;
    TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, sway_vehicle_check(&vehicle, &offender));
    TEST_ASSERT_EQUAL_STRING("trailer.axles", sway_vehicle_name(offender)->key);
    vehicle.trailer.axles = 2;
    TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, sway_vehicle_check(&vehicle, &offender));
    TEST_ASSERT_EQUAL_STRING("car.mass", sway_vehicle_name(offender)->key);
}

static sway_error_t lengths(int32_t axles, int32_t front_um, int32_t rear_um, int32_t hitch_um)
{
    setUp();
    vehicle.trailer.axles = axles;
    vehicle.trailer.front_axle_to_cog_um = front_um;
    vehicle.trailer.rear_axle_to_cog_um = rear_um;
    vehicle.trailer.hitch_to_cog_um = hitch_um;
    const sway_error_t error = sway_vehicle_check(&vehicle, &offender);
    if (error != SWAY_OK) {
        TEST_ASSERT_EQUAL_STRING("trailer.rear_axle_to_cog", sway_vehicle_name(offender)->key);
    }
    return error;
}

/* 0.1 m between two axles, 0.5 m from the hitch to the rear one. */
static void lengths_must_fit_together(void)
{
    TEST_ASSERT_EQUAL(SWAY_OK, lengths(2, 600000, -500000, 5000000));
    TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, lengths(2, 600000, -500001, 5000000));
    TEST_ASSERT_EQUAL(SWAY_OK, lengths(1, 600000, -500001, 5000000)); /* of one axle: no base */
    for (int32_t axles = 1; axles <= 2; axles++) {
        TEST_ASSERT_EQUAL(SWAY_OK, lengths(axles, 9000000, -4500000, 5000000));
        TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, lengths(axles, 9000000, -4500001, 5000000));
    }
    TEST_ASSERT_EQUAL(SWAY_OK, lengths(0, 0, -9000000, 5000000));
}

static void null_is_refused_and_the_offender_may_be(void)
{
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT, sway_vehicle_check(NULL, &offender));
    TEST_ASSERT_EQUAL(SWAY_OK, sway_vehicle_check(&vehicle, NULL));
    vehicle.car.mass_g = 0;
    TEST_ASSERT_EQUAL(SWAY_ERROR_VEHICLE, sway_vehicle_check(&vehicle, NULL));
}

/* What the single-track model needs: with each of these unknown there is none. */
static void the_model_needs_inertia_lengths_and_stiffnesses(void)
{
    static const size_t needed[] = {
        offsetof(sway_vehicle_t, car.yaw_inertia_gm2),
        offsetof(sway_vehicle_t, car.front_cornering_stiffness_n_per_rad),
        offsetof(sway_vehicle_t, car.rear_cornering_stiffness_n_per_rad),
        offsetof(sway_vehicle_t, car.hitch_to_cog_um),
        offsetof(sway_vehicle_t, trailer.rear_cornering_stiffness_n_per_rad),
        offsetof(sway_vehicle_t, trailer.front_cornering_stiffness_n_per_rad)};
    for (int32_t axles = 0; axles <= 2; axles++) {
        const size_t count = axles == 0 ? 3 : (axles == 1 ? 5 : 6);
        for (size_t i = 0; i < 6; i++) {
            setUp();
            vehicle.trailer.axles = axles;
            TEST_ASSERT_TRUE(sway_vehicle_is_complete(&vehicle));
            memset((char *)&vehicle + needed[i], 0, sizeof(int32_t));
            TEST_ASSERT_EQUAL(i >= count, sway_vehicle_is_complete(&vehicle));
        }
    }
}

/* Of a car alone the trailer's values may be anything, and are not even added up. */
static void a_car_alone_may_have_any_trailer(void)
{
    static const int32_t any[] = {INT32_MIN, INT32_MAX, 0};
    for (int i = 0; i < 3; i++) {
        vehicle.trailer.axles = 0;
        vehicle.trailer.front_axle_to_cog_um = any[i];
        vehicle.trailer.rear_axle_to_cog_um = any[i];
        vehicle.trailer.hitch_to_cog_um = any[i];
        TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_vehicle_check(&vehicle, NULL));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(both_ends_of_every_range_are_allowed_and_no_more);
    RUN_TEST(every_field_has_its_own_range);
    RUN_TEST(fields_of_no_trailer_are_ignored);
    RUN_TEST(lengths_must_fit_together);
    RUN_TEST(null_is_refused_and_the_offender_may_be);
    RUN_TEST(the_model_needs_inertia_lengths_and_stiffnesses);
    RUN_TEST(a_car_alone_may_have_any_trailer);
    return UNITY_END();
}

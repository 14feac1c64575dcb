// SPDX-License-Identifier: MIT
#include "sway_vehicle.h"

#include <string.h>

#define CAR(field) offsetof(sway_vehicle_t, car.field)
#define TRAILER(field) offsetof(sway_vehicle_t, trailer.field)
#define TON 1000000
#define METRE 1000000
#define KGM2 1000
#define NEWTON 1000

/* key of vehicle.toml, field, lowest, highest, units in one SI unit, 0 allowed too */
#define FIELDS(ROW)                                                                                \
    ROW("car.mass", CAR(mass_g), 3 * TON / 10, 60 * TON, 1000, false)                              \
    ROW("car.yaw_inertia", CAR(yaw_inertia_gm2), 100 * KGM2, 1000000 * KGM2, KGM2, true)           \
    ROW("car.front_axle_to_cog", CAR(front_axle_to_cog_um), METRE / 10, 10 * METRE, METRE, false)  \
    ROW("car.rear_axle_to_cog", CAR(rear_axle_to_cog_um), METRE / 10, 10 * METRE, METRE, false)    \
    ROW("car.hitch_to_cog", CAR(hitch_to_cog_um), METRE / 10, 15 * METRE, METRE, true)             \
    ROW("car.front_cornering_stiffness", CAR(front_cornering_stiffness_n_per_rad), 1000, 2000000,  \
        1, true)                                                                                   \
    ROW("car.rear_cornering_stiffness", CAR(rear_cornering_stiffness_n_per_rad), 1000, 2000000, 1, \
        true)                                                                                      \
    ROW("car.front_axle_load", CAR(front_axle_load_mn), 100 * NEWTON, 500000 * NEWTON, NEWTON,     \
        true)                                                                                      \
    ROW("car.rear_axle_load", CAR(rear_axle_load_mn), 100 * NEWTON, 500000 * NEWTON, NEWTON, true) \
    ROW("car.steering_ratio", CAR(steering_ratio_milli), 1000, 60000, 1000, false)                 \
    ROW("car.lateral_acceleration_position", CAR(lateral_acc_position_um), -15 * METRE,            \
        15 * METRE, METRE, true)                                                                   \
    ROW("trailer.axles", TRAILER(axles), 0, 2, 1, true)                                            \
    ROW("trailer.mass", TRAILER(mass_g), TON / 20, 60 * TON, 1000, false)                          \
    ROW("trailer.yaw_inertia", TRAILER(yaw_inertia_gm2), 10 * KGM2, 2000000 * KGM2, KGM2, false)   \
    ROW("trailer.front_axle_to_cog", TRAILER(front_axle_to_cog_um), -10 * METRE, 10 * METRE,       \
        METRE, true)                                                                               \
    ROW("trailer.rear_axle_to_cog", TRAILER(rear_axle_to_cog_um), -10 * METRE, 10 * METRE, METRE,  \
        true)                                                                                      \
    ROW("trailer.hitch_to_cog", TRAILER(hitch_to_cog_um), METRE / 2, 15 * METRE, METRE, false)     \
    ROW("trailer.front_cornering_stiffness", TRAILER(front_cornering_stiffness_n_per_rad), 1000,   \
        2000000, 1, true)                                                                          \
    ROW("trailer.rear_cornering_stiffness", TRAILER(rear_cornering_stiffness_n_per_rad), 1000,     \
        2000000, 1, true)                                                                          \
    ROW("trailer.front_axle_load", TRAILER(front_axle_load_mn), 100 * NEWTON, 500000 * NEWTON,     \
        NEWTON, true)                                                                              \
    ROW("trailer.rear_axle_load", TRAILER(rear_axle_load_mn), 100 * NEWTON, 500000 * NEWTON,       \
        NEWTON, true)                                                                              \
    ROW("trailer.lateral_acceleration_position", TRAILER(lateral_acc_position_um), -15 * METRE,    \
        15 * METRE, METRE, true)

#define RANGE(name, offset, low, high, scale, may_be_zero)                                         \
    {low, high, (uint16_t)offset, may_be_zero},
#define NAME(name, offset, low, high, scale, may_be_zero) {name, scale},

static const sway_vehicle_range_t RANGES[] = {FIELDS(RANGE)};

enum {
    RANGE_COUNT = (int)(sizeof RANGES / sizeof RANGES[0]),
    TRAILER_AXLES = 11,
    TRAILER_REAR = 15
};

const sway_vehicle_range_t *sway_vehicle_ranges(size_t *count)
{
    *count = (size_t)RANGE_COUNT;
    return RANGES;
}

/* Only for messages to people: an ECU links neither the function nor its table. */
const sway_vehicle_name_t *sway_vehicle_name(const sway_vehicle_range_t *range)
{
    static const sway_vehicle_name_t NAMES[] = {FIELDS(NAME)};
    return &NAMES[range - RANGES];
}

int32_t sway_vehicle_value(const sway_vehicle_t *vehicle, const sway_vehicle_range_t *range)
{
    int32_t value;
    memcpy(&value, (const unsigned char *)vehicle + range->offset, sizeof value);
    return value;
}

static bool in_range(const sway_vehicle_t *vehicle, const sway_vehicle_range_t *range)
{
    const int32_t value = sway_vehicle_value(vehicle, range);
    return (value == 0 && range->may_be_zero) || (value >= range->low && value <= range->high);
}

static const sway_vehicle_range_t *find_offender(const sway_vehicle_t *vehicle)
{
    if (!in_range(vehicle, &RANGES[TRAILER_AXLES])) {
        return &RANGES[TRAILER_AXLES];
    }
    const int used = vehicle->trailer.axles == 0 ? (int)TRAILER_AXLES : (int)RANGE_COUNT;
    for (int i = 0; i < used; i++) {
        if (!in_range(vehicle, &RANGES[i])) {
            return &RANGES[i];
        }
    }
    const sway_trailer_t *const trailer = &vehicle->trailer;
    /* Of a car alone they may be anything. */
    const int64_t wheelbase_um =
        (int64_t)trailer->front_axle_to_cog_um + trailer->rear_axle_to_cog_um;
    const int64_t drawbar_um = (int64_t)trailer->hitch_to_cog_um + trailer->rear_axle_to_cog_um;
    if (trailer->axles == 2 && wheelbase_um < METRE / 10) {
        return &RANGES[TRAILER_REAR];
    }
    if (trailer->axles > 0 && drawbar_um < METRE / 2) {
        return &RANGES[TRAILER_REAR];
    }
    return NULL;
}

sway_error_t sway_vehicle_check(const sway_vehicle_t *vehicle,
                                const sway_vehicle_range_t **offender)
{
    if (vehicle == NULL) {
        return SWAY_ERROR_ARGUMENT;
    }
    const sway_vehicle_range_t *const found = find_offender(vehicle);
    if (offender != NULL) {
        *offender = found;
    }
    return found == NULL ? SWAY_OK : SWAY_ERROR_VEHICLE;
}

static bool trailer_is_complete(const sway_vehicle_t *vehicle)
{
    const sway_trailer_t *const trailer = &vehicle->trailer;
    return vehicle->car.hitch_to_cog_um != 0 && trailer->rear_cornering_stiffness_n_per_rad != 0 &&
           (trailer->axles == 1 || trailer->front_cornering_stiffness_n_per_rad != 0);
}

bool sway_vehicle_is_complete(const sway_vehicle_t *vehicle)
{
    const sway_car_t *const car = &vehicle->car;
    return car->yaw_inertia_gm2 != 0 && car->front_cornering_stiffness_n_per_rad != 0 &&
           car->rear_cornering_stiffness_n_per_rad != 0 &&
           (vehicle->trailer.axles == 0 || trailer_is_complete(vehicle));
}

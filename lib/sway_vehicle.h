// SPDX-License-Identifier: MIT
/// sway_vehicle: what the user believes of the car and its trailer.
///
/// Plain integers with their units in the names, so that one configuration is the same on every
/// target. Distances are measured from the body's centre of gravity (COG) along its own x axis.
#ifndef SWAY_VEHICLE_H
#define SWAY_VEHICLE_H

#include <stddef.h>

#include "sway_types.h"

SWAY_C_BEGIN

/// The towing car. Zero in a field marked (0: unknown) switches off what needs it.
typedef struct {
    int32_t mass_g;               ///< 300 kg .. 60 t
    int32_t yaw_inertia_gm2;      ///< 100 .. 1e6 kgm2, about the COG (0: unknown)
    int32_t front_axle_to_cog_um; ///< l_f1 > 0, axle ahead of the COG
    int32_t rear_axle_to_cog_um;  ///< l_r1 > 0, axle behind the COG
    int32_t hitch_to_cog_um;      ///< l_h1, hitch behind the COG (0: unknown, solo car)
    int32_t front_cornering_stiffness_n_per_rad; ///< of the axle, both wheels (0: unknown)
    int32_t rear_cornering_stiffness_n_per_rad;  ///< (0: unknown)
    int32_t front_axle_load_mn;                  ///< at rest (0: from the mass and the lengths)
    int32_t rear_axle_load_mn;                   ///< at rest (0: from the mass and the lengths)
    int32_t steering_ratio_milli;    ///< i_s, steering wheel to road wheel (15 -> 15000)
    int32_t lateral_acc_position_um; ///< accelerometer ahead of the COG (rear axle: -l_r1)
} sway_car_t;

/// The trailer. `axles` 0: no trailer, every other field is ignored. `axles` 1: its axle is the
/// *rear* one, the front_ fields are ignored.
typedef struct {
    int32_t axles;                               ///< 0, 1 or 2
    int32_t mass_g;                              ///< 50 kg .. 60 t
    int32_t yaw_inertia_gm2;                     ///< 10 .. 2e6 kgm2, about the COG
    int32_t front_axle_to_cog_um;                ///< l_f2, axle ahead of the COG; may be negative
    int32_t rear_axle_to_cog_um;                 ///< l_r2, axle behind the COG; may be negative
    int32_t hitch_to_cog_um;                     ///< l_h2 > 0, hitch ahead of the COG
    int32_t front_cornering_stiffness_n_per_rad; ///< (0: unknown)
    int32_t rear_cornering_stiffness_n_per_rad;  ///< (0: unknown)
    int32_t front_axle_load_mn;                  ///< (0: from the mass and the lengths)
    int32_t rear_axle_load_mn;
    int32_t lateral_acc_position_um; ///< accelerometer ahead of the COG
} sway_trailer_t;

typedef struct {
    sway_car_t car;
    sway_trailer_t trailer;
} sway_vehicle_t;

/// Allowed range of one field.
typedef struct {
    int32_t low;
    int32_t high;
    uint16_t offset;  ///< of the int32_t in sway_vehicle_t
    bool may_be_zero; ///< 0 (unknown) is allowed besides [low, high]
} sway_vehicle_range_t;

/// What people call that field.
typedef struct {
    const char *key; ///< of vehicle.toml: "trailer.mass"
    int32_t scale;   ///< integer units in one SI unit (mass_g: 1000)
} sway_vehicle_name_t;

/// The table of ranges and its length; car first, then trailer.
const sway_vehicle_range_t *sway_vehicle_ranges(size_t *count);

/// The name of an entry of that table.
const sway_vehicle_name_t *sway_vehicle_name(const sway_vehicle_range_t *range);

/// SWAY_OK, or SWAY_ERROR_VEHICLE with `*offender` (may be NULL) pointing at the range that is
/// violated. Beyond the single ranges: axle distances must add up to a positive wheelbase. For a
/// wheelbase that does not, the offender is the rear axle's distance.
sway_error_t sway_vehicle_check(const sway_vehicle_t *vehicle,
                                const sway_vehicle_range_t **offender);

/// The value of a field by its range entry.
int32_t sway_vehicle_value(const sway_vehicle_t *vehicle, const sway_vehicle_range_t *range);

/// True where all fields are known that the single-track model needs (inertias, lengths,
/// stiffnesses of the axles there are).
bool sway_vehicle_is_complete(const sway_vehicle_t *vehicle);

SWAY_C_END

#endif

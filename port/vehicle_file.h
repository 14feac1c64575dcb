/// vehicle_file: vehicle.toml into the integers of the core, for programs on a host.
///
/// The part of TOML that such a file needs: tables [car] and [trailer], `key = number`, comments.
/// Keys and units (SI) are those of sway_vehicle_ranges(); besides the ones of the Python tools,
/// `lateral_acceleration_position` (m ahead of the centre of gravity) says where an accelerometer
/// sits. A [trailer] without front_axle_to_cog has one axle.
#ifndef SWAY_VEHICLE_FILE_H
#define SWAY_VEHICLE_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "sway_vehicle.h"

/// Reads `path`, then takes `setting_count` settings "car.lateral_acceleration_position=-1.383"
/// that win over it, and checks the whole. False: `message` (of `size` bytes) names file, line or
/// key, value, and what would be right; `vehicle` is unchanged then.
bool vehicle_file_read(const char *path, char *const *settings, size_t setting_count,
                       sway_vehicle_t *vehicle, char *message, size_t size);

#endif

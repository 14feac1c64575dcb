// SPDX-License-Identifier: MIT
/// sway_types: the words that all parts of swaywatch share.
///
/// Axes are ISO 8855: x forward, y left, z up; yaw, steering and lateral force positive left.
/// Articulation is psi_trailer - psi_car. Hitch forces are those of the trailer on the car.
#ifndef SWAY_TYPES_H
#define SWAY_TYPES_H

#include <stdbool.h>
#include <stdint.h>

#include "sway_config.h"
#include "sway_version.h"

/// Result of every function that can refuse its input. Negative values are refusals; nothing was
/// changed then.
typedef enum {
    SWAY_OK = 0,
    SWAY_ERROR_ARGUMENT = -1,   ///< a null pointer or a value outside its documented range
    SWAY_ERROR_RANGE = -2,      ///< a sample outside the range of its input
    SWAY_ERROR_TIME = -3,       ///< a timestamp before the last one of the same input
    SWAY_ERROR_NO_DATA = -4,    ///< not enough valid samples yet
    SWAY_ERROR_SINGULAR = -5,   ///< equations without a solution
    SWAY_ERROR_VEHICLE = -6,    ///< a vehicle parameter outside its range
    SWAY_ERROR_SPEED = -7,      ///< speed below 30 km/h, or unknown
    SWAY_ERROR_FRAME = -8,      ///< wrong length, CRC or counter of a frame
    SWAY_ERROR_UNKNOWN_ID = -9, ///< a CAN identifier that is not ours
} sway_error_t;

/// What comes in: one physical signal each, sampled whenever its message arrives.
/// Angles in microradian, yaw rates in microradian/s, accelerations in micrometre/s2,
/// forces in millinewton, speed in millimetre/s.
typedef enum {
    SWAY_INPUT_STEERING_WHEEL_ANGLE, ///< urad, +-12.6e6 (two turns)
    SWAY_INPUT_CAR_YAW_RATE,         ///< urad/s, +-5.3e6 (300 deg/s)
    SWAY_INPUT_CAR_LATERAL_ACC,      ///< um/s2, +-40e6; at the position in the vehicle data
    SWAY_INPUT_TRAILER_YAW_RATE,     ///< urad/s, +-5.3e6
    SWAY_INPUT_TRAILER_LATERAL_ACC,  ///< um/s2, +-40e6; trailer axes
    SWAY_INPUT_ARTICULATION,         ///< urad, +-1.6e6
    SWAY_INPUT_HITCH_FX,             ///< mN, +-50e6; car axes, positive forward
    SWAY_INPUT_HITCH_FY,             ///< mN, +-50e6; car axes, positive left
    SWAY_INPUT_CAR_FY_FL,            ///< mN, +-50e6; wheel axes. Left and right are added
    SWAY_INPUT_CAR_FY_FR,            ///<   to one channel per axle
    SWAY_INPUT_CAR_FY_RL,
    SWAY_INPUT_CAR_FY_RR,
    SWAY_INPUT_CAR_FZ_FL, ///< mN, 0..50e6; road on wheel, positive up
    SWAY_INPUT_CAR_FZ_FR,
    SWAY_INPUT_CAR_FZ_RL,
    SWAY_INPUT_CAR_FZ_RR,
    SWAY_INPUT_TRAILER_FY_FL, ///< mN; front axle of the trailer; the only one of a single-axle
    SWAY_INPUT_TRAILER_FY_FR, ///<   trailer is its rear axle
    SWAY_INPUT_TRAILER_FY_RL,
    SWAY_INPUT_TRAILER_FY_RR,
    SWAY_INPUT_TRAILER_FZ_FL,
    SWAY_INPUT_TRAILER_FZ_FR,
    SWAY_INPUT_TRAILER_FZ_RL,
    SWAY_INPUT_TRAILER_FZ_RR,
    SWAY_INPUT_SPEED, ///< mm/s, 0..120000
    SWAY_INPUT_COUNT
} sway_input_t;

/// What the estimator works on: one evenly sampled row each, in the units of the inputs.
typedef enum {
    SWAY_CHANNEL_STEERING_WHEEL_ANGLE,
    SWAY_CHANNEL_CAR_YAW_RATE,
    SWAY_CHANNEL_CAR_LATERAL_ACC,
    SWAY_CHANNEL_TRAILER_YAW_RATE,
    SWAY_CHANNEL_TRAILER_LATERAL_ACC,
    SWAY_CHANNEL_ARTICULATION,
    SWAY_CHANNEL_HITCH_FX,
    SWAY_CHANNEL_HITCH_FY,
    SWAY_CHANNEL_CAR_FRONT_FY,
    SWAY_CHANNEL_CAR_REAR_FY,
    SWAY_CHANNEL_CAR_FRONT_FZ,
    SWAY_CHANNEL_CAR_REAR_FZ,
    SWAY_CHANNEL_TRAILER_FRONT_FY,
    SWAY_CHANNEL_TRAILER_REAR_FY,
    SWAY_CHANNEL_TRAILER_FRONT_FZ,
    SWAY_CHANNEL_TRAILER_REAR_FZ,
    SWAY_CHANNEL_COUNT,                     ///< those before it have rings and lines
    SWAY_CHANNEL_SPEED = SWAY_CHANNEL_COUNT ///< kept as mean and slope over the window
} sway_channel_t;

/// Inputs that the build keeps, at a place each: those of its channels in their order, the speed
/// last. With all channels the place of an input is its number.
#if SWAY_CHANNELS <= 8
#define SWAY_INPUT_PLACES (SWAY_CHANNELS + 1U)
#else
#define SWAY_INPUT_PLACES (2U * SWAY_CHANNELS - 7U)
#endif
#define SWAY_PLACE_OF_SPEED (SWAY_INPUT_PLACES - 1U)

/// Place of an input; SWAY_INPUT_PLACES for one that the build does not keep.
SWAY_INLINE uint32_t sway_input_place(sway_input_t input)
{
    const uint32_t number = (uint32_t)input;
    const uint32_t place = number < SWAY_PLACE_OF_SPEED ? number : SWAY_INPUT_PLACES;
    return input == SWAY_INPUT_SPEED ? SWAY_PLACE_OF_SPEED : place;
}

/// Bit of a channel in a mask.
#define SWAY_CHANNEL_BIT(channel) ((uint32_t)1U << (uint32_t)(channel))

/// The four axles, from the front of the car to the rear of the trailer.
typedef enum {
    SWAY_AXLE_CAR_FRONT,
    SWAY_AXLE_CAR_REAR,
    SWAY_AXLE_TRAILER_FRONT,
    SWAY_AXLE_TRAILER_REAR,
    SWAY_AXLE_COUNT
} sway_axle_t;

#endif

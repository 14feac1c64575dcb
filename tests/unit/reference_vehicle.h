/* The reference combination of the tests: a car and a trailer of two axles, the accelerometer of
 * the car over its rear axle, that of the trailer at its centre of gravity. */
#ifndef SWAY_REFERENCE_VEHICLE_H
#define SWAY_REFERENCE_VEHICLE_H

#include "sway_vehicle.h"

static inline sway_vehicle_t reference_vehicle(void)
{
    const sway_vehicle_t vehicle = {.car = {.mass_g = 1955000,
                                            .yaw_inertia_gm2 = 2690000,
                                            .front_axle_to_cog_um = 1302000,
                                            .rear_axle_to_cog_um = 1383000,
                                            .hitch_to_cog_um = 2166000,
                                            .front_cornering_stiffness_n_per_rad = 109300,
                                            .rear_cornering_stiffness_n_per_rad = 185200,
                                            .steering_ratio_milli = 15000,
                                            .lateral_acc_position_um = -1383000},
                                    .trailer = {.axles = 2,
                                                .mass_g = 1880000,
                                                .yaw_inertia_gm2 = 10350000,
                                                .front_axle_to_cog_um = 124000,
                                                .rear_axle_to_cog_um = 526000,
                                                .hitch_to_cog_um = 5073000,
                                                .front_cornering_stiffness_n_per_rad = 131200,
                                                .rear_cornering_stiffness_n_per_rad = 124400}};
    return vehicle;
}

#endif

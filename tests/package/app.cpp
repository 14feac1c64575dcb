// A C++ program that uses the core as its README says.
#include <cstdio>

#include "sway_ecu.h"
#include "sway_node.h"
#include "sway_version.h"

static_assert(SWAY_VERSION >= SWAY_VERSION_OF(0, 1, 0), "version macros work in a #if and here");

static sway_node_t node;

int main()
{
    sway_core_config_t config;
    sway_core_defaults(&config);
    config.vehicle.car.mass_g = 1955000;
    config.vehicle.car.yaw_inertia_gm2 = 2690000;
    config.vehicle.car.front_axle_to_cog_um = 1302000;
    config.vehicle.car.rear_axle_to_cog_um = 1383000;
    config.vehicle.car.hitch_to_cog_um = 2166000;
    config.vehicle.car.front_cornering_stiffness_n_per_rad = 109300;
    config.vehicle.car.rear_cornering_stiffness_n_per_rad = 185200;
    config.vehicle.car.steering_ratio_milli = 15000;
    config.vehicle.trailer.axles = 1;
    config.vehicle.trailer.mass_g = 1500000;
    config.vehicle.trailer.yaw_inertia_gm2 = 6000000;
    config.vehicle.trailer.rear_axle_to_cog_um = 200000;
    config.vehicle.trailer.hitch_to_cog_um = 4500000;
    config.vehicle.trailer.rear_cornering_stiffness_n_per_rad = 110000;
    if (sway_node_init(&node, &config) != SWAY_OK) {
        return 1;
    }
    const uint8_t frame[8] = {0};
    (void)sway_node_receive(&node, 10000, 0x120, 8, frame);
    while (sway_node_run(&node)) {
    }
    std::printf("swaywatch %d.%d.%d: %u bytes\n", SWAY_VERSION_MAJOR, SWAY_VERSION_MINOR,
                SWAY_VERSION_PATCH, (unsigned)sizeof node);
    return sway_node_fault(&node, SWAY_FRAME_FAULT_CRC) == 1 ? 0 : 2;
}

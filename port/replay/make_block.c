/* make_block VEHICLE.TOML BLOCK [sample_period_us=N] [KEY=VALUE ...]: the parameter block for an
 * ECU's flash.
 *
 * The vehicle (see vehicle_file.h; a KEY=VALUE wins over the file) and the defaults for all that is
 * not of the vehicle, checked as the ECU will check them. Runs on the host. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sway_block.h"
#include "vehicle_file.h"

#define PERIOD "sample_period_us="

static int refuse(const char *what, const char *why)
{
    fprintf(stderr, "make_block: %s%s%s\n", what, why[0] == '\0' ? "" : ": ", why);
    return 1;
}

int main(int argc, char **argv)
{
    char message[256];
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_core_config_t config;
    if (argc < 3) {
        return refuse("wanted VEHICLE.TOML BLOCK [sample_period_us=N] [KEY=VALUE ...]", "");
    }
    sway_core_defaults(&config);
    int first = 3;
    if (argc > first && strncmp(argv[first], PERIOD, sizeof PERIOD - 1U) == 0) {
        config.sample_period_us = (int32_t)strtol(argv[first] + sizeof PERIOD - 1U, NULL, 10);
        if (config.sample_period_us < 5000 || config.sample_period_us > 20000) {
            return refuse(argv[first], "5000 to 20000");
        }
        first++;
    }
    if (!vehicle_file_read(argv[1], argv + first, (size_t)(argc - first), &config.vehicle, message,
                           sizeof message)) {
        return refuse(message, "");
    }
    sway_block_write(&config, 1, block);
    FILE *file = fopen(argv[2], "wb");
    if (file == NULL) {
        return refuse(argv[2], "cannot be written");
    }
    const bool written = fwrite(block, 1, sizeof block, file) == sizeof block;
    return fclose(file) == 0 && written ? 0 : refuse(argv[2], "cannot be written");
}

/* make_block VEHICLE.TOML BLOCK [KEY=VALUE ...]: the parameter block for an ECU's flash.
 *
 * The vehicle (see vehicle_file.h; a KEY=VALUE wins over the file) and the defaults for all that is
 * not of the vehicle, checked as the ECU will check them. Runs on the host. */
#include <stdio.h>

#include "sway_block.h"
#include "vehicle_file.h"

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
        return refuse("wanted VEHICLE.TOML BLOCK [KEY=VALUE ...]", "");
    }
    sway_core_defaults(&config);
    if (!vehicle_file_read(argv[1], argv + 3, (size_t)argc - 3U, &config.vehicle, message,
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

/* make_block VEHICLE.TOML BLOCK [KEY=VALUE ...]: the parameter block for an ECU.
 *
 * Reads the vehicle (SI units, as in the recordings' vehicle.toml), takes the defaults for all that
 * is not of the vehicle, and checks the values as the ECU will. A KEY=VALUE, for example
 * car.lateral_acceleration_position=-1.383, comes after the file and wins. Runs on the host. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sway_block.h"

#define KEY_SIZE 64

typedef struct {
    sway_core_config_t config;
    bool has_trailer;
    bool has_axles;
    bool has_front_axle;
} maker_t;

static int refuse(const char *where, const char *what, const char *why)
{
    fprintf(stderr, "make_block: %s: %s: %s\n", where, what, why);
    return 1;
}

static bool set_value(maker_t *maker, const char *key, double si)
{
    size_t count = 0;
    const sway_vehicle_range_t *ranges = sway_vehicle_ranges(&count);
    for (size_t i = 0; i < count; i++) {
        if (strcmp(ranges[i].name, key) == 0) {
            const double scaled = si * ranges[i].scale;
            if (!(scaled > -2147483647.0 && scaled < 2147483647.0)) {
                return false;
            }
            const int32_t value = (int32_t)(scaled + (scaled < 0 ? -0.5 : 0.5));
            memcpy((char *)&maker->config.vehicle + ranges[i].offset, &value, sizeof value);
            maker->has_trailer = maker->has_trailer || strncmp(key, "trailer.", 8) == 0;
            maker->has_axles = maker->has_axles || strcmp(key, "trailer.axles") == 0;
            maker->has_front_axle =
                maker->has_front_axle || strcmp(key, "trailer.front_axle_to_cog") == 0;
            return true;
        }
    }
    return false;
}

static int set_text(maker_t *maker, const char *where, const char *key, const char *text)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    if (end == text || (*end != '\0' && strchr(" \t\r\n#", *end) == NULL)) {
        return refuse(where, key, "wanted a number");
    }
    return set_value(maker, key, value) ? 0 : refuse(where, key, "no such key, or out of range");
}

static int read_vehicle(maker_t *maker, const char *path)
{
    char line[256];
    char section[KEY_SIZE / 2] = "";
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        return refuse(path, "file", "cannot be read");
    }
    int status = 0;
    while (status == 0 && fgets(line, sizeof line, file) != NULL) {
        char key[KEY_SIZE / 2];
        char full[KEY_SIZE];
        int at = 0;
        if (sscanf(line, " [%31[a-z]]", section) == 1) {
            continue;
        }
        if (sscanf(line, " %31[a-z0-9_] = %n", key, &at) == 1 && at > 0) {
            snprintf(full, sizeof full, "%s.%s", section, key);
            status = set_text(maker, path, full, line + at);
        }
    }
    fclose(file);
    return status;
}

static int read_arguments(maker_t *maker, int count, char **texts)
{
    for (int i = 0; i < count; i++) {
        char *equals = strchr(texts[i], '=');
        if (equals == NULL) {
            return refuse("arguments", texts[i], "wanted KEY=VALUE");
        }
        *equals = '\0';
        if (set_text(maker, "arguments", texts[i], equals + 1) != 0) {
            return 1;
        }
    }
    return 0;
}

static int write_block(const maker_t *maker, const char *path)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_block_write(&maker->config, 1, block);
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        return refuse(path, "file", "cannot be written");
    }
    const bool written = fwrite(block, 1, sizeof block, file) == sizeof block;
    return fclose(file) == 0 && written ? 0 : refuse(path, "file", "cannot be written");
}

int main(int argc, char **argv)
{
    maker_t maker = {.has_trailer = false};
    const sway_vehicle_range_t *offender = NULL;
    if (argc < 3) {
        return refuse("arguments", "too few", "wanted VEHICLE.TOML BLOCK [KEY=VALUE ...]");
    }
    sway_core_defaults(&maker.config);
    if (read_vehicle(&maker, argv[1]) != 0 || read_arguments(&maker, argc - 3, argv + 3) != 0) {
        return 1;
    }
    if (maker.has_trailer && !maker.has_axles) {
        maker.config.vehicle.trailer.axles = maker.has_front_axle ? 2 : 1;
    }
    if (sway_vehicle_check(&maker.config.vehicle, &offender) != SWAY_OK) {
        return refuse(argv[1], offender == NULL ? "vehicle" : offender->name, "out of its range");
    }
    return write_block(&maker, argv[2]);
}

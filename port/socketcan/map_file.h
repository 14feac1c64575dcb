/// map_file: a map of a car's own bus (sway_map) from a file that `swaywatch map` wrote.
#ifndef SWAY_MAP_FILE_H
#define SWAY_MAP_FILE_H

#include <stdbool.h>

#include "bus/sway_map.h"

/// Reads and checks `path`; false: said on standard error what is wrong.
bool map_file_read(const char *path, sway_map_t *map);

#endif

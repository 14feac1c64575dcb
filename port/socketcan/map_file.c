#include "map_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define WORDS (sizeof(sway_map_t) / 4U)

static bool read_words(FILE *file, sway_map_t *map)
{
    static uint8_t bytes[4U * WORDS + 1U];
    if (fread(bytes, 1, sizeof bytes, file) != 4U * WORDS) {
        return false;
    }
    for (size_t i = 0; i < WORDS; i++) {
        const uint8_t *b = &bytes[4U * i];
        const uint32_t word =
            (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
        memcpy((uint8_t *)map + 4U * i, &word, sizeof word);
    }
    return true;
}

static bool is_checked(const char *path, const sway_map_t *map)
{
    uint32_t where = 0;
    if (sway_map_check(map, &where) == SWAY_OK) {
        return true;
    }
    if (where == SWAY_MAP_NONE) {
        fprintf(stderr, "swaywatchd: %s: no map of version %u; `swaywatch map` makes one\n", path,
                SWAY_MAP_VERSION);
    } else if (where < SWAY_MAP_MESSAGES) {
        fprintf(stderr,
                "swaywatchd: %s: message %u (0x%X) is refused: identifier, length, CRC or "
                "counter\n",
                path, where, (unsigned)map->message[where].can_id);
    } else {
        fprintf(stderr,
                "swaywatchd: %s: signal %u is refused: place in the frame, input, scale or "
                "range\n",
                path, where - SWAY_MAP_MESSAGES);
    }
    return false;
}

bool map_file_read(const char *path, sway_map_t *map)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fprintf(stderr, "swaywatchd: %s: %s\n", path, strerror(errno));
        return false;
    }
    const bool is_read = read_words(file, map);
    fclose(file);
    if (!is_read) {
        fprintf(stderr, "swaywatchd: %s: a map has %u bytes; `swaywatch map` makes one\n", path,
                (unsigned)(4U * WORDS));
    }
    return is_read && is_checked(path, map);
}

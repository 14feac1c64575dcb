/* Fuzzer of what is read from files: parameter blocks, a vehicle.toml, a candump log. The first
 * byte says which. Every one ends in a result or in words, and stamps never run back. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "candump.h"
#include "fuzz.h"
#include "log_file.h"
#include "sway_block.h"
#include "vehicle_file.h"

static void block(bytes_t from)
{
    uint8_t bytes[SWAY_BLOCK_SIZE + 8U];
    sway_core_config_t config;
    sway_core_config_t before;
    uint32_t sequence = 0;
    const bool is_sealed = (take(&from, 1) & 1U) != 0U;
    const size_t size = from.left < sizeof bytes ? from.left : sizeof bytes;
    memset(bytes, 0xFF, sizeof bytes);
    memcpy(bytes, from.data, size);
    sway_core_defaults(&config);
    if (is_sealed) { // intact, whatever its values
        memcpy(bytes, "SWAY", 4);
        bytes[4] = SWAY_BLOCK_VERSION;
        bytes[6] = (uint8_t)SWAY_BLOCK_WORDS;
        bytes[5] = bytes[7] = 0;
        const uint32_t crc = sway_block_crc32(0, bytes, SWAY_BLOCK_SIZE - 4U);
        memcpy(bytes + SWAY_BLOCK_SIZE - 4U, &crc, 4); // the host is little-endian
    }
    before = config;
    const size_t given = is_sealed ? sizeof bytes : size;
    const sway_block_result_t result = sway_block_read(bytes, given, &config, &sequence);
    require(!is_sealed || result == SWAY_BLOCK_OK);
    require(result == SWAY_BLOCK_OK || memcmp(&before, &config, sizeof config) == 0);
    if (result == SWAY_BLOCK_OK) {
        static sway_core_t core;
        uint8_t again[SWAY_BLOCK_SIZE];
        sway_block_write(&config, sequence, again);
        require(memcmp(again, bytes, sizeof again) == 0);
        const bool is_good = sway_block_offender(&config) == SWAY_BLOCK_WORDS;
        require(!is_good || sway_core_init(&core, &config) == SWAY_OK);
    }
}

static const char *file_of(bytes_t from, char *path, size_t size, int *fd)
{
    *fd = memfd_create("fuzz", 0);
    require(*fd >= 0 && write(*fd, from.data, from.left) == (ssize_t)from.left);
    snprintf(path, size, "/proc/self/fd/%d", *fd);
    return path;
}

static void vehicle(bytes_t from)
{
    char path[64];
    char message[300] = "";
    int fd = -1;
    sway_vehicle_t read;
    const bool is_good = vehicle_file_read(file_of(from, path, sizeof path, &fd), NULL, 0, &read,
                                           message, sizeof message);
    require(is_good == (message[0] == '\0'));
    require(!is_good || sway_vehicle_check(&read, NULL) == SWAY_OK);
    close(fd);
}

static void log_lines(bytes_t from)
{
    char path[64];
    int fd = -1;
    log_file_t log;
    sway_port_frame_t frame;
    int64_t last_us = INT64_MIN;
    uint64_t frames = 0;
    require(log_file_open(&log, file_of(from, path, sizeof path, &fd)));
    (void)log_file_time_us(&log);
    while (log_file_next(&log, &frame)) {
        char line[CANDUMP_LINE];
        require(frame.time_us >= last_us && frame.id <= 0x7FFU && frame.dlc <= 8U);
        require(candump_format(&frame, line) < sizeof line);
        last_us = frame.time_us;
        frames++;
    }
    require(frames == log.frames);
    require(log_file_close(&log));
    close(fd);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t from = {data, size};
    switch (take(&from, 1) % 3U) {
    case 0:
        block(from);
        break;
    case 1:
        vehicle(from);
        break;
    default:
        log_lines(from);
        break;
    }
    return 0;
}

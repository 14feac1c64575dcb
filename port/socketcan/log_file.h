/// log_file: a candump log ("candump -l", with or without R and T at the ends of lines) as a source
/// of frames. What is in it besides classic data frames is counted by kind, never taken for one.
#ifndef SWAY_LOG_FILE_H
#define SWAY_LOG_FILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "sway_port.h"

typedef struct {
    FILE *file;
    const char *path;
    char *line;
    size_t room;
    int64_t last_us;
    uint64_t lines;
    uint64_t frames;
    uint64_t error_frames;
    uint64_t foreign;    ///< 29-bit identifiers, remote frames, CAN FD
    uint64_t dropped;    ///< frames that DROPCOUNT lines say the logger lost
    uint64_t unreadable; ///< lines that are none of these
    uint64_t clock_back; ///< stamps set forward because they run backwards
    int64_t most_back_us;
    sway_port_frame_t held; ///< read ahead for its time
    bool holds;
} log_file_t;

/// False: the file cannot be opened, `errno` says why. "-" is the standard input.
bool log_file_open(log_file_t *log, const char *path);
/// The next data frame with an 11-bit identifier; false: the file has ended. The first unreadable
/// line is shown on the standard error.
bool log_file_next(log_file_t *log, sway_port_frame_t *frame);
/// Time of the newest frame; before any was asked for, that of the first one. 0: there is none.
int64_t log_file_time_us(log_file_t *log);
/// False where the file could not be read to its end.
bool log_file_close(log_file_t *log);

#endif

/// log_file: a candump log ("candump -l", with or without R and T at the ends of lines) as a source
/// of frames. What is in it besides classic data frames is counted by kind, never taken for one.
#ifndef SWAY_LOG_FILE_H
#define SWAY_LOG_FILE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "sway_port.h"

/// Longest line; a longer one is none of candump's.
#define LOG_FILE_LINE 512
/// Stamps out of order by more than this are damaged, or the logger's clock was set.
#define LOG_FILE_ORDER_US 20000

typedef struct {
    FILE *file;
    const char *path;
    const volatile sig_atomic_t *wants_end; ///< a signal asks to stop; may be NULL
    char line[LOG_FILE_LINE];
    int64_t last_us;
    int64_t shift_us; ///< added to the log's stamps since its clock was set back
    uint64_t lines;
    uint64_t frames;
    uint64_t error_frames;
    uint64_t foreign;    ///< 29-bit identifiers, remote frames, CAN FD
    uint64_t dropped;    ///< frames that DROPCOUNT lines say the logger lost
    uint64_t unreadable; ///< lines that are none of these
    uint64_t clock_back; ///< stamps set forward because they run backwards
    int64_t most_back_us;
    uint64_t stamps_damaged; ///< stamps that neither the frame before nor the one after agrees with
    uint64_t clock_set;      ///< times that the logger's clock was set back
    sway_port_frame_t held;  ///< read ahead
    bool holds;
} log_file_t;

/// False: the file cannot be opened, `errno` says why. "-" is the standard input.
bool log_file_open(log_file_t *log, const char *path);
/// The next data frame with an 11-bit identifier; false: the file has ended. Stamps never run
/// back: a single damaged one is replaced by that of its neighbour, and where the clock was set
/// back time goes on from there. The first unreadable line, damaged stamp and setting of the clock
/// are shown on the standard error; all are counted.
bool log_file_next(log_file_t *log, sway_port_frame_t *frame);
/// Time of the newest frame; before any was asked for, that of the first one. 0: there is none.
int64_t log_file_time_us(log_file_t *log);
/// False where the file could not be read to its end.
bool log_file_close(log_file_t *log);

#endif

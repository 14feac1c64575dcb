/// candump: one frame as a line of `candump -L`, both ways: "(12.345678) can0
/// 120#0011223344556677".
#ifndef SWAY_CANDUMP_H
#define SWAY_CANDUMP_H

#include "sway_port.h"

/// A line never needs more than this, its end included.
#define CANDUMP_LINE 80U

/// False: the line holds no classic data frame with an 11-bit identifier; `frame` is unchanged.
bool candump_parse(const char *line, sway_port_frame_t *frame);
/// Writes a line with its newline and a terminating 0; returns its length. `time_us` >= 0.
size_t candump_format(const sway_port_frame_t *frame, char *line);

#endif

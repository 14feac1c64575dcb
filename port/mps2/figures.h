/// figures: what the ECU costs in instructions and stack while a recording runs through it.
#ifndef SWAY_FIGURES_H
#define SWAY_FIGURES_H

#include "sway_ecu.h"

/// The ECU takes over from the port: counting goes on. The time of the newest frame tells which
/// 10 ms (row of the grid) the count belongs to.
void figures_began(int64_t time_us);
/// The ECU calls the port: counting stops; `is_finished`: the frame is done with.
void figures_returned(bool is_finished);
/// Writes the figures to a file of the host, one `name value` per line.
void figures_write(const char *path, const sway_ecu_t *ecu);

#endif

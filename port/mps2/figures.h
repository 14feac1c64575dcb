/// figures: what the ECU costs in instructions and stack while a recording runs through it.
#ifndef SWAY_FIGURES_H
#define SWAY_FIGURES_H

#include "replay.h"

/// The ECU goes on: counting does too. The time of the newest frame tells which 10 ms (row of the
/// grid) the count belongs to.
void figures_began(int64_t time_us);
/// The ECU calls the port, or has returned and has done `what`: counting stops.
void figures_stopped(replay_did_t what);
/// Writes the figures to a file of the host, one `name value` per line.
void figures_write(const char *path, const sway_ecu_t *ecu);

#endif

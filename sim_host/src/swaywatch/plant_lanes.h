/// plant_lanes: the planar plant of the diagnosis, several simulations side by side.
///
/// What the slots, constants and outputs are is said by diagnose/plant.py, which owns their order.
#ifndef PLANT_LANES_H
#define PLANT_LANES_H

#include <stdint.h>

#define PLANT_BODY 18
#define PLANT_SCALARS 31
#define PLANT_SERIES 28
#define PLANT_OUTPUTS 34
#define PLANT_STATES 16
#define PLANT_BLOCK 10
#define PLANT_LANES 8

/// One simulation of samples `first` to `stop`; all arrays are indexed by the sample of the run.
typedef struct {
    int64_t first; ///< multiple of PLANT_BLOCK
    int64_t stop;  ///< above `first`
    const double *speed;
    const double *acceleration;
    const double *steer;
    const double *series[PLANT_SERIES]; ///< NULL: neutral
    const double *body;
    const double *scalars;
    double state[PLANT_STATES];    ///< in: at `first`; out: at the last sample
    double *output;                ///< rows of `columns` outputs, or NULL
    int32_t columns;               ///< outputs in a row of `output`
    int32_t column[PLANT_OUTPUTS]; ///< which
    double *blocks;                ///< rows of sums over PLANT_BLOCK samples, or NULL
    double *states;                ///< rows of PLANT_STATES at the samples stepped on, or NULL
    double sums[PLANT_OUTPUTS];    ///< of the block that is open; zero at the start
    int64_t at;                    ///< where the simulation stands
    int64_t diverged;              ///< 1: outputs from `at` on are zero
} plant_lane_t;

/// Runge-Kutta 4 over the lanes, at most PLANT_LANES; a `stride` of 2 takes the middle sample at
/// stage 3. What a lane gives does not depend on the lanes beside it. O(samples).
void plant_lanes(plant_lane_t *lanes, int32_t count, double period_s, int32_t stride);

#endif

/// plant_generator: axle loads that the motion itself makes at twice its frequency.
#ifndef PLANT_GENERATOR_H
#define PLANT_GENERATOR_H

#include <math.h>

#include "plant_lanes.h"

#define FLOOR_YAW 1e-6        ///< (rad/s)^2, below it the normalised load fades out
#define FLOOR_FRICTION 2.5e-5 ///< of (force over load)^2

/// Value of a reference of the generator `back` steps ago, between its samples.
static inline double generator_past(const plant_generator_t *g, int64_t reference, double back)
{
    const int64_t whole = (int64_t)back;
    const double part = back - (double)whole;
    const int64_t last = g->steps - 1;
    const int64_t first = last > whole ? last - whole : 0;
    const int64_t second = first > 0 ? first - 1 : 0;
    const double *row = g->history + reference * g->length;
    return (1.0 - part) * row[first % g->length] + part * row[second % g->length];
}

/// Extra loads of the axles at `time`, by Eq. 6.1-6.2 from the references up to the last step.
static inline void generator_loads(const plant_generator_t *g, double time, double step,
                                   double *load)
{
    for (int a = 0; a < 4; a++) {
        load[a] = 0.0;
    }
    for (int64_t n = 0; n < g->count && g->steps > 0; n++) {
        const double *w = g->windows + n * PLANT_GENERATOR_WINDOW;
        if (time >= w[G_START] && time < w[G_STOP]) {
            load[(int)w[G_AXLE]] +=
                w[G_GAIN] * generator_past(g, (int64_t)w[G_REFERENCE], w[G_DELAY] / step);
        }
    }
}

/// Advance the high-pass of the references: yaw rate squared, friction used squared.
///
/// Friction (side force over load) stands for the side force: the load that is made from it does
/// not distort it. Row 0 of the history is the yaw rate's as it is, 1 to 5 are normalised.
static inline void generator_remember(plant_generator_t *g, double step, double yaw_rate,
                                      const double *friction)
{
    const double share = 1.0 - exp(-step / g->mean_time_s);
    const double slow = 1.0 - exp(-step / g->level_time_s);
    const int64_t at = g->steps % g->length;
    for (int k = 0; k < 5; k++) {
        const double value = k == 0 ? yaw_rate : friction[k - 1];
        const double square = value * value;
        if (g->steps == 0) {
            g->mean[k] = g->level[k] = square;
        }
        g->mean[k] += share * (square - g->mean[k]);
        g->level[k] += slow * (square - g->level[k]);
        const double floor = k == 0 ? FLOOR_YAW : FLOOR_FRICTION;
        g->history[(1 + k) * g->length + at] = (square - g->mean[k]) / (g->level[k] + floor);
        if (k == 0) {
            g->history[at] = square - g->mean[k];
        }
    }
    g->steps++;
}

#endif

/* Shared by tests of the whole core: a computed line as samples of its inputs. */
#ifndef CORE_FEED_H
#define CORE_FEED_H

#include "sway_core.h"
#include "sway_test.h"

static inline void drain(sway_core_t *c)
{
    while (sway_core_run(c)) {
    }
}

static const struct {
    sway_input_t input;
    sway_channel_t channel;
    double scale;
} SIGNALS[] = {
    {SWAY_INPUT_STEERING_WHEEL_ANGLE, SWAY_CHANNEL_STEERING_WHEEL_ANGLE, 1e6},
    {SWAY_INPUT_CAR_YAW_RATE, SWAY_CHANNEL_CAR_YAW_RATE, 1e6},
    {SWAY_INPUT_CAR_LATERAL_ACC, SWAY_CHANNEL_CAR_LATERAL_ACC, 1e6},
    {SWAY_INPUT_TRAILER_YAW_RATE, SWAY_CHANNEL_TRAILER_YAW_RATE, 1e6},
    {SWAY_INPUT_TRAILER_LATERAL_ACC, SWAY_CHANNEL_TRAILER_LATERAL_ACC, 1e6},
    {SWAY_INPUT_HITCH_FX, SWAY_CHANNEL_HITCH_FX, 1e3},
    {SWAY_INPUT_HITCH_FY, SWAY_CHANNEL_HITCH_FY, 1e3},
    {SWAY_INPUT_CAR_FY_FL, SWAY_CHANNEL_CAR_FRONT_FY, 5e2},
    {SWAY_INPUT_CAR_FY_FR, SWAY_CHANNEL_CAR_FRONT_FY, 5e2},
    {SWAY_INPUT_CAR_FY_RL, SWAY_CHANNEL_CAR_REAR_FY, 5e2},
    {SWAY_INPUT_CAR_FY_RR, SWAY_CHANNEL_CAR_REAR_FY, 5e2},
};

/* Samples of a line from `from_s` to `to_s`; `every` slices are run after each sample (< 0: all).
 */
static inline void feed(sway_core_t *c, const sway_line_t *line, const test_plant_t *plant,
                        double from_s, double to_s, int every)
{
    for (int k = (int)lround(from_s * 100); k < (int)lround(to_s * 100); k++) {
        const int64_t time_us = 1000000 + 10000 * (int64_t)k;
        const double complex e = cexp(plant->s * 0.01 * k);
        (void)sway_core_input(c, SWAY_INPUT_SPEED, time_us, (int32_t)lround(plant->v * 1e3));
        for (unsigned i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
            const sway_line_channel_t *const channel = &line->channel[SIGNALS[i].channel];
            const double x = value(channel->mean) + creal(cvalue(channel->amplitude) * e);
            (void)sway_core_input(c, SIGNALS[i].input, time_us,
                                  (int32_t)lround(x * SIGNALS[i].scale));
            for (int n = 0; n != every && sway_core_run(c); n++) {
            }
        }
    }
}

#endif

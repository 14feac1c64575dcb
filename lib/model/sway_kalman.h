// SPDX-License-Identifier: MIT
/// sway_kalman: values with tolerances, updated by measured relations.
///
/// Each number is 0 where the user's belief is right, with a tolerance (its prior standard
/// deviation). A relation says residual + slope . numbers = noise; taking it moves the numbers and
/// shrinks their covariance (a Kalman filter's measurement). A number may fade: what was learnt of
/// it is forgotten towards its tolerance, never beyond it (an Ornstein-Uhlenbeck process). So if
/// the beliefs hold, a number is normal with variance `tolerance^2 - covariance` at any time, and
/// what it is worth to set some numbers free has a chi-square distribution: a test whose false
/// alarms are known, whenever one looks.
///
/// The arrays are the caller's. Work is done in slices of at most SWAY_KALMAN_CHUNK products.
#ifndef SWAY_KALMAN_H
#define SWAY_KALMAN_H

#include <stddef.h>

#include "arithmetic/sway_real.h"

/// Products in one slice: about 55 thousand instructions of a Cortex-M0+.
#define SWAY_KALMAN_CHUNK 360U

/// Most numbers.
#define SWAY_KALMAN_MOST 48

/// Places in a packed lower triangle of `count` numbers.
#define SWAY_KALMAN_TRIANGLE(count) ((count) * ((count) + 1) / 2)

/// Numbers set free together at most.
#define SWAY_KALMAN_GROUP 6

typedef struct {
    uint8_t count;
    uint8_t row;                  ///< of the work in progress
    const int32_t *tolerance_ppm; ///< of each number
    sway_real_t *value;
    sway_real_t *covariance; ///< packed lower triangle
    sway_real_t *slope;      ///< of the relation in progress
    sway_real_t *moved;      ///< covariance times slope
    sway_real_t gain;        ///< innovation over its variance
    sway_real_t by_variance; ///< 1 over the innovation's variance
} sway_kalman_t;

/// Back to the beliefs.
void sway_kalman_reset(sway_kalman_t *gauss);

/// One slice of forgetting: numbers of `fading` (a bit each) keep `keep_ppm` of themselves. False:
/// done. Begin with `row` 0.
bool sway_kalman_fade(sway_kalman_t *gauss, uint64_t fading, int32_t keep_ppm);

/// Takes the relation residual + slope . value = noise of this variance, in slices: call with `row`
/// 0 first, until false.
bool sway_kalman_take(sway_kalman_t *gauss, sway_real_t residual, sway_real_t variance);

/// Worth of setting the numbers of `group` free: chi-square with `size` degrees of freedom if the
/// beliefs hold. 0 where nothing has been learnt of them.
sway_real_t sway_kalman_worth(const sway_kalman_t *gauss, const uint8_t *group, uint32_t size);

/// Number and standard error with its tolerance lifted. `se` is 0 where nothing has been learnt.
void sway_kalman_free(const sway_kalman_t *gauss, uint32_t index, sway_real_t *value,
                      sway_real_t *se);

/// Covariance of two numbers.
sway_real_t sway_kalman_covariance(const sway_kalman_t *gauss, uint32_t a, uint32_t b);

#endif

// SPDX-License-Identifier: MIT
/// sway_supervise: detects a broken sensor, a changed vehicle or a wrong configuration.
///
/// While driving, every relation that the inputs allow (sway_relations) is taken as a measurement
/// of all numbers that may be wrong (sway_kalman): gain and phase of every sensor, the speed, the
/// user's values of the vehicle, changes during the drive. Which relations are violated together
/// decides which explanation is worth most; each costs 3 for every number in it.
///
/// An explanation worth more than SWAY_SUPERVISE_LIMIT is a finding; one that is ahead of all
/// others by SWAY_SUPERVISE_LEAD, twice in a row, is reported: a sensor is rejected and leaves the
/// estimate for the rest of the drive; of a vehicle the differing value is reported, with size and
/// error. Until then the sensors among the best explanations are suspect. A report comes at the
/// first moment that is clear enough, so chance has helped it and its size is too large: the sensor
/// stays in the relations for SWAY_SUPERVISE_MEASURED rounds more and is measured anew, with a flat
/// prior; nothing else is reported meanwhile. Offsets of yaw rates and accelerations are found from
/// their means over 2.5 s (r1 = r2, a = v r, a bank for both bodies) and reported; they do not
/// affect the sway, so nothing is excluded.
///
/// The noise of the sensors, the road and the wind are assumed large; each relation's innovations
/// say how much of that is there, and 1.5 times of it is believed (at least a tenth, never more
/// than assumed).
///
/// False alarms: if the values are right within their tolerances, worth is chi-square and tested
/// anew about every minute of driving with steering; 19 explanations at 3e-7, twice in a row, are
/// less than one false finding in 1,000 hours. That is arithmetic; what was simulated is in
/// README.md.
///
/// In simulation gains, signs, delays and offsets of sensors are reported, mostly within a minute
/// of swerves. Changes of the vehicle are not reported with motion sensors alone; they keep a
/// sensor from being blamed for them. A car or trailer other than the configured one is never
/// reported.
#ifndef SWAY_SUPERVISE_H
#define SWAY_SUPERVISE_H

#include "model/sway_kalman.h"
#include "model/sway_relations.h"
#include "signal/sway_grid.h"
#include "sway_status.h"

/// Worth of an explanation, less 3 for each of its numbers, that makes a finding.
#define SWAY_SUPERVISE_LIMIT 24
/// How far it has to be ahead of every other: odds of e^6.
#define SWAY_SUPERVISE_LEAD 12

/// Rounds (windows of driving with steering) in which a rejected sensor is measured.
#define SWAY_SUPERVISE_MEASURED 12

/// Explanations: each source from SWAY_ORIGIN_STEERING on, and eight by the vehicle.
#define SWAY_SUPERVISE_SENSORS 11
#define SWAY_SUPERVISE_EXPLANATIONS 19
#define SWAY_SUPERVISE_OFFSETS 9

/// What is found.
typedef struct {
    int32_t code; ///< sway_finding_t, with the channel of a sensor
    int32_t size_micro;
    int32_t se_micro;
} sway_finding_report_t;

/// How a relation holds: mean squares over about four windows.
typedef struct {
    uint8_t state; ///< sway_relation_state_t
    sway_real_t residual;
    sway_real_t allowed; ///< of the residual, by tolerances, noise, road and wind
    sway_real_t size;    ///< of its terms
} sway_supervise_relation_t;

typedef struct {
    uint8_t stage;
    uint8_t relation;
    uint8_t harmonic;
    uint8_t explanation; ///< evaluated next
    uint8_t candidate;   ///< the best one of the last round
    bool unresolved;     ///< the last round had a finding that was ambiguous
    uint8_t reported;    ///< explanation by the vehicle, or SWAY_SUPERVISE_EXPLANATIONS for none
    uint8_t measured;    ///< sensor whose size is measured, for
    uint8_t measuring;   ///< so many rounds more
    uint32_t suspect_mask;
    uint32_t rejected_mask;
    uint32_t offset_mask; ///< channels with an offset
    uint32_t rounds;
    sway_finding_report_t finding;
    const sway_vehicle_t *vehicle;
    int32_t sample_period_us;
    /* Means. */
    uint32_t rows;
    int64_t sum[3];
    int64_t sum_of_squares[3];
    int64_t sum_yaw_rate;
    int64_t sum_speed;
    sway_kalman_t offsets;
    sway_real_t offset_value[SWAY_SUPERVISE_OFFSETS];
    sway_real_t offset_slope[SWAY_SUPERVISE_OFFSETS];
    sway_real_t offset_moved[SWAY_SUPERVISE_OFFSETS];
    sway_real_t offset_covariance[SWAY_KALMAN_TRIANGLE(SWAY_SUPERVISE_OFFSETS)];
    /* Relations. */
    int32_t score_milli[SWAY_SUPERVISE_EXPLANATIONS];
    int32_t tolerance_ppm[SWAY_UNKNOWN_COUNT];
    sway_kalman_t numbers;
    sway_real_t value[SWAY_UNKNOWN_COUNT];
    sway_real_t slope[SWAY_UNKNOWN_COUNT];
    sway_real_t moved[SWAY_UNKNOWN_COUNT];
    sway_real_t covariance[SWAY_KALMAN_TRIANGLE(SWAY_UNKNOWN_COUNT)];
    sway_supervise_relation_t held[SWAY_RELATION_COUNT];
    sway_real_t share[SWAY_RELATION_COUNT]; ///< innovations squared over the assumed variance
    uint8_t taken[SWAY_RELATION_COUNT];     ///< values in that mean
    sway_relations_sums_t sums;
    sway_relations_t relations;
} sway_supervise_t;

/// `vehicle` must stay. The structure must not be moved.
void sway_supervise_init(sway_supervise_t *supervise, const sway_vehicle_t *vehicle,
                         int32_t sample_period_us);

/// Inputs that are to be in the rows: all but the rejected ones that are no longer measured.
uint32_t sway_supervise_wanted(const sway_supervise_t *supervise);

/// Takes one row of the grid.
void sway_supervise_row(sway_supervise_t *supervise, const sway_row_t *row);

/// How a relation holds, its residual over its size, and one deviation of that. Zero where it was
/// not asked.
sway_relation_state_t sway_supervise_relation(const sway_supervise_t *supervise,
                                              sway_relation_t relation, int32_t *size_ppm,
                                              int32_t *deviation_ppm);

/// One slice of at most SWAY_SLICE_COST; false: nothing is to be done.
bool sway_supervise_run(sway_supervise_t *supervise);

#endif

// SPDX-License-Identifier: MIT
/// sway_phasor: complex amplitudes that carry their first-order errors with them.
///
/// What identification computes (slips, forces, stiffnesses, inertias, v_crit) are functions of the
/// same few measured amplitudes, so their errors are correlated: the trailer's acceleration, say,
/// is in its slip and in its force. A phasor therefore keeps, beside its value, its derivative with
/// respect to every measured amplitude (a source); all operations used are analytic. The variance
/// of any result is then the sum of |derivative|^2 times the variance of the source.
#ifndef SWAY_PHASOR_H
#define SWAY_PHASOR_H

#include "arithmetic/sway_real.h"
#include "sway_types.h"

/// What is measured. Each has one standard error for its real and its imaginary part.
typedef enum {
    SWAY_ORIGIN_S, ///< growth + j omega
    SWAY_ORIGIN_STEERING,
    SWAY_ORIGIN_CAR_YAW_RATE,
    SWAY_ORIGIN_CAR_ACC,
    SWAY_ORIGIN_TRAILER_YAW_RATE,
    SWAY_ORIGIN_TRAILER_ACC,
    SWAY_ORIGIN_ARTICULATION,
    SWAY_ORIGIN_HITCH_FY,
    SWAY_ORIGIN_CAR_FRONT_FY,
    SWAY_ORIGIN_CAR_REAR_FY,
    SWAY_ORIGIN_TRAILER_FRONT_FY,
    SWAY_ORIGIN_TRAILER_REAR_FY,
    SWAY_ORIGIN_ALL
} sway_origin_t;

/// Channel of a source; SWAY_CHANNEL_COUNT for SWAY_ORIGIN_S, which has none.
sway_channel_t sway_origin_of_channel(sway_origin_t from);

/// Sources that are kept: those of the channels that the build has.
#if SWAY_CHANNELS > 12
#define SWAY_ORIGIN_COUNT 12
#elif SWAY_CHANNELS > 9
#define SWAY_ORIGIN_COUNT 10
#elif SWAY_CHANNELS > 5
#define SWAY_ORIGIN_COUNT 8
#else
#define SWAY_ORIGIN_COUNT (SWAY_CHANNELS + 1)
#endif

typedef struct {
    bool known; ///< false: made of something that was not measured
    sway_complex_t value;
    sway_complex_t slope[SWAY_ORIGIN_COUNT]; ///< d value / d source
} sway_phasor_t;

/// Variances of the sources: of the real part, and the same of the imaginary one.
typedef struct {
    sway_real_t variance[SWAY_ORIGIN_COUNT];
} sway_sources_t;

/// A measured amplitude.
sway_phasor_t sway_phasor_measured(sway_complex_t value, sway_origin_t source);
/// A constant, without error.
sway_phasor_t sway_phasor_constant(sway_complex_t value);
sway_phasor_t sway_phasor_unknown(void);

/// Results are known where both operands are. Division by 0 is not known.
void sway_phasor_add(sway_phasor_t *sum, const sway_phasor_t *term);
/// sum += factor * term
void sway_phasor_add_scaled(sway_phasor_t *sum, const sway_phasor_t *term, sway_real_t factor);
void sway_phasor_scale(sway_phasor_t *phasor, sway_real_t factor);
void sway_phasor_multiply(sway_phasor_t *product, const sway_phasor_t *factor);
void sway_phasor_divide(sway_phasor_t *quotient, const sway_phasor_t *divisor);

/// Standard error of the real part, and the same of the imaginary part.
sway_real_t sway_phasor_se(const sway_phasor_t *phasor, const sway_sources_t *sources);

#endif

// SPDX-License-Identifier: MIT
/// sway_evidence: damping ratio from signals and model, weighted by their errors.
///
/// The growth of the free oscillation needs no model, but steering or gusts look like damping to
/// it. The combination believes
///   - the model while the oscillation is forced, too small, or not one damped line;
///   - both, weighted by variance, where they agree within four standard errors, three where the
///     model is `slow`;
///   - the signal where a clean free oscillation contradicts the model (physics is missing there).
#ifndef SWAY_EVIDENCE_H
#define SWAY_EVIDENCE_H

#include "arithmetic/sway_real.h"
#include "sway_status.h"

/// What the combination is made of.
typedef struct {
    sway_real_t ratio;
    sway_real_t se;
    bool usable;
    bool slow; ///< of a model: it learns a change slowly (the car's own sensors)
} sway_evidence_t;

/// How much the road and the wind disturb the swing. A swing that is pushed about by disturbances
/// shows any damping over two oscillations: the error of its damping ratio is some amplitude,
/// learnt here, over its own amplitude. (Measured on ordinary driving: 0.3 deg/s over the
/// amplitude.)
typedef struct {
    sway_real_t variance; ///< of the amplitude, (rad/s)^2
    int64_t time_us;
    int32_t learnt_us; ///< how long it has been learnt, up to its memory
    bool started;
} sway_disturbance_t;

/// Standard error of the signal's damping ratio: twice that of the fit, the disturbance's, and the
/// driver's. A hand that moves the wheel at the line's frequency, so that the yaw rate would follow
/// with `steered_rad_s` if it were slow, adds up to 3/4 steered / amplitude to the damping ratio
/// (1/2 for a plain oscillator; 0.55 to 0.9 for the mode of combinations, by their residues).
sway_real_t sway_disturbance_se(const sway_disturbance_t *disturbance, sway_real_t fit_se,
                                sway_real_t amplitude_rad_s, sway_real_t steered_rad_s);

/// Learns from the difference between the signal's damping ratio and the combined one, less what
/// the driver's hand may have done.
void sway_disturbance_learn(sway_disturbance_t *disturbance, int64_t time_us,
                            sway_real_t difference, sway_real_t amplitude_rad_s,
                            sway_real_t steered_rad_s);

/// The clock has started again at `time_us`; what was learnt stays.
void sway_disturbance_restart(sway_disturbance_t *disturbance, int64_t time_us);

/// Combined damping ratio. `disagrees` is set where the two differ beyond their errors.
sway_belief_t sway_evidence_combine(const sway_evidence_t *model, const sway_evidence_t *signal,
                                    sway_evidence_t *combined, bool *disagrees);

#endif

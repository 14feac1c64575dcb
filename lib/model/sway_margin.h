// SPDX-License-Identifier: MIT
/// sway_margin: how far the combination is from instability, by its model.
///
/// It puts the identified stiffnesses (with their arguments, as relaxation lengths)
/// and yaw inertias into the single-track model: damping ratio at the present speed, critical speed
/// and its standard error. One window gives noisy values in ordinary driving, so each quantity is
/// filtered over many (sway_quantity), where forces come from balances as far as an earlier swing
/// predicts this one.
///
/// Dry friction at the ball holds small swings and lets large ones go, so the model has none: the
/// inertias are taken without it, and the critical speed is that of a swing which friction does not
/// hold, the lowest of all sizes.
#ifndef SWAY_MARGIN_H
#define SWAY_MARGIN_H

#include "model/sway_quantity.h"
#include "model/sway_single_track.h"

/// Parameters whose derivatives are renewed with an estimate.
#define SWAY_MARGIN_TURN 2

/// Estimates between a swing and the one that it predicts: a quarter of a window.
#define SWAY_MARGIN_PAST 4

/// Swing of an earlier estimate.
typedef struct {
    int64_t time_us;
    sway_real_t omega_rad_s;
    sway_complex_t swing; ///< yaw rate of the trailer; of the car where that is not known
} sway_margin_past_t;

typedef struct {
    bool has_model; ///< damping ratio is valid
    bool vague;     ///< the critical speed is too uncertain for a notice or a warning
    bool has_steady;
    sway_vcrit_t kind;
    sway_source_t source;
    sway_real_t damping_ratio;
    sway_real_t damping_ratio_se;
    sway_complex_t root; ///< dominant root at the present speed
    sway_real_t v_crit_m_s;
    sway_real_t v_crit_se_m_s;
    sway_real_t omega_crit_rad_s;
    sway_real_t sensitivity_m_s[SWAY_PARAMETER_COUNT];
    sway_single_track_static_t steady;
} sway_margin_model_t;

typedef struct {
    /* Work in progress. */
    uint8_t step;
    uint8_t count;
    uint8_t turn;  ///< parameter whose derivatives are renewed next
    bool complete; ///< all derivatives have been computed once
    bool far;      ///< the limit was found far from where its slopes were taken
    sway_real_t speed_m_s;
    sway_complex_t f_s;
    sway_complex_t f_v;
    sway_single_track_quartic_t quartic;
    sway_single_track_roots_t roots;
    sway_single_track_t stm; ///< with relaxation
    sway_margin_model_t next;
    sway_complex_t limit_per_percent[SWAY_PARAMETER_COUNT]; ///< change of v_crit for +1 %: of the
                                                            ///< value (re), of its argument (im)
    sway_complex_t root_per_percent[SWAY_PARAMETER_COUNT];  ///< change of the dominant root
    /* What stays. */
    uint8_t past_next;
    sway_margin_past_t past[SWAY_MARGIN_PAST];
    sway_margin_model_t model; ///< latest finished
    sway_quantity_t stiffness[SWAY_AXLE_COUNT];
    sway_quantity_t inertia[2];
    sway_vehicle_t vehicle;
} sway_margin_t;

/// Starts from the user's values.
void sway_margin_init(sway_margin_t *margin, const sway_vehicle_t *vehicle);

/// Takes the estimates of `identify` (NULL: none now) into the filters, as of `time_us`, and begins
/// a computation at `speed_m_s`. SWAY_ERROR_SPEED: speed below 30 km/h. SWAY_ERROR_VEHICLE: too
/// little is known for the model.
sway_error_t sway_margin_start(sway_margin_t *margin, const sway_identify_t *identify,
                               int64_t time_us, sway_real_t speed_m_s);

/// What the next slice costs about, in the unit of SWAY_SLICE_COST.
uint32_t sway_margin_cost(const sway_margin_t *margin);

/// One slice; true while more is to be done. Then margin->model is the result. Derivatives to the
/// parameters change slowly: after the first time, SWAY_MARGIN_TURN of them are renewed each time.
bool sway_margin_run(sway_margin_t *margin);

#endif

// SPDX-License-Identifier: MIT
/// sway_judge: evidence in, judgement out; the one place where it is decided what to believe.
///
///     evidence                  its error                               out when
///     the line, free or forced  fit, road and wind, driver's hand       no line is held, or
///     nothing
///                                                                       tells how large it is
///     the model                 filtered stiffnesses and inertias       no speed, too little known
///
/// Nothing vetoes: an input that is gone, a gap, a hand on the wheel make errors larger, and the
/// two are weighted by their errors (sway_evidence). The combination goes to the alarm
/// (sway_alarm).
///
/// How large the swing is, is said by the trailer's yaw rate. Where that is gone, it is what the
/// car's motion says of it (sway_trailer), else any other motion says it: how much yaw rate of the
/// trailer goes with it is learnt while both are there.
#ifndef SWAY_JUDGE_H
#define SWAY_JUDGE_H

#include "judge/sway_alarm.h"
#include "judge/sway_evidence.h"
#include "model/sway_margin.h"
#include "signal/sway_line.h"

/// Motions that can stand in for the trailer's yaw rate.
#define SWAY_JUDGE_STANDINS 4

/// Evidence of one estimate.
typedef struct {
    int64_t time_us;       ///< newest row
    int32_t speed_mm_s;    ///< newest; -1: not known
    uint32_t seen_mask;    ///< channels that have ever come, SWAY_CHANNEL_SPEED too
    uint32_t missing_mask; ///< of those, missing in a row since the last estimate
    uint32_t quality;      ///< SWAY_QUALITY_* of line and identification
    const sway_line_t *line;
    const sway_margin_model_t *model; ///< the latest, also if it is of an earlier estimate
    bool modelled;                    ///< it is of this estimate
    bool has_reconstruction; ///< the trailer's yaw rate is known from the car's motion, as follows
    sway_real_t reconstructed_rad_s;
} sway_judge_evidence_t;

/// What comes out, beside state, reasons and time to limit of `sway_judge_t::alarm`.
typedef struct {
    sway_evidence_t signal;
    sway_evidence_t combined;
    sway_belief_t belief;
    bool has_swing;
    sway_real_t swing_rad_s; ///< yaw rate of the trailer (of a car alone) at the line
    sway_real_t swing_se_rad_s;
    uint32_t quality;      ///< with what the judgement has added
    uint32_t missing_mask; ///< channels that have come before and are not in this judgement
} sway_judgement_t;

typedef struct {
    bool is_solo;
    int32_t steering_ratio_milli;
    int32_t last_speed_mm_s; ///< newest that was known; -1: none
    int64_t last_speed_us;
    sway_real_t swing_by[SWAY_JUDGE_STANDINS]; ///< trailer's yaw rate over the motion, SI
    sway_disturbance_t disturbance;
    sway_alarm_t alarm;
} sway_judge_t;

/// SWAY_ERROR_ARGUMENT: see sway_alarm_init().
sway_error_t sway_judge_init(sway_judge_t *judge, const sway_vehicle_t *vehicle,
                             const sway_alarm_config_t *alarm);

/// The clock has started again at `time_us`: what is known stays, what was timed begins anew.
void sway_judge_restart(sway_judge_t *judge, int64_t time_us);

/// Takes one estimate.
void sway_judge_take(sway_judge_t *judge, const sway_judge_evidence_t *evidence,
                     sway_judgement_t *judgement);

/// Whether a limit was found, oscillatory or static, with an error that means something: what ends
/// at a bound of the search has none.
bool sway_judge_has_limit(const sway_margin_model_t *model);

#endif

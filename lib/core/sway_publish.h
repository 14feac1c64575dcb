// SPDX-License-Identifier: MIT
/// sway_publish: one estimate into the plain integers of sway_status_t.
#ifndef SWAY_PUBLISH_H
#define SWAY_PUBLISH_H

#include "judge/sway_judge.h"
#include "model/sway_identify.h"
#include "model/sway_margin.h"
#include "sway_status.h"

/// What is known of one estimate; pointers are NULL where there is nothing.
typedef struct {
    const sway_line_t *line; ///< a line to believe, or NULL
    const sway_identify_t *identify;
    const sway_margin_model_t *model;
    int64_t time_us;    ///< newest row
    int32_t speed_mm_s; ///< newest; -1: not known
    const sway_judgement_t *judgement;
    const sway_alarm_t *alarm;
} sway_publish_t;

/// Parts of what is identified: the axles and the inertias.
#define SWAY_PUBLISH_PARTS ((uint32_t)SWAY_AXLE_COUNT + 1U)

/// Writes one part (0..SWAY_PUBLISH_PARTS-1); all of them before sway_publish().
void sway_publish_part(sway_status_t *status, const sway_identify_t *identify, uint32_t part);

/// Writes all but those parts, sequence and fault counters. What is not valid now keeps its
/// last value and is marked old, if it ever was valid.
void sway_publish(sway_status_t *status, const sway_publish_t *from);

#endif

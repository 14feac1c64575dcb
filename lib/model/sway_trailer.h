// SPDX-License-Identifier: MIT
/// sway_trailer: what hangs on the ball, as the car's own sensors tell.
///
/// Two observers run side by side on the same samples, one of the car alone and one with a trailer
/// (sway_observer). Which of them predicts the car's yaw rate and lateral acceleration better says
/// whether a trailer is there: the logarithm of their likelihoods' ratio, less what a car's missing
/// physics could win (0.4 a sample), over 2 for samples that tell the same. It is weighed while the
/// driver steers: wind and road alone prove neither. The observer with the trailer gives
/// the trailer's parameters, the damping ratio at the present speed and the critical speed, tyres
/// that lag included, with standard errors from its whole covariance: masses and stiffnesses that
/// cannot be separated leave the critical speed well known. Hard driving, in which tyres level
/// off, teaches little.
///
/// All this is silent, and costs nothing but its memory, as soon as a sensor of the trailer has
/// been heard: then sway_identify knows more.
#ifndef SWAY_TRAILER_H
#define SWAY_TRAILER_H

#include "model/sway_margin.h"
#include "model/sway_observer.h"
#include "signal/sway_grid.h"

typedef enum {
    SWAY_TRAILER_UNDECIDED,
    SWAY_TRAILER_NONE,
    SWAY_TRAILER_THERE,
    SWAY_TRAILER_SENSED ///< sensors of the trailer were heard
} sway_trailer_presence_t;

/// A number with its standard error.
typedef struct {
    int32_t value;
    int32_t se;
} sway_trailer_number_t;

/// What is known of the trailer and by the way of the car.
typedef struct {
    int32_t presence;           ///< sway_trailer_presence_t
    int32_t evidence_milli;     ///< natural logarithm of the odds that a trailer is there, x 1000
    int32_t learnt_ms;          ///< driving that it was learnt from
    int32_t agreement_milli[2]; ///< innovations squared over their variance: yaw rate, acceleration
    sway_trailer_number_t mass_kg;
    sway_trailer_number_t hitch_to_cog_mm;
    sway_trailer_number_t hitch_to_axle_mm; ///< middle of two axles
    sway_trailer_number_t yaw_inertia_kgm2;
    sway_trailer_number_t stiffness_n_per_rad; ///< all axles
    sway_trailer_number_t friction_nm;         ///< dry, at the ball
    sway_trailer_number_t car_front_n_per_rad;
    sway_trailer_number_t car_rear_n_per_rad;
    sway_trailer_number_t yaw_rate_urad_s; ///< of the trailer, now
    sway_trailer_number_t articulation_urad;
} sway_trailer_report_t;

/// What a drive leaves in the memory of an ECU, so that the trailer can be known again: of the car
/// SWAY_STATE_CAR_FRONT and the states after it, of the trailer SWAY_STATE_TRAILER_MASS and after.
#define SWAY_TRAILER_UNKNOWNS 6U
#define SWAY_TRAILER_CAR 5U
#define SWAY_TRAILER_MEMORY (SWAY_TRAILER_CAR + SWAY_TRAILER_UNKNOWNS)
#define SWAY_TRAILER_TRIANGLE (SWAY_TRAILER_MEMORY * (SWAY_TRAILER_MEMORY + 1U) / 2U)
typedef struct {
    sway_real_t value[SWAY_TRAILER_MEMORY];
    sway_real_t covariance[SWAY_TRAILER_TRIANGLE];
} sway_trailer_memory_t;

/// Parameters that move the critical speed.
#define SWAY_TRAILER_PARAMETERS 10

typedef struct {
    bool sensed;     ///< a sensor of the trailer was heard
    bool configured; ///< the user's vehicle has a trailer: axles > 0
    bool busy[2];    ///< an observer has work: alone, with
    bool has_model;
    bool complete;    ///< all derivatives have been computed once
    uint8_t presence; ///< sway_trailer_presence_t
    uint8_t rows;     ///< in the sums
    uint8_t rows_due;
    uint8_t step; ///< of the model in progress
    uint8_t count;
    uint8_t turn;
    int32_t learnt_ms;
    int64_t sum[4];
    sway_real_t evidence;
    sway_real_t net;      ///< what the evidence grows by, two-second mean
    sway_real_t asked;    ///< acceleration that the steering asks for, two-second mean
    sway_real_t steering; ///< mean square about it
    sway_real_t start[SWAY_TRAILER_UNKNOWNS];       ///< of the trailer, before anything was learnt
    sway_real_t start_error[SWAY_TRAILER_UNKNOWNS]; ///< their standard errors
    sway_real_t start_se; ///< of the critical speed, as the user's values give it; 0: not yet
    sway_real_t speed_m_s;
    sway_complex_t f_s;
    sway_complex_t f_v; ///< at the limit
    sway_single_track_quartic_t quartic;
    sway_single_track_roots_t roots;
    sway_single_track_t stm;
    sway_margin_model_t next;
    sway_margin_model_t model;
    sway_real_t limit_by[SWAY_TRAILER_PARAMETERS];
    sway_real_t ratio_by[SWAY_TRAILER_PARAMETERS];
    sway_observer_t alone;
    sway_observer_t with;
} sway_trailer_watch_t;

/// Starts from the user's values. `assumed`: bits 1 << (state - SWAY_STATE_TRAILER_MASS) of values
/// of the trailer that nobody knows, typical ones; without trailer (axles 0) all are.
void sway_trailer_init(sway_trailer_watch_t *trailer, const sway_vehicle_t *vehicle,
                       uint32_t assumed, int32_t sample_period_us);

/// Takes one row of the grid.
void sway_trailer_push(sway_trailer_watch_t *trailer, const sway_row_t *row);

/// What the next slice of the observers costs about, in the unit of SWAY_SLICE_COST; 0: nothing.
uint32_t sway_trailer_cost(const sway_trailer_watch_t *trailer);

/// One slice of the observers.
void sway_trailer_run(sway_trailer_watch_t *trailer);

/// The model is the observer's to give: no sensor of the trailer, and no proof that there is none.
bool sway_trailer_speaks(const sway_trailer_watch_t *trailer);

/// Begins to compute the model at `speed_m_s`; then slices until false, the result is in
/// trailer->model. Its errors hold what the single-track model leaves out.
void sway_trailer_model_start(sway_trailer_watch_t *trailer, sway_real_t speed_m_s);
uint32_t sway_trailer_model_cost(const sway_trailer_watch_t *trailer);
bool sway_trailer_model_run(sway_trailer_watch_t *trailer);

/// Amplitude of the trailer's yaw rate at the line: of the car's yaw rate and acceleration.
sway_real_t sway_trailer_swing(const sway_trailer_watch_t *trailer, const sway_line_t *line);

/// What is known, in plain integers.
void sway_trailer_report(const sway_trailer_watch_t *trailer, sway_trailer_report_t *report);

/// What is to be kept while the ECU is off.
void sway_trailer_remember(const sway_trailer_watch_t *trailer, sway_trailer_memory_t *memory);

/// Begins with the car of another drive, that it has not to be learnt again; the trailer is as
/// unknown as at the start. After sway_trailer_init().
void sway_trailer_recall(sway_trailer_watch_t *trailer, const sway_trailer_memory_t *memory);

/// Is the trailer the remembered one? Natural logarithm of how many times more probable the drive
/// since sway_trailer_recall() is with it than with one that nobody knows: 0 where nothing was
/// learnt, or where the memory is no covariance. About 300 thousand instructions of a Cortex-M0+:
/// not in a slice.
sway_real_t sway_trailer_likeness(const sway_trailer_watch_t *trailer,
                                  const sway_trailer_memory_t *memory);

#endif

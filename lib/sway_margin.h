/// sway_margin: how far the combination is from instability, by its model and by its signals.
///
/// The model margin puts the identified stiffnesses (with their arguments, as relaxation lengths)
/// and yaw inertias into the single-track model: damping ratio at the present speed, critical speed
/// and its standard error. One window gives noisy values in ordinary driving, so each quantity
/// passes a scalar Kalman filter: it starts at the user's value with the user's likely error,
/// drifts a little with time, and takes every usable estimate by its variance. Windows overlap
/// 16-fold, so an estimate counts as one of SWAY_MARGIN_OVERLAP.
///
/// The signal margin is the growth of the free oscillation itself; it needs no model, but steering
/// or gusts look like damping to it. The combination believes
///   - the model while the oscillation is forced, too small, or not one damped line;
///   - both, weighted by variance, where they agree within three standard errors;
///   - the signal where a clean free oscillation contradicts the model (physics is missing there).
#ifndef SWAY_MARGIN_H
#define SWAY_MARGIN_H

#include "sway_identify.h"
#include "sway_stm.h"

/// Estimates that overlap enough to share their noise.
#define SWAY_MARGIN_OVERLAP 8

/// Parameters whose derivatives are renewed with an estimate.
#define SWAY_MARGIN_TURN 2

/// One filtered quantity: complex stiffness of an axle in N/rad, or a yaw inertia in kgm2
/// (imaginary part 0); variances in their squares.
typedef struct {
    bool strange;    ///< the last estimate did not fit
    bool started;    ///< has a value
    bool identified; ///< at least one estimate is in it
    sway_complex_t value;
    sway_real_t variance_re;
    sway_real_t variance_im;
    sway_complex_t s_by_v; ///< 1/m, of the last estimate: what the imaginary part belongs to
    int64_t time_us;       ///< of the last prediction
} sway_margin_state_t;

typedef struct {
    bool has_model; ///< damping ratio is valid
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
    sway_stm_static_t steady;
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
    sway_stm_quartic_t quartic;
    sway_stm_roots_t roots;
    sway_stm_t stm; ///< with relaxation
    sway_margin_model_t next;
    sway_complex_t limit_per_percent[SWAY_PARAMETER_COUNT]; ///< change of v_crit for +1 %: of the
                                                            ///< value (re), of its argument (im)
    sway_complex_t root_per_percent[SWAY_PARAMETER_COUNT];  ///< change of the dominant root
    /* What stays. */
    sway_margin_model_t model; ///< latest finished
    sway_margin_state_t stiffness[SWAY_AXLE_COUNT];
    sway_margin_state_t inertia[2];
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

/// What the combination is made of.
typedef struct {
    sway_real_t ratio;
    sway_real_t se;
    bool usable;
} sway_margin_damping_t;

/// How much the road and the wind disturb the swing. A swing that is pushed about by disturbances
/// shows any damping over two oscillations: the error of its damping ratio is some amplitude,
/// learnt here, over its own amplitude. (Measured on ordinary driving: 0.3 deg/s over the
/// amplitude.)
typedef struct {
    sway_real_t variance; ///< of the amplitude, (rad/s)^2
    int64_t time_us;
    int32_t learnt_us; ///< how long it has been learnt, up to its memory
    bool started;
} sway_unrest_t;

/// Standard error of the signal's damping ratio: twice that of the fit, the unrest's, and the
/// driver's. A hand that moves the wheel at the line's frequency, so that the yaw rate would follow
/// with `steered_rad_s` if it were slow, adds up to 3/4 steered / amplitude to the damping ratio
/// (1/2 for a plain oscillator; 0.55 to 0.9 for the mode of combinations, by their residues).
sway_real_t sway_margin_signal_se(const sway_unrest_t *unrest, sway_real_t fit_se,
                                  sway_real_t amplitude_rad_s, sway_real_t steered_rad_s);

/// Learns from the difference between the signal's damping ratio and the combined one, less what
/// the driver's hand may have done.
void sway_margin_learn_unrest(sway_unrest_t *unrest, int64_t time_us, sway_real_t difference,
                              sway_real_t amplitude_rad_s, sway_real_t steered_rad_s);

/// Combined damping ratio. `disagrees` is set where the two differ beyond their errors.
sway_belief_t sway_margin_combine(const sway_margin_damping_t *model,
                                  const sway_margin_damping_t *signal,
                                  sway_margin_damping_t *combined, bool *disagrees);

#endif

// SPDX-License-Identifier: MIT
/// sway_line: one damped line shared by all channels, estimated with standard errors.
///
/// Model of channel c over the window, t counted from its middle:
///     x_c(t) = Re(a_c e^((growth + j omega) t)) + mean_c + slope_c t [+ the same at 2 omega, 3
///     omega
///              with their own amplitudes where those stand out of the noise] + white noise
/// omega and growth are common; amplitudes, mean, slope and noise are each channel's own. Least
/// squares weighted by each channel's noise: the maximum-likelihood estimate, found by Gauss-Newton
/// steps with the linear parameters projected out. The window is summed to at most
/// SWAY_FIT_BLOCKS blocks first: a block sum of a damped line is the same line times a known
/// factor, so that costs no bias and, at 10 blocks per oscillation, 1.5 % of precision.
/// Rows marked not valid are left out (their blocks are filled from the model at each step, which
/// has the same solution).
///
/// An estimate is a job run in slices of bounded cost; all integer arithmetic.
#ifndef SWAY_LINE_H
#define SWAY_LINE_H

#include "signal/sway_change.h"
#include "signal/sway_ring.h"

/// Flags of a result; 0 is good.
#define SWAY_LINE_NO_OSCILLATION 0x001U ///< the line does not stand out of noise, mean and slope
#define SWAY_LINE_FORCED 0x002U ///< the steering wheel moves: growth need not be the free one
#define SWAY_LINE_GAP 0x004U    ///< rows are missing in a channel of the estimate
#define SWAY_LINE_SPEED_CHANGING 0x008U ///< speed changes more than allowed over the window
#define SWAY_LINE_NONLINEAR 0x010U      ///< 2f or 3f above 15 % of f in a yaw-rate channel
#define SWAY_LINE_SEEKING 0x020U        ///< no line is held: values are not to be used
#define SWAY_LINE_STARTING 0x040U       ///< the window is not full yet
#define SWAY_LINE_NOT_CONVERGED 0x080U  ///< the last step was not small against its standard error
#define SWAY_LINE_MISFIT 0x100U ///< residual far from white: not one damped line (step, onset)
#define SWAY_LINE_STEERING_MODELLED                                                                \
    0x200U ///< with FORCED: the driver's tone is modelled beside the line

/// One channel's part of a line; SI units: rad, rad/s, m/s2, N.
typedef struct {
    sway_complex_t amplitude; ///< x(t) = Re(amplitude e^((growth + j omega)(t - t_mid)))
    sway_real_t amplitude_se; ///< standard error of |amplitude|
    sway_real_t phase_se_rad; ///< standard error of its argument; 0 where amplitude is 0
    sway_complex_t second;    ///< the part at 2f, e^(2 (growth + j omega)(t - t_mid))
    sway_real_t second_se;    ///< standard error of re and of im
    sway_real_t mean;         ///< at mid-window
    sway_real_t noise_rms;    ///< residual standard deviation per row, as of white noise
} sway_line_channel_t;

typedef struct {
    int64_t mid_time_us;    ///< middle of the window
    int32_t window_samples; ///< rows in the window
    sway_real_t omega_rad_s;
    sway_real_t omega_se_rad_s;
    sway_real_t growth_1_s; ///< damping ratio = -growth / sqrt(growth^2 + omega^2)
    sway_real_t growth_se_1_s;
    sway_real_t speed_m_s;        ///< mean over the window; 0 where speed is not known
    sway_real_t speed_slope_m_s2; ///< least-squares slope over the window
    uint32_t valid_mask;          ///< SWAY_CHANNEL_BIT of the channels with enough data
    uint32_t flags;               ///< SWAY_LINE_...
    sway_line_channel_t channel[SWAY_CHANNELS];
} sway_line_t;

/// What an estimate needs to know.
typedef struct {
    int32_t sample_period_us;
    uint32_t channel_mask;     ///< channels that take part in frequency and growth
    int32_t frequency_min_mhz; ///< band of the line, millihertz
    int32_t frequency_max_mhz;
    int32_t steering_quiet_urad; ///< see sway_track_config_t
    int32_t speed_change_milli;
    uint32_t result_mask;     ///< channels that get a result
    uint32_t harmonics_mask;  ///< channels that had 2f and 3f in their model last time
    sway_real_t forced_rad_s; ///< omega of a tone of the driver that is to be taken apart; or 0
    sway_real_t chirp_rad_s2; ///< known change of omega, |chirp| (window / 2)^2 <= 1 rad; or 0
    bool level; ///< no slopes in the model: for windows of one or two swings that die out, of which
                ///< a slope would take a part
} sway_line_config_t;

/// Weighed sums of all channels for the common parameters, growth and omega times half the window.
typedef struct {
    sway_real_t growth_growth;
    sway_real_t growth_omega;
    sway_real_t omega_omega;
    sway_real_t growth_right;
    sway_real_t omega_right;
    sway_real_t inflated; ///< omega_omega times each channel's inflation for coloured residuals
    sway_real_t all;      ///< omega_omega of all channels, by the residuals of the result
    sway_real_t misfit;   ///< omega_omega of the channels whose residual is no noise
} sway_line_normal_t;

/// What a job keeps of a channel.
typedef struct {
    bool harmonics; ///< 2f and 3f are in the model
    int32_t shift;
    uint32_t lost;    ///< blocks missing in the input
    uint64_t missing; ///< bit per block: not data
    int64_t removed;  ///< mean block sum that was taken out
    sway_real_t parameter[SWAY_FIT_LINEAR];
    int32_t sum[SWAY_FIT_BLOCKS]; ///< block sums less their mean, times 2^-shift
} sway_line_data_t;

/// State of one estimate; contents are private. Nothing of it is needed for the next one.
typedef struct {
    bool final;   ///< this pass makes the result
    bool changed; ///< the result asks for another model
    bool converged;
    bool broken;       ///< amplitude or phase change within the window, before change_time_us
    sway_line_t *line; ///< the result in the making
    uint32_t state;
    uint32_t channel;
    uint32_t passes_left;
    uint32_t refits;
    uint32_t columns;     ///< linear columns of the channel
    uint32_t rounds_left; ///< of filling its missing blocks
    uint32_t block;       ///< rows in a block
    uint32_t head;        ///< ring slot after the newest row of the window
    uint32_t used_mask;   ///< channels that take part
    sway_line_config_t config;
    sway_real_t half_s;     ///< from the middle of the window to the middle of its last block
    int64_t change_time_us; ///< where `broken`
    sway_real_t variance;   ///< of the channel's blocks
    sway_real_t product[SWAY_FIT_COLUMNS]; ///< columns times its data
    sway_line_normal_t normal;
    sway_real_t covariance[3]; ///< of growth and omega times half_s
    sway_complex_t factor[2];  ///< block sum of the line, of 2f, by its value at the block's middle
    sway_real_t factor_size[2];
    sway_fit_basis_t basis;
    sway_fit_system_t system[2]; ///< one line; with 2f and 3f
    sway_change_sums_t sums;     ///< in the pass that makes the result
    sway_line_data_t data[SWAY_CHANNELS];
    int32_t residual[SWAY_FIT_BLOCKS]; ///< of the channel, in the pass that makes the result
} sway_line_job_t;

/// Begins an estimate over the newest `window` rows (SWAY_WINDOW_MIN..SWAY_WINDOW_MAX) from a start
/// frequency, good to about half a bin (1/window). SWAY_ERROR_ARGUMENT; SWAY_ERROR_NO_DATA (the
/// ring holds fewer rows). The rows must stay in the ring for the first SWAY_CHANNELS + 1 slices.
/// `line` is written from now on; it is the result when sway_line_run() has returned false.
sway_error_t sway_line_start(sway_line_job_t *job, const sway_line_config_t *config,
                             const sway_ring_t *ring, uint32_t window, sway_real_t omega_rad_s,
                             sway_line_t *line);

/// Channels that have 2f and 3f in their model, for the next configuration.
uint32_t sway_line_harmonics(const sway_line_job_t *job);

/// What the next slice costs about, in the unit of SWAY_SLICE_COST.
uint32_t sway_line_cost(const sway_line_job_t *job);

/// One slice; true while more is to be done.
bool sway_line_run(sway_line_job_t *job, const sway_ring_t *ring);

/// Damping ratio -growth/sqrt(growth^2 + omega^2) and its standard error.
void sway_line_damping(const sway_line_t *line, sway_real_t *ratio, sway_real_t *se);

/// Ratio of two channels at the line.
typedef struct {
    sway_complex_t ratio;  ///< numerator / denominator, in their SI units
    sway_real_t se;        ///< standard error of re and im of the ratio
    sway_real_t coherence; ///< 0..1: share of the line in both channels' power, geometric mean
} sway_line_ratio_t;

/// numerator(t - numerator_delay) / denominator(t) with the time offset taken out: the numerator is
/// known to be `numerator_delay_us` older than its rows say. SWAY_ERROR_NO_DATA where a channel is
/// not in valid_mask, SWAY_ERROR_SINGULAR where the denominator has no amplitude.
sway_error_t sway_line_ratio(const sway_line_t *line, sway_channel_t numerator,
                             sway_channel_t denominator, int32_t numerator_delay_us,
                             sway_line_ratio_t *result);

/// 1e-6 for the micro-units of most channels, 1e-3 for forces: SI per unit of the ring.
sway_real_t sway_line_unit(sway_channel_t channel);

#endif

// SPDX-License-Identifier: MIT
#include "signal/sway_track.h"

#include <string.h>

/* Rows between searches while no line is held. */
#define SEARCH_HOP 16U
#define HOPS_PER_WINDOW 16U
/* Estimates in a row without a line after which the search begins again. */
#define LOST_LIMIT 3U

enum { TRACK_IDLE, TRACK_SEARCH, TRACK_LINE, TRACK_TONE_SEARCH, TRACK_TONE, TRACK_HELD };

#define STEERING SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE)

sway_track_config_t sway_track_default(int32_t sample_period_us)
{
    const sway_track_config_t config = {.sample_period_us = sample_period_us,
                                        .window_cycles_milli = 2000,
                                        .frequency_min_mhz = 250,
                                        .frequency_max_mhz = 2000,
                                        .channel_mask =
                                            (SWAY_CHANNEL_BIT(SWAY_CHANNELS) - 1U) &
                                            ~SWAY_CHANNEL_BIT(SWAY_CHANNEL_STEERING_WHEEL_ANGLE),
                                        .steering_quiet_urad = 17453,
                                        .speed_change_milli = 50};
    return config;
}

static bool config_is_good(const sway_track_config_t *config)
{
    return config->sample_period_us >= 1000 && config->sample_period_us <= 100000 &&
           config->window_cycles_milli >= 1500 && config->window_cycles_milli <= 6000 &&
           config->frequency_min_mhz >= 100 && config->frequency_max_mhz <= 10000 &&
           config->frequency_max_mhz > config->frequency_min_mhz && config->channel_mask != 0U &&
           config->steering_quiet_urad >= 0 && config->speed_change_milli >= 0;
}

static void empty(sway_track_t *track)
{
    sway_ring_clear(&track->ring);
    memset(&track->spectrum, 0, sizeof track->spectrum);
    track->state = TRACK_IDLE;
    track->locked = false;
    track->free = false;
    track->lost = 0;
    track->past_count = 0;
    track->rows_to_hop = SEARCH_HOP;
    track->harmonics_mask = 0;
    track->change_time_us = INT64_MIN;
}

sway_error_t sway_track_init(sway_track_t *track, const sway_track_config_t *config,
                             sway_track_work_t *work)
{
    if (track == NULL || config == NULL || work == NULL || !config_is_good(config)) {
        return SWAY_ERROR_ARGUMENT;
    }
    memset(track, 0, sizeof *track);
    track->config = *config;
    track->work = work;
    track->line.flags = SWAY_LINE_STARTING | SWAY_LINE_SEEKING;
    empty(track);
    return SWAY_OK;
}

void sway_track_push(sway_track_t *track, const sway_row_t *row)
{
    if (row->restart && track->ring.filled > 0U) {
        empty(track);
    }
    sway_ring_push(&track->ring, row);
    track->spectrum_first = true;
    if (track->spectrum.window > 0U) {
        sway_spectrum_push(&track->spectrum, &track->ring);
    }
    if (track->rows_to_hop > 0U) {
        track->rows_to_hop -= 1U;
    }
}

/* Rows in the configured number of oscillations, before any limit. */
static uint32_t wanted_window(const sway_track_t *track, sway_real_t omega_rad_s)
{
    const sway_real_t row_s = sway_real_micro(track->config.sample_period_us);
    const sway_real_t turns = sway_real_ratio(track->config.window_cycles_milli, 500);
    const sway_real_t angle = sway_real_mul(turns, sway_real_pi());
    const sway_real_t rows = sway_real_div(angle, sway_real_mul(omega_rad_s, row_s));
    return (uint32_t)sway_real_to_int(rows, 1, SWAY_WINDOW_MIN, SWAY_WINDOW_MAX);
}

static void give_up(sway_track_t *track, uint32_t flags)
{
    track->line.flags = flags | SWAY_LINE_SEEKING;
    track->line.mid_time_us = track->ring.newest_time_us;
    track->line.valid_mask = 0;
    track->sequence += 1U;
    track->state = TRACK_IDLE;
    track->rows_to_hop = SEARCH_HOP;
}

/* Change of omega over about one window, in rad/s2; 0 where it is within 4 standard errors, or more
 * than 1 rad at the ends of the window. */
static sway_real_t known_chirp(const sway_track_t *track, uint32_t window)
{
    const sway_real_t none = sway_real_zero();
    if (!track->locked || track->past_count < SWAY_TRACK_HISTORY) {
        return none;
    }
    const uint32_t oldest = track->past_count % SWAY_TRACK_HISTORY;
    const uint32_t newest = (track->past_count - 1U) % SWAY_TRACK_HISTORY;
    const sway_real_t change = sway_real_sub(track->past_omega[newest], track->past_omega[oldest]);
    const sway_real_t se_new = track->past_se[newest];
    const sway_real_t se_old = track->past_se[oldest];
    const sway_real_t spread =
        sway_real_add(sway_real_mul(se_new, se_new), sway_real_mul(se_old, se_old));
    const sway_real_t bar = sway_real_scale(spread, 4);
    const sway_real_t span_s = sway_real_micro(track->past_us[newest] - track->past_us[oldest]);
    const sway_real_t chirp = sway_real_div(change, span_s);
    const sway_real_t half_s =
        sway_real_scale(sway_real_micro((int64_t)window * track->config.sample_period_us), -1);
    const sway_real_t bow = sway_real_mul(sway_real_abs(chirp), sway_real_mul(half_s, half_s));
    const bool known =
        sway_real_less(bar, sway_real_mul(change, change)) && sway_real_less(bow, sway_real_int(1));
    return known ? chirp : none;
}

/* Only undisturbed estimates tell how the frequency drifts. */
static void remember(sway_track_t *track)
{
    const uint32_t disturbed =
        SWAY_LINE_FORCED | SWAY_LINE_GAP | SWAY_LINE_STARTING | SWAY_LINE_MISFIT;
    const uint32_t at = track->past_count % SWAY_TRACK_HISTORY;
    if ((track->line.flags & disturbed) != 0U) {
        track->past_count = 0;
        return;
    }
    track->past_omega[at] = track->line.omega_rad_s;
    track->past_se[at] = track->line.omega_se_rad_s;
    track->past_us[at] = track->line.mid_time_us;
    track->past_count += 1U;
}

static sway_line_config_t line_config(const sway_track_t *track)
{
    const sway_track_config_t *config = &track->config;
    const sway_line_config_t line = {.sample_period_us = config->sample_period_us,
                                     .channel_mask = config->channel_mask,
                                     .frequency_min_mhz = config->frequency_min_mhz,
                                     .frequency_max_mhz = config->frequency_max_mhz,
                                     .steering_quiet_urad = config->steering_quiet_urad,
                                     .speed_change_milli = config->speed_change_milli,
                                     .result_mask = UINT32_MAX,
                                     .harmonics_mask = track->harmonics_mask};
    return line;
}

static void start_line(sway_track_t *track, sway_real_t omega_rad_s)
{
    const uint32_t wanted = wanted_window(track, omega_rad_s);
    const uint32_t filled = track->ring.filled;
    const uint32_t window = wanted < filled ? wanted : filled;
    sway_line_config_t line = line_config(track);
    line.chirp_rad_s2 = known_chirp(track, window);
    line.forced_rad_s = track->forced_rad_s;
    const bool enough = 10U * window >= 7U * wanted;
    if (!enough || sway_line_start(&track->work->job, &line, &track->ring, window, omega_rad_s,
                                   &track->line) != SWAY_OK) {
        give_up(track, SWAY_LINE_STARTING);
        return;
    }
    if (window < wanted) {
        track->line.flags |= SWAY_LINE_STARTING;
    }
    if (line.forced_rad_s.m != 0) {
        track->line.flags |= SWAY_LINE_STEERING_MODELLED;
    }
    track->state = TRACK_LINE;
    track->rows_to_hop = window / HOPS_PER_WINDOW;
}

/* The channel whose line stands out most. */
static sway_channel_t pilot(const sway_track_t *track)
{
    uint32_t best = 0;
    sway_real_t most = sway_real_int(-1);
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        const sway_line_channel_t *channel = &track->line.channel[c];
        const sway_real_t size = sway_complex_abs(channel->amplitude);
        const sway_real_t clear = sway_real_div(size, channel->amplitude_se);
        if ((track->line.valid_mask & track->config.channel_mask & SWAY_CHANNEL_BIT(c)) != 0U &&
            sway_real_less(most, clear)) {
            most = clear;
            best = c;
        }
    }
    return (sway_channel_t)best;
}

/* Where the sliding spectrum sees the line. */
static sway_real_t spectrum_omega(const sway_track_t *track)
{
    const sway_channel_t channel = track->pilot;
    sway_real_t size[SWAY_BINS];
    uint32_t best = 1;
    size[0] = sway_real_zero();
    for (uint32_t k = 1; k < SWAY_BINS; k++) {
        size[k] = sway_complex_abs(sway_spectrum_hann(&track->spectrum, channel, k));
        best = k + 1U < SWAY_BINS && sway_real_less(size[best], size[k]) ? k : best;
    }
    const sway_real_t x = sway_search_offset(size[best - 1U], size[best], size[best + 1U]);
    const sway_real_t bins = sway_real_add(sway_real_int((int32_t)best), x);
    const int64_t span_us = (int64_t)track->config.sample_period_us * track->spectrum.window;
    const sway_real_t turn = sway_real_scale(sway_real_pi(), 1);
    return sway_real_div(sway_real_mul(turn, bins), sway_real_micro(span_us));
}

static bool start_search(sway_track_t *track, uint32_t mask)
{
    const sway_search_config_t search = {.channel_mask = mask,
                                         .sample_period_us = track->config.sample_period_us,
                                         .frequency_min_mhz = track->config.frequency_min_mhz,
                                         .frequency_max_mhz = track->config.frequency_max_mhz};
    return sway_search_start(&track->work->search, &search, &track->ring) == SWAY_OK;
}

static void start_held_line(sway_track_t *track)
{
    const bool look = track->lost > 0U && sway_spectrum_ready(&track->spectrum);
    start_line(track, look ? spectrum_omega(track) : track->omega_rad_s);
}

static void start_estimate(sway_track_t *track)
{
    track->forced_rad_s = sway_real_zero();
    if (track->lost > 0U) {
        track->pilot = pilot(track); // now: a line of the steering wheel would take its place
    }
    if (!track->locked) {
        if (start_search(track, track->config.channel_mask)) {
            track->state = TRACK_SEARCH;
        } else {
            give_up(track, SWAY_LINE_STARTING);
        }
    } else if (track->free && (track->line.flags & SWAY_LINE_FORCED) != 0U &&
               start_search(track, STEERING)) {
        track->state = TRACK_TONE_SEARCH;
    } else {
        track->state = TRACK_HELD;
    }
}

/* Fits a line to the steering wheel angle alone, where the search saw one. */
static void run_tone_search(sway_track_t *track)
{
    sway_real_t omega;
    if (sway_search_run(&track->work->search, &track->ring)) {
        return;
    }
    const uint32_t window = wanted_window(track, track->omega_rad_s);
    sway_line_config_t tone = line_config(track);
    tone.channel_mask = STEERING;
    tone.result_mask = STEERING;
    if (sway_search_result(&track->work->search, &omega) &&
        sway_line_start(&track->work->job, &tone, &track->ring, window, omega, &track->line) ==
            SWAY_OK) {
        track->state = TRACK_TONE;
    } else {
        track->state = TRACK_HELD;
    }
}

/* The tone counts if it is clean and steady over the whole window, and a quarter of a bin or more
 * from the line: what is nearer is the line itself, driven. */
static void take_tone(sway_track_t *track)
{
    const uint32_t bad = SWAY_LINE_NO_OSCILLATION | SWAY_LINE_NOT_CONVERGED | SWAY_LINE_MISFIT;
    const sway_line_t *tone = &track->line;
    const sway_real_t span_s = sway_real_scale(track->work->job.half_s, 1);
    const sway_real_t apart =
        sway_real_mul(span_s, sway_real_sub(tone->omega_rad_s, track->omega_rad_s));
    const sway_real_t change = sway_real_mul(span_s, tone->growth_1_s);
    const sway_real_t quarter = sway_real_scale(sway_real_pi(), -1);
    const sway_real_t steady = sway_real_ratio(1, 10);
    const bool whole = track->work->job.data[SWAY_CHANNEL_STEERING_WHEEL_ANGLE].missing == 0U;
    if ((tone->flags & bad) == 0U && whole && sway_real_less(quarter, sway_real_abs(apart)) &&
        sway_real_less(sway_real_abs(change), steady)) {
        track->forced_rad_s = tone->omega_rad_s;
    }
    track->state = TRACK_HELD;
}

/* The sliding sums follow the window when it has changed by more than a sixteenth. */
static void follow_window(sway_track_t *track)
{
    const uint32_t wanted = wanted_window(track, track->omega_rad_s);
    const uint32_t have = track->spectrum.window;
    const uint32_t apart = wanted > have ? wanted - have : have - wanted;
    if (16U * apart > wanted) {
        (void)sway_spectrum_init(&track->spectrum, wanted);
    }
}

/* Whether the driver's tone is larger than the line beside it in the clearest channel: then what
 * moves the vehicle is the driver, and the driven line is the one to hold. */
static bool tone_is_larger(const sway_track_t *track)
{
    const sway_line_data_t *data = &track->work->job.data[pilot(track)];
    const sway_complex_t tone = sway_complex(data->parameter[6], data->parameter[7]);
    const sway_complex_t line = sway_complex_scale(
        sway_complex(data->parameter[0], data->parameter[1]), track->work->job.basis.scale);
    return sway_real_less(sway_complex_norm(line), sway_complex_norm(tone));
}

/* Marks the windows that hold a break. Where it is, the first window that shows it tells best: it
 * has just come in. While the driver steers, what comes in is no step but lasts; such a window
 * marks itself only, for what it says of the place is not reliable. */
static void keep_change(sway_track_t *track)
{
    sway_line_t *line = &track->line;
    const int64_t half_us = (int64_t)line->window_samples * track->config.sample_period_us / 2;
    if (line->mid_time_us - half_us < track->change_time_us) {
        line->flags |= SWAY_LINE_MISFIT;
    } else if (track->work->job.broken && (line->flags & SWAY_LINE_FORCED) == 0U) {
        track->change_time_us = track->work->job.change_time_us;
    }
}

static void take_line(sway_track_t *track)
{
    const uint32_t bad = SWAY_LINE_NO_OSCILLATION | SWAY_LINE_NOT_CONVERGED;
    keep_change(track);
    track->state = TRACK_IDLE;
    if ((track->line.flags & bad) == 0U) {
        track->locked = true;
        track->lost = 0;
        track->omega_rad_s = track->line.omega_rad_s;
        track->free = track->free || (track->line.flags & SWAY_LINE_FORCED) == 0U;
        remember(track);
        follow_window(track);
    } else {
        track->lost += 1U;
        track->locked = track->locked && track->lost < LOST_LIMIT;
    }
    if ((track->line.flags & SWAY_LINE_STEERING_MODELLED) != 0U && tone_is_larger(track)) {
        track->free = false;
        track->locked = false;
    }
    if (!track->locked) {
        track->free = false;
        track->past_count = 0;
        track->line.flags |= SWAY_LINE_SEEKING;
    }
    track->sequence += 1U;
}

static void run_search(sway_track_t *track)
{
    sway_real_t omega;
    if (sway_search_run(&track->work->search, &track->ring)) {
        return;
    }
    if (sway_search_result(&track->work->search, &omega)) {
        start_line(track, omega);
    } else {
        give_up(track, SWAY_LINE_NO_OSCILLATION);
    }
}

static bool spectrum_pending(const sway_track_t *track)
{
    return track->spectrum.window > 0U && !sway_spectrum_ready(&track->spectrum);
}

static void run_idle(sway_track_t *track)
{
    if (track->rows_to_hop == 0U) {
        start_estimate(track);
    }
}

/* See SWAY_SLICE_COST. */
enum { COST_START = 12, COST_HELD = 36, COST_SEARCH = 60, COST_SPECTRUM = 41 };

/* With each row the sums are filled by a slice, before the estimate goes on. */
static bool spectrum_is_next(const sway_track_t *track)
{
    return track->spectrum_first && spectrum_pending(track);
}

uint32_t sway_track_cost(const sway_track_t *track)
{
    if (spectrum_is_next(track)) {
        return COST_SPECTRUM;
    }
    switch (track->state) {
    case TRACK_SEARCH:
    case TRACK_TONE_SEARCH:
        return COST_SEARCH;
    case TRACK_HELD:
        return COST_HELD;
    case TRACK_LINE:
    case TRACK_TONE:
        return sway_line_cost(&track->work->job);
    default:
        return track->rows_to_hop == 0U ? COST_START : 0U;
    }
}

static void run_line(sway_track_t *track)
{
    if (sway_line_run(&track->work->job, &track->ring)) {
        return;
    }
    track->harmonics_mask = sway_line_harmonics(&track->work->job);
    if (track->state == TRACK_TONE) {
        take_tone(track);
    } else {
        take_line(track);
    }
}

bool sway_track_run(sway_track_t *track)
{
    if (spectrum_is_next(track)) {
        (void)sway_spectrum_run(&track->spectrum, &track->ring);
        track->spectrum_first = false;
        return true;
    }
    switch (track->state) {
    case TRACK_SEARCH:
        run_search(track);
        break;
    case TRACK_TONE_SEARCH:
        run_tone_search(track);
        break;
    case TRACK_LINE:
    case TRACK_TONE:
        run_line(track);
        break;
    case TRACK_HELD:
        start_held_line(track);
        break;
    default:
        run_idle(track);
        break;
    }
    return track->state != TRACK_IDLE || track->rows_to_hop == 0U || spectrum_is_next(track);
}

const sway_line_t *sway_track_line(const sway_track_t *track)
{
    return &track->line;
}

uint32_t sway_track_sequence(const sway_track_t *track)
{
    return track->sequence;
}

/* The estimator of lib/ behind plain arrays of doubles, for tests/bench/estimator.py. */
#include <math.h>
#include <string.h>

#include "signal/sway_track.h"

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

static sway_ring_t ring;
static sway_search_t seek;
static sway_line_job_t job;
static sway_line_t result;
static sway_track_t track;
static sway_track_work_t work;

enum { COMMON = 10, PER_CHANNEL = 10 };

static void export_line(const sway_line_t *line, double *common, double *channel)
{
    common[0] = to_double(line->omega_rad_s);
    common[1] = to_double(line->omega_se_rad_s);
    common[2] = to_double(line->growth_1_s);
    common[3] = to_double(line->growth_se_1_s);
    common[4] = (double)line->mid_time_us * 1e-6;
    common[5] = line->window_samples;
    common[6] = line->flags;
    common[7] = line->valid_mask;
    common[8] = to_double(line->speed_m_s);
    common[9] = to_double(line->speed_slope_m_s2);
    for (int c = 0; c < SWAY_CHANNELS; c++, channel += PER_CHANNEL) {
        const sway_line_channel_t *from = &line->channel[c];
        channel[0] = to_double(from->amplitude.re);
        channel[1] = to_double(from->amplitude.im);
        channel[2] = to_double(from->amplitude_se);
        channel[3] = to_double(from->phase_se_rad);
        channel[4] = to_double(from->second.re);
        channel[5] = to_double(from->second.im);
        channel[6] = to_double(from->second_se);
        channel[7] = to_double(from->mean);
        channel[8] = to_double(from->noise_rms);
        channel[9] = 0;
    }
}

/* samples[rows][SWAY_CHANNELS]; channels that take part by mask. Returns the slices needed. */
int estimate(const int32_t *samples, int rows, unsigned mask, double *common, double *channel)
{
    const sway_search_config_t where = {mask, 10000, 250, 2000};
    const sway_line_config_t what = {.sample_period_us = 10000,
                                     .channel_mask = mask,
                                     .frequency_min_mhz = 250,
                                     .frequency_max_mhz = 2000,
                                     .steering_quiet_urad = 17453,
                                     .speed_change_milli = 50,
                                     .result_mask = UINT32_MAX};
    sway_row_t tick;
    sway_real_t omega;
    int slices = 0;
    sway_ring_clear(&ring);
    memset(&tick, 0, sizeof tick);
    tick.valid_mask = mask;
    tick.present_mask = mask;
    for (int i = 0; i < rows; i++) {
        tick.time_us = (int64_t)i * 10000;
        memcpy(tick.value, samples + (size_t)i * SWAY_CHANNELS, SWAY_CHANNELS * sizeof *samples);
        sway_ring_push(&ring, &tick);
    }
    if (sway_search_start(&seek, &where, &ring) != SWAY_OK) {
        return -1;
    }
    while (sway_search_run(&seek, &ring)) {
        slices++;
    }
    if (!sway_search_result(&seek, &omega)) {
        return -2;
    }
    common[9] = to_double(omega);
    if (sway_line_start(&job, &what, &ring, (uint32_t)rows, omega, &result) != SWAY_OK) {
        return -3;
    }
    while (sway_line_run(&job, &ring)) {
        slices++;
    }
    export_line(&result, common, channel);
    common[9] = to_double(omega);
    return slices;
}

static sway_grid_t grid;

typedef struct {
    double *common;
    double *channel;
    int records;
    int limit;
    uint32_t sequence;
} log_t;

static void push(const sway_row_t *tick, log_t *log)
{
    sway_track_push(&track, tick);
    for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
        (void)sway_track_run(&track);
        if (sway_track_sequence(&track) != log->sequence && log->records < log->limit) {
            log->sequence = sway_track_sequence(&track); // its line stays until the next slice
            export_line(sway_track_line(&track), log->common + (size_t)log->records * COMMON,
                        log->channel + (size_t)log->records * SWAY_CHANNELS * PER_CHANNEL);
            log->records++;
        }
    }
}

static int start(unsigned mask, int cycles_milli)
{
    sway_track_config_t config = sway_track_default(10000);
    config.window_cycles_milli = cycles_milli;
    config.channel_mask = mask & config.channel_mask;
    return (int)sway_track_init(&track, &config, &work);
}

/* The whole loop, row by row; writes one record per new estimate, at most `limit`. valid[rows] is
 * the mask of each row. Returns the number of records. */
int follow(const int32_t *samples, const uint32_t *valid, int rows, unsigned mask, int cycles_milli,
           double *common, double *channel, int limit)
{
    log_t log = {common, channel, 0, limit, 0};
    sway_row_t tick;
    if (start(mask, cycles_milli) != 0) {
        return -1;
    }
    memset(&tick, 0, sizeof tick);
    tick.present_mask = mask;
    for (int i = 0; i < rows; i++) {
        tick.time_us = (int64_t)i * 10000;
        tick.valid_mask = valid[i];
        memcpy(tick.value, samples + (size_t)i * SWAY_CHANNELS, SWAY_CHANNELS * sizeof *samples);
        push(&tick, &log);
    }
    return log.records;
}

/* The same from samples with their own times, through the grid. Returns the number of records. */
int follow_samples(const int64_t *time_us, const int32_t *input, const int32_t *value, int count,
                   unsigned mask, int cycles_milli, double *common, double *channel, int limit)
{
    const sway_grid_config_t config = sway_grid_default(10000);
    log_t log = {common, channel, 0, limit, 0};
    sway_row_t tick;
    if (start(mask, cycles_milli) != 0 || sway_grid_init(&grid, &config) != SWAY_OK) {
        return -1;
    }
    for (int i = 0; i < count; i++) {
        (void)sway_grid_input(&grid, (sway_input_t)input[i], time_us[i], value[i]);
        while (sway_grid_next_row(&grid, &tick)) {
            push(&tick, &log);
        }
    }
    return log.records;
}

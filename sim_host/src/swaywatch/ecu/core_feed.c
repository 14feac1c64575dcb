#include "core_feed.h"

#include <math.h>
#include <string.h>

#include "sway_version.h"

/// The feed with the earliest next sample; feed_count where all are at their end.
static size_t earliest(const core_feed_t *feeds, size_t feed_count)
{
    size_t best = feed_count;
    for (size_t i = 0; i < feed_count; i++) {
        const core_feed_t *feed = &feeds[i];
        if (feed->next < feed->count &&
            (best == feed_count ||
             feed->time_us[feed->next] < feeds[best].time_us[feeds[best].next])) {
            best = i;
        }
    }
    return best;
}

size_t core_feed(sway_core_t *core, core_feed_t *feeds, size_t feed_count, int64_t until_us,
                 sway_status_t *status, size_t room, bool *done)
{
    size_t written = 0;
    *done = false;
    while (written < room) {
        const size_t which = earliest(feeds, feed_count);
        if (which == feed_count || feeds[which].time_us[feeds[which].next] >= until_us) {
            *done = true;
            break;
        }
        core_feed_t *feed = &feeds[which];
        const uint32_t before = sway_core_status(core)->sequence;
        (void)sway_core_input(core, (sway_input_t)feed->input, feed->time_us[feed->next],
                              feed->value[feed->next]); /* refusals are counted by the core */
        feed->next++;
        while (sway_core_run(core)) {
        }
        if (sway_core_status(core)->sequence != before) {
            status[written++] = *sway_core_status(core);
        }
    }
    return written;
}

uint32_t core_version(void)
{
    return (uint32_t)SWAY_VERSION;
}

void core_protect(const uint32_t *can_id, uint8_t *data, size_t width, size_t count)
{
    uint8_t counter[2048] = {0};
    for (size_t i = 0; i < count; i++) {
        uint8_t *const next = &counter[can_id[i] & 2047U];
        sway_e2e_protect(can_id[i], *next, data + i * width);
        *next = sway_e2e_next(*next);
    }
}

size_t core_replay(sway_node_t *node, const int64_t *time_us, const uint32_t *can_id,
                   const uint8_t *length, const uint8_t *data, size_t width, size_t count,
                   size_t *next, int64_t *out_time_us, uint32_t *out_id, uint8_t *out_data,
                   size_t room)
{
    size_t written = 0;
    for (;;) {
        uint8_t out_length = 0;
        while (written < room &&
               sway_node_transmit(node, &out_id[written], &out_length, out_data + 8 * written)) {
            out_time_us[written] = *next > 0 ? time_us[*next - 1] : 0;
            written++;
        }
        if (written == room || *next == count) {
            break;
        }
        (void)sway_node_receive(node, time_us[*next], can_id[*next], length[*next],
                                data + *next * width); /* refusals are counted by the node */
        (*next)++;
        while (sway_node_run(node)) {
        }
    }
    return written;
}

static double to_double(sway_real_t x)
{
    return ldexp((double)x.m, x.e);
}

/* Channel 0 of the core is the steering wheel, which it judges by itself: left out here. */
static void fill_ring(sway_ring_t *ring, const int32_t *sample, uint32_t rows, uint32_t channels,
                      int32_t sample_period_us)
{
    sway_row_t tick;
    memset(&tick, 0, sizeof tick);
    tick.valid_mask = ((1U << channels) - 1U) << 1U;
    tick.present_mask = tick.valid_mask;
    sway_ring_clear(ring);
    for (uint32_t i = 0; i < rows; i++) {
        tick.time_us = (int64_t)i * sample_period_us;
        memcpy(tick.value + 1, sample + (size_t)i * channels, channels * sizeof *sample);
        sway_ring_push(ring, &tick);
    }
}

static void copy_line(const sway_line_t *line, uint32_t channels, core_line_t *found)
{
    found->flags = line->flags;
    found->rows = (uint32_t)line->window_samples;
    found->omega_rad_s = to_double(line->omega_rad_s);
    found->omega_se_rad_s = to_double(line->omega_se_rad_s);
    found->growth_1_s = to_double(line->growth_1_s);
    found->growth_se_1_s = to_double(line->growth_se_1_s);
    for (uint32_t c = 0; c < channels; c++) {
        const sway_line_channel_t *from = &line->channel[c + 1U];
        const double unit = to_double(sway_line_unit((sway_channel_t)(c + 1U)));
        found->amplitude_re[c] = to_double(from->amplitude.re) / unit;
        found->amplitude_im[c] = to_double(from->amplitude.im) / unit;
        found->mean[c] = to_double(from->mean) / unit;
        found->noise_rms[c] = to_double(from->noise_rms) / unit;
    }
}

void core_window(core_window_t *memory, const int32_t *sample, uint32_t rows, uint32_t channels,
                 uint32_t used_mask, int32_t sample_period_us, double omega_rad_s, bool level,
                 core_line_t *found)
{
    const sway_line_config_t config = {.sample_period_us = sample_period_us,
                                       .channel_mask = used_mask << 1U,
                                       .frequency_min_mhz = 100,
                                       .frequency_max_mhz = 10000,
                                       .steering_quiet_urad = INT32_MAX,
                                       .speed_change_milli = INT32_MAX,
                                       .result_mask = UINT32_MAX,
                                       .level = level};
    memset(found, 0, sizeof *found);
    if (channels < 1U || channels >= SWAY_CHANNELS) {
        found->error = SWAY_ERROR_ARGUMENT;
        return;
    }
    fill_ring(&memory->ring, sample, rows, channels, sample_period_us);
    found->error = sway_line_start(&memory->job, &config, &memory->ring, rows,
                                   sway_real_micro((int64_t)(omega_rad_s * 1e6)), &memory->line);
    if (found->error != SWAY_OK) {
        return;
    }
    while (sway_line_run(&memory->job, &memory->ring)) {
    }
    copy_line(&memory->line, channels, found);
}

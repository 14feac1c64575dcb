#include "core_feed.h"

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

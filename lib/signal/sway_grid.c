// SPDX-License-Identifier: MIT
#include "signal/sway_grid.h"

#include <string.h>

#include "arithmetic/sway_int64.h"

/* A stamp this far ahead of everything else is accepted only when a second one agrees. */
#define JUMP_US 500000
/* A jump this long starts the grid anew instead of handing out empty rows. */
#define RESTART_US 2000000
/* An input this long silent is not waited for. */
#define SILENT_US 1000000
#define REFUSALS_TO_RESTART 16U
/* Samples over which the rate of an input is averaged; percentages of the nominal interval. */
#define RATE_SAMPLES 64
#define RATE_LEAVE 6
#define RATE_RETURN 4

static const int32_t limits[SWAY_INPUT_COUNT] = {
    12600000, 5300000,  40000000, 5300000,  40000000, 1600000,  50000000, 50000000, 50000000,
    50000000, 50000000, 50000000, 50000000, 50000000, 50000000, 50000000, 50000000, 50000000,
    50000000, 50000000, 50000000, 50000000, 50000000, 50000000, 120000};

static bool is_unsigned(sway_input_t input)
{
    return (input >= SWAY_INPUT_CAR_FZ_FL && input <= SWAY_INPUT_CAR_FZ_RR) ||
           input >= SWAY_INPUT_TRAILER_FZ_FL; // the last of them, with the speed
}

int32_t sway_grid_limit(sway_input_t input)
{
    return (uint32_t)input < SWAY_INPUT_COUNT ? limits[input] : 0;
}

sway_grid_config_t sway_grid_default(int32_t sample_period_us)
{
    const sway_grid_config_t config = {.sample_period_us = sample_period_us,
                                       .max_gap_us = 60000,
                                       .max_speed_gap_us = 500000,
                                       .max_wait_us = 100000};
    return config;
}

static bool within(int32_t value, int32_t low, int32_t high)
{
    return value >= low && value <= high;
}

static bool config_is_good(const sway_grid_config_t *config)
{
    const int32_t period = config->sample_period_us;
    if (!within(period, 1000, 100000) || !within(config->max_gap_us, period, JUMP_US) ||
        !within(config->max_speed_gap_us, period, RESTART_US) ||
        !within(config->max_wait_us, 0, period * (SWAY_GRID_ROWS - 2))) {
        return false;
    }
    if (config->input_period_us != 0 && !within(config->input_period_us, 1000, 100000)) {
        return false;
    }
    for (uint32_t i = 0; i < SWAY_INPUT_PLACES; i++) {
        if (!within(config->delay_us[i], -500000, 500000)) {
            return false;
        }
    }
    return true;
}

sway_error_t sway_grid_init(sway_grid_t *grid, const sway_grid_config_t *config)
{
    if (grid == NULL || config == NULL || !config_is_good(config)) {
        return SWAY_ERROR_ARGUMENT;
    }
    memset(grid, 0, sizeof *grid);
    grid->config = *config;
    return SWAY_OK;
}

static void count(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        *counter += 1U;
    }
}

/* The first row at or after `time_us`. */
static int64_t row_at_or_after(const sway_grid_t *grid, int64_t time_us)
{
    const int64_t period = grid->config.sample_period_us;
    int64_t row = sway_int64_divide(time_us, period) * period;
    if (row < time_us) {
        row += period;
    }
    return row;
}

static void start_at(sway_grid_t *grid, int64_t time_us)
{
    for (uint32_t i = 0; i < SWAY_INPUT_PLACES; i++) {
        grid->input[i].timed = false;
        grid->input[i].silent = false;
        grid->input[i].time_us = time_us;
    }
    memset(grid->filled, 0, sizeof grid->filled);
    memset(grid->valid, 0, sizeof grid->valid);
    grid->next_time_us = row_at_or_after(grid, time_us);
    grid->newest_time_us = time_us;
    grid->restart = true;
    if (grid->running) {
        count(&grid->faults.restarts);
    }
    grid->running = true;
}

static bool refuse_time(sway_grid_t *grid)
{
    count(&grid->faults.time_backward);
    grid->refused += 1U;
    return false;
}

/* A stamp before the input's last or far behind the rows. After many in a row the clock counts as
 * restarted. */
static bool accept_old(sway_grid_t *grid, int64_t time_us)
{
    if (grid->refused + 1U < REFUSALS_TO_RESTART) {
        return refuse_time(grid);
    }
    count(&grid->faults.time_backward);
    start_at(grid, time_us);
    return true;
}

/* A stamp far ahead of all others: accepted when a second one is near it. */
static bool accept_jump(sway_grid_t *grid, int64_t time_us)
{
    const int64_t apart = time_us - grid->suspect_us;
    if (!grid->suspected || apart > JUMP_US || apart < -JUMP_US) {
        grid->suspected = true;
        grid->suspect_us = time_us;
        return refuse_time(grid);
    }
    if (time_us > grid->newest_time_us + RESTART_US) {
        start_at(grid, time_us);
    }
    return true;
}

/* Whether the stamp can be accepted; keeps the clock of the grid. */
static bool accept_time(sway_grid_t *grid, const sway_grid_input_t *in, int64_t time_us)
{
    if (!grid->running) {
        start_at(grid, time_us);
    }
    const bool old =
        (in->timed && time_us < in->time_us) || time_us < grid->next_time_us - SILENT_US;
    if (old && !accept_old(grid, time_us)) {
        return false;
    }
    if (time_us > grid->newest_time_us + JUMP_US && !accept_jump(grid, time_us)) {
        return false;
    }
    grid->suspected = false;
    grid->refused = 0;
    if (time_us > grid->newest_time_us) {
        grid->newest_time_us = time_us;
    }
    return true;
}

/* delta * part / span, rounded, for 0 <= part < span. Short spans, and those are all that count as
 * data, need no 64-bit division: delta = q span + r, and r part < 2^32. */
static int32_t share(int32_t delta, int64_t part, int64_t span)
{
    const uint32_t size = delta < 0 ? 0U - (uint32_t)delta : (uint32_t)delta;
    uint32_t result;
    if (span < 65536) {
        const uint32_t short_span = (uint32_t)span;
        const uint32_t rest = size % short_span * (uint32_t)part; // below 65535^2
        result = size / short_span * (uint32_t)part + rest / short_span +
                 (uint32_t)(rest % short_span >= short_span - rest % short_span);
    } else {
        result = (uint32_t)sway_int64_divide((int64_t)size * part + span / 2, span);
    }
    return delta < 0 ? -(int32_t)result : (int32_t)result;
}

/* For from->time_us < at_us < to_us. */
static int32_t interpolate(const sway_grid_input_t *from, int64_t to_us, int32_t to, int64_t at_us)
{
    const int64_t span = to_us - from->time_us;
    return from->value + share(to - from->value, at_us - from->time_us, span);
}

static void put_row(sway_grid_t *grid, uint32_t slot, uint32_t place, int32_t value, bool valid)
{
    const uint32_t bit = (uint32_t)1U << place;
    grid->row[slot][place] = value;
    grid->filled[slot] |= bit;
    grid->valid[slot] |= valid ? bit : 0U;
}

/* Fills the waiting rows after the input's last sample up to that of now. */
static void fill_rows(sway_grid_t *grid, uint32_t place, const sway_grid_input_t *now,
                      bool span_valid)
{
    const sway_grid_input_t *last = &grid->input[place];
    int64_t row = grid->next_time_us;
    if (now->time_us < row) {
        count(&grid->faults.late);
    }
    for (uint32_t i = 0; i < SWAY_GRID_ROWS && row <= now->time_us; i++) {
        const uint32_t slot = (grid->next_slot + i) & (SWAY_GRID_ROWS - 1U);
        if (row == now->time_us) {
            put_row(grid, slot, place, now->value,
                    span_valid || (now->usable && !last->stamp_refused));
        } else if (last->timed && row > last->time_us) {
            put_row(grid, slot, place, interpolate(last, now->time_us, now->value, row),
                    span_valid);
        }
        row += grid->config.sample_period_us;
    }
}

/* Whether the input has had no sample for too long at `time_us`. Such a gap is counted once. */
static bool is_silent(sway_grid_t *grid, uint32_t place, int64_t time_us)
{
    sway_grid_input_t *in = &grid->input[place];
    const int32_t max_gap =
        place == SWAY_PLACE_OF_SPEED ? grid->config.max_speed_gap_us : grid->config.max_gap_us;
    const bool silent = in->seen && time_us - in->time_us > max_gap;
    if (silent && !in->silent) {
        in->silent = true;
        count(&grid->faults.gaps);
    }
    return silent;
}

/* `span` less the nearest multiple of the nominal interval, in us. */
static int32_t off_nominal(int32_t nominal, int32_t span)
{
    const int32_t rest =
        2 * span < 3 * nominal ? span - nominal : (int32_t)((uint32_t)span % (uint32_t)nominal);
    return 2 * rest > nominal ? rest - nominal : rest;
}

/* Follows the rate of an input that has a sample at `time_us`. */
static void watch_rate(sway_grid_t *grid, sway_grid_input_t *in, int64_t time_us)
{
    const int32_t nominal = grid->config.input_period_us;
    const int64_t span = time_us - in->time_us;
    if (nominal == 0 || !in->timed || 4 * span < 3 * nominal || span > SILENT_US) {
        return;
    }
    const int32_t ahead = off_nominal(nominal, (int32_t)span) / 2 - in->drift; // below 2^16
    const int32_t half = ahead < 0 ? -RATE_SAMPLES / 2 : RATE_SAMPLES / 2;
    in->drift = (int16_t)(in->drift + (ahead + half) / RATE_SAMPLES);
    const int32_t off = 200 * (in->drift < 0 ? -in->drift : in->drift);
    if (!in->off_rate && off > RATE_LEAVE * nominal) {
        in->off_rate = true;
        count(&grid->faults.off_rate);
    } else if (off < RATE_RETURN * nominal) {
        in->off_rate = false;
    }
}

static void take(sway_grid_t *grid, uint32_t place, int64_t time_us, int32_t value, bool usable)
{
    sway_grid_input_t *in = &grid->input[place];
    const bool gap = is_silent(grid, place, time_us);
    watch_rate(grid, in, time_us);
    sway_grid_input_t now = *in;
    now.time_us = time_us;
    now.value = value;
    now.timed = true;
    now.usable = usable && !in->off_rate;
    now.stamp_refused = false;
    now.silent = false;
    fill_rows(grid, place, &now, now.usable && in->timed && in->usable && !gap);
    *in = now;
}

static bool is_good_call(const sway_grid_t *grid, sway_input_t input, int64_t time_us)
{
    return grid != NULL && (uint32_t)input < SWAY_INPUT_COUNT && time_us >= -SWAY_GRID_TIME_LIMIT &&
           time_us <= SWAY_GRID_TIME_LIMIT;
}

sway_error_t sway_grid_input(sway_grid_t *grid, sway_input_t input, int64_t time_us, int32_t value)
{
    if (!is_good_call(grid, input, time_us)) {
        return SWAY_ERROR_ARGUMENT;
    }
    const uint32_t place = sway_input_place(input);
    const int32_t low = is_unsigned(input) ? 0 : -limits[input];
    const bool in_range = value >= low && value <= limits[input];
    if (!in_range) {
        count(&grid->faults.out_of_range);
    }
    if (place == SWAY_INPUT_PLACES) {
        return in_range ? SWAY_OK : SWAY_ERROR_RANGE;
    }
    sway_grid_input_t *in = &grid->input[place];
    if (!in_range) {
        in->usable = false;
        return SWAY_ERROR_RANGE;
    }
    const int64_t measured_us = time_us - grid->config.delay_us[place];
    if (!accept_time(grid, in, measured_us)) {
        in->usable = false;
        in->stamp_refused = true;
        return SWAY_ERROR_TIME;
    }
    take(grid, place, measured_us, value, true);
    in->seen = true;
    return SWAY_OK;
}

void sway_grid_invalid(sway_grid_t *grid, sway_input_t input, int64_t time_us)
{
    const uint32_t place = sway_input_place(input);
    if (!is_good_call(grid, input, time_us) || place == SWAY_INPUT_PLACES) {
        return;
    }
    count(&grid->faults.invalid);
    const int64_t measured_us = time_us - grid->config.delay_us[place];
    sway_grid_input_t *in = &grid->input[place];
    if (accept_time(grid, in, measured_us)) {
        take(grid, place, measured_us, in->value, false);
    }
}

/* Whether the row waits for an input: speed is held instead, silent inputs are given up. */
static bool is_waiting(const sway_grid_t *grid)
{
    const uint32_t filled = grid->filled[grid->next_slot];
    for (uint32_t i = 0; i < SWAY_INPUT_PLACES; i++) {
        const sway_grid_input_t *in = &grid->input[i];
        if (((filled >> i) & 1U) == 0U && in->timed && i != SWAY_PLACE_OF_SPEED &&
            grid->newest_time_us - in->time_us < SILENT_US) {
            return true;
        }
    }
    return false;
}

typedef struct {
    int32_t value;
    bool valid;
} input_value_t;

static input_value_t input_value(const sway_grid_t *grid, uint32_t place)
{
    const uint32_t slot = grid->next_slot;
    const sway_grid_input_t *in = &grid->input[place];
    if (((grid->filled[slot] >> place) & 1U) != 0U) {
        const input_value_t known = {grid->row[slot][place],
                                     ((grid->valid[slot] >> place) & 1U) != 0U};
        return known;
    }
    const input_value_t held = {
        in->value, place == SWAY_PLACE_OF_SPEED && in->timed && in->usable &&
                       grid->next_time_us - in->time_us <= grid->config.max_speed_gap_us};
    return held;
}

static void add_channel(sway_row_t *row, uint32_t channel, input_value_t value, bool seen)
{
    row->value[channel] = value.value;
    row->valid_mask |= value.valid ? SWAY_CHANNEL_BIT(channel) : 0U;
    row->present_mask |= seen ? SWAY_CHANNEL_BIT(channel) : 0U;
}

static bool row_is_ready(const sway_grid_t *grid)
{
    if (!grid->running || grid->newest_time_us < grid->next_time_us) {
        return false;
    }
    return grid->newest_time_us - grid->next_time_us >= grid->config.max_wait_us ||
           !is_waiting(grid);
}

static void add_channels(const sway_grid_t *grid, sway_row_t *row)
{
    for (uint32_t c = 0; c < SWAY_CHANNEL_CAR_FRONT_FY && c < SWAY_CHANNELS; c++) {
        add_channel(row, c, input_value(grid, c), grid->input[c].seen);
    }
    for (uint32_t c = SWAY_CHANNEL_CAR_FRONT_FY; c < SWAY_CHANNELS; c++) {
        const uint32_t left = 2U * c - SWAY_CHANNEL_CAR_FRONT_FY;
        const input_value_t a = input_value(grid, left);
        const input_value_t b = input_value(grid, left + 1U);
        const input_value_t both = {a.value + b.value, a.valid && b.valid};
        add_channel(row, c, both, grid->input[left].seen && grid->input[left + 1U].seen);
    }
    add_channel(row, SWAY_CHANNEL_SPEED, input_value(grid, SWAY_PLACE_OF_SPEED),
                grid->input[SWAY_PLACE_OF_SPEED].seen);
}

bool sway_grid_next_row(sway_grid_t *grid, sway_row_t *row)
{
    if (grid == NULL || row == NULL || !row_is_ready(grid)) {
        return false;
    }
    for (uint32_t i = 0; i < SWAY_INPUT_PLACES; i++) {
        (void)is_silent(grid, i, grid->next_time_us);
    }
    const uint32_t slot = grid->next_slot;
    memset(row, 0, sizeof *row);
    row->time_us = grid->next_time_us;
    row->restart = grid->restart;
    add_channels(grid, row);
    grid->filled[slot] = 0;
    grid->valid[slot] = 0;
    grid->restart = false;
    grid->next_slot = (slot + 1U) & (SWAY_GRID_ROWS - 1U);
    grid->next_time_us += grid->config.sample_period_us;
    return true;
}

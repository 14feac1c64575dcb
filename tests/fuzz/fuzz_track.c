/* Fuzzer of the estimator: any sequence of samples, in any order, with any times (make fuzz).
 *
 * Checked at every step: nothing undefined (sanitizers), rows come in order and their values are in
 * range, counters never go down, the job ends, the sliding sums equal fresh sums. */
#include <stdlib.h>
#include <string.h>

#include "signal/sway_grid.h"
#include "signal/sway_track.h"

static sway_grid_t grid;
static sway_track_t track;
static sway_track_work_t work;

static void require(bool fact)
{
    if (!fact) {
        abort();
    }
}

static void check_sums(void)
{
    const sway_spectrum_t *spectrum = &track.spectrum;
    const uint32_t c = spectrum->phase % SWAY_CHANNELS;
    for (uint32_t k = 0; k <= SWAY_BINS; k++) {
        int64_t re = 0;
        for (uint32_t age = 0; age < spectrum->window; age++) {
            const uint32_t back = (age + 1U) % spectrum->window;
            const uint32_t phase = (spectrum->phase + spectrum->window - back) % spectrum->window;
            const int64_t x = track.ring.sample[c][sway_ring_slot(&track.ring, age)];
            re += x * sway_spectrum_cosine(spectrum, k * phase % spectrum->window);
        }
        require(re == spectrum->re[c][k]);
    }
}

static int64_t last_row_us;
static int rows;

static void take_rows(void)
{
    sway_row_t tick;
    int taken = 0;
    while (sway_grid_next_row(&grid, &tick)) {
        require(++taken < 1000);
        require(tick.restart || rows == 0 || tick.time_us > last_row_us);
        last_row_us = tick.time_us;
        for (int c = 0; c < SWAY_CHANNEL_COUNT; c++) {
            require(tick.value[c] < SWAY_SAMPLE_LIMIT && tick.value[c] > -SWAY_SAMPLE_LIMIT);
        }
        require((tick.valid_mask & ~tick.present_mask) == 0U);
        sway_track_push(&track, &tick);
        for (int i = 0; i < SWAY_TRACK_SLICES; i++) {
            (void)sway_track_run(&track);
        }
        if (++rows % 64 == 0 && sway_spectrum_ready(&track.spectrum)) {
            check_sums();
        }
    }
}

static uint32_t sum_of_faults(void)
{
    const sway_grid_faults_t *f = &grid.faults;
    return f->out_of_range + f->time_backward + f->gaps + f->invalid + f->late + f->restarts +
           f->off_rate;
}

/* Ten bytes a step: kind, input, time step, value, how often. */
static void step(const uint8_t *bytes, int64_t *time_us)
{
    int32_t value;
    int16_t hop;
    memcpy(&value, bytes + 4, sizeof value);
    memcpy(&hop, bytes + 2, sizeof hop);
    const sway_input_t input = (sway_input_t)(bytes[1] % (SWAY_INPUT_COUNT + 1));
    const int repeats = 1 + bytes[8];
    const int32_t wave = (int32_t)bytes[9] - 128;
    for (int i = 0; i < repeats; i++) {
        const int64_t scale = (bytes[0] & 3U) == 3U ? INT64_C(1) << (bytes[0] >> 3) : 1;
        *time_us += (bytes[0] & 4U) != 0U ? 10000 : hop * scale;
        const uint32_t before = sum_of_faults();
        if ((bytes[0] & 3U) == 1U) {
            sway_grid_invalid(&grid, input, *time_us);
        } else {
            const int32_t shaped = value / (1 + (i % 16) * (wave & 7));
            const sway_error_t error = sway_grid_input(&grid, input, *time_us, shaped);
            require(error == SWAY_OK || error == SWAY_ERROR_ARGUMENT || sum_of_faults() > before);
        }
        require(sum_of_faults() >= before);
        take_rows();
        if (*time_us > SWAY_GRID_TIME_LIMIT || *time_us < -SWAY_GRID_TIME_LIMIT) {
            *time_us = 0;
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sway_grid_config_t grid_config = sway_grid_default(10000);
    grid_config.input_period_us = (size & 1U) != 0U ? 10000 : 0;
    const sway_track_config_t config = sway_track_default(10000);
    int64_t time_us = 0;
    rows = 0;
    require(sway_grid_init(&grid, &grid_config) == SWAY_OK);
    require(sway_track_init(&track, &config, &work) == SWAY_OK);
    for (; size >= 10U; data += 10, size -= 10U) {
        step(data, &time_us);
    }
    return 0;
}

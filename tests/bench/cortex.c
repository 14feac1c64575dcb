/* Instructions of the estimator on a Cortex-M, beside FFTs of 256 points (make bench-cortex).
 * 16 channels, 5 lines, rows every 10 ms; counted by the emulator, the same run after run. */
#include <string.h>

#include "bench.h"
#include "kiss_fft.h"
#include "signal/sway_grid.h"
#include "signal/sway_track.h"

#ifdef WITH_CMSIS
#include "arm_math.h"
#endif

#define ROWS 900
#define POINTS 256

static sway_grid_t grid;
static sway_track_t track;
static sway_track_work_t work;

/* One oscillation of 0.67 Hz is 149.25 rows: a Q20 pointer turned by integers. */
static int32_t pointer[2] = {1 << 20, 0};

static void turn_pointer(void)
{
    /* cos and sin of 2 pi 0.67 / 100 in Q30 */
    const int64_t c = 1072790367;
    const int64_t s = 45187899;
    const int64_t re = (pointer[0] * c - pointer[1] * s) / (INT64_C(1) << 30);
    pointer[1] = (int32_t)((pointer[0] * s + pointer[1] * c) / (INT64_C(1) << 30));
    pointer[0] = (int32_t)re;
}

static uint32_t seed = 1;

static int32_t noise(void)
{
    seed = seed * 1664525U + 1013904223U;
    return (int32_t)(seed >> 20) - 2048;
}

/* Samples of all inputs of one row, 0.1 ms apart, the speed too. */
static uint32_t grid_row(int row, uint32_t *samples)
{
    uint32_t spent = 0;
    turn_pointer();
    for (int i = 0; i < SWAY_INPUT_COUNT; i++) {
        const int64_t at = (int64_t)row * 10000 + 100 * i;
        int32_t value = pointer[i & 1] / 10 + 2 * noise();
        value = i == 0 ? noise() : value;
        value = i == SWAY_INPUT_SPEED ? 28000 : i >= SWAY_INPUT_CAR_FZ_FL ? value + 400000 : value;
        const uint32_t before = bench_now();
        (void)sway_grid_input(&grid, (sway_input_t)i, at, value);
        spent += bench_instructions(before, bench_now());
        *samples += 1U;
    }
    return spent;
}

typedef struct {
    uint32_t sum;
    uint32_t most;
    uint32_t count;
} tally_t;

static void add(tally_t *tally, uint32_t value)
{
    tally->sum += value;
    tally->count += 1U;
    tally->most = value > tally->most ? value : tally->most;
}

static void print(const char *name, const tally_t *tally)
{
    bench_text(name);
    bench_line(" mean", tally->count > 0U ? tally->sum / tally->count : 0);
    bench_text(name);
    bench_line(" most", tally->most);
}

static tally_t input_tally;
static tally_t tick_tally;
static tally_t push_tally;
static tally_t sum_tally;
static tally_t estimate_tally;
static tally_t slice_tally;

static void one_slice(uint32_t *estimate)
{
    const uint32_t before_sequence = sway_track_sequence(&track);
    const uint32_t before = bench_now();
    (void)sway_track_run(&track);
    const uint32_t spent = bench_instructions(before, bench_now());
    if (track.state != 0U || sway_track_sequence(&track) != before_sequence) {
        *estimate += spent;
    }
    if (spent > 200U) {
        add(&slice_tally, spent);
    }
    if (sway_track_sequence(&track) != before_sequence) {
        if (track.locked && sway_track_sequence(&track) > 20U) {
            add(&estimate_tally, *estimate);
        }
        *estimate = 0;
    }
}

static void run_rows(void)
{
    sway_row_t tick;
    uint32_t samples = 0;
    uint32_t estimate = 0;
    for (int row = 0; row < ROWS; row++) {
        const uint32_t inputs = grid_row(row, &samples);
        for (;;) {
            const uint32_t before = bench_now();
            const bool ready = sway_grid_next_row(&grid, &tick);
            const uint32_t after = bench_now();
            if (!ready) {
                break;
            }
            sway_track_push(&track, &tick);
            const uint32_t end = bench_now();
            if (sway_spectrum_ready(&track.spectrum)) {
                add(&input_tally, inputs);
                add(&tick_tally, bench_instructions(before, after));
                add(&push_tally, bench_instructions(after, end));
            }
            for (int s = 0; s < SWAY_TRACK_SLICES; s++) {
                one_slice(&estimate);
            }
        }
    }
    for (int i = 0; i < 10; i++) {
        const uint32_t before = bench_now();
        sway_spectrum_push(&track.spectrum, &track.ring);
        add(&sum_tally, bench_instructions(before, bench_now()));
    }
}

static int64_t memory[(sizeof(int) * 66 + POINTS * 8 + 64) / 8];
static kiss_fft_cpx input[POINTS];
static kiss_fft_cpx output[POINTS];

static void fft_kiss(void)
{
    size_t size = sizeof memory;
    kiss_fft_cfg state = kiss_fft_alloc(POINTS, 0, memory, &size);
    for (int i = 0; i < POINTS; i++) {
        input[i].r = noise() << 16;
        input[i].i = noise() << 16;
    }
    const uint32_t before = bench_now();
    kiss_fft(state, input, output);
    bench_line("kissfft Q31 complex 256", bench_instructions(before, bench_now()));
}

#ifdef WITH_CMSIS
static void fft_cmsis(void)
{
    static q31_t data_31[2 * POINTS];
    static q15_t data_15[2 * POINTS];
    arm_cfft_instance_q31 instance_31;
    arm_cfft_instance_q15 instance_15;
    for (int i = 0; i < 2 * POINTS; i++) {
        data_31[i] = noise() << 16;
        data_15[i] = (q15_t)noise();
    }
    (void)arm_cfft_init_256_q31(&instance_31);
    (void)arm_cfft_init_256_q15(&instance_15);
    const uint32_t before = bench_now();
    arm_cfft_q31(&instance_31, data_31, 0, 1);
    const uint32_t middle = bench_now();
    arm_cfft_q15(&instance_15, data_15, 0, 1);
    const uint32_t end = bench_now();
    bench_line("CMSIS-DSP Q31 complex 256", bench_instructions(before, middle));
    bench_line("CMSIS-DSP Q15 complex 256", bench_instructions(middle, end));
}
#endif

int main(void)
{
    const sway_grid_config_t grid_config = sway_grid_default(10000);
    const sway_track_config_t config = sway_track_default(10000);
    if (sway_grid_init(&grid, &grid_config) != SWAY_OK ||
        sway_track_init(&track, &config, &work) != SWAY_OK) {
        return 1;
    }
    run_rows();
    print("grid: samples of a row", &input_tally);
    print("grid: hand out a row", &tick_tally);
    print("ring and sliding sums, a row", &push_tally);
    print("sliding sums alone, a row", &sum_tally);
    print("estimate", &estimate_tally);
    print("slice", &slice_tally);
    bench_line("estimates", estimate_tally.count);
    bench_line("flags of the last", track.line.flags);
    bench_line("RAM of sway_track_t", (int64_t)sizeof track);
    bench_line("RAM of sway_grid_t", (int64_t)sizeof grid);
    fft_kiss();
#ifdef WITH_CMSIS
    fft_cmsis();
#endif
    return estimate_tally.count > 10U && track.locked ? 0 : 1;
}

/* 1e9 rows through the sliding sums; now and at the end they must equal fresh sums bit for bit.
 * Usage: fast_forward ROWS. Built with 4 channels. Noise of full scale, so that every bit is used;
 * the state holds no count of rows, so nothing in it can grow. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "signal/sway_spectrum.h"

static sway_ring_t ring;
static sway_spectrum_t spectrum;

static int is_fresh(void)
{
    for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
        for (uint32_t k = 0; k <= SWAY_BINS; k++) {
            int64_t re = 0;
            int64_t im = 0;
            for (uint32_t age = 0; age < spectrum.window; age++) {
                const uint32_t back = (age + 1U) % spectrum.window;
                const uint32_t phase = (spectrum.phase + spectrum.window - back) % spectrum.window;
                const int64_t x = ring.sample[c][sway_ring_slot(&ring, age)];
                re += x * sway_spectrum_cosine(&spectrum, k * phase % spectrum.window);
                im += x * sway_spectrum_sine(&spectrum, k * phase % spectrum.window);
            }
            if (re != spectrum.re[c][k] || im != spectrum.im[c][k]) {
                return 0;
            }
        }
    }
    return 1;
}

int main(int argc, char **argv)
{
    const long rows = argc > 1 ? atol(argv[1]) : 0;
    uint64_t state = 88172645463325252U;
    sway_row_t tick;
    memset(&tick, 0, sizeof tick);
    if (rows < 1000 || sway_spectrum_init(&spectrum, 299) != SWAY_OK) {
        fprintf(stderr, "usage: fast_forward ROWS, at least 1000\n");
        return 2;
    }
    while (sway_spectrum_run(&spectrum, &ring)) {
    }
    for (long row = 1; row <= rows; row++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        for (uint32_t c = 0; c < SWAY_CHANNELS; c++) {
            tick.value[c] = (int32_t)((state >> (9U * c)) & 0xFFFFFFFU) - SWAY_SAMPLE_LIMIT + 1;
        }
        sway_ring_push(&ring, &tick);
        sway_spectrum_push(&spectrum, &ring);
        if ((row == 1000 || row % (rows / 10) == 0) && !is_fresh()) {
            printf("after %ld rows the sliding sums differ from fresh ones\n", row);
            return 1;
        }
    }
    printf("after %ld rows in each of %d channels the sliding sums equal fresh sums bit for bit\n",
           rows, SWAY_CHANNELS);
    return 0;
}

#include "figures.h"

#include <string.h>

#include "bench.h"
#include "semihosting.h"

/* A histogram with 16 steps an octave: the median is known to 4 %, the longest call exactly. */
#define STEPS 16U
#define BINS (24U * STEPS)

static uint32_t began_at;
static uint32_t call;  // instructions of the frame at hand so far
static uint32_t calls; // frames
static uint32_t longest;
static uint64_t total;
static uint32_t histogram[BINS];

static uint32_t bin_of(uint32_t count)
{
    uint32_t octave = 0;
    while (count >> octave >= 2U * STEPS) {
        octave++;
    }
    const uint32_t bin = count < STEPS ? count : octave * STEPS + (count >> octave);
    return bin < BINS ? bin : BINS - 1U;
}

static uint32_t bin_start(uint32_t bin)
{
    return bin < 2U * STEPS ? bin : (bin % STEPS + STEPS) << (bin / STEPS - 1U);
}

static uint32_t quantile(uint32_t per_mille)
{
    uint64_t wanted = (uint64_t)calls * per_mille / 1000U;
    for (uint32_t bin = 0; bin < BINS; bin++) {
        if (wanted < histogram[bin]) {
            return bin_start(bin);
        }
        wanted -= histogram[bin];
    }
    return longest;
}

void figures_began(void)
{
    began_at = bench_now();
}

void figures_returned(bool is_finished)
{
    call += began_at == 0U ? 0U : bench_instructions(began_at, bench_now());
    if (!is_finished) {
        return;
    }
    if (began_at != 0U) {
        calls++;
        total += call;
        longest = call > longest ? call : longest;
        histogram[bin_of(call)]++;
    }
    call = 0;
}

static void line(int32_t file, const char *name, int64_t value)
{
    char text[48];
    char digits[24];
    size_t at = strlen(name);
    size_t count = 0;
    memcpy(text, name, at);
    text[at++] = ' ';
    uint64_t rest = (uint64_t)value;
    do {
        digits[count++] = (char)('0' + (char)(rest % 10U));
        rest /= 10U;
    } while (rest != 0U);
    while (count > 0U) {
        text[at++] = digits[--count];
    }
    text[at++] = '\n';
    (void)semihosting_write(file, text, at);
}

void figures_write(const char *path, const sway_ecu_t *ecu)
{
    const uint32_t stack = bench_stack_used();
    const int32_t file = semihosting_open(path, SEMIHOSTING_WRITE);
    line(file, "frames", calls);
    line(file, "instructions", (int64_t)total);
    line(file, "frame_median", quantile(500));
    line(file, "frame_p99", quantile(990));
    line(file, "frame_longest", longest);
    line(file, "estimates", sway_core_status(&ecu->node.core)->sequence);
    line(file, "stack", stack);
    line(file, "ecu_bytes", sizeof *ecu);
    semihosting_close(file);
}

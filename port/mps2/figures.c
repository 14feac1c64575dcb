#include "figures.h"

#include <string.h>

#include "bench.h"
#include "semihosting.h"

/* Counts of a kind of call. A histogram with 16 steps an octave from 2^8 on: the median is known to
 * 6 %, the longest exactly. */
#define STEPS 16U
#define FIRST_OCTAVE 8U
#define OCTAVES 14U
#define BINS (OCTAVES * STEPS)

typedef struct {
    uint32_t count;
    uint32_t longest;
    uint64_t total;
    uint16_t bin[BINS];
} counts_t;

static uint32_t began_at;
static uint32_t call; // instructions of the poll at hand so far
static uint32_t row;  // of the 10 ms at hand
static int64_t row_number;
static counts_t polls[REPLAY_KINDS];
static counts_t rows;

static uint32_t bin_of(uint32_t instructions)
{
    uint32_t octave = FIRST_OCTAVE;
    while (octave < FIRST_OCTAVE + OCTAVES - 1U && instructions >> (octave + 1U) != 0U) {
        octave++;
    }
    const uint32_t step =
        instructions >> octave == 0U ? 0U : (instructions >> (octave - 4U)) - STEPS;
    return (octave - FIRST_OCTAVE) * STEPS + (step < STEPS ? step : STEPS - 1U);
}

static uint32_t bin_start(uint32_t bin)
{
    return (bin % STEPS + STEPS) << (bin / STEPS + FIRST_OCTAVE - 4U);
}

static void add(counts_t *counts, uint32_t instructions)
{
    uint16_t *bin = &counts->bin[bin_of(instructions)];
    *bin = *bin == UINT16_MAX ? UINT16_MAX : (uint16_t)(*bin + 1U);
    counts->count++;
    counts->total += instructions;
    counts->longest = instructions > counts->longest ? instructions : counts->longest;
}

static uint32_t quantile(const counts_t *counts, uint32_t per_mille)
{
    uint32_t wanted = (uint32_t)((uint64_t)counts->count * per_mille / 1000U);
    for (uint32_t bin = 0; bin < BINS; bin++) {
        if (wanted < counts->bin[bin]) {
            return bin_start(bin);
        }
        wanted -= counts->bin[bin];
    }
    return counts->longest;
}

void figures_began(int64_t time_us)
{
    if (time_us / 10000 != row_number) {
        row_number = time_us / 10000;
        add(&rows, row);
        row = 0;
    }
    began_at = bench_now();
}

void figures_stopped(replay_did_t what)
{
    call += bench_instructions(began_at, bench_now());
    if (what != REPLAY_NOT_DONE) {
        add(&polls[what], call);
        row += call;
        call = 0;
    }
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

static void put(int32_t file, const char *name, const char *what, int64_t value)
{
    char text[32];
    const size_t size = strlen(name);
    memcpy(text, name, size);
    memcpy(text + size, what, strlen(what) + 1U);
    line(file, text, value);
}

void figures_write(const char *path, const sway_ecu_t *ecu)
{
    static const char *const names[REPLAY_KINDS] = {"", "work", "send", "receive"};
    const uint32_t stack = bench_stack_used();
    const int32_t file = semihosting_open(path, SEMIHOSTING_WRITE);
    uint64_t total = 0;
    for (replay_did_t what = REPLAY_WORKED; what < REPLAY_KINDS; what++) {
        total += polls[what].total;
        put(file, names[what], "", polls[what].count);
        put(file, names[what], "_median", quantile(&polls[what], 500));
        put(file, names[what], "_longest", polls[what].longest);
    }
    line(file, "instructions", (int64_t)total);
    line(file, "rows", rows.count);
    line(file, "row_median", quantile(&rows, 500));
    line(file, "row_quiet", quantile(&rows, 30)); // before the first estimate
    line(file, "row_longest", rows.longest);
    line(file, "estimates", sway_core_status(&ecu->node.core)->sequence);
    line(file, "stack", stack);
    line(file, "ecu_bytes", sizeof *ecu);
    line(file, "core_bytes", sizeof ecu->node.core);
    semihosting_close(file);
}

/* corpus_run RUNS FILE...: a fuzzer without libFuzzer, for `make test`: every file of its corpus,
 * then RUNS mutations of each, always the same. */
#include <stdio.h>

#include "fuzz.h"

#define MOST 8192U

static uint32_t state;

static uint32_t random_number(void)
{
    state = state * 1664525U + 1013904223U;
    return state >> 8;
}

static size_t mutate(uint8_t *data, size_t size)
{
    for (uint32_t n = 1U + random_number() % 6U; n > 0U && size > 0U; n--) {
        const size_t at = random_number() % size;
        const size_t to = random_number() % size;
        const size_t length = 1U + random_number() % 16U;
        switch (random_number() % 5U) {
        case 0:
            data[at] ^= (uint8_t)(1U << random_number() % 8U);
            break;
        case 1:
            data[at] = (uint8_t)random_number();
            break;
        case 2: /* cut */
            size = at + 1U;
            break;
        case 3: /* copied over */
            memmove(data + to, data + at, size - (at > to ? at : to) < length ? 1U : length);
            break;
        default: /* repeated at the end */
            if (size + length <= MOST && at + length <= size) {
                memcpy(data + size, data + at, length);
                size += length;
            }
            break;
        }
    }
    return size;
}

int main(int argc, char **argv)
{
    static uint8_t data[MOST];
    static uint8_t copy[MOST];
    unsigned long runs = argc > 1 ? strtoul(argv[1], NULL, 10) : 0U;
    unsigned long done = 0;
    for (int i = 2; i < argc; i++) {
        FILE *file = fopen(argv[i], "rb");
        if (file == NULL) {
            fprintf(stderr, "corpus_run: %s: cannot be read\n", argv[i]);
            return 2;
        }
        const size_t size = fread(data, 1, sizeof data, file);
        fclose(file);
        (void)LLVMFuzzerTestOneInput(data, size);
        state = (uint32_t)i;
        for (unsigned long k = 0; k < runs; k++) {
            memcpy(copy, data, size);
            (void)LLVMFuzzerTestOneInput(copy, mutate(copy, size));
        }
        done += runs + 1U;
    }
    printf("%s: %d files, %lu runs\n", argv[0], argc - 2, done);
    return argc > 2 ? 0 : 2;
}

/* Shared by the fuzzers of port/ and of the bus: numbers out of the fuzzer's bytes. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Unity, whose checks port_test.h has, wants them. */
void setUp(void);
void tearDown(void);
__attribute__((weak)) void setUp(void)
{
}
__attribute__((weak)) void tearDown(void)
{
}

typedef struct {
    const uint8_t *data;
    size_t left;
} bytes_t;

static inline uint32_t take(bytes_t *from, unsigned count)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < count && from->left > 0U; i++) {
        value |= (uint32_t)*from->data++ << (8U * i);
        from->left--;
    }
    return value;
}

/* Not an assert: it holds in every build. */
static inline void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

#endif

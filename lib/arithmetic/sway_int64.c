// SPDX-License-Identifier: MIT
#include "arithmetic/sway_int64.h"

static uint64_t magnitude(int64_t value)
{
    return value < 0 ? UINT64_C(0) - (uint64_t)value : (uint64_t)value;
}

int64_t sway_int64_divide(int64_t value, int64_t divisor)
{
    const uint64_t size = magnitude(divisor);
    uint64_t rest = magnitude(value);
    uint64_t step = size;
    uint64_t quotient = 0;
    if (divisor == 0) {
        return 0; // as sway_real_div()
    }
    while (step <= rest / 2U) {
        step *= 2U;
    }
    for (; step >= size; step /= 2U) {
        quotient *= 2U;
        if (rest >= step) {
            rest -= step;
            quotient += 1U;
        }
    }
    /*@ split quotient == 0; */ // for make proofs-any: the interval of what is turned round
    return (int64_t)((value < 0) == (divisor < 0) ? quotient : UINT64_C(0) - quotient);
}

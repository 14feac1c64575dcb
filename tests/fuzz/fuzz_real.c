/* Fuzzer of sway_real: any numbers, also such as no operation makes, keep every operation defined
 * and every result normal. */
#include <stdlib.h>
#include <string.h>

#include "arithmetic/sway_real.h"

static void require_normal(sway_real_t x)
{
    const int64_t size = x.m < 0 ? -(int64_t)x.m : x.m;
    const bool normal = size >= (INT64_C(1) << 30) && size < (INT64_C(1) << 31);
    if (!(x.m == 0 ? x.e == 0 : normal) || x.e > SWAY_REAL_EXPONENT_MAX ||
        x.e < -SWAY_REAL_EXPONENT_MAX) {
        abort();
    }
}

static void check_pair(sway_real_t a, sway_real_t b)
{
    sway_real_t s;
    sway_real_t c;
    require_normal(sway_real_add(a, b));
    require_normal(sway_real_sub(a, b));
    require_normal(sway_real_mul(a, b));
    require_normal(sway_real_div(a, b));
    require_normal(sway_real_atan2(a, b));
    require_normal(sway_real_sqrt(a));
    require_normal(sway_real_exp(a));
    require_normal(sway_real_ln(a));
    sway_real_sincos(a, &s, &c);
    require_normal(s);
    require_normal(c);
    (void)sway_real_to_int(a, 1000000, INT32_MIN, INT32_MAX);
    (void)sway_real_to_int64(a, b.e % 100);
    if (sway_real_compare(a, b) != -sway_real_compare(b, a)) {
        abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int64_t mantissa[2];
    int32_t exponent[2];
    if (size < sizeof mantissa + sizeof exponent) {
        return 0;
    }
    memcpy(mantissa, data, sizeof mantissa);
    memcpy(exponent, data + sizeof mantissa, sizeof exponent);
    for (int i = 0; i < 2; i++) {
        exponent[i] %= (exponent[i] & 1) != 0 ? 100 : 2 * SWAY_REAL_EXPONENT_MAX;
    }
    const sway_real_t a = sway_real(mantissa[0], exponent[0]);
    const sway_real_t b = sway_real(mantissa[1], exponent[1]);
    require_normal(a);
    require_normal(b);
    check_pair(a, b);
    return 0;
}

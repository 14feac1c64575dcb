/* Proof that the sliding sums of signal/sway_spectrum.c cannot overflow (make proofs, Frama-C WP).
 *
 * SAMPLE: |x| < 2^27 (sway_ring_push clips to it). FACTOR: |w| <= 2^SWAY_TWIDDLE_BITS. A window has
 * at most SWAY_RING_SAMPLES rows. For every ring size, 2^27 * 2^bits * rows = 2^62.
 *
 * slide() is the update of add_sample(): the sum of N products, of which one leaves and one enters,
 * is again a sum of N products and so within the bound; the product of the difference, |x| < 2^28,
 * is within 2^(28 + 29). fresh_sum() shows that the bound of a sum of N products holds. */
#include <stdint.h>

#include "signal/sway_fit.h"
#include "signal/sway_spectrum.h"

#define SAMPLE_MAX ((INT64_C(1) << 27) - 1)
#define FACTOR_MAX (INT64_C(1) << SWAY_TWIDDLE_BITS)
#define TERM_MAX (SAMPLE_MAX * FACTOR_MAX)

/*@ requires 0 < rows <= SWAY_RING_SAMPLES;
    requires \valid_read(x + (0 .. rows - 1)) && \valid_read(w + (0 .. rows - 1));
    requires \forall integer i; 0 <= i < rows ==> -SAMPLE_MAX <= x[i] <= SAMPLE_MAX;
    requires \forall integer i; 0 <= i < rows ==> -FACTOR_MAX <= w[i] <= FACTOR_MAX;
    assigns \nothing;
    ensures -rows * TERM_MAX <= \result <= rows * TERM_MAX;
    ensures -4611686018427387904 <= \result <= 4611686018427387904;
*/
int64_t fresh_sum(const int32_t *x, const int32_t *w, uint32_t rows)
{
    int64_t sum = 0;
    /*@ loop invariant 0 <= i <= rows;
        loop invariant -i * TERM_MAX <= sum <= i * TERM_MAX;
        loop assigns i, sum;
        loop variant rows - i; */
    for (uint32_t i = 0; i < rows; i++) {
        /*@ assert -TERM_MAX <= x[i] * w[i] <= TERM_MAX; */
        sum += (int64_t)x[i] * w[i];
    }
    return sum;
}

/*@ requires 0 < rows <= SWAY_RING_SAMPLES;
    requires -SAMPLE_MAX <= entering <= SAMPLE_MAX && -SAMPLE_MAX <= leaving <= SAMPLE_MAX;
    requires -FACTOR_MAX <= factor <= FACTOR_MAX;
    requires sum == rest + leaving * factor;
    requires -(rows - 1) * TERM_MAX <= rest <= (rows - 1) * TERM_MAX;
    assigns \nothing;
    ensures \result == rest + entering * factor;
    ensures -rows * TERM_MAX <= \result <= rows * TERM_MAX;
*/
int64_t slide(int64_t sum, int64_t rest, int32_t entering, int32_t leaving, int32_t factor,
              uint32_t rows)
{
    const int32_t step = entering - leaving;
    /*@ assert -TERM_MAX <= entering * factor <= TERM_MAX; */
    /*@ assert sum + step * factor == rest + entering * factor; */
    return sum + (int64_t)step * factor;
}

/* sway_fit_product(): columns are Q28, block sums below 2^27, residuals below 2^28. */
/*@ requires 0 < blocks <= SWAY_FIT_BLOCKS;
    requires \valid_read(a + (0 .. blocks - 1)) && \valid_read(b + (0 .. blocks - 1));
    requires \forall integer i; 0 <= i < blocks ==> -268435456 <= a[i] <= 268435456;
    requires \forall integer i; 0 <= i < blocks ==> -268435456 <= b[i] <= 268435456;
    assigns \nothing;
    ensures -4611686018427387904 <= \result <= 4611686018427387904;
*/
int64_t block_product(const int32_t *a, const int32_t *b, uint32_t blocks)
{
    int64_t sum = 0;
    /*@ loop invariant 0 <= i <= blocks;
        loop invariant -i * 72057594037927936 <= sum <= i * 72057594037927936;
        loop assigns i, sum;
        loop variant blocks - i; */
    for (uint32_t i = 0; i < blocks; i++) {
        /*@ assert -72057594037927936 <= a[i] * b[i] <= 72057594037927936; */
        sum += (int64_t)a[i] * b[i];
    }
    return sum;
}

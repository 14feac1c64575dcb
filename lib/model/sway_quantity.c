// SPDX-License-Identifier: MIT
#include "model/sway_quantity.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* What a lag of the user's value belongs to, in 1/m: 0.67 Hz at 30 m/s. */
#define USER_LAG_S_BY_V sway_real_ratio(14, 100)

static sway_real_t ppm(int32_t value)
{
    return sway_real_micro(value);
}

void sway_quantity_start(sway_quantity_t *quantity, sway_real_t value, int32_t re_ppm,
                         int32_t im_ppm)
{
    memset(quantity, 0, sizeof *quantity);
    quantity->value.re = value;
    quantity->variance_re = sway_real_square(MUL(value, ppm(re_ppm)));
    quantity->variance_im = sway_real_square(MUL(value, ppm(im_ppm)));
    quantity->s_by_v.im = USER_LAG_S_BY_V;
    quantity->started = sway_real_sign(value) > 0;
}

void sway_quantity_drift(sway_quantity_t *quantity, int64_t time_us, int32_t re_ppm, int32_t im_ppm)
{
    const int64_t elapsed_us = quantity->time_us == 0 ? 0 : time_us - quantity->time_us;
    quantity->time_us = time_us;
    if (!quantity->identified || elapsed_us <= 0) {
        return; // the user's value does not grow less certain
    }
    const sway_real_t seconds = sway_real_micro(elapsed_us);
    const sway_real_t size = sway_real_square(quantity->value.re);
    quantity->variance_re =
        ADD(quantity->variance_re, MUL(MUL(size, sway_real_square(ppm(re_ppm))), seconds));
    quantity->variance_im =
        ADD(quantity->variance_im, MUL(MUL(size, sway_real_square(ppm(im_ppm))), seconds));
}

/* How an estimate counts. */
typedef struct {
    sway_real_t share;    ///< of its swing that was predicted
    sway_real_t variance; ///< with what overlaps
    sway_real_t common;   ///< variance that stays
} weight_t;

/* Least squares would weigh by the swing itself, of which today's wind is a part; an instrument
 * weighs by what was predicted of it. The variance is that of any gain (Joseph's form), and the
 * gain ends where no more than the common part of the variance would be left. */
static void update(sway_real_t *value, sway_real_t *variance, sway_real_t measured,
                   const weight_t *weight)
{
    if (sway_real_compare(*variance, weight->common) <= 0) {
        return;
    }
    const sway_real_t one = sway_real_int(1);
    const sway_real_t by = MUL(*variance, weight->share);
    const sway_real_t full = DIV(by, ADD(MUL(by, weight->share), weight->variance));
    const sway_real_t gain = sway_real_min(full, SUB(one, DIV(weight->common, *variance)));
    *value = ADD(*value, MUL(gain, SUB(measured, *value)));
    *variance = ADD(MUL(sway_real_square(SUB(one, gain)), *variance),
                    MUL(sway_real_square(gain), weight->variance));
}

/* Variance of an estimate. A stiffness is a force over a slip, and its error comes mostly from the
 * noise of the slip: noise that makes the slip too large makes the stiffness and its stated error
 * too small together. Taken as stated, the low estimates of a swing that fades into the noise
 * would outweigh the high ones, so they count with the error that they would have at the value so
 * far. In a swing that grows the tyres may have failed: there they count as stated. */
static sway_real_t variance_of(const sway_quantity_t *quantity, const sway_estimate_t *estimate,
                               bool fades)
{
    const sway_real_t low = estimate->value.re;
    sway_real_t se = estimate->se;
    if (fades && sway_real_sign(low) > 0 && sway_real_less(low, quantity->value.re)) {
        se = DIV(MUL(se, quantity->value.re), low);
    }
    return sway_real_square(se);
}

/* A change that the drift cannot explain (a tyre loses pressure, a load moves): two estimates in a
 * row are off by more than two errors. Windows overlap 16-fold, so about 16 estimates see one
 * change, and each adds a sixteenth of its square to the variance. */
static void follow_jump(sway_quantity_t *quantity, sway_real_t measured, sway_real_t variance)
{
    const sway_real_t innovation = SUB(measured, quantity->value.re);
    const sway_real_t square = sway_real_square(innovation);
    const sway_real_t expected = ADD(quantity->variance_re, variance);
    const bool far = sway_real_less(sway_real_scale(expected, 2), square);
    if (far && quantity->strange) {
        quantity->variance_re = ADD(quantity->variance_re, sway_real_scale(square, -4));
        quantity->variance_im = ADD(quantity->variance_im, sway_real_scale(square, -6));
    }
    quantity->strange = far;
}

/* The imaginary part of C = C0/(1 + sigma s/v) grows with s/v: at another frequency or speed the
 * same lag is another argument. */
static void move_to(sway_quantity_t *quantity, sway_complex_t s_by_v)
{
    if (sway_real_sign(quantity->s_by_v.im) > 0) {
        const sway_real_t ratio = DIV(s_by_v.im, quantity->s_by_v.im);
        quantity->value.im = MUL(quantity->value.im, ratio);
        quantity->variance_im = MUL(quantity->variance_im, sway_real_square(ratio));
    }
    quantity->s_by_v = s_by_v;
}

void sway_quantity_take(sway_quantity_t *quantity, const sway_estimate_t *estimate,
                        sway_complex_t s_by_v, const sway_real_t *predicted)
{
    const sway_complex_t value = estimate->value;
    const sway_real_t variance = variance_of(quantity, estimate, sway_real_sign(s_by_v.re) < 0);
    weight_t weight = {sway_real_int(1), MUL(variance, sway_real_int(SWAY_QUANTITY_OVERLAP)),
                       sway_real_zero()};
    if (predicted != NULL && quantity->started) {
        if (sway_real_sign(*predicted) <= 0) {
            return;
        }
        weight.variance = MUL(variance, sway_real_int(SWAY_QUANTITY_OVERLAP_DERIVED));
        const sway_real_t new_motion = sway_real_square(SUB(weight.share, *predicted));
        weight.common = MUL(sway_real_scale(variance, SWAY_QUANTITY_COMMON), new_motion);
        weight.share = *predicted;
    }
    move_to(quantity, s_by_v);
    if (!quantity->started) {
        quantity->value = value;
        quantity->variance_re = weight.variance;
        quantity->variance_im = weight.variance;
        quantity->started = true;
    } else {
        follow_jump(quantity, value.re, variance);
        update(&quantity->value.re, &quantity->variance_re, value.re, &weight);
        update(&quantity->value.im, &quantity->variance_im, value.im, &weight);
    }
    quantity->identified = true;
}

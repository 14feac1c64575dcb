// SPDX-License-Identifier: MIT
#include "model/sway_phasor.h"

static const sway_complex_t NOTHING = {{0, 0}, {0, 0}};

sway_channel_t sway_origin_of_channel(sway_origin_t from)
{
    static const uint8_t channel[SWAY_ORIGIN_ALL] = {
        SWAY_CHANNEL_COUNT,
        SWAY_CHANNEL_STEERING_WHEEL_ANGLE,
        SWAY_CHANNEL_CAR_YAW_RATE,
        SWAY_CHANNEL_CAR_LATERAL_ACC,
        SWAY_CHANNEL_TRAILER_YAW_RATE,
        SWAY_CHANNEL_TRAILER_LATERAL_ACC,
        SWAY_CHANNEL_ARTICULATION,
        SWAY_CHANNEL_HITCH_FY,
        SWAY_CHANNEL_CAR_FRONT_FY,
        SWAY_CHANNEL_CAR_REAR_FY,
        SWAY_CHANNEL_TRAILER_FRONT_FY,
        SWAY_CHANNEL_TRAILER_REAR_FY,
    };
    return (sway_channel_t)channel[from];
}

static bool is_zero(sway_complex_t a)
{
    return a.re.m == 0 && a.im.m == 0;
}

sway_phasor_t sway_phasor_constant(sway_complex_t value)
{
    sway_phasor_t phasor;
    phasor.value = value;
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        phasor.slope[i] = NOTHING;
    }
    phasor.known = true;
    return phasor;
}

sway_phasor_t sway_phasor_unknown(void)
{
    sway_phasor_t phasor = sway_phasor_constant(NOTHING);
    phasor.known = false;
    return phasor;
}

sway_phasor_t sway_phasor_measured(sway_complex_t value, sway_origin_t source)
{
    sway_phasor_t phasor = sway_phasor_constant(value);
    phasor.slope[source].re = sway_real_int(1);
    return phasor;
}

void sway_phasor_add(sway_phasor_t *sum, const sway_phasor_t *term)
{
    sum->value = sway_complex_add(sum->value, term->value);
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        if (!is_zero(term->slope[i])) {
            sum->slope[i] = sway_complex_add(sum->slope[i], term->slope[i]);
        }
    }
    sum->known = sum->known && term->known;
}

void sway_phasor_scale(sway_phasor_t *phasor, sway_real_t factor)
{
    phasor->value = sway_complex_scale(phasor->value, factor);
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        if (!is_zero(phasor->slope[i])) {
            phasor->slope[i] = sway_complex_scale(phasor->slope[i], factor);
        }
    }
}

void sway_phasor_add_scaled(sway_phasor_t *sum, const sway_phasor_t *term, sway_real_t factor)
{
    sway_phasor_t scaled = *term;
    sway_phasor_scale(&scaled, factor);
    sway_phasor_add(sum, &scaled);
}

void sway_phasor_multiply(sway_phasor_t *product, const sway_phasor_t *factor)
{
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        sway_complex_t slope = NOTHING;
        if (!is_zero(product->slope[i])) {
            slope = sway_complex_mul(product->slope[i], factor->value);
        }
        if (!is_zero(factor->slope[i])) {
            slope = sway_complex_add(slope, sway_complex_mul(product->value, factor->slope[i]));
        }
        product->slope[i] = slope;
    }
    product->value = sway_complex_mul(product->value, factor->value);
    product->known = product->known && factor->known;
}

void sway_phasor_divide(sway_phasor_t *quotient, const sway_phasor_t *divisor)
{
    if (is_zero(divisor->value)) {
        *quotient = sway_phasor_unknown();
        return;
    }
    const sway_complex_t one = {{1 << 30, -30}, {0, 0}};
    const sway_complex_t inverse = sway_complex_div(one, divisor->value);
    quotient->value = sway_complex_mul(quotient->value, inverse);
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        sway_complex_t slope = quotient->slope[i];
        if (!is_zero(divisor->slope[i])) {
            slope = sway_complex_sub(slope, sway_complex_mul(quotient->value, divisor->slope[i]));
        }
        quotient->slope[i] = is_zero(slope) ? slope : sway_complex_mul(slope, inverse);
    }
    quotient->known = quotient->known && divisor->known;
}

sway_real_t sway_phasor_se(const sway_phasor_t *phasor, const sway_sources_t *sources)
{
    sway_real_t variance = {0, 0};
    for (int i = 0; i < (int)SWAY_ORIGIN_COUNT; i++) {
        if (!is_zero(phasor->slope[i])) {
            variance = sway_real_add(
                variance, sway_real_mul(sway_complex_norm(phasor->slope[i]), sources->variance[i]));
        }
    }
    return sway_real_sqrt(variance);
}

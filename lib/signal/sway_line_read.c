// SPDX-License-Identifier: MIT
/* What can be read from a line. */
#include <stddef.h>

#include "signal/sway_line.h"

sway_real_t sway_line_unit(sway_channel_t channel)
{
    return sway_real_ratio(
        1, channel >= SWAY_CHANNEL_HITCH_FX && channel < SWAY_CHANNEL_COUNT ? 1000 : 1000000);
}

void sway_line_damping(const sway_line_t *line, sway_real_t *ratio, sway_real_t *se)
{
    const sway_real_t g = line->growth_1_s;
    const sway_real_t o = line->omega_rad_s;
    const sway_real_t norm = sway_real_add(sway_real_square(g), sway_real_square(o));
    const sway_real_t size = sway_real_sqrt(norm);
    const sway_real_t by_g = sway_real_mul(o, line->growth_se_1_s);
    const sway_real_t by_o = sway_real_mul(g, line->omega_se_rad_s);
    const sway_real_t spread =
        sway_real_sqrt(sway_real_add(sway_real_square(by_g), sway_real_square(by_o)));
    *ratio = sway_real_neg(sway_real_div(g, size));
    *se = sway_real_div(sway_real_mul(o, spread), sway_real_mul(norm, size));
}

static sway_real_t line_share(const sway_line_channel_t *channel)
{
    const sway_real_t power = sway_real_scale(sway_complex_norm(channel->amplitude), -1);
    return sway_real_div(power, sway_real_add(power, sway_real_square(channel->noise_rms)));
}

sway_error_t sway_line_ratio(const sway_line_t *line, sway_channel_t numerator,
                             sway_channel_t denominator, int32_t numerator_delay_us,
                             sway_line_ratio_t *result)
{
    if (line == NULL || result == NULL || (uint32_t)numerator >= SWAY_CHANNELS ||
        (uint32_t)denominator >= SWAY_CHANNELS) {
        return SWAY_ERROR_ARGUMENT;
    }
    const uint32_t both = SWAY_CHANNEL_BIT(numerator) | SWAY_CHANNEL_BIT(denominator);
    if ((line->valid_mask & both) != both) {
        return SWAY_ERROR_NO_DATA;
    }
    const sway_line_channel_t *a = &line->channel[numerator];
    const sway_line_channel_t *b = &line->channel[denominator];
    const sway_real_t size = sway_complex_abs(b->amplitude);
    if (size.m == 0) {
        return SWAY_ERROR_SINGULAR;
    }
    const sway_real_t delay_s = sway_real_micro(numerator_delay_us);
    const sway_complex_t turn =
        sway_complex_scale(sway_complex_unit(sway_real_mul(line->omega_rad_s, delay_s)),
                           sway_real_exp(sway_real_mul(line->growth_1_s, delay_s)));
    result->ratio = sway_complex_mul(sway_complex_div(a->amplitude, b->amplitude), turn);
    const sway_real_t scaled = sway_real_mul(sway_complex_abs(result->ratio), b->amplitude_se);
    const sway_real_t spread =
        sway_real_add(sway_real_square(a->amplitude_se), sway_real_square(scaled));
    result->se = sway_real_div(sway_real_sqrt(spread), size);
    result->coherence = sway_real_sqrt(sway_real_mul(line_share(a), line_share(b)));
    return SWAY_OK;
}

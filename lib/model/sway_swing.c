// SPDX-License-Identifier: MIT
#include "model/sway_swing.h"

#include <string.h>

#include "arithmetic/sway_real_ops.h"

/* Lateral friction at the peak, and how far y may be off. */
#define FRICTION_PPM 900000
#define Y_SE_PPM 600000

/* What is forgotten with each estimate: 1/256, as slow as a stiffness follows. */
#define FADE (-8)

/* 1 + y at the least: forces beyond the assumed peak have been seen. */
#define LEAST_PPM 250000

/* Load of an axle at rest by its body's mass and distances: to this axle, to the other support. */
static sway_real_t load_n(int32_t mass_g, int32_t near_um, int32_t far_um)
{
    const int32_t base_um = near_um + far_um;
    const sway_real_t weight = MUL(sway_real_ratio(mass_g, 1000), sway_real_micro(9810000));
    const int32_t share_um = far_um > 0 ? far_um : 0;
    if (base_um <= 0) {
        return weight; // no places
    }
    return MUL(weight, sway_real_min(sway_real_ratio(share_um, base_um), sway_real_int(1)));
}

static sway_real_t halfway(sway_real_t a, sway_real_t b)
{
    return sway_real_scale(ADD(a, b), -1);
}

void sway_swing_init(sway_swing_t *swing, const sway_vehicle_t *vehicle)
{
    const sway_car_t *const car = &vehicle->car;
    const sway_trailer_t *const trailer = &vehicle->trailer;
    const int32_t front_um = car->front_axle_to_cog_um;
    const int32_t rear_um = car->rear_axle_to_cog_um;
    sway_real_t *const peak = swing->peak_n;
    memset(swing, 0, sizeof *swing);
    peak[SWAY_AXLE_CAR_FRONT] = load_n(car->mass_g, front_um, rear_um);
    peak[SWAY_AXLE_CAR_REAR] = load_n(car->mass_g, rear_um, front_um);
    if (trailer->axles == 1) {
        peak[SWAY_AXLE_TRAILER_REAR] =
            load_n(trailer->mass_g, trailer->rear_axle_to_cog_um, trailer->hitch_to_cog_um);
    } else if (trailer->axles == 2) {
        const int32_t f_um = trailer->front_axle_to_cog_um;
        const int32_t r_um = trailer->rear_axle_to_cog_um;
        const sway_real_t equal = load_n(trailer->mass_g, 1, 1);
        peak[SWAY_AXLE_TRAILER_FRONT] = halfway(equal, load_n(trailer->mass_g, f_um, r_um));
        peak[SWAY_AXLE_TRAILER_REAR] = halfway(equal, load_n(trailer->mass_g, r_um, f_um));
    }
    for (int axle = 0; axle < (int)SWAY_AXLE_COUNT; axle++) {
        peak[axle] = MUL(peak[axle], sway_real_micro(FRICTION_PPM));
    }
}

static void fold(sway_real_t *sum, sway_real_t now)
{
    *sum = ADD(SUB(*sum, sway_real_scale(*sum, FADE)), now);
}

void sway_swing_take(sway_swing_t *swing, const sway_identify_t *id, sway_real_t swing_rad_s)
{
    const sway_real_t squared = sway_real_square(swing_rad_s);
    for (uint32_t axle = 0; axle < (uint32_t)SWAY_AXLE_COUNT; axle++) {
        if ((id->valid & ((uint32_t)SWAY_VALID_CAR_FRONT << axle)) != 0U) {
            fold(&swing->force_2[axle], sway_complex_norm(id->axle[axle].force.value));
            fold(&swing->swing_2[axle], squared);
            fold(&swing->swing_4[axle], sway_real_square(squared));
        }
        if ((id->valid & ((uint32_t)SWAY_VALID_CAR_FRONT_LOAD << axle)) != 0U) {
            swing->peak_n[axle] = MUL(id->axle[axle].load_n, sway_real_micro(FRICTION_PPM));
        }
    }
}

bool sway_swing_speed(const sway_swing_t *swing, const sway_margin_model_t *model,
                      sway_real_t swing_rad_s, sway_swing_speed_t *speed)
{
    const sway_real_t one = sway_real_int(1);
    const sway_real_t wanted = sway_real_square(swing_rad_s);
    sway_real_t fall = sway_real_zero();  // of ln v_crit
    sway_real_t slope = sway_real_zero(); // its derivative to ln y of all axles
    for (uint32_t axle = 0; axle < (uint32_t)SWAY_AXLE_COUNT; axle++) {
        const sway_real_t weight = swing->swing_2[axle];
        if (sway_real_is_zero(swing->peak_n[axle])) {
            continue;
        }
        if (sway_real_sign(weight) <= 0) {
            return false;
        }
        const sway_real_t change = SUB(wanted, DIV(swing->swing_4[axle], weight));
        const sway_real_t by =
            DIV(swing->force_2[axle],
                MUL(weight, sway_real_scale(sway_real_square(swing->peak_n[axle]), 1)));
        const sway_real_t ratio =
            sway_real_max(ADD(one, MUL(by, change)), sway_real_micro(LEAST_PPM));
        const sway_real_t exponent =
            DIV(MUL(model->sensitivity_m_s[SWAY_PARAMETER_CAR_FRONT_STIFFNESS + axle],
                    sway_real_int(50)),
                model->v_crit_m_s);
        fall = ADD(fall, MUL(exponent, sway_real_ln(ratio)));
        slope = ADD(slope, MUL(exponent, SUB(one, DIV(one, ratio))));
    }
    speed->v_crit_m_s = MUL(model->v_crit_m_s, sway_real_exp(NEG(fall)));
    const sway_real_t assumed = MUL(MUL(speed->v_crit_m_s, slope), sway_real_micro(Y_SE_PPM));
    speed->se_m_s =
        sway_real_sqrt(ADD(sway_real_square(model->v_crit_se_m_s), sway_real_square(assumed)));
    return true;
}

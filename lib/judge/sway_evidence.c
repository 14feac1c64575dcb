// SPDX-License-Identifier: MIT
#include "judge/sway_evidence.h"

#include "arithmetic/sway_real_ops.h"

static sway_real_t ppm(int32_t value)
{
    return sway_real_micro(value);
}

/* What the model leaves out (roll, air, saturation) in the damping ratio, at the least. */
#define MODEL_FLOOR_PPM 5000

/* Amplitude noise of the road, rad/s: before any experience, least and most; the time over which it
 * is learnt, and the time that the value before any experience is worth. */
#define DISTURBANCE_START_URAD_S 3000
#define DISTURBANCE_LEAST_URAD_S 500
#define DISTURBANCE_MOST_URAD_S 12000
#define DISTURBANCE_TIME_US 20000000
#define DISTURBANCE_START_US 6000000

/* Amplitude that the driver's hand may add or take in one oscillation, over 2 pi, squared. */
static sway_real_t square_of_hand(sway_real_t steered_rad_s)
{
    return sway_real_square(MUL(steered_rad_s, sway_real_ratio(3, 4)));
}

sway_real_t sway_disturbance_se(const sway_disturbance_t *disturbance, sway_real_t fit_se,
                                sway_real_t amplitude_rad_s, sway_real_t steered_rad_s)
{
    const sway_real_t start = sway_real_square(ppm(DISTURBANCE_START_URAD_S));
    const sway_real_t pushed = disturbance->started ? disturbance->variance : start;
    const sway_real_t both = ADD(pushed, square_of_hand(steered_rad_s));
    return sway_real_sqrt(ADD(sway_real_square(sway_real_scale(fit_se, 1)),
                              DIV(both, sway_real_square(amplitude_rad_s))));
}

void sway_disturbance_learn(sway_disturbance_t *disturbance, int64_t time_us,
                            sway_real_t difference, sway_real_t amplitude_rad_s,
                            sway_real_t steered_rad_s)
{
    int64_t elapsed_us = time_us > disturbance->time_us ? time_us - disturbance->time_us : 0;
    disturbance->time_us = time_us;
    if (!disturbance->started) {
        disturbance->started = true;
        disturbance->variance = sway_real_square(ppm(DISTURBANCE_START_URAD_S));
        disturbance->learnt_us = DISTURBANCE_START_US;
        return;
    }
    elapsed_us = elapsed_us > DISTURBANCE_TIME_US / 8 ? DISTURBANCE_TIME_US / 8 : elapsed_us;
    disturbance->learnt_us += (int32_t)elapsed_us;
    disturbance->learnt_us =
        disturbance->learnt_us > DISTURBANCE_TIME_US ? DISTURBANCE_TIME_US : disturbance->learnt_us;
    const sway_real_t least = sway_real_square(ppm(DISTURBANCE_LEAST_URAD_S));
    const sway_real_t most = sway_real_square(ppm(DISTURBANCE_MOST_URAD_S));
    const sway_real_t moved =
        SUB(sway_real_square(MUL(difference, amplitude_rad_s)), square_of_hand(steered_rad_s));
    const sway_real_t seen = sway_real_max(sway_real_min(moved, most), sway_real_zero());
    const sway_real_t weight =
        sway_real_div(sway_real(elapsed_us, 0), sway_real_int(disturbance->learnt_us));
    disturbance->variance =
        ADD(disturbance->variance, MUL(weight, SUB(seen, disturbance->variance)));
    disturbance->variance = sway_real_max(disturbance->variance, least);
}

void sway_disturbance_restart(sway_disturbance_t *disturbance, int64_t time_us)
{
    disturbance->time_us = time_us;
}

sway_belief_t sway_evidence_combine(const sway_evidence_t *model, const sway_evidence_t *signal,
                                    sway_evidence_t *combined, bool *disagrees)
{
    *disagrees = false;
    *combined = model->usable ? *model : *signal;
    if (!model->usable || !signal->usable) {
        const sway_belief_t alone = model->usable ? SWAY_BELIEF_MODEL : SWAY_BELIEF_SIGNAL;
        return combined->usable ? alone : SWAY_BELIEF_NONE;
    }
    const sway_real_t of_model =
        ADD(sway_real_square(model->se), sway_real_square(ppm(MODEL_FLOOR_PPM)));
    const sway_real_t of_signal = sway_real_square(signal->se);
    const sway_real_t sum = ADD(of_model, of_signal);
    const sway_real_t difference = SUB(signal->ratio, model->ratio);
    const sway_real_t most = sway_real_int(model->slow ? 9 : 16);
    if (sway_real_less(MUL(most, sum), sway_real_square(difference))) {
        *disagrees = true;
        *combined = *signal;
        return SWAY_BELIEF_SIGNAL;
    }
    const sway_real_t weight = DIV(of_model, sum);
    combined->ratio = ADD(model->ratio, MUL(weight, difference));
    combined->se = sway_real_sqrt(MUL(weight, of_signal));
    return SWAY_BELIEF_BOTH;
}

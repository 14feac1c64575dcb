#include "sway_bit_timing.h"

#define QUANTA_MIN 8U
#define QUANTA_MAX 80U

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* The second segment for `quanta` in a bit, as near to the sample point as the limits allow. */
static bool split(uint32_t quanta, uint32_t sample_point_milli, const sway_bit_limits_t *limits,
                  sway_bit_timing_t *timing)
{
    uint32_t segment2 = (quanta * (1000U - sample_point_milli) + 500U) / 1000U;
    segment2 = smaller(segment2 < 2U ? 2U : segment2, limits->segment2_max);
    if (quanta - 1U > limits->segment1_max + segment2) {
        segment2 = quanta - 1U - limits->segment1_max;
    }
    timing->segment2 = segment2;
    timing->segment1 = quanta - 1U - segment2;
    timing->jump = smaller(segment2, limits->jump_max);
    return segment2 <= limits->segment2_max && timing->segment1 <= limits->segment1_max;
}

bool sway_bit_timing(uint32_t clock_hz, uint32_t bit_rate, uint32_t sample_point_milli,
                     const sway_bit_limits_t *limits, sway_bit_timing_t *timing)
{
    if (bit_rate == 0U || clock_hz % bit_rate != 0U || sample_point_milli >= 1000U) {
        return false;
    }
    const uint32_t clocks = clock_hz / bit_rate;
    uint32_t best_error = UINT32_MAX;
    for (uint32_t quanta = QUANTA_MAX; quanta >= QUANTA_MIN; quanta--) {
        sway_bit_timing_t candidate = {.prescaler = clocks / quanta};
        if (clocks % quanta != 0U || candidate.prescaler == 0U ||
            candidate.prescaler > limits->prescaler_max ||
            !split(quanta, sample_point_milli, limits, &candidate)) {
            continue;
        }
        const uint32_t point = (1000U * (1U + candidate.segment1) + quanta / 2U) / quanta;
        const uint32_t error =
            point > sample_point_milli ? point - sample_point_milli : sample_point_milli - point;
        if (error < best_error) {
            best_error = error;
            *timing = candidate;
        }
    }
    return best_error != UINT32_MAX;
}

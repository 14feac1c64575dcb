// SPDX-License-Identifier: MIT
#include "bus/sway_e2e.h"

#include "arithmetic/sway_int64.h"

#define TURN (SWAY_E2E_COUNTER_MAX + 1)

/* CRC-8H2F: polynomial 0x2F */
static const uint8_t table[16] = {0x00, 0x2F, 0x5E, 0x71, 0xBC, 0x93, 0xE2, 0xCD,
                                  0x57, 0x78, 0x09, 0x26, 0xEB, 0xC4, 0xB5, 0x9A};

uint8_t sway_e2e_crc_byte(const uint8_t *remainders, uint8_t crc, uint8_t byte)
{
    uint32_t r = (uint32_t)crc ^ (uint32_t)byte;
    r = ((r << 4) & 0xFFU) ^ remainders[r >> 4];
    return (uint8_t)(((r << 4) & 0xFFU) ^ remainders[r >> 4]);
}

uint8_t sway_e2e_crc(uint32_t can_id, const uint8_t *data)
{
    uint8_t crc = 0xFFU;
    for (uint32_t i = 1U; i < SWAY_E2E_LENGTH; i++) {
        crc = sway_e2e_crc_byte(table, crc, data[i]);
    }
    crc = sway_e2e_crc_byte(table, crc, (uint8_t)(can_id & 0xFFU));
    return (uint8_t)(crc ^ 0xFFU);
}

void sway_e2e_protect(uint32_t can_id, uint8_t counter, uint8_t *data)
{
    data[1] = (uint8_t)((data[1] & 0xF0U) | (counter & 0x0FU));
    data[0] = sway_e2e_crc(can_id, data);
}

uint8_t sway_e2e_next(uint8_t counter)
{
    return (uint8_t)((counter + 1U) & 0x0FU);
}

bool sway_e2e_check(uint32_t can_id, const uint8_t *data)
{
    return data[0] == sway_e2e_crc(can_id, data);
}

/* The number congruent to `steps` modulo TURN that is nearest to elapsed / period. */
static int32_t unwrap(int32_t steps, int64_t elapsed_us, int32_t period_us)
{
    const int64_t turn_us = (int64_t)TURN * period_us;
    const int64_t rest_us = elapsed_us - (int64_t)steps * period_us + turn_us / 2;
    /* elapsed >= 0 and steps < TURN: never more than one turn down. */
    const int64_t turns = rest_us < 0 ? -1 : sway_int64_divide(rest_us, turn_us);
    return steps + (int32_t)turns * TURN;
}

/* The counter said "next": this is one period. A mean at first, so that two frames sent in one
 * burst are not taken for the period; a pause counts as two periods at most. */
static void learn(sway_e2e_t *e2e, int64_t elapsed_us)
{
    const bool known = e2e->learned >= SWAY_E2E_LEARN_MAX;
    const int64_t most_us = known ? 2 * (int64_t)e2e->period_us + 1000 : elapsed_us;
    const int32_t dt_us = (int32_t)(elapsed_us < most_us ? elapsed_us : most_us);
    e2e->learned = known ? e2e->learned : (uint8_t)(e2e->learned + 1U);
    e2e->period_us += (int32_t)sway_int64_divide(dt_us - e2e->period_us, e2e->learned);
}

static int32_t steps_since(sway_e2e_t *e2e, uint8_t counter, int64_t elapsed_us, int32_t limit_us)
{
    int32_t steps = (int32_t)counter - (int32_t)e2e->counter;
    steps += steps < 0 ? TURN : 0;
    if (elapsed_us > limit_us) {
        return steps == 0 ? 1 : steps;
    }
    if (steps == 1) {
        learn(e2e, elapsed_us);
        return 1;
    }
    if (e2e->learned >= SWAY_E2E_LEARN_MIN && e2e->period_us >= SWAY_E2E_PERIOD_MIN_US) {
        return unwrap(steps, elapsed_us, e2e->period_us);
    }
    return steps > TURN / 2 ? steps - TURN : steps;
}

int32_t sway_e2e_step(sway_e2e_t *e2e, uint8_t counter, int64_t time_us, int32_t limit_us)
{
    int32_t steps = 1;
    if (e2e->started) {
        const int64_t elapsed_us = time_us > e2e->time_us ? time_us - e2e->time_us : 0;
        steps = steps_since(e2e, counter, elapsed_us, limit_us);
    }
    if (steps >= 0) {
        e2e->counter = counter;
        e2e->time_us = time_us;
        e2e->started = true;
    }
    return steps;
}

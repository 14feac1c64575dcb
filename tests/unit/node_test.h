/* A node, frames into it and out of it: what both tests of sway_node use. */
#ifndef NODE_TEST_H
#define NODE_TEST_H

#include <string.h>
#include "reference_vehicle.h"
#include "sway_node.h"
#include "unity.h"

static sway_node_t node;
static uint8_t counter[SWAY_MESSAGE_COUNT];
static uint32_t slices; /* of work that sway_node_run() has done */

static const sway_core_config_t *config(void)
{
    static sway_core_config_t c;
    sway_core_defaults(&c);
    c.vehicle = reference_vehicle();
    return &c;
}

void setUp(void)
{
    TEST_ASSERT_EQUAL(SWAY_OK, sway_node_init(&node, config()));
    memset(counter, 0, sizeof counter);
}

void tearDown(void)
{
}

/* A frame with two 16-bit values, both marked valid, not yet protected. */
static void fill(uint8_t *data, int16_t first, int16_t second)
{
    memset(data, 0, 8);
    data[2] = (uint8_t)((uint16_t)first & 0xFFU);
    data[3] = (uint8_t)((uint16_t)first >> 8);
    data[4] = (uint8_t)((uint16_t)second & 0xFFU);
    data[5] = (uint8_t)((uint16_t)second >> 8);
}

static sway_error_t send(sway_message_t m, int64_t time_us, int16_t first, int16_t second)
{
    uint8_t data[8];
    const uint32_t id = sway_frames_input_id(m);
    fill(data, first, second);
    sway_e2e_protect(id, counter[m], data);
    counter[m] = sway_e2e_next(counter[m]);
    const sway_error_t error = sway_node_receive(&node, time_us, id, 8, data);
    while (sway_node_run(&node)) {
        slices++;
    }
    return error;
}

static int drain(uint32_t wanted_id, uint8_t *data)
{
    uint32_t id;
    uint8_t dlc;
    uint8_t frame[8];
    int found = 0;
    while (sway_node_transmit(&node, &id, &dlc, frame)) {
        TEST_ASSERT_EQUAL(8, dlc);
        TEST_ASSERT_TRUE(sway_e2e_check(id, frame));
        if (id == wanted_id) {
            memcpy(data, frame, 8);
            found++;
        }
    }
    return found;
}

/* The two bits of a message in the newest frame SwayInputs. */
static int reported_state(sway_message_t m)
{
    uint8_t data[8];
    TEST_ASSERT_EQUAL(1, drain(0x1B8, data));
    return data[2 + m / 4] >> (2 * (m % 4)) & 3;
}

static uint32_t frozen(void)
{
    return sway_node_fault(&node, SWAY_FRAME_FAULT_FROZEN);
}

/* The frames that are due, as bits from 0x1A0; each once, in order of their identifiers. */
static uint32_t due(void)
{
    uint32_t sent = 0;
    uint32_t id;
    uint8_t dlc;
    uint8_t frame[8];
    while (sway_node_transmit(&node, &id, &dlc, frame)) {
        TEST_ASSERT_UINT32_WITHIN(14, 0x1AE, id);
        TEST_ASSERT_LESS_THAN_UINT32(1U << (id - 0x1A0), sent);
        sent |= 1U << (id - 0x1A0);
    }
    return sent;
}

#endif

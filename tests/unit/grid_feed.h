/* Shared by the tests of sway_grid: a grid of 10 ms and its next row. */
#ifndef GRID_FEED_H
#define GRID_FEED_H

#include <string.h>

#include "signal/sway_grid.h"
#include "unity.h"

static sway_grid_t grid;
static sway_row_t tick;

void setUp(void)
{
    const sway_grid_config_t config = sway_grid_default(10000);
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_init(&grid, &config));
}

void tearDown(void)
{
}

static inline void put(sway_input_t input, int64_t time_us, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(SWAY_OK, sway_grid_input(&grid, input, time_us, value));
}

static inline bool is_valid(sway_channel_t channel)
{
    return (tick.valid_mask & SWAY_CHANNEL_BIT(channel)) != 0U;
}

#endif

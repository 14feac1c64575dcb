/* Fuzzer of the bus: frames of every message, most with right CRC and counter, at any time. What
 * comes out must be well formed, and nothing may run for ever. */
#include "fuzz.h"
#include "port_test.h"
#include "sway_node.h"

#define OUTPUTS_MAX 60

static void drain(sway_node_t *node)
{
    uint8_t data[8];
    uint8_t dlc = 0;
    uint32_t id = 0;
    int sent = 0;
    for (int slices = 0; sway_node_run(node); slices++) {
        require(slices < 100000);
    }
    for (; sway_node_transmit(node, &id, &dlc, data); sent++) {
        require(sent < OUTPUTS_MAX && dlc == 8U && sway_e2e_check(id, data));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const uint16_t ids[] = {0x120, 0x121, 0x122, 0x123, 0x124, 0x125, 0x130, 0x131,
                                   0x132, 0x133, 0x134, 0x135, 0x136, 0x137, 0x6E0, 0x1A0};
    static sway_node_t node;
    bytes_t from = {bytes, size};
    uint8_t counter[16] = {0};
    sway_core_config_t config = good_config();
    config.sample_period_us = 5000 + 5000 * (int32_t)(take(&from, 1) % 4U);
    require(sway_node_init(&node, &config) == SWAY_OK);
    int64_t time_us = (int64_t)take(&from, 4) << take(&from, 1) % 28U;
    while (from.left >= 8U) {
        const uint32_t how = take(&from, 1);
        const uint32_t which = how & 15U;
        uint8_t data[8];
        const uint32_t step = take(&from, 1);
        time_us += step < 250U ? step * 40U : (int64_t)(step - 252U) * 500000;
        for (unsigned i = 2; i < 8U; i++) {
            data[i] = (uint8_t)take(&from, 1);
        }
        data[1] = (uint8_t)(how & 0x10U ? data[2] & 0xF0U : 0U);
        sway_e2e_protect(ids[which], counter[which], data);
        counter[which] = how & 0x20U ? counter[which] : sway_e2e_next(counter[which]);
        data[0] ^= (how & 0xC0U) == 0xC0U ? 1U : 0U;
        const uint8_t dlc = (how & 0xE0U) == 0xA0U ? (uint8_t)(data[7] % 9U) : 8U;
        (void)sway_node_receive(&node, time_us, ids[which], dlc, data);
        drain(&node);
    }
    sway_node_time(&node, time_us + 1000000);
    drain(&node);
    return 0;
}

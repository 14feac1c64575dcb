#include "can.h"

#include <string.h>

#include "sway_registers.h"

#define BACKOFF_MAX_NS INT64_C(1000000000)

/* The standard's 128 times 11 recessive bits. */
static int64_t recovery_ns(const can_t *can)
{
    return INT64_C(128) * 11 * 1000000000 / (int64_t)can->config.bit_rate;
}

bool can_prepare(can_t *can, const can_config_t *config)
{
    if (config->filters > CAN_FILTERS || config->bit_rate == 0U || config->time_ns == NULL) {
        return false;
    }
    (void)memset(can, 0, sizeof *can);
    can->config = *config;
    can->backoff_ns = recovery_ns(can);
    return true;
}

void can_put(can_t *can, const sway_port_frame_t *frame)
{
    const uint32_t head = can->head;
    if (head - can->tail >= CAN_RING) {
        can->counters.overflows += 1U;
        return;
    }
    can->ring[head % CAN_RING] = *frame;
    can->counters.received += 1U;
    can->backoff_ns = recovery_ns(can); // the bus works
    sway_memory_barrier();              // the frame before the word that shows it
    can->head = head + 1U;
}

bool can_receive(can_t *can, sway_port_frame_t *frame)
{
    const uint32_t tail = can->tail;
    if (tail == can->head) {
        return false;
    }
    sway_memory_barrier();
    *frame = can->ring[tail % CAN_RING];
    sway_memory_barrier();
    can->tail = tail + 1U;
    return true;
}

void can_note_bus_off(can_t *can)
{
    can->counters.bus_offs += 1U;
    can->restart_ns = can->config.time_ns() + can->backoff_ns;
    can->backoff_ns = can->backoff_ns * 2 > BACKOFF_MAX_NS ? BACKOFF_MAX_NS : can->backoff_ns * 2;
    can->bus_off = true;
}

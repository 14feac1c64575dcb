/* The ECU alone, for the table of sizes: nothing in it but what a product needs. Frames come and go
 * through two rings in memory, as from a controller's interrupt. */
#include <string.h>

#include "fault.h"
#include "sway_checks.h"
#include "sway_ecu.h"

#ifndef MAILBOX_FRAMES
#define MAILBOX_FRAMES 16
#endif
#define RING ((uint32_t)MAILBOX_FRAMES)
#define REGISTER(address) (*(volatile uint32_t *)(address))
#define AIRCR REGISTER(0xE000ED0CU)
#define SYSTEM_RESET 0x05FA0004U

typedef struct {
    sway_port_frame_t frame[RING];
    volatile uint32_t head;
    volatile uint32_t tail;
} mailbox_t;

extern const uint8_t code_start[];
extern const uint32_t image_crc[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];

mailbox_t mailbox_in;
mailbox_t mailbox_out;
volatile int64_t mailbox_time_us;
__attribute__((section(".parameters"))) uint8_t mailbox_block[SWAY_BLOCK_SIZE]; // in flash
__attribute__((section(".parameters"))) uint8_t mailbox_key[SWAY_SIPHASH_KEY];

__attribute__((section(".noinit"))) static sway_ecu_retained_t retained;

void fault_stop(uint32_t cause, uint32_t address)
{
    sway_ecu_note_fault(&retained, cause, address);
    for (;;) {
        AIRCR = SYSTEM_RESET;
    }
}

void main_returned(int status)
{
    fault_stop(0U, (uint32_t)status); // it never does
}

static bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (mailbox_in.tail == mailbox_in.head) {
        return false;
    }
    *frame = mailbox_in.frame[mailbox_in.tail % RING];
    mailbox_in.tail = mailbox_in.tail + 1U;
    return true;
}

static bool send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (mailbox_out.head - mailbox_out.tail >= RING) {
        return false;
    }
    mailbox_out.frame[mailbox_out.head % RING] = *frame;
    mailbox_out.head = mailbox_out.head + 1U;
    return true;
}

static int64_t time_us(void *context)
{
    (void)context;
    return mailbox_time_us;
}

int main(void)
{
    static sway_ecu_t ecu;
    const sway_port_t port = {
        .receive = receive, .send = send, .time_us = time_us, .key = mailbox_key};
    (void)sway_ecu_start(&ecu, &port, &retained, mailbox_block, sizeof mailbox_block);
    if (!sway_check_image(code_start, (size_t)((uintptr_t)image_crc - (uintptr_t)code_start),
                          image_crc[0])) {
        sway_ecu_fail(&ecu, SWAY_ECU_IMAGE);
    }
    if (!sway_check_memory(bss_start, bss_end)) {
        sway_ecu_fail(&ecu, SWAY_ECU_MEMORY);
    }
    for (;;) {
        (void)sway_ecu_poll(&ecu);
    }
}

/* The ECU on a NUCLEO-G474RE with a CAN transceiver at PA11 (receive) and PA12 (transmit). */
#include "board.h"
#include "fault.h"
#include "program.h"
#include "sway_checks.h"

extern const uint8_t code_start[];
extern const uint32_t image_crc[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];

__attribute__((section(".noinit"))) static sway_ecu_retained_t retained;

void fault_stop(uint32_t cause, uint32_t address)
{
    sway_ecu_note_fault(&retained, cause, address);
    for (;;) {
        board_restart();
    }
}

void main_returned(int status)
{
    fault_stop(SWAY_ECU_CONTROLLER, (uint32_t)status);
}

void interrupt_21(void)
{
    program_can_interrupt();
}

/* A double word of the parameters that was being written when power went says so in this way. */
void interrupt_nmi(void)
{
    if (!program_nmi()) {
        fault_stop(2U, 0U);
    }
}

/* Keeps the clock's count of turns, and ends the sleep that waits for time to pass. */
void interrupt_tick(void)
{
    (void)board_time_ns();
}

/* Not where it may be the image itself that faults when it is read: sway_ecu_start() stays safe. */
static sway_ecu_cause_t check(void)
{
    if (sway_ecu_gave_up(&retained)) {
        return SWAY_ECU_NO_CAUSE;
    }
    const size_t size = (size_t)((uintptr_t)image_crc - (uintptr_t)code_start);
    if (!sway_check_image(code_start, size, image_crc[0])) {
        return SWAY_ECU_IMAGE;
    }
    return sway_check_memory(bss_start, bss_end) ? SWAY_ECU_NO_CAUSE : SWAY_ECU_MEMORY;
}

int main(void)
{
    if (!program_start(&retained, check())) {
        return 1; // no crystal or no controller: main_returned() restarts, and it is tried again
    }
    for (;;) {
        if (!program_pass()) {
            __asm__ volatile("wfi");
        }
    }
}

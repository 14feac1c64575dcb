/* The replay program on an emulated Cortex-M, with figures of what it costs.
 *
 * Arguments: BLOCK RECORDING OUTPUT FIGURES. OUTPUT gets the frames, FIGURES one `name value` per
 * line. A fault is noted in retained memory, the processor restarts, and the ECU reports it. */
#include <string.h>

#include "bench.h"
#include "fault.h"
#include "figures.h"
#include "replay.h"
#include "semihosting.h"

#define AIRCR (*(volatile uint32_t *)0xE000ED0CU)
#define SYSTEM_RESET 0x05FA0004U

__attribute__((section(".noinit"))) static sway_ecu_retained_t retained;

void fault_stop(uint32_t cause, uint32_t address)
{
    sway_ecu_note_fault(&retained, cause == 2U ? (uint32_t)SWAY_ECU_WATCHDOG : cause, address);
    for (;;) {
        AIRCR = SYSTEM_RESET;
    }
}

static int32_t machine_open(const char *path, bool write_it)
{
    return semihosting_open(path, write_it ? SEMIHOSTING_WRITE : SEMIHOSTING_READ);
}

int main(void)
{
    static sway_ecu_t ecu;
    static char arguments[512];
    const replay_machine_t machine = {.open = machine_open,
                                      .read = semihosting_read,
                                      .write = semihosting_write,
                                      .standard_output = semihosting_stdout(),
                                      .began = figures_began,
                                      .returned = figures_returned};
    semihosting_arguments(arguments, sizeof arguments);
    char *figures_path = strrchr(arguments, ' ');
    if (figures_path == NULL) {
        return 2;
    }
    *figures_path++ = '\0';
    const int status = replay_run(&ecu, &retained, &machine, arguments);
    figures_write(figures_path, &ecu);
    return status;
}

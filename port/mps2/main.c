/* The replay program on an emulated Cortex-M, with figures of what it costs.
 *
 * Arguments: BLOCK RECORDING OUTPUT FIGURES [DRILL]. OUTPUT gets the frames, FIGURES one
 * `name value` per line. A fault is noted in retained memory, the processor restarts, the recording
 * starts again, and the ECU reports what happened. DRILL makes a fault on purpose, once: null (a
 * write to it), read (a read from it), stack, undefined, hang, state, cut (power goes between
 * erasing and writing the second block stored), memory (the check finds memory that is none). */
#include <string.h>

#include "fault.h"
#include "figures.h"
#include "replay.h"
#include "semihosting.h"
#include "sway_checks.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define AIRCR REGISTER(0xE000ED0CU)
#define SYSTEM_RESET 0x05FA0004U
#define SYST_CALIB ((volatile uint32_t *)0xE000E01CU) // read only
#define WATCHDOG_LOAD REGISTER(0x40008000U)
#define WATCHDOG_CONTROL REGISTER(0x40008008U)
#define WATCHDOG_CLEAR REGISTER(0x4000800CU)
#define WATCHDOG_LOCK REGISTER(0x40008C00U)
#define WATCHDOG_KEY 0x1ACCE551U
#define WATCHDOG_NMI_AND_RESET 3U
#define WATCHDOG_TICKS 100000000U // 4 s, 16 million instructions

#define NMI 2U
#define DRILL_AFTER 500U

extern const uint8_t code_start[];
extern const uint32_t image_crc[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];

__attribute__((section(".noinit"))) static sway_ecu_retained_t retained;
__attribute__((section(".noinit"))) static pages_t pages;
static sway_ecu_t ecu;
static const char *drill = "";
static uint32_t polls;

static void restart(void) __attribute__((noreturn));
static void restart(void)
{
    for (;;) {
        AIRCR = SYSTEM_RESET;
    }
}

void fault_stop(uint32_t cause, uint32_t address)
{
    sway_ecu_note_fault(&retained, cause == NMI ? (uint32_t)SWAY_ECU_WATCHDOG : cause, address);
    restart();
}

/* --- faults on purpose ------------------------------------------------------------------------ */

static uint32_t recurse(const volatile uint32_t *before)
{
    volatile uint32_t here[16];
    here[0] = *before + 1U;
    return polls == 0U ? here[0] : recurse(here) + here[0];
}

static void make_fault(void)
{
    volatile uint32_t zero = 0U;
    if (strcmp(drill, "null") == 0) {
        REGISTER((uintptr_t)zero) = 1U;
    } else if (strcmp(drill, "read") == 0) {
        zero = REGISTER((uintptr_t)zero + 8U);
    } else if (strcmp(drill, "stack") == 0) {
        zero = recurse(&zero);
    } else if (strcmp(drill, "undefined") == 0) {
        __asm__ volatile("udf #0");
    } else if (strcmp(drill, "state") == 0) {
        ecu.canary = 0U;
    } else if (strcmp(drill, "hang") == 0) {
        while (zero == 0U) {
        }
    }
}

/* The power goes: nothing is noted. */
static void cut_power(uint32_t erasures)
{
    if (erasures == 2U && strcmp(drill, "cut") == 0) {
        restart();
    }
}

/* --- the machine ------------------------------------------------------------------------------ */

static void alive(void *context)
{
    (void)context;
    WATCHDOG_LOCK = WATCHDOG_KEY;
    WATCHDOG_CLEAR = 1U;
    WATCHDOG_LOCK = 0U;
    polls++;
    if (polls == DRILL_AFTER && retained.restarts == 0U) {
        make_fault();
    }
}

static void start_watchdog(void)
{
    WATCHDOG_LOCK = WATCHDOG_KEY;
    WATCHDOG_LOAD = WATCHDOG_TICKS;
    WATCHDOG_CONTROL = WATCHDOG_NMI_AND_RESET;
    WATCHDOG_LOCK = 0U;
}

/* The page at NULL can only be read by the processor itself: the image counts from behind it. */
static sway_ecu_cause_t check(void)
{
    const size_t size = (size_t)((uintptr_t)image_crc - (uintptr_t)code_start);
    if (!sway_check_image(code_start, size, image_crc[0])) {
        return SWAY_ECU_IMAGE;
    }
    if (strcmp(drill, "memory") == 0) {
        return sway_check_memory(SYST_CALIB, SYST_CALIB + 1) ? SWAY_ECU_NO_CAUSE : SWAY_ECU_MEMORY;
    }
    return sway_check_memory(bss_start, bss_end) ? SWAY_ECU_NO_CAUSE : SWAY_ECU_MEMORY;
}

static int32_t machine_open(const char *path, bool write_it)
{
    return semihosting_open(path, write_it ? SEMIHOSTING_WRITE : SEMIHOSTING_READ);
}

int main(void)
{
    static char arguments[512];
    const replay_machine_t machine = {.open = machine_open,
                                      .read = semihosting_read,
                                      .write = semihosting_write,
                                      .standard_output = semihosting_stdout(),
                                      .check = check,
                                      .alive = alive,
                                      .erased = cut_power,
                                      .began = figures_began,
                                      .stopped = figures_stopped};
    semihosting_arguments(arguments, sizeof arguments);
    char *rest = arguments;
    const char *block_path = replay_word(&rest);
    const char *recording = replay_word(&rest);
    const char *output = replay_word(&rest);
    const char *figures_path = replay_word(&rest);
    drill = replay_word(&rest);
    if (figures_path[0] == '\0') {
        return 2;
    }
    start_watchdog();
    const int status = replay_run(&ecu, &retained, &pages, &machine, block_path, recording, output);
    figures_write(figures_path, &ecu);
    return status;
}

#include "r5.h"

#include <string.h>

#define PAINT UINT32_C(0xA5C3F00D)

extern uint32_t data_start[];
extern uint32_t data_end[];
extern uint32_t data_load[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];
extern uint32_t stack_guard[];
extern uint32_t stack_bottom[];
extern uint32_t stack_top[];

int main(void);
void start(void);
void _start(void);

/* --- memory protection (ARM DDI 0460, PMSAv7) ------------------------------------------------- */

#define REGION_SIZE(log2) ((uint32_t)((log2)-1U) << 1 | 1U)
#define NO_ACCESS 0x1000U       // and never executed
#define READ_ONLY 0x0608U       // normal memory, not cached
#define READ_WRITE_DATA 0x1308U // normal memory, never executed

static void region(uint32_t number, uint32_t base, uint32_t size, uint32_t access)
{
    __asm__ volatile("mcr p15, 0, %0, c6, c2, 0\n"
                     "mcr p15, 0, %1, c6, c1, 0\n"
                     "mcr p15, 0, %3, c6, c1, 4\n"
                     "mcr p15, 0, %2, c6, c1, 2\n"
                     :
                     : "r"(number), "r"(base), "r"(size), "r"(access)
                     : "memory");
}

/* A higher number wins; 0xFFFF0000 on holds the vectors. Peripherals keep the background map. */
static void protect(void)
{
    uint32_t control;
    region(0U, 0xFFFC0000U, REGION_SIZE(18U), READ_WRITE_DATA);
    region(1U, 0xFFFC0000U, REGION_SIZE(16U), READ_ONLY);
    region(2U, 0xFFFD0000U, REGION_SIZE(15U), READ_ONLY);
    region(3U, 0xFFFF0000U, REGION_SIZE(8U), READ_ONLY);
    region(4U, 0U, REGION_SIZE(12U), NO_ACCESS);
    region(5U, (uint32_t)(uintptr_t)stack_guard, REGION_SIZE(8U), NO_ACCESS);
    __asm__ volatile("mrc p15, 0, %0, c1, c0, 0" : "=r"(control));
    control |= 1U << 17 | 1U; // background map, MPU on
    __asm__ volatile("dsb\n mcr p15, 0, %0, c1, c0, 0\n isb" : : "r"(control) : "memory");
}

/* --- clock ------------------------------------------------------------------------------------ */

static uint64_t cycles;
static uint32_t cycles_seen;

static void start_clock(void)
{
    __asm__ volatile("mcr p15, 0, %0, c9, c12, 0" : : "r"(5U));                // PMCR: on, cleared
    __asm__ volatile("mcr p15, 0, %0, c9, c12, 1" : : "r"(UINT32_C(1) << 31)); // cycle counter
}

int64_t r5_time_ns(void)
{
    uint32_t now;
    uint32_t status;
    __asm__ volatile("mrs %0, cpsr\n cpsid i" : "=r"(status) : : "memory");
    __asm__ volatile("mrc p15, 0, %0, c9, c13, 0" : "=r"(now));
    cycles += (uint32_t)(now - cycles_seen);
    cycles_seen = now;
    const uint64_t count = cycles;
    __asm__ volatile("msr cpsr_c, %0" : : "r"(status) : "memory");
    return R5_CLOCK_HZ == INT64_C(1000000000)
               ? (int64_t)count
               : (int64_t)(count / (uint64_t)R5_CLOCK_HZ * 1000000000U +
                           count % (uint64_t)R5_CLOCK_HZ * 1000000000U / (uint64_t)R5_CLOCK_HZ);
}

/* --- start ------------------------------------------------------------------------------------ */

static void paint_stack(void)
{
    uint32_t *sp;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    for (uint32_t *word = stack_bottom; word < sp - 16; word++) {
        *word = PAINT;
    }
}

uint32_t r5_stack_used(void)
{
    const uint32_t *word = stack_bottom;
    while (word < stack_top && *word == PAINT) {
        word++;
    }
    return (uint32_t)((uintptr_t)stack_top - (uintptr_t)word);
}

void start(void)
{
    memcpy(data_start, data_load, (size_t)((uintptr_t)data_end - (uintptr_t)data_start));
    memset(bss_start, 0, (size_t)((uintptr_t)bss_end - (uintptr_t)bss_start));
    protect();
    paint_stack();
    start_clock();
    (void)main();
    r5_restart();
}

void r5_restart(void)
{
    _start();
    for (;;) {
    }
}

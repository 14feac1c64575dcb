#include "bench.h"

#include <string.h>

#include "fault.h"
#include "semihosting.h"

/* Timer 0 of the CMSDK: 32 bits, where SysTick's 24 wrap after 2.6 million instructions. */
#define TIMER0_CTRL (*(volatile uint32_t *)0x40000000U)
#define TIMER0_VALUE (*(volatile uint32_t *)0x40000004U)
#define TIMER0_RELOAD (*(volatile uint32_t *)0x40000008U)

extern uint32_t stack_bottom[];
extern uint32_t stack_top[];

uint32_t bench_now(void)
{
    if (TIMER0_CTRL == 0U) {
        TIMER0_RELOAD = UINT32_MAX;
        TIMER0_VALUE = UINT32_MAX;
        TIMER0_CTRL = 1U;
    }
    return UINT32_MAX - TIMER0_VALUE;
}

static uint32_t between(uint32_t before, uint32_t after)
{
    return (uint32_t)(((uint64_t)(after - before) * 10U + 32U) / 64U);
}

uint32_t bench_instructions(uint32_t before, uint32_t after)
{
    static uint32_t overhead = UINT32_MAX;
    if (overhead == UINT32_MAX) {
        const uint32_t first = bench_now();
        const uint32_t second = bench_now();
        overhead = between(first, second);
    }
    const uint32_t count = between(before, after);
    return count > overhead ? count - overhead : 0U;
}

static uint32_t *stack_pointer(void)
{
    uint32_t *sp;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    return sp;
}

void bench_paint_stack(void)
{
    for (uint32_t *word = stack_bottom; word < stack_pointer() - 16; word++) {
        *word = STACK_PAINT;
    }
}

uint32_t bench_stack_used(void)
{
    const uint32_t *word = stack_bottom;
    while (word < stack_top && *word == STACK_PAINT) {
        word++;
    }
    return (uint32_t)((uintptr_t)stack_top - (uintptr_t)word);
}

void bench_text(const char *text)
{
    (void)semihosting_write(semihosting_stdout(), text, strlen(text));
}

void bench_number(int64_t value)
{
    char digits[24];
    char *at = &digits[sizeof digits - 1U];
    uint64_t rest = value < 0 ? UINT64_C(0) - (uint64_t)value : (uint64_t)value;
    *at = '\0';
    do {
        *--at = (char)('0' + (char)(rest % 10U));
        rest /= 10U;
    } while (rest != 0U);
    if (value < 0) {
        *--at = '-';
    }
    bench_text(at);
}

void bench_line(const char *name, int64_t value)
{
    bench_text(name);
    bench_text(" ");
    bench_number(value);
    bench_text("\n");
}

void main_returned(int status)
{
    semihosting_exit(status);
}

__attribute__((weak)) void fault_stop(uint32_t cause, uint32_t address)
{
    bench_line("fault", (int64_t)cause);
    bench_line("at", (int64_t)address);
    semihosting_exit(99);
}

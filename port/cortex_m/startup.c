/* From reset to main() on a Cortex-M.
 *
 * main() runs on its own stack (PSP) with a no-access page under it; exceptions run on another
 * (MSP), so that a stack overflow can still be reported. */
#include <stdint.h>
#include <string.h>

#include "fault.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define SCB_VTOR REGISTER(0xE000ED08U)
#define SCB_SHCSR REGISTER(0xE000ED24U)
#define SCB_CPACR REGISTER(0xE000ED88U)
#define MPU_TYPE REGISTER(0xE000ED90U)
#define MPU_CTRL REGISTER(0xE000ED94U)
#define MPU_RNR REGISTER(0xE000ED98U)
#define MPU_RBAR REGISTER(0xE000ED9CU)
#define MPU_RASR REGISTER(0xE000EDA0U)

extern uint32_t image_lowest[];
extern uint32_t data_start[];
extern uint32_t data_end[];
extern uint32_t data_load[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];
extern uint32_t stack_guard[];
extern uint32_t stack_bottom[];
extern uint32_t stack_top[];
extern uint32_t handler_stack_top[];

int main(void);
void reset_handler(void);
void fault_entry(void);
void fault_collect(const uint32_t *frame) __attribute__((used));
void start(void) __attribute__((used));

/* Region attributes: access permission at bit 24, execute-never bit 28, size 2^(n+1) at bit 1. */
#ifndef MPU_FLASH_LOG2
#define MPU_FLASH_LOG2 22U // how much flash is the program's and read only
#endif
#define MPU_ENABLE 1U
#define MPU_SIZE(log2) ((uint32_t)((log2)-1U) << 1)
#define MPU_NO_ACCESS (0U << 24)
#define MPU_READ_WRITE (3U << 24)
#define MPU_READ_ONLY (6U << 24)
#define MPU_EXECUTE_NEVER (1U << 28)
#define MPU_NORMAL ((1U << 17) | (1U << 18))

static void mpu_region(uint32_t number, uint32_t base, uint32_t attributes)
{
    MPU_RNR = number;
    MPU_RBAR = base;
    MPU_RASR = attributes | MPU_ENABLE;
}

/* A higher number wins where regions overlap: the two no-access pages come last. The vectors may
 * lie in the page at NULL; the processor fetches them past the MPU. */
static void mpu_start(void)
{
    if (MPU_TYPE == 0U) {
        return;
    }
    mpu_region(0U, (uint32_t)(uintptr_t)image_lowest,
               MPU_READ_ONLY | MPU_NORMAL | MPU_SIZE(MPU_FLASH_LOG2));
    mpu_region(1U, 0x20000000U, MPU_READ_WRITE | MPU_NORMAL | MPU_EXECUTE_NEVER | MPU_SIZE(22U));
    mpu_region(2U, 0U, MPU_NO_ACCESS | MPU_EXECUTE_NEVER | MPU_SIZE(8U));
    mpu_region(3U, (uint32_t)(uintptr_t)stack_guard,
               MPU_NO_ACCESS | MPU_EXECUTE_NEVER | MPU_SIZE(8U));
    MPU_CTRL = 5U; // on, with the default map behind it
    __asm__ volatile("dsb\n isb" ::: "memory");
}

static void paint_stack(void)
{
    uint32_t *sp;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    for (uint32_t *word = stack_bottom; word < sp - 16; word++) {
        *word = STACK_PAINT;
    }
}

void start(void)
{
    memcpy(data_start, data_load, (size_t)((uintptr_t)data_end - (uintptr_t)data_start));
    memset(bss_start, 0, (size_t)((uintptr_t)bss_end - (uintptr_t)bss_start));
#if __ARM_ARCH >= 7
    SCB_SHCSR = 7U << 16; // MemManage, BusFault and UsageFault have their own exceptions
    SCB_CPACR |= 0xFU << 20;
#endif
    mpu_start();
    paint_stack();
    main_returned(main());
}

__attribute__((naked)) void reset_handler(void)
{
    __asm__ volatile("ldr r0, =stack_top\n"
                     "msr psp, r0\n"
                     "movs r0, #2\n"
                     "msr control, r0\n"
                     "isb\n"
                     "bl start\n"
                     ".ltorg\n");
}

/* r0: the frame that the processor has pushed. */
__attribute__((naked)) void fault_entry(void)
{
    __asm__ volatile("mov r1, lr\n"
                     "movs r0, #4\n"
                     "tst r0, r1\n"
                     "beq 1f\n"
                     "mrs r0, psp\n"
                     "b 2f\n"
                     "1: mrs r0, msp\n"
                     "2: ldr r1, =handler_stack_top\n"
                     "mov sp, r1\n"
                     "bl fault_collect\n"
                     ".ltorg\n");
}

/* The frame itself is unreadable after a stack overflow: it would lie in the guard. */
void fault_collect(const uint32_t *frame)
{
    uint32_t cause;
    uint32_t address = 0U;
    __asm__ volatile("mrs %0, ipsr" : "=r"(cause));
    if (frame >= stack_guard + 64 && frame + 8 <= handler_stack_top) {
        address = frame[6];
    }
    fault_stop(cause, address);
}

/* A program that has an interrupt defines its function; any other interrupt is a fault. */
void interrupt_nmi(void) __attribute__((weak, alias("fault_entry")));
void interrupt_tick(void) __attribute__((weak, alias("fault_entry")));
void interrupt_21(void) __attribute__((weak, alias("fault_entry")));

typedef void (*vector_t)(void);

__attribute__((section(".vectors"), used)) static const vector_t vectors[48] = {
    (vector_t)(uintptr_t)handler_stack_top,
    reset_handler,
    interrupt_nmi, // the watchdog, errors of memory
    fault_entry,   // HardFault
    fault_entry,   // MemManage
    fault_entry,   // BusFault
    fault_entry,   // UsageFault
    [15] = interrupt_tick,
    [16 + 21] = interrupt_21,
};

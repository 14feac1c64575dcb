#include "board.h"

#include "stm32g474.h"
#include "sway_registers.h"

#define POLLS 1000000U
#define WATCHDOG_PRESCALER 3U // 32 kHz / 32: a millisecond
#define WATCHDOG_MS 500U
#define TICK_HZ 1000U

static uint32_t get(uintptr_t base, uintptr_t offset)
{
    return sway_register_read(base + offset);
}

static void put(uintptr_t base, uintptr_t offset, uint32_t value)
{
    sway_register_write(base + offset, value);
}

static void change(uintptr_t base, uintptr_t offset, uint32_t mask, uint32_t value)
{
    put(base, offset, (get(base, offset) & ~mask) | value);
}

static bool wait_for(uintptr_t base, uintptr_t offset, uint32_t mask, uint32_t wanted)
{
    for (uint32_t polls = 0; polls < POLLS; polls++) {
        if ((get(base, offset) & mask) == wanted) {
            return true;
        }
    }
    return false;
}

/* 24 MHz / 6 x 84 / 2 = 168 MHz. Above 150 MHz the regulator has to boost; above 80 MHz the bus
 * clock goes up in two steps (RM0440, "System clock selection"). */
static bool start_clock(void)
{
    change(STM32_RCC, RCC_CR, RCC_CR_HSEON, RCC_CR_HSEON);
    if (!wait_for(STM32_RCC, RCC_CR, RCC_CR_HSERDY, RCC_CR_HSERDY)) {
        return false;
    }
    change(STM32_RCC, RCC_APB1ENR1, RCC_APB1ENR1_PWR, RCC_APB1ENR1_PWR);
    (void)get(STM32_RCC, RCC_APB1ENR1); // the clock is there after one access
    change(STM32_PWR, PWR_CR5, PWR_CR5_R1MODE, 0U);
    change(STM32_FLASH, FLASH_ACR, FLASH_ACR_LATENCY_MASK,
           4U | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    if (!wait_for(STM32_FLASH, FLASH_ACR, FLASH_ACR_LATENCY_MASK, 4U)) {
        return false;
    }
    put(STM32_RCC, RCC_PLLCFGR,
        RCC_PLLCFGR_SRC_HSE | RCC_PLLCFGR_M(6) | RCC_PLLCFGR_N(84) | RCC_PLLCFGR_REN);
    change(STM32_RCC, RCC_CR, RCC_CR_PLLON, RCC_CR_PLLON);
    if (!wait_for(STM32_RCC, RCC_CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY)) {
        return false;
    }
    change(STM32_RCC, RCC_CFGR, RCC_CFGR_HPRE_MASK, RCC_CFGR_HPRE_DIV2);
    change(STM32_RCC, RCC_CFGR, 3U, RCC_CFGR_SW_PLL);
    const bool is_on = wait_for(STM32_RCC, RCC_CFGR, RCC_CFGR_SWS_MASK, RCC_CFGR_SWS_PLL);
    for (uint32_t i = 0; i < 100U; i++) { // more than a microsecond
        (void)get(STM32_RCC, RCC_CFGR);
    }
    change(STM32_RCC, RCC_CFGR, RCC_CFGR_HPRE_MASK, 0U);
    return is_on;
}

static void start_timer(uintptr_t timer)
{
    put(timer, TIM_PSC, BOARD_CPU_HZ / 1000000U - 1U);
    put(timer, TIM_ARR, UINT32_MAX); // of TIM3's 16 bits as many as it has
    put(timer, TIM_EGR, TIM_EGR_UG); // takes the prescaler over
    put(timer, TIM_CR1, TIM_CR1_CEN);
}

static void start_pins(void)
{
    const uint32_t both = 15U << 12 | 15U << 16;
    change(STM32_GPIOA, GPIO_AFRH, both, GPIO_AF_FDCAN1 << 12 | GPIO_AF_FDCAN1 << 16);
    change(STM32_GPIOA, GPIO_MODER, 3U << 22 | 3U << 24, 2U << 22 | 2U << 24);
}

bool board_start(void)
{
    if (!start_clock()) {
        return false;
    }
    change(STM32_RCC, RCC_AHB2ENR, RCC_AHB2ENR_GPIOA, RCC_AHB2ENR_GPIOA);
    const uint32_t used = RCC_APB1ENR1_TIM2 | RCC_APB1ENR1_TIM3 | RCC_APB1ENR1_FDCAN;
    change(STM32_RCC, RCC_APB1ENR1, used, used);
    change(STM32_RCC, RCC_CCIPR, RCC_CCIPR_FDCAN_MASK, 0U); // from the crystal
    start_pins();
    start_timer(STM32_TIM2);
    start_timer(STM32_TIM3);
    return true;
}

void board_enable_interrupts(void)
{
    put(CORTEX_SYST_RVR, 0U, BOARD_CPU_HZ / TICK_HZ - 1U);
    put(CORTEX_SYST_CVR, 0U, 0U);
    put(CORTEX_SYST_CSR, 0U, 7U);
    put(CORTEX_NVIC_ISER0, 0U, 1U << STM32_IRQ_FDCAN1_IT0);
}

/* 64 bits out of 32, without a lock: the high half is that of the last reading, one more where the
 * low half has turned over since. A reading that is interrupted by another finds the same. */
int64_t board_time_ns(void)
{
    static volatile uint32_t turns_and_half; // turns x 2 + the counter's highest bit
    const uint32_t before = turns_and_half;
    const uint32_t now = get(STM32_TIM2, TIM_CNT);
    const uint32_t half = now >> 31;
    const uint32_t after = before + ((before ^ half) & 1U);
    turns_and_half = after;
    return (int64_t)((uint64_t)(after >> 1) << 32 | now) * 1000;
}

void board_start_watchdog(void)
{
    put(STM32_IWDG, IWDG_KR, IWDG_KEY_START);
    put(STM32_IWDG, IWDG_KR, IWDG_KEY_ACCESS);
    put(STM32_IWDG, IWDG_PR, WATCHDOG_PRESCALER);
    put(STM32_IWDG, IWDG_RLR, WATCHDOG_MS - 1U);
    (void)wait_for(STM32_IWDG, IWDG_SR, 7U, 0U);
    board_serve_watchdog();
}

void board_serve_watchdog(void)
{
    put(STM32_IWDG, IWDG_KR, IWDG_KEY_RELOAD);
}

bool board_was_watchdog(void)
{
    const bool was = (get(STM32_RCC, RCC_CSR) & RCC_CSR_IWDGRSTF) != 0U;
    change(STM32_RCC, RCC_CSR, RCC_CSR_RMVF, RCC_CSR_RMVF);
    return was;
}

/* Clocked by the 48 MHz oscillator, whose clock the generator has to have. */
uint32_t board_random(void)
{
    change(STM32_RCC, RCC_CRRCR, RCC_CRRCR_HSI48ON, RCC_CRRCR_HSI48ON);
    if (!wait_for(STM32_RCC, RCC_CRRCR, RCC_CRRCR_HSI48RDY, RCC_CRRCR_HSI48RDY)) {
        return 0U;
    }
    change(STM32_RCC, RCC_CCIPR, RCC_CCIPR_CLK48_MASK, 0U);
    change(STM32_RCC, RCC_AHB2ENR, RCC_AHB2ENR_RNG, RCC_AHB2ENR_RNG);
    change(STM32_RNG, RNG_CR, RNG_CR_RNGEN, RNG_CR_RNGEN);
    const bool is_ready = wait_for(STM32_RNG, RNG_SR, RNG_SR_DRDY, RNG_SR_DRDY);
    return is_ready ? get(STM32_RNG, RNG_DR) : 0U;
}

void board_restart(void)
{
    put(CORTEX_AIRCR, 0U, CORTEX_AIRCR_RESET);
}

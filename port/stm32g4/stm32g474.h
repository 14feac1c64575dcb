/// stm32g474: the registers of the STM32G474 that this port uses, named as in ST's reference manual
/// RM0440. Written for swaywatch; addresses in bytes.
#ifndef SWAY_STM32G474_H
#define SWAY_STM32G474_H

/* Memory. Two banks of flash (option bit DBANK as delivered): program in the first, parameters in
 * the second, so that the program runs on while a page of parameters is erased. */
#define STM32_FLASH_BANK1 0x08000000U
#define STM32_FLASH_BANK2 0x08040000U
#define STM32_FLASH_PAGE 2048U

/* Timers: TIM2 counts microseconds in 32 bits, TIM3 the same in 16 for the FDCAN's stamps. */
#define STM32_TIM2 0x40000000U
#define STM32_TIM3 0x40000400U
#define TIM_CR1 0x00U
#define TIM_EGR 0x14U
#define TIM_CNT 0x24U
#define TIM_PSC 0x28U
#define TIM_ARR 0x2CU
#define TIM_CR1_CEN (1U << 0)
#define TIM_EGR_UG (1U << 0)

/* Independent watchdog. */
#define STM32_IWDG 0x40003000U
#define IWDG_KR 0x00U
#define IWDG_PR 0x04U
#define IWDG_RLR 0x08U
#define IWDG_SR 0x0CU
#define IWDG_KEY_RELOAD 0xAAAAU
#define IWDG_KEY_ACCESS 0x5555U
#define IWDG_KEY_START 0xCCCCU

/* CAN. */
#define STM32_FDCAN1 0x40006400U
#define STM32_FDCAN1_RAM 0x4000A400U

/* Power. */
#define STM32_PWR 0x40007000U
#define PWR_CR5 0x80U
#define PWR_CR5_R1MODE (1U << 8) ///< clear: boost, for more than 150 MHz

/* Reset and clocks. */
#define STM32_RCC 0x40021000U
#define RCC_CR 0x00U
#define RCC_CFGR 0x08U
#define RCC_PLLCFGR 0x0CU
#define RCC_AHB2ENR 0x4CU
#define RCC_APB1ENR1 0x58U
#define RCC_CCIPR 0x88U
#define RCC_CSR 0x94U
#define RCC_CRRCR 0x98U
#define RCC_CR_HSEON (1U << 16)
#define RCC_CR_HSERDY (1U << 17)
#define RCC_CR_PLLON (1U << 24)
#define RCC_CR_PLLRDY (1U << 25)
#define RCC_CFGR_SW_PLL 3U
#define RCC_CFGR_SWS_MASK (3U << 2)
#define RCC_CFGR_SWS_PLL (3U << 2)
#define RCC_CFGR_HPRE_MASK (15U << 4)
#define RCC_CFGR_HPRE_DIV2 (8U << 4)
#define RCC_PLLCFGR_SRC_HSE 3U
#define RCC_PLLCFGR_M(m) (((uint32_t)(m)-1U) << 4)
#define RCC_PLLCFGR_N(n) ((uint32_t)(n) << 8)
#define RCC_PLLCFGR_REN (1U << 24) ///< output R, the system clock, divided by 2
#define RCC_AHB2ENR_GPIOA (1U << 0)
#define RCC_AHB2ENR_RNG (1U << 26)
#define RCC_APB1ENR1_TIM2 (1U << 0)
#define RCC_APB1ENR1_TIM3 (1U << 1)
#define RCC_APB1ENR1_FDCAN (1U << 25)
#define RCC_APB1ENR1_PWR (1U << 28)
#define RCC_CCIPR_FDCAN_MASK (3U << 24) ///< 0: HSE
#define RCC_CCIPR_CLK48_MASK (3U << 26) ///< 0: HSI48
#define RCC_CRRCR_HSI48ON (1U << 0)
#define RCC_CRRCR_HSI48RDY (1U << 1)
#define RCC_CSR_RMVF (1U << 23)
#define RCC_CSR_IWDGRSTF (1U << 29)

/* Flash. */
#define STM32_FLASH 0x40022000U
#define FLASH_ACR 0x00U
#define FLASH_KEYR 0x08U
#define FLASH_SR 0x10U
#define FLASH_CR 0x14U
#define FLASH_ECCR 0x18U
#define FLASH_ACR_LATENCY_MASK 15U
#define FLASH_ACR_PRFTEN (1U << 8)
#define FLASH_ACR_ICEN (1U << 9)
#define FLASH_ACR_DCEN (1U << 10)
#define FLASH_ACR_DCRST (1U << 12)
#define FLASH_KEY1 0x45670123U
#define FLASH_KEY2 0xCDEF89ABU
#define FLASH_SR_ERRORS 0xC3FAU
#define FLASH_SR_BSY (1U << 16)
#define FLASH_CR_PG (1U << 0)
#define FLASH_CR_PER (1U << 1)
#define FLASH_CR_PAGE(page) ((uint32_t)(page) << 3)
#define FLASH_CR_BANK2 (1U << 11)
#define FLASH_CR_STRT (1U << 16)
#define FLASH_CR_LOCK (1U << 31)
#define FLASH_ECCR_ECCD (1U << 31) ///< two bits of a double word are wrong; raises the NMI

/* Random numbers. */
#define STM32_RNG 0x50060800U
#define RNG_CR 0x00U
#define RNG_SR 0x04U
#define RNG_DR 0x08U
#define RNG_CR_RNGEN (1U << 2)
#define RNG_SR_DRDY (1U << 0)

/* Pins. PA11: CAN receive, PA12: CAN transmit, both alternate function 9; PA5: the board's LED. */
#define STM32_GPIOA 0x48000000U
#define GPIO_MODER 0x00U
#define GPIO_BSRR 0x18U
#define GPIO_AFRH 0x24U
#define GPIO_AF_FDCAN1 9U

/* The processor's own. */
#define CORTEX_SYST_CSR 0xE000E010U
#define CORTEX_SYST_RVR 0xE000E014U
#define CORTEX_SYST_CVR 0xE000E018U
#define CORTEX_NVIC_ISER0 0xE000E100U
#define CORTEX_AIRCR 0xE000ED0CU
#define CORTEX_AIRCR_RESET 0x05FA0004U
#define STM32_IRQ_FDCAN1_IT0 21U

#endif

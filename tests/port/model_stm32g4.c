#include "model_stm32g4.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "stm32g474.h"
#include "sway_registers.h"

#define HSE_HZ 24000000U
#define LSI_HZ 32000U
#define WORDS 0x400U
#define FIFO 3U

uint8_t model_flash[MODEL_FLASH_SIZE];
bool model_dead_crystal;
bool model_dead_can;
bool model_dead_flash;
bool model_dead_noise;
bool model_dead_pll;
bool model_dead_hsi48;
bool model_dead_wait_states;
bool model_stuck_standby;
bool model_other_nmi;
unsigned model_bus_babbles;
bool model_write_protected;
int32_t model_cut_after = -1;
bool model_bus_is_busy;
model_cut_t model_cut_leaves;
bool (*model_nmi)(void);

/* Plain registers, by base; what is special is in the functions below. */
static uint32_t rcc[64];
static uint32_t pwr[64];
static uint32_t gpio[64];
static uint32_t timer[2][64];
static uint32_t flash[64];
static uint32_t can[64];
static uint32_t ram[0x350 / 4];
static uint32_t core[4]; /* SysTick, NVIC */

static int64_t now_us;
static int64_t timer_start_us[2];
static int64_t served_us;
static bool watchdog_runs;
static bool watchdog_open;
static bool watchdog_has_bit;
static uint32_t watchdog_prescaler;
static uint32_t watchdog_reload;
static unsigned watchdog_updates; /* readings of IWDG_SR until the last write is taken over */
static unsigned flash_busy;       /* readings of FLASH_SR until the last operation has ended */
static bool restart_wanted;
static uint32_t keys;
static uint32_t half_word;
static uintptr_t half_at;
static uint32_t cache[MODEL_FLASH_SIZE / 4U]; /* the data cache, as large as can be */
static bool is_cached[MODEL_FLASH_SIZE / 4U];
static bool power_off;
static bool torn[MODEL_FLASH_SIZE / 8U];
static bool nmi_restarts;
static bool tears_now;
static uint32_t rng[4];
static uint32_t rx_get;
static uint32_t rx_fill;
static uint32_t tx_put;
static uint32_t tx_get;
static uint32_t tx_fill;

static void forbidden(const char *what, uintptr_t address)
{
    fprintf(stderr, "model: %s at %08lx\n", what, (unsigned long)address);
    exit(3);
}

/* --- time, watchdog --------------------------------------------------------------------------- */

void model_wait_us(int64_t us)
{
    now_us += us;
    const int64_t divider = (int64_t)4 << watchdog_prescaler;
    const int64_t limit_us = ((int64_t)watchdog_reload + 1) * divider * 1000000 / (int64_t)LSI_HZ;
    watchdog_has_bit = watchdog_has_bit || (watchdog_runs && now_us - served_us > limit_us);
}

int64_t model_time_us(void)
{
    return now_us;
}

bool model_watchdog_bit(void)
{
    return watchdog_has_bit;
}

static void write_watchdog(uintptr_t offset, uint32_t value)
{
    if (offset == IWDG_KR) {
        if (value == IWDG_KEY_RELOAD && watchdog_updates > 0U) {
            forbidden("watchdog served before it has taken its new values over", offset);
        }
        watchdog_runs = watchdog_runs || value == IWDG_KEY_START;
        watchdog_open = value == IWDG_KEY_ACCESS;
        served_us = value == IWDG_KEY_RELOAD || value == IWDG_KEY_START ? now_us : served_us;
    } else if (!watchdog_open) {
        forbidden("write to the locked watchdog", offset);
    } else if (offset == IWDG_PR) {
        watchdog_prescaler = value;
        watchdog_updates = 3U;
    } else if (offset == IWDG_RLR) {
        watchdog_reload = value;
        watchdog_updates = 3U;
    }
}

/* A timer counts microseconds only if clock and prescaler say so. */
static uint32_t timer_count(unsigned which)
{
    const uint32_t *t = timer[which];
    if ((t[TIM_CR1 / 4U] & TIM_CR1_CEN) == 0U || (rcc[RCC_APB1ENR1 / 4U] & (1U << which)) == 0U) {
        return 0U;
    }
    const int64_t us = now_us - timer_start_us[which];
    const int64_t hz = model_cpu_hz() / (t[TIM_PSC / 4U] + 1U);
    const int64_t ticks = us / 1000000 * hz + us % 1000000 * hz / 1000000;
    return (uint32_t)ticks & (which == 0U ? UINT32_MAX : 0xFFFFU);
}

/* --- clocks ----------------------------------------------------------------------------------- */

uint32_t model_cpu_hz(void)
{
    const uint32_t pll = rcc[RCC_PLLCFGR / 4U];
    if ((rcc[RCC_CFGR / 4U] & RCC_CFGR_SWS_MASK) != RCC_CFGR_SWS_PLL) {
        return 16000000U;
    }
    const uint32_t vco = HSE_HZ / (((pll >> 4) & 15U) + 1U) * ((pll >> 8) & 127U);
    const uint32_t divide = (rcc[RCC_CFGR / 4U] >> 4 & 15U) == 8U ? 2U : 1U;
    return vco / (2U * (((pll >> 25) & 3U) + 1U)) / divide;
}

static void check_speed(void)
{
    const uint32_t wait_states = flash[FLASH_ACR / 4U] & 15U;
    const bool boost = (pwr[PWR_CR5 / 4U] & PWR_CR5_R1MODE) == 0U;
    if (model_cpu_hz() > 150000000U && (wait_states < 4U || !boost)) {
        forbidden("more than 150 MHz without boost or wait states", model_cpu_hz());
    }
}

static void write_rcc(uintptr_t offset, uint32_t value)
{
    uint32_t *const cr = &rcc[RCC_CR / 4U];
    if (offset == RCC_CSR && (value & RCC_CSR_RMVF) != 0U) {
        rcc[RCC_CSR / 4U] = 0U;
        return;
    }
    if (offset == RCC_PLLCFGR && (*cr & RCC_CR_PLLON) != 0U) {
        forbidden("PLL changed while it runs", offset);
    }
    rcc[offset / 4U] = value;
    if (offset == RCC_CR) {
        *cr &= ~(RCC_CR_HSERDY | RCC_CR_PLLRDY);
        *cr |= (*cr & RCC_CR_HSEON) != 0U && !model_dead_crystal ? RCC_CR_HSERDY : 0U;
        const bool pll = (*cr & RCC_CR_PLLON) != 0U && (*cr & RCC_CR_HSERDY) != 0U;
        *cr |= pll && !model_dead_pll ? RCC_CR_PLLRDY : 0U;
    }
    if (offset == RCC_CRRCR) {
        const bool is_on = (value & RCC_CRRCR_HSI48ON) != 0U && !model_dead_hsi48;
        rcc[RCC_CRRCR / 4U] |= is_on ? RCC_CRRCR_HSI48RDY : 0U;
    }
    if (offset == RCC_CFGR) {
        if ((value & 3U) == RCC_CFGR_SW_PLL && (*cr & RCC_CR_PLLRDY) == 0U) {
            forbidden("switched to a PLL that does not run", offset);
        }
        rcc[RCC_CFGR / 4U] = (value & ~RCC_CFGR_SWS_MASK) | (value & 3U) << 2;
        check_speed();
    }
}

/* --- flash ------------------------------------------------------------------------------------ */

void model_flash_new(void)
{
    memset(model_flash, 0xFF, sizeof model_flash);
    memset(torn, 0, sizeof torn);
}

void model_flash_tear(uint32_t at)
{
    torn[at / 8U] = true;
    for (unsigned i = 0; i < 8U; i++) {
        model_flash[(at & ~7U) + i] ^= (uint8_t)(0x5AU >> (at / 8U % 3U));
    }
}

bool model_nmi_restarts(void)
{
    return nmi_restarts;
}

/* Two bits wrong: the load goes on with what is there, and the NMI comes until the flag is off. */
static uint32_t load_flash(uintptr_t at)
{
    uint32_t word = 0;
    if (model_other_nmi) {
        model_other_nmi = false;
        nmi_restarts = nmi_restarts || model_nmi == NULL || !model_nmi();
    }
    if (torn[at / 8U]) {
        flash[FLASH_ECCR / 4U] |= FLASH_ECCR_ECCD;
        nmi_restarts = nmi_restarts || model_nmi == NULL || !model_nmi() ||
                       (flash[FLASH_ECCR / 4U] & FLASH_ECCR_ECCD) != 0U;
        flash[FLASH_ECCR / 4U] &= ~FLASH_ECCR_ECCD;
    }
    memcpy(&word, model_flash + at, sizeof word);
    if ((flash[FLASH_ACR / 4U] & FLASH_ACR_DCEN) == 0U) {
        return word;
    }
    cache[at / 4U] = is_cached[at / 4U] ? cache[at / 4U] : word;
    is_cached[at / 4U] = true;
    return cache[at / 4U];
}

static void write_access_control(uint32_t value)
{
    if ((value & FLASH_ACR_DCRST) != 0U) {
        if ((flash[FLASH_ACR / 4U] & FLASH_ACR_DCEN) != 0U) {
            forbidden("data cache reset while it is on", FLASH_ACR);
        }
        memset(is_cached, 0, sizeof is_cached);
    }
    flash[FLASH_ACR / 4U] = value & ~(model_dead_wait_states ? FLASH_ACR_LATENCY_MASK : 0U);
}

/* True: the operation is not carried out; what is left of it is for the caller to make. */
static bool power_goes(void)
{
    const bool now = !power_off && model_cut_after == 0;
    tears_now = now && model_cut_leaves == MODEL_CUT_TORN;
    power_off = power_off || now;
    model_cut_after -= model_cut_after > 0 ? 1 : 0;
    return power_off && !(now && model_cut_leaves == MODEL_CUT_AFTER);
}

static void write_flash_control(uint32_t value)
{
    uint32_t *const cr = &flash[FLASH_CR / 4U];
    if ((*cr & FLASH_CR_LOCK) != 0U) {
        return; /* locked: ignored */
    }
    *cr = value & ~FLASH_CR_STRT;
    keys = (value & FLASH_CR_LOCK) != 0U ? 0U : keys;
    if ((value & FLASH_CR_STRT) == 0U) {
        return;
    }
    const uint32_t page = (value >> 3) & 127U;
    if ((value & FLASH_CR_PER) == 0U || (value & FLASH_CR_BANK2) == 0U || page == 2U || page > 4U) {
        forbidden("erasing what holds the program or the key", page);
    }
    if (model_write_protected || (flash[FLASH_SR / 4U] & FLASH_SR_ERRORS) != 0U) {
        flash[FLASH_SR / 4U] |= 1U << 4;
    } else if (flash_busy = 2U, !power_goes()) {
        memset(model_flash + page * STM32_FLASH_PAGE, 0xFF, STM32_FLASH_PAGE);
        memset(torn + page * STM32_FLASH_PAGE / 8U, 0, STM32_FLASH_PAGE / 8U);
    } else if (tears_now) {
        for (uint32_t at = 0; at < STM32_FLASH_PAGE; at += 8U) {
            model_flash_tear(page * STM32_FLASH_PAGE + at);
        }
    }
}

static void write_flash(uintptr_t offset, uint32_t value)
{
    if (offset == FLASH_KEYR) {
        keys =
            keys == 0U && value == FLASH_KEY1 ? 1U : (keys == 1U && value == FLASH_KEY2 ? 2U : 3U);
        flash[FLASH_CR / 4U] &= keys == 2U ? ~FLASH_CR_LOCK : UINT32_MAX;
    } else if (offset == FLASH_SR) {
        flash[FLASH_SR / 4U] &= ~value; /* written ones clear */
    } else if (offset == FLASH_ECCR) {
        flash[FLASH_ECCR / 4U] &= ~(value & FLASH_ECCR_ECCD);
    } else if (offset == FLASH_CR) {
        write_flash_control(value);
    } else if (offset == FLASH_ACR) {
        write_access_control(value);
    } else {
        flash[offset / 4U] = value;
    }
}

/* 64 bits at a time, lower half first, only over erased bits. */
static void program_flash(uintptr_t address, uint32_t value)
{
    const uintptr_t at = address - STM32_FLASH_BANK2;
    if ((flash[FLASH_CR / 4U] & (FLASH_CR_PG | FLASH_CR_LOCK)) != FLASH_CR_PG) {
        forbidden("write to flash that is not open", address);
    }
    if (flash_busy > 0U) {
        forbidden("write to flash that is busy", address);
    }
    if (at % 8U == 0U) {
        half_at = at;
        half_word = value;
        return;
    }
    if (at != half_at + 4U) {
        flash[FLASH_SR / 4U] |= 1U << 7;
        return;
    }
    const uint32_t word[2] = {half_word, value};
    flash_busy = 2U;
    for (unsigned i = 0; i < 8U; i++) {
        if (model_flash[half_at + i] != 0xFFU) {
            flash[FLASH_SR / 4U] |= 1U << 3;
            return;
        }
    }
    if (model_write_protected) {
        return;
    }
    if (!power_goes()) {
        memcpy(model_flash + half_at, word, sizeof word);
    } else if (tears_now) {
        memcpy(model_flash + half_at, word, sizeof word);
        model_flash_tear((uint32_t)half_at);
    }
}

bool model_power_is_off(void)
{
    return power_off;
}

/* --- CAN -------------------------------------------------------------------------------------- */

enum { CCCR = 6, NBTP = 7, TSCC = 8, ECR = 16, PSR = 17, IR = 20, IE = 21, ILE = 23, RXGFC = 32 };
#define CONFIGURABLE(index)                                                                        \
    ((index) == NBTP || (index) == TSCC || (index) == RXGFC || (index) == 48)

static void write_can(uintptr_t offset, uint32_t value)
{
    const uintptr_t index = offset / 4U;
    if (index == CCCR) {
        can[CCCR] = model_dead_can ? 0U : value & ~8U;
        can[CCCR] |= (value & 16U) != 0U || model_stuck_standby ? 8U : 0U;
        if ((value & 1U) == 0U && (can[PSR] & 1U << 7) != 0U) {
            can[PSR] &= ~(1U << 7); /* back on the bus after 129 times 11 bits: here at once */
            can[IR] |= 1U << 19;    /* tells of the change, whichever it is */
        }
        return;
    }
    if (CONFIGURABLE(index) && (can[CCCR] & 3U) != 3U) {
        forbidden("CAN configured while it runs", offset);
    }
    switch (offset) {
    case 0x50:
        can[IR] &= ~value;
        break;
    case 0x94: /* RXF0A */
        if (value != rx_get || rx_fill == 0U) {
            forbidden("acknowledged another frame than the oldest", offset);
        }
        rx_get = (rx_get + 1U) % FIFO;
        rx_fill--;
        if (model_bus_babbles > 0U) {
            static const sway_port_frame_t noise = {.id = 0x120, .dlc = 8};
            model_bus_babbles--;
            (void)model_bus_frame(&noise, false, false);
        }
        break;
    case 0xCC: /* TXBAR */
        if (value != 1U << tx_put || tx_fill == FIFO || (can[CCCR] & 1U) != 0U) {
            forbidden("transmit request out of order", offset);
        }
        tx_put = (tx_put + 1U) % FIFO;
        tx_fill++;
        break;
    default:
        can[index] = value;
        break;
    }
}

static uint32_t read_can(uintptr_t offset)
{
    const uint32_t value = can[offset / 4U];
    switch (offset) {
    case 0x24: /* TSCV */
        return (can[TSCC] & 3U) == 2U ? timer_count(1U) : 0U;
    case 0x44:
        can[PSR] |= 7U; /* read: nothing new */
        return value;
    case 0x90:
        return rx_fill | rx_get << 8 | ((rx_get + rx_fill) % FIFO) << 16;
    case 0xC4:
        return (FIFO - tx_fill) | tx_get << 8 | tx_put << 16 | (tx_fill == FIFO ? 1U << 21 : 0U);
    default:
        return value;
    }
}

static bool passes_filter(uint32_t id)
{
    const uint32_t count = (can[RXGFC] >> 16) & 31U;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t filter = ram[i];
        if (filter >> 30 != 2U || ((filter >> 27) & 7U) != 1U) {
            forbidden("filter of another kind", i);
        }
        if ((id & filter & 0x7FFU) == ((filter >> 16) & filter & 0x7FFU)) {
            return true;
        }
    }
    return ((can[RXGFC] >> 4) & 3U) == 0U;
}

bool model_bus_frame(const sway_port_frame_t *frame, bool extended, bool remote)
{
    const bool refused =
        (extended && ((can[RXGFC] >> 2) & 3U) >= 2U) || (remote && (can[RXGFC] & 2U) != 0U);
    if ((can[CCCR] & 1U) != 0U || refused || !passes_filter(frame->id)) {
        return false;
    }
    if (rx_fill == FIFO) {
        can[IR] |= 1U << 2;
        return false;
    }
    uint32_t *element = &ram[(0xB0U + 72U * ((rx_get + rx_fill) % FIFO)) / 4U];
    element[0] = (uint32_t)frame->id << 18 | (extended ? 1U << 30 : 0U) | (remote ? 1U << 29 : 0U);
    element[1] = 1U << 31 | (uint32_t)frame->dlc << 16 | timer_count(1U); /* 31: no filter's own */
    memcpy(&element[2], frame->data, 8);
    rx_fill++;
    can[IR] |= 1U;
    return true;
}

bool model_bus_sent(sway_port_frame_t *frame)
{
    if (model_bus_is_busy || tx_fill == 0U || (can[CCCR] & 1U) != 0U) {
        return false;
    }
    const uint32_t *element = &ram[(0x278U + 72U * tx_get) / 4U];
    frame->time_us = now_us;
    frame->id = (uint16_t)(element[0] >> 18 & 0x7FFU);
    frame->dlc = (uint8_t)(element[1] >> 16 & 15U);
    memcpy(frame->data, &element[2], 8);
    tx_get = (tx_get + 1U) % FIFO;
    tx_fill--;
    can[IR] |= 1U << 7; /* sent, which nobody has to know */
    return true;
}

void model_bus_error(uint32_t code)
{
    can[PSR] = (can[PSR] & ~7U) | code;
    can[IR] |= 1U << 21;
}

void model_bus_counters(uint32_t transmit, uint32_t receive)
{
    const bool passive = transmit > 127U || receive > 127U;
    const bool warning = transmit > 95U || receive > 95U;
    can[ECR] = (transmit & 255U) | (receive & 127U) << 8;
    can[PSR] = (can[PSR] & 7U) | (passive ? 1U << 5 : 0U) | (warning ? 1U << 6 : 0U);
    if (transmit > 255U) {
        can[PSR] |= 1U << 7;
        can[CCCR] |= 1U;
        can[IR] |= 1U << 19;
        tx_fill = 0U;
        tx_get = tx_put;
    }
}

bool model_wants_interrupt(void)
{
    const bool line = (can[IR] & can[IE]) != 0U && (can[ILE] & 1U) != 0U;
    return line && (core[3] & (1U << STM32_IRQ_FDCAN1_IT0)) != 0U;
}

/* --- the map ---------------------------------------------------------------------------------- */

typedef struct {
    uintptr_t base;
    uintptr_t size;
    uint32_t *plain;
} part_t;

static const part_t parts[] = {
    {STM32_RCC, 0x100, rcc},          {STM32_PWR, 0x100, pwr},        {STM32_GPIOA, 0x100, gpio},
    {STM32_TIM2, 0x100, timer[0]},    {STM32_TIM3, 0x100, timer[1]},  {STM32_FLASH, 0x100, flash},
    {STM32_FDCAN1, 0x100, can},       {STM32_FDCAN1_RAM, 0x350, ram}, {CORTEX_SYST_CSR, 0x0C, core},
    {CORTEX_NVIC_ISER0, 4, &core[3]}, {STM32_IWDG, 0x10, NULL},       {CORTEX_AIRCR, 4, NULL},
    {STM32_RNG, 0x10, rng},
};

static const part_t *find(uintptr_t address)
{
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        if (address >= parts[i].base && address < parts[i].base + parts[i].size &&
            address % 4U == 0U) {
            return &parts[i];
        }
    }
    forbidden("no register", address);
    return NULL;
}

static void need_clock(uintptr_t base, uintptr_t address)
{
    const uint32_t bus = rcc[RCC_APB1ENR1 / 4U];
    const bool dead =
        ((base == STM32_FDCAN1 || base == STM32_FDCAN1_RAM) && (bus & RCC_APB1ENR1_FDCAN) == 0U) ||
        (base == STM32_PWR && (bus & RCC_APB1ENR1_PWR) == 0U) ||
        (base == STM32_GPIOA && (rcc[RCC_AHB2ENR / 4U] & RCC_AHB2ENR_GPIOA) == 0U) ||
        (base == STM32_RNG && ((rcc[RCC_AHB2ENR / 4U] & RCC_AHB2ENR_RNG) == 0U ||
                               (rcc[RCC_CRRCR / 4U] & RCC_CRRCR_HSI48RDY) == 0U));
    if (dead) {
        forbidden("access to a part without a clock", address);
    }
}

uint32_t model_read(uintptr_t address)
{
    const part_t *part = find(address);
    return part->plain == NULL ? 0U : part->plain[(address - part->base) / 4U];
}

static uint32_t read_flash(uintptr_t offset)
{
    if (offset == FLASH_SR && (model_dead_flash || flash_busy > 0U)) {
        flash_busy -= flash_busy > 0U ? 1U : 0U;
        return FLASH_SR_BSY;
    }
    return model_read(STM32_FLASH + offset);
}

static uint32_t read_watchdog(uintptr_t offset)
{
    if (offset != IWDG_SR || watchdog_updates == 0U) {
        return 0U;
    }
    watchdog_updates--;
    return 7U;
}

/* A number a reading, as long as it is on. */
static uint32_t read_rng(uintptr_t offset)
{
    if ((rng[0] & RNG_CR_RNGEN) != 0U && offset == RNG_DR) {
        rng[2] = rng[2] * 1664525U + 1013904223U;
    }
    return offset == RNG_SR ? (rng[0] & RNG_CR_RNGEN && !model_dead_noise ? RNG_SR_DRDY : 0U)
                            : rng[offset / 4U];
}

uint32_t sway_register_read(uintptr_t address)
{
    if (address >= STM32_FLASH_BANK2 && address < STM32_FLASH_BANK2 + MODEL_FLASH_SIZE) {
        return load_flash(address - STM32_FLASH_BANK2);
    }
    const part_t *part = find(address);
    const uintptr_t offset = address - part->base;
    need_clock(part->base, address);
    if (part->base == STM32_FDCAN1) {
        return read_can(offset);
    }
    if ((part->base == STM32_TIM2 || part->base == STM32_TIM3) && offset == TIM_CNT) {
        return timer_count(part->base == STM32_TIM3);
    }
    if (part->base == STM32_RNG) {
        return read_rng(offset);
    }
    if (part->base == STM32_FLASH) {
        return read_flash(offset);
    }
    if (part->base == STM32_IWDG) {
        return read_watchdog(offset);
    }
    return model_read(address);
}

void sway_register_write(uintptr_t address, uint32_t value)
{
    if (address >= STM32_FLASH_BANK2 && address < STM32_FLASH_BANK2 + MODEL_FLASH_SIZE) {
        program_flash(address, value);
        return;
    }
    const part_t *part = find(address);
    const uintptr_t offset = address - part->base;
    need_clock(part->base, address);
    switch (part->base) {
    case STM32_RCC:
        write_rcc(offset, value);
        break;
    case STM32_FLASH:
        write_flash(offset, value);
        break;
    case STM32_FDCAN1:
        write_can(offset, value);
        break;
    case STM32_IWDG:
        write_watchdog(offset, value);
        break;
    case CORTEX_AIRCR:
        restart_wanted = restart_wanted || value == CORTEX_AIRCR_RESET;
        break;
    default:
        part->plain[offset / 4U] = value;
        break;
    }
    if (part->base == STM32_TIM2 || part->base == STM32_TIM3) {
        const unsigned which = part->base == STM32_TIM3;
        timer_start_us[which] = offset == TIM_CR1 ? now_us : timer_start_us[which];
    }
}

bool model_wants_restart(void)
{
    return restart_wanted;
}

void model_restart(void)
{
    const uint32_t reason = watchdog_has_bit ? RCC_CSR_IWDGRSTF : 0U;
    memset(rcc, 0, sizeof rcc);
    memset(gpio, 0, sizeof gpio);
    memset(timer, 0, sizeof timer);
    memset(flash, 0, sizeof flash);
    memset(can, 0, sizeof can);
    memset(core, 0, sizeof core);
    rcc[RCC_CSR / 4U] = reason;
    rcc[RCC_PLLCFGR / 4U] = 0x1000U;
    pwr[PWR_CR5 / 4U] = PWR_CR5_R1MODE;
    gpio[GPIO_MODER / 4U] = 0xABFFFFFFU; // analogue, but for the debugger's pins
    gpio[GPIO_AFRH / 4U] = 0xFFFFFFFFU;  // 0 on the part; here so that what is not cleared is seen
    rcc[RCC_CCIPR / 4U] = RCC_CCIPR_FDCAN_MASK | RCC_CCIPR_CLK48_MASK; // likewise
    flash[FLASH_CR / 4U] = FLASH_CR_LOCK;
    can[CCCR] = 1U;
    can[PSR] = 7U;
    keys = 0U;
    rx_get = rx_fill = tx_put = tx_get = tx_fill = 0U;
    watchdog_runs = watchdog_open = watchdog_has_bit = restart_wanted = power_off = false;
    tears_now = false;
    watchdog_updates = flash_busy = 0U;
    memset(is_cached, 0, sizeof is_cached);
    model_cut_after = -1;
}

void model_power_on(void)
{
    model_dead_crystal = model_dead_can = model_dead_flash = model_write_protected = false;
    model_dead_pll = model_dead_hsi48 = model_dead_wait_states = model_dead_noise = false;
    model_bus_is_busy = model_stuck_standby = model_other_nmi = false;
    model_bus_babbles = 0U;
    watchdog_has_bit = false;
    nmi_restarts = false;
    model_cut_leaves = MODEL_CUT_BEFORE;
    rng[0] = 0U;
    model_restart();
}

#include "flash.h"

#include "stm32g474.h"
#include "sway_registers.h"

#define PAGES 128U
#define WORD 8U         // bytes that are written at once
#define POLLS 20000000U // a quarter of a second, ten times an erasure

static uint32_t get(uintptr_t offset)
{
    return sway_register_read(STM32_FLASH + offset);
}

static void put(uintptr_t offset, uint32_t value)
{
    sway_register_write(STM32_FLASH + offset, value);
}

static bool is_ready(void)
{
    for (uint32_t polls = 0; polls < POLLS; polls++) {
        if ((get(FLASH_SR) & FLASH_SR_BSY) == 0U) {
            return true;
        }
    }
    return false;
}

static bool open(uint32_t operation)
{
    if (!is_ready()) {
        return false;
    }
    put(FLASH_KEYR, FLASH_KEY1);
    put(FLASH_KEYR, FLASH_KEY2);
    put(FLASH_SR, FLASH_SR_ERRORS); // old ones would refuse the new operation
    put(FLASH_CR, operation);
    return (get(FLASH_CR) & FLASH_CR_LOCK) == 0U;
}

/* What the data cache holds of the page is old now. */
static bool close(bool good)
{
    const bool done = is_ready() && (get(FLASH_SR) & FLASH_SR_ERRORS) == 0U;
    put(FLASH_CR, FLASH_CR_LOCK);
    const uint32_t access = get(FLASH_ACR);
    put(FLASH_ACR, access & ~FLASH_ACR_DCEN);
    put(FLASH_ACR, (access & ~FLASH_ACR_DCEN) | FLASH_ACR_DCRST);
    put(FLASH_ACR, access);
    return good && done;
}

bool flash_erase(uint32_t page)
{
    const uint32_t operation = FLASH_CR_PER | FLASH_CR_BANK2 | FLASH_CR_PAGE(page);
    if (page >= PAGES || !open(operation)) {
        return false;
    }
    put(FLASH_CR, operation | FLASH_CR_STRT);
    return close(true);
}

static uint32_t word_at(const uint8_t *bytes, size_t at, size_t size)
{
    uint32_t word = 0;
    for (size_t i = 0; i < 4U; i++) {
        word |= (uint32_t)(at + i < size ? bytes[at + i] : 0xFFU) << (8U * i);
    }
    return word;
}

bool flash_write(uint32_t page, uint32_t offset, const uint8_t *bytes, size_t size)
{
    if (page >= PAGES || offset % WORD != 0U || offset + size > STM32_FLASH_PAGE ||
        !open(FLASH_CR_PG)) {
        return false;
    }
    const uintptr_t start = STM32_FLASH_BANK2 + page * STM32_FLASH_PAGE + offset;
    bool good = true;
    for (size_t at = 0; good && at < size; at += WORD) {
        sway_register_write(start + at, word_at(bytes, at, size));
        sway_register_write(start + at + 4U, word_at(bytes, at + 4U, size));
        good = is_ready();
    }
    return close(good);
}

/* --- reading ----------------------------------------------------------------------------------
 * The load that meets a wrong double word still ends, with what is there; the NMI comes beside it.
 * Left alone it would come again for as long as the flag stands. */

static volatile bool is_reading;
static volatile bool is_damaged;

bool flash_nmi(void)
{
    if ((get(FLASH_ECCR) & FLASH_ECCR_ECCD) == 0U || !is_reading) {
        return false;
    }
    put(FLASH_ECCR, FLASH_ECCR_ECCD); // written as one it clears
    is_damaged = true;
    return true;
}

bool flash_read(uint32_t page, uint8_t *bytes, size_t size)
{
    const uintptr_t start = STM32_FLASH_BANK2 + page * STM32_FLASH_PAGE;
    is_damaged = false;
    is_reading = true;
    for (size_t at = 0; at < size; at++) {
        const uint32_t word = sway_register_read(start + (at & ~(size_t)3U));
        bytes[at] = (uint8_t)(word >> (8U * (at % 4U)));
    }
    (void)get(FLASH_ECCR); // an NMI of the last load comes before this ends
    sway_memory_barrier();
    is_reading = false;
    return !is_damaged;
}

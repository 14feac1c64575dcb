#include "pages.h"

#include <string.h>

#define MARK UINT32_C(0x50414745)

void pages_start(pages_t *pages, const uint8_t *block, size_t size)
{
    if (pages->mark != MARK) {
        memset(pages->page, 0xFF, sizeof pages->page);
        memcpy(pages->page[0], block, size < SWAY_BLOCK_SIZE ? size : SWAY_BLOCK_SIZE);
        pages->erasures = 0U;
        pages->mark = MARK;
    }
    pages->erased = NULL;
}

static bool read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    const pages_t *pages = context;
    memcpy(bytes, pages->page[slot], size);
    return true;
}

static bool erase(void *context, uint32_t slot)
{
    pages_t *pages = context;
    memset(pages->page[slot], 0xFF, sizeof pages->page[slot]);
    pages->erasures += 1U;
    if (pages->erased != NULL) {
        pages->erased(pages->erasures);
    }
    return true;
}

static bool write(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    pages_t *pages = context;
    for (size_t i = 0; i < size; i++) {
        pages->page[slot][i] = (uint8_t)(pages->page[slot][i] & block[i]);
    }
    return true;
}

sway_store_t pages_store(pages_t *pages)
{
    const sway_store_t store = {.size = SWAY_BLOCK_SIZE,
                                .check = sway_block_check,
                                .read = read,
                                .erase = erase,
                                .write = write,
                                .context = pages};
    return store;
}

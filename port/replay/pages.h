/// pages: two pages of flash for machines that have none: memory that a restart leaves alone. The
/// rules are those of real flash: a page is erased as a whole, and writing only clears bits.
#ifndef SWAY_PAGES_H
#define SWAY_PAGES_H

#include "sway_store.h"

/// Place it where start-up code does not clear it.
typedef struct {
    uint32_t mark;
    uint32_t erasures; ///< since power came on
    uint8_t page[SWAY_STORE_SLOTS][SWAY_BLOCK_SIZE];
    void (*erased)(uint32_t erasures); ///< called between erasing and writing; may be NULL
} pages_t;

/// At a first start both pages are erased and `block` (of `size` bytes, 0: none) is put into the
/// first one as a programmer would. After a restart they are as they were.
void pages_start(pages_t *pages, const uint8_t *block, size_t size);
/// `pages` has to outlive it.
sway_store_t pages_store(pages_t *pages);

#endif

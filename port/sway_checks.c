#include "sway_checks.h"

#include "sway_block.h"

bool sway_check_memory(volatile uint32_t *first, const volatile uint32_t *end)
{
    bool good = true;
    for (volatile uint32_t *word = first; word < end; word++) {
        const uint32_t kept = *word;
        *word = ~kept;
        good = good && *word == ~kept;
        *word = kept;
        good = good && *word == kept;
    }
    return good;
}

bool sway_check_image(const void *image, size_t size, uint32_t crc)
{
    return sway_block_crc32(0, image, size) == crc;
}

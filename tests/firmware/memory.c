/* The functions of port/cortex_m/memory.S against plain loops: every alignment, lengths of 0 to 40
 * bytes, and what lies beside. A program for Linux on ARM without a library; exits with 1 at the
 * first difference. */
#include <stddef.h>
#include <stdint.h>

void *tested_memcpy(void *to, const void *from, size_t length);
void *tested_memset(void *to, int byte, size_t length);
int tested_memcmp(const void *a, const void *b, size_t length);

enum { SPACE = 64, EDGE = 8, LONGEST = 40 };
static _Alignas(8) uint8_t to[SPACE];
static _Alignas(8) uint8_t from[SPACE];
static const int KINDS[] = {0, 1, 0x7F, 0x80, 0xFF, 0x1A5};

static void fill(void)
{
    for (size_t i = 0; i < SPACE; i++) {
        to[i] = (uint8_t)(i * 7U + 3U);
        from[i] = (uint8_t)(i * 13U + 129U);
    }
}

static int is_right(size_t at, size_t length, const uint8_t *inside, size_t stride)
{
    for (size_t i = 0; i < SPACE; i++) {
        const int is_in = i >= at && i < at + length;
        const uint8_t expected = is_in ? inside[(i - at) * stride] : (uint8_t)(i * 7U + 3U);
        if (to[i] != expected) {
            return 0;
        }
    }
    return 1;
}

static int check(size_t at, size_t other, size_t length)
{
    fill();
    int is_good = tested_memcpy(&to[at], &from[other], length) == &to[at];
    is_good = is_good && is_right(at, length, &from[other], 1U);
    is_good = is_good && tested_memcmp(&to[at], &from[other], length) == 0;
    for (size_t i = 0; i < length; i++) { // what differs behind the first difference is not seen
        to[at + length - 1U] = (uint8_t)~from[other + length - 1U];
        to[at + i] = (uint8_t)(from[other + i] ^ 0x80U);
        const int sign = tested_memcmp(&to[at], &from[other], length);
        is_good = is_good && (to[at + i] > from[other + i] ? sign > 0 : sign < 0);
        to[at + i] = from[other + i];
        to[at + length - 1U] = from[other + length - 1U];
    }
    for (size_t i = 0; i < sizeof KINDS / sizeof KINDS[0]; i++) {
        const uint8_t byte = (uint8_t)KINDS[i];
        fill();
        is_good = is_good && tested_memset(&to[at], KINDS[i], length) == &to[at];
        is_good = is_good && is_right(at, length, &byte, 0U);
    }
    return is_good;
}

static int check_all(void)
{
    for (size_t length = 0; length <= LONGEST; length++) {
        for (size_t at = EDGE; at < EDGE + 4U; at++) {
            for (size_t other = EDGE; other < EDGE + 4U; other++) {
                if (!check(at, other, length)) {
                    return 1;
                }
            }
        }
    }
    return 0;
}

void _start(void)
{
    register int status __asm__("r0") = check_all();
    __asm__ volatile("movs r7, #1\n svc #0" ::"r"(status) : "r7"); // exit
}

#include "semihosting.h"

#include <string.h>

enum {
    SYS_OPEN = 0x01,
    SYS_CLOSE = 0x02,
    SYS_WRITE = 0x05,
    SYS_READ = 0x06,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20
};

#define ADP_STOPPED_APPLICATION_EXIT 0x20026U

static uint32_t call(uint32_t operation, const void *block)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = block;
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
#elif defined(__thumb__)
    __asm__ volatile("svc 0xAB" : "+r"(r0) : "r"(r1) : "memory", "lr");
#else
    __asm__ volatile("svc 0x123456" : "+r"(r0) : "r"(r1) : "memory", "lr");
#endif
    return r0;
}

static uint32_t word(const void *address)
{
    return (uint32_t)(uintptr_t)address;
}

static int32_t open_as(const char *path, uint32_t mode)
{
    const uint32_t block[3] = {word(path), mode, (uint32_t)strlen(path)};
    return (int32_t)call(SYS_OPEN, block);
}

int32_t semihosting_open(const char *path, semihosting_mode_t mode)
{
    return open_as(path, (uint32_t)mode);
}

int32_t semihosting_stdout(void)
{
    static int32_t file = -1;
    if (file < 0) {
        file = open_as(":tt", 4);
    }
    return file;
}

size_t semihosting_read(int32_t file, void *bytes, size_t size)
{
    const uint32_t block[3] = {(uint32_t)file, word(bytes), (uint32_t)size};
    const uint32_t left = call(SYS_READ, block);
    return left > size ? 0U : size - left;
}

bool semihosting_write(int32_t file, const void *bytes, size_t size)
{
    const uint32_t block[3] = {(uint32_t)file, word(bytes), (uint32_t)size};
    return call(SYS_WRITE, block) == 0U;
}

void semihosting_close(int32_t file)
{
    const uint32_t block[1] = {(uint32_t)file};
    (void)call(SYS_CLOSE, block);
}

void semihosting_arguments(char *text, size_t size)
{
    uint32_t block[2] = {word(text), (uint32_t)size};
    text[0] = '\0';
    if (call(SYS_GET_CMDLINE, block) != 0U) {
        text[0] = '\0';
    }
}

void semihosting_exit(int32_t status)
{
    const uint32_t block[2] = {ADP_STOPPED_APPLICATION_EXIT, (uint32_t)status};
    for (;;) {
        (void)call(SYS_EXIT_EXTENDED, block);
    }
}

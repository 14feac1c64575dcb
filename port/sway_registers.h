/// sway_registers: access to the registers of a peripheral, or to a model of them in tests.
///
/// With SWAY_REGISTER_MODEL defined the two functions are the test's own, so a driver's register
/// traffic is checked on the host, byte by byte, without the part.
#ifndef SWAY_REGISTERS_H
#define SWAY_REGISTERS_H

#include <stdint.h>

#ifdef SWAY_REGISTER_MODEL
uint32_t sway_register_read(uintptr_t address);
void sway_register_write(uintptr_t address, uint32_t value);
#else
static inline uint32_t sway_register_read(uintptr_t address)
{
    return *(volatile uint32_t *)address;
}
static inline void sway_register_write(uintptr_t address, uint32_t value)
{
    *(volatile uint32_t *)address = value;
}
#endif

/// Keeps the compiler and the processor from moving memory accesses across it.
static inline void sway_memory_barrier(void)
{
#if defined(__GNUC__)
    __sync_synchronize();
#endif
}

#endif

/// fault: what a Cortex-M writes down when it stops, and how it starts again.
#ifndef SWAY_MPS2_FAULT_H
#define SWAY_MPS2_FAULT_H

#include <stdint.h>

/// Hands a fault to the program: `cause` is the exception number (2 NMI/watchdog, 3 HardFault,
/// 4 MemManage, 5 BusFault, 6 UsageFault), `address` where it happened. Runs on the handlers'
/// own stack, so it works after a stack overflow too. The default ends the emulator with 99.
void fault_stop(uint32_t cause, uint32_t address) __attribute__((noreturn));

#endif

/// fault: what start-up code asks of the program when something ends: a fault, or main().
#ifndef SWAY_MPS2_FAULT_H
#define SWAY_MPS2_FAULT_H

#include <stdint.h>

/// Hands a fault to the program: `cause` is the exception number (2 NMI/watchdog, 3 HardFault,
/// 4 MemManage, 5 BusFault, 6 UsageFault), `address` where it happened. Runs on the handlers'
/// own stack, so it works after a stack overflow too.
void fault_stop(uint32_t cause, uint32_t address) __attribute__((noreturn));

/// main() has returned.
void main_returned(int status);

/// What the unused stack is filled with before main().
#define STACK_PAINT UINT32_C(0xA5C3F00D)

#endif

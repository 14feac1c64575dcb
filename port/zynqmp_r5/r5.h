/// r5: start-up, memory protection and clock of a Cortex-R5.
#ifndef SWAY_R5_H
#define SWAY_R5_H

#include <stdint.h>

/// Counts of the cycle counter in a second. The emulator's counts nanoseconds.
#ifndef R5_CLOCK_HZ
#define R5_CLOCK_HZ INT64_C(1000000000)
#endif

/// Nanoseconds since start. Must be called at least every 4 s.
int64_t r5_time_ns(void);
/// Deepest stack so far in bytes, by its paint.
uint32_t r5_stack_used(void);
/// The program's own: what to do about a fault. `cause` 4 data abort, 5 prefetch abort, 6 undefined
/// instruction. Runs on the handlers' own stack.
void fault_stop(uint32_t cause, uint32_t address) __attribute__((noreturn));
/// The program's own: an interrupt.
void interrupt(void);
/// Begins again as after a reset; .noinit keeps its contents.
void r5_restart(void) __attribute__((noreturn));

#endif

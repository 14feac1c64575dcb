/// bench: counting instructions and stack on an emulated Cortex-M, and printing the figures.
///
/// Run the image with `-icount shift=8`: the emulator then advances its 25 MHz clock by exactly
/// 6.4 ticks for every instruction. Differences of two readings are exact to one instruction and
/// the same run after run. They are instructions, not cycles: a Cortex-M4 takes about 1.2 cycles
/// for one, an M0+ about 1.4 (more for its 32 x 32 -> 64 multiplications, which are calls).
#ifndef SWAY_BENCH_H
#define SWAY_BENCH_H

#include <stdint.h>

/// A reading of the clock. Two readings up to 671 million instructions apart can be compared.
uint32_t bench_now(void);
/// Instructions between two readings, without those of bench_now() itself.
uint32_t bench_instructions(uint32_t before, uint32_t after);

/// Fills the unused stack with a pattern. The figure below counts from here on.
void bench_paint_stack(void);
/// Deepest stack since bench_paint_stack(), in bytes from the stack's top.
uint32_t bench_stack_used(void);

/// To the emulator's standard output.
void bench_text(const char *text);
void bench_number(int64_t value);
/// `name value\n`
void bench_line(const char *name, int64_t value);

#endif

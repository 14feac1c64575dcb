/// board: clocks, pins, timers and watchdog of a NUCLEO-G474RE.
#ifndef SWAY_STM32G4_BOARD_H
#define SWAY_STM32G4_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#define BOARD_HSE_HZ 24000000U ///< the board's crystal X3; the CAN controller's clock too
#define BOARD_CPU_HZ 168000000U

/// Clocks and pins. False: the crystal or the PLL did not start (the processor then runs on, at
/// 16 MHz, and there is no CAN: its bit rate would be off by up to 1 %).
bool board_start(void);
/// Interrupts of the CAN controller and of the 1 kHz tick, from here on.
void board_enable_interrupts(void);
/// Nanoseconds since board_start(), counted in microseconds. At least once an hour; the tick sees
/// to that. May be called from interrupts.
int64_t board_time_ns(void);
/// Starts the watchdog: without board_serve_watchdog() for half a second the processor restarts.
void board_start_watchdog(void);
void board_serve_watchdog(void);
/// True where the watchdog was the reason of the last restart; asking forgets it.
bool board_was_watchdog(void);
/// 32 bits of noise; 0 where the generator does not start.
uint32_t board_random(void);
/// Restarts the processor at once.
void board_restart(void);

#endif

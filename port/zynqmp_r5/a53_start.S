// The A53 that the emulator starts first: asks the firmware to let R5 core 0 go at 0xFFFC0000
// (PSCI CPU_ON), then sleeps. On a board the boot loader does this.
    .global _start
_start:
    movz x0, #0x0003
    movk x0, #0xC400, lsl #16
    mov x1, #4
    movz x2, #0x0000
    movk x2, #0xFFFC, lsl #16
    mov x3, #0
    smc #0
1:  wfi
    b 1b

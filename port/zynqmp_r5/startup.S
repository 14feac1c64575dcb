// From reset to main() on a Cortex-R5. Runs from the on-chip memory at 0xFFFC0000; the exception
// vectors lie at 0xFFFF0000 (SCTLR.V), so that the page at NULL can be closed.
    .syntax unified
    .arm

    .section .vectors, "ax"
    ldr pc, =_start
    ldr pc, =undefined_entry
    ldr pc, =_start             // SVC: not used by the program
    ldr pc, =prefetch_entry
    ldr pc, =data_entry
    nop
    ldr pc, =irq_entry
    ldr pc, =_start
    .ltorg

    .section .start, "ax"
    .global _start
    .type _start, %function     // Thumb code calls it: the linker has to change the state
_start:
    cpsid if
    mrc p15, 0, r0, c1, c0, 0
    bic r0, r0, #5              // MPU and data cache off
    bic r0, r0, #(1 << 30)      // exceptions in ARM state
    orr r0, r0, #(1 << 13)      // vectors at 0xFFFF0000
    mcr p15, 0, r0, c1, c0, 0
    isb
    cps #0x17                   // abort
    ldr sp, =handler_stack_top
    cps #0x1B                   // undefined
    ldr sp, =handler_stack_top
    cps #0x12                   // IRQ
    ldr sp, =irq_stack_top
    cps #0x1F                   // system: the program's own
    ldr sp, =stack_top
    bl start
1:  b 1b
    .ltorg

    // Cause numbers are those of sway_ecu_cause_t below 16, the Cortex-M's: 4 data abort,
    // 5 prefetch abort, 6 undefined instruction. r1: where it happened.
    .type undefined_entry, %function
    .type prefetch_entry, %function
    .type data_entry, %function
    .type irq_entry, %function
undefined_entry:
    mov r0, #6
    sub r1, lr, #4
    b fault_stop
prefetch_entry:
    mov r0, #5
    sub r1, lr, #4
    b fault_stop
data_entry:
    mov r0, #4
    sub r1, lr, #8
    b fault_stop

irq_entry:
    sub lr, lr, #4
    srsdb sp!, #0x12
    push {r0-r3, r12, lr}
    bl interrupt
    pop {r0-r3, r12, lr}
    rfeia sp!

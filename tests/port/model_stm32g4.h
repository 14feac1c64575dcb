/* A model of the registers of an STM32G474 that port/stm32g4 uses, after ST's reference manual
 * RM0440: what a write does, what is refused, what happens on the bus. Time passes only by
 * model_wait_us(). An access that the manual forbids ends the program with a message. */
#ifndef MODEL_STM32G4_H
#define MODEL_STM32G4_H

#include "sway_port.h"

#define MODEL_FLASH_SIZE 10240U

extern uint8_t model_flash[MODEL_FLASH_SIZE]; /* first five pages of bank 2 */

void model_power_on(void); /* everything but the flash */
void model_restart(void);  /* a reset: clears peripherals, keeps the reason */
void model_wait_us(int64_t us);
int64_t model_time_us(void);
uint32_t model_read(uintptr_t address); /* without side effects, for checks */

/* What is broken. */
extern bool model_dead_crystal;
extern bool model_dead_can;
extern bool model_dead_flash;
extern bool model_dead_noise;
extern bool model_dead_pll;
extern bool model_dead_hsi48;
extern bool model_dead_wait_states; /* the flash does not take them over */
extern bool model_stuck_standby;    /* the CAN controller does not wake up */
extern bool model_write_protected;
extern int32_t model_cut_after; /* flash operations until the power goes; -1: never */
bool model_power_is_off(void);
/* What the operation leaves that the power cut: as it was, torn (what is read is neither, and its
 * ECC is wrong), or done. */
typedef enum { MODEL_CUT_BEFORE, MODEL_CUT_TORN, MODEL_CUT_AFTER } model_cut_t;
extern model_cut_t model_cut_leaves;
void model_flash_new(void);         /* erased, nothing torn */
void model_flash_tear(uint32_t at); /* the double word there */
extern bool (*model_nmi)(void);     /* the program's; false: it restarts the processor */
bool model_nmi_restarts(void);      /* it did since power came on */
extern bool model_other_nmi;        /* the next load from flash meets one of another part */

/* The bus. */
bool model_bus_frame(const sway_port_frame_t *frame, bool extended,
                     bool remote);             /* was it taken? */
bool model_bus_sent(sway_port_frame_t *frame); /* next frame that left */
extern bool model_bus_is_busy;                 /* nothing leaves */
extern unsigned model_bus_babbles;   /* frames that come, each as one is read from the FIFO */
void model_bus_error(uint32_t code); /* 1 stuff 2 form 3 ack 4 bit1 5 bit0 6 crc */
void model_bus_counters(uint32_t transmit, uint32_t receive);
bool model_wants_interrupt(void);

/* What was done. */
bool model_watchdog_bit(void); /* it would have restarted the processor */
uint32_t model_cpu_hz(void);
bool model_wants_restart(void);
#endif

/// program: the ECU on an STM32G474, without what only the processor can do (main.c): so that the
/// tests can run it against a model of the registers.
#ifndef SWAY_STM32G4_PROGRAM_H
#define SWAY_STM32G4_PROGRAM_H

#include "can.h"
#include "sway_ecu.h"

#define PROGRAM_BIT_RATE 500000U
#define PROGRAM_SAMPLE_POINT_MILLI 875U

/// Starts board, CAN and ECU. `check` is what the checks of memory and image found. False: there
/// is no clock or no CAN controller; the caller restarts.
bool program_start(sway_ecu_retained_t *retained, sway_ecu_cause_t check);
/// One pass of the main loop; false: there was nothing to do until the next interrupt.
bool program_pass(void);
/// The interrupt of the CAN controller.
void program_can_interrupt(void);
/// The NMI. True: a damaged double word among the parameters, which is dealt with; else it is a
/// fault.
bool program_nmi(void);

const sway_ecu_t *program_ecu(void);
const can_t *program_can(void);

#endif

/* The whole program of the STM32G474 on the host, fed from a candump file through the model of its
 * registers: replay_stm32g4 BLOCK RECORDING OUTPUT. Frames are put on the modelled bus in the
 * microsecond of the recording; what the program sends has to be what a replay without a bus
 * sends, byte for byte. */
#include <stdio.h>
#include <string.h>

#include "board.h"
#include "candump.h"
#include "model_stm32g4.h"
#include "program.h"
#include "stm32g474.h"

#define LONGEST_US INT64_C(1000000000)

static FILE *output;

static void drain(void)
{
    sway_port_frame_t frame;
    char line[CANDUMP_LINE];
    while (model_bus_sent(&frame)) {
        (void)candump_format(&frame, line);
        fputs(line, output);
    }
}

/* Everything that the program wants to do now. */
static void settle(void)
{
    bool busy = true;
    while (busy) {
        while (model_wants_interrupt()) {
            program_can_interrupt();
        }
        busy = program_pass();
        const uint32_t sent = program_can()->counters.sent;
        drain();
        (void)program_pass();
        busy = busy || program_can()->counters.sent != sent;
        drain();
    }
}

/* Recordings may begin with the seconds since 1970; the tick keeps the clock's count meanwhile. */
static void wait_until(int64_t time_us)
{
    while (model_time_us() < time_us) {
        const int64_t left_us = time_us - model_time_us();
        model_wait_us(left_us < LONGEST_US ? left_us : LONGEST_US);
        (void)board_time_ns();
    }
}

static int refuse(const char *what)
{
    fprintf(stderr, "replay_stm32g4: %s\n", what);
    return 1;
}

int main(int argc, char **argv)
{
    static sway_ecu_retained_t retained;
    char line[256];
    FILE *block = argc > 3 ? fopen(argv[1], "rb") : NULL;
    FILE *recording = argc > 3 ? fopen(argv[2], "r") : NULL;
    output = argc > 3 ? fopen(argv[3], "w") : NULL;
    if (block == NULL || recording == NULL || output == NULL) {
        return refuse("wanted BLOCK RECORDING OUTPUT");
    }
    model_flash_new();
    memcpy(model_flash + 2U * STM32_FLASH_PAGE, "swaywatch replay", SWAY_SIPHASH_KEY);
    model_nmi = program_nmi;
    if (fread(model_flash, 1, SWAY_BLOCK_SIZE, block) != SWAY_BLOCK_SIZE) {
        return refuse("the block is too short");
    }
    model_power_on();
    model_dead_noise = true; // a recording holds the answers to challenges without it
    if (!program_start(&retained, SWAY_ECU_NO_CAUSE)) {
        return refuse("the program does not start");
    }
    while (fgets(line, sizeof line, recording) != NULL) {
        sway_port_frame_t frame;
        line[strcspn(line, "\n")] = '\0';
        if (!candump_parse(line, &frame)) {
            return refuse("a line that is no frame");
        }
        wait_until(frame.time_us);
        if (!model_bus_frame(&frame, false, false)) {
            return refuse("a frame that the filters refuse, or that was lost");
        }
        settle();
    }
    fclose(block);
    fclose(recording);
    return fclose(output) == 0 && program_can()->counters.overflows == 0U ? 0 : 1;
}

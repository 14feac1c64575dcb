/* The ECU on a Cortex-R5 with a real CAN controller, and on the same emulated bus a second
 * controller that plays a recording to it and writes down what it answers.
 *
 * Arguments: BLOCK RECORDING OUTPUT FIGURES [DRILL]. A fault is noted, the program starts again,
 * the recording too. DRILL makes one on purpose, once: null, read, stack, undefined, cut (power
 * goes between erasing and writing the second block stored). CAN1 is the ECU's; CAN0 is the
 * player's. Frames go out in the microsecond in which they were recorded, and the ECU sees them by
 * the controller's own time stamps: the answers have to be those of a replay without a bus, byte
 * for byte.
 *
 * The emulator has no interrupt controller at the R5; the main loop calls the drivers' interrupt
 * functions whenever a controller raises its line. The clocks run SLOW times slower than the
 * instructions, so that player and ECU fit on one processor. */
#include <string.h>

#include "can.h"
#include "r5.h"
#include "replay.h"
#include "semihosting.h"
#include "sway_checks.h"

#define CAN0 0xFF060000U
#define CAN1 0xFF070000U
#define CAN_CLOCK_HZ 24000000U
#define BIT_RATE 500000U
#define SAMPLE_POINT_MILLI 875U

#ifndef SLOW
#define SLOW 8
#endif
/* The ECU is not given the processor when a frame is due so soon. */
#define GUARD_NS INT64_C(200000)
/* A frame sent later than this after its time would be stamped with the next microsecond. */
#define LATE_NS INT64_C(600)
#define LEAD_NS INT64_C(200)
#define DRILL_AFTER 500U

typedef struct {
    can_t can;
    replay_t replay;
    sway_port_frame_t next;
    bool has_next;
    int64_t shift_us; ///< of the ECU's clock to that of the recording
    uint32_t late;
    uint32_t played;
} player_t;

extern const uint8_t image_start[];
extern const uint32_t image_crc[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];

__attribute__((section(".noinit"))) static sway_ecu_retained_t retained;
__attribute__((section(".noinit"))) static pages_t pages;
static sway_ecu_t ecu;
static can_t ecu_can;
static player_t player;
static const char *drill = "";
static uint32_t polls;

void fault_stop(uint32_t cause, uint32_t address)
{
    sway_ecu_note_fault(&retained, cause, address);
    r5_restart();
}

void interrupt(void)
{
    can_interrupt(&ecu_can);
}

/* --- faults on purpose ------------------------------------------------------------------------ */

static uint32_t recurse(const volatile uint32_t *before)
{
    volatile uint32_t here[16];
    here[0] = *before + 1U;
    return polls == 0U ? here[0] : recurse(here) + here[0];
}

static void make_fault(void)
{
    volatile uintptr_t zero = 0U;
    volatile uint32_t depth = 0U;
    if (strcmp(drill, "null") == 0) {
        *(volatile uint32_t *)zero = 1U;
    } else if (strcmp(drill, "read") == 0) {
        depth = *(volatile uint32_t *)(zero + 8U);
    } else if (strcmp(drill, "stack") == 0) {
        depth = recurse(&depth);
    } else if (strcmp(drill, "undefined") == 0) {
        __asm__ volatile("udf #0");
    }
}

static void alive(void *context)
{
    (void)context;
    polls++;
    if (polls == DRILL_AFTER && retained.restarts == 0U) {
        make_fault();
    }
}

/* The power goes: nothing is noted. */
static void cut_power(uint32_t erasures)
{
    if (erasures == 2U && strcmp(drill, "cut") == 0) {
        r5_restart();
    }
}

/* --- the machine ------------------------------------------------------------------------------ */

/* The image as the build has sealed it, and the memory of the program's variables. */
static sway_ecu_cause_t check(void)
{
    const size_t size = (size_t)((uintptr_t)image_crc - (uintptr_t)image_start);
    if (!sway_check_image(image_start, size, image_crc[0])) {
        return SWAY_ECU_IMAGE;
    }
    return sway_check_memory(bss_start, bss_end) ? SWAY_ECU_NO_CAUSE : SWAY_ECU_MEMORY;
}

static int32_t machine_open(const char *path, bool write_it)
{
    return semihosting_open(path, write_it ? SEMIHOSTING_WRITE : SEMIHOSTING_READ);
}

static int64_t time_ns(void)
{
    return r5_time_ns() / SLOW;
}

/* --- the ECU's port --------------------------------------------------------------------------- */

static bool port_receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (!can_receive(&ecu_can, frame)) {
        return false;
    }
    frame->time_us += player.shift_us;
    return true;
}

static bool port_send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    return can_send(&ecu_can, frame);
}

static int64_t port_time_us(void *context)
{
    (void)context;
    return time_ns() / 1000 + player.shift_us;
}

/* --- the player ------------------------------------------------------------------------------- */

static int64_t due_ns(void)
{
    return (player.next.time_us - player.shift_us) * 1000 + LEAD_NS;
}

static void play(void)
{
    while (player.has_next && time_ns() >= due_ns()) {
        if (time_ns() - due_ns() > LATE_NS) {
            player.late += 1U;
        }
        if (!can_send(&player.can, &player.next)) {
            return;
        }
        player.played += 1U;
        player.has_next = replay_next(&player.replay, &player.next);
    }
}

static void write_answers(void)
{
    sway_port_frame_t frame;
    while (can_receive(&player.can, &frame)) {
        frame.time_us += player.shift_us;
        replay_put(&player.replay, &frame);
    }
}

/* --- both ------------------------------------------------------------------------------------- */

static void serve(can_t *can)
{
    if (can_wants_interrupt(can)) {
        can_interrupt(can);
    }
    can_service(can);
}

/* Nothing to do: the emulator runs a row of no-operations in no time. */
static void wait(void)
{
    const int64_t left_ns = player.has_next ? (due_ns() - time_ns()) * SLOW : 0;
    for (int64_t blocks = (left_ns - 4000) / 520; blocks > 0; blocks--) {
        __asm__ volatile(".rept 498\n nop\n .endr");
    }
}

static can_config_t config_of(uintptr_t base)
{
    const can_config_t config = {.base = base,
                                 .clock_hz = CAN_CLOCK_HZ * SLOW,
                                 .bit_rate = BIT_RATE,
                                 .sample_point_milli = SAMPLE_POINT_MILLI,
                                 .time_ns = time_ns};
    return config;
}

static bool start_controllers(void)
{
    can_config_t config = config_of(CAN0);
    if (!can_start(&player.can, &config)) {
        return false;
    }
    config = config_of(CAN1);
    config.filter[0] = (can_filter_t){.wanted = 0x120, .mask = 0x7E0};
    config.filter[1] = (can_filter_t){.wanted = 0x6E0, .mask = 0x7FF};
    config.filters = 2;
    return can_start(&ecu_can, &config);
}

static void put_figure(int32_t file, const char *name, uint32_t value)
{
    char text[48];
    char digits[12];
    size_t at = strlen(name);
    size_t count = 0;
    memcpy(text, name, at);
    text[at++] = ' ';
    do {
        digits[count++] = (char)('0' + (char)(value % 10U));
        value /= 10U;
    } while (value != 0U);
    while (count > 0U) {
        text[at++] = digits[--count];
    }
    text[at++] = '\n';
    (void)semihosting_write(file, text, at);
}

static void put_figures(const char *path)
{
    const int32_t file = semihosting_open(path, SEMIHOSTING_WRITE);
    put_figure(file, "played", player.played);
    put_figure(file, "late", player.late);
    put_figure(file, "ecu_received", ecu_can.counters.received);
    put_figure(file, "ecu_sent", ecu_can.counters.sent);
    put_figure(file, "overflows", ecu_can.counters.overflows + player.can.counters.overflows);
    put_figure(file, "answers", player.can.counters.received);
    put_figure(file, "stack", r5_stack_used());
    semihosting_close(file);
}

static void run(void)
{
    int64_t idle_since_ns = 0;
    while (player.has_next || time_ns() - idle_since_ns < 1000000) {
        play();
        serve(&ecu_can);
        serve(&player.can);
        write_answers();
        bool busy = false;
        if (!player.has_next || due_ns() - time_ns() > GUARD_NS) {
            busy = sway_ecu_poll(&ecu);
        }
        if (busy || player.has_next) {
            idle_since_ns = time_ns();
        }
        if (!busy) {
            wait();
        }
    }
}

int main(void)
{
    static char arguments[512];
    const replay_machine_t machine = {.open = machine_open,
                                      .read = semihosting_read,
                                      .write = semihosting_write,
                                      .standard_output = semihosting_stdout(),
                                      .check = check,
                                      .erased = cut_power};
    const sway_port_t port = {
        .receive = port_receive, .send = port_send, .time_us = port_time_us, .alive = alive};
    semihosting_arguments(arguments, sizeof arguments);
    char *rest = arguments;
    const char *block_path = replay_word(&rest);
    const char *recording = replay_word(&rest);
    const char *output = replay_word(&rest);
    const char *figures_path = replay_word(&rest);
    drill = replay_word(&rest);
    if (replay_open(&player.replay, &machine, recording, output) != 0 || !start_controllers()) {
        semihosting_exit(2);
    }
    player.has_next = replay_next(&player.replay, &player.next);
    player.shift_us = player.next.time_us - time_ns() / 1000 - 1000;
    if (!replay_start(&ecu, &retained, port, &pages, &machine, block_path)) {
        semihosting_exit(2);
    }
    run();
    put_figures(figures_path);
    semihosting_exit(player.replay.failed || player.late > 0U ? 1 : 0);
}

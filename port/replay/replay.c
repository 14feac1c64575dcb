#include "replay.h"

#include <string.h>

#include "candump.h"
#if REPLAY_XCP
#include "sway_xcp.h"
#endif

static void say(const replay_machine_t *machine, const char *text)
{
    (void)machine->write(machine->standard_output, text, strlen(text));
}

static bool refill(replay_t *replay)
{
    const size_t left = replay->end - replay->at;
    memmove(replay->text, replay->text + replay->at, left);
    replay->at = 0;
    replay->end = left;
    const size_t count =
        replay->machine->read(replay->input, replay->text + left, sizeof replay->text - left);
    replay->end += count;
    return count > 0U;
}

/* The next line, with its end cut off; NULL at the end of the file. */
static char *next_line(replay_t *replay)
{
    for (;;) {
        char *line = replay->text + replay->at;
        char *end = memchr(line, '\n', replay->end - replay->at);
        if (end != NULL) {
            *end = '\0';
            replay->at = (size_t)(end - replay->text) + 1U;
            return line;
        }
        if (!refill(replay)) {
            return NULL; // what follows the last newline is no whole line
        }
    }
}

bool replay_next(replay_t *replay, sway_port_frame_t *frame)
{
    char *line = next_line(replay);
    while (line != NULL) {
        if (candump_parse(line, frame)) {
            replay->time_us = frame->time_us;
            return true;
        }
        replay->lines_refused += 1U;
        line = next_line(replay);
    }
    replay->is_done = true;
    return false;
}

static void stop(const replay_t *replay, replay_did_t what)
{
    if (replay->machine->stopped != NULL) {
        replay->machine->stopped(what);
    }
}

static void go_on(const replay_t *replay)
{
    if (replay->machine->began != NULL) {
        replay->machine->began(replay->time_us);
    }
}

static bool replay_receive(void *context, sway_port_frame_t *frame)
{
    replay_t *replay = context;
    stop(replay, REPLAY_NOT_DONE);
    const bool received = replay_next(replay, frame);
    replay->did = received ? REPLAY_RECEIVED : replay->did;
    go_on(replay);
    return received;
}

void replay_put(replay_t *replay, const sway_port_frame_t *frame)
{
    char line[CANDUMP_LINE];
    const size_t size = candump_format(frame, line);
    if (!replay->machine->write(replay->output, line, size)) {
        replay->failed = true;
    }
}

static bool replay_send(void *context, const sway_port_frame_t *frame)
{
    replay_t *replay = context;
    stop(replay, REPLAY_NOT_DONE);
    replay_put(replay, frame);
    replay->did = REPLAY_SENT;
    go_on(replay);
    return true;
}

static int64_t replay_time_us(void *context)
{
    const replay_t *replay = context;
    return replay->time_us;
}

sway_port_t replay_port(replay_t *replay)
{
    const sway_port_t port = {.receive = replay_receive,
                              .send = replay_send,
                              .time_us = replay_time_us,
                              .context = replay};
    return port;
}

char *replay_word(char **text)
{
    char *word = *text;
    while (*word == ' ') {
        word++;
    }
    char *end = word;
    while (*end != ' ' && *end != '\0') {
        end++;
    }
    *text = *end == '\0' ? end : end + 1;
    *end = '\0';
    return word;
}

int replay_open(replay_t *replay, const replay_machine_t *machine, const char *recording,
                const char *output)
{
    memset(replay, 0, sizeof *replay);
    replay->machine = machine;
    replay->output = machine->standard_output;
    if (recording[0] == '\0') {
        say(machine, "replay: wanted BLOCK RECORDING [OUTPUT]\n");
        return 2;
    }
    replay->input = machine->open(recording, false);
    if (output[0] != '\0') {
        replay->output = machine->open(output, true);
    }
    if (replay->input < 0 || replay->output < 0) {
        say(machine, "replay: cannot open ");
        say(machine, replay->input < 0 ? recording : output);
        say(machine, "\n");
        return 1;
    }
    return 0;
}

#if REPLAY_XCP
static sway_xcp_t xcp;

static sway_port_t attach(sway_ecu_t *ecu, const sway_port_t *port)
{
    const sway_xcp_config_t config = {.request_id = 0x6E4,
                                      .reply_id = 0x6E5,
                                      .ecu_address = (uint32_t)(uintptr_t)ecu,
                                      .working_address = (uint32_t)(uintptr_t)&xcp.working};
    return sway_xcp_attach(&xcp, ecu, port, &config);
}

static void attached(void)
{
    sway_xcp_start(&xcp);
}

static void poll(sway_ecu_t *ecu)
{
    (void)ecu;
    (void)sway_xcp_poll(&xcp);
}
#else
static sway_port_t attach(sway_ecu_t *ecu, const sway_port_t *port)
{
    (void)ecu;
    return *port;
}

static void attached(void)
{
}

static void poll(sway_ecu_t *ecu)
{
    (void)sway_ecu_poll(ecu);
}
#endif

/* For the tests: a product has one of its own, and keeps it to itself. */
static const uint8_t key[SWAY_SIPHASH_KEY] = "swaywatch replay";

static pages_t *stored; // the ECU has one memory for parameters

static bool replay_store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    const sway_store_t store = pages_store(stored);
    return sway_store_write(&store, block, size);
}

bool replay_start(sway_ecu_t *ecu, sway_ecu_retained_t *retained, sway_port_t port, pages_t *pages,
                  const replay_machine_t *machine, const char *path)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    const int32_t file = machine->open(path, false);
    pages_start(pages, block, file < 0 ? 0U : machine->read(file, block, sizeof block));
    pages->erased = machine->erased;
    stored = pages;
    port.store = replay_store;
    port.key = key;
    port = attach(ecu, &port);
    const sway_store_t store = pages_store(pages);
    const bool interrupted = sway_store_find(&store, block);
    if (sway_ecu_start(ecu, &port, retained, block, sizeof block) != SWAY_OK) {
        return false;
    }
    attached();
    const sway_ecu_cause_t cause = machine->check();
    if (cause != SWAY_ECU_NO_CAUSE) {
        sway_ecu_fail(ecu, cause);
    }
    if (interrupted) {
        sway_ecu_warn(ecu, SWAY_ECU_STORE_CUT);
    }
    return true;
}

int replay_run(sway_ecu_t *ecu, sway_ecu_retained_t *retained, pages_t *pages,
               const replay_machine_t *machine, const char *block, const char *recording,
               const char *output)
{
    static replay_t replay;
    const int status = replay_open(&replay, machine, recording, output);
    if (status != 0) {
        return status;
    }
    sway_port_t port = replay_port(&replay);
    port.alive = machine->alive;
    if (!replay_start(ecu, retained, port, pages, machine, block)) {
        return 2;
    }
    while (!replay.is_done) {
        replay.did = REPLAY_WORKED;
        go_on(&replay);
        poll(ecu);
        stop(&replay, replay.did);
    }
    return replay.failed ? 1 : 0;
}

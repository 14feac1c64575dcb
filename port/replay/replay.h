/// replay: the ECU fed from a candump file instead of a bus, on any machine that can read files.
///
/// BLOCK is the parameter block as it would lie in flash, RECORDING and OUTPUT are candump files;
/// with an empty OUTPUT the status frames go to the standard output.
#ifndef SWAY_REPLAY_H
#define SWAY_REPLAY_H

#include "pages.h"
#include "sway_ecu.h"

/// What one sway_ecu_poll() has done.
typedef enum {
    REPLAY_NOT_DONE, ///< it is not over yet
    REPLAY_WORKED,
    REPLAY_SENT,
    REPLAY_RECEIVED,
    REPLAY_KINDS
} replay_did_t;

/// Files and clock of the machine. A file is a number that `open` gave, negative: refused.
typedef struct {
    int32_t (*open)(const char *path, bool write);
    size_t (*read)(int32_t file, void *bytes, size_t size);
    bool (*write)(int32_t file, const void *bytes, size_t size);
    int32_t standard_output;
    sway_ecu_cause_t (*check)(void); ///< start-up checks of the machine
    void (*alive)(void *context);    ///< serves the watchdog; may be NULL
    /// Optional: a page of parameters is erased and not yet written.
    void (*erased)(uint32_t erasures);
    /// Optional, for counting what the ECU costs: it goes on now, at this time of the recording, or
    /// stops: it calls the port, or sway_ecu_poll() has returned and has done `what`.
    void (*began)(int64_t time_us);
    void (*stopped)(replay_did_t what);
} replay_machine_t;

typedef struct {
    const replay_machine_t *machine;
    int32_t input;
    int32_t output;
    char text[512]; ///< of the input, not yet used from `at` to `end`
    size_t at;
    size_t end;
    int64_t time_us;
    replay_did_t did; ///< in this poll
    uint32_t lines_refused;
    bool failed;
    bool is_done;
} replay_t;

/// Opens the files; 0, or the exit status 2 with a message on the standard output.
int replay_open(replay_t *replay, const replay_machine_t *machine, const char *recording,
                const char *output);
/// The recording's next frame; false at its end.
bool replay_next(replay_t *replay, sway_port_frame_t *frame);
/// One frame to the output; a failure is remembered in `failed`.
void replay_put(replay_t *replay, const sway_port_frame_t *frame);
/// Cuts the next word off `text`, which moves on.
char *replay_word(char **text);
/// The port that reads and writes the files. `replay` has to outlive it.
sway_port_t replay_port(replay_t *replay);
/// Starts the ECU with the parameters in `pages`; at a first start they come from the file `path`
/// (none: empty flash), afterwards from what was stored. Adds `store` to the port. What the
/// machine's start-up checks find ends in the safe state. False: wrong arguments.
bool replay_start(sway_ecu_t *ecu, sway_ecu_retained_t *retained, sway_port_t port, pages_t *pages,
                  const replay_machine_t *machine, const char *path);
/// The whole program: opens, starts the ECU, polls until the recording ends. Exit status: 0, 1 a
/// file could not be read or written, 2 wrong arguments.
int replay_run(sway_ecu_t *ecu, sway_ecu_retained_t *retained, pages_t *pages,
               const replay_machine_t *machine, const char *block, const char *recording,
               const char *output);

#endif

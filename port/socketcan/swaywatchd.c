/* swaywatchd: the ECU's program as a Linux daemon on a SocketCAN interface, or over a candump log.
 *
 * What it loses or cannot use it says on the standard error: at once when something happens, as one
 * line "counts {...}" (JSON) at the end and on SIGUSR1. */
#include <errno.h>
#include <getopt.h>
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>

#include "can_bus.h"
#include "candump.h"
#include "log_file.h"
#include "map_file.h"
#include "sway_version.h"
#include "sway_xcp.h"
#include "swaywatch_dbc.h"
#include "names.h"
#include "vehicle_file.h"

#define EXIT_USAGE 2
#define EXIT_UNREADABLE 3
#define IDLE_MS 20
#define RETRY_MS 1
#define SETTINGS_MAX 32
#define XCP_REQUEST_ID 0x6E4
#define XCP_REPLY_ID 0x6E5

static const char usage[] =
    "usage: swaywatchd --vehicle vehicle.toml [OPTIONS] INTERFACE\n"
    "       swaywatchd --vehicle vehicle.toml [OPTIONS] --replay LOG\n"
    "\n"
    "Reads the messages of swaywatch.dbc, watches the stability of the car-trailer\n"
    "combination, and sends its status frames.\n"
    "\n"
    "  --vehicle FILE      known values of the combination (SI units)\n"
    "  --set KEY=VALUE     overrides a value of the file, any number of times, for example\n"
    "                      car.lateral_acceleration_position=-1.383 (m ahead of the centre\n"
    "                      of gravity), or core.window_oscillations=2.0 (1.5 to 6, else 1.7):\n"
    "                      longer windows have smaller errors, but respond later\n"
    "  --map FILE          read a car's own bus by a map of `swaywatch map`; frames of\n"
    "                      swaywatch.dbc are still read\n"
    "  --replay LOG        read a candump log instead of a bus (- : standard input);\n"
    "                      status frames go to the standard output\n"
    "  --candump-out FILE  write the status frames there, as candump lines (- : standard\n"
    "                      output)\n"
    "  --remember FILE     keep the trailer that was learnt from the car's own sensors there,\n"
    "                      at standstill and at the end, and compare the next drive with it\n"
    "                      (message SwayTrailer); created if it is missing or damaged\n"
    "  --key FILE          16 bytes, required for changing parameters over CAN\n"
    "  --xcp               measurement and calibration by XCP on CAN, identifiers 0x6E4 and\n"
    "                      0x6E5; changes need the key. A2L file: make build/swaywatchd.a2l\n"
    "  --version           print the version\n"
    "\n"
    "SIGTERM or SIGINT end it, SIGUSR1 makes it print its counters. When its terminal closes\n"

    "(SIGHUP) or its output is no longer read, it continues.\n"
    "Exit status: 0 done, 1 an error of files or interface, 2 wrong arguments,\n"
    "3 the log was read but has lines that are not candump's, or implausible time stamps.\n";

typedef struct {
    const char *vehicle;
    const char *replay;
    const char *candump_out;
    const char *interface;
    const char *key;
    const char *map;
    const char *remember;
    bool has_xcp;
    char *settings[SETTINGS_MAX];
    size_t setting_count;
    int32_t window_cycles_milli; ///< 0: as the core has it
} options_t;

static can_bus_t bus;
static log_file_t recording;
static sway_ecu_t ecu;
static sway_xcp_t xcp;
static sway_map_t map; ///< of the car's own bus, --map
static sway_map_listen_t listening = {.map = &map};
static uint8_t key[SWAY_SIPHASH_KEY];
static FILE *candump_out;
static const char *remembered; ///< file of --remember
static uint64_t output_lost;
static uint64_t other_ecu;
static volatile sig_atomic_t wants_end;
static volatile sig_atomic_t wants_counts;

static void on_signal(int number)
{
    if (number == SIGUSR1 || number == SIGHUP) {
        wants_counts = 1;
    } else {
        wants_end = 1;
    }
}

/* --- what is said about losses -----------------------------------------------------------------
 */

static void print_count(const char *name, uint64_t count)
{
    fprintf(stderr, "\"%s\": %llu, ", name, (unsigned long long)count);
}

static void print_node_counts(void)
{
    static const char *const frame_faults[SWAY_FRAME_FAULT_COUNT] = {
        "crc", "lost", "repeated", "late", "length", "timeout", "stuck", "frozen", "unknown_id"};
    static const char *const core_faults[SWAY_FAULT_COUNT] = {
        "range", "time", "invalid", "gap", "singular", "overrun", "rate"};
    for (int i = 0; i < SWAY_FRAME_FAULT_COUNT; i++) {
        print_count(frame_faults[i], sway_node_fault(&ecu.node, (sway_frame_fault_t)i));
    }
    const sway_status_t *status = sway_core_status(&ecu.node.core);
    for (int i = 0; i < SWAY_FAULT_COUNT; i++) {
        print_count(core_faults[i], status->fault_count[i]);
    }
    print_count("accepted", ecu.node.accepted);
    print_count("estimates", status->sequence);
    fprintf(stderr, "\"alarm\": %d}\n", (int)status->alarm);
}

static void print_bus_counts(void)
{
    const can_bus_counts_t *c = &bus.counts;
    fprintf(stderr, "swaywatchd: counts {");
    print_count("received", c->received);
    print_count("foreign", c->foreign);
    print_count("kernel_lost", c->kernel_lost);
    print_count("sent", c->sent);
    print_count("send_retries", c->send_retries);
    print_count("send_lost", c->send_lost);
    print_count("downs", c->downs);
    print_count("clock_back", c->clock_back);
    print_count("clock_set", c->clock_set);
    print_count("stamped_here", c->stamped_here);
    print_count("output_lost", output_lost);
    print_count("other_ecu", other_ecu);
    print_count("error_frames", c->error_frames);
    for (int i = 0; i < CAN_BUS_CLASSES; i++) {
        print_count(can_bus_class_name((can_bus_class_t)i), c->error_class[i]);
    }
    print_node_counts();
}

static void print_replay_counts(void)
{
    fprintf(stderr, "swaywatchd: counts {");
    print_count("lines", recording.lines);
    print_count("received", recording.frames);
    print_count("foreign", recording.foreign);
    print_count("error_frames", recording.error_frames);
    print_count("dropped_by_logger", recording.dropped);
    print_count("unreadable", recording.unreadable);
    print_count("clock_back", recording.clock_back);
    print_count("most_back_us", (uint64_t)recording.most_back_us);
    print_count("stamps_damaged", recording.stamps_damaged);
    print_count("clock_set", recording.clock_set);
    print_node_counts();
}

/* --- the ECU's ports ---------------------------------------------------------------------------
 */

/* Said when it happens: at the end nobody may be there. The ECU goes on. */
static void lose_output(void)
{
    if (output_lost == 0U) {
        fprintf(stderr, "swaywatchd: the status frames can no longer be written: %s\n",
                strerror(errno));
    }
    output_lost++;
    clearerr(candump_out);
}

static void flush_candump(void)
{
    if (candump_out != NULL && fflush(candump_out) != 0) {
        lose_output();
    }
}

static void write_candump(const sway_port_frame_t *frame)
{
    char line[CANDUMP_LINE];
    const size_t size = candump_format(frame, line);
    if (candump_out != NULL && fwrite(line, 1, size, candump_out) != size) {
        lose_output();
    }
}

/* Only one ECU of this kind belongs on a bus: two would answer each other's driver. */
static void find_other_ecu(const sway_port_frame_t *frame)
{
    if (frame->id != SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID &&
        frame->id != SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
        return;
    }
    if (other_ecu == 0U) {
        fprintf(stderr, "swaywatchd: %s: another swaywatch ECU sends on this bus\n", bus.name);
    }
    other_ecu++;
}

static bool bus_receive(void *context, sway_port_frame_t *frame)
{
    const bool is_there = can_bus_receive(context, frame);
    if (is_there) {
        find_other_ecu(frame);
    }
    return is_there;
}

static bool bus_send(void *context, const sway_port_frame_t *frame)
{
    write_candump(frame);
    can_bus_send(context, frame);
    return true;
}

static int64_t bus_time_us(void *context)
{
    (void)context;
    return can_bus_time_us();
}

static uint32_t bus_random(void *context)
{
    (void)context;
    uint32_t value = 0;
    (void)getrandom(&value, sizeof value, 0);
    return value;
}

static bool log_receive(void *context, sway_port_frame_t *frame)
{
    return log_file_next(context, frame);
}

static bool log_send(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    write_candump(frame);
    return true;
}

static int64_t log_time_us(void *context)
{
    return log_file_time_us(context);
}

/* The parameter block that an ECU would find in its flash. */
static bool read_block(const options_t *options, uint8_t *block)
{
    sway_core_config_t config;
    char message[300];
    sway_core_defaults(&config);
    if (!vehicle_file_read(options->vehicle, options->settings, options->setting_count,
                           &config.vehicle, message, sizeof message)) {
        fprintf(stderr, "swaywatchd: %s\n", message);
        return false;
    }
    if (options->window_cycles_milli != 0) {
        config.window_cycles_milli = options->window_cycles_milli;
    }
    sway_block_write(&config, 1, block);
    return true;
}

static void hear(void *context, sway_node_t *node, const sway_port_frame_t *frame)
{
    (void)sway_map_receive(context, node, frame->time_us, frame->id, frame->dlc, frame->data);
}

/* --- the trailer remembered --------------------------------------------------------------------
 */

/* Written beside and renamed: a cut leaves the old one or the new one, whole. */
static bool keep_trailer(void *context, const uint8_t *record, size_t size)
{
    (void)context;
    char beside[PATH_MAX];
    const int length = snprintf(beside, sizeof beside, "%s.new", remembered);
    FILE *file = length > 0 && (size_t)length < sizeof beside ? fopen(beside, "wb") : NULL;
    bool is_kept = file != NULL && fwrite(record, 1, size, file) == size && fflush(file) == 0 &&
                   fsync(fileno(file)) == 0;
    if (file != NULL) {
        is_kept = fclose(file) == 0 && is_kept;
    }
    is_kept = is_kept && rename(beside, remembered) == 0;
    if (!is_kept) {
        fprintf(stderr, "swaywatchd: %s: %s\n", remembered, strerror(errno));
    }
    return is_kept;
}

static void recall_trailer(const char *path)
{
    uint8_t record[SWAY_REMEMBER_SIZE];
    FILE *file = fopen(path, "rb");
    const size_t size = file != NULL ? fread(record, 1, sizeof record, file) : 0U;
    if (file != NULL) {
        fclose(file);
    }
    uint32_t sequence = 0;
    if (sway_remember_check(record, size, &sequence) != SWAY_BLOCK_OK) {
        fprintf(stderr, "swaywatchd: %s: %s; starts without a remembered trailer\n", path,
                file == NULL ? "not found" : "damaged, or of another version");
    }
    remembered = path;
    sway_ecu_remember(&ecu, keep_trailer, record, size);
}

static void print_trailer(void)
{
    static const char *const words[] = {"unknown", "no trailer", "new", "same", "another"};
    const sway_trailer_watch_t *const watch = sway_core_trailer(&ecu.node.core);
    if (remembered != NULL) {
        fprintf(stderr, "swaywatchd: trailer: %s, likeness %.2f, learnt from %d s, %u written\n",
                words[sway_remember_state(&ecu.remember, watch)],
                sway_real_to_int(ecu.remember.likeness, 100, -INT32_MAX, INT32_MAX) / 100.0,
                (int)(watch->learnt_ms / 1000), (unsigned)ecu.remember.writes);
    }
}

static void leave(void)
{
    sway_ecu_leave(&ecu);
    print_trailer();
}

static bool start(const options_t *options, const sway_port_t *port, const uint8_t *block)
{
    static sway_ecu_retained_t retained;
    if (sway_ecu_start(&ecu, port, &retained, block, SWAY_BLOCK_SIZE) != SWAY_OK ||
        ecu.state != SWAY_ECU_RUNNING) {
        fprintf(stderr, "swaywatchd: the core refuses the parameters\n");
        return false;
    }
    if (options->map != NULL) {
        sway_ecu_listen(&ecu, hear, &listening);
    }
    if (options->remember != NULL) {
        recall_trailer(options->remember);
    }
    return true;
}

/* A key that others may read is none, but that is not ours to say. */
static bool read_key(const char *path)
{
    FILE *file = fopen(path, "rb");
    const bool is_read =
        file != NULL && fread(key, 1, sizeof key, file) == sizeof key && fgetc(file) == EOF;
    if (!is_read) {
        fprintf(stderr, "swaywatchd: %s: %s\n", path,
                file == NULL ? strerror(errno) : "a key has 16 bytes, no more and no less");
    }
    if (file != NULL) {
        fclose(file);
    }
    return is_read;
}

/* --- XCP ---------------------------------------------------------------------------------------
 */

/* Where the ELF file says that something is: a program that was loaded elsewhere than it was linked
 * (PIE) is linked to 0. */
static uint32_t linked_at(const void *object)
{
#ifdef __PIE__
    extern const char __executable_start[];
    return (uint32_t)((uintptr_t)object - (uintptr_t)__executable_start);
#else
    return (uint32_t)(uintptr_t)object;
#endif
}

static sway_port_t attach_xcp(const sway_port_t *port)
{
    const sway_xcp_config_t config = {.request_id = XCP_REQUEST_ID,
                                      .reply_id = XCP_REPLY_ID,
                                      .ecu_address = linked_at(&ecu),
                                      .working_address = linked_at(&xcp.working)};
    return sway_xcp_attach(&xcp, &ecu, port, &config);
}

static bool poll_ecu(const options_t *options)
{
    return options->has_xcp ? sway_xcp_poll(&xcp) : sway_ecu_poll(&ecu);
}

/* --- live --------------------------------------------------------------------------------------
 */

static void wait_for_work(const sigset_t *open_mask)
{
    struct pollfd fd = {.fd = bus.socket, .events = POLLIN};
    const bool is_away = bus.link == CAN_BUS_DOWN;
    const long wait_ms = bus.queue_waits ? RETRY_MS : IDLE_MS;
    const struct timespec timeout = {.tv_sec = 0, .tv_nsec = wait_ms * 1000000};
    /* An interface that is down reports an error for as long as it is: only sleep then. */
    (void)ppoll(&fd, is_away ? 0U : 1U, &timeout, open_mask);
}

static int run_live(const options_t *options, const uint8_t *block)
{
    sigset_t open_mask;
    sigset_t closed_mask;
    sway_port_t port = {.receive = bus_receive,
                        .send = bus_send,
                        .time_us = bus_time_us,
                        .random = bus_random,
                        .key = options->key != NULL ? key : NULL,
                        .context = &bus};
    if (options->has_xcp) {
        port = attach_xcp(&port);
    }
    sigemptyset(&closed_mask);
    sigaddset(&closed_mask, SIGTERM);
    sigaddset(&closed_mask, SIGINT);
    sigaddset(&closed_mask, SIGUSR1);
    sigaddset(&closed_mask, SIGHUP);
    sigprocmask(SIG_BLOCK, &closed_mask, &open_mask);
    if (!can_bus_open(&bus, options->interface)) {
        fprintf(stderr, "swaywatchd: %s: %s\n", options->interface,
                errno == EAFNOSUPPORT ? "this kernel has no CAN; --replay works without"
                                      : strerror(errno));
        return EXIT_FAILURE;
    }
    if (!start(options, &port, block)) {
        return EXIT_FAILURE;
    }
    if (options->has_xcp) {
        sway_xcp_start(&xcp);
    }
    fprintf(stderr, "swaywatchd: %s: running\n", options->interface);
    while (wants_end == 0) {
        while (poll_ecu(options)) {
            if (bus.batch_at == bus.batch_end) {
                can_bus_work(&bus);
            }
        }
        can_bus_work(&bus);
        flush_candump();
        if (wants_counts != 0) {
            wants_counts = 0;
            print_bus_counts();
            print_trailer();
        }
        wait_for_work(&open_mask);
    }
    print_bus_counts();
    leave();
    can_bus_close(&bus);
    return EXIT_SUCCESS;
}

/* --- replay ------------------------------------------------------------------------------------
 */

static int run_replay(const options_t *options, const uint8_t *block)
{
    const sway_port_t port = {
        .receive = log_receive, .send = log_send, .time_us = log_time_us, .context = &recording};
    if (!log_file_open(&recording, options->replay)) {
        fprintf(stderr, "swaywatchd: %s: %s\n", options->replay, strerror(errno));
        return EXIT_FAILURE;
    }
    recording.wants_end = &wants_end;
    if (!start(options, &port, block)) {
        return EXIT_FAILURE;
    }
    while (wants_end == 0 && output_lost == 0U && sway_ecu_poll(&ecu)) {
    }
    const bool is_read = log_file_close(&recording);
    print_replay_counts();
    leave();
    if (!is_read || ecu.node.accepted == 0U) {
        fprintf(stderr, "swaywatchd: %s: %s\n", options->replay,
                is_read ? "no frame of swaywatch.dbc in it, nor of a --map; swaywatch convert "
                          "makes such a log from any recording"
                        : "cannot be read to its end");
        return EXIT_FAILURE;
    }
    const uint64_t damaged = recording.unreadable + recording.stamps_damaged + recording.clock_set;
    return damaged > 0U ? EXIT_UNREADABLE : EXIT_SUCCESS;
}

/* --- the command line --------------------------------------------------------------------------
 */

/* "core.window_oscillations=2.0": the one value of the core itself that a user sets. */
static bool read_core_setting(const char *setting, options_t *options)
{
    static const char name[] = "core.window_oscillations=";
    const uint32_t word = (uint32_t)(offsetof(sway_core_config_t, window_cycles_milli) / 4U);
    int32_t low = 0;
    int32_t high = 0;
    bool may_be_zero = false;
    (void)sway_block_range(word, &low, &high, &may_be_zero);
    char *end = NULL;
    const bool is_known = strncmp(setting, name, sizeof name - 1U) == 0;
    const double value = is_known ? strtod(setting + sizeof name - 1U, &end) : 0.0;
    if (!is_known || *end != '\0' || !(value >= low / 1e3 && value <= high / 1e3)) {
        fprintf(stderr, "swaywatchd: --set %.80s: expected core.window_oscillations=%g to %g\n",
                setting, low / 1e3, high / 1e3);
        return false;
    }
    options->window_cycles_milli = (int32_t)(value * 1e3 + 0.5);
    return true;
}

static bool read_option(int option, options_t *options)
{
    switch (option) {
    case 'v':
        options->vehicle = optarg;
        return true;
    case 'r':
        options->replay = optarg;
        return true;
    case 'o':
        options->candump_out = optarg;
        return true;
    case 's':
        if (strncmp(optarg, "core.", 5) == 0) {
            return read_core_setting(optarg, options);
        }
        options->settings[options->setting_count % SETTINGS_MAX] = optarg;
        options->setting_count++;
        return options->setting_count <= SETTINGS_MAX;
    case 'k':
        options->key = optarg;
        return true;
    case 'm':
        options->map = optarg;
        return true;
    case 'e':
        options->remember = optarg;
        return true;
    case 'x':
        options->has_xcp = true;
        return true;
    case 'h':
        fputs(usage, stdout);
        exit(EXIT_SUCCESS);
    case 'V':
        printf("swaywatchd %d.%d.%d\n", SWAY_VERSION_MAJOR, SWAY_VERSION_MINOR, SWAY_VERSION_PATCH);
        exit(EXIT_SUCCESS);
    default:
        return false;
    }
}

/* Names the option that an unknown one is two letters or fewer away from. */
static void suggest(const char *argument, const struct option *known)
{
    const struct option *nearest = known;
    if (optopt != 0 || strncmp(argument, "--", 2) != 0) {
        return; // a known one without its value, or a letter
    }
    const char *name = argument + 2;
    const size_t size = strcspn(name, "=");
    for (; known->name != NULL; known++) {
        if (names_apart(name, size, known->name) < names_apart(name, size, nearest->name)) {
            nearest = known;
        }
    }
    if (names_apart(name, size, nearest->name) <= NAMES_ALIKE) {
        fprintf(stderr, "swaywatchd: did you mean --%s?\n", nearest->name);
    }
}

static bool read_options(int argc, char **argv, options_t *options)
{
    static const struct option known[] = {{"vehicle", required_argument, NULL, 'v'},
                                          {"replay", required_argument, NULL, 'r'},
                                          {"candump-out", required_argument, NULL, 'o'},
                                          {"set", required_argument, NULL, 's'},
                                          {"key", required_argument, NULL, 'k'},
                                          {"map", required_argument, NULL, 'm'},
                                          {"remember", required_argument, NULL, 'e'},
                                          {"xcp", no_argument, NULL, 'x'},
                                          {"help", no_argument, NULL, 'h'},
                                          {"version", no_argument, NULL, 'V'},
                                          {NULL, 0, NULL, 0}};
    int option;
    while ((option = getopt_long(argc, argv, "h", known, NULL)) != -1) {
        if (option == '?') {
            suggest(argv[optind - 1], known);
        }
        if (!read_option(option, options)) {
            return false;
        }
    }
    options->interface = optind < argc ? argv[optind] : NULL;
    const int sources = (options->replay != NULL) + (argc - optind);
    const bool live_only = options->has_xcp || options->key != NULL;
    return options->vehicle != NULL && sources == 1 && !(live_only && options->replay != NULL);
}

/* Opening a file to write it empties it. */
static bool is_input(const options_t *options, const char *path)
{
    const char *inputs[] = {options->vehicle, options->replay, options->map, options->remember};
    struct stat output;
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++) {
        struct stat input;
        if (inputs[i] != NULL && stat(path, &output) == 0 && stat(inputs[i], &input) == 0 &&
            S_ISREG(input.st_mode) && input.st_dev == output.st_dev &&
            input.st_ino == output.st_ino) {
            fprintf(stderr, "swaywatchd: %s: is read already (%s); write to another file\n", path,
                    inputs[i]);
            return true;
        }
    }
    return false;
}

static bool open_output(const options_t *options)
{
    const char *path = options->candump_out;
    if (path == NULL && options->replay == NULL) {
        return true;
    }
    const bool to_stdout = path == NULL || strcmp(path, "-") == 0;
    if (!to_stdout && is_input(options, path)) {
        return false;
    }
    candump_out = to_stdout ? stdout : fopen(path, "w");
    if (candump_out == NULL) {
        fprintf(stderr, "swaywatchd: %s: %s\n", path, strerror(errno));
    }
    return candump_out != NULL;
}

int main(int argc, char **argv)
{
    options_t options = {0};
    if (!read_options(argc, argv, &options)) {
        fputs(usage, stderr);
        return EXIT_USAGE;
    }
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    action.sa_flags = SA_RESTART; // a read that waits for a pipe goes on after these two
    sigaction(SIGUSR1, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
    signal(SIGPIPE, SIG_IGN); // write() says so
    uint8_t block[SWAY_BLOCK_SIZE];
    if ((options.key != NULL && !read_key(options.key)) ||
        (options.map != NULL && !map_file_read(options.map, &map))) {
        return EXIT_FAILURE;
    }
    if (!read_block(&options, block) || !open_output(&options)) {
        return EXIT_FAILURE;
    }
    const int status =
        options.replay != NULL ? run_replay(&options, block) : run_live(&options, block);
    flush_candump();
    if (output_lost > 0U) {
        fprintf(stderr, "swaywatchd: the status frames could not all be written\n");
        return EXIT_FAILURE;
    }
    return status;
}

/* campaign SEED FAULTS TABLE.md: so many faults of bus, sensors, time, power and logs, each in a
 * drive of its own. Of each: it ends, it is reported, the ECU is right again afterwards, and what
 * it says is valid is near the truth. Exit status 1 where one of the first three does not hold. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "candump.h"
#include "fuzz.h"
#include "log_file.h"
#include "port_test.h"
#include "sway_store.h"

#define STEP_US 10000
#define BEGIN_S 3.0
#define AFTER_S 2.5
#define POLLS_MAX 200000
/* Flags that warn of the frequency; the others are of what is identified with it. */
#define OF_THE_LINE                                                                                \
    (SWAY_QUALITY_NO_OSCILLATION | SWAY_QUALITY_FORCED | SWAY_QUALITY_GAP |                        \
     SWAY_QUALITY_SPEED_CHANGING | SWAY_QUALITY_SEEKING | SWAY_QUALITY_MISFIT)

typedef enum {
    LOST,
    DOUBLED,
    FLIPPED,
    LENGTH,
    ORDER,
    SILENT_BUS,
    SILENT_MESSAGE,
    UNKNOWN,
    NO_ROOM,
    SECOND_SENDER,
    REQUESTS,
    NOT_AVAILABLE,
    RANGE,
    FROZEN,
    STUCK,
    CLOCK_AHEAD,
    CLOCK_BACK,
    CLOCK_FAST,
    RESTART,
    STORE_CUT,
    FLASH_BIT,
    LOG_STAMP,
    LOG_LINE,
    CLASSES
} class_t;

static const char *const names[CLASSES] = {
    "frames lost",
    "frames doubled",
    "bits flipped",
    "wrong length",
    "out of order",
    "bus silent",
    "a message silent",
    "frames of others",
    "no room to send",
    "a second sender, 0.4 ms early",
    "parameter requests without a session",
    "value marked not available",
    "value out of range",
    "sensor frozen",
    "counter stuck",
    "stamps jump ahead",
    "stamps jump back",
    "stamps 8 to 20 % fast",
    "fault of the processor, restart",
    "power cut while storing",
    "a bit of the flash flips",
    "a digit of a log's stamp",
    "a damaged line of a log",
};

static struct {
    unsigned long injected, unreported, hung, not_right, values, beyond;
} table[CLASSES];

static uint64_t state;
static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static sway_port_frame_t inbox[32];
static unsigned head;
static unsigned tail;
static int64_t clock_us;
static bool no_room;
static bool hung;
static uint8_t reported_cause;
static bool inputs_lost;
static unsigned access_frames;
static uint8_t page[SWAY_STORE_SLOTS][SWAY_BLOCK_SIZE];
static bool torn[SWAY_STORE_SLOTS];
static int power_left;
static struct swaywatch_dbc_sway_parameter_reply_t reply;

static uint32_t random_number(void)
{
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(state >> 33);
}

static double between(double low, double high)
{
    return low + (high - low) * (double)(random_number() % 100000U) / 1e5;
}

static bool chance(unsigned percent)
{
    return random_number() % 100U < percent;
}

/* --- the ECU and its flash -------------------------------------------------------------------- */

static bool receive(void *context, sway_port_frame_t *frame)
{
    (void)context;
    if (tail == head) {
        return false;
    }
    *frame = inbox[tail++ % 32U];
    return true;
}

static bool send_frame(void *context, const sway_port_frame_t *frame)
{
    (void)context;
    if (no_room) {
        return false;
    }
    if (frame->id == SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID) {
        const uint8_t cause = report_of(frame).fault_cause;
        reported_cause = cause != 0U ? cause : reported_cause;
    } else if (frame->id == SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID) {
        reply = reply_of(frame);
    } else if (frame->id == SWAYWATCH_DBC_SWAY_ALARM_FRAME_ID) {
        inputs_lost = (frame->data[4] & 2U) != 0U;
    } else if (frame->id == SWAYWATCH_DBC_SWAY_ACCESS_FRAME_ID) {
        access_frames++;
    }
    return true;
}

static int64_t time_now(void *context)
{
    (void)context;
    return clock_us;
}

static bool page_read(void *context, uint32_t slot, uint8_t *to, size_t size)
{
    (void)context;
    memcpy(to, page[slot], size);
    return !torn[slot];
}

/* The power goes: what is being erased or written is neither as it was nor done. */
static bool power(uint32_t slot)
{
    if (power_left == 1) {
        torn[slot] = true;
    }
    power_left -= power_left > 0 ? 1 : 0;
    return power_left != 0;
}

static bool page_erase(void *context, uint32_t slot)
{
    (void)context;
    if (power(slot)) {
        memset(page[slot], 0xFF, sizeof page[slot]);
        torn[slot] = false;
    }
    return power_left != 0;
}

static bool page_write(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)context;
    for (size_t i = 0; i < size && (i % 8U != 0U || power(slot)); i++) {
        page[slot][i] &= block[i];
    }
    return power_left != 0;
}

static const sway_store_t flash = {.size = SWAY_BLOCK_SIZE,
                                   .check = sway_block_check,
                                   .read = page_read,
                                   .erase = page_erase,
                                   .write = page_write};

static bool store(void *context, const uint8_t *block, size_t size)
{
    (void)context;
    return sway_store_write(&flash, block, size);
}

static const sway_port_t port = {
    .receive = receive, .send = send_frame, .time_us = time_now, .store = store, .key = test_key};

static bool start(void)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    const bool was_cut = sway_store_find(&flash, block);
    power_left = -1;
    (void)sway_ecu_start(&ecu, &port, &retained, block, sizeof block);
    if (was_cut) {
        sway_ecu_warn(&ecu, SWAY_ECU_STORE_CUT);
    }
    return was_cut;
}

static void deliver(sway_port_frame_t frame)
{
    inbox[head++ % 32U] = frame;
    int polls = 0;
    while (sway_ecu_poll(&ecu) && polls < POLLS_MAX) {
        polls++;
    }
    hung = hung || polls == POLLS_MAX;
}

/* --- a drive with a fault --------------------------------------------------------------------- */

typedef struct {
    class_t class;
    double end_s;
    double frequency_hz;
    double amplitude;
    double decay_1_s;
    double size;
    uint32_t sequence;
    unsigned struck;
    bool has_held;
    sway_port_frame_t held;
    uint8_t frozen[2];
    bool has_frozen;
} drive_t;

static void put16(uint8_t *to, double value)
{
    const int32_t raw = (int32_t)lround(value);
    to[0] = (uint8_t)((uint32_t)raw & 255U);
    to[1] = (uint8_t)((uint32_t)raw >> 8 & 255U);
}

static sway_port_frame_t sensor_frame(const drive_t *d, unsigned which, double t)
{
    sway_port_frame_t frame = {.id = (uint16_t)(0x120U + which), .dlc = 8};
    const double phase = 2.0 * 3.14159265358979 * d->frequency_hz * t;
    const double a = d->amplitude * exp(-d->decay_1_s * t);
    const double noise[2] = {between(-1.0, 1.0), between(-1.0, 1.0)};
    if (which == 0U) {
        put16(frame.data + 2, noise[0]);
    } else if (which == 1U) {
        put16(frame.data + 2, 9000.0);
    } else {
        const double shift = which == 2U ? 0.0 : 0.6;
        const double gain = which == 2U ? 0.5 : 1.0;
        put16(frame.data + 2, 100.0 * gain * a * cos(phase + shift) + noise[0]);
        put16(frame.data + 4, 100.0 * gain * a * sin(phase + shift) + noise[1]);
    }
    return frame;
}

/* False: the frame does not arrive. */
static bool strike(drive_t *d, unsigned which, sway_port_frame_t *frame, uint8_t *counter, double t)
{
    const class_t c = d->class;
    const bool all = c == SILENT_BUS || (c == SILENT_MESSAGE && which == 3U) ||
                     (c == FROZEN && which == 3U) || (c == STUCK && which == 2U) ||
                     (c == SECOND_SENDER && which == 1U);
    const bool some =
        (c <= ORDER || c == UNKNOWN || c == NOT_AVAILABLE) && which > 0U && chance(30);
    if (t < BEGIN_S || t >= d->end_s ||
        !(all || some || (c == RANGE && which == 1U && chance(30)))) {
        sway_e2e_protect(frame->id, *counter, frame->data);
        *counter = sway_e2e_next(*counter);
        return true;
    }
    d->struck++;
    frame->data[1] = c == NOT_AVAILABLE ? 0x50U : 0U;
    if (c == RANGE) {
        put16(frame->data + 2, 60000.0);
    } else if (c == FROZEN) {
        memcpy(d->has_frozen ? frame->data + 2 : d->frozen,
               d->has_frozen ? d->frozen : frame->data + 2, 2);
        d->has_frozen = true;
    }
    sway_e2e_protect(frame->id, *counter, frame->data);
    *counter = c == STUCK ? *counter : sway_e2e_next(*counter);
    frame->data[0] ^= c == FLIPPED ? (uint8_t)(1U << random_number() % 8U) : 0U;
    frame->dlc = c == LENGTH ? (uint8_t)(random_number() % 8U) : 8U;
    frame->id = c == UNKNOWN ? 0x13F : frame->id;
    if (c == DOUBLED || c == SECOND_SENDER) {
        sway_port_frame_t other = *frame;
        other.time_us -= c == SECOND_SENDER ? 400 : 0;
        deliver(other);
    }
    if (c == ORDER && !d->has_held) {
        d->held = *frame;
        d->has_held = true;
        return false;
    }
    return c != LOST && c != SILENT_BUS && c != SILENT_MESSAGE;
}

static void look(drive_t *d, double t)
{
    const sway_status_t *status = sway_core_status(&ecu.node.core);
    if (status->sequence == d->sequence || ecu.state != SWAY_ECU_RUNNING || t < 2.0) {
        return;
    }
    d->sequence = status->sequence;
    if ((status->valid & SWAY_VALID_LINE) != 0U && (status->quality & OF_THE_LINE) == 0U) {
        const double error = fabs(status->frequency_uhz * 1e-6 - d->frequency_hz);
        table[d->class].values++;
        table[d->class].beyond += error > 5e-6 * status->frequency_se_uhz;
    }
}

static int64_t stamp(const drive_t *d, double t)
{
    double shifted = t;
    if (t >= BEGIN_S) {
        shifted += d->class == CLOCK_AHEAD ? d->size : (d->class == CLOCK_BACK ? -d->size : 0.0);
        shifted += d->class == CLOCK_FAST ? d->size * (fmin(t, d->end_s) - BEGIN_S) : 0.0;
    }
    return INT64_C(1000000000) + (int64_t)llround(shifted * 1e6);
}

static void drive(drive_t *d)
{
    static uint8_t counter[4];
    const int steps = (int)((d->end_s + AFTER_S) * 1e6 / STEP_US);
    for (int step = 0; step < steps; step++) {
        const double t = step * 1e-6 * STEP_US;
        const bool is_on = t >= BEGIN_S && t < d->end_s;
        no_room = d->class == NO_ROOM && is_on;
        for (unsigned which = 0; which < 4U; which++) {
            sway_port_frame_t frame = sensor_frame(d, which, t);
            frame.time_us = stamp(d, t) + (int64_t)which * 500;
            clock_us = frame.time_us;
            if (strike(d, which, &frame, &counter[which], t)) {
                deliver(frame);
            }
            if (d->has_held && frame.time_us > d->held.time_us + 12000) {
                d->has_held = false;
                d->held.time_us = frame.time_us + 100;
                deliver(d->held);
            }
        }
        if (d->class == REQUESTS && is_on && chance(30)) {
            sway_port_frame_t frame = request_frame((uint8_t)(1U + random_number() % 4U),
                                                    (uint16_t)(random_number() % SWAY_BLOCK_WORDS),
                                                    (int32_t)random_number());
            frame.time_us = stamp(d, t) + 3000;
            d->struck++;
            deliver(frame);
        }
        if (d->class == RESTART && t >= BEGIN_S && d->struck == 0U) {
            d->struck = 1;
            sway_ecu_note_fault(&retained, 3U + random_number() % 4U, random_number());
            (void)start();
        }
        look(d, t);
    }
}

static unsigned long all_faults(void)
{
    const sway_status_t *status = sway_core_status(&ecu.node.core);
    unsigned long sum = 0;
    for (int i = 0; i < SWAY_FRAME_FAULT_COUNT; i++) {
        sum += sway_node_fault(&ecu.node, (sway_frame_fault_t)i);
    }
    for (int i = 0; i < SWAY_FAULT_COUNT; i++) {
        sum += i == SWAY_FAULT_SINGULAR ? 0U : status->fault_count[i];
    }
    return sum;
}

/* Counted exactly where the fault has a counter of its own. */
static bool is_reported(const drive_t *d)
{
    const sway_status_t *status = sway_core_status(&ecu.node.core);
    const struct {
        class_t class;
        unsigned long count;
    } exact[] = {
        {DOUBLED, sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_REPEATED)},
        {SECOND_SENDER, sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_REPEATED)},
        {FLIPPED, sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_CRC)},
        {LENGTH, sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_LENGTH)},
        {UNKNOWN, sway_node_fault(&ecu.node, SWAY_FRAME_FAULT_UNKNOWN)},
        {RANGE, status->fault_count[SWAY_FAULT_RANGE]},
        {REQUESTS, ecu.requests_refused},
    };
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++) {
        if (exact[i].class == d->class) {
            return exact[i].count == d->struck &&
                   (d->class != REQUESTS || d->struck == 0U || access_frames > 0U) &&
                   (d->class != SECOND_SENDER || d->struck < 20U ||
                    reported_cause == SWAY_ECU_DOUBLED);
        }
    }
    if (d->class == NO_ROOM) {
        return ecu.frames_received == 4U * (unsigned long)((d->end_s + AFTER_S) * 1e6 / STEP_US);
    }
    if (d->class == RESTART) {
        return reported_cause == retained.cause;
    }
    return d->struck > 0U || d->class >= CLOCK_AHEAD ? all_faults() > 0U : true;
}

static void drive_trial(class_t class)
{
    drive_t d = {.class = class,
                 .end_s = BEGIN_S + between(0.1, 1.2),
                 .frequency_hz = between(0.5, 1.1),
                 .amplitude = between(3.0, 9.0),
                 .decay_1_s = between(-0.05, 0.2),
                 .size = class == CLOCK_FAST ? between(0.08, 0.2) : between(0.05, 5.0)};
    if (class == FROZEN) { // reported once the yaw rates have moved by 20 deg/s
        d.end_s += 3.0;
        d.amplitude = between(9.0, 12.0);
        d.decay_1_s = 0.0;
    } else if (class == CLOCK_FAST) {
        d.end_s += 1.5;
    } else if (class == CLOCK_BACK) { // time stands until it is where it was
        d.size = between(0.05, 2.0);
    }
    (void)start();
    drive(&d);
    table[class].unreported += !is_reported(&d);
    table[class].not_right += ecu.state != SWAY_ECU_RUNNING || inputs_lost;
}

/* --- power ------------------------------------------------------------------------------------ */

static void stand(void)
{
    static uint8_t counter;
    for (int i = 0; i < 30; i++) {
        sway_port_frame_t frame = {.id = 0x121, .dlc = 8};
        sway_e2e_protect(frame.id, counter, frame.data);
        counter = sway_e2e_next(counter);
        clock_us += STEP_US;
        frame.time_us = clock_us;
        deliver(frame);
    }
}

static void say(sway_port_frame_t frame)
{
    clock_us += 1000;
    frame.time_us = clock_us;
    deliver(frame);
}

static void power_trial(class_t class)
{
    int32_t mass_g = 1955000;
    bool was_cut = false;
    (void)start();
    for (int round = 0; round < 2; round++) {
        const int32_t wanted_g = 1700000 + (int32_t)(random_number() % 500000U);
        uint8_t block[SWAY_BLOCK_SIZE];
        stand();
        say(request_frame(OPEN, 0, 0));
        const struct swaywatch_dbc_sway_parameter_reply_t opened = reply;
        say(request_frame(WRITE, 0, wanted_g));
        sway_block_write(&ecu.staged, ecu.block_sequence + 1U, block);
        power_left = class == STORE_CUT ? 1 + (int)(random_number() % 40U) : -1;
        say(proof_frame(STORE, test_key, opened, block));
        const bool is_stored = reply.parameter_result == DONE;
        mass_g = is_stored ? wanted_g : mass_g;
        if (class == FLASH_BIT) {
            page[random_number() % 2U][random_number() % SWAY_BLOCK_SIZE] ^=
                (uint8_t)(1U << random_number() % 8U);
        }
        was_cut = start();
        const int32_t now_g = sway_ecu_config(&ecu)->vehicle.car.mass_g;
        if (class == STORE_CUT) {
            table[class].not_right += ecu.state != SWAY_ECU_RUNNING || now_g != mass_g;
            table[class].unreported += !is_stored && !was_cut;
        } else {
            /* One of two blocks is damaged: that is reported, and the other one is used. */
            const bool old_one = now_g != mass_g;
            table[class].not_right += ecu.state != SWAY_ECU_RUNNING;
            table[class].unreported += !was_cut;
            mass_g = now_g;
            (void)old_one;
            return;
        }
    }
}

/* --- logs ------------------------------------------------------------------------------------- */

#define LINES 400

static void log_trial(class_t class)
{
    char path[64];
    char text[LINES][CANDUMP_LINE];
    const int fd = memfd_create("log", 0);
    const unsigned victim = 1U + random_number() % (LINES - 2U);
    log_file_t log;
    sway_port_frame_t frame = {.id = 0x121, .dlc = 8};
    for (unsigned i = 0; i < LINES; i++) {
        frame.time_us = INT64_C(1700000000000000) + (int64_t)i * 2500;
        (void)candump_format(&frame, text[i]);
    }
    char *line = text[victim];
    if (class == LOG_STAMP) {
        const size_t at = 1U + random_number() % 13U; // down to hundredths of a second
        const char before = line[at == 11U ? 10 : at];
        char *digit = &line[at == 11U ? 10 : at];
        *digit = (char)('0' + (before - '0' + 1 + (int)(random_number() % 9U)) % 10);
    } else {
        line[random_number() % 18U] = (char)(1 + (int)(random_number() % 9U));
    }
    for (unsigned i = 0; i < LINES; i++) {
        require(write(fd, text[i], strlen(text[i])) > 0);
    }
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    require(log_file_open(&log, path));
    unsigned frames = 0;
    int64_t last_us = 0;
    while (log_file_next(&log, &frame)) {
        last_us = frame.time_us;
        frames++;
    }
    const bool is_reported = class == LOG_STAMP
                                 ? log.stamps_damaged + log.clock_set > 0U || log.most_back_us > 0
                                 : log.unreadable == 1U;
    const int64_t end_us = INT64_C(1700000000000000) + (LINES - 1) * 2500;
    table[class].unreported += !is_reported;
    table[class].not_right +=
        frames != LINES - (class == LOG_LINE ? 1U : 0U) || llabs(last_us - end_us) > 25000;
    (void)log_file_close(&log);
    close(fd);
}

/* --- all of it -------------------------------------------------------------------------------- */

static void trial(class_t class)
{
    const sway_core_config_t config = good_config();
    memset(&retained, 0, sizeof retained);
    memset(torn, 0, sizeof torn);
    memset(&ecu, 0, sizeof ecu);
    sway_block_write(&config, 1, page[0]);
    sway_block_write(&config, 2, page[1]);
    power_left = -1;
    clock_us = 1000000000;
    head = tail = access_frames = 0U;
    no_room = hung = inputs_lost = false;
    reported_cause = 0;
    if (class >= LOG_STAMP) {
        log_trial(class);
    } else if (class >= STORE_CUT) {
        power_trial(class);
    } else {
        drive_trial(class);
    }
    table[class].injected++;
    table[class].hung += hung;
}

int main(int argc, char **argv)
{
    const unsigned long seed = argc > 1 ? strtoul(argv[1], NULL, 10) : 1U;
    const unsigned long faults = argc > 2 ? strtoul(argv[2], NULL, 10) : 230U;
    FILE *out = argc > 3 ? fopen(argv[3], "w") : stdout;
    unsigned long bad = 0;
    if (out == NULL || freopen("/dev/null", "w", stderr) == NULL) {
        return 2;
    }
    for (unsigned long i = 0; i < faults; i++) {
        state = seed * 1000003U + i;
        (void)random_number();
        trial((class_t)(i % CLASSES));
    }
    fprintf(
        out,
        "**`make fault-campaign`**: %lu faults, seed %lu, one in each drive\n\n"
        "| fault | injected | hung | not reported | not right again | values marked valid, without "
        "flags | beyond 5 standard errors |\n|---|---|---|---|---|---|---|\n",
        faults, seed);
    for (int c = 0; c < CLASSES; c++) {
        fprintf(out, "| %s | %lu | %lu | %lu | %lu | %lu | %lu |\n", names[c], table[c].injected,
                table[c].hung, table[c].unreported, table[c].not_right, table[c].values,
                table[c].beyond);
        bad += table[c].hung + table[c].unreported + table[c].not_right;
    }
    if (out != stdout) {
        fclose(out);
    }
    printf("fault campaign: %lu faults, seed %lu, %lu hung, unreported or not right again\n",
           faults, seed, bad);
    return bad == 0U ? 0 : 1;
}

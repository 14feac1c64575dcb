#include "log_file.h"

#include <linux/can.h>
#include <stdlib.h>
#include <string.h>

#include "candump.h"

bool log_file_open(log_file_t *log, const char *path)
{
    memset(log, 0, sizeof *log);
    log->path = path;
    log->file = strcmp(path, "-") == 0 ? stdin : fopen(path, "r");
    log->last_us = INT64_MIN;
    return log->file != NULL;
}

static void show_unreadable(log_file_t *log)
{
    log->unreadable++;
    if (log->unreadable > 1U) {
        return;
    }
    char text[64];
    size_t n = 0;
    for (const char *c = log->line; *c != '\0' && *c != '\n' && n + 1 < sizeof text; c++) {
        text[n++] = *c >= ' ' && *c <= '~' ? *c : '?';
    }
    text[n] = '\0';
    fprintf(stderr,
            "swaywatchd: %s:%llu: not a line of a candump log: \"%s\"; expected "
            "\"(1700000000.123456) can0 120#0011223344556677\"\n",
            log->path, (unsigned long long)log->lines, text);
}

/* Counts a line that has the form of a frame which is not for us; false: it has not. */
static bool is_foreign(log_file_t *log)
{
    char id[9] = "";
    char hash = '\0';
    char first = '\0';
    const int found =
        sscanf(log->line, "(%*[0-9].%*[0-9]) %*15s %8[0-9A-Fa-f]%c%c", id, &hash, &first);
    if (found < 3 || hash != '#') {
        return false;
    }
    const bool is_long = strlen(id) == 8U;
    if (is_long && (strtoul(id, NULL, 16) & CAN_ERR_FLAG) != 0U) {
        log->error_frames++;
        return true;
    }
    const bool is_other = is_long || (strlen(id) == 3U && (first == 'R' || first == '#'));
    log->foreign += is_other ? 1U : 0U;
    return is_other;
}

/* What a line is that candump_parse() has refused. */
static void classify(log_file_t *log)
{
    static const char lost[] = "DROPCOUNT: dropped ";
    if (strncmp(log->line, lost, sizeof lost - 1U) == 0) {
        log->dropped += strtoull(log->line + sizeof lost - 1U, NULL, 10);
    } else if (log->line[strspn(log->line, " \t\r\n")] != '\0' && !is_foreign(log)) {
        show_unreadable(log);
    }
}

/* A line of any length and any bytes; of one that is too long only the start is kept. */
static bool read_line(log_file_t *log)
{
    size_t count = 0;
    int c = getc(log->file);
    if (c == EOF) {
        return false;
    }
    for (; c != EOF && c != '\n'; c = getc(log->file)) {
        if (log->wants_end != NULL && *log->wants_end != 0) {
            return false;
        }
        if (count + 1U < sizeof log->line) {
            log->line[count++] = c == '\0' ? '?' : (char)c;
        }
    }
    log->line[count] = '\0';
    log->lines++;
    return true;
}

/* The next frame with the stamp that the log has for it. */
static bool read_frame(log_file_t *log, sway_port_frame_t *frame)
{
    while ((log->wants_end == NULL || *log->wants_end == 0) && read_line(log)) {
        if (candump_parse(log->line, frame)) {
            log->frames++;
            return true;
        }
        classify(log);
    }
    return false;
}

static void tell(const log_file_t *log, uint64_t count, const char *what, int64_t by_us)
{
    if (count == 1U) {
        fprintf(stderr, "swaywatchd: %s: near line %llu: %s by %.3f s\n", log->path,
                (unsigned long long)log->lines, what, (double)by_us / 1e6);
    }
}

/* Before the first frame there is no order yet. */
static bool is_behind(const log_file_t *log, int64_t time_us)
{
    return log->last_us != INT64_MIN && time_us < log->last_us - LOG_FILE_ORDER_US;
}

/* A stamp that the one after it takes back is damaged, whether it is ahead or behind; where the
 * ones after it agree that it is earlier, the clock was set. */
static void judge_stamp(log_file_t *log, sway_port_frame_t *frame, const sway_port_frame_t *next)
{
    const int64_t next_us = next != NULL ? next->time_us + log->shift_us : INT64_MAX;
    const bool is_ahead =
        next != NULL && frame->time_us > next_us + LOG_FILE_ORDER_US && !is_behind(log, next_us);
    const bool is_late = is_behind(log, frame->time_us);
    const int64_t back_us = is_late ? log->last_us - frame->time_us : 0;
    if (is_ahead || (is_late && next_us >= log->last_us)) {
        log->stamps_damaged++;
        tell(log, log->stamps_damaged, "a time stamp is off",
             is_ahead ? frame->time_us - next_us : back_us);
        frame->time_us = log->last_us != INT64_MIN ? log->last_us : next_us;
    } else if (is_late) {
        log->clock_set++;
        tell(log, log->clock_set, "the logger's clock was set back", back_us);
        log->shift_us += back_us;
        frame->time_us = log->last_us;
    }
}

static void keep_order(log_file_t *log, sway_port_frame_t *frame)
{
    if (frame->time_us < log->last_us) {
        const int64_t back_us = log->last_us - frame->time_us;
        log->clock_back++;
        log->most_back_us = back_us > log->most_back_us ? back_us : log->most_back_us;
        frame->time_us = log->last_us;
    }
    log->last_us = frame->time_us;
}

bool log_file_next(log_file_t *log, sway_port_frame_t *frame)
{
    if (!log->holds) {
        log->holds = read_frame(log, &log->held);
    }
    if (!log->holds) {
        return false;
    }
    *frame = log->held;
    log->holds = read_frame(log, &log->held);
    frame->time_us += log->shift_us;
    judge_stamp(log, frame, log->holds ? &log->held : NULL);
    keep_order(log, frame);
    return true;
}

int64_t log_file_time_us(log_file_t *log)
{
    if (log->frames == 0U) {
        log->holds = read_frame(log, &log->held);
        return log->holds ? log->held.time_us : 0;
    }
    return log->last_us != INT64_MIN ? log->last_us : log->held.time_us;
}

bool log_file_close(log_file_t *log)
{
    const bool is_read = ferror(log->file) == 0;
    if (log->file != stdin) {
        fclose(log->file);
    }
    return is_read;
}

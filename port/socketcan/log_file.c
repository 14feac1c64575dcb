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
    unsigned long dropped = 0;
    if (sscanf(log->line, "DROPCOUNT: dropped %lu", &dropped) == 1) {
        log->dropped += dropped;
    } else if (log->line[strspn(log->line, " \t\r\n")] != '\0' && !is_foreign(log)) {
        show_unreadable(log);
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

static bool read_frame(log_file_t *log, sway_port_frame_t *frame)
{
    while (getline(&log->line, &log->room, log->file) >= 0) {
        log->lines++;
        if (candump_parse(log->line, frame)) {
            log->frames++;
            keep_order(log, frame);
            return true;
        }
        classify(log);
    }
    return false;
}

bool log_file_next(log_file_t *log, sway_port_frame_t *frame)
{
    if (log->holds) {
        log->holds = false;
        *frame = log->held;
        return true;
    }
    return read_frame(log, frame);
}

int64_t log_file_time_us(log_file_t *log)
{
    if (log->frames == 0U) {
        log->holds = read_frame(log, &log->held);
    }
    return log->frames > 0U ? log->last_us : 0;
}

bool log_file_close(log_file_t *log)
{
    const bool is_read = ferror(log->file) == 0;
    free(log->line);
    log->line = NULL;
    if (log->file != stdin) {
        fclose(log->file);
    }
    return is_read;
}

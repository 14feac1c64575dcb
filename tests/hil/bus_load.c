/* bus_load INTERFACE RATE SECONDS OUTPUT: loads a bus with frames of swaywatch.dbc.
 *
 * Sends all input messages in turn, RATE frames a second by absolute deadlines (0: as fast as the
 * kernel takes them), with right CRCs and counters. Meanwhile writes every status frame that it
 * sees to OUTPUT: kernel stamp in microseconds of CLOCK_MONOTONIC, identifier, data. At the end
 * prints what was sent, how late the worst frame was, and the retries. */
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <math.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "bus/sway_e2e.h"
#include "bus/sway_frames.h"

static int64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static int open_bus(const char *name, const struct can_filter *filter)
{
    const int on = 1;
    const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    const struct sockaddr_can address = {.can_family = AF_CAN,
                                         .can_ifindex = (int)if_nametoindex(name)};
    if (fd < 0 || setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filter, filter != NULL ? sizeof *filter : 0) !=
            0 ||
        bind(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        perror(name);
        exit(1);
    }
    return fd;
}

/* A swing of 0.67 Hz at 90 km/h, so that the core has its full work. */
static void fill(uint8_t *data, sway_message_t message, double t)
{
    const double wave = sin(2.0 * M_PI * 0.67 * t);
    const int first = message == SWAY_MESSAGE_SPEED
                          ? 9000
                          : (int)lround(wave * (message < SWAY_MESSAGE_HITCH_FORCES ? 500 : 3000));
    const int second = message < SWAY_MESSAGE_CAR_WHEEL_FL ? first / 2 : 5000;
    memset(data, 0, 8);
    data[2] = (uint8_t)first;
    data[3] = (uint8_t)((unsigned)first >> 8);
    data[4] = (uint8_t)second;
    data[5] = (uint8_t)((unsigned)second >> 8);
}

/* From the clock of day, which the kernel stamps by, to CLOCK_MONOTONIC: the reading that was
 * disturbed least. */
static int64_t compare_clocks(void)
{
    int64_t shift = 0;
    int64_t best = INT64_MAX;
    for (int i = 0; i < 50; i++) {
        const int64_t before = clock_ns(CLOCK_MONOTONIC);
        const int64_t day = clock_ns(CLOCK_REALTIME);
        const int64_t after = clock_ns(CLOCK_MONOTONIC);
        if (after - before < best) {
            best = after - before;
            shift = before + best / 2 - day;
        }
    }
    return shift;
}

static void read_status(int fd, FILE *output, int64_t shift)
{
    for (;;) {
        struct can_frame frame;
        union {
            char bytes[CMSG_SPACE(sizeof(struct timespec))];
            struct cmsghdr alignment;
        } control;
        struct iovec part = {&frame, sizeof frame};
        struct msghdr message = {.msg_iov = &part,
                                 .msg_iovlen = 1,
                                 .msg_control = control.bytes,
                                 .msg_controllen = sizeof control.bytes};
        if (recvmsg(fd, &message, MSG_DONTWAIT) != (ssize_t)sizeof frame) {
            return;
        }
        struct timespec t = {0, 0};
        const struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        if (c != NULL && c->cmsg_type == SO_TIMESTAMPNS) {
            memcpy(&t, CMSG_DATA(c), sizeof t);
        }
        const int64_t stamp = (int64_t)t.tv_sec * 1000000000 + t.tv_nsec + shift;
        fprintf(output, "%lld %03X ", (long long)(stamp / 1000), frame.can_id);
        for (int i = 0; i < frame.can_dlc; i++) {
            fprintf(output, "%02X", frame.data[i]);
        }
        fputc('\n', output);
    }
}

int main(int argc, char **argv)
{
    if (argc != 5) {
        fprintf(stderr, "usage: bus_load INTERFACE RATE SECONDS OUTPUT\n");
        return 2;
    }
    const struct can_filter status = {.can_id = 0x180, .can_mask = 0x780};
    const int out = open_bus(argv[1], NULL);
    const int in = open_bus(argv[1], &status);
    const double rate = atof(argv[2]);
    const double seconds = atof(argv[3]);
    FILE *output = fopen(argv[4], "w");
    uint8_t counter[SWAY_MESSAGE_COUNT] = {0};
    const int64_t shift = compare_clocks();
    const int64_t begin = clock_ns(CLOCK_MONOTONIC);
    int64_t worst = 0;
    long sent = 0;
    long retries = 0;
    while (output != NULL) {
        const int64_t due = rate > 0.0 ? begin + (int64_t)((double)sent * 1e9 / rate) : 0;
        int64_t now = clock_ns(CLOCK_MONOTONIC);
        if ((double)(now - begin) > seconds * 1e9 || (double)(due - begin) > seconds * 1e9) {
            break;
        }
        if (now < due) {
            const struct timespec t = {due / 1000000000, due % 1000000000};
            read_status(in, output, shift);
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
            now = clock_ns(CLOCK_MONOTONIC);
        }
        worst = rate > 0.0 && now - due > worst ? now - due : worst;
        const sway_message_t m = (sway_message_t)(sent % SWAY_MESSAGE_COUNT);
        struct can_frame frame = {.can_id = sway_frames_input_id(m), .can_dlc = 8};
        fill(frame.data, m, (double)(now - begin) * 1e-9);
        sway_e2e_protect(frame.can_id, counter[m], frame.data);
        while (write(out, &frame, sizeof frame) != (ssize_t)sizeof frame) {
            if (errno != ENOBUFS) {
                perror("write");
                return 1;
            }
            retries++;
            usleep(200);
        }
        counter[m] = sway_e2e_next(counter[m]);
        sent++;
    }
    usleep(300000);
    read_status(in, output, shift);
    const double took = (double)(clock_ns(CLOCK_MONOTONIC) - begin) * 1e-9 - 0.3;
    printf("{\"sent\": %ld, \"worst_late_us\": %lld, \"retries\": %ld, \"seconds\": %.3f}\n", sent,
           (long long)(worst / 1000), retries, took);
    return output == NULL || fclose(output) != 0;
}

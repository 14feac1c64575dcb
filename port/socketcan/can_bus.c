#include "can_bus.h"

#include <errno.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define RECEIVE_BUFFER (8 * 1024 * 1024)
#define LOOK_EVERY_US 50000
#define CLOCK_READINGS 50
#define CLOCK_SET_US 1000
#define CLOCK_STEP_US 20000 // less is a clock that is being adjusted

static int64_t clock_us(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

int64_t can_bus_time_us(void)
{
    return clock_us(CLOCK_MONOTONIC);
}

const char *can_bus_class_name(can_bus_class_t class)
{
    static const char *const names[CAN_BUS_CLASSES] = {
        "tx-timeout", "arbitration-lost", "controller", "protocol",  "transceiver",
        "no-ack",     "bus-off",          "bus-error",  "restarted", "error-counters"};
    return names[class];
}

/* The kernel stamps by the clock of day, which may be set at any time. Between such settings the
 * clocks differ by a constant; a reading of the two that was interrupted tells nothing. */
static void compare_clocks(can_bus_t *bus)
{
    const int64_t before_us = can_bus_time_us();
    const int64_t day_us = clock_us(CLOCK_REALTIME);
    const int64_t took_us = can_bus_time_us() - before_us;
    const int64_t shift_us = before_us + took_us / 2 - day_us;
    const int64_t change_us = shift_us - bus->to_monotonic_us;
    const bool is_better = took_us < bus->reading_us;
    const bool is_set = change_us > CLOCK_SET_US + took_us || change_us < -CLOCK_SET_US - took_us;
    if (is_set && bus->drained_us != 0 &&
        (change_us > CLOCK_STEP_US || change_us < -CLOCK_STEP_US)) {
        bus->counts.clock_set++;
        bus->before_set_us = bus->to_monotonic_us;
        fprintf(stderr, "swaywatchd: the clock of day was set by %.3f s\n",
                (double)-change_us / 1e6);
    }
    if (is_better || is_set) {
        bus->to_monotonic_us = shift_us;
        bus->reading_us = took_us;
    }
}

/* A frame came after the bus was last found empty and before it is read. A stamp that says
 * otherwise was made by a clock that has been set since, or before; where neither fits, the time
 * of reading is near enough. */
static int64_t place(can_bus_t *bus, int64_t day_us, int64_t now_us)
{
    const int64_t shift_us[2] = {bus->to_monotonic_us, bus->before_set_us};
    for (unsigned i = 0; i < 2U; i++) {
        const int64_t stamp_us = day_us + shift_us[i];
        if (stamp_us >= bus->drained_us - CLOCK_SET_US && stamp_us <= now_us + CLOCK_SET_US) {
            return stamp_us;
        }
    }
    bus->counts.stamped_here++;
    return now_us;
}

/* --- opening -----------------------------------------------------------------------------------
 */

static bool set_options(int fd)
{
    const int on = 1;
    const int room = RECEIVE_BUFFER;
    const can_err_mask_t errors = CAN_ERR_MASK;
    /* More room needs a privilege; without it the kernel's own limit has to do. */
    if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0) {
        (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    }
    return setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) == 0 &&
           setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0 &&
           setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0;
}

static bool attach(can_bus_t *bus)
{
    const unsigned index = if_nametoindex(bus->name);
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (fd < 0) {
        return false;
    }
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)index};
    if (index == 0U || !set_options(fd) ||
        bind(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        const int reason = index == 0U ? ENODEV : errno;
        close(fd);
        errno = reason;
        return false;
    }
    bus->socket = fd;
    bus->overflow = 0;
    return true;
}

static bool is_up(const can_bus_t *bus)
{
    struct ifreq request = {0};
    memcpy(request.ifr_name, bus->name, strnlen(bus->name, IFNAMSIZ - 1));
    return ioctl(bus->socket, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

bool can_bus_open(can_bus_t *bus, const char *name)
{
    memset(bus, 0, sizeof *bus);
    bus->name = name;
    bus->socket = -1;
    bus->reading_us = INT64_MAX / 4;
    for (int i = 0; i < CLOCK_READINGS; i++) {
        compare_clocks(bus);
    }
    bus->before_set_us = bus->to_monotonic_us;
    if (!attach(bus)) {
        return false;
    }
    bus->link = is_up(bus) ? CAN_BUS_UP : CAN_BUS_DOWN;
    if (bus->link == CAN_BUS_DOWN) {
        fprintf(stderr, "swaywatchd: %s: is down; waiting for it\n", name);
    }
    return true;
}

void can_bus_close(can_bus_t *bus)
{
    if (bus->socket >= 0) {
        close(bus->socket);
    }
    bus->socket = -1;
}

/* --- the interface goes and comes --------------------------------------------------------------
 */

/* What waits to be sent would be old news by the time the bus is back. */
static void drop_queue(can_bus_t *bus)
{
    bus->counts.send_lost += bus->queue_length;
    bus->queue_length = 0;
}

static void went_down(can_bus_t *bus, int reason)
{
    if (reason == ENODEV || reason == ENXIO) {
        can_bus_close(bus);
    }
    if (bus->link == CAN_BUS_UP) {
        bus->link = CAN_BUS_DOWN;
        bus->counts.downs++;
        fprintf(stderr, "swaywatchd: %s: %s\n", bus->name,
                bus->socket < 0 ? "interface is gone; waiting for it" : "interface is down");
    }
    drop_queue(bus);
}

static void came_up(can_bus_t *bus)
{
    if (bus->link == CAN_BUS_DOWN) {
        bus->link = CAN_BUS_UP;
        fprintf(stderr, "swaywatchd: %s: interface is up\n", bus->name);
    }
}

/* True where the name now means another device than the one we are bound to, or none. */
static bool is_replaced(const can_bus_t *bus)
{
    struct sockaddr_can address;
    socklen_t size = sizeof address;
    return getsockname(bus->socket, (struct sockaddr *)&address, &size) != 0 ||
           (unsigned)address.can_ifindex != if_nametoindex(bus->name);
}

static void look(can_bus_t *bus)
{
    const int64_t now_us = can_bus_time_us();
    if (bus->link == CAN_BUS_UP || now_us < bus->look_us) {
        return;
    }
    bus->look_us = now_us + LOOK_EVERY_US;
    if (bus->socket >= 0 && is_replaced(bus)) {
        can_bus_close(bus);
    }
    if ((bus->socket >= 0 || attach(bus)) && is_up(bus)) {
        came_up(bus);
    }
}

/* --- receiving ---------------------------------------------------------------------------------
 */

static void note_error(can_bus_t *bus, const struct can_frame *frame)
{
    bus->counts.error_frames++;
    for (unsigned i = 0; i < CAN_BUS_CLASSES; i++) {
        if ((frame->can_id & (1U << i)) != 0U) {
            bus->counts.error_class[i]++;
        }
    }
    if ((frame->can_id & CAN_ERR_BUSOFF) != 0U) {
        fprintf(stderr, "swaywatchd: %s: bus-off\n", bus->name);
        drop_queue(bus);
    }
    if ((frame->can_id & CAN_ERR_RESTARTED) != 0U) {
        fprintf(stderr, "swaywatchd: %s: controller restarted\n", bus->name);
    }
}

static void note_overflow(can_bus_t *bus, uint32_t overflow)
{
    if (overflow != bus->overflow) {
        const uint32_t lost = overflow - bus->overflow;
        fprintf(stderr, "swaywatchd: %s: the kernel dropped %u frames\n", bus->name, lost);
        bus->counts.kernel_lost += lost;
        bus->overflow = overflow;
    }
}

static int64_t read_control(can_bus_t *bus, struct msghdr *message, int64_t now_us)
{
    int64_t stamp_us = now_us;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c != NULL; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level != SOL_SOCKET) {
            continue;
        }
        if (c->cmsg_type == SO_TIMESTAMPNS) {
            struct timespec t;
            memcpy(&t, CMSG_DATA(c), sizeof t);
            stamp_us = place(bus, (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000, now_us);
        } else if (c->cmsg_type == SO_RXQ_OVFL) {
            uint32_t overflow;
            memcpy(&overflow, CMSG_DATA(c), sizeof overflow);
            note_overflow(bus, overflow);
        }
    }
    return stamp_us;
}

static void read_batch(can_bus_t *bus)
{
    union {
        char bytes[CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(uint32_t))];
        struct cmsghdr alignment;
    } control[CAN_BUS_BATCH];
    struct iovec part[CAN_BUS_BATCH];
    struct mmsghdr messages[CAN_BUS_BATCH];
    memset(messages, 0, sizeof messages);
    for (unsigned i = 0; i < CAN_BUS_BATCH; i++) {
        part[i] = (struct iovec){&bus->batch[i], sizeof bus->batch[i]};
        messages[i].msg_hdr.msg_iov = &part[i];
        messages[i].msg_hdr.msg_iovlen = 1;
        messages[i].msg_hdr.msg_control = control[i].bytes;
        messages[i].msg_hdr.msg_controllen = sizeof control[i].bytes;
    }
    const int64_t asked_us = can_bus_time_us();
    const int count = recvmmsg(bus->socket, messages, CAN_BUS_BATCH, MSG_DONTWAIT, NULL);
    bus->batch_at = 0;
    bus->batch_end = count > 0 ? (unsigned)count : 0U;
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
        went_down(bus, errno);
    }
    compare_clocks(bus);
    const int64_t now_us = can_bus_time_us();
    for (unsigned i = 0; i < bus->batch_end; i++) {
        bus->batch_us[i] = read_control(bus, &messages[i].msg_hdr, now_us);
    }
    bus->drained_us = bus->batch_end < CAN_BUS_BATCH ? asked_us : bus->drained_us;
    if (bus->batch_end > 0U) {
        came_up(bus);
    }
}

static void give(can_bus_t *bus, const struct can_frame *from, int64_t stamp_us,
                 sway_port_frame_t *to)
{
    if (stamp_us < bus->last_us) {
        bus->counts.clock_back++;
        stamp_us = bus->last_us;
    }
    bus->last_us = stamp_us;
    bus->counts.received++;
    to->time_us = stamp_us;
    to->id = (uint16_t)(from->can_id & CAN_SFF_MASK);
    to->dlc = from->can_dlc;
    memcpy(to->data, from->data, sizeof to->data);
}

bool can_bus_receive(can_bus_t *bus, sway_port_frame_t *frame)
{
    for (;;) {
        if (bus->batch_at == bus->batch_end) {
            if (bus->socket < 0) {
                return false;
            }
            read_batch(bus);
            if (bus->batch_end == 0U) {
                return false;
            }
        }
        const struct can_frame *next = &bus->batch[bus->batch_at];
        const int64_t stamp_us = bus->batch_us[bus->batch_at];
        bus->batch_at++;
        if ((next->can_id & CAN_ERR_FLAG) != 0U) {
            note_error(bus, next);
        } else if ((next->can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) != 0U) {
            bus->counts.foreign++;
        } else {
            give(bus, next, stamp_us, frame);
            return true;
        }
    }
}

/* --- sending -----------------------------------------------------------------------------------
 */

void can_bus_send(can_bus_t *bus, const sway_port_frame_t *frame)
{
    if (bus->link == CAN_BUS_DOWN) {
        bus->counts.send_lost++;
        return;
    }
    if (bus->queue_length == CAN_BUS_QUEUE) {
        bus->queue_at = (bus->queue_at + 1U) % CAN_BUS_QUEUE;
        bus->queue_length--;
        bus->counts.send_lost++;
    }
    bus->queue[(bus->queue_at + bus->queue_length) % CAN_BUS_QUEUE] = *frame;
    bus->queue_length++;
}

static bool write_frame(can_bus_t *bus, const sway_port_frame_t *frame)
{
    struct can_frame raw = {.can_id = frame->id, .can_dlc = frame->dlc};
    memcpy(raw.data, frame->data, sizeof raw.data);
    if (write(bus->socket, &raw, sizeof raw) == (ssize_t)sizeof raw) {
        bus->counts.sent++;
        return true;
    }
    if (errno == ENOBUFS || errno == EAGAIN || errno == EINTR) {
        bus->counts.send_retries++;
        bus->queue_waits = true;
    } else {
        went_down(bus, errno);
    }
    return false;
}

void can_bus_work(can_bus_t *bus)
{
    look(bus);
    bus->queue_waits = false;
    while (bus->queue_length > 0U && bus->socket >= 0 &&
           write_frame(bus, &bus->queue[bus->queue_at])) {
        bus->queue_at = (bus->queue_at + 1U) % CAN_BUS_QUEUE;
        bus->queue_length--;
    }
}

/* The replay program for a machine with an operating system: x86-64, or big-endian MIPS under
 * qemu-user. */
#include <fcntl.h>
#include <unistd.h>

#include "replay.h"

static int32_t machine_open(const char *path, bool write_it)
{
    return write_it ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666) : open(path, O_RDONLY);
}

static size_t machine_read(int32_t file, void *bytes, size_t size)
{
    const ssize_t count = read(file, bytes, size);
    return count > 0 ? (size_t)count : 0U;
}

static bool machine_write(int32_t file, const void *bytes, size_t size)
{
    return write(file, bytes, size) == (ssize_t)size;
}

static sway_ecu_cause_t check(void)
{
    return SWAY_ECU_NO_CAUSE;
}

static sway_ecu_t ecu;
static sway_ecu_retained_t retained;
static pages_t pages;

int main(int argc, char **argv)
{
    static const replay_machine_t machine = {.open = machine_open,
                                             .read = machine_read,
                                             .write = machine_write,
                                             .standard_output = STDOUT_FILENO,
                                             .check = check};
    return replay_run(&ecu, &retained, &pages, &machine, argc > 1 ? argv[1] : "",
                      argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
}

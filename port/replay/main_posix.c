/* The replay program for a machine with an operating system: x86-64, or big-endian MIPS under
 * qemu-user. */
#include <fcntl.h>
#include <string.h>
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

static void began(void)
{
}

static void returned(bool is_finished)
{
    (void)is_finished;
}

int main(int argc, char **argv)
{
    static const replay_machine_t machine = {.open = machine_open,
                                             .read = machine_read,
                                             .write = machine_write,
                                             .standard_output = STDOUT_FILENO,
                                             .began = began,
                                             .returned = returned};
    static sway_ecu_t ecu;
    static sway_ecu_retained_t retained;
    char arguments[1024] = "";
    for (int i = 1; i < argc; i++) {
        if (strlen(arguments) + strlen(argv[i]) + 2U > sizeof arguments) {
            return 2;
        }
        strcat(arguments, argv[i]);
        strcat(arguments, " ");
    }
    return replay_run(&ecu, &retained, &machine, arguments);
}

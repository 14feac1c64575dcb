/* Lets User Mode Linux run on processors with more registers than it knows, as a preloaded library.
 *
 * The kernel takes a process's extended registers only whole: on a processor with matrix registers
 * (AMX) that is 11,008 bytes, of which UML 6.1 keeps the first 2,696, and its first guest process
 * ends with "ptrace set fp regs failed, errno = 14". Here the rest is what the process has.
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#define MOST_BYTES 65536u

static long ask(long request, long pid, void *address, void *data)
{
    return syscall(SYS_ptrace, request, pid, address, data);
}

/* UML's stack is small, and its kernel one thread. */
static unsigned char whole[MOST_BYTES];

static long set_registers(long pid, void *kind, const struct iovec *given)
{
    struct iovec all = {whole, sizeof whole};
    if (ask(PTRACE_GETREGSET, pid, kind, &all) < 0) {
        return -1;
    }
    if (all.iov_len > given->iov_len) {
        memcpy(whole, given->iov_base, given->iov_len);
    } else {
        all = *given;
    }
    return ask(PTRACE_SETREGSET, pid, kind, &all);
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    const long pid = va_arg(arguments, pid_t);
    void *const address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);
    if (request == PTRACE_SETREGSET && (uintptr_t)address == NT_X86_XSTATE) {
        return set_registers(pid, address, data);
    }
    const int reads = request == PTRACE_PEEKTEXT || request == PTRACE_PEEKDATA ||
                      request == PTRACE_PEEKUSER; /* the value is the result, as in glibc */
    long value = 0;
    if (reads) {
        data = &value;
    }
    const long result = ask(request, pid, address, data);
    if (reads && result >= 0) {
        errno = 0;
        return value;
    }
    return result;
}

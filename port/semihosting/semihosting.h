/// semihosting: files, arguments, output and exit status of the machine that runs the emulator.
///
/// Arm semihosting (bkpt 0xAB on Cortex-M, svc 0x123456 on the R5). Nothing here is for a target
/// on the road: a call stops a processor that has no debugger.
#ifndef SWAY_SEMIHOSTING_H
#define SWAY_SEMIHOSTING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// How a file is opened, in semihosting's own numbers.
typedef enum { SEMIHOSTING_READ = 1, SEMIHOSTING_WRITE = 5 } semihosting_mode_t;

/// Opens a file of the host; negative: it cannot be opened.
int32_t semihosting_open(const char *path, semihosting_mode_t mode);
/// The emulator's own output; never closed.
int32_t semihosting_stdout(void);
/// Reads up to `size` bytes; returns how many, 0 at the end of the file.
size_t semihosting_read(int32_t file, void *bytes, size_t size);
/// Writes all bytes; false: the host took fewer.
bool semihosting_write(int32_t file, const void *bytes, size_t size);
void semihosting_close(int32_t file);
/// The arguments given to the emulator, separated by spaces; an empty string for none.
void semihosting_arguments(char *text, size_t size);
/// Ends the emulator with this exit status.
void semihosting_exit(int32_t status) __attribute__((noreturn));

#endif

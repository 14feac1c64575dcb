// SPDX-License-Identifier: MIT
/// sway_version: which swaywatch this is, and what C++ needs to know of its headers.
///
/// lib/*.h are for users; what they include from the rooms below (arithmetic/, signal/, model/,
/// judge/, bus/) is there because users own the memory, and may change with any version.
#ifndef SWAY_VERSION_H
#define SWAY_VERSION_H

#define SWAY_VERSION_MAJOR 0
#define SWAY_VERSION_MINOR 1
#define SWAY_VERSION_PATCH 0

/// For comparisons: #if SWAY_VERSION >= SWAY_VERSION_OF(1, 2, 0)
#define SWAY_VERSION_OF(major, minor, patch) ((major)*10000 + (minor)*100 + (patch))
#define SWAY_VERSION SWAY_VERSION_OF(SWAY_VERSION_MAJOR, SWAY_VERSION_MINOR, SWAY_VERSION_PATCH)

#ifdef __cplusplus
#define SWAY_C_BEGIN extern "C" {
#define SWAY_C_END }
#else
#define SWAY_C_BEGIN
#define SWAY_C_END
#endif

#endif

// SPDX-License-Identifier: MIT
/// sway_config: the compile-time sizes of swaywatch. Define a macro on the compiler's command line
/// to change it; a value out of range stops the build.
#ifndef SWAY_CONFIG_H
#define SWAY_CONFIG_H

/// Functions of a few instructions, which cost less than their call even where size is saved.
#if defined(__GNUC__)
#define SWAY_INLINE static inline __attribute__((always_inline))
#else
#define SWAY_INLINE static inline
#endif

/// Functions with a large frame that are called seldom: they are not put into their callers, whose
/// frames lie under everything else.
#if defined(__GNUC__)
#define SWAY_NOINLINE static __attribute__((noinline))
#else
#define SWAY_NOINLINE static
#endif

/// Samples a channel's ring holds; the longest window. A power of two.
/// 512 samples at 100 Hz hold 6 oscillations down to 1.2 Hz, 3 at 0.6 Hz, 2 at 0.4 Hz.
#ifndef SWAY_RING_SAMPLES
#define SWAY_RING_SAMPLES 512
#endif
#if SWAY_RING_SAMPLES < 64 || SWAY_RING_SAMPLES > 8192 ||                                          \
    (SWAY_RING_SAMPLES & (SWAY_RING_SAMPLES - 1)) != 0
#error "SWAY_RING_SAMPLES: a power of two from 64 to 8192"
#endif

/// Channels that have a ring and a line each: the first SWAY_CHANNELS of `sway_channel_t`.
#ifndef SWAY_CHANNELS
#define SWAY_CHANNELS 16
#endif
#if SWAY_CHANNELS < 4 || SWAY_CHANNELS > 16
#error "SWAY_CHANNELS: 4 to 16"
#endif

/// Spectral lines (bins of the sliding DFT, without the mean) kept for each channel.
#ifndef SWAY_BINS
#define SWAY_BINS 5
#endif
#if SWAY_BINS < 3 || SWAY_BINS > 16
#error "SWAY_BINS: 3 to 16"
#endif

/// 1: identifies the trailer from the car's own sensors where it has none (sway_trailer); 0: leaves
/// that out, for small targets.
#ifndef SWAY_TRAILER
#define SWAY_TRAILER 1
#endif
#if SWAY_TRAILER != 0 && SWAY_TRAILER != 1
#error "SWAY_TRAILER: 0 or 1"
#endif

/// 1: an ECU can keep the trailer that it has learnt without power and tell another one
/// (sway_remember, sway_ecu_remember()); 0: leaves that out.
#ifndef SWAY_REMEMBER
#define SWAY_REMEMBER SWAY_TRAILER
#endif
#if SWAY_REMEMBER != 0 && (SWAY_REMEMBER != 1 || SWAY_TRAILER != 1)
#error "SWAY_REMEMBER: 0, or 1 with SWAY_TRAILER"
#endif

/// 1: checks the relations between the inputs while driving (sway_supervise); 0: leaves that out.
/// Its work has a slice of its own in each row, so estimates come at the same times either way.
#ifndef SWAY_SUPERVISION
#define SWAY_SUPERVISION (SWAY_CHANNELS == 16)
#endif
#if SWAY_SUPERVISION != 0 && (SWAY_SUPERVISION != 1 || SWAY_CHANNELS != 16)
#error "SWAY_SUPERVISION: 0, or 1 with 16 channels"
#endif

/// 1: gives the smallest critical speed of small, driven and limit swings (sway_swing); 0: leaves
/// that out.
#ifndef SWAY_SWING
#define SWAY_SWING SWAY_SUPERVISION
#endif
#if SWAY_SWING != 0 && (SWAY_SWING != 1 || SWAY_SUPERVISION != 1)
#error "SWAY_SWING: 0, or 1 with SWAY_SUPERVISION"
#endif

/// 1: an ECU can hear a car's own bus (sway_map, sway_ecu_listen()); 0: it hears frames of
/// dbc/swaywatch.dbc only.
#ifndef SWAY_MAP
#define SWAY_MAP 1
#endif
#if SWAY_MAP != 0 && SWAY_MAP != 1
#error "SWAY_MAP: 0 or 1"
#endif

/// Most work in one call of sway_core_run(), in thousands of instructions of a Cortex-M0+ (about;
/// other processors take fewer): 60 are 1.3 ms at 48 MHz.
#ifndef SWAY_SLICE_COST
#define SWAY_SLICE_COST 60
#endif
#if SWAY_SLICE_COST < 60 || SWAY_SLICE_COST > 1000
#error "SWAY_SLICE_COST: 60 to 1000"
#endif

/// Most calls of sway_core_run() for each row of the grid. Their product is the most that a row
/// costs; where estimates ask for more, they come later. Both change results (a little), so they
/// must be alike on machines whose answers are compared.
#ifndef SWAY_SLICES_PER_ROW
#define SWAY_SLICES_PER_ROW 6
#endif
#if SWAY_SLICES_PER_ROW < 6 || SWAY_SLICES_PER_ROW > 200
#error "SWAY_SLICES_PER_ROW: 6 to 200"
#endif

#endif

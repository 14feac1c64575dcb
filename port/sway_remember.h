/// sway_remember: the trailer that the ECU has learnt, kept without power and known again.
///
/// What one drive has learnt of car and trailer (sway_trailer_remember()) is a record of
/// SWAY_REMEMBER_SIZE bytes. The next drive begins with the remembered car, the trailer is as
/// unknown as ever; after each SWAY_REMEMBER_ASK_MS of learning it is asked how likely the trailer
/// is the remembered one (sway_trailer_likeness()).
///
/// Writes are few: at standstill or at the end only, and only a trailer that is certainly there
/// after SWAY_REMEMBER_LEARNT_MS: one where none was remembered and another one once in a drive,
/// the same one only where the product of its variances has fallen by e^2 or more. The variances
/// fall from the start value to what sensors allow, by e^20 at most (sums of 0.4^2 to 0.03^2 and
/// the like), so a trailer is written ten times in its life; with a swap at every drive, and two
/// pages of 10,000 erasures each, flash lasts 20,000 drives.
///
/// Layout, little-endian: "SWTR", version u16, number of words u16, sequence number u32, CRC-32 of
/// the parameters that it was learnt with (values are relative to them), the words (mantissa and
/// exponent of each number as int32), CRC-32 of all before it.
#ifndef SWAY_REMEMBER_H
#define SWAY_REMEMBER_H

#include "sway_block.h"

#if SWAY_REMEMBER

#define SWAY_REMEMBER_VERSION 1U
#define SWAY_REMEMBER_NUMBERS (SWAY_TRAILER_MEMORY + SWAY_TRAILER_TRIANGLE)
#define SWAY_REMEMBER_WORDS (2U * SWAY_REMEMBER_NUMBERS)
#define SWAY_REMEMBER_SIZE (16U + 4U * SWAY_REMEMBER_WORDS + 4U)

/// Time of learning between two questions.
#define SWAY_REMEMBER_ASK_MS 20000
/// Time of learning before anything is kept.
#define SWAY_REMEMBER_LEARNT_MS 60000

/// SwayTrailer.TrailerState.
typedef enum {
    SWAY_REMEMBER_UNKNOWN, ///< nothing said yet, or sensors of the trailer are heard
    SWAY_REMEMBER_NONE,    ///< no trailer
    SWAY_REMEMBER_NEW,     ///< a trailer; none is remembered
    SWAY_REMEMBER_SAME,
    SWAY_REMEMBER_ANOTHER, ///< stays so until the next start
} sway_remember_state_t;

typedef struct {
    bool has_memory;  ///< one is recalled, of the parameters in use
    bool was_another; ///< it was said in this drive
    bool kept;        ///< this drive has replaced what was stored
    uint8_t writes;   ///< since the start
    uint32_t sequence;
    uint32_t parameters;          ///< CRC-32 of those in use
    int32_t asked_ms;             ///< learnt when it was asked last
    sway_real_t likeness;         ///< natural logarithm, see sway_trailer_likeness()
    sway_real_t volume;           ///< of what is stored, see sway_remember_begin()
    sway_trailer_memory_t memory; ///< what was stored when the drive began
} sway_remember_t;

/// Whole and of this version? As sway_block_check().
sway_block_result_t sway_remember_check(const uint8_t *record, size_t size, uint32_t *sequence);

/// Begins a drive with `record` (NULL or damaged: nothing is remembered) and the parameters in use.
void sway_remember_begin(sway_remember_t *remember, const uint8_t *record, size_t size,
                         const sway_core_config_t *config);

/// The core begins anew, maybe with other parameters.
void sway_remember_restart(sway_remember_t *remember, sway_trailer_watch_t *watch,
                           const sway_core_config_t *config);

/// Asks where it is due, which takes 300 thousand instructions once in SWAY_REMEMBER_ASK_MS. True:
/// asked.
bool sway_remember_look(sway_remember_t *remember, const sway_trailer_watch_t *watch);

sway_remember_state_t sway_remember_state(const sway_remember_t *remember,
                                          const sway_trailer_watch_t *watch);

/// Is what is known now worth a write? True: `record` is filled, to be kept; tell with
/// sway_remember_kept().
bool sway_remember_wants(const sway_remember_t *remember, const sway_trailer_watch_t *watch,
                         uint8_t *record);
void sway_remember_kept(sway_remember_t *remember, const sway_trailer_watch_t *watch);

#endif

#endif

/* The trailer remembered: what is kept and when, what the next drive says, power cuts. */
#include "ecu_bench.h"

static uint8_t slot_of[SWAY_STORE_SLOTS][SWAY_REMEMBER_SIZE]; // two pages of their own
static unsigned writes;
static int cut_after; // bytes until the power goes, the erasure counts as one; negative: never

static bool slot_read(void *context, uint32_t slot, uint8_t *bytes, size_t size)
{
    (void)context;
    memcpy(bytes, slot_of[slot], size);
    return true;
}

static bool spend(void)
{
    const bool is_on = cut_after != 0;
    cut_after -= cut_after > 0 ? 1 : 0;
    return is_on;
}

static bool slot_erase(void *context, uint32_t slot)
{
    (void)context;
    if (!spend()) {
        return false;
    }
    memset(slot_of[slot], 0xFF, SWAY_REMEMBER_SIZE);
    return true;
}

static bool slot_write(void *context, uint32_t slot, const uint8_t *record, size_t size)
{
    (void)context;
    for (size_t i = 0; i < size; i++) {
        if (!spend()) {
            return false;
        }
        slot_of[slot][i] = record[i];
    }
    return true;
}

static const sway_store_t slots = {.size = SWAY_REMEMBER_SIZE,
                                   .check = sway_remember_check,
                                   .read = slot_read,
                                   .erase = slot_erase,
                                   .write = slot_write};

static bool keep(void *context, const uint8_t *record, size_t size)
{
    (void)context;
    writes++;
    return sway_store_write(&slots, record, size);
}

static sway_trailer_watch_t *watch(void)
{
    return &ecu.node.core.watch;
}

/* A start with what the pages hold. */
static void begin(void)
{
    uint8_t record[SWAY_REMEMBER_SIZE];
    start_good();
    (void)sway_store_find(&slots, record);
    sway_ecu_remember(&ecu, keep, record, sizeof record);
}

static void begin_empty(void)
{
    setUp();
    memset(slot_of, 0xFF, sizeof slot_of);
    writes = 0U;
    cut_after = -1;
    begin();
}

static sway_real_t real(double value)
{
    return sway_real_ratio((int32_t)(value * 1e6), 1000000);
}

/* A drive that has found a trailer whose values are `off` standard errors of the start away from
 * where they began, known ten times as well. */
static void learn(double off, int32_t seconds)
{
    sway_trailer_watch_t *const w = watch();
    w->presence = SWAY_TRAILER_THERE;
    w->learnt_ms = seconds * 1000;
    for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
        const uint32_t state = SWAY_STATE_TRAILER_MASS + i;
        w->with.x[state] = sway_real_add(w->start[i], sway_real_mul(w->start_error[i], real(off)));
        w->with.p[state * (state + 1U) / 2U + state] =
            sway_real_mul(sway_real_mul(w->start_error[i], w->start_error[i]), real(0.01));
    }
}

static struct swaywatch_dbc_sway_trailer_t reported(void)
{
    struct swaywatch_dbc_sway_trailer_t t;
    sent_count = 0U;
    for (int i = 0; i < 120; i++) {
        now_us += 9000;
        give_speed();
    }
    const sway_port_frame_t *frame = last_of(SWAYWATCH_DBC_SWAY_TRAILER_FRAME_ID);
    TEST_ASSERT_NOT_NULL_MESSAGE(frame, "no SwayTrailer");
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_trailer_unpack(&t, frame->data, frame->dlc);
    return t;
}

/* Moves on until the next look whether something is to be kept. */
static void stand(void)
{
    speed_mm_s = 0;
    for (int i = 0; i < 1100; i++) {
        now_us += 9000;
        give_speed();
        sent_count = 0U;
    }
}

static void test_without_keep_nothing_is_reported(void)
{
    start_good();
    learn(0.5, 120);
    for (int i = 0; i < 300; i++) {
        now_us += 9000;
        give_speed();
    }
    TEST_ASSERT_NULL(last_of(SWAYWATCH_DBC_SWAY_TRAILER_FRAME_ID));
    sway_ecu_leave(&ecu);
    start_from(NULL); // the safe state
    sway_ecu_remember(&ecu, keep, NULL, 0);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    sway_ecu_leave(&ecu);
    TEST_ASSERT_EQUAL_UINT(0, writes);
}

static void test_states_of_a_first_drive(void)
{
    begin_empty();
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_UNKNOWN, reported().trailer_state);
    watch()->presence = SWAY_TRAILER_NONE;
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_NONE, reported().trailer_state);
    watch()->sensed = true;
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_UNKNOWN, reported().trailer_state);
    watch()->presence = SWAY_TRAILER_THERE;
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_UNKNOWN, reported().trailer_state);
    watch()->sensed = false;
    watch()->learnt_ms = 59000;
    const struct swaywatch_dbc_sway_trailer_t t = reported();
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_NEW, t.trailer_state);
    TEST_ASSERT_EQUAL_UINT16(59, t.trailer_learnt);
    stand();
    TEST_ASSERT_EQUAL_UINT(0, writes); // not after 59 s
}

/* At standstill, once; not while driving, nor where the speed is not known. */
static void test_a_new_trailer_is_kept_at_standstill(void)
{
    begin_empty();
    learn(0.5, 120);
    stand();
    TEST_ASSERT_EQUAL_UINT(1, writes);
    stand();
    TEST_ASSERT_EQUAL_UINT(1, writes);
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_NEW, reported().trailer_state);
    TEST_ASSERT_EQUAL_UINT8(1, reported().trailer_writes);
    begin_empty();
    learn(0.5, 120);
    speed_mm_s = 1000;
    for (int i = 0; i < 1500; i++) {
        now_us += 9000;
        give_speed();
        sent_count = 0U;
    }
    TEST_ASSERT_EQUAL_UINT(0, writes);
    sway_ecu_leave(&ecu);
    TEST_ASSERT_EQUAL_UINT(1, writes);
}

static void test_the_same_and_another_trailer(void)
{
    for (int another = 0; another < 2; another++) {
        begin_empty();
        learn(0.8, 120);
        stand();
        begin();
        TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_UNKNOWN, reported().trailer_state);
        learn(another ? -0.8 : 0.8, 19);
        TEST_ASSERT_EQUAL_INT(0, reported().trailer_likeness); // not asked yet
        TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_UNKNOWN, reported().trailer_state);
        watch()->learnt_ms = 20000;
        const struct swaywatch_dbc_sway_trailer_t t = reported();
        TEST_ASSERT_EQUAL_UINT8(another ? SWAY_REMEMBER_ANOTHER : SWAY_REMEMBER_SAME,
                                t.trailer_state);
        TEST_ASSERT_TRUE(another ? t.trailer_likeness < -100 : t.trailer_likeness > 100);
        /* The same is not written again, another one is, and stays another one in this drive. */
        watch()->learnt_ms = 60000;
        stand();
        TEST_ASSERT_EQUAL_UINT(1U + (unsigned)another, writes);
        learn(0.8, 100);
        TEST_ASSERT_EQUAL_UINT8(another ? SWAY_REMEMBER_ANOTHER : SWAY_REMEMBER_SAME,
                                reported().trailer_state);
        stand();
        TEST_ASSERT_EQUAL_UINT(1U + (unsigned)another, writes);
    }
}

/* The car is recalled, the trailer is not. */
static void test_the_next_drive_begins_with_the_car(void)
{
    begin_empty();
    learn(0.8, 120);
    watch()->with.x[SWAY_STATE_CAR_FRONT] = real(0.07);
    stand();
    begin();
    TEST_ASSERT_TRUE(sway_real_compare(real(0.07), watch()->alone.x[SWAY_STATE_CAR_FRONT]) == 0);
    TEST_ASSERT_TRUE(sway_real_compare(real(0.07), watch()->with.x[SWAY_STATE_CAR_FRONT]) == 0);
    TEST_ASSERT_TRUE(
        sway_real_compare(watch()->start[0], watch()->with.x[SWAY_STATE_TRAILER_MASS]) == 0);
    /* A core that begins anew with the same parameters recalls it again, with others nothing. */
    watch()->with.x[SWAY_STATE_CAR_FRONT] = real(0.5);
    TEST_ASSERT_EQUAL_UINT8(DONE, change(APPLY, NOTHING, 0).parameter_result);
    TEST_ASSERT_TRUE(sway_real_compare(real(0.07), watch()->with.x[SWAY_STATE_CAR_FRONT]) == 0);
    TEST_ASSERT_EQUAL_UINT8(DONE, change(APPLY, 0, 1800000).parameter_result);
    TEST_ASSERT_TRUE(sway_real_is_zero(watch()->with.x[SWAY_STATE_CAR_FRONT]));
    learn(0.8, 10);
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_NEW, reported().trailer_state);
}

/* The next frames; how many SwayTrailer among them, and when the last one was sent. */
static unsigned sent_within(int64_t us, int64_t *last_us)
{
    unsigned count = 0U;
    for (const int64_t end_us = now_us + us; now_us < end_us;) {
        now_us += 9000;
        sent_count = 0U;
        give_speed();
        if (last_of(SWAYWATCH_DBC_SWAY_TRAILER_FRAME_ID) != NULL) {
            count++;
            *last_us = now_us;
        }
    }
    return count;
}

/* The first one at once, also where the ECU was given its record anew, then every second. */
static void test_said_at_once_and_every_second(void)
{
    int64_t first_us = 0;
    begin_empty();
    TEST_ASSERT_EQUAL_UINT(1, sent_within(500000, &first_us));
    TEST_ASSERT_INT64_WITHIN(10000, 10000, first_us);
    int64_t second_us = 0;
    TEST_ASSERT_EQUAL_UINT(1, sent_within(800000, &second_us));
    TEST_ASSERT_INT64_WITHIN(10000, first_us + 1000000, second_us);
    sway_ecu_remember(&ecu, keep, NULL, 0);
    TEST_ASSERT_EQUAL_UINT(1, sent_within(100000, &second_us));
}

/* Where a frame was sent, there may be another one: the caller is to ask again. */
static void test_a_poll_that_says_it_is_not_the_last(void)
{
    begin_empty();
    for (int i = 0; i < 64; i++) {
        sent_count = 0U;
        const bool again = sway_ecu_poll(&ecu);
        if (last_of(SWAYWATCH_DBC_SWAY_TRAILER_FRAME_ID) != NULL) {
            TEST_ASSERT_TRUE(again);
            return;
        }
    }
    TEST_FAIL_MESSAGE("no SwayTrailer");
}

/* A write that failed is tried again after ten seconds, not before. */
static void test_looks_every_ten_seconds(void)
{
    int64_t last_us = 0;
    begin_empty();
    speed_mm_s = 0;
    learn(0.5, 120);
    cut_after = 0;
    (void)sent_within(9500000, &last_us);
    TEST_ASSERT_EQUAL_UINT(1, writes);
    (void)sent_within(10000000, &last_us);
    TEST_ASSERT_EQUAL_UINT(2, writes);
    cut_after = -1;
    (void)sent_within(10000000, &last_us);
    TEST_ASSERT_EQUAL_UINT(3, writes);
    TEST_ASSERT_EQUAL_UINT8(SWAY_BLOCK_OK,
                            sway_remember_check(slot_of[0], SWAY_REMEMBER_SIZE, &(uint32_t){0}));
}

/* In hundredths, and as far as its 16 bits go. */
static void test_likeness_is_in_hundredths(void)
{
    static const struct {
        int32_t tenths;
        int hundredths;
    } cases[] = {{123, 1230}, {-123, -1230}, {10000, INT16_MAX}, {-10000, -INT16_MAX}};
    begin_empty();
    for (unsigned k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ecu.remember.likeness = sway_real_ratio(cases[k].tenths, 10);
        TEST_ASSERT_EQUAL_INT(cases[k].hundredths, reported().trailer_likeness);
    }
}

/* It is the same one where that is e^6 times more probable, not before. */
static void test_the_same_trailer_has_to_be_400_times_more_probable(void)
{
    sway_trailer_watch_t seen = {.presence = (uint8_t)SWAY_TRAILER_THERE};
    sway_remember_t asked = {.has_memory = true};
    static const struct {
        int32_t hundredths;
        sway_remember_state_t state;
    } cases[] = {{601, SWAY_REMEMBER_SAME},
                 {600, SWAY_REMEMBER_UNKNOWN},
                 {-99, SWAY_REMEMBER_UNKNOWN},
                 {599, SWAY_REMEMBER_UNKNOWN}};
    for (unsigned k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        asked.likeness = sway_real_ratio(cases[k].hundredths, 100);
        TEST_ASSERT_EQUAL_INT(cases[k].state, sway_remember_state(&asked, &seen));
    }
}

/* Learnt with other parameters it says nothing, and is replaced. */
static void test_a_record_of_other_parameters_is_not_used(void)
{
    begin_empty();
    learn(0.8, 120);
    stand();
    uint8_t record[SWAY_REMEMBER_SIZE];
    (void)sway_store_find(&slots, record);
    sway_core_config_t config = good_config();
    config.vehicle.car.mass_g += 50000;
    put_block(0, &config, 2);
    start();
    sway_ecu_remember(&ecu, keep, record, sizeof record);
    learn(0.8, 120);
    TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_NEW, reported().trailer_state);
    stand();
    TEST_ASSERT_EQUAL_UINT(2, writes);
}

static void test_the_same_is_written_again_where_it_is_known_much_better(void)
{
    static const struct {
        double times; // all six variances
        bool written;
    } cases[] = {{0.8, false}, {0.7, true}}; // e^-2 is 0.717^6
    for (int k = 0; k < 2; k++) {
        begin_empty();
        learn(0.8, 120);
        stand();
        begin();
        learn(0.8, 120);
        for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
            const uint32_t state = SWAY_STATE_TRAILER_MASS + i;
            sway_real_t *const p = &watch()->with.p[state * (state + 1U) / 2U + state];
            *p = sway_real_mul(*p, real(cases[k].times));
        }
        stand();
        TEST_ASSERT_EQUAL_UINT(cases[k].written ? 2 : 1, writes);
    }
}

static void test_damage_is_found(void)
{
    uint32_t sequence = 0;
    uint8_t record[SWAY_REMEMBER_SIZE];
    begin_empty();
    learn(0.8, 120);
    stand();
    (void)sway_store_find(&slots, record);
    TEST_ASSERT_EQUAL(SWAY_BLOCK_OK, sway_remember_check(record, sizeof record, &sequence));
    TEST_ASSERT_EQUAL_UINT32(1, sequence);
    TEST_ASSERT_EQUAL(SWAY_BLOCK_EMPTY, sway_remember_check(NULL, sizeof record, &sequence));
    TEST_ASSERT_EQUAL(SWAY_BLOCK_EMPTY, sway_remember_check(record, sizeof record - 1U, &sequence));
    for (unsigned bit = 0; bit < 8U * SWAY_REMEMBER_SIZE; bit++) {
        record[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        const sway_block_result_t wanted = bit < 32U   ? SWAY_BLOCK_EMPTY
                                           : bit < 64U ? SWAY_BLOCK_VERSION_UNKNOWN
                                                       : SWAY_BLOCK_CRC;
        TEST_ASSERT_EQUAL(wanted, sway_remember_check(record, sizeof record, &sequence));
        record[bit / 8U] ^= (uint8_t)(1U << bit % 8U);
    }
}

/* Whenever the power goes while another trailer is kept, the next drive knows the one before or
 * this one, whole. */
static void test_power_cut_at_every_byte(void)
{
    const int whole = 1 + (int)SWAY_REMEMBER_SIZE;
    for (int cut = 0; cut <= whole; cut += cut < 40 || cut > whole - 10 ? 1 : 13) {
        begin_empty();
        learn(0.8, 120);
        sway_ecu_leave(&ecu);
        learn(-0.8, 120);
        ecu.remember.kept = false;
        cut_after = cut;
        sway_ecu_leave(&ecu);
        TEST_ASSERT_EQUAL_UINT(2, writes);
        TEST_ASSERT_EQUAL_UINT8(2, ecu.remember.writes); // it wears either way
        TEST_ASSERT_EQUAL(cut == whole, ecu.remember.kept);
        cut_after = -1;
        begin();
        learn(cut == whole ? -0.8 : 0.8, 20);
        TEST_ASSERT_EQUAL_UINT8(SWAY_REMEMBER_SAME, reported().trailer_state);
    }
}

/* Twenty between two power-ups, whatever goes wrong. */
static void test_flash_is_not_worn(void)
{
    begin_empty();
    learn(0.8, 120);
    for (int i = 0; i < 30; i++) {
        cut_after = 0;
        sway_ecu_leave(&ecu);
    }
    TEST_ASSERT_EQUAL_UINT(20, writes);
}

/* --- the record and the questions, without the ECU around them -------------------------------- */

static sway_remember_t known;

static uint32_t little_endian(const uint8_t *bytes, unsigned count)
{
    uint32_t value = 0;
    for (unsigned i = count; i > 0U; i--) {
        value = 256U * value + bytes[i - 1U];
    }
    return value;
}

/* CRC-32 of IEEE 802.3, bit by bit. */
static uint32_t crc32_of(uint32_t before, const void *data, size_t size)
{
    uint32_t crc = ~before;
    for (size_t i = 0; i < size; i++) {
        crc ^= ((const uint8_t *)data)[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1U) ^ ((crc & 1U) != 0U ? 0xEDB88320U : 0U);
        }
    }
    return ~crc;
}

static uint32_t parameters_of(const sway_core_config_t *config)
{
    uint32_t crc = crc32_of(0, &config->vehicle, sizeof config->vehicle);
    crc = crc32_of(crc, &config->trailer_assumed, sizeof config->trailer_assumed);
    return crc32_of(crc, &config->sample_period_us, sizeof config->sample_period_us);
}

static void expect_record(const uint8_t *record, uint32_t sequence,
                          const sway_core_config_t *config)
{
    sway_trailer_memory_t memory;
    sway_trailer_remember(watch(), &memory);
    TEST_ASSERT_EQUAL_MEMORY("SWTR", record, 4);
    TEST_ASSERT_EQUAL_UINT32(SWAY_REMEMBER_VERSION, little_endian(record + 4, 2));
    TEST_ASSERT_EQUAL_UINT32(SWAY_REMEMBER_WORDS, little_endian(record + 6, 2));
    TEST_ASSERT_EQUAL_HEX32(sequence, little_endian(record + 8, 4));
    TEST_ASSERT_EQUAL_HEX32(parameters_of(config), little_endian(record + 12, 4));
    for (unsigned i = 0; i < SWAY_REMEMBER_NUMBERS; i++) {
        const sway_real_t number =
            i < SWAY_TRAILER_MEMORY ? memory.value[i] : memory.covariance[i - SWAY_TRAILER_MEMORY];
        TEST_ASSERT_EQUAL_HEX32((uint32_t)number.m, little_endian(record + 16 + 8 * i, 4));
        TEST_ASSERT_EQUAL_HEX32((uint32_t)number.e, little_endian(record + 20 + 8 * i, 4));
    }
    const unsigned end = SWAY_REMEMBER_SIZE - 4U;
    TEST_ASSERT_EQUAL_HEX32(crc32_of(0, record, end), little_endian(record + end, 4));
}

/* As its header says, to the byte; each has the number after the last one. */
static void test_the_record_is_as_documented(void)
{
    struct {
        uint8_t record[SWAY_REMEMBER_SIZE];
        uint8_t behind[8];
    } kept;
    sway_core_config_t config = good_config();
    config.trailer_assumed = 2;
    begin_empty();
    learn(0.8, 120);
    memset(&known, 0xA5, sizeof known);
    memset(&kept, 0xA5, sizeof kept);
    sway_remember_begin(&known, NULL, 0, &config);
    for (uint32_t sequence = 1; sequence < 4U; sequence++) {
        TEST_ASSERT_TRUE(sway_remember_wants(&known, watch(), kept.record));
        expect_record(kept.record, sequence, &config);
        TEST_ASSERT_EACH_EQUAL_HEX8(0xA5, kept.behind, sizeof kept.behind);
        sway_remember_kept(&known, watch());
        TEST_ASSERT_EQUAL_UINT8(sequence, known.writes);
        known.kept = false;
    }
    kept.record[8] = 0xFF; // a number of all its bytes
    kept.record[9] = 0xFE;
    kept.record[10] = 0xFD;
    kept.record[11] = 0x7C;
    const uint32_t crc = crc32_of(0, kept.record, SWAY_REMEMBER_SIZE - 4U);
    for (unsigned i = 0; i < 4U; i++) {
        kept.record[SWAY_REMEMBER_SIZE - 4U + i] = (uint8_t)(crc >> 8U * i);
    }
    sway_remember_begin(&known, kept.record, SWAY_REMEMBER_SIZE, &config);
    known.was_another = true;
    TEST_ASSERT_TRUE(sway_remember_wants(&known, watch(), kept.record));
    expect_record(kept.record, 0x7CFDFF00U, &config);
}

/* Whatever the memory held before: nothing is known, and nothing has been said or written. */
static void test_a_drive_begins_with_nothing_of_the_last_one(void)
{
    const sway_core_config_t config = good_config();
    begin_empty();
    learn(0.8, 120);
    memset(&known, 0xA5, sizeof known);
    sway_remember_begin(&known, NULL, 0, &config);
    TEST_ASSERT_FALSE(known.has_memory || known.was_another || known.kept);
    TEST_ASSERT_EQUAL_UINT8(0, known.writes);
    TEST_ASSERT_EQUAL_UINT32(0, known.sequence);
    TEST_ASSERT_EQUAL_INT32(0, known.asked_ms);
    TEST_ASSERT_TRUE(sway_real_is_zero(known.likeness));
    TEST_ASSERT_EQUAL(SWAY_REMEMBER_NEW, sway_remember_state(&known, watch()));
}

/* Recalls what was learnt with a trailer `off` from where it began. */
static void recall(double off)
{
    const sway_core_config_t config = good_config();
    uint8_t record[SWAY_REMEMBER_SIZE];
    begin_empty();
    learn(off, 120);
    sway_remember_begin(&known, NULL, 0, &config);
    TEST_ASSERT_TRUE(sway_remember_wants(&known, watch(), record));
    sway_remember_begin(&known, record, sizeof record, &config);
    TEST_ASSERT_TRUE(known.has_memory);
}

/* After every 20 s of learning, if there is anything to ask. */
static void test_the_question_is_asked_every_20_s(void)
{
    static const struct {
        int32_t learnt_ms;
        bool asked;
    } cases[] = {{19999, false}, {20000, true}, {20001, false}, {39999, false},
                 {40000, true},  {65000, true}, {84999, false}, {85000, true}};
    recall(0.8);
    for (unsigned k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        known.likeness = sway_real_zero();
        watch()->learnt_ms = cases[k].learnt_ms;
        TEST_ASSERT_EQUAL(cases[k].asked, sway_remember_look(&known, watch()));
        TEST_ASSERT_EQUAL(cases[k].asked, !sway_real_is_zero(known.likeness));
    }
    known.likeness = sway_real_zero();
    watch()->learnt_ms = 200000;
    watch()->presence = SWAY_TRAILER_UNDECIDED;
    TEST_ASSERT_FALSE(sway_remember_look(&known, watch()));
    watch()->presence = SWAY_TRAILER_THERE;
    known.has_memory = false;
    TEST_ASSERT_FALSE(sway_remember_look(&known, watch()));
    TEST_ASSERT_TRUE(sway_real_is_zero(known.likeness));
    known.has_memory = true;
    TEST_ASSERT_TRUE(sway_remember_look(&known, watch()));
}

/* The core begins anew, and its time of learning with it: the question is due after 20 s again.
 * With the same parameters what was said stays, with others nothing does. */
static void test_what_stays_when_the_core_begins_anew(void)
{
    for (int other = 0; other < 2; other++) {
        uint8_t record[SWAY_REMEMBER_SIZE];
        sway_core_config_t config = good_config();
        config.vehicle.car.mass_g += other * 50000;
        recall(0.8);
        learn(-0.8, 100);
        TEST_ASSERT_TRUE(sway_remember_look(&known, watch()));
        TEST_ASSERT_TRUE(known.was_another);
        sway_remember_kept(&known, watch());
        sway_remember_restart(&known, watch(), &config);
        TEST_ASSERT_TRUE(sway_real_is_zero(known.likeness));
        TEST_ASSERT_EQUAL(other, sway_remember_wants(&known, watch(), record));
        TEST_ASSERT_EQUAL(other ? SWAY_REMEMBER_NEW : SWAY_REMEMBER_ANOTHER,
                          sway_remember_state(&known, watch()));
        if (other) {
            expect_record(record, 3, &config);
        }
        watch()->learnt_ms = 20000;
        TEST_ASSERT_EQUAL(!other, sway_remember_look(&known, watch()));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_without_keep_nothing_is_reported);
    RUN_TEST(test_states_of_a_first_drive);
    RUN_TEST(test_a_new_trailer_is_kept_at_standstill);
    RUN_TEST(test_the_same_and_another_trailer);
    RUN_TEST(test_the_next_drive_begins_with_the_car);
    RUN_TEST(test_said_at_once_and_every_second);
    RUN_TEST(test_a_poll_that_says_it_is_not_the_last);
    RUN_TEST(test_looks_every_ten_seconds);
    RUN_TEST(test_likeness_is_in_hundredths);
    RUN_TEST(test_the_same_trailer_has_to_be_400_times_more_probable);
    RUN_TEST(test_a_record_of_other_parameters_is_not_used);
    RUN_TEST(test_the_same_is_written_again_where_it_is_known_much_better);
    RUN_TEST(test_damage_is_found);
    RUN_TEST(test_power_cut_at_every_byte);
    RUN_TEST(test_flash_is_not_worn);
    RUN_TEST(test_the_record_is_as_documented);
    RUN_TEST(test_a_drive_begins_with_nothing_of_the_last_one);
    RUN_TEST(test_the_question_is_asked_every_20_s);
    RUN_TEST(test_what_stays_when_the_core_begins_anew);
    return UNITY_END();
}

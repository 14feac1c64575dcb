/* Parameters in flash: blocks, two pages, power cuts, flash that lies. */
#include "ecu_bench.h"

/* --- the block -------------------------------------------------------------------------------- */

static void test_good_block_starts(void)
{
    sway_core_config_t config = good_config();
    config.alarm.hold_ms = 777;
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    TEST_ASSERT_EQUAL_MEMORY(&config, sway_ecu_config(&ecu), sizeof config);
    TEST_ASSERT_EQUAL_UINT8(0, report().fault_cause);
}

static void test_empty_flash_is_the_safe_state(void)
{
    TEST_ASSERT_FALSE(start()); // nothing was cut
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_EMPTY, report().fault_cause);
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
    start_from(NULL);
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
}

/* Every single bit that flips is found, and nothing of the block is used. */
static void test_damaged_block_is_never_used(void)
{
    const sway_core_config_t config = good_config();
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    for (unsigned bit = 0; bit < 8U * SWAY_BLOCK_SIZE; bit++) {
        put_block(0, &config, 1);
        page[0][bit / 8U] ^= (uint8_t)(1U << bit % 8U);
        start();
        TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
        TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
        const unsigned wanted = bit < 32U   ? SWAY_BLOCK_EMPTY
                                : bit < 64U ? SWAY_BLOCK_VERSION_UNKNOWN
                                            : SWAY_BLOCK_CRC;
        TEST_ASSERT_EQUAL_UINT(SWAY_ECU_BLOCK + wanted, ecu.cause);
    }
}

static void test_block_of_another_version_is_refused(void)
{
    const sway_core_config_t config = good_config();
    put_block(0, &config, 1);
    page[0][4] = SWAY_BLOCK_VERSION - 1U;
    const uint32_t crc = sway_block_crc32(0, page[0], SWAY_BLOCK_SIZE - 4U);
    memcpy(page[0] + SWAY_BLOCK_SIZE - 4U, &crc, 4);
    start();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_VERSION_UNKNOWN, report().fault_cause);
}

static void test_intact_block_with_wrong_values_is_refused(void)
{
    sway_core_config_t config = good_config();
    config.vehicle.trailer.mass_g = 1;
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL_UINT8(SWAY_ECU_BLOCK + SWAY_BLOCK_REFUSED, report().fault_cause);
}

/* --- two pages -------------------------------------------------------------------------------- */

static uint32_t found_sequence(bool *interrupted)
{
    uint8_t block[SWAY_BLOCK_SIZE];
    uint32_t sequence = 0;
    *interrupted = sway_store_find(&flash, block);
    TEST_ASSERT_EQUAL(SWAY_BLOCK_OK, sway_block_check(block, sizeof block, &sequence));
    return sequence;
}

static void test_newest_good_block_wins(void)
{
    bool interrupted = false;
    sway_core_config_t config = good_config();
    put_block(0, &config, 4);
    config.vehicle.car.mass_g = 1700000;
    put_block(1, &config, 5);
    TEST_ASSERT_EQUAL_UINT32(5, found_sequence(&interrupted));
    put_block(0, &config, 6);
    TEST_ASSERT_EQUAL_UINT32(6, found_sequence(&interrupted));
    put_block(0, &config, UINT32_MAX); // the numbers turn over
    put_block(1, &config, 0);
    TEST_ASSERT_EQUAL_UINT32(0, found_sequence(&interrupted));
    TEST_ASSERT_FALSE(interrupted);
    page[1][40] ^= 1U;
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, found_sequence(&interrupted));
    TEST_ASSERT_TRUE(interrupted);
}

/* A block that looks whole is not used where the memory calls it damaged. */
static void test_what_the_memory_calls_damaged_is_not_used(void)
{
    const sway_core_config_t config = good_config();
    bool interrupted = false;
    put_block(0, &config, 4);
    put_block(1, &config, 5);
    read_fails[1] = true;
    TEST_ASSERT_EQUAL_UINT32(4, found_sequence(&interrupted));
    TEST_ASSERT_TRUE(interrupted);
    read_fails[0] = true;
    (void)start();
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL_UINT(SWAY_ECU_BLOCK + SWAY_BLOCK_CRC, ecu.cause);
}

/* Power cut after every byte of a store: old or new parameters, whole, and never silently. */
static void test_power_cut_at_every_byte_of_a_store(void)
{
    const int whole = 1 + (int)SWAY_BLOCK_SIZE;
    for (int cut = 0; cut <= whole; cut++) {
        setUp();
        const sway_core_config_t config = good_config();
        put_block(0, &config, 1);
        put_block(1, &config, 2);
        start();
        power_left = cut;
        TEST_ASSERT_EQUAL_UINT8(cut < whole ? NOT_STORED : DONE,
                                change(STORE, 0, 1800000).parameter_result);
        const bool interrupted = start();
        TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
        TEST_ASSERT_EQUAL_INT32(cut < whole ? 1955000 : 1800000,
                                sway_ecu_config(&ecu)->vehicle.car.mass_g);
        TEST_ASSERT_EQUAL(cut > 0 && cut < whole, interrupted);
    }
}

/* With a single page a cut means defaults, the safe state and a report: never half a block. */
static void test_power_cut_with_nothing_stored_before(void)
{
    const int whole = 1 + (int)SWAY_BLOCK_SIZE;
    sway_core_config_t defaults;
    sway_core_defaults(&defaults);
    for (int cut = 0; cut < whole; cut++) {
        setUp();
        start();
        ecu.staged = good_config();
        power_left = cut;
        TEST_ASSERT_EQUAL_UINT8(NOT_STORED, change(STORE, NOTHING, 0).parameter_result);
        start();
        TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
        TEST_ASSERT_EQUAL_MEMORY(&defaults, &ecu.staged, sizeof defaults);
        const uint8_t cause = report().fault_cause;
        TEST_ASSERT_TRUE(cause == SWAY_ECU_BLOCK + SWAY_BLOCK_EMPTY ||
                         cause == SWAY_ECU_BLOCK + SWAY_BLOCK_VERSION_UNKNOWN ||
                         cause == SWAY_ECU_BLOCK + SWAY_BLOCK_CRC);
    }
}

static void test_dead_flash_keeps_the_old_block(void)
{
    start_good();
    flash_is_dead = true;
    TEST_ASSERT_EQUAL_UINT8(NOT_STORED, change(STORE, NOTHING, 0).parameter_result);
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, ecu.state);
}

/* --- flash that lies ---------------------------------------------------------------------------
 */

static bool forget(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)write(context, slot, block, size);
    page[slot][17] ^= 1U;
    return true;
}

static bool deny(void *context, uint32_t slot, const uint8_t *block, size_t size)
{
    (void)write(context, slot, block, size);
    return false;
}

static bool keep(void *context, uint32_t slot)
{
    (void)context;
    (void)slot;
    return true; // erased nothing
}

static void test_flash_that_does_not_hold_is_found(void)
{
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_store_t bad = flash;
    sway_block_write(&config, 1, block);
    TEST_ASSERT_TRUE(sway_store_write(&flash, block, sizeof block));
    TEST_ASSERT_FALSE(sway_store_write(&flash, block, sizeof block - 1U));
    bad.write = forget;
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    bad.write = deny;
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    bad = flash;
    bad.erase = keep;
    memset(page[1], 0, sizeof page[1]);
    TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
    TEST_ASSERT_TRUE(sway_store_write(&flash, block, sizeof block));
}

/* --- the block itself --------------------------------------------------------------------------
 */

static void test_checksum_is_that_of_single_bits(void)
{
    for (unsigned byte = 0; byte < 256U; byte++) {
        const uint8_t value = (uint8_t)byte;
        uint32_t crc = UINT32_MAX ^ byte;
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ ((crc & 1U) != 0U ? UINT32_C(0xEDB88320) : 0U);
        }
        TEST_ASSERT_EQUAL_HEX32(~crc, sway_block_crc32(0, &value, 1));
    }
}

/* Limits of all that is not the vehicle's, as they are documented; a value on a limit is taken, one
 * beyond it is found. */
static void test_every_word_beyond_the_vehicle_has_its_range(void)
{
    static const struct {
        uint16_t word;
        int32_t low, high;
        bool may_be_zero;
    } expected[] = {{WORD_OF(sample_period_us), 5000, 20000, false},
                    {WORD_OF(window_cycles_milli), 1500, 6000, false},
                    {WORD_OF(input_delay_us), -500000, 500000, false},
                    {WORD_OF(input_period_us) - 1U, -500000, 500000, false},
                    {WORD_OF(input_period_us), 1000, 100000, true},
                    {WORD_OF(alarm.notice_margin_mm_s), 500, 14000, false},
                    {WORD_OF(alarm.margin_hysteresis_mm_s), 0, 5600, false},
                    {WORD_OF(alarm.notice_damping_ratio_ppm), 10000, 200000, false},
                    {WORD_OF(alarm.damping_hysteresis_ppm), 0, 100000, false},
                    {WORD_OF(alarm.minimum_amplitude_urad_s), 9000, 87000, false},
                    {WORD_OF(alarm.large_amplitude_urad_s), 35000, 210000, false},
                    {WORD_OF(alarm.limit_amplitude_urad_s), 87000, 524000, false},
                    {WORD_OF(alarm.critical_time_ms), 500, 20000, false},
                    {WORD_OF(alarm.hold_ms), 200, 20000, false},
                    {WORD_OF(alarm.minimum_speed_mm_s), 2800, 16700, false},
                    {WORD_OF(alarm.confidence_milli), 0, 3000, false},
                    {WORD_OF(trailer_assumed), 0, SWAY_ASSUMED_ALL, true}};
    for (unsigned i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        int32_t low = 1;
        int32_t high = 1;
        bool may_be_zero = !expected[i].may_be_zero;
        TEST_ASSERT_EQUAL(SWAY_OK, sway_block_range(expected[i].word, &low, &high, &may_be_zero));
        TEST_ASSERT_EQUAL_INT32(expected[i].low, low);
        TEST_ASSERT_EQUAL_INT32(expected[i].high, high);
        TEST_ASSERT_EQUAL(expected[i].may_be_zero, may_be_zero);
        for (int beyond = 0; beyond < 2; beyond++) {
            sway_core_config_t config = good_config();
            TEST_ASSERT_EQUAL(SWAY_OK, sway_block_set(&config, expected[i].word, low - beyond));
            TEST_ASSERT_EQUAL_UINT32(beyond ? expected[i].word : SWAY_BLOCK_WORDS,
                                     sway_block_offender(&config));
            TEST_ASSERT_EQUAL(SWAY_OK, sway_block_set(&config, expected[i].word, high + beyond));
            TEST_ASSERT_EQUAL_UINT32(beyond ? expected[i].word : SWAY_BLOCK_WORDS,
                                     sway_block_offender(&config));
        }
    }
    int32_t none;
    bool zero;
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT,
                      sway_block_range((uint32_t)SWAY_BLOCK_WORDS, &none, &none, &zero));
}

/* Thresholds that a core would take, but by which the alarm would never come. */
static void test_a_block_with_a_silent_alarm_is_refused(void)
{
    sway_core_config_t config = good_config();
    config.alarm.notice_margin_mm_s = 0;
    put_block(0, &config, 1);
    start();
    TEST_ASSERT_EQUAL(SWAY_ECU_SAFE, ecu.state);
    TEST_ASSERT_EQUAL(SWAY_ECU_BLOCK + SWAY_BLOCK_REFUSED, ecu.cause);
    int32_t value = 7;
    TEST_ASSERT_EQUAL(SWAY_ERROR_ARGUMENT,
                      sway_block_set(&config, (uint32_t)SWAY_BLOCK_WORDS, value));
}

static unsigned stubborn; /* byte that an erasure leaves */

static bool erase_badly(void *context, uint32_t slot)
{
    const bool is_erased = erase(context, slot);
    page[slot][stubborn] = 0x7F;
    return is_erased;
}

/* Wherever it is, a byte that was not erased is found before anything is written. */
static void test_a_byte_that_stays_is_found(void)
{
    static const unsigned bytes[] = {0, 1, 2, SWAY_BLOCK_SIZE / 2U, SWAY_BLOCK_SIZE - 1U};
    const sway_store_t bad = {.size = SWAY_BLOCK_SIZE,
                              .check = sway_block_check,
                              .read = read,
                              .erase = erase_badly,
                              .write = write};
    const sway_core_config_t config = good_config();
    uint8_t block[SWAY_BLOCK_SIZE];
    for (unsigned i = 0; i < sizeof bytes / sizeof bytes[0]; i++) {
        setUp();
        stubborn = bytes[i];
        sway_block_write(&config, 1, block);
        TEST_ASSERT_FALSE(sway_store_write(&bad, block, sizeof block));
        for (unsigned at = 0; at < SWAY_BLOCK_SIZE; at++) {
            TEST_ASSERT_EQUAL_HEX8(at == stubborn ? 0x7F : 0xFF, page[0][at]);
        }
        TEST_ASSERT_TRUE(sway_store_write(&flash, block, sizeof block));
    }
}

/* Of two blocks of one number the first is used; a stale copy of it never wins. */
static void test_of_equal_numbers_the_first_counts(void)
{
    sway_core_config_t config = good_config();
    put_block(0, &config, 7);
    config.alarm.hold_ms += 100;
    put_block(1, &config, 7);
    start();
    TEST_ASSERT_EQUAL_INT32(good_config().alarm.hold_ms, sway_ecu_config(&ecu)->alarm.hold_ms);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_good_block_starts);
    RUN_TEST(test_empty_flash_is_the_safe_state);
    RUN_TEST(test_damaged_block_is_never_used);
    RUN_TEST(test_block_of_another_version_is_refused);
    RUN_TEST(test_intact_block_with_wrong_values_is_refused);
    RUN_TEST(test_newest_good_block_wins);
    RUN_TEST(test_what_the_memory_calls_damaged_is_not_used);
    RUN_TEST(test_power_cut_at_every_byte_of_a_store);
    RUN_TEST(test_power_cut_with_nothing_stored_before);
    RUN_TEST(test_dead_flash_keeps_the_old_block);
    RUN_TEST(test_flash_that_does_not_hold_is_found);
    RUN_TEST(test_checksum_is_that_of_single_bits);
    RUN_TEST(test_every_word_beyond_the_vehicle_has_its_range);
    RUN_TEST(test_a_block_with_a_silent_alarm_is_refused);
    RUN_TEST(test_a_byte_that_stays_is_found);
    RUN_TEST(test_of_equal_numbers_the_first_counts);
    return UNITY_END();
}

/* The trailer remembered in the flash of port/stm32g4, against the model of its registers: which
 * pages are written, and what the program knows again when it starts. */
#include "model_stm32g4.h"
#include "port_test.h"
#include "program.h"
#include "stm32g474.h"
#include "sway_store.h"

#define TRAILER_PAGE 3U
#define PAGE(number) (model_flash + (number)*STM32_FLASH_PAGE)

static sway_ecu_retained_t retained;

static void start(void)
{
    model_restart();
    TEST_ASSERT_TRUE(program_start(&retained, SWAY_ECU_NO_CAUSE));
    TEST_ASSERT_EQUAL(SWAY_ECU_RUNNING, program_ecu()->state);
}

/* Parameters in the first page, a key in the third, no trailer. */
void setUp(void)
{
    const sway_core_config_t config = good_config();
    model_flash_new();
    sway_block_write(&config, 1, PAGE(0));
    memcpy(PAGE(2), test_key, sizeof test_key);
    memset(&retained, 0, sizeof retained);
    model_nmi = program_nmi;
    model_power_on();
    start();
}

void tearDown(void)
{
}

/* The program's ECU, which a test changes. */
static sway_ecu_t *ecu(void)
{
    return (sway_ecu_t *)program_ecu();
}

static sway_trailer_watch_t *watch(void)
{
    return &ecu()->node.core.watch;
}

/* A drive learns a trailer `parts` tenths of a standard error away from where it began, and a car
 * whose front tyres are `front` thousandths off; then the ignition is turned off. */
static void drive(int parts, int front)
{
    sway_trailer_watch_t *const w = watch();
    w->presence = SWAY_TRAILER_THERE;
    w->learnt_ms = 120000;
    w->with.x[SWAY_STATE_CAR_FRONT] = sway_real_ratio(front, 1000);
    for (uint32_t i = 0; i < SWAY_TRAILER_UNKNOWNS; i++) {
        const uint32_t state = SWAY_STATE_TRAILER_MASS + i;
        w->with.x[state] = sway_real_add(
            w->start[i], sway_real_mul(w->start_error[i], sway_real_ratio(parts, 10)));
        w->with.p[state * (state + 1U) / 2U + state] = sway_real_mul(
            sway_real_mul(w->start_error[i], w->start_error[i]), sway_real_ratio(1, 100));
    }
    (void)sway_remember_look(&ecu()->remember, w);
    sway_ecu_leave(ecu());
}

static void expect_pages(uint32_t fourth, uint32_t fifth)
{
    const uint32_t wanted[SWAY_STORE_SLOTS] = {fourth, fifth};
    for (uint32_t slot = 0; slot < SWAY_STORE_SLOTS; slot++) {
        uint32_t sequence = 0;
        const sway_block_result_t found =
            sway_remember_check(PAGE(TRAILER_PAGE + slot), SWAY_REMEMBER_SIZE, &sequence);
        TEST_ASSERT_EQUAL(wanted[slot] == 0U ? SWAY_BLOCK_EMPTY : SWAY_BLOCK_OK, found);
        TEST_ASSERT_EQUAL_UINT32(wanted[slot], wanted[slot] == 0U ? 0U : sequence);
    }
}

static void expect_car(int front)
{
    TEST_ASSERT_TRUE(ecu()->remember.has_memory);
    TEST_ASSERT_TRUE(sway_real_compare(sway_real_ratio(front, 1000),
                                       watch()->alone.x[SWAY_STATE_CAR_FRONT]) == 0);
}

/* In turn, with what was in both pages before them untouched; the next start knows the last one. */
static void test_trailers_are_kept_in_the_fourth_and_fifth_page(void)
{
    static uint8_t before[TRAILER_PAGE * STM32_FLASH_PAGE];
    static const struct {
        uint32_t fourth, fifth;
    } pages[] = {{1, 0}, {1, 2}, {3, 2}, {3, 4}};
    memcpy(before, model_flash, sizeof before);
    TEST_ASSERT_FALSE(ecu()->remember.has_memory);
    TEST_ASSERT_TRUE(sway_real_is_zero(watch()->alone.x[SWAY_STATE_CAR_FRONT]));
    for (int i = 0; i < 4; i++) {
        drive(i % 2 == 0 ? 8 : -8, 70 + i); // another one each time
        expect_pages(pages[i].fourth, pages[i].fifth);
        TEST_ASSERT_EQUAL_MEMORY(before, model_flash, sizeof before);
        start();
        TEST_ASSERT_EQUAL_UINT32(i + 1, ecu()->remember.sequence);
        expect_car(70 + i);
    }
}

/* Damaged by a power cut it is learnt again, and the one before is still known; no warning. */
static void test_a_damaged_trailer_is_no_warning(void)
{
    drive(8, 70);
    start();
    drive(-8, 71);
    PAGE(TRAILER_PAGE + 1U)[40] ^= 1U;
    start();
    expect_car(70);
    TEST_ASSERT_EQUAL(SWAY_ECU_NO_CAUSE, ecu()->notice);
    PAGE(TRAILER_PAGE)[40] ^= 1U;
    start();
    TEST_ASSERT_FALSE(ecu()->remember.has_memory);
    TEST_ASSERT_EQUAL(SWAY_ECU_NO_CAUSE, ecu()->notice);
    drive(8, 72); // and is kept again
    start();
    expect_car(72);
}

/* A torn double word of the record restarts nothing. */
static void test_a_torn_trailer_is_survived(void)
{
    drive(8, 70);
    model_flash_tear(TRAILER_PAGE * STM32_FLASH_PAGE + 16U);
    start();
    TEST_ASSERT_FALSE(model_nmi_restarts());
    TEST_ASSERT_FALSE(ecu()->remember.has_memory);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_trailers_are_kept_in_the_fourth_and_fifth_page);
    RUN_TEST(test_a_damaged_trailer_is_no_warning);
    RUN_TEST(test_a_torn_trailer_is_survived);
    return UNITY_END();
}

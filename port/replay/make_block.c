/* make_block VEHICLE.TOML BLOCK [sample_period_us=N] [KEY=VALUE ...]: the parameter block for an
 * ECU's flash.
 * make_block --list: number, name, default, lowest and highest value of each word, as
 * SwayParameterRequest counts them; "or 0" where 0 (unknown) is allowed besides.
 *
 * The vehicle (see vehicle_file.h; a KEY=VALUE wins over the file) and the defaults for all that is
 * not of the vehicle, checked as the ECU will check them. Runs on the host. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sway_block.h"
#include "vehicle_file.h"

#define PERIOD "sample_period_us="

static int refuse(const char *what, const char *why)
{
    fprintf(stderr, "make_block: %s%s%s\n", what, why[0] == '\0' ? "" : ": ", why);
    return 1;
}

#define WORD_OF(field) (offsetof(sway_core_config_t, field) / sizeof(int32_t))

/* The name of a word: a vehicle's as in vehicle.toml, others as in the core's headers. */
static const char *name_of(size_t word)
{
    static const char *const alarm[] = {"alarm.notice_margin_mm_s",
                                        "alarm.margin_hysteresis_mm_s",
                                        "alarm.notice_damping_ratio_ppm",
                                        "alarm.damping_hysteresis_ppm",
                                        "alarm.minimum_amplitude_urad_s",
                                        "alarm.large_amplitude_urad_s",
                                        "alarm.limit_amplitude_urad_s",
                                        "alarm.critical_time_ms",
                                        "alarm.hold_ms",
                                        "alarm.minimum_speed_mm_s",
                                        "alarm.confidence_milli"};
    typedef char all_alarm_words_have_a_name
        [sizeof alarm / sizeof alarm[0] == sizeof(sway_alarm_config_t) / sizeof(int32_t) ? 1 : -1];
    size_t count = 0;
    const sway_vehicle_range_t *ranges = sway_vehicle_ranges(&count);
    for (size_t i = 0; i < count; i++) {
        if ((offsetof(sway_core_config_t, vehicle) + ranges[i].offset) / sizeof(int32_t) == word) {
            return sway_vehicle_name(&ranges[i])->key;
        }
    }
    (void)sizeof(all_alarm_words_have_a_name);
    if (word == WORD_OF(trailer_assumed)) {
        return "trailer_assumed";
    }
    if (word >= WORD_OF(alarm)) {
        return alarm[word - WORD_OF(alarm)];
    }
    if (word == WORD_OF(input_period_us)) {
        return "input_period_us";
    }
    if (word >= WORD_OF(input_delay_us)) {
        return "input_delay_us";
    }
    return word == WORD_OF(window_cycles_milli) ? "window_cycles_milli" : "sample_period_us";
}

static int list(void)
{
    sway_core_config_t config;
    sway_core_defaults(&config);
    for (uint32_t word = 0; word < SWAY_BLOCK_WORDS; word++) {
        int32_t value = 0;
        (void)sway_block_get(&config, word, &value);
        printf("%u %s", (unsigned)word, name_of(word));
        if (word >= WORD_OF(input_delay_us) && word < WORD_OF(input_period_us)) {
            printf("[%u]", (unsigned)(word - WORD_OF(input_delay_us)));
        }
        int32_t low = 0;
        int32_t high = 0;
        bool may_be_zero = false;
        (void)sway_block_range(word, &low, &high, &may_be_zero);
        const bool adds_zero = may_be_zero && (low > 0 || high < 0);
        printf(" %ld %ld %ld%s\n", (long)value, (long)low, (long)high, adds_zero ? " or 0" : "");
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "--list") == 0) {
        return list();
    }
    char message[256];
    uint8_t block[SWAY_BLOCK_SIZE];
    sway_core_config_t config;
    if (argc < 3) {
        return refuse("wanted VEHICLE.TOML BLOCK [sample_period_us=N] [KEY=VALUE ...]", "");
    }
    sway_core_defaults(&config);
    int first = 3;
    if (argc > first && strncmp(argv[first], PERIOD, sizeof PERIOD - 1U) == 0) {
        config.sample_period_us = (int32_t)strtol(argv[first] + sizeof PERIOD - 1U, NULL, 10);
        if (config.sample_period_us < 5000 || config.sample_period_us > 20000) {
            return refuse(argv[first], "5000 to 20000");
        }
        first++;
    }
    if (!vehicle_file_read(argv[1], argv + first, (size_t)(argc - first), &config.vehicle, message,
                           sizeof message)) {
        return refuse(message, "");
    }
    sway_block_write(&config, 1, block);
    FILE *file = fopen(argv[2], "wb");
    if (file == NULL) {
        return refuse(argv[2], "cannot be written");
    }
    const bool written = fwrite(block, 1, sizeof block, file) == sizeof block;
    return fclose(file) == 0 && written ? 0 : refuse(argv[2], "cannot be written");
}

#include "vehicle_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "names.h"

#define LINE_MAX_LENGTH 400

typedef struct {
    const char *path;
    char *message;
    size_t size;
    int line; ///< 0: a setting
    char where[200];
    const char *table; ///< that keys belong to; NULL before the first
    sway_vehicle_t vehicle;
    bool seen[64];
    bool has_trailer;
} reader_t;

static char *trim(char *text)
{
    text += strspn(text, " \t\r\n");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t\r\n", text[length - 1]) != NULL) {
        text[--length] = '\0';
    }
    return text;
}

/* "vehicle.toml:12", or the setting itself. */
static const char *place(reader_t *r)
{
    if (r->line == 0) {
        return r->path;
    }
    snprintf(r->where, sizeof r->where, "%.160s:%d", r->path, r->line);
    return r->where;
}

static bool refuse(reader_t *r, const char *what, const char *value)
{
    snprintf(r->message, r->size, "%s: %s: \"%.80s\"", place(r), what, value);
    return false;
}

/* An unknown key, with the one of this table that was probably meant. */
static bool refuse_key(reader_t *r, const char *key)
{
    size_t count = 0;
    const sway_vehicle_range_t *ranges = sway_vehicle_ranges(&count);
    const size_t table = strlen(r->table);
    const char *nearest = NULL;
    size_t least = NAMES_ALIKE + 1U;
    for (size_t i = 0; i < count; i++) {
        const char *name = sway_vehicle_name(&ranges[i])->key;
        const bool here = strncmp(name, r->table, table) == 0 && name[table] == '.';
        const size_t apart = here ? names_apart(key, strlen(key), name + table + 1U) : least;
        if (apart < least) {
            least = apart;
            nearest = name + table + 1U;
        }
    }
    (void)refuse(r, "unknown key", key);
    if (nearest != NULL) {
        const size_t said = strlen(r->message);
        snprintf(r->message + said, r->size - said, "; did you mean \"%s\"?", nearest);
    }
    return false;
}

static void *field(sway_vehicle_t *vehicle, const sway_vehicle_range_t *range)
{
    return (char *)vehicle + range->offset;
}

static const sway_vehicle_range_t *find(const char *table, const char *key, size_t *index)
{
    char name[96];
    size_t count = 0;
    const sway_vehicle_range_t *ranges = sway_vehicle_ranges(&count);
    snprintf(name, sizeof name, "%s.%s", table, key);
    for (*index = 0; *index < count; (*index)++) {
        if (strcmp(sway_vehicle_name(&ranges[*index])->key, name) == 0) {
            return &ranges[*index];
        }
    }
    return NULL;
}

static bool use_table(reader_t *r, const char *name)
{
    const bool is_trailer = strcmp(name, "trailer") == 0;
    if (!is_trailer && strcmp(name, "car") != 0) {
        return refuse(r, "unknown table; known are [car] and [trailer]", name);
    }
    r->table = is_trailer ? "trailer" : "car";
    r->has_trailer = r->has_trailer || is_trailer;
    return true;
}

static bool read_table(reader_t *r, char *text)
{
    char *end = strchr(text, ']');
    if (end == NULL || end[1] != '\0') {
        return refuse(r, "a table is written as [car] or [trailer]", text);
    }
    *end = '\0';
    return use_table(r, trim(text + 1));
}

static bool parse_number(char *text, double *value)
{
    char clean[64];
    size_t n = 0;
    for (const char *c = text; *c != '\0' && n + 1 < sizeof clean; c++) {
        if (*c != '_') { /* TOML allows 109_300.0 */
            clean[n++] = *c;
        }
    }
    clean[n] = '\0';
    char *end = clean;
    errno = 0;
    *value = strtod(clean, &end);
    return end != clean && *end == '\0' && errno == 0 && isfinite(*value);
}

static bool read_value(reader_t *r, const char *key, char *text)
{
    if (r->table == NULL) {
        return refuse(r, "a key before the first table [car]", key);
    }
    size_t index = 0;
    const sway_vehicle_range_t *range = find(r->table, key, &index);
    double value = 0.0;
    if (range == NULL) {
        return refuse_key(r, key);
    }
    if (!parse_number(text, &value)) {
        return refuse(r, "not a number", text);
    }
    const sway_vehicle_name_t *named = sway_vehicle_name(range);
    const double scaled = round(value * named->scale);
    const double low = (double)range->low / named->scale;
    const double high = (double)range->high / named->scale;
    if (!(scaled >= range->low && scaled <= range->high)) {
        snprintf(r->message, r->size, "%s: %s = %g is out of range; expected %g to %g (SI)",
                 place(r), named->key, value, low, high);
        return false;
    }
    const int32_t integer = (int32_t)scaled;
    memcpy(field(&r->vehicle, range), &integer, sizeof integer);
    r->seen[index] = true;
    return true;
}

static bool read_line(reader_t *r, char *line)
{
    char *comment = strchr(line, '#');
    if (comment != NULL) {
        *comment = '\0';
    }
    char *text = trim(line);
    if (*text == '\0') {
        return true;
    }
    if (*text == '[') {
        return read_table(r, text);
    }
    char *equals = strchr(text, '=');
    if (equals == NULL) {
        return refuse(r, "expected \"key = number\"", text);
    }
    *equals = '\0';
    return read_value(r, trim(text), trim(equals + 1));
}

#define LINES_MAX 10000

static bool read_lines(reader_t *r, FILE *file)
{
    char line[LINE_MAX_LENGTH];
    while (fgets(line, sizeof line, file) != NULL) {
        r->line++;
        const size_t length = strlen(line);
        if ((length == 0U || line[length - 1U] != '\n') && feof(file) == 0) {
            return refuse(r, length + 1 == sizeof line ? "line too long" : "a zero byte", line);
        }
        if (r->line > LINES_MAX) {
            return refuse(r, "too many lines for a vehicle", line);
        }
        if (!read_line(r, line)) {
            return false;
        }
    }
    return true;
}

static bool check(reader_t *r)
{
    size_t index = 0;
    if (r->has_trailer && find("trailer", "axles", &index) != NULL && !r->seen[index]) {
        (void)find("trailer", "front_axle_to_cog", &index);
        r->vehicle.trailer.axles = r->seen[index] ? 2 : 1;
    }
    const sway_vehicle_range_t *offender = NULL;
    if (sway_vehicle_check(&r->vehicle, &offender) == SWAY_OK) {
        return true;
    }
    if (offender == NULL) {
        snprintf(r->message, r->size, "%s: vehicle refused", r->path);
        return false;
    }
    const sway_vehicle_name_t *named = sway_vehicle_name(offender);
    const double scale = named->scale;
    snprintf(r->message, r->size, "%s: %s = %g is missing or out of range; expected %g to %g (SI)",
             r->path, named->key, sway_vehicle_value(&r->vehicle, offender) / scale,
             offender->low / scale, offender->high / scale);
    return false;
}

/* "car.mass=1900": as a line of its own in the table that it names. */
static bool read_setting(reader_t *r, const char *setting)
{
    char text[LINE_MAX_LENGTH];
    snprintf(text, sizeof text, "%s", setting);
    char *dot = strchr(text, '.');
    char *equals = strchr(text, '=');
    if (dot == NULL || equals == NULL || dot > equals) {
        return refuse(r, "expected \"car.key=number\" or \"trailer.key=number\"", setting);
    }
    *dot = '\0';
    *equals = '\0';
    return use_table(r, text) && read_value(r, dot + 1, equals + 1);
}

static bool read_file(reader_t *r)
{
    FILE *file = fopen(r->path, "r");
    if (file == NULL) {
        snprintf(r->message, r->size, "%s: %s", r->path, strerror(errno));
        return false;
    }
    bool is_read = read_lines(r, file);
    if (is_read && ferror(file) != 0) {
        snprintf(r->message, r->size, "%s: cannot be read", r->path);
        is_read = false;
    }
    fclose(file);
    return is_read;
}

bool vehicle_file_read(const char *path, char *const *settings, size_t setting_count,
                       sway_vehicle_t *vehicle, char *message, size_t size)
{
    reader_t reader = {.path = path, .message = message, .size = size};
    if (!read_file(&reader)) {
        return false;
    }
    for (size_t i = 0; i < setting_count; i++) {
        reader.path = settings[i];
        reader.line = 0;
        if (!read_setting(&reader, settings[i])) {
            return false;
        }
    }
    reader.path = path;
    if (!check(&reader)) {
        return false;
    }
    *vehicle = reader.vehicle;
    return true;
}

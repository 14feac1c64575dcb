#include "names.h"

#define NAME_MOST 32U

size_t names_apart(const char *a, size_t size, const char *b)
{
    size_t row[NAME_MOST];
    if (size >= NAME_MOST) {
        return NAME_MOST;
    }
    for (size_t i = 0; i <= size; i++) {
        row[i] = i;
    }
    for (; *b != '\0'; b++) {
        size_t left_above = row[0];
        row[0]++;
        for (size_t i = 1; i <= size; i++) {
            const size_t above = row[i];
            size_t least = left_above + (a[i - 1U] != *b ? 1U : 0U);
            least = above + 1U < least ? above + 1U : least;
            row[i] = row[i - 1U] + 1U < least ? row[i - 1U] + 1U : least;
            left_above = above;
        }
    }
    return row[size];
}

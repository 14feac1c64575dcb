/// names: how unlike two names are, for "did you mean" in programs on a host.
#ifndef SWAY_NAMES_H
#define SWAY_NAMES_H

#include <stddef.h>

/// Up to so many letters apart a name was probably meant.
#define NAMES_ALIKE 2U

/// Letters to be changed, put in or left out between the first `size` letters of `a` and `b`;
/// 32 where `a` has as many or more. Effort: the product of both lengths.
size_t names_apart(const char *a, size_t size, const char *b);

#endif

// SPDX-License-Identifier: MIT
/// sway_real_ops: short names for formulas, for source files only.
#ifndef SWAY_REAL_OPS_H
#define SWAY_REAL_OPS_H

#include "arithmetic/sway_real.h"

#define ADD sway_real_add
#define SUB sway_real_sub
#define MUL sway_real_mul
#define DIV sway_real_div
#define NEG sway_real_neg

#endif

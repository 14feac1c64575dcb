// SPDX-License-Identifier: MIT
/// sway_fit: the linear algebra under sway_line: columns of the model, their products, small
/// solves.
///
/// Columns over the blocks b = 0..n-1 of a window, tau = (2 b - n + 1) / (n - 1) in [-1, 1], and
/// z = scale e^((growth + j omega) (b - (n-1)/2)) with the largest |z| = 1 (and a known chirp):
///     0, 1: Re z, -Im z       x = a Re z - b Im z is Re((a + j b) z)
///     2, 3: 1, tau            mean and slope
///     4, 5: Re z^2, -Im z^2   6, 7: Re z^3, -Im z^3
///     8, 9: tau times columns 0, 1: the derivatives with respect to growth and omega
/// Every channel has the same columns, so their products are made once for all channels.
#ifndef SWAY_FIT_H
#define SWAY_FIT_H

#include "arithmetic/sway_real.h"

/// Most blocks in a window: sums of rows that the fit works on. Ten to an oscillation cost 1.5 % of
/// precision, thirty 0.2 %.
#ifndef SWAY_FIT_BLOCKS
#define SWAY_FIT_BLOCKS 64
#endif
#if SWAY_FIT_BLOCKS < 32 || SWAY_FIT_BLOCKS > 64
#error "SWAY_FIT_BLOCKS: 32 to 64"
#endif
#define SWAY_FIT_COLUMNS 10
/// Linear parameters: columns 0..7.
#define SWAY_FIT_LINEAR 8
#define SWAY_FIT_MEAN 2
#define SWAY_FIT_SLOPE 3
#define SWAY_FIT_TAU_RE 8
#define SWAY_FIT_TAU_IM 9
/// Columns are Q28.
#define SWAY_FIT_BITS 28

/// A complex number in Q30.
typedef struct {
    int32_t re;
    int32_t im;
} sway_fit_q30_t;

/// How far the columns are made. They are made from the end of the window where |z| = 1.
typedef struct {
    bool backward; ///< from the last block on
    bool is_bent;
    bool has_tone;
    uint32_t done; ///< blocks
    sway_fit_q30_t z;
    sway_fit_q30_t step; ///< from one block to the next
    sway_fit_q30_t bend; ///< of the step
    sway_fit_q30_t tone; ///< columns 6 and 7, if they are a tone
    sway_fit_q30_t tone_step;
} sway_fit_walk_t;

typedef struct {
    uint32_t blocks;
    sway_real_t scale; ///< e^(-|growth| (n-1)/2), so that |z| <= 1
    sway_fit_walk_t walk;
    sway_real_t gram[SWAY_FIT_COLUMNS * (SWAY_FIT_COLUMNS + 1) / 2]; ///< products of columns, the
                                                                     ///< lower triangle by rows
    int32_t column[SWAY_FIT_COLUMNS][SWAY_FIT_BLOCKS];
} sway_fit_basis_t;

/// Least squares on columns 0..n-1 (n = 4: one line; n = 8: with 2f and 3f). Their factor is in the
/// basis, the same for both.
typedef struct {
    uint32_t n;
    sway_real_t cross[2][SWAY_FIT_LINEAR]; ///< solutions for columns 8 and 9
    sway_real_t schur[3];    ///< what of columns 8, 9 the linear part leaves: (8,8), (8,9), (9,9)
    sway_real_t variance[3]; ///< of parameters 0, 1 for unit noise: (0,0), (0,1), (1,1)
    sway_real_t second_variance; ///< of parameters 4, 5, mean of both; n = 8 only
} sway_fit_system_t;

/// Shape of the line, per block: z = scale e^(growth u + j (omega u + chirp u^2 / 2)), u = b -
/// (n-1)/2.
typedef struct {
    sway_real_t growth; ///< |growth| (n-1)/2 <= 8
    sway_real_t omega;
    sway_real_t chirp;  ///< known change of omega per block; 0 for a line of one frequency
    sway_real_t forced; ///< not 0: columns 6, 7 are a steady tone of this omega instead of 3f
} sway_fit_pole_t;

/// Begins to make the columns over blocks 2..64.
void sway_fit_begin(sway_fit_basis_t *basis, uint32_t blocks, const sway_fit_pole_t *pole);
/// Makes them for up to `count` more blocks, columns 4 to 7 only if asked for; true while blocks
/// are left.
bool sway_fit_columns(sway_fit_basis_t *basis, uint32_t count, bool harmonics);
/// Products of columns first..last with those up to themselves and with 8 and 9.
/// sway_fit_gram(basis, 0, 3) makes what n = 4 needs; then (basis, 4, 5), (basis, 6, 7) what n = 8
/// adds.
void sway_fit_gram(sway_fit_basis_t *basis, uint32_t first, uint32_t last);

/// Holds the slope at 0 (to 2^-40 of what it would be), before the factor is made.
void sway_fit_pin_slope(sway_fit_basis_t *basis);

/// Puts the factor L D L^T in the place of the products, rows first..last, when those before are
/// done: L, and 1/d on the diagonal. (0, 3), then (4, 7).
void sway_fit_factor(sway_fit_basis_t *basis, uint32_t first, uint32_t last);

/// The steps of building a system of n columns, each of bounded cost, in this order.
void sway_fit_cross(sway_fit_system_t *system, const sway_fit_basis_t *basis, uint32_t n);
void sway_fit_variance(sway_fit_system_t *system, const sway_fit_basis_t *basis);
void sway_fit_second_variance(sway_fit_system_t *system, const sway_fit_basis_t *basis);

/// x = (products of columns)^-1 right, for columns 0..n-1; x may be `right`.
void sway_fit_solve(const sway_fit_basis_t *basis, uint32_t n, const sway_real_t *right,
                    sway_real_t *x);

/// a[0] b[0] + .. + a[n-1] b[n-1], n > 0.
sway_real_t sway_fit_dot(const sway_real_t *a, const sway_real_t *b, uint32_t n);

/// Sum over the blocks of column times data; |data| < 2^27.
sway_real_t sway_fit_product(const sway_fit_basis_t *basis, uint32_t column, const int32_t *data);

/// Takes the mean out of `sums` and scales by 2^-shift to magnitudes below 2^27. Returns the shift.
int32_t sway_fit_center(const int64_t *sums, uint32_t n, int32_t *data, int64_t *mean);

/// Model of the linear parameters 0..n-1 at the blocks whose bit is set in `blocks`, rounded,
/// |model| <= 2^28; other entries stay as they are.
void sway_fit_model(const sway_fit_basis_t *basis, const sway_real_t *parameter, uint32_t n,
                    uint64_t blocks, int32_t *model);

#endif

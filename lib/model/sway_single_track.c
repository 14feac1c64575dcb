// SPDX-License-Identifier: MIT
#include "model/sway_single_track.h"

#include "arithmetic/sway_real_ops.h"

/* Short names for the arithmetic, to keep formulas readable. */
#define CADD sway_complex_add
#define CSUB sway_complex_sub
#define CMUL sway_complex_mul
#define CSCALE sway_complex_scale

/* P and Q of one body at one (s, v). */
typedef struct {
    sway_complex_t p;
    sway_complex_t q;
} factors_t;

/* P and Q as polynomials of s and u = 1/v: p = p2 s^2 + p1 u s + p02 u^2 + p00,
 * q = q2 s^2 + q1 u s + q0. */
typedef struct {
    sway_real_t p2;
    sway_real_t p1;
    sway_real_t p02;
    sway_real_t p00;
    sway_real_t q2;
    sway_real_t q1;
    sway_real_t q0;
} body_poly_t;

/* The quartic as polynomials of u: a4, a3 u, a20 + a22 u^2, a11 u + a13 u^3, a00 + a02 u^2. */
typedef struct {
    sway_real_t a4;
    sway_real_t a3;
    sway_real_t a20;
    sway_real_t a22;
    sway_real_t a11;
    sway_real_t a13;
    sway_real_t a00;
    sway_real_t a02;
} speed_poly_t;

static sway_real_t zero(void)
{
    return sway_real_zero();
}

static sway_complex_t from_real(sway_real_t a)
{
    return sway_complex(a, zero());
}

sway_real_t sway_single_track_speed_low(void)
{
    return sway_real_ratio(10000, 3600);
}

sway_real_t sway_single_track_speed_high(void)
{
    return sway_real_ratio(250000, 3600);
}

static sway_real_t metre(int32_t micrometre)
{
    return sway_real_micro(micrometre);
}

static void car_from_vehicle(sway_single_track_body_t *body, const sway_car_t *car)
{
    body->mass_kg = sway_real_ratio(car->mass_g, 1000);
    body->yaw_inertia_kgm2 = sway_real_ratio(car->yaw_inertia_gm2, 1000);
    body->axle_m[0] = metre(car->front_axle_to_cog_um);
    body->axle_m[1] = metre(-car->rear_axle_to_cog_um);
    body->hitch_m = metre(-car->hitch_to_cog_um);
    body->stiffness_n_per_rad[0] = sway_real_int(car->front_cornering_stiffness_n_per_rad);
    body->stiffness_n_per_rad[1] = sway_real_int(car->rear_cornering_stiffness_n_per_rad);
    body->relaxation_m[0] = zero();
    body->relaxation_m[1] = zero();
}

static void trailer_from_vehicle(sway_single_track_body_t *body, const sway_trailer_t *trailer)
{
    const bool tandem = trailer->axles == 2;
    body->mass_kg = sway_real_ratio(trailer->mass_g, 1000);
    body->yaw_inertia_kgm2 = sway_real_ratio(trailer->yaw_inertia_gm2, 1000);
    body->axle_m[0] = metre(tandem ? trailer->front_axle_to_cog_um : 0);
    body->axle_m[1] = metre(-trailer->rear_axle_to_cog_um);
    body->hitch_m = metre(trailer->hitch_to_cog_um);
    body->stiffness_n_per_rad[0] =
        sway_real_int(tandem ? trailer->front_cornering_stiffness_n_per_rad : 0);
    body->stiffness_n_per_rad[1] = sway_real_int(trailer->rear_cornering_stiffness_n_per_rad);
    body->relaxation_m[0] = zero();
    body->relaxation_m[1] = zero();
}

sway_error_t sway_single_track_from_vehicle(sway_single_track_t *stm, const sway_vehicle_t *vehicle)
{
    if (sway_vehicle_check(vehicle, NULL) != SWAY_OK || !sway_vehicle_is_complete(vehicle)) {
        return SWAY_ERROR_VEHICLE;
    }
    stm->has_trailer = vehicle->trailer.axles > 0;
    car_from_vehicle(&stm->body[SWAY_SINGLE_TRACK_CAR], &vehicle->car);
    trailer_from_vehicle(&stm->body[SWAY_SINGLE_TRACK_TRAILER], &vehicle->trailer);
    return SWAY_OK;
}

/* --- f(s, v) with relaxation ------------------------------------------------------------------ */

static sway_complex_t stiffness_at(const sway_single_track_body_t *body, int axle,
                                   sway_complex_t s_by_v)
{
    const sway_complex_t c = from_real(body->stiffness_n_per_rad[axle]);
    if (sway_real_is_zero(body->relaxation_m[axle]) || sway_real_is_zero(c.re)) {
        return c;
    }
    const sway_complex_t lag = CSCALE(s_by_v, body->relaxation_m[axle]);
    return sway_complex_div(c, CADD(from_real(sway_real_int(1)), lag));
}

/* sum + term factor */
static void add_scaled(sway_complex_t *sum, const sway_complex_t *term, sway_real_t factor)
{
    sum->re = ADD(sum->re, MUL(term->re, factor));
    sum->im = ADD(sum->im, MUL(term->im, factor));
}

static factors_t body_factors(const sway_single_track_body_t *body, sway_complex_t s, sway_real_t v)
{
    const sway_complex_t z = sway_complex(DIV(s.re, v), DIV(s.im, v));
    const sway_complex_t s2 = CMUL(s, s);
    const sway_real_t m = body->mass_kg;
    const sway_real_t inertia = body->yaw_inertia_kgm2;
    const sway_real_t base_by_v = DIV(SUB(body->axle_m[0], body->axle_m[1]), v);
    const sway_complex_t none = from_real(zero());
    /* Sums over the axles of C times m x^2 + I, x, d and d^2, d being the distance to the hitch. */
    sway_complex_t turn = none;
    sway_complex_t moment = none;
    sway_complex_t k1 = none;
    sway_complex_t k2 = none;
    sway_complex_t c[2];
    for (int axle = 0; axle < 2; axle++) {
        const sway_real_t x = body->axle_m[axle];
        const sway_real_t d = SUB(x, body->hitch_m);
        c[axle] = stiffness_at(body, axle, z);
        add_scaled(&turn, &c[axle], ADD(MUL(m, sway_real_square(x)), inertia));
        add_scaled(&moment, &c[axle], x);
        add_scaled(&k1, &c[axle], d);
        add_scaled(&k2, &c[axle], sway_real_square(d));
    }
    const sway_complex_t cross = CSCALE(CMUL(c[0], c[1]), sway_real_square(base_by_v));
    const sway_real_t about_hitch = ADD(inertia, MUL(m, sway_real_square(body->hitch_m)));
    factors_t result;
    result.p = CADD(CSCALE(s2, MUL(m, inertia)), CMUL(turn, z));
    result.p = CADD(result.p, CSUB(cross, CSCALE(moment, m)));
    result.q = CSUB(CADD(CSCALE(s2, about_hitch), CMUL(k2, z)), k1);
    return result;
}

sway_complex_t sway_single_track_characteristic(const sway_single_track_t *stm, sway_complex_t s,
                                                sway_real_t v)
{
    const factors_t car = body_factors(&stm->body[SWAY_SINGLE_TRACK_CAR], s, v);
    if (!stm->has_trailer) {
        return car.p;
    }
    const factors_t trailer = body_factors(&stm->body[SWAY_SINGLE_TRACK_TRAILER], s, v);
    return CADD(CMUL(car.p, trailer.q), CMUL(trailer.p, car.q));
}

/* --- the quartic ------------------------------------------------------------------------------ */

static body_poly_t body_poly(const sway_single_track_body_t *body)
{
    const sway_real_t m = body->mass_kg;
    const sway_real_t h = body->hitch_m;
    const sway_real_t base = SUB(body->axle_m[0], body->axle_m[1]);
    sway_real_t sum = zero();
    sway_real_t moment = zero();
    sway_real_t second = zero();
    body_poly_t poly;
    poly.q1 = zero();
    poly.q0 = zero();
    for (int axle = 0; axle < 2; axle++) {
        const sway_real_t c = body->stiffness_n_per_rad[axle];
        const sway_real_t x = body->axle_m[axle];
        const sway_real_t d = SUB(x, h);
        sum = ADD(sum, c);
        moment = ADD(moment, MUL(c, x));
        second = ADD(second, MUL(c, sway_real_square(x)));
        poly.q1 = ADD(poly.q1, MUL(c, sway_real_square(d)));
        poly.q0 = SUB(poly.q0, MUL(c, d));
    }
    poly.p2 = MUL(m, body->yaw_inertia_kgm2);
    poly.p1 = ADD(MUL(m, second), MUL(body->yaw_inertia_kgm2, sum));
    poly.p02 = MUL(MUL(body->stiffness_n_per_rad[0], body->stiffness_n_per_rad[1]),
                   sway_real_square(base));
    poly.p00 = sway_real_neg(MUL(m, moment));
    poly.q2 = ADD(body->yaw_inertia_kgm2, MUL(m, sway_real_square(h)));
    return poly;
}

static sway_real_t pair(sway_real_t a, sway_real_t b, sway_real_t c, sway_real_t d)
{
    return ADD(MUL(a, b), MUL(c, d));
}

static speed_poly_t speed_poly(const sway_single_track_t *stm)
{
    const body_poly_t c = body_poly(&stm->body[SWAY_SINGLE_TRACK_CAR]);
    const body_poly_t t = body_poly(&stm->body[SWAY_SINGLE_TRACK_TRAILER]);
    speed_poly_t poly;
    if (!stm->has_trailer) {
        const speed_poly_t solo = {zero(), zero(), c.p2, zero(), c.p1, zero(), c.p00, c.p02};
        return solo;
    }
    poly.a4 = pair(c.p2, t.q2, t.p2, c.q2);
    poly.a3 = ADD(pair(c.p2, t.q1, c.p1, t.q2), pair(t.p2, c.q1, t.p1, c.q2));
    poly.a20 = ADD(pair(c.p2, t.q0, c.p00, t.q2), pair(t.p2, c.q0, t.p00, c.q2));
    poly.a22 = ADD(pair(c.p1, t.q1, c.p02, t.q2), pair(t.p1, c.q1, t.p02, c.q2));
    poly.a11 = ADD(pair(c.p1, t.q0, c.p00, t.q1), pair(t.p1, c.q0, t.p00, c.q1));
    poly.a13 = pair(c.p02, t.q1, t.p02, c.q1);
    poly.a00 = pair(c.p00, t.q0, t.p00, c.q0);
    poly.a02 = pair(c.p02, t.q0, t.p02, c.q0);
    return poly;
}

sway_single_track_quartic_t sway_single_track_quartic(const sway_single_track_t *stm, sway_real_t v)
{
    const speed_poly_t poly = speed_poly(stm);
    const sway_real_t u = DIV(sway_real_int(1), v);
    const sway_real_t w = sway_real_square(u);
    sway_single_track_quartic_t quartic;
    quartic.a[4] = poly.a4;
    quartic.a[3] = MUL(poly.a3, u);
    quartic.a[2] = ADD(poly.a20, MUL(poly.a22, w));
    quartic.a[1] = MUL(u, ADD(poly.a11, MUL(poly.a13, w)));
    quartic.a[0] = ADD(poly.a00, MUL(poly.a02, w));
    return quartic;
}

/* --- critical speed --------------------------------------------------------------------------- */

/* Larger root of h2 w^2 + h1 w + h0 for h2 > 0; false where it is not real and positive. */
static bool larger_root(sway_real_t h2, sway_real_t h1, sway_real_t h0, sway_real_t *w)
{
    const sway_real_t half = sway_real_scale(h1, -1);
    const sway_real_t discriminant = SUB(sway_real_square(half), MUL(h2, h0));
    if (sway_real_sign(discriminant) < 0) {
        return false;
    }
    const sway_real_t root = sway_real_sqrt(discriminant);
    if (sway_real_sign(half) > 0) {
        /* -half - root would be the sum without cancellation; the other root is h0 over it. */
        *w = DIV(sway_real_neg(h0), ADD(half, root));
    } else {
        *w = DIV(SUB(root, half), h2);
    }
    return sway_real_sign(*w) > 0;
}

/* Greatest w = 1/v^2 at which the Hurwitz determinant is zero and the pair oscillates. */
static bool flutter(const speed_poly_t *p, sway_real_t *w)
{
    const sway_real_t a3a22 = MUL(p->a3, p->a22);
    const sway_real_t a3a20 = MUL(p->a3, p->a20);
    const sway_real_t a3a3 = sway_real_square(p->a3);
    const sway_real_t h2 = MUL(p->a13, SUB(a3a22, MUL(p->a4, p->a13)));
    const sway_real_t twice = sway_real_scale(MUL(p->a4, MUL(p->a11, p->a13)), 1);
    const sway_real_t h1 = SUB(SUB(pair(p->a11, a3a22, p->a13, a3a20), MUL(p->a02, a3a3)), twice);
    const sway_real_t h0 =
        SUB(SUB(MUL(p->a11, a3a20), MUL(p->a00, a3a3)), MUL(p->a4, sway_real_square(p->a11)));
    return larger_root(h2, h1, h0, w);
}

/* Stable in the limit of low speed. Where M s^2 + C s outweighs the rest, M and C symmetric and
 * positive, its roots are real and negative: a4, a3, a22, a13 and the Hurwitz determinant's leading
 * coefficient are positive. What is left is the slow root's sign. */
static bool stable_at_rest(const speed_poly_t *p)
{
    return sway_real_sign(p->a02) > 0;
}

static sway_real_t speed_of(sway_real_t w)
{
    return DIV(sway_real_int(1), sway_real_sqrt(w));
}

static sway_vcrit_t clip_speed(sway_vcrit_t kind, sway_real_t *v_m_s)
{
    if (sway_real_less(*v_m_s, sway_single_track_speed_low())) {
        *v_m_s = sway_single_track_speed_low();
        return SWAY_VCRIT_BELOW_RANGE;
    }
    if (sway_real_less(sway_single_track_speed_high(), *v_m_s)) {
        *v_m_s = sway_single_track_speed_high();
        return SWAY_VCRIT_BEYOND_RANGE;
    }
    return kind;
}

static bool has_axles(const sway_single_track_t *stm)
{
    const sway_real_t *const car = stm->body[SWAY_SINGLE_TRACK_CAR].stiffness_n_per_rad;
    const sway_real_t *const trailer = stm->body[SWAY_SINGLE_TRACK_TRAILER].stiffness_n_per_rad;
    return sway_real_sign(car[0]) > 0 && sway_real_sign(car[1]) > 0 &&
           (!stm->has_trailer || sway_real_sign(trailer[1]) > 0);
}

sway_vcrit_t sway_single_track_critical_speed(const sway_single_track_t *stm, sway_real_t *v_m_s,
                                              sway_real_t *omega_rad_s)
{
    const speed_poly_t poly = speed_poly(stm);
    *v_m_s = zero();
    *omega_rad_s = zero();
    if (!has_axles(stm)) {
        return SWAY_VCRIT_SINGULAR;
    }
    if (stm->has_trailer && !stable_at_rest(&poly)) {
        *v_m_s = sway_single_track_speed_low();
        return SWAY_VCRIT_BELOW_RANGE;
    }
    sway_real_t w_flutter = zero();
    sway_real_t w_static = zero();
    const bool flutters = stm->has_trailer && flutter(&poly, &w_flutter);
    const bool diverges = sway_real_sign(poly.a00) < 0;
    if (diverges) {
        w_static = DIV(sway_real_neg(poly.a00), poly.a02);
    }
    if (diverges && sway_real_less(w_flutter, w_static)) {
        *v_m_s = speed_of(w_static);
        return clip_speed(SWAY_VCRIT_DIVERGENCE, v_m_s);
    }
    if (!flutters) {
        *v_m_s = sway_single_track_speed_high();
        return SWAY_VCRIT_BEYOND_RANGE;
    }
    *v_m_s = speed_of(w_flutter);
    const sway_real_t a1 = ADD(poly.a11, MUL(poly.a13, w_flutter));
    *omega_rad_s = sway_real_sqrt(DIV(a1, poly.a3));
    return clip_speed(SWAY_VCRIT_FOUND, v_m_s);
}

/* --- roots ------------------------------------------------------------------------------------ */

void sway_single_track_roots_start(sway_single_track_roots_t *roots,
                                   const sway_single_track_quartic_t *quartic)
{
    roots->count = sway_real_is_zero(quartic->a[4]) ? 2 : 4;
    /* Size of the roots: |a0/an|^(1/n); angles that no symmetry of the roots shares. */
    const sway_real_t size =
        sway_real_abs(DIV(quartic->a[0], quartic->a[roots->count == 2 ? 2 : 4]));
    sway_real_t radius = sway_real_sqrt(size);
    if (roots->count == 4) {
        radius = sway_real_sqrt(radius);
    }
    if (sway_real_is_zero(radius)) {
        radius = sway_real_int(1);
    }
    for (int k = 0; k < roots->count; k++) {
        const sway_real_t angle =
            sway_real_ratio(50 + (int32_t)(628U * (uint32_t)k / (uint32_t)roots->count), 100);
        roots->root[k] = CSCALE(sway_complex_unit(angle), radius);
    }
}

static sway_complex_t polynomial(const sway_single_track_quartic_t *quartic, int degree,
                                 sway_complex_t s)
{
    sway_complex_t sum = from_real(quartic->a[degree]);
    for (int k = degree - 1; k >= 0; k--) {
        sum = CADD(CMUL(sum, s), from_real(quartic->a[k]));
    }
    return sum;
}

bool sway_single_track_roots_sweep(sway_single_track_roots_t *roots,
                                   const sway_single_track_quartic_t *quartic)
{
    bool settled = true;
    for (int k = 0; k < roots->count; k++) {
        sway_complex_t below = from_real(quartic->a[roots->count]);
        for (int i = 0; i < roots->count; i++) {
            if (i != k) {
                below = CMUL(below, CSUB(roots->root[k], roots->root[i]));
            }
        }
        const sway_complex_t step =
            sway_complex_div(polynomial(quartic, roots->count, roots->root[k]), below);
        roots->root[k] = CSUB(roots->root[k], step);
        /* |step|^2 against (1e-7)^2 |root|^2 */
        const sway_real_t bound =
            MUL(sway_complex_norm(roots->root[k]),
                sway_real_div(sway_real_int(1), sway_real(INT64_C(100000000000000), 0)));
        settled = settled && sway_real_compare(sway_complex_norm(step), bound) <= 0;
    }
    return settled;
}

sway_real_t sway_single_track_damping_ratio(sway_complex_t s)
{
    const sway_real_t one = sway_real_int(1);
    const sway_real_t ratio = DIV(sway_real_neg(s.re), sway_complex_abs(s));
    return sway_real_max(sway_real_min(ratio, one), sway_real_neg(one));
}

sway_real_t sway_single_track_damping_change(sway_complex_t s, sway_complex_t ds)
{
    const sway_real_t across = SUB(MUL(ds.im, s.re), MUL(ds.re, s.im));
    const sway_real_t size = sway_complex_abs(s);
    return DIV(MUL(DIV(across, size), DIV(s.im, size)), size);
}

sway_complex_t sway_single_track_dominant(const sway_single_track_roots_t *roots)
{
    sway_complex_t best = roots->root[0];
    bool best_oscillates = false;
    for (int k = 0; k < roots->count; k++) {
        const sway_complex_t root = roots->root[k];
        /* A double real root is found as a pair with a small imaginary part. */
        const bool oscillates =
            sway_real_less(MUL(sway_complex_abs(root), sway_real_ratio(1, 10000)), root.im);
        bool better = oscillates && !best_oscillates;
        if (oscillates && best_oscillates) {
            better = sway_real_less(sway_single_track_damping_ratio(root),
                                    sway_single_track_damping_ratio(best));
        } else if (!oscillates && !best_oscillates) {
            better = sway_real_less(best.re, root.re);
        }
        if (better) {
            best = root;
            best_oscillates = oscillates;
        }
    }
    if (!best_oscillates) {
        best.im = zero();
    }
    return best;
}

/* --- derivatives ------------------------------------------------------------------------------ */

/* f is analytic in s: a difference along one direction is enough. */
static sway_real_t step_s(sway_complex_t s)
{
    const bool at_rest = sway_real_is_zero(s.re) && sway_real_is_zero(s.im);
    return MUL(at_rest ? sway_real_int(1) : sway_complex_abs(s), sway_real_ratio(1, 1000));
}

static sway_complex_t over_twice(sway_complex_t difference, sway_real_t step)
{
    const sway_real_t twice = sway_real_scale(step, 1);
    return sway_complex(DIV(difference.re, twice), DIV(difference.im, twice));
}

/* f at (s, v), the upper half of a difference, or with the lower one the difference over `step`. */
static bool slope(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v, uint32_t half,
                  sway_real_t step, sway_complex_t *f)
{
    const sway_complex_t at = sway_single_track_characteristic(stm, s, v);
    *f = half == 0U ? at : over_twice(CSUB(*f, at), step);
    return half != 0U;
}

static sway_real_t moved(sway_real_t value, uint32_t half, sway_real_t step)
{
    return half == 0U ? ADD(value, step) : SUB(value, step);
}

bool sway_single_track_slope_s(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v,
                               uint32_t half, sway_complex_t *f)
{
    const sway_real_t step = step_s(s);
    s.re = moved(s.re, half, step);
    return slope(stm, s, v, half, step, f);
}

bool sway_single_track_slope_v(const sway_single_track_t *stm, sway_complex_t s, sway_real_t v,
                               uint32_t half, sway_complex_t *f)
{
    const sway_real_t step = MUL(v, sway_real_ratio(1, 1000));
    return slope(stm, s, moved(v, half, step), half, step, f);
}

/* The field that a parameter is; `index` tells of which body. */
static sway_real_t *parameter_field(sway_single_track_t *stm, sway_parameter_t parameter,
                                    int *index)
{
    sway_single_track_body_t *const car = &stm->body[SWAY_SINGLE_TRACK_CAR];
    sway_single_track_body_t *const trailer = &stm->body[SWAY_SINGLE_TRACK_TRAILER];
    sway_real_t *const field[SWAY_PARAMETER_COUNT] = {
        &car->mass_kg,
        &trailer->mass_kg,
        &car->yaw_inertia_kgm2,
        &trailer->yaw_inertia_kgm2,
        &car->axle_m[0],
        &car->axle_m[1],
        &car->hitch_m,
        &trailer->axle_m[0],
        &trailer->axle_m[1],
        &trailer->hitch_m,
        &car->stiffness_n_per_rad[0],
        &car->stiffness_n_per_rad[1],
        &trailer->stiffness_n_per_rad[0],
        &trailer->stiffness_n_per_rad[1],
    };
    *index = SWAY_SINGLE_TRACK_CAR;
    for (int body = SWAY_SINGLE_TRACK_CAR; body <= SWAY_SINGLE_TRACK_TRAILER; body++) {
        const sway_real_t *const first = (const sway_real_t *)(const void *)&stm->body[body];
        const sway_real_t *const last =
            first + sizeof(sway_single_track_body_t) / sizeof(sway_real_t);
        if (field[parameter] >= first && field[parameter] < last) {
            *index = body;
        }
    }
    return field[parameter];
}

bool sway_single_track_has_parameter(const sway_single_track_t *stm, sway_parameter_t parameter)
{
    sway_single_track_t copy = *stm;
    int index;
    const sway_real_t value = *parameter_field(&copy, parameter, &index);
    return !sway_real_is_zero(value) && (index == SWAY_SINGLE_TRACK_CAR || stm->has_trailer) &&
           (stm->has_trailer || parameter != SWAY_PARAMETER_CAR_HITCH);
}

sway_complex_t sway_single_track_slope_parameter(const sway_single_track_t *stm, sway_complex_t s,
                                                 sway_real_t v, sway_parameter_t parameter)
{
    sway_single_track_t copy = *stm;
    int index;
    sway_real_t *const field = parameter_field(&copy, parameter, &index);
    const sway_real_t value = *field;
    const sway_real_t step = MUL(value, sway_real_ratio(1, 200));
    *field = ADD(value, step);
    const factors_t up = body_factors(&copy.body[index], s, v);
    *field = SUB(value, step);
    const factors_t down = body_factors(&copy.body[index], s, v);
    const sway_complex_t dp = CSUB(up.p, down.p);
    if (!stm->has_trailer) {
        return dp;
    }
    const factors_t other = body_factors(&stm->body[1 - index], s, v);
    return CADD(CMUL(dp, other.q), CMUL(CSUB(up.q, down.q), other.p));
}

sway_error_t sway_single_track_shift(sway_complex_t f_s, sway_complex_t f_v, sway_complex_t df,
                                     sway_real_t *d_omega, sway_real_t *d_v)
{
    const sway_complex_t f_omega = sway_complex(sway_real_neg(f_s.im), f_s.re);
    const sway_real_t determinant = SUB(MUL(f_omega.re, f_v.im), MUL(f_v.re, f_omega.im));
    const sway_real_t size = MUL(sway_complex_abs(f_omega), sway_complex_abs(f_v));
    if (sway_real_compare(sway_real_abs(determinant), MUL(size, sway_real_micro(1))) <= 0) {
        return SWAY_ERROR_SINGULAR;
    }
    *d_omega = DIV(SUB(MUL(f_v.re, df.im), MUL(df.re, f_v.im)), determinant);
    *d_v = DIV(SUB(MUL(df.re, f_omega.im), MUL(f_omega.re, df.im)), determinant);
    return SWAY_OK;
}

/* --- steady state ----------------------------------------------------------------------------- */

/* With the trailer's axles at d_i behind the hitch, the hitch force in a steady turn of yaw rate r
 * and speed v is F = (e v^2 + k) r/v on the trailer, and the articulation follows from the force
 * balance of the trailer:
 *   e = m2 (sum C x)/(sum C d), k = C_f C_r l_2^2 / (sum C d),    d > 0 behind the hitch. */
typedef struct {
    sway_real_t force_v2; ///< e
    sway_real_t force_0;  ///< k
    sway_real_t angle_v2; ///< of the trailer's slip at the hitch, times v/r
    sway_real_t angle_0;
} trailer_steady_t;

static sway_error_t trailer_steady(const sway_single_track_body_t *t, trailer_steady_t *result)
{
    const sway_real_t c_f = t->stiffness_n_per_rad[0];
    const sway_real_t c_r = t->stiffness_n_per_rad[1];
    const sway_real_t b_f = SUB(t->hitch_m, t->axle_m[0]);
    const sway_real_t b_r = SUB(t->hitch_m, t->axle_m[1]);
    const sway_real_t base = SUB(t->axle_m[0], t->axle_m[1]);
    const sway_real_t moment = pair(c_f, b_f, c_r, b_r);
    if (sway_real_sign(moment) <= 0) {
        return SWAY_ERROR_SINGULAR;
    }
    /* Slip of an axle b behind the hitch: alpha = g + b r/v, g the slip of the drawbar at the hitch
     * (psi2 less the course of the hitch). Moments about the hitch: m2 v r h = sum C b alpha;
     * lateral: F_hitch = m2 v r - sum C alpha. */
    const sway_real_t second = pair(c_f, sway_real_square(b_f), c_r, sway_real_square(b_r));
    const sway_real_t sum = ADD(c_f, c_r);
    result->angle_v2 = DIV(MUL(t->mass_kg, t->hitch_m), moment);
    result->angle_0 = sway_real_neg(DIV(second, moment));
    result->force_v2 = SUB(t->mass_kg, MUL(sum, result->angle_v2));
    result->force_0 = DIV(MUL(MUL(c_f, c_r), sway_real_square(base)), moment);
    return SWAY_OK;
}

sway_error_t sway_single_track_steady_state(const sway_single_track_t *stm, sway_real_t v,
                                            sway_single_track_static_t *result)
{
    const sway_single_track_body_t *const car = &stm->body[SWAY_SINGLE_TRACK_CAR];
    const sway_real_t g = sway_real_ratio(981, 100);
    const sway_real_t c_f = car->stiffness_n_per_rad[0];
    const sway_real_t c_r = car->stiffness_n_per_rad[1];
    const sway_real_t l_f = car->axle_m[0];
    const sway_real_t l_r = sway_real_neg(car->axle_m[1]);
    const sway_real_t base = ADD(l_f, l_r);
    const sway_real_t overhang = SUB(sway_real_neg(car->hitch_m), l_r); // l_hr1
    trailer_steady_t trailer = {zero(), zero(), zero(), zero()};
    if (!has_axles(stm) ||
        (stm->has_trailer &&
         trailer_steady(&stm->body[SWAY_SINGLE_TRACK_TRAILER], &trailer) != SWAY_OK)) {
        return SWAY_ERROR_SINGULAR;
    }
    /* Front and rear force for a lateral force H that the trailer takes at the hitch:
     * F_f = m v r l_r/l - H l_hr/l, F_r = m v r l_f/l + H (l + l_hr)/l. */
    const sway_real_t by_front = DIV(overhang, MUL(c_f, base));
    const sway_real_t by_rear = DIV(ADD(base, overhang), MUL(c_r, base));
    const sway_real_t bend = ADD(by_front, by_rear); // of delta, per hitch force
    const sway_real_t solo = MUL(DIV(car->mass_kg, base), SUB(DIV(l_r, c_f), DIV(l_f, c_r)));
    const sway_real_t gradient = SUB(solo, MUL(trailer.force_v2, bend)); // K_u''/g
    result->understeer_gradient_rad = MUL(g, solo);
    result->combination_understeer_gradient_rad = MUL(g, gradient);
    result->effective_wheelbase_m = SUB(base, MUL(trailer.force_0, bend));
    const sway_real_t v2 = sway_real_square(v);
    const sway_real_t below = ADD(result->effective_wheelbase_m, MUL(gradient, v2));
    if (sway_real_is_zero(below)) {
        return SWAY_ERROR_SINGULAR;
    }
    result->yaw_rate_gain_1_s = DIV(v, below);

    /* Course of the hitch against the car's axis: rear slip and the distance behind the axle. */
    const sway_real_t rear_slip =
        ADD(MUL(v2, MUL(DIV(car->mass_kg, base), DIV(l_f, c_r))),
            MUL(ADD(trailer.force_0, MUL(trailer.force_v2, v2)), by_rear));
    const sway_real_t course = sway_real_neg(ADD(rear_slip, overhang));
    const sway_real_t drawbar = ADD(trailer.angle_0, MUL(trailer.angle_v2, v2));
    result->hitch_angle_gain = stm->has_trailer ? DIV(ADD(course, drawbar), below) : zero();

    const sway_real_t ratio = DIV(result->effective_wheelbase_m, gradient);
    const sway_real_t speed = sway_real_sqrt(sway_real_abs(ratio));
    result->characteristic_speed_m_s = sway_real_sign(ratio) < 0 ? sway_real_neg(speed) : speed;
    return SWAY_OK;
}

// Steps of WIDTH simulations side by side; included once for each width, with NAME(name).

typedef double NAME(v) __attribute__((vector_size(8 * WIDTH)));
typedef int64_t NAME(m) __attribute__((vector_size(8 * WIDTH)));
#define V NAME(v)
#define M NAME(m)
#define FEATURES NAME(features_t)
#define SAMPLE NAME(sample_t)
#define AXLE NAME(axle_t)
#define SLIPS NAME(slips_t)
#define INPUTS NAME(inputs_t)
#define STATE NAME(state_t)

/// What any lane of a group uses; the rest is not calculated.
typedef struct {
    bool relaxed, saturated, rolls, flexible, playing, aero, sticking, banked, blocks, full;
} FEATURES;

typedef struct {
    V speed, acceleration, steer, series[PLANT_SERIES];
} SAMPLE;

INLINE V NAME(all)(double value)
{
    return (V){0} + value;
}

INLINE V NAME(choose)(M mask, V yes, V no)
{
    return (V)(((M)yes & mask) | ((M)no & ~mask));
}

INLINE bool NAME(any)(M mask)
{
    int64_t found = 0;
    for (int i = 0; i < WIDTH; i++) {
        found |= mask[i];
    }
    return found != 0;
}

INLINE V NAME(least)(V a, V b)
{
    return NAME(choose)(a < b, a, b);
}

INLINE V NAME(most)(V a, V b)
{
    return NAME(choose)(a > b, a, b);
}

INLINE V NAME(absolute)(V x)
{
    return (V)((M)x & 0x7fffffffffffffff);
}

INLINE V NAME(nearest)(V x)
{
    const double magic = 6755399441055744.0; // 1.5 * 2^52
    V shifted = x + magic;
    __asm__("" : "+m"(shifted)); // the sum must not be undone
    return shifted - magic;
}

/// Sine of an angle of at most a quarter turn, by its series; `q` is its square.
INLINE V NAME(sine)(V r, V q)
{
    V s = q * (-1.0 / 5.1090942171709440e19) + 1.0 / 1.21645100408832e17;
    s = s * q - 1.0 / 355687428096000.0;
    s = s * q + 1.0 / 1307674368000.0;
    s = s * q - 1.0 / 6227020800.0;
    s = s * q + 1.0 / 39916800.0;
    s = s * q - 1.0 / 362880.0;
    s = s * q + 1.0 / 5040.0;
    s = s * q - 1.0 / 120.0;
    s = s * q + 1.0 / 6.0;
    return r - r * q * s;
}

/// Sine and cosine, from within a quarter turn of a multiple of pi.
INLINE void NAME(turn)(V x, V *sine, V *cosine)
{
    const V n = NAME(nearest)(x * 0.31830988618379067154);
    const V odd = n - 2.0 * NAME(nearest)(0.5 * n);
    const V sign = 1.0 - 2.0 * odd * odd;
    const V r = (x - n * 3.14159265358979311600) - n * 1.22464679914735317722e-16;
    const V q = r * r;
    *sine = sign * NAME(sine)(r, q);
    V c = q * (-1.0 / 1.1240007277776077e21) + 1.0 / 2432902008176640000.0;
    c = c * q - 1.0 / 6402373705728000.0;
    c = c * q + 1.0 / 20922789888000.0;
    c = c * q - 1.0 / 87178291200.0;
    c = c * q + 1.0 / 479001600.0;
    c = c * q - 1.0 / 3628800.0;
    c = c * q + 1.0 / 40320.0;
    c = c * q - 1.0 / 720.0;
    c = c * q + 1.0 / 24.0;
    *cosine = sign * (1.0 - q * (0.5 - q * c));
}

/// Arc tangent: rational approximation of Moshier's Cephes library (public description).
INLINE V NAME(arc_tangent)(V x)
{
    const V a = NAME(absolute)(x);
    const M large = a > 2.41421356237309504880;
    const M middle = (a > 0.66) & ~large;
    const V one = NAME(all)(1.0);
    const V top = NAME(choose)(large, -one, NAME(choose)(middle, a - 1.0, a));
    const V bottom = NAME(choose)(large, a, NAME(choose)(middle, a + 1.0, one));
    const V z = top / bottom;
    const V q = z * z;
    V p = -8.750608600031904122785e-1 * q - 1.615753718733365076637e1;
    p = p * q - 7.500855792314704667340e1;
    p = p * q - 1.228866684490136173410e2;
    p = p * q - 6.485021904942025371773e1;
    V d = q + 2.485846490142306297962e1;
    d = d * q + 1.650270098316988542046e2;
    d = d * q + 4.328810604912902668951e2;
    d = d * q + 4.853903996359136964868e2;
    d = d * q + 1.945506571482613964425e2;
    const V base = NAME(choose)(large, NAME(all)(1.57079632679489661923),
                                NAME(choose)(middle, NAME(all)(0.78539816339744830962), 0.0 * one));
    const V y = base + (z + z * q * (p / d));
    return NAME(choose)(x < 0.0, -y, y);
}

/// Slip angle: the series is good to 1e-9 below 0.1.
INLINE V NAME(slip)(V x)
{
    const V q = x * x;
    V y = x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q * (1.0 / 7.0))));
    const M far = ~(NAME(absolute)(x) < 0.1);
    if (NAME(any)(far)) {
        y = NAME(choose)(far, NAME(arc_tangent)(x), y);
    }
    return y;
}

INLINE V NAME(hyperbolic_tangent)(V x)
{
    V y = {0};
    for (int i = 0; i < WIDTH; i++) {
        y[i] = tanh(x[i]);
    }
    return y;
}

/// Saturated force of a wheel: peak sin(SHAPE atan(linear / (SHAPE peak))), peak above zero.
///
/// The arc tangent of a ratio up to one is a polynomial with Chebyshev nodes (error 3e-17), that of
/// the inverse the rest of a quarter turn: one division.
INLINE V NAME(saturation)(V linear, V peak)
{
    const V size = NAME(absolute)(linear);
    const V bound = SHAPE * peak;
    const M steep = size > bound;
    const V t = NAME(choose)(steep, bound, size) / NAME(choose)(steep, size, bound);
    const V q = t * t;
    const V u = q * q;
    V odd = 1.806195461861215e-05 * u + 0.0010496035084968515;
    V even = -0.00019996189377901382 * u - 0.0034958859739163094;
    odd = odd * u + 0.008368931178450162;
    even = even * u - 0.015535152475414177;
    odd = odd * u + 0.023696731580048622;
    even = even * u - 0.031277189066996385;
    odd = odd * u + 0.03749486812535247;
    even = even * u - 0.04260356632601652;
    odd = odd * u + 0.04737749579527779;
    even = even * u - 0.052579733342841106;
    odd = odd * u + 0.05881506877793656;
    even = even * u - 0.06666564699289104;
    odd = odd * u + 0.07692298971033217;
    even = even * u - 0.09090908590891934;
    odd = odd * u + 0.11111111093490827;
    even = even * u - 0.14285714285384132;
    odd = odd * u + 0.1999999999999753;
    even = even * u - 0.3333333333333333;
    const V angle = t + t * q * (odd * q + even);
    const V full = SHAPE * NAME(choose)(steep, 1.57079632679489661923 - angle, angle);
    const V near = NAME(least)(full, 3.14159265358979323846 - full);
    const V sine = peak * NAME(sine)(near, near * near);
    return (V)((M)sine ^ ((M)linear & INT64_MIN));
}

typedef struct {
    V force[2], load[2];
} AXLE;

/// Lateral force of an axle from its two wheels. `left` and `right` carry the extra load; `shift`
/// goes from left to right, `heave` is shared.
INLINE V NAME(axle)(V stiffness, V load, V per_load, V left, V right, V shift, V heave, V slip,
                    V degression, V friction, bool saturated, AXLE *out)
{
    V total = {0};
    for (int wheel = 0; wheel < 2; wheel++) {
        V fz = 0.5 * (load + heave);
        fz = wheel == 0 ? fz - shift + left : fz + shift + right;
        fz = NAME(most)(fz, NAME(all)(0.0));
        const V z = 2.0 * fz * per_load;
        const V linear = 0.5 * stiffness * slip * z * (1.0 - degression * (z - 1.0));
        V force = linear;
        if (saturated) {
            const V peak = fz * friction;
            force =
                NAME(choose)((friction > 0.0) & (fz > 1.0), NAME(saturation)(linear, peak), linear);
        }
        out->force[wheel] = force;
        out->load[wheel] = fz;
        total += force;
    }
    return total;
}

/// Slip that acts: what lags behind by the relaxation length, the rest at once.
INLINE V NAME(lagged)(V length, V slip, V state)
{
    const V part = NAME(least)(length * (1.0 / SHORTEST_LAG_M), NAME(all)(1.0));
    return NAME(choose)(length > 0.0, slip + part * (state - slip), slip);
}

INLINE V NAME(lag_rate)(V length, V slip, V state, V speed)
{
    const V rate = (slip - state) * speed / NAME(most)(length, NAME(all)(SHORTEST_LAG_M));
    return NAME(choose)(length > 0.0, rate, NAME(all)(0.0));
}

/// Where the wheels go, and the slip angles: of the motion, and as they act.
typedef struct {
    V sine, cosine;       // of the articulation
    V hitch, speed, side; // hitch's lateral velocity in car axes; the trailer's own velocities
    V per_speed;          // 1 / speed of the trailer
    V roll[2];            // car, trailer
    V angle[4], acting[4];
} SLIPS;

INLINE void NAME(slips)(const V *x, const SAMPLE *now, const V *p, const V *e, const V *k,
                        const FEATURES *has, SLIPS *to)
{
    const V *ser = now->series;
    const V vx = now->speed;
    const V vy = x[0], r1 = x[1], r2 = x[3];
    V s, c;
    NAME(turn)(x[2], &s, &c);
    const V hvy = vy - p[4] * r1;
    const V vx2 = c * vx + s * hvy;
    const V vy2 = c * hvy - s * vx - p[11] * r2;
    const V per_vx = 1.0 / vx;
    const V per_vx2 = 1.0 / vx2;
    V angle[4];
    angle[0] = now->steer - NAME(slip)((vy + p[2] * r1) * per_vx) + ser[24];
    angle[1] = ser[25] - NAME(slip)((vy - p[3] * r1) * per_vx);
    angle[2] = ser[26] - NAME(slip)((vy2 + p[9] * r2) * per_vx2);
    angle[3] = ser[27] - NAME(slip)((vy2 - p[10] * r2) * per_vx2);
    V roll1 = {0}, roll2 = {0};
    if (has->rolls) {
        roll1 = e[19] * x[12];
        roll2 = e[20] * x[13];
        angle[0] += e[12] * roll1;
        angle[1] += e[13] * roll1;
        angle[2] += e[14] * roll2;
        angle[3] += e[14] * roll2;
    }
    for (int a = 0; a < 4; a++) {
        to->angle[a] = angle[a];
        to->acting[a] =
            has->relaxed ? NAME(lagged)(e[a < 3 ? 9 + a : 11], angle[a], x[6 + a]) : angle[a];
    }
    const V cf = p[5] * (1.0 + ser[0]);
    if (has->flexible) {
        to->acting[0] = to->acting[0] / (1.0 + e[0] * cf * (1.0 + ser[4] * k[0]));
    }
    if (has->playing) {
        const V lost = NAME(hyperbolic_tangent)(cf * to->acting[0] * (1.0 / FREE_PLAY_N));
        to->acting[0] = to->acting[0] - e[1] * lost;
    }
    to->sine = s, to->cosine = c;
    to->hitch = hvy, to->speed = vx2, to->side = vy2, to->per_speed = per_vx2;
    to->roll[0] = roll1, to->roll[1] = roll2;
}

/// Forces and loads of all wheels; total of each axle in `total`.
INLINE void NAME(axles)(const V *x, const V *ser, const V *p, const V *e, const V *k,
                        const FEATURES *has, const SLIPS *slips, AXLE *w, V *total)
{
    const V friction = k[4] * (1.0 + ser[21]);
    // Fig. 6-3 of the dissertation: the extra load sits on the left while the yaw rate is negative
    const M negative = x[1] < 0.0;
    static const int stiffness[4] = {5, 6, 12, 13};
    for (int a = 0; a < 4; a++) {
        const V left = (V)((M)ser[4 + a] & negative);
        const V right = (V)((M)ser[4 + a] & ~negative);
        total[a] = NAME(axle)(p[stiffness[a]] * (1.0 + ser[a]), p[14 + a], k[a], left, right,
                              e[15 + a] * x[4 + a / 2] + ser[13 + a], ser[17 + a], slips->acting[a],
                              e[8], friction, has->saturated, &w[a]);
    }
}

/// Rates of what lags behind: roll, load transfer, relaxation. `felt` is what the bodies feel.
INLINE void NAME(lags)(const V *x, const V *e, const FEATURES *has, const SLIPS *slips, V speed,
                       const V *felt, V *dx)
{
    // roll and load transfer: second order behind the acceleration that the body feels
    dx[4] = x[10];
    dx[10] = e[21] * (e[21] * (felt[0] - x[4]) - 2.0 * e[22] * x[10]);
    dx[5] = x[11];
    dx[11] = e[23] * (e[23] * (felt[1] - x[5]) - 2.0 * e[24] * x[11]);
    // the roll that steers may be damped otherwise than the load transfer
    if (has->rolls) {
        const M mask = (e[12] != 0.0) | (e[13] != 0.0) | (e[14] != 0.0);
        const V none = {0};
        dx[12] = NAME(choose)(mask, x[14], none);
        dx[13] = NAME(choose)(mask, x[15], none);
        dx[14] = e[25] * (e[25] * (felt[0] - x[12]) - 2.0 * e[26] * x[14]);
        dx[15] = e[27] * (e[27] * (felt[1] - x[13]) - 2.0 * e[28] * x[15]);
        dx[14] = NAME(choose)(mask, dx[14], none);
        dx[15] = NAME(choose)(mask, dx[15], none);
    }
    if (has->relaxed) {
        for (int a = 0; a < 4; a++) {
            dx[6 + a] = NAME(lag_rate)(e[a < 3 ? 9 + a : 11], slips->angle[a], x[6 + a], speed);
        }
    }
}

/// Derivative of the states, see diagnose/plant.py; `out` takes the outputs where `store`.
INLINE void NAME(derivative)(const V *x, const SAMPLE *now, const V *p, const V *e, const V *k,
                             const FEATURES *has, V *dx, bool store, V *out)
{
    const V *ser = now->series;
    const V vx = now->speed;
    const V vy = x[0], r1 = x[1], r2 = x[3];
    const V m1 = p[0], lh = p[4], m2 = p[7], lh2 = p[11];
    V unused, cos_steer;
    NAME(turn)(now->steer, &unused, &cos_steer);
    SLIPS slips;
    NAME(slips)(x, now, p, e, k, has, &slips);
    const V s = slips.sine, c = slips.cosine;
    AXLE w[4];
    V f[4];
    NAME(axles)(x, ser, p, e, k, has, &slips, w, f);
    V tilt = {0};
    if (has->banked) { // ISO 8855: positive with the left side high
        V sine;
        NAME(turn)(ser[12], &sine, &unused);
        tilt = -GRAVITY * sine;
    }
    const V y1 = ser[8] + m1 * tilt;
    V n2 = ser[11];
    V y2 = ser[10] + m2 * tilt;
    if (has->aero) {
        const V q = 0.5 * AIR_DENSITY * TRAILER_AREA * slips.speed * slips.speed *
                    NAME(slip)(slips.side * slips.per_speed);
        y2 -= q * e[5];
        n2 -= q * e[6];
    }
    const V rate = r2 - r1;
    V mh = e[4] * rate;
    if (has->sticking) {
        mh += e[2] * NAME(hyperbolic_tangent)(rate / e[3]);
    }
    const V tt = f[2] + f[3] + y2;
    const V fc = f[0] * cos_steer;
    const V ahx = now->acceleration - vy * r1 + lh * r1 * r1;
    const V per_m = k[5], a12 = k[6], per_d22 = k[7], a33 = k[8];
    const V a13 = -m2 * c * lh2;
    const V a23 = lh * m2 * c * lh2;
    const V inner = c * tt - m2 * vx * r1 - m2 * s * lh2 * r2 * r2;
    const V b1 = fc + f[1] + y1 + c * tt - (m1 + m2) * vx * r1 - m2 * s * lh2 * r2 * r2;
    const V b2 = p[2] * fc - p[3] * f[1] + ser[9] + mh - lh * inner;
    const V b3 =
        p[9] * f[2] - p[10] * f[3] + n2 - mh - lh2 * tt + lh2 * m2 * (c * vx * r1 - s * ahx);
    // symmetric 3 x 3
    const V d23 = a23 - a12 * a13 * per_m;
    const V d33 = a33 - a13 * a13 * per_m;
    const V g2 = b2 - a12 * b1 * per_m;
    const V g3 = b3 - a13 * b1 * per_m;
    const V r2d = (g3 - d23 * g2 * per_d22) / (d33 - d23 * d23 * per_d22);
    const V r1d = (g2 - d23 * r2d) * per_d22;
    const V vyd = (b1 - a12 * r1d - a13 * r2d) * per_m;
    const V ay1 = vyd + vx * r1;
    const V ahy = ay1 - lh * r1d;
    const V a2x = c * ahx + s * ahy + lh2 * r2 * r2;
    const V a2y = c * ahy - s * ahx - lh2 * r2d;
    // an observer keeps the state near the measured one, so that what is missing shows where and
    // when it acts instead of being carried on (innovation form of the prediction-error method)
    dx[0] = vyd;
    dx[1] = r1d + e[29] * (ser[22] - r1);
    dx[2] = rate;
    dx[3] = r2d + e[29] * (ser[23] - r2);
    const V felt[2] = {ay1 - tilt, a2y - tilt};
    NAME(lags)(x, e, has, &slips, vx, felt, dx);
    if (!store) {
        return;
    }
    const V px = -m2 * a2x;
    const V py = tt - m2 * a2y;
    const V sensed = tilt * (1.0 - e[30]);
    for (int j = 0; j < 4; j++) {
        out[j] = x[j], out[22 + j] = slips.acting[j];
    }
    for (int wheel = 0; wheel < 2; wheel++) {
        out[4 + wheel] = w[0].force[wheel], out[6 + wheel] = w[1].force[wheel];
        out[10 + wheel] = w[0].load[wheel], out[12 + wheel] = w[1].load[wheel];
        out[26 + wheel] = w[2].force[wheel], out[28 + wheel] = w[3].force[wheel];
        out[30 + wheel] = w[2].load[wheel], out[32 + wheel] = w[3].load[wheel];
    }
    out[8] = f[2], out[9] = f[3];
    out[14] = c * px - s * py, out[15] = s * px + c * py;
    out[16] = ay1 - sensed, out[17] = a2y - sensed;
    out[18] = r1d, out[19] = r2d, out[20] = slips.roll[0], out[21] = slips.roll[1];
}

/// Constants of the lanes, and what follows from them: reciprocals of the axle loads and of the
/// friction, and the parts of the mass matrix that do not move.
INLINE void NAME(constants)(plant_lane_t *const *lane, V *p, V *e, V *k, FEATURES *has)
{
    for (int l = 0; l < WIDTH; l++) {
        for (int j = 0; j < PLANT_BODY; j++) {
            p[j][l] = lane[l]->body[j];
        }
        for (int j = 0; j < PLANT_SCALARS; j++) {
            e[j][l] = lane[l]->scalars[j];
        }
        const double *s = lane[l]->scalars;
        has->flexible |= s[0] != 0.0;
        has->playing |= s[1] > 0.0;
        has->sticking |= s[2] != 0.0;
        has->aero |= s[5] != 0.0 || s[6] != 0.0;
        has->saturated |= s[7] > 0.0;
        has->relaxed |= s[9] > 0.0 || s[10] > 0.0 || s[11] > 0.0;
        has->rolls |= s[12] != 0.0 || s[13] != 0.0 || s[14] != 0.0;
        has->banked |= lane[l]->series[12] != NULL;
        has->blocks |= lane[l]->blocks != NULL;
        has->full |= lane[l]->output != NULL;
    }
    for (int a = 0; a < 4; a++) {
        k[a] = 1.0 / p[14 + a];
    }
    const V none = {0};
    k[4] = NAME(choose)(e[7] > 0.0, 1.0 / e[7], none);
    k[5] = 1.0 / (p[0] + p[7]);
    k[6] = -p[7] * p[4];
    k[7] = 1.0 / (p[1] + p[7] * p[4] * p[4] - k[6] * k[6] * k[5]);
    k[8] = p[8] + p[7] * p[11] * p[11];
}

typedef struct {
    int slots[PLANT_SERIES];
    int count;
    const double *from[PLANT_SERIES + 3][WIDTH];
    int64_t step[PLANT_SERIES + 3][WIDTH];
} INPUTS;

INLINE void NAME(inputs)(plant_lane_t *const *lane, INPUTS *in)
{
    in->count = 0;
    for (int j = 0; j < PLANT_SERIES; j++) {
        bool used = false;
        for (int l = 0; l < WIDTH; l++) {
            used |= lane[l]->series[j] != NULL;
        }
        if (!used) {
            continue;
        }
        for (int l = 0; l < WIDTH; l++) {
            const double *from = lane[l]->series[j];
            in->from[in->count][l] = from != NULL ? from + lane[l]->at : &NEUTRAL;
            in->step[in->count][l] = from != NULL ? 1 : 0;
        }
        in->slots[in->count++] = j;
    }
    for (int l = 0; l < WIDTH; l++) {
        const double *own[3] = {lane[l]->speed, lane[l]->acceleration, lane[l]->steer};
        for (int j = 0; j < 3; j++) {
            in->from[PLANT_SERIES + j][l] = own[j] + lane[l]->at;
        }
    }
}

INLINE void NAME(load)(const INPUTS *in, int64_t sample, SAMPLE *to)
{
    for (int l = 0; l < WIDTH; l++) {
        to->speed[l] = in->from[PLANT_SERIES][l][sample];
        to->acceleration[l] = in->from[PLANT_SERIES + 1][l][sample];
        to->steer[l] = in->from[PLANT_SERIES + 2][l][sample];
    }
    for (int j = 0; j < in->count; j++) {
        V value = {0};
        for (int l = 0; l < WIDTH; l++) {
            value[l] = in->from[j][l][sample * in->step[j][l]];
        }
        to->series[in->slots[j]] = value;
    }
}

/// Outputs of a sample to where the lanes want them.
INLINE void NAME(put)(plant_lane_t *const *lane, int32_t count, const FEATURES *has, M alive,
                      int64_t sample, V *out, V *sums)
{
    for (int j = 0; j < PLANT_OUTPUTS; j++) {
        out[j] = (V)((M)out[j] & alive);
    }
    if (has->blocks) {
        for (int j = 0; j < PLANT_OUTPUTS; j++) {
            sums[j] += out[j];
        }
    }
    if (has->full) {
        for (int32_t l = 0; l < count; l++) {
            double *to = lane[l]->output;
            if (to != NULL) {
                const int32_t columns = lane[l]->columns;
                to += (lane[l]->at + sample) * columns;
                for (int32_t j = 0; j < columns; j++) {
                    to[j] = out[lane[l]->column[j]][l];
                }
            }
        }
    }
    if (has->blocks && (lane[0]->at + sample - lane[0]->first) % PLANT_BLOCK == PLANT_BLOCK - 1) {
        for (int32_t l = 0; l < count; l++) {
            double *to = lane[l]->blocks;
            if (to != NULL) {
                to += (lane[l]->at + sample) / PLANT_BLOCK * PLANT_OUTPUTS;
                for (int j = 0; j < PLANT_OUTPUTS; j++) {
                    to[j] = sums[j][l];
                }
            }
        }
        for (int j = 0; j < PLANT_OUTPUTS; j++) {
            sums[j] = (V){0};
        }
    }
}

INLINE void NAME(middle)(const INPUTS *in, const SAMPLE *a, const SAMPLE *b, SAMPLE *to)
{
    to->speed = 0.5 * b->speed + 0.5 * a->speed;
    to->acceleration = 0.5 * b->acceleration + 0.5 * a->acceleration;
    to->steer = 0.5 * b->steer + 0.5 * a->steer;
    for (int j = 0; j < in->count; j++) {
        const int slot = in->slots[j];
        to->series[slot] = 0.5 * b->series[slot] + 0.5 * a->series[slot];
    }
}

INLINE void NAME(keep)(plant_lane_t *const *lane, int32_t count, int64_t sample, const V *x)
{
    for (int32_t l = 0; l < count; l++) {
        if (lane[l]->states != NULL) {
            double *to = lane[l]->states + (lane[l]->at + sample) * PLANT_STATES;
            for (int j = 0; j < PLANT_STATES; j++) {
                to[j] = x[j][l];
            }
        }
    }
}

/// Everything of the lanes while they are stepped.
typedef struct {
    plant_lane_t *lane[WIDTH];
    int32_t count;
    V p[PLANT_BODY], e[PLANT_SCALARS], k[9];
    V x[PLANT_STATES], dx[PLANT_STATES], out[PLANT_OUTPUTS], sums[PLANT_OUTPUTS];
    M alive;
    FEATURES has;
    INPUTS in;
    SAMPLE samples[3]; // at the beginning, the middle and the end of a step
} STATE;

INLINE void NAME(begin)(plant_lane_t *const *given, int32_t count, STATE *now)
{
    memset(now, 0, sizeof *now);
    now->count = count;
    for (int l = 0; l < WIDTH; l++) {
        now->lane[l] = given[l < count ? l : 0];
        for (int j = 0; j < PLANT_STATES; j++) {
            now->x[j][l] = now->lane[l]->state[j];
        }
        for (int j = 0; j < PLANT_OUTPUTS; j++) {
            now->sums[j][l] = now->lane[l]->sums[j];
        }
        now->alive[l] = now->lane[l]->diverged ? 0 : -1;
    }
    NAME(constants)(now->lane, now->p, now->e, now->k, &now->has);
    NAME(inputs)(now->lane, &now->in);
    NAME(load)(&now->in, 0, &now->samples[0]);
}

INLINE void NAME(end)(STATE *now, int64_t samples)
{
    for (int32_t l = 0; l < now->count; l++) {
        plant_lane_t *lane = now->lane[l];
        for (int j = 0; j < PLANT_STATES; j++) {
            lane->state[j] = now->x[j][l];
        }
        for (int j = 0; j < PLANT_OUTPUTS; j++) {
            lane->sums[j] = now->sums[j][l];
        }
        lane->diverged = now->alive[l] ? 0 : 1;
        lane->at += samples;
    }
}

/// The four stages of a step from sample `i`, and the new states. Without a stride only the first.
INLINE void NAME(step)(STATE *now, double step, int32_t stride, int64_t i)
{
    V tmp[PLANT_STATES], total[PLANT_STATES];
    for (int j = 0; j < PLANT_STATES; j++) {
        tmp[j] = now->x[j];
        total[j] = (V){0};
    }
    // one place of call, so that the compiler takes the derivative into the loop once
    for (int stage = 0; stage < 4; stage++) {
        const bool store = stage == 0 || (stage == 2 && stride == 2);
        const SAMPLE *sample = &now->samples[(stage + 1) / 2];
        NAME(derivative)(tmp, sample, now->p, now->e, now->k, &now->has, now->dx, store, now->out);
        if (store) {
            NAME(put)
            (now->lane, now->count, &now->has, now->alive, stage == 0 ? i : i + 1, now->out,
             now->sums);
        }
        if (stride == 0) {
            return;
        }
        const double weight = stage == 0 || stage == 3 ? 1.0 : 2.0;
        const double ahead = stage == 2 ? step : 0.5 * step;
        for (int j = 0; j < PLANT_STATES; j++) {
            total[j] += weight * now->dx[j];
            tmp[j] = now->x[j] + ahead * now->dx[j];
        }
    }
    M bad = {0};
    for (int j = 0; j < PLANT_STATES; j++) {
        now->x[j] += step / 6.0 * total[j];
        bad |= ~(NAME(absolute)(now->x[j]) < LIMIT);
    }
    now->alive &= ~bad;
    for (int j = 0; j < PLANT_STATES; j++) {
        now->x[j] = (V)((M)now->x[j] & now->alive);
    }
}

/// `steps` steps of `stride` samples of every lane; a stride of 0: only the outputs of the sample.
WIDEST
static void NAME(advance)(plant_lane_t *const *given, int32_t count, double period_s,
                          int32_t stride, int64_t steps)
{
    STATE now;
    NAME(begin)(given, count, &now);
    const double step = period_s * (stride == 2 ? 2.0 : 1.0);
    for (int64_t taken = 0; taken < steps && NAME(any)(now.alive); taken++) {
        const int64_t i = taken * stride;
        NAME(keep)(now.lane, count, i, now.x);
        if (stride > 0) {
            NAME(load)(&now.in, i + stride, &now.samples[2]);
        }
        if (stride == 2) {
            NAME(load)(&now.in, i + 1, &now.samples[1]);
        } else if (stride == 1) {
            NAME(middle)(&now.in, &now.samples[0], &now.samples[2], &now.samples[1]);
        }
        NAME(step)(&now, step, stride, i);
        now.samples[0] = now.samples[2];
    }
    NAME(end)(&now, steps * stride);
}

#undef V
#undef M
#undef FEATURES
#undef SAMPLE
#undef AXLE
#undef SLIPS
#undef INPUTS
#undef STATE

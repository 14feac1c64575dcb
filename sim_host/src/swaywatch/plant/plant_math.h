// Elementary functions over a row of lanes; included by plant_step.h for each width.

typedef double NAME(v) __attribute__((vector_size(8 * WIDTH)));
typedef int64_t NAME(m) __attribute__((vector_size(8 * WIDTH)));
#define V NAME(v)
#define M NAME(m)

INLINE V NAME(all)(double value)
{
    return (V){0} + value;
}

INLINE V NAME(choose)(M mask, V yes, V no)
{
    return (V)(((M)yes & mask) | ((M)no & ~mask));
}

INLINE V NAME(where)(V condition, V yes)
{
    return NAME(choose)(condition > 0.0, yes, (V){0});
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
    return (x + MAGIC) - MAGIC;
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

/// Hyperbolic tangent, e / (e + 2) with e = exp(2 |x|) - 1, that by its series within half a
/// doubling: relative error 4e-16, and the same to the bit on any machine, which that of a C
/// library is not.
INLINE V NAME(hyperbolic_tangent)(V x)
{
    const V size = NAME(absolute)(x);
    const V twice = 2.0 * NAME(choose)(size > 22.0, NAME(all)(22.0), size); // from there on 1
    const V shifted = twice * 1.44269504088896338700 + MAGIC;
    const V n = shifted - MAGIC;
    const V r = (twice - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
    const V q = r * r;
    V odd = q * (1.0 / 6227020800.0) + 1.0 / 39916800.0;
    V even = q * (1.0 / 479001600.0) + 1.0 / 3628800.0;
    odd = odd * q + 1.0 / 362880.0;
    even = even * q + 1.0 / 40320.0;
    odd = odd * q + 1.0 / 5040.0;
    even = even * q + 1.0 / 720.0;
    odd = odd * q + 1.0 / 120.0;
    even = even * q + 1.0 / 24.0;
    odd = odd * q + 1.0 / 6.0;
    even = even * q + 0.5;
    const V less = r + q * (even + r * odd); // exp(r) - 1
    const V power = (V)(((M)shifted << 52) + (1023LL << 52));
    const V e = power * less + (power - 1.0);
    return (V)((M)(e / (e + 2.0)) | ((M)x & INT64_MIN));
}

/// Sine of zero to a quarter turn: a polynomial with Chebyshev nodes, error 8e-14.
INLINE V NAME(quarter_sine)(V r)
{
    const V q = r * r;
    V s = 1.5411463924650553e-10 * q - 2.503028755489896e-08;
    s = s * q + 2.7556953493193696e-06;
    s = s * q - 0.0001984126669125144;
    s = s * q + 0.0083333333204108;
    s = s * q - 0.16666666666467955;
    s = s * q + 0.9999999999999502;
    return r * s;
}

/// Saturated force of a wheel: peak sin(shape atan(linear / (shape peak))), peak above zero and
/// shape at most 2.
///
/// The arc tangent of a ratio up to one is a polynomial with Chebyshev nodes (error 2e-12 of it),
/// that of the inverse the rest of a quarter turn: one division.
INLINE V NAME(saturation)(V linear, V peak, V shape)
{
    const V size = NAME(absolute)(linear);
    const V bound = shape * peak;
    const M steep = size > bound;
    const V t = NAME(choose)(steep, bound, size) / NAME(choose)(steep, size, bound);
    const V q = t * t;
    const V u = q * q;
    V odd = -0.0002666010394055167 * u - 0.008241886106073201;
    V even = 0.00216278896674385 * u + 0.019937423423745854;
    odd = odd * u - 0.035267704529007626;
    even = even * u + 0.05045556959400332;
    odd = odd * u - 0.06366092077884622;
    even = even * u + 0.07614250245326529;
    odd = odd * u - 0.09076798916564101;
    even = even * u + 0.11109428375919612;
    odd = odd * u - 0.1428559239599274;
    even = even * u + 0.1999999534050863;
    odd = odd * u - 0.33333333262483106;
    even = even * u + 0.999999999998197;
    const V angle = t * (odd * q + even);
    const V full = shape * NAME(choose)(steep, 1.57079632679489661923 - angle, angle);
    const V near = NAME(least)(full, 3.14159265358979323846 - full);
    const V sine = peak * NAME(quarter_sine)(near);
    return (V)((M)sine ^ ((M)linear & INT64_MIN));
}

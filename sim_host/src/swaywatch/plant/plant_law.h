// Laws that no named effect has: a force that one motion makes, a mass that swings in a body, a
// drawbar that gives way; included by plant_step.h. What the slots are is said by plant/lanes.py.

/// A straight line, or bent at `at`: saturating, dead within it; cube, odd and even square; of one
/// side only, or `at` times as steep on the other one; a line with `at` times the cube; friction
/// that falls to half of it at `at`; of one side only, beyond `at`; of one size beyond it.
INLINE V NAME(bent)(V z, V shape, V at)
{
    const V some = NAME(most)(at, NAME(all)(1e-9));
    V found = z;
    found = NAME(choose)(shape == 1.0, some * NAME(hyperbolic_tangent)(z / some), found);
    const V within = NAME(most)(NAME(least)(z, some), -some);
    found = NAME(choose)(shape == 2.0, z - within, found);
    found = NAME(choose)(shape == 3.0, z * z * z, found);
    found = NAME(choose)(shape == 4.0, z * NAME(absolute)(z), found);
    const V above = NAME(most)(z, NAME(all)(0.0)), below = NAME(least)(z, NAME(all)(0.0));
    found = NAME(choose)(shape == 8.0, above, found);
    found = NAME(choose)(shape == 9.0, below, found);
    found = NAME(choose)(shape == 11.0, above + at * below, found);
    found = NAME(choose)(shape == 13.0, z * (1.0 + at * z * z), found);
    const V beyond = z / some, rises = NAME(hyperbolic_tangent)(STEEP * beyond);
    found = NAME(choose)(shape == 15.0, some * rises / (1.0 + beyond * beyond), found);
    found = NAME(choose)(shape == 16.0, NAME(most)(z - some, NAME(all)(0.0)), found);
    found = NAME(choose)(shape == 17.0, NAME(least)(z + some, NAME(all)(0.0)), found);
    const V on = (NAME(absolute)(z) - some) / (SWITCHED_SHARE * some);
    const V size = 0.5 * some * (1.0 + NAME(hyperbolic_tangent)(on));
    found = NAME(choose)(shape == 18.0, NAME(choose)(z < 0.0, -size, size), found);
    return NAME(choose)(shape == 5.0, z * z, found);
}

/// A curve of straight pieces through nothing; its slope changes at fifths of the bend.
INLINE V NAME(in_pieces)(V z, const V *e)
{
    V found = e[E_LAW_LINE] * z + e[E_LAW_OF_SIZE] * NAME(absolute)(z);
    for (int j = 0; j < PIECES; j++) {
        const V at = e[E_LAW_BEND] * ((j + 1) * (1.0 / PIECES)), none = {0};
        found += e[E_LAW_RIGHT_1 + j] * NAME(most)(z - at, none);
        found += e[E_LAW_LEFT_1 + j] * NAME(least)(z + at, none);
    }
    return found;
}

/// How fast what dry friction follows goes on: articulation, roll of car and trailer; or as seen
/// from where `z` was before.
INLINE V NAME(rubbing)(const V *x, const V *of, const V *turning, const V *e, V z)
{
    const V *is = e + E_LAW_OF_ARTICULATION;
    const M known =
        (is[0] != 0.0) | (e[E_LAW_OF_ROLL_CAR] != 0.0) | (e[E_LAW_OF_ROLL_TRAILER] != 0.0);
    const V rate =
        is[0] * of[1] + e[E_LAW_OF_ROLL_CAR] * turning[0] + e[E_LAW_OF_ROLL_TRAILER] * turning[1];
    return NAME(choose)(known, rate, (z - x[X_BEHIND]) * (1.0 / BEHIND_S));
}

/// Dry friction behind an elastic part (Dahl): slips at a bend.
INLINE V NAME(dragged)(const V *x, V rate, const V *e)
{
    const V some = NAME(most)(e[E_LAW_BEND], NAME(all)(1e-9));
    return rate - NAME(absolute)(rate) * x[X_LAW] / some;
}

/// How far `z` swings: what it was at the most, forgotten within a while.
INLINE V NAME(followed_swing)(V swing, V z)
{
    const V beyond = NAME(absolute)(z) - swing;
    const V grows = beyond * (1.0 / SWING_SEEN_S), fades = beyond * (1.0 / SWING_KEPT_S);
    return NAME(choose)(beyond > 0.0, grows, fades);
}

/// Nothing while the swing is small, `z` once it is larger than `at`.
INLINE V NAME(waiting)(V z, V swing, V at)
{
    const V some = NAME(most)(at, NAME(all)(1e-9));
    return 0.5 * z * (1.0 + NAME(hyperbolic_tangent)((swing - some) / (WAITING_SHARE * some)));
}

/// What follows `z` no faster than `at` a second.
INLINE V NAME(hurrying)(V behind, V at)
{
    const V some = NAME(most)(at, NAME(all)(1e-9));
    return NAME(most)(NAME(least)(behind * (1.0 / HURRY_S), some), -some);
}

/// What follows `z` once that is farther away than the play `at`.
INLINE V NAME(played)(V behind, V at)
{
    return (behind - NAME(most)(NAME(least)(behind, at), -at)) * (1.0 / PLAYED_S);
}

/// What multiplies a law: the size of a motion, or of what is felt.
INLINE V NAME(times)(const V *x, const V *of, const V *e)
{
    const V by = e[E_LAW_BY];
    V found = NAME(choose)(by > PLANT_LAW_STATES, NAME(absolute)(x[X_PRESSED]), NAME(all)(1.0));
    for (int j = 0; j < PLANT_LAW_STATES; j++) {
        found = NAME(choose)(by == 1.0 + j, NAME(absolute)(of[j]), found);
    }
    return found;
}

/// Value of the law: its gain, the shape of what it depends on, a power of the speed, a lag; or of
/// what has changed within that lag, or of what is felt; or what an oscillator makes of it.
/// `factor`: less one, of what is not the motion.
INLINE V NAME(law)(const V *x, const V *of, const V *turning, const V *e, V speed, V factor, V *dx)
{
    V z = {0};
    for (int j = 0; j < PLANT_LAW_STATES; j++) {
        z += e[E_LAW_OF_ARTICULATION + j] * of[j];
    }
    const V rate = NAME(rubbing)(x, of, turning, e, z);
    dx[X_BEHIND] = (z - x[X_BEHIND]) * (1.0 / BEHIND_S);
    const V lag = e[E_LAW_LAG], passing = e[E_LAW_TRANSIENT];
    const M follows = passing == OSCILLATES;
    z = NAME(choose)((passing > 0.0) & ~follows, z - x[X_LAW], z);
    z = NAME(choose)(passing == FELT, x[X_LAW], z);
    const V faster = speed * (1.0 / LAW_SPEED), power = e[E_LAW_SPEED_POWER];
    const V sticks = e[E_LAW_SHAPE] - LAW_STICKS;
    V bent = NAME(choose)(sticks == 0.0, x[X_LAW], NAME(bent)(z, e[E_LAW_SHAPE], e[E_LAW_BEND]));
    bent = NAME(choose)(e[E_LAW_SHAPE] == CURVE, NAME(in_pieces)(z, e), bent);
    const V against = NAME(hyperbolic_tangent)(rate * (1.0 / LAW_SLOW));
    bent = NAME(choose)(sticks == 1.0, NAME(absolute)(z) * against, bent);
    const V waits = sticks - WAITS;
    bent = NAME(choose)(waits == 0.0, NAME(waiting)(z, x[X_LAW], e[E_LAW_BEND]), bent);
    const V hurries = sticks - HURRIES, plays = sticks - PLAYS;
    bent = NAME(choose)((hurries == 0.0) | (plays == 0.0), x[X_LAW], bent);
    V value = e[E_LAW_GAIN] * bent * (1.0 + factor) * NAME(times)(x, of, e);
    value *= NAME(choose)(power > 0.0, faster, NAME(all)(1.0));
    value *= NAME(choose)(power > 1.0, faster, NAME(all)(1.0));
    value /= NAME(choose)(power < 0.0, faster, NAME(all)(1.0));
    // what is transient is a damper in series with a spring, which may have play or give way
    V pulls = NAME(choose)(passing > 0.0, z, value - x[X_LAW]);
    pulls = NAME(choose)(passing > 1.0, bent, pulls);
    const V late = pulls / NAME(most)(lag, NAME(all)(SHORTEST_LAW_S));
    dx[X_LAW] = NAME(choose)(sticks == 0.0, NAME(dragged)(x, rate, e), NAME(where)(lag, late));
    dx[X_LAW] = NAME(choose)(waits == 0.0, NAME(followed_swing)(x[X_LAW], z), dx[X_LAW]);
    const V hurried = NAME(hurrying)(z - x[X_LAW], e[E_LAW_BEND]);
    dx[X_LAW] = NAME(choose)(hurries == 0.0, hurried, dx[X_LAW]);
    const V played = NAME(played)(z - x[X_LAW], e[E_LAW_BEND]);
    dx[X_LAW] = NAME(choose)(plays == 0.0, played, dx[X_LAW]);
    // one state: what goes with the heading has neither lag nor friction, nor does it wait
    dx[X_LAW] = NAME(choose)(e[E_LAW_OF_HEADING] > 0.0, of[3], dx[X_LAW]);
    const V omega = 1.0 / NAME(most)(lag, NAME(all)(SHORTEST_LAW_S));
    const V back = value - x[X_LAW] - 2.0 * e[E_LAW_BEND] * x[X_BEHIND] / omega;
    dx[X_LAW] = NAME(choose)(follows, x[X_BEHIND], dx[X_LAW]);
    dx[X_BEHIND] = NAME(choose)(follows, omega * omega * back, dx[X_BEHIND]);
    const M at_once = (lag <= 0.0) | ((passing > 0.0) & ~follows);
    return NAME(choose)(at_once, value, x[X_LAW]);
}

/// How what is felt goes on behind its lag: accelerations of both bodies, and the trailer's force
/// on the ball. They are known once the motion is solved only, which the law takes part in.
INLINE V NAME(felt)(const V *x, const V *e, const V *felt, V force, V late)
{
    const V *of = e + E_LAW_OF_LATERAL_ACCELERATION_CAR;
    const V sum = of[0] * felt[0] + of[1] * felt[1] + of[2] * force;
    const V lag = NAME(most)(e[E_LAW_LAG], NAME(all)(SHORTEST_FELT_S));
    return NAME(choose)(e[E_LAW_TRANSIENT] == FELT, (sum - x[X_LAW]) / lag, late);
}

/// How that which is felt and multiplies a law goes on.
INLINE V NAME(pressing)(const V *x, const V *e, const V *felt, V force)
{
    const V by = e[E_LAW_BY] - PLANT_LAW_STATES;
    V found = NAME(choose)(by == 1.0, felt[0], force);
    found = NAME(choose)(by == 2.0, felt[1], found);
    return NAME(where)(by, (found - x[X_PRESSED]) * (1.0 / SHORTEST_FELT_S));
}

/// Deceleration of the mass that swings in a body: free within a gap in the middle, or held by
/// friction on the floor. `factor`: less one, of what holds it.
INLINE V NAME(pulled_back)(const V *x, const V *e, int body, V factor)
{
    const V omega = e[E_MODE_FREQUENCY_CAR + body], zeta = e[E_MODE_DAMPING_CAR + body];
    const V gap = e[E_MODE_GAP_CAR + body], q = x[X_MODE + body];
    const V free = q - NAME(most)(NAME(least)(q, gap), -gap);
    const V right = NAME(choose)(free < 0.0, e[E_MODE_OTHER_SIDE_CAR + body], NAME(all)(0.0));
    const V held = free * (1.0 + right) * (1.0 + factor);
    const V rate = x[X_MODE_RATE + body];
    const V drag = e[E_MODE_DRAG_CAR + body] * NAME(absolute)(rate);
    const V rubs =
        e[E_MODE_FRICTION_CAR + body] * NAME(hyperbolic_tangent)(rate * (1.0 / MODE_SLOW));
    return omega * (omega * held + 2.0 * zeta * rate) + drag * rate + rubs;
}

/// Its side force on the body.
INLINE V NAME(swinging)(const V *x, const V *e, int body, V factor)
{
    return e[E_MODE_MASS_CAR + body] * NAME(pulled_back)(x, e, body, factor);
}

/// How it goes on where its place has the acceleration `base` sideways.
INLINE void NAME(swing)(const V *x, const V *e, int body, V base, V factor, V *dx)
{
    const V back = NAME(pulled_back)(x, e, body, factor);
    dx[X_MODE + body] = NAME(where)(e[E_MODE_MASS_CAR + body], x[X_MODE_RATE + body]);
    dx[X_MODE_RATE + body] = NAME(where)(e[E_MODE_MASS_CAR + body], -base - back);
}

/// How much of the motion of a drawbar that is not stiffer than the steps allow is its own.
INLINE V NAME(drawbar_share)(const V *e)
{
    return NAME(least)(e[E_DRAWBAR_COMPLIANCE] * (1.0 / LEAST_DRAWBAR), NAME(all)(1.0));
}

/// Its side force on the car, in the trailer's axes.
INLINE V NAME(drawbar_force)(const V *x, const V *e)
{
    const V per_n = NAME(most)(e[E_DRAWBAR_COMPLIANCE], NAME(all)(LEAST_DRAWBAR));
    return (x[X_DRAWBAR] + DRAWBAR_LOSS_S * x[X_DRAWBAR_RATE]) / per_n;
}

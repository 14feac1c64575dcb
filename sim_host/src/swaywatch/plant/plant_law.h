// Laws that no named effect has: a force that one motion makes, a mass that swings in a body, a
// drawbar that gives way; included by plant_step.h. What the slots are is said by plant/lanes.py.

/// The hyperbolic tangent that a shape is made of, `per` one over its bend: of what saturates or
/// falls, is switched, goes in steps, or waits for a `swing`; of friction that grows with a
/// deflection.
INLINE V NAME(level)(V z, V swing, V rate, V shape, V per)
{
    const V beyond = z * per;
    V of = NAME(choose)(shape == FALLS, STEEP * beyond, beyond);
    of = NAME(choose)(shape == RUBS, rate * (1.0 / LAW_SLOW), of);
    of = NAME(choose)(shape == WAITS, (swing * per - 1.0) * (1.0 / WAITING_SHARE), of);
    const V switched = (NAME(absolute)(beyond) - 1.0) * (1.0 / SWITCHED_SHARE);
    of = NAME(choose)(shape == SWITCHES, switched, of);
    const V within = beyond - 0.5 - NAME(nearest)(beyond - 0.5);
    return NAME(hyperbolic_tangent)(NAME(choose)(shape == STEPS, within * (1.0 / STEP_SHARE), of));
}

/// A straight line, or bent at `at`: saturating, dead within it; cube, odd and even square; of one
/// side only, or `at` times as steep on the other one; a line with `at` times the cube; friction
/// that falls to half of it at `at`; of one side only, beyond `at`; of one size beyond it; a size
/// with the sign of its rate; all of it once what waits does no longer; steps; waves. `state`: what
/// has one.
INLINE V NAME(bent)(V z, V shape, V at, V level, V state, const FEATURES *has)
{
    const V some = NAME(most)(at, NAME(all)(1e-9)), none = {0};
    const V size = NAME(absolute)(z), square = z * z;
    V found = NAME(choose)(shape == SATURATES, some * level, z);
    const V within = NAME(most)(NAME(least)(z, some), -some);
    found = NAME(choose)(shape == 2.0, z - within, found);
    found = NAME(choose)(shape == 3.0, square * z, found);
    found = NAME(choose)(shape == 4.0, z * size, found);
    found = NAME(choose)(shape == 5.0, square, found);
    found = NAME(choose)(shape == RUBS, size * level, found);
    const V above = NAME(most)(z, none), below = NAME(least)(z, none);
    found = NAME(choose)(shape == 8.0, above, found);
    found = NAME(choose)(shape == 9.0, below, found);
    found = NAME(choose)(shape == WAITS, 0.5 * z * (1.0 + level), found);
    found = NAME(choose)(shape == 11.0, above + at * below, found);
    found = NAME(choose)(shape == 13.0, z * (1.0 + at * square), found);
    found = NAME(choose)(shape == FALLS, some * level / (1.0 + square / (some * some)), found);
    found = NAME(choose)(shape == 16.0, NAME(most)(z - some, none), found);
    found = NAME(choose)(shape == 17.0, NAME(least)(z + some, none), found);
    const V on = 0.5 * some * (1.0 + level);
    found = NAME(choose)(shape == SWITCHES, NAME(choose)(z < 0.0, -on, on), found);
    if (has->shapes & (BIT(STEPS) | BIT(NOTCHES))) {
        const V whole = NAME(nearest)(z / some - 0.5) + 0.5 + level * (0.5 / STEP_WHOLE);
        found = NAME(choose)(shape == STEPS, some * whole, found);
        V wave, unused;
        NAME(turn)(z / some, &wave, &unused);
        found = NAME(choose)(shape == NOTCHES, some * wave, found);
    }
    const M keeps = (shape == STICKS) | (shape == HURRIES) | (shape == PLAYS);
    return NAME(choose)(keeps, state, found);
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

/// Dry friction behind an elastic part (Dahl): slips at a bend, `per` one over it.
INLINE V NAME(dragged)(V state, V rate, V per)
{
    return rate - NAME(absolute)(rate) * state * per;
}

/// How far `z` swings: what it was at the most, forgotten within a while.
INLINE V NAME(followed_swing)(V swing, V z)
{
    const V beyond = NAME(absolute)(z) - swing;
    const V grows = beyond * (1.0 / SWING_SEEN_S), fades = beyond * (1.0 / SWING_KEPT_S);
    return NAME(choose)(beyond > 0.0, grows, fades);
}

/// What follows `z` no faster than `at` a second.
INLINE V NAME(hurrying)(V behind, V at)
{
    return NAME(most)(NAME(least)(behind * (1.0 / HURRY_S), at), -at);
}

/// What follows `z` once that is farther away than the play `at`.
INLINE V NAME(played)(V behind, V at)
{
    return (behind - NAME(most)(NAME(least)(behind, at), -at)) * (1.0 / PLAYED_S);
}

/// How the state of a shape that has one goes on; of others `otherwise`.
INLINE V NAME(kept)(V z, V state, V rate, V shape, V some, V per, V otherwise)
{
    V found = NAME(choose)(shape == STICKS, NAME(dragged)(state, rate, per), otherwise);
    found = NAME(choose)(shape == WAITS, NAME(followed_swing)(state, z), found);
    found = NAME(choose)(shape == HURRIES, NAME(hurrying)(z - state, some), found);
    return NAME(choose)(shape == PLAYS, NAME(played)(z - state, some), found);
}

/// What multiplies a law: the size of a motion, or of what is felt; or what grows with it from
/// nothing to one, half of that at a bend; or what is beyond the bend; or whether it is on one
/// side.
INLINE V NAME(times)(const V *x, const V *of, const V *e)
{
    const V by = e[E_LAW_BY], side = e[E_LAW_BY_SIDE], none = {0};
    V found = NAME(choose)(by > PLANT_LAW_STATES, x[X_PRESSED], none);
    for (int j = 0; j < PLANT_LAW_STATES; j++) {
        found = NAME(choose)(by == 1.0 + j, of[j], found);
    }
    const V there = 0.5 + 0.5 * NAME(hyperbolic_tangent)(found * side);
    const V size = NAME(absolute)(found), bend = e[E_LAW_BY_BEND];
    const V some = NAME(absolute)(bend);
    const V levels = size * size / (size * size + NAME(most)(some * some, NAME(all)(1e-12)));
    V sized = NAME(choose)(bend > 0.0, levels, size);
    sized = NAME(choose)(bend < 0.0, NAME(most)(size - some, none), sized);
    found = NAME(choose)(side == 0.0, sized, there);
    return NAME(choose)(by > 0.0, found, NAME(all)(1.0));
}

/// A power of the speed: -1 to 2.
INLINE V NAME(of_speed)(V speed, V power)
{
    const V faster = speed * (1.0 / LAW_SPEED), one = NAME(all)(1.0);
    const V square = NAME(choose)(power > 1.0, faster * faster, faster);
    return NAME(choose)(power > 0.0, square, NAME(choose)(power < 0.0, 1.0 / faster, one));
}

/// Value of the law: its gain, the shape of what it depends on, a power of the speed, a lag; or of
/// what has changed within that lag, or of what is felt; or what an oscillator makes of it.
/// `factor`: less one, of what is not the motion.
INLINE V NAME(law)(const V *x, const V *of, const V *turning, const V *e, const FEATURES *has,
                   V speed, V factor, V *dx)
{
    const V state = x[X_LAW], shape = e[E_LAW_SHAPE], lag = e[E_LAW_LAG];
    const V some = NAME(most)(e[E_LAW_BEND], NAME(all)(1e-9)), per = 1.0 / some;
    V z = {0};
    for (int j = 0; j < PLANT_LAW_STATES; j++) {
        z += e[E_LAW_OF_ARTICULATION + j] * of[j];
    }
    const V rate = NAME(rubbing)(x, of, turning, e, z);
    dx[X_BEHIND] = (z - x[X_BEHIND]) * (1.0 / BEHIND_S);
    const V passing = e[E_LAW_TRANSIENT];
    const M follows = passing == OSCILLATES;
    z = NAME(choose)((passing > 0.0) & ~follows, z - state, z);
    z = NAME(choose)(passing == FELT, state, z);
    const V memory = NAME(choose)(passing == FELT, x[X_BEHIND], state);
    V bent = z, level = {0};
    if (has->shapes & LEVELS) {
        level = NAME(level)(z, memory, rate, shape, per);
    }
    if (has->shapes & BENT) {
        bent = NAME(bent)(z, shape, e[E_LAW_BEND], level, memory, has);
    }
    if (has->shapes & BIT(CURVE)) {
        bent = NAME(choose)(shape == CURVE, NAME(in_pieces)(z, e), bent);
    }
    V value = e[E_LAW_GAIN] * bent * (1.0 + factor);
    if (has->times) {
        value *= NAME(times)(x, of, e);
    }
    value *= NAME(of_speed)(speed, e[E_LAW_SPEED_POWER]);
    // what is transient is a damper in series with a spring, which may have play or give way
    V pulls = NAME(choose)(passing > 0.0, z, value - state);
    pulls = NAME(choose)(passing > 1.0, bent, pulls);
    const V omega = 1.0 / NAME(most)(lag, NAME(all)(SHORTEST_LAW_S));
    V goes = NAME(where)(lag, pulls * omega);
    if (has->shapes & KEEP) {
        goes = NAME(kept)(z, state, rate, shape, some, per, goes);
    }
    // one state: what goes with the heading has neither lag nor friction, nor does it wait
    goes = NAME(choose)(e[E_LAW_OF_HEADING] > 0.0, of[3], goes);
    const V back = (value - state) * omega - 2.0 * e[E_LAW_BEND] * x[X_BEHIND];
    dx[X_LAW] = NAME(choose)(follows, x[X_BEHIND], goes);
    dx[X_BEHIND] = NAME(choose)(follows, omega * back, dx[X_BEHIND]);
    const M at_once = (lag <= 0.0) | ((passing > 0.0) & ~follows);
    return NAME(choose)(at_once, value, state);
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

/// How the memory of a shape goes on that follows what is felt: it has the second state, as the lag
/// has the first one. `rate`: of what is felt; of other laws `otherwise`.
INLINE V NAME(remembered)(const V *x, const V *e, V rate, V otherwise)
{
    const V some = NAME(most)(e[E_LAW_BEND], NAME(all)(1e-9));
    const V goes =
        NAME(kept)(x[X_LAW], x[X_BEHIND], rate, e[E_LAW_SHAPE], some, 1.0 / some, otherwise);
    return NAME(choose)(e[E_LAW_TRANSIENT] == FELT, goes, otherwise);
}

/// How that which is felt and multiplies a law goes on.
INLINE V NAME(pressing)(const V *x, const V *e, const V *felt, V force)
{
    const V by = e[E_LAW_BY] - PLANT_LAW_STATES;
    V found = NAME(choose)(by == 1.0, felt[0], force);
    found = NAME(choose)(by == 2.0, felt[1], found);
    return NAME(where)(by, (found - x[X_PRESSED]) * (1.0 / SHORTEST_FELT_S));
}

/// Deceleration of the mass that swings in a body: free, or less held, within a gap in the middle,
/// or held by friction on the floor, or in a part by friction within itself. `factor`: less one, of
/// what holds it.
INLINE V NAME(pulled_back)(const V *x, const V *e, const FEATURES *has, int body, V factor)
{
    const V omega = e[E_MODE_FREQUENCY_CAR + body], zeta = e[E_MODE_DAMPING_CAR + body];
    const V gap = e[E_MODE_GAP_CAR + body], q = x[X_MODE + body];
    const V free = q - NAME(most)(NAME(least)(q, gap), -gap);
    const V right = NAME(choose)(free < 0.0, e[E_MODE_OTHER_SIDE_CAR + body], NAME(all)(0.0));
    const V within = e[E_MODE_WITHIN_CAR + body] * (q - free);
    V held = (free * (1.0 + right) + within) * (1.0 + factor);
    if (has->stacks) {
        held += e[E_MODE_RUBBING_CAR + body] * (x[X_MODE_KEPT + body] - held);
    }
    const V rate = x[X_MODE_RATE + body];
    const V drag = e[E_MODE_DRAG_CAR + body] * NAME(absolute)(rate);
    V back = omega * (omega * held + 2.0 * zeta * rate) + drag * rate;
    if (has->rubs) {
        const V turned = NAME(hyperbolic_tangent)(rate * (1.0 / MODE_SLOW));
        back += e[E_MODE_FRICTION_CAR + body] * turned;
    }
    return back;
}

/// Its side force on the body.
INLINE V NAME(swinging)(const V *x, const V *e, const FEATURES *has, int body, V factor)
{
    return e[E_MODE_MASS_CAR + body] * NAME(pulled_back)(x, e, has, body, factor);
}

/// How it goes on where its place has the acceleration `base` sideways.
INLINE void NAME(swing)(const V *x, const V *e, const FEATURES *has, int body, V base, V factor,
                        V *dx)
{
    const V back = NAME(pulled_back)(x, e, has, body, factor);
    dx[X_MODE + body] = NAME(where)(e[E_MODE_MASS_CAR + body], x[X_MODE_RATE + body]);
    dx[X_MODE_RATE + body] = NAME(where)(e[E_MODE_MASS_CAR + body], -base - back);
    if (has->stacks) {
        const V slips = NAME(most)(e[E_MODE_SLIPS_CAR + body], NAME(all)(1e-9));
        const V goes = NAME(dragged)(x[X_MODE_KEPT + body], x[X_MODE_RATE + body], 1.0 / slips);
        dx[X_MODE_KEPT + body] = NAME(where)(e[E_MODE_RUBBING_CAR + body], goes);
    }
}

/// How much of the motion of a drawbar that is not stiffer than the steps allow is its own.
INLINE V NAME(drawbar_share)(const V *e)
{
    return NAME(least)(e[E_DRAWBAR_COMPLIANCE] * (1.0 / LEAST_DRAWBAR), NAME(all)(1.0));
}

/// Its side force on the car, in the trailer's axes: nothing holds the ball within a play, where
/// only friction acts; the loss comes in with what is pressed.
INLINE V NAME(drawbar_force)(const V *x, const V *e)
{
    const V per_n = NAME(most)(e[E_DRAWBAR_COMPLIANCE], NAME(all)(LEAST_DRAWBAR));
    const V q = x[X_DRAWBAR], rate = x[X_DRAWBAR_RATE], play = e[E_DRAWBAR_PLAY];
    const V pressed = q - NAME(most)(NAME(least)(q, play), -play);
    const V right = NAME(choose)(q < 0.0, e[E_DRAWBAR_OTHER_SIDE], NAME(all)(0.0));
    const V share = NAME(least)(NAME(absolute)(pressed) * (1.0 / BALL_MEETS_M), NAME(all)(1.0));
    const V meets = NAME(choose)(play > 0.0, share, NAME(all)(1.0));
    // as steep as the steps allow
    const V friction = NAME(most)(e[E_DRAWBAR_FRICTION], NAME(all)(1e-9));
    const V rubs = friction * NAME(hyperbolic_tangent)(rate * (BALL_RUBS / friction));
    return (pressed + DRAWBAR_LOSS_S * meets * rate) * (1.0 + right) / per_n +
           NAME(where)(e[E_DRAWBAR_FRICTION], rubs);
}

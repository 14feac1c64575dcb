// Wheels: where they go, what they carry, their side force; included by plant_step.h.

typedef struct {
    V force[2], load[2];
    V moment; // aligning, of both wheels
    V lifted; // what lifts the body
} AXLE;

/// What an axle's wheels carry and what their tyres are like.
typedef struct {
    V stiffness, load, per_load;
    V left, right; // extra load of one wheel
    V shift;       // load that goes from left to right
    V heave;       // load shared by both
    V slip, degression, softening, friction, trail, shape;
} TYRES;

/// Pneumatic trail of the brush model as a share of that at no slip; `x` is the linear force over
/// the peak (Pacejka, Tyre and Vehicle Dynamics, section 3.2: zero from full sliding, x = 3, on).
INLINE V NAME(trail)(V x)
{
    const V share = NAME(least)(NAME(absolute)(x) * (1.0 / 3.0), NAME(all)(1.0));
    const V left = 1.0 - share;
    return left * left * left / (1.0 - share + share * share * (1.0 / 3.0));
}

/// Force of a tyre whose stiffness falls with the square of its force over its load.
INLINE V NAME(softened)(V linear, V load, V softening)
{
    const V used = linear / NAME(most)(load, NAME(all)(1.0));
    V root = 1.0 + softening * used * used;
    for (int i = 0; i < WIDTH; i++) {
        root[i] = sqrt(root[i]);
    }
    return linear / root;
}

/// Where a tyre saturates: one comparison, as GCC takes two that are joined lane by lane.
INLINE M NAME(held)(const TYRES *t, V fz)
{
    return fz > NAME(choose)(t->friction > 0.0, NAME(all)(1.0), NAME(all)(1e300));
}

/// Lateral force of an axle from its two wheels.
INLINE V NAME(axle)(const TYRES *t, const FEATURES *has, AXLE *out)
{
    V total = {0};
    out->moment = total;
    for (int wheel = 0; wheel < 2; wheel++) {
        V fz = 0.5 * (t->load + t->heave);
        fz = wheel == 0 ? fz - t->shift + t->left : fz + t->shift + t->right;
        fz = NAME(most)(fz, NAME(all)(0.0));
        const V z = 2.0 * fz * t->per_load;
        V linear = 0.5 * t->stiffness * t->slip * z * (1.0 - t->degression * (z - 1.0));
        if (has->softens) {
            linear = NAME(softened)(linear, fz, t->softening);
        }
        V force = linear, share = {0};
        if (has->saturated) {
            const V peak = fz * t->friction;
            const M held = NAME(held)(t, fz);
            force = NAME(choose)(held, NAME(saturation)(linear, peak, t->shape), linear);
            if (has->aligning) {
                share = NAME(choose)(held, linear / peak, share);
            }
        }
        if (has->aligning) {
            out->moment -= t->trail * NAME(trail)(share) * force;
        }
        out->force[wheel] = force;
        out->load[wheel] = fz;
        total += force;
    }
    return total;
}

/// Force of an axle whose load has not shifted, for the load that it shifts itself.
INLINE V NAME(even)(const TYRES *t, const FEATURES *has)
{
    const V fz = NAME(most)(t->load + t->heave, NAME(all)(0.0));
    const V z = fz * t->per_load;
    V linear = t->stiffness * t->slip * z * (1.0 - t->degression * (z - 1.0));
    if (has->softens) {
        linear = NAME(softened)(linear, fz, t->softening);
    }
    if (!has->saturated) {
        return linear;
    }
    const V peak = fz * t->friction;
    const M held = NAME(held)(t, fz);
    return NAME(choose)(held, NAME(saturation)(linear, peak, t->shape), linear);
}

/// Share of the slip that lags behind by the relaxation length; the rest acts at once.
INLINE V NAME(lagging)(V length)
{
    return NAME(where)(length, NAME(least)(length * (1.0 / SHORTEST_LAG_M), NAME(all)(1.0)));
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
    V ahead, steer;       // speed of the car; angle of its front wheels
    V roll[2];            // car, trailer
    V angle[4], acting[4];
    V law;      // N, Nm or rad
    V drag[2];  // N, air drag of car and trailer
    V drive;    // N, what drives the whole where the speed is prescribed
    V pitch[4]; // N, axle loads that drag and drive shift lengthwise
} SLIPS;

/// Tyres of an axle as they are before any load shifts.
INLINE void NAME(tyres)(const V *ser, const V *p, const V *e, const CONSTANTS *k,
                        const SLIPS *slips, int a, TYRES *t)
{
    static const int stiffness[4] = {
        P_CAR_FRONT_CORNERING_STIFFNESS, P_CAR_REAR_CORNERING_STIFFNESS,
        P_TRAILER_FRONT_CORNERING_STIFFNESS, P_TRAILER_REAR_CORNERING_STIFFNESS};
    t->stiffness = p[stiffness[a]] * (1.0 + ser[T_STIFFNESS_CAR_FRONT + a]);
    t->load = p[P_CAR_FRONT_AXLE_LOAD + a];
    t->per_load = k->per_load[a];
    t->heave = ser[T_HEAVE_CAR_FRONT + a] + slips->pitch[a];
    t->shift = ser[T_SHIFT_CAR_FRONT + a];
    t->degression = k->axle[a][A_DEGRESSION];
    t->softening = k->axle[a][A_SOFTENING];
    t->friction = k->friction[a] * (1.0 + ser[T_FRICTION]);
    t->shape = k->drive[D_SHAPE];
    t->trail = e[E_TRAIL_CAR_FRONT + (a < 3 ? a : 2)];
}

/// Steering: free play rolls freely within its gap, compliance gives way to the side force
/// (Eq. 5.3). From the angle of rigid wheels, `to->angle[0]`, to what lags and what acts.
INLINE void NAME(steering)(V state, const V *ser, const V *p, const V *e, const CONSTANTS *k,
                           const FEATURES *has, SLIPS *to)
{
    V lost = {0};
    if (has->playing) {
        const V half = e[E_FREE_PLAY];
        lost = NAME(most)(NAME(least)(to->angle[0], half), -half);
    }
    const V rigid = to->angle[0] - lost;
    const V lags = NAME(lagging)(k->axle[0][A_RELAXATION]);
    const V mixed = rigid + lags * (state - rigid);
    V acting = mixed, yields = {0};
    if (has->flexible) {
        const V soft = (1.0 - lags) * e[E_STEERING_FLEXIBILITY];
        TYRES t;
        NAME(tyres)(ser, p, e, k, to, 0, &t);
        t.load += ser[T_LOAD_CAR_FRONT];
        const V slope = 1.0 / (1.0 + soft * t.stiffness * t.load * t.per_load);
        acting = mixed * slope;
        for (int i = 0; i < 2 && has->saturated; i++) {
            t.slip = acting;
            acting -= slope * (acting - mixed + soft * NAME(even)(&t, has));
        }
        t.slip = acting;
        yields = e[E_STEERING_FLEXIBILITY] * NAME(even)(&t, has);
    }
    to->steer -= lost + yields;
    to->angle[0] = rigid - yields;
    to->acting[0] = acting;
}

/// Air drag, and what it and the acceleration do to the axle loads: the trailer pulls at the ball,
/// the drive acts at the road. Quasi-static moments about the axles; bodies without springs keep
/// their loads.
INLINE void NAME(lengthwise)(const V *x, const SAMPLE *now, const V *p, const V *e,
                             const CONSTANTS *k, const FEATURES *has, SLIPS *to)
{
    const V m1 = p[P_CAR_MASS], m2 = p[P_TRAILER_MASS];
    to->drag[0] = 0.5 * AIR_DENSITY * e[E_DRAG_AREA_CAR] * to->ahead * to->ahead;
    to->drag[1] = 0.5 * AIR_DENSITY * e[E_DRAG_AREA_TRAILER] * to->speed * to->speed;
    V rate = now->acceleration;
    if (has->whole) {
        const V own = (x[X_DRIVE] - to->drag[0] - to->drag[1]) * k->per_m;
        rate = NAME(choose)(k->free > 0.0, own, rate);
    }
    const V pull = m2 * rate + to->drag[1];
    to->drive = m1 * rate + to->drag[0] + pull;
    if (!has->sprung) {
        memset(to->pitch, 0, sizeof to->pitch);
        return;
    }
    const V axis = e[E_ROLL_AXIS_HEIGHT_CAR];
    const V front = p[P_CAR_FRONT_AXLE_TO_COG], rear = p[P_CAR_REAR_AXLE_TO_COG];
    const V hitch = p[P_CAR_HITCH_TO_COG];
    // the trailer about its wheels: less weight on the ball
    const V first = p[P_TRAILER_FRONT_AXLE_LOAD], second = p[P_TRAILER_REAR_AXLE_LOAD];
    const V share = NAME(where)(first, first / (first + second));
    const V lever = p[P_TRAILER_HITCH_TO_COG] - share * p[P_TRAILER_FRONT_AXLE_TO_COG] +
                    (1.0 - share) * p[P_TRAILER_REAR_AXLE_TO_COG];
    const V over = m2 * rate * (k->height[1] - k->ball[1]) +
                   to->drag[1] * (e[E_WIND_HEIGHT_TRAILER] - k->ball[1]);
    const V lifted = NAME(where)(k->towed, over / lever);
    const V back = m1 * rate * (k->height[0] + axis) + to->drag[0] * (e[E_WIND_HEIGHT_CAR] + axis) +
                   pull * (k->ball[0] + axis);
    const V per_base = 1.0 / (front + rear);
    const V front_to = (lifted * (hitch - rear) - back) * per_base;
    const V rear_to = (back - lifted * (hitch + front)) * per_base;
    const V part = e[E_PITCH_TRANSFER];
    to->pitch[0] = part * front_to, to->pitch[1] = part * rear_to;
    to->pitch[2] = part * lifted * share, to->pitch[3] = part * lifted * (1.0 - share);
}

/// Slip angle of the trailer's tyres: of two axles the mean.
INLINE V NAME(middle_slip)(const V *angle, const V *p)
{
    const V two = p[P_TRAILER_FRONT_CORNERING_STIFFNESS];
    return NAME(choose)(two > 0.0, 0.5 * (angle[2] + angle[3]), angle[3]);
}

INLINE void NAME(slips)(const V *x, const SAMPLE *now, const V *p, const V *e, const CONSTANTS *k,
                        const FEATURES *has, SLIPS *to, V *dx)
{
    const V *ser = now->series;
    const V vx = has->whole ? NAME(choose)(k->free > 0.0, x[X_SPEED], now->speed) : now->speed;
    const V vy = x[X_SIDE], r1 = x[X_YAW_1], r2 = x[X_YAW_2];
    V s, c;
    NAME(turn)(x[X_ARTICULATION], &s, &c);
    V hvy = vy - p[P_CAR_HITCH_TO_COG] * r1;
    V own = -p[P_TRAILER_HITCH_TO_COG] * r2;
    if (has->sprung) {
        hvy -= k->ball[0] * x[X_ROLL_RATE];
        own += k->ball[1] * x[X_ROLL_RATE + 1];
    }
    if (has->bends) {
        own += NAME(drawbar_share)(e) * x[X_DRAWBAR_RATE];
    }
    const V vx2 = c * vx + s * hvy;
    const V vy2 = c * hvy - s * vx + own;
    const V per_vx = 1.0 / vx;
    const V per_vx2 = 1.0 / vx2;
    V *angle = to->angle;
    angle[0] = now->steer - NAME(slip)((vy + p[P_CAR_FRONT_AXLE_TO_COG] * r1) * per_vx);
    angle[1] = -NAME(slip)((vy - p[P_CAR_REAR_AXLE_TO_COG] * r1) * per_vx);
    angle[2] = -NAME(slip)((vy2 + p[P_TRAILER_FRONT_AXLE_TO_COG] * r2) * per_vx2);
    angle[3] = -NAME(slip)((vy2 - p[P_TRAILER_REAR_AXLE_TO_COG] * r2) * per_vx2);
    V turning[2];
    for (int body = 0; body < 2; body++) {
        V roll = {0}, rate = {0};
        if (has->sprung) {
            roll = x[X_ROLL + body], rate = x[X_ROLL_RATE + body];
        } else if (has->whole) {
            roll = e[E_ROLL_GAIN_CAR + body] * x[X_TRANSFER + body];
            rate = e[E_ROLL_GAIN_CAR + body] * x[X_TRANSFER_RATE + body];
        } else if (has->rolls) {
            roll = e[E_ROLL_GAIN_CAR + body] * x[X_ROLL + body];
            rate = e[E_ROLL_GAIN_CAR + body] * x[X_ROLL_RATE + body];
        }
        to->roll[body] = roll, turning[body] = rate;
    }
    to->law = (V){0};
    if (has->law) {
        const V of[PLANT_LAW_STATES] = {x[X_ARTICULATION],
                                        r2 - r1,
                                        r1,
                                        r2,
                                        NAME(slip)(vy * per_vx),
                                        NAME(slip)(vy2 * per_vx2),
                                        now->steer,
                                        to->roll[0],
                                        to->roll[1],
                                        x[X_LAW],
                                        angle[0],
                                        angle[1],
                                        NAME(middle_slip)(angle, p)};
        to->law = NAME(law)(x, of, turning, e, has, vx, ser[T_LAW], dx);
    }
    for (int a = 0; a < 4; a++) {
        angle[a] += ser[T_SLIP_CAR_FRONT + a];
        if (has->law) {
            angle[a] += to->law * e[E_LAW_TO_SLIP_CAR_FRONT + (a < 3 ? a : 2)];
        }
        if (has->rolls) {
            angle[a] += k->axle[a][A_ROLL_STEER] * to->roll[a / 2];
        }
        const V lags = NAME(lagging)(k->axle[a][A_RELAXATION]);
        to->acting[a] = has->relaxed ? angle[a] + lags * (x[X_SLIP + a] - angle[a]) : angle[a];
    }
    to->sine = s, to->cosine = c;
    to->hitch = hvy, to->speed = vx2, to->side = vy2, to->per_speed = per_vx2;
    to->ahead = vx;
    NAME(lengthwise)(x, now, p, e, k, has, to);
    to->steer = now->steer;
    if (has->flexible || has->playing) {
        NAME(steering)(x[X_SLIP], ser, p, e, k, has, to);
    }
}

/// An extra load is on the left while the yaw rate is negative (Fig. 6-3 of the dissertation).
INLINE M NAME(loaded_left)(const V *x)
{
    return x[X_YAW_1] < 0.0;
}

/// Extra force of the dampers beyond healthy ones, the springs of heave, and what they do to roll.
typedef struct {
    V left[4], right[4]; // N, a damper's own and the extra load of its strut
    V spring[4];         // N of each wheel
    V moment[2];         // Nm, rolls the body to the right
} DAMPERS;

/// Forces and loads of all wheels; total of each axle in `total`.
INLINE void NAME(axles)(const V *x, const V *ser, const V *p, const V *e, const CONSTANTS *k,
                        const FEATURES *has, const SLIPS *slips, const DAMPERS *dampers, AXLE *w,
                        V *total)
{
    const M negative = NAME(loaded_left)(x);
    for (int a = 0; a < 4; a++) {
        const int body = a / 2;
        TYRES t;
        NAME(tyres)(ser, p, e, k, slips, a, &t);
        const V extra = ser[T_LOAD_CAR_FRONT + a];
        const M own = (M)(has->heaves ? extra - e[E_LOAD_BY_STRUTS] * extra : extra);
        t.left = (V)(own & negative), t.right = (V)(own & ~negative);
        t.slip = slips->acting[a];
        V unshifted = {0};
        if (has->heaves || has->sprung) {
            unshifted = NAME(even)(&t, has);
        }
        if (has->heaves) {
            t.left -= dampers->spring[a] + dampers->left[a];
            t.right -= dampers->spring[a] + dampers->right[a];
            w[a].lifted = e[E_JACKING_CAR + body] * slips->roll[body] * unshifted;
            t.left += 0.5 * w[a].lifted, t.right += 0.5 * w[a].lifted;
        }
        if (has->sprung) {
            t.shift += k->spring[a] * x[X_ROLL + body] + k->damper[a] * x[X_ROLL_RATE + body];
            t.shift += k->geometric[a] * unshifted;
        } else {
            t.shift += e[E_TRANSFER_CAR_FRONT + a] * x[X_TRANSFER + body];
        }
        total[a] = NAME(axle)(&t, has, &w[a]);
    }
}

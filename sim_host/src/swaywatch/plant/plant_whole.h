// What a simulator needs beyond a fit: dampers and heave, drive and path; for each width.

INLINE V NAME(damper)(V rate, V damping, V factor, V asymmetry)
{
    const V sign = NAME(choose)(rate > 0.0, NAME(all)(1.0), NAME(all)(-1.0));
    return damping * rate * (factor * (1.0 + asymmetry * sign) - 1.0);
}

INLINE V NAME(roll_rate)(const V *x, const V *e, const FEATURES *has, int body)
{
    return has->sprung ? x[X_ROLL_RATE + body]
                       : e[E_ROLL_GAIN_CAR + body] * x[X_TRANSFER_RATE + body];
}

/// Forces of the dampers beyond healthy ones, and of the struts' share of an extra load: what
/// presses a wheel down lifts the body over it.
INLINE void NAME(dampers)(const V *x, const V *ser, const V *e, const CONSTANTS *k,
                          const FEATURES *has, DAMPERS *to)
{
    const M negative = NAME(loaded_left)(x);
    for (int a = 0; a < 4; a++) {
        const M extra = (M)(e[E_LOAD_BY_STRUTS] * ser[T_LOAD_CAR_FRONT + a]);
        const V *of = k->axle[a];
        const V swing = NAME(roll_rate)(x, e, has, a / 2) * of[A_HALF_TRACK];
        const V z = x[X_HEAVE + a], rate = x[X_HEAVE_RATE + a], omega = of[A_HEAVE_OMEGA];
        to->left[a] =
            NAME(damper)(rate + swing, of[A_DAMPER], of[A_DAMPER_LEFT], of[A_DAMPER_ASYMMETRY]) -
            (V)(extra & negative);
        to->right[a] =
            NAME(damper)(rate - swing, of[A_DAMPER], of[A_DAMPER_RIGHT], of[A_DAMPER_ASYMMETRY]) -
            (V)(extra & ~negative);
        to->spring[a] =
            0.5 * of[A_HEAVE_MASS] * omega * (omega * z + 2.0 * of[A_HEAVE_ZETA] * rate);
    }
    for (int body = 0; body < 2; body++) {
        const int f = 2 * body, r = f + 1;
        to->moment[body] = k->axle[f][A_HALF_TRACK] * (to->right[f] - to->left[f]) +
                           k->axle[r][A_HALF_TRACK] * (to->right[r] - to->left[r]);
    }
}

/// Heave over each axle; without springs the roll's lag takes the dampers' moment.
INLINE void NAME(heave)(const V *x, const V *e, const CONSTANTS *k, const FEATURES *has,
                        const DAMPERS *by, const AXLE *w, V *dx)
{
    for (int a = 0; a < 4; a++) {
        const V *of = k->axle[a];
        const V z = x[X_HEAVE + a], rate = x[X_HEAVE_RATE + a], omega = of[A_HEAVE_OMEGA];
        const V own = -omega * (omega * z + 2.0 * of[A_HEAVE_ZETA] * rate);
        const V mass = of[A_HEAVE_MASS];
        dx[X_HEAVE + a] = rate;
        dx[X_HEAVE_RATE + a] =
            NAME(where)(mass, own - (by->left[a] + by->right[a] - w[a].lifted) / mass);
    }
    for (int body = 0; body < 2 && !has->sprung; body++) {
        V stiffness = {0}; // of roll per m/s2 of the lag
        for (int a = 2 * body; a < 2 * body + 2; a++) {
            stiffness += 2.0 * k->axle[a][A_HALF_TRACK] * e[E_TRANSFER_CAR_FRONT + a];
        }
        const V omega = e[E_ROLL_FREQUENCY_CAR + 2 * body];
        dx[X_TRANSFER_RATE + body] +=
            NAME(where)(stiffness, by->moment[body] * omega * omega / stiffness);
    }
}

/// Drag, rolling resistance, brakes, and what side forces have along the bodies; with the moments
/// that differences between left and right make. `sine` is of the front wheels' angle.
INLINE void NAME(along)(const V *x, const V *ser, const CONSTANTS *k, const SLIPS *slips,
                        const AXLE *w, V sine, LOADS *to)
{
    const V *d = k->drive;
    to->along[0] = x[X_DRIVE] * k->free - slips->drag[0] - ser[T_BRAKE_CAR];
    to->along[1] -= ser[T_BRAKE_TRAILER];
    for (int a = 0; a < 4; a++) {
        V back[2];
        const V turned = k->axle[a][A_ROLL_STEER] * slips->roll[a / 2];
        for (int wheel = 0; wheel < 2; wheel++) {
            back[wheel] = w[a].force[wheel] * (a == 0 ? turned + sine : turned) +
                          w[a].load[wheel] * d[D_ROLLING_RESISTANCE];
        }
        to->along[a / 2] -= back[0] + back[1];
        to->yaw[a / 2] += k->axle[a][A_HALF_TRACK] * (back[0] - back[1]);
    }
}

/// The car's side force reaches its body with a lag (suspension compliance).
INLINE void NAME(lag_forces)(const V *x, const CONSTANTS *k, V *side, V *yaw, V *dx)
{
    const V lag = k->drive[D_SUSPENSION_LAG];
    const M lags = lag > 0.0;
    dx[X_LAG] = NAME(where)(lag, (*side - x[X_LAG]) / lag);
    dx[X_LAG + 1] = NAME(where)(lag, (*yaw - x[X_LAG + 1]) / lag);
    *side = NAME(choose)(lags, x[X_LAG], *side);
    *yaw = NAME(choose)(lags, x[X_LAG + 1], *yaw);
}

/// Speed controller (Eq. 5.1-5.2: PI, feed-forward on the deceleration, lag) and path.
INLINE void NAME(travel)(const V *x, const SAMPLE *now, const V *p, const CONSTANTS *k,
                         const SLIPS *slips, const RATES *rates, V *dx)
{
    const V *d = k->drive;
    const V error = now->speed - slips->ahead;
    const V mass = p[P_CAR_MASS] + p[P_TRAILER_MASS];
    V wanted = d[D_CONTROL_P] * error + d[D_CONTROL_I] * x[X_SPEED_INTEGRAL];
    wanted += slips->drag[0] + slips->drag[1];
    wanted += mass * (d[D_ROLLING_RESISTANCE] * GRAVITY + now->acceleration +
                      d[D_FEED_FORWARD] * (now->acceleration - rates->ahead));
    wanted = NAME(most)(NAME(least)(wanted, d[D_FORCE_MAX]), -d[D_FORCE_MAX]);
    dx[X_SPEED] = k->free * rates->ahead;
    dx[X_SPEED_INTEGRAL] = k->free * error;
    dx[X_DRIVE] = NAME(where)(k->free, (wanted - x[X_DRIVE]) / d[D_CONTROL_LAG]);
    V sine, cosine;
    NAME(turn)(x[X_HEADING], &sine, &cosine);
    dx[X_PLACE] = slips->ahead * cosine - x[X_SIDE] * sine;
    dx[X_PLACE + 1] = slips->ahead * sine + x[X_SIDE] * cosine;
    dx[X_HEADING] = x[X_YAW_1];
}

/// Outputs beyond those of a fit.
INLINE void NAME(whole_outputs)(const V *x, const SAMPLE *now, const V *p, const V *e,
                                const CONSTANTS *k, const FEATURES *has, const SLIPS *slips,
                                const LOADS *by, const RATES *rates, V *out)
{
    const V ahead = rates->ahead - x[X_SIDE] * x[X_YAW_1];
    out[O_SPEED] = slips->ahead;
    out[O_CAR_ACCELERATION_X] = ahead;
    out[O_TRAILER_ACCELERATION_X] = by->trailer_x;
    out[O_HITCH_MOMENT] = by->hitch;
    out[O_DRIVE_FORCE] = NAME(choose)(k->free > 0.0, x[X_DRIVE],
                                      p[P_CAR_MASS] * ahead - by->along[0] - out[O_HITCH_X]);
    out[O_ROAD_WHEEL_ANGLE] = slips->steer;
    out[O_PATH_X] = x[X_PLACE], out[O_PATH_Y] = x[X_PLACE + 1];
    out[O_HEADING] = x[X_HEADING];
    out[O_TRAILER_SIDESLIP] = NAME(slip)(slips->side * slips->per_speed);
    out[O_BANK] = now->series[T_BANK];
    for (int a = 0; a < 4; a++) {
        out[O_SLIP_ANGLE_F + a] = slips->angle[a];
    }
    for (int body = 0; body < 2; body++) {
        out[O_CAR_ROLL_RATE + body] = NAME(roll_rate)(x, e, has, body);
    }
}

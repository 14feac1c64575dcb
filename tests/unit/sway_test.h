/* Shared by unit tests: double <-> sway_real, the reference vehicle, a model mode as a line. */
#ifndef SWAY_TEST_H
#define SWAY_TEST_H

#include <complex.h>
#include <math.h>
#include <string.h>

#include "model/sway_identify.h"
#include "model/sway_single_track.h"
#include "reference_vehicle.h"

static inline double value(sway_real_t a)
{
    return ldexp((double)a.m, a.e);
}

static inline double complex cvalue(sway_complex_t a)
{
    return value(a.re) + I * value(a.im);
}

static inline sway_real_t real(double a)
{
    int exponent;
    const double mantissa = frexp(a, &exponent);
    return sway_real((int64_t)llround(ldexp(mantissa, 40)), exponent - 40);
}

static inline sway_complex_t complex_of(double complex a)
{
    return sway_complex(real(creal(a)), real(cimag(a)));
}

/* A motion of a linear combination at one s, and what its sensors say. */
typedef struct {
    double complex s;
    double v;
    double complex stiffness[4];
    double inertia[2];
    double pull;     /* hitch force along the car's axis, on the car */
    double friction; /* moment at the hitch, Nm per rad/s of articulation rate */
} test_plant_t;

static inline test_plant_t reference_plant(double kmh)
{
    const test_plant_t plant = {-0.1 + 4.2 * I, kmh / 3.6, {109300, 185200, 131200, 124400},
                                {2690, 10350},  0,         0};
    return plant;
}

static inline void set_channel(sway_line_t *line, sway_channel_t channel, double complex amplitude)
{
    line->channel[channel].amplitude = complex_of(amplitude);
    line->valid_mask |= SWAY_CHANNEL_BIT(channel);
}

/* The line that a vehicle of the given lengths and masses shows at plant->s when its steering wheel
 * moves by 20 deg: exact, linear. car_yaw_rate, accelerations, hitch and wheel forces. With the
 * wrong s there is no free motion, so the steering is what keeps it going. Unknowns: lateral speeds
 * are replaced by v (psi1), hitch kinematics and both bodies' balances. */
static inline void plant_line(const test_plant_t *plant, const sway_vehicle_t *vehicle,
                              sway_line_t *line)
{
    const double m1 = vehicle->car.mass_g / 1e3, m2 = vehicle->trailer.mass_g / 1e3;
    const double lf1 = vehicle->car.front_axle_to_cog_um / 1e6;
    const double lr1 = vehicle->car.rear_axle_to_cog_um / 1e6;
    const double lh1 = vehicle->car.hitch_to_cog_um / 1e6;
    const double lf2 = vehicle->trailer.front_axle_to_cog_um / 1e6;
    const double lr2 = vehicle->trailer.rear_axle_to_cog_um / 1e6;
    const double lh2 = vehicle->trailer.hitch_to_cog_um / 1e6;
    const double v = plant->v;
    const double complex s = plant->s, delta = 0.35 / (vehicle->car.steering_ratio_milli / 1e3);
    const double complex *c = plant->stiffness;
    const int axles = vehicle->trailer.axles;
    const double complex c2f = axles == 2 ? c[2] : 0, c2r = axles > 0 ? c[3] : 0;
    /* Unknowns: lateral speed u of the hitch (inertial), psi1, psi2; rows as in sway_single_track.
     */
    const double af = lh1 + lf1, ar = lh1 - lr1, bf = lh2 - lf2, br = lh2 + lr2;
    const double I1 = plant->inertia[0], I2 = plant->inertia[1];
    double complex A[3][4];
    A[0][0] = (axles ? m1 + m2 : m1) * s + (c[0] + c[1] + c2f + c2r) / v;
    A[0][1] = m1 * lh1 * s * s + (c[0] * af + c[1] * ar) * s / v - c[0] - c[1];
    A[0][2] = -((axles ? m2 : 0) * lh2 * s * s + (c2f * bf + c2r * br) * s / v) - c2f - c2r;
    A[0][3] = c[0] * delta;
    A[1][0] = m1 * lh1 * s + (c[0] * af + c[1] * ar) / v;
    A[1][1] = (I1 + m1 * lh1 * lh1) * s * s + (c[0] * af * af + c[1] * ar * ar) * s / v -
              (c[0] * af + c[1] * ar);
    A[1][2] = 0;
    A[1][3] = c[0] * af * delta;
    A[2][0] = -((axles ? m2 : 0) * lh2 * s + (c2f * bf + c2r * br) / v);
    A[2][1] = 0;
    A[2][2] = axles ? (I2 + m2 * lh2 * lh2) * s * s + (c2f * bf * bf + c2r * br * br) * s / v +
                          c2f * bf + c2r * br
                    : 1;
    A[2][3] = 0;
    if (axles) {
        const double complex turn = plant->friction * s;
        A[1][1] += turn;
        A[1][2] -= turn;
        A[2][1] -= turn;
        A[2][2] += turn;
    }
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            const double complex factor = i == k ? 0 : A[i][k] / A[k][k];
            for (int j = k; j < 4; j++) {
                A[i][j] -= factor * A[k][j];
            }
        }
    }
    const double complex u = A[0][3] / A[0][0], psi1 = A[1][3] / A[1][1], psi2 = A[2][3] / A[2][2];
    const double complex y1 = u + lh1 * s * psi1, y2 = u - lh2 * s * psi2;
    memset(line, 0, sizeof *line);
    line->window_samples = 300;
    line->omega_rad_s = real(cimag(s));
    line->growth_1_s = real(creal(s));
    line->speed_m_s = real(v);
    const double x1 = vehicle->car.lateral_acc_position_um / 1e6;
    const double x2 = vehicle->trailer.lateral_acc_position_um / 1e6;
    const double complex f1 = c[0] * (delta + psi1 - (y1 + lf1 * s * psi1) / v);
    const double complex r1 = c[1] * (psi1 - (y1 - lr1 * s * psi1) / v);
    const double complex f2 = c2f * (psi2 - (y2 + lf2 * s * psi2) / v);
    const double complex r2 = c2r * (psi2 - (y2 - lr2 * s * psi2) / v);
    set_channel(line, SWAY_CHANNEL_STEERING_WHEEL_ANGLE, 0.35);
    set_channel(line, SWAY_CHANNEL_CAR_YAW_RATE, s * psi1);
    set_channel(line, SWAY_CHANNEL_CAR_LATERAL_ACC, s * y1 + x1 * s * s * psi1);
    set_channel(line, SWAY_CHANNEL_CAR_FRONT_FY, f1);
    set_channel(line, SWAY_CHANNEL_CAR_REAR_FY, r1);
    if (axles == 0) {
        return;
    }
    set_channel(line, SWAY_CHANNEL_TRAILER_YAW_RATE, s * psi2);
    set_channel(line, SWAY_CHANNEL_TRAILER_LATERAL_ACC, s * y2 + x2 * s * s * psi2);
    set_channel(line, SWAY_CHANNEL_HITCH_FY, m1 * s * y1 - f1 - r1 + plant->pull * (psi2 - psi1));
    set_channel(line, SWAY_CHANNEL_HITCH_FX, 0);
    line->channel[SWAY_CHANNEL_HITCH_FX].mean = real(plant->pull);
    if (axles == 2) {
        set_channel(line, SWAY_CHANNEL_TRAILER_FRONT_FY, f2);
    }
    set_channel(line, SWAY_CHANNEL_TRAILER_REAR_FY, r2);
}

#endif

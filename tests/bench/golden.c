/* Every golden value of the reference (recomputed in double precision from its corrected matrices)
 * beside what the integer core says: a Markdown table, and exit status 1 on a miss. The core is fed
 * with the speed alone; its status then holds the model of the user's vehicle. The second mode is
 * not in the status: it comes from sway_single_track. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sway_core.h"
#include "signal/sway_search.h"
#include "sway_test.h"

static int misses;
static int rows;

static void row(const char *name, double found, double golden, double tolerance, int digits)
{
    const int good = fabs(found - golden) <= tolerance;
    printf("| %s | %.*f | %.*f | %.*f | %s |\n", name, digits, found, digits, golden, digits,
           tolerance, good ? "yes" : "**no**");
    rows++;
    misses += !good;
}

/* Status of a core that has seen two seconds of constant speed. */
static sway_status_t status_at(const sway_vehicle_t *vehicle, double v_m_s)
{
    static sway_core_t core;
    sway_core_config_t config;
    sway_core_defaults(&config);
    config.vehicle = *vehicle;
    if (sway_core_init(&core, &config) != SWAY_OK) {
        fputs("golden: the core refuses the reference vehicle\n", stderr);
        exit(1);
    }
    for (int k = 0; k < 200; k++) {
        (void)sway_core_input(&core, SWAY_INPUT_SPEED, 10000 * k, (int32_t)lround(v_m_s * 1e3));
        while (sway_core_run(&core)) {
        }
    }
    return *sway_core_status(&core);
}

static void critical_speeds(void)
{
    sway_vehicle_t vehicle = reference_vehicle();
    row("critical speed, Tables A and B, km/h", status_at(&vehicle, 30).v_crit_mm_s * 3.6e-3,
        123.3397, 0.05, 4);
    vehicle.car.front_cornering_stiffness_n_per_rad = 109200;
    vehicle.car.rear_cornering_stiffness_n_per_rad = 184900;
    vehicle.trailer.front_cornering_stiffness_n_per_rad = 134200;
    vehicle.trailer.rear_cornering_stiffness_n_per_rad = 123400;
    row("critical speed, Table 5-1, experiment, km/h", status_at(&vehicle, 30).v_crit_mm_s * 3.6e-3,
        123.028, 0.05, 4);
}

/* Damping ratio and frequency of the oscillating mode that is not the dominant one. */
static void other_mode(double v_m_s, double *ratio, double *hertz)
{
    const sway_vehicle_t vehicle = reference_vehicle();
    sway_single_track_t stm;
    sway_single_track_roots_t roots;
    (void)sway_single_track_from_vehicle(&stm, &vehicle);
    const sway_single_track_quartic_t quartic = sway_single_track_quartic(&stm, real(v_m_s));
    sway_single_track_roots_start(&roots, &quartic);
    for (int sweep = 0; sweep < 50 && !sway_single_track_roots_sweep(&roots, &quartic); sweep++) {
    }
    *ratio = -2;
    for (int k = 0; k < roots.count; k++) {
        const double found = value(sway_single_track_damping_ratio(roots.root[k]));
        if (value(roots.root[k].im) > 0 && found > *ratio) {
            *ratio = found;
            *hertz = value(roots.root[k].im) / (2 * M_PI);
        }
    }
}

static void modes(void)
{
    static const double golden[5][5] = {
        {80, 0.2520, 0.6478, 0.9178, 0.5180},    {100, 0.1115, 0.6659, 0.8840, 0.5385},
        {107.9, 0.0689, 0.6690, 0.8712, 0.5448}, {117.3, 0.0250, 0.6712, 0.8565, 0.5513},
        {140, -0.0587, 0.6729, 0.8240, 0.5638},
    };
    const sway_vehicle_t vehicle = reference_vehicle();
    for (int i = 0; i < 5; i++) {
        const double v_m_s = golden[i][0] / 3.6;
        const sway_status_t status = status_at(&vehicle, v_m_s);
        double ratio = 0;
        double hertz = 0;
        char name[80];
        other_mode(v_m_s, &ratio, &hertz);
        snprintf(name, sizeof name, "damping ratio at %g km/h", golden[i][0]);
        row(name, status.model_damping_ratio_ppm * 1e-6, golden[i][1], 0.0005, 4);
        snprintf(name, sizeof name, "frequency at %g km/h, Hz", golden[i][0]);
        row(name, status.model_frequency_uhz * 1e-6, golden[i][2], 0.0005, 4);
        snprintf(name, sizeof name, "other mode: damping ratio at %g km/h", golden[i][0]);
        row(name, ratio, golden[i][3], 0.0005, 4);
        snprintf(name, sizeof name, "other mode: frequency at %g km/h, Hz", golden[i][0]);
        row(name, hertz, golden[i][4], 0.0005, 4);
    }
}

static void sensitivities(void)
{
    static const struct {
        const char *name;
        double golden;
    } parameter[SWAY_PARAMETER_COUNT] = {
        {"m1", 0.188},     {"m2", -0.216},   {"Iz1", 0.140},   {"Iz2", -0.721},  {"l_f1", 0.064},
        {"l_r1", 0.844},   {"l_h1", -0.767}, {"l_f2", -0.062}, {"l_r2", 0.284},  {"l_h2", 1.452},
        {"C_af1", -0.156}, {"C_ar1", 0.440}, {"C_af2", 0.005}, {"C_ar2", 0.334},
    };
    const sway_vehicle_t vehicle = reference_vehicle();
    const sway_status_t status = status_at(&vehicle, 30);
    for (int i = 0; i < (int)SWAY_PARAMETER_COUNT; i++) {
        char name[80];
        snprintf(name, sizeof name, "critical speed for +1 %% of %s, km/h", parameter[i].name);
        row(name, status.sensitivity_mm_s[i] * 3.6e-3, parameter[i].golden,
            fmax(0.03 * fabs(parameter[i].golden), 0.005), 4);
    }
}

static void steady_state(void)
{
    static const double golden[3][3] = {
        {10, 3.35706, -1.99922}, {20, 4.98953, -1.37428}, {30, 5.24074, -0.83228}};
    const sway_vehicle_t vehicle = reference_vehicle();
    for (int i = 0; i < 3; i++) {
        const sway_status_t status = status_at(&vehicle, golden[i][0]);
        char name[80];
        snprintf(name, sizeof name, "yaw rate per road-wheel angle at %g m/s, 1/s", golden[i][0]);
        row(name, status.yaw_rate_gain_micro_per_s * 1e-6, golden[i][1], 0.001 * fabs(golden[i][1]),
            5);
        snprintf(name, sizeof name, "hitch angle per road-wheel angle at %g m/s", golden[i][0]);
        row(name, status.hitch_angle_gain_ppm * 1e-6, golden[i][2], 0.001 * fabs(golden[i][2]), 5);
    }
}

/* x = 4 r / (3 + sqrt(9 + 4 r^2)): the offset of a line from its bin, Hann window. */
static void hann_offsets(void)
{
    for (double x = -0.5; x <= 0.5; x += 0.25) {
        char name[80];
        const double r = 6 * x / (4 - x * x);
        snprintf(name, sizeof name, "offset of a Hann line, r = %.4f, bins", r);
        row(name, value(sway_search_offset(real(1), real(2), real(1 + 2 * r))), x, 1.2e-6, 7);
    }
}

int main(void)
{
    printf("**Golden values of the reference (`make bench-golden`)**\n\n");
    printf("| value | core | golden | tolerance | met |\n|---|---|---|---|---|\n");
    critical_speeds();
    modes();
    sensitivities();
    steady_state();
    hann_offsets();
    printf("\n%d of %d values within their tolerance.\n", rows - misses, rows);
    return misses != 0;
}

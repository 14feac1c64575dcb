/* The core as a model: inputs are what sensors measure, parameters the vehicle, outputs the newest
 * status. A step takes the inputs as one sample of each; what is never set is a sensor that is not
 * there. */
#include "fmu_model.h"

#include <math.h>
#include <string.h>

#include "sway_core.h"

typedef struct {
    const char *name;
    const char *unit;
    sway_input_t input;
    double scale; ///< of the core in one SI unit
} input_t;

#define FORCES(prefix, fy, fz)                                                                     \
    {prefix "wheel_lateral_force_fl", "N", fy##_FL, 1e3},                                          \
        {prefix "wheel_lateral_force_fr", "N", fy##_FR, 1e3},                                      \
        {prefix "wheel_lateral_force_rl", "N", fy##_RL, 1e3},                                      \
        {prefix "wheel_lateral_force_rr", "N", fy##_RR, 1e3},                                      \
        {prefix "wheel_vertical_load_fl", "N", fz##_FL, 1e3},                                      \
        {prefix "wheel_vertical_load_fr", "N", fz##_FR, 1e3},                                      \
        {prefix "wheel_vertical_load_rl", "N", fz##_RL, 1e3},                                      \
    {                                                                                              \
        prefix "wheel_vertical_load_rr", "N", fz##_RR, 1e3                                         \
    }

static const input_t inputs[] = {
    {"steering_wheel_angle", "rad", SWAY_INPUT_STEERING_WHEEL_ANGLE, 1e6},
    {"speed", "m/s", SWAY_INPUT_SPEED, 1e3},
    {"car_yaw_rate", "rad/s", SWAY_INPUT_CAR_YAW_RATE, 1e6},
    {"car_lateral_acceleration", "m/s2", SWAY_INPUT_CAR_LATERAL_ACC, 1e6},
    {"trailer_yaw_rate", "rad/s", SWAY_INPUT_TRAILER_YAW_RATE, 1e6},
    {"trailer_lateral_acceleration", "m/s2", SWAY_INPUT_TRAILER_LATERAL_ACC, 1e6},
    {"articulation", "rad", SWAY_INPUT_ARTICULATION, 1e6},
    {"hitch_longitudinal_force", "N", SWAY_INPUT_HITCH_FX, 1e3},
    {"hitch_lateral_force", "N", SWAY_INPUT_HITCH_FY, 1e3},
    FORCES("", SWAY_INPUT_CAR_FY, SWAY_INPUT_CAR_FZ),
    FORCES("trailer_", SWAY_INPUT_TRAILER_FY, SWAY_INPUT_TRAILER_FZ),
};
#define INPUT_COUNT (sizeof inputs / sizeof inputs[0])

typedef struct {
    const char *name;
    const char *unit;
    uint16_t offset; ///< of the 32 bits in the status
    double factor;   ///< to SI
} output_t;

#define OF(field) (uint16_t) offsetof(sway_status_t, field)
static const output_t outputs[] = {
    {"sequence", "", OF(sequence), 1.0},
    {"valid", "", OF(valid), 1.0},
    {"quality", "", OF(quality), 1.0},
    {"alarm", "", OF(alarm), 1.0},
    {"reasons", "", OF(reasons), 1.0},
    {"speed_m_s", "m/s", OF(speed_mm_s), 1e-3},
    {"frequency_hz", "Hz", OF(frequency_uhz), 1e-6},
    {"frequency_se_hz", "Hz", OF(frequency_se_uhz), 1e-6},
    {"growth_per_s", "1/s", OF(growth_ppm_per_s), 1e-6},
    {"growth_se_per_s", "1/s", OF(growth_se_ppm_per_s), 1e-6},
    {"damping_ratio", "", OF(damping_ratio_ppm), 1e-6},
    {"damping_ratio_se", "", OF(damping_ratio_se_ppm), 1e-6},
    {"amplitude_rad_s", "rad/s", OF(amplitude_urad_s), 1e-6},
    {"margin_damping_ratio", "", OF(margin_damping_ratio_ppm), 1e-6},
    {"v_crit_m_s", "m/s", OF(v_crit_mm_s), 1e-3},
    {"v_crit_se_m_s", "m/s", OF(v_crit_se_mm_s), 1e-3},
    {"margin_m_s", "m/s", OF(margin_mm_s), 1e-3},
    {"car_front.cornering_stiffness_n_per_rad", "N/rad", OF(axle[0].cornering_stiffness_n_per_rad),
     1.0},
    {"car_rear.cornering_stiffness_n_per_rad", "N/rad", OF(axle[1].cornering_stiffness_n_per_rad),
     1.0},
    {"trailer_front.cornering_stiffness_n_per_rad", "N/rad",
     OF(axle[2].cornering_stiffness_n_per_rad), 1.0},
    {"trailer_rear.cornering_stiffness_n_per_rad", "N/rad",
     OF(axle[3].cornering_stiffness_n_per_rad), 1.0},
    {"time_to_limit_s", "s", OF(time_to_limit_ms), 1e-3},
};
#define OUTPUT_COUNT (sizeof outputs / sizeof outputs[0])

/// Lengths of a step, s: the core's inputs come every 1 to 100 ms.
#define SHORTEST_STEP_S 0.001
#define LONGEST_STEP_S 0.1

struct fmu_model {
    bool is_used;
    bool is_started;
    bool is_set[INPUT_COUNT];
    double input[INPUT_COUNT];
    double time_s;
    int64_t time_us;
    sway_core_config_t config;
    sway_core_t core;
};

static fmu_model_t models[FMU_INSTANCES];

/* A reference combination, so that an FMU can be tried as it is. */
static const sway_vehicle_t reference = {.car = {.mass_g = 1955000,
                                                 .yaw_inertia_gm2 = 2690000,
                                                 .front_axle_to_cog_um = 1302000,
                                                 .rear_axle_to_cog_um = 1383000,
                                                 .hitch_to_cog_um = 2166000,
                                                 .front_cornering_stiffness_n_per_rad = 109300,
                                                 .rear_cornering_stiffness_n_per_rad = 185200,
                                                 .steering_ratio_milli = 15000},
                                         .trailer = {.axles = 2,
                                                     .mass_g = 1880000,
                                                     .yaw_inertia_gm2 = 10350000,
                                                     .front_axle_to_cog_um = 124000,
                                                     .rear_axle_to_cog_um = 526000,
                                                     .hitch_to_cog_um = 5073000,
                                                     .front_cornering_stiffness_n_per_rad = 131200,
                                                     .rear_cornering_stiffness_n_per_rad = 124400}};

static const char *unit_of(const char *key)
{
    static const char *const units[][2] = {{"mass", "kg"}, {"inertia", "kg.m2"},
                                           {"_cog", "m"},  {"stiffness", "N/rad"},
                                           {"_load", "N"}, {"position", "m"}};
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        if (strstr(key, units[i][0]) != NULL) {
            return units[i][1];
        }
    }
    return "";
}

bool fmu_variable(size_t index, fmu_variable_t *variable)
{
    size_t parameters = 0;
    const sway_vehicle_range_t *const ranges = sway_vehicle_ranges(&parameters);
    if (index < INPUT_COUNT) {
        *variable = (fmu_variable_t){inputs[index].name, inputs[index].unit, FMU_INPUT,
                                     FMU_INPUTS + (uint32_t)index, 0.0};
        return true;
    }
    index -= INPUT_COUNT;
    if (index < parameters) {
        const sway_vehicle_name_t *const name = sway_vehicle_name(&ranges[index]);
        *variable = (fmu_variable_t){
            name->key, unit_of(name->key), FMU_PARAMETER, FMU_PARAMETERS + (uint32_t)index,
            (double)sway_vehicle_value(&reference, &ranges[index]) / (double)name->scale};
        return true;
    }
    index -= parameters;
    if (index < OUTPUT_COUNT) {
        *variable = (fmu_variable_t){outputs[index].name, outputs[index].unit, FMU_OUTPUT,
                                     FMU_OUTPUTS + (uint32_t)index, 0.0};
        return true;
    }
    return false;
}

/* --- life --------------------------------------------------------------------------------------
 */

void fmu_reset(fmu_model_t *model)
{
    memset(model, 0, sizeof *model);
    model->is_used = true;
    sway_core_defaults(&model->config);
    model->config.vehicle = reference;
    model->config.input_period_us = 0; // whatever the length of a step
}

fmu_model_t *fmu_new(void)
{
    for (size_t i = 0; i < FMU_INSTANCES; i++) {
        if (!models[i].is_used) {
            fmu_reset(&models[i]);
            return &models[i];
        }
    }
    return NULL;
}

void fmu_free(fmu_model_t *model)
{
    model->is_used = false;
}

bool fmu_start(fmu_model_t *model, const char **message)
{
    const sway_vehicle_range_t *offender = NULL;
    *message = "";
    if (sway_vehicle_check(&model->config.vehicle, &offender) != SWAY_OK) {
        *message = sway_vehicle_name(offender)->key;
        return false;
    }
    model->time_us = -1;
    model->is_started = sway_core_init(&model->core, &model->config) == SWAY_OK;
    return model->is_started;
}

/* --- values ------------------------------------------------------------------------------------
 */

static bool fits(double value)
{
    return value > -2147483647.5 && value < 2147483647.5; // false for what is no number, too
}

static bool set_parameter(fmu_model_t *model, size_t index, double value)
{
    size_t count = 0;
    const sway_vehicle_range_t *const ranges = sway_vehicle_ranges(&count);
    if (index >= count || model->is_started) {
        return false;
    }
    const double scaled = nearbyint(value * (double)sway_vehicle_name(&ranges[index])->scale);
    if (!fits(scaled)) {
        return false;
    }
    const int32_t whole = (int32_t)scaled;
    memcpy((unsigned char *)&model->config.vehicle + ranges[index].offset, &whole, sizeof whole);
    return true;
}

bool fmu_set(fmu_model_t *model, uint32_t reference_number, double value)
{
    if (reference_number >= FMU_PARAMETERS) {
        return set_parameter(model, reference_number - FMU_PARAMETERS, value);
    }
    const size_t index = (size_t)reference_number - FMU_INPUTS;
    if (reference_number < FMU_INPUTS || index >= INPUT_COUNT) {
        return false;
    }
    model->input[index] = value;
    model->is_set[index] = true;
    return true;
}

static bool get_parameter(const fmu_model_t *model, size_t index, double *value)
{
    size_t count = 0;
    const sway_vehicle_range_t *const ranges = sway_vehicle_ranges(&count);
    if (index >= count) {
        return false;
    }
    *value = (double)sway_vehicle_value(&model->config.vehicle, &ranges[index]) /
             (double)sway_vehicle_name(&ranges[index])->scale;
    return true;
}

/* Bits and counts are without a sign; none of them reaches the sign's bit. */
static double output(const fmu_model_t *model, size_t index)
{
    int32_t value;
    memcpy(&value, (const unsigned char *)sway_core_status(&model->core) + outputs[index].offset,
           sizeof value);
    return (double)value * outputs[index].factor;
}

bool fmu_get(const fmu_model_t *model, uint32_t number, double *value)
{
    if (number == 0U) {
        *value = model->time_s;
        return true;
    }
    if (number >= FMU_OUTPUTS) {
        const size_t index = number - FMU_OUTPUTS;
        *value = index < OUTPUT_COUNT && model->is_started ? output(model, index) : 0.0;
        return index < OUTPUT_COUNT;
    }
    if (number >= FMU_PARAMETERS) {
        return get_parameter(model, number - FMU_PARAMETERS, value);
    }
    if (number - FMU_INPUTS >= INPUT_COUNT) {
        return false;
    }
    *value = model->input[number - FMU_INPUTS];
    return true;
}

static void feed(fmu_model_t *model, size_t index)
{
    const double scaled = nearbyint(model->input[index] * inputs[index].scale);
    if (fits(scaled)) {
        (void)sway_core_input(&model->core, inputs[index].input, model->time_us, (int32_t)scaled);
    } else {
        sway_core_invalid(&model->core, inputs[index].input, model->time_us);
    }
}

bool fmu_step(fmu_model_t *model, double time_s, double step_s)
{
    const double us = nearbyint(time_s * 1e6);
    if (!model->is_started || !(step_s >= SHORTEST_STEP_S * 0.999) ||
        !(step_s <= LONGEST_STEP_S * 1.001) || !(us > (double)model->time_us) || !(us < 4e15)) {
        return false;
    }
    model->time_us = (int64_t)us;
    model->time_s = time_s + step_s;
    for (size_t i = 0; i < INPUT_COUNT; i++) {
        if (model->is_set[i]) {
            feed(model, i);
        }
    }
    while (sway_core_run(&model->core)) {
    }
    return true;
}

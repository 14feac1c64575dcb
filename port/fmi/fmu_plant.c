/* The plant as a model: car and trailer on springs (sim_host/src/swaywatch/plant/plant_lanes.h),
 * one simulation. Steering and speed run within a step with the rates that are set beside them (0:
 * they stay), everything else stays. plant_table.h, made by plant_table.py of a vehicle file, holds
 * what the vehicle starts with and the names of all variables. */
#include <math.h>
#include <string.h>

#include "fmu_model.h"
#include "plant_lanes.h"

#define GRAVITY 9.81
#define AIR_DENSITY 1.2
#define LONGEST_STEP_S 0.1
#define LONGEST_INNER_STEP_S 0.005
#define SHORTEST_RELAXATION_M 0.15
#define MOST_INNER_STEPS 128
#define SLOWEST_M_S 0.5
#define FASTEST_M_S 120.0

/// Where a parameter goes.
typedef enum { TO_BODY, TO_SCALAR, TO_AXLE, TO_DRIVE, TO_OWN } room_t;
/// Parameters that are no number of the plant itself.
enum { OWN_STEERING_RATIO, OWN_POSITION_CAR, OWN_POSITION_TRAILER, OWN_COUNT };

typedef struct {
    const char *name;
    const char *unit;
    room_t room;
    int index;
    bool is_inverse; ///< the plant takes one over it; 0: none of it
    double low;      ///< least value
    double start;
} parameter_t;

typedef struct {
    const char *name;
    const char *unit;
    int column; ///< of the plant's outputs
    int body;   ///< whose lateral acceleration at its sensor it is; -1: the column as it is
} output_t;

#include "plant_table.h"

#define PARAMETER_COUNT (sizeof parameters / sizeof parameters[0])
#define OUTPUT_COUNT (sizeof outputs / sizeof outputs[0])

enum {
    IN_STEERING,
    IN_STEERING_RATE,
    IN_SPEED,
    IN_ACCELERATION,
    IN_HELD, ///< from here on what stays within a step
    IN_COUNT = IN_HELD + 7
};

typedef struct {
    const char *name;
    const char *unit;
    double start;
} input_t;

static const input_t inputs[IN_COUNT] = {
    {"steering_wheel_angle", "rad", 0.0},
    {"steering_wheel_angle_rate", "rad/s", 0.0},
    {"target_speed", "m/s", 25.0},
    {"target_speed_rate", "m/s2", 0.0},
    {"car_brake_force", "N", 0.0},
    {"trailer_brake_force", "N", 0.0},
    {"car_wind_force", "N", 0.0},
    {"car_wind_moment", "N.m", 0.0},
    {"trailer_wind_force", "N", 0.0},
    {"trailer_wind_moment", "N.m", 0.0},
    {"road_bank", "rad", 0.0},
};
/// Time function of each input that is held.
static const int held_slot[IN_COUNT - IN_HELD] = {
    T_BRAKE_CAR,     T_BRAKE_TRAILER,  T_FORCE_CAR, T_MOMENT_CAR,
    T_FORCE_TRAILER, T_MOMENT_TRAILER, T_BANK,
};

struct fmu_model {
    bool is_used;
    bool is_started;
    bool is_lost;
    double time_s;
    double input[IN_COUNT];
    double parameter[PARAMETER_COUNT];
    double own[OWN_COUNT];
    double body[PLANT_BODY], scalars[PLANT_SCALARS], axles[4 * PLANT_AXLE];
    plant_whole_t whole;
    plant_lane_t lane;
    double speed[MOST_INNER_STEPS + 1], acceleration[MOST_INNER_STEPS + 1];
    double steer[MOST_INNER_STEPS + 1], held[IN_COUNT - IN_HELD][MOST_INNER_STEPS + 1];
    double rows[MOST_INNER_STEPS + 1][PLANT_OUTPUTS];
    double output[PLANT_OUTPUTS]; ///< where it stands
};

static fmu_model_t models[FMU_INSTANCES];

bool fmu_variable(size_t index, fmu_variable_t *variable)
{
    if (index < IN_COUNT) {
        *variable = (fmu_variable_t){inputs[index].name, inputs[index].unit, FMU_INPUT,
                                     FMU_INPUTS + (uint32_t)index, inputs[index].start};
        return true;
    }
    index -= IN_COUNT;
    if (index < PARAMETER_COUNT) {
        *variable = (fmu_variable_t){parameters[index].name, parameters[index].unit, FMU_PARAMETER,
                                     FMU_PARAMETERS + (uint32_t)index, parameters[index].start};
        return true;
    }
    index -= PARAMETER_COUNT;
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
    for (size_t i = 0; i < IN_COUNT; i++) {
        model->input[i] = inputs[i].start;
    }
    for (size_t i = 0; i < PARAMETER_COUNT; i++) {
        model->parameter[i] = parameters[i].start;
    }
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

/// Writes the parameters over the vehicle's numbers.
static void place_parameters(fmu_model_t *model)
{
    memcpy(model->body, base_body, sizeof model->body);
    memcpy(model->scalars, base_scalars, sizeof model->scalars);
    memcpy(model->axles, base_axles, sizeof model->axles);
    memcpy(model->whole.drive, base_drive, sizeof model->whole.drive);
    double *const rooms[] = {model->body, model->scalars, model->axles, model->whole.drive,
                             model->own};
    for (size_t i = 0; i < PARAMETER_COUNT; i++) {
        double value = model->parameter[i];
        if (parameters[i].is_inverse) {
            value = value > 0.0 ? 1.0 / value : 0.0;
        }
        rooms[parameters[i].room][parameters[i].index] = value;
    }
    double *const drive = model->whole.drive;
    if (!(drive[D_FREE_SPEED] > 0.0)) { // a speed that is prescribed needs no drag
        drive[D_ROLLING_RESISTANCE] = 0.0;
        model->scalars[E_DRAG_AREA_CAR] = model->scalars[E_DRAG_AREA_TRAILER] = 0.0;
    }
    static const int tracks[] = {E_TRACK_CAR_FRONT, E_TRACK_CAR_REAR, E_TRACK_TRAILER,
                                 E_TRACK_TRAILER};
    for (int axle = 0; axle < 4; axle++) {
        model->axles[axle * PLANT_AXLE + A_HALF_TRACK] = 0.5 * model->scalars[tracks[axle]];
    }
}

/// State of straight driving at the speed that is set.
static void start_state(fmu_model_t *model)
{
    double *const state = model->lane.state;
    const double *const drive = model->whole.drive;
    const double speed = model->input[IN_SPEED];
    memset(state, 0, sizeof model->lane.state);
    state[X_SPEED] = speed;
    if (drive[D_FREE_SPEED] > 0.0) {
        const double weight = (model->body[P_CAR_MASS] + model->body[P_TRAILER_MASS]) * GRAVITY;
        const double area = model->scalars[E_DRAG_AREA_CAR] + model->scalars[E_DRAG_AREA_TRAILER];
        state[X_DRIVE] =
            0.5 * AIR_DENSITY * speed * speed * area + drive[D_ROLLING_RESISTANCE] * weight;
    }
}

/// Points the lane to the numbers of the model.
static void connect(fmu_model_t *model)
{
    plant_lane_t *const lane = &model->lane;
    memset(lane, 0, sizeof *lane);
    lane->speed = model->speed;
    lane->acceleration = model->acceleration;
    lane->steer = model->steer;
    lane->body = model->body;
    lane->scalars = model->scalars;
    lane->axles = model->axles;
    lane->whole = &model->whole;
    lane->output = &model->rows[0][0];
    lane->columns = PLANT_OUTPUTS;
    for (int32_t i = 0; i < PLANT_OUTPUTS; i++) {
        lane->column[i] = i;
    }
}

/// Inputs over `count` inner steps of `inner_s`, from the beginning of a step on.
static void lay_inputs(fmu_model_t *model, int count, double inner_s)
{
    const double *const in = model->input;
    const double per_ratio = 1.0 / model->own[OWN_STEERING_RATIO];
    for (int i = 0; i <= count; i++) {
        const double since = (double)i * inner_s;
        model->speed[i] = in[IN_SPEED] + since * in[IN_ACCELERATION];
        model->acceleration[i] = in[IN_ACCELERATION];
        model->steer[i] = (in[IN_STEERING] + since * in[IN_STEERING_RATE]) * per_ratio;
    }
    for (int h = 0; h < IN_COUNT - IN_HELD; h++) {
        const double value = in[IN_HELD + h];
        model->lane.series[held_slot[h]] = value != 0.0 ? model->held[h] : NULL;
        for (int i = 0; i <= count; i++) {
            model->held[h][i] = value;
        }
    }
}

static bool is_within_bounds(const double *row)
{
    return fabs(row[O_TRAILER_YAW_RATE]) < 20.0 && fabs(row[O_LATERAL_VELOCITY]) < 200.0 &&
           fabs(row[O_ARTICULATION]) < 3.2;
}

/// Goes on by `count` inner steps; 0: only what it gives where it stands.
static bool go_on(fmu_model_t *model, int count, double inner_s)
{
    lay_inputs(model, count, inner_s);
    model->lane.first = 0;
    model->lane.stop = count + 1;
    plant_lanes(&model->lane, 1, inner_s, 1);
    memcpy(model->output, model->rows[count], sizeof model->output);
    return model->lane.diverged == 0 && is_within_bounds(model->output);
}

static bool is_speed(double value)
{
    return value >= SLOWEST_M_S && value <= FASTEST_M_S;
}

bool fmu_start(fmu_model_t *model, const char **message)
{
    *message = "";
    for (size_t i = 0; i < PARAMETER_COUNT; i++) {
        if (!(model->parameter[i] >= parameters[i].low)) {
            *message = parameters[i].name;
            return false;
        }
    }
    if (!is_speed(model->input[IN_SPEED])) {
        *message = inputs[IN_SPEED].name;
        return false;
    }
    place_parameters(model);
    connect(model);
    start_state(model);
    model->is_started = go_on(model, 0, LONGEST_INNER_STEP_S);
    return model->is_started;
}

/* --- values ------------------------------------------------------------------------------------
 */

bool fmu_set(fmu_model_t *model, uint32_t reference, double value)
{
    const size_t parameter = (size_t)reference - FMU_PARAMETERS;
    const size_t input = (size_t)reference - FMU_INPUTS;
    if (!(fabs(value) < 1e12)) {
        return false;
    }
    if (reference >= FMU_PARAMETERS && parameter < PARAMETER_COUNT && !model->is_started) {
        model->parameter[parameter] = value;
        return true;
    }
    if (reference >= FMU_INPUTS && input < IN_COUNT) {
        model->input[input] = value;
        return true;
    }
    return false;
}

/// Value of an output; an accelerometer feels the road's bank and sits ahead of its body's COG.
static double output(const fmu_model_t *model, const output_t *of)
{
    const double *const row = model->output;
    if (of->body < 0) {
        return row[of->column];
    }
    const double tilt = of->body == 0 ? 1.0 : cos(row[O_ARTICULATION]);
    return row[of->column] +
           model->own[OWN_POSITION_CAR + of->body] * row[O_CAR_YAW_ACCELERATION + of->body] +
           GRAVITY * sin(row[O_BANK]) * tilt;
}

bool fmu_get(const fmu_model_t *model, uint32_t reference, double *value)
{
    if (reference == 0U) {
        *value = model->time_s;
    } else if (reference >= FMU_OUTPUTS && reference - FMU_OUTPUTS < OUTPUT_COUNT) {
        *value = model->is_started ? output(model, &outputs[reference - FMU_OUTPUTS]) : 0.0;
    } else if (reference >= FMU_PARAMETERS && reference - FMU_PARAMETERS < PARAMETER_COUNT) {
        *value = model->parameter[reference - FMU_PARAMETERS];
    } else if (reference >= FMU_INPUTS && reference - FMU_INPUTS < IN_COUNT) {
        *value = model->input[reference - FMU_INPUTS];
    } else {
        return false;
    }
    return true;
}

/// Inner steps of a step: relaxing tyres need short ones at speed.
static double inner_steps(const fmu_model_t *model, double step_s)
{
    double longest = LONGEST_INNER_STEP_S;
    for (int axle = 0; axle < 4; axle++) {
        const double length = model->axles[axle * PLANT_AXLE + A_RELAXATION];
        if (length > 0.0) {
            longest = fmin(longest,
                           1.5 * fmax(length, SHORTEST_RELAXATION_M) / model->lane.state[X_SPEED]);
        }
    }
    return fmax(1.0, ceil(step_s / longest - 1e-9));
}

bool fmu_step(fmu_model_t *model, double time_s, double step_s)
{
    const double end_m_s = model->input[IN_SPEED] + step_s * model->input[IN_ACCELERATION];
    if (!model->is_started || model->is_lost || !(step_s > 0.0) ||
        !(step_s <= LONGEST_STEP_S * 1.001) || !is_speed(model->input[IN_SPEED]) ||
        !is_speed(end_m_s)) {
        return false;
    }
    const double inner = inner_steps(model, step_s);
    if (!(inner <= MOST_INNER_STEPS)) {
        return false;
    }
    model->is_lost = !go_on(model, (int)inner, step_s / inner);
    model->time_s = time_s + step_s;
    return !model->is_lost;
}

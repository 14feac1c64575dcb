/// fmu_model: what both versions of FMI call of a model: the core (fmu_core.c), the plant
/// (fmu_plant.c).
///
/// Every variable is a number in SI units with one reference: the time, inputs, parameters,
/// outputs. A step takes the inputs as they are at its beginning. No heap: instances come from a
/// fixed number of them.
#ifndef FMU_MODEL_H
#define FMU_MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FMU_INSTANCES 4U
/// First reference of each kind; the time is 0.
#define FMU_INPUTS 1U
#define FMU_PARAMETERS 100U
#define FMU_OUTPUTS 200U

typedef struct fmu_model fmu_model_t;

typedef enum { FMU_INPUT, FMU_PARAMETER, FMU_OUTPUT } fmu_kind_t;

typedef struct {
    const char *name;
    const char *unit;
    fmu_kind_t kind;
    uint32_t reference;
    double start;
} fmu_variable_t;

/// Variable `index` from 0 on; false behind the last one.
bool fmu_variable(size_t index, fmu_variable_t *variable);

/// A new instance, NULL: all are in use.
fmu_model_t *fmu_new(void);
void fmu_free(fmu_model_t *model);
/// As after fmu_new().
void fmu_reset(fmu_model_t *model);
/// Ends the initialisation; false: the parameters are refused, `*message` says which.
bool fmu_start(fmu_model_t *model, const char **message);
/// False: no such variable, or not to be set (parameters once it has started).
bool fmu_set(fmu_model_t *model, uint32_t reference, double value);
bool fmu_get(const fmu_model_t *model, uint32_t reference, double *value);
/// One step from `time_s` on; false: not started, a length out of range, time runs back, or the
/// motion has left all bounds.
bool fmu_step(fmu_model_t *model, double time_s, double step_s);

#endif

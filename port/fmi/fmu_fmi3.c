/* FMI 3.0, co-simulation. What is not here, a stub answers that make_fmu.py makes from the header.
 */
#include <string.h>

#include "fmi3Functions.h"
#include "fmu_model.h"

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)path, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)environment, (void)log, (void)update;
    return strcmp(token, FMU_TOKEN) == 0 ? fmu_new() : NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    if (c != NULL) {
        fmu_free(c);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)c, (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return start >= 0.0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    const char *message;
    return fmu_start(c, &message) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    fmu_reset(c);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          fmi3Float64 value[], size_t values)
{
    for (size_t i = 0; i < n; i++) {
        if (values != n || !fmu_get(c, vr[i], &value[i])) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          const fmi3Float64 value[], size_t values)
{
    for (size_t i = 0; i < n; i++) {
        if (values != n || !fmu_set(c, vr[i], value[i])) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set_state,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *last)
{
    (void)no_set_state;
    *event = false;
    *terminate = false;
    *early = false;
    *last = time + step;
    return fmu_step(c, time, step) ? fmi3OK : fmi3Error;
}

/* Prints the variables of the FMU for make_fmu.py: kind, reference, name, unit or -, start. */
#include <stdio.h>

#include "fmu_model.h"

int main(void)
{
    static const char *const kinds[] = {"input", "parameter", "output"};
    fmu_variable_t v;
    for (size_t i = 0; fmu_variable(i, &v); i++) {
        printf("%s %u %s %s %.17g\n", kinds[v.kind], (unsigned)v.reference, v.name,
               v.unit[0] == '\0' ? "-" : v.unit, v.start);
    }
    return 0;
}

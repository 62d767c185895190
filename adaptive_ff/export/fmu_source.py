"""The functions of FMI 2.0 for co-simulation around an exported controller."""

import math

from adaptive_ff.export.export import Export
from adaptive_ff.export.sample import optional_inputs
from controllers.kernels.names import c_name

FUNCTIONS = """/* FMI 2.0 for co-simulation around {prefix}.h.
 *
 * A communication step is a sampling period: doStep(t, h) takes the inputs of the time t, and gives the torque that the
 * drive is to apply from then on. dt of a sample is the length of the communication step before it.
 */
#include "{prefix}.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum {{ fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending }} fmi2Status;
typedef enum {{ fmi2ModelExchange, fmi2CoSimulation }} fmi2Type;
typedef int fmi2StatusKind;

#define GUID "{guid}"
#define REALS {reals}
#define BOOLEANS {booleans}
#define KNOWABLE {knowable}

typedef struct {{
    {prefix}_Controller controller;
    {prefix}_Inputs inputs; /* as they were set, known or not */
    {prefix}_Output output;
{regressor_field}{estimate_field}    bool known[KNOWABLE + 1];
{switch_fields}    double last_step; /* length of the last communication step, s; 0 before the first */
}} Instance;

static void start(Instance *instance)
{{
    memset(instance, 0, sizeof *instance);
    {prefix}_init(&instance->controller);
{switch_starts}{refresh}}}

static fmi2Status set_real(Instance *instance, fmi2ValueReference reference, fmi2Real value)
{{
    switch (reference) {{
{real_setters}
    default:
        return fmi2Error;
    }}
}}

static fmi2Status get_real(const Instance *instance, fmi2ValueReference reference, fmi2Real *value)
{{
    switch (reference) {{
{real_getters}
    default:
        return fmi2Error;
    }}
}}

static fmi2Status set_boolean(Instance *instance, fmi2ValueReference reference, bool value)
{{
    if (reference < KNOWABLE) {{
        instance->known[reference] = value;
        return fmi2OK;
    }}
    switch (reference) {{
{boolean_setters}
    default:
        return fmi2Error;
    }}
}}

static fmi2Status get_boolean(const Instance *instance, fmi2ValueReference reference, fmi2Boolean *value)
{{
    if (reference < KNOWABLE) {{
        *value = instance->known[reference];
        return fmi2OK;
    }}
    switch (reference) {{
{boolean_getters}
    default:
        return fmi2Error;
    }}
}}

EXPORTED const char *fmi2GetTypesPlatform(void)
{{
    return "default";
}}

EXPORTED const char *fmi2GetVersion(void)
{{
    return "2.0";
}}

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String names[])
{{
    (void)c, (void)on, (void)count, (void)names;
    return fmi2OK;
}}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
    const void *functions, fmi2Boolean visible, fmi2Boolean logging)
{{
    (void)name, (void)location, (void)functions, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, GUID) != 0) {{
        return NULL;
    }}
    Instance *instance = malloc(sizeof *instance);
    if (instance != NULL) {{
        start(instance);
    }}
    return instance;
}}

EXPORTED void fmi2FreeInstance(fmi2Component c)
{{
    free(c);
}}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
    fmi2Real start_time, fmi2Boolean has_stop, fmi2Real stop_time)
{{
    (void)c, (void)has_tolerance, (void)tolerance, (void)start_time, (void)has_stop, (void)stop_time;
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{{
    (void)c;
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{{
    (void)c;
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c)
{{
    (void)c;
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2Reset(fmi2Component c)
{{
    start(c);
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
    fmi2Real values[])
{{
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < count && status == fmi2OK; i++) {{
        status = get_real(c, references[i], &values[i]);
    }}
    return status;
}}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
    const fmi2Real values[])
{{
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < count && status == fmi2OK; i++) {{
        status = set_real(c, references[i], values[i]);
    }}
    return status;
}}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
    fmi2Boolean values[])
{{
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < count && status == fmi2OK; i++) {{
        status = get_boolean(c, references[i], &values[i]);
    }}
    return status;
}}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
    const fmi2Boolean values[])
{{
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < count && status == fmi2OK; i++) {{
        status = set_boolean(c, references[i], values[i] != 0);
    }}
    return status;
}}

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean no_return)
{{
    Instance *instance = c;
    {prefix}_Inputs inputs = instance->inputs;
    (void)time, (void)no_return;
{unknown}    inputs.dt = ({real})(instance->last_step > 0.0 ? instance->last_step : length);
{regressors}    if (!(length > 0.0)
        || {prefix}_step(&instance->controller, &inputs, &instance->output) != {upper}_OK) {{
        return fmi2Discard; /* an input is not finite */
    }}
    instance->last_step = length;
{refresh}    return fmi2OK;
}}

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{{
    if (*state == NULL) {{
        *state = malloc(sizeof(Instance));
    }}
    if (*state == NULL) {{
        return fmi2Error;
    }}
    memcpy(*state, c, sizeof(Instance));
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{{
    memcpy(c, state, sizeof(Instance));
    return fmi2OK;
}}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}}

/* What this FMU has none of. */
#define NONE(name, arguments) EXPORTED fmi2Status name arguments
NONE(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]))
{{
    (void)c, (void)r, (void)v;
    return n == 0 ? fmi2OK : fmi2Error;
}}
NONE(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]))
{{
    (void)c, (void)r, (void)v;
    return n == 0 ? fmi2OK : fmi2Error;
}}
NONE(fmi2GetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]))
{{
    (void)c, (void)r, (void)v;
    return n == 0 ? fmi2OK : fmi2Error;
}}
NONE(fmi2SetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]))
{{
    (void)c, (void)r, (void)v;
    return n == 0 ? fmi2OK : fmi2Error;
}}
NONE(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate s, size_t *n))
{{
    (void)c, (void)s, (void)n;
    return fmi2Error;
}}
NONE(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n))
{{
    (void)c, (void)s, (void)b, (void)n;
    return fmi2Error;
}}
NONE(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s))
{{
    (void)c, (void)b, (void)n, (void)s;
    return fmi2Error;
}}
NONE(fmi2GetDirectionalDerivative, (fmi2Component c, const fmi2ValueReference u[], size_t nu,
    const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[]))
{{
    (void)c, (void)u, (void)nu, (void)k, (void)nk, (void)dk, (void)du;
    return fmi2Error;
}}
NONE(fmi2SetRealInputDerivatives, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
    const fmi2Real v[]))
{{
    (void)c, (void)r, (void)n, (void)o, (void)v;
    return fmi2Error;
}}
NONE(fmi2GetRealOutputDerivatives, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
    fmi2Real v[]))
{{
    (void)c, (void)r, (void)n, (void)o, (void)v;
    return fmi2Error;
}}
NONE(fmi2CancelStep, (fmi2Component c))
{{
    (void)c;
    return fmi2Error;
}}
NONE(fmi2GetStatus, (fmi2Component c, fmi2StatusKind s, fmi2Status *v))
{{
    (void)c, (void)s, (void)v;
    return fmi2Discard;
}}
NONE(fmi2GetRealStatus, (fmi2Component c, fmi2StatusKind s, fmi2Real *v))
{{
    (void)c, (void)s, (void)v;
    return fmi2Discard;
}}
NONE(fmi2GetIntegerStatus, (fmi2Component c, fmi2StatusKind s, fmi2Integer *v))
{{
    (void)c, (void)s, (void)v;
    return fmi2Discard;
}}
NONE(fmi2GetBooleanStatus, (fmi2Component c, fmi2StatusKind s, fmi2Boolean *v))
{{
    (void)c, (void)s, (void)v;
    return fmi2Discard;
}}
NONE(fmi2GetStringStatus, (fmi2Component c, fmi2StatusKind s, fmi2String *v))
{{
    (void)c, (void)s, (void)v;
    return fmi2Discard;
}}
"""


TAKING_REGRESSORS = """    if ({prefix}_set_regressors(&instance->controller, instance->regressors) != {upper}_OK) {{
        return fmi2Discard; /* a regressor is far too large */
    }}
"""


def regressor_count(export: Export) -> int:
    """Return how many further known regressors the controller takes."""
    return 0 if export.regressors is None else export.regressors.count


def fmu_source(export: Export, guid: str) -> str:
    """Return the source around the header, with the value references of ``fmu_variables``."""
    prefix, upper, regressors = export.prefix, export.upper, regressor_count(export)
    inputs = [c_name(name) for name in export.input_names if name != "dt"]
    outputs = [c_name(name) for name, _ in export.output.fields]
    estimates = range(len(export.controller.estimate_names))
    knowable = optional_inputs()
    real, unknown = export.precision.real, export.precision.literal(math.nan)
    taken = [f"instance->inputs.{name}" for name in inputs] + [f"instance->regressors[{i}]" for i in range(regressors)]
    getters = taken + [f"instance->output.{name}" for name in outputs]
    getters += [f"instance->estimates[{place}]" for place in estimates]
    setters = [f"{place} = ({real})value;" for place in taken]
    switches = export.switches
    return FUNCTIONS.format(
        prefix=prefix,
        upper=upper,
        guid=guid,
        real=real,
        reals=len(getters),
        booleans=len(knowable) + len(switches),
        knowable=len(knowable),
        regressor_field=f"    {real} regressors[{upper}_REGRESSORS];\n" if regressors else "",
        regressors=TAKING_REGRESSORS.format(prefix=prefix, upper=upper) if regressors else "",
        estimate_field=f"    {real} estimates[{upper}_ESTIMATES];\n" if estimates else "",
        switch_fields="".join(f"    bool {switch.name};\n" for switch in switches),
        switch_starts="".join(
            f"    instance->{switch.name} = instance->controller.state.{switch.leaves[0].member};\n"
            for switch in switches
        ),
        refresh=f"    {prefix}_estimates(&instance->controller, instance->estimates);\n" if estimates else "",
        unknown="".join(
            f"    inputs.{c_name(name)} = instance->known[{place}] ? inputs.{c_name(name)} : {unknown};\n"
            for place, name in enumerate(knowable)
        ),
        real_setters=_cases(setters, ["return fmi2OK;"]),
        real_getters=_cases([f"*value = (fmi2Real){text};" for text in getters], ["return fmi2OK;"]),
        boolean_setters=_cases(
            [
                f"instance->{switch.name} = value;\n        {prefix}_set_{switch.name}(&instance->controller, value);"
                for switch in switches
            ],
            ["return fmi2OK;"],
            len(knowable),
        ),
        boolean_getters=_cases(
            [f"*value = instance->{switch.name};" for switch in switches], ["return fmi2OK;"], len(knowable)
        ),
    )


def _cases(actions: list[str], ending: list[str], first: int = 0) -> str:
    lines = []
    for place, action in enumerate(actions, start=first):
        lines += [f"    case {place}:", f"        {action}", *(f"        {line}" for line in ending)]
    return "\n".join(lines)

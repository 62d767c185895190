"""The functions of FMI 2.0 for co-simulation around an exported controller."""

import math

from adaptive_ff.export.export import Export
from adaptive_ff.export.rendering import rendered
from adaptive_ff.export.sample import optional_inputs
from controllers.kernels.names import c_name


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
    return rendered(
        "fmi2.c",
        prefix=prefix,
        upper=upper,
        guid=guid,
        real=real,
        reals=len(getters),
        booleans=len(knowable) + len(switches),
        knowable=len(knowable),
        regressor_field=f"    {real} regressors[{upper}_REGRESSORS];\n" if regressors else "",
        regressors=rendered("fmi2_regressors.c", prefix=prefix, upper=upper) if regressors else "",
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

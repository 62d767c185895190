"""The functions of FMI for co-simulation around an exported controller."""

import math

from adaptive_ff.export.export import Export
from adaptive_ff.export.rendering import rendered
from adaptive_ff.export.sample import optional_inputs
from controllers.kernels.names import c_name


def regressor_count(export: Export) -> int:
    """Return how many further known regressors the controller takes."""
    return 0 if export.regressors is None else export.regressors.count


def fmu_source(export: Export, version: str, token: str) -> str:
    """Return the source around the header, with the value references of ``fmu_variables``."""
    regressors, estimates = regressor_count(export), len(export.controller.estimate_names)
    setters = [f"instance->inputs.{c_name(name)}" for name in export.input_names if name != "dt"]
    setters += [f"instance->regressors[{place}]" for place in range(regressors)]
    getters = [*setters, *(f"instance->output.{c_name(name)}" for name, _ in export.output.fields)]
    getters += [f"instance->estimates[{place}]" for place in range(estimates)]
    return rendered(
        f"fmi{version[0]}.c",
        prefix=export.prefix,
        upper=export.upper,
        token=token,
        real=export.precision.real,
        unknown=export.precision.literal(math.nan),
        setters=setters,
        getters=getters,
        knowable=[c_name(name) for name in optional_inputs()],
        switches=export.switches,
        regressors=regressors,
        estimates=estimates,
    )

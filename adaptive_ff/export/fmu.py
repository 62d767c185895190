"""An FMU 2.0 or 3.0 for co-simulation: the exported source, what importing tools need to know of it, and a binary."""

import hashlib
import io
import platform
import zipfile
from dataclasses import dataclass

from adaptive_ff.export.errors import compiled
from adaptive_ff.export.export import Export
from adaptive_ff.export.sample import optional_inputs
from adaptive_ff.export.source import estimate_unit, header, rendered, source
from controllers import Inputs, Output
from controllers.kernels.compiler import compiler
from controllers.kernels.memory import value_at
from controllers.kernels.text import c_name, described, plain, unit

PLATFORMS = {
    ("Linux", "x86_64"): {"2.0": "linux64", "3.0": "x86_64-linux"},
    ("Linux", "aarch64"): {"3.0": "aarch64-linux"},
    ("Darwin", "x86_64"): {"2.0": "darwin64", "3.0": "x86_64-darwin"},
    ("Darwin", "arm64"): {"3.0": "aarch64-darwin"},
}
"""Folder of binaries in each version of FMI, by system and processor."""

VERSIONS = ("2.0", "3.0")
"""Versions of FMI."""

UNITS = {
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "s": {"s": 1},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "N m s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "kg m^2": {"kg": 1, "m": 2},
}
"""Exponents of the base units of each unit that variables have."""


@dataclass(frozen=True)
class Variable:
    """A variable of the model description."""

    name: str
    kind: str
    reference: int
    causality: str
    description: str
    unit: str = ""
    start: str = ""


def fmu_variables(export: Export) -> list[Variable]:
    """Return the variables in their order; value references count them from zero."""
    texts = dict(described(Inputs))
    units = {name: unit(text) for name, text in texts.items()}
    for name in optional_inputs():  # else one who connects it alone would not learn that it is not used
        texts[name] = f"Used only while {name}_known is true. {texts[name]}"
    found = [(name, "Real", "input", texts[name], units[name], "0") for name in export.input_names if name != "dt"]
    for place in range(export.regressor_count):
        found.append((f"regressors[{place}]", "Real", "input", "Further known regressor.", "", "0"))
    for name, text in described(Output).items():
        found.append((f"{name}{'_out' * (name in export.input_names)}", "Real", "output", text, unit(text), ""))
    for name in export.controller.estimate_names:
        found.append((f"estimates.{name}", "Real", "output", "Physical estimate.", estimate_unit(name), ""))
    for name in optional_inputs():
        found.append((f"{name}_known", "Boolean", "input", f"Whether {name} is known.", "", "false"))
    for switch in export.switches:
        state = value_at(export.controller.state, switch.leaves[0].path)
        found.append((switch.name, "Boolean", "input", switch.doc, "", "true" if state else "false"))
    return [
        Variable(name, kind, place, causality, plain(text), in_unit if in_unit in UNITS else "", start)
        for place, (name, kind, causality, text, in_unit, start) in enumerate(found)
    ]


def model_description(export: Export, version: str, token: str) -> str:
    """Return the model description."""
    variables = fmu_variables(export)
    return rendered(
        f"modelDescription{version[0]}.xml",
        export,
        token=token,
        period=repr(export.controller.period),
        units=[item for item in UNITS.items() if any(variable.unit == item[0] for variable in variables)],
        variables=variables,
    )


def fmu_source(export: Export, version: str, token: str) -> str:
    """Return the source around the header, with the value references of ``fmu_variables``."""
    setters = [f"instance->inputs.{c_name(name)}" for name in export.input_names if name != "dt"]
    setters += [f"instance->regressors[{place}]" for place in range(export.regressor_count)]
    getters = [*setters, *(f"instance->output.{c_name(name)}" for name, _ in export.output.fields)]
    getters += [f"instance->estimates[{place}]" for place in range(len(export.controller.estimate_names))]
    return rendered(f"fmi{version[0]}.c", export, token=token, setters=setters, getters=getters)


def fmu(export: Export, version: str) -> bytes:
    """Return the FMU: with a binary where there is a C compiler and this version of FMI has a name for this machine."""
    prefix = export.prefix
    sources = {f"{prefix}.h": header(export), f"{prefix}.c": source(export)}
    digest = hashlib.sha256("".join(sources.values()).encode()).hexdigest()
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    sources[f"{prefix}_fmu.c"] = fmu_source(export, version, token)
    files = {"modelDescription.xml": model_description(export, version, token).encode()}
    files |= {f"sources/{name}": text.encode("ascii") for name, text in sources.items()}
    if version != "2.0":
        files["sources/buildDescription.xml"] = rendered("buildDescription.xml", export).encode()
    system = platform.system()
    place = PLATFORMS.get((system, platform.machine()), {}).get(version)
    if place is not None and compiler() is not None:
        with compiled(sources) as library:
            files[f"binaries/{place}/{prefix}{'.dylib' if system == 'Darwin' else '.so'}"] = library.read_bytes()
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # no date: same bytes each time
    return archive.getvalue()

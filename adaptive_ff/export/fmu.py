"""An FMU 2.0 for co-simulation: the exported source, what importing tools need to know of it, and a binary."""

import hashlib
import io
import platform
import tempfile
import zipfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from xml.sax.saxutils import quoteattr

from adaptive_ff.export.errors import compile_export
from adaptive_ff.export.export import Export
from adaptive_ff.export.fmu_source import fmu_source, regressor_count
from adaptive_ff.export.header import header
from adaptive_ff.export.leaves import value_at
from adaptive_ff.export.sample import optional_inputs
from adaptive_ff.export.source import source
from adaptive_ff.export.units import estimate_unit, field_units
from controllers import Inputs, Output
from controllers.kernels.comments import plain, section
from controllers.kernels.compiler import compiler

PLATFORMS = {("Linux", "x86_64"): ("linux64", ".so"), ("Darwin", "x86_64"): ("darwin64", ".dylib")}
"""Folder and ending of binaries that FMI 2.0 names, by system and processor."""

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

    def xml(self) -> str:
        """Return its element."""
        attributes = f"name={quoteattr(self.name)} valueReference={quoteattr(str(self.reference))}"
        attributes += f" description={quoteattr(self.description)} causality={quoteattr(self.causality)}"
        attributes += ' variability="discrete"' + (' initial="calculated"' if self.causality == "output" else "")
        inner = (f" unit={quoteattr(self.unit)}" if self.unit in UNITS else "") + (
            f" start={quoteattr(self.start)}" if self.start else ""
        )
        return f"    <ScalarVariable {attributes}>\n      <{self.kind}{inner}/>\n    </ScalarVariable>"


def fmu_variables(export: Export) -> list[Variable]:
    """Return the variables in their order; value references count those of each kind from zero."""
    units, described = field_units(Inputs), section(Inputs, "Attributes")
    for name in optional_inputs():  # else one who connects it alone would not learn that it is not used
        described[name] = f"Used only while {name}_known is true. {described[name]}"
    reals = [(name, "input", described[name], units[name], "0") for name in export.input_names if name != "dt"]
    reals += [
        (f"regressors[{i}]", "input", "Further known regressor.", "", "0") for i in range(regressor_count(export))
    ]
    output_units, outputs = field_units(Output), section(Output, "Attributes")
    reals += [
        (name if name not in export.input_names else f"{name}_out", "output", outputs[name], output_units[name], "")
        for name, _ in export.output.fields
    ]
    reals += [
        (f"estimates.{name}", "output", "Physical estimate.", estimate_unit(name), "")
        for name in export.controller.estimate_names
    ]
    flags = [(f"{name}_known", f"Whether {name} is known.", "false") for name in optional_inputs()]
    for switch in export.switches:
        state = value_at(export.controller.state, switch.leaves[0].path)
        flags.append((switch.name, switch.doc, "true" if state else "false"))
    found = [
        Variable(name, "Real", place, causality, plain(text), unit, start)
        for place, (name, causality, text, unit, start) in enumerate(reals)
    ]
    found += [
        Variable(name, "Boolean", place, "input", plain(text), "", start)
        for place, (name, text, start) in enumerate(flags)
    ]
    return found


def model_description(export: Export, guid: str) -> str:
    """Return the model description."""
    variables = fmu_variables(export)
    prefix, period = export.prefix, export.controller.period
    units = [
        f"    <Unit name={quoteattr(unit)}><BaseUnit "
        + " ".join(f'{base}="{exponent}"' for base, exponent in bases.items())
        + "/></Unit>"
        for unit, bases in UNITS.items()
        if any(variable.unit == unit for variable in variables)
    ]
    unknowns = [
        f'      <Unknown index="{place}"/>'
        for place, variable in enumerate(variables, start=1)
        if variable.causality == "output"
    ]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="2.0" modelName={quoteattr(prefix)} guid={quoteattr(guid)}',
            f"  description={quoteattr(plain(export.title))}",
            f'  generationTool="adaptive-ff {version("adaptive-ff")}" variableNamingConvention="structured">',
            f'  <CoSimulation modelIdentifier={quoteattr(prefix)} canHandleVariableCommunicationStepSize="true"',
            '    canGetAndSetFMUstate="true">',
            f'    <SourceFiles><File name="{prefix}.c"/><File name="{prefix}_fmu.c"/></SourceFiles>',
            "  </CoSimulation>",
            "  <UnitDefinitions>",
            *units,
            "  </UnitDefinitions>",
            f'  <DefaultExperiment startTime="0" stepSize="{period!r}"/>',
            "  <ModelVariables>",
            *(variable.xml() for variable in variables),
            "  </ModelVariables>",
            "  <ModelStructure>",
            "    <Outputs>",
            *unknowns,
            "    </Outputs>",
            "    <InitialUnknowns>",
            *unknowns,
            "    </InitialUnknowns>",
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def fmu(export: Export) -> bytes:
    """Return the FMU: with a binary where there is a C compiler and FMI 2.0 has a name for this machine.

    Raises
    ------
    InputError
        The compiler fails.
    """
    prefix = export.prefix
    sources = {f"{prefix}.h": header(export), f"{prefix}.c": source(export)}
    digest = hashlib.sha256("".join(sources.values()).encode()).hexdigest()
    guid = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    sources[f"{prefix}_fmu.c"] = fmu_source(export, guid)
    files = {"modelDescription.xml": model_description(export, guid).encode()}
    files |= {f"sources/{name}": text.encode("ascii") for name, text in sources.items()}
    place = PLATFORMS.get((platform.system(), platform.machine()))
    if place is not None and compiler() is not None:
        files[f"binaries/{place[0]}/{prefix}{place[1]}"] = _binary(prefix, sources)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # no date: same bytes each time
    return archive.getvalue()


def _binary(prefix: str, sources: dict[str, str]) -> bytes:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="ascii")
        library = Path(folder) / "library"
        compile_export([Path(folder) / f"{prefix}.c", Path(folder) / f"{prefix}_fmu.c"], library)
        return library.read_bytes()

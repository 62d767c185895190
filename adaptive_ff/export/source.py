"""Header and source of an exported controller: translated kernels and settings in their templates."""

import importlib
import math
from importlib.metadata import version
from typing import Any

from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR
from adaptive_ff.export.buffer import HEADER, MAGIC, VERSION
from adaptive_ff.export.export import Export
from adaptive_ff.export.rendering import rendered
from adaptive_ff.export.sample import optional_inputs, unchecked_inputs
from adaptive_ff.export.tables import arrays_of, arrays_struct, has_own_start, state_tables
from adaptive_ff.friction.model import unit_of
from controllers.kernels.comments import comment_lines, joined, plain, summary
from controllers.kernels.helpers import helper_texts
from controllers.kernels.names import c_name
from controllers.kernels.types import Record, passed_by_pointer


def header(export: Export) -> str:
    """Return the header."""
    cls = type(export.controller).__name__
    introduction = rendered(
        "header_comment.txt", title=export.title, version=version("adaptive-ff"), cls=cls, prefix=export.prefix
    )
    return rendered(
        "controller.h",
        **_common(export),
        introduction=introduction,
        state_size=HEADER.size + export.payload_size,
        state_arrays=arrays_struct(export, f"{export.prefix}_StateArrays", "Arrays of the state.", export.state_leaves),
    )


def source(export: Export) -> str:
    """Return the source."""
    result = export.step.result
    assert isinstance(result, Record)
    output, new_state = (name for name, _ in result.fields)

    def passed(state: str) -> str:
        """Return parameters and state of a controller as arguments of a kernel."""
        given = {"PARAMETERS": export.parameters, state: export.state}
        return ", ".join(f"{'&' if passed_by_pointer(kind) else ''}{name}" for name, kind in given.items())

    return rendered(
        "controller.c",
        **_common(export),
        kernels=_translated(export),
        passed=passed,
        result=export.unit.c_type(result),
        given="inputs" if passed_by_pointer(export.inputs) else "*inputs",
        output=output,
        new_state=new_state,
        start="START" if has_own_start(export) else "NEW",
        header=HEADER.size,
        version=VERSION,
        magic=int.from_bytes(MAGIC, "little"),
        bits="uint32_t" if export.single else "uint64_t",
    )


def _common(export: Export) -> dict[str, Any]:
    """Return what both templates are given."""
    unchecked = unchecked_inputs()
    return {
        "export": export,
        "p": export.prefix,
        "P": export.upper,
        "title": plain(export.title),
        "real": export.precision.real,
        "state": export.unit.c_type(export.state),
        "arrays": arrays_of(export.state_leaves),
        "optional": optional_inputs(),
        "finite": [name for name in export.input_names if name not in unchecked],
        "estimates": [(name, estimate_unit(name)) for name in export.controller.estimate_names],
        "largest": LARGEST_REGRESSOR,
        "nan": math.nan,
        "literal": export.precision.literal,
        "comment": comment_lines,
        "c_name": c_name,
    }


def estimate_unit(name: str) -> str:
    """Return the unit of a physical estimate by its name, which may end in a direction; empty where it is not known."""
    return plain(unit_of(name.removesuffix("_positive").removesuffix("_negative")))


def _translated(export: Export) -> str:
    """Return constants, structs, helpers and kernels, and the settings."""
    kernels = _kernels(export)  # first: it says which constants and helpers there are
    return joined(
        [
            export.unit.definitions(),
            *(struct.text for struct in list(export.unit.structs.values())[len(export.public_structs) :]),
            *helper_texts(export.unit.helpers, export.precision.real),
            kernels,
            state_tables(export),
        ]
    )


def _kernels(export: Export) -> str:
    parts, last, written = [], "", set()
    called = [function.name for function in (export.step, export.write_estimates) if function is not None]
    for function in export.unit.called_in(" ".join(f"{name}()" for name in called)):
        kernel = function.kernel
        if kernel.path != last:
            last = kernel.path
            module = importlib.import_module(kernel.function.__module__)
            text = f"---- {kernel.path}" if last in written else f"---- {kernel.path}\n\n{summary(module)}"
            written.add(last)
            parts.append(comment_lines(text))
        parts.append(function.text)
    return joined(parts)

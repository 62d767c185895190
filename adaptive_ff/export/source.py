"""Header and source of an exported controller: translated kernels, settings and start state in their templates.

These are ``templates/*.jinja``, in which the files can be read as they are.
"""

import importlib
import math
from importlib.metadata import version
from textwrap import wrap
from typing import Any

import numpy as np

from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR
from adaptive_ff.export.buffer import HEADER, MAGIC, VERSION
from adaptive_ff.export.export import Export
from adaptive_ff.export.sample import optional_inputs, unchecked_inputs
from adaptive_ff.files import template
from adaptive_ff.friction.model import unit_of
from controllers.kernels.memory import Leaf, value_at
from controllers.kernels.text import c_name, comment_lines, joined, plain, summary
from controllers.kernels.types import Array, Line, Record, Type, passed_by_pointer

WIDTH = 101
"""Longest initialiser on one line."""


def rendered(name: str, export: Export, **values: Any) -> str:
    """Return a file of an export by the name of its template, with what all may use and the values of this one."""
    unchecked, cls = unchecked_inputs(), type(export.controller)
    common = {
        "export": export,
        "p": export.prefix,
        "P": export.prefix.upper(),
        "real": export.precision.real,
        "title": plain((cls.__doc__ or cls.__name__).strip().partition("\n")[0]),
        "cls": cls.__name__,
        "version": version("adaptive-ff"),
        "state": export.unit.c_type(export.state),
        "arrays": export.state_arrays,
        "optional": optional_inputs(),
        "finite": [name for name in export.input_names if name not in unchecked],
        "estimates": [(name, estimate_unit(name)) for name in export.controller.estimate_names],
        "largest": LARGEST_REGRESSOR,
        "nan": math.nan,
        "literal": export.precision.literal,
        "comment": comment_lines,
        "c_name": c_name,
    }
    return template("adaptive_ff.export", name).render(common | values)


def header(export: Export) -> str:
    """Return the header."""
    return rendered(
        "controller.h",
        export,
        state_size=HEADER.size + export.payload_size,
        state_arrays=arrays_struct(export, f"{export.prefix}_StateArrays", "Arrays of the state.", export.state_arrays),
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
        export,
        kernels=_translated(export),
        passed=passed,
        result=export.unit.c_type(result),
        given="inputs" if passed_by_pointer(export.inputs) else "*inputs",
        output=output,
        new_state=new_state,
        start="START" if export.has_own_start else "NEW",
        header=HEADER.size,
        format_version=VERSION,
        magic=int.from_bytes(MAGIC, "little"),
        bits="uint32_t" if export.single else "uint64_t",
    )


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
            *export.unit.helper_texts(),
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


def record_table(export: Export, name: str, kind: Record, value: Any, arrays: str = "") -> str:
    """Return a constant struct with all numbers in it; its arrays are those of a constant, or bound later."""
    text = _initialiser(export, kind, value, 0, (), arrays)
    return f"static const {export.unit.c_type(kind)} {name} = {text};\n"


def _initialiser(export: Export, kind: Type, value: Any, depth: int, path: tuple[str | int, ...], arrays: str) -> str:
    if isinstance(kind, Record):
        inner = "    " * (depth + 1)
        items = {
            c_name(name): _initialiser(export, field, getattr(value, name), depth + 1, (*path, name), arrays)
            for name, field in kind.fields
        }
        lines = [f"{inner}.{name} = {item}," for name, item in items.items() if item]
        return "{0}" if not lines else "{\n" + "\n".join(lines) + "\n" + "    " * depth + "}"
    if isinstance(kind, Line):
        listed = [_initialiser(export, kind.element, item, depth + 1, path, arrays) for item in value]
        return "{.at = {" + ", ".join(listed) + "}}"
    if isinstance(kind, Array):
        place = f"{arrays}.{Leaf(path, kind.element, value.shape, True).storage}"
        return f"({export.unit.declaration(kind, '').strip()}){place}" if arrays and value.size else ""
    return export.precision.literal(value, ".".join(map(str, path)))


def arrays_struct(export: Export, name: str, doc: str, arrays: list[Leaf]) -> str:
    """Return the struct of arrays; nothing where there is none."""
    lines = [
        f"    {export.unit.c_type(leaf.kind)} {leaf.storage}{''.join(f'[{extent}]' for extent in leaf.shape)};"
        for leaf in arrays
    ]
    return f"/* {doc} */\ntypedef struct {{\n" + "\n".join(lines) + f"\n}} {name};\n" if lines else ""


def array_table(export: Export, struct: str, name: str, arrays: list[Leaf], value: Any) -> str:
    """Return a constant struct with the numbers of arrays."""
    lines = [
        f"    .{leaf.storage} = {_numbers(export, np.asarray(value_at(value, leaf.path)), leaf.storage, 1)},"
        for leaf in arrays
    ]
    return f"static const {struct} {name} = {{\n" + "\n".join(lines) + "\n};\n"


def _numbers(export: Export, array: Any, where: str, depth: int) -> str:
    if array.ndim > 1:
        inner = "    " * (depth + 1)
        rows = [f"{inner}{_numbers(export, row, where, depth + 1)}," for row in array]
        return "{\n" + "\n".join(rows) + "\n" + "    " * depth + "}"
    items = ", ".join(export.precision.literal(item, where) for item in array.tolist())
    lines = wrap(f"{items},", WIDTH, break_long_words=False, break_on_hyphens=False)
    return "{" + ("\n" + "    " * (depth + 1)).join(lines).removesuffix(",") + "}"


def state_tables(export: Export) -> str:
    """Return settings and states as constants; the state to start in only where it is not that of a new controller."""
    parts, parameters = [], export.controller.parameters
    if arrays := export.parameter_arrays:
        parts.append(arrays_struct(export, "ParameterArrays", "Arrays of the parameters.", arrays))
        parts.append(array_table(export, "ParameterArrays", "PARAMETER_ARRAYS", arrays, parameters))
    parts.append(record_table(export, "PARAMETERS", export.parameters, parameters, "PARAMETER_ARRAYS"))
    for name, one in {"NEW": export.fresh, **({"START": export.controller} if export.has_own_start else {})}.items():
        parts.append(record_table(export, f"{name}_STATE", export.state, one.state))
        if export.state_arrays:
            struct = f"{export.prefix}_StateArrays"
            parts.append(array_table(export, struct, f"{name}_STATE_ARRAYS", export.state_arrays, one.state))
    return joined(parts)

"""Settings and start state as initialisers in C."""

from typing import Any

import numpy as np

from adaptive_ff.export.export import Export
from adaptive_ff.export.leaves import Leaf, value_at
from adaptive_ff.export.scope import c_name
from adaptive_ff.export.types import Array, Line, Record, Type

WIDTH = 100
"""Longest initialiser on one line."""


def arrays_of(found: list[Leaf]) -> list[Leaf]:
    """Return the arrays that hold numbers."""
    return [leaf for leaf in found if leaf.is_array and leaf.count]


def record_table(export: Export, name: str, kind: Record, value: Any) -> str:
    """Return a constant struct with all numbers that stand in it; its arrays are bound to their numbers later."""
    text = _initialiser(export, kind, value, 0, name)
    return f"static const {export.unit.c_type(kind)} {name} = {text};\n"


def _initialiser(export: Export, kind: Type, value: Any, depth: int, where: str) -> str:
    if isinstance(kind, Record):
        inner = "    " * (depth + 1)
        lines = [
            f"{inner}.{c_name(name)} = {_initialiser(export, field, getattr(value, name), depth + 1, f'{where}.{name}')},"
            for name, field in kind.fields
            if not isinstance(field, Array)
        ]
        return "{0}" if not lines else "{\n" + "\n".join(lines) + "\n" + "    " * depth + "}"
    if isinstance(kind, Line):
        items = [_initialiser(export, kind.element, item, depth + 1, where) for item in value]
        return "{.at = {" + ", ".join(items) + "}}"
    return export.precision.literal(value, where)


def array_table(export: Export, struct: str, name: str, found: list[Leaf], value: Any) -> str:
    """Return a constant struct with the numbers of all arrays."""
    lines = [
        f"    .{leaf.storage} = {_numbers(export, np.asarray(value_at(value, leaf.path)), leaf.storage, 1)},"
        for leaf in arrays_of(found)
    ]
    return f"static const {struct} {name} = {{\n" + "\n".join(lines) + "\n};\n"


def _numbers(export: Export, array: Any, where: str, depth: int) -> str:
    if array.ndim > 1:
        inner = "    " * (depth + 1)
        rows = [f"{inner}{_numbers(export, row, where, depth + 1)}," for row in array]
        return "{\n" + "\n".join(rows) + "\n" + "    " * depth + "}"
    items = [export.precision.literal(item, where) for item in array.tolist()]
    lines, line = [], ""
    for item in items:
        if line and len(line) + len(item) > WIDTH:
            lines.append(line)
            line = ""
        line += f"{item}, "
    lines.append(line)
    return "{" + ("\n" + "    " * (depth + 1)).join(part.rstrip() for part in lines).removesuffix(",") + "}"

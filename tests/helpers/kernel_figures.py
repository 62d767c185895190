"""Figures of kernels: what those of all that their language has become in C, and what small ones do, or why not."""

import ast
import inspect
import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import written_kernels as written
from drawn_arguments import digest

from controllers.kernels import unit
from controllers.kernels.language import NotTranslatable
from controllers.kernels.sources import read_kernel
from controllers.kernels.text import DOUBLE, SINGLE
from controllers.kernels.types import type_of

GIVEN = {"a": 1.5, "b": 1.5, "n": 3, "m": 2, "flag": True, "row": np.ones(4), "table": np.ones((3, 4))}
GIVEN |= {"point": written.Point(1.5, -2.0), "circle": written.Circle(2.0), "square": written.Square(3.0)}
GIVEN["body"] = written.Body(True, GIVEN["point"], 4, (1.0, 2.0, 3.0), GIVEN["row"], GIVEN["table"], False)
"""Samples of the arguments of kernels, by their names; others are numbers."""

PIECES = Path(__file__).resolve().parent.parent / "pieces_of_kernels.txt"
"""Expressions, then statements, then bodies of kernels, where E stands for the first, S and T for two of the others."""


def c_of(function, kinds, precision, fixed):
    """Return the C of a kernel, or what it is refused with."""
    made = unit.Unit(precision, "x", fixed=fixed)
    try:
        made.function(function, kinds)
    except NotTranslatable as error:
        return re.sub(r"\.py:\d+", ".py", str(error).rpartition("/")[2])
    parts = [part.text for part in (*made.structs.values(), *made.functions.values())]
    return "\n".join([made.definitions(), *parts, *made.helper_texts()])


def written_figures():
    """Return digests of what kernels of all that their language has become in C."""
    found = {}
    for name, kernel in vars(written).items():
        if not inspect.isfunction(kernel) or kernel.__module__ != written.__name__:
            continue
        for label, precision, fixed in (("double", DOUBLE, True), ("single", SINGLE, True), ("open", DOUBLE, False)):
            kinds = tuple(type_of(GIVEN.get(one, 1.5), sizes=fixed) for one in inspect.signature(kernel).parameters)
            found[f"{name} {label}"] = digest([c_of(kernel, kinds, precision, fixed)])
    return found


def piece_figures(part, parts):
    """Return a digest of what each body becomes in C with any piece in it, or why it is refused, for some of them."""
    expressions, statements, bodies = (each.splitlines() for each in PIECES.read_text("utf-8").split("\n\n"))
    kinds = {fixed: tuple(type_of(one, sizes=fixed) for one in GIVEN.values()) for fixed in (True, False)}
    host, found = written.on_its_own, {}
    for row, body in enumerate(bodies[part::parts]):
        pieces, said = expressions if re.search(r"\bE\b", body) else statements, []
        for place, piece in enumerate(pieces):
            put = {"E": piece if piece[0] == "*" else f"({piece})", "S": piece, "T": pieces[place - 17]}
            lines = re.sub(r"\b[EST]\b", lambda word: put[word[0]], body.replace(r"\n", "\n    "))  # noqa: B023
            try:
                tree = ast.parse(f"def {host.__name__}({', '.join(GIVEN)}):\n    {lines}").body[0]
            except SyntaxError:
                continue
            kernel, fixed = replace(read_kernel(host), tree=tree), (place + row) % 2 == 0
            with patch.object(unit, "read_kernel", lambda one: kernel if one is host else read_kernel(one)):  # noqa: B023
                said.append(c_of(host, kinds[fixed], DOUBLE, fixed))
        found[body] = digest(said)
    return found

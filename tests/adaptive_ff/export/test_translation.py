"""Every kernel that a controller runs has a translation; what has none is refused with its place and a remedy."""

import functools

import numpy as np
import pytest
from closed_loops import NAMES, SCENARIO, sampled
from exports import DELAYED, WARNINGS, adaptive, compiled, made, needs_gcc
from kernels_from_text import from_text

from adaptive_ff.comparison.own import Foreign
from adaptive_ff.export.errors import NotExportable
from adaptive_ff.export.export import Export
from adaptive_ff.export.source import source
from controllers import STEPS
from controllers.kernels.language import NotTranslatable
from controllers.kernels.text import DOUBLE
from controllers.kernels.types import type_of
from controllers.kernels.unit import Unit


def translated(text, tmp_path, monkeypatch, *arguments, with_structs=False):
    """Translate a function of a module with the given text; where asked for, after the structs that it needs."""
    function = from_text(text, tmp_path, monkeypatch).py_func
    unit = Unit(DOUBLE, "x", fixed=True)
    whole = unit.function(function, tuple(type_of(argument, sizes=True) for argument in arguments))
    parts = (*(unit.structs.values() if with_structs else [whole]), *unit.functions.values())
    return "\n".join([*(unit.helper_texts() if with_structs else []), *(part.text for part in parts)])


OURS = {kind for kind in set(STEPS) - {Foreign} if kind.__module__.startswith(("adaptive_ff.", "controllers."))}
KINDS = sorted(OURS, key=lambda kind: kind.__name__)  # a user's own has no kernel, and tests register some


@functools.cache
def made_once(name, delayed):
    return made(name, DELAYED if delayed else SCENARIO)


@pytest.mark.parametrize("delayed", sampled([False, True], [True]), ids=["prompt", "delayed"])
@pytest.mark.parametrize("kind", KINDS)  # users' have no kernel
def test_every_registered_kernel_has_a_translation(kind, delayed):
    first = next(c for c in (made_once(name, delayed) for name in NAMES) if type(c.parameters) is kind)
    export = Export(first, "made")
    text = source(export)
    assert f"static inline {export.unit.c_type(export.step.result)} {export.step.name}(" in text
    for function in export.unit.functions.values():
        assert text.count(f" {function.name}(") >= 1


def test_every_controller_of_the_comparison_is_of_a_registered_class():
    assert {type(made_once(name, False).parameters) for name in NAMES} == OURS


def test_names_comments_and_equations_of_the_kernels_are_kept():
    text = source(Export(made("pi"), "made"))
    assert "The integral is a backward Euler sum, I(k) = I(k-1) + Ki dt e(k)" in text
    assert "---- controllers/pi.py" in text
    assert "integral += fraction * (inputs->realised_torque - asked_torque(pi, state));" in text


def test_single_precision_has_no_double():
    text = source(Export(adaptive(), "made", single=True))
    code = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith(("/*", "*")))
    assert "double" not in code
    assert "expf(" in code
    assert " exp(" not in code


def test_what_has_no_kernel_or_diverges_in_single_precision_is_refused_with_its_reason():
    with pytest.raises(NotExportable, match="Own cannot be exported: it has no kernel"):
        Export(type("Own", (), {"step": lambda self, reference, velocity: 0.0})(), "made")
    with pytest.raises(NotExportable, match=r"PaperController cannot be exported in single precision: the covariance"):
        Export(made("adaptive_paper"), "made", single=True)


def test_a_loop_without_a_known_length_is_refused_with_its_line_and_a_remedy(tmp_path, monkeypatch):
    text = "def kernel(x):\n    while x > 0.0:\n        x -= 1.0\n    return x\n"
    with pytest.raises(NotTranslatable, match=r"\.py:2: kernel: .*; in firmware a loop over a range replaces while$"):
        translated(text, tmp_path, monkeypatch, 1.0)


PASSED_ON = """from typing import NamedTuple

class Pair(NamedTuple):
    x: float
    y: float
    shift: float
    factor: float
    rest: float

def pair_of(x, y):
    return Pair(x, y, 0.0, 1.0, 0.0)

def swapped(pair):
    return pair_of(pair.y, pair.x)

def parts(pair, factor):
    return factor * pair.x, pair

def count(pair):
    return 2

def place(pair):
    return 1 if pair.x > pair.y else 0

"""


@needs_gcc
@pytest.mark.parametrize(
    "body",
    [
        "    return parts(swapped(pair_of(a, rows[0, 0])), a)",
        "    first, second = parts(swapped(pair_of(a, a)), a)\n    return first + second.y",
        "    return a * count(swapped(pair_of(a, a)))",
        "    if count(pair_of(a, a)) > 1:\n        a += 1.0\n    return a",
        "    # the pair decides nothing\n    if count(pair_of(a, a)) > 1:\n        a += 1.0\n    return a",
        "    rows[place(swapped(pair_of(a, 1.0)))][1] = a\n    return a",
        "    rows[place(swapped(pair_of(a, 1.0)))][1] += a\n    return a",
    ],
)
def test_a_record_that_is_passed_on_leaves_no_unused_variable(body, tmp_path, monkeypatch):
    text = f"{PASSED_ON}def kernel(a, rows):\n{body}\n"
    made = translated(text, tmp_path, monkeypatch, 0.5, np.zeros((2, 2)), with_structs=True)
    (tmp_path / "kernel.c").write_text(f"#include <stdbool.h>\n#include <stdint.h>\n\n{made}")
    compiled(tmp_path, ["kernel.c"], "-c", *WARNINGS, out="kernel.o")


def test_each_call_of_a_kernel_is_made_once(tmp_path, monkeypatch):
    for body in ("return parts(swapped(pair_of(a, a)), a)", "rows[place(swapped(pair_of(a, 1.0)))][1] = a"):
        text = f"{PASSED_ON}def kernel(a, rows):\n    {body}\n"
        made = translated(text, tmp_path, monkeypatch, 0.5, np.zeros((2, 2)), with_structs=True)
        assert made.count("= swapped(") == 1


NO_NAME, TAKEN = ("", "1st", "Upper", "with space", "double", "a" * 40, "é"), ("main", "math", "stdint", "string")


@pytest.mark.parametrize("prefix", [*NO_NAME, *TAKEN])
def test_a_prefix_must_be_a_name_and_not_that_of_another_file(prefix):
    other_file = rf"^prefix = '{prefix}' is not allowed: {prefix}\.c or {prefix}\.h is anot"
    said = other_file if prefix in TAKEN else r"prefix = .* begins with a letter and is no word of C"
    with pytest.raises(NotExportable, match=said):
        Export(made("pi", SCENARIO), prefix)

"""What kernels contain does the same as machine code as it does in Python, from the disk as well."""

import copy
import importlib
import linecache
import math
import sys

import numpy as np
import pytest
import written_kernels as written
from exports import printed
from kernels_from_text import compiling
from written_kernels import Body, Circle, Point, Square

from controllers.compiled import Compiled, compiled
from controllers.kernels.language import NotTranslatable
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, type_of


def row():
    return np.array([0.5, 3.0, -1.0, 2.0])


def table():
    return np.array([[1.0, 2.0, 4.0, -0.5], [0.1, 0.2, 0.3, 0.4], [5.0, 6.0, 7.0, 8.0]])


def body(moving=True):
    return Body(moving, Point(1.5, -2.0), 4, (1.0, 2.0, 3.0), row(), table(), False)


CALLS = [
    *[(written.arithmetic, (a, b, n)) for a, b, n in [(1.5, 2.0, 3), (-0.3, 0.7, -2), (1e100, 3.0, 0)]],
    *[(written.mathematics, (a,)) for a in (0.3, 1.0, 1.7)],
    *[(written.whole_numbers, (a, n)) for a, n in [(2.5, 3), (-2.5, -3), (0.0, 0)]],
    *[(written.divided, (n, m)) for n in (-7, -4, 0, 5) for m in (-3, -2, 2, 5)],
    *[
        (written.choices, (a, b, n))
        for a, b, n in [(1.0, 2.0, 3), (math.nan, 2.0, 0), (2.0, math.nan, 9), (0.0, -0.0, 1)]
    ],
    *[(written.tests, (a, b)) for a in (-1.0, 0.0, math.nan, math.inf) for b in (0.0, -0.0, math.nan, -math.inf)],
    *[(written.joined, (a, b, flag)) for a in (-2.0, 0.5) for b in (-1.0, 1.0, 3.0) for flag in (True, False)],
    *[(written.first_of, (np.ones(size),)) for size in (2, 6)],
    *[(written.compared_last, (row(), a)) for a in (-1.0, 1.0, 2.0)],
    *[(written.branches, (a, n)) for a in (2.0, 0.5, -3.0) for n in (0, 5)],
    *[(written.nested, (a, b, n)) for a in (-2.0, 0.5, 3.0) for b in (-1.0, 2.5) for n in (1, 5)],
    *[(written.chosen, (flag, body())) for flag in (True, False)],
    *[(written.sums, (values, table())) for values in (row(), -row(), np.arange(4.0))],
    *[(written.waiting, (a,)) for a in (0.5, 40.0, 1e300)],
    *[(written.from_the_end, (row(), table(), n)) for n in (-1, 0, 1, -3)],
    *[(written.changed, (values, table(), 1.25)) for values in (row(), np.ones(2 + 1))],
    (written.exchanged, (1.0, 2.0, body())),
    (written.kept_from_a_loop, (row(),)),
    *[(written.made, (body(moving), 0.25)) for moving in (True, False)],
    *[(written.calls, (point, row(), 2.0)) for point in (Point(3.0, 4.0), Point(0.0, 0.0))],
    (written.items, (body(),)),
    *[(written.shadowed, (a,)) for a in (1.0, 3.0)],
    (written.both, (Circle(2.0), Square(3.0), 1.5)),
    (written.on_its_own, (1.0,)),
]

COMPILED = {kernel: compiled(kernel) for kernel, _ in CALLS}


def flat(value):
    """All numbers of a result, so that those that are none can be compared."""
    if isinstance(value, tuple):
        return [number for item in value for number in flat(item)]
    return np.ravel(np.asarray(value, dtype=float)).tolist()


def shape_of(value):
    """Classes of a result: a tuple of which kind, an integer or a real number."""
    if isinstance(value, tuple):
        return (type(value), *map(shape_of, value))
    return np.ndarray if isinstance(value, np.ndarray) else type(value)


@pytest.mark.parametrize(("kernel", "arguments"), CALLS, ids=lambda item: getattr(item, "__name__", ""))
def test_a_kernel_does_the_same_as_machine_code(kernel, arguments):
    given, taken = copy.deepcopy(arguments), copy.deepcopy(arguments)
    expected, found = kernel(*given), COMPILED[kernel](*taken)
    np.testing.assert_array_equal(flat(found), flat(expected))
    np.testing.assert_array_equal(flat(taken), flat(given))
    assert np.signbit(flat(found)).tolist() == np.signbit(flat(expected)).tolist()


@pytest.mark.parametrize(
    ("kernel", "arguments"), [(written.made, (body(), 0.25)), (written.exchanged, (1.0, 2.0, body()))]
)
def test_what_comes_back_has_the_classes_that_python_gives(kernel, arguments):
    assert shape_of(compiled(kernel)(*arguments)) == shape_of(kernel(*arguments))


def test_a_division_of_integers_by_zero_gives_zero_and_does_not_end_the_process():
    assert compiled(written.divided)(7, 0)[:2] == (0, 0)


def test_an_integer_for_a_real_field_becomes_a_real_number():
    found = compiled(written.kept_from_a_loop)(np.array([0.0, 2.0]))
    assert found == (2.0, 1.0)
    assert shape_of(found) == (Point, float, float)


def test_arrays_that_come_back_are_those_that_were_given():
    given = body()
    found = compiled(written.made)(given, 1.0)[0]
    assert found.row is given.row
    assert found.table is given.table


def test_a_function_without_source_or_within_another_is_refused():
    with pytest.raises(NotTranslatable, match="must be a function of a module"):
        Compiled(lambda x: x)(1.0)
    with pytest.raises(NotTranslatable, match="source is not at hand"):
        Compiled(len)(1.0)


def test_types_come_from_samples():
    pair = Record("Point", (("x", REAL), ("y", REAL)), Point)
    assert type_of(Point(1.0, 2.0)) == type_of(Point(3.0, 4.0)) == pair
    assert type_of((1, 2)) == Line(INTEGER, 2)
    assert type_of(np.zeros((2, 3), dtype=bool)) == Array(BOOLEAN, (None, None))
    assert type_of(np.zeros((2, 3)), sizes=True) == Array(REAL, (2, 3))
    assert type_of(True, values=True).value == 1


@pytest.mark.parametrize(
    "value",
    ["text", None, [1.0], np.zeros(3, dtype=np.float32), np.zeros((4, 4)).T, np.zeros(4)[::2], 1j, (1, 2.0), ()],
)
def test_other_values_are_refused(value):
    with pytest.raises(NotTranslatable, match="is not allowed in kernels: they take numbers, contiguous arrays"):
        type_of(Point(1.0, value), "place")


SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from controllers.compiled import compiled, is_cached
from edited import kernel
entry = compiled(kernel)
made = is_cached(entry)
print(made, entry(2.0))
"""


def test_machine_code_is_loaded_until_a_source_outside_of_the_packages_changes(tmp_path):
    source = tmp_path / "edited.py"
    known, found = compiling(tmp_path / "cache"), []
    for text in ("3.0 * x", "3.0 * x", "5.0 * x"):
        source.write_text(f"def kernel(x):\n    return {text}\n")
        found.append(printed(sys.executable, "-c", SCRIPT, tmp_path, env=known).strip())
    assert found == ["False 6.0", "True 6.0", "True 10.0"]
    files = list((tmp_path / "cache").rglob("kernel_*.record"))
    assert len(files) == 2


def test_a_module_that_is_loaded_anew_has_its_new_code_at_once(tmp_path, monkeypatch):
    source = tmp_path / "loaded_anew.py"
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    found = []
    for factor in (2.0, 3.0):
        source.write_text(f"def kernel(x):\n    return {factor} * x\n")
        importlib.invalidate_caches()
        linecache.clearcache()
        kernel = importlib.import_module("loaded_anew").kernel
        found += [compiled(kernel)(1.0), compiled(kernel)(1.0)]
        sys.modules.pop("loaded_anew")
    assert found == [2.0, 2.0, 3.0, 3.0]


OWN_SCRIPT = """
from typing import NamedTuple
from controllers.compiled import compiled, is_cached

class Own(NamedTuple):
    number: float

def kernel(own):
    return Own({} * own.number)

print(compiled(kernel)(Own(2.0)).number)
"""


def test_two_scripts_may_use_the_same_names_and_a_damaged_file_is_made_anew(tmp_path):
    known, found = compiling(tmp_path / "cache"), []
    for name, factor in (("one", 3.0), ("two", 5.0), ("one", 3.0), ("two", 5.0)):
        script = tmp_path / f"{name}.py"
        script.write_text(OWN_SCRIPT.format(factor))
        found.append(float(printed(sys.executable, script, env=known)))
        if len(found) == 2:
            for file in (tmp_path / "cache").rglob("kernel_*.record"):
                file.write_bytes(file.read_bytes()[:20])
    assert found == [6.0, 10.0, 6.0, 10.0]

"""What kernels contain, written or drawn at random from the language, does the same as machine code as in Python."""

import copy
import importlib
import linecache
import math
import random
import sys

import numpy as np
import pytest
import written_kernels as written
from exports import printed
from kernels_from_text import compiling, from_text
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


KERNELS = 12
HEAD = "import math\n\n\n"
FUNCTIONS = ("math.sin", "math.atan", "math.sinh", "abs", "math.floor", "-")


class Drawn:
    """Draws expressions and statements over the real numbers x, y, z and the integers i, n."""

    def __init__(self, seed):
        self.draw = random.Random(seed)

    def real(self, depth):
        draw = self.draw
        if depth == 0:
            return draw.choice(["x", "y", "z", "i", "n", repr(round(draw.uniform(-3.0, 3.0), 3))])
        one, two = self.real(depth - 1), self.real(draw.randrange(depth))
        kinds = [*(f"({one} {sign} {two})" for sign in "+-*"), f"({one} / (1.5 + abs({two})))"]
        kinds += [f"min({one}, {two})", f"max({one}, {two})", f"({one} if {self.truth(depth - 1)} else {two})"]
        kinds += [f"{draw.choice(FUNCTIONS)}(math.atan({one}))", f"math.copysign({one}, {two})"]
        return draw.choice([*kinds, f"({self.whole(depth - 1)} + 0.5)"])

    def whole(self, depth):
        draw = self.draw
        if depth == 0:
            return draw.choice(["i", "n", str(draw.randrange(-9, 9))])
        one, two = self.whole(depth - 1), self.whole(draw.randrange(depth))
        divisor = draw.choice([-7, -3, 2, 5])
        return draw.choice([f"({one} + {two})", f"({one} - {two})", f"({one} // {divisor})", f"({one} % {divisor})"])

    def truth(self, depth):
        draw = self.draw
        if depth == 0:
            return f"{self.real(0)} {draw.choice(['<', '<=', '>', '>=', '==', '!='])} {self.real(0)}"
        one, two = self.truth(depth - 1), self.truth(depth - 1)
        return draw.choice([f"({one} and {two})", f"({one} or {two})", f"not ({one})", f"{one}"])

    def statements(self, depth, indent="    ", inner=False):
        draw, lines = self.draw, []
        for _ in range(draw.randrange(1, 4)):
            kind = draw.randrange(6) if depth else draw.randrange(3)
            if kind < 2:
                lines.append(f"{draw.choice('xyz')} {draw.choice(['=', '+=', '-='])} math.atan({self.real(2)})")
            elif kind == 2:
                lines.append(f"i = {self.whole(2)} % 11")
            elif kind == 3:
                lines += [f"if {self.truth(1)}:", *self.statements(depth - 1, "    ", inner)]
                lines += ["else:", *self.statements(depth - 1, "    ", inner)] if draw.random() < 0.5 else []
            elif kind == 4:
                start, stop, step = draw.choice([(0, 4, 1), (3, -1, -1), (-2, 3, 1)])
                lines += [f"for k{depth} in range({start}, {stop}, {step}):", f"    z += 0.25 * k{depth}"]
                lines += self.statements(depth - 1, "    ", True)
            elif inner:
                lines += [f"if {self.truth(0)}:", f"    {draw.choice(['break', 'continue', 'return x, y, z, i'])}"]
        return [indent + line for line in lines or ["z += x"]]

    def kernel(self, name):
        body = "\n".join(self.statements(3))
        return f"def {name}(x, y, n):\n    z = 0.5\n    i = 1\n{body}\n    return x, y, z, i\n\n\n"


@pytest.mark.parametrize("seed", range(4))
def test_kernels_drawn_at_random_are_the_same_as_machine_code(seed, tmp_path, monkeypatch):
    drawn = Drawn(seed)
    names = [f"drawn_{number}" for number in range(KERNELS)]
    calls = ", ".join(f"{name}(x, y, n)" for name in names)
    text = HEAD + "".join(map(drawn.kernel, names)) + f"def kernel(x, y, n):\n    return {calls}\n"
    kernel = from_text(text, tmp_path, monkeypatch)
    for _ in range(25):
        x, y = drawn.draw.uniform(-4.0, 4.0), drawn.draw.choice([0.0, -0.0, 1.0, 1e-9, -2.5])
        given = (x, y, drawn.draw.randrange(-5, 6))
        expected, found = kernel.py_func(*given), kernel(*given)
        for one, other in zip(expected, found, strict=True):
            assert [type(value) for value in other[:3]] == [float] * 3
            assert np.array_equal(other, one)
            assert np.array_equal(np.signbit(other), np.signbit(one))

"""The text of kernels in C, and where their values lie in memory."""

import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kernels_from_text import from_text

from controllers.compiled import compiled
from controllers.kernels import text as texts
from controllers.kernels.language import NotTranslatable
from controllers.kernels.memory import Memory
from controllers.kernels.text import DOUBLE, LARGEST_SINGLE, SINGLE, SMALLEST_SINGLE, comment_lines, wrapped_code
from controllers.kernels.types import type_of
from controllers.kernels.unit import Unit

FAR = "How far it is, " * 7 + "m."
HEAD = f'''from typing import NamedTuple
from controllers.kernels.language import natural
COUNT, DEPTH = 3, -2

class Point(NamedTuple):
    """A point on a plane.

    Attributes
    ----------
    x, y : float
        Place,
        m.
    z : float
        {FAR}
    """
    x: float
    y: float
    z: float
    number: int  # which one

def at(row, n, k):
    return row[natural(n) + k]

def two():
    return 2

'''


def written(text, tmp_path, monkeypatch, fixed):
    """Kernels in C, with their struct: as firmware of known sizes or for this machine."""
    function = from_text(HEAD + text, tmp_path, monkeypatch).py_func
    given = (1.0, 2, np.zeros(3), np.zeros((3, 2)), function.__globals__["Point"](1.0, 2.0, 3.0, 4))
    whole = Unit(DOUBLE, "x", fixed=fixed)
    whole.function(function, tuple(type_of(each, sizes=fixed) for each in given))
    structs = (struct.text for struct in whole.structs.values() if struct.name == "x_Point")
    return re.sub(r"MADE_\d+", "MADE", "\n".join([*structs, *(made.text for made in whole.functions.values())]))


def test_arrays_of_firmware_do_not_change_their_names_together(tmp_path, monkeypatch):
    text = "def kernel(x, n, row, table, point):\n    row, x = row, row[0]\n    return x\n"
    with pytest.raises(NotTranslatable, match="give arrays their names one by one"):
        written(text, tmp_path, monkeypatch, fixed=True)
    assert "kernel" in written(text, tmp_path, monkeypatch, fixed=False)


@pytest.mark.parametrize("fixed", [False, True])
def test_what_is_said_of_a_constant_stands_in_firmware_alone(fixed, tmp_path, monkeypatch):
    text = 'LEVEL = 2.0\n"""How high."""\n\ndef kernel(x):\n    return LEVEL * x\n'
    unit = Unit(DOUBLE, "x", fixed=fixed)
    unit.function(from_text(text, tmp_path, monkeypatch).py_func, (type_of(1.0),))
    assert ("How high." in unit.definitions()) == fixed


def test_names_that_c_has_are_not_taken():
    assert [texts.unit(said) for said in ("speed, rad/s", "a name")] == ["rad/s", ""]
    assert [texts.function_name(name) for name in ("own", "while", "tan")] == ["own", "while_", "tan_"]
    assert [texts.c_name(name) for name in ("own", "while", "tan")] == ["own", "while_", "tan"]


def test_numbers_are_written_as_c_has_them():
    values = [True, np.bool_(False), -7, np.int64(-(2**63)), 2.0, -1e-7, -0.0, math.nan, math.inf, -math.inf]
    found = [" ".join(precision.literal(value) for value in values) for precision in (DOUBLE, SINGLE)]
    assert found == [
        "true false -7 INT64_MIN 2.0 -1e-07 -0.0 (double)NAN (double)INFINITY (double)-INFINITY",
        "true false -7 INT64_MIN 2.0f -1e-07f -0.0f NAN INFINITY -INFINITY",
    ]
    for value in (1e39, -1e39):
        with pytest.raises(NotTranslatable, match=r"^LARGEST = -?1e\+39 is too large for single precision"):
            SINGLE.literal(value, "LARGEST")


@settings(max_examples=100)
@given(st.floats(-LARGEST_SINGLE, LARGEST_SINGLE) | st.floats(-1e-37, 1e-37))
def test_numbers_read_back_as_the_nearest_that_are_no_zero(value):
    assert float(DOUBLE.literal(value)) == value
    least = math.copysign(SMALLEST_SINGLE, value)
    nearest = least if 0.0 < abs(value) < SMALLEST_SINGLE else np.float32(value)
    assert np.float32(SINGLE.literal(value).removesuffix("f")) == nearest


WORDS = "word-word " * 10


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ""),
        ("of one µm² */\n", "  /* of one um^2 * / */\n"),
        ("a ``b``\n\n  indented??", "  /* a b\n   *\n   *   indented? ?\n   */\n"),
        (108 * "x", f"  /* {108 * 'x'} */\n"),
        (109 * "x", f"  /* {109 * 'x'}\n   */\n"),
        (f"  {WORDS}word-word and", f"  /*   {WORDS}word-word\n   *   and\n   */\n"),
        (f"  {WORDS}word-words", f"  /*   {WORDS.rstrip()}\n   *   word-words\n   */\n"),
    ],
)
def test_comments_are_wrapped_between_words_and_end_nowhere_else(text, expected):
    assert comment_lines(text, "  ") == expected


LINES = """
1234567890123456789012345678901234567890;
/* 123456789012345678901234567890, 1234567890 */
1234567890123456789012, 5678901234567890123456
12345678901234567890123,|    678901234567890123456
1234567890123456789012 + 678901234567890123456
    a = 1234567890123456789, 45, 789,|        1234, 67
    total = alpha_beta_gamma * del|        + (eta - zeta) * theta;
    if (alpha_beta_gamma_delta|        && (eta <= zeta)) {
    + alpha_beta_gamma_delta + zeta|    + eta * iota;
"""
FIELDS = "  a = (P){|      .a = 1,|      .b = f(2, 3),|      .c = (Q){|          .d = -eta,|      },|  };"


def test_long_lines_are_broken_where_least_is_nested_and_each_field_has_its_own():
    """None to the left of the 26th character, at which the second of these that are broken is."""
    for line in LINES.strip("\n").split("\n"):
        first, *rest = line.split("|")
        assert wrapped_code(" ".join([first, *(part.lstrip() for part in rest)]), 40) == [first, *rest]
    assert wrapped_code("  a = (P){.a = 1, .b = f(2, 3), .c = (Q){.d = -eta}};", 22) == FIELDS.split("|")


ALIKE = ["x - (x - 1.0)", "x - 1.0 - x", "x / (x * 2.0)", "x * 2.0 / x", "x * (x + 1.0)", "-(-x)", "x - -1.0"]
EXPRESSIONS = {each: each for each in [*ALIKE, "(n == 2) != (n == 3)", "(x < 1.0) == (x < 2.0)"]} | {
    "not (x < 1.0 or n > 0) and (0.0 < x <= 1.0 or n < 0)": "!(x < 1.0 || n > 0) && ((0.0 < x && x <= 1.0) || n < 0)",
    "x if n > 0 else (1.0 if n < 0 else 0.0)": "n > 0 ? x : (n < 0 ? 1.0 : 0.0)",
    "(1 if x > 0.0 else 2) * n / 2": "(double)((x > 0.0 ? 1 : 2) * n) / 2.0",
    "2 * COUNT * x + DEPTH": "(double)(2 * MADE_COUNT) * x + (double)MADE_DEPTH",
    "x if two() > 1 else 0.0": "x",
    "x < (x, 1.0)[1]": "x < value.at[1]",
    "int(x) - int(n)": "(int64_t)x - n | whole_number(x) - n",
    "x**2 + x**x - max(x, n, 1)": "square(x) + pow(x, x) - larger(larger(x, (double)n), 1.0)",
    "abs(x) + abs(n)": "fabs(x) + (double)absolute_integer(n)",
    "n // 3 + n % 3": "floored_quotient(n, 3) + floored_rest(n, 3)",
    "natural(n) // 3 + natural(n) % 3": "n / 3 + n % 3",
    "natural(n) // n + natural(n) % -3": "floored_quotient(n, n) + floored_rest(n, -3)",
    "row[-1]": "row[2] | row[3 - 1]",
    "row[n] + row[natural(n) - 1]": "row[from_start(n, 3)] + row[from_start(n - 1, 3)]",
    "at(row, n, 0) + row[0]": "row[n + k]",
    "at(row, n, -1)": "row[from_start(n + k, 3)]",
    "row[n % 3] + row[int(x > 0.0)]": "row[floored_rest(n, 3)] + row[(int64_t)(x > 0.0)]",
    "row[max(natural(n), 1)] + row[1 if x > 0.0 else 0]": "row[larger_integer(n, 1)] + row[x > 0.0 ? 1 : 0]",
    "t[natural(n) + 1, 1]": "t[n + 1][1] | t[(n + 1) * 2 + 1]",
    "t.size + t.shape[0]": "9 | t.size0 * 2 + t.size0",
    "p._replace(x=1, y=x).x * p[3]": "(x_Point){.x = 1.0, .y = x, .z = p.z, .number = p.number}.x * (double)p.number",
}
"""Expressions in C, and behind a bar as they are for this machine where arrays differ by more than their sizes."""


@pytest.mark.parametrize(("python", "expected"), EXPRESSIONS.items())
def test_expressions_keep_their_grouping_and_indices_count_from_the_start(python, expected, tmp_path, monkeypatch):
    for fixed, place in ((True, 0), (False, -1)):
        text = written(f"def kernel(x, n, row, t, p):\n    return {python}\n", tmp_path, monkeypatch, fixed)
        plain = text.replace(".data", "").replace("row.size0", "3").replace("t.size1", "2")
        assert f"    return {expected.split(' | ')[place]};" in plain


KERNEL = """def kernel(x, n, row, t, p):
    \"\"\"Return a sum.\"\"\"
    # above
    total, new = 0.0, 2  # beside
    x, total = total, x
    pass  # of no statement
    t[1] = (x, 2.0)
    for i in range(row.size):
        if i == n:  # the one
            continue
        elif x > 1.0:
            total += i
        else:
            break
    return total
"""
FIRMWARE = Path(__file__).with_name("firmware.c").read_text("utf-8")


def test_structs_and_functions_of_firmware_say_what_the_kernel_says_and_name_what_is_unused(tmp_path, monkeypatch):
    assert written(KERNEL, tmp_path, monkeypatch, True).split() == FIRMWARE.split()
    here = written(KERNEL, tmp_path, monkeypatch, False)
    assert "KERNEL double kernel(double x, int64_t n, RealArray1 row, RealArray2 t, x_Point p)\n{\n    double" in here
    assert re.findall(r"\(void\)|/\*", here) == []
    nothing = written("def kernel(x, n, row, t, p):\n    row[0] = x\n", tmp_path, monkeypatch, False)
    assert "KERNEL void kernel(" in nothing


class Inner(NamedTuple):
    flag: bool
    number: float
    other: bool


class Outer(NamedTuple):
    first: bool
    inner: Inner
    count: int
    line: tuple[float, ...]
    vector: np.ndarray
    again: Inner
    matrix: np.ndarray
    last: bool


def made():
    return Outer(
        True, Inner(False, 1.5, True), -7, (2.0, 3.0), np.arange(3.0), Inner(True, 4.0, False), np.eye(2), True
    )


def read(value):
    value.vector[0] = 9.0
    numbers = value.vector[2], value.matrix[1, 1]
    return value.first, value.inner, value.count, value.line, numbers, value.again, value.last


def test_compiled_code_reads_what_was_laid_down():
    value = made()
    found = compiled(read)(value)
    assert found == (value.first, value.inner, value.count, value.line, (2.0, 1.0), value.again, value.last)
    assert value.vector[0] == 9.0


def test_value_comes_back_with_the_same_arrays():
    value = made()
    memory = Memory(value)
    assert memory.value.vector is value.vector
    assert memory.value.matrix is value.matrix
    changed = value._replace(count=8, inner=Inner(True, 2.5, False), vector=np.ones(3))
    memory.value = changed
    assert (memory.value.count, memory.value.inner) == (8, changed.inner)
    assert memory.value.vector is changed.vector


def test_numbers_of_numpy_are_those_that_compiled_code_sees():
    assert Memory(Inner(np.bool_(True), np.float64(2.0), False)).value == (True, 2.0, False)


@pytest.mark.parametrize("value", ["text", None, 1j, np.float32(1.0)])
def test_what_has_no_place_is_refused(value):
    with pytest.raises(TypeError, match="compiled code takes numbers and arrays"):
        Memory(Inner(True, value, False))


def test_firmware_has_loops_over_ranges_alone(tmp_path, monkeypatch):
    text = "def kernel(x, n, row, table, point):\n    while x > 1.0:\n        x *= 0.5\n    return x\n"
    assert "while" in written(text, tmp_path, monkeypatch, False)
    with pytest.raises(NotTranslatable, match="in firmware a loop over a range replaces while"):
        written(text, tmp_path, monkeypatch, True)

"""What machine code cannot hold or do is refused, with file and line, and with what to write instead."""

import math

import numpy as np
import pytest
from kernels_from_text import from_text

from controllers.kernels.language import NotTranslatable
from controllers.kernels.types import type_of

HEAD = """import collections
import functools
import math
from typing import NamedTuple
from written_kernels import Point, is_far, measure

COUNT = 3
LEVEL = 9.0
LARGE = 2**64
LEAST = -(2**63)
LIST = [1.0]
LISTS = ([1.0],)

def g(a, b=1.0):
    return a - b

def all_of(*a):
    return a[0]

def named_only(a, *, b=1.0):
    return a - b

def placed_only(a, /, b=1.0):
    return a - b

def risen(t):
    t[0, 0] += 1.0
    return t[0, 0] > 1.5

def doubled(f):
    @functools.wraps(f)
    def around(x):
        return 2.0 * f(x)
    return around

@doubled
def decorated(x):
    return x

def bump(t):
    t[0, 0] += 1.0
    return t[0, 0]

def place(t):
    t[0, 0] *= 10.0
    return 1

class Pair(NamedTuple):
    a: float
    b: float

class Doubling(collections.namedtuple("Doubling", "x")):
    def __new__(cls, x):
        return super().__new__(cls, 2.0 * x)

def twice(x):
    return x

first = twice

def twice(x):
    return 2.0 * x

def yielding(x):
    return x
    yield x

"""
FIRST = HEAD.count("\n") + 2  # line of the first statement of a kernel
ALIEN = ("y = [x, x]\nreturn x", "return ~x", "global LIST\nreturn x", "return [y for y in (x,)]")
ALIEN += ("try:\n    return x\nfinally:\n    x = 0.0",)
MISCOUNTED = ("math.sin(x, x)", "abs()", "float(x, x)", "math.isfinite(x, x)")
TOO_LARGE = ("LARGE", "(9223372036854775807 + 1)", "4611686018427387904 * 4", "-LEAST")
BUMPED = ("x = bump(t) + t[0, 0]", "x = t[0, 1] * bump(t)", "x = max(bump(t), bump(t))")
BUMPED += ("t[place(t), 0] += 1.0 + t[0, 0]",)
NO_VALUE = "has no value here; give it one before the branch or loop"


def kernel_of(lines, tmp_path, monkeypatch, head="def kernel(x, n, t):"):
    return from_text(HEAD + head + "\n" + "".join(f"    {each}\n" for each in lines.split("\n")), tmp_path, monkeypatch)


@pytest.mark.parametrize(
    ("lines", "line", "advice"),
    [
        *((lines, 0, "has no translation") for lines in ALIEN),
        *((f"return {one}", 0, "is not known") for one in ("unknown", "bool(x > 0.0)", "print(x)")),
        *((f"return {one}", 0, "no number") for one in ("'text'", "LIST")),
        *((f"return {one}(x)", 0, f"{one} is no function") for one in ("LIST", "LISTS")),
        *((f"return {one}", 0, "must have 1 arguments") for one in MISCOUNTED),
        *((f"return n + {one}", 0, "beyond the 64 bits") for one in TOO_LARGE),
        *((f"{one} = 1.0", 0, f"{one} is a slice; write a loop over a range") for one in ("t[0:1]", "t[0, :]", "t[:]")),
        *((lines, 0, "changes arrays in place") for lines in BUMPED),
        ("return math.gamma(x)", 0, "has no translation; call mathematics or kernels"),
        ("return x**3", 0, "as products"),
        ("return x if x else 1.0", 0, "compare it"),
        ("for item in (1.0, 2.0):\n    x += item\nreturn x", 0, "range"),
        ("for i in range(0, 9, 2):\n    x += i\nreturn x", 0, "by 1 or -1"),
        ("for i in range(3):\n    x += i\nelse:\n    x = 0.0\nreturn x", 0, "without else"),
        ("while x > 0.0:\n    x -= 1.0\nelse:\n    x = 0.0\nreturn x", 0, "else"),
        ("y = 0\ny = 0.5 * x\nreturn y", 1, "y changes its type; begin with 0.0"),
        ("return kernel(x - 1.0, n, t)", 0, "calls itself"),
        ("return math.unknown", 0, "math.unknown is not known; pass it as an argument or make it a module constant"),
        ("return LIST.append(x)", 0, "LIST.append is not known; pass it as an argument"),
        ("return t.shape", 0, "a shape or a tuple of constants cannot be returned"),
        ("return t.shape, x", 0, "a shape or a tuple of constants has no value; use its items"),
        ("return x // 2.0", 0, "+ - * /"),
        ("if x > 0.0:\n    return x, x\nreturn x", 2, "all returns must give values of the same types"),
        ("if x > 0.0:\n    return\nreturn x", 1, "put what follows into the other branch of an if"),
        ("y = x = 1.0\nreturn y", 0, "write a statement for each target"),
        ("if x > 0.0:\n    return x", -1, "must return a value at its end"),
        ("point = Point(x)\npoint.y = 1.0\nreturn point", 1, "make a new NamedTuple"),
        ("return Point(x).z", 0, "has no field z"),
        ("return Point(x)[2]", 0, "one constant place"),
        ("return Point(x)[int(x)]", 0, "one constant place"),
        ("return x[0]", 0, "there are no elements in a number"),
        ("return Point(x, x, x)", 0, "too many"),
        ("return Point(x, z=x)", 0, "name every argument"),
        ("return Point(y=x)", 0, "missing a required argument"),
        ("y = x > 0.0\ny += 1.0\nreturn y", 1, "y is no number"),
        ("return math.sin(x > 0.0)", 0, "math.sin(x > 0.0) is no number"),
        ("return max(x)", 0, "one by one"),
        ("return measure(Point(x), x)", 0, "no kernel is registered"),
        ("a, b = x, x, x\nreturn a", 0, "a value for each"),
        ("a, b = x\nreturn a", 0, "is no tuple"),
        ("return x & 1", 0, "there are + - * /"),
        ("return x is None", 0, "there are < >"),
        ("if x > 1.0:\n    y = x\nelse:\n    y = x > 0.0\nreturn y", 3, "y changes its type"),
        ("return x.real", 0, "has no field"),
        ("if x > 0.0:\n    y = x\nreturn y", 2, NO_VALUE),
        ("if x > 0.0:\n    y = x\nelif x < -1.0:\n    y = -x\nreturn y", 4, NO_VALUE),
        ("if x > 0.0:\n    y = x\ny += 1.0\nreturn y", 2, NO_VALUE),
        ("for i in range(n):\n    y = x\nreturn y", 2, NO_VALUE),
        ("for i in range(n):\n    x += 1.0\nreturn i", 2, NO_VALUE),
        ("for i in range(3, 3):\n    y = x\nreturn y", 2, NO_VALUE),
        ("for i in range(3):\n    if i == n:\n        break\n    y = x\nreturn y", 4, NO_VALUE),
        ("for i in range(3):\n    if i == n:\n        continue\n    y = x\nreturn y", 4, NO_VALUE),
        ("while x > 0.0:\n    x -= 1.0\n    y = x\nreturn y", 3, NO_VALUE),
        ("for i in range(3):\n    if i > 0:\n        x += y\n    else:\n        y = x\nreturn x", 2, NO_VALUE),
        ("while True:\n    if x > 2.0:\n        break\n    y = x\n    x += 1.0\nreturn y", 5, NO_VALUE),
        ("if n > 0:\n    if x > 0.0:\n        y = x\n    else:\n        return x\nreturn y", 5, NO_VALUE),
        ("for i in range(3):\n    x += 1.0\nreturn x + i", 2, NO_VALUE),
        ("z = y\ny = x\nreturn z", 0, "has no value here"),
        ("return g(x, a=3.0)", 0, "multiple values for argument 'a'"),
        ("return g()", 0, "missing a required argument: 'a'"),
        ("return named_only(x, 3.0)", 0, "too many positional arguments"),
        ("return placed_only(a=x)", 0, "name every argument, or give it in its place"),
        ("return all_of(x)", 0, "one by one, without *"),
        ("return (x, x)[2]", 0, "(x, x)[2] is outside of its 2 elements"),
        ("return (x, x)[-3]", 0, "is outside of its 2 elements"),
        ("return decorated(x)", -32, "decorated: a decorator has put another function around it"),
        ("return n + 9223372036854775808", 0, "9223372036854775808 is beyond the 64 bits of integers; write a real"),
        ("return x._replace(y=1.0)", 0, "x._replace(y=1.0): x is no named tuple"),
        ("return Pair(x, x)._replace(x).a", 0, "name every field that changes"),
        ("return Pair(x, x)._replace(c=x).a", 0, "Pair has no field c"),
        ("return Doubling(x).x", 0, "Doubling has a __new__ of its own; write a kernel"),
        ("for _ in range(n):\n    x += 1.0\nreturn _", 2, "_ keeps no value; give the variable a name"),
        ("s = t.shape\nreturn s[0]", 0, "a shape or a tuple of constants has no value; use its items"),
        ("(a, b), c = (x, x), x\nreturn a", 0, "(a, b) cannot be one of several targets; write a statement for each"),
        ("a = b, c = x, x\nreturn b", 0, "write a statement for each target"),
        ("a, *b = x, x\nreturn a", 0, "*b cannot be one of several targets; write a statement for each"),
        ("[a, b] = x, x\nreturn a", 0, "[a, b] cannot be one of several targets; write a statement for each"),
        ("for i in range():\n    x += i\nreturn x", 0, "a range must be of integers"),
        ("for i in range(0, n, 1, 7):\n    x += i\nreturn x", 0, "a range must be of integers"),
        ("t[:] += 1.0", 0, "t[:] is a slice; write a loop over a range"),
        ("t[0] = 1.0", 0, "t[0] is no number of an array; give an index for each dimension"),
        ("p = (x, x)\np[0] = 1.0", 1, "p[0] cannot be assigned to; make a new tuple"),
        ("t[0, 0] += bump(t)", 0, "changes arrays in place; give its result a name in a line before"),
        ("return x > 0.0 and (x, x)[n] > 1.0", 0, "(x, x)[n] stands where it may not be computed; give it a name"),
        ("return 0.0 < x < (x, x)[n]", 0, "(x, x)[n] stands where it may not be computed"),
        ("return x if n > 0 else (x, x)[n]", 0, "(x, x)[n] stands where it may not be computed"),
        ("while (x, x)[n] > 1.0:\n    x *= 0.5\nreturn x", 0, "(x, x)[n] stands where it may not be computed"),
        ("return len(t)", 0, "len is not known; write .size or .shape of an array"),
        ("return round(x)", 0, "round is not known; write math.floor(x + 0.5)"),
        ("return math.hypot(x, x)", 0, "math.hypot has no translation; write math.sqrt(x * x + y * y)"),
        ("return yielding(x)", -5, "yielding: yields; return the values instead"),
        ("return twice(x)", -8, "twice: is a second function of this name; give each a name of its own"),
        ("return first(x)", -8, "twice: is a second function of this name; give each a name of its own"),
    ],
)
def test_what_has_no_translation_is_refused_with_its_line(lines, line, advice, tmp_path, monkeypatch):
    with pytest.raises(NotTranslatable) as error:
        kernel_of(lines, tmp_path, monkeypatch)(1.0, 2, np.ones((2, 3)))
    kernel = "" if line < -1 else "kernel: "  # elsewhere the advice begins with the name
    assert f".py:{FIRST + line}: {kernel}" in str(error.value)
    assert advice in str(error.value)
    assert "\n" not in str(error.value)
    assert "''" not in str(error.value)


def test_an_argument_without_a_name_cannot_be_assigned_to(tmp_path, monkeypatch):
    with pytest.raises(NotTranslatable, match="_ keeps no value; give the argument a name"):
        kernel_of("_ = 2.0\nreturn _", tmp_path, monkeypatch, "def kernel(_):")(1.0)
    assert kernel_of("return _ + 1.0", tmp_path, monkeypatch, "def kernel(_):")(1.0) == 2.0


@pytest.mark.parametrize(
    ("arguments", "advice"),
    [
        ((1.0, 2**63, np.ones(2)), "9223372036854775808 is beyond the 64 bits that integers have in kernels"),
        ((1.0, -(2**63) - 1, np.ones(2)), "is beyond the 64 bits"),
        ((1.0, 2, np.array(3.0)), "is an array without dimensions, which kernels do not take; give the number"),
        ((1.0, 2, "text"), "'text' is not allowed in kernels"),
        ((1.0, 2), "compiled it takes 3 arguments, was given 2"),
    ],
)
@pytest.mark.parametrize("again", [False, True])
def test_arguments_that_kernels_do_not_take_are_refused(arguments, advice, again, tmp_path, monkeypatch):
    kernel = kernel_of("return x", tmp_path, monkeypatch)
    if again:
        kernel(1.0, 2, np.ones(2))
        advice = advice.replace("9223372036854775808 is", "[9223372036854775808] are").partition(" that integers")[0]
        advice = advice.replace("is beyond the", "beyond the")
    with pytest.raises(TypeError) as error:
        kernel(*arguments)
    assert f".py:{FIRST - 1}: kernel: " in str(error.value)
    assert advice in str(error.value)


def test_a_class_that_makes_something_else_of_its_fields_is_no_kind(tmp_path, monkeypatch):
    doubling = kernel_of("return x", tmp_path, monkeypatch).py_func.__globals__["Doubling"]
    with pytest.raises(
        NotTranslatable, match="is of a class with a __new__ of its own; kernels take plain named tuples"
    ):
        type_of(doubling(1.0))


def test_an_array_that_was_not_given_cannot_come_back(tmp_path, monkeypatch):
    kernel = kernel_of("return t[0]", tmp_path, monkeypatch)
    with pytest.raises(TypeError, match=rf":{FIRST - 1}: kernel: gives back an array that is no argument; return its"):
        kernel(1.0, 2, np.ones((2, 3)))


def test_the_least_integer_can_be_written_and_is_no_index_from_the_start(tmp_path, monkeypatch):
    assert kernel_of("return -9223372036854775808", tmp_path, monkeypatch)(1.0, 2, np.ones(2)) == -(2**63)
    quotient = kernel_of("return abs(n) // 3", tmp_path, monkeypatch)
    assert quotient(1.0, -(2**63), np.ones(2)) == -(2**63) // 3
    assert quotient(1.0, -7, np.ones(2)) == 2


@pytest.mark.parametrize(
    ("x", "expected"), [(math.nan, 0), (1e300, 2**63 - 1), (-math.inf, -(2**63)), (-3.7, -3), (2.0**62, 2**62)]
)
def test_integers_of_real_numbers_are_the_nearest_that_there_are(x, expected, tmp_path, monkeypatch):
    assert kernel_of("return int(x)", tmp_path, monkeypatch)(x, 2, np.ones(2)) == expected
    rounded = kernel_of("return math.floor(x), math.ceil(x)", tmp_path, monkeypatch)(x, 2, np.ones(2))
    assert rounded == (math.floor(x), math.ceil(x)) if abs(x) < 1e18 else rounded == (expected, expected)


@pytest.mark.parametrize(
    "lines",
    [
        "if x > 0.0:\n    y = x\nelse:\n    y = -x\nreturn y",
        "if x > 0.0:\n    y = x\nelse:\n    return -1.0\nreturn y",
        "if x <= 0.0:\n    return -1.0\nelif n > 1:\n    y = 2.0\nelse:\n    y = 3.0\nreturn y",
        "if COUNT == 3:\n    y = x\nreturn y",
        "if x > 0.0:\n    y = x\ny = 2.0\nreturn y",
        "if x > 0.0:\n    y = x\n    x = y + 1.0\nreturn x",
        "for i in range(3):\n    y = x + i\nreturn y",
        "for i in range(COUNT - 1, -1, -1):\n    y = x + i\nreturn y",
        "for i in range(3):\n    y = x\n    if i == n:\n        break\n    x += 1.0\nreturn y",
        "for i in range(3):\n    y = x\n    if i == n:\n        continue\n    x += 1.0\nreturn y",
        "while True:\n    x += 1.0\n    y = 2.0 * x\n    if x > 9.0:\n        break\nreturn y",
        "while True:\n    x = x * 0.5\n    if x < 1.0:\n        return x",
        "while False:\n    x += 1.0\nreturn x",
        "for i in range(n):\n    y = x\n    x += y\nreturn x",
        "for i in range(3):\n    if x > i:\n        y = x\n        continue\n    return 0.0\nreturn y",
        "y = Point(x, x)\nreturn LEVEL if is_far(y) else LEVEL + 1.0",
        "y = 0.0\nfor i in range(n):\n    y = x\nreturn y",
        "while x > 1.0:\n    x *= 0.5\nreturn (x, x)[n % 2]",
        "if x > 0.0:\n    return x, 2.0\nreturn 1, x",
        "y = risen(t) and not (t[0, 0] > 9.0 and risen(t))\nreturn x if y else -x",
        "y = -1.0 < x < 2.0 and n > 1\nz = x if y or n < 0 else 2.0\nreturn (x, z)[n % 2]",
    ],
)
def test_a_variable_with_a_value_on_every_way_is_read(lines, tmp_path, monkeypatch):
    kernel = kernel_of(lines, tmp_path, monkeypatch)
    for x, n in ((1.5, 2), (-0.5, 0), (30.0, 7)):
        assert kernel(x, n, np.ones((2, 3))) == kernel.py_func(x, n, np.ones((2, 3)))

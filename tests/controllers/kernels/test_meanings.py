"""Names and arguments in kernels mean what they mean in Python, and machine code on disk holds for these alone."""

import math
import sys

import numpy as np
import pytest
from exports import printed
from kernels_from_text import compiling, from_text

from controllers.kernels.language import NotTranslatable
from controllers.kernels.record import meaning

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
import settings
from controllers.compiled import compiled
from kernels import kernel, TABLE, Own
from others import other
exec(sys.argv[2])
print(compiled(kernel)(Own(2.0)))
"""

KERNELS = """
from typing import NamedTuple
import settings
from settings import LEVEL, Mode
from controllers.kernels.language import dispatched

class Own(NamedTuple):
    number: float

def _chosen(own):
    return own.number

TABLE = {Own: _chosen}

def _choose(own):
    return TABLE[type(own)](own)

choose = dispatched(TABLE, _choose)

def level(own, factor=1.0):
    return factor * LEVEL * own.number

def kernel(own):
    return level(own) + Mode.A * settings.OFFSET + 1000.0 * choose(own)
"""

SETTINGS = """
import os
from enum import IntEnum
LEVEL = float(os.environ["LEVEL"])
OFFSET = float(os.environ["OFFSET"])
class Mode(IntEnum):
    A = int(os.environ["MODE"])
"""

OTHERS = "def other(own):\n    return 7.0\n"


def test_machine_code_on_disk_holds_for_what_its_names_stood_for(tmp_path):
    for name, text in (("kernels", KERNELS), ("settings", SETTINGS), ("others", OTHERS)):
        (tmp_path / f"{name}.py").write_text(text)
    first = {"LEVEL": "3.0", "OFFSET": "0.5", "MODE": "2"}
    found = []
    for changed, before in [
        ({}, ""),
        ({"LEVEL": "4.0"}, ""),
        ({"OFFSET": "0.25"}, ""),
        ({"MODE": "20"}, ""),
        ({}, "TABLE[Own] = other"),
        ({}, "import kernels; kernels.level = other"),
        ({}, "import kernels; kernels.level.__defaults__ = (10.0,)"),
        ({}, ""),
    ]:
        known = compiling(tmp_path / "cache", **{**first, **changed})
        found.append(float(printed(sys.executable, "-c", SCRIPT, tmp_path, before, env=known)))
    assert found == [2007.0, 2009.0, 2006.5, 2016.0, 7007.0, 2008.0, 2061.0, 2007.0]


HELPED = """
import sys
sys.path[:0] = sys.argv[1:]
from controllers.compiled import compiled
from helped import kernel
print(compiled(kernel)(2.0))
"""


def test_a_function_of_the_same_name_in_another_file_is_another_one(tmp_path):
    (tmp_path / "helped.py").write_text("from helper import help\n\ndef kernel(x):\n    return help(x)\n")
    found = []
    for factor in (3.0, 5.0, 3.0):
        folder = tmp_path / f"times_{factor}"
        folder.mkdir(exist_ok=True)
        (folder / "helper.py").write_text(f"def help(x):\n    return {factor} * x\n")
        known = compiling(tmp_path / "cache")
        found.append(float(printed(sys.executable, "-c", HELPED, tmp_path, folder, env=known)))
    assert found == [6.0, 10.0, 6.0]


def test_a_function_of_a_library_is_the_same_wherever_that_is_installed():
    assert "site-packages" not in meaning({"np": np}, "np.isfinite")


LEAST = -(2**63)


def both(text, arguments, tmp_path, monkeypatch):
    """What a kernel gives as Python and as machine code, and what is in its arrays afterwards."""
    kernel = from_text(text, tmp_path, monkeypatch)
    found = []
    for function in (kernel.py_func, kernel):
        given = tuple(np.copy(each) if isinstance(each, np.ndarray) else each for each in arguments)
        found.append((function(*given), [each.tolist() for each in given if isinstance(each, np.ndarray)]))
    return found


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("def kernel(a, b):\n    return a < b, a > b, a <= b, a >= b\n", (True, False)),
        ("def kernel(a, b):\n    return a < b, a > b, a <= b, a >= b\n", (False, True)),
        ("import math\ndef kernel(n):\n    return math.floor(n), math.ceil(n)\n", (2**53 + 1,)),
        ("import math\ndef kernel(n):\n    return math.fabs(n), abs(n)\n", (-(2**53) - 1,)),
        ("def kernel(n, m):\n    return n % m\n", (LEAST, -1)),
        (
            "def kernel(row, a, b):\n    s, e = 0.0, (a, b)\n"
            "    for i in range(2):\n        s += row[i]\n    for i in range(*e):\n        s += row[i]\n    return s\n",
            (np.arange(4.0), -2, 0),
        ),
        ("from math import pi, sin\ndef kernel(x):\n    return pi * sin(x)\n", (0.5,)),
        ("from enum import Enum\nclass M(int, Enum):\n    A = 3\nQ = M.A\n"
         "def g(n, m=Q):\n    return n + m\ndef kernel(n):\n    return g(n)\n", (1,)),
        ("from typing import NamedTuple\nclass P(NamedTuple):\n    x: float\n    n: int\n    y: float\n"
         "def moved(p):\n    return p._replace(x=p.y, y=p.x)\n"
         "def kernel(a, b):\n    p = moved(P(a, 2, b))\n    p = p._replace(n=p.n + 1)\n"
         "    q = moved(p)._replace(x=1)\n    return p.x, p.n, p.y, q.x, q.n, q.y\n", (0.5, 1.5)),
        *(("COUNT = 3\ndef kernel(x, y):\n    if x > 5.0:\n        y = 1.0\n    elif COUNT == 3:\n"
           "        if x > 1.0:\n            y = 2.0\n        y = y + 10.0\n    return y\n", (x, 0.5))
          for x in (0.0, 2.0, 6.0)),
        *(("from controllers.kernels.language import natural\n"
           "def kernel(t, i, x):\n    return t[1, natural(i) if x > 0.0 else 0]\n",
           (np.arange(12.0).reshape(3, 4), 3, x)) for x in (-1.0, 1.0)),
    ],
)  # fmt: skip
def test_machine_code_does_what_python_does(text, arguments, tmp_path, monkeypatch):
    expected, found = both(text, arguments, tmp_path, monkeypatch)
    assert found == expected


def test_the_largest_quotient_of_integers_wraps_and_does_not_end_the_process(tmp_path, monkeypatch):
    kernel = from_text("def kernel(n, m):\n    return n // m\n", tmp_path, monkeypatch)
    assert kernel(LEAST, -1) == LEAST


def test_powers_have_the_bits_that_python_gives(tmp_path, monkeypatch):
    text = "def kernel(x):\n    return abs(x) ** 0.5, 2.0 ** x, 8.0 ** x, 10.0 ** x\n"
    kernel = from_text(text, tmp_path, monkeypatch)
    numbers = np.random.default_rng(1).uniform(-30.0, 30.0, 500).tolist()
    assert [kernel(x) for x in numbers] == [kernel.py_func(x) for x in numbers]
    assert kernel(-math.inf) == kernel.py_func(-math.inf)


def test_another_range_is_no_range(tmp_path, monkeypatch):
    text = "def range(n):\n    return (7,)\n\ndef kernel(n):\n    for i in range(n):\n        n += i\n    return n\n"
    with pytest.raises(NotTranslatable, match="write for i in range"):
        from_text(text, tmp_path, monkeypatch)(3)


def test_a_wrong_number_of_arguments_is_said(tmp_path, monkeypatch):
    kernel = from_text("def kernel(x, y=2.0):\n    return x * y\n", tmp_path, monkeypatch)
    with pytest.raises(TypeError, match="takes 2 arguments, was given 1"):
        kernel(1.0)


def test_relative_imports_of_constants_are_followed(tmp_path, monkeypatch):
    package = tmp_path / "small_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "levels.py").write_text("LEVEL = 2.5\n")
    (package / "kernels.py").write_text("from .levels import LEVEL\n\ndef kernel(x):\n    return LEVEL * x\n")
    kernel = from_text("from small_package.kernels import kernel\n", tmp_path, monkeypatch)
    assert kernel(2.0) == 5.0


def test_a_kernel_may_call_one_of_the_same_name_in_another_module(tmp_path, monkeypatch):
    (tmp_path / "same_names.py").write_text("def kernel(x):\n    return 3.0 * x\n")
    text = "import same_names\n\ndef kernel(x):\n    return 1.0 + same_names.kernel(x)\n"
    assert from_text(text, tmp_path, monkeypatch)(2.0) == 7.0

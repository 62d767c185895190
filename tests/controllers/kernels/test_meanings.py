"""Machine code on disk is loaded only while the global names in its kernels stand for what they stood for."""

import sys

import numpy as np
from exports import printed
from kernels_from_text import compiling

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

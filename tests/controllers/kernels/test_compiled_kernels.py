"""Compiled kernels on disk: made by two processes at once, and not at all where there is no compiler."""

import os
import subprocess
import sys

import numpy as np
import pytest

from controllers import Inputs, Output
from controllers.kernels.language import call
from controllers.native import TORQUE, CalledBack

SCRIPT = """
import sys, warnings
sys.path.insert(0, sys.argv[1])
from kernels import kernel
from controllers import PI, compiled
warnings.simplefilter("always")
print(compiled(kernel)(3.0), PI(100.0, 0.0, 0.01).step(0.5, 0.1))
"""


def running(tmp_path, **variables):
    known = {**os.environ, "ADAPTIVE_FF_CACHE": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
    line = [sys.executable, "-c", SCRIPT, str(tmp_path)]
    return subprocess.Popen(line, env={**known, **variables}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.fixture
def kernels(tmp_path):
    (tmp_path / "kernels.py").write_text("def kernel(x):\n    return 2.0 * x\n")
    return tmp_path


def test_two_processes_may_compile_the_same_at_once(kernels):
    both = [running(kernels) for _ in range(2)]
    found = [each.communicate() for each in both]
    assert [out for out, _ in found] == ["6.0 40.0\n"] * 2, found
    assert list((kernels / "cache").rglob("*.part")) == []


def test_without_a_compiler_kernels_run_as_python_and_one_line_says_so(kernels):
    out, errors = running(kernels, CC="no-such-compiler").communicate()
    assert out == "6.0 40.0\n"
    assert errors.count("pip install ziglang") == 1


def test_a_step_in_python_is_called_back_and_its_error_is_raised_behind_the_loop():
    seen = []

    def step(inputs):
        seen.append(inputs)
        if len(seen) == 2:
            raise ZeroDivisionError("in the second sample")
        return Output(3.0, 1.0)

    called = CalledBack(step, None)
    exchange = called.block.exchange
    exchange[:TORQUE] = np.arange(TORQUE)
    torques = []
    for _ in range(3):
        call(called.block.step, 0, 0, exchange)
        torques.append(exchange[TORQUE])
    assert torques == [3.0, 0.0, 0.0]
    assert seen[0] == Inputs(*np.arange(float(TORQUE)))
    assert len(seen) == 2
    with pytest.raises(ZeroDivisionError, match="in the second sample"):
        called.check()

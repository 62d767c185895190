"""Exported controllers for tests: one of each kind and variant, and what is needed to compile and to run them."""

import itertools
import shutil
import subprocess
from functools import partial

import numpy as np
import pytest
from closed_loops import SCENARIO, make

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.export.sample import made_up_inputs
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, WITH_GRAVITY, WITH_OFFSET
from benchmarks.export.project import zig
from controllers import Inputs, pi_gains

DELAYED = SCENARIO.modified(actuator={"delay": 0.015}, feedback={"bandwidth": 3.0})
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-pedantic", "-Werror")
SIZES = {"symmetric": ESTIMATED, "offset": WITH_OFFSET, "gravity": WITH_GRAVITY, "directions": PER_DIRECTION}

made = make
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc on this machine")


def adaptive(parameters=ESTIMATED, delay=0.0, velocity_lag=0.0, period=0.01, **further):
    """Make an adaptive controller of a variant, for a joint of 20 kg m^2 in a loop of 10 Hz."""
    known = {"inertia": 20.0, "stribeck_velocity": 0.05, "torque_limit": np.inf}
    variant = {**known, "parameters": parameters, "delay": delay, "velocity_lag": velocity_lag, **further}
    return AdaptiveController(*pi_gains(20.0, 10.0), period, **variant)


adaptive_with_map = partial(adaptive, WITH_OFFSET, position_periods=[0.3], position_hats=9, load_friction=True)
"""One that learns friction over position and load."""
adaptive_with_ripples = partial(adaptive, WITH_GRAVITY, ripple_periods=[0.02, 0.3])
"""One that learns gravity, and ripples of two periods."""


def adaptive_variants():
    """Variants of the adaptive controller by name, as functions that make one: all sizes of all arrays and tuples."""
    grid = itertools.product(SIZES, ((0.0, 0.0), (1.5, 0.004)))
    return {"map": adaptive_with_map, "ripples": adaptive_with_ripples} | {
        f"{size} delay={delay} lag={lag}": partial(adaptive, SIZES[size], delay, lag) for size, (delay, lag) in grid
    }


def steps_in_python(controller, rows):
    """Step a controller in plain Python over rows of inputs; return torque and feedforward of each."""
    controller.run_uncompiled()
    return np.array([controller.step_plain(Inputs(*row.tolist())) for row in rows])


def steps_in_c(runner, rows):
    """Step a controller in C over the same; the checks of ``step`` are left out, so that all inputs may be missing."""
    return np.array([runner.step_in_c(*row.tolist()) for row in rows])


def inputs(controller, samples=160):
    """Rows of inputs with jitter, lost samples and missing previews; other ones than the export records."""
    return made_up_inputs(controller.period, samples, seed=102)


def compiled(folder, sources, *flags, program="gcc", out="a.out"):
    """Compile sources in a folder; return the program, or fail with what the compiler says.

    Where there is no clang, that of zig, which is clang.
    """
    instead = zig() if program == "clang" and shutil.which(program) is None else None
    line = [*(instead or [program]), "-std=c99", *flags, *sources, "-o", out, "-lm"]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return folder / out


def printed(*command, **where):
    """Run a program that must end well, ``where`` with ``cwd`` and ``env``; return what it prints."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, **where)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    return done.stdout

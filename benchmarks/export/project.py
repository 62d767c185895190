"""Exported projects of controllers, compiled and run: on this machine, under emulation, for processors of drives."""

import itertools
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from adaptive_ff import AdaptiveController, export_controller, load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, WITH_GRAVITY, WITH_OFFSET
from controllers import PI

SIZES = {"symmetric": ESTIMATED, "offset": WITH_OFFSET, "gravity": WITH_GRAVITY, "directions": PER_DIRECTION}
STRICT = ("-std=c99", "-ffp-contract=off")


def adaptive(size: str, delay: float = 0.0, velocity_lag: float = 0.0) -> AdaptiveController:
    """Make an adaptive controller for the built-in joint."""
    design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    given = {"parameters": SIZES[size], "delay": delay, "velocity_lag": velocity_lag}
    known: dict[str, Any] = {"inertia": 20.0, "stribeck_velocity": 0.05, **given}
    return AdaptiveController(design.proportional, design.integral, 0.01, **known)


def variants() -> dict[str, Callable[[], Any]]:
    """Return functions that make a controller of each kind that compare knows, and all variants of the adaptive one."""
    prompt = load_scenario()
    delayed = prompt.modified(actuator={"delay": 0.015}, feedback={"bandwidth": 3.0})
    found: dict[str, Callable[[], Any]] = {}
    kinds = set()
    for scenario, word in ((prompt, ""), (delayed, ", delay 1.5")):
        for name, maker in CONTROLLERS.items():
            kind = (type(maker(scenario)), type(maker(scenario).parameters), word)
            if name != "adaptive" and kind not in kinds:
                kinds.add(kind)
                found[f"{name}{word}"] = partial(maker, scenario)
    for size, delay, lag in itertools.product(SIZES, (0.0, 1.5), (0.0, 0.004)):
        found[f"adaptive, {size}, delay {delay}, velocity lag {lag}"] = partial(adaptive, size, delay, lag)
    return found


def zig() -> list[str] | None:
    """Return the command of the cross compiler from the package index; none where it is not installed."""
    return [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") else None


@contextmanager
def exported(controller: Any, *, single: bool = False) -> Iterator[Path]:
    """Give the folder of an exported project, whose names begin with ``drive``."""
    with tempfile.TemporaryDirectory() as folder:
        export_controller(controller, folder, prefix="drive", single=single)
        yield Path(folder)


def run(folder: Path, *command: str) -> str:
    """Run a command in a folder and return what it prints; where it fails, what it says is the error."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    if done.returncode:
        raise ArithmeticError(f"{' '.join(command[:3])}: {(done.stderr + done.stdout)[:300]}")
    return done.stdout


def difference(folder: Path, command: Sequence[str], emulator: Sequence[str] = ()) -> float:
    """Return the largest difference of the self-test to the recorded run, over its largest torque."""
    run(folder, *command, *STRICT, "drive.c", "drive_selftest.c", "-o", "selftest", "-lm")
    return float(re.findall(r"difference (\S+)", run(folder, *emulator, "./selftest"))[0])

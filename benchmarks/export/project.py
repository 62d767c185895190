"""Exported projects of controllers, compiled and run: on this machine, under emulation, for processors of drives."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from adaptive_ff import Scenario, export_controller, load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS, make_controller
from adaptive_ff.friction.model import IDENTIFIED

STRICT = ("-std=c99", "-ffp-contract=off")
PROMPT = load_scenario()
LATE = PROMPT.modified(actuator={"delay": 0.015}, feedback={"bandwidth": 3.0})


def adaptive(scenario: Scenario, identify: str) -> Any:
    """Make an adaptive controller that identifies so many parameters."""
    return make_controller(scenario.modified(adaptation={"identify": identify}), "adaptive")


def variants() -> dict[str, Callable[[], Any]]:
    """Return functions that make each controller that compare knows, and the adaptive one of all sizes."""
    sizes = {f"adaptive, {size}": partial(adaptive, PROMPT, size) for size in IDENTIFIED}
    late = {f"{name}, late": partial(maker, LATE) for name, maker in CONTROLLERS.items()}
    return {**sizes, **late, "adaptive, directions, late": partial(adaptive, LATE, "directions")}


def zig() -> list[str] | None:
    """Return the command of the cross compiler from the package index; none where it is not installed."""
    return [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") else None


@contextmanager
def exported(controller: Any, *, single: bool = False) -> Iterator[Path]:
    """Give the folder of an exported project, whose names begin with ``drive``."""
    with tempfile.TemporaryDirectory() as folder:
        export_controller(controller, folder, prefix="drive", single=single)
        yield Path(folder)


def announced(what: str, names: Iterable[str]) -> Iterator[str]:
    """Yield names, and print each with its place before: what follows takes seconds."""
    listed = list(names)
    for place, name in enumerate(listed, 1):
        print(f"{what}: {name} ({place} of {len(listed)})", file=sys.stderr, flush=True)
        yield name


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

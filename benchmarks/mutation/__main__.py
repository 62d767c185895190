"""``python -m benchmarks.mutation``: how many small faults of the kernels the tests notice.

Every kernel of the estimator, its regression, the tuning of the lag, the detection of changes, the feedforward, the PI
loop and the joint's step is mutated, see ``operators``; a sample of the mutants is drawn. Kernels run as plain Python.
Each mutant is put into a fork of a process that has collected the tests, where those that call the kernel run, the
quickest first, until one fails.
"""

import importlib
import os
import time
from pathlib import Path
from types import FunctionType
from typing import Annotated
from unittest.mock import patch

# before numpy is loaded; a fork must not find threads waited for that it does not have
os.environ |= {"ADAPTIVE_FF_COMPILE": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import numpy as np
import pytest
import typer
from hypothesis import Phase, settings

from adaptive_ff.comparison.registry import CONTROLLERS
from benchmarks.mutation.equivalent import EQUIVALENT
from benchmarks.mutation.operators import Mutant, mutants
from benchmarks.mutation.session import Mutation

ROOT = Path(__file__).resolve().parent.parent.parent

ROOMS = ("adaptive_ff/friction", "adaptive_ff/learning", "adaptive_ff/adaptive", "controllers/pi.py", "plant/step.py")
"""Where the kernels are that are mutated."""

TESTS = (
    *("adaptive_ff/friction", "adaptive_ff/learning", "adaptive_ff/adaptive", "controllers/test_pi.py"),
    *("plant/test_step.py", "plant/test_directions.py", "plant/test_changes.py"),
)
"""Their tests; those that call a mutated kernel are found out by calling them."""

LINE_UP = ("pi", "oracle", "adaptive")
"""Controllers that the tests find; others are identified or tuned in many runs before they are made."""

CLOSED_LOOP = (
    "after_a_change",
    "forgotten_at_a_change",
    "without_a_change",
    "lag_that_is_not_tuned",
    "tuned_lag",
    "than_the_true_lag",
    "switched_off",
    "plain_python_equals",
    "slides_one_way",
    "joint_that_reverses",
    "without_the_gate",
    "gate_needs_its_hold",
    "vanishes_with_the_period",
    "for_an_hour",
    "breaks_away",
)
"""Parts of the names of tests that run whole closed loops, which in plain Python takes seconds."""

OPTIONS = ("-n", "0", "-q", "-p", "no:cacheprovider", "--assert=plain", "--hypothesis-profile", "mutation")
OPTIONS += ("-k", f"not ({' or '.join(CLOSED_LOOP)})")

MARK = "@register_jitable"
"""Decorator of a kernel."""

PHASES = (Phase.explicit, Phase.generate)
"""What hypothesis does; a failure need not be made small here."""


def modules(rooms: tuple[str, ...] = ROOMS) -> list[str]:
    """Return the full names of the modules of rooms that have kernels."""
    files = [
        file for room in rooms for file in ([ROOT / room] if room.endswith(".py") else (ROOT / room).rglob("*.py"))
    ]
    chosen = [file for file in files if f"\n{MARK}" in file.read_text(encoding="utf-8")]
    return sorted(".".join(file.relative_to(ROOT).with_suffix("").parts) for file in chosen)


def kernels() -> dict[str, FunctionType]:
    """Return the kernels that are mutated, by their full names."""
    found = {}
    for name in modules():
        module = importlib.import_module(name)
        source = Path(str(module.__file__)).read_text().splitlines()
        for function in vars(module).values():
            if not isinstance(function, FunctionType) or function.__module__ != name:
                continue
            if source[function.__code__.co_firstlineno - 1].startswith(MARK):
                found[f"{name}.{function.__name__}"] = function
    return found


def drawn(found: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """Return a sample of mutants, in the order in which they are drawn: a run that is cut short is a smaller sample."""
    return [found[place] for place in np.random.default_rng(seed).permutation(len(found))[:count]]


def main(
    count: Annotated[int, typer.Option(min=1, help="Number of mutants that are drawn.")] = 400,
    seed: Annotated[int, typer.Option(help="Seed of the draw.")] = 1,
    only: Annotated[str, typer.Option(help="Part of the names of the kernels.")] = "",
    timing: Annotated[bool, typer.Option(help="Print how long each test takes.")] = False,
) -> None:
    """Print which mutants survive."""
    start = time.monotonic()
    functions = kernels()
    everything = [mutant for name, function in functions.items() if only in name for mutant in mutants(function)]
    alive = [mutant for mutant in everything if mutant.key not in EQUIVALENT]
    sample = drawn(alive, count, seed)
    progress = os.dup(2)  # pytest captures the other, and forks close it
    run = Mutation(functions, sample, lambda line: os.write(progress, f"{line}\n".encode()))
    settings.register_profile("mutation", deadline=None, derandomize=True, database=None, phases=PHASES)
    files = [str(ROOT / "tests" / name) for name in TESTS]
    with patch.dict(CONTROLLERS, {name: CONTROLLERS[name] for name in LINE_UP}, clear=True):
        status = pytest.main([*OPTIONS, *files], [run])
    if status != pytest.ExitCode.OK:
        raise typer.Exit(1)
    if timing:
        for name, one in sorted(run.noted.items(), key=lambda pair: pair[1].seconds):
            print(f"{one.seconds:8.3f} {'' if one.passed else 'left out'} {len(one.kernels)} {name}")
    for key, reason in EQUIVALENT.items():
        print(f"equivalent: {key[0]}: {key[1]}  ->  {key[2]}: {reason}")
    for place, mutant in enumerate(sample):
        if place not in run.killed:
            print(f"survives: {mutant.module}.{mutant.function}:{mutant.line}: {mutant.before}  ->  {mutant.after}")
    share = len(run.killed) / max(1, len(sample))
    print(
        f"{len(run.killed)} of {len(sample)} mutants killed ({100.0 * share:.1f} %); drawn with seed {seed} from "
        f"{len(alive)} in {len(functions)} kernels, {len(EQUIVALENT)} equivalent ones left out; "
        f"{time.monotonic() - start:.0f} s"
    )


if __name__ == "__main__":
    typer.run(main)

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
"""What is mutated."""

TESTS = (
    *("adaptive_ff/friction", "adaptive_ff/learning", "adaptive_ff/adaptive", "controllers/test_pi.py"),
    *("plant/test_step.py", "plant/test_directions.py", "plant/test_changes.py"),
)
"""Their tests; those that call a mutated function are found out by calling them."""

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

PHASES = (Phase.explicit, Phase.generate)
"""What hypothesis does; a failure need not be made small here."""


def functions(rooms: tuple[str, ...] = ROOMS) -> dict[str, FunctionType]:
    """Return the functions of rooms, kernels among them, by their full names."""
    places, found = [ROOT / room for room in rooms], {}
    files = [file for place in places for file in ([place] if place.is_file() else place.rglob("*.py"))]
    for name in sorted(".".join(file.relative_to(ROOT).with_suffix("").parts) for file in files):
        if not name.endswith("__init__"):
            listed = vars(importlib.import_module(name)).values()
            own = [one for one in listed if isinstance(one, FunctionType) and one.__module__ == name]
            found |= {f"{name}.{function.__name__}": function for function in own}
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
    found = functions()
    everything = [mutant for name, function in found.items() if only in name for mutant in mutants(function)]
    alive = [mutant for mutant in everything if mutant.key not in EQUIVALENT]
    sample = drawn(alive, count, seed)
    progress = os.dup(2)  # pytest captures the other, and forks close it
    run = Mutation(found, sample, lambda line: os.write(progress, f"{line}\n".encode()))
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
        f"{len(alive)} in {len(found)} functions, {len(EQUIVALENT)} equivalent ones left out; "
        f"{time.monotonic() - start:.0f} s"
    )


if __name__ == "__main__":
    typer.run(main)

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

MUTATED = (
    "adaptive_ff.adaptive.learning.estimator",
    "adaptive_ff.adaptive.learning.prediction",
    "adaptive_ff.learning.filters",
    "adaptive_ff.regression.known_loads",
    "adaptive_ff.learning.sliding_gate",
    "adaptive_ff.learning.torque_form",
    "adaptive_ff.adaptive.learning.lag_tuning",
    "adaptive_ff.adaptive.learning.change_detection",
    "adaptive_ff.friction.feedforward",
    "adaptive_ff.adaptive.supervision.acquittal",
    "adaptive_ff.adaptive.supervision.balance",
    "adaptive_ff.adaptive.supervision.circumstances",
    "adaptive_ff.adaptive.supervision.colour",
    "adaptive_ff.adaptive.command",
    "adaptive_ff.adaptive.faults.counts",
    "adaptive_ff.adaptive.faults.doubt",
    "adaptive_ff.adaptive.faults.drive_limit",
    "adaptive_ff.adaptive.faults.foresight",
    "adaptive_ff.adaptive.learning.forgetting",
    "adaptive_ff.adaptive.learning.friction_guess",
    "adaptive_ff.adaptive.at_rest.held_friction",
    "adaptive_ff.adaptive.faults.held_integral",
    "adaptive_ff.model.loop_response",
    "adaptive_ff.adaptive.supervision.noise_level",
    "adaptive_ff.adaptive.supervision.observer",
    "adaptive_ff.adaptive.supervision.observer_effect",
    "adaptive_ff.adaptive.supervision.observer_gates",
    "adaptive_ff.adaptive.supervision.observer_hand_over",
    "adaptive_ff.adaptive.supervision.one_way",
    "adaptive_ff.adaptive.at_rest.outer_loop",
    "adaptive_ff.adaptive.faults.proven_torque",
    "adaptive_ff.adaptive.supervision.ringing",
    "adaptive_ff.adaptive.supervision.swift_ringing",
    "adaptive_ff.adaptive.faults.rising_resistance",
    "adaptive_ff.adaptive.faults.seen_velocity",
    "adaptive_ff.adaptive.supervision.trust",
    "adaptive_ff.adaptive.learning.unexplained",
    "adaptive_ff.adaptive.watching",
    "adaptive_ff.adaptive.fed_shares",
    "adaptive_ff.adaptive.sensing",
    "adaptive_ff.adaptive.at_rest.wound_integral",
    "adaptive_ff.adaptive.setting_out",
    "adaptive_ff.adaptive.share_out",
    "adaptive_ff.adaptive.supervised_step",
    "controllers.pi",
    "plant.step",
)

TESTS = (
    "adaptive_ff/adaptive/learning/test_estimator_by_hand.py",
    "adaptive_ff/adaptive/learning/test_estimator_kernels.py",
    "adaptive_ff/adaptive/learning/test_attribution_by_hand.py",
    "adaptive_ff/adaptive/learning/test_change_detection.py",
    "adaptive_ff/adaptive/learning/test_friction_map.py",
    "adaptive_ff/adaptive/learning/test_lag_tuning.py",
    "adaptive_ff/adaptive/supervision/test_acquittal.py",
    "adaptive_ff/adaptive/supervision/test_balance.py",
    "adaptive_ff/adaptive/supervision/test_colour.py",
    "adaptive_ff/adaptive/faults/test_counts.py",
    "adaptive_ff/adaptive/faults/test_doubt.py",
    "adaptive_ff/adaptive/faults/test_drive_limit.py",
    "adaptive_ff/adaptive/faults/test_foresight.py",
    "adaptive_ff/adaptive/at_rest/test_held_friction.py",
    "adaptive_ff/adaptive/faults/test_held_integral.py",
    "adaptive_ff/adaptive/supervision/test_noise_level.py",
    "adaptive_ff/adaptive/supervision/test_observer.py",
    "adaptive_ff/adaptive/supervision/test_observer_effect.py",
    "adaptive_ff/adaptive/supervision/test_observer_gates.py",
    "adaptive_ff/adaptive/supervision/test_one_way.py",
    "adaptive_ff/adaptive/at_rest/test_outer_loop.py",
    "adaptive_ff/adaptive/supervision/test_ringing.py",
    "adaptive_ff/adaptive/supervision/test_swift_ringing.py",
    "adaptive_ff/adaptive/faults/test_rising_resistance.py",
    "adaptive_ff/adaptive/faults/test_seen_velocity.py",
    "adaptive_ff/adaptive/at_rest/test_wound_integral.py",
    "adaptive_ff/adaptive/test_supervised_step.py",
    "adaptive_ff/adaptive/supervision/test_trust.py",
    "adaptive_ff/friction",
    "adaptive_ff/learning",
    "adaptive_ff/regression",
    "controllers/test_pi.py",
    "plant/test_step.py",
    "plant/test_directions.py",
    "plant/test_changes.py",
)
"""Tests of these kernels; those that call a mutated one are found out by calling them."""

LINE_UP = ("pi", "oracle", "adaptive_unsupervised", "adaptive")
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


def kernels(modules: tuple[str, ...] = MUTATED) -> dict[str, FunctionType]:
    """Return the kernels of modules by their full names."""
    found = {}
    for name in modules:
        module = importlib.import_module(name)
        source = Path(str(module.__file__)).read_text().splitlines()
        for function in vars(module).values():
            if not isinstance(function, FunctionType) or function.__module__ != name:
                continue
            if source[function.__code__.co_firstlineno - 1].startswith("@register_jitable"):
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

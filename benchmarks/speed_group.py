"""A step of a group over the number of its joints, beside the same joints stepped one by one from Python."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import AdaptiveController, JointGroup, load_scenario
from adaptive_ff.comparison.registry import make_controller
from benchmarks.speed_rows import Row
from benchmarks.speed_steps import CLOCK, Call, recorded_samples

JOINTS = (1, 2, 6, 12, 24)
"""Numbers of joints that are measured."""

APART = 97
"""Samples by which a joint is ahead of the one before, so that the joints of a group are at different places."""

Samples = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Reference, next reference and measured velocity, shape (samples, n) each."""


def group_steps(calls: int, numbers: Sequence[int] = JOINTS) -> list[Row]:
    """Measure steps of groups of independent joints, in turn with single steps of as many joints, and fit ``a + b n``.

    Parameters
    ----------
    calls : int
        Steps of each group that are timed.
    numbers : sequence of int
        Numbers of joints, two at least.
    """
    jobs: list[Call] = []
    for count in numbers:
        samples = samples_of(count)
        jobs += [step_together(joints_of(count), samples), step_one_by_one(joints_of(count), samples)]
    for job in jobs:
        job(0)  # compiles, or loads
    times = np.array([[job(k) for job in jobs] for k in range(1, calls + 1)])
    together, single = times[:, ::2], times[:, 1::2]
    medians, alone = np.median(together, axis=0), np.median(single, axis=0)
    ratios = np.median(together / single, axis=0)
    rows = [
        Row(f"group of {count} joints", "single steps", float(ours), float(theirs), float(ratio))
        for count, ours, theirs, ratio in zip(numbers, medians, alone, ratios, strict=True)
    ]
    return rows + fitted_rows(numbers, medians, float(alone[0] / numbers[0]))


def fitted_rows(numbers: Sequence[int], medians: NDArray[np.float64], single: float) -> list[Row]:
    """Return ``a`` and ``b`` of ``a + b n``, fitted to medians (s) in shares of each, beside a single step (s)."""
    slope, start = np.polyfit(numbers, medians, 1, w=1.0 / medians).tolist()
    off = float(np.max(np.abs((start + slope * np.asarray(numbers)) / medians - 1.0)))
    return [
        Row("a of a + b n joints", "single step", start, single, start / single),
        Row(f"b, a joint more; fit within {100.0 * off:.0f} %", "single step", slope, single, slope / single),
    ]


def joints_of(count: int) -> dict[str, AdaptiveController]:
    """Return so many adaptive controllers of the built-in scenario by name."""
    scenario = load_scenario()
    made = {f"joint_{place}": make_controller(scenario, "adaptive") for place in range(count)}
    return {name: one for name, one in made.items() if isinstance(one, AdaptiveController)}


def samples_of(count: int) -> Samples:
    """Return the samples of the built-in scenario for so many joints, each ahead of the one before."""
    reference, following, measured = (
        np.column_stack([np.roll(series, -APART * place) for place in range(count)]) for series in recorded_samples()
    )
    return reference, following, measured


def step_together(joints: dict[str, AdaptiveController], samples: Samples) -> Call:
    """Return what steps joints as one group."""
    group = JointGroup(joints)
    torques: NDArray[np.float64] | None = None

    def call(k: int) -> float:
        nonlocal torques
        now, coming, velocity = (series[k % len(series)] for series in samples)
        begin = CLOCK()
        torques = group.step(now, velocity, next_reference=coming, realised_torque=torques)
        return (CLOCK() - begin) * 1e-9

    return call


def step_one_by_one(joints: dict[str, AdaptiveController], samples: Samples) -> Call:
    """Return what steps joints one after the other from Python, with numbers, as somebody without a group would."""
    steps: list[Callable[..., float]] = [controller.step for controller in joints.values()]
    series = [list(zip(*(signal[:, place].tolist() for signal in samples), strict=True)) for place in range(len(steps))]
    torques: list[float | None] = [None] * len(steps)

    def call(k: int) -> float:
        nonlocal torques
        rows = [of_joint[k % len(of_joint)] for of_joint in series]
        begin = CLOCK()
        torques = [
            step(now, velocity, next_reference=coming, realised_torque=torque)
            for step, (now, coming, velocity), torque in zip(steps, rows, torques, strict=True)
        ]
        return (CLOCK() - begin) * 1e-9

    return call

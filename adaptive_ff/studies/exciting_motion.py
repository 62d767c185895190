"""The exciting motion of a scenario: limits from the drive, several candidates, the best of them in simulation."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS
from adaptive_ff.comparison.registry import loop_of
from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError
from adaptive_ff.learning.batch import identify_torque_form
from adaptive_ff.scenario.plausibility import PEAK_FACTOR, USED_FRACTION
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.excitation import LEAST_HARMONICS, find_excitations, polished
from adaptive_ff.studies.information import (
    GATE_FRACTION,
    NAMES,
    Array,
    AssumedJoint,
    information,
    interval_sizes,
)
from adaptive_ff.studies.motion import Excitation, MotionLimits

FASTER = 4.0
"""Default limit of the velocity over the default peak of a multisine; less where the torque limit asks for it."""

FASTEST, BANDWIDTH_FRACTION = 4.0, 0.4
"""Largest frequency of the series, Hz, and its largest fraction of the bandwidth of the loop."""

SLOWER = (1.0, 0.5, 0.25)
"""Fractions of that frequency that are tried: what the loop follows badly carries less information."""

POLE_FRACTION, HOLD_TIMES = 0.5, 3.0
"""Pole of the filters of identification over the crossover, and its hold in their time constants."""

TRIAL_SEEDS = tuple(range(101, 107))
"""Seeds of noise of a trial; nothing is reported on them."""

YARDSTICK = 60.0
"""Length of the multisine that intervals are measured by, s."""

GRID = 0.02
"""Step of the grid on which the information of that multisine is found, s."""


def assumed_joint(scenario: Scenario) -> AssumedJoint:
    """Return what a scenario assumes of its joint.

    Inertia and Stribeck velocity are those of ``[feedback]`` and ``[adaptation]``; friction is that of ``[fixed]``, or
    of the joint where there is no such table.
    """
    fixed, joint = scenario.fixed, scenario.joint
    known = fixed if fixed.coulomb > 0.0 else joint
    stiction = known.stiction if known.stiction is not None else known.coulomb
    proportional = scenario.feedback.gains[0]
    return AssumedJoint(
        scenario.feedback.inertia,
        known.coulomb,
        max(stiction, joint.stiction / joint.coulomb * known.coulomb if joint.coulomb > 0.0 else 0.0),
        known.viscous,
        scenario.adaptation.stribeck_velocity,
        HOLD_TIMES * scenario.feedback.inertia / (POLE_FRACTION * proportional),
        scenario.adaptation.stribeck_shape,
    )


def default_limits(scenario: Scenario, **given: float | None) -> MotionLimits:
    """Return the limits of a motion: those that are given, and what suits the scenario for the others.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    **given
        ``position``, ``velocity``, ``acceleration`` or ``torque``, or None. By default the torque is 0.7 of the drive's
        limit, and the velocity four times the default peak of a multisine, 28 Stribeck velocities.

    Raises
    ------
    InputError
        The torque limit leaves nothing for a motion.
    """
    joint, limit = assumed_joint(scenario), scenario.actuator.torque_limit
    torque = given.get("torque")
    if torque is None and limit is not None:
        torque = USED_FRACTION * limit
    if torque is not None and not torque > joint.stiction:
        raise InputError(
            f"torque = {torque:g} N m is not allowed: it must be more than the stiction, {joint.stiction:g} N m"
        )
    velocity = given.get("velocity")
    if velocity is None:
        velocity = FASTER * PEAK_FACTOR * joint.stribeck_velocity
        if torque is not None and joint.viscous > 0.0:
            velocity = min(velocity, (torque - joint.stiction) / joint.viscous)
    return MotionLimits(velocity, given.get("position"), given.get("acceleration"), torque)


def interval_widths(scenario: Scenario, seeds: Sequence[int]) -> dict[str, float]:
    """Return the widths of the 95 % intervals that the reference of a scenario gives, the median over seeds.

    The PI loop follows the reference; the torque form is identified from measured velocity and torque of the drive,
    with the assumed Stribeck velocity, see :func:`adaptive_ff.learning.batch.identify_torque_form`.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with its bandwidth.
    seeds : sequence of int
        Seeds of noise and reference.

    Returns
    -------
    dict of float
        Width by name; infinite where nothing can be identified.
    """
    found = [_widths(scenario.modified(seed=seed)) for seed in seeds]
    return {name: float(np.median([one[name] for one in found])) for name in NAMES}


def _widths(scenario: Scenario) -> dict[str, float]:
    assumed, run = scenario.adaptation, simulate(scenario, "pi")
    pole = POLE_FRACTION * scenario.feedback.gains[0] / scenario.feedback.inertia
    try:
        found = identify_torque_form(
            run.time,
            run.measured,
            np.roll(run.torque, 1),
            stribeck_velocity=assumed.stribeck_velocity,
            stribeck_shape=assumed.stribeck_shape,
            filter_pole=pole,
            slowest=GATE_FRACTION * assumed.stribeck_velocity,
            hold=HOLD_TIMES / pole,
        )
    except ValueError:
        return dict.fromkeys(NAMES, math.inf)
    return {name: found.physical[name].upper - found.physical[name].lower for name in NAMES}


def with_motion(scenario: Scenario, reference: dict[str, Any], duration: float) -> Scenario:
    """Return a scenario with another reference and duration (s), and no changes of the joint."""
    content = scenario.model_dump(exclude_unset=True)
    return Scenario.model_validate({**content, "reference": reference, "duration": duration, "change": []})


def yardstick(scenario: Scenario) -> Scenario:
    """Return the scenario with a minute of the built-in multisine, its peak by default the one that suits the joint."""
    return with_motion(scenario, Multisine().model_dump(exclude_unset=True) | {"kind": "multisine"}, YARDSTICK)


def exciting_motion(
    scenario: Scenario,
    limits: MotionLimits,
    *,
    period: float = 10.0,
    fastest: float | None = None,
    seed: int = 0,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> Excitation:
    """Find the exciting motion of a scenario.

    Candidates are found by the information that they have and tried in simulation, for one period and for two; the one
    whose largest interval is the least there, each over that of a minute of multisine, is improved by trials of what is
    near it. Seeds of the simulation are those that nothing is reported on.

    Parameters
    ----------
    scenario : Scenario
        The scenario; its own reference plays no part.
    limits : MotionLimits
        What the motion must keep, see :func:`default_limits`.
    period : float, optional
        Length of the motion, s.
    fastest : float, optional
        Largest frequency, Hz; by default 4 Hz, or 0.4 of the bandwidth of the loop. Half and a quarter of it are
        tried, too.
    seed : int, optional
        Seed of the search.
    workers : int, optional
        Number of processes; None for one a core.
    progress : callable, optional
        Is called with the fraction done, from 0 to 1.

    Returns
    -------
    Excitation
        The motion; its ``sizes`` are those of the simulation.

    Raises
    ------
    InputError
        A limit or an argument is out of range.
    """
    loop = loop_of(scenario, "pi")
    joint, measured_by = assumed_joint(loop), yardstick(loop)
    if fastest is None:
        bandwidth = loop.feedback.gains[0] / (2.0 * math.pi * loop.feedback.inertia)
        fastest = min(FASTEST, BANDWIDTH_FRACTION * bandwidth)
    every = max(1, round(GRID / loop.joint.solver_period))
    plans = np.stack([measured_by.modified(seed=one).reference_velocity()[::every] for one in TUNING_SEEDS])
    measure: Array = interval_sizes(np.mean(information(joint, plans, every * loop.joint.solver_period), axis=0))
    base = interval_widths(measured_by, TRIAL_SEEDS)
    trial = partial(_trial, loop, base, period)
    found: list[Excitation] = []
    fractions = [fraction for fraction in SLOWER if fraction == 1.0 or fraction * fastest * period >= LEAST_HARMONICS]
    parts = len(fractions) + 1
    for i, fraction in enumerate(fractions):
        found += find_excitations(
            joint,
            limits,
            measure,
            period=period,
            fastest=fraction * fastest,
            seed=seed,
            trial=trial,
            workers=workers,
            progress=_part_of(progress, i, parts),
        )
    best = min(found, key=lambda motion: motion.widest)
    return polished(joint, limits, best, trial, seed=seed, progress=_part_of(progress, parts - 1, parts))


def _trial(loop: Scenario, base: dict[str, float], period: float, motion: Excitation) -> dict[str, float]:
    """Return the widths of the intervals that a motion of a period (s) gives, each over that of the yardstick."""
    table = motion.reference.model_dump()
    once, twice = (interval_widths(with_motion(loop, table, times * period), TRIAL_SEEDS) for times in (1, 2))
    # a joint that sticks between two periods may give less in a longer log: such a motion is not repeated
    return {name: max(once[name], twice[name]) / base[name] for name in NAMES}


def _part_of(progress: Callable[[float], None] | None, part: int, parts: int) -> Callable[[float], None] | None:
    """Return the progress of one of some parts, or None where nobody looks."""
    return None if progress is None else lambda done: progress((part + done) / parts)

"""The exciting motion of a scenario: a Fourier series within limits, found by information, the best in simulation.

The parametrisation is that of J. Swevers, C. Ganseman, D. Tuekel, J. De Schutter, H. Van Brussel, "Optimal robot
excitation and identification" (IEEE Transactions on Robotics and Automation 13, 1997): finite Fourier series. Their
criterion, the determinant of the information matrix, may give up one parameter for others. Here the largest interval is
made as small as possible, each over the one that a minute of multisine gives.

Information is that of a motion which is followed exactly and of noise that is white. What a trial of the motion gives
differs, most for the lag; so the search is repeated with each interval measured by what the last trial gave.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS
from adaptive_ff.comparison.registry import loop_of
from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError, check_positive
from adaptive_ff.learning.batch import identify_torque_form
from adaptive_ff.scenario.plausibility import PEAK_FACTOR, USED_FRACTION
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.motion import (
    GATE_FRACTION,
    NAMES,
    Array,
    AssumedJoint,
    Excitation,
    MotionLimits,
    MotionSearch,
    information,
    interval_sizes,
)
from adaptive_ff.studies.study import Found, run_study
from adaptive_ff.workers import part_of_progress

Trial = Callable[[Excitation], dict[str, float]]  # the intervals of a motion over what each is measured by
FASTER = 4.0  # default limit of the velocity over the default peak of a multisine; the torque limit may ask for less
FASTEST, BANDWIDTH_FRACTION = 4.0, 0.4  # largest frequency of the series, Hz, and over the bandwidth of the loop
SLOWER = (1.0, 0.5, 0.25)  # fractions of it that are tried: what the loop follows badly carries less information
POLE_FRACTION, HOLD_TIMES = 0.5, 3.0  # pole of identification's filters over the crossover, its hold in their times
TRIAL_SEEDS = tuple(range(101, 107))  # seeds of noise of a trial; nothing is reported on them
YARDSTICK, GRID = 60.0, 0.02  # length of the multisine to measure by, and step of the grid for its information, s
STARTS, ROUNDS, SEED = 6, 8, 0  # starts of the search, trials of each, and the seed of both
BELIEF, LARGEST_RATIO = 0.6, 4.5  # power of the ratio of trial and information for the next round, and its largest size
POLISHING, FIRST_STEP = 150, 0.1  # random steps from the best motion, and length of the first over the direction
LEAST_HARMONICS, MOST_HARMONICS = 3, 60  # least and most harmonics of a series


def assumed_joint(scenario: Scenario) -> AssumedJoint:
    """Return what a scenario assumes of its joint: friction by ``[fixed]``, or the joint's where there is none."""
    fixed, joint = scenario.fixed, scenario.joint
    known = fixed if fixed.coulomb > 0.0 else joint
    stiction = known.stiction if known.stiction is not None else known.coulomb
    return AssumedJoint(
        scenario.feedback.inertia,
        known.coulomb,
        max(stiction, joint.stiction / joint.coulomb * known.coulomb if joint.coulomb > 0.0 else 0.0),
        known.viscous,
        scenario.adaptation.stribeck_velocity,
        HOLD_TIMES * scenario.feedback.inertia / (POLE_FRACTION * scenario.feedback.gains[0]),
        scenario.adaptation.stribeck_shape,
    )


def default_limits(scenario: Scenario, **given: float | None) -> MotionLimits:
    """Return the limits of a motion: those that are given, and what suits the scenario for the others.

    By default the torque is 0.7 of the drive's limit, the velocity four times the default peak of a multisine.
    """
    joint, limit = assumed_joint(scenario), scenario.actuator.torque_limit
    velocity, torque = given.get("velocity"), given.get("torque")
    if torque is None and limit is not None:
        torque = USED_FRACTION * limit
    _check_torque(joint, torque)
    if velocity is None:
        velocity = FASTER * PEAK_FACTOR * joint.stribeck_velocity
        if torque is not None and joint.viscous > 0.0:
            velocity = min(velocity, (torque - joint.stiction) / joint.viscous)
    return MotionLimits(velocity, given.get("position"), given.get("acceleration"), torque)


def _check_torque(joint: AssumedJoint, torque: float | None) -> None:
    if torque is not None and not torque > joint.stiction:
        raise InputError(
            f"torque = {torque:g} N m is not allowed: it must be more than the stiction, {joint.stiction:g} N m"
        )


def interval_widths(scenario: Scenario, seeds: Sequence[int]) -> dict[str, float]:
    """Return the widths of the 95 % intervals that the reference of a scenario gives, by name, the median over seeds.

    The torque form is identified from measured velocity and torque of the PI loop, with the assumed Stribeck velocity.
    A width is infinite where nothing can be identified.
    """
    found = np.array([_widths(scenario.modified(seed=seed)) for seed in seeds])
    return dict(zip(NAMES, np.median(found, axis=0).tolist(), strict=True))


def _widths(scenario: Scenario) -> list[float]:
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
        return [math.inf] * len(NAMES)
    return [found.physical[name].upper - found.physical[name].lower for name in NAMES]


def with_motion(scenario: Scenario, reference: dict[str, Any], duration: float) -> Scenario:
    """Return a scenario with another reference and duration (s), and no changes of the joint."""
    return scenario.replaced(reference=reference, duration=duration, change=[])


def yardstick(scenario: Scenario) -> Scenario:
    """Return the scenario with a minute of the built-in multisine, its peak by default the one that suits the joint."""
    return with_motion(scenario, Multisine().model_dump(exclude_unset=True) | {"kind": "multisine"}, YARDSTICK)


def exciting_motion(
    scenario: Scenario,
    limits: MotionLimits,
    *,
    period: float = 10.0,
    fastest: float | None = None,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> Excitation:
    """Find the exciting motion of a scenario, whose ``sizes`` are those of the simulation; its reference plays no part.

    Candidates of a length (``period``, s) are found by the information that they have and tried in simulation, for one
    period and for two; the one whose largest interval is the least there, each over that of a minute of multisine, is
    improved by trials of what is near it. The largest frequency (``fastest``, Hz) is by default 4 Hz, or 0.4 of the
    bandwidth of the loop; half and a quarter of it are tried, too.
    """
    loop = loop_of(scenario, "pi")
    joint, measured_by = assumed_joint(loop), yardstick(loop)
    if fastest is None:
        fastest = min(FASTEST, BANDWIDTH_FRACTION * (loop.feedback.gains[0] / (2.0 * math.pi * loop.feedback.inertia)))
    every = max(1, round(GRID / loop.joint.solver_period))
    plans = np.stack([measured_by.modified(seed=one).reference_velocity()[::every] for one in TUNING_SEEDS])
    measure: Array = interval_sizes(np.mean(information(joint, plans, every * loop.joint.solver_period), axis=0))
    trial = partial(_trial, loop, interval_widths(measured_by, TRIAL_SEEDS), period)
    fractions = [fraction for fraction in SLOWER if fraction == 1.0 or fraction * fastest * period >= LEAST_HARMONICS]
    tried, parts = [fraction * fastest for fraction in fractions], len(fractions) + 1
    searching = part_of_progress(progress, 0, parts, len(fractions))
    options: dict[str, Any] = {"period": period, "fastest": tried, "workers": workers, "progress": searching}
    found = find_excitations(joint, limits, measure, trial=trial, **options)
    best = min(found, key=lambda motion: motion.widest)
    return polished(joint, best, trial, progress=part_of_progress(progress, parts - 1, parts))


def _trial(loop: Scenario, base: dict[str, float], period: float, motion: Excitation) -> dict[str, float]:
    """Return the widths of the intervals that a motion of a period (s) gives, each over that of the yardstick."""
    table = motion.reference.model_dump()
    once, twice = (interval_widths(with_motion(loop, table, times * period), TRIAL_SEEDS) for times in (1, 2))
    # a joint that sticks between two periods may give less in a longer log: such a motion is not repeated
    return {name: max(once[name], twice[name]) / base[name] for name in NAMES}


def find_excitations(
    joint: AssumedJoint,
    limits: MotionLimits,
    measure: Array,
    *,
    period: float = 10.0,
    fastest: Sequence[float] = (2.0,),
    starts: int = STARTS,
    rounds: int = ROUNDS,
    trial: Trial | None = None,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Excitation]:
    """Find motions that identify the parameters of a joint, for each largest frequency (Hz) the best from each start.

    A start is searched from in some rounds, with a trial after each, in one where there is no trial; every other start
    dwells at the speeds that have the most information. Sizes are those of the trial, by default by information, over
    ``measure``, shape (5,).
    """
    searches = [MotionSearch(joint, limits, period, _check(joint, limits, period, hertz)) for hertz in fastest]
    cases = {f"{search.harmonics}, {turn}": (search, turn) for search in searches for turn in range(starts)}
    function = partial(_from_start, measure, rounds if trial is not None else 1, trial)
    found = run_study(function, cases, ["motion"], workers=workers, progress=progress)
    return [one["motion"] for one in found.values()]


def _from_start(
    measure: Array, rounds: int, trial: Trial | None, case: tuple[MotionSearch, int], names: list[str]
) -> Found:
    """Return the best motion of some rounds from one start of the search."""
    search, turn = case
    generator = np.random.default_rng([SEED, turn])
    direction = search.plateau_start(generator) if turn % 2 == 0 else search.random_start(generator)
    tried, calibrated = [], measure
    for _ in range(rounds):
        direction = search.search(direction, calibrated)
        motion = search.motion(direction, measure)
        if trial is not None:
            expected, motion = motion, replace(motion, sizes=trial(motion))
            calibrated = _calibrated(calibrated, measure, expected, motion)
        tried.append(motion)
    return dict.fromkeys(names, min(tried, key=lambda one: one.widest))


def polished(
    joint: AssumedJoint,
    motion: Excitation,
    trial: Trial,
    *,
    trials: int = POLISHING,
    progress: Callable[[float], None] | None = None,
) -> Excitation:
    """Return the best of a motion and of random steps from the best one so far, by trials alone.

    Steps become longer by half after one that is better, else shorter by a tenth, which balances where one in five is
    better (the one fifth rule of I. Rechenberg, 1973).
    """
    search = MotionSearch(joint, motion.limits, motion.reference.period, len(motion.reference.sines))
    generator = np.random.default_rng([SEED, trials])
    best, direction, length = motion, search.direction(motion), FIRST_STEP
    for i in range(trials):
        step = generator.standard_normal(direction.size) * length / math.sqrt(direction.size)
        near = search.motion(direction + step, np.ones(len(NAMES)))
        near = replace(near, sizes=trial(near))
        better = near.widest < best.widest
        if better:
            best, direction = near, search.direction(near)
        length *= 1.5 if better else 0.9
        if progress is not None:
            progress((i + 1) / trials)
    return best


def _calibrated(calibrated: Array, measure: Array, expected: Excitation, tried: Excitation) -> Array:
    """Return by what the intervals of the next search are measured, from what they were and what the trial gave."""
    before, now = (np.array([motion.sizes[name] for name in NAMES]) for motion in (expected, tried))
    ratio = now / (before * measure / calibrated)
    ratio = np.nan_to_num(ratio, nan=1.0, posinf=np.inf)  # unknown where the multisine does not determine it, either
    believed = np.clip(ratio, 1.0 / LARGEST_RATIO, LARGEST_RATIO) ** BELIEF
    return np.asarray(calibrated / believed)


def _check(joint: AssumedJoint, limits: MotionLimits, period: float, fastest: float) -> int:
    """Return the number of harmonics, or refuse."""
    given = {**vars(limits), "period": period, "fastest": fastest}
    check_positive(**{name: value for name, value in given.items() if value is not None})
    _check_torque(joint, limits.torque)
    harmonics = math.floor(fastest * period + 1e-9)
    if not LEAST_HARMONICS <= harmonics <= MOST_HARMONICS:
        raise InputError(
            f"period = {period:g} s and fastest = {fastest:g} Hz make {harmonics} harmonics; there must be from "
            f"{LEAST_HARMONICS} to {MOST_HARMONICS}"
        )
    return harmonics

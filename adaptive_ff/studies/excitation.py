"""A motion from which the parameters of a joint are identified: a Fourier series within limits, by ``scipy.optimize``.

The parametrisation is that of J. Swevers, C. Ganseman, D. Tuekel, J. De Schutter, H. Van Brussel, "Optimal robot
excitation and identification" (IEEE Transactions on Robotics and Automation 13, 1997): finite Fourier series, so that
the motion is smooth, periodic and known exactly. Their criterion, the determinant of the information matrix, is the
sum of all (logarithmic) intervals and may give up one parameter for others. Here the largest interval is made as small
as possible, each over the one that a minute of multisine gives; so none is given up.

Information is that of a motion which is followed exactly and of noise that is white. What a trial of the motion gives
differs, most for the lag; so the search is repeated with each interval measured by what the last trial gave.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.studies.information import NAMES, Array, AssumedJoint
from adaptive_ff.studies.motion import Excitation, MotionLimits
from adaptive_ff.studies.motion_search import MotionSearch
from adaptive_ff.studies.study import Found, run_study

STARTS, ROUNDS = 6, 8
"""Starts of the search, and trials of each."""

BELIEF = 0.6
"""Fraction of the (logarithmic) ratio of trial and information that the next round takes over."""

LARGEST_RATIO = 4.5
"""Largest ratio, either way, that one trial is believed."""

POLISHING, FIRST_STEP = 150, 0.1
"""Trials of random steps from the best motion, and the length of the first over that of the direction."""

LEAST_HARMONICS, MOST_HARMONICS = 3, 60
"""Least and most harmonics of a series."""


def find_excitations(
    joint: AssumedJoint,
    limits: MotionLimits,
    measure: Array,
    *,
    period: float = 10.0,
    fastest: float = 2.0,
    seed: int = 0,
    starts: int = STARTS,
    rounds: int = ROUNDS,
    trial: Callable[[Excitation], dict[str, float]] | None = None,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Excitation]:
    """Find motions that identify the parameters of a joint, the best one from each start of the search.

    Parameters
    ----------
    joint : AssumedJoint
        What is assumed of the joint; a factor of two wrong is fine.
    limits : MotionLimits
        What the motion must keep.
    measure : ndarray, shape (5,)
        Sizes of the intervals that the motion's are measured by, see ``information.interval_sizes``.
    period : float, optional
        Length of the motion, s; it begins and ends at rest and in the same place.
    fastest : float, optional
        Largest frequency of the series, Hz.
    seed : int, optional
        Seed of the starts.
    starts : int, optional
        Number of starts; every other one dwells at the speeds that have the most information.
    rounds : int, optional
        Searches from each start, with a trial after each; one where there is no trial.
    trial : callable, optional
        Returns the intervals that a motion gives by parameter, each over what it is measured by; the motions returned
        have them as ``sizes``. By default ``sizes`` are those by information.
    workers : int, optional
        Number of processes that search from the starts; None for one a core, for which the trial must be picklable.
    progress : callable, optional
        Is called with the fraction done, from 0 to 1.

    Raises
    ------
    InputError
        A limit or an argument is out of range.
    """
    search = MotionSearch(joint, limits, period, _check(joint, limits, period, fastest))
    found = run_study(
        partial(_from_start, search, measure, rounds if trial is not None else 1, trial, seed),
        {str(turn): turn for turn in range(starts)},
        ["motion"],
        workers=workers,
        progress=progress,
    )
    return [one["motion"] for one in found.values()]


def _from_start(
    search: MotionSearch,
    measure: Array,
    rounds: int,
    trial: Callable[[Excitation], dict[str, float]] | None,
    seed: int,
    turn: int,
    names: list[str],
) -> Found:
    """Return the best motion of some rounds from one start of the search."""
    generator = np.random.default_rng([seed, turn])
    direction = search.plateau_start(generator) if turn % 2 == 0 else search.random_start(generator)
    tried, calibrated = [], measure
    for _ in range(rounds):
        direction = search.search(direction, calibrated)
        motion = search.motion(direction, measure)
        if trial is not None:
            expected = np.array([motion.sizes[name] for name in NAMES])
            motion = motion.with_sizes(trial(motion))
            calibrated = _calibrated(calibrated, measure, expected, motion)
        tried.append(motion)
    return dict.fromkeys(names, min(tried, key=lambda one: one.widest))


def polished(
    joint: AssumedJoint,
    limits: MotionLimits,
    motion: Excitation,
    trial: Callable[[Excitation], dict[str, float]],
    *,
    trials: int = POLISHING,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Excitation:
    """Return the best of a motion and of random steps from it, each from the best one so far, by trials alone.

    Steps become longer by half after one that is better and shorter by a tenth after one that is not, which balances
    where one in five is better (the one fifth rule of I. Rechenberg, 1973).
    """
    search = MotionSearch(joint, limits, motion.reference.period, len(motion.reference.sines))
    generator = np.random.default_rng([seed, trials])
    best, direction, length = motion, search.direction(motion), FIRST_STEP
    for i in range(trials):
        step = generator.standard_normal(direction.size) * length / math.sqrt(direction.size)
        near = search.motion(direction + step, np.ones(len(NAMES)))
        near = near.with_sizes(trial(near))
        better = near.widest < best.widest
        if better:
            best, direction = near, search.direction(near)
        length *= 1.5 if better else 0.9
        if progress is not None:
            progress((i + 1) / trials)
    return best


def _calibrated(calibrated: Array, measure: Array, expected: Array, tried: Excitation) -> Array:
    """Return by what the intervals of the next search are measured, from what they were and what the trial gave."""
    ratio = np.array([tried.sizes[name] for name in NAMES]) / (expected * measure / calibrated)
    ratio = np.nan_to_num(ratio, nan=1.0, posinf=np.inf)  # unknown where the multisine does not determine it, either
    believed = np.clip(ratio, 1.0 / LARGEST_RATIO, LARGEST_RATIO) ** BELIEF
    return np.asarray(calibrated / believed)


def _check(joint: AssumedJoint, limits: MotionLimits, period: float, fastest: float) -> int:
    """Return the number of harmonics, or refuse."""
    given = {**vars(limits), "period": period, "fastest": fastest}
    for name, value in given.items():
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value} is not allowed: it must be positive and finite")
    if limits.torque is not None and limits.torque <= joint.stiction:
        raise InputError(
            f"torque = {limits.torque:g} N m is not allowed: it must be more than the stiction, {joint.stiction:g} N m"
        )
    harmonics = math.floor(fastest * period + 1e-9)
    if not LEAST_HARMONICS <= harmonics <= MOST_HARMONICS:
        raise InputError(
            f"period = {period:g} s and fastest = {fastest:g} Hz make {harmonics} harmonics; there must be from "
            f"{LEAST_HARMONICS} to {MOST_HARMONICS}"
        )
    return harmonics

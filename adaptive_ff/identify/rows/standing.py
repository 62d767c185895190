"""Where a joint stands: at rest, and for a moment while it reverses.

Friction holds there what the torque happens to be, which no model of sliding says. Rows beside a rest are of motion,
but the filters of the band carry into them what is beside: a torque of three times the friction that was regressed,
since a sign of a velocity of zero is none. So the equation is multiplied, before it is filtered, by one where the joint
moves and by zero where it stands, on both sides: it holds again, in every band. Without it inertia of joints that
stick came out up to 86 % too large, with intervals of a tenth of that, and a friction without lag lagged by 10 to
20 ms. At the edges of a motion the wide filter, behind which the sign of the velocity is taken, still smears; so a
motion begins a little later and ends a little earlier, and standing has the sign of the motion next to it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.identify.rows.path_lag import Bending
from adaptive_ff.identify.terms import SATURATIONS, SQUARE_STICTION, STICTION
from adaptive_ff.logs.defects import runs
from adaptive_ff.logs.derivatives import Array

REST_SHARE = 0.005
"""Speed below which the joint counts as resting, over its largest."""

REST_CYCLES = 1.0
"""Cycles of the band for which it must be slower than that, creeping or not."""

STOP_CYCLES, STOP_SIGNS = 0.1, 3
"""The same for a joint that stands for a moment: its measured velocity changes the sign not once but so often.

What sticks at each reversal, for as long as the torque takes to turn, has no sign of velocity there. Taken for a quick
reversal it shows a negative lag and too much stiction: of a joint of ``adaptive-ff new`` 2.61 N m for 2.5, and a
Stribeck velocity of 0.077 for 0.12 rad/s. That is so where friction jumps, with stiction or without. A joint whose
friction rises from standstill on creeps there instead, which tells of its friction: without it a model of half of the
record of the TX40's joint 4 leaves 0.75 N m for 0.57.
"""

DWELL = 1.5
"""Time for which a joint that reverses is slow, over that of its accelerations on both sides, from which on it stands.

A stop that is too short for the filter to let the sign change more than once still shows so. With such stops taken for
quick reversals, inertia came out 0.6 % too large, with a tenth of that as interval, and friction led by 3 ms.
"""

LOBE_CYCLES = 1.0
"""Cycles of the band beside a rest within which the filter may overshoot, the other way than the motion there."""

QUICK = 3.0
"""Speed over that of rest from which on a reversal is one of the motion, not of noise."""

INTO_MOTION = 0.5
"""Cycles of the wide filter at the begin and the end of a motion which count as standing."""

STRIBECK_GRID, SQUARE_GRID, SATURATION_GRID = 16, 19, 8
"""Speeds for which the columns of both shapes of stiction and of saturation are made; between them they are
interpolated. The second shape, which only intervals are taken over, goes up to the largest speed: with a Stribeck
velocity of a third of it friction falls over the whole motion, which looks like less viscous and more Coulomb
friction."""

SMEARED = 0.05
"""Slowest speed at which friction may saturate, over the largest: below, noise around a reversal, which smears the sign
of the velocity, looks the same."""

TINY = 1e-300
"""A velocity that is none, but has a sign, rad/s."""


class Rest(NamedTuple):
    """What counts as rest, and the grids of speeds that go with it.

    Attributes
    ----------
    slowest : float
        Speed below which the joint may rest, rad/s.
    speeds : dict of ndarray, shape (k,)
        Speeds of the bend of stiction and of saturation, rad/s, by term, in geometric order.
    corner : float
        Corner of the wide filter, behind which the sign of the velocity is taken, Hz.
    sticks : bool
        Whether a joint that stands for less than a cycle of the band, as while it reverses, counts as resting.
    dwells : bool
        Whether it counts as standing, too, where it is slow for longer than its accelerations say, or goes on the same
        way. A joint that creeps does the same, so it is set only where no model whose friction rises from standstill
        fits the log better.
    bending : Bending or None
        Over which path friction follows; None where it jumps.
    """

    slowest: float
    speeds: dict[str, Array]
    corner: float
    sticks: bool = False
    dwells: bool = False
    bending: Bending | None = None


def find_rest(velocities: list[Array], corner: float) -> Rest:
    """Return what counts as rest in a log.

    Parameters
    ----------
    velocities : list of ndarray
        Velocities of the pieces behind the wide filter, rad/s.
    corner : float
        Corner of that filter, Hz.
    """
    largest = max(float(np.max(np.abs(velocity))) for velocity in velocities)
    slowest = REST_SHARE * largest
    speeds = {
        STICTION: np.geomspace(2.0 * slowest, 0.5 * largest, STRIBECK_GRID),
        SQUARE_STICTION: np.geomspace(2.0 * slowest, largest, SQUARE_GRID),
        **{shape: np.geomspace(SMEARED * largest, largest, SATURATION_GRID) for shape in SATURATIONS},
    }
    return Rest(slowest, speeds, corner)


def at_rest(velocity: Array, slowest: float, cycle: float, reach: int | None, *, sticks: bool) -> NDArray[np.bool_]:
    """Return where a joint rests.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Its velocity, rad/s.
    slowest : float
        Speed below which it is slow, rad/s.
    cycle : float
        Samples of a cycle of the band.
    reach : int or None
        Samples over which the accelerations beside a reversal are taken; None where those do not count.
    sticks : bool
        Whether it rests where it stands for less than a cycle, too.
    """
    sign, slow = np.sign(velocity), np.abs(velocity) < slowest
    resting = np.zeros_like(slow)
    for start, stop in runs(slow):
        cycles = REST_CYCLES
        turns = sign[start] != sign[stop - 1]
        if sticks and (turns or reach is not None) and np.count_nonzero(np.diff(sign[start:stop])) >= STOP_SIGNS:
            cycles = STOP_CYCLES
        elif sticks and reach is not None and _dwells(velocity, start, stop, slowest, reach):
            cycles = 0.0
        resting[start:stop] = stop - start >= math.ceil(cycles * cycle)
    return resting


def _dwells(velocity: Array, start: int, stop: int, slowest: float, reach: int) -> bool:
    """Tell whether a joint that reverses is slow for longer than its accelerations on both sides say."""
    if start < reach or stop + reach > velocity.size or velocity[start - 1] * velocity[stop] >= 0.0:
        return False
    ends = np.abs(velocity[[start - reach, start, stop - 1, stop - 1 + reach]])
    braking, starting = (ends[0] - ends[1]) / reach, (ends[3] - ends[2]) / reach
    if min(braking, starting) <= 0.0:
        return False
    return bool(stop - 1 - start > DWELL * (slowest / braking + slowest / starting))


def widened(mask: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return a mask whose runs of true values reach further on both sides."""
    steps = np.zeros(mask.size + 1, dtype=np.int64)
    for start, stop in runs(mask):
        steps[max(0, start - reach)] += 1
        steps[min(mask.size, stop + reach)] -= 1
    return np.cumsum(steps[:-1]) > 0


def standing(resting: NDArray[np.bool_], velocity: Array, rest: Rest, cycle: float, period: float) -> NDArray[np.bool_]:
    """Return where a joint stands as far as its filtered velocity is smeared: from begin to end of a motion.

    Parameters
    ----------
    resting : ndarray of bool, shape (n,)
        Where it rests.
    velocity : ndarray, shape (n,)
        Its velocity behind the wide filter, rad/s.
    rest : Rest
        What counts as rest.
    cycle : float
        Samples of a cycle of the band.
    period : float
        Sample time, s.
    """
    stands, reach, quick = resting.copy(), math.ceil(LOBE_CYCLES * cycle), QUICK * rest.slowest
    for start, stop in runs(resting):
        stands[stop : stop + _lobes(velocity[stop : stop + reach], quick)] = True
        stands[start - _lobes(velocity[max(0, start - reach) : start][::-1], quick) : start] = True
    return widened(stands, math.ceil(INTO_MOTION / (rest.corner * period)))


def _lobes(beside: Array, quick: float) -> int:
    """Return how many samples beside a rest, nearest first, are lobes of the filter: up to the last of another sign."""
    if beside.size == 0:
        return 0
    peak = int(np.argmax(np.minimum(np.abs(beside), quick)))
    against = np.flatnonzero(beside[:peak] * beside[peak] <= 0.0)
    return int(against[-1]) + 1 if against.size else 0


def with_signs_of_motion(velocity: Array, stands: NDArray[np.bool_]) -> Array:
    """Return a velocity (rad/s) that is next to zero where a joint stands, with the sign of the nearest motion."""
    moved = velocity.copy()
    for start, stop in runs(stands):
        ends = [velocity[place] for place in (start - 1, stop) if 0 <= place < velocity.size]
        middle = (start + stop) // 2 if len(ends) == 2 else stop
        moved[start:stop] = 0.0
        if ends:
            moved[start:middle] = math.copysign(TINY, ends[0])
            moved[middle:stop] = math.copysign(TINY, ends[-1])
    return moved


def reversals(velocity: Array, stands: NDArray[np.bool_], rest: Rest) -> int:
    """Return how often a joint reverses without standing in between, from its velocity (rad/s)."""
    quick = np.flatnonzero(np.abs(velocity) > QUICK * rest.slowest)
    turns = velocity[quick[1:]] * velocity[quick[:-1]] < 0.0
    stood = np.cumsum(stands)
    return int(np.count_nonzero(turns & (stood[quick[1:]] == stood[quick[:-1]])))

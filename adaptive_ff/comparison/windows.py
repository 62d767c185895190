"""Never worse than PI, made precise: errors of a controller and of PI in windows of a motion, over draws of the noise.

The error of PI itself scatters by some 10 % from one draw of the measurement noise to another, so a single pair of runs
decides nothing. Both controllers run on the same few draws along the same reference, and what is compared are roots of
the mean squares over all draws:

- the *settled* error, over the last half of the time after the last change, or of the run without one;
- the error in disjoint *windows* of 5 s from the start. The error allowed in a window is a multiple of PI's there, or
  of a share of PI's median window where that is more: where PI has nearly no error, none is to be gained or lost;
- the error of the *start*, the first 5 s of motion, and of the first 5 s after each change.

The error is that of the velocity, and behind a position loop that of the position, which such a loop is there for.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import simulate
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import Course, lay_course
from adaptive_ff.simulation.metrics import START, settled_start
from controllers.arrays import NDArray

WINDOW = 5.0
"""Length of a window, s."""

DRAWS = 5
"""Draws of the noise for each reference."""

SHARE_OF_MEDIAN = 0.15
"""Least error that counts in a window, as a share of PI's median window."""

NOISE_STREAM = 1
"""Stream of random numbers of the sensor's noise; a draw beyond the first adds its number."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """Errors of a controller on a scenario, each the root of the mean square over all draws of the noise.

    They are in rad/s, behind a position loop in rad.

    Attributes
    ----------
    windows : ndarray, shape (windows,)
        In disjoint windows of 5 s; what remains at the end is left out.
    settled : float
        Settled.
    start : float
        In the first 5 s of motion.
    after : tuple of float
        In the first 5 s after each change.
    """

    windows: Array
    settled: float
    start: float
    after: tuple[float, ...]


@dataclass(frozen=True)
class Judgement:
    """A controller against PI on one reference.

    Attributes
    ----------
    base, own : Errors
        Errors of PI and of the controller.
    """

    base: Errors
    own: Errors

    @property
    def settled(self) -> float:
        """Settled error of PI over the controller's: below one the controller is worse."""
        return _over(self.base.settled, self.own.settled)

    @property
    def windows(self) -> Array:
        """Error of the controller in each window over what counts for PI there: above one the controller is worse."""
        counted = np.maximum(self.base.windows, SHARE_OF_MEDIAN * float(np.median(self.base.windows)))
        return np.array([_over(own, base) for own, base in zip(self.own.windows, counted, strict=True)])

    @property
    def worst_window(self) -> float:
        """The largest of :attr:`windows`."""
        return float(np.max(self.windows))

    @property
    def start(self) -> float:
        """Error of the controller at the start over PI's."""
        return _over(self.own.start, self.base.start)

    @property
    def after(self) -> tuple[float, ...]:
        """Error of the controller over PI's in the first 5 s after each change."""
        return tuple(_over(own, base) for own, base in zip(self.own.after, self.base.after, strict=True))


def judge(
    scenario: Scenario, controller: Any = "adaptive", *, draws: int = DRAWS, base: Errors | None = None
) -> Judgement:
    """Compare a controller with PI along the reference of a scenario.

    Parameters
    ----------
    scenario : Scenario
        The scenario; its seed gives the reference and the first draw of the noise.
    controller : str or callable, optional
        Name of a controller, or what makes one for a scenario.
    draws : int, optional
        Draws of the noise; without noise one is enough and all.
    base : Errors, optional
        Errors of PI from :func:`run_errors` with the same draws, where they are known.

    Raises
    ------
    ValueError
        The number of draws is not positive.
    """
    base = run_errors(scenario, BASELINE, draws=draws) if base is None else base
    return Judgement(base, run_errors(scenario, controller, draws=draws))


def judge_chance(scenario: Scenario, *, draws: int = DRAWS) -> Judgement:
    """Compare PI with itself under as many other draws of the noise: what a judgement owes to chance alone.

    The parameters are those of :func:`judge`. Without noise there is one draw, and no chance.
    """
    base = run_errors(scenario, BASELINE, draws=draws)
    noisy = scenario.sensor.is_random
    return Judgement(base, run_errors(scenario, BASELINE, draws=draws, first=draws) if noisy else base)


def run_errors(scenario: Scenario, controller: Any, *, draws: int = DRAWS, first: int = 0) -> Errors:
    """Return the errors of a controller along the reference of a scenario over draws of the noise from a first one on.

    The other parameters are those of :func:`judge`. A controller that does not keep the loop finite has infinite
    errors.
    """
    if draws < 1:
        raise ValueError(f"draws = {draws} is not allowed: it must be at least 1")
    parts, squares = None, []
    for course in noisy_courses(scenario, draws, first):
        parts = _parts(scenario, course.reference) if parts is None else parts
        made = make_controller(scenario, controller) if isinstance(controller, str) else controller(scenario)
        try:
            run = simulate(scenario, made, course=course, uncertain=False)
        except ArithmeticError:
            squares.append(np.full(len(parts), np.inf))
            continue
        error = run.reference - run.velocity if run.position_error is None else run.position_error
        square = np.square(error)
        squares.append(np.array([float(np.mean(square[part])) for part in parts]))
    assert parts is not None
    errors = np.sqrt(np.mean(squares, axis=0))
    changes = len(scenario.change)
    last = errors.size - changes
    return Errors(errors[2:last], float(errors[0]), float(errors[1]), tuple(errors[last:].tolist()))


def noisy_courses(scenario: Scenario, draws: int, first: int = 0) -> Iterator[Course]:
    """Yield the course of a scenario with one draw of the noise after the other; draw 0 is the scenario's own."""
    course = lay_course(scenario)
    if first == 0:
        yield course
    if scenario.sensor.is_random:  # an encoder without faults has nothing to draw
        for draw in range(max(first, 1), first + draws):
            generator = np.random.default_rng([scenario.seed, NOISE_STREAM, draw])
            noise, held = scenario.sensed(generator)
            yield course._replace(noise=noise, held=held)


def window_slices(size: int, period: float) -> list[slice]:
    """Return the windows of a series of a size on a grid of a period (s); a rest at the end is left out."""
    length = round(WINDOW / period)
    if size < length:
        return [slice(0, size)]
    return [slice(first, first + length) for first in range(0, size - length + 1, length)]


def _parts(scenario: Scenario, reference: Array) -> list[slice]:
    """Return the slices of the solver's grid over which errors are wanted: settled, start, windows, after changes."""
    period, size = scenario.joint.solver_period, reference.size

    def index(time: float) -> int:
        return min(size - 1, int(np.ceil(time / period - 1e-6)))

    moving = np.flatnonzero(reference)
    begin = int(moving[0]) if moving.size else 0
    five = round(START / period)
    settled = slice(index(settled_start(scenario.last_change, (size - 1) * period)), None)
    changes = [index(change.time) for change in scenario.change]
    return [
        settled,
        slice(begin, begin + five + 1),
        *window_slices(size, period),
        *(slice(first, first + five) for first in changes),
    ]


def _over(top: float, bottom: float) -> float:
    """Return a ratio of errors; that of two vanishing ones is one, that of two infinite ones infinite."""
    if top == bottom and np.isfinite(top):
        return 1.0
    if np.isinf(bottom):
        return np.inf if np.isinf(top) else 0.0
    return float(top / bottom) if bottom > 0.0 else np.inf

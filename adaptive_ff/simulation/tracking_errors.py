"""Tracking errors of a run in parts of its time, and their ratios to those of PI.

From the error ``e`` of each solver step (of the velocity in rad/s, behind a position loop of the position in rad):

- ``settled = sqrt(mean(e^2))`` over the last half of the time after the last change, or of the run without one;
- ``start``, the same over the first 5 s of motion, and ``after`` over the first 5 s after each change;
- ``windows``, the same in disjoint windows of 5 s; what remains at the end is left out.

Noise makes the error of PI itself scatter by some 10 %, so mean squares are pooled over draws of the noise. In a window
the controller's error is divided by PI's, but PI's is taken at least 0.15 times its median: where PI has nearly no
error none is to be gained or lost.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from adaptive_ff.simulation.metrics import START, first_motion, settled_part, start_part, step_at
from controllers.arrays import NDArray

WINDOW = 5.0
"""Length of a window, s."""

LEAST_OF_MEDIAN = 0.15
"""Least error of PI that counts in a window, over its median window."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrackingErrors:
    """Root mean square errors in parts of a run, rad/s or rad; infinite where a controller failed."""

    # settled, and in the first 5 s of motion
    settled: float
    start: float
    # in each window, and in the first 5 s after each change
    windows: tuple[float, ...]
    after: tuple[float, ...] = ()

    @property
    def series(self) -> tuple[float, ...]:
        """All errors in one sequence."""
        return (self.settled, self.start, *self.windows, *self.after)


def tracking_errors(
    squares: Array, period: float, *, begin: float = 0.0, changes: Sequence[float] = ()
) -> TrackingErrors:
    """Compute the errors of a run from its squared errors on a grid with a period (s), and times of its changes (s)."""
    settled, start, windows, after = error_slices(squares.size, period, begin=begin, changes=changes)

    def rms(part: slice) -> float:
        return math.sqrt(float(np.mean(squares[part])))

    return TrackingErrors(rms(settled), rms(start), tuple(map(rms, windows)), tuple(map(rms, after)))


def error_slices(
    size: int, period: float, *, begin: float = 0.0, changes: Sequence[float] = ()
) -> tuple[slice, slice, list[slice], list[slice]]:
    """Return where the errors of a run of some steps count: settled, in the start, in windows, and after changes."""
    settled = settled_part(size, period, max(changes, default=0.0))
    places = [step_at(size, period, change) for change in changes]
    after = [slice(place, place + round(START / period)) for place in places]
    return settled, start_part(period, step_at(size, period, begin)), window_slices(size, period), after


def first_motion_time(reference: Array, period: float) -> float:
    """Return the time of the first value of a reference that is not zero, s."""
    return first_motion(reference) * period


def window_slices(size: int, period: float) -> list[slice]:
    """Return the windows of a series of a size on a grid of a period (s); a rest at the end is left out."""
    length = round(WINDOW / period)
    if size < length:
        return [slice(0, size)]
    return [slice(first, first + length) for first in range(0, size - length + 1, length)]


def pooled(draws: Iterable[TrackingErrors]) -> TrackingErrors:
    """Return roots of the mean squares over several runs along the same reference."""
    listed = list(draws)
    roots = np.sqrt(np.mean(np.square([one.series for one in listed]), axis=0)).tolist()
    last = 2 + len(listed[0].windows)
    return TrackingErrors(roots[0], roots[1], tuple(roots[2:last]), tuple(roots[last:]))


def failed(alike: TrackingErrors) -> TrackingErrors:
    """Return the errors of a controller that did not keep the loop finite, with the parts of another run."""
    infinite = math.inf
    return TrackingErrors(infinite, infinite, (infinite,) * len(alike.windows), (infinite,) * len(alike.after))


def ratios(base: TrackingErrors, own: TrackingErrors) -> dict[str, float]:
    """Return what a controller's errors are beside those of PI.

    ``settled``: PI's settled error over the controller's, so that more is better; ``window``: the controller's error
    over what counts for PI in the worst window; ``start``: the same in the first 5 s; ``after``: the same after
    changes, the geometric mean over them, where there are any.
    """
    least = LEAST_OF_MEDIAN * float(np.median(base.windows))
    windows = (_over(mine, max(theirs, least)) for mine, theirs in zip(own.windows, base.windows, strict=True))
    found = {"settled": _over(base.settled, own.settled), "window": max(windows), "start": _over(own.start, base.start)}
    if base.after:
        after = [_over(mine, theirs) for mine, theirs in zip(own.after, base.after, strict=True)]
        found["after"] = math.prod(after) ** (1.0 / len(after))
    return found


def figures_of(errors: Mapping[str, TrackingErrors]) -> dict[str, dict[str, float]]:
    """Return the figures of controllers by name: the settled ``error`` itself, and the ratios to PI."""
    return {name: {"error": own.settled, **ratios(errors["pi"], own)} for name, own in errors.items()}


def _over(top: float, bottom: float) -> float:
    """Return a ratio of errors; that of two vanishing ones is one, that of two infinite ones infinite."""
    if top == bottom and math.isfinite(top):
        return 1.0
    if math.isinf(bottom):
        return math.inf if math.isinf(top) else 0.0
    return top / bottom if bottom > 0.0 else math.inf

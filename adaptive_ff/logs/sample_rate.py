"""Whether a log changes its sample rate: a stretch whose rows are as evenly, but further or less far apart."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import GAP, runs
from adaptive_ff.logs.log import Array, Log

FEWEST = 50
"""Steps of the clock, one after the other, that a sample time of its own takes."""

OTHER = 1.4
"""Step of the clock over the usual one, or the other way round, from which on it is another sample time."""

EVEN, NEARLY = 0.25, 0.9
"""Distance from the median of the stretch, over it, that nearly all of its steps are within."""


class Stretch(NamedTuple):
    """Rows ``start`` to ``stop``, both included, with a sample time of their own, s."""

    start: int
    stop: int
    step: float


class OneRate(NamedTuple):
    """A log with one sample rate.

    Attributes
    ----------
    log : Log
        The log, without stretches that are slower by so much that rows between cannot be bridged.
    said : list of str
        What was found, at most a sentence.
    ends : list of float
        Times after which rows are left out, s.
    """

    log: Log
    said: list[str]
    ends: list[float]


def with_one_rate(log: Log, step: float) -> OneRate:
    """Return a log, whose clock has some median step (s), without the stretches that are much slower."""
    found = find_other_rates(log.time, step)
    if not found:
        return OneRate(log, [], [])
    first = found[0]
    often = "" if len(found) == 1 else f" in {len(found)} stretches, the first"
    steps = f"{1e3 * first.step:.4g} ms instead of {1e3 * step:.4g} ms"
    what = f"the sample time changes{often} to {steps} at {log.time[first.start]:.6g} s"
    slow = [stretch for stretch in found if stretch.step > GAP * step]
    if not slow:
        return OneRate(log, [f"{what}; such rows are used beside the others"], [])
    left = np.zeros(log.time.size, dtype=np.bool_)
    for stretch in slow:
        left[stretch.start + 1 : stretch.stop + (stretch.stop == log.time.size - 1)] = True
    count = counted(int(np.count_nonzero(left)), "row")
    begins = [float(log.time[stretch.start]) for stretch in slow]
    said = f"{count} left out: {what}; identify such a part as a log of its own"
    return OneRate(log.part(~left), [said], begins)


def find_other_rates(time: Array, step: float) -> list[Stretch]:
    """Return the stretches of a clock of some median step, s, that have another sample time."""
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.diff(time)
        slower = (steps > OTHER * step) & (steps < np.inf)
        faster = (steps > 0.0) & (steps < step / OTHER)
    stretches = [
        Stretch(start, stop, float(np.median(steps[start:stop])))
        for mask in (slower, faster)
        for start, stop in runs(mask)
        if stop - start >= FEWEST and _is_even(steps[start:stop])
    ]
    return sorted(stretches)


def _is_even(steps: NDArray[np.float64]) -> bool:
    usual = float(np.median(steps))
    return float(np.mean(np.abs(steps - usual) <= EVEN * usual)) >= NEARLY

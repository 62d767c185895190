"""Rows in which a position, a velocity or a torque is far off and comes back at once: glitches of a sensor or a bus.

Such a row is none of the motion: left in, it is a jump there and back, and its acceleration outweighs all the others.
What is looked for leaves its neighbours in one step, stays away for one to three rows and is back in one step, where
the slope around it says. Steps, ramps, friction that reverses and torques that die away are not like that. Far is
measured against the usual step of the series and the steps beside; so noise, encoders of few counts, pulses that come
all the time and vibration are not far. A torque or a velocity may really come and go within three rows (a reference
that jumps, a joint that slips); of these only what is far outside the range of all others counts, and of torques only
what the joint did not feel (:mod:`adaptive_ff.logs.felt_torque`).
"""

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import bridged, median_step
from adaptive_ff.logs.felt_torque import were_felt
from adaptive_ff.logs.log import Array, Log

WIDEST = 3
"""Rows that a glitch takes at most."""

FAR = 4.0
"""Distance from the neighbours, over the usual step and over those beside, from which on a row is far off."""

USUAL = 0.95
"""Share of the steps that are usual; of those that are not zero, as a joint may rest for most of a log."""

BACK = 0.2
"""Distance from where the slope leads to, over that of the glitch, up to which a series is back."""

BESIDE = 6
"""Rows on either side whose steps are compared; the two largest may be those of another glitch."""

NEAREST = 3
"""Rows that there must be on either side."""

OUTSIDE = 1.5
"""Distance of a torque or a velocity that is far off, over the range of all but the rarest values."""

RAREST = 0.002
"""Share of the values at either end that the range leaves out; what comes more often is no glitch."""


def without_outliers(log: Log) -> tuple[Log, list[str]]:
    """Return a log without the rows in which a series is far off for one to three rows, and what was left out.

    Where the clock leaves such a gap that it cannot be bridged, nothing is left out.
    """
    step = median_step(log)
    said = []
    for role in ("position", "velocity", "torque"):
        series: Array | None = getattr(log, role)
        if series is None:
            continue
        off = find_outliers(series, None if role == "position" else usual_range(series), log)
        kept = bridged(log.time, off, step)
        if kept:
            first, left = kept[0][0], np.ones(off.size, dtype=np.bool_)
            for start, stop in kept:
                left[start:stop] = False
            number = off.size - int(np.count_nonzero(left))
            said.append(
                f"{counted(number, 'row')} left out: the {role} is far off there, and back within {WIDEST} rows, first "
                f"at {log.time[first]:.6g} s, where it is {series[first]:.3g}"
            )
            log = log.part(left)
    return log, said


def find_outliers(values: Array, within: tuple[float, float] | None, log: Log) -> NDArray[np.bool_]:
    """Return the rows in which a series is far off for one to three rows.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The series.
    within : tuple of float or None
        Range of its usual values, where it can come and go within three rows, as all but a position can.
    log : Log
        The log that it is of; what of its torque the joint felt is not off.

    Returns
    -------
    ndarray of bool, shape (n,)
        True in rows that are far off.
    """
    off = np.zeros(values.size, dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        steps = np.diff(values)
        moved = np.abs(steps)
        moved = moved[(moved > 0.0) & (moved < np.inf)]
        if not moved.size:
            return off
        limit = FAR * float(np.quantile(moved, USUAL))
        if within is not None:
            limit = max(limit, OUTSIDE * (within[1] - within[0]))
        begin = np.flatnonzero(np.abs(steps) > limit) + 1
        for width in range(1, WIDEST + 1):
            first = begin[(begin >= NEAREST) & (begin + width <= values.size - NEAREST)]
            first = first[_are_off(values, steps, first, width, limit)]
            if within is not None:
                first = first[_are_outside(values, first, width, within)]
            if values is log.torque and within is not None:
                is_position = log.position is not None
                first = first[~were_felt(log.motion, values, first, width, is_position=is_position, range_=within)]
            for start in first:
                if not (off[start - 1] or off[start + width]):  # else what is between two glitches
                    off[start : start + width] = True
    return off


def _are_outside(values: Array, first: NDArray[np.int64], width: int, within: tuple[float, float]) -> NDArray[np.bool_]:
    """Tell at which of some first rows all of so many are outside a range; one between two glitches is not."""
    rows = values[first[:, np.newaxis] + np.arange(width)]
    outside: NDArray[np.bool_] = np.all((rows < within[0]) | (rows > within[1]), axis=1)
    return outside


def usual_range(values: Array) -> tuple[float, float]:
    """Return the range of all but the rarest values of a series; of none that is finite, nothing."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 0.0
    low, high = np.quantile(known, (RAREST, 1.0 - RAREST))
    return float(low), float(high)


def _are_off(values: Array, steps: Array, first: NDArray[np.int64], width: int, limit: float) -> NDArray[np.bool_]:
    """Tell at which of some first rows begin so many that are off, and end."""
    before, after = first - 1, first + width
    reach = np.arange(BESIDE)
    places = np.concatenate([before[:, np.newaxis] - 1 - reach, after[:, np.newaxis] + reach], axis=1)
    beside = np.where((places >= 0) & (places < steps.size), steps[np.clip(places, 0, steps.size - 1)], 0.0)
    slope = np.median(beside, axis=1)
    lines = values[before][:, np.newaxis] + slope[:, np.newaxis] * np.arange(1, width + 2)
    distances = np.abs(values[before[:, np.newaxis] + np.arange(1, width + 2)] - lines)
    nearest = np.min(distances[:, :-1], axis=1)
    third = np.sort(np.abs(beside), axis=1)[:, -3]
    is_back = distances[:, -1] <= BACK * nearest
    is_far = (nearest > np.maximum(limit, FAR * third)) & np.all(np.isfinite(distances), axis=1)
    off: NDArray[np.bool_] = is_far & is_back
    return off

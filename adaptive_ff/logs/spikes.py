"""Rows in which a series is far off for one to three rows and back at once: glitches of a sensor or a bus.

What is looked for leaves its neighbours in one step, stays away and is back in one step, where the slope around it
says. Far is measured against the usual step of the series and the steps beside; so noise, encoders of few counts,
pulses that come all the time and vibration are not far. A torque or a velocity may really come and go within three
rows; of these only what is far outside the range of all others counts, and of torques only what the joint did not
feel: an impulse changes its velocity.
"""

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import bridged, steps_of
from adaptive_ff.logs.log import Array, Log

WIDEST, NEAREST, BESIDE = 3, 3, 6
"""Rows that a spike takes at most, that there must be on either side, and whose steps are compared there."""

FAR, USUAL = 4.0, 0.95
"""Distance from the neighbours, over the usual step and those beside, that is far; fraction of steps that are usual."""

BACK = 0.2
"""Distance from where the slope leads to, over that of the spike, up to which a series is back."""

OUTSIDE, RAREST = 1.5, 0.002
"""Distance of a torque or a velocity over the range of all values but this fraction at either end."""

AROUND, FELT = 5, 3.0
"""Rows over which the velocity is a mean; its change over that which nine of ten other places do not exceed."""


def without_spikes(log: Log) -> tuple[Log, list[str]]:
    """Leave out the rows in which a series is far off; none where the clock would leave a gap."""
    said: list[str] = []
    for role in [role for role in ("position", "velocity", "torque") if role in log.series]:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            kept = bridged(log.time, find_spikes(log, role))
        if kept:
            left = np.zeros(log.time.size, dtype=np.bool_)
            for start, stop in kept:
                left[start:stop] = True
            first = kept[0][0]
            said.append(
                f"{counted(int(left.sum()), 'row')} left out: the {role} is far off there, and back within {WIDEST} "
                f"rows, first at {log.time[first]:.6g} s, where it is {log.series[role][first]:.3g}"
            )
            log = log.part(~left)
    return log, said


def find_spikes(log: Log, role: str) -> NDArray[np.bool_]:
    """Return the rows in which the position, velocity or torque of a log is far off for one to three rows."""
    values = log.series[role]
    off = np.zeros(values.size, dtype=np.bool_)
    steps = steps_of(values)
    moved = np.abs(steps)
    moved = moved[(moved > 0.0) & (moved < np.inf)]
    if not moved.size:
        return off
    limit = FAR * float(np.quantile(moved, USUAL))  # of steps that are not zero: a joint may rest for most of a log
    low, high = np.quantile(values[np.isfinite(values)], (RAREST, 1.0 - RAREST))
    if role != "position":
        limit = max(limit, OUTSIDE * (high - low))
    begin = np.flatnonzero(np.abs(steps) > limit) + 1
    for width in range(1, WIDEST + 1):
        first = begin[(begin >= NEAREST) & (begin + width <= values.size - NEAREST)]
        first = first[_are_off(values, steps, first, width, limit)]
        if role != "position":
            inside = values[first[:, np.newaxis] + np.arange(width)]
            first = first[np.all((inside < low) | (inside > high), axis=1)]
        if role == "torque":
            first = first[~_were_felt(log, first, width)]
        for start in first:
            if not (off[start - 1] or off[start + width]):  # else what is between two spikes
                off[start : start + width] = True
    return off


def _are_off(values: Array, steps: Array, first: NDArray[np.int64], width: int, limit: float) -> NDArray[np.bool_]:
    """Tell at which of some first rows begin so many that are off, and end."""
    before, reach = first[:, np.newaxis] - 1, np.arange(BESIDE)
    places = np.concatenate([before - 1 - reach, before + 1 + width + reach], axis=1)
    beside = np.where((places >= 0) & (places < steps.size), steps[np.clip(places, 0, steps.size - 1)], 0.0)
    ahead = np.arange(1, width + 2)
    distances = np.abs(values[before + ahead] - values[before] - np.median(beside, axis=1)[:, np.newaxis] * ahead)
    nearest = np.min(distances[:, :-1], axis=1)
    third = np.sort(np.abs(beside), axis=1)[:, -3]  # the two largest may be those of another spike
    is_far = (nearest > np.maximum(limit, FAR * third)) & np.all(np.isfinite(distances), axis=1)
    return np.asarray(is_far & (distances[:, -1] <= BACK * nearest))


def _were_felt(log: Log, rows: NDArray[np.int64], width: int) -> NDArray[np.bool_]:
    """Tell at which rows the velocity changes by more than anywhere else, as an impulse of the torque changes it."""
    velocity = log.motion if log.position is None else np.diff(log.motion, append=log.motion[-1])
    mean = np.convolve(velocity, np.full(AROUND, 1.0 / AROUND), mode="same")
    apart = width + AROUND + 1
    changes = np.abs(mean[apart:] - mean[:-apart])
    known = changes[np.isfinite(changes)]
    if not known.size:
        return np.zeros(rows.size, dtype=np.bool_)
    usual = float(np.quantile(known, 0.9))
    return np.asarray(changes[np.clip(rows - AROUND // 2 - 1, 0, changes.size - 1)] > FELT * usual)

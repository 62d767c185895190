"""Spikes: rows in which a series is far off for one to three rows, as a glitch of a sensor or a bus leaves them.

They are found by the Hampel filter [1]_: a row is off if it is far from the median of the rows around it, measured by
the median of these distances and by the usual step of the series. So noise, encoders of few counts, slopes and jumps
that stay are no spikes. A torque or a velocity may really come and go within three rows; of these only what is far
outside the range of all others counts, and of torques only what the joint did not feel: an impulse changes its
velocity.

References
----------
.. [1] R. K. Pearson, Outliers in process modeling and identification, IEEE Trans. Control Syst. Technol. 10, 2002.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import bridged, runs, steps_of
from adaptive_ff.logs.log import Log

WIDEST = 3
"""Rows that a spike takes at most; the median is that of so many on either side."""

FAR, USUAL = 4.0, 0.95
"""Distance from the median, over the usual step and the median distance, that is far; fraction of usual steps."""

OUTSIDE, RAREST = 1.5, 0.002
"""Distance of a torque or a velocity over the range of all values but this fraction at either end."""

AROUND, FELT = 5, 3.0
"""Rows over which the velocity is a mean; its change over that which nine of ten other places do not exceed."""


def without_spikes(log: Log) -> tuple[Log, list[str]]:
    """Leave out the rows in which a series is far off; none where the clock would leave a gap."""
    said: list[str] = []
    for role in [role for role in ("position", "velocity", "torque") if role in log.series]:
        with np.errstate(invalid="ignore", over="ignore"):
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
    values, off = log.series[role], np.zeros(log.time.size, dtype=np.bool_)
    known, moved = np.isfinite(values), np.abs(steps_of(values))
    moved = moved[(moved > 0.0) & (moved < np.inf)]
    if not moved.size:
        return off
    limit = FAR * float(np.quantile(moved, USUAL))  # of steps that are not zero: a joint may rest for most of a log
    if role != "position":
        limit = max(limit, OUTSIDE * float(np.ptp(np.quantile(values[known], (RAREST, 1.0 - RAREST)))))
    away = np.where(known, np.abs(values - ndimage.median_filter(values, 2 * WIDEST + 1)), 0.0)
    far = away > np.maximum(limit, FAR * ndimage.median_filter(away, 2 * WIDEST + 1))
    felt = _is_felt(log) if role == "torque" and far.any() else off.copy()
    for start, stop in runs(far):
        off[start:stop] = stop - start <= WIDEST and not felt[start]
    return off


def _is_felt(log: Log) -> NDArray[np.bool_]:
    """Tell where the velocity changes by more than anywhere else, as an impulse of the torque changes it."""
    velocity = log.motion if log.position is None else np.diff(log.motion, append=log.motion[-1])
    mean = np.convolve(velocity, np.full(AROUND, 1.0 / AROUND), mode="same")
    before, behind = AROUND // 2 + 1, AROUND // 2 + 1 + WIDEST
    padded = np.pad(mean, (before, behind), mode="edge")
    changes = np.abs(padded[before + behind :] - padded[: -before - behind])
    known = changes[np.isfinite(changes)]
    return np.asarray(changes > FELT * np.quantile(known, 0.9)) if known.size else np.zeros(mean.size, dtype=np.bool_)

"""A log made ready for the regression: cleaned, cut at gaps, put on even times, filtered, divided into folds."""

import math
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.errors import InputError, counted
from adaptive_ff.identify.columns import Map, Shape, unit_torques
from adaptive_ff.identify.motion import (
    TUNING,
    Array,
    Rows,
    Segment,
    Spectrum,
    choose_band,
    derivative,
    even,
    lowpass,
    make_rows,
    spectrum,
)
from adaptive_ff.identify.regression import Fit, Folds, Model, remainder, sums
from adaptive_ff.logs.cleaning import clean, lacking_column
from adaptive_ff.logs.columns import in_degrees
from adaptive_ff.logs.defects import Skipped, median_step, usable_segments
from adaptive_ff.logs.log import KNOWN, Log
from controllers.arrays import NDArray


class Prepared(NamedTuple):
    """A log, ready for the regression.

    The cleaned log and its segments, as measured and filtered; torque in the band (N m), velocity, position and time at
    the sliding rows, with the fold of each; band (Hz), speed that few samples exceed (rad/s), sample time (s); where
    motion and noise are; whether the axis is rotary, and the time of the torque known; samples that were used, what was
    not, and what was done to the log; what of position friction may depend on; whether it may rise with the known
    torque, else with the torque of ``load`` of :class:`Shape`.
    """

    log: Log
    segments: list[Segment]
    rows: list[Rows]
    torque: Array
    velocity: Array
    position: Array
    time: Array
    fold: NDArray[np.int64]
    band: float
    fast: float
    period: float
    found: Spectrum
    rotary: bool
    delay_known: bool
    used: int
    skipped: list[Skipped]
    said: list[str]
    place: Map = Map()
    has_known: bool = False
    load: tuple[float, ...] = ()

    @property
    def longest(self) -> Rows:
        """The longest segment."""
        return max(self.rows, key=lambda rows: rows.time.size)

    @property
    def noise(self) -> dict[str, float]:
        """Variance of the noise of the measured motion in a row, by column."""
        found, corners = self.found, (self.band, self.longest.corner)
        return {name: found.variance(corners, order, self.period) for name, order in (("inertia", 1), ("viscous", 0))}

    def columns(self, names: tuple[str, ...], shape: Shape) -> Array:
        """Return unit torques in the band at the sliding rows, one column a name."""
        return np.concatenate([unit_torques(rows, names, shape, self.place) for rows in self.rows])

    def modelled(self, fit: Fit) -> Array:
        """Return the torque of a model in the band at the rows."""
        return np.asarray(self.columns(*fit.model) @ [fit.values[name] for name in fit.model.names])

    def left(self, fit: Fit) -> float:
        """Return what a model leaves of the torque, see :func:`remainder`."""
        return remainder((self.torque - self.modelled(fit)) ** 2, self.torque, fit.model.names)

    def sums(self, names: tuple[str, ...], columns: Array) -> Folds:
        """Return the sums of some columns by fold."""
        return sums(names, columns, self.torque, self.fold, self.noise)

    def fit(self, model: Model) -> Folds:
        """Return the sums of a model."""
        return self.sums(model.names, self.columns(*model))


def prepare(
    log: Log,
    *,
    bandwidth: float | None = None,
    torque_delay: float | None = None,
    linear: bool = False,
    judged: float | None = None,
) -> Prepared:
    """Make a log ready, in a band (Hz; the motion's own if none is given) and with the torque late by a delay (s).

    ``judged`` asks for that band (Hz) instead, or the widest there is, and for a motion without the frequencies at
    which its acceleration is mostly noise.

    Raises
    ------
    InputError
        The log is too short, does not move, has no torque, or the band is not allowed.
    """
    _check(log)
    whole, said = clean(log, linear=linear)
    period = median_step(whole)
    ranges, skipped = usable_segments(whole, 32)
    spans = [slice(one.start, one.stop) for one in ranges]
    _check_content(log, whole, spans, skipped, linear=linear)
    segments = [_segment(whole, span, period, torque_delay or 0.0) for span in spans]
    longest = max(segments, key=lambda one: one.position.size)
    # as measured: a velocity that is summed up has lost the noise of its highest frequencies
    found = spectrum(longest.motion, longest.period, is_position=whole.position is not None)
    if judged is None:
        band, widest = choose_band(found, period, bandwidth), math.inf
    else:
        band, widest = min(judged, TUNING.sampling_fraction / period), found.quiet
    filtered = _filtered(log.name, segments, band, found, widest)
    return Prepared(
        log=whole,
        segments=segments,
        **filtered,
        period=longest.period,
        found=found,
        rotary=not linear,
        delay_known=torque_delay is not None,
        used=sum(map(len, ranges)),
        skipped=skipped,
        said=[*said, *in_degrees(whole, float(np.max(np.abs(filtered["velocity"]))), linear=linear)],
    )


def narrowed(prepared: Prepared) -> Prepared | None:
    """Return the same in half the band; None where that leaves too few rows."""
    try:
        rows = _filtered(prepared.log.name, prepared.segments, 0.5 * prepared.band, prepared.found)
    except InputError:
        return None
    return prepared._replace(**rows)


def _filtered(
    name: str, segments: list[Segment], band: float, found: Spectrum, widest: float = math.inf
) -> dict[str, Any]:
    """Return what of :class:`Prepared` depends on the band and on the widest filter of the motion, Hz."""
    longest = max(segments, key=lambda one: one.position.size)
    smooth = derivative(lowpass(band, longest.period)(longest.position), longest.period)
    fast = float(np.quantile(np.abs(smooth), 0.95))
    if not fast > 0.0:
        raise InputError(f"{name}: nothing moves; the joint must move to be identified")
    every = [make_rows(one, band, found, fast, widest) for one in segments]
    speed = np.concatenate([made.velocity[made.inner] for made in every])
    noise, power = speed.size * every[0].noise ** 2, float(np.sum(speed**2))
    if noise > TUNING.most_noise * power:
        lost = math.sqrt(noise / max(noise, power))
        raise InputError(
            f"{name}: the speed is lost in the noise of the {'position' if found.of_position else 'velocity'}, "
            f"which is {100.0 * lost:.0f} % of it (rms): record faster motion, or with a finer sensor, or "
            "narrow the band"
        )
    rows = [made for made in every if made.kept.size and made.time.size * made.period > 4.0 / band]
    count = sum(made.kept.size for made in rows)
    if count < TUNING.fewest_rows:
        raise InputError(
            f"{name}: the joint slides in {counted(count, 'row')} of the band of {band:.3g} Hz only; there must be "
            f"at least {TUNING.fewest_rows}: record for longer, or widen the band"
        )
    cycles = count / (TUNING.rows_in_cycle * band) * found.slow
    folds = min(int(np.clip(cycles, *TUNING.folds)), max(4, count // 12))
    joined = {
        name: np.concatenate([getattr(made, name)[made.kept] for made in rows])
        for name in ("velocity", "position", "time")
    }
    joined["torque"] = np.concatenate([made.in_band(made.torque)[made.kept] for made in rows])
    return {"rows": rows, "fold": np.arange(count) * folds // count, "band": band, "fast": fast, **joined}


def _segment(log: Log, part: slice, period: float, delay: float) -> Segment:
    """Return a segment at even times; a velocity is summed up to a position."""
    time = log.time[part]
    count = round(float(time[-1] - time[0]) / period) + 1
    step = float(time[-1] - time[0]) / (count - 1)
    grid = time[0] + step * np.arange(count)
    motion, torque = even(time, log.motion[part], grid), even(time + delay, log.torque[part], grid)
    position = motion
    if log.position is None:
        position = np.concatenate([[0.0], np.cumsum(0.5 * (motion[1:] + motion[:-1])) * step])
    known = even(time + delay, log.extra[KNOWN][part], grid) if KNOWN in log.extra else np.zeros(count)
    return Segment(float(time[0]), step, motion, position, torque, known)


def _check(log: Log) -> None:
    """Refuse what is too short, and values with which squares would leave the range of numbers."""
    if log.time.size < TUNING.fewest_samples:
        few = counted(log.time.size, "sample")
        raise InputError(f"{log.name}: the log has {few}; there must be at least {TUNING.fewest_samples}")
    least, most = 1.0 / TUNING.largest, TUNING.largest
    series = {"sample time": np.array([median_step(log)]), "torque": log.torque, "motion": log.motion}
    for name, values in series.items():
        peak = float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))
        if peak != 0.0 and not least <= peak <= most:
            raise InputError(f"{log.name}: the {name} reaches {peak:.3g}; it must be from {least:g} to {most:g}")


def _check_content(given: Log, log: Log, spans: list[slice], skipped: list[Skipped], *, linear: bool) -> None:
    """Refuse a log without a usable segment, without motion or without torque."""
    if not spans:
        worst = max(skipped, key=lambda skip: skip.stop - skip.start).reason if skipped else "there is none at all"
        raise InputError(
            f"{log.name}: no segment of 32 samples is without defect; mostly {worst}{lacking_column(given)}"
        )
    hint = "" if linear else "; of a joint that swings freely, take its known gravity away with --known-torque"
    for role, rule in (
        (log.moving, "it must move to be identified"),
        ("torque", f"it must be that of the drive{hint}"),
    ):
        values = np.concatenate([log.series[role][span] for span in spans])
        if np.all(values == values[0]):
            raise InputError(f"{log.name}: the {role} is {values[0] + 0.0:g} all over; {rule}")  # -0 is 0

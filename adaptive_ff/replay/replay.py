"""Replay of a log: what the adaptive feedforward would have learnt, and the torque it would have left.

In its loop the controller learns from the velocity error behind the response of the loop, along the reference. A log
has no loop of ours: here the same columns run along the measured motion, and a low-pass stands for the response.
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy

from adaptive_ff.errors import InputError, check_positive, read_text, sentence
from adaptive_ff.friction.model import IDENTIFIED, unit_of
from adaptive_ff.identify.columns import of_current
from adaptive_ff.identify.identification import OppositeSigns, check_delay, identify_log
from adaptive_ff.identify.motion import TUNING, Array, Rows
from adaptive_ff.identify.preparation import Prepared, prepare
from adaptive_ff.identify.regression import tolerance
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.learning.kalman import LOOP, Estimate
from adaptive_ff.logs.log import Log, check_log
from adaptive_ff.replay.learning import COLUMNS, DRY, TURNING, Learner, columns_of, initial_state, learn, make_learner
from adaptive_ff.reported import WORTH, Reported
from adaptive_ff.scenario.axis_units import axis_unit
from controllers.arrays import packed, unpacked

NONE, FIXED, RECORDED, COLD, SAVED = "none", "fixed", "recorded", "adaptive", "adaptive_saved"
"""Feedforwards: none; a fixed model; the machine's own; the adaptive one from a cold start, and from a saved state."""

BAND = 20.0
"""Band in which the torque left is judged, Hz."""

MEMORY = 5.0
"""Memory where none is given, s of sliding motion."""

FEEDFORWARD = "feedforward"
"""Name in ``Log.extra`` of the machine's own."""


class Left(NamedTuple):
    """Torque left to the feedback, rms in the band, N m: whole log, its second half, and while the joint moves."""

    whole: float
    second_half: float
    moving: float


class Series(NamedTuple):
    """Series of a replay: time (s), torque and feedforwards in the band (N m), and estimates by name."""

    time: Array
    needed: Array
    feedforward: dict[str, Array]
    estimates: dict[str, dict[str, Array]]


@dataclass(frozen=True, eq=False)
class Replay(Reported):
    """A log replayed."""

    _drawn_by = "plot_replay"

    data: Prepared  # the log as it was replayed: cleaned, in the band in which is judged, with what was not used of it
    linear: bool  # whether it is of a linear axis
    is_current: bool  # whether its torque is a current
    settings: dict[str, Any]  # what was assumed
    notes: list[str]  # what is to be known of the figures
    fixed: LogIdentification | None  # the fixed model: the first half of the log identified
    unidentified: list[str]  # parameters that the motion does not tell from others
    left: dict[str, Left]  # torque left by feedforward
    series: Series  # torques and estimates over time
    state: str  # state at the end, for the next log

    @property
    def units(self) -> dict[str, str]:
        """Units of the estimates, by name."""
        names = next(iter(self.series.estimates.values()))
        units = {name: axis_unit("linear" if self.linear else "", unit_of(name) or "N m") for name in names}
        return of_current(units) if self.is_current else units

    @property
    def unit(self) -> str:
        """Unit of torque: N m, N of a linear axis, or A."""
        return self.units["coulomb"]

    @property
    def estimates(self) -> dict[str, dict[str, float]]:
        """Estimates at the end, of each adaptive feedforward, by name."""
        return {
            which: {name: float(history[-1]) for name, history in histories.items()}
            for which, histories in self.series.estimates.items()
        }

    @property
    def verdict(self) -> dict[str, Any]:
        """Which feedforward leaves the least torque in the second half of the log, and by how much; what was given."""
        left = {name: one.second_half for name, one in self.left.items() if math.isfinite(one.second_half)}
        best = min((name for name in left if name != NONE), key=lambda name: left[name], default=NONE)
        over = {name: left[name] / left[best] for name in (NONE, RECORDED) if name in left and left[best] > 0.0}
        known = ("inertia", "stribeck_velocity")
        given = [name for name in known if self.settings[name] is not None]
        apart = {*given, *self.unidentified}
        return {
            "best": best,
            "over_none": over.get(NONE),
            "over_recorded": over.get(RECORDED),
            "worth": over.get(NONE, 1.0) > WORTH,
            "given": given,
            "unidentified": self.unidentified,
            "identified": [name for name in next(iter(self.series.estimates.values())) if name not in apart],
        }

    def state_to_json(self) -> str:
        """Return the state at the end, for the next log."""
        return self.state

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        left = {
            name: {key: value if math.isfinite(value) else None for key, value in one._asdict().items()}
            for name, one in self.left.items()
        }
        return {
            "log": self.data.log.name,
            "left": left,
            "unit": self.unit,
            "band": self.data.band,
            "settings": self.settings,
            "fixed": None if self.fixed is None else self.fixed.best.values,
            "estimates": self.estimates,
            "samples": {"log": self.data.log.time.size, "used": self.data.used},
            "skipped": [skip._asdict() for skip in self.data.skipped],
            "notes": self.notes,
            "verdict": self.verdict,
        }


def replay_log(
    log: Log,
    *,
    inertia: float | None = None,
    stribeck_velocity: float | None = None,
    memory: float | None = None,
    identify: str = "offset",
    ripple_periods: tuple[float, ...] = (),
    torque_delay: float | None = None,
    bandwidth: float | None = None,
    band: float = BAND,
    state: str | Path | None = None,
    linear: bool = False,
    is_current: bool = False,
) -> Replay:
    """Replay a log.

    Parameters
    ----------
    log : Log
        The log; in ``Log.extra`` it may have ``feedforward`` (N m), the machine's own.
    inertia : float, optional
        Inertia that is assumed, kg m^2; learnt from nothing if not given.
    stribeck_velocity : float, optional
        Stribeck velocity that is assumed, rad/s; a twentieth of the usual speed if not given.
    memory : float, optional
        Memory, s of sliding motion.
    identify : str, optional
        What is learnt: ``symmetric``, ``offset``, ``directions``, ``gravity`` or ``directions_and_gravity``.
    ripple_periods : tuple of float, optional
        Periods of a torque over the position that is learnt, rad.
    torque_delay : float, optional
        Time after its stamp at which a torque acts, s.
    bandwidth : float, optional
        Band in which the fixed model is fitted, Hz.
    band : float, optional
        Band in which is judged, Hz.
    state : str or Path, optional
        State of an earlier replay, see :meth:`Replay.state_to_json`, or its file.
    linear, is_current : bool, optional
        Whether it is a linear axis, and whether the torque is a current.

    Raises
    ------
    InputError
        The log cannot be used, or an argument is out of range.
    """
    check_log("log", log)
    given = {"inertia": inertia, "stribeck_velocity": stribeck_velocity, "memory": memory, "band": band}
    check_positive(**{name: value for name, value in given.items() if value is not None})
    check_positive(**{f"ripple_periods[{place}]": one for place, one in enumerate(ripple_periods)})
    if identify not in IDENTIFIED:
        raise InputError(f"identify = {identify!r} is not allowed: it must be one of {', '.join(IDENTIFIED)}")
    check_delay(torque_delay or 0.0)
    gravity = "gravity" in identify
    if (gravity or ripple_periods) and log.position is None:
        raise InputError(f"{log.name}: gravity and ripples are learnt over a position; the log has none")
    prepared = prepare(log, judged=band, torque_delay=torque_delay, linear=linear)
    learner = make_learner(
        fast=prepared.fast,
        torque=float(np.std(prepared.torque)),
        accelerated=float(np.std(np.concatenate([np.diff(rows.velocity) / rows.period for rows in prepared.rows]))),
        inertia=inertia,
        stribeck_velocity=stribeck_velocity or TUNING.slow * prepared.fast,
        parameters=IDENTIFIED[identify],
        ripples=tuple(ripple_periods),
    )
    saved = None if state is None else _saved_state(learner, state)
    fixed, note = _fixed(log, bandwidth, torque_delay, linear=linear, is_current=is_current)
    started = {COLD: initial_state(learner), **({} if saved is None else {SAVED: saved})}
    parts = [_replayed(prepared, rows, learner, started, memory or MEMORY) for rows in prepared.rows]
    needed = [rows.torque for rows in prepared.rows]
    others: dict[str, list[Array]] = {NONE: [np.zeros_like(one) for one in needed]}
    if fixed is not None:
        others[FIXED] = [_fixed_torque(fixed, prepared, rows) for rows in prepared.rows]
    if FEEDFORWARD in log.extra:
        clock, recorded = prepared.log.time, prepared.log.extra[FEEDFORWARD]
        known = np.isfinite(recorded)
        others[RECORDED] = [np.interp(rows.time, clock[known], recorded[known]) for rows in prepared.rows]
    fed, estimates = ({name: [part[name][place] for part in parts] for name in started} for place in (0, 1))
    left, series = _judged(prepared, needed, {**others, **fed}, estimates, learner)
    notes = [
        "Columns run along the measured motion, and a low-pass stands for the response of the loop: in its loop the "
        "controller learns along its reference, from the error.",
        note,
        *map(sentence, prepared.said),
    ]
    if prepared.band < band:
        notes.append(f"The band is {prepared.band:.3g} Hz, a fifth of the sampling frequency, and not {band:.3g} Hz.")
    if fixed is not None and not gravity and "gravity_sine" in fixed.best.values:
        notes.append("The fixed model holds gravity; for the adaptive one it is --identify gravity.")
    worse = [name for name, torque in left.items() if torque.whole > left[NONE].whole]
    if worse:
        notes.append(
            f"More torque than without any feedforward is left by {' and '.join(worse)}: another torque acts "
            "on the joint (gravity, other axes), or signs or units are not those of the log."
        )
    return Replay(
        data=prepared,
        linear=linear,
        is_current=is_current,
        settings={**given, "memory": memory or MEMORY, "identify": identify, "ripple_periods": list(ripple_periods)},
        notes=notes,
        fixed=fixed,
        unidentified=_unidentified(prepared, learner),
        left=left,
        series=series,
        state=_state_to_json(learner, started.get(SAVED, started[COLD])),
    )


def _replayed(
    prepared: Prepared, rows: Rows, learner: Learner, states: dict[str, Estimate], memory: float
) -> dict[str, tuple[Array, Array]]:
    """Return the torque fed along a segment by what was learnt before each sample, and the estimates, by state."""
    columns, still = columns_of(learner, rows), np.abs(rows.velocity) < rows.slow
    series = np.column_stack([columns, rows.torque, still])
    response = scipy.signal.butter(2, min(prepared.band, 0.4 / rows.period), fs=1.0 / rows.period, output="sos")
    start = scipy.signal.sosfilt_zi(response)[:, :, np.newaxis] * series[0]
    passed = scipy.signal.sosfilt(response, series, axis=0, zi=start)[0]
    measured, torque, slides = passed[:, :-2], passed[:, -2], passed[:, -1] < 0.2
    held = np.concatenate([torque[:1], torque[:-1]])  # at standstill friction is what the joint was measured to hold
    found = {}
    for name, state in states.items():
        estimates = learn(learner, state, measured, torque, slides, rows.period, memory)
        fed = np.sum(columns * estimates, axis=1)
        found[name] = np.where(still & ~slides, held, fed), estimates
    return found


def _unidentified(prepared: Prepared, learner: Learner) -> list[str]:
    """Return the parameters whose columns the others explain: dry friction is all of it, and its shape as assumed."""
    columns = np.concatenate([rows.in_band(columns_of(learner, rows))[rows.kept] for rows in prepared.rows])[:, :-2]
    dry, turning = ([COLUMNS.index(name) for name in some] for some in (DRY, TURNING))
    columns[:, turning] -= columns[:, dry].sum(axis=1, keepdims=True)
    names = zip(learner.names, tolerance(columns.T @ columns), strict=False)
    return [name for name, own in names if own < TUNING.collinear and name not in TURNING]


def _judged(
    prepared: Prepared,
    needed: list[Array],
    feeds: dict[str, list[Array]],
    estimates: dict[str, list[Array]],
    learner: Learner,
) -> tuple[dict[str, Left], Series]:
    """Return what each feedforward leaves in the band, and the series."""
    rows = prepared.rows

    def inner(parts: list[Array]) -> Array:
        return np.concatenate([part[one.inner] for one, part in zip(rows, parts, strict=True)])

    def in_band(parts: list[Array]) -> Array:
        return inner([one.in_band(part) for one, part in zip(rows, parts, strict=True)])

    torque = in_band(needed)
    shown = {name: in_band(parts) for name, parts in feeds.items()}
    moves = np.abs(inner([one.velocity for one in rows])) > 0.01 * prepared.fast
    second = np.arange(torque.size) >= torque.size // 2
    masks = np.ones_like(second), second, moves
    left = {name: Left(*(_rms((torque - fed)[mask]) for mask in masks)) for name, fed in shown.items()}
    histories = {}
    for which, parts in estimates.items():
        values = inner(parts)
        found = {name: values[:, k] for k, name in enumerate(learner.names)}
        turning = sum(found[name] for name in TURNING)
        found |= {name: found[name] + turning for name in DRY}
        hidden = (*TURNING, "lag_slope", "velocity_slope")  # no parameters of a joint
        histories[which] = {name: one for name, one in found.items() if name not in hidden}
    return left, Series(inner([one.time for one in rows]), torque, shown, histories)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan


def _fixed(
    log: Log, bandwidth: float | None, delay: float | None, *, linear: bool, is_current: bool
) -> tuple[LogIdentification | None, str]:
    """Return the first half of a log identified, and a sentence on it."""
    half = log.part(slice(None, log.time.size // 2))
    try:
        found = identify_log(half, bandwidth=bandwidth, torque_delay=delay, linear=linear, is_current=is_current)
    except OppositeSigns:
        raise
    except InputError as error:
        return None, f"There is no fixed model: of the first half, {str(error).removeprefix(log.name + ': ')}."
    return found, f"The fixed model is that of identify, of the first half, in a band of {found.data.band:.3g} Hz."


def _fixed_torque(found: LogIdentification, prepared: Prepared, rows: Rows) -> Array:
    """Return the torque of the fixed model along a segment."""
    data = prepared._replace(rows=[rows.unfiltered()])
    names = tuple(name for name in found.best.model.names if name != "torque_delay")
    return np.asarray(data.columns(names, found.best.model.shape) @ [found.best.values[name] for name in names])


def _state_to_json(learner: Learner, state: Estimate) -> str:
    estimate = state.mean[LOOP:] * learner.deviation
    covariance = unpacked(state.covariance)[LOOP:, LOOP:] * np.outer(learner.deviation, learner.deviation)
    return json.dumps({"replay": learner.names, "estimate": estimate.tolist(), "covariance": covariance.tolist()})


def _saved_state(learner: Learner, state: str | Path) -> Estimate:
    """Return a saved state, or that in a file, in the units of a learner.

    Raises
    ------
    InputError
        It is none, or one of other parameters.
    """
    named, text = (f"{state}: ", read_text(state, "cannot be read")) if isinstance(state, Path) else ("", state)
    try:
        content = json.loads(text)
        if not isinstance(content, dict):
            raise TypeError("it must be an object")
        names = tuple(content["replay"])
        estimate, covariance = (np.array(content[key], dtype=float) for key in ("estimate", "covariance"))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{named}is no saved state of a replay: {error}") from error
    size = len(learner.names)
    if names != learner.names or estimate.shape != (size,) or covariance.shape != (size, size):
        raise InputError(
            f"{named}the saved state is of {', '.join(map(str, names))}; identify and ripple_periods must be alike"
        )
    if not (np.all(np.isfinite(estimate)) and np.all(np.isfinite(covariance))):
        raise InputError(f"{named}the saved state holds values that are no finite numbers")
    units = np.where(learner.deviation > 0.0, learner.deviation, 1.0)
    whole = np.pad(covariance / np.outer(units, units), (LOOP, 0))
    return Estimate(np.pad(estimate / units, (LOOP, 0)), packed(whole))

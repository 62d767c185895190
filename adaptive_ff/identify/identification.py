"""Identification of a joint from a log: from the samples to the result."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from adaptive_ff.errors import InputError, check_kind, check_positive
from adaptive_ff.identify.columns import ASYMMETRY, LINEAR, ROTARY, TEXTBOOK, Map, of_current
from adaptive_ff.identify.motion import TUNING
from adaptive_ff.identify.preparation import Prepared, prepare
from adaptive_ff.identify.regression import NOT_NEGATIVE, Model
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.selection import select
from adaptive_ff.learning.checks import check_confidence
from adaptive_ff.logs.log import KNOWN, Log, check_log
from controllers.checks import check_numbers, checked_switch

FAMILIES: dict[str, tuple[tuple[str, ...], bool | None]] = {
    "auto": (TEXTBOOK, None),
    "coulomb-viscous": (TEXTBOOK[:3], False),
    "symmetric": (TEXTBOOK[:3], False),
    "offset": (TEXTBOOK, False),
    "directions": ((*TEXTBOOK, ASYMMETRY), False),
    "gravity": (TEXTBOOK, True),
    "gravity-directions": ((*TEXTBOOK, ASYMMETRY), True),
}
"""Terms of the textbook's model by the name of a family, and whether gravity is one; None where the log is to tell."""


def identify_log(
    log: Log,
    *,
    bandwidth: float | None = None,
    held_out: float = 0.0,
    validation: Log | None = None,
    torque_delay: float | None = None,
    linear: bool = False,
    is_current: bool = False,
    model: str = "auto",
    position_periods: Sequence[float] = (),
    position_hats: int = 0,
    load_friction: bool = False,
    confidence: float = 0.95,
) -> LogIdentification:
    """Identify a joint from a log.

    ``u = J dw/dt + Fc sgn w + sigma w + offset (+ gravity)`` is fitted by bounded least squares, torque and columns
    behind one zero-phase low-pass whose band the motion tells. Refinements are taken where folds that were left out
    of the fit are predicted better by them.

    Parameters
    ----------
    log : Log
        The log, see :func:`adaptive_ff.logs.log.read_log`.
    bandwidth : float, optional
        Band of the regression, Hz; from the motion if not given.
    held_out : float, optional
        Fraction of the samples, at the end of the log, that is not fitted, but validated on.
    validation : Log, optional
        Another log of the joint to validate on.
    torque_delay : float, optional
        Time after its stamp at which a torque acts, s: half a sample time where the torque is held until the next row.
        Where it is not given, a late torque is one of the models that the estimates are averaged over.
    linear : bool, optional
        Whether the joint is a linear axis, in m and N.
    is_current : bool, optional
        Whether the torque is given as a current, A.
    model : str, optional
        Terms that the textbook's model has: a key of ``FAMILIES``; by default gravity is taken where it takes torque.
    position_periods : sequence of float, optional
        Known periods, rad (m), over which friction, or a force, may vary with position.
    position_hats : int, optional
        Number of hats, evenly over the positions of the log, of a map of friction or of a force; 2 or more.
    load_friction : bool, optional
        Whether friction may rise with the known torque of the log.
    confidence : float, optional
        Probability that the intervals are meant to have.

    Raises
    ------
    InputError
        The log does not determine a joint, or an argument is out of range.
    TypeError
        The log is none, or an argument is of another kind.
    """
    _check_arguments(log, validation, held_out, torque_delay, confidence, model)
    linear, is_current = checked_switch("linear", linear), checked_switch("is_current", is_current)
    check_kind("position_periods", position_periods, Iterable, "a sequence of periods")
    _check_map(log, tuple(position_periods), position_hats, checked_switch("load_friction", load_friction))
    used = log.time.size if validation is not None else round((1.0 - held_out) * log.time.size)
    prepared = prepare(log.part(slice(None, used)), bandwidth=bandwidth, torque_delay=torque_delay, linear=linear)
    ends = float(np.min(prepared.position)), float(np.max(prepared.position))
    data = prepared._replace(place=Map(tuple(position_periods), position_hats, *ends), has_known=load_friction)
    textbook, refined, taken, lacking = select(data, *FAMILIES[model], confidence, refine=model != "coulomb-viscous")
    best, units = refined or textbook, LINEAR if linear else ROTARY
    _check_plausible(log, data, textbook.model, best.left)
    said, error, name = list(data.said), None, ""
    if validation is not None or held_out:
        other = validation or replace(log.part(slice(used, None)), name=f"{log.name}, its end that is held out")
        measured = prepare(other, judged=data.band, torque_delay=torque_delay, linear=linear)
        error = measured._replace(place=data.place).left(best)
        name = "the end of the log" if validation is None else validation.name
        cuts = [one.reason for one in measured.skipped]
        if measured.band < 0.99 * data.band:
            cuts.append(f"the torque is compared up to {measured.band:.3g} Hz, a fifth of the sampling frequency")
        said += [] if validation is None else [f"{name}: {sentence}" for sentence in (*measured.said, *cuts)]
    return LogIdentification(
        data,
        of_current(units) if is_current else units,
        textbook,
        refined,
        taken,
        lacking,
        confidence,
        validation=error,
        validated_on=name,
        cautions=said,
    )


class OppositeSigns(InputError):
    """Torque and motion of a log have opposite signs."""


def _check_plausible(log: Log, data: Prepared, model: Model, left: float) -> None:
    """Refuse a torque that has nothing to do with the motion, and one of the wrong sign."""
    values = data.fit(model).solve(bounded=False)
    free = dict.fromkeys(NOT_NEGATIVE, 0.0) | dict(zip(model.names, values.tolist(), strict=True))
    speed = np.abs(data.velocity)
    dissipated = free["coulomb"] * np.mean(speed) + free["viscous"] * np.mean(speed**2)
    backward = (free["inertia"] < 0.0 and dissipated < 0.0) or (free["inertia"] <= 0.0 and free["coulomb"] < 0.0)
    unexplained = np.var(data.torque - data.columns(*model) @ values) / np.var(data.torque)
    if backward and unexplained < 1.0 - TUNING.explained:
        raise OppositeSigns(
            f"{log.name}: friction would drive the joint and inertia be negative: torque and motion have opposite "
            f"signs, or their columns are exchanged: {log.scaling('torque', '-1')}, or name the others"
        )
    if left > TUNING.unexplained:
        raise InputError(
            f"{log.name}: the motion explains {100.0 * max(0.0, 1.0 - left**2):.0f} % of the torque: it is not "
            "that of the drive of this joint, or other forces are larger (give what is known with --known-torque)"
        )


def _check_map(log: Log, periods: tuple[float, ...], hats: int, load: bool) -> None:
    check_numbers(position_hats=hats)
    check_positive(**{f"position_periods[{place}]": period for place, period in enumerate(periods)})
    if hats % 1 != 0 or hats < 0 or hats == 1:
        raise InputError(f"position_hats = {hats:g} is not allowed: it must be 0 or a whole number from 2 on")
    if periods and hats:
        raise InputError("position_periods and position_hats are both given; give one of them")
    if (periods or hats) and log.position is None:
        raise InputError(f"{log.name}: a map over the position takes a log with positions, not velocities")
    if load and KNOWN not in log.extra:
        raise InputError(f"{log.name}: load_friction takes a log with a known torque (--known-torque)")


def _check_arguments(
    log: Log, validation: Log | None, held_out: float, torque_delay: float | None, confidence: float, model: str
) -> None:
    check_log("log", log)
    check_log("validation", log if validation is None else validation)
    if validation is not None and log.is_same_record(validation):
        raise InputError(
            f"{validation.name}: the log to validate on is the one that is fitted; give another one, or none"
        )
    check_numbers(held_out=held_out)
    if not 0.0 <= held_out < 1.0:
        raise InputError(f"held_out = {held_out:g} is not allowed: it must be zero or more, and less than one")
    check_delay(torque_delay or 0.0)
    check_confidence(confidence)
    if model not in FAMILIES:
        raise InputError(f"model = {model!r} is not allowed: it must be one of {', '.join(FAMILIES)}")


def check_delay(torque_delay: float) -> None:
    """Raise ``InputError`` for a delay of the torque, s, that no drive has."""
    check_numbers(torque_delay=torque_delay)
    if not abs(torque_delay) <= TUNING.longest_delay:
        raise InputError(
            f"torque_delay = {torque_delay:g} s is not allowed: it must be from {-TUNING.longest_delay:g} to "
            f"{TUNING.longest_delay:g} s"
        )

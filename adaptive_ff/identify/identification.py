"""Identification of a joint from a log: the steps from the samples to the result."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from adaptive_ff.errors import InputError, check_kind
from adaptive_ff.identify.alternatives.bristle_lag import fit_on_bristles
from adaptive_ff.identify.alternatives.held_out_error import is_larger
from adaptive_ff.identify.alternatives.held_torque import Later, fit_if_held
from adaptive_ff.identify.alternatives.reasons import reasons
from adaptive_ff.identify.fitting.constant_speed import friction_curve
from adaptive_ff.identify.fitting.families import AUTO
from adaptive_ff.identify.fitting.prediction import predict, rest_torque, torque_error
from adaptive_ff.identify.fitting.search import lag_profile
from adaptive_ff.identify.maps.identified_map import identified_map
from adaptive_ff.identify.maps.map_columns import MapAsked, check_asked, check_periods, with_map
from adaptive_ff.identify.model_choice import Chosen, choose_model, has_positions
from adaptive_ff.identify.preparation import Parts, Prepared, divide, prepare, regression_problem
from adaptive_ff.identify.reported import reported
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.rows.recorded_reference import reference_of
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import LAG
from adaptive_ff.identify.units import LINEAR, ROTARY, of_current
from adaptive_ff.identify.words.cautions import cautions, check_plausible, held_words
from adaptive_ff.identify.words.verdict import verdict
from adaptive_ff.learning.confidence import check_confidence
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.log import Log, check_log
from controllers.checks import check_numbers, checked_switch

HELD_OUT = 0.25
"""Share of the log that is held out by default."""

LAG_POINTS = 201
"""Points of the profile over the friction lag."""

LONGEST_DELAY = 1.0
"""Longest time after its stamp at which a torque may act, s; a longer one is a slip of the unit."""


def identify_log(
    log: Log,
    *,
    bandwidth: float | None = None,
    held_out: float = HELD_OUT,
    validation: Log | None = None,
    torque_delay: float | None = None,
    linear: bool = False,
    is_current: bool = False,
    model: str = AUTO,
    position_periods: Sequence[float] = (),
    position_hats: int = 0,
    load_friction: bool = False,
    confidence: float = 0.95,
) -> LogIdentification:
    """Identify a joint from a log.

    The torque is regressed on acceleration, velocity and the sign of the velocity, all without delay and in one band;
    see :mod:`adaptive_ff.identify.rows.filtering`. Rows at rest take no part. Pieces of the log between defects are
    filtered each by itself.

    Parameters
    ----------
    log : Log
        The log, see :func:`adaptive_ff.logs.log.read_log`.
    bandwidth : float, optional
        Band of the regression, Hz; by default five times the frequency of the motion, see
        :func:`adaptive_ff.logs.bandwidth.choose_bandwidth`.
    held_out : float, optional
        Share of the samples, at the end of the log, that is not fitted, but validated on; zero for none.
    validation : Log, optional
        Another log of the joint to validate on; nothing of the first is then held out.
    torque_delay : float, optional
        Time after its stamp at which a torque acts, s: half a sample time where the stamp is that of the command and
        the torque is held until the next. It is no friction lag, but looks like one. Where it is not known it is taken
        for zero, and a torque that seems to be held is told in ``cautions``.
    linear : bool, optional
        Whether the joint is a linear axis, in m and N: the report then names these units.
    is_current : bool, optional
        Whether the torque is given as a current, A: the report then names units made of it.
    model : str, optional
        Family of models: a key of :data:`adaptive_ff.identify.fitting.families.FAMILIES`; by default the one that says
        best what it has not seen. Lag, stiction and viscous friction that saturates are chosen within each.
    position_periods : sequence of float, optional
        Known periods, rad (m), over which friction, or a force, may vary with position.
    position_hats : int, optional
        Number of hats, evenly over the positions of the log, of a map of friction, or of a force, without a known
        period; 2 or more.
    load_friction : bool, optional
        Whether friction may rise with the known torque of the log. These three are used where they validate better.
        Without any of them, and with the default of ``model``, a ripple over the position is looked for, see
        :mod:`adaptive_ff.identify.maps.ripple`.
    confidence : float, optional
        Probability that the confidence intervals are meant to have.

    Returns
    -------
    LogIdentification
        Parameters with intervals, errors of fit and validation, and a verdict. How often the intervals hold the truth
        on synthetic logs is printed by ``python -m benchmarks.coverage``. None covers what every model lacks.

    Raises
    ------
    InputError
        The log does not determine a joint, or an argument is out of range.
    TypeError
        The log is none, or an argument is of another kind.
    """
    _check_logs(log, validation)
    told, torque_delay = torque_delay is not None, torque_delay or 0.0
    _check_arguments(held_out, torque_delay, confidence)
    linear, is_current = checked_switch("linear", linear), checked_switch("is_current", is_current)
    check_kind("position_periods", position_periods, Iterable, "a sequence of periods")
    asked = MapAsked(tuple(position_periods), position_hats, checked_switch("load_friction", load_friction))
    check_asked(asked, log)
    prepared = prepare(log, bandwidth, linear=linear)
    parts = divide(prepared, held_out if validation is None else 0.0)
    if asked.periods:
        check_periods(asked, log.name, *_positions(prepared, parts.fitting))
    chosen = choose_model(
        prepared,
        parts.fitting,
        torque_delay,
        asked,
        family=model,
        rotary=not linear,
        located=has_positions(prepared, validation),
        confidence=confidence,
    )
    chosen, later = _with_alternatives(chosen, parts.fitting, delay_told=told)
    other, unseen, name = _unseen(chosen.prepared, parts.holding, validation, chosen.asked, linear=linear)
    held = regression_problem(other, unseen, torque_delay)
    if chosen.basis is not None and chosen.selection.varied is not None:
        held = with_map(held, other, unseen, chosen.basis, chosen.selection.varied)
    units = LINEAR if linear else ROTARY
    units = of_current(units) if is_current else units
    found = _assemble(chosen, parts, held, confidence, units, name)
    if found.validation is not None and is_larger(found.fit, found.validation):
        why = reasons(chosen.problem, held, found.selection, found.fit, found.validation, of_log=validation is not None)
        found = replace(found, **why._asdict())
    check_plausible(found, log)
    said = [] if validation is None else [f"{name}: {sentence}" for sentence in other.said]
    said += [*cautions(found, log), *held_words(found, later)]
    return replace(found, verdict=verdict(found), cautions=[*prepared.said, *said])


def _with_alternatives(chosen: Chosen, fitting: list[Piece], *, delay_told: bool) -> tuple[Chosen, Later | None]:
    """Return what was chosen with the fits that intervals are taken over, too, and that to a torque that is held."""
    prepared, problem, selection = chosen.prepared, chosen.problem, chosen.selection
    later = None if delay_told else fit_if_held(problem, prepared, fitting, selection)
    if later is not None and LAG in selection.chosen.terms:  # which a held torque does as well
        selection = selection._replace(held=later.fitted)
    on_bristles = fit_on_bristles(problem, prepared, fitting, selection.chosen, delay_told=delay_told)
    return chosen._replace(selection=selection._replace(bristles=on_bristles)), later


def _unseen(
    prepared: Prepared, holding: list[Piece], validation: Log | None, asked: MapAsked, *, linear: bool
) -> tuple[Prepared, list[Piece], str]:
    """Return the log, its pieces and its name that the model is validated on: what was held out, or another log."""
    if validation is None:
        return prepared, holding, "the end of the log"
    check_asked(asked, validation)
    other = prepare(validation, prepared.bandwidth, linear=linear)._replace(rest=prepared.rest)
    return other, other.pieces, validation.name


def _assemble(
    chosen: Chosen, parts: Parts, held: Problem, confidence: float, units: dict[str, str], validated_on: str
) -> LogIdentification:
    """Return the result of a fit, before anything is said of it."""
    prepared, problem, selection, basis, asked = chosen
    model, log = selection.chosen, prepared.log
    rows, unseen = predict(problem, model), predict(held, model)
    fit = torque_error(rows)
    if fit is None:
        raise InputError(f"{log.name}: there is no torque while the joint slides; it must be that of the drive")
    longest = max(prepared.pieces, key=lambda piece: piece.size)
    grid = np.linspace(-problem.longest_lag, problem.longest_lag, LAG_POINTS)
    lags = np.union1d(grid, [model.values.get("friction_lag", 0.0)])  # with the minimum itself
    return LogIdentification(
        name=log.name,
        units=units,
        parameters=reported(selection),
        selection=selection,
        confidence=confidence,
        bandwidth=prepared.bandwidth,
        period=prepared.period,
        samples=log.time.size,
        used=sum(piece.size for piece in [*parts.fitting, *parts.holding]),
        skipped=sorted([*prepared.skipped, *parts.short]),
        fit=fit,
        validation=torque_error(unseen),
        validated_on=validated_on,
        both_ways=problem.moves_both_ways,
        curve=friction_curve(rows, model.values["coulomb"], prepared.bandwidth, confidence),
        rest_torque=rest_torque(problem, model.values),
        lags=lags,
        lag_errors=lag_profile(problem, model, lags),
        rows=rows,
        held_out=unseen,
        reference=reference_of(log, longest, prepared.bandwidth, prepared.period),
        map_asked=asked,
        position_map=None if basis is None else identified_map(model, basis, _positions(prepared, parts.fitting)),
    )


def _positions(prepared: Prepared, pieces: list[Piece]) -> tuple[float, float]:
    """Return the lowest and the highest position of some pieces of a log, rad."""
    motions = [prepared.log.motion[piece.start : piece.stop] for piece in pieces]
    return min(float(np.min(motion)) for motion in motions), max(float(np.max(motion)) for motion in motions)


def _check_logs(log: Log, validation: Log | None) -> None:
    check_log("log", log)
    if validation is not None:
        check_log("validation", validation)
        if log.is_same_record(validation):
            raise InputError(
                f"{validation.name}: the log to validate on is the one that is fitted; give another one, or none: the "
                "end of the log is held out then"
            )


def _check_arguments(held_out: float, torque_delay: float, confidence: float) -> None:
    check_numbers(held_out=held_out)
    if not 0.0 <= held_out < 1.0:
        raise InputError(f"held_out = {held_out:g} is not allowed: it must be zero or more, and less than one")
    check_delay(torque_delay)
    check_confidence(confidence)


def check_delay(torque_delay: float) -> None:
    """Raise ``InputError`` for a delay of the torque, s, that no drive has."""
    check_numbers(torque_delay=torque_delay)
    if not abs(torque_delay) <= LONGEST_DELAY:
        raise InputError(
            f"torque_delay = {torque_delay:g} s is not allowed: it must be from {-LONGEST_DELAY:g} to "
            f"{LONGEST_DELAY:g} s"
        )

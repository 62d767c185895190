"""Identification of a joint from a log: the steps from the samples to the result."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.errors import InputError, check_kind, counted
from adaptive_ff.estimation.confidence import check_confidence
from adaptive_ff.identify.alternatives.bristle_lag import fit_on_bristles
from adaptive_ff.identify.alternatives.carry_over import carries_over
from adaptive_ff.identify.alternatives.held_out_error import error_with_other_load, has_changed, is_larger
from adaptive_ff.identify.alternatives.held_torque import fit_if_held
from adaptive_ff.identify.alternatives.other_units import other_units
from adaptive_ff.identify.fitting.constant_speed import friction_curve
from adaptive_ff.identify.fitting.families import AUTO
from adaptive_ff.identify.fitting.prediction import predict, torque_error
from adaptive_ff.identify.fitting.search import lag_profile
from adaptive_ff.identify.fitting.term_selection import Selection, select_terms
from adaptive_ff.identify.maps.identified_map import identified_map
from adaptive_ff.identify.maps.map_columns import MapAsked, MapBasis, check_asked, check_periods, with_map
from adaptive_ff.identify.maps.map_selection import select_map
from adaptive_ff.identify.maps.ripple import ripple_period
from adaptive_ff.identify.preparation import Prepared, prepare, split, too_short
from adaptive_ff.identify.reported import reported
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.rows.band import shortest_piece
from adaptive_ff.identify.rows.column_noise import column_noise
from adaptive_ff.identify.rows.filtering import Conditioned, condition
from adaptive_ff.identify.rows.recorded_reference import reference_of
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import LAG, is_mapped, jumps_at_reversal
from adaptive_ff.identify.units import LINEAR, ROTARY, of_current
from adaptive_ff.identify.words.cautions import cautions, check_plausible, held_words
from adaptive_ff.identify.words.verdict import verdict
from adaptive_ff.logs.defects import Piece, Skipped
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.logs.log import Log, check_log
from controllers.checks import check_numbers, checked_switch

HELD_OUT = 0.25
"""Share of the log that is held out by default."""

LAG_CYCLES = 1.0
"""Largest friction lag that is looked for, in cycles of the band."""

LAG_POINTS = 201
"""Points of the profile over the friction lag."""

LONGEST_DELAY = 1.0
"""Longest time after its stamp at which a torque may act, s; a longer one is a slip of the unit."""

FEWEST_ROWS = 30
"""Rows at which the joint slides that a fit needs."""

BOTH_WAYS = 0.02
"""Share of the rows that the rarer direction must have for the joint to count as moving both ways."""


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
    check_log("log", log)
    if validation is not None:
        check_log("validation", validation)
        if log.is_same_record(validation):
            raise InputError(
                f"{validation.name}: the log to validate on is the one that is fitted; give another one, or none: the "
                "end of the log is held out then"
            )
    told, torque_delay = torque_delay is not None, torque_delay or 0.0
    _check_arguments(held_out, torque_delay, confidence)
    linear, is_current = checked_switch("linear", linear), checked_switch("is_current", is_current)
    check_kind("position_periods", position_periods, Iterable, "a sequence of periods")
    asked = MapAsked(tuple(position_periods), position_hats, checked_switch("load_friction", load_friction))
    check_asked(asked, log)
    prepared = prepare(log, bandwidth, linear=linear)
    fitting, holding, short = _divide(prepared, held_out if validation is None else 0.0)
    if asked.periods:
        check_periods(asked, log.name, *_positions(prepared, fitting))
    located = _has_positions(prepared, validation)
    chosen = _choose(
        prepared, fitting, torque_delay, asked, family=model, rotary=not linear, located=located, confidence=confidence
    )
    prepared, problem, selection, basis, asked = chosen
    later = None if told else fit_if_held(problem, prepared, fitting, selection)
    if later is not None and LAG in selection.chosen.terms:  # which a held torque does as well
        selection = selection._replace(held=later.fitted)
    on_bristles = fit_on_bristles(problem, prepared, fitting, selection.chosen, delay_told=told)
    selection = selection._replace(bristles=on_bristles)
    other, unseen, name = _unseen(prepared, holding, validation, asked, linear=linear)
    held = regression_problem(other, unseen, torque_delay)
    if basis is not None and selection.varied is not None:
        held = with_map(held, other, unseen, basis, selection.varied)
    used = Used(sum(piece.size for piece in [*fitting, *holding]), sorted([*prepared.skipped, *short]))
    found = _assemble(prepared, used, problem, selection, held, confidence)
    units = LINEAR if linear else ROTARY
    if is_current:
        units = of_current(units)
    learnt = None if basis is None else identified_map(selection.chosen, basis, _positions(prepared, fitting))
    found = replace(
        found, units=units, validated_on=name, both_ways=_moves_both_ways(problem), map_asked=asked, position_map=learnt
    )
    if found.validation is not None and is_larger(found.fit, found.validation):
        found = replace(found, **_reasons(found, problem, held, of_log=validation is not None))
    check_plausible(found, log)
    said = [] if validation is None else [f"{name}: {sentence}" for sentence in other.said]
    said += [*cautions(found, log), *held_words(found, later)]
    return replace(found, verdict=verdict(found), cautions=[*prepared.said, *said])


class _Chosen(NamedTuple):
    """Rows that are fitted, the models that were compared on them, and the map that was asked for, or found."""

    prepared: Prepared
    problem: Problem
    selection: Selection
    basis: MapBasis | None
    asked: MapAsked


def _choose(
    prepared: Prepared,
    fitting: list[Piece],
    torque_delay: float,
    asked: MapAsked,
    *,
    family: str,
    rotary: bool,
    located: bool,
    confidence: float,
) -> _Chosen:
    """Choose rows and model of some pieces of a log, in which a ripple is looked for where all logs have positions."""
    problem = regression_problem(prepared, fitting, torque_delay)
    select = partial(_select, prepared.log, family=family, rotary=rotary, confidence=confidence)
    selection = select(problem)
    if jumps_at_reversal(selection.chosen.terms):  # so it may stick while it reverses
        prepared, problem, selection = _without_stops(select, prepared, fitting, torque_delay, problem, selection)
    basis: MapBasis | None = None
    if asked != MapAsked():
        problem, selection, basis = select_map(problem, prepared, fitting, selection, asked, confidence)
    elif family == AUTO and located:
        found = _with_ripple(problem, prepared, fitting, selection, confidence)
        if found is not None:
            problem, selection, basis = found
            asked = basis.asked
    return _Chosen(prepared, problem, selection, basis, asked)


def _unseen(
    prepared: Prepared, holding: list[Piece], validation: Log | None, asked: MapAsked, *, linear: bool
) -> tuple[Prepared, list[Piece], str]:
    """Return the log, its pieces and its name that the model is validated on: what was held out, or another log."""
    if validation is None:
        return prepared, holding, "the end of the log"
    check_asked(asked, validation)
    other = prepare(validation, prepared.bandwidth, linear=linear)._replace(rest=prepared.rest)
    return other, other.pieces, validation.name


class Used(NamedTuple):
    """Number of samples that were used, and what was not."""

    samples: int
    skipped: list[Skipped]


def _assemble(
    prepared: Prepared, used: Used, problem: Problem, selection: Selection, held: Problem, confidence: float
) -> LogIdentification:
    """Return the result of a fit; its units, its map and the name of the validation are the caller's."""
    chosen, log = selection.chosen, prepared.log
    rows, unseen = predict(problem, chosen), predict(held, chosen)
    fit = torque_error(rows)
    if fit is None:
        raise InputError(f"{log.name}: there is no torque while the joint slides; it must be that of the drive")
    longest = max(prepared.pieces, key=lambda piece: piece.size)
    grid = np.linspace(-problem.longest_lag, problem.longest_lag, LAG_POINTS)
    lags = np.union1d(grid, [chosen.values.get("friction_lag", 0.0)])  # with the minimum itself
    return LogIdentification(
        name=log.name,
        units=ROTARY,
        parameters=reported(selection),
        selection=selection,
        confidence=confidence,
        bandwidth=prepared.bandwidth,
        period=prepared.period,
        samples=log.time.size,
        used=used.samples,
        skipped=used.skipped,
        fit=fit,
        validation=torque_error(unseen),
        validated_on="",
        carries_over=None,
        other_units=None,
        has_other_load=False,
        has_changed=False,
        both_ways=True,
        curve=friction_curve(rows, chosen.values["coulomb"], prepared.bandwidth, confidence),
        rest_torque=rest_torque(problem, chosen.values),
        lags=lags,
        lag_errors=lag_profile(problem, chosen, lags),
        rows=rows,
        held_out=unseen,
        reference=reference_of(log, longest, prepared.bandwidth, prepared.period),
        map_asked=MapAsked(),
        position_map=None,
    )


def _without_stops(
    select: Callable[[Problem], Selection],
    prepared: Prepared,
    fitting: list[Piece],
    torque_delay: float,
    problem: Problem,
    selection: Selection,
) -> tuple[Prepared, Problem, Selection]:
    """Leave out the rows in which a joint stands while it reverses; short stops only where it does not creep there."""
    might_creep = any(not jumps_at_reversal(other.terms) for other in selection.validated)
    again, compared = selection, _rows(problem)
    for dwells in (True, False) if might_creep else (False,):
        sticking = prepared._replace(rest=prepared.rest._replace(sticks=True, dwells=dwells))
        sliding = regression_problem(sticking, fitting, torque_delay)
        rows = _rows(sliding)
        if not FEWEST_ROWS <= rows < _rows(problem):
            continue
        if rows != compared:  # else every stop is one that the sign tells, and the models are those of these rows
            again, compared = select(sliding), rows
        if not dwells or jumps_at_reversal(again.chosen.terms):  # else it creeps, which tells of its friction
            return sticking, sliding, again
    return prepared, problem, selection


def _has_positions(prepared: Prepared, validation: Log | None) -> bool:
    """Tell whether positions of a log are known, and where another one is given, those of both from the same zero.

    Velocities of a log without a gap add up to positions from its begin; those of two logs to two.
    """
    if prepared.log.position is not None:
        return validation is None or validation.position is not None
    return validation is None and len(prepared.pieces) == 1 and not prepared.skipped


def _with_ripple(
    problem: Problem, prepared: Prepared, fitting: list[Piece], selection: Selection, confidence: float
) -> tuple[Problem, Selection, MapBasis] | None:
    """Return rows, models and functions with a ripple over the position; None where the log shows none."""
    if selection.chosen.values["coulomb"] <= 0.0:
        return None
    period = ripple_period(problem, prepared, fitting, selection.chosen)
    if period is None:
        return None
    made = select_map(problem, prepared, fitting, selection, MapAsked((period,), found=True), confidence)
    return made if any(is_mapped(term) for term in made[1].chosen.terms) else None


def _reasons(found: LogIdentification, problem: Problem, held: Problem, *, of_log: bool) -> dict[str, Any]:
    """Return why a model is much worse on what was held out, which may be of another log."""
    assert found.validation is not None
    foreign = other_units(problem, held) if of_log else None
    arguments = held, found.selection, found.fit, found.validation
    carrying = carries_over(problem, *arguments, found.confidence)
    loaded = None if foreign else error_with_other_load(*arguments)
    if loaded is not None and carrying is not None:
        loaded, carrying = (loaded, None) if loaded < carrying[1].rms_error else (None, carrying)
    return {
        "other_units": foreign,
        "carries_over": carrying,
        "has_other_load": loaded is not None,
        "has_changed": not foreign
        and loaded is None
        and carrying is None
        and has_changed(*arguments, found.confidence),
    }


def rest_torque(problem: Problem, values: Mapping[str, float]) -> float | None:
    """Return the largest torque at rest without offset and gravity, N m; None where the joint does not rest."""
    torques = [np.abs((piece.held - carried(piece, values))[piece.rests]) for piece in problem.pieces]
    largest = [float(np.max(torque)) for torque in torques if torque.size]
    return max(largest) if largest else None


def carried(piece: Conditioned, values: Mapping[str, float]) -> Array | float:
    """Return the torque (N m) that carries offset and gravity along a piece, for the values of the terms."""
    torque: Array | float = values.get("offset", 0.0)
    for term, wave in (("gravity_sine", np.sin), ("gravity_cosine", np.cos)):
        if term in values and piece.position is not None:
            torque = torque + values[term] * wave(piece.position)
    return torque


def _positions(prepared: Prepared, pieces: list[Piece]) -> tuple[float, float]:
    """Return the lowest and the highest position of some pieces of a log, rad."""
    motions = [prepared.log.motion[piece.start : piece.stop] for piece in pieces]
    return min(float(np.min(motion)) for motion in motions), max(float(np.max(motion)) for motion in motions)


def _divide(prepared: Prepared, share: float) -> tuple[list[Piece], list[Piece], list[Skipped]]:
    """Return pieces to fit and to hold out, and what became too short for the filters."""
    needed = shortest_piece(prepared.bandwidth, prepared.period)
    parts = split(prepared.pieces, share)
    fitting, holding = ([piece for piece in part if piece.size >= needed] for part in parts)
    short = [
        Skipped(*piece, too_short(piece, prepared.period, needed))
        for part in parts
        for piece in part
        if piece.size < needed
    ]
    if not fitting:
        raise InputError(
            f"{prepared.log.name}: with {100.0 * share:g} % held out, no piece is left of the {needed} samples that "
            "the filters need; hold out less"
        )
    return fitting, holding, short


def regression_problem(prepared: Prepared, pieces: list[Piece], torque_delay: float) -> Problem:
    """Return what is regressed of some pieces of a log; the delay of the torque in s."""
    band, period, rest = prepared.bandwidth, prepared.period, prepared.rest
    conditioned = [condition(prepared.log, piece, band, period, rest, torque_delay) for piece in pieces]
    longest = max(prepared.pieces, key=lambda piece: piece.size)
    noise = column_noise(prepared.log, longest, period, (rest.corner, band))
    variances = {"inertia": noise.acceleration, "viscous": noise.velocity}
    return Problem(conditioned, rest.speeds, LAG_CYCLES / band, variances)


def _rows(problem: Problem) -> int:
    return sum(int(np.count_nonzero(piece.slides)) for piece in problem.pieces)


def _select(log: Log, problem: Problem, *, family: str, rotary: bool, confidence: float) -> Selection:
    rows = _rows(problem)
    if rows < FEWEST_ROWS:
        raise InputError(
            f"{log.name}: the joint slides in {counted(rows, 'row')} (five for each cycle of the band) only; there "
            f"must be at least {FEWEST_ROWS}"
        )
    try:
        return select_terms(
            problem, family=family, both_ways=_moves_both_ways(problem), rotary=rotary, confidence=confidence
        )
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{log.name}: the log does not determine a joint: {error}") from error


def _moves_both_ways(problem: Problem) -> bool:
    direction = np.concatenate([piece.direction[piece.slides] for piece in problem.pieces])
    return bool(min(np.mean(direction > 0.5), np.mean(direction < -0.5)) >= BOTH_WAYS)


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

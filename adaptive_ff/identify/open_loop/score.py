"""Open-loop score: a model trained on one log, and its simulation of another one.

It is the protocol of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot, 2019): identified on one record, the model
simulates the position of the other from its force alone, and the root mean square of the error counts, without the
first samples. Nothing is chosen on the other record: how much it counts that viscous friction differs by direction,
that there is a force over the position and how far it is shrunk, is found by blocked cross-validation on the first, in
the same measure, the error of an open-loop simulation over as long as a block. Used is the mean of all these structures
with shares by this error (:mod:`adaptive_ff.identify.open_loop.mean`), because which of them is the best hangs on the
last digits of the log.

Whether friction has the map over position that is asked for, is chosen among the means without and with each map: the
one of fewest parameters within a standard error of the best one, on paired differences (L. Breiman et al.,
"Classification and Regression Trees", 1984, section 3.4.3); of a model that is shrunk their effective number counts
(:mod:`adaptive_ff.identify.open_loop.shrinkage`).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from adaptive_ff.adaptive.learning.friction_map import NO_MAP, MapParameters, coefficient_count
from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.errors import InputError
from adaptive_ff.identify.identification import check_delay, identify_log
from adaptive_ff.identify.maps.map_columns import MapAsked, check_asked, check_periods
from adaptive_ff.identify.open_loop.mean import Validated, held_out_squares, mean_of_all
from adaptive_ff.identify.open_loop.shrinkage import fit_path
from adaptive_ff.identify.open_loop.simulation import FIRST, OpenLoopModel, Record
from adaptive_ff.identify.open_loop.slopes import Training
from adaptive_ff.identify.preparation import Prepared, prepare
from adaptive_ff.identify.rows.band import uniform
from adaptive_ff.logs.derivatives import Array, lowpass
from adaptive_ff.logs.log import Log, check_log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KNOTS = (1, 65)
"""Numbers of knots that are compared: an offset, and a force whose detail the shrinkage limits."""

WEIGHTS = (16.0, 5.0, 1.6, 0.5, 0.16, 0.05)
"""Weights of the shrinkage that are compared, from strong to weak."""

FEWEST_HATS = 4
"""Hats below which no fewer are tried."""

BLOCKS = 5
"""Blocks of the training record; simulations of the training are as long as one."""

WINDOW = 1.0
"""Length of the short simulations of the score, s."""

SETTLING = 20
"""Samples that do not count at the start of a simulation, as in the benchmark."""

VELOCITY_BAND = 100.0
"""Band of the velocity that a simulation starts with, Hz, at most a quarter of the sampling frequency."""


class Choice(NamedTuple):
    """The mean of the structures that have the same map of friction over position.

    Attributes
    ----------
    error, squares : float, tuple of float
        Its error on blocks that were held out, rad, and its square on each, rad^2.
    mapped : int
        Coefficients of the map; zero without one.
    parameters : float
        Effective number of parameters, the mean of that of the structures.
    by_direction : float
        Share of the structures whose viscous friction differs by direction.
    structures : tuple of dict
        The structures: ``share``, ``knots``, ``by_direction``, ``weight`` of the shrinkage (zero where nothing depends
        on the position), ``error`` on blocks that were held out (rad), effective ``parameters``; largest share first.
    """

    error: float
    squares: tuple[float, ...]
    mapped: int = 0
    parameters: float = 0.0
    by_direction: float = 0.0
    structures: tuple[dict[str, Any], ...] = ()


def choose_mean(choices: Sequence[Choice]) -> Choice:
    """Return the mean of fewest parameters that is no more than one standard error behind the best one."""
    best = min(choices, key=lambda choice: choice.error)
    near = []
    for choice in choices:
        behind = np.array(choice.squares) - np.array(best.squares)
        if float(np.sum(behind)) <= math.sqrt(behind.size * float(np.var(behind, ddof=1))):
            near.append(choice)
    return min(near, key=lambda choice: (choice.parameters, choice.error))


@dataclass(frozen=True, eq=False)
class Score:
    """What a model makes of another log in open loop; positions in rad, or m.

    Attributes
    ----------
    trained, tested : str
        Names of the logs.
    model : OpenLoopModel
        The model.
    choices : list of Choice
        Means without and with each map that were compared on the training record, the one with the smallest error
        first; see ``choose_mean`` for the one that is used.
    rms, fit, windows : float
        Error of the simulation of the whole other log, root mean square; how much of its variation is explained, per
        cent; root mean square over simulations of 1 s.
    training_rms : float
        Error of the simulation of the whole training record.
    time, measured, simulated : ndarray, shape (n,)
        The other log.
    linear : bool
        Whether it is a linear axis.
    cautions : list of str
        What was done about the logs, or is probably wrong with them, a sentence each.
    """

    trained: str
    tested: str
    model: OpenLoopModel
    choices: list[Choice]
    rms: float
    fit: float
    windows: float
    training_rms: float
    time: Array
    measured: Array
    simulated: Array
    linear: bool
    cautions: list[str] = field(default_factory=list)

    @property
    def chosen(self) -> Choice:
        """The mean that is used."""
        return choose_mean(self.choices)

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        figures = ("trained", "tested", "rms", "fit", "windows", "training_rms")
        result: dict[str, Any] = {name: getattr(self, name) for name in figures}
        result["unit"] = "m" if self.linear else "rad"
        result["warnings"] = self.cautions
        result["model"] = self.model.to_dict()
        result["choices"] = [choice._asdict() for choice in self.choices]
        return result

    def plot(self, folder: str | Path | None = None) -> "dict[str, Figure]":
        """Draw the simulation; write it as ``score.png`` where a folder is given."""
        from adaptive_ff.report.score_plots import plot_score

        return plot_score(self, folder)


def score_log(
    train: Log,
    test: Log,
    *,
    linear: bool = False,
    torque_delay: float = 0.0,
    position_periods: Sequence[float] = (),
    position_hats: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Score:
    """Train a model on a log, and simulate another one with it in open loop.

    Parameters
    ----------
    train, test : Log
        Logs of the same joint, with positions.
    linear : bool, optional
        Whether it is a linear axis, in m and N.
    torque_delay : float, optional
        Time after its stamp at which a torque acts, s, in both logs: half a sample time where the stamp is that of the
        command and the torque is held until the next. Between samples it is taken on straight lines.
    position_periods : sequence of float, optional
        Known periods, rad (m), over which friction may vary with position.
    position_hats : int, optional
        Largest number of hats, evenly over the positions of the training, of a map of friction over position; half
        as many, and again, down to ``FEWEST_HATS``, are tried as well. Periods and hats are used where the blocks that
        were held out are simulated better with them.
    progress : callable, optional
        Is called with the share done, from 0 to 1.

    Raises
    ------
    InputError
        A log has no position, a defect, or does not determine a joint, or an argument is out of range.
    """
    check_log("train", train)
    check_log("test", test)
    check_delay(torque_delay)
    asked = MapAsked(tuple(position_periods), position_hats)
    check_asked(asked, train)
    prepared = [_prepared(log, linear=linear) for log in (train, test)]
    records = [_record(one, torque_delay) for one in prepared]
    check_periods(asked, train.name, float(np.min(records[0].position)), float(np.max(records[0].position)))
    found = identify_log(train, held_out=0.0, torque_delay=torque_delay, linear=linear, model="offset")
    start = np.array([*(found.selection.chosen.values[name] for name in FIRST[:3]), 0.0])
    offset = found.selection.chosen.values.get("offset", 0.0)
    structures = [
        _begin(np.concatenate([start, np.full(knots, offset)]), variation, records[0])
        for variation in (NO_MAP, *_maps(position_periods, position_hats, records[0]))
        for knots in KNOTS
    ]
    made: dict[int, list[Validated]] = {}
    for place, (begin, by_direction) in enumerate(product(structures, (False, True))):
        made.setdefault(begin.coefficients.size, []).extend(_validated(begin, records[0], by_direction=by_direction))
        if progress is not None:
            progress((place + 1) / (2 * len(structures)))
    means = sorted((_mean(members, records[0]) for members in made.values()), key=lambda one: one[0].error)
    choices = [choice for choice, _ in means]
    model = means[choices.index(choose_mean(choices))][1]
    said = [f"{one.log.name}: {sentence}" for one in prepared for sentence in one.said]
    if train.is_same_record(test):
        said.append(f"{test.name}: is the log that the model is trained on; its error says nothing about other motion")
    return replace(_judge(train, test, model, choices, records, linear=linear), cautions=list(dict.fromkeys(said)))


def _validated(begin: OpenLoopModel, record: Record, *, by_direction: bool) -> list[Validated]:
    """Return a structure with each weight of the shrinkage, fitted without each block."""
    knots = begin.force.size
    weights = WEIGHTS if knots > 1 or begin.coefficients.size else (0.0,)
    length = record.position.size // BLOCKS
    blocks = np.arange(BLOCKS) * length
    fits, held = [], np.empty((len(weights), BLOCKS))
    for block in range(BLOCKS):
        training = Training(record, np.delete(blocks, block), length, SETTLING)
        fits.append(fit_path(begin, training, weights, by_direction=by_direction))
        for place, fitted in enumerate(fits[-1]):
            unseen = fitted.model.errors(record, blocks[block : block + 1], length)[:, SETTLING:]
            held[place, block] = float(np.mean(unseen**2))
    made = []
    for weight, squares, same in zip(weights, held, zip(*fits, strict=True), strict=True):
        models, parameters = tuple(one.model for one in same), float(np.mean([one.parameters for one in same]))
        made.append(Validated(knots, by_direction, weight, models, tuple(squares.tolist()), parameters))
    return made


def _mean(members: list[Validated], record: Record) -> tuple[Choice, OpenLoopModel]:
    """Return the mean of structures with the same map, as it is compared, and its model."""
    model, shares = mean_of_all(members)
    squares = held_out_squares(members, record, record.position.size // BLOCKS, SETTLING)
    plain = ("knots", "by_direction", "weight", "error", "parameters")
    listed = [
        {"share": share, **{name: getattr(one, name) for name in plain}}
        for share, one in zip(shares.tolist(), members, strict=True)
    ]
    choice = Choice(
        math.sqrt(float(np.mean(squares))),
        tuple(squares.tolist()),
        members[0].models[0].coefficients.size,
        float(shares @ [one.parameters for one in members]),
        float(shares @ [one.by_direction for one in members]),
        tuple(sorted(listed, key=lambda one: -one["share"])),
    )
    return choice, model


def _maps(periods: Sequence[float], hats: int, record: Record) -> list[MapParameters]:
    """Return the maps of friction over position that are compared: with all periods, and each number of hats."""
    if not hats:
        return [map_parameters(periods, 0, None, 0.0, 1.0)] if periods else []
    ends = float(np.min(record.position)), float(np.max(record.position))
    numbers = [hats]
    while numbers[-1] // 2 >= FEWEST_HATS:
        numbers.append(numbers[-1] // 2)
    return [map_parameters(periods, number, ends, 0.0, 1.0) for number in numbers]


def _judge(
    train: Log, test: Log, model: OpenLoopModel, choices: list[Choice], records: list[Record], *, linear: bool
) -> Score:
    training, other = records
    whole = model.errors(other, np.array([0]), other.position.size)[0]
    window = round(WINDOW / other.period)
    starts = np.arange(0, other.position.size - window + 1, window)
    return Score(
        train.name,
        test.name,
        model,
        choices,
        rms=_rms(whole[SETTLING:]),
        fit=100.0 * (1.0 - _rms(whole[SETTLING:]) / float(np.std(other.position[SETTLING:]))),
        windows=_rms(model.errors(other, starts, window)[:, SETTLING:]),
        training_rms=_rms(model.errors(training, np.array([0]), training.position.size)[0, SETTLING:]),
        time=other.period * np.arange(other.position.size, dtype=np.float64),
        measured=other.position,
        simulated=other.position + whole,
        linear=linear,
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _prepared(log: Log, *, linear: bool) -> Prepared:
    """Return a log that can be simulated from end to end."""
    if log.position is None:
        raise InputError(f"{log.name}: a score takes a position, which is what the simulation is compared with")
    prepared = prepare(log, linear=linear)
    if len(prepared.pieces) != 1 or prepared.skipped:
        reason = prepared.skipped[0].reason if prepared.skipped else "it has several pieces"
        raise InputError(f"{log.name}: an open-loop simulation takes a log without defect; {reason}")
    return prepared


def _record(prepared: Prepared, torque_delay: float) -> Record:
    """Return a log on a uniform grid, with velocities to start from; the delay of the torque in s."""
    log = prepared.log
    time, position, torque = uniform(log, prepared.pieces[0], prepared.period)
    if torque_delay != 0.0:
        torque = np.interp(time - torque_delay, time, torque)
    fewest, longest = 2 * SETTLING * BLOCKS, WINDOW / (SETTLING + 1)
    if position.size < fewest or prepared.period > longest:
        raise InputError(
            f"{log.name}: {position.size} samples, {prepared.period:.3g} s apart, are not enough for a score; it takes "
            f"{fewest} or more, at most {longest:.3g} s apart"
        )
    smooth = lowpass(position, (min(VELOCITY_BAND, 0.25 / prepared.period),), prepared.period)
    return Record(
        np.ascontiguousarray(position),
        np.gradient(smooth, prepared.period),
        np.ascontiguousarray(torque),
        prepared.period,
    )


def _begin(values: Array, variation: MapParameters, record: Record) -> OpenLoopModel:
    """Return the model that a fit starts from: that of the torque, without anything over the position."""
    low, high = float(np.min(record.position)), float(np.max(record.position))
    inertia, coulomb, viscous, asymmetry = (float(value) for value in values[:4])
    nothing = np.zeros(coefficient_count(variation))
    return OpenLoopModel(inertia, coulomb, viscous, asymmetry, low, high, values[4:], variation, nothing)

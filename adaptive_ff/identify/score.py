"""Open-loop score: a model trained on one log, and its simulation of another one.

It is the protocol of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot, 2019): identified on one record, the model
simulates the position of the other from its force alone, and the root mean square of the error counts, without the
first samples. Nothing is chosen on the other record: whether viscous friction differs by direction, how many knots
the force over the position has, and whether friction has the map over position that is asked for, is chosen by
blocked cross-validation on the first, in the same measure, the error of an open-loop simulation over as long as a
block. Used is the structure of fewest parameters within a standard error of the best one, on paired differences
(L. Breiman et al., "Classification and Regression Trees", 1984, section 3.4.3).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.friction_map import NO_MAP, MapParameters, coefficient_count
from adaptive_ff.adaptive.map_settings import map_parameters
from adaptive_ff.errors import InputError
from adaptive_ff.identify.filtering import uniform
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.map_columns import MapAsked, check_asked
from adaptive_ff.identify.open_loop import FIRST, OpenLoopModel, Record
from adaptive_ff.identify.preparation import prepare
from adaptive_ff.logs.derivatives import Array, lowpass
from adaptive_ff.logs.log import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KNOTS = (1, 4, 8, 16, 24, 32)
"""Numbers of knots that are compared."""

MAPPED_KNOTS = (1, 4, 8)
"""The same beside a map of friction over position."""

FEWEST_HATS = 4
"""Hats below which no fewer are tried."""

BLOCKS = 5
"""Blocks of the training record; simulations of the training are as long as one."""

WINDOW = 1.0
"""Length of the short simulations of the score, s."""

SETTLING = 20
"""Samples that do not count at the start of a simulation, as in the benchmark."""

STEPS = 6
"""Steps of Gauss and Newton."""

NUDGE = 1e-4
"""Step of the difference quotients, over the size of a parameter."""

VELOCITY_BAND = 100.0
"""Band of the velocity that a simulation starts with, Hz, at most a quarter of the sampling frequency."""


class Choice(NamedTuple):
    """A structure of the model.

    Attributes
    ----------
    knots : int
        Knots of the force over position.
    by_direction : bool
        Whether viscous friction differs by direction.
    error, squares : float, tuple of float
        Its error on blocks that were held out, rad, and its square on each, rad^2.
    mapped : int
        Coefficients of a map of friction over position; zero without one.
    """

    knots: int
    by_direction: bool
    error: float
    squares: tuple[float, ...] = ()
    mapped: int = 0

    @property
    def parameters(self) -> int:
        """Number of parameters."""
        return self.knots + 3 + self.by_direction + self.mapped


def choose_structure(choices: Sequence[Choice]) -> Choice:
    """Return the structure of fewest parameters that is no more than one standard error behind the best one."""
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
        All structures that were compared on the training record, the one with the smallest error first; see
        ``choose_structure`` for the one that is used.
    rms, fit, windows : float
        Error of the simulation of the whole other log, root mean square; how much of its variation is explained, per
        cent; root mean square over simulations of 1 s.
    training_rms : float
        Error of the simulation of the whole training record.
    time, measured, simulated : ndarray, shape (n,)
        The other log.
    linear : bool
        Whether it is a linear axis.
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

    @property
    def chosen(self) -> Choice:
        """The structure that is used."""
        return choose_structure(self.choices)

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        figures = ("trained", "tested", "rms", "fit", "windows", "training_rms")
        result: dict[str, Any] = {name: getattr(self, name) for name in figures}
        result["unit"] = "m" if self.linear else "rad"
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
        A log has no position, a defect, or does not determine a joint.
    """
    check_asked(MapAsked(tuple(position_periods), position_hats), train)
    records = [_record(log, linear=linear) for log in (train, test)]
    found = identify_log(train, held_out=0.0, linear=linear, model="offset")
    start = np.array([*(found.selection.chosen.values[name] for name in FIRST[:3]), 0.0])
    offset = found.selection.chosen.values.get("offset", 0.0)
    choices, models = [], {}
    length = records[0].position.size // BLOCKS
    structures = [*product(KNOTS, (False, True), [NO_MAP])]
    structures += product(MAPPED_KNOTS, (False, True), _maps(position_periods, position_hats, records[0]))
    for place, (knots, by_direction, variation) in enumerate(structures):
        mapped = coefficient_count(variation)
        values = np.concatenate([start, np.full(knots, offset), np.zeros(mapped)])
        begin = _model(values, knots, variation, records[0])
        held = []
        blocks = np.arange(BLOCKS) * length
        for block in range(BLOCKS):
            fitted = _train(begin, records[0], np.delete(blocks, block), length, by_direction=by_direction)
            unseen = fitted.errors(records[0], blocks[block : block + 1], length)[:, SETTLING:]
            held.append(float(np.mean(unseen**2)))
        choices.append(Choice(knots, by_direction, math.sqrt(float(np.mean(held))), tuple(held), mapped))
        models[knots, by_direction, mapped] = _train(begin, records[0], blocks, length, by_direction=by_direction)
        if progress is not None:
            progress((place + 1) / len(structures))
    choices.sort(key=lambda choice: choice.error)
    chosen = choose_structure(choices)
    model = models[chosen.knots, chosen.by_direction, chosen.mapped]
    return _judge(train, test, model, choices, records, linear=linear)


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


def _record(log: Log, *, linear: bool) -> Record:
    """Return a log on a uniform grid, with velocities to start from."""
    if log.position is None:
        raise InputError(f"{log.name}: a score takes a position, which is what the simulation is compared with")
    prepared = prepare(log, linear=linear)
    if len(prepared.pieces) != 1 or prepared.skipped:
        reason = prepared.skipped[0].reason if prepared.skipped else "it has several pieces"
        raise InputError(f"{log.name}: an open-loop simulation takes a log without defect; {reason}")
    _, position, torque = uniform(log, prepared.pieces[0], prepared.period)
    smooth = lowpass(position, (min(VELOCITY_BAND, 0.25 / prepared.period),), prepared.period)
    return Record(
        np.ascontiguousarray(position),
        np.gradient(smooth, prepared.period),
        np.ascontiguousarray(torque),
        prepared.period,
    )


def _model(values: Array, knots: int, variation: MapParameters, record: Record) -> OpenLoopModel:
    low, high = float(np.min(record.position)), float(np.max(record.position))
    inertia, coulomb, viscous, asymmetry = (float(value) for value in values[:4])
    force, coefficients = values[4 : 4 + knots].copy(), values[4 + knots :].copy()
    return OpenLoopModel(inertia, max(coulomb, 0.0), viscous, asymmetry, low, high, force, variation, coefficients)


def _train(
    begin: OpenLoopModel, record: Record, starts: NDArray[np.int64], length: int, *, by_direction: bool
) -> OpenLoopModel:
    """Fit a model to open-loop simulations from each start, by steps of Gauss and Newton that lower the error."""
    knots, variation = begin.force.size, begin.variation
    values = np.concatenate([[getattr(begin, name) for name in FIRST], begin.force, begin.coefficients])
    scale = np.abs(values) + 0.01 * np.max(np.abs(values[1:3]))
    scale[0], scale[3] = abs(values[0]), abs(values[2])
    scale[4 : 4 + knots] = abs(values[1])
    scale[4 + knots :] = 1.0
    free = np.flatnonzero([index != 3 or by_direction for index in range(values.size)])

    def errors(trial: Array) -> Array:
        found: Array = _model(trial, knots, variation, record).errors(record, starts, length)[:, SETTLING:].ravel()
        return found

    now = errors(values)
    for _ in range(STEPS):
        slopes = np.empty((now.size, free.size))
        for column, index in enumerate(free):
            nudged = values.copy()
            nudged[index] += NUDGE * scale[index]
            slopes[:, column] = (errors(nudged) - now) / NUDGE
        normal = slopes.T @ slopes
        ridge = 1e-6 * np.trace(normal) / free.size * np.eye(free.size)
        step = -np.linalg.solve(normal + ridge, slopes.T @ now)
        for share in (1.0, 0.5, 0.25, 0.1):
            trial = values.copy()
            trial[free] += share * step * scale[free]
            if trial[0] <= 0.0:
                continue
            after = errors(trial)
            if float(after @ after) < float(now @ now):
                break
        else:
            break
        done = float(after @ after) > 0.999 * float(now @ now)
        values, now = trial, after
        if done:
            break
    return _model(values, knots, variation, record)

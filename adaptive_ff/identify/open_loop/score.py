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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.identify.identification import check_delay, identify_log
from adaptive_ff.identify.maps.map_columns import MapAsked, check_asked, check_periods
from adaptive_ff.identify.open_loop.changed_joint import (
    ChangedJoint,
    fitted_changes,
    root_mean_square,
    whole_error,
    words_of_change,
)
from adaptive_ff.identify.open_loop.choice import Choice, choose_mean, mean_of_map
from adaptive_ff.identify.open_loop.mean import Validated
from adaptive_ff.identify.open_loop.records import WINDOW, prepare_whole, record_of
from adaptive_ff.identify.open_loop.simulation import FIRST, OpenLoopModel, Record
from adaptive_ff.identify.open_loop.structures import SETTLING, structures, validated, work_of
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.logs.log import Log, check_log

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    changes : list of ChangedJoint
        What of the error on the other log a change of one parameter explains, the one that leaves least first; they
        have no part in the model.
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
    changes: list[ChangedJoint] = field(default_factory=list)
    cautions: list[str] = field(default_factory=list)

    @property
    def chosen(self) -> Choice:
        """The mean that is used."""
        return choose_mean(self.choices)

    @property
    def explanation(self) -> str:
        """A sentence on what explains most of the error on the other log; empty where no single number does."""
        return words_of_change(self.changes[0], self.rms, linear=self.linear) if self.changes else ""

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        figures = ("trained", "tested", "rms", "fit", "windows", "training_rms")
        result: dict[str, Any] = {name: getattr(self, name) for name in figures}
        result["unit"] = "m" if self.linear else "rad"
        result["changes"] = [change._asdict() for change in self.changes]
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
    prepared = [prepare_whole(log, linear=linear) for log in (train, test)]
    records = [record_of(one, torque_delay) for one in prepared]
    check_periods(asked, train.name, float(np.min(records[0].position)), float(np.max(records[0].position)))
    found = identify_log(train, held_out=0.0, torque_delay=torque_delay, linear=linear, model="offset")
    start = np.array([*(found.selection.chosen.values[name] for name in FIRST[:3]), 0.0])
    offset = found.selection.chosen.values.get("offset", 0.0)
    compared = structures(start, offset, records[0], position_periods, position_hats)
    made: dict[int, list[Validated]] = {}
    done, work = 0.0, 2 * sum(work_of(begin) for begin in compared)
    for begin, by_direction in product(compared, (False, True)):
        share = work_of(begin) / work

        def watch(of_it: float, done: float = done, share: float = share) -> None:
            if progress is not None:
                progress(done + of_it * share)

        fits = validated(begin, records[0], by_direction=by_direction, watch=watch)
        made.setdefault(begin.coefficients.size, []).extend(fits)
        done += share
    means = sorted((mean_of_map(members, records[0]) for members in made.values()), key=lambda one: one[0].error)
    choices = [choice for choice, _ in means]
    model = means[choices.index(choose_mean(choices))][1]
    said = [f"{one.log.name}: {sentence}" for one in prepared for sentence in one.said]
    if train.is_same_record(test):
        said.append(f"{test.name}: is the log that the model is trained on; its error says nothing about other motion")
    return replace(_judge(train, test, model, choices, records, linear=linear), cautions=list(dict.fromkeys(said)))


def _judge(
    train: Log, test: Log, model: OpenLoopModel, choices: list[Choice], records: list[Record], *, linear: bool
) -> Score:
    training, other = records
    whole = model.errors(other, np.array([0]), other.position.size)[0]
    rms = root_mean_square(whole[SETTLING:])
    window = round(WINDOW / other.period)
    starts = np.arange(0, other.position.size - window + 1, window)
    return Score(
        train.name,
        test.name,
        model,
        choices,
        rms=rms,
        fit=100.0 * (1.0 - rms / float(np.std(other.position[SETTLING:]))),
        windows=root_mean_square(model.errors(other, starts, window)[:, SETTLING:]),
        training_rms=root_mean_square(whole_error(model, training)),
        time=other.period * np.arange(other.position.size, dtype=np.float64),
        measured=other.position,
        simulated=other.position + whole,
        linear=linear,
        changes=fitted_changes(model, other),
    )

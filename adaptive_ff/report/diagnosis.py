"""Diagnosis of the adaptive controller in words: what it learns, how sure it is, what its feedforward saves.

It reads the state and changes nothing, so it may be asked at any time, also on a robot between two samples (it takes
some tenths of a millisecond).
"""

import io
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table
from rich.text import Text

from adaptive_ff.adaptive.adaptive_state import AdaptiveParameters, AdaptiveState
from adaptive_ff.adaptive.controller import AdaptiveBase
from adaptive_ff.adaptive.learning.candidate_choice import assess_choice
from adaptive_ff.adaptive.learning.candidates import MEMORIES
from adaptive_ff.adaptive.learning.estimator_state import carries_loads
from adaptive_ff.adaptive.learning.fed_model import gate_speed
from adaptive_ff.adaptive.learning.uncertainty import Confidence, assess, mean_squared_error
from adaptive_ff.friction.model import GRAVITY, RIPPLE, unit_of
from adaptive_ff.report.diagnosis_map import map_sentences
from adaptive_ff.report.diagnosis_supervision import supervision
from adaptive_ff.report.diagnosis_warnings import NOT_IDENTIFIABLE, find_warnings

WIDTH = 120
"""Width of the text, characters."""


YOUTH = 10.0
"""Sliding motion, s, before which the uncertainty is too small."""


class Recorded(Protocol):
    """Series of a run: realised torque, and the feedforward in it, N m."""

    @property
    def torque(self) -> NDArray[np.float64]:
        """Torque, shape (n,)."""

    @property
    def feedforward(self) -> NDArray[np.float64]:
        """Feedforward in it, shape (n,)."""


@dataclass(frozen=True)
class ParameterDiagnosis:
    """What is known of one parameter.

    Attributes
    ----------
    name, unit : str
        Name and unit.
    estimate : float
        The estimate that is fed forward.
    uncertainty : float
        How far it may be off, as a standard deviation; see ``confidence`` for what that is not.
    identifiable : bool
        Whether the recent motion excites it, so that the data determine it.
    apart : bool
        Whether it is identifiable, or not at all; False where only a combination with other parameters is.
    pace : float
        Time constant with which it follows a change of the joint, s of sliding motion; infinite where it does not.
    """

    name: str
    unit: str
    estimate: float
    uncertainty: float
    identifiable: bool
    apart: bool
    pace: float

    @property
    def verdict(self) -> str:
        """Whether the recent motion identifies it, in a few words."""
        if self.identifiable:
            return "identifiable"
        return "not identifiable" if self.apart else "only in combination"


@dataclass(frozen=True)
class Diagnosis:
    """What the adaptive controller knows and does.

    Attributes
    ----------
    learning : bool
        Whether it learnt from the last sample.
    learning_words : str
        The same in words, with the reason.
    learnt : float
        Time that it has learnt from so far, s of sliding motion.
    parameters : tuple of ParameterDiagnosis
        The parameters.
    unexplained : float
        Root of the mean square of the filtered torque that the model did not predict, over the recent sliding motion,
        N m.
    largest_torque : float
        Largest filtered torque so far, N m.
    feedforward_lag : float
        Friction lag that the feedforward is computed with, s.
    feedback_torque, model_torque : float
        What feedback and model gave of the last command, N m.
    feedback_share : float or None
        Root mean square of the feedback torque over that of the whole, in the second half of a run, where one was
        given.
    rejected : int
        Measurements that were not finite.
    supervision : tuple of str
        What is distrusted of the model and why, and what the observer does, a sentence each.
    warnings : tuple of str
        What an engineer should look at, a sentence each.
    friction_map : tuple of str
        How friction depends on position and load, where that is learnt, a sentence each.
    """

    learning: bool
    learning_words: str
    learnt: float
    parameters: tuple[ParameterDiagnosis, ...]
    unexplained: float
    largest_torque: float
    feedforward_lag: float
    feedback_torque: float
    model_torque: float
    feedback_share: float | None
    rejected: int
    supervision: tuple[str, ...]
    warnings: tuple[str, ...]
    friction_map: tuple[str, ...] = ()

    @property
    def excited(self) -> bool:
        """Whether every parameter is identifiable from the recent motion: persistent excitation."""
        return all(parameter.identifiable for parameter in self.parameters)

    def table(self) -> Table:
        """Return the parameters as a table for a terminal."""
        table = Table(box=SIMPLE)
        for heading in ("parameter", "estimate", "+-", "follows in, s", "by the recent motion"):
            table.add_column(heading, justify="left" if heading in ("parameter", "by the recent motion") else "right")
        for one in self.parameters:
            pace = f"{one.pace:.2g}" if one.pace < 1e4 else "-"
            table.add_row(f"{one.name}, {one.unit}", f"{one.estimate:.4g}", f"{one.uncertainty:.2g}", pace, one.verdict)
        return table

    def sentences(self) -> list[str]:
        """Return what is to be said beside the table, warnings last."""
        said = [f"{self.learning_words} Learnt from {self.learnt:.3g} s of sliding motion so far."]
        said += self._excitation()
        if self.learnt > 0.0:
            if self.learnt < YOUTH:
                said.append(
                    f"Young: up to {YOUTH:g} s of sliding motion the estimates are biased by more than +- says."
                )
            said.append(
                f"The model leaves {self.unexplained:.2g} N m (rms) of the torque unexplained; the largest so far was "
                f"{self.largest_torque:.3g} N m."
            )
            said.append(f"Reversals are fed forward with a lag of {1e3 * self.feedforward_lag:.3g} ms.")
        given = f"the model gave {self.model_torque:.3g}, feedback {self.feedback_torque:.3g} N m"
        said.append(f"Of the last command {given}.")
        if self.feedback_share is not None:
            share = f"{100.0 * self.feedback_share:.2g} %"
            said.append(f"Over the second half of the run feedback did {share} of the torque (rms).")
        said += [*self.friction_map, *self.supervision]
        return said + [f"Warning: {warning}" for warning in self.warnings]

    def _excitation(self) -> list[str]:
        if self.learnt == 0.0:
            return []
        if self.excited:
            return ["The recent sliding motion excites every parameter: all are identifiable."]
        tangled = [one.name for one in self.parameters if not one.identifiable and not one.apart]
        silent = [one.name for one in self.parameters if not one.identifiable and one.apart]
        said = []
        if silent:
            said.append(f"The recent sliding motion does not identify {_listed(silent)}: do not rely on these numbers.")
        if len(tangled) == 1:
            said.append(f"The recent sliding motion identifies {tangled[0]} only in combination with the others.")
        elif tangled:
            names = _listed(tangled)
            said.append(f"The recent sliding motion identifies a combination of {names}, but not each of them.")
        return said

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Print the table and the sentences."""
        yield self.table()
        for sentence in self.sentences():
            yield Text(sentence)

    def __str__(self) -> str:
        text = io.StringIO()
        Console(file=text, width=WIDTH, color_system=None).print(self)
        return text.getvalue().strip("\n")


def diagnose(controller: AdaptiveBase, run: Recorded | None = None) -> Diagnosis:
    """Diagnose an adaptive controller.

    Parameters
    ----------
    controller : AdaptiveBase
        The controller; it is left as it is.
    run : Run, optional
        A run of it, or any object with the recorded series ``torque`` and ``feedforward``: from it is computed what
        share of the torque feedback still did. The state of a controller does not hold it.

    Returns
    -------
    Diagnosis
        What it knows and does.

    Raises
    ------
    ValueError
        The series of the run are empty or of unequal length.
    """
    block, state = controller.parameters, controller.state
    estimator = state.estimator
    confidence = assess(block.estimator, estimator, block.period)
    parameters = _parameters(controller, confidence)
    learning, words = _learning(block, state)
    unexplained = math.sqrt(mean_squared_error(block.estimator, estimator)) * block.estimator.torque_scale
    model_torque = state.model_torques[0]
    return Diagnosis(
        learning=learning,
        learning_words=words,
        learnt=float(estimator.levels.learnt),
        parameters=parameters,
        unexplained=unexplained,
        largest_torque=float(estimator.levels.torque),
        feedforward_lag=controller.feedforward_lag,
        feedback_torque=state.feedback.commands[0] - model_torque - state.known_torques[0],
        model_torque=model_torque,
        feedback_share=None if run is None else feedback_share(run),
        rejected=controller.rejected,
        supervision=tuple(supervision(controller)),
        warnings=tuple(find_warnings(controller, confidence, unexplained)),
        friction_map=tuple(map_sentences(controller.learnt_map)),
    )


def feedback_share(run: Recorded) -> float:
    """Return the root mean square of the feedback torque over that of the whole torque, in the second half of a run.

    One minus its square is not what the feedforward saves: the two parts are correlated.

    Raises
    ------
    ValueError
        The series are empty or of unequal length.
    TypeError
        The run has no such series.
    """
    if not (hasattr(run, "torque") and hasattr(run, "feedforward")):
        raise TypeError(f"run = {run!r} is not allowed: it must have the series torque and feedforward")
    torque, feedforward = np.asarray(run.torque), np.asarray(run.feedforward)
    if torque.ndim != 1 or torque.size == 0 or feedforward.shape != torque.shape:
        raise ValueError(
            f"torque has shape {torque.shape} and feedforward {feedforward.shape}; they must be series of one length"
        )
    half = torque.size // 2
    whole = float(np.sqrt(np.mean(torque[half:] ** 2)))
    return float(np.sqrt(np.mean((torque - feedforward)[half:] ** 2))) / whole if whole > 0.0 else 0.0


def _parameters(controller: AdaptiveBase, confidence: Confidence) -> tuple[ParameterDiagnosis, ...]:
    memory, estimator = controller.parameters.estimator.memory, controller.state.estimator
    found = []
    for i, (name, value) in enumerate(list(controller.estimates.items())[: confidence.errors.size]):
        if name.startswith((*GRAVITY, *RIPPLE)) and not carries_loads(controller.parameters.estimator, estimator):
            continue  # there has been no position
        identifiable, share = bool(confidence.together[i] < NOT_IDENTIFIABLE), float(confidence.shares[i])
        apart = identifiable or bool(confidence.alone[i] >= NOT_IDENTIFIABLE)
        pace = memory / share if share > 0.0 else math.inf
        error = float(confidence.errors[i])
        found.append(ParameterDiagnosis(name, unit_of(name), value, error, identifiable, apart, pace))
    for one in assess_choice(controller.parameters.estimator, controller.state.estimator.candidates):
        unit, pace = unit_of(one.name), MEMORIES * memory if one.identifiable else math.inf
        found.append(ParameterDiagnosis(one.name, unit, one.value, one.error, one.identifiable, True, pace))
    return tuple(found)


def _learning(block: AdaptiveParameters, state: AdaptiveState) -> tuple[bool, str]:
    """Return whether the last sample was learnt from, and the reason in words."""
    if not state.enabled:
        return False, "Holds its estimates: enabled is False."
    if state.feedback.samples == 0:
        return False, "Has not made a step yet."
    if state.sliding > block.hold:
        return True, "Learns: the joint slides."
    if state.sliding == 0.0:
        return False, (
            f"Holds its estimates: the joint is slower than {gate_speed(block, state.estimator):.2g} rad/s or moves "
            "against its reference."
        )
    return False, (
        f"Holds its estimates: the joint slides, but must do so for {block.hold - state.sliding:.2g} s more "
        "until the filters have forgotten that it may have stuck."
    )


def _listed(names: list[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last

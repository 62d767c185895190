"""One controller in the closed loop of a scenario."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import Course, Record, empty_record, lay_course
from adaptive_ff.simulation.loop import run_compiled, run_plain, start_position
from adaptive_ff.simulation.metrics import Metrics, evaluate
from controllers import ESTIMATES, STEPS, Controller, Inputs, Output, without_estimates

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PART = 20_000
"""Samples between two reports of progress."""


class Foreign(NamedTuple):
    """A user's own controller, as parameters of the loop in plain Python.

    Attributes
    ----------
    controller : object
        Has a method ``step`` like :meth:`controllers.Controller.step`.
    accepted : frozenset of str
        Names of the keyword arguments that its ``step`` accepts; it is given no others.
    """

    controller: Any
    accepted: frozenset[str]


def own_controller(controller: Any) -> Foreign:
    """Return a user's controller with the keyword arguments that it accepts."""
    try:
        parameters = signature(controller.step).parameters.values()
    except (TypeError, ValueError):  # written in another language
        return Foreign(controller, frozenset(Inputs._fields))
    if any(parameter.kind is Parameter.VAR_KEYWORD for parameter in parameters):
        return Foreign(controller, frozenset(Inputs._fields))
    named = (Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    return Foreign(controller, frozenset(parameter.name for parameter in parameters if parameter.kind in named))


def _step_foreign(block: Foreign, state: None, inputs: Inputs) -> tuple[Output, None]:
    reference, following = inputs.reference, inputs.next_reference
    if "correction" not in block.accepted:  # one velocity is all it can follow: that of plan and outer loop together
        reference, following = reference + inputs.correction, following + inputs.correction
    others = {
        "next_reference": following,
        "correction": inputs.correction,
        "position": _known(inputs.position),
        "realised_torque": _known(inputs.realised_torque),
        "feedforward": inputs.feedforward,
        "inertia": _known(inputs.inertia),
        "dt": inputs.dt,
    }
    accepted = {name: value for name, value in others.items() if name in block.accepted}
    torque = block.controller.step(reference, inputs.velocity, **accepted)
    try:
        value = float(torque)
    except (TypeError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"the controller {block.controller!r} returned a torque of {torque!r}; it must be finite")
    return Output(value, 0.0), state


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


STEPS[Foreign] = _step_foreign
ESTIMATES[Foreign] = without_estimates


@dataclass(frozen=True)
class Run:
    """A run and its time series.

    Attributes
    ----------
    name : str
        Name of the controller.
    scenario : Scenario
        The scenario.
    time : ndarray, shape (samples,)
        Times of the samples, s.
    solver_time : ndarray, shape (steps + 1,)
        The solver's grid, s.
    reference, velocity : ndarray, shape (steps + 1,)
        Reference and true velocity on the solver's grid, rad/s.
    measured : ndarray, shape (samples,)
        Measured velocity, rad/s.
    torque, feedforward : ndarray, shape (samples,)
        Realised torque over the period that begins with the sample, and the feedforward in it, N m.
    friction : ndarray, shape (samples,)
        True friction torque, N m.
    estimates : dict of ndarray, shape (samples,)
        Physical estimates by name, for controllers that have any.
    metrics : Metrics
        Figures of merit.
    """

    name: str
    scenario: Scenario
    time: NDArray[np.float64]
    solver_time: NDArray[np.float64]
    reference: NDArray[np.float64]
    velocity: NDArray[np.float64]
    measured: NDArray[np.float64]
    torque: NDArray[np.float64]
    feedforward: NDArray[np.float64]
    friction: NDArray[np.float64]
    estimates: dict[str, NDArray[np.float64]]
    metrics: Metrics

    @property
    def final_estimates(self) -> dict[str, float]:
        """Estimates at the end of the run, by name."""
        return {name: float(series[-1]) for name, series in self.estimates.items()}

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Return the series at the samples by name, as they are written to CSV."""
        samples = self.scenario.sample_steps[:-1]
        named = {f"estimated_{name}": series for name, series in self.estimates.items()}
        return {
            "time": self.time,
            "reference": self.reference[samples],
            "velocity": self.velocity[samples],
            "measured": self.measured,
            "torque": self.torque,
            "feedforward": self.feedforward,
            "friction": self.friction,
            **named,
        }

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw tracking, error and torque; write the picture where a path is given."""
        from adaptive_ff.report.comparison_plots import plot_run

        return plot_run(self, path)


def simulate(
    scenario: Scenario,
    controller: Any = "adaptive",
    *,
    name: str | None = None,
    course: Course | None = None,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Run one controller in the closed loop.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    controller : str, Controller or any object with a method ``step``
        Name of a controller, or a controller in the state that it has; it ends in the state at the end of the run.
        An object of another class runs in the same loop, in plain Python, and is given those keyword arguments of
        :meth:`controllers.Controller.step` that its ``step`` accepts; where ``correction`` is not among them, it is
        part of the reference.
    name : str, optional
        Name of the run; by default that of the controller or its class.
    course : Course, optional
        What :func:`lay_course` returns for the scenario, where several controllers share it.
    progress : callable, optional
        Is called with the share done, from 0 to 1.

    Returns
    -------
    Run
        Time series and figures of merit.

    Raises
    ------
    InputError
        The name is not known.
    ArithmeticError
        The run did not stay finite.
    """
    if isinstance(controller, str):
        name, controller = name or controller, make_controller(scenario, controller)
    if isinstance(controller, type) or not callable(getattr(controller, "step", None)):
        raise InputError(
            f"controller = {controller!r} is not allowed: it must be a name or an object with a method step"
        )
    course = lay_course(scenario) if course is None else course
    own = not isinstance(controller, Controller)
    names = () if own else controller.estimate_names
    record = empty_record(course, len(names))
    block, state = (own_controller(controller), None) if own else (controller.parameters, controller.state)
    run = run_plain if own else run_compiled
    position = start_position(course)
    count = course.noise.size
    while position.sample < count:
        stop = min(position.sample + PART, count)
        state, position = run(block, state, course, position, stop, record)
        if progress is not None:
            progress(stop / count)
    if not own:
        controller.state = state
    return _finished(name or type(controller).__name__, scenario, course, record, names)


def _finished(name: str, scenario: Scenario, course: Course, record: Record, names: tuple[str, ...]) -> Run:
    time = scenario.times()
    with np.errstate(over="ignore", invalid="ignore"):
        metrics = evaluate(time, course.reference, record.velocity, record.torque, scenario.last_change)
    if not all(np.isfinite(list(vars(metrics).values()))):
        raise ArithmeticError(f"the run of {name} did not stay finite: {metrics}")
    return Run(
        name,
        scenario,
        time[course.samples[:-1]],
        time,
        course.reference,
        record.velocity,
        record.measured,
        record.torque,
        record.feedforward,
        record.friction,
        {key: record.estimates[:, i] for i, key in enumerate(names)},
        metrics,
    )

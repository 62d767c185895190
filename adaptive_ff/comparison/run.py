"""One controller in the closed loop of a scenario."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.comparison.registry import loop_of, make_controller
from adaptive_ff.comparison.running import drive_over
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import Course, Record, lay_course
from adaptive_ff.simulation.metrics import Metrics, PositionMetrics, evaluate, evaluate_position
from controllers import Controller
from controllers.arrays import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKS = 120
"""Times in a run at which the uncertainty of the estimates is noted."""


@dataclass(frozen=True, repr=False)
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
    position_error : ndarray, shape (steps + 1,), or None
        Planned minus true position on the solver's grid, rad; None without a position loop.
    position_metrics : PositionMetrics or None
        Figures of merit of the position; None without a position loop.
    monitors : dict of ndarray, shape (samples,)
        What a controller watches itself by, by name: trust, observer gain and observed torque (N m) of ``adaptive``.
    uncertainties : dict of ndarray, shape (marks,)
        How far each estimate may be off, as a standard deviation, for controllers that say so; no confidence interval,
        see :mod:`adaptive_ff.adaptive.uncertainty`.
    uncertainty_time : ndarray, shape (marks,)
        When, s.
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
    position_error: NDArray[np.float64] | None = None
    position_metrics: PositionMetrics | None = None
    monitors: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    uncertainties: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    uncertainty_time: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    def __repr__(self) -> str:
        """Return what was run and its settled error in one line."""
        settled = self.metrics.rms_error_settled
        return f"Run({self.name!r}, {self.solver_time[-1]:g} s, settled rms error {settled:.3g} rad/s)"

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
            **({} if self.position_error is None else {"position_error": self.position_error[samples]}),
            **named,
            **self.monitors,
        }

    def figures(self) -> dict[str, float]:
        """Return the figures of merit by name, those of the position too where there is a position loop."""
        return {**asdict(self.metrics), **({} if self.position_metrics is None else asdict(self.position_metrics))}

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
    uncertain: bool = True,
) -> Run:
    """Run one controller in the closed loop.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    controller : str, Controller or any object with a method ``step``
        Name of a controller, or a controller in the state that it has; it ends in the state at the end of the run.
        An object of another class runs in the same loop, in plain Python; see
        :class:`~adaptive_ff.comparison.own.OwnController` for what it is given and what of it is recorded.
    name : str, optional
        Name of the run; by default that of the controller or its class.
    course : Course, optional
        What :func:`lay_course` returns for the scenario, where several controllers share it.
    progress : callable, optional
        Is called with the share done, from 0 to 1.
    uncertain : bool, optional
        Whether to note how uncertain the estimates are along the run, for controllers that know.

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
        scenario = loop_of(scenario, controller)
        name, controller = name or controller, make_controller(scenario, controller)
    if isinstance(controller, type) or not callable(getattr(controller, "step", None)):
        raise InputError(
            f"controller = {controller!r} is not allowed: it must be a name or an object with a method step"
        )
    course = lay_course(scenario) if course is None else course
    marks: list[tuple[int, dict[str, float]]] = []
    if uncertain and isinstance(controller, Controller) and hasattr(controller, "uncertainties"):

        def note(sample: int) -> None:
            marks.append((sample, controller.uncertainties))

        record, names, watched = drive_over(controller, course, progress, note=note, parts=MARKS)
    else:
        record, names, watched = drive_over(controller, course, progress)
    return _finished(name or type(controller).__name__, scenario, course, record, names, watched, marks)


def _finished(
    name: str,
    scenario: Scenario,
    course: Course,
    record: Record,
    names: tuple[str, ...],
    watched: tuple[str, ...],
    marks: list[tuple[int, dict[str, float]]],
) -> Run:
    time = scenario.times()
    with np.errstate(over="ignore", invalid="ignore"):
        metrics = evaluate(time, course.reference, record.velocity, record.torque, scenario.last_change)
        position_error = None if scenario.position is None else course.planned - record.position
        position_metrics = (
            None if position_error is None else evaluate_position(time, position_error, scenario.last_change)
        )
    if not all(np.isfinite(list(vars(metrics).values()))):
        raise ArithmeticError(f"the run of {name} did not stay finite: {metrics}")
    sampled = time[course.samples[:-1]]
    return Run(
        name,
        scenario,
        sampled,
        time,
        course.reference,
        record.velocity,
        record.measured,
        record.torque,
        record.feedforward,
        record.friction,
        {key: record.estimates[:, i] for i, key in enumerate(names)},
        metrics,
        position_error,
        position_metrics,
        {key: record.monitors[:, i] for i, key in enumerate(watched)},
        {key: np.array([known[key] for _, known in marks]) for key in (marks[0][1] if marks else ())},
        sampled[[sample for sample, _ in marks]],
    )

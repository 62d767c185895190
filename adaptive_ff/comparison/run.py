"""One controller in the closed loop of a scenario; and the noise floor, the run of that loop without friction.

The joint of the floor keeps its inertia, payloads and spring, the loop its gains, sensor, drive and reference;
friction, loads, gravity and ripple of the drive are taken away, and the true inertia is fed forward. What remains of
the error is due to noise, sampling, delay and spring. No controller of friction can be expected to do better with the
same loop, but for what friction damps.
"""

import math
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.extensions.over_position import LearntMap
from adaptive_ff.comparison.own import Own
from adaptive_ff.comparison.registry import loop_of, make_controller, make_oracle
from adaptive_ff.comparison.running import Drive, check_progress, drive_over
from adaptive_ff.errors import InputError, check_kind
from adaptive_ff.reported import Reported
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.scenario import Scenario, check_scenario
from adaptive_ff.simulation.experiment import RunSetup, build_setup, without_noise
from adaptive_ff.simulation.metrics import Metrics, PositionMetrics, evaluate, evaluate_position
from controllers import Controller
from controllers.arrays import NDArray
from controllers.checks import checked_switch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_STEPS = 2_000_000  # solver steps of which all series are kept; of longer runs about as many samples are
MARKS = 120  # times in a run at which the uncertainty of the estimates is noted
NOISE_FLOOR = "noise_floor"  # name of the line in tables
SPRING = ("link_share", "link_stiffness", "link_damping")


@dataclass(frozen=True, eq=False, repr=False)
class Run(Reported):
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
        Reference and true velocity on the solver's grid, rad/s. Of a thinned run there is no such grid: these, their
        times and the position error are at the samples that are kept, as all series are.
    measured : ndarray, shape (samples,)
        Measured velocity, rad/s.
    torque, feedforward, friction : ndarray, shape (samples,)
        Realised torque over the period that begins with the sample, the feedforward in it, and true friction, N m.
    estimates : dict of ndarray, shape (samples,)
        Physical estimates by name, for controllers that have any.
    metrics : Metrics
        Figures of merit.
    position_error : ndarray, shape (steps + 1,), or None
        Planned minus true position on the solver's grid, rad; None without a position loop.
    position_metrics : PositionMetrics or None
        Figures of merit of the position; None without a position loop.
    monitors : dict of ndarray, shape (samples,)
        What a controller watches itself by, by name: of ``adaptive`` the probability of a change, observer gain and
        observed torque (N m).
    uncertainties, uncertainty_time : dict of ndarray, ndarray, shape (marks,)
        How far each estimate may be off, as a standard deviation, for controllers that say so; and when, s.
    thin : int
        One of so many samples is kept, and the last; the figures of merit are those of the whole run.
    friction_map : LearntMap or None
        Friction over position and load as the controller has learnt it at the end, where it does.
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
    thin: int = 1
    friction_map: LearntMap | None = None

    def __repr__(self) -> str:
        """Return what was run and its settled error in one line."""
        error = f"{self.metrics.rms_error_settled:.3g} {axis_unit(self.scenario.joint.axis, 'rad/s')}"
        return f"Run({self.name!r}, {self.solver_time[-1]:g} s, settled rms error {error})"

    @property
    def final_estimates(self) -> dict[str, float]:
        """Estimates at the end of the run, by name."""
        return {name: float(series[-1]) for name, series in self.estimates.items()}

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Return the series at the samples by name, as they are written to CSV."""
        samples = self.scenario.sample_steps[:-1] if self.thin == 1 else slice(None)
        return {
            "time": self.time,
            "reference": self.reference[samples],
            "velocity": self.velocity[samples],
            "measured": self.measured,
            "torque": self.torque,
            "feedforward": self.feedforward,
            "friction": self.friction,
            **({} if self.position_error is None else {"position_error": self.position_error[samples]}),
            **{f"estimated_{name}": series for name, series in self.estimates.items()},
            **self.monitors,
        }

    def figures(self) -> dict[str, float]:
        """Return the figures of merit by name, those of the position too where there is a position loop."""
        return {**asdict(self.metrics), **({} if self.position_metrics is None else asdict(self.position_metrics))}

    def plot(self, path: str | Path | None = None) -> "Figure":  # type: ignore[override]
        """Draw tracking, error and torque; write the picture where a path is given."""
        figure: Figure = self._report("plot_run", path)
        return figure


def simulate(
    scenario: Scenario,
    controller: Any = "adaptive",
    *,
    name: str | None = None,
    setup: RunSetup | None = None,
    progress: Callable[[float], None] | None = None,
    uncertain: bool = True,
    thin: int | None = None,
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
    setup : RunSetup, optional
        What :func:`build_setup` returns for the scenario, where several controllers have one.
    progress : callable, optional
        Is called with the fraction done, from 0 to 1.
    uncertain : bool, optional
        Whether to note how uncertain the estimates are along the run, for controllers that know.
    thin : int, optional
        Keep one of so many samples, and the last, in the series; 1 keeps all, and the solver's grid. By default all
        are kept up to two million solver steps, and of a longer run as many as keep its series from growing further.
        The figures of merit are of the whole run all the same.

    Returns
    -------
    Run
        Time series and figures of merit.

    Raises
    ------
    InputError
        The name is not known.
    TypeError
        The scenario is none, or another argument is of another kind.
    ValueError
        ``thin`` is no whole number of at least one, or ``uncertain`` neither true nor false.
    ArithmeticError
        The run did not stay finite.
    """
    check_scenario(scenario)
    check_kind("name", name, (str, NoneType), "a text")
    check_kind("setup", setup, (RunSetup, NoneType), "what build_setup(scenario) returns")
    check_progress(progress)
    whole = isinstance(thin, int | np.integer) and not isinstance(thin, bool)
    if thin is not None and not (whole and 1 <= thin < 2**63):
        shown = reprlib.repr(thin)
        raise ValueError(f"thin = {shown} is not allowed: it must be a whole number of at least 1 and below 2**63")
    noted = checked_switch("uncertain", uncertain)
    if isinstance(controller, str):
        scenario = loop_of(scenario, controller)
        name, controller = name or controller, make_controller(scenario, controller)
    if isinstance(controller, type) or not callable(getattr(controller, "step", None)):
        raise InputError(
            f"controller = {controller!r} is not allowed: it must be a name or an object with a method step"
        )
    setup = build_setup(scenario) if setup is None else setup
    marks: list[tuple[int, dict[str, float]]] = []
    noting = noted and isinstance(controller, Controller) and hasattr(controller, "uncertainties")

    def reports(stop: int, count: int) -> None:
        if noting:
            marks.append((stop - 1, controller.uncertainties))
        if progress is not None:
            progress(stop / count)

    if noting:
        marks.append((0, controller.uncertainties))
    if thin is None:
        thin = max(1, math.ceil((setup.reference.size - 1) / MOST_STEPS))
    drive = drive_over(controller, setup, reports, MARKS if noting else 1)
    run = _run(name or type(controller).__name__, scenario, drive, thin)
    if marks:
        uncertainties = {key: np.array([known[key] for _, known in marks]) for key in marks[0][1]}
        run = replace(run, uncertainties=uncertainties, uncertainty_time=_times(setup, [at for at, _ in marks]))
    return replace(run, friction_map=controller.learnt_map) if isinstance(controller, AdaptiveController) else run


def _times(setup: RunSetup, samples: Any) -> NDArray[np.float64]:
    """Return the times of samples, s."""
    return np.asarray(setup.samples[samples] * setup.solver_period, dtype=np.float64)


def _run(name: str, scenario: Scenario, drive: Drive, thin: int) -> Run:
    """Return a run with its series and figures; ``ArithmeticError`` where it did not stay finite."""
    setup, record = drive.setup, drive.record
    change, period = scenario.last_change, setup.solver_period
    position_error, position_metrics = None, None
    with np.errstate(over="ignore", invalid="ignore"):
        metrics = evaluate(setup.reference, record.velocity, record.torque, period, change)
        if scenario.position is not None:
            position_error = setup.planned - record.position
            position_metrics = evaluate_position(position_error, period, change)
    if not all(np.isfinite(list(vars(metrics).values()))):
        raise ArithmeticError(f"the run of {name} did not stay finite: {metrics}")
    last = setup.noise.size - 1
    kept: Any = slice(last + 1) if thin == 1 else np.unique([*range(0, last, thin), last])
    grid, time = slice(None) if thin == 1 else setup.samples[kept], _times(setup, kept)
    return Run(
        name,
        scenario,
        time,
        scenario.times() if thin == 1 else time,
        setup.reference[grid],
        record.velocity[grid],
        record.measured[kept],
        record.torque[kept],
        record.feedforward[kept],
        record.friction[kept],
        {key: record.estimates[kept, i] for i, key in enumerate(drive.names)},
        metrics,
        None if position_error is None else position_error[grid],
        position_metrics,
        {key: record.monitors[kept, i] for i, key in enumerate(drive.watched)},
        thin=thin,
    )


def frictionless(scenario: Scenario) -> Scenario:
    """Return the scenario of the same loop on a joint without friction, loads, gravity and ripple; payloads stay."""
    joint = scenario.joint
    kept = {name: getattr(joint, name) for name in ("stribeck_velocity", "stribeck_shape", "solver_period", "axis")}
    table: dict[str, Any] = {"kind": "stribeck", "inertia": joint.inertia, **kept}
    table |= {"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}
    if hasattr(joint, "link_share"):
        table |= {"kind": "elastic", **{name: getattr(joint, name) for name in SPRING}}
    changes = [{"time": change.time, "inertia_scale": change.inertia_scale} for change in scenario.change]
    actuator = scenario.actuator.model_dump(exclude_unset=True, exclude={"ripple_amplitude"})
    return scenario.replaced(joint=table, change=changes, actuator=actuator, variation={})


def noise_floor(scenario: Scenario, setup: RunSetup | None = None, *, noisy: bool = True) -> Run:
    """Run the loop of a scenario on a joint without friction, with the noise and the reference of its set-up.

    Without noise the sensor has neither noise nor the steps of its encoder.
    """
    plain = frictionless(scenario)
    built = build_setup(plain)
    if setup is not None:
        built = built._replace(noise=setup.noise, reference=setup.reference)
    built = built if noisy else without_noise(built)
    return simulate(plain, make_oracle(plain), name=NOISE_FLOOR, setup=built)


def run_by_name(
    scenario: Scenario, name: str, setup: RunSetup, own: Mapping[str, Own] | None = None, thin: int | None = None
) -> Run:
    """Run a controller, own ones and the noise floor included, over a set-up of the scenario."""
    if name == NOISE_FLOOR:
        return noise_floor(scenario, setup)
    made = make_controller(scenario, name, own)
    return simulate(scenario, made, name=name, setup=setup, uncertain=False, thin=thin)

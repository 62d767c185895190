"""Models identified once, before the run that they are used in: a calibration run of the PI loop, then a batch fit.

The calibration run is the scenario's own joint, sensor, drive and kind of reference with another seed, for 120 s,
before its friction changes. Only what can be measured takes part: the velocity and the torque of the drive; ``Vs``
and ``delta`` are assumed known. Two steps:

1. The filtered torque form on sliding samples, by least squares within what is possible. Filters at half of the
   crossover and a gate at 0.4 of the Stribeck velocity gave the least errors on the built-in joint (seeds from 101 on).
   Inertia, friction curve and viscous coefficient come out within a few per cent. The friction lag does not: it
   acts on the filtered second derivative, where noise biases it by three quarters towards zero, and the reversals that
   show it are cut out by the gate, since a joint under PI sticks there.
2. For a model with lag, that is why the same loop is then simulated without noise along the same reference, with the
   model as its joint, and all five parameters are fitted so that it moves as measured: closed-loop output error,
   as in M. Gautier, A. Janot, P.-O. Vandanjon, "A new closed-loop output error method for parameter identification
   of robot dynamics" (IEEE Transactions on Control Systems Technology, 2013), which compares torques where this
   compares velocities. It starts from the lag that does best when the first step finds all others for it. What
   remains (the lag 10 to 20 % too large on the built-in joint) is what noise does to a joint that sticks.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, lsq_linear, minimize_scalar

from adaptive_ff.errors import InputError
from adaptive_ff.friction.bounds import INERTIA_RANGE, VISCOUS_SHARE, largest_lag
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.rows import torque_form_rows
from adaptive_ff.learning.torque_form import REGRESSORS, TorqueForm, initial_signals, settle_signals_in_place
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import Course, Record, empty_record, lay_course
from adaptive_ff.simulation.loop import run_compiled, start_position
from controllers import PI
from controllers.arrays import NDArray
from plant import Gravity, JointModel, schedule

Array = NDArray[np.float64]

DURATION = 120.0
"""Length of the calibration run, s."""

OTHER_SEED = 1_000_000
"""Added to the seed of the scenario."""

POLE_SHARE = 0.5
"""Pole of the filters, as a share of the crossover ``Kp/J``."""

GATE_SHARE = 0.4
"""Speed of the gate, as a share of the Stribeck velocity."""

GATE_HOLD = 3.0
"""Hold of the gate, in time constants of the filters."""

LAG_STEP = 0.01
"""Resolution of the first search for the friction lag, in time constants ``J/Kp`` of the feedback."""

LARGEST_FIRST_LAG = 4.0
"""Its upper end, in the same unit."""

OUTPUT_ERROR = {"diff_step": 1e-2, "xtol": 1e-3, "ftol": 1e-9, "max_nfev": 12}
"""Settings of the output-error fit: parameters to 0.1 %, differences that see past the moments of sticking."""

FINE = 1e-12
"""Resolution of the encoder of a model, rad."""

COLUMNS = {"coulomb": 3, "stribeck": 4}
"""Number of parameters of the forms without lag, of inertia, Coulomb friction, viscous coefficient and adhesion."""


class Calibration(NamedTuple):
    """A calibration run.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    course : Course
        Its joint, reference and noise, before any controller runs.
    measured : ndarray, shape (n,)
        Measured velocity, rad/s.
    equations : ndarray, shape (7, 7)
        Triangular factor of the torque-form regressors and, in the last column, the regressed torque.
    """

    scenario: Scenario
    course: Course
    measured: Array
    equations: Array


def identify_joint(scenario: Scenario, form: str) -> TorqueModel:
    """Identify a scenario's joint in a calibration run.

    Parameters
    ----------
    scenario : Scenario
        The scenario that the model is for.
    form : str
        ``coulomb``, ``stribeck`` or ``lagged``: the form that is fitted.

    Returns
    -------
    TorqueModel
        The model, within what is physically possible.

    Raises
    ------
    InputError
        The calibration run does not slide enough to be identified from.
    """
    other = scenario.modified(seed=(scenario.seed + OTHER_SEED) % 2**63, duration=DURATION, change=[])
    return _identify(other.model_dump_json(), form)


@lru_cache(maxsize=32)
def _identify(text: str, form: str) -> TorqueModel:
    calibration = _calibrate(text)
    if form in COLUMNS:
        return _model(calibration.scenario, _fit_curve(calibration, COLUMNS[form], 0.0), 0.0)
    return _fit_output(calibration)


@lru_cache(maxsize=4)
def _calibrate(text: str) -> Calibration:
    """Do the calibration run of a scenario given as JSON text."""
    scenario = Scenario.model_validate_json(text)
    course = lay_course(scenario)
    record = _run(scenario, course)
    return Calibration(scenario, course, record.measured, _equations(scenario, course, record))


def _run(scenario: Scenario, course: Course) -> Record:
    """Run the PI loop."""
    loop = PI(*scenario.feedback.gains, scenario.sampling.period, delay=scenario.assumed_delay)
    record = empty_record(course, 0)
    run_compiled(loop.parameters, loop.state, course, start_position(course), course.noise.size, record)
    return record


def _equations(scenario: Scenario, course: Course, record: Record) -> Array:
    """Return the triangular factor of the torque form's equations."""
    assumed, pole = scenario.adaptation, POLE_SHARE * scenario.feedback.gains[0] / scenario.feedback.inertia
    form = TorqueForm(pole, assumed.stribeck_velocity, assumed.stribeck_shape)
    signals = settle_signals_in_place(form, initial_signals(), float(record.measured[0]))
    time: Array = course.samples[:-1] * np.float64(course.solver_period)
    rows, outputs = np.zeros((time.size, len(REGRESSORS))), np.zeros(time.size)
    used = np.zeros(time.size, dtype=np.bool_)
    gate = (GATE_SHARE * assumed.stribeck_velocity, GATE_HOLD / pole)
    acted = np.roll(record.torque, 1)
    torque_form_rows(form, signals, time, record.measured, acted, gate, rows, outputs, used)
    count, needed = int(np.count_nonzero(used)), len(REGRESSORS) + 1
    if count < needed:
        raise InputError(
            f"identification before the run: in {DURATION:g} s under PI the joint slides faster than {gate[0]:g} rad/s "
            f"for {gate[1]:.2g} s or more in {count} samples; there must be at least {needed}"
        )
    return np.asarray(np.linalg.qr(np.column_stack([rows[used], outputs[used]]), mode="r"), dtype=np.float64)


def _units(scenario: Scenario) -> Array:
    """Return the expected size of inertia, Coulomb friction, viscous coefficient, adhesion and friction lag."""
    inertia, proportional = scenario.feedback.inertia, scenario.feedback.gains[0]
    torque = proportional * scenario.adaptation.stribeck_velocity
    return np.array([inertia, torque, VISCOUS_SHARE * proportional, torque, inertia / proportional])


def _possible(scenario: Scenario) -> tuple[Array, Array]:
    """Return the least and the largest of what is possible, in those units; adhesion is stiction beyond Coulomb's."""
    response = scenario.feedback.inertia / scenario.feedback.gains[0]
    least = np.array([1.0 / INERTIA_RANGE, 0.0, 0.0, 0.0, 0.0])
    return least, np.array([INERTIA_RANGE, np.inf, np.inf, np.inf, largest_lag(response) / response])


def _fit_curve(calibration: Calibration, count: int, lag: float) -> Array:
    """Fit the first parameters for a given friction lag (s); return inertia, Coulomb, viscous friction and adhesion."""
    factor = calibration.equations
    column = {name: factor[:, place] for place, name in enumerate(REGRESSORS)}
    columns = [
        column["inertia"] + lag * column["inertia_lag"],
        column["coulomb"] + column["stiction"],
        column["viscous"],
        column["stiction"],
    ]
    units = _units(calibration.scenario)[:count]
    least, most = _possible(calibration.scenario)
    matrix = np.column_stack(columns[:count]) * units
    size = np.linalg.norm(matrix)
    goal = factor[:, -1] - lag * column["friction_lag"]
    found = np.zeros(len(columns))
    found[:count] = units * lsq_linear(matrix / size, goal / size, bounds=(least[:count], most[:count])).x
    return found


def _model(scenario: Scenario, curve: Array, lag: float) -> TorqueModel:
    return TorqueModel(
        inertia=float(curve[0]),
        coulomb=float(curve[1]),
        stiction=float(curve[1] + curve[3]),
        viscous=float(curve[2]),
        friction_lag=float(lag),
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        stribeck_shape=scenario.adaptation.stribeck_shape,
    )


def _fit_output(calibration: Calibration) -> TorqueModel:
    """Fit all parameters so that the simulated loop moves as measured."""
    scenario, units = calibration.scenario, _units(calibration.scenario)
    possible = _possible(scenario)

    def error(parameters: Array) -> Array:
        """Return the error of the simulated velocity, in units of the Stribeck velocity."""
        velocity = _simulated(calibration, _model(scenario, parameters, parameters[-1]))
        difference: Array = (velocity - calibration.measured) / scenario.adaptation.stribeck_velocity
        return difference

    def with_lag(lag: float) -> Array:
        return np.append(_fit_curve(calibration, 4, lag * units[-1]), lag * units[-1])

    search = minimize_scalar(
        lambda lag: float(np.mean(error(with_lag(lag)) ** 2)),
        bounds=(0.0, LARGEST_FIRST_LAG),
        method="bounded",
        options={"xatol": LAG_STEP},
    )
    first = np.clip(with_lag(float(search.x)) / units, *possible)
    fit = least_squares(
        lambda scaled: error(scaled * units),
        first,
        bounds=possible,
        x_scale=np.maximum(first, 0.1),
        **OUTPUT_ERROR,
    )
    found = fit.x * units
    return _model(scenario, found, found[-1])


def _simulated(calibration: Calibration, model: TorqueModel) -> Array:
    """Return the velocity at the samples (rad/s) of the loop around a modelled joint, without noise.

    A model that cannot be simulated with the solver period counts as a joint that does not move.
    """
    scenario, course = calibration.scenario, calibration.course
    try:
        joint = JointModel(
            **{name: getattr(model, name) for name in JointModel.model_fields if name in model._fields},
            solver_period=scenario.joint.solver_period,
        )
    except ValueError:
        return np.zeros_like(calibration.measured)
    exact = course._replace(
        joint=joint.parameters,
        plan=schedule([], joint.solver_period),
        resolution=min(course.resolution, FINE),
        noise=np.zeros_like(course.noise),
        actuator=course.actuator._replace(gain=1.0),  # the torque that the drive reports is all that is known of it
        gravity=Gravity(0.0, 0.0),  # the forms have none
    )
    return _run(scenario, exact).measured

"""The models of the fixed feedforwards: three forms, each from four sources.

Forms are ``coulomb`` (with viscous friction), ``stribeck`` (the whole static curve) and ``lagged`` (with lag). Sources:

- ``true``: the joint's own parameters at the start of the run.
- ``nominal``: as from a data sheet. Coulomb friction, stiction, viscous coefficient and lag are each off by a factor
  of their own, drawn evenly on a logarithmic scale between 1/1.25 and 1.25 by the scenario's seed; ``Vs`` and
  ``delta`` are those that the identifying controllers assume, the inertia that of the feedback's design.
- ``stale``: identified exactly, when all friction was 1.3 times what it is now, as after a change of temperature.
- ``batch``: identified from a calibration run of the PI loop: another seed, 120 s, before friction changes. A joint
  under PI sticks at the reversals, which are what shows the lag; so the lag is the one with which the same loop,
  simulated without noise around the identified joint, moves as measured (closed-loop output error, A. Janot,
  M. Gautier, P.-O. Vandanjon 2013, with the velocity in place of the torque).
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from adaptive_ff.baselines.bounds import largest_lag
from adaptive_ff.comparison.own_bandwidth import plain_pi
from adaptive_ff.comparison.running import drive_over
from adaptive_ff.friction.model import TorqueModel, model_friction
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import RunSetup, build_setup, without_noise
from plant import ElastoPlasticJoint, Gravity, JointModel, LuGreJoint, MaxwellJoint, RollingJoint, schedule

SPREAD = 1.25  # largest factor by which a nominal parameter is off
STALE = 1.3  # friction at the time of a stale identification, over that at the start of the run
STREAM = 4  # stream of random numbers for nominal parameters, beside those of reference and sensor
LEAST_REACH = 1e-3  # presliding displacement of a joint that has none, over ``assumed_displacement``
SPEEDS = 500  # number of speeds that the Coulomb-viscous form is fitted at, evenly spread over the time of the motion
DURATION, OTHER_SEED = 120.0, 1_000_000  # length of the calibration run, s, and what is added to the scenario's seed
LAGS = 2.0 ** np.arange(-7.0, 0.25, 0.5)  # friction lags that are tried beside none, over the largest possible one


def coulomb_form(model: TorqueModel, reference: NDArray[np.float64]) -> TorqueModel:
    """Return the Coulomb-viscous form of a model: its least-squares fit over the speeds of a reference (rad/s).

    The curve's own ``Fc`` and ``sigma`` lie below it wherever there is stiction.
    """
    moving = np.abs(reference[reference != 0.0])
    if moving.size == 0:
        return model._replace(stiction=model.coulomb, friction_lag=0.0)
    speeds = np.quantile(moving, (np.arange(SPEEDS) + 0.5) / SPEEDS)
    friction = np.array([model_friction(model, float(speed)) for speed in speeds])
    (coulomb, viscous), _ = scipy.optimize.nnls(np.column_stack([np.ones_like(speeds), speeds]), friction)
    return model._replace(coulomb=float(coulomb), stiction=float(coulomb), viscous=float(viscous), friction_lag=0.0)


def nominal_source(scenario: Scenario, truth: TorqueModel) -> TorqueModel:
    """Return what a data sheet says."""
    limit, assumed = math.log(SPREAD), scenario.adaptation
    factors = np.exp(np.random.default_rng([scenario.seed, STREAM]).uniform(-limit, limit, 4)).tolist()
    coulomb = factors[0] * truth.coulomb
    return truth._replace(
        inertia=scenario.feedback.inertia,
        coulomb=coulomb,
        stiction=max(factors[1] * truth.stiction, coulomb),
        viscous=factors[2] * truth.viscous,
        friction_lag=factors[3] * truth.friction_lag,
        stribeck_velocity=assumed.stribeck_velocity,
        stribeck_shape=assumed.stribeck_shape,
    )


def batch_source(scenario: Scenario, _: TorqueModel) -> TorqueModel:
    """Identify a scenario's joint in a calibration run; ``InputError`` where that does not move enough."""
    other = scenario.modified(seed=(scenario.seed + OTHER_SEED) % 2**63, duration=DURATION, change=[])
    return _identified(other.model_dump_json())


@lru_cache(maxsize=32)
def _identified(text: str) -> TorqueModel:
    """Return the model of a scenario given as JSON text."""
    # here, not above: few comparisons identify a log
    from adaptive_ff.identify.identification import identify_log
    from adaptive_ff.logs.log import Log

    scenario = Scenario.model_validate_json(text)
    setup = build_setup(scenario)
    run = drive_over(plain_pi(scenario), setup).record
    time = setup.samples[:-1] * np.float64(setup.solver_period)
    log = Log("calibration run", time, run.torque, velocity=run.measured)
    found = identify_log(log, torque_delay=0.5 * scenario.sampling.period, model="symmetric").torque_model()

    def error(lag: float) -> float:
        try:
            modelled = _modelled(scenario, setup, found._replace(friction_lag=lag))
        except ValueError:  # the solver period does not suit it
            return math.inf
        return float(np.mean((drive_over(plain_pi(scenario), modelled).record.measured - run.measured) ** 2))

    # the error is rough: sticking begins and ends at steps of the solver; so a grid, and a parabola over its best part
    lags = np.append(0.0, largest_lag(response_time(scenario)) * LAGS)
    errors = np.array([error(lag) for lag in lags.tolist()])
    best = int(np.argmin(errors))
    near = slice(best - 1, best + 2)
    if 0 < best < lags.size - 1 and np.isfinite(errors[near]).all():
        curvature, slope, _ = np.polyfit(lags[near], errors[near], 2)
        return found._replace(friction_lag=float(-0.5 * slope / curvature))
    return found._replace(friction_lag=float(lags[best]))


def _modelled(scenario: Scenario, setup: RunSetup, model: TorqueModel) -> RunSetup:
    """Return the setup with a modelled joint, without noise and gravity."""
    known = {name: value for name, value in model._asdict().items() if name in JointModel.model_fields}
    joint = JointModel(**known, solver_period=scenario.joint.solver_period)
    return without_noise(setup)._replace(
        joint=joint.parameters,
        plan=schedule([], joint.solver_period),
        actuator=setup.actuator._replace(gain=1.0),  # the torque that the drive reports is all that is known of it
        gravity=Gravity(0.0, 0.0),
    )


FORMS: dict[str, Callable[[TorqueModel, NDArray[np.float64]], TorqueModel]] = {
    "coulomb": coulomb_form,
    "stribeck": lambda model, reference: model._replace(friction_lag=0.0),
    "lagged": lambda model, reference: model,
}
"""How each form is made of a known model and a reference."""

SOURCES: dict[str, Callable[[Scenario, TorqueModel], TorqueModel]] = {
    "nominal": nominal_source,
    "stale": lambda scenario, truth: truth._replace(
        **{name: STALE * getattr(truth, name) for name in ("coulomb", "stiction", "viscous")}
    ),
    "true": lambda scenario, truth: truth,
    "batch": batch_source,
}
"""Where a model comes from."""


def fixed_model(scenario: Scenario, truth: TorqueModel, form: str, source: str) -> TorqueModel:
    """Return the model of a form and a source that a fixed feedforward assumes; the truth is that of the start."""
    return FORMS[form](SOURCES[source](scenario, truth), scenario.reference_velocity())


def response_time(scenario: Scenario) -> float:
    """Compute the time constant ``J/Kp`` of the feedback, s."""
    return scenario.feedback.inertia / scenario.feedback.gains[0]


def assumed_displacement(scenario: Scenario) -> float:
    """Compute the displacement at ``Vs`` in a time constant of the feedback, rad."""
    return scenario.adaptation.stribeck_velocity * response_time(scenario)


def nominal_presliding(scenario: Scenario) -> float:
    """Return the displacement (rad) from a reversal until the joint slides, as from a data sheet; least where none is.

    Bristles and elements slip gradually: of a LuGre joint it is twice what the stiction bends, of Maxwell slip the
    reach of the last element, of rolling friction its range. It is off by a factor as the parameters of ``nominal``
    models are.
    """
    joint, true = scenario.joint, 0.0
    if isinstance(joint, LuGreJoint):
        true = 2.0 * joint.stiction / joint.stiffness
    elif isinstance(joint, MaxwellJoint):
        true = max(joint.displacements)
    elif isinstance(joint, RollingJoint):
        true = joint.rolling_range
    elif isinstance(joint, ElastoPlasticJoint):
        true = joint.presliding
    factor = SPREAD ** np.random.default_rng([scenario.seed, STREAM, 1]).uniform(-1.0, 1.0)
    return max(float(factor) * true, LEAST_REACH * assumed_displacement(scenario))

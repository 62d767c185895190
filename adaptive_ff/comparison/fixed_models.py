"""The models of the fixed feedforwards: three forms, each from four sources.

Forms: ``coulomb`` (Coulomb and viscous friction), ``stribeck`` (the whole static curve), ``lagged`` (with lag).

Sources:

- ``true``: the joint's own parameters at the start of the run.
- ``nominal``: as from a data sheet. Coulomb friction, stiction, viscous coefficient and lag are each off by a factor
  of their own, drawn evenly on a logarithmic scale between 1/1.25 and 1.25 by the scenario's seed; ``Vs`` and
  ``delta`` are those that the identifying controllers assume, the inertia that of the feedback's design.
- ``stale``: identified exactly, when all friction was 1.3 times what it is now, as after a change of temperature.
- ``batch``: identified from a calibration run, see ``calibration``.

The Coulomb-viscous form of a known curve is its least-squares fit over the speeds of the reference, which is as near
to the curve as the form comes along this motion, not the curve's own ``Fc`` and ``sigma``, which lie below it
wherever there is stiction.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from adaptive_ff.comparison.calibration import identify_joint
from adaptive_ff.friction.model import TorqueModel, model_friction
from adaptive_ff.scenario.scenario import Scenario
from plant import ElastoPlasticJoint, LuGreJoint, MaxwellJoint, RollingJoint

SPREAD = 1.25
"""Largest factor by which a nominal parameter is off."""

STALE = 1.3
"""Friction at the time of a stale identification, over that at the start of the run."""

STREAM = 4
"""Stream of random numbers for nominal parameters, beside those of reference and sensor."""

LEAST_REACH = 1e-3
"""Presliding displacement of a joint that has none, over ``assumed_displacement``."""

SPEEDS = 500
"""Number of speeds that the Coulomb-viscous form is fitted at, evenly spread over the time of the motion."""


def coulomb_form(model: TorqueModel, reference: NDArray[np.float64]) -> TorqueModel:
    """Return the Coulomb-viscous form of a model that is best along a reference (rad/s)."""
    moving = np.abs(reference[reference != 0.0])
    if moving.size == 0:
        return model._replace(stiction=model.coulomb, friction_lag=0.0)
    speeds = np.quantile(moving, (np.arange(SPEEDS) + 0.5) / SPEEDS)
    friction = np.array([model_friction(model, float(speed)) for speed in speeds])
    (coulomb, viscous), _ = nnls(np.column_stack([np.ones_like(speeds), speeds]), friction)
    return model._replace(coulomb=float(coulomb), stiction=float(coulomb), viscous=float(viscous), friction_lag=0.0)


def nominal_source(scenario: Scenario, truth: TorqueModel) -> TorqueModel:
    """Return what a data sheet says."""
    limit = math.log(SPREAD)
    factors = np.exp(np.random.default_rng([scenario.seed, STREAM]).uniform(-limit, limit, 4)).tolist()
    coulomb = factors[0] * truth.coulomb
    return truth._replace(
        inertia=scenario.feedback.inertia,
        coulomb=coulomb,
        stiction=max(factors[1] * truth.stiction, coulomb),
        viscous=factors[2] * truth.viscous,
        friction_lag=factors[3] * truth.friction_lag,
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        stribeck_shape=scenario.adaptation.stribeck_shape,
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
    "batch": lambda scenario, truth: identify_joint(scenario),
}
"""Where a model comes from."""


def fixed_model(scenario: Scenario, truth: TorqueModel, form: str, source: str) -> TorqueModel:
    """Return the model that a fixed feedforward assumes, of one of ``FORMS`` and from one of ``SOURCES``.

    ``truth`` holds the parameters of the joint at the start of the run.
    """
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
    joint, least = scenario.joint, LEAST_REACH * assumed_displacement(scenario)
    true = 0.0
    if isinstance(joint, LuGreJoint):
        true = 2.0 * joint.stiction / joint.stiffness
    elif isinstance(joint, MaxwellJoint):
        true = max(joint.displacements)
    elif isinstance(joint, RollingJoint):
        true = joint.rolling_range
    elif isinstance(joint, ElastoPlasticJoint):
        true = joint.presliding
    factor = SPREAD ** np.random.default_rng([scenario.seed, STREAM, 1]).uniform(-1.0, 1.0)
    return max(float(factor) * true, least)

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
wherever there is stiction. From a calibration run each form is fitted to the data itself.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from adaptive_ff.comparison.calibration import identify_joint
from adaptive_ff.friction.model import TorqueModel, model_friction
from adaptive_ff.scenario.scenario import Scenario

SPREAD = 1.25
"""Largest factor by which a nominal parameter is off."""

STALE = 1.3
"""Friction at the time of a stale identification, over that at the start of the run."""

STREAM = 4
"""Stream of random numbers for nominal parameters, beside those of reference and sensor."""

SPEEDS = 500
"""Number of speeds that the Coulomb-viscous form is fitted at, evenly spread over the time of the motion."""


def with_friction(model: TorqueModel, scale: float) -> TorqueModel:
    """Return a model with its friction times a factor."""
    return model._replace(coulomb=scale * model.coulomb, stiction=scale * model.stiction, viscous=scale * model.viscous)


def coulomb_form(model: TorqueModel, reference: NDArray[np.float64]) -> TorqueModel:
    """Return the Coulomb-viscous form of a model that is best along a reference (rad/s)."""
    moving = np.abs(reference[reference != 0.0])
    if moving.size == 0:
        return stribeck_form(model._replace(stiction=model.coulomb), reference)
    speeds = np.quantile(moving, (np.arange(SPEEDS) + 0.5) / SPEEDS)
    friction = np.array([model_friction(model, float(speed)) for speed in speeds])
    (coulomb, viscous), _ = nnls(np.column_stack([np.ones_like(speeds), speeds]), friction)
    return model._replace(coulomb=float(coulomb), stiction=float(coulomb), viscous=float(viscous), friction_lag=0.0)


def stribeck_form(model: TorqueModel, reference: NDArray[np.float64]) -> TorqueModel:
    """Return a model without its friction lag."""
    return model._replace(friction_lag=0.0)


def lagged_form(model: TorqueModel, reference: NDArray[np.float64]) -> TorqueModel:
    """Return a model as it is."""
    return model


def true_source(scenario: Scenario, truth: TorqueModel) -> TorqueModel:
    """Return the truth."""
    return truth


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


def stale_source(scenario: Scenario, truth: TorqueModel) -> TorqueModel:
    """Return the truth of another day."""
    return with_friction(truth, STALE)


FORMS: dict[str, Callable[[TorqueModel, NDArray[np.float64]], TorqueModel]] = {
    "coulomb": coulomb_form,
    "stribeck": stribeck_form,
    "lagged": lagged_form,
}
"""How each form is made of a known model and a reference."""

KNOWN: dict[str, Callable[[Scenario, TorqueModel], TorqueModel]] = {
    "nominal": nominal_source,
    "stale": stale_source,
    "true": true_source,
}
"""Sources that know the whole model."""

SOURCES = (*KNOWN, "batch")
"""All sources."""


def fixed_model(scenario: Scenario, truth: TorqueModel, form: str, source: str) -> TorqueModel:
    """Return the model that a fixed feedforward assumes.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    truth : TorqueModel
        Parameters of its joint at the start of the run.
    form, source : str
        One of ``FORMS`` and one of ``SOURCES``.

    Raises
    ------
    InputError
        The joint cannot be identified in a calibration run.
    """
    if source == "batch":
        return identify_joint(scenario, form)
    return FORMS[form](KNOWN[source](scenario, truth), scenario.reference_velocity())

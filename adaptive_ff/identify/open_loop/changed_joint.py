"""What of an open-loop error a change of the joint between two logs explains.

Friction changes with temperature, wear and lubricant, and nothing in the log of the training tells by how much it has
done so when another one is recorded. An open-loop simulation adds such a change up: a viscous coefficient that is wrong
by some per cent moves the joint to another place, and keeps it there. So one parameter of the model at a time is fitted
to the other log. That is an explanation of the error and no part of the score, in which nothing is chosen on that log.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from adaptive_ff.identify.open_loop.simulation import OpenLoopModel, Record
from adaptive_ff.identify.open_loop.structures import SETTLING
from adaptive_ff.logs.derivatives import Array

LARGEST = 0.5
"""Largest change that is looked for, a share of the parameter, and of the Coulomb friction for an offset."""

EXPLAINS = 0.5
"""Share of the error that must be left at most for the change to be an explanation of it."""

NAMES = {"viscous": "viscous friction", "coulomb": "Coulomb friction", "inertia": "inertia", "offset": "an offset"}
"""Parameters that are changed, and what they are called."""


class ChangedJoint(NamedTuple):
    """One parameter fitted to the other log.

    Attributes
    ----------
    parameter : str
        ``viscous``, ``coulomb``, ``inertia`` or ``offset``.
    change : float
        Its change, as a share of it; of an offset in N m.
    rms : float
        Root mean square of the error that is left, rad.
    """

    parameter: str
    change: float
    rms: float


def whole_error(model: OpenLoopModel, record: Record) -> Array:
    """Return simulated minus measured position of a whole log, without its first samples, rad."""
    return model.errors(record, np.array([0]), record.position.size)[0, SETTLING:]


def root_mean_square(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def fitted_changes(model: OpenLoopModel, record: Record) -> list[ChangedJoint]:
    """Return a change of each parameter, fitted to another log, the one that leaves least of the error first.

    Parameters
    ----------
    model : OpenLoopModel
        The model, as it was trained.
    record : Record
        The other log.
    """
    return sorted((_fitted(name, model, record) for name in NAMES), key=lambda one: one.rms)


def changed(model: OpenLoopModel, parameter: str, share: float) -> OpenLoopModel:
    """Return the model with one parameter changed by a share; an offset by that share of the Coulomb friction."""
    if parameter == "offset":
        return model._replace(force=model.force + share * model.coulomb)
    names = ("viscous", "viscous_asymmetry") if parameter == "viscous" else (parameter,)
    return model._replace(**{name: (1.0 + share) * getattr(model, name) for name in names})


def _fitted(parameter: str, model: OpenLoopModel, record: Record) -> ChangedJoint:
    def squares(share: float) -> float:
        return float(np.mean(whole_error(changed(model, parameter, share), record) ** 2))

    found = minimize_scalar(squares, bounds=(-LARGEST, LARGEST), method="bounded", options={"xatol": 1e-4})
    unit = model.coulomb if parameter == "offset" else 1.0
    return ChangedJoint(parameter, unit * float(found.x), float(np.sqrt(found.fun)))


def words_of_change(change: ChangedJoint, rms: float, *, linear: bool) -> str:
    """Return a sentence on a change that explains an error (root mean square, rad or m); none where it does not."""
    if change.rms > EXPLAINS * rms:
        return ""
    unit, torque = ("mm", "N") if linear else ("mrad", "N m")
    if change.parameter == "offset":
        what = f"an offset of {change.change:+.3g} {torque} beside its own"
    else:
        what = f"{NAMES[change.parameter]} {abs(change.change):.1%} {'larger' if change.change > 0.0 else 'smaller'}"
    return (
        f"With {what}, a single number fitted to the test log, the same model leaves "
        f"{1e3 * change.rms:.3g} instead of {1e3 * rms:.3g} {unit}: most of the error is a joint that has changed "
        "between the logs."
    )

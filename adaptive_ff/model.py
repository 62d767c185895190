"""The friction model that controllers assume of a joint: a hypothesis, to be told or identified.

It is the paper's model, equations (1)-(3), written for one direction of use: which torque does a motion need. The truth
that a simulation runs on is ``plant``; a test ties the two where they must agree.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable


class TorqueModel(NamedTuple):
    """Assumed parameters of a joint; names as in the scenario's ``[joint]`` table.

    Attributes
    ----------
    inertia : float
        Inertia ``J``, kg m^2.
    coulomb : float
        Coulomb friction ``Fc``, N m.
    stiction : float
        Stiction ``Fs``, N m.
    viscous : float
        Viscous coefficient ``sigma``, N m s/rad.
    friction_lag : float
        Friction lag ``tau``, s.
    stribeck_velocity : float
        Stribeck velocity ``Vs``, rad/s.
    stribeck_shape : float
        Stribeck shape factor ``delta``.
    """

    inertia: float
    coulomb: float
    stiction: float
    viscous: float
    friction_lag: float
    stribeck_velocity: float
    stribeck_shape: float


ESTIMATED = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")
"""Fields of the model that are identified online; the other two are pre-estimated, as in the paper."""

UNITS = {"inertia": "kg m²", "coulomb": "N m", "stiction": "N m", "viscous": "N m s/rad", "friction_lag": "s"}
"""Units of the identified parameters."""


@register_jitable
def adhesion_share(speed: float, stribeck_velocity: float, stribeck_shape: float) -> float:
    """Return the share of stiction, ``exp(-(|w|/Vs)^delta)``, which is ``|h(w)|`` of (6).

    The rest of one is the share of Coulomb friction, ``|g(w)|`` of (5).
    """
    ratio = speed / stribeck_velocity
    if stribeck_shape == 1.0:
        return math.exp(-ratio)
    if stribeck_shape == 2.0:
        return math.exp(-ratio * ratio)
    if ratio > 1.0 and stribeck_shape * math.log(ratio) > 7.0:
        return 0.0  # exp(-exp(7)) underflows, and the power below could overflow
    return math.exp(-(ratio**stribeck_shape))


@register_jitable
def model_friction(model: TorqueModel, speed: float) -> float:
    """Friction torque (N m) of the model at a sliding speed ``|w| >= 0`` (rad/s), equation (3)."""
    share = adhesion_share(speed, model.stribeck_velocity, model.stribeck_shape)
    return model.coulomb * (1.0 - share) + model.stiction * share + model.viscous * speed

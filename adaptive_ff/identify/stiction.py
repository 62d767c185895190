"""Stiction, Stribeck velocity and shape as far as a log shows them, and what is assumed where it does not."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.learning.batch_least_squares import Estimate

SLOW = 0.05
"""Assumed Stribeck velocity where none is identified, over the largest speed."""


class Stiction(NamedTuple):
    """Friction at the slowest speeds.

    Attributes
    ----------
    stiction : float
        Stiction, N m.
    velocity, shape : float
        Stribeck velocity, rad/s, and shape factor.
    estimate : Estimate or None
        Value and interval of the stiction; None where it is assumed.
    remark : str
        Where it comes from, unless it is a parameter of the identification.
    """

    stiction: float
    velocity: float
    shape: float
    estimate: Estimate | None
    remark: str


def known_stiction(found: LogIdentification, coulomb: float) -> Stiction:
    """Return what an identification says of stiction, beside a Coulomb friction (N m).

    The parameters of the model come first, then the curve through stretches at constant speed; where neither
    determines it, stiction is taken to be Coulomb friction, and the Stribeck velocity a twentieth of the largest speed.
    """
    reported = found.parameters.get("stiction")
    if reported is not None and reported.identifiable:
        stiction = max(found.value("stiction"), coulomb)
        return Stiction(stiction, found.value("stribeck_velocity"), 1.0, reported.estimate, "")
    fit = found.curve.fit
    if fit is not None and fit.determined and fit.estimates["stiction"].value > coulomb:
        estimate = fit.estimates["stiction"]
        remark = "from stretches at constant speed"
        return Stiction(estimate.value, fit.stribeck_velocity, fit.stribeck_shape, estimate, remark)
    slow = SLOW * float(np.max(np.abs(found.reference.velocity)))
    remark = "assumed: the log does not determine a stiction above Coulomb friction"
    return Stiction(coulomb, float(f"{slow:.3g}"), 1.0, None, remark)

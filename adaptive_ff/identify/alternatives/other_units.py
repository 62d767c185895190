"""Whether another log of a joint has its torque or its motion in other units, or with the other sign.

A joint may have another friction or inertia there; but no joint has 57 times the inertia and 57 times the viscous
coefficient with the same Coulomb friction, and in none friction drives.
"""

import numpy as np

from adaptive_ff.identify.rows.regressors import Problem, design, measured_torque
from adaptive_ff.identify.terms import BASE
from adaptive_ff.learning.batch_least_squares import fit_least_squares

TERMS = (*BASE, "offset")
"""Terms of the simple fit that is compared: all are linear."""

FOREIGN = 5.0
"""Factor from which on parameters are those of other units; that of turns for radians is 6.3, and no common one is
smaller."""

MOST_LEFT = 0.5
"""Share of the mean square torque that the simple fit may leave of the other log: else no joint has made it."""

ALIKE = 2.0
"""Factor within which parameters may differ on another log of a joint that has changed, but is in the same units."""


def other_units(problem: Problem, held: Problem) -> str | None:
    """Say what the torque or the motion of another log seems to be in; None where its units seem to be the same.

    Parameters
    ----------
    problem, held : Problem
        The rows that were fitted, and those of the other log.
    """
    try:
        (here, _), (there, left) = _simple(problem), _simple(held)
    except ValueError:
        return None  # the rows do not determine the terms
    if left > MOST_LEFT:
        return None  # whatever made the torque there
    inertia, coulomb, viscous = (there[name] / here[name] if here[name] != 0.0 else 0.0 for name in BASE)
    if inertia < 0.0 and coulomb < 0.0:
        return "friction would drive the joint there, so the torque or the motion has the other sign in that log"
    if min(inertia, coulomb, viscous) <= 0.0:
        return None
    if _are_alike(inertia, viscous) and not _are_alike(inertia, 1.0, FOREIGN):
        shown = f"inertia comes out {inertia:.3g} times, viscous friction {viscous:.3g} times as large there"
        if _are_alike(coulomb, 1.0):
            return f"{shown}, but Coulomb friction alike, so the motion is in another unit in that log{_hint(inertia)}"
        if _are_alike(coulomb, inertia):
            return f"{shown}, and Coulomb friction {coulomb:.3g} times, so the torque is in another unit in that log"
    return None


def _simple(problem: Problem) -> tuple[dict[str, float], float]:
    """Return the values of the simple fit, and the share of the mean square torque that it leaves."""
    torque = measured_torque(problem)
    fit = fit_least_squares(design(problem, TERMS, {}), torque, names=TERMS)
    return dict(zip(TERMS, fit.values.tolist(), strict=True)), float(np.mean(fit.residuals**2) / np.mean(torque**2))


def _are_alike(one: float, other: float, within: float = ALIKE) -> bool:
    return 1.0 / within < one / other < within


def _hint(factor: float) -> str:
    """Name degrees where a factor is about that of degrees to radians, or the other way round."""
    degrees = 0.017453
    is_degrees = _are_alike(factor, degrees) or _are_alike(factor, 1.0 / degrees)
    return " (one is in degrees, the other in radians?)" if is_degrees else ""

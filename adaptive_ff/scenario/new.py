"""A first scenario of one's own joint from the numbers of a data sheet, with what is assumed beside each number."""

import math

from pydantic import ValidationError

from adaptive_ff.errors import InputError
from adaptive_ff.scenario.file import toml_text
from adaptive_ff.scenario.reference import SHORTEST, Multisine
from adaptive_ff.scenario.relations import LONGEST
from controllers import fastest_bandwidth
from plant import JointModel

COULOMB_SHARE, STICTION_FACTOR = 0.1, 1.25
"""Coulomb friction over the rated torque, and stiction over Coulomb friction, of a geared axis."""

VISCOUS_SHARE = 0.05
"""Viscous friction at the rated speed over the rated torque."""

STRIBECK_SHARE, NOISE_SHARE = 0.02, 2e-4
"""Stribeck velocity, and noise of the measured velocity, over the rated speed."""

LOOP_SHARE = 0.5
"""Bandwidth of the PI loop over the largest one that a maximum sensitivity of 1.7 allows."""

LONGEST_SOLVER_PERIOD = 0.001
"""Longest solver period, s."""

SHORTEST_PERIOD = SHORTEST / LONGEST
"""Shortest sampling period, s: a scenario without a duration takes ``SHORTEST`` s, in at most ``LONGEST`` steps."""

LONGEST_PERIOD = 0.5 / max(Multisine().frequencies)
"""Sampling period, s, below which the built-in reference is below half the sampling frequency."""

UNITS = {
    "rotary": {"inertia": "kg m^2", "torque": "N m", "speed": "rad/s", "viscous": "N m s/rad"},
    "linear": {"inertia": "kg", "torque": "N", "speed": "m/s", "viscous": "N s/m"},
}


def new_scenario_text(
    inertia: float, torque: float, speed: float, *, period: float = 0.001, linear: bool = False
) -> str:
    """Return the text of a smallest complete scenario file.

    Parameters
    ----------
    inertia : float
        Inertia of motor and load at the joint, kg m^2, or moving mass, kg.
    torque : float
        Rated torque at the joint, N m, or rated force, N.
    speed : float
        Rated speed, rad/s or m/s.
    period : float, optional
        Sampling period of the velocity controller, s.
    linear : bool, optional
        Whether the axis is linear.

    Returns
    -------
    str
        The text, every assumed number with a comment that says so.

    Raises
    ------
    InputError
        A number is not positive and finite, the period is not one of a scenario that can be run, or no simulation of
        such a joint is possible.
    """
    for name, value in (("inertia", inertia), ("torque", torque), ("speed", speed), ("period", period)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g} is not allowed: it must be positive and finite")
    if not SHORTEST_PERIOD <= period < LONGEST_PERIOD:
        raise InputError(
            f"period = {period:g} s is not allowed: it must be from {SHORTEST_PERIOD:g} s to less than "
            f"{LONGEST_PERIOD:g} s"
        )
    axis = "linear" if linear else "rotary"
    coulomb, viscous = COULOMB_SHARE * torque, VISCOUS_SHARE * torque / speed
    curve = {
        "inertia": _rounded(inertia),
        "coulomb": _rounded(coulomb),
        "stiction": _rounded(STICTION_FACTOR * coulomb),
        "viscous": _rounded(viscous),
        "stribeck_velocity": _rounded(STRIBECK_SHARE * speed),
    }
    content = {
        "joint": {**({"axis": axis} if linear else {}), **curve, "solver_period": _solver_period(curve, period)},
        "sampling": {"period": period},
        "sensor": {"velocity_noise": _rounded(NOISE_SHARE * speed)},
        "actuator": {"torque_limit": _rounded(torque)},
        "feedback": {"inertia": curve["inertia"], "bandwidth": _rounded(LOOP_SHARE * fastest_bandwidth(period))},
        "adaptation": {"stribeck_velocity": curve["stribeck_velocity"]},
        "fixed": {name: curve[name] for name in ("inertia", "coulomb", "viscous")},
    }
    head = [
        "A joint from data-sheet numbers; what is assumed says so. A log of the real joint gives better numbers:",
        "adaptive-ff identify LOG. The reference is the built-in multisine, its peak chosen for this joint.",
    ]
    return toml_text(content, _comments(UNITS[axis]), head)


def _comments(units: dict[str, str]) -> dict[str, str]:
    """Return what is said beside the numbers, with their units."""
    return {
        "joint.inertia": f"{units['inertia']}, motor and load at the joint",
        "joint.coulomb": f"{units['torque']}, assumed: {100.0 * COULOMB_SHARE:g} % of the rated one",
        "joint.stiction": f"{units['torque']}, assumed: {STICTION_FACTOR:g} times Coulomb friction",
        "joint.viscous": f"{units['viscous']}, assumed: {100.0 * VISCOUS_SHARE:g} % of the rated one at rated speed",
        "joint.stribeck_velocity": f"{units['speed']}, assumed: {100.0 * STRIBECK_SHARE:g} % of the rated one",
        "joint.solver_period": "s, of the simulation",
        "sampling.period": "s",
        "sensor.velocity_noise": f"{units['speed']}, standard deviation, assumed",
        "actuator.torque_limit": f"{units['torque']}, the rated one",
        "feedback.inertia": "as the designer assumes it",
        "feedback.bandwidth": "Hz, half of the most that a maximum sensitivity of 1.7 allows",
        "adaptation.stribeck_velocity": "prior knowledge of the adaptive controller; a factor of two wrong is fine",
        "fixed": "the friction model that the controller 'fixed' feeds forward",
    }


def _solver_period(curve: dict[str, float], period: float) -> float:
    """Return the longest part of the sampling period for which the simulated joint has a unique step."""
    shortest = max(period / 1000.0, SHORTEST_PERIOD)
    parts = 1
    while parts <= 1000:
        solver = float(f"{period / parts:.12g}")
        if shortest * (1.0 - 1e-9) <= solver <= LONGEST_SOLVER_PERIOD:
            try:
                JointModel(**curve, solver_period=solver)
            except ValidationError:
                pass
            else:
                return solver
        parts += 1
    raise InputError(
        f"inertia = {curve['inertia']:g} is too small beside the rated torque for a simulation in steps of "
        f"{shortest:g} s; give the inertia of motor and load at the joint"
    )


def _rounded(value: float) -> float:
    """Return a value with the digits that an assumption deserves."""
    return float(f"{value:.4g}")

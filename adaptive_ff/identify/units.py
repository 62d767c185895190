"""Units of what is reported of a joint."""

import re
from collections.abc import Mapping

from adaptive_ff.scenario.axis_units import of_linear

ROTARY = {
    "inertia": "kg m²",
    **dict.fromkeys(("viscous", "viscous_asymmetry"), "N m s/rad"),
    **dict.fromkeys(("coulomb", "offset", "gravity_sine", "gravity_cosine", "stiction_excess", "torque"), "N m"),
    **dict.fromkeys(("friction_lag", "torque_delay"), "s"),
    **dict.fromkeys(("stribeck_velocity", "velocity"), "rad/s"),
    "path": "rad",
    "load_friction": "",
}
"""Units of a rotary joint; what is over position is in those of the torque."""

LINEAR = {name: of_linear(unit) for name, unit in ROTARY.items()}
"""Units of a linear axis."""

MASS_IN_AMPERES = {"kg m²": "A s²/rad", "kg": "A s²/m"}
"""Unit of the inertia where a torque, or a force, is given as a current."""


def of_current(units: Mapping[str, str]) -> dict[str, str]:
    """Return units where the torque, or force, is given as a current, A: inertia is then in A s²/rad, or A s²/m."""
    return {name: MASS_IN_AMPERES.get(unit, re.sub("^N( m)?", "A", unit)) for name, unit in units.items()}


def unit_of(units: Mapping[str, str], name: str) -> str:
    """Return the unit of a parameter; those of a map over position are torques."""
    return units.get(name, units["torque"])

"""Units of what is reported of a joint."""

from collections.abc import Mapping

from adaptive_ff.friction.model import UNITS
from adaptive_ff.identify.terms import SATURATIONS
from adaptive_ff.scenario.axis_units import of_linear

ROTARY = {
    **UNITS,
    "offset": "N m",
    "stribeck_velocity": "rad/s",
    "viscous_asymmetry": "N m s/rad",
    **dict.fromkeys(("gravity_sine", "gravity_cosine", *SATURATIONS, "stiction_excess"), "N m"),
    **dict.fromkeys((f"{shape}_velocity" for shape in SATURATIONS), "rad/s"),
    "torque": "N m",
    "velocity": "rad/s",
}
"""Units of a rotary joint."""

LINEAR = {name: of_linear(unit) for name, unit in ROTARY.items()}
"""Units of a linear axis."""

MASS_IN_AMPERES = {"kg m²": "A s²/rad", "kg": "A s²/m"}
"""Unit of the inertia where a torque, or a force, is given as a current."""


def of_current(units: Mapping[str, str]) -> dict[str, str]:
    """Return units where the torque, or force, is given as a current, A: inertia is then in A s²/rad, or A s²/m."""
    return {name: _of_current(unit) for name, unit in units.items()}


def is_linear(units: Mapping[str, str]) -> bool:
    """Tell whether some units are those of a linear axis."""
    return units["velocity"] == LINEAR["velocity"]


def is_of_current(units: Mapping[str, str]) -> bool:
    """Tell whether the torque, or force, of some units is a current."""
    return units["torque"] == "A"


def _of_current(unit: str) -> str:
    if unit in MASS_IN_AMPERES:
        return MASS_IN_AMPERES[unit]
    if not unit.startswith("N"):
        return unit
    return unit.replace("N m" if unit.startswith("N m") else "N", "A", 1)

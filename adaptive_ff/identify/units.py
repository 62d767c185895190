"""Units of what is reported of a joint."""

from adaptive_ff.identify.families import SATURATIONS
from adaptive_ff.model.friction import UNITS

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

LINEAR = {
    "inertia": "kg",
    **dict.fromkeys(("coulomb", "stiction", "stiction_excess", *SATURATIONS, "offset", "torque"), "N"),
    **dict.fromkeys(("viscous", "viscous_asymmetry"), "N s/m"),
    **dict.fromkeys(("velocity", "stribeck_velocity", *(f"{shape}_velocity" for shape in SATURATIONS)), "m/s"),
    "friction_lag": "s",
}
"""Units of a linear axis."""


def of_current(units: dict[str, str]) -> dict[str, str]:
    """Return units where the torque, or force, is given as a current, A: inertia is then in A s²/rad."""
    angle = "m" if units is LINEAR else "rad"
    mass, torque = ("kg", "N") if units is LINEAR else ("kg m²", "N m")
    return {
        name: f"A s²/{angle}" if unit == mass else unit.replace(torque, "A", 1) if unit.startswith("N") else unit
        for name, unit in units.items()
    }

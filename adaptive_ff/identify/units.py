"""Units of what is reported of a joint."""

from adaptive_ff.model.friction import UNITS

ROTARY = {
    **UNITS,
    "offset": "N m",
    "stribeck_velocity": "rad/s",
    "viscous_asymmetry": "N m s/rad",
    **dict.fromkeys(("gravity_sine", "gravity_cosine", "saturation", "slow_saturation", "stiction_excess"), "N m"),
    **dict.fromkeys(("saturation_velocity", "slow_saturation_velocity"), "rad/s"),
    "torque": "N m",
    "velocity": "rad/s",
}
"""Units of a rotary joint."""

LINEAR = {
    "inertia": "kg",
    **dict.fromkeys(
        ("coulomb", "stiction", "stiction_excess", "saturation", "slow_saturation", "offset", "torque"), "N"
    ),
    **dict.fromkeys(("viscous", "viscous_asymmetry"), "N s/m"),
    **dict.fromkeys(("velocity", "stribeck_velocity", "saturation_velocity", "slow_saturation_velocity"), "m/s"),
    "friction_lag": "s",
}
"""Units of a linear axis."""

"""Units of the fields of a scenario, as powers of torque, time and angle, and scenarios in other units.

With scale factors that are powers of two, floating-point results scale exactly; a constant with a hidden unit shows.
"""

NONE, TORQUE, TIME, ANGLE = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)
SPEED, RATE, INERTIA, DAMPING, STIFFNESS = (0, -1, 1), (0, -1, 0), (1, 2, -1), (1, 1, -1), (1, 0, -1)
UNITS = {
    INERTIA: "inertia motor_inertia link_inertia",
    TORQUE: """
        coulomb stiction coulomb_backward stiction_backward offset gravity hysteresis torque_limit torque_resolution
        actuator.ripple_amplitude load friction_torque hysteresis_torque load_1 load_2 load_3 load_4""",
    (1, -1, 0): "attraction rate_limit",
    DAMPING: "viscous viscous_backward damping link_damping proportional",
    STIFFNESS: "stiffness link_stiffness integral",
    SPEED: """
        velocity motor_velocity stribeck_velocity velocity_noise peak speed position.limit velocities leap cosines
        sines""",
    (0, -2, 1): "acceleration",
    (0, -3, 1): "jerk",
    (0, -2.5, 1): "acceleration_walk",
    TIME: """
        duration time friction_lag solver_period sampling.period delay lag fade_in pause dwell hold reference.period
        memory warm_up_time thermal_time""",
    RATE: "frequencies bandwidth cutoff position.gain",
    ANGLE: """
        position deflection twist wind travel gap hysteresis_reach displacements rolling_range presliding
        encoder_resolution sensor.ripple_amplitude ripple_period position_period ripple_periods position_periods
        position_range positions distance""",
    (-1, 1, -1): "thermal_resistance",
    (-1, 0, 0): "load_share",
    NONE: """
        stribeck_shape gravity_phase gear_ratio link_share friction_share shares exponent jitter leap_share held
        held_share actuator.gain amplitudes repeats friction_scale coulomb_scale viscous_scale inertia_scale lag_scale
        warm_up_excess position_amplitude thinning seed position_hats turned slip_1 slip_2 slip_3 slip_4""",
}
POWERS = {name: powers for powers, names in UNITS.items() for name in names.split()}


def factor_of(table, name, scales):
    """What a field of a table is multiplied with where torque, time and angle are, each by its scale."""
    powers = POWERS[f"{table}.{name}" if f"{table}.{name}" in POWERS else name]
    torque, time, angle = (scale**power for scale, power in zip(scales, powers, strict=True))
    return torque * time * angle


def in_other_units(content, scales, table=""):
    """Content of a table, and of the tables in it, with torque, time and angle each times its scale."""

    def scaled(name, value):
        if isinstance(value, dict):
            return in_other_units(value, scales, name)
        if isinstance(value, list):
            return [scaled(name, one) for one in value]
        if isinstance(value, bool | str | None):
            return value
        factor = factor_of(table, name, scales)
        return value if factor == 1.0 else value * factor

    return {name: scaled(name, value) for name, value in content.items()}

"""Scenario files for tests: the built-in one as plain content, to be changed, put in other units, written as TOML."""

import copy
import json
import math
import tomllib

import pytest

from adaptive_ff import InputError
from adaptive_ff.scenario.scenario import BUILT_IN

REMOVED = object()
"""Stands for a field that is to be taken away."""


def built_in():
    """Content of the built-in scenario."""
    return tomllib.loads(BUILT_IN.read_text(encoding="utf-8"))


def short():
    """Content of a scenario that runs in no time."""
    return {**built_in(), "duration": 0.5, "controllers": ["pi"]}


def changed(content, path, value):
    """Content with the value at a path such as ``joint.inertia`` or ``change.0.time`` replaced, added or removed."""
    content = copy.deepcopy(content)
    *parents, last = [int(part) if part.isdecimal() else part for part in path.split(".")]
    place = content
    for part in parents:
        place = place.setdefault(part, {}) if isinstance(place, dict) else place[part]
    if value is REMOVED:
        del place[last]
    else:
        place[last] = value
    return content


def to_toml(content):
    """Content as a TOML text, tables inline."""
    return "".join(f"{_text(key)} = {_value(value)}\n" for key, value in content.items())


def refused(prefix, function, *arguments, **named):
    """What a refusal, which is one line, says after a prefix."""
    with pytest.raises(InputError) as caught:
        function(*arguments, **named)
    message = str(caught.value)
    assert message.splitlines() == [message]
    assert message.startswith(prefix)
    return message.removeprefix(prefix)


def write_scenario(folder, content, name="scenario.toml"):
    """Write content as a TOML file and return its path."""
    path = folder / name
    path.write_text(to_toml(content), encoding="utf-8")
    return path


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(key)} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
    return _text(value) if isinstance(value, str) else str(value)


def _text(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


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
"""Fields by powers of torque, time and angle."""

POWERS = {name: powers for powers, names in UNITS.items() for name in names.split()}


def factor_of(table, name, scales):
    """What a field of a table is multiplied with where torque, time and angle are, each by its scale."""
    powers = POWERS[f"{table}.{name}" if f"{table}.{name}" in POWERS else name]
    torque, time, angle = (scale**power for scale, power in zip(scales, powers, strict=True))
    return torque * time * angle


def in_other_units(content, scales, table=""):
    """Content of a table, and of the tables in it, with torque, time and angle each times its scale.

    With scales that are powers of two floating-point results scale exactly; a constant with a hidden unit shows.
    """

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

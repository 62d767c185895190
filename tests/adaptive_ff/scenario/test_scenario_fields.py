"""Every field of a scenario file: what is refused, and how the message names it."""

import copy
import math
import re
from types import UnionType
from typing import Annotated, Union, get_args, get_origin

import pytest
from pydantic import BaseModel
from scenario_files import REMOVED, built_in, changed, write_scenario

from adaptive_ff import InputError, Scenario, load_scenario, parse_scenario

RANGES = {
    "inertia": [0.1, 10.0],
    "coulomb": [0.1, 10.0],
    "viscous": [0.1, 10.0],
    "stiction": [1.0, 2.0],
    "friction_lag": [0.0, 0.05],
    "velocity_noise": [0.0, 0.005],
    "assumed_stribeck_velocity": [0.5, 2.0],
    "assumed_inertia": [0.7, 1.3],
}
SCALES = ("friction_scale", "coulomb_scale", "viscous_scale", "inertia_scale", "lag_scale")
POSITIVE = [
    "duration",
    *(f"joint.{name}" for name in ("inertia", "stribeck_velocity", "stribeck_shape", "solver_period")),
    "sampling.period",
    *(f"sensor.{name}" for name in ("encoder_resolution", "ripple_period")),
    *(f"actuator.{name}" for name in ("torque_limit", "rate_limit", "ripple_period")),
    *(f"variation.{name}" for name in ("warm_up_time", "position_period", "thermal_time")),
    *(f"velocity.{name}" for name in ("cutoff", "acceleration_walk")),
    *(f"joint.{name}" for name in ("stiffness", "link_stiffness", "hysteresis_reach")),
    *(f"joint.{name}" for name in ("displacements.0", "shares.0", "attraction", "rolling_range", "presliding")),
    "reference.frequencies.0",
    *(f"position.{name}" for name in ("gain", "limit", "encoder_resolution")),
    *(f"reference.{name}" for name in ("speed", "acceleration", "jerk", "period", "hold")),
    "reference.peak",
    *(f"feedback.{name}" for name in ("inertia", "bandwidth", "proportional")),
    *(f"adaptation.{name}" for name in ("stribeck_velocity", "stribeck_shape", "memory")),
    *(f"adaptation.{name}_periods.0" for name in ("ripple", "position")),
    "joint.gear_ratio",
    *(f"fixed.{name}" for name in ("stribeck_velocity", "stribeck_shape")),
    *(f"change.0.{name}" for name in SCALES),
    "actuator.gain",
    *(f"sweep.{name}.0" for name in ("inertia", "coulomb", "viscous", "assumed_stribeck_velocity", "assumed_inertia")),
]
NOT_NEGATIVE = [
    *(f"joint.{name}" for name in ("coulomb", "stiction", "viscous", "friction_lag")),
    *(f"joint.{name}_backward" for name in ("coulomb", "stiction", "viscous")),
    *(f"joint.{name}" for name in ("damping", "link_damping", "gap", "hysteresis")),
    "sampling.jitter",
    *(f"sensor.{name}" for name in ("velocity_noise", "leap", "leap_share", "held_share", "ripple_amplitude")),
    *(f"actuator.{name}" for name in ("torque_resolution", "ripple_amplitude", "delay", "lag")),
    "feedback.delay",
    "joint.gravity",
    *(f"variation.{name}" for name in ("position_amplitude", "load_share", "thermal_resistance", "thinning")),
    "reference.fade_in",
    "reference.dwell",
    "reference.pause.0",
    "feedback.integral",
    *(f"fixed.{name}" for name in ("inertia", "coulomb", "stiction", "viscous", "friction_lag")),
    "change.0.time",
    *(f"sweep.{name}.0" for name in ("friction_lag", "velocity_noise")),
]
NUMBERS = [
    *POSITIVE,
    *NOT_NEGATIVE,
    *("joint.link_share", "joint.exponent", "joint.gravity_phase", "change.0.load"),
    *("reference.positions.0", "reference.distance", "reference.velocities.0"),
    *("reference.cosines.0", "reference.sines.0"),
    "adaptation.position_range.0",
    *("joint.offset", "variation.warm_up_excess", "reference.amplitudes.0", "sweep.stiction.0"),
]
TEXTS = ["controllers.0", "reference.path", "reference.time", "reference.velocity", "reference.position"]
LISTS = [
    "controllers",
    "reference.frequencies",
    "reference.amplitudes",
    "reference.pause",
    "reference.positions",
    "reference.velocities",
    "change",
    "adaptation.ripple_periods",
    "adaptation.position_periods",
    "adaptation.position_range",
    *(f"sweep.{name}" for name in RANGES),
]
TABLES = [
    "joint",
    "sampling",
    "sensor",
    "velocity",
    "actuator",
    "reference",
    "position",
    "feedback",
    "adaptation",
    "fixed",
    "change.0",
    "variation",
    "sweep",
]
OTHERS = [
    "reference.repeats",
    "joint.axis",
    "seed",
    "joint.kind",
    "reference.kind",
    "velocity.method",
    "sensor.held",
    "actuator.reports_torque",
    *(f"adaptation.{name}" for name in ("identify", "motor_turn", "position_hats", "load_friction")),
]
KINDS = "'multisine', 'csv', 'point_to_point', 'triangle', 'staircase' or 'fourier'"
REQUIRED = [
    *("joint", "feedback", "adaptation", "reference.path"),
    *(f"joint.{name}" for name in ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity")),
    *("feedback.inertia", "adaptation.stribeck_velocity", "change.0.time"),
]

TOP = (
    "duration, seed, controllers, joint, sampling, sensor, velocity, actuator, reference, position, feedback, "
    "adaptation, fixed, change, variation, sweep"
)
FRICTION = "inertia, coulomb, stiction, viscous"
KNOWN = {
    "": TOP,
    "joint": (
        f"kind, {FRICTION}, stribeck_velocity, stribeck_shape, coulomb_backward, stiction_backward, viscous_backward, "
        "offset, axis, gravity, gravity_phase, gear_ratio, friction_lag, solver_period"
    ),
    "sampling": "period, jitter",
    "sensor": "velocity_noise, encoder_resolution, leap, leap_share, held, held_share, ripple_amplitude, ripple_period",
    "velocity": "method, cutoff, acceleration_walk",
    "actuator": (
        "torque_limit, torque_resolution, rate_limit, ripple_amplitude, ripple_period, delay, lag, gain, reports_torque"
    ),
    "reference": "kind, frequencies, amplitudes, peak, fade_in, pause",
    "position": "gain, limit, encoder_resolution",
    "feedback": "inertia, bandwidth, proportional, integral, delay",
    "adaptation": (
        "stribeck_velocity, stribeck_shape, memory, identify, ripple_periods, position_periods, motor_turn, "
        "position_hats, position_range, load_friction"
    ),
    "fixed": f"{FRICTION}, friction_lag, stribeck_velocity, stribeck_shape",
    "change.0": "time, friction_scale, coulomb_scale, viscous_scale, inertia_scale, lag_scale, load",
    "variation": (
        "warm_up_excess, warm_up_time, position_amplitude, position_period, load_share, thermal_resistance, "
        "thermal_time, thinning"
    ),
    "sweep": ", ".join(RANGES),
}


KIND_OF = {f"reference.{name}": "point_to_point" for name in ("speed", "acceleration", "jerk", "dwell", "distance")}
KIND_OF |= {"reference.period": "triangle", "reference.hold": "staircase"}


def without_lag(joint):
    return {name: value for name, value in joint.items() if name != "friction_lag"}


def complete(path=""):
    """Content with every table, and the alternative that a field belongs to."""
    change = [{"time": 30.0, "friction_scale": 0.6}]
    tables = {
        "change": change,
        "variation": {"warm_up_time": 20.0},
        "velocity": {"cutoff": 50.0},
        "position": {"gain": 10.0},
        "sweep": copy.deepcopy(RANGES),
    }
    content = {**built_in(), "controllers": ["pi"], **tables}
    if path in ("feedback.proportional", "feedback.integral"):
        content["feedback"] = {"inertia": 20.0, "proportional": 1000.0, "integral": 9000.0}
    if path in ("joint.stiffness", "joint.damping"):
        content["joint"] = {**without_lag(content["joint"]), "kind": "lugre", "stiffness": 1e5}
    if path.startswith(("joint.displacements", "joint.shares")) or path == "joint.attraction":
        joint = without_lag(content["joint"])
        content["joint"] = {**joint, "kind": "maxwell", "displacements": [0.1, 0.2, 0.3, 0.4], "shares": 4 * [0.25]}
    if path in ("joint.rolling_range", "joint.exponent"):
        content["joint"] = {**without_lag(content["joint"]), "kind": "rolling", "rolling_range": 0.1}
    if path == "joint.presliding":
        content["joint"] = {**content["joint"], "kind": "elasto_plastic", "presliding": 0.1}
    if path in ("joint.gap", "joint.hysteresis", "joint.hysteresis_reach"):
        content["joint"] = {
            **content["joint"],
            "kind": "backlash",
            "link_share": 0.5,
            "link_stiffness": 1e4,
            "gap": 0.1,
        }
        content["joint"] |= {"hysteresis": 1.0, "hysteresis_reach": 0.01}
    if path.startswith("joint.link"):
        content["joint"] = {**content["joint"], "kind": "elastic", "link_share": 0.5, "link_stiffness": 1e4}
    if path.startswith(("adaptation.position", "adaptation.ripple")):
        content["adaptation"] |= {"ripple_periods": [1.0]}
        content["adaptation"] |= {"position_periods": [1.0], "position_hats": 9, "position_range": [-1.0, 100.0]}
    if path.startswith("reference.pause"):
        content["reference"] = {**content["reference"], "pause": [10.0, 100.0]}
    if path == "sensor.encoder_resolution":
        content["sensor"] = {"encoder_resolution": 1e-5}
    if path.startswith("sensor.held"):
        content["sensor"] = {"held": 2, "held_share": 0.1}
    if path.startswith("sensor.ripple"):
        content["sensor"] = {"ripple_period": 100.0}
    if path.startswith("sensor.leap"):
        content["sensor"] = {"leap": 2.0, "leap_share": 0.1}
    kind = KIND_OF.get(path)
    if kind is not None:
        content["reference"] = {"kind": kind, **({"distance": 0.2} if kind == "point_to_point" else {})}
    if path.startswith("reference.positions"):
        content["reference"] = {"kind": "point_to_point", "positions": [0.2, 0.1]}
    if path.startswith(("reference.cosines", "reference.sines")):
        content["reference"] = {"kind": "fourier", "period": 5.0, "cosines": [0.0, 0.0], "sines": [0.2, 0.1]}
    if path.startswith("reference.velocities"):
        content["reference"] = {"kind": "staircase", "velocities": [0.2, 0.1]}
    if path in TEXTS[1:]:
        content["reference"] = {"kind": "csv", "path": "motion.csv"}
    return content


def refusal(folder, content):
    """What the message says after the name of the file; it is one line."""
    path = write_scenario(folder, content)
    with pytest.raises(InputError) as caught:
        load_scenario(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.splitlines() == [message]
    return message.removeprefix(f"{path}: ")


def leaves(annotation, path=()):
    """Paths of all fields that a model holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        for name, field in annotation.model_fields.items():
            yield from leaves(field.annotation, (*path, name))
    elif get_origin(annotation) is Annotated:
        yield from leaves(get_args(annotation)[0], path)
    elif get_origin(annotation) is list:
        yield from leaves(get_args(annotation)[0], (*path, "0"))
    elif get_origin(annotation) in (Union, UnionType):
        for part in get_args(annotation):
            yield from leaves(part, path)
    elif annotation is not type(None):
        yield ".".join(path)


def test_no_field_of_a_scenario_is_missing_from_the_lists_here():
    assert set(leaves(Scenario)) == {*NUMBERS, *TEXTS, *OTHERS}


def test_complete_content_is_accepted(tmp_path):
    assert load_scenario(write_scenario(tmp_path, complete())).change[0].time == 30.0


@pytest.mark.parametrize("path", REQUIRED)
def test_field_that_is_missing_is_named(tmp_path, path):
    assert refusal(tmp_path, changed(complete(path), path, REMOVED)) == f"{path} is missing; it must be given"


@pytest.mark.parametrize("path", NUMBERS)
@pytest.mark.parametrize("value", ["1", True, [1.0], {"a": 1.0}, math.nan, math.inf, -math.inf, 10**400])
def test_value_that_is_no_finite_number_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(path), path, value))
    shown = repr(value)[:50]
    assert message.startswith(f"{path} = {shown}")
    endings = "a finite number", "positive", "a positive and finite number of Hz, or 'auto'"
    assert message.endswith(tuple(f"is not allowed: it must be {ending}" for ending in endings))


@pytest.mark.parametrize("path", POSITIVE)
@pytest.mark.parametrize("value", [0.0, 0, -1.0, -1e-300])
def test_value_that_is_not_positive_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(path), path, value))
    assert message == f"{path} = {value!r} is not allowed: it must be positive"


@pytest.mark.parametrize("path", NOT_NEGATIVE)
@pytest.mark.parametrize("value", [-1.0, -5e-324])
def test_negative_value_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(path), path, value))
    assert message == f"{path} = {value!r} is not allowed: it must be greater than or equal to 0"


@pytest.mark.parametrize(
    "path",
    [
        path
        for path in NUMBERS
        if not path.endswith(
            (
                "period",
                "link_share",
                "leap_share",
                "held_share",
                "sensor.ripple_amplitude",
                "displacements.0",
                "shares.0",
            )
        )
    ],
)
def test_whole_number_is_a_number(tmp_path, path):
    whole = {"joint.stiffness": 100000, "feedback.bandwidth": 10, "reference.frequencies.0": 1, "change.0.time": 30}
    whole |= {"sampling.jitter": 2, "variation.position_amplitude": 0, "actuator.delay": 0, "feedback.delay": 0}
    whole |= {f"sweep.{name}.0": math.ceil(low) for name, (low, _) in RANGES.items()}
    value = whole.get(path, 90)
    content = changed(changed(complete(path), "joint.stiction", 100.0), path, value)
    found = load_scenario(write_scenario(tmp_path, content))
    for part in path.split("."):
        found = (
            found[int(part)] if part.isdecimal() else found[part] if isinstance(found, dict) else getattr(found, part)
        )
    assert found == value
    assert type(found) is float or part in ("delay", "seed")


@pytest.mark.parametrize("path", TEXTS)
@pytest.mark.parametrize("value", [1, 1.0, True, ["a"], {"a": "b"}])
def test_value_that_is_no_text_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(path), path, value))
    assert message == f"{path} = {value!r} is not allowed: it must be a valid string"


@pytest.mark.parametrize("path", LISTS)
@pytest.mark.parametrize("value", ["a", 1.0, True, {"a": 1}])
def test_value_that_is_no_list_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(path), path, value))
    allowed = "a list of tables; in a file write [[change]]" if path == "change" else "a valid list"
    assert message == f"{path} = {value!r} is not allowed: it must be {allowed}"


@pytest.mark.parametrize("names", [["pi", "pi"], ["pi", "adaptive", "pi"]])
def test_controller_that_is_named_twice_is_refused(names):
    with pytest.raises(
        InputError, match=rf"controllers = {re.escape(repr(names))} is not allowed: it must have every name"
    ):
        parse_scenario({**built_in(), "controllers": names}, "mine")


@pytest.mark.parametrize("path", ["controllers", "reference.frequencies", "reference.amplitudes"])
def test_empty_list_is_refused(tmp_path, path):
    message = refusal(tmp_path, changed(complete(), path, []))
    assert message == f"{path} = [] is not allowed: it must have at least 1 item"


@pytest.mark.parametrize("path", TABLES)
@pytest.mark.parametrize("value", ["a", 1.0, True, [1.0], [[]]])
def test_value_that_is_no_table_is_refused(tmp_path, path, value):
    message = refusal(tmp_path, changed(complete(), path, value))
    assert message == f"{path} = {value!r} is not allowed: it must be a table"


@pytest.mark.parametrize("value", ["1", 1.0, True, [1]])
def test_seed_that_is_no_whole_number_is_refused(tmp_path, value):
    message = refusal(tmp_path, {**complete(), "seed": value})
    assert message == f"seed = {value!r} is not allowed: it must be a valid integer"


@pytest.mark.parametrize("value", ["no", 0, 1.0, [True]])
def test_whether_a_drive_reports_its_torque_is_yes_or_no(tmp_path, value):
    message = refusal(tmp_path, changed(complete(), "actuator.reports_torque", value))
    assert message == f"actuator.reports_torque = {value!r} is not allowed: it must be a valid boolean"


@pytest.mark.parametrize("value", [-1, 2**63, 2**64, 10**400])
def test_seed_out_of_range_is_refused(tmp_path, value):
    message = refusal(tmp_path, {**complete(), "seed": value})
    assert message.startswith(f"seed = {value!r}"[:50])
    assert message.endswith(("it must be greater than or equal to 0", f"it must be less than {2**63}"))


@pytest.mark.parametrize("value", ["noise", "", "Multisine", 3, True])
def test_unknown_kind_of_reference_is_refused_and_the_known_are_listed(tmp_path, value):
    message = refusal(tmp_path, changed(complete(), "reference.kind", value))
    assert message == f"reference.kind = {str(value)!r} is not allowed: it must be {KINDS}"


def test_reference_without_a_kind_is_recorded_where_it_has_a_path_and_else_a_multisine(tmp_path):
    scenario = parse_scenario(changed(complete(), "reference.kind", REMOVED), "test")
    assert scenario.reference.kind == "multisine"
    with pytest.raises(InputError, match=r"gone\.csv: cannot be read"):
        parse_scenario({**complete(), "reference": {"path": "gone.csv"}}, "test")


@pytest.mark.parametrize("table", KNOWN)
@pytest.mark.parametrize("key", ["inertai", "csv", "multisine", "", "a.b", "a b\n"])
def test_unknown_key_is_refused_and_the_known_are_listed(tmp_path, table, key):
    content = complete()
    place = content
    for part in table.split(".") if table else []:
        place = place[int(part) if part.isdecimal() else part]
    place[key] = 1.0
    shown = key if key.isalpha() else repr(key)
    path = f"{table}.{shown}" if table else shown
    near = [name for name in KNOWN[table].split(", ") if name in ("inertia", "inertia_scale")]
    hint = f"did you mean {near[0]}? " if key == "inertai" and near else ""
    assert refusal(tmp_path, content) == f"{path} = 1.0 is not known; {hint}allowed there: {KNOWN[table]}"


def test_unknown_key_of_a_recorded_reference_is_answered_with_the_keys_of_its_kind(tmp_path):
    message = refusal(tmp_path, changed(complete("reference.path"), "reference.peak", 1.0))
    assert message == "reference.peak = 1.0 is not known; allowed there: kind, path, time, velocity, position"


def test_all_that_is_missing_or_wrong_is_named_at_once(tmp_path):
    content = changed(changed(complete(), "joint.inertia", -1.0), "fixed.viscous", "x")
    for path in ("joint.coulomb", "feedback.inertia", "adaptation"):
        content = changed(content, path, REMOVED)
    assert refusal(tmp_path, content) == (
        "joint.coulomb, feedback.inertia and adaptation are missing; they must be given; "
        "joint.inertia = -1.0 is not allowed: it must be positive; "
        "fixed.viscous = 'x' is not allowed: it must be a finite number"
    )


def test_many_wrong_fields_are_counted_beyond_what_a_person_reads(tmp_path):
    content = changed(complete(), "reference.frequencies", [-1.0] * 20)
    message = refusal(tmp_path, content)
    assert message.count("is not allowed: it must be positive") == 12
    assert message.endswith("; and 8 more")


def test_value_too_large_to_be_shown_is_refused_all_the_same(tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text(f"duration = 0x{'f' * 5000}", encoding="utf-8")
    with pytest.raises(InputError, match=r"duration = \(a huge int\) is not allowed: it must be a finite number"):
        load_scenario(path)
    path.write_text(f"duration.{'a.' * 5000}a = 1", encoding="utf-8")
    shown = r"(\(a huge dict\)|\{'a': [^;]{51}\.\.\.)"  # newer versions of Python show so many levels
    with pytest.raises(InputError, match=rf"duration = {shown} is not allowed: it must be a finite number"):
        load_scenario(path)


def test_unknown_way_to_a_velocity_is_refused_and_the_known_are_listed(tmp_path):
    message = refusal(tmp_path, {**complete(), "velocity": {"method": "magic"}})
    assert message == "velocity.method = 'magic' is not allowed: it must be 'difference', 'low_pass' or 'kalman'"


@pytest.mark.parametrize("share", [0.0, 1.0, 90, -0.1])
def test_share_of_the_link_is_between_none_and_all(tmp_path, share):
    message = refusal(tmp_path, changed(complete("joint.link_share"), "joint.link_share", share))
    assert message.startswith(f"joint.link_share = {share!r} is not allowed: it must be ")


@pytest.mark.parametrize("kind", ["lugr", "", 3])
def test_unknown_kind_of_joint_is_refused_and_the_known_are_listed(tmp_path, kind):
    message = refusal(tmp_path, changed(complete(), "joint.kind", kind))
    known = "'stribeck', 'lugre', 'elastic', 'backlash', 'maxwell', 'rolling' or 'elasto_plastic'"
    assert message == f"joint.kind = {str(kind)!r} is not allowed: it must be {known}"

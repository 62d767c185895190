"""Every argument of every public class and function: the message names it, shows the value and says what is allowed.

The signatures are walked. Each numeric argument is given what is no number, what is not finite and, where physics has
no sign for it, what is not positive; switches, series and paths likewise. What a new one may be is learnt from its
annotation; a plausible value for its name has to be added to ``VALUES``.
"""

import inspect
import math
import re
import types
from functools import cache, partial
from pathlib import Path
from typing import Union, get_args, get_origin

import numpy as np
import pytest
from pydantic import BaseModel

import adaptive_ff
import controllers
import plant
from adaptive_ff import baselines
from adaptive_ff.adaptive.tuning import Tuning

MODEL = plant.JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05)
SHORT = adaptive_ff.load_scenario().modified(duration=10.0, controllers=["pi"])
TIME = 0.01 * np.arange(400)
WAVE = np.sin(6.0 * TIME)
SPEEDS = np.geomspace(0.005, 0.3, 12)
CURVE = 60.0 + 30.0 * np.exp(-SPEEDS / 0.05) + 80.0 * SPEEDS
GAINS = {"proportional": 1256.0, "integral": 15800.0, "period": 0.01}
PI = controllers.PI(**GAINS)
LEARNING = {**GAINS, "inertia": 20.0, "stribeck_velocity": 0.05}
LEARNER, BRISTLES = (partial(one, **LEARNING) for one in (adaptive_ff.AdaptiveController, baselines.LearntFeedforward))
CYCLE = partial(baselines.Repetitive, **GAINS, inertia=20.0, cycle=5)

VALUES = {
    **{**GAINS, "delay": 0, "inertia": 20.0, "bandwidth": 5.0},
    **{"maximum_sensitivity": 2.0, "velocity_gain": 0.5, "disturbance_gain": 100.0, "bound": 100.0, "gain": 5.0},
    **{"limit": 1.0, "cutoff": 10.0, "position_gain": 0.5, "acceleration_gain": 10.0, "position_noise": 0.001},
    **{"acceleration_walk": 10.0, "velocity_noise": 0.002, "disturbance_walk": 10.0, "friction_slope": 1.0},
    **{"torque": 1.0, "reference": 0.1, "velocity": 0.0, "planned": 0.1, "position": 0.1, "duration": 0.01},
    **{"stribeck_velocity": 0.05, "stribeck_shape": 1.0, "solver_period": 0.001, "confidence": 0.95},
    **{"dead_zone": 0.05, "stiffness": 1e5, "rate": 1.0, "cycle": 5},
    **{"presliding": 1e-3, "model": adaptive_ff.TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)},
    **{"filter_pole": 30.0, "slowest": 0.01, "hold": 0.1},
}
"""Plausible values by the names of arguments."""

OWN = {
    "plant.Joint": {"model": MODEL},
    "plant.initial_state": {"joint": MODEL.parameters},
    "plant.schedule": {"changes": [plant.FrictionChange(time=1.0, friction_scale=0.5)]},
    "controllers.initial_velocity_state": {"estimator": controllers.direct_velocity(0.01)},
    "controllers.kalman_velocity": {"velocity_gain": 10.0},
    "adaptive_ff.compare": {"scenario": SHORT},
    "adaptive_ff.simulate": {"scenario": SHORT, "controller": "pi"},
    "adaptive_ff.parse_scenario": {"content": {}, "name": "mine"},
    "adaptive_ff.export_controller": {"controller": PI, "out": "drive"},
    "adaptive_ff.run_in_c": {"controller": PI},
    "adaptive_ff.read_log": {"path": "log.csv", "torque": "u", "position": "q"},
    "adaptive_ff.Log": {"name": "log", "time": TIME, "torque": WAVE, "velocity": WAVE},
    "adaptive_ff.identify_log": {"log": adaptive_ff.Log("log", TIME, WAVE, velocity=WAVE)},
    "adaptive_ff.identify_series": {"velocity": WAVE, "torque": WAVE},
    "adaptive_ff.identify_torque_form": {"time": TIME, "velocity": WAVE, "torque": WAVE},
    "adaptive_ff.JointGroup.step": {"reference": [0.1], "velocity": [0.0]},
    "adaptive_ff.assert_no_regression": {"comparison": adaptive_ff.Comparison(SHORT, {}), "baseline": "earlier.json"},
    "adaptive_ff.read_baseline": {"path": "earlier.json"},
    "adaptive_ff.load_scenario": {},
    "adaptive_ff.fit_stribeck": {"velocity": SPEEDS, "torque": CURVE, "standard_error": np.ones(12)},
    "adaptive_ff.support_points": {"velocity": [[0.1, 0.11], [0.2, 0.21]], "torque": [[1.0, 2.0], [2.0, 3.0]]},
}
"""Arguments of single functions: what is no number, and what has another meaning there."""

UNCHECKED = """
    plant.encoder_reading plant.scaled_friction plant.stribeck_decay
    controllers.Controller controllers.Native controllers.check_positive
    controllers.compiled controllers.delayed controllers.estimate_velocity
    controllers.natural controllers.planned_inputs controllers.remember controllers.step_in_memory
    controllers.PILoop controllers.DesignedLoop controllers.Observing controllers.argument controllers.controller
    adaptive_ff.OwnController.step adaptive_ff.Comparison.plot"""
"""Parts of loops, which are given what has been checked before, and what a user's controller overrides."""

SIGNED = """
    torque reference velocity position planned friction_slope next_reference correction realised_torque feedforward
    acting_reference next_acting_reference torque_delay gear_ratio"""
"""Numbers of either sign; that a gear ratio is not zero is asked of it below."""

ZERO = "integral delay velocity_lag velocity_noise regressors position_hats held_out deviation friction_share"
"""Numbers that may be zero."""

LOST, SIGNS = (math.nan, math.inf), (0, -1, -5e-324)
GAIN = {"proportional": (0,)}  # none, where the integral acts alone
ACCEPTED = {
    "plant.whole_multiple": {"duration": (*LOST, *SIGNS)},
    "controllers.PI": GAIN,
    "controllers.check_gains": GAIN,
    **{f"controllers.{name}": GAIN for name in ("DisturbanceObserver", "ExtendedState", "KalmanDisturbance")},
    "controllers.SuperTwisting": GAIN,
    "controllers.PositionLoop": {"limit": (math.inf,)},
    "controllers.PositionLoop.step": {"position": LOST},
    "controllers.Controller.step": dict.fromkeys(("velocity", "position", "realised_torque"), LOST),
    "controllers.loop_systems": {"proportional": SIGNS, "integral": SIGNS},
    "adaptive_ff.AdaptiveController": {"torque_limit": (math.inf,)},
    **{f"adaptive_ff.baselines.{name}": GAIN for name in baselines.__all__},
    "adaptive_ff.baselines.LuGreObserver": {**GAIN, "gain": (0,)},
    "adaptive_ff.baselines.ModelBased": {**GAIN, "held": (0,)},
    **{f"adaptive_ff.baselines.{name}": {"compensated": (0,)} for name in baselines.__all__ if "Canudas" in name},
    "adaptive_ff.baselines.LearntFeedforward": {"lag": (0,)},
    "adaptive_ff.baselines.Repetitive": {**GAIN, "cycle": (0,), "lead": (0,)},
}
"""Where what is not finite, or has no other sign, has a meaning of its own."""

BEYOND = {"maximum_sensitivity": (1.0, 0.5), "confidence": (1.0, 95.0), "held_out": (1.0,), "delay": (10.5,)}
BEYOND |= {"compensated": (1.1,), "held": (1.1,)}
"""What lies beyond a limit of its own."""

ELSEWHERE = {
    ("controllers.Controller.step", "regressors"),  # a controller that has no use for any refuses all
    ("adaptive_ff.AdaptiveController", "position_map"),  # needs a map
    ("adaptive_ff.AdaptiveController", "map_deviation"),
    ("adaptive_ff.JointGroup.step", "dt"),  # one number for all joints
    ("adaptive_ff.JointGroup.step", "regressors"),
    ("adaptive_ff.identify_torque_form", "slowest"),
    ("adaptive_ff.identify_torque_form", "hold"),
    ("adaptive_ff.identify_series", "use"),
    ("adaptive_ff.support_points", "drive"),
    ("adaptive_ff.identify_log", "torque_delay"),
    ("adaptive_ff.read_log", "period"),  # the message begins with the file
}
"""Arguments with rules of their own, which other tests look at."""


INSTANCES = {
    "plant.Joint": lambda: plant.Joint(MODEL),
    "controllers.Controller": lambda: controllers.PI(**GAINS),
    "controllers.PIDesign": lambda: controllers.design_pi(20.0, 0.01),
    "controllers.PositionLoop": lambda: controllers.PositionLoop(5.0),
    "adaptive_ff.Comparison": lambda: adaptive_ff.Comparison(SHORT, {}),
    "adaptive_ff.JointGroup": lambda: adaptive_ff.JointGroup({"elbow": adaptive_ff.AdaptiveController(**LEARNING)}),
}
"""Objects whose methods are walked; results, which are not made by hand, apart."""


def public(package):
    """Public classes and functions of a package, and what its classes define, by name; records apart."""
    for name in package.__all__:
        value, full = getattr(package, name), f"{package.__name__}.{name}"
        if inspect.isfunction(value):
            yield full, value
        if not inspect.isclass(value) or issubclass(value, tuple | BaseModel | Exception):
            continue
        is_result = hasattr(value, "__dataclass_fields__")
        if not is_result:
            yield full, value
        elif full not in INSTANCES:
            continue
        for member, found in vars(value).items():
            if member[0] != "_" and isinstance(found, types.FunctionType | classmethod | staticmethod):
                yield f"{full}.{member}", getattr(value, member)


def parts(annotation):
    """The alternatives of an annotation, None apart."""
    found = get_args(annotation) if get_origin(annotation) in (Union, types.UnionType) else (annotation,)
    return {one for one in found if one is not type(None)}


def kind_of(annotation):
    """What an argument is checked as: ``number``, ``switch``, ``series``, ``path``; None for what has no rule here."""
    found = parts(annotation)
    if found == {int}:
        return "whole number"
    if float in found and found <= {float, int}:
        return "number"
    if found == {bool}:
        return "switch"
    if "ArrayLike" in str(annotation) or "Sequence[float]" in str(annotation):
        return "series"
    return "path" if found & {Path} else None


@cache
def arguments():
    """Kinds of the arguments of everything public, by name; kernels, which take records, apart."""
    found = {}
    for package in (plant, controllers, adaptive_ff, baselines):
        for name, function in public(package):
            given = [one for one in inspect.signature(function).parameters.values() if one.name != "self"]
            given = [one for one in given if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]
            records = [one for one in given if inspect.isclass(one.annotation) and issubclass(one.annotation, tuple)]
            kinds = {one.name: kind_of(one.annotation) for one in given}
            if any(kinds.values()) and name not in UNCHECKED.split() and (not records or inspect.isclass(function)):
                checked = {key: kind for key, kind in kinds.items() if kind and (name, key) not in ELSEWHERE}
                found[name] = function, checked
    return found


def call(name, /, **wrong):
    """Call something public with plausible arguments, but for those that are given."""
    function, _ = arguments()[name]
    if inspect.isfunction(function) and "self" in inspect.signature(function).parameters:
        function = getattr(INSTANCES[name.rpartition(".")[0]](), name.rpartition(".")[2])
    own, needed = OWN.get(name, {}), inspect.signature(function).parameters.values()
    given = {one.name: VALUES[one.name] for one in needed if one.default is one.empty and one.name in VALUES}
    return function(**{**given, **own, **wrong})


def refused(name, argument, wrong, error):
    with pytest.raises(error, match=rf"^{argument}(\[\d+\])? = [\s\S]* is not allowed: ") as caught:
        call(name, **{argument: wrong})
    return str(caught.value)


def of_kind(*kinds):
    return [name for name, (_, found) in arguments().items() if {*kinds} & {*found.values()}]


def each(name, *kinds):
    return [argument for argument, found in arguments()[name][1].items() if found in kinds]


NUMBERS = ("number", "whole number")


@pytest.mark.parametrize("name", [name for name in of_kind(*NUMBERS) if not name.startswith("adaptive_ff.")])
def test_plausible_numbers_are_accepted(name):
    own = OWN.get(name, {})
    call(name, **{one: own.get(one, VALUES[one]) for one in each(name, *NUMBERS) if one in VALUES})


@pytest.mark.parametrize("name", of_kind(*NUMBERS))
def test_what_is_no_number_is_refused(name):
    for argument in each(name, *NUMBERS):
        for wrong in ("abc", "5", [1.0, 2.0], {}, 1j):
            said = refused(name, argument, wrong, (TypeError, ValueError))
            if argument in each(name, "number"):
                assert said == f"{argument} = {wrong!r} is not allowed: it must be a number"
            assert re.search(r" = .* is not allowed: it must be (0, or )?a (whole )?number", said)


@pytest.mark.parametrize("name", of_kind(*NUMBERS))
def test_number_that_no_machine_has_is_refused(name):
    for argument in each(name, *NUMBERS):
        signs = () if argument in SIGNED.split() else SIGNS[1:] if argument in ZERO.split() else SIGNS
        broken = (0.5,) if argument in each(name, "whole number") else ()
        for wrong in (*LOST, -math.inf, 10**400, *signs, *broken, *BEYOND.get(argument, ())):
            accepted = ACCEPTED.get(name, {}).get(argument, ())
            if wrong not in accepted and not (wrong == -math.inf and math.nan in accepted):
                refused(name, argument, wrong, ValueError)


@pytest.mark.parametrize("name", of_kind("series"))
def test_what_is_no_series_is_refused(name):
    for argument in each(name, "series"):
        boxed = [np.array([one, 2.0], dtype=object) for one in ("1", b"1", None)]
        for wrong in ("abc", "5", ["1", "2"], {"a": 1.0}, [1j], [[1.0], [2.0, 3.0]], *boxed):
            assert re.search(r"it must be (\d+ |a )?number", refused(name, argument, wrong, (TypeError, ValueError)))


MEASURED = [name for name in of_kind("series") if isinstance(OWN.get(name, {}).get("velocity"), np.ndarray | list)]


@pytest.mark.parametrize("name", [name for name in MEASURED if "JointGroup" not in name])
def test_series_with_a_hole_or_of_another_shape_are_refused(name):
    for argument in each(name, "series"):
        for hole in LOST:
            torn = np.array(OWN[name][argument])
            torn.flat[-1] = hole
            with pytest.raises(ValueError, match=rf"^{argument}\[[\d, ]+\] = {hole} is not allowed: all "):
                call(name, **{argument: torn})
        for shape in ((0,), (5,), (2, 2, 2)):
            with pytest.raises(ValueError, match=rf"^(?=.*\b{argument}\b).*; \w+ must (be|have) "):
                call(name, **{argument: np.ones(shape)})


@pytest.mark.parametrize("name", of_kind("path"))
def test_what_is_no_path_is_refused(name):
    for argument in each(name, "path"):
        for wrong in (1, [], b"mine"):
            said = refused(name, argument, wrong, TypeError)
            assert said.startswith(f"{argument} = {wrong!r} is not allowed: it must be a path")


@pytest.mark.parametrize("name", of_kind("switch"))
def test_what_is_neither_true_nor_false_is_refused(name):
    for argument in each(name, "switch"):
        for wrong in ("off", 2, math.nan, None, [True]):
            assert refused(name, argument, wrong, ValueError).endswith(" is not allowed: it must be True or False")


A_COMPARISON = r"it must be a Comparison: compare\(scenario\) makes one"
A_JOINT = "it must be a JointModel, or another joint"
KINDS = [
    *(("plant.Joint", "model", wrong, A_JOINT) for wrong in (None, "stribeck", MODEL.parameters, {"inertia": 20.0})),
    *(("plant.initial_state", "joint", wrong, "it must be the parameters of a joint") for wrong in (None, "x", MODEL)),
    ("plant.schedule", "changes", [1.0], "it must be a sequence of FrictionChange"),
    ("plant.schedule", "variation", 1.0, "it must be a FrictionVariation"),
    *(("controllers.PI.design", "friction", wrong, "it must be a function of the speed") for wrong in (60.0, "x")),
    ("controllers.initial_velocity_state", "estimator", "low-pass", "it must be an estimator"),
    ("adaptive_ff.AdaptiveController", "model", "mine", "it must be a TorqueModel, or values by name"),
    ("adaptive_ff.AdaptiveController", "model", [1.0, 2.0], "it must be a TorqueModel, or values by name"),
    ("adaptive_ff.AdaptiveController", "tuning", {"clip": 3.0}, "it must be a Tuning"),
    ("adaptive_ff.assert_no_regression", "comparison", None, A_COMPARISON),
    ("adaptive_ff.compare", "progress", "loud", "it must be a function"),
    ("adaptive_ff.simulate", "progress", 1, "it must be a function"),
    ("adaptive_ff.simulate", "setup", SHORT, r"it must be what build_setup\(scenario\) returns"),
    ("adaptive_ff.simulate", "name", 1, "it must be a text"),
    ("adaptive_ff.export_controller", "prefix", 1, "it must be a text"),
    ("adaptive_ff.identify_log", "position_periods", 0.5, "it must be a sequence of periods"),
    ("adaptive_ff.parse_scenario", "content", "joint.toml", "it must be tables and fields by name"),
    ("adaptive_ff.read_log", "torque", None, "it must be the name of a column"),
    ("adaptive_ff.read_log", "time", 3, "it must be the name of a column"),
    ("adaptive_ff.read_log", "extra", ["w"], "it must be by name"),
    ("adaptive_ff.read_log", "scale", 2.0, "it must be by name"),
]


@pytest.mark.parametrize(("name", "argument", "wrong", "rule"), KINDS)
def test_another_kind_is_refused_with_what_is_allowed(name, argument, wrong, rule):
    with pytest.raises(TypeError, match=rf"^{argument} = .* is not allowed: {rule}"):
        call(name, **{argument: wrong})


BAD = [
    (controllers.loop_margins_of, (5,), r"systems = 5 is not allowed: it must be what loop_systems returns$"),
    (adaptive_ff.JointGroup.from_table, ("arm.toml",), "table = .* must be a table with period and joints"),
    (
        adaptive_ff.JointGroup,
        ({"a": LEARNER(), "b": LEARNER(period=0.02)},),
        r"periods = \[0.01, 0.02\] are not allowed",
    ),
    (adaptive_ff.fit_stribeck, (SPEEDS, 6 * [1.0, -1.0]), "torque is 0 N m higher in the direction of motion"),
    (adaptive_ff.Log, ("log", TIME, WAVE, WAVE, None, [WAVE]), "extra = .* it must be series by name"),
    (adaptive_ff.Log, ("log", None, WAVE, WAVE), "log: time must be a one-dimensional array of numbers"),
    *(
        (adaptive_ff.Log, ("log", TIME, one, WAVE), "log: torque must be a one-dimensional array of numbers")
        for one in (None, WAVE.astype(str))
    ),
    (adaptive_ff.Log, ("log", TIME, WAVE, [[0.0]]), "log: position must be a one-dimensional array of numbers"),
    (adaptive_ff.Log, ("log", TIME, WAVE), "log: position and velocity are both missing"),
    (adaptive_ff.Log, ("log", TIME, WAVE[:4], WAVE), "log: torque has 4 samples; it must have 400"),
    (adaptive_ff.Log, ("log", TIME, WAVE, WAVE, None, {"own": WAVE[:, None]}), "log: own must be a one-dimensional"),
    (adaptive_ff.regressions, (SHORT, {}), f"comparison = .* is not allowed: {A_COMPARISON}"),
    (adaptive_ff.regressions, (adaptive_ff.Comparison(SHORT, {}), "x"), r"baseline = .* what read_baseline\(path\)"),
    (adaptive_ff.regressions, (adaptive_ff.Comparison(SHORT, {}), {"pi": {}}), "baseline is not allowed: it lacks"),
    (controllers.delay_line, (10.5,), "delay = 10.5 is not allowed: it must be from 0 to 10 "),
    (partial(PI.step, regressors=[1.0]), (0.1, 0.0), "regressors is not allowed: PI"),
    *((partial(LEARNER, regressors=wrong), (), f"regressors = {wrong} is not allowed") for wrong in (21, True)),
    *(
        (partial(LEARNER, tuning=Tuning(**{name: wrong})), (), f"tuning.{name} = {wrong} is not allowed: {allowed}")
        for name, wrong, allowed in (
            *((name, -1.0, "it must be from ") for name in Tuning._fields),
            ("growth", 0.99, "it must be from 1 to inf"),
            ("distances", 10.5, "it must be from 1 to 10"),
        )
    ),
    *(
        (partial(LEARNER(regressors=2).step, regressors=wrong), (0.1, 0.0), ".*it must be 2 numbers")
        for wrong in ([], [1.0], [1.0, 2.0, 3.0], 1.0)
    ),
    (partial(LEARNER(regressors=2).step, regressors=[1.0, 1e7]), (0.1, 0.0), r"regressors = 1e\+07 is not allowed"),
    (partial(BRISTLES, reaches=[1e-3, 1e-3]), (), "reaches"),
    (partial(BRISTLES, centres=[1.0]), (), ".*two at least"),
    (partial(CYCLE, lead=5), (), "lead = 5 is not allowed: it must be less than the cycle, 5"),
    (partial(CYCLE, gain=2.0), (), "gain = 2.0 is not allowed"),
    (adaptive_ff.support_points, ([0.1, 0.2], [1.0]), r"velocity has shape \(2,\), torque \(1,\)"),
    (adaptive_ff.support_points, ([0.1, 0.2], [1.0, 2.0]), ".*drive is not given"),
    (adaptive_ff.support_points, ([0.1, 0.2], [1.0, 2.0], [1]), r"drive has shape \(1,\)"),
    (adaptive_ff.support_points, ([0.1, 0.2, 0.2], [1.0, 2.0, 1.0], [1, 2, 2]), ".*single reading"),
    (adaptive_ff.support_points, ([0.1, 0.1], [1.0, 2.0], [math.nan, 1.0]), ".*label that is not a finite number"),
    (adaptive_ff.support_points, ([[0.1, -0.1]], [[1.0, 2.0]]), ".*drive 0 does not move"),
    (adaptive_ff.support_points, ([[0.1, 0.1], [0.2, 0.2]], [[1.0, 2.0], [3.0, 3.0]]), ".*drive 1 has no spread"),
]


@pytest.mark.parametrize(("function", "given", "message"), BAD)
def test_what_no_function_can_use_is_refused(function, given, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        function(*given)


def test_takeover_takes_numbers_of_any_kind():
    at_integer, at_float = controllers.PI(**GAINS), controllers.PI(**GAINS)
    at_integer.take_over(True, 1, 0)
    at_float.take_over(1.0, 1.0, 0.0)
    assert at_integer.state == at_float.state


def test_numbers_of_any_kind_are_taken():
    given = dict(list(OWN["adaptive_ff.fit_stribeck"].items())[:2])
    plain = adaptive_ff.fit_stribeck(*(values.astype(object).tolist() for values in given.values()))
    boxed = adaptive_ff.fit_stribeck(*(values.astype(object) for values in given.values()))
    assert adaptive_ff.fit_stribeck(**given).estimates == plain.estimates == boxed.estimates

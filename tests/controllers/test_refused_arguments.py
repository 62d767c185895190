"""Every public function that takes numbers names the argument that is none, its value and what is allowed."""

import inspect
import math
import re

import pytest

import controllers
from controllers import (
    PI,
    DisturbanceObserver,
    ExtendedState,
    KalmanDisturbance,
    PositionLoop,
    SuperTwisting,
    loop_systems,
)

LOOP = {"proportional": 1256.0, "integral": 15800.0, "period": 0.01}
ONE_GAIN = {"proportional": 1256.0, "period": 0.01}
DESIGN = {"inertia": 20.0, "period": 0.01, "bandwidth": 10.0, "maximum_sensitivity": 1.7, "delay": 0}
OBSERVER = {**LOOP, **DESIGN, "bandwidth": 1.0}

CALLS = {
    "PI": (PI, {**LOOP, "delay": 0.0}),
    "PI.design": (PI.design, DESIGN),
    "PI.take_over": (lambda **given: PI(**LOOP).take_over(**given), {"torque": 1.0, "reference": 0.1, "velocity": 0.0}),
    "DisturbanceObserver": (DisturbanceObserver, {**LOOP, "inertia": 20.0, "bandwidth": 5.0, "delay": 0.0}),
    "DisturbanceObserver.design": (DisturbanceObserver.design, OBSERVER),
    "ExtendedState": (ExtendedState, {**ONE_GAIN, "inertia": 20.0, "bandwidth": 5.0, "delay": 0.0}),
    "ExtendedState.design": (
        ExtendedState.design,
        {name: value for name, value in OBSERVER.items() if name != "integral"},
    ),
    "KalmanDisturbance": (
        KalmanDisturbance,
        {**LOOP, "inertia": 20.0, "velocity_gain": 0.5, "disturbance_gain": 100.0, "delay": 0.0},
    ),
    "KalmanDisturbance.design": (KalmanDisturbance.design, OBSERVER),
    "KalmanDisturbance.walk": (
        KalmanDisturbance.walk,
        {"inertia": 20.0, "period": 0.01, "velocity_noise": 0.002, "bandwidth": 5.0},
    ),
    "SuperTwisting": (SuperTwisting, {**LOOP, "inertia": 20.0, "bound": 100.0, "delay": 0.0}),
    "PositionLoop": (PositionLoop, {"gain": 5.0, "limit": 1.0}),
    "PositionLoop.step": (lambda **given: PositionLoop(5.0).step(**given), {"planned": 0.1, "position": 0.1}),
    "check_gains": (controllers.check_gains, {**LOOP, "delay": 0.0}),
    "default_position_gain": (controllers.default_position_gain, {"bandwidth": 5.0}),
    "delay_line": (controllers.delay_line, {"delay": 1.0}),
    "design_position_loop": (
        controllers.design_position_loop,
        {"period": 0.01, "bandwidth": 10.0, "gain": 5.0, "delay": 0, "maximum_sensitivity": 1.7},
    ),
    "difference_velocity": (controllers.difference_velocity, {"period": 0.01}),
    "direct_velocity": (controllers.direct_velocity, {"period": 0.01}),
    "fastest_bandwidth": (
        controllers.fastest_bandwidth,
        {"period": 0.01, "delay": 0, "maximum_sensitivity": 1.7},
    ),
    "initial_velocity_state": (
        lambda **given: controllers.initial_velocity_state(controllers.direct_velocity(0.01), **given),
        {"position": 0.1, "velocity": 0.2},
    ),
    "kalman_disturbance_gains": (
        controllers.kalman_disturbance_gains,
        {"inertia": 20.0, "period": 0.01, "velocity_noise": 0.002, "disturbance_walk": 10.0},
    ),
    "kalman_velocity": (
        controllers.kalman_velocity,
        {"position_gain": 0.5, "velocity_gain": 10.0, "acceleration_gain": 10.0, "period": 0.01},
    ),
    "kalman_velocity_gains": (
        controllers.kalman_velocity_gains,
        {"position_noise": 0.001, "acceleration_walk": 10.0, "period": 0.01},
    ),
    "loop_systems": (
        loop_systems,
        {"proportional": 100.0, "integral": 100.0, "inertia": 1.0, "period": 0.01, "delay": 0, "friction_slope": 1.0},
    ),
    "low_pass_lag": (controllers.low_pass_lag, {"cutoff": 10.0, "period": 0.01}),
    "low_pass_velocity": (controllers.low_pass_velocity, {"cutoff": 10.0, "period": 0.01}),
    "pi_gains": (controllers.pi_gains, {"inertia": 20.0, "bandwidth": 10.0}),
}
ARGUMENTS = [(call, name) for call, (_, given) in CALLS.items() for name in given]
UNLIMITED = {("PositionLoop", "limit"): (math.inf,), ("PositionLoop.step", "position"): (math.inf, math.nan)}
"""Where what is not finite has a meaning of its own."""

HOLDS_NUMBERS = {"check_positive"}
"""Functions that take numbers of any name, which other tests look at."""

SCALAR = ("float", "int", "float | None")


def refused(call, name, wrong, kind):
    function, given = CALLS[call]
    with pytest.raises(kind, match=rf"^{name} = .* is not allowed: ") as error:
        function(**{**given, name: wrong})
    return str(error.value)


@pytest.mark.parametrize("call", CALLS)
def test_plausible_numbers_are_accepted(call):
    function, given = CALLS[call]
    function(**given)


@pytest.mark.parametrize(("call", "name"), ARGUMENTS)
@pytest.mark.parametrize("wrong", ["abc", "5", [1.0, 2.0], {}, 1j], ids=repr)
def test_what_is_no_number_is_refused_by_name(call, name, wrong):
    assert refused(call, name, wrong, TypeError) == f"{name} = {wrong!r} is not allowed: it must be a number"


@pytest.mark.parametrize(("call", "name"), ARGUMENTS)
@pytest.mark.parametrize("wrong", [math.nan, math.inf, 10**400], ids=["nan", "inf", "huge"])
def test_what_no_joint_can_have_is_refused_by_name(call, name, wrong):
    if wrong not in UNLIMITED.get((call, name), ()):
        refused(call, name, wrong, ValueError)


@pytest.mark.parametrize("friction", [60.0, "coulomb"])
def test_friction_that_cannot_be_called_is_refused(friction):
    with pytest.raises(TypeError, match=r"^friction = .* is not allowed: it must be a function of the speed$"):
        PI.design(**DESIGN, friction=friction)


def test_what_is_no_loop_has_no_margins():
    with pytest.raises(TypeError, match=r"^systems = 5 is not allowed: it must be what loop_systems returns$"):
        controllers.loop_margins_of(5)


def test_state_of_what_estimates_no_velocity_is_refused():
    with pytest.raises(TypeError, match=r"^block = 'low-pass' is not allowed: it must be an estimator"):
        controllers.initial_velocity_state("low-pass", 0.0)


def test_takeover_takes_numbers_of_any_kind():
    at_integer, at_float = PI(**LOOP), PI(**LOOP)
    at_integer.take_over(True, 1, 0)
    at_float.take_over(1.0, 1.0, 0.0)
    assert at_integer.state == at_float.state


@pytest.mark.parametrize("delay", [-1.0, 10.5])
def test_line_for_a_delay_that_no_drive_has_is_refused(delay):
    with pytest.raises(ValueError, match=rf"^delay = {re.escape(str(delay))} is not allowed: it must be from 0 to 10 "):
        controllers.delay_line(delay)


def test_no_public_function_of_plain_numbers_is_left_out():
    plain = []
    for name in controllers.__all__:
        function = getattr(controllers, name)
        if not inspect.isfunction(function) or "register_jitable" in inspect.getsource(function).partition("def ")[0]:
            continue
        kinds = {str(parameter.annotation) for parameter in inspect.signature(function).parameters.values()}
        if kinds and kinds <= {"<class 'float'>", "<class 'int'>", *SCALAR}:
            plain.append(name)
    assert {*plain} - HOLDS_NUMBERS <= {*CALLS} | {"natural"}

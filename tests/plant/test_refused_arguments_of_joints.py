"""A joint that is stepped by hand names the argument that is no number, its value and what is allowed."""

import pytest

from plant import Joint, JointModel, initial_state, whole_multiple

MODEL = JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05)
CALLS = {
    "Joint": (lambda **given: Joint(MODEL, **given), {"velocity": 0.1}),
    "Joint.step": (lambda **given: Joint(MODEL).step(**given), {"torque": 100.0, "duration": 0.01}),
    "initial_state": (lambda **given: initial_state(MODEL.parameters, **given), {"velocity": 0.1}),
    "whole_multiple": (whole_multiple, {"duration": 0.01, "period": 0.001}),
}


@pytest.mark.parametrize(("call", "name"), [(call, name) for call, (_, given) in CALLS.items() for name in given])
@pytest.mark.parametrize("wrong", ["abc", "5", None, [1.0, 2.0], 1j], ids=repr)
def test_what_is_no_number_is_refused_by_name(call, name, wrong):
    function, given = CALLS[call]
    function(**given)
    with pytest.raises(TypeError) as refused:
        function(**{**given, name: wrong})
    assert str(refused.value) == f"{name} = {wrong!r} is not allowed: it must be a number"


def test_whole_number_that_no_float_holds_is_refused_in_a_short_message():
    with pytest.raises(ValueError, match=r"^torque = 1000.{0,60} is not allowed: its size must be below 1e308$"):
        Joint(MODEL).step(10**400, 0.01)


@pytest.mark.parametrize("wrong", [None, "stribeck", MODEL.parameters, {"inertia": 20.0}], ids=repr)
def test_what_is_no_joint_is_refused(wrong):
    with pytest.raises(TypeError, match=r"^model = .* is not allowed: it must be a JointModel, or another joint"):
        Joint(wrong)


@pytest.mark.parametrize("wrong", [None, "stribeck", MODEL], ids=repr)
def test_state_of_what_is_no_joint_is_refused(wrong):
    with pytest.raises(TypeError, match=r"^joint = .* is not allowed: it must be the parameters of a joint"):
        initial_state(wrong, 0.0)


def test_period_of_zero_holds_no_duration():
    with pytest.raises(ValueError, match=r"^period = 0\.0 is not allowed: it must be positive$"):
        whole_multiple(0.01, 0.0)

"""What is made of an identified joint whose numbers are given by hand."""

import math
import re
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff import InputError
from adaptive_ff.identify.columns import ROTARY, Map, Shape
from adaptive_ff.identify.identification import _check_plausible
from adaptive_ff.identify.motion import TUNING
from adaptive_ff.identify.regression import Fit, Model, Parameter
from adaptive_ff.identify.result import CARE, GOOD, UNUSABLE, LogIdentification
from adaptive_ff.identify.scenario_text import _beside_friction, joined_ends, left_out
from adaptive_ff.identify.simulators import ENDINGS

HEAVY = {"inertia": 2.0, "coulomb": 3.0, "viscous": 0.5, "offset": -0.5, "gravity_sine": 4.0, "gravity_cosine": 3.0}
PLACE, SHAPE = Map((0.7, 0.3)), Shape(load=(1.0, 0.0, 0.0))


def identified(shape=SHAPE, *, left=0.1, half=0.1, validation=None, unidentified=(), **values):
    """An identification of the values, with intervals of a fraction of them to either side."""
    values = HEAVY | values | shape.bends
    parameters = {name: Parameter(one, one - half * abs(one), one + half * abs(one)) for name, one in values.items()}
    rows = SimpleNamespace(position=np.array([0.25]))
    data = SimpleNamespace(log=make_log(0.1), place=PLACE, velocity=np.array([-1.0, 2.0]), longest=rows)
    fit = Fit(Model(tuple(values), shape), parameters, left)
    return LogIdentification(data, ROTARY, fit, None, (), dict.fromkeys(unidentified), 0.95, validation)


def test_torque_model_and_friction_have_the_values_but_of_a_dip():
    assert identified().torque_model()[:9] == (2.0, 3.0, 3.0, 0.5, 0.01, 0.1, 1.0, -0.5, 0.0)
    found = identified(Shape(path=0.01, stribeck_velocity=0.2), stiction_excess=1.0)
    assert found.torque_model()[2:6] == (4.0, 0.5, 0.0, 0.2)
    assert found.friction(np.array([-0.2, 0.0])) == pytest.approx([-3.6 - math.exp(-1.0), -0.5])
    assert found.given == ["friction_lag"]
    assert [found.value(name) for name in ("viscous_asymmetry", "force_sine_2", "viscous")] == [0.0, 0.0, 0.5]
    with pytest.raises(InputError, match=r"^the parameter 'foo' is not known; there are inertia, .* force_cosine_2$"):
        found.value("foo")
    dips = identified(Shape(stribeck_velocity=0.2), stiction_excess=-1.0)
    assert list(dips.joint_parameters) == list(HEAVY)
    assert Map((), 4).names == ("hat_2", "hat_3", "hat_4")
    assert Map((), 4, -1.0, 2.0).fraction("hat_4", np.array([0.5, 1.5, 2.0, 9.0])).tolist() == [0.0, 0.5, 1.0, 1.0]


def test_grade_is_that_of_what_is_left_and_not_known():
    good = [{"left": 0.15}, {"half": 0.249}, {"validation": 0.15}]
    care = [{"left": 0.151}, {"left": 0.5, "validation": 0.1}, {"half": 0.251}, {"unidentified": ["coulomb"]}]
    unusable = [{"left": 0.501}, {"validation": 0.501}, {"inertia": 0.0}, {"unidentified": ["inertia"]}]
    for grade, changes in ((GOOD, good), (CARE, care), (UNUSABLE, unusable)):
        assert {identified(**change).grade for change in changes} == {grade}


def test_simulators_have_the_joint_on_the_side_of_the_gear_and_name_what_they_lack():
    """A link of half the inertia, turned by ``q`` about y, takes ``- mass g x`` to hold."""
    text = identified().simulator("mjcf", gear_ratio=2.0)
    names = ("armature", "damping", "frictionloss", "mass", r"inertial pos")
    armature, damping, coulomb, mass, centre = (re.search(f'{name}="(.*?)"', text)[1].split() for name in names)
    assert [float(one) for (one,) in (armature, damping, coulomb)] == [4.0, 2.0, 6.0]
    centre, (mass,) = np.array(centre, float), map(float, mass)
    assert mass * np.sum(centre**2) == pytest.approx(4.0, rel=1e-4)
    assert -9.81 * mass * centre == pytest.approx([6.0, 0.0, 8.0], rel=1e-4)
    light = identified(offset=0.0, gravity_sine=0.0, gravity_cosine=0.0)
    assert not any("Not among" in light.simulator(kind) for kind in ENDINGS)
    lacking = {"stiction_excess": 1.0, "load_friction": 0.25, "viscous_asymmetry": 0.25}
    said = "stiction 8 with a Stribeck velocity of 0.1; load friction 0.25; viscous "
    sticky = identified(Shape(0.1, 0.25, 0.2), **lacking)
    for kind in ENDINGS:
        text = sticky.simulator(kind, gear_ratio=2.0)
        assert (
            f"{said}asymmetry 1; friction lag 0.1; path 0.125; offset -1 (a constant torque against the motor's)"
            in text
        )
        assert ("gravity 10 sin(q + 0.6435)" in text) == (kind in ("isaac", "drake"))
    for name, value in (("armature", 8), ("friction", 8), ("dynamic_friction", 6), ("viscous_friction", 2)):
        assert re.search(rf"\b{name}={value}\b", sticky.simulator("isaac", gear_ratio=2.0))
    dips = identified(Shape(stribeck_velocity=0.2), stiction_excess=-1.0, torque_delay=0.25, force_hat_2=0.5)
    assert "numbers: friction that is 2 less at low speed; torque delay 0.25; force hat 2 1" in (
        dips.simulator("mjcf", gear_ratio=2.0)
    )
    assert "viscous, which is not identified; offset" not in identified().simulator("urdf")
    assert "viscous, which is not identified; offset" in identified(unidentified=["viscous"]).simulator("urdf")
    with pytest.raises(InputError, match="the Coulomb friction is not identifiable, so there is no joint of a simul"):
        identified(unidentified=["coulomb"]).simulator("mjcf")
    with pytest.raises(InputError, match="simulator 'gazebo' is not known; allowed: mjcf, urdf"):
        sticky.simulator("gazebo")


def test_scenario_learns_and_simulates_what_there_is_beside_friction():
    gravity, waves = {"identify": "gravity"}, {"friction_sine_1": 0.9, "friction_cosine_1": 1.2, "friction_sine_2": 0.6}
    below = identified(load_friction=0.75, gravity_cosine=-1.0)
    assert _beside_friction(below) == (gravity, {"variation": {"load_share": 0.25}})
    assert left_out(identified(load_friction=0.75, force_hat_2=1.0)) == ["force_hat_2"]
    assert left_out(identified(Shape(), load_friction=0.75)) == ["load_friction"]
    for nothing in ({"coulomb": 0.0}, {"shape": Shape()}, {"gravity_sine": 0.0, "gravity_cosine": 0.0}):
        assert _beside_friction(identified(**{"load_friction": 0.6, **nothing}))[1] == {}
    learnt, simulated = _beside_friction(identified(Shape(), **waves, force_sine_1=0.3, force_cosine_2=0.6))
    assert learnt == {**gravity, "ripple_periods": [0.7, 0.3], "position_periods": [0.7, 0.3]}
    assert simulated["variation"] == pytest.approx({"position_amplitude": 0.5, "position_period": 0.7})
    assert simulated["actuator"] == pytest.approx({"ripple_amplitude": 0.6, "ripple_period": 0.3})
    steep = identified(Shape(), friction_sine_1=9.0, friction_cosine_2=-9.0).first_estimate()["position_map"]
    assert steep == (0.0, TUNING.most_variation, -TUNING.most_variation, 0.0)


def test_ends_of_a_motion_are_joined_no_steeper_than_it_is():
    time = 0.01 * np.arange(131)
    velocity = np.sin(2.0 * np.pi * time) + 0.5
    joined = joined_ends(time, velocity)
    assert joined["velocity"][:131].tolist() == velocity.tolist()
    assert joined["velocity"][-1] == pytest.approx(velocity[0])
    assert np.diff(joined["time"]) == pytest.approx(np.full(joined["time"].size - 1, 0.01))
    assert 0.9 < np.max(np.abs(np.diff(joined["velocity"])[130:])) / np.max(np.abs(np.diff(velocity))) <= 1.0
    assert joined_ends(time[:101], velocity[:101])["time"].size == 101


@pytest.mark.parametrize(
    ("values", "left", "refusal"),
    [
        ((-1.0, 1.0, 1.0, 0.0), 0.95, None),
        ((1.0, -1.0, -1.0, 0.0), 0.9, None),
        ((-1.0, -1.0, 3.0, 9.0), 0.9, None),  # explains little
        ((-1.0, 0.0, 3.0, 0.0), 0.9, None),
        ((-1.0, 1.0, -3.0, 0.0), 0.9, "friction would drive the joint"),
        ((-1.0, -1.0, 3.0, 0.0), 0.9, "friction would drive the joint"),
        ((1.0, 1.0, 1.0, 0.0), 0.96, "the motion explains 8 % of the torque"),
    ],
)
def test_friction_that_drives_against_the_inertia_is_refused_where_it_explains_the_torque(values, left, refusal):
    columns = np.linalg.qr(np.random.default_rng(1).standard_normal((40, 4)))[0]
    found, torque = SimpleNamespace(solve=lambda bounded: np.array(values[:3])), columns @ values
    data = SimpleNamespace(fit=lambda _: found, columns=lambda *_: columns[:, :3], velocity=np.ones(2), torque=torque)
    with pytest.raises(InputError, match=refusal) if refusal else nullcontext():
        _check_plausible(make_log(0.1), data, Model(("inertia", "coulomb", "viscous")), left)

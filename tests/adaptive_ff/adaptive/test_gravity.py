"""Gravity and further known regressors identified beside the friction."""

import math

import numpy as np
import pytest

from adaptive_ff import PER_DIRECTION_WITH_GRAVITY, WITH_GRAVITY, WITH_OFFSET
from tests.helpers import driven_joint
from tests.helpers.driven_joint import drive, known_position, reference_joint, rms

END = 40.0


def make(parameters=WITH_GRAVITY, **options):
    return driven_joint.make(parameters, **options)


def weight(time, position):
    return 100.0 * math.sin(position + 0.4)


def settled(run):
    return rms(run.error[run.time > 0.6 * END])


@pytest.fixture(scope="module")
def unloaded():
    return settled(drive(make(), reference_joint(), 0.0, END, position=known_position))


@pytest.mark.parametrize("parameters", [WITH_GRAVITY, PER_DIRECTION_WITH_GRAVITY], ids=["symmetric", "directions"])
def test_joint_with_weight_settles_as_without(unloaded, parameters):
    errors = []
    for seed in (101, 102, 103):  # one reversal turned wrongly costs a third in one draw of the noise of twenty
        controller = make(parameters)
        run = drive(controller, reference_joint(), 0.0, END, seed=seed, load=weight, position=known_position)
        errors.append(settled(run))
    assert np.median(errors) < 1.1 * unloaded
    assert max(errors) < 1.5 * unloaded
    assert controller.estimates["gravity_sin"] == pytest.approx(100.0 * math.cos(0.4), abs=10.0)
    held = controller.estimates["gravity_cos"] + controller.estimates["offset"]  # told apart where the joint turns far
    assert held == pytest.approx(100.0 * math.sin(0.4), abs=8.0)
    assert controller.estimates["coulomb"] == pytest.approx(60.0, abs=3.0)


def test_without_a_position_nothing_of_gravity_is_identified_or_fed():
    plain, blind = make(WITH_OFFSET), make()
    first = drive(plain, reference_joint(), 0.0, 5.0)
    second = drive(blind, reference_joint(), 0.0, 5.0)
    assert blind.estimates["gravity_sin"] == blind.estimates["gravity_cos"] == 0.0
    np.testing.assert_array_equal(first.torque, second.torque)


def test_position_of_the_motor_through_a_gear():
    ratio = -50.0
    controller, direct = make(gear_ratio=ratio), make()
    drive(direct, reference_joint(), 0.0, 10.0, load=weight, position=known_position)
    assert abs(direct.estimates["gravity_sin"]) > 20.0
    drive(controller, reference_joint(), 0.0, 20.0, load=lambda t, q: weight(t, q / ratio), position=lambda t, q: q)
    # over half a radian of the motor the joint hardly turns: only the sum at this angle is identifiable
    here = controller.estimates["gravity_cos"] + controller.estimates["offset"]
    assert here == pytest.approx(100.0 * math.sin(0.4), rel=0.05)
    with pytest.raises(ValueError, match=r"^gear_ratio = "):
        make(gear_ratio=0.0)


def test_further_regressors_carry_what_another_joint_hangs_on_this_one(unloaded):
    """Sines of a summed angle: the second joint of an arm moves on its own."""

    def other(time):
        return 0.8 * math.sin(0.9 * time)

    def load(time, position):
        return weight(time, position) + 40.0 * math.sin(position + other(time))

    def sines(time, position):
        return math.sin(position + other(time)), math.cos(position + other(time))

    informed, alone = make(regressors=2), make()
    run = drive(informed, reference_joint(), 0.0, END, load=load, position=known_position, regressors=sines)
    assert settled(run) < 1.2 * unloaded
    assert informed.estimates["regressor_1"] == pytest.approx(40.0, abs=3.0)
    assert informed.estimates["regressor_2"] == pytest.approx(0.0, abs=3.0)
    assert settled(drive(alone, reference_joint(), 0.0, END, load=load, position=known_position)) > 1.2 * settled(run)

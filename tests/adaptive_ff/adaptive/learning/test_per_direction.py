"""The regression with an offset and friction that differs by direction."""

import sys

import numpy as np
import pytest
from closed_loops import SCENARIO, drive, lay_course, own_loop, run_plain
from unequal_joint import EQUAL, LAG, Unequal, rms

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, WITH_OFFSET, directed_friction
from adaptive_ff.identify.batch import identify_torque_form
from controllers import PI

LOADED = EQUAL._replace(load=25.0)
UNEQUAL = Unequal()
GAINS, PERIOD = SCENARIO.feedback.gains, SCENARIO.sampling.period
SHORT = SCENARIO.modified(duration=6.0)


def make(parameters=PER_DIRECTION):
    return UnsupervisedController(*GAINS, PERIOD, inertia=20.0, stribeck_velocity=0.05, parameters=parameters)


@pytest.fixture(scope="module")
def course():
    return lay_course(SCENARIO.modified(seed=103, duration=40.0))


def error(controller, course, joint):
    """Error over the last 15 s, mrad/s."""
    record, _ = drive(controller, course._replace(joint=joint.plant.parameters))
    return rms(record.velocity - course.reference, 15.0)


@pytest.mark.parametrize(
    ("joint", "parameters"),
    [(EQUAL, WITH_OFFSET), (EQUAL, PER_DIRECTION), (LOADED, WITH_OFFSET), (UNEQUAL, PER_DIRECTION)],
)
def test_it_tracks_about_as_well_as_the_true_parameters(course, joint, parameters):
    adaptive = make(parameters)
    oracle = error(ModelBased(*GAINS, PERIOD, joint.model), course, joint)
    assert error(adaptive, course, joint) < 1.2 * oracle
    assert error(PI(*GAINS, PERIOD), course, joint) > 4.0 * oracle
    assert tuple(adaptive.estimates) == parameters
    found = joint.model._replace(offset=0.0, stiction_asymmetry=0.0, viscous_asymmetry=0.0)
    found = found._replace(**adaptive.estimates)
    for speed in (0.02, 0.1, 0.3):
        for direction in (1.0, -1.0):
            torques = [directed_friction(model, speed, direction) + model.offset for model in (found, joint.model)]
            assert torques[0] == pytest.approx(torques[1], abs=4.0)


@pytest.mark.parametrize(("joint", "parameters"), [(LOADED, ESTIMATED), (UNEQUAL, ESTIMATED)])
def test_without_the_parameters_that_the_joint_has_it_tracks_worse(course, joint, parameters):
    """The counterpart of the last test."""
    oracle = error(ModelBased(*GAINS, PERIOD, joint.model), course, joint)
    assert error(make(parameters), course, joint) > 1.2 * oracle


@pytest.mark.parametrize("parameters", [WITH_OFFSET, PER_DIRECTION])
def test_on_a_joint_that_is_the_same_in_both_directions_the_start_is_as_good(parameters):
    errors = {ESTIMATED: [], parameters: []}
    for seed in range(101, 107):
        course = lay_course(SCENARIO.modified(seed=seed, duration=10.0))
        for names, found in errors.items():
            record, _ = drive(make(names), course)
            found.append(np.sqrt(np.mean((record.velocity - course.reference) ** 2)))
    assert np.mean(errors[parameters]) < 1.05 * np.mean(errors[ESTIMATED])


def test_with_five_parameters_it_is_the_unsupervised_controller_of_the_line_up():
    course = lay_course(SHORT)
    found, _ = drive(make(ESTIMATED), course)
    expected, _ = drive(make_controller(SHORT, "adaptive_unsupervised"), course)
    assert np.array_equal(found.torque, expected.torque)


@pytest.mark.parametrize("parameters", [WITH_OFFSET, PER_DIRECTION])
def test_plain_python_equals_compiled_and_ones_own_loop_the_run(parameters):
    course, plain, fast, stepped = lay_course(SHORT), *(make(parameters) for _ in range(3))
    expected, _ = drive(plain, course, run=run_plain)
    found, _ = drive(fast, course)
    for series in ("torque", "velocity", "estimates"):
        wanted = getattr(expected, series)
        assert np.max(np.abs(getattr(found, series) - wanted)) <= 1e-12 * np.max(np.abs(wanted))
    assert own_loop(stepped, course) == pytest.approx(found.torque, rel=1e-12)
    assert np.all(found.estimates[-1, 5:] != 0.0)


def test_state_is_saved_and_restored_with_all_parameters():
    course, first, second = lay_course(SHORT), make(), make()
    drive(first, course)
    second.state_from_json(first.state_to_json())
    assert second.estimates == first.estimates
    assert second.step(0.1, 0.09) == first.step(0.1, 0.09)
    with pytest.raises(ValueError, match=r"^estimates = "):
        make(WITH_OFFSET).state_from_json(first.state_to_json())


def arrays_in(state):
    """Return all arrays of a nested state."""
    if isinstance(state, np.ndarray):
        return [state]
    return [array for item in state for array in arrays_in(item)] if isinstance(state, tuple) else []


def test_steps_neither_leak_nor_lose_the_arrays_of_the_state():
    controller = make()
    controller.step(0.1, 0.1)
    arrays = arrays_in(controller.state)
    before = [sys.getrefcount(array) for array in arrays]
    for _ in range(1000):
        controller.step(0.1, 0.1)
    assert all(new is old for new, old in zip(arrays_in(controller.state), arrays, strict=True))
    assert [sys.getrefcount(array) for array in arrays] == before


WRONG = [(), ("inertia",), (*ESTIMATED, "viscous_asymmetry"), PER_DIRECTION[::-1], (*PER_DIRECTION, "load")]


@pytest.mark.parametrize("parameters", WRONG)
def test_other_choices_of_parameters_are_refused_with_those_there_are(parameters):
    with pytest.raises(ValueError, match=r"^parameters = \(.*\) is not allowed: it must be \('inertia', 'coulomb'"):
        make(parameters)


@pytest.fixture(scope="module")
def unequal_log():
    """Time, velocity and torque over the period that ends, of a PI loop without noise at 1 kHz."""
    scenario = SCENARIO.modified(duration=30.0, sampling={"period": 0.001}, sensor={"velocity_noise": 0.0})
    course = lay_course(scenario)._replace(joint=UNEQUAL.plant.parameters)
    record, _ = drive(PI(*GAINS, 0.001), course)
    return 0.001 * np.arange(record.velocity.size), record.velocity, np.append(0.0, record.torque)


def identify(log, parameters):
    gate = {"filter_pole": 60.0, "slowest": 0.02, "hold": 0.1}
    return identify_torque_form(*log, stribeck_velocity=0.05, **gate, parameters=parameters)


def test_batch_finds_the_joint_of_each_direction(unequal_log):
    found, true = identify(unequal_log, PER_DIRECTION), Unequal().model
    assert tuple(found.physical) == PER_DIRECTION
    assert found.regression.names == ("inertia_lag", *PER_DIRECTION)
    for name in PER_DIRECTION:
        assert found.physical[name].value == pytest.approx(getattr(true, name), rel=0.03, abs=0.1)
        assert found.physical[name].value == getattr(found.model, name)


def test_batch_of_fewer_parameters_finds_another_joint_and_fits_worse(unequal_log):
    full, five = identify(unequal_log, PER_DIRECTION), identify(unequal_log, ESTIMATED)
    assert not any(five.model[7:])
    assert five.regression.residual_rms > 5.0 * full.regression.residual_rms
    assert abs(five.physical["friction_lag"].value / LAG - 1.0) > 0.05


def test_batch_refuses_other_choices(unequal_log):
    with pytest.raises(ValueError, match=r"^parameters = \('inertia',\) is not allowed"):
        identify(unequal_log, ("inertia",))

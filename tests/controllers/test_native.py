"""Controllers as they are declared, and as they lie in memory for machine code."""

import copy
import inspect
import math
import pickle

import numpy as np
import pytest
from closed_loops import make, run_compiled, setup_along
from hypothesis import given, settings
from hypothesis import strategies as st

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.simulation.experiment import empty_record
from adaptive_ff.simulation.loop import run_in_memory, run_plain, start_position
from controllers import PI, DisturbanceObserver, ExtendedState, SuperTwisting
from controllers.declaration import initial_state
from controllers.native import declined, step_native
from controllers.registry import RULES, Inputs


def pi():
    return PI(2000.0, 5000.0, period=0.01)


def steps(controller, count=20):
    return [controller.step(0.1 * np.sin(0.3 * k), 0.02 * k % 0.1, next_reference=0.1) for k in range(count)]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_a_copy_goes_on_from_where_the_original_stood_and_both_stand_alone(copied):
    original = make("extended_state")
    assert isinstance(original, ExtendedState)
    steps(original)
    twin = copied(original)
    kept = original.state_to_json()
    found = steps(twin)
    assert original.state_to_json() == kept
    assert steps(original) == found


def test_a_copy_of_a_controller_in_plain_python_stays_plain():
    twin = copy.deepcopy(pi().run_uncompiled())
    steps(twin)
    assert twin._native is None


def test_a_state_that_is_set_is_the_one_that_goes_on():
    controller = pi()
    begin = controller.state
    first = steps(controller)
    controller.state = begin
    assert steps(controller) == first


def test_numbers_that_are_no_floats_are_those_floats_compiled_or_not():
    given = {"next_reference": np.float32(0.3), "realised_torque": np.float32(0.7)}
    compiled, plain = pi().step(np.float32(0.1), 0, **given), pi().run_uncompiled().step(np.float32(0.1), 0, **given)
    assert (type(plain), plain) == (float, compiled)
    assert pi().step(1.0, 0.0) == pi().step(np.float32(1.0), 0) == pytest.approx(2050.0)


def test_regressors_are_not_taken_beside_what_is_no_number():
    controller = AdaptiveController(2000.0, 5000.0, period=0.01, inertia=20.0, stribeck_velocity=0.05, regressors=2)
    for velocity in (1j, np.zeros(2)):
        with pytest.raises(TypeError, match=r"velocity = .* is not allowed"):
            controller.step(0.1, velocity, regressors=[1.0, 1.0])
    np.testing.assert_array_equal(controller.regressors, 0.0)


def test_regressors_are_seen_by_the_next_step():
    controller = AdaptiveController(2000.0, 5000.0, period=0.01, inertia=20.0, stribeck_velocity=0.05, regressors=2)
    assert controller.regressors is controller.state.regressors


def test_the_loop_is_compiled_once_for_controllers_of_all_classes():
    setup = setup_along(0.1 * np.sin(0.02 * np.arange(200)))
    versions = []
    for controller in (pi(), make("extended_state"), make("fixed")):
        record = empty_record(setup, len(controller.estimate_names))
        run_in_memory(controller.native, 0, setup, start_position(setup), setup.noise.size, record)
        versions.append(len(run_in_memory._known))
    assert versions == [versions[0]] * 3


def test_every_input_reaches_a_controller_in_memory():
    step_native(native := pi().native, 0, Inputs(*range(1, 12)))
    assert native.exchange[:11].tolist() == list(range(1, 12))


def test_compiled_runs_write_estimates_and_monitors_as_plain_ones_do():
    setup, found = setup_along(0.1 * np.sin(0.02 * np.arange(200))), []
    for run in (run_compiled, run_plain):
        controller = make("adaptive")
        record = empty_record(setup, len(controller.estimate_names), len(controller.monitor_names))
        run(controller.parameters, controller.state, setup, start_position(setup), setup.noise.size, record)
        found.append(record)
    compiled, plain = found
    np.testing.assert_array_equal(compiled.estimates, plain.estimates)
    np.testing.assert_array_equal(compiled.monitors, plain.monitors)
    assert np.any(compiled.monitors[:, 0] > 0.0)  # probability of a change


ODD = st.sampled_from(
    [None, 0.3, -1, True, 0.0, np.float32(0.7), np.float64(0.02), math.nan, -math.inf, 10**400, "1", [1]]
)


@settings(max_examples=150, deadline=None)
@given(st.dictionaries(st.sampled_from(list(RULES)), ODD))
def test_one_call_of_the_extension_takes_and_refuses_what_the_checks_do(given):
    given = {"reference": 0.1, "velocity": 0.0, **given}
    found = []
    for controller in (pi(), pi()):
        controller.step(0.1, 0.0)
        if found:
            controller._fast = declined
        try:
            found.append(controller.step(**given))
        except (TypeError, ValueError) as error:
            found.append(repr(error))
    assert found[0] == found[1]


GIVEN = {"proportional": 100.0, "integral": 50.0, "period": 0.01, "inertia": 2.0, "bound": 3.0}


def test_signature_has_what_is_common_first_and_by_place_then_its_own():
    shown = str(inspect.signature(SuperTwisting)).partition(" ->")[0]
    common = "proportional: float, integral: float, period: float"
    assert shown == f"({common}, *, inertia: float, bound: float, delay: float = 0.0)"
    assert list(inspect.signature(ExtendedState).parameters)[:2] == ["proportional", "period"]


def test_class_that_derives_of_one_has_a_signature_of_its_own():
    class Mine(SuperTwisting):
        def __init__(self, scenario):
            super().__init__(**GIVEN)

    assert list(inspect.signature(Mine).parameters) == ["scenario"]
    assert Mine(None).step(0.1, 0.0) == SuperTwisting(**GIVEN).step(0.1, 0.0)


def test_kernel_is_given_arguments_and_what_is_derived_but_not_what_the_loop_inside_has():
    made = DisturbanceObserver(100.0, 50.0, 0.01, inertia=2.0, bandwidth=5.0)
    assert made.parameters._fields == ("feedback", "inertia", "pole", "period")
    assert made.pole == made.parameters.pole == 2.0 * math.pi * made.bandwidth
    with pytest.raises(AttributeError):
        made.inertia = 3.0  # which the kernel would not know of


def test_state_at_the_start_is_made_anew_for_every_controller():
    made = SuperTwisting(**GIVEN, delay=2.0)
    assert initial_state(made.parameters) == made.state
    assert len(made.state.feedback.commands) == 3


def test_controller_that_runs_goes_on_in_another_process_as_here():
    made = SuperTwisting(**GIVEN)
    made.step(0.1, 0.02)
    assert pickle.loads(pickle.dumps(made)).step(0.2, 0.1) == made.step(0.2, 0.1)


def test_missing_argument_is_named():
    with pytest.raises(TypeError, match="'inertia'"):
        SuperTwisting(100.0, 50.0, 0.01, bound=3.0)

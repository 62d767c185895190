"""The decorator that makes a controller of arguments, state and step."""

import inspect
import math
import pickle

import pytest

from controllers import DisturbanceObserver, ExtendedState, SuperTwisting
from controllers.declaration import initial_state

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

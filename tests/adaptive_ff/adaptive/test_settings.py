"""The record of what an adaptive controller is made with, and the constructors that fill it in."""

import inspect

import pytest

from adaptive_ff.adaptive.controller import AdaptiveController, UnsupervisedController
from adaptive_ff.adaptive.settings import Settings, adaptive_parameters, settings_among
from adaptive_ff.friction.model import ESTIMATED

OBSERVER_AND_FIRST_MAP = {"observer_bandwidth", "position_map", "map_deviation"}
"""What the supervised controller takes beside the settings."""

NEEDED = {"proportional": 1000.0, "integral": 4000.0, "period": 0.01, "inertia": 20.0, "stribeck_velocity": 0.05}


def arguments_of(controller):
    return inspect.signature(controller).parameters


def test_every_setting_is_an_argument_and_every_argument_a_setting():
    assert set(arguments_of(AdaptiveController)) == {*Settings._fields, *OBSERVER_AND_FIRST_MAP}
    assert set(arguments_of(UnsupervisedController)) == set(Settings._fields) - set(Settings._field_defaults)


@pytest.mark.parametrize("controller", [AdaptiveController, UnsupervisedController])
def test_a_constructor_hands_on_what_it_is_given(controller):
    defaults = {
        name: argument.default
        for name, argument in arguments_of(controller).items()
        if argument.default is not inspect.Parameter.empty
    }
    names, block = adaptive_parameters(settings_among({**defaults, **NEEDED, "memory": 7.0, "velocity_lag": 0.003}))
    made = controller(**NEEDED, memory=7.0, velocity_lag=0.003)
    assert made.estimate_names[: len(names)] == names
    assert (made.parameters.estimator.memory, made.parameters.velocity_lag) == (7.0, 0.003)
    assert made.parameters.feedback == block.feedback
    assert made.parameters.command == block.command
    assert made.parameters.estimator.candidates.tolist() == block.estimator.candidates.tolist()


def test_parameters_may_be_named_by_what_can_be_gone_through_once():
    assert UnsupervisedController(**NEEDED, parameters=iter(ESTIMATED)).estimate_names == ESTIMATED


@pytest.mark.parametrize("lag", [-0.001, 20.0, float("inf"), float("nan")])
def test_a_velocity_lag_in_milliseconds_is_refused(lag):
    with pytest.raises(
        ValueError, match=r"velocity_lag = .* s is not allowed: it must be from 0 to 10 s, 1000 sampling"
    ):
        UnsupervisedController(**NEEDED, velocity_lag=lag)

"""Saved states that were tampered with, or are of another joint: refused, or harmless."""

import json
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, make, own_loop
from nightly import sampled
from poisoned_runs import is_finite
from test_checklist_saved_state import altered, leaves

from adaptive_ff import AdaptiveController
from controllers import PI, pi_gains

NAMES = ["pi", "adaptive", "adaptive_unsupervised", "adaptive_paper", "canudas", "disturbance_observer", "repetitive"]
SHORT = SCENARIO.modified(duration=6.0)
AFTER = SCENARIO.modified(duration=1.0)  # what a controller whose state was accepted is driven through
LOST = (math.nan, math.inf)


def tampered(text):
    """The changes of a text that make each number in turn negated, far too large, tiny, zero and none."""
    for path in leaves(json.loads(text)["state"]):
        changes = [lambda x: -x, lambda x: x * 1e6, lambda x: x + 1e9]
        for change in changes + [lambda x, value=value: value for value in (1e300, -1e15, 1e15, 5e-324, 0, *LOST)]:

            def put(place, key, change=change):
                if not isinstance(place[key], bool):
                    value = change(place[key])
                    place[key] = type(place[key])(value) if math.isfinite(value) else value

            yield path, put


@pytest.mark.parametrize("name", sampled(NAMES, ("pi", "adaptive")))
def test_what_is_accepted_of_tampered_states_stays_finite(name):
    controller, setup = make(name), build_setup(AFTER)
    drive(controller, build_setup(SHORT))
    text = controller.state_to_json()
    refused, accepted = 0, 0
    changes = list(tampered(text))
    for path, put in changes[:: max(1, len(changes) // 150)]:
        other, wrong = make(name), altered(text, path, put)
        try:
            other.state_from_json(wrong)
        except ValueError:
            refused += 1
            continue
        record, _ = drive(other, setup)
        assert np.all(np.isfinite(record.torque)), wrong
        assert is_finite(other.state)
        accepted += 1
    assert refused > 0
    assert refused + accepted > 30


def adaptive(inertia, period=0.01, **others):
    others = {"inertia": inertia, "stribeck_velocity": 0.05, **others}
    return AdaptiveController(*pi_gains(others["inertia"], 10.0), period=period, **others)


@pytest.mark.parametrize(
    ("other", "named"),
    [
        (adaptive(0.001), "proportional"),
        (adaptive(20.0, period=0.001), "period"),
        (adaptive(20.0, delay=1.0), "delay"),
        (AdaptiveController(*pi_gains(20.0, 10.0), period=0.01, inertia=10.0, stribeck_velocity=0.05), "inertia"),
        (adaptive(20.0, parameters=("inertia", "coulomb", "stiction", "viscous", "friction_lag")), "estimates"),
    ],
    ids=["joint", "period", "delay", "inertia", "names"],
)
def test_a_state_of_another_joint_is_refused_by_name(other, named):
    saved = adaptive(20.0).state_to_json()
    before = other.state_to_json()
    with pytest.raises(ValueError, match=named):
        other.state_from_json(saved)
    assert other.state_to_json() == before


@pytest.mark.parametrize(
    "change",
    [
        lambda m: (-np.array(m)).tolist(),
        lambda m: [value + 1e6 * (place == 8) for place, value in enumerate(m)],  # beside the diagonal
    ],
    ids=["negative", "indefinite"],
)
def test_a_covariance_that_is_none_is_refused(change):
    controller = make("adaptive")
    saved = json.loads(controller.state_to_json())
    estimate = saved["state"]["estimate"]
    estimate["covariance"] = change(estimate["covariance"])
    with pytest.raises(ValueError, match=r"covariance is not allowed: it must be symmetric and positive semi-definite"):
        controller.state_from_json(json.dumps(saved))


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"controller": "PI", "state": ' + "[" * 100_000], ids=["list", "state"]
)
def test_nested_text_is_refused(text):
    with pytest.raises(ValueError, match="no saved controller state"):
        PI(1.0, 1.0, 0.01).state_from_json(text)


def test_a_state_without_version_is_refused():
    controller = PI(1.0, 1.0, 0.01)
    saved = json.loads(controller.state_to_json())
    del saved["version"]
    with pytest.raises(ValueError, match="version"):
        controller.state_from_json(json.dumps(saved))


def test_a_spoilt_covariance_leaves_the_torque_finite_and_the_joint_known():
    controller = make("adaptive")
    drive(controller, build_setup(SCENARIO))
    controller.state.estimate.covariance[9] = -1.0  # of the fourth number
    before = controller.estimates
    torques = own_loop(controller, build_setup(SCENARIO.modified(duration=20.0)))
    assert np.all(np.isfinite(torques))
    assert is_finite(controller.state)
    assert controller.estimates["coulomb"] == pytest.approx(before["coulomb"], rel=0.1)
    assert math.isfinite(controller.estimates["inertia"])

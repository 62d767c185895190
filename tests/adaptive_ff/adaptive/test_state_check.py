"""Restored states that no controller has come to: the message names the field, its value and what is allowed."""

import json

import pytest
from closed_loops import SCENARIO, make
from exports import adaptive

from adaptive_ff.adaptive.state_check import SIZES
from adaptive_ff.learning.kalman import LOOP


def put(tree, path, value):
    for part in path[:-1]:
        tree = tree[part]
    tree[path[-1]] = value


@pytest.fixture(scope="module")
def worked():
    controller = make("adaptive", SCENARIO)
    for k in range(20):
        controller.step(0.01 * k, 0.009 * k)
    return controller.state_to_json()


MEAN = ("estimate", "mean")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("weight",), 1.5, r"\.weight = 1.5 is not allowed: it must be from 0 to 1"),
        (("observer", "gain"), 2.0, r"\.observer.gain = 2.0 is not allowed: it must be from 0 to 1"),
        (("observer", "error"), -1e-9, ": error = -1e-09 is not allowed: it must be zero or more"),
        *(((name,), -1e19, rf"\.{name} = .* N m is not allowed: at most") for name in SIZES),
        (("observer", "torque"), -1e19, r"\.observer.torque = .* N m is not allowed: at most"),
        (("unit",), 0.0, r"\.unit = 0.0 N m is not allowed: it must be above 0"),
        (("filtered",), 1e6, r"\.filtered = 1000000.0 is not allowed: at most 100000 rad/s"),
        (("interval", "lost"), 3, r"\.interval is not allowed: samples = "),
        (("interval", "samples"), 4, r"\.interval is not allowed: samples = 4 must be from 0 to "),
        (("psi", 1), -1e19, ": psi is not allowed: its numbers must be at most"),
        (("friction", "lagged", 1), -2e9, r"\.friction is not allowed: what follows a lag or a path"),
        (("friction", "direction"), -1.1, r"\.friction is not allowed"),
        (("friction", "held"), -1.1, r"\.friction is not allowed"),
        ((*MEAN, LOOP), 200.1, r"\.estimate.mean\[2\] = 200.1 is not allowed: it must be from 2 to 200"),
    ],
)
def test_a_state_that_cannot_be_is_refused_with_its_field(path, value, message, worked):
    saved = json.loads(worked)
    put(saved["state"], path, value)
    with pytest.raises(ValueError, match=f"^state{message}"):
        make("adaptive", SCENARIO).state_from_json(json.dumps(saved))


def test_a_state_of_an_older_version_is_refused_and_the_version_named(worked):
    saved = json.loads(worked) | {"version": 2}
    with pytest.raises(ValueError, match=r"^version of the state = 2 is not allowed: it must be 8$"):
        make("adaptive", SCENARIO).state_from_json(json.dumps(saved))


def test_a_new_state_is_restored_by_a_controller_with_every_column():
    columns = {"regressors": 2, "ripple_periods": [0.3], "position_periods": [1.0], "position_hats": 5}
    new, restored = (adaptive(**columns, load_friction=True) for _ in range(2))
    text = new.state_to_json()
    restored.state_from_json(text)
    assert restored.state_to_json() == text

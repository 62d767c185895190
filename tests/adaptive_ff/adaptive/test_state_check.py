"""Restored states that no controller has come to: the message names the field, its value and what is allowed."""

import json

import pytest
from closed_loops import SCENARIO, build_setup, drive, make
from exports import adaptive


def put(tree, path, value):
    for part in path[:-1]:
        tree = tree[part]
    tree[path[-1]] = value


@pytest.fixture(scope="module")
def worked():
    controller = make("adaptive", SCENARIO)
    drive(controller, build_setup(SCENARIO.modified(duration=5.0)))
    return controller.state_to_json()


@pytest.mark.parametrize(
    ("path", "value", "allowed"),
    [
        (("weight",), 1.5, "from 0 to 1"),
        (("fed_gain",), -0.1, "from 0 to 1"),
        (("observer", "gain"), 2.0, "from 0 to 1"),
        (("steady",), 1e19, "N m is not allowed: at most"),
        (("unit",), 0.0, "above 0"),
        (("filtered",), 1e6, "at most 100000 rad/s"),
    ],
)
def test_a_state_that_cannot_be_is_refused_with_its_field(path, value, allowed, worked):
    saved = json.loads(worked)
    put(saved["state"], path, value)
    with pytest.raises(ValueError, match=rf"^state\.{'.'.join(path)} = .*{allowed}"):
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

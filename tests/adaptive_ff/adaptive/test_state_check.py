"""Restored states: of another version, and of a controller with every column; the figures hold what is refused."""

import json

import pytest
from closed_loops import SCENARIO, make
from exports import adaptive


@pytest.fixture(scope="module")
def worked():
    controller = make("adaptive", SCENARIO)
    for k in range(20):
        controller.step(0.01 * k, 0.009 * k)
    return controller.state_to_json()


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

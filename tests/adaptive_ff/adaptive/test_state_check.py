"""Restored states that no controller has come to: the message names the field, its value and what is allowed."""

import json

import pytest
from closed_loops import SCENARIO, make


def put(tree, path, value):
    *parts, last = path.split(".")
    for part in parts:
        tree = tree[part]
    tree[last] = value


@pytest.mark.parametrize(
    ("path", "value", "allowed"),
    [
        ("doubt.left", -1.0, "zero or more"),
        ("seen.gap", -0.5, "zero or more"),
        ("trust.trust", 1.5, "from 0 to 1"),
        ("trust.xx", -1.0, "zero or more"),
        ("trust.peak", 1e6, "from 0 to 100000 rad/s"),
        ("observer.stuck", -1.0, "zero or more"),
        ("observer.noise.variance", -1.0, "zero or more"),
        ("observer.colour.time", -1.0, "zero or more"),
        ("observer.effect.used_expected", -1.0, "zero or more"),
        ("observer.effect.acquittal.time", -1.0, "zero or more"),
        ("estimator.levels.learnt", -1.0, "zero or more"),
        ("estimator.candidates.waited", -1.0, "zero or more"),
    ],
)
def test_a_state_that_cannot_be_is_refused_with_its_field(path, value, allowed):
    controller = make("adaptive", SCENARIO)
    saved = json.loads(controller.state_to_json())
    put(saved["state"], path, value)
    with pytest.raises(ValueError, match=f"^state.{path} = {value:.1f} is not allowed: it must be {allowed}"):
        controller.state_from_json(json.dumps(saved))

"""Saved states, checked over all controllers."""

import json
import math

import numpy as np
import pytest
from closed_loops import LINE_UP, SCENARIO, build_setup, drive, make, own_loop

from controllers import PI

SHORT = SCENARIO.modified(duration=6.0)
LIMIT = SCENARIO.actuator.torque_limit

controllers = pytest.mark.parametrize("name", LINE_UP)


@controllers
def test_state_saved_in_mid_run_goes_on_bit_for_bit_in_a_new_controller(name):
    setup, first, second = build_setup(SHORT), make(name), make(name)
    middle = 301
    saved = {}

    def save(k):
        if k == middle:
            saved["text"] = first.state_to_json()

    torques = own_loop(first, setup, watch=save)
    inputs = []

    class Spy:
        def step(self, reference, velocity, **others):
            inputs.append((reference, velocity, others))
            return first.step(reference, velocity, **others)

    first.reset()
    assert np.array_equal(own_loop(Spy(), setup), torques)
    second.state_from_json(saved["text"])
    assert second.state_to_json() == saved["text"]
    found = [second.step(reference, velocity, **others) for reference, velocity, others in inputs[middle:]]
    assert np.array_equal(np.clip(found, -LIMIT, LIMIT), torques[middle:])
    assert second.state_to_json() == first.state_to_json()


def leaves(content, path=()):
    """Paths to the numbers of a saved state."""
    if isinstance(content, dict):
        return [leaf for key, item in content.items() for leaf in leaves(item, (*path, key))]
    if isinstance(content, list):
        return [leaf for index, item in enumerate(content) for leaf in leaves(item, (*path, index))]
    return [path]


def altered(text, path, change):
    """Return a saved state with ``change(container, key)`` applied at a path."""
    saved = json.loads(text)
    place = saved["state"]
    for key in path[:-1]:
        place = place[key]
    change(place, path[-1])
    return json.dumps(saved)


def wrong_texts(text):
    """Texts that are almost a saved state: each number in turn is missing, a word, null, a list, not finite.

    Of the numbers of an array after its first, which are read alike, each is wrong in one of these ways.
    """
    yield from ("", "[]", "3", '{"state": {}}', text[:-2], text.replace('"controller": "', '"controller": "X', 1))
    yield json.dumps({"controller": json.loads(text)["controller"], "state": None})
    ways = [lambda place, key: place.pop(key)]
    for value in ("much", None, [1.0, 2.0], math.nan, math.inf):
        ways.append(lambda place, key, value=value: place.__setitem__(key, value))
    for count, path in enumerate(leaves(json.loads(text)["state"])):
        inside = any(isinstance(step, int) and step > 0 for step in path)
        for change in [ways[count % len(ways)]] if inside else ways:
            yield altered(text, path, change)
        if isinstance(path[-1], str):
            yield altered(text, path, lambda place, key: place.__setitem__(key + "x", place[key]))


MOST_TEXTS = 300
"""Texts that are tried of a state, evenly drawn from all of them."""


@controllers
def test_wrong_texts_are_refused_and_leave_the_state(name):
    controller = make(name)
    drive(controller, build_setup(SHORT))
    text, count = controller.state_to_json(), 0
    texts = list(wrong_texts(text))
    for wrong in texts[:: max(1, len(texts) // MOST_TEXTS)]:
        with pytest.raises(ValueError, match=r"text|controller|state"):
            controller.state_from_json(wrong)
        count += 1
    assert count > 30
    assert controller.state_to_json() == text


def test_state_of_another_controller_is_refused():
    controller = PI(1.0, 1.0, 0.01)
    with pytest.raises(ValueError, match="AdaptiveController"):
        controller.state_from_json(make("adaptive").state_to_json())

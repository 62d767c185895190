"""Saved states: of all controllers; those that were tampered with, or are of another joint, are refused or harmless."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from closed_loops import LINE_UP, SCENARIO, build_setup, drive, is_finite, make, own_loop, sampled

from controllers import PI

SHORT = SCENARIO.modified(duration=6.0)
LIMIT = SCENARIO.actuator.torque_limit
LOST = (math.nan, math.inf)
AFTER = SCENARIO.modified(duration=1.0)  # what a controller whose state was accepted is driven through
NAMES = ["pi", "adaptive", "adaptive_unsupervised", "adaptive_paper", "canudas", "disturbance_observer", "repetitive"]
"""Controllers whose states are tampered with."""

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

    def noted_step(reference, velocity, **others):
        inputs.append((reference, velocity, others))
        return first.step(reference, velocity, **others)

    first.reset()
    assert np.array_equal(own_loop(SimpleNamespace(step=noted_step), setup), torques)
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


@pytest.mark.parametrize(("other", "said"), [({}, ""), ({"spare": 1}, ", not spare")])
def test_what_a_state_belongs_to_is_named_where_some_of_it_is_missing(other, said):
    saved = json.loads((controller := make("pi")).state_to_json())
    names = list(saved["belongs_to"])
    saved["belongs_to"] = dict.fromkeys(names[1:], 1.0) | other
    with pytest.raises(ValueError, match=f"^state: belongs_to must have the fields {', '.join(names)}{said}$"):
        controller.state_from_json(json.dumps(saved))


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


SAVED = PI(1.0, 1.0, 0.01).state_to_json()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SAVED.replace('"PI"', '"AdaptiveController"'), "controller = 'AdaptiveController' is not allowed"),
        (SAVED.replace('"version"', '"virsion"'), "version of the state = None is not allowed"),
        ("[" * 100_000, "no saved controller state"),
        ('{"controller": "PI", "state": ' + "[" * 100_000, "no saved controller state"),
    ],
    ids=["controller", "version", "list", "nested state"],
)
def test_what_is_no_state_of_this_controller_is_refused(text, said):
    with pytest.raises(ValueError, match=said):
        PI(1.0, 1.0, 0.01).state_from_json(text)


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
    refused, accepted, other = 0, 0, make(name)
    changes = list(tampered(text))
    for path, put in changes[:: max(1, len(changes) // 150)]:
        wrong = altered(text, path, put)
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


def test_a_state_of_another_joint_is_refused_by_name():
    other = make("adaptive", SCENARIO.modified(feedback={"inertia": 10.0}))
    before = other.state_to_json()
    with pytest.raises(ValueError, match="proportional"):
        other.state_from_json(make("adaptive").state_to_json())
    assert other.state_to_json() == before


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

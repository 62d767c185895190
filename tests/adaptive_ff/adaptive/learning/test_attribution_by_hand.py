"""What a change is attributed to, beside a list of rules of which the first that holds counts.

Times are multiples of a power of two, and values are drawn from those at which a rule begins to hold: limits are met
exactly.
"""

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff.adaptive.learning.change_detection import (
    EITHER,
    FRICTION,
    LETTING_GO,
    LOAD,
    NO_ALARM,
    NOTHING,
    RENEWED,
    SETTLING,
    TURNED,
    TURNED_FOR,
    UNDECIDED,
    UNDONE,
    Alarm,
    Surprise,
    attribute_change,
    explained_by_friction,
    load_is_undone,
    note_surprise,
)
from adaptive_ff.adaptive.learning.forgetting import error_to_learn, explain_in_place, follow_friction_in_place

WINDOW, LONGEST, DURATION = 0.5, 4.0, 0.25
SIZES = (0.0, 1.0, -1.0)
ERRORS = (*SIZES, LETTING_GO, -LETTING_GO, 2.0, -2.0, UNDONE - 1.0, 1.0 - UNDONE, -0.9)
PRODUCTS = (*SIZES, RENEWED, -RENEWED, 0.5, -2.0)
FRICTIONS = (*SIZES, TURNED, -TURNED, 0.25, -0.25, 2.0, -2.0)


def by_rules(alarm, noticed, surprise, friction):
    """The rules in words: what the alarm becomes where one holds that none before it does."""
    cause, product, first, age, turned, load, undone = alarm
    last = (load, undone)
    error, later = surprise.error, age + DURATION
    begun = Alarm(UNDECIDED, surprise.product, friction, 0.0, 0.0, *last)
    ends = not undone and age > TURNED_FOR * WINDOW and abs(error + load) < UNDONE * abs(load)
    other_way = math.copysign(1.0, friction) != math.copysign(1.0, first) and friction != 0.0 != first
    fast = abs(friction) > TURNED * abs(first)
    waits = cause == EITHER and turned == 0.0 and not other_way
    turned += DURATION if (cause == EITHER and not waits) or (cause == UNDECIDED and fast and other_way) else 0.0
    if cause == UNDECIDED and fast and not other_way:
        turned = 0.0
        product = surprise.product if abs(surprise.product) > RENEWED * abs(product) else product
    long_enough = cause == UNDECIDED and turned > TURNED_FOR * WINDOW
    left = math.exp(-turned / WINDOW)
    since = (surprise.product - left * product) / (1.0 - left) if turned > 0.0 else product
    rules = (
        (cause == NOTHING, begun if noticed else alarm),
        (ends and (noticed or cause == UNDECIDED), Alarm(LOAD, alarm.product, first, 0.0, 0.0, -load, True)),
        (cause == LOAD and noticed and not undone and load * error < -LETTING_GO * load**2, begun),
        (waits, Alarm(EITHER, product, first, 0.0, turned, *last)),
        (cause != UNDECIDED and later > SETTLING * WINDOW, NO_ALARM._replace(load=load, undone=undone)),
        (cause != UNDECIDED, Alarm(cause, product, first, later, turned, *last)),
        (long_enough and surprise.product * product < 0.0, Alarm(LOAD, product, first, 0.0, 0.0, error, False)),
        (long_enough, Alarm(FRICTION, since, first, 0.0, 0.0, *last)),
        (later > LONGEST, Alarm(EITHER, product, first, 0.0, 0.0, *last)),
        (True, Alarm(UNDECIDED, product, first, later, turned, *last)),
    )
    return next(after for holds, after in rules if holds)


def drawn_alarm(rng):
    """Any alarm of those that there can be, also at the limits of its times."""
    limits = (0.0, TURNED_FOR * WINDOW, SETTLING * WINDOW - DURATION, LONGEST - DURATION)
    age = max(0.0, rng.choice(limits) + DURATION * rng.integers(-1, 2))
    turned = max(0.0, TURNED_FOR * WINDOW - DURATION * rng.integers(0, 4))
    friction = rng.choice(FRICTIONS)
    cause, product, load = int(rng.integers(0, 5)), rng.choice(PRODUCTS), rng.choice(SIZES)
    return Alarm(cause, product, friction, age, turned, load, bool(rng.integers(0, 2)))


@pytest.mark.parametrize("seed", [201, 202])
def test_an_alarm_becomes_what_the_rules_say(seed):
    rng, seen = np.random.default_rng(seed), Counter()
    for _ in range(12000):
        alarm, noticed = drawn_alarm(rng), bool(rng.integers(0, 2))
        surprise, friction = Surprise(rng.choice(PRODUCTS), 1.0, rng.choice(ERRORS)), rng.choice(FRICTIONS)
        found = attribute_change(alarm, noticed, surprise, friction, WINDOW, LONGEST, DURATION)
        assert found == by_rules(alarm, noticed, surprise, friction), (alarm, noticed, surprise, friction)
        seen[alarm.cause, found.cause] += 1
    assert set(seen) == {
        *((NOTHING, after) for after in (NOTHING, UNDECIDED)),
        *((UNDECIDED, after) for after in (UNDECIDED, FRICTION, LOAD, EITHER)),
        *((FRICTION, after) for after in (NOTHING, FRICTION, LOAD)),
        *((LOAD, after) for after in (NOTHING, UNDECIDED, LOAD)),
        *((EITHER, after) for after in (NOTHING, LOAD, EITHER)),
    }
    assert min(seen.values()) > 20


def test_a_load_that_was_none_is_not_undone():
    """Neither size nor error: there is nothing to undo, however long it has lasted."""
    old = NO_ALARM._replace(cause=UNDECIDED, age=10.0)
    assert not load_is_undone(old, Surprise(0.0, 1.0, 0.0), WINDOW)
    assert not load_is_undone(old._replace(load=1.0, age=TURNED_FOR * WINDOW), Surprise(0.0, 1.0, -1.0), WINDOW)
    assert load_is_undone(old._replace(load=1.0), Surprise(0.0, 1.0, -1.0), WINDOW)


def test_a_correction_is_scaled_only_where_it_goes_the_way_of_the_error():
    gradient = np.array([1.0, -2.0])
    for error in (0.5, 0.0, -0.5):
        for size in (0.25, 0.0, -0.25):
            correction = size * np.array([1.0, 1.0])  # explains -size
            explain_in_place(correction, gradient, error)
            wanted = abs(error) * math.copysign(1.0, size) if size * error < 0.0 else size
            assert correction.tolist() == [wanted, wanted]


NUMBERS = st.sampled_from([0.0, -0.0, 1.0, -1.0, 5e-324, 1e-200, -1e-200])


@given(st.lists(NUMBERS, min_size=8, max_size=8), st.integers(0, 4), st.booleans())
def test_zeros_and_smallest_numbers_are_no_trouble(values, cause, noticed):
    """Nothing is divided by a friction, a product or an error that may be zero."""
    product, squared, error, friction, first, load, guess, before = values
    surprise = Surprise(product, abs(squared), error)
    alarm = Alarm(cause, before, first, 1.0, 0.0, load, False)
    found = attribute_change(alarm, noticed, surprise, friction, WINDOW, LONGEST, DURATION)
    assert all(map(math.isfinite, found))
    assert math.isfinite(error_to_learn(alarm, noticed, surprise, error, abs(squared)))
    assert all(map(math.isfinite, note_surprise(surprise, friction, error, DURATION, WINDOW)))
    assert explained_by_friction(surprise) >= 0.0
    estimate = np.full(6, guess)
    follow_friction_in_place(estimate, product, abs(squared), 0)
    assert np.all(np.isfinite(estimate))

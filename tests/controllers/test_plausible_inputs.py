"""What a step is given and what of it is plausible, torques that observers reckon with, states as plain content."""

import json
import math
from collections import namedtuple

import numpy as np
import pytest

from controllers import planned_inputs
from controllers.plausibility import Guard, checked_inputs, inertia_bounds, kept, largest_torque
from controllers.saved_state import plain_state, rebuilt_state
from controllers.torques import acting_torque, slope_torque

GIVEN = planned_inputs(0.1, 0.09, 0.2, 80.0, 0.02)


def test_inputs_along_a_plan_know_nothing_else():
    known = {name: value for name, value in GIVEN._asdict().items() if not math.isnan(value)}
    assert known == {
        **{"reference": 0.1, "velocity": 0.09, "next_reference": 0.2, "realised_torque": 80.0, "dt": 0.02},
        **{"correction": 0.0, "feedforward": 0.0},
    }


@pytest.mark.parametrize(
    ("field", "largest", "beyond", "instead"),
    [  # of gains of 100: torques of 1e7 N m, inertias between 1e-4 and 1e5 kg m^2; periods of 1e-5 to 100 s
        ("reference", -1e5, 1.001e5, 0.3),
        ("reference", 1e5, math.nan, 0.3),
        ("next_reference", 1e5, -1.001e5, math.nan),
        ("acting_reference", math.nan, 1.001e5, math.nan),
        ("next_acting_reference", 1e5, -math.inf, math.nan),
        ("correction", 1e5, math.nan, 0.0),
        ("feedforward", -1e7, 1.001e7, 7.0),
        ("realised_torque", 1e7, -1.001e7, math.nan),
        ("position", 1e12, -1.001e12, math.nan),
        ("inertia", 1.001e-4, 100.0 * 1e-6, math.nan),
        ("inertia", 1e5, 1.001e5, math.nan),
        ("dt", 1e-5, 0.999e-5, 0.01),
        ("dt", 100.0, 100.1, 0.01),
        ("velocity", -1e5, 1.001e5, math.nan),
    ],
)
@pytest.mark.parametrize("gains", [(100.0, 5.0), (0.0, 100.0)])
def test_what_no_machine_can_give_is_replaced_and_counted(gains, field, largest, beyond, instead):
    given = GIVEN._replace(position=0.5, inertia=2.0, feedforward=3.0, acting_reference=0.3, next_acting_reference=0.4)
    for value, expected, fault in ((largest, largest, 0), (beyond, instead, 1)):
        found, guard = checked_inputs(given._replace(**{field: value}), Guard(0.3, 7.0, 1.0, 4), *gains, 0.01)
        wanted = given._replace(**{field: expected})
        if fault and "acting" in field:
            wanted = wanted._replace(acting_reference=math.nan, next_acting_reference=math.nan)
        np.testing.assert_array_equal(found, wanted)
        is_lost = fault and field == "velocity"  # which is counted elsewhere
        lost = 1.0 + given.dt if is_lost else 0.0
        assert guard == Guard(wanted.reference, wanted.feedforward, lost, 4 + (fault and not is_lost))


def test_torque_along_the_reference_is_that_of_the_slope_that_is_known_best():
    without = GIVEN._replace(next_reference=math.nan, acting_reference=2.0)
    acting = GIVEN._replace(acting_reference=2.0, next_acting_reference=2.3)
    cases = [(acting, True), (GIVEN, False), (without, True), (without, False), (GIVEN._replace(inertia=6.0), True)]
    found = [slope_torque(2.0, inputs, 0.06, started, 0.01) for inputs, started in cases]
    assert found == pytest.approx([2.0 * 0.3 / 0.01, 2.0 * 0.1 / 0.01, 2.0 * 0.04 / 0.02, 0.0, 6.0 * 0.1 / 0.01])
    lost = GIVEN._replace(realised_torque=math.nan)
    assert (acting_torque(GIVEN, 90.0, 30.0), acting_torque(lost, 90.0, 30.0)) == (50.0, 60.0)


Inner, Saved = namedtuple("Inner", "count flag line"), namedtuple("Saved", "inner table empty")
SAVED = Saved(Inner(3, True, (0.5, 1.5)), np.arange(6.0).reshape(2, 3), np.zeros((0, 3)))


def test_a_state_is_that_of_its_content_in_types_and_shapes():
    found = rebuilt_state(SAVED, json.loads(json.dumps(plain_state(SAVED))), "state")
    assert found.inner == SAVED.inner
    assert [type(item) for item in found.inner] == [int, bool, tuple]
    np.testing.assert_array_equal(found.table, SAVED.table)
    assert found.empty.shape == (0, 3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"table": [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]}, r"state.table must be finite and of shape \(2, 3\)"),
        ({"table": [[0.0, 1.0, 2.0], [3.0, 4.0, math.nan]]}, "state.table must be finite"),
        ({"table": [[0.0], [1.0, 2.0]]}, r"state.table = \[\[0.0\], \[1.0, 2.0\]\] is not allowed"),
        ({"empty": [1.0]}, "state.empty must be finite and of shape"),
        ({"table": [0.0] * 99}, rf"of shape \(2, 3\), not \[{'0.0, ' * 15}0.0,$"),
        ({"inner": {"count": 1.5, "flag": True, "line": [0.0, 1.0]}}, "state.inner.count = 1.5 .* of type int64"),
        ({"inner": {"count": 1, "flag": True}}, "state.inner must have the fields .*: line missing, none unknown"),
        ({"inner": 1}, "state.inner must have the fields count, flag, line$"),
        ({"more": 1}, "none missing, more unknown"),
    ],
)
def test_content_of_another_shape_is_refused_with_its_place(change, said):
    with pytest.raises(ValueError, match=said):
        rebuilt_state(SAVED, {**plain_state(SAVED), **change}, "state")


def test_bounds_of_loops_with_small_gains_or_none_and_of_what_an_observer_holds():
    assert [largest_torque(*gains) for gains in ((0.5, 0.0), (0.0, 0.5), (0.0, 0.0))] == [5e4, 5e4, math.inf]
    assert inertia_bounds(0.0) == (0.0, math.inf)
    assert [kept(value) for value in (0.9e30, 1e30, -1.1e30, math.nan)] == [0.9e30, 0.0, 0.0, 0.0]

"""The verdict of a comparison names what limits it, and whether feedforward is worth it."""

import pytest
from closed_loops import SCENARIO

from adaptive_ff import compare
from adaptive_ff.comparison.comparison import error_parts, verdict
from adaptive_ff.report.verdicts import LIMITS, comparison_lines

SHORT = SCENARIO.modified(duration=10.0, controllers=["pi", "oracle", "adaptive"])
QUIET = {"velocity_noise": 0.0}


@pytest.mark.parametrize(
    ("changed", "limit"),
    [
        ({}, "noise"),
        ({"sensor": QUIET}, "friction"),
        ({"actuator": {"torque_limit": 80.0}}, "saturation"),
        ({"sensor": QUIET, "joint": {"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}}, "bandwidth"),
    ],
)
def test_limit_is_the_largest_part_of_the_error(changed, limit):
    found = verdict(compare(SHORT.modified(**changed)))
    assert found.limit == limit
    assert any(LIMITS[limit][0] in line for line in comparison_lines(found))


def test_best_is_a_controller_that_does_not_know_the_truth_and_says_what_it_identified():
    comparison = compare(SHORT.modified(controllers=["pi", "oracle", "fixed", "adaptive"]))
    found = verdict(comparison)
    assert found.best == "adaptive"
    assert found.over_pi == comparison.improvement["adaptive"]
    assert "inertia" in found.identified
    assert "gravity_sin" in found.given  # there is none
    assert not set(found.identified) & set(found.given)


def test_where_nothing_beats_pi_it_is_kept():
    noise = SCENARIO.modified(duration=5.0, controllers=["pi", "oracle"])
    found = verdict(compare(noise))
    assert (found.best, found.over_pi, found.worth, found.identified) == ("pi", 1.0, False, ())
    assert comparison_lines(found)[0] == "Verdict: pi: nothing that ran is worth it on this joint, keep pi."


def test_without_pi_nothing_is_said_of_worth_and_late_changes_do_not_hide_the_limit():
    late = {"duration": 70.0, "controllers": ["oracle", "fixed"], "change": [{"time": 65.0, "friction_scale": 0.5}]}
    found = verdict(compare(SCENARIO.modified(**late)))
    assert (found.best, found.over_pi, found.worth) == ("fixed", None, False)
    assert comparison_lines(found)[0].startswith("Verdict: fixed: the least settled error")
    assert found.limit is not None


def test_parts_add_up_to_the_error():
    parts = error_parts(SHORT, 1e-2)
    assert sum(value**2 for value in parts.values()) == pytest.approx(1e-4)

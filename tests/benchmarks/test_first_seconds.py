"""What is left of the first seconds where all is known after some time, beside the runs themselves."""

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from benchmarks.first_seconds import KNOWN_AFTER, first_squares, ratios


@pytest.fixture(scope="module")
def joint():
    return load_scenario().modified(duration=8.0, seed=101)


def test_squares_begin_with_the_motion(joint):
    run = simulate(joint, "pi")
    square, period = np.square(run.reference - run.velocity), joint.joint.solver_period
    begin = int(np.flatnonzero(run.reference)[0])
    assert np.array_equal(first_squares(joint, "pi"), square[begin : begin + round(5.0 / period)])


def test_squares_begin_with_a_change(joint):
    changed = joint.modified(change=[{"time": 2.0, "friction_scale": 0.6}])
    run, period = simulate(changed, "pi"), joint.joint.solver_period
    begin = round(2.0 / period)
    assert np.array_equal(
        first_squares(changed, "pi"), np.square(run.reference - run.velocity)[begin : begin + round(5.0 / period)]
    )


def test_who_knows_later_leaves_what_was_made_before(joint):
    own, knowing, *known = ratios(joint)
    squares = {name: first_squares(joint, name) for name in ("pi", "adaptive", "oracle_tuned")}
    assert own == pytest.approx(np.sqrt(squares["adaptive"].sum() / squares["pi"].sum()))
    assert knowing < own
    cut = round(KNOWN_AFTER[1] / joint.joint.solver_period)
    mixed = squares["adaptive"][:cut].sum() + squares["oracle_tuned"][cut:].sum()
    assert known[1] == pytest.approx(np.sqrt(mixed / squares["pi"].sum()))

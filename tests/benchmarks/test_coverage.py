"""The synthetic logs on which the intervals of ``identify`` are counted."""

import numpy as np
import pytest

from benchmarks.cases.drawn_logs import make_case
from benchmarks.cases.logs import repetition


@pytest.mark.parametrize("seed", [2, 3, 8, 11])
def test_records_of_a_joint_share_it_but_not_their_motion(seed):
    one, other = (make_case(seed, record=record) for record in (0, 1))
    assert one.truth["inertia"] == other.truth["inertia"]
    assert one.kind == other.kind
    assert not np.array_equal(one.log.position[:100], other.log.position[:100])
    again = make_case(seed)
    assert np.array_equal(again.log.torque, one.log.torque)


def test_repetition_agrees_within_both_half_widths():
    one = {"inertia_error": [0.0], "inertia_width": [0.03]}
    near, far = ({"inertia_error": [error], "inertia_width": [0.04]} for error in (0.049, 0.051))
    assert repetition(one, near) == {"inertia_repeats": [1.0]}
    assert repetition(one, far) == {"inertia_repeats": [0.0]}

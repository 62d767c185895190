"""What a group of joints is made of."""

import pytest

from adaptive_ff import AdaptiveController, JointGroup
from controllers import PI


def test_what_is_no_adaptive_controller_is_refused_by_name():
    for other in (PI(100.0, 1000.0, 0.01), 3):
        with pytest.raises(TypeError, match=r"^elbow = .* is not allowed: it must be an AdaptiveController"):
            JointGroup({"elbow": other})


def test_one_controller_under_two_names_is_refused():
    one = AdaptiveController(100.0, 1000.0, 0.01, inertia=2.0, stribeck_velocity=0.05)
    with pytest.raises(ValueError, match="one controller stands under two names"):
        JointGroup({"shoulder": one, "elbow": one})

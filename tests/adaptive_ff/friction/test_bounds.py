"""What is believed of a joint's parameters."""

import numpy as np
import pytest

from adaptive_ff.friction.bounds import largest_lag, torque_model


@pytest.mark.parametrize(("response", "largest"), [(0.016, 0.16), (0.01, 0.1), (0.0013, 0.1), (1e-6, 0.1)])
def test_largest_lag_is_ten_time_constants_of_the_feedback_and_at_least_a_tenth_of_a_second(response, largest):
    assert largest_lag(response) == pytest.approx(largest, rel=1e-12)


@pytest.mark.parametrize("stiction", [5.0, 1.0])
def test_friction_falls_or_rises_from_standstill_on(stiction):
    estimate = np.array([1.0, 3.0, stiction, 0.5, 0.01, 0.0, 9.0, 0.0])
    model = torque_model(estimate, 0.02, 0.05, 1.0)
    assert (model.coulomb, model.stiction, model.stiction_asymmetry) == (3.0, stiction, 2.0)

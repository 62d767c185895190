import math

import numpy as np
import pytest

from controllers.design.margins import loop_margins, maximum_sensitivity
from controllers.design.observer_design import on_measured_velocity
from controllers.design.sampled_loop import SampledLoop, open_loop


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize("integral", [0.0, 0.02])
@pytest.mark.parametrize("velocity_gain", [1.0, 0.6])
def test_search_has_the_sensitivity_of_the_margins_to_the_bit(delay, integral, velocity_gain):
    loop = SampledLoop(0.25, integral, delay)
    unstable = 0
    for gain in (0.02, 0.1, 0.3, 0.9):
        opened = open_loop(loop, on_measured_velocity(velocity_gain, gain))
        found = maximum_sensitivity(*opened, 0.01)
        assert found == loop_margins(*opened, 0.01).maximum_sensitivity
        unstable += math.isinf(found)
    assert unstable < 4


def test_product_of_polynomials_is_that_of_numpy():
    from controllers.design.sampled_loop import _product

    for first, second in (([0.0, 2.0, 1.0], [0.0, 0.0, 3.0]), ([0.0], [1.0, 2.0]), ([1.0, -1.0], [1.0, -1.0])):
        np.testing.assert_array_equal(_product(np.array(first), np.array(second)), np.polymul(first, second))

"""The sampled loop: its margins."""

import math

import numpy as np
import pytest

from controllers.design.margins import loop_margins
from controllers.design.sampled_loop import SampledLoop, open_loop


@pytest.mark.parametrize("proportional", [1e-4, 1e-2, 0.4, 1.2])
def test_margins_are_those_at_the_crossover_of_loops_of_any_speed(proportional):
    loop = SampledLoop(proportional, 0.2 * proportional**2, 0)
    found = loop_margins(*open_loop(loop), 1e-2 * min(proportional, 1.0))
    numerator, denominator = (np.polyval(one, np.exp(2j * math.pi * found.crossover)) for one in open_loop(loop))
    assert abs(numerator / denominator) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(math.degrees(np.angle(-numerator / denominator)), abs=1e-6)

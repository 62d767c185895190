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


NOTCH = 0.35 * np.array([1.0, -1.96 * math.cos(0.5), 0.98**2])


@pytest.mark.parametrize(
    ("loop", "rest"), [(NOTCH, [1.0, -1.0, 0.0, 0.0]), ([-0.05], [1.0, -0.9])], ids=["notch", "negative when slow"]
)
def test_loop_is_stable_up_to_its_gain_margin(loop, rest):
    loop = np.array(loop)
    margin = loop_margins(loop, np.array(rest), 1e-3).gain_margin
    largest_poles = [np.max(np.abs(np.roots(np.polyadd(gain * margin * loop, rest)))) for gain in (0.99, 1.01)]
    assert largest_poles[0] < 1.0 < largest_poles[1]

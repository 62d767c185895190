"""The short check of the inputs lets nothing pass that the long one would replace."""

import itertools
import math

import numpy as np
import pytest

from controllers.plausibility import Guard, checked_inputs, replaced_inputs, surely_plausible
from controllers.registry import Inputs

BOUNDS = (0.0, 1e-6, 1e-3, 1.0, 1e3, 1e4, 1e5, 1e12, 1e306, math.inf)
AROUND = [np.nextafter(bound, way) for bound in BOUNDS for way in (-math.inf, bound, math.inf)]
VALUES = [math.nan, *sorted({float(sign * value) for sign in (-1.0, 1.0) for value in AROUND})]
USUAL = Inputs(0.1, 0.2, 0.11, 0.0, 1.0, 3.0, 0.0, 20.0, 0.01, 0.12, 0.13)
GUARD = Guard(0.05, 0.5, 0.3, 2)


@pytest.mark.parametrize(("proportional", "integral"), [(100.0, 50.0), (0.0, 50.0), (0.0, 0.0), (1e304, 1.0)])
def test_short_check_passes_nothing_that_the_long_one_replaces(proportional, integral):
    settings = proportional, integral, 0.01
    passed = 0
    for first, second in itertools.combinations(Inputs._fields, 2):
        for one, other in zip(VALUES, np.random.default_rng(1).permutation(VALUES), strict=True):
            inputs = USUAL._replace(**{first: one, second: float(other)})
            whole, guard = replaced_inputs(inputs, GUARD, *settings)
            short = surely_plausible(inputs, proportional if proportional > 0.0 else integral, 0.01)
            passed += short
            if short:
                assert np.array_equal(whole, inputs, equal_nan=True)
            assert repr(checked_inputs(inputs, GUARD, *settings)) == repr((whole, guard))
    assert passed > 10 or proportional == integral == 0.0


def test_usual_inputs_pass_the_short_check():
    unknown = USUAL._replace(next_reference=math.nan, position=math.nan, realised_torque=math.nan, inertia=math.nan)
    assert surely_plausible(USUAL, 100.0, 0.01)
    assert surely_plausible(unknown, 100.0, 0.01)

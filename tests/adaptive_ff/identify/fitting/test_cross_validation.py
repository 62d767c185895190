"""Which model is used of those that say blocks which they have not seen about equally well."""

import numpy as np
import pytest

from adaptive_ff.identify.fitting.cross_validation import Validated, behind, choose
from adaptive_ff.identify.fitting.grid import BLOCKS
from adaptive_ff.identify.fitting.grid_fit import Point
from adaptive_ff.identify.terms import LAG, STICTION

PLAIN = ("inertia", "coulomb", "viscous")
ERRORS = 1e-5 * (1.0 + np.random.default_rng(1).uniform(-0.3, 0.3, BLOCKS))
SCATTER = np.linspace(-1.0, 1.0, BLOCKS)


def validated(held, *added):
    return Validated((*PLAIN, *added), Point(0.0, 0.0, 0.0, 0.0, False), held)


@pytest.mark.parametrize("rounding", [1e-17, -1e-17, 0.0])
def test_a_term_that_comes_out_as_zero_is_left_out_whichever_way_it_is_rounded(rounding):
    """Alike in every block, such differences have next to no scatter: they are above one standard error."""
    simple, lagged = validated(ERRORS + rounding), validated(ERRORS, LAG)
    assert choose([simple, lagged])[0] is simple
    assert choose([lagged, simple])[0] is simple


@pytest.mark.parametrize(("errors", "used"), [(0.9, False), (1.1, True)])
@pytest.mark.parametrize("term", [LAG, STICTION])
def test_a_term_that_validates_better_by_more_than_a_standard_error_is_used(term, errors, used):
    worse, deviation = behind(validated(ERRORS + 1e-7 * SCATTER), validated(ERRORS))
    assert abs(worse) < 1e-12
    simple = validated(ERRORS + 1e-7 * SCATTER + errors * deviation / BLOCKS)
    further = validated(ERRORS, term)
    assert choose([simple, further])[0] is (further if used else simple)


@pytest.mark.parametrize(("errors", "used"), [(1.1, False), (1.9, False), (2.1, True)])
def test_a_lag_that_a_log_does_not_show_takes_two_standard_errors_and_widens_the_interval(errors, used):
    _, deviation = behind(validated(ERRORS + 1e-7 * SCATTER), validated(ERRORS))
    simple = validated(ERRORS + 1e-7 * SCATTER + errors * deviation / BLOCKS)
    lagged = validated(ERRORS, LAG)
    chosen, near = choose([simple, lagged], shows_lag=False)
    assert chosen is (lagged if used else simple)
    assert near == ([] if used else [lagged])
    assert choose([simple, lagged])[0] is lagged

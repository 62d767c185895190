"""Intervals of the speeds at which friction bends."""

import math
from types import SimpleNamespace

import pytest

from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.terms import BENT
from adaptive_ff.learning.batch_least_squares import Estimate


def bend(logarithm):
    """Interval of a bend whose logarithm has this one."""
    regression = SimpleNamespace(estimate=lambda name: logarithm)
    return Fitted.estimate(SimpleNamespace(_stiction=("", ""), regression=regression), list(BENT.values())[-1])


def test_a_bend_that_the_log_does_not_know_is_anywhere():
    assert bend(Estimate(math.log(0.3), 20.0, -40.0, 40.0))[2:] == (0.0, math.inf)


def test_one_that_it_knows_has_the_interval_of_its_logarithm():
    value, deviation, lower, upper = bend(Estimate(math.log(0.3), 0.1, math.log(0.2), math.log(0.5)))
    assert (value, deviation, lower, upper) == pytest.approx((0.3, 0.03, 0.2, 0.5))

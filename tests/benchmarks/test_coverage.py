"""The synthetic logs on which the intervals of ``identify`` are counted."""

import pytest

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.terms import SATURATIONS
from benchmarks.coverage import examine, flag_sentence, make_case
from benchmarks.coverage_told import fit_told

UNTOLD = 406
"""Seed of a log whose friction saturates, in a shape and at a bend that it does not tell."""


@pytest.fixture(scope="module")
def case():
    return make_case(UNTOLD)


def test_viscous_friction_that_shapes_of_saturation_make_vague_is_said_to_be_confounded_with_them(case):
    found = identify_log(case.log, held_out=0.0)
    chosen = set(found.selection.chosen.terms) & set(SATURATIONS)
    assert chosen
    assert set(found.parameters["viscous"].confounded) >= chosen
    assert found.parameters["inertia"].confounded == ()
    lower, upper = found.selection.ends(found.selection.chosen, "viscous")
    fitted = found.selection.chosen.estimate("viscous")
    assert upper - lower > 3.0 * (fitted.upper - fitted.lower)  # the fit alone knows of one shape only


def test_the_shape_that_fits_best_states_more_than_the_log_tells(case):
    fitted = fit_told(case)
    assert set(fitted.terms) & set(SATURATIONS)
    lower, upper = fitted.estimate("viscous")[2:]
    assert not lower < case.truth["viscous"] < upper  # the true shape is none of those identified
    assert examine(case)["viscous"]["covers"]


def test_what_is_flagged_is_counted_by_the_half_width_over_the_value(case):
    result = examine(case)
    assert result["viscous"]["flagged"]
    assert 0.25 < result["viscous"]["vague"] < 0.5
    assert "100.0 % from 25 % of the value on, 0.0 % from 50 %" in flag_sentence([result])

"""Friction on bristles: viscous friction does not lag there, so that the inertia of the model is too large."""

import numpy as np
import pytest
from bristle_logs import INERTIA, VISCOUS, bristle_log

from adaptive_ff.identify.alternatives.bristle_lag import fit_on_bristles
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.preparation import prepare, regression_problem
from adaptive_ff.identify.rows.regressors import piece_columns
from adaptive_ff.identify.terms import LAG


@pytest.mark.parametrize(("seed", "options"), [(1, {}), (2, {"delay": 0.001}), (3, {"seconds": 30, "travel": 1e-3})])
def test_intervals_hold_the_inertia_and_viscous_friction_of_a_joint_on_bristles(seed, options):
    """Inertia came out at 0.507 to 0.533 kg m^2 for 0.5, with the delay viscous friction at 1.954 to 1.995 for 2."""
    found = identify_log(bristle_log(seed, **options), held_out=0.0)
    inertia, viscous = (found.parameters[name].estimate for name in ("inertia", "viscous"))
    assert inertia.lower < INERTIA < inertia.upper
    assert inertia.upper - inertia.lower < 0.08 * INERTIA
    assert viscous.lower < VISCOUS < viscous.upper


def test_the_inertia_is_said_that_bristles_would_have_whose_path_does_not_show():
    found = identify_log(bristle_log(2, delay=0.001), held_out=0.0)
    assert LAG in found.selection.chosen.terms
    on_bristles = found.selection.bristles.values["inertia"]
    assert on_bristles == pytest.approx(INERTIA, rel=0.01)
    (sentence,) = (one for one in found.verdict if "on bristles lags" in one)
    assert f"inertia would be about {on_bristles:.4g} instead of" in sentence


def test_a_lag_of_all_friction_that_shows_is_not_taken_for_bristles():
    found = identify_log(bristle_log(1, lag=0.04), held_out=0.0)
    assert found.value(LAG) == pytest.approx(0.04, rel=0.02)
    assert found.parameters["inertia"].estimate.value == pytest.approx(INERTIA, rel=0.01)
    assert found.selection.bristles is None
    assert not any("bristles" in one for one in found.verdict)


def test_there_are_no_bristles_without_a_lag():
    log = bristle_log(1)
    prepared = prepare(log, None)
    found = identify_log(log, held_out=0.0, model="coulomb-viscous")
    problem = regression_problem(prepared, prepared.pieces, 0.0)
    assert fit_on_bristles(problem, prepared, prepared.pieces, found.selection.chosen, delay_told=True) is None


def test_terms_that_do_not_lag_are_those_without_a_lag():
    prepared = prepare(bristle_log(1), None)
    problem = regression_problem(prepared, prepared.pieces, 0.0)
    (piece,) = problem.pieces
    terms, lag = ("coulomb", "viscous"), {"friction_lag": 0.02}
    lagged = piece_columns(piece, problem.speeds, terms, lag)
    mixed = piece_columns(piece, problem.speeds, terms, lag, ("viscous",))
    at_once = piece_columns(piece, problem.speeds, terms, {})
    assert np.array_equal(mixed[:, 0], lagged[:, 0])
    assert np.array_equal(mixed[:, 1], at_once[:, 1])
    assert not np.allclose(lagged[:, 1], at_once[:, 1])


@pytest.mark.parametrize(("lag", "is_said"), [(0.3, True), (0.05, False)])
def test_a_lag_at_the_end_of_what_is_looked_for_is_said(lag, is_said):
    """It was given with an interval of a few per cent, and nothing was said."""
    found = identify_log(bristle_log(1, lag=lag), held_out=0.0)
    assert (found.value(LAG) > 0.99 * found.lags[-1]) == is_said
    assert any("the longest time that is looked for" in one for one in found.cautions) == is_said

"""Physical estimates: their slopes, by which deviations are theirs, against difference quotients."""

import numpy as np
import pytest
from exports import adaptive, adaptive_variants

from adaptive_ff.adaptive.estimates import HELD, fill_slopes, write_physical
from adaptive_ff.learning.kalman import LOOP

VARIANTS = {name: make() for name, make in adaptive_variants().items()}
VARIANTS |= {"no offset, regressors": adaptive(regressors=2), "no offset, ripples": adaptive(ripple_periods=[0.3])}


@pytest.mark.parametrize("controller", VARIANTS.values(), ids=VARIANTS)
def test_slopes_are_the_derivatives_of_the_estimates(controller):
    parameters, state, count = controller.parameters, controller.state, len(controller.estimate_names)
    mean = np.random.default_rng(1).uniform(0.5, 2.0, state.estimate.mean.size)

    def with_mean(values):
        return state._replace(estimate=state.estimate._replace(mean=values))

    def estimates(values):
        row = np.zeros(count)
        write_physical(parameters, with_mean(values)._replace(steady=values[HELD]), row)
        return row

    slopes, steps = np.ones((count, mean.size)), 1e-5 * np.eye(mean.size)
    fill_slopes(parameters, with_mean(mean), slopes)
    expected = np.array([(estimates(mean + step) - estimates(mean - step)) / 2e-5 for step in steps]).T
    np.testing.assert_allclose(slopes, expected, rtol=1e-6, atol=1e-8)
    assert np.all(np.any(slopes[:, LOOP:], axis=1) | (np.array(controller.estimate_names) == "offset"))

"""Share of a jump's samples that is left in those of its lagged friction: against sums over samples of many jumps."""

import numpy as np
import pytest

from adaptive_ff.identify.rows.sampled_lag import SMALL, sampled_share


@pytest.mark.parametrize("lag", [0.001, 0.0035, 0.01, 0.05])
def test_share_is_the_regression_of_lagged_samples_on_static_ones(lag):
    period = 0.01
    before = (np.arange(400) + 0.5) / 400 * period  # by how much the jump comes before a sample
    times = before[:, np.newaxis] + period * np.arange(2000)
    lagged = period * np.sum(np.exp(-times / lag), axis=1) + before - 0.5 * period  # area that the samples lack
    static = before - 0.5 * period
    slope = np.sum((lagged - lag) * static) / np.sum(static**2)
    assert np.mean(lagged) == pytest.approx(lag, rel=1e-3)
    assert sampled_share(period, lag) == pytest.approx(slope, rel=1e-3, abs=1e-6)


def test_share_goes_from_one_to_zero_without_a_step():
    assert sampled_share(0.01, 0.0) == 1.0
    assert sampled_share(0.01, 1e-9) == pytest.approx(1.0, abs=1e-5)
    below, above = sampled_share(SMALL * (1 - 1e-6), 1.0), sampled_share(SMALL * (1 + 1e-6), 1.0)
    assert below == pytest.approx(above, rel=0.02)
    assert sampled_share(0.01, -0.004) == sampled_share(0.01, 0.004)

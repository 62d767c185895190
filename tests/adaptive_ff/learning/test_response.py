"""The response of the loop against python-control's discrete loop."""

import control
import numpy as np
import pytest

from adaptive_ff.learning.response import advance_response, initial_response, put_in
from controllers import check_gains, pi_gains

INERTIA, PERIOD = 20.0, 0.01
GAINS = pi_gains(INERTIA, 10.0)


def answers(torques, delay=0.0, lag=0.0, lost=()):
    """Measured velocities, rad/s, of a torque that is put in from the first sample on."""
    pi, response = check_gains(*GAINS, PERIOD, delay), initial_response(1, delay)
    followed, found = PERIOD / (PERIOD + lag), []
    for k, torque in enumerate(torques):
        put_in(response, 0, torque)
        found.append(advance_response(response, 0, 0.0, pi, INERTIA, followed, PERIOD, k not in lost))
    return np.array(found)


def discrete_loop(delay, lag):
    z = control.tf([1.0, 0.0], [1.0], PERIOD)
    whole, part = int(delay), delay - int(delay)
    late = (1.0 - part) * z**-whole if whole else control.tf([1.0 - part], [1.0], PERIOD)
    if part:
        late = late + part * z ** -(whole + 1)
    joint = control.tf([PERIOD / INERTIA, 0.0], [1.0, -1.0], PERIOD)  # measured at the end of the period
    share = PERIOD / (PERIOD + lag)
    seen = control.tf([share, 0.0], [1.0, share - 1.0], PERIOD)
    feedback = control.tf([GAINS[0] + GAINS[1] * PERIOD, -GAINS[0]], [1.0, -1.0], PERIOD)
    forward = joint * late * seen
    return forward / (1.0 + forward * feedback * z**-1)


@pytest.mark.parametrize("lag", [0.0, 0.004])
@pytest.mark.parametrize("delay", [0.0, 1.0, 0.5, 1.5])
def test_it_is_the_response_of_the_sampled_loop(delay, lag):
    torques = np.random.default_rng(1).standard_normal(200)
    time = PERIOD * np.arange(torques.size)
    expected = control.forced_response(discrete_loop(delay, lag), time, torques).outputs
    np.testing.assert_allclose(answers(torques, delay, lag), expected, rtol=1e-8, atol=1e-10)

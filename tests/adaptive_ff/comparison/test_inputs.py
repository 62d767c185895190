"""Plan, correction and configuration reach every controller in the same way."""

import math

import numpy as np
import pytest
from closed_loops import SAMPLE, SCENARIO
from nightly import sampled

from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from controllers import PI, feedback_state

NAMES = [name for name in CONTROLLERS if name not in FIXED]
SAMPLES = 150


CORRECTED = ("lugre_observer", "maxwell_adaptive", "radial_basis")
"""Their law corrects what is fed by the tracking error, of which the correction is a part; with no switch for it."""


def make(name):
    controller = CONTROLLERS[name](SCENARIO).run_uncompiled()
    if hasattr(controller, "enabled"):
        controller.enabled = False  # what is learnt may differ; how it is fed may not
    return controller


def torques(controller, correction):
    """Torques along a motion with reversals, for given corrections and realised torques."""
    period, found = controller.period, []
    for k in range(SAMPLES):
        now, following = (0.3 * math.sin(6.0 * period * sample) for sample in (k, k + 1))
        velocity = now - 0.01 * math.cos(9.0 * period * k)
        given = {"realised_torque": 50.0 * math.sin(0.1 * k) if k else None, "correction": correction[k]}
        found.append(controller.step(now, velocity, next_reference=following, **given))
    return np.array(found)


@pytest.mark.parametrize("name", sampled([name for name in NAMES if name not in CORRECTED], SAMPLE))
def test_correction_is_seen_by_the_feedback_alone(name):
    """The torque differs by exactly what the PI loop makes of the correction.

    What ``adaptive`` learns and observes of a joint that does not answer to it differs as well: there to a sixth.
    """
    correction = 0.05 * np.random.default_rng(101).standard_normal(SAMPLES)
    controller = make(name)
    loop = feedback_state(controller.parameters)
    feedback = (loop.proportional, loop.integral)  # where an observer integrates, there is none
    assert feedback[0] == SCENARIO.feedback.gains[0]
    found = torques(controller, correction) - torques(make(name), np.zeros(SAMPLES))
    pair = [PI(*feedback, controller.period, delay=SCENARIO.delay).run_uncompiled() for _ in range(2)]
    expected = torques(pair[0], correction) - torques(pair[1], np.zeros(SAMPLES))
    assert np.ptp(expected) > 50.0
    tolerance = np.ptp(expected) / 6.0 if name == "adaptive" else 1e-9
    assert found == pytest.approx(expected, abs=tolerance)


def test_a_refused_step_changes_nothing():
    controller = make("pi")
    state = controller.state
    for wrong in ({"correction": math.nan}, {"correction": math.inf}, {"inertia": 0.0}, {"inertia": math.nan}):
        with pytest.raises(ValueError, match=f"^{min(wrong)} = .* is not allowed"):
            controller.step(0.1, 0.0, **wrong)
    assert controller.state == state

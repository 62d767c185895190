"""The super-twisting observer: the implicit step solves its inclusion, and the estimate is exact without noise."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers import SuperTwisting
from controllers.observers.super_twisting import FIRST, SECOND, twisted


@given(st.floats(-1.0, 1.0), st.floats(1e-3, 1e4), st.floats(1e-4, 0.1))
def test_implicit_step_solves_its_inclusion(error, bound, duration):
    after, sign = twisted(error, bound, duration)
    left = after + duration * FIRST * math.sqrt(bound * abs(after)) * math.copysign(1.0, after)
    left += duration**2 * SECOND * bound * sign
    assert left == pytest.approx(error, abs=1e-9 * max(abs(error), duration**2 * bound))
    assert abs(sign) <= 1.0
    if after != 0.0:
        assert sign == math.copysign(1.0, after)


def test_disturbance_within_the_bound_is_found_exactly_after_a_finite_time():
    # d = 20 + 30 t, |dd/dt| = 30 < J L = 200; only the sample's own delay is left: the mean over a period
    inertia, period = 20.0, 0.001
    controller = SuperTwisting(0.0, 0.0, period, inertia=inertia, bound=10.0).run_uncompiled()
    velocity, torque = 0.0, controller.step(0.0, 0.0, next_reference=0.0)
    for k in range(3000):
        disturbance = 20.0 + 30.0 * (k + 0.5) * period
        velocity += period / inertia * (torque - disturbance)
        torque = controller.step(0.0, velocity, next_reference=0.0)
        if k > 2000:
            assert controller.disturbance == pytest.approx(disturbance, abs=0.5)
    assert abs(velocity) < 2.0

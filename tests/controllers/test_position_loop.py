import math

import control
import numpy as np
import pytest

from controllers import PI, PositionLoop, design_position_loop

PERIOD, INERTIA, BANDWIDTH = 0.01, 20.0, 10.0
GAINS = PI.design(INERTIA, PERIOD, BANDWIDTH)


def test_correction_is_the_gain_times_the_error_within_the_limit():
    loop = PositionLoop(10.0, limit=0.5)
    assert loop.step(1.0, 0.98) == pytest.approx(0.2)
    assert loop.step(1.0, 0.5) == 0.5
    assert loop.step(-1.0, 0.5) == -0.5
    assert PositionLoop(10.0).step(1.0, -1.0) == pytest.approx(20.0)


def test_bad_plan_is_refused_and_changes_nothing():
    loop = PositionLoop(10.0)
    loop.step(1.0, 0.9)
    state = loop.state
    with pytest.raises(ValueError, match=r"^planned = nan is not allowed"):
        loop.step(math.nan, 0.0)
    assert loop.state == state


def cascade(gain, delay, count=400):
    """Position of an inertia that is stepped exactly, for a step of the planned position by 1 rad."""
    velocity_loop = PI(GAINS.proportional, GAINS.integral, PERIOD).run_uncompiled()
    position_loop, position, velocity, late, found = PositionLoop(gain), 0.0, 0.0, [0.0] * delay, []
    for _ in range(count):
        found.append(position)
        late.append(velocity_loop.step(0.0, velocity, correction=position_loop.step(1.0, position)))
        acceleration = late.pop(0) / INERTIA
        position += PERIOD * velocity + 0.5 * PERIOD**2 * acceleration
        velocity += PERIOD * acceleration
    return np.array(found)


def open_loop(gain):
    """From the position error to the position: states are position, velocity and integral."""
    proportional, integral = GAINS.proportional, GAINS.integral * PERIOD
    torque = np.array([0.0, -(proportional + integral), 1.0])  # of the states; (Kp + Ki Ts) Kv of the error
    speed, way = PERIOD / INERTIA, PERIOD**2 / (2.0 * INERTIA)
    dynamics = np.array([[1.0, PERIOD, 0.0], [0.0, 1.0, 0.0], [0.0, -integral, 1.0]])
    dynamics += np.outer([way, speed, 0.0], torque)
    inputs = gain * (np.array([way, speed, 0.0]) * (proportional + integral) + np.array([0.0, 0.0, integral]))
    return control.ss(dynamics, inputs[:, None], [[1.0, 0.0, 0.0]], 0.0, PERIOD)


@pytest.mark.parametrize("gain", [5.0, 2.0 * math.pi * BANDWIDTH / 6.0])
def test_cascade_moves_as_the_transfer_function_that_the_design_reckons_with(gain):
    opened = open_loop(gain)
    closed = control.feedback(opened, 1.0)
    expected = control.forced_response(closed, inputs=np.ones(400)).outputs
    assert cascade(gain, 0) == pytest.approx(expected, abs=1e-8)
    margins = control.stability_margins(opened, method="frd")
    design = design_position_loop(PERIOD, BANDWIDTH, gain)
    assert design.gain_margin == pytest.approx(margins[0], rel=1e-2)
    assert design.phase_margin == pytest.approx(margins[1], abs=0.5)
    assert design.crossover == pytest.approx(margins[4] / (2.0 * math.pi), rel=1e-2)
    assert design.maximum_sensitivity == pytest.approx(1.0 / margins[2], rel=1e-2)


def test_largest_gain_is_named_and_the_margin_is_met_there():
    for bandwidth in (0.5, BANDWIDTH):
        with pytest.raises(ValueError, match=r"^gain = 100 1/s is not allowed: .* at most ([0-9.]+) 1/s$") as found:
            PositionLoop.design(PERIOD, bandwidth, 100.0)
        largest = float(str(found.value).split()[-2])
        design = PositionLoop.design(PERIOD, bandwidth, 0.999 * largest)
        assert design.maximum_sensitivity == pytest.approx(1.7, rel=1e-2)
    assert np.max(np.abs(cascade(8.0 * largest, 0))) > 1e3  # it does become unstable

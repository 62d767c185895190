"""The PI loop, the delay that controllers reckon with, and the position loop around it."""

import math

import control
import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, PERIOD, run_inertia

from controllers import PI, PositionLoop, compiled, design_position_loop, feed_back, planned_inputs
from controllers.delay import delay_line, delayed, remember


def test_a_measurement_may_be_lost_for_two_seconds():
    loop, found = PI(*GAINS, 0.5), []
    for _ in range(5):
        loop.step(0.1, math.nan)
        found.append(loop.fault)
    assert found == [False, False, False, False, True]


@pytest.mark.parametrize("gains", [GAINS, (GAINS[0], 0.0), (100.0, 3000.0)])
def test_closed_loop_with_an_inertia_is_the_transfer_function_of_python_control(gains):
    proportional, integral = gains
    rng = np.random.default_rng(3)
    reference, disturbance = rng.standard_normal(400), 100.0 * rng.standard_normal(400)
    characteristic = [
        INERTIA,
        PERIOD * (proportional + integral * PERIOD) - 2.0 * INERTIA,
        INERTIA - PERIOD * proportional,
    ]
    tracking = control.tf([PERIOD * (proportional + integral * PERIOD), -PERIOD * proportional], characteristic, PERIOD)
    rejection = control.tf([PERIOD, -PERIOD], characteristic, PERIOD)
    expected = control.forced_response(tracking, inputs=reference).outputs
    expected = expected + control.forced_response(rejection, inputs=disturbance).outputs
    velocities, _ = run_inertia(PI(*gains, PERIOD), reference, load=-disturbance, tell=False, preview=False)
    assert np.max(np.abs(velocities)) > 0.1
    assert velocities == pytest.approx(expected, rel=1e-12, abs=1e-12)


def samples_in_saturation_after_the_reversal(tell, limit=50.0):
    """Block the joint for 20 s under a reference it cannot follow, then reverse the reference."""
    controller, realised = PI(*GAINS, PERIOD), None
    for _ in range(2000):
        torque = controller.step(0.5, 0.0, realised_torque=realised if tell else None)
        realised = min(max(torque, -limit), limit)
    blocked = controller.state.integral
    samples = 0
    while controller.step(-0.5, 0.0, realised_torque=realised if tell else None) > 0.0:
        realised = limit
        samples += 1
    return samples, blocked


def test_told_of_the_realised_torque_the_loop_leaves_saturation_at_once():
    samples, integral = samples_in_saturation_after_the_reversal(tell=True)
    assert samples == 0
    assert integral == pytest.approx(50.0, rel=1e-9)  # back-calculation settles where I is the torque given


def test_not_told_it_stays_in_saturation_about_as_long_as_it_was_blocked():
    samples, integral = samples_in_saturation_after_the_reversal(tell=False)
    assert integral == pytest.approx(GAINS[1] * PERIOD * 0.5 * 2000, rel=1e-9)
    assert 1900 < samples < 2000


@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf])
def test_lost_measurement_is_counted_and_its_error_taken_for_zero_while_the_integral_is_held(lost):
    controller = PI(100.0, 2000.0, PERIOD)
    controller.step(0.5, 0.1)
    integral = controller.state.integral
    for count in range(1, 4):
        assert controller.step(0.5, lost) == integral
        assert controller.rejected == count
        assert controller.state.integral == integral
        assert controller.state.velocity == 0.1  # the last one that was one
    assert controller.step(0.6, lost, feedforward=7.0) == integral + 7.0
    assert controller.step(0.5, 0.1) == pytest.approx(40.0 + 2.0 * integral)
    assert controller.rejected == 4


def behind_a_delay(controller, delay):
    """Step through a motion behind a drive that holds torques back; return the torques asked for.

    The drive applies the torque of a sample from so many periods later on, for a period; what is reported is the mean.
    """
    realised, torques = None, []
    for k in range(200):
        torques.append(controller.step(math.sin(0.1 * k), math.sin(0.1 * k - 0.2), realised_torque=realised))
        edges = [max(0.0, min(1.0, age - delay)) for age in range(k + 2)]  # how much of a torque has been applied
        shares = [edges[age + 1] - edges[age] for age in range(k + 1)]
        realised = sum(share * torques[k - age] for age, share in enumerate(shares))
    return np.array(torques)


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 1.75, 3.0])
def test_drive_that_gives_later_what_it_was_asked_for_leaves_the_integral_alone(delay):
    expected = behind_a_delay(PI(*GAINS, PERIOD), delay=0.0)
    found = behind_a_delay(PI(*GAINS, PERIOD, delay=delay), delay)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    mistaken = behind_a_delay(PI(*GAINS, PERIOD, delay=delay + 1.0), delay)
    assert np.max(np.abs(mistaken - expected)) > 1.0


@pytest.mark.parametrize("delay", [0.5, 1.0, 4.0])
def test_behind_a_delay_back_calculation_settles_where_the_integral_is_the_torque_given(delay):
    controller = PI(*GAINS, PERIOD, delay=delay)
    for _ in range(2000):
        controller.step(0.5, 0.0, realised_torque=50.0)
    assert controller.state.integral == pytest.approx(50.0, rel=1e-9)


def test_a_torque_that_is_not_finite_is_none_and_the_loop_begins_anew():
    controller = PI(100.0, 2000.0, PERIOD).run_uncompiled()
    controller.step(0.5, 0.1)
    controller.state = controller.state._replace(integral=math.inf)
    output = controller.step_plain(planned_inputs(0.5, 0.1, math.nan, math.nan, PERIOD))
    assert tuple(output) == (0.0, 0.0)
    assert controller.state.integral == 0.0
    assert (controller.faults, controller.rejected, controller.state.samples) == (1, 0, 2)
    assert controller.state.commands == (0.0,)
    assert controller.step(0.5, 0.1) == pytest.approx(40.0 + 20.0 * 0.4)


@pytest.mark.parametrize(("proportional", "share"), [(0.0, 1.0), (0.5, 0.4), (0.1, 1.0)])
@pytest.mark.parametrize("unit", [1.0, 0.02])
def test_share_of_refused_torque_that_leaves_the_integral_is_that_of_the_gains(proportional, share, unit):
    """``dt Ki/Kp`` of a loop in small units too, and all of it where that is above one or without end."""
    controller = PI(unit * proportional, unit * 20.0, PERIOD).run_uncompiled()
    asked = controller.step(0.5, 0.1)
    integral = controller.state.integral
    controller.step(0.1, 0.1, realised_torque=asked - unit * 0.3)
    assert controller.state.integral == pytest.approx(integral - unit * 0.3 * share)


@pytest.mark.parametrize(("integral", "feedforward"), [(1e308, 1e308), (math.inf, -math.inf), (math.inf, 0.0)])
def test_neither_torque_nor_integral_is_infinite(integral, feedforward):
    """A sum beyond all numbers, and infinities that cancel into no number."""
    controller = PI(100.0, 0.0, PERIOD).run_uncompiled()
    state = controller.state._replace(integral=integral, samples=1)
    inputs = planned_inputs(0.5, 0.1, math.nan, math.nan, PERIOD)._replace(feedforward=feedforward)
    output, after = feed_back(controller.parameters, state, inputs, state.guard)
    assert tuple(output) == (0.0, 0.0)
    assert (after.integral, after.guard.faults) == (0.0, state.guard.faults + 1)


def test_a_correction_adds_to_the_plan_and_the_feedforward_is_told_apart():
    controller = PI(100.0, 0.0, PERIOD).run_uncompiled()
    inputs = planned_inputs(0.5, 0.1, math.nan, math.nan, PERIOD)._replace(correction=0.2, feedforward=7.0)
    assert tuple(controller.step_plain(inputs)) == pytest.approx((100.0 * 0.6 + 7.0, 7.0))


def test_torque_of_a_lost_measurement_is_held_two_seconds_and_fades_in_one():
    controller = PI(100.0, 2000.0, PERIOD)
    controller.step(0.5, 0.0)
    held = controller.state.integral
    torques = [controller.step(0.5, math.nan) for _ in range(320)]
    assert torques[:199] == [held] * 199
    assert torques[250] == pytest.approx(held * (1.0 - 0.51), rel=1e-9)
    assert torques[301:] == [0.0] * 19


@pytest.mark.parametrize(
    "wrong",
    [{"velocity": "0.1"}, {"position": "0.5"}, {"realised_torque": []}, {"acting_reference": "soon"}, {"dt": "x"}],
)
def test_step_that_is_refused_changes_nothing(wrong):
    one, twin = (PI(*GAINS, PERIOD, delay=1) for _ in range(2))
    for controller in (one, twin):
        for _ in range(5):
            controller.step(0.1, 0.0)
    given = {"velocity": 0.0, "acting_reference": 0.2, "next_acting_reference": 0.3, **wrong}
    (name,) = wrong
    with pytest.raises(TypeError, match=rf"^{name} = "):
        one.step(0.1, **given)
    assert one.state == twin.state
    assert one.step(0.1, 0.02, next_reference=0.2) == twin.step(0.1, 0.02, next_reference=0.2)


def through(delay, values):
    line, found = delay_line(delay), []
    for value in values:
        found.append(delayed(line, delay))
        line = remember(line, value)
    return found


def both(line, delay, value):
    return delayed(line, delay), remember(line, value)


APPLIED = {0.0: [0.0, 1.0, 2.0, 4.0, 8.0], 0.25: [0.0, 0.75, 1.75, 3.5, 7.0]}
APPLIED |= {1.0: [0.0, 0.0, 1.0, 2.0, 4.0], 2.5: [0.0, 0.0, 0.0, 0.5, 1.5]}
"""Means of 1, 2, 4, 8, 16 by the delay."""


@pytest.mark.parametrize(("delay", "expected"), APPLIED.items())
def test_line_gives_the_mean_of_what_was_applied_over_the_period_that_ends(delay, expected):
    assert through(delay, [1.0, 2.0, 4.0, 8.0, 16.0]) == expected


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0, 3.0])
def test_line_is_long_enough_for_the_delay_and_compiled_it_is_the_same(delay):
    line = tuple(float(i) for i in range(1, 1 + len(delay_line(delay))))
    assert len(line) == {0.0: 1, 0.5: 3, 1.0: 3, 3.0: 11}[delay]
    assert compiled(both)(line, delay, 9.0) == (delayed(line, delay), remember(line, 9.0))
    assert len(remember(line, 9.0)) == len(line)


BANDWIDTH = 10.0
DESIGNED = PI.design(INERTIA, PERIOD, BANDWIDTH)


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
    velocity_loop = PI(DESIGNED.proportional, DESIGNED.integral, PERIOD).run_uncompiled()
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
    proportional, integral = DESIGNED.proportional, DESIGNED.integral * PERIOD
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

"""The sampled loop: its margins, and as python-control systems against the design and the simulated joint."""

import math

import control
import numpy as np
import pytest

from controllers import PI, loop_margins_of, loop_systems
from controllers.design.margins import loop_margins
from controllers.design.sampled_loop import SampledLoop, open_loop
from plant import Joint, JointModel


@pytest.mark.parametrize("delay", [0, 2])
def test_margins_of_given_gains_are_those_of_the_design(delay):
    design = PI.design(inertia=20.0, period=0.01, bandwidth=3.0, delay=delay)
    found = loop_margins_of(design.systems())
    assert found.stable
    assert found.maximum_sensitivity == pytest.approx(design.maximum_sensitivity, rel=2e-3)
    assert found.crossover == pytest.approx(design.crossover, rel=5e-3)
    assert found.phase_margin == pytest.approx(design.phase_margin, abs=0.5)
    assert found.gain_margin == pytest.approx(design.gain_margin, rel=2e-2)


def test_step_response_is_that_of_the_simulated_joint():
    design = PI.design(inertia=20.0, period=0.01, bandwidth=5.0)
    joint = Joint(
        JointModel(inertia=20.0, coulomb=0.0, stiction=0.0, viscous=0.0, stribeck_velocity=1.0, solver_period=0.01)
    )
    controller, velocity, expected = PI(design.proportional, design.integral, 0.01), 0.0, []
    for _ in range(60):
        expected.append(velocity)
        velocity = joint.step(controller.step(1.0, velocity), 0.01)
    response = control.step_response(design.systems().closed_loop, 0.01 * np.arange(60)).outputs
    assert response == pytest.approx(expected, abs=1e-9)


def test_falling_friction_beyond_the_gain_is_unstable_and_viscous_friction_is_not():
    gains = (100.0, 0.0, 20.0, 0.001)
    assert loop_margins_of(loop_systems(*gains, friction_slope=-90.0)).stable
    unstable = loop_margins_of(loop_systems(*gains, friction_slope=-110.0))
    assert (unstable.stable, unstable.maximum_sensitivity) == (False, math.inf)
    systems = loop_systems(*gains, friction_slope=50.0)
    assert systems.plant.dcgain() == pytest.approx(1.0 / 50.0)
    assert (systems.sensitivity + systems.closed_loop).dcgain() == pytest.approx(1.0)


@pytest.mark.parametrize("proportional", [1e-4, 1e-2, 0.4, 1.2])
def test_margins_are_those_at_the_crossover_of_loops_of_any_speed(proportional):
    loop = SampledLoop(proportional, 0.2 * proportional**2, 0)
    found = loop_margins(*open_loop(loop), 1e-2 * min(proportional, 1.0))
    numerator, denominator = (np.polyval(one, np.exp(2j * math.pi * found.crossover)) for one in open_loop(loop))
    assert abs(numerator / denominator) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(math.degrees(np.angle(-numerator / denominator)), abs=1e-6)


NOTCH = 0.35 * np.array([1.0, -1.96 * math.cos(0.5), 0.98**2])


@pytest.mark.parametrize(
    ("loop", "rest"), [(NOTCH, [1.0, -1.0, 0.0, 0.0]), ([-0.05], [1.0, -0.9])], ids=["notch", "negative when slow"]
)
def test_loop_is_stable_up_to_its_gain_margin(loop, rest):
    loop = np.array(loop)
    margin = loop_margins(loop, np.array(rest), 1e-3).gain_margin
    largest_poles = [np.max(np.abs(np.roots(np.polyadd(gain * margin * loop, rest)))) for gain in (0.99, 1.01)]
    assert largest_poles[0] < 1.0 < largest_poles[1]

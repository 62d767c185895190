"""The LuGre feedforward tuned by gradient: its derivatives against differences, and joints that it learns."""

import math

import numpy as np
import pytest

from adaptive_ff.baselines.lugre_gradient import COULOMB, NAMES, STICTION, STIFFNESS, LuGreGradient, bend_in_place

PERIOD = 0.01
GAINS = (1256.0, 15_000.0)
ASSUMED = {"inertia": 20.0, "stribeck_velocity": 0.05, "stiffness": 2e4, "rate": 25.0}
TRUTH = np.array([22.0, 70.0, 4.0, 50.0, 80.0, 3e4])
PLAN = 0.2 * np.sin(math.pi * PERIOD * np.arange(3001)) + 0.1 * np.sin(3.0 * math.pi * PERIOD * np.arange(3001))


def frozen(parameters, **settings):
    """A controller with given parameters that does not learn, in plain Python."""
    controller = LuGreGradient(*GAINS, PERIOD, **ASSUMED, **settings).run_uncompiled()
    controller.state.parameters[:] = parameters
    controller.enabled = False
    return controller


def along(controller, samples, inertia=20.0):
    """Velocities of a mere inertia, whose held torque moves it exactly."""
    velocity, velocities = 0.0, []
    for now, following in zip(PLAN[:samples].tolist(), PLAN[1 : samples + 1].tolist(), strict=True):
        velocities.append(velocity)
        velocity += PERIOD / inertia * controller.step(now, velocity, next_reference=following)
    return np.array(velocities)


@pytest.mark.parametrize("place", range(len(NAMES)), ids=NAMES)
def test_sensitivities_are_what_the_closed_loop_makes_of_a_parameter(place):
    """The loop is linear around the feedforward: differences of its velocities are exact up to rounding."""
    controller, change = frozen(TRUTH), 1e-4 * TRUTH[place]
    along(controller, 150)
    higher, lower = TRUTH.copy(), TRUTH.copy()
    higher[place] += change
    lower[place] -= change
    differences = (along(frozen(higher), 151) - along(frozen(lower), 151)) / (2.0 * change)
    assert controller.state.sensitivities[place] == pytest.approx(differences[-1], rel=1e-5)


def test_bristles_follow_their_equation_and_stop_at_the_level():
    controller = frozen(TRUTH)
    adhesion = math.exp(-0.1 / 0.05)
    level = 50.0 + 30.0 * adhesion
    torque = bend_in_place(controller.parameters, controller.state, -0.1, adhesion)
    assert torque == pytest.approx(-level * (1.0 - math.exp(-3e4 * 1e-3 / level)), rel=1e-12)
    controller.state = controller.state._replace(bristles=torque)
    for _ in range(100):
        torque = bend_in_place(controller.parameters, controller.state, -0.1, adhesion)
        controller.state = controller.state._replace(bristles=torque)
    assert controller.state.bristles == pytest.approx(-level, rel=1e-9)
    assert controller.state.slopes[COULOMB] == pytest.approx(adhesion - 1.0, rel=1e-6)
    assert controller.state.slopes[STICTION] == pytest.approx(-adhesion, rel=1e-6)
    assert abs(controller.state.slopes[STIFFNESS]) < 1e-9

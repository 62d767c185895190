"""Changes of a joint's parameters, gravity, and the lag of a drive, against oracles."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import plant

FRICTION = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
CHANGE = plant.JointChange(dry=1.5, viscous=0.5, inertia=2.0, lag=0.25, load=30.0)


def flat(parameters):
    numbers = []
    for value in parameters:
        numbers.extend(flat(value) if isinstance(value, tuple) else [value])
    return numbers


def test_every_kind_can_be_changed():
    assert plant.CHANGE_JOINT.keys() == plant.SCALE_JOINT.keys() == plant.STEP_JOINT.keys()


LINK = {"link_stiffness": 5e4, "inertia": 25.0}  # 15 + 5 kg m^2 become 15 + 10
LAG, SHORTER = {"friction_lag": 0.02}, {"friction_lag": 0.005}
ELEMENTS = {"displacements": [2e-4, 5e-4, 1e-3, 2e-3]}


@pytest.mark.parametrize(
    ("kind", "before", "after"),
    [
        (plant.JointModel, LAG, SHORTER),
        (plant.LuGreJoint, {"stiffness": 1e5, "damping": 500.0}, {"stiffness": 1.5e5, "damping": 750.0}),
        (plant.ElasticJoint, LAG | {"link_share": 0.25}, SHORTER | {"link_share": 0.4} | LINK),
        (plant.BacklashJoint, {"gap": 0.002, "link_share": 0.25}, {"gap": 0.002, "link_share": 0.4} | LINK),
        (plant.MaxwellJoint, {"attraction": 2e3} | ELEMENTS, {"attraction": 12e3} | ELEMENTS),
        (plant.ElastoPlasticJoint, {"presliding": 1e-3} | LAG, {"presliding": 1e-3} | SHORTER),
    ],
)
def test_changed_joint_is_the_joint_made_with_the_changed_fields(kind, before, after):
    """What bends before it slides goes with the dry friction."""
    stiff = {"link_stiffness": 5e4} if "link_share" in before else {}
    parameters = kind(**FRICTION, offset=7.0, **stiff, **before).parameters
    fields = {"coulomb": 90.0, "stiction": 135.0, "viscous": 40.0, "inertia": 40.0, "offset": 37.0, **after}
    expected = kind(**{**FRICTION, **fields}).parameters
    assert flat(plant.CHANGE_JOINT[type(parameters)](parameters, CHANGE)) == pytest.approx(flat(expected), rel=1e-14)


@pytest.mark.parametrize(("phase", "share"), [(0.0, 1.0), (0.7, 0.5)])
def test_weight_without_friction_swings_as_a_pendulum(phase, share):
    free = {"inertia": 20.0, "coulomb": 0.0, "stiction": 0.0, "viscous": 0.0, "stribeck_velocity": 0.05}
    errors = []
    for period in (1e-3, 5e-4):
        joint = plant.Joint(plant.JointModel(**free, gravity=100.0, gravity_phase=phase, solver_period=period), share)
        velocity = [joint.step(0.0, 0.01) for _ in range(300)]
        exact = solve_ivp(
            lambda _, y: [y[1], -5.0 * math.sin(y[0] + phase)],
            (0.0, 3.0),
            [0.0, share],
            t_eval=0.01 * np.arange(1, 301),
            rtol=1e-10,
            atol=1e-12,
        )
        errors.append(np.max(np.abs(velocity - exact.y[1])))
    assert errors[0] < 5e-3
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.1)  # first order


def test_lagged_torque_is_the_exact_response_of_a_first_order_lag():
    drive = plant.Actuator(lag=0.004).parameters
    mean, end = plant.lagged_torque(drive, 50.0, -10.0, 0.001)
    time = np.linspace(0.0, 0.001, 100_001)
    setup = 50.0 - 60.0 * np.exp(-time / 0.004)
    assert end == pytest.approx(setup[-1], rel=1e-12)
    assert mean == pytest.approx(np.trapezoid(setup, time) / 0.001, rel=1e-9)
    assert plant.lagged_torque(plant.Actuator().parameters, 50.0, -10.0, 0.001) == (50.0, 50.0)

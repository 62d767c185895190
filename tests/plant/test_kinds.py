"""What every kind of joint promises: it serves the same loop, stands in the same tables and is refused alike."""

import itertools
import math
from functools import partial

import numpy as np
import pytest
from pydantic import ValidationError
from stepped_joint import along_paths, run

import plant
from controllers import compiled
from plant.elasto_plastic import mobilised_torque
from plant.lugre import bristle_torque
from plant.maxwell import Element, added_torque

FRICTION = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
UNEVEN = {**FRICTION, "offset": 7.0, "stiction_backward": 70.0}
LINK = {"link_share": 0.5, "link_stiffness": 5e4, "link_damping": 20.0}
MODELS = {
    "stribeck": plant.JointModel(**FRICTION),
    "lagged": plant.JointModel(**UNEVEN, friction_lag=0.02),
    "lugre": plant.LuGreJoint(**UNEVEN, stiffness=1e5),
    "elastic": plant.ElasticJoint(**UNEVEN, **LINK),
    "backlash": plant.BacklashJoint(**FRICTION, **LINK, gap=0.002, hysteresis=10.0, offset=7.0),
    "maxwell": plant.MaxwellJoint(**UNEVEN, displacements=[2e-4, 5e-4, 1e-3, 2e-3], attraction=2e3),
    "rolling": plant.RollingJoint(**UNEVEN, rolling_range=2e-3),
    "elasto_plastic": plant.ElastoPlasticJoint(**UNEVEN, presliding=1e-3, friction_lag=0.02),
}
TORQUES = 150.0 * np.sin(0.01 * np.arange(2000)) + 30.0 * np.sin(0.037 * np.arange(2000))


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]


def test_tables_serve_every_kind(model):
    parameters = model.parameters
    kind, state = type(parameters), plant.initial_state(parameters, 0.1)
    assert plant.INITIAL_STATE[kind](parameters, 0.1) == state
    assert plant.SENSED_VELOCITY[type(state)](state) == 0.1
    assert plant.SCALE_JOINT[kind](parameters, 1.0) == parameters
    doubled = plant.SCALE_JOINT[kind](parameters, 2.0)
    assert doubled.offset == parameters.offset
    for curve, before in ((doubled.friction, parameters.friction), (doubled.backward, parameters.backward)):
        assert plant.sliding_friction(curve, 0.1) == pytest.approx(2.0 * plant.sliding_friction(before, 0.1))
    plant.CHECK_PERIOD[kind](parameters, 0.001)
    with pytest.raises(ValueError, match="solver_period = 1 s is too long for this joint"):
        plant.CHECK_PERIOD[kind](parameters, 1.0)


CARRIED = ("lugre", "maxwell", "rolling")
RIGID = [name for name in MODELS if name not in ("elastic", "backlash")]


@pytest.mark.parametrize("kind", RIGID)
def test_twice_the_friction_on_twice_the_inertia_moves_alike_under_twice_the_torque(kind):
    joint = MODELS[kind].parameters
    twice = plant.SCALE_JOINT[type(joint)](joint, 2.0)._replace(inertia=40.0, offset=2.0 * joint.offset)
    before = run(joint, plant.initial_state(joint, 0.1), TORQUES, 1e-3)
    after = run(twice, plant.initial_state(twice, 0.1), 2.0 * TORQUES, 1e-3)
    before[:, 1] *= 2.0
    apart, least = np.abs(after - before)[:, :3], [1e-15, 1e-12, 1e-15]
    assert np.all(apart <= np.maximum(1e-9 * np.abs(before[:, :3]), least))


@pytest.mark.parametrize("velocity", [0.003, 3.0, -0.05])
@pytest.mark.parametrize("kind", [*CARRIED, "elasto_plastic"])
def test_friction_settles_on_the_stribeck_curve_of_its_direction(kind, velocity):
    model = type(MODELS[kind])(**{**MODELS[kind].model_dump(), "coulomb_backward": 40.0, "viscous_backward": 100.0})
    joint = model.parameters._replace(inertia=1e12)  # nothing changes its velocity
    start = plant.initial_state(joint, 0.0)._replace(velocity=velocity)
    friction = run(joint, start, np.full(6000, joint.offset), 1e-3)[-1, 1]
    curve = joint.friction if velocity > 0.0 else joint.backward
    assert friction == pytest.approx(math.copysign(plant.sliding_friction(curve, abs(velocity)), velocity), rel=1e-6)
    long, step = plant.initial_state(joint, velocity), plant.STEP_JOINT[type(joint)]
    after = step(joint, long, joint.offset + friction, 1e-3)
    assert after.position == pytest.approx(1e-3 * velocity, rel=1e-9)
    assert tuple(after._replace(position=0.0)) == pytest.approx(long, rel=1e-9)


def test_slopes_that_a_speed_is_solved_for_with_are_those_of_differences():
    elastic = type(MODELS["elasto_plastic"])(**{**MODELS["elasto_plastic"].model_dump(), "viscous_backward": 9.0})
    joint, curve = elastic.parameters, elastic.friction
    elements = tuple(Element(0.25, 80.0, 0.02 * slip, load, slip > 0) for slip in (0, 1) for load in (-20.0, 1.0))
    functions = [partial(added_torque, curve, elements)]
    functions += [lambda x, y=bending: bristle_torque(curve, y, 100.0, 300.0, x)[:2] for bending in (-80.0, 20.0)]
    for way, turned, travel in itertools.product((1.0, -1.0), (-0.9, 0.4), (0.0, 5e-4)):
        functions.append(partial(mobilised_torque, joint, way, turned, travel, 1e-3))
    for function, speed in itertools.product(functions, (0.003, 0.04, 0.31, 3.0)):
        (below, _), (above, _) = (function(speed * (1.0 + change)) for change in (-1e-6, 1e-6))
        assert function(speed)[1] == pytest.approx((above - below) / (2e-6 * speed), rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("kind", ["maxwell", "rolling", "elasto_plastic"])
def test_presliding_is_rate_independent(kind):
    flat = {"stiction": 60.0, "stiction_backward": None, "viscous": 0.0, "offset": 0.0}
    flat |= {"friction_lag": 0.0} if kind == "elasto_plastic" else {"attraction": None} if kind == "maxwell" else {}
    joint = type(MODELS[kind])(**{**MODELS[kind].model_dump(), **flat}).parameters
    follow = along_paths(plant.STEP_JOINT[type(joint)], plant.initial_state(joint, 0.0))
    path = 2e-3 * np.sin(np.linspace(0.0, 9.0, 800)) + 5e-4 * np.sin(np.linspace(0.0, 50.0, 800))
    assert follow(joint, path, 1e-1) == pytest.approx(follow(joint, path, 1e-4), rel=1e-9, abs=1e-9)


def test_the_longest_solver_period_is_named_and_accepted(model):
    with pytest.raises(ValidationError, match="solver_period = 1 s is too long for this joint") as caught:
        type(model)(**{**model.model_dump(), "solver_period": 1.0})
    longest = float(str(caught.value).partition("beyond ")[2].split()[0])
    assert type(model)(**{**model.model_dump(), "solver_period": 0.999 * longest}).kind == model.kind
    with pytest.raises(ValidationError, match="is too long"):
        type(model)(**{**model.model_dump(), "solver_period": 1.001 * longest})
    with pytest.raises(ValidationError, match="frozen"):
        model.inertia = 1.0


def test_friction_that_grows_may_need_a_shorter_period(model):
    parameters = model.parameters
    harder = plant.SCALE_JOINT[type(parameters)](parameters, 1e3)
    with pytest.raises(ValueError, match="is too long"):
        plant.CHECK_PERIOD[type(parameters)](harder, model.solver_period)


@pytest.mark.parametrize("shape", [0.7, 1.0, 1.5, 2.0])
def test_compiled_step_is_the_plain_one(model, shape):
    parameters = model.parameters
    curves = {side: getattr(parameters, side)._replace(stribeck_shape=shape) for side in ("friction", "backward")}
    parameters = parameters._replace(**curves)
    plain = plant.STEP_JOINT[type(parameters)]
    step, state = compiled(plain), plant.initial_state(parameters, 0.1)
    for torque in TORQUES[:700:2]:  # to the other side and back
        expected = plain(parameters, state, torque, 0.001)
        state = step(parameters, state, torque, 0.001)
        assert state == pytest.approx(expected, rel=1e-12, abs=1e-13)


def test_torque_that_is_not_a_number_does_not_look_like_rest(model):
    state = plant.initial_state(model.parameters, 0.0)
    assert math.isnan(plant.STEP_JOINT[type(model.parameters)](model.parameters, state, math.nan, 0.001).velocity)

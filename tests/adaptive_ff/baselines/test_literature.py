"""The baselines against their own equations, and on motions and joints that they were made for."""

import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, make, plan_inputs
from scipy.integrate import solve_ivp

from adaptive_ff import TorqueModel, simulate
from adaptive_ff.baselines import CanudasController, CanudasMeasuredController, FrictionObserver
from adaptive_ff.baselines.canudas import INITIAL_COVARIANCE, friction_along
from adaptive_ff.baselines.feedback_learning import FIRST, FeedbackErrorLearning, LearntFeedforward
from adaptive_ff.baselines.friction_observer import PreslidingState, mobilised_fraction, step_presliding
from adaptive_ff.baselines.lee_tomizuka import zero_phase_torque
from adaptive_ff.baselines.lugre_gradient import COULOMB, NAMES, STICTION, STIFFNESS, LuGreGradient, bend_in_place
from adaptive_ff.baselines.lugre_observer import bent
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
from adaptive_ff.scenario.truth import true_model
from controllers import DisturbanceObserver

GAINS = SCENARIO.feedback.gains
PERIOD = 0.01
LEARNT = {"inertia": 20.0, "stribeck_velocity": 0.05}


def plan(seconds):
    """A motion with a period of 2 s, known one sample ahead."""
    time = PERIOD * np.arange(round(seconds / PERIOD) + 1)
    return 0.2 * np.sin(math.pi * time) + 0.1 * np.sin(3.0 * math.pi * time)


def test_elements_are_stop_operators_of_the_planned_way():
    controller = LearntFeedforward(*GAINS, PERIOD, **LEARNT, reaches=[1e-3, 5e-3]).run_uncompiled()
    reference, loads, way = plan(1.5), np.zeros(2), np.array([1e-3, 5e-3])
    for now, following in zip(reference[:-1].tolist(), reference[1:].tolist(), strict=True):
        controller.step(now, now, next_reference=following)
        loads = np.clip(loads + 0.005 * (now + following) / way, -1.0, 1.0)
        assert controller.state.features[FIRST:] == pytest.approx(loads, abs=1e-12)
    assert np.ptp(reference) > 0.3


def test_weights_move_along_the_last_features_as_the_normalised_gradient_says():
    controller = LearntFeedforward(1000.0, 0.0, 0.01, **LEARNT, reaches=[1e-3], rate=5.0).run_uncompiled()
    controller.step(0.1, 0.1, next_reference=0.11)
    before, features = controller.state.weights.copy(), controller.state.features.copy()
    controller.step(0.11, 0.108, next_reference=0.12)
    scale = np.array([20.0, 100.0, 50.0, 50.0])  # inertia, share of the gain, gain times Vs
    step = (1.0 - math.exp(-0.05)) * scale**2 * features * 1000.0 * 0.002 / np.sum((scale * features) ** 2)
    assert controller.state.weights - before == pytest.approx(step, rel=1e-9)
    controller.state = controller.state._replace(enabled=False)
    held = controller.state.weights.copy()
    controller.step(0.12, 0.1, next_reference=0.13)
    assert np.array_equal(controller.state.weights, held)


def test_bristles_of_an_observer_follow_their_differential_equation():
    def slope(t, y):
        return [1e5 * (0.03 + 0.002) - 1e5 * 0.03 / 80.0 * y[0]]

    exact = solve_ivp(slope, (0.0, 0.01), [-30.0], rtol=1e-11, atol=1e-11).y[0, -1]
    assert bent(-30.0, 80.0, 1e5, 0.03, 0.002, 0.01) == pytest.approx(exact, rel=1e-8)
    assert bent(-30.0, 80.0, 1e5, 0.0, 0.002, 0.01) == pytest.approx(-28.0, rel=1e-12)
    assert bent(-30.0, 80.0, 1e9, 0.03, 0.0, 0.01) == pytest.approx(80.0, rel=1e-12)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_inverse_is_that_of_tomizuka_for_a_plan_of_third_order(delay):
    """``J/(2 T^2) (1 - z^-1)^2 (1 + z) q_ref(k+1+d)``, with nothing continued."""

    def position(k):
        time = PERIOD * k
        return 0.3 + 0.2 * time - 0.5 * time**2 + 4.0 * time**3

    def velocity(k):
        time = PERIOD * k
        return 0.2 - time + 12.0 * time**2

    def seconds(k):
        return sum(position(one) - 2.0 * position(one - 1) + position(one - 2) for one in (k + 1, k + 2))

    k = 7
    expected = 20.0 / (2.0 * PERIOD**2) * seconds(k + delay)
    found = zero_phase_torque(20.0, velocity(k - 1), velocity(k), velocity(k + 1), PERIOD, float(delay))
    assert found == pytest.approx(expected, rel=1e-9)
    assert (seconds(k) == seconds(k + delay)) is (delay == 0)


def test_inverse_times_the_joint_has_no_phase_at_low_frequency():
    """Of the joint from held torque to position, behind a delay of two periods."""
    delay, frequency = 2, 1.0
    phase = 2.0 * math.pi * frequency * PERIOD
    shift = np.exp(1j * phase)  # z
    plan = {k: np.exp(1j * phase * k) for k in (-1, 0, 1)}
    torque = zero_phase_torque(20.0, plan[-1], plan[0], plan[1], PERIOD, float(delay))
    velocity = torque * PERIOD / 20.0 / (shift - 1.0) * shift**-delay
    assert velocity == pytest.approx(1.0, abs=0.02)
    assert abs(np.angle(velocity)) < 2e-3


def test_with_the_true_weights_its_feedforward_is_that_of_the_model():
    """Oracle: the model. The lag acts on viscous friction there, which leaves ``sigma tau dw_ref/dt``."""
    setup, model = build_setup(SCENARIO.modified(duration=6.0)), true_model(SCENARIO)._replace(viscous=0.0)
    learning = FeedbackErrorLearning(*GAINS, PERIOD, **LEARNT, lags=[model.friction_lag / 2.0, model.friction_lag])
    learning.state.weights[:3] = model.inertia, model.viscous, 0.0
    learning.state.weights[5:7] = model.coulomb, model.stiction  # of the second lag
    learning.enabled = False
    found, _ = drive(learning, setup)
    state, expected = FeedforwardState(), []
    for reference, following in itertools.pairwise(setup.reference[setup.samples]):
        torque, state = step_feedforward(model, state, plan_inputs(reference, following), PERIOD)
        expected.append(torque)
    assert found.feedforward[: len(expected)] == pytest.approx(expected, abs=1e-9)
    assert np.ptp(found.feedforward) > 100.0


def test_it_converges_to_the_inverse_model_of_a_joint_without_lag_and_the_feedback_torque_vanishes():
    fast = {"sampling": {"period": 0.001}, "sensor": {"velocity_noise": 0.0}}
    scenario = SCENARIO.modified(duration=120.0, joint={"friction_lag": 0.0}, **fast)
    learning = FeedbackErrorLearning(*GAINS, 0.001, **LEARNT, lags=[0.0], rate=0.15 * GAINS[0] / 20.0)
    record, _ = drive(learning, build_setup(scenario))
    joint, found = scenario.joint, learning.estimates
    assert found["inertia"] == pytest.approx(joint.inertia, rel=0.05)
    assert found["coulomb"] == pytest.approx(joint.coulomb, rel=0.03)
    assert found["stiction"] == pytest.approx(joint.stiction, rel=0.03)
    assert found["viscous"] == pytest.approx(joint.viscous, rel=0.1)
    assert found["friction_lag"] == 0.0
    assert abs(found["offset"]) < 1.0
    feedback = record.torque - record.feedforward
    early, late = (np.sqrt(np.mean(feedback[part] ** 2)) for part in (slice(0, 5000), slice(-20_000, None)))
    assert late < 0.05 * early


@pytest.mark.parametrize("wrong", [{"lags": []}, {"lags": [-0.1]}, {"lags": [0.02, 0.01]}], ids=str)
def test_wrong_values_are_refused_by_name(wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} = "):
        FeedbackErrorLearning(*GAINS, PERIOD, **{**LEARNT, **wrong})


TRUTH = np.array([22.0, 70.0, 4.0, 50.0, 80.0, 3e4])
PLAN = plan(30.0)


def frozen(parameters):
    """A controller with given parameters that does not learn, in plain Python."""
    controller = LuGreGradient(*GAINS, PERIOD, **LEARNT, stiffness=2e4, rate=25.0).run_uncompiled()
    controller.state.parameters[:] = parameters
    controller.enabled = False
    return controller


def velocities_along(controller, samples, inertia=20.0):
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
    velocities_along(controller, 150)
    higher, lower = TRUTH.copy(), TRUTH.copy()
    higher[place] += change
    lower[place] -= change
    differences = (velocities_along(frozen(higher), 151) - velocities_along(frozen(lower), 151)) / (2.0 * change)
    assert controller.state.sensitivities[place] == pytest.approx(differences[-1], rel=1e-5)


def test_bristles_of_the_gradient_follow_their_equation_and_stop_at_the_level():
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


TRUE = np.array([17.0, 40.0, 65.0, 90.0, 50.0])
"""Inertia, Coulomb friction forwards and backwards, viscous friction forwards and backwards."""


def discrete_friction(velocity):
    _, forwards, backwards, slope_forwards, slope_backwards = TRUE
    return forwards + slope_forwards * velocity if velocity > 0.0 else -backwards + slope_backwards * velocity


def discrete_joint(steps, seed, noise=0.0):
    """A joint that is the assumed discrete model, under a torque that drives it forth and back; uneven periods."""
    rng = np.random.default_rng(seed)
    durations = PERIOD * rng.uniform(0.7, 1.3, steps)
    velocity, torque = np.zeros(steps + 1), np.zeros(steps)
    velocity[0] = 0.2
    wanted = 0.3 * np.cos(0.04 * np.arange(steps + 1)) + 0.05 * rng.standard_normal(steps + 1)
    for k in range(steps):
        torque[k] = 600.0 * (wanted[k] - velocity[k])
        velocity[k + 1] = velocity[k] + durations[k] / TRUE[0] * (torque[k] - discrete_friction(velocity[k]))
    return velocity + noise * rng.standard_normal(steps + 1), torque, durations


def watch_joint(controller, velocity, torque, durations):
    controller.step(0.0, velocity[0])
    for k in range(torque.size):
        controller.step(0.0, velocity[k + 1], realised_torque=torque[k], dt=durations[k])
    return controller


def estimates_of(controller):
    return np.array(list(controller.estimates.values()))


@pytest.mark.parametrize("controller", [CanudasController, CanudasMeasuredController])
def test_friction_of_each_direction_is_identified_from_the_discrete_model(controller):
    joint = controller(*GAINS, PERIOD, inertia=20.0, dead_zone=0.01, memory=3.0)
    watch_joint(joint, *discrete_joint(4000, seed=1))
    assert estimates_of(joint) == pytest.approx(TRUE, rel=1e-6)


def test_it_is_one_weighted_batch_solution_with_the_fading_prior():
    """Oracle: numpy's least squares on the unscaled equations in the joint's mobility and frictions over inertia."""
    dead_zone, memory, inertia = 0.02, 8.0, 20.0
    velocity, torque, durations = discrete_joint(1500, seed=2, noise=0.002)
    joint = CanudasController(*GAINS, PERIOD, inertia=inertia, dead_zone=dead_zone, memory=memory)
    watch_joint(joint, velocity, torque, durations)
    rows, outputs, ages = [], [], []
    for k in range(torque.size):
        start, end = velocity[k], velocity[k + 1]
        if min(abs(start), abs(end)) < dead_zone or start * end < 0.0:
            continue
        forwards = float(start > 0.0)
        backwards = 1.0 - forwards
        row = [torque[k], -forwards, backwards, -start * forwards, -start * backwards]
        rows.append(durations[k] * np.array(row))
        outputs.append(end - start)
        ages = [*(age + durations[k] for age in ages), 0.0]
    unit = GAINS[0] * dead_zone
    size = np.array([1.0, unit, unit, 0.2 * GAINS[0], 0.2 * GAINS[0]]) / inertia  # of each coefficient
    weights = np.exp(-0.5 * np.array(ages) / memory) * GAINS[0] / unit
    fading = math.exp(-0.5 * ages[0] / memory) / math.sqrt(INITIAL_COVARIANCE)  # not forgotten at the first equation
    prior = fading * np.diag(1.0 / size)
    first = np.array([1.0 / inertia, 0.0, 0.0, 0.0, 0.0])
    matrix = np.vstack([weights[:, np.newaxis] * np.array(rows), prior])
    found = np.linalg.lstsq(matrix, np.append(weights * np.array(outputs), prior @ first), rcond=None)[0]
    expected = np.append(1.0 / found[0], found[1:] / found[0])
    assert estimates_of(joint) == pytest.approx(expected, rel=1e-9)
    assert np.max(np.abs(estimates_of(joint) / TRUE - 1.0)) > 1e-3  # the noise is in both


@pytest.mark.parametrize(
    ("start", "end"), [(0.1, 0.3), (-0.2, -0.1), (0.1, -0.3), (-0.05, 0.2), (0.0, 0.2), (0.0, 0.0)]
)
def test_friction_along_a_period_is_its_mean(start, end):
    moments = (np.arange(20_000) + 0.5) / 20_000
    velocity = start + (end - start) * moments
    expected = np.mean([discrete_friction(value) if value != 0.0 else 0.0 for value in velocity])
    assert friction_along(TRUE, start, end) == pytest.approx(expected, abs=0.02)


MODEL = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
NOTHING = TorqueModel(20.0, 0.0, 0.0, 0.0, 0.0, 0.05, 1.0)
NO_JOINT = {"inertia": -1.0, "coulomb": -1.0, "friction_lag": math.nan, "stribeck_velocity": 0.0, "offset": math.inf}


@pytest.mark.parametrize(("field", "value"), NO_JOINT.items())
def test_model_that_no_joint_has_is_refused_by_name(field, value):
    bad = MODEL._replace(**{field: value})
    with pytest.raises(ValueError, match=rf"^model\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, bad)
    with pytest.raises(ValueError, match=rf"^changes\[0\]\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, MODEL, [(1.0, bad)])
    with pytest.raises(TypeError, match=r"^model = None is not allowed: it must be a TorqueModel"):
        ModelBased(100.0, 1000.0, 0.01, None)


@pytest.mark.parametrize("delay", [0.0, 0.01])
def test_without_friction_in_the_model_it_is_the_disturbance_observer(delay):
    scenario = SCENARIO.modified(duration=12.0, actuator={"delay": delay}, feedback={"bandwidth": 5.0})
    gains = scenario.feedback.gains
    plain = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=4.0, delay=scenario.delay)
    own = ObservedModel(*gains, PERIOD, NOTHING, bandwidth=4.0, delay=scenario.delay)
    expected = simulate(scenario, plain)
    assert np.array_equal(simulate(scenario, own).velocity, expected.velocity)


def test_mobilised_fraction_runs_along_the_curve_from_reversal_to_reversal():
    for z in (0.1, 0.5, 0.9):
        assert mobilised_fraction(2e-3, 1.0, -2e-3 * z) == pytest.approx(1.0 - 2.0 * z * (1.0 - math.log(z)), rel=1e-12)
        assert mobilised_fraction(2e-3, 0.0, 2e-3 * z) == pytest.approx(z * (1.0 - math.log(z)), rel=1e-12)
    assert mobilised_fraction(2e-3, -0.4, 0.0) == -0.4
    assert mobilised_fraction(2e-3, -0.4, 5e-3) == pytest.approx(1.0, rel=1e-15)


def way(time):
    """Planned position; the plan reverses after a second."""
    slow, fast = 1.0 - math.cos(math.pi * time), 1.0 - math.cos(3.0 * math.pi * time)
    return 0.2 / math.pi * slow + 0.1 / (3.0 * math.pi) * fast


def rise(displacement):
    part = min(max(displacement / 0.02, 1e-300), 1.0)
    return part * (1.0 - math.log(part))


def test_friction_solves_the_differential_equation_of_its_lag():
    """On the virgin curve and the branch after a reversal, in periods short enough to take the plan as linear."""
    period, model = 1e-4, MODEL._replace(stiction=60.0, viscous=0.0)

    def target(time):
        if time < 1.0:
            return 60.0 * rise(way(time))
        return 60.0 * (1.0 - 2.0 * rise(way(1.0) - way(time)))

    gains = {"proportional": 1256.0, "integral": 15_000.0, "velocity_gain": 0.3, "disturbance_gain": 100.0}
    block = FrictionObserver(**gains, period=period, model=model, presliding=0.02).parameters
    times, state, found = np.arange(13_001) * period, PreslidingState(0.0, 0.0, 0.0), []
    plan = 0.2 * np.sin(math.pi * times) + 0.1 * np.sin(3.0 * math.pi * times)
    for now, following in itertools.pairwise(plan.tolist()):  # the mean in each period
        friction, state = step_presliding(block, state, now, following)
        found.append(friction)
    end = float(times[-1])
    options = {"rtol": 1e-9, "atol": 1e-9, "max_step": 1e-3, "t_eval": times}
    exact = solve_ivp(lambda t, f: (target(t) - f) / model.friction_lag, (0.0, end), [0.0], **options).y[0]
    assert np.ptp(exact) > 110.0
    assert found == pytest.approx(0.5 * (exact[:-1] + exact[1:]), abs=2e-2)


@pytest.mark.parametrize("name", ["friction_observer", "lee_tomizuka"])
def test_a_disturbance_is_found_wherever_the_state_holds_it(name):
    drive(controller := make(name), build_setup(SCENARIO.modified(duration=3.0)))
    assert abs(controller.disturbance) > 0.1

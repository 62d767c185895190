"""Records of the reference joint: noise-driven, as in Figs 3 to 5, and of the robot of section V; models along them.

Of Figs 3 to 5 the paper says no more than "low-pass filtered band-limited white noise", a fixed-step solver at 1 kHz
and 10 ms. Chosen here: white noise of 100 Hz through a second-order Butterworth low-pass with its corner at 2 Hz, rms
1.5 times the stiction, held for 10 ms; from rest, without measurement noise.

Of the robot it prints a mean sampling time of about 22 ms with periodic outliers up to almost twice that, a multisine
of 0.01 to 1 Hz and velocities of 1 to 20 deg/s. One thing is simpler than there, where a fast loop runs behind the
interface that is read out: here the loop itself runs at the samples, so the torque between them is known.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from adaptive_ff import load_scenario
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.scenario.truth import true_model
from adaptive_ff.simulation.experiment import RunSetup, build_plain_setup, empty_record
from adaptive_ff.simulation.loop import run_controller, start_position
from controllers import PI, Controller, compiled, pi_gains
from plant import JointParameters, JointState, Stribeck, step_joint

Array = NDArray[np.float64]
Steps = NDArray[np.int64]

SCENARIO = load_scenario()  # the reference joint, its multisine and its torque limit; the paper prints no parameters
TRUE = true_model(SCENARIO)
TRUTH_VALUES = np.array(TRUE[: len(ESTIMATED)])  # inertia, Coulomb friction, stiction, viscous coefficient, lag
CURVE = {"stribeck_velocity": TRUE.stribeck_velocity, "stribeck_shape": TRUE.stribeck_shape}  # taken for known
SOLVER_PERIOD = SCENARIO.joint.solver_period  # s
SEED = 1  # seed of what is reported; settings were chosen on seeds from 101 on
MORE_SEEDS = range(1, 21)  # seeds on which it is repeated

PERIOD = 0.01  # s, of Figs 3 to 5
DURATION = 60.0  # s
CORNER = 2.0  # Hz
TORQUE_RMS = 1.5 * TRUE.stiction  # N m

ROBOT_PERIOD = 0.022  # s, what controllers and estimators assume; the mean of the pattern is 22.025 ms
ROBOT_DURATION = 120.0  # s
CYCLE = 40  # samples
REGULAR = 21.0  # ms
OUTLIERS = {9: 31.0, 19: 42.0, 29: 31.0}  # ms, by place in the cycle
TORQUE_CONSTANT = 80.0  # K, N m of joint torque per A of motor current
CURRENT_STEP = 0.025  # A, resolution of the current: 2 N m
LATE = 0.025  # s; a longer sampling time is an outlier
NOISE = 0.002  # rad/s, standard deviation of the velocity reading
BANDWIDTH = 5.0  # Hz, of the PI loop
FORGETTING = 0.85  # lambda of section V-E
GAINS = pi_gains(SCENARIO.feedback.inertia, BANDWIDTH)


class Record(NamedTuple):
    """A run as it is read out, and what was true of it."""

    time: Array  # time, velocity: shape (n,): time of the samples, s, and measured velocity, rad/s
    velocity: Array
    commanded: Array  # shape (n,): torque commanded at the sample and held until the next, N m
    acting: Array  # shape (n,): torque over the period that ends at the sample, N m; zero before the first
    steps: Steps  # shape (n,): solver step of each sample
    true: Array  # true, reference: shape (steps + 1,): velocity and reference on the grid of the solver, rad/s
    reference: Array

    def every(self, period: float) -> "Record":
        """Return an open-loop record sampled with another period, s, that divides the one of the torque."""
        return _sampled(self.commanded[:-1], self.true, period)


def _sampled(torque: Array, true: Array, period: float) -> Record:
    """Return the record of torques (N m) held for 10 ms each, with the velocity on the grid of the solver."""
    steps, held = round(period / SOLVER_PERIOD), np.repeat(torque, round(PERIOD / period))
    places = np.arange(held.size + 1)
    acting, commanded = np.append(0.0, held), np.append(held, held[-1])
    return Record(period * places, true[::steps], commanded, acting, steps * places, true, np.zeros(true.size))


def simulate_noise(seed: int, *, duration: float = DURATION, corner: float = CORNER) -> Record:
    """Simulate the joint for a time (s) under noise through a low-pass with a corner (Hz)."""
    count = round(duration / PERIOD)
    sections = signal.butter(2, corner, fs=1.0 / PERIOD, output="sos")
    noise = signal.sosfilt(sections, np.random.default_rng(seed).standard_normal(count))
    torque = noise * TORQUE_RMS / np.sqrt(np.mean(noise**2))
    still = np.zeros(count * round(PERIOD / SOLVER_PERIOD) + 1)
    return _sampled(torque, predict(TRUE, _sampled(torque, still, SOLVER_PERIOD), one_step=False), PERIOD)


def sample_steps(duration: float, *, uniform: bool = False) -> Steps:
    """Return the solver steps of the robot's samples in a time (s): with outliers, or evenly every 22 ms."""
    pattern = np.full(CYCLE, 1e3 * ROBOT_PERIOD if uniform else REGULAR)  # ms
    if not uniform:
        pattern[list(OUTLIERS)] = list(OUTLIERS.values())
    pattern = np.rint(1e-3 * pattern / SOLVER_PERIOD).astype(np.int64)
    steps = round(duration / SOLVER_PERIOD)
    ends = np.cumsum(np.tile(pattern, steps // int(pattern.sum()) + 1))
    return np.append(0, ends[ends <= steps]).astype(np.int64)


def build_robot_setup(
    seed: int, *, duration: float = ROBOT_DURATION, noise: float = NOISE, uniform: bool = False
) -> RunSetup:
    """Lay down the reference, the noise (rad/s) and the samples of a drive."""
    samples = sample_steps(duration, uniform=uniform)
    reference = _multisine(seed, duration)[: samples[-1] + 1]
    sensed = noise * np.random.default_rng([seed, 1]).standard_normal(samples.size - 1)
    return build_plain_setup(SCENARIO.joint, samples, reference, sensed, SCENARIO.actuator)


@cache
def _multisine(seed: int, duration: float) -> Array:
    time = SOLVER_PERIOD * np.arange(round(duration / SOLVER_PERIOD) + 1)
    return SCENARIO.reference.velocity(time, np.random.default_rng([seed, 0]))


def drive(setup: RunSetup, controller: Controller | None = None, *, current_step: float = CURRENT_STEP) -> Record:
    """Run a controller on the robot, by default the PI loop; the resolution of the current is in A."""
    controller = PI(*GAINS, ROBOT_PERIOD) if controller is None else controller
    run = empty_record(setup, len(controller.estimate_names))
    coarse = setup._replace(actuator=setup.actuator._replace(torque_resolution=TORQUE_CONSTANT * current_step))
    start, count = start_position(coarse), setup.noise.size
    run_controller(controller, coarse, start, count, run)
    steps, acting = setup.samples[:-1], np.append(0.0, run.torque[:-1])
    return Record(SOLVER_PERIOD * steps, run.measured, run.torque, acting, steps, run.velocity, setup.reference)


def predict(models: TorqueModel | Array, record: Record, *, one_step: bool) -> Array:
    """Return the velocity (rad/s) at the samples that a simulated joint has under the torque of a record.

    ``models``: a model, or one after each sample, of which that of the sample before predicts, shape (n, 5): inertia,
    Coulomb friction, stiction, viscous coefficient, friction lag; ``one_step``: whether its velocity is set to the
    measured one at every sample (its friction torque is its own), or runs free.
    """
    rows = np.array([models[: len(ESTIMATED)]]) if isinstance(models, TorqueModel) else np.ascontiguousarray(models)
    velocity = np.array(record.velocity)
    curve = TRUE.stribeck_velocity, TRUE.stribeck_shape
    series = map(np.ascontiguousarray, (record.steps, record.acting, record.velocity))
    run_models(rows, *series, one_step, SOLVER_PERIOD, curve, velocity)
    return velocity


def _run_models(
    models: Array,
    steps: Steps,
    torque: Array,
    measured: Array,
    one_step: bool,
    period: float,
    curve: tuple[float, float],
    velocity: Array,
) -> None:
    state = JointState(measured[0], 0.0, 0.0)
    for k in range(1, steps.size):
        row = models[min(k, models.shape[0]) - 1]
        friction = Stribeck(row[1], max(row[1], row[2]), row[3], curve[0], curve[1])
        for _ in range(steps[k - 1], steps[k]):
            joint = JointParameters(row[0], friction, friction, 0.0, row[4])
            state = step_joint(joint, state, torque[k], period)
        velocity[k] = state.velocity
        if one_step:
            state = JointState(measured[k], state.friction_torque, 0.0)


run_models = compiled(_run_models)

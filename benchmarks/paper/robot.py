"""The robot of section V, in simulation: closed loop, quantised current, sampling with outliers.

The paper prints a mean sampling time of about 22 ms with periodic outliers up to almost twice that, a multisine of 0.01
to 1 Hz and velocities of 1 to 20 deg/s. What it leaves open is chosen here and stands with the constants. One thing
is simpler than on the robot: there a fast loop runs behind the interface that is read out; here the loop itself runs at
the samples, so the torque between them is known.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from adaptive_ff import load_scenario
from adaptive_ff.simulation.experiment import RunSetup, build_plain_setup, empty_record
from adaptive_ff.simulation.loop import run_compiled, start_position
from benchmarks.paper.data import Array, Steps
from controllers import PI, Controller, pi_gains

SCENARIO = load_scenario()  # the reference joint, its multisine and its torque limit
SOLVER_PERIOD = SCENARIO.joint.solver_period  # s
DURATION = 120.0  # s
CYCLE = 40  # samples
REGULAR = 21.0  # ms
OUTLIERS = {9: 31.0, 19: 42.0, 29: 31.0}  # ms, by place in the cycle
PERIOD = 0.022  # s, what controllers and estimators assume; the mean of the pattern is 22.025 ms
TORQUE_CONSTANT = 80.0  # K, N m of joint torque per A of motor current
CURRENT_STEP = 0.025  # A, resolution of the current: 2 N m
LATE = 0.025  # s; a longer sampling time is an outlier
NOISE = 0.002  # rad/s, standard deviation of the velocity reading
BANDWIDTH = 5.0  # Hz, of the PI loop
GAINS = pi_gains(SCENARIO.feedback.inertia, BANDWIDTH)


class Drive(NamedTuple):
    """A record as it is read out, and how well the reference was tracked.

    ``time`` (n,): time of the samples, s; ``reference``, ``velocity`` (n,): reference and measured velocity, rad/s;
    ``commanded`` (n,): torque ``K i`` over the period that begins at the sample, N m; ``acting`` (n,): the one over the
    period that ends there, N m; zero before the first; ``steps`` (n,): solver step of each sample; ``tracking_error``
    (steps + 1,): reference minus true velocity on the solver's grid, rad/s.
    """

    time: Array
    reference: Array
    velocity: Array
    commanded: Array
    acting: Array
    steps: Steps
    tracking_error: Array


def sample_steps(duration: float, *, uniform: bool = False) -> Steps:
    """Return the solver steps of the samples in a time (s): with outliers, or evenly every 22 ms."""
    pattern = np.full(CYCLE, 1e3 * PERIOD if uniform else REGULAR)  # ms
    if not uniform:
        pattern[list(OUTLIERS)] = list(OUTLIERS.values())
    pattern = np.rint(1e-3 * pattern / SOLVER_PERIOD).astype(np.int64)
    steps = round(duration / SOLVER_PERIOD)
    ends = np.cumsum(np.tile(pattern, steps // int(pattern.sum()) + 1))
    return np.append(0, ends[ends <= steps]).astype(np.int64)


def build_robot_setup(
    seed: int, *, duration: float = DURATION, noise: float = NOISE, uniform: bool = False
) -> RunSetup:
    """Lay down the reference, the noise (rad/s) and the samples of a drive."""
    samples = sample_steps(duration, uniform=uniform)
    return build_plain_setup(
        SCENARIO.joint,
        samples,
        _multisine(seed, duration)[: samples[-1] + 1],
        noise * np.random.default_rng([seed, 1]).standard_normal(samples.size - 1),
        SCENARIO.actuator,
    )


@cache
def _multisine(seed: int, duration: float) -> Array:
    time = SOLVER_PERIOD * np.arange(round(duration / SOLVER_PERIOD) + 1)
    return SCENARIO.reference.velocity(time, np.random.default_rng([seed, 0]))


def drive(setup: RunSetup, controller: Controller | None = None, *, current_step: float = CURRENT_STEP) -> Drive:
    """Run a controller on the robot, by default the PI loop; the resolution of the current is in A."""
    controller = PI(*GAINS, PERIOD) if controller is None else controller
    record = empty_record(setup, len(controller.estimate_names))
    coarse = setup._replace(actuator=setup.actuator._replace(torque_resolution=TORQUE_CONSTANT * current_step))
    start, count = start_position(coarse), setup.noise.size
    controller.state, _ = run_compiled(controller.parameters, controller.state, coarse, start, count, record)
    steps = setup.samples[:-1]
    return Drive(
        SOLVER_PERIOD * steps,
        setup.reference[steps],
        record.measured,
        record.torque,
        np.append(0.0, record.torque[:-1]),
        steps,
        setup.reference - record.velocity,
    )

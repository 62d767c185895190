"""Data of Figs 3 to 5, and joints simulated along a record.

The paper says no more than "low-pass filtered band-limited white noise", a fixed-step solver at 1 kHz and 10 ms. Chosen
here: white noise of 100 Hz through a second-order Butterworth low-pass with its corner at 2 Hz, rms 1.5 times the
stiction, held for 10 ms; the reference joint, from rest, without measurement noise.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from controllers import compiled
from plant import JointParameters, JointState, Stribeck, step_joint

Array = NDArray[np.float64]
Steps = NDArray[np.int64]
TRUE = TorqueModel(
    inertia=20.0,
    coulomb=60.0,
    stiction=90.0,
    viscous=80.0,
    friction_lag=0.02,
    stribeck_velocity=0.05,
    stribeck_shape=1.0,
)
"""The reference joint; the paper prints no parameter values."""
SYMBOLS = dict(zip(ESTIMATED, ("J", "Fc", "Fs", "sigma", "tau"), strict=True))
"""The paper's symbols of the identified parameters."""
SOLVER_PERIOD = 0.001  # s
PERIOD = 0.01  # s
DURATION = 60.0  # s
CORNER = 2.0  # Hz
TORQUE_RMS = 1.5 * TRUE.stiction  # N m
SEED = 1  # seed of what is reported; settings were chosen on seeds from 101 on
MORE_SEEDS = range(1, 21)  # seeds on which it is repeated
TRUTH_VALUES = np.array([getattr(TRUE, name) for name in ESTIMATED])
"""True inertia, Coulomb friction, stiction, viscous coefficient and friction lag."""
CURVE = {"stribeck_velocity": TRUE.stribeck_velocity, "stribeck_shape": TRUE.stribeck_shape}
"""What the paper takes for known."""


class Data(NamedTuple):
    """A record of an open-loop run.

    ``time`` (n,): time of the samples, s; ``velocity`` (n,): velocity at the samples, rad/s; ``commanded`` (n,): torque
    commanded at the sample and held until the next, N m; ``acting`` (n,): torque that acted over the period that ends
    at the sample, N m; zero before the first; ``fine_velocity`` (m,): velocity on the grid of the solver, rad/s.
    """

    time: Array
    velocity: Array
    commanded: Array
    acting: Array
    fine_velocity: Array

    def every(self, period: float) -> "Data":
        """Return the record sampled with another period, s, that divides the one of the torque."""
        steps, parts = round(period / SOLVER_PERIOD), round(PERIOD / period)
        held = np.repeat(self.commanded[:-1], parts)
        return Data(
            period * np.arange(held.size + 1),
            self.fine_velocity[::steps],
            np.append(held, held[-1]),
            np.append(0.0, held),
            self.fine_velocity,
        )


def simulate_noise(seed: int, *, duration: float = DURATION, corner: float = CORNER) -> Data:
    """Simulate the joint under filtered noise.

    ``seed``: seed of the noise; ``duration``: duration, s; ``corner``: corner frequency of the low-pass, Hz.
    """
    count = round(duration / PERIOD)
    sections = signal.butter(2, corner, fs=1.0 / PERIOD, output="sos")
    noise = signal.sosfilt(sections, np.random.default_rng(seed).standard_normal(count))
    return simulate_torque(noise * TORQUE_RMS / np.sqrt(np.mean(noise**2)))


def simulate_torque(torque: Array) -> Data:
    """Simulate the joint, from rest, under torques (N m) held for 10 ms each."""
    parts = round(PERIOD / SOLVER_PERIOD)
    held, steps = np.append(0.0, np.repeat(torque, parts)), np.arange(torque.size * parts + 1)
    velocity = predict(as_row(TRUE), steps, held, np.zeros(steps.size), one_step=False)
    commanded = np.append(torque, torque[-1])
    return Data(PERIOD * np.arange(commanded.size), velocity[::parts], commanded, np.append(0.0, torque), velocity)


def deviations(model: TorqueModel) -> dict[str, float]:
    """Return by how much each identified parameter is off the truth, relative."""
    return {name: getattr(model, name) / getattr(TRUE, name) - 1.0 for name in ESTIMATED}


def in_words(model: TorqueModel) -> str:
    """Return the deviations of a model from the truth as a line of text, %."""
    return ", ".join(f"{SYMBOLS[name]} {100.0 * value:+.1f}" for name, value in deviations(model).items())


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def predict(
    models: Array, steps: Steps, torque: Array, measured: Array, *, one_step: bool, period: float = SOLVER_PERIOD
) -> Array:
    """Return the velocity (rad/s) at the samples that a simulated joint has under the torque of a record.

    ``models`` (m, 5): inertia, Coulomb friction, stiction, viscous coefficient, friction lag: one model, or one after
    each sample, of which that of the sample before predicts; ``steps`` (n,): solver step of each sample; ``torque``,
    ``measured`` (n,): torque over the period that ends at the sample, N m, and velocity there, rad/s; ``one_step``:
    whether its velocity is set to the measured one at every sample (its friction torque is its own), or runs free;
    ``period``: solver period, s.
    """
    velocity = np.array(measured)
    series = (np.ascontiguousarray(one) for one in (models, steps, torque, measured))
    run_models(*series, one_step, period, (TRUE.stribeck_velocity, TRUE.stribeck_shape), velocity)
    return velocity


def as_row(model: TorqueModel) -> Array:
    """Return the identified parameters of a model, shape (1, 5)."""
    return np.array([[getattr(model, name) for name in ESTIMATED]])


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

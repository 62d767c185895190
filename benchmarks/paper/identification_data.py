"""Data of Fig. 4: filtered noise drives the joint of Fig. 2; torque and velocity are collected every 10 ms.

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

SEED = 1
"""Seed of what is reported; settings were chosen on seeds from 101 on."""

MORE_SEEDS = range(1, 21)
"""Seeds on which it is repeated."""


class Data(NamedTuple):
    """A record of an open-loop run.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Time of the samples, s.
    velocity : ndarray, shape (n,)
        Velocity at the samples, rad/s.
    commanded : ndarray, shape (n,)
        Torque commanded at the sample and held until the next, N m.
    acting : ndarray, shape (n,)
        Torque that acted over the period that ends at the sample, N m; zero before the first.
    fine_velocity : ndarray, shape (m,)
        Velocity on the grid of the solver, rad/s.
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

    Parameters
    ----------
    seed : int
        Seed of the noise.
    duration : float, optional
        Duration, s.
    corner : float, optional
        Corner frequency of the low-pass, Hz.
    """
    count = round(duration / PERIOD)
    sections = signal.butter(2, corner, fs=1.0 / PERIOD, output="sos")
    noise = signal.sosfilt(sections, np.random.default_rng(seed).standard_normal(count))
    return simulate_torque(noise * TORQUE_RMS / np.sqrt(np.mean(noise**2)))


def simulate_torque(torque: Array, solver_period: float = SOLVER_PERIOD) -> Data:
    """Simulate the joint, from rest, under torques (N m) held for 10 ms each."""
    joint = joint_of(TRUE)
    parts = round(PERIOD / solver_period)
    velocity = np.zeros(torque.size * parts + 1)
    run_held(joint, JointState(0.0, 0.0, 0.0), np.ascontiguousarray(torque), parts, solver_period, velocity)
    commanded = np.append(torque, torque[-1])
    acting = np.append(0.0, torque)
    fine = velocity[:: round(SOLVER_PERIOD / solver_period)]
    return Data(PERIOD * np.arange(commanded.size), velocity[::parts], commanded, acting, fine)


def joint_of(model: TorqueModel) -> JointParameters:
    """Return the simulated joint that a model describes."""
    friction = Stribeck(model.coulomb, model.stiction, model.viscous, model.stribeck_velocity, model.stribeck_shape)
    return JointParameters(model.inertia, friction, friction, 0.0, model.friction_lag)


def deviations(model: TorqueModel) -> dict[str, float]:
    """Return by how much each identified parameter is off the truth, relative."""
    return {name: getattr(model, name) / getattr(TRUE, name) - 1.0 for name in ESTIMATED}


def _run_held(
    joint: JointParameters, state: JointState, torque: Array, parts: int, solver_period: float, velocity: Array
) -> None:
    """Fill in the velocity on the solver's grid under torques held for a number of its steps."""
    velocity[0] = state.velocity
    for k in range(torque.size):
        for i in range(parts):
            state = step_joint(joint, state, torque[k], solver_period)
            velocity[k * parts + i + 1] = state.velocity


run_held = compiled(_run_held)

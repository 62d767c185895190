"""Logs in closed form: a sum of sines as motion, and the torque that the joint's equation gives."""

import numpy as np

from adaptive_ff.files import write_csv
from adaptive_ff.logs.log import Log

JOINT = {"inertia": 2.0, "coulomb": 3.0, "viscous": 4.0, "offset": -0.5}
FREQUENCIES, AMPLITUDES, PHASES = (0.31, 0.83, 1.7), (0.9, 0.7, 0.3), (0.4, 2.0, 5.0)


def motion(time):
    """Position, velocity and acceleration."""
    omega = 2.0 * np.pi * np.array(FREQUENCIES)[:, np.newaxis]
    phase = omega * time + np.array(PHASES)[:, np.newaxis]
    amplitude = np.array(AMPLITUDES)
    return (amplitude @ (-np.cos(phase) / omega), amplitude @ np.sin(phase), amplitude @ (omega * np.cos(phase)))


def make_log(duration=30.0, period=0.002, noise=0.0, seed=101, asymmetry=0.0, as_position=True, **joint):
    """A log of the joint; the noise of the torque is a first-order autoregression with a time constant of 20 ms."""
    values = {**JOINT, **joint}
    time = period * np.arange(round(duration / period))
    position, velocity, acceleration = motion(time)
    torque = values["inertia"] * acceleration + values["viscous"] * velocity + values["offset"]
    torque += values["coulomb"] * np.sign(velocity) + asymmetry * np.abs(velocity)
    if noise:
        torque += coloured(time.size, period, noise, np.random.default_rng(seed))
    if as_position:
        return Log("log", time, torque, position=position)
    return Log("log", time, torque, velocity=velocity)


def sines_log(further, *, seconds=30, rate=500):
    """A log of a joint of 0.5 kg m^2 and 0.5 N m s/rad along three sines, and its largest speed.

    ``further(position, velocity)`` is the torque beside, N m.
    """
    time = np.arange(rate * seconds) / rate
    rates, phases = 2.0 * np.pi * np.array([0.13, 0.37, 0.9]), np.array([0.3, 1.1, 2.0])
    sizes = 2.0 * np.array([0.6, 0.3, 0.1])
    angle = np.outer(time, rates) + phases
    position, velocity = np.sin(angle) @ sizes, np.cos(angle) @ (sizes * rates)
    acceleration = -np.sin(angle) @ (sizes * rates**2)
    torque = 0.5 * acceleration + 0.5 * velocity + further(position, velocity)
    torque += 0.02 * np.random.default_rng(3).standard_normal(time.size)
    return Log("sines", time, torque, position=position), float(np.max(np.abs(velocity)))


def coloured(size, period, deviation, generator, time_constant=0.02):
    from scipy.signal import lfilter

    pole = np.exp(-period / time_constant)
    series = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], generator.standard_normal(size + 500))
    return deviation * series[500:]


def write_log(path, **options):
    """A noisy log as a file of columns of the usual names; returns its path."""
    log = make_log(**{"noise": 0.05, **options})
    write_csv(path, {"time": log.time, "position": log.position, "torque": log.torque})
    return path

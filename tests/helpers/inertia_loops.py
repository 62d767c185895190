"""A pure inertia around a controller, stepped exactly, for tests against closed forms."""

import math

import control
import numpy as np

from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance

INERTIA, PERIOD = 20.0, 0.01
GAINS = (2.0 * math.pi * 5.0 * INERTIA, (2.0 * math.pi * 5.0) ** 2 * INERTIA / 5.0)
NOISE = 0.002


def make_observing(name, bandwidth, *, period=PERIOD, gains=GAINS, inertia=INERTIA):
    """Controller with an observer of a bandwidth in Hz; the integral gain is left out where there is none."""
    if name == "DisturbanceObserver":
        return DisturbanceObserver(*gains, period, inertia=inertia, bandwidth=bandwidth)
    if name == "ExtendedState":
        return ExtendedState(gains[0], period, inertia=inertia, bandwidth=bandwidth)
    walk = KalmanDisturbance.walk(inertia, period, NOISE, bandwidth)
    return make_kalman(walk, period=period, gains=gains, inertia=inertia)


def make_kalman(walk, *, noise=NOISE, period=PERIOD, gains=GAINS, inertia=INERTIA):
    """Loop with a Kalman filter for a walk of the disturbance in N m/sqrt(s)."""
    first, second = KalmanDisturbance.gains(inertia, period, noise, walk)
    return KalmanDisturbance(*gains, period, inertia=inertia, velocity_gain=first, disturbance_gain=second)


OBSERVING = ("DisturbanceObserver", "ExtendedState", "KalmanDisturbance")


def run_inertia(
    controller,
    reference,
    *,
    load=0.0,
    known=0.0,
    disturbance=0.0,
    dt=PERIOD,
    delay=0,
    tell=True,
    preview=True,
    inertia=INERTIA,
    velocity=0.0,
):
    """Velocity (as measured) and estimated disturbance, none without an observer, at each sample.

    ``load`` opposes the torque over the period that begins with a sample, ``known`` is what the controller knows of it;
    ``disturbance`` is added to the measurement. The drive gives a command after ``delay`` periods.
    """
    count = len(reference)
    load, known, disturbance, dt = (np.broadcast_to(series, count) for series in (load, known, disturbance, dt))
    late, realised, before = [0.0] * delay, None, controller.period
    measured, estimates = [], []
    for k in range(count):
        measured.append(velocity + disturbance[k])
        following = reference[k + 1] if preview and k + 1 < count else None
        given = {"realised_torque": realised if tell else None, "feedforward": known[k], "dt": before}
        late.append(controller.step(reference[k], measured[-1], next_reference=following, **given))
        estimates.append(getattr(controller, "disturbance", 0.0))
        realised = late.pop(0)
        velocity += dt[k] / inertia * (realised - load[k])
        before = dt[k]
    return np.array(measured), np.array(estimates)


def z_transform():
    """The variable ``z`` of python-control."""
    return control.tf([1.0, 0.0], [1.0], PERIOD)


def response(system, inputs):
    """Outputs of a python-control system from rest."""
    return control.forced_response(control.minreal(system, tol=1e-7, verbose=False), inputs=np.array(inputs)).outputs

"""Response ``G`` of the measured velocity to torque put into the PI loop around the assumed inertia.

The loop is linear in the torque that is put in beside its own feedback, whatever friction does::

    e = G (needed - fed)

``G`` is simulated, for any number of inputs side by side: ``J dx/dt = u - c`` over the real time between samples,
the velocity filter ``x_m``, and the feedback ``c = Kp x_m + Ki int x_m dt``, both torques as late as the drive is.
Where the measurement is lost the feedback keeps its integral alone.
"""

from typing import NamedTuple

import numpy as np

from controllers import PIParameters
from controllers.arrays import MutableArray

VELOCITY, INTEGRAL, MEASURED = 0, 1, 2
"""Places in the state of a response: velocity (rad/s), integral of the feedback (N m), velocity as it is measured."""


class Response(NamedTuple):
    """Responses to some inputs; arrays are changed in place."""

    states: MutableArray  # shape (n, 3); velocity, integral and measured velocity of each
    torques: MutableArray  # shape (lines, n); torques put in less those of the feedback, N m, the newest first


def initial_response(count: int, delay: float) -> Response:
    """Return the response at rest to so many inputs, of a drive with a delay in periods."""
    lines = int(np.ceil(delay)) + 1
    return Response(np.zeros((count, 3)), np.zeros((lines, count)))


def late(line: MutableArray, place: int, delay: float) -> float:
    """Return the mean over the period that ends of what a line held back."""
    whole = int(delay)
    mean = float(line[whole, place])
    if whole < delay:
        rest = delay - whole
        mean = (1.0 - rest) * mean + rest * line[whole + 1, place]
    return mean


def advance_response(
    response: Response,
    place: int,
    further: float,
    pi: PIParameters,
    inertia: float,
    followed: float,
    duration: float,
    measured: bool,
) -> float:
    """Advance one response over the period that ends; return the velocity as it is measured, rad/s.

    Parameters
    ----------
    response, place : Response, int
        The responses, and which of them.
    further : float
        Torque that was put in beside what the line holds, N m.
    pi, inertia : PIParameters, float
        The loop.
    followed : float
        Share that the velocity filter takes of a new value, ``T/(T + lag)``.
    duration : float
        The period, s.
    measured : bool
        Whether there is a measurement now.
    """
    states, torques = response.states, response.torques
    states[place, VELOCITY] += duration / inertia * (late(torques, place, pi.delay) + further)
    states[place, MEASURED] += followed * (states[place, VELOCITY] - states[place, MEASURED])
    answer = states[place, INTEGRAL]
    if measured:
        answer += pi.integral * duration * states[place, MEASURED]
        states[place, INTEGRAL] = answer
        answer += pi.proportional * states[place, MEASURED]
    for line in range(torques.shape[0] - 1, 0, -1):
        torques[line, place] = torques[line - 1, place]
    torques[0, place] = -answer
    return float(states[place, MEASURED])


def put_in(response: Response, place: int, torque: float, passed: float = 0.0) -> None:
    """Put in a torque (N m) for the coming period, beside the feedback's, whose integral has passed some on."""
    response.states[place, INTEGRAL] += passed
    response.torques[0, place] += torque - passed

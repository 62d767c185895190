"""An open-loop simulation with its sensitivities: errors of position and their derivatives by every parameter.

With ``sgn(w)`` the simulation of :mod:`adaptive_ff.identify.open_loop.simulation` has bends: where the motion almost
stops and goes on, a joint that rests forgets its velocity and one that does not keeps it, and a search for the best
parameters stops there. For the fit the Coulomb friction is ``Fc w/(|w| + W)`` with a small velocity ``W``, by the
implicit Euler method

    (1 + h/J phi sigma) x + h/J phi Fc x/(x + W) = |v + h/J (u - g(q))|,    x = |v'|

which is a quadratic equation, with the force ``g`` between knots, the factor ``phi`` on friction, and ``sigma`` of the
direction of motion. It is differentiated exactly. Only the fit uses it: such a joint creeps where it should rest.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.friction_map import MapParameters, hat_place, limited_factor, map_value
from adaptive_ff.identify.open_loop.simulation import FIRST, OpenLoopModel, Record
from adaptive_ff.logs.derivatives import Array
from controllers import compiled

SMOOTH = 0.0005
"""Velocity ``W``, over the root mean square of that of the log.

The larger it is, the further the fit is from the model that is used: with 0.002, blocks held out came out worse. A fit
that starts with so small a one stops at another bend after a change of 1e-12 of the log; see
:data:`adaptive_ff.identify.open_loop.shrinkage.ROUNDINGS`.
"""


class Fitted(NamedTuple):
    """Parameters of a fit, parts of one row, and room for the derivatives of the motion by them.

    Attributes
    ----------
    parameters : ndarray, shape (n,)
        All of them: those of ``FIRST``, force at the knots, coefficients of the map.
    force, coefficients : ndarray
        The last two.
    of_velocity, of_position : ndarray, shape (n,)
        Derivatives of velocity and position.
    basis : ndarray
        Functions of the map, of each coefficient.
    """

    parameters: Array
    force: Array
    coefficients: Array
    of_velocity: Array
    of_position: Array
    basis: Array


def fitted(parameters: Array, knots: int) -> Fitted:
    """Return parameters of a number of knots with room for a simulation."""
    force, coefficients = parameters[len(FIRST) : len(FIRST) + knots], parameters[len(FIRST) + knots :]
    room = np.zeros(parameters.size), np.zeros(parameters.size), np.zeros(coefficients.size)
    return Fitted(parameters, force, coefficients, *room)


class Training(NamedTuple):
    """What a model is fitted to: simulations of parts of a log.

    Attributes
    ----------
    record : Record
        The log.
    starts : ndarray of int
        Samples that simulations start at.
    length : int
        Samples of each.
    skipped : int
        Samples at the start of each that do not count.
    """

    record: Record
    starts: NDArray[np.int64]
    length: int
    skipped: int


def _basis_in_place(variation: MapParameters, angle: float, out: Array) -> None:
    """Write the functions of a map of the position (rad), in the order of its coefficients."""
    waves = variation.waves.size
    for i in range(waves):
        phase = variation.waves[i] * angle
        out[2 * i], out[2 * i + 1] = math.cos(phase), math.sin(phase)
    if variation.hats > 1:
        for i in range(2 * waves, out.size):
            out[i] = 0.0
        below, share = hat_place(variation, angle)
        out[2 * waves + below], out[2 * waves + below + 1] = 1.0 - share, share


def _map_slope(variation: MapParameters, coefficients: Array, angle: float) -> float:
    """Return the derivative of a map by the position, 1/rad."""
    value = 0.0
    for i in range(variation.waves.size):
        phase = variation.waves[i] * angle
        value += variation.waves[i] * (
            coefficients[2 * i + 1] * math.cos(phase) - coefficients[2 * i] * math.sin(phase)
        )
    if variation.hats > 1 and 0.0 < (angle - variation.lowest) / variation.spacing < variation.hats - 1.0:
        place = 2 * variation.waves.size + hat_place(variation, angle)[0]
        value += (coefficients[place + 1] - coefficients[place]) / variation.spacing
    return value


def _force_at(force: Array, low: float, width: float, position: float) -> tuple[int, float, float, float]:
    """Return the knot below a position, the share of the one above, the force there, and its derivative, N m/rad."""
    if force.size == 1:
        return 0, 0.0, force[0], 0.0
    wanted = (position - low) / width
    place = min(max(wanted, 0.0), force.size - 1.0)
    knot = min(int(place), force.size - 2)
    share, rise = place - knot, force[knot + 1] - force[knot]
    return knot, share, force[knot] + share * rise, rise / width if place == wanted else 0.0


def _follow_with_slopes(
    fit: Fitted,
    low: float,
    width: float,
    variation: MapParameters,
    record: Record,
    starts: NDArray[np.int64],
    length: int,
    skipped: int,
    stride: int,
    smooth: float,
    errors: Array,
    slopes: Array,
) -> int:
    """Write errors and their derivatives of every so many samples of each simulation; return how many were written."""
    parameters = fit.parameters
    inertia, coulomb, viscous, asymmetry = parameters[0], parameters[1], parameters[2], parameters[3]
    of_velocity, of_position, basis, knots = fit.of_velocity, fit.of_position, fit.basis, fit.force.size
    force, coefficients, first = fit.force, fit.coefficients, 4 + knots
    period, row = record.period, 0
    gain = period / inertia
    for run in range(starts.size):
        start = starts[run]
        velocity, position = record.velocity[start], record.position[start]
        of_velocity[:] = 0.0
        of_position[:] = 0.0
        for k in range(1, length):
            knot, share, against, steepness = _force_at(force, low, width, position)
            factor, bend = 1.0, 0.0
            if coefficients.size > 0:
                mapped = map_value(variation, coefficients, position, 0.0)
                factor = limited_factor(1.0, mapped)
                basis[:] = 0.0
                if factor == 1.0 + mapped:
                    bend = _map_slope(variation, coefficients, position)
                    _basis_in_place(variation, position, basis)
            torque = 0.5 * (record.torque[start + k - 1] + record.torque[start + k]) - against
            free = velocity + gain * torque
            direction = 1.0 if free > 0.0 else -1.0
            damping, dry = viscous + direction * asymmetry, gain * factor * coulomb
            slowing = 1.0 + gain * factor * damping
            half = 0.5 * (slowing * smooth + dry - abs(free))
            root = math.sqrt(half * half + slowing * abs(free) * smooth)
            # the form without cancellation
            speed = (root - half) / slowing if half <= 0.0 else abs(free) * smooth / (root + half)
            velocity = direction * speed
            full = velocity / (speed + smooth)
            decay = 1.0 / (slowing + dry * smooth / ((speed + smooth) * (speed + smooth)))
            friction = coulomb * full + damping * velocity
            pushed = decay * gain
            back = pushed * (steepness + bend * friction)
            for i in range(parameters.size):
                of_velocity[i] = decay * of_velocity[i] - back * of_position[i]
            of_velocity[0] -= pushed * (torque - factor * friction) / inertia
            of_velocity[1] -= pushed * factor * full
            of_velocity[2] -= pushed * factor * velocity
            of_velocity[3] -= pushed * factor * direction * velocity
            of_velocity[4 + knot] -= pushed * (1.0 - share)
            if knots > 1:
                of_velocity[5 + knot] -= pushed * share
            for i in range(basis.size):
                of_velocity[first + i] -= pushed * friction * basis[i]
            position += period * velocity
            for i in range(parameters.size):
                of_position[i] += period * of_velocity[i]
            if k >= skipped and k % stride == 0:
                errors[row] = position - record.position[start + k]
                into = slopes[row]
                into[:] = of_position
                row += 1
    return row


follow_with_slopes = compiled(_follow_with_slopes)


def parameters_of(model: OpenLoopModel) -> Array:
    """Return the parameters of a model in one row: those of ``FIRST``, force at the knots, coefficients of the map."""
    return np.concatenate([[getattr(model, name) for name in FIRST], model.force, model.coefficients])


def with_parameters(model: OpenLoopModel, parameters: Array) -> OpenLoopModel:
    """Return a model with other parameters, in the order of :func:`parameters_of`."""
    inertia, coulomb, viscous, asymmetry = (float(value) for value in parameters[:4])
    end = 4 + model.force.size
    force, coefficients = parameters[4:end].copy(), parameters[end:].copy()
    return OpenLoopModel(
        inertia, coulomb, viscous, asymmetry, model.low, model.high, force, model.variation, coefficients
    )


def errors_and_slopes(
    model: OpenLoopModel, training: Training, stride: int, rounding: float = 1.0
) -> tuple[Array, Array]:
    """Simulate from each start, and return errors of position with their derivatives.

    Parameters
    ----------
    model : OpenLoopModel
        The model.
    training : Training
        What is simulated.
    stride : int
        Every so many samples count; the error is an integral, and changes little from one to the next.
    rounding : float, optional
        How far the corner of the Coulomb friction is rounded, over ``SMOOTH``.

    Returns
    -------
    ndarray, shape (n,)
        Simulated minus measured position, rad.
    ndarray, shape (n, parameters)
        Its derivatives, in the order of :func:`parameters_of`.
    """
    parameters, record = parameters_of(model), training.record
    errors = np.empty(training.starts.size * (training.length // stride + 1))
    slopes = np.empty((errors.size, parameters.size))
    width = (model.high - model.low) / max(1, model.force.size - 1)
    place = model.low, width, model.variation
    smooth = rounding * SMOOTH * float(np.sqrt(np.mean(record.velocity**2)))
    first, how = (fitted(parameters, model.force.size), *place, record), (stride, smooth, errors, slopes)
    count = follow_with_slopes(*first, training.starts, training.length, training.skipped, *how)
    return errors[:count], slopes[:count]

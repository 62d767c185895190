"""The torque that a fitted model says, beside the measured one."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.rows.filtering import Conditioned
from adaptive_ff.identify.rows.regressors import Problem, piece_columns
from adaptive_ff.logs.derivatives import Array


class Prediction(NamedTuple):
    """Rows of a piece with what the model says; SI units.

    Attributes
    ----------
    time, velocity : ndarray, shape (n,)
        Time of the log and velocity in the band.
    torque, fitted : ndarray, shape (n,)
        Measured torque in the band, and the model's.
    acceleration : ndarray, shape (n,)
        Acceleration in the band.
    inertia : float
        The model's inertia.
    slides : ndarray of bool, shape (n,)
        Rows that count; at rest friction is whatever torque there is.
    period : float
        Time between rows, s.
    """

    time: Array
    velocity: Array
    torque: Array
    fitted: Array
    acceleration: Array
    inertia: float
    slides: NDArray[np.bool_]
    period: float

    @property
    def friction(self) -> Array:
        """Measured torque without that of inertia."""
        friction: Array = self.torque - self.inertia * self.acceleration
        return friction


class TorqueError(NamedTuple):
    """How well the model says the torque.

    Attributes
    ----------
    relative_error : float
        Norm of the residual over the norm of the torque, both in the band, on rows that slide.
    rms_error : float
        Root mean square of the residual, N m.
    rows : int
        Number of rows.
    duration : float
        Time that they stand for, s.
    """

    relative_error: float
    rms_error: float
    rows: int
    duration: float


def predict(problem: Problem, fitted: Fitted) -> list[Prediction]:
    """Return what a model says on all rows of a problem, which need not be the one it was fitted to."""
    values = np.array([fitted.values[name] for name in fitted.linear])
    made = []
    for piece in problem.pieces:
        matrix = piece_columns(piece, problem.speeds, fitted.linear, fitted.searched)
        made.append(
            Prediction(
                time=piece.time,
                velocity=piece.velocity,
                torque=piece.torque,
                fitted=matrix @ values + piece.torque - piece.moving_torque,
                acceleration=piece.acceleration,
                inertia=fitted.values["inertia"],
                slides=piece.slides,
                period=piece.period,
            )
        )
    return made


def torque_error(predictions: Sequence[Prediction]) -> TorqueError | None:
    """Return how well a model does; None where no row slides."""
    torque = np.concatenate([rows.torque[rows.slides] for rows in predictions]) if predictions else np.empty(0)
    if torque.size == 0:
        return None
    residual = torque - np.concatenate([rows.fitted[rows.slides] for rows in predictions])
    size, whole = float(np.linalg.norm(residual)), float(np.linalg.norm(torque))
    if whole == 0.0:
        return None
    relative = size / whole
    return TorqueError(relative, size / torque.size**0.5, torque.size, torque.size * predictions[0].period)


def rest_torque(problem: Problem, values: Mapping[str, float]) -> float | None:
    """Return the largest torque at rest without offset and gravity, N m; None where the joint does not rest."""
    torques = [np.abs((piece.held - _carried(piece, values))[piece.rests]) for piece in problem.pieces]
    largest = [float(np.max(torque)) for torque in torques if torque.size]
    return max(largest) if largest else None


def _carried(piece: Conditioned, values: Mapping[str, float]) -> Array | float:
    """Return the torque (N m) that carries offset and gravity along a piece, for the values of the terms."""
    torque: Array | float = values.get("offset", 0.0)
    for term, wave in (("gravity_sine", np.sin), ("gravity_cosine", np.cos)):
        if term in values and piece.position is not None:
            torque = torque + values[term] * wave(piece.position)
    return torque

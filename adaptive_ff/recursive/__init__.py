"""Recursive estimators of linear regressions, for one's own: one interface, several ways to forget."""

from adaptive_ff.recursive.exponential_resetting import ExponentialResetting
from adaptive_ff.recursive.instrumental_variable import InstrumentalVariable
from adaptive_ff.recursive.interface import Recursion, RecursiveEstimator
from adaptive_ff.recursive.kalman_random_walk import KalmanRandomWalk
from adaptive_ff.recursive.least_squares import LeastSquares

__all__ = [
    "ExponentialResetting",
    "InstrumentalVariable",
    "KalmanRandomWalk",
    "LeastSquares",
    "Recursion",
    "RecursiveEstimator",
]

from .exponential_resetting import ExponentialResetting as ExponentialResetting
from .instrumental_variable import InstrumentalVariable as InstrumentalVariable
from .kalman_random_walk import KalmanRandomWalk as KalmanRandomWalk
from .least_squares import LeastSquares as LeastSquares
from .recursive_estimator import Recursion as Recursion
from .recursive_estimator import RecursiveEstimator as RecursiveEstimator

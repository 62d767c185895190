import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from inertia_loops import INERTIA, NOISE, PERIOD, make_kalman, make_observing
from scipy.integrate import quad_vec
from scipy.linalg import solve_discrete_are

from controllers import KalmanDisturbance
from controllers.observers.inertia_observer import ObserverState, correct, predict

TRANSITION = np.array([[1.0, -PERIOD / INERTIA], [0.0, 1.0]])
INPUT = np.array([PERIOD / INERTIA, 0.0])
WALKS = [3.0, 60.0, 300.0, 5000.0]

walks = pytest.mark.parametrize("walk", WALKS)


def process_noise(walk):
    """Covariance that a period adds, by quadrature: white noise enters the disturbance, and through it the velocity."""

    def spread(time):
        reached = walk * np.array([-time / INERTIA, 1.0])
        return np.outer(reached, reached)

    return quad_vec(spread, 0.0, PERIOD)[0]


def make_filter(walk):
    controller = make_kalman(walk)
    return controller, np.array([controller.parameters.velocity_gain, -controller.parameters.disturbance_gain])


def filterpy_filter(walk):
    kalman = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
    kalman.F, kalman.B, kalman.Q = TRANSITION, INPUT[:, None], process_noise(walk)
    kalman.H, kalman.R = np.array([[1.0, 0.0]]), np.array([[NOISE**2]])
    kalman.P = np.diag([NOISE**2, (0.1 * walk) ** 2])
    return kalman


@walks
def test_gains_solve_the_riccati_equation_of_scipy(walk):
    measured = np.array([[1.0, 0.0]])
    covariance = solve_discrete_are(TRANSITION.T, measured.T, process_noise(walk), np.array([[NOISE**2]]))
    expected = covariance[:, 0] / (covariance[0, 0] + NOISE**2)
    assert make_filter(walk)[1] == pytest.approx(expected, rel=1e-8)


def test_estimates_are_those_of_settled_filterpy_step_by_step():
    walk = 60.0
    kalman, (controller, _) = filterpy_filter(walk), make_filter(walk)
    for _ in range(4000):
        kalman.predict()
        kalman.update(0.0)
    kalman.x = np.zeros((2, 1))
    generator, realised = np.random.default_rng(8), None
    velocities = 0.1 * np.cumsum(generator.standard_normal(300))
    velocities[0] = 0.0
    for k, velocity in enumerate(velocities):
        if k > 0:
            kalman.predict(u=np.array([[realised]]))
            kalman.update(velocity)
        controller.step(0.1, velocity, realised_torque=realised)
        assert controller.state.observer == pytest.approx(kalman.x[:, 0], rel=1e-8, abs=1e-10)
        realised = 50.0 * generator.standard_normal()
    assert abs(controller.disturbance) > 10.0


def innovations(walk, factor):
    """Innovations of the filter, its gain of the disturbance scaled, on data of the model that it assumes."""
    _, gain = make_filter(walk)
    generator = np.random.default_rng(9)
    steps = generator.multivariate_normal(np.zeros(2), process_noise(walk), size=20_000, method="cholesky")
    state, believed, found = np.zeros(2), ObserverState(0.0, 0.0), []
    for step in steps:
        torque = -1000.0 * believed.velocity + believed.disturbance
        state = TRANSITION @ state + INPUT * torque + step
        believed = predict(INERTIA, believed, torque, PERIOD)
        measured = state[0] + NOISE * generator.standard_normal()
        found.append(measured - believed.velocity)
        believed = correct(believed, measured, gain[0], -factor * gain[1])
    return np.array(found[500:])


def autocorrelation(series, lags):
    return np.array([np.mean(series[lag:] * series[:-lag]) for lag in range(1, lags + 1)]) / np.mean(series**2)


def test_innovation_is_white_and_as_large_as_predicted_on_the_model_it_assumes():
    walk = 60.0
    series = innovations(walk, 1.0)
    bound = 4.0 / math.sqrt(series.size)
    assert np.max(np.abs(autocorrelation(series, 20))) < bound
    covariance = solve_discrete_are(TRANSITION.T, np.array([[1.0], [0.0]]), process_noise(walk), np.array([[NOISE**2]]))
    assert np.var(series) == pytest.approx(covariance[0, 0] + NOISE**2, rel=4.0 * math.sqrt(2.0 / series.size))
    # a gain that is not the right one is seen
    for factor in (0.3, 2.0):
        assert np.max(np.abs(autocorrelation(innovations(walk, factor), 20))) > 2.0 * bound


@pytest.mark.parametrize("bandwidth", [0.1, 0.5])
def test_slow_filter_is_a_butterworth_one_with_the_stated_natural_frequency(bandwidth):
    controller = make_observing("KalmanDisturbance", bandwidth)
    gain = np.array([[controller.parameters.velocity_gain], [-controller.parameters.disturbance_gain]])
    poles = np.linalg.eigvals((np.eye(2) - gain @ np.array([[1.0, 0.0]])) @ TRANSITION)
    found = np.log(poles) / PERIOD
    natural = 2.0 * math.pi * bandwidth
    assert np.abs(found) == pytest.approx([natural, natural], rel=2e-2)
    assert -found.real / np.abs(found) == pytest.approx([math.sqrt(0.5)] * 2, rel=2e-2)


def test_only_the_ratio_of_walk_to_noise_matters_and_its_unit_holds_at_every_period():
    loud = make_kalman(600.0, noise=0.02)
    assert loud.parameters == make_filter(60.0)[0].parameters
    rates = [KalmanDisturbance.walk(INERTIA, period, NOISE * math.sqrt(0.01 / period), 6.0) for period in (0.01, 0.001)]
    assert rates[0] == pytest.approx(rates[1], rel=1e-12)  # the same noise density, the same walk


def test_noises_that_are_too_far_apart_are_refused():
    with pytest.raises(ValueError, match=r"process noise and that of the measurement are too far apart"):
        KalmanDisturbance.gains(1.0, 1.0, velocity_noise=1.0, disturbance_walk=1e24)

"""What is bounded in the adaptive controller whatever it is fed, and how it recovers.

The inputs are adversarial: references, measurements and torques without any relation to a joint.
"""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, error_of, make
from exports import adaptive
from hypothesis import example, given, settings
from hypothesis import strategies as st

from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION_WITH_GRAVITY
from adaptive_ff.learning.kalman import LOOP
from controllers import Inputs
from controllers.arrays import unpacked

LIMIT, FASTEST = 400.0, 0.5

PARTS = st.lists(
    st.tuples(
        st.integers(1, 120),  # samples
        st.floats(-FASTEST, FASTEST),  # reference at the end of the part
        st.sampled_from(["follows", "flipped", "stuck", "noisy", "wild", "lost"]),
        st.sampled_from(["given", "saturated", "flipped", "random", "unknown"]),
        st.sampled_from([0.0, 0.002, 1.0]),
    ),
    min_size=1,
    max_size=12,
)
DOUBLES = st.floats(allow_nan=True, allow_infinity=True)
ANY = st.tuples(*[DOUBLES] * len(Inputs._fields))


def measured_velocity(kind, reference, spread, rng):
    return {
        "follows": reference + spread * rng.standard_normal(),
        "flipped": -reference,
        "stuck": 0.0,
        "noisy": reference * (1.0 + spread * rng.standard_normal()),
        "wild": float(rng.choice([1e12, -1e6, 30.0, -3.0, 0.0, reference])),
        "lost": float(rng.choice([math.nan, math.inf, -math.inf])),
    }[kind]


def drive_torque(kind, command, rng):
    given = min(max(command, -LIMIT), LIMIT)
    return {
        "given": given,
        "saturated": math.copysign(LIMIT, command),
        "flipped": -given,
        "random": float(rng.uniform(-LIMIT, LIMIT)),
        "unknown": None,
    }[kind]


def feed(controller, parts, seed):
    rng, reference, torque = np.random.default_rng(seed), 0.0, 0.0
    for samples, target, velocity, driven, spread in parts:
        for following in np.linspace(reference, target, samples + 1)[1:]:
            measured = measured_velocity(velocity, reference, spread, rng)
            realised = drive_torque(driven, torque, rng)
            torque = controller.step(reference, measured, next_reference=following, realised_torque=realised)
            assert abs(torque) <= LIMIT
            reference = float(following)


def check_estimate(controller):
    """Estimates lie within their bounds, and the covariance is positive semi-definite."""
    prior, estimate = controller.parameters.prior, controller.state.estimate
    values = estimate.mean[LOOP:]
    assert np.all((values >= prior.lowest - 1e-9) & (values <= prior.highest + 1e-9))
    covariance = unpacked(estimate.covariance)
    sizes = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    assert np.linalg.eigvalsh(covariance / np.outer(sizes, sizes))[0] > -1e-7


@pytest.mark.parametrize("parameters", [ESTIMATED, PER_DIRECTION_WITH_GRAVITY], ids=["symmetric", "per direction"])
@pytest.mark.parametrize("period", [0.01, 0.001])
@settings(max_examples=10)
@example(
    [(100, 0.3, "follows", "given", 0.0), (30, 0.2, "wild", "random", 1.0), (100, -0.3, "follows", "given", 0.0)], 0
)
@given(parts=PARTS, seed=st.integers(0, 10**6))
def test_whatever_it_is_fed_estimates_stay_within_bounds_and_covariances_definite(parameters, period, parts, seed):
    given = {"period": period, "torque_limit": LIMIT}
    controller = adaptive(parameters, **given)
    feed(controller, parts, seed)
    check_estimate(controller)
    adaptive(parameters, **given).state_from_json(controller.state_to_json())


@settings(max_examples=20)
@example([(0.0, 1e7, 0.0, 0.0, 0.0, 0.0, 1e8, 0.0, 0.0, 0.0, 0.0)])  # indefinite by rounding without `RESOLVED`
@given(rows=st.lists(ANY, min_size=1, max_size=60))
def test_any_doubles_in_finite_torque_out(rows):
    controller = adaptive(PER_DIRECTION_WITH_GRAVITY, regressors=1, position_hats=3, load_friction=True)
    controller.run_uncompiled()
    for k in range(20):
        controller.step(0.01 * k, 0.01 * k, next_reference=0.01 * (k + 1), position=0.001 * k)
    for row in rows:
        assert math.isfinite(controller.step_plain(Inputs(*row)).torque)
    torques = [controller.step(0.1, 0.1, next_reference=0.1) for _ in range(5)]
    assert all(map(math.isfinite, torques))
    check_estimate(controller)


@pytest.mark.parametrize("value", [math.nan, 1e6, -3.0])
def test_after_a_second_of_nonsense_it_recovers(value):
    setup = build_setup(SCENARIO.modified(duration=30.0))
    noise = setup.noise.copy()
    noise[1000:1100] = value
    found, plain = make("adaptive"), make("pi")
    torn, _ = drive(found, setup._replace(noise=noise))
    alone, _ = drive(plain, setup._replace(noise=noise))
    assert error_of(setup, torn, 10.0) < 0.6 * error_of(setup, alone, 10.0)


def test_hours_without_excitation_neither_wind_up_nor_blow_up():
    controller = adaptive()
    for reference in (0.0, 0.2):
        torques = [abs(controller.step(reference, reference, next_reference=reference)) for _ in range(30_000)]
        assert max(torques[1000:]) <= torques[1000] < 10.0
        check_estimate(controller)

"""The adaptive controller stays bounded, refuses states that cannot be, and learns the same in other units."""

import json
import math
from functools import partial

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, error_of, make
from exports import adaptive
from hypothesis import example, given, settings
from hypothesis import strategies as st

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.state_check import ROUNDING, check_adaptive_state
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION_WITH_GRAVITY
from adaptive_ff.learning.kalman import LOOP
from controllers import Inputs, pi_gains
from controllers.arrays import unpacked
from controllers.plausibility import LARGEST_VELOCITY, MOST_TIME, largest_torque

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
@example([(1, -5e-324, "follows", "given", 0.0), (3, 0.5, "follows", "given", 0.0)], 0)  # a turn in no time
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


def test_a_state_of_an_older_version_is_refused_and_the_version_named():
    controller = make("adaptive", SCENARIO)
    older = json.loads(controller.state_to_json()) | {"version": 2}
    with pytest.raises(ValueError, match=r"^version of the state = 2 is not allowed: it must be 9$"):
        controller.state_from_json(json.dumps(older))


def test_a_new_state_is_restored_by_a_controller_with_every_column():
    columns = {"regressors": 2, "ripple_periods": [0.3], "position_periods": [1.0], "position_hats": 5}
    new, restored = (adaptive(**columns, load_friction=True) for _ in range(2))
    text = new.state_to_json()
    restored.state_from_json(text)
    assert restored.state_to_json() == text


PERIOD = 0.002
INERTIA, COULOMB, STICTION, VISCOUS, STRIBECK_VELOCITY = 0.5, 2.0, 2.5, 0.2, 0.1
PEAK = 1.0  # rad/s


def torques(torque_unit, angle_unit, count=3000):
    """Torques, N m, of a joint with a load of 1.5 N m in a loop whose controller has other units.

    The measurement is lost for 0.3 s now and then, and an outer loop corrects the plan.
    """
    speed_unit = angle_unit  # a second is a second
    inertia = INERTIA * torque_unit / angle_unit
    known = {"stribeck_velocity": STRIBECK_VELOCITY * speed_unit, "torque_limit": 20.0 * torque_unit}
    controller = AdaptiveController(*pi_gains(inertia, 20.0), PERIOD, inertia=inertia, **known)
    noise = np.random.default_rng(1).normal(0.0, 0.002, count)
    times = PERIOD * np.arange(count + 1)
    plan = PEAK * (np.sin(2.0 * times) + 0.4 * np.sin(5.1 * times))
    velocity, error, found = 0.0, 0.0, []
    for k in range(count):
        measured = math.nan if k % 1000 > 850 else (velocity + noise[k]) * speed_unit
        now, following = (float(one) * speed_unit for one in plan[k : k + 2])
        given = {"next_reference": following, "correction": 5.0 * error * speed_unit}
        found.append(controller.step(now, measured, **given) / torque_unit)
        velocity = moved(velocity, found[-1] - 1.5)
        error += PERIOD * (plan[k] - velocity)
    return np.array(found)


def moved(velocity, torque):
    """Velocity after a period, rad/s, by Euler's rule in steps of a quarter."""
    for _ in range(4):
        friction = COULOMB + (STICTION - COULOMB) * math.exp(-abs(velocity) / STRIBECK_VELOCITY)
        net = torque - VISCOUS * velocity
        if velocity == 0.0 and abs(net) <= friction:
            return 0.0
        after = velocity + 0.25 * PERIOD / INERTIA * (net - math.copysign(friction, velocity or net))
        velocity = 0.0 if after * velocity < 0.0 else after
    return velocity


@pytest.fixture(scope="module")
def expected():
    return torques(1.0, 1.0)


@pytest.mark.parametrize(
    ("torque_unit", "angle_unit"),
    [
        pytest.param(2.0**-30, 1.0, id="5e-10 kg m^2"),
        pytest.param(2.0**20, 1.0, id="5e5 kg m^2"),
        pytest.param(1.0, 2.0**10, id="a spindle"),
        pytest.param(1.0, 2.0**-17, id="rates of a telescope"),
    ],
)
def test_a_joint_in_other_units_moves_alike(torque_unit, angle_unit, expected):
    """In units that are powers of two, whose arithmetic is exact but for bounds that stand for rounding."""
    np.testing.assert_allclose(torques(torque_unit, angle_unit), expected, rtol=0.0, atol=1e-3)


LARGEST = largest_torque(*pi_gains(20.0, 10.0))
LIMITS = {
    **dict.fromkeys(("weight", "fed_gain", "observer.gain"), (0.0, 1.0)),
    **dict.fromkeys(("observer.error", "observer.brought", "noise.means"), (0.0, math.inf)),
    **dict.fromkeys(("held", "steady", "sliding", "observer.torque"), (-LARGEST, LARGEST)),
    **dict.fromkeys(("response.states", "response.torques", "psi", "sums"), (-LARGEST, LARGEST)),
    **dict.fromkeys(("filtered", "last_reference"), (-LARGEST_VELOCITY, LARGEST_VELOCITY)),
    **dict.fromkeys(("friction.lagged", "friction.bent"), (-1.0 / ROUNDING, 1.0 / ROUNDING)),
    **dict.fromkeys(("friction.direction", "friction.held"), (-1.0, 1.0)),
    "unit": (5e-324, LARGEST),
    "interval.samples": (0, 3),
    "interval.duration": (0.0, MOST_TIME * 0.001 * 3),
    "estimate.covariance": (-(LARGEST**2), LARGEST**2),
    f"estimate.mean.{LOOP + 1}": (-ROUNDING, LARGEST),
}
"""Least and largest numbers of a state, by their place in it; of an array, in all places or in one."""


def with_number(value, place, number):
    """Return a state with another number in a place."""
    name, _, rest = place.partition(".")
    if isinstance(value, np.ndarray):
        changed = value.copy()
        changed[int(name) if name else ...] = number
        return changed
    return value._replace(**{name: with_number(getattr(value, name), rest, number)}) if name else number


@pytest.mark.parametrize("place", LIMITS)
def test_a_state_may_hold_each_limit_and_nothing_beyond_it(place):
    controller = adaptive(period=0.001)
    check, known = partial(check_adaptive_state, controller.parameters), controller.state
    rule = "no deviation is beyond" if place == "estimate.covariance" else ""
    for limit, way in zip(LIMITS[place], (-np.inf, np.inf), strict=True):
        check(with_number(known, place, limit if math.isfinite(limit) else 0.0))
        with pytest.raises(ValueError, match=rf"^state.*({place.replace('.', '|')}).* not allowed.*{rule}"):
            check(with_number(known, place, np.nextafter(limit, way) if math.isfinite(limit) else math.inf))

"""What every controller has in common whatever the joint; the adaptive one is never worse than PI on drawn ones."""

import math

import numpy as np
import pytest
from closed_loops import LEARNING, NAMES, SAMPLE, SCENARIO, make, sampled
from scenario_files import in_other_units

from adaptive_ff import load_scenario, parse_scenario
from adaptive_ff.comparison.run import simulate
from adaptive_ff.scenario.loop import fall_over_gain
from adaptive_ff.studies.sweep import draw_scenario
from adaptive_ff.studies.tracking import track_scenario
from benchmarks.cases.drawn import draw_cascade, draw_elastic, draw_machine, draw_resting
from benchmarks.cases.situations import named_scenario

SHORT = SCENARIO.modified(duration=10.0, adaptation={"memory": 20.0})
SMOOTH = dict.fromkeys(("coulomb", "stiction", "viscous", "friction_lag"), 0.0)
FRICTIONLESS = SCENARIO.modified(duration=10.0, joint=SMOOTH, sensor={"velocity_noise": 0.0})
"""Nothing to compensate: the inertia is the one that is assumed, and there is no noise to learn from."""

SCALES = {"torque": (4.0, 1.0, 1.0), "time": (1.0, 4.0, 1.0), "angle": (1.0, 1.0, 4.0)}

FADES = "friction that is held at rest fades with a time constant in seconds"
WALKS = "the balance of its observer takes a torque for a torque in a root of a second"
IDENTITY = "its first covariance is a multiple of the identity in SI units, as in the paper"
WEIGHS = "a weight acts along the sine of an angle in rad"
HIDDEN = {
    **{("time", name): FADES for name in ("adaptive", "adaptive_unsupervised", "coulomb_nominal", "fixed", "oracle")},
    **{("time", name): WALKS for name in ("friction_observer", "observed_nominal")},
    **{(unit, "adaptive_paper"): IDENTITY for unit in SCALES},
    **{("angle", name): WEIGHS for name in ("adaptive", "adaptive_unsupervised")},
}
"""Constants with a unit that are known; what no longer has one has to leave this list."""

NOT_PI = {
    "pi": "it has no torque of the inertia",
    "fixed": "its model is given",
    "lugre_observer": "it refuses a joint without friction",
    "lugre_gradient": "its bristles keep the friction that it begins with",
    "adaptive_paper": "without friction and noise its regressors are collinear",
}


def cases(reasons, *units):
    """Parameters of a test: name by unit, the known failures marked, controllers beyond the sample nightly."""
    found = []
    for name in NAMES:
        for unit in units or ("",):
            marks = [] if name in SAMPLE else [pytest.mark.nightly]
            reason = reasons.get((unit, name) if unit else name)
            marks += [pytest.mark.xfail(reason=reason, strict=True)] if reason else []
            found.append(pytest.param(*((name, unit) if unit else (name,)), marks=marks))
    return found


@pytest.mark.parametrize(("name", "unit"), cases(HIDDEN, *SCALES))
def test_torque_is_the_same_in_other_units(name, unit):
    """Of the whole loop: a constant with a hidden unit, in joint, drive, sensor or controller, does not pass.

    With a scale that is a power of two there is no rounding that could be amplified.
    """
    scales = torque, time, angle = SCALES[unit]
    content = {key: value for key, value in SHORT.model_dump(exclude={"sweep"}).items() if value is not None}
    other = parse_scenario(in_other_units(content, scales), "other units")
    expected, found = simulate(SHORT, name), simulate(other, name)
    assert np.ptp(expected.torque) > 100.0
    assert found.torque / torque == pytest.approx(expected.torque, abs=1e-9 * np.ptp(expected.torque))
    assert found.metrics.rms_error * time / angle == pytest.approx(expected.metrics.rms_error, rel=1e-9)


@pytest.mark.parametrize("name", cases(NOT_PI))
def test_without_friction_it_is_pi_with_the_torque_of_the_inertia(name):
    expected, found = simulate(FRICTIONLESS, "pi_inertia"), simulate(FRICTIONLESS, name)
    assert np.ptp(expected.torque) > 10.0
    assert found.torque == pytest.approx(expected.torque, abs=1e-9 * np.ptp(expected.torque))


def test_feedforward_of_a_model_without_anything_is_pi():
    nothing = dict.fromkeys(("inertia", "coulomb", "stiction", "viscous", "friction_lag"), 0.0)
    scenario = SHORT.modified(fixed=nothing)
    assert np.array_equal(simulate(scenario, "fixed").torque, simulate(scenario, "pi").torque)


def torques(controller, inertia):
    """Torques along a motion with reversals that the joint follows late, less the torque of an inertia."""
    found = [0.0]
    for k in range(300):
        now, following = (0.3 * math.sin(0.06 * sample) for sample in (k, k + 1))
        velocity = 0.28 * math.sin(0.06 * k - 0.1) + 0.01 * math.sin(1.7 * k)
        known = -inertia * (following - now) / controller.period
        torque = controller.step(now, velocity, next_reference=following, feedforward=known, realised_torque=found[-1])
        found.append(torque)
    return np.array(found)


KEEP = ("adaptive", "lugre_gradient")
"""What observes a disturbance all the same, and what begins with bristles."""


@pytest.mark.parametrize("name", [name for name in LEARNING if name not in KEEP])
def test_what_has_learnt_nothing_is_pi_with_the_torque_of_the_inertia(name):
    controller = make(name).run_uncompiled()
    controller.enabled = False
    expected = torques(make("pi").run_uncompiled(), 0.0)
    assert np.ptp(expected) > 50.0
    assert torques(controller, SCENARIO.feedback.inertia) == pytest.approx(expected, abs=1e-9)


SEED, DRAWS = 101, 5


def judge(scenario, draws=DRAWS):
    """Return the ratios to PI: ``settled``, ``window``, ``start``, ``after``."""
    return track_scenario(scenario, ["adaptive"], draws=draws)["adaptive"]


def is_never_worse(scenario, draws=DRAWS):
    judged = judge(scenario, draws)
    return judged["settled"] >= 1.0 and judged["window"] <= 1.2


@pytest.mark.parametrize("draw", sampled(range(3), (0, 1)))
def test_on_drawn_joints(draw):
    assert is_never_worse(draw_scenario(load_scenario(), SEED, draw))


@pytest.mark.nightly
@pytest.mark.parametrize("draw", [3, 314, 842])
def test_settled_on_joints_that_hunt(draw):
    """With the identified inertia in the observer, far below the true one, two settled at 0.79 and 0.78."""
    scenario = draw_scenario(load_scenario(), SEED, draw)
    assert fall_over_gain(scenario) > 5.0
    assert judge(scenario)["settled"] >= 0.95


@pytest.mark.parametrize("draw", sampled(range(8), (0, 1)))
@pytest.mark.parametrize("machine", [draw_machine, draw_cascade])
def test_on_machines_of_other_sizes_and_with_a_weight_behind_a_position_loop(machine, draw):
    assert is_never_worse(machine(SEED, draw))


@pytest.mark.parametrize("draw", sampled(range(8), (0, 1)))
@pytest.mark.parametrize("machine", [draw_resting, draw_elastic])
def test_with_rests_of_seconds_or_a_gear_that_nobody_tells_of_it_settles_as_pi_does_or_better(machine, draw):
    assert judge(machine(SEED, draw), draws=1)["settled"] >= 0.95


def test_inertia_of_a_weight_on_bristles_is_not_found_ten_times_too_large():
    assert is_never_worse(draw_cascade(SEED, 137), draws=1)  # settled at 0.82, first 5 s 2.8 times those of PI


def test_where_the_inertia_is_told_twice_too_large():
    told = load_scenario().modified(seed=SEED + 2, duration=20.0, joint={"inertia": 10.0})
    assert is_never_worse(told, draws=1)  # the first 5 s were 3.8 times those of PI: the observer hunted


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("seed", "draw", "settled", "window", "was"),
    [
        (SEED, 279, 1.0, 2.0, "settled at 0.68 by an offset that motion one way had not shown"),
        (201, 450, 1.0, 1.2, "a window at 2.8 by the same"),
        (SEED, 494, 1.5, 1.5, "a window at 3.8 by friction on top of an integral that grew while the joint stuck"),
        (SEED, 513, 1.5, 1.2, "a window at 3.3 by the same"),
        (SEED, 563, 2.0, 1.2, "a window at 4.1 by friction turned where the plan of a late drive only stops"),
    ],
)
def test_on_machines_that_were_worse(seed, draw, settled, window, was):
    """By the median over draws of the noise: a machine that hunts settles anywhere from 0.9 to 3.6."""
    judged = [judge(draw_machine(seed, draw).modified(seed=one), draws=1) for one in range(draw, draw + 9)]
    assert np.median([one["settled"] for one in judged]) >= settled, was
    assert np.median([one["window"] for one in judged]) <= window, was


@pytest.mark.parametrize(
    "name",
    sampled(
        ["payload_half", "gravity_40", "slow_025", "steep_5", "friction_drops", "map_short_hats", "map_no_need_load"],
        ("payload_half", "friction_drops"),
    ),
)
def test_in_situations_outside_its_model_and_with_maps(name):
    assert is_never_worse(named_scenario(name, SEED))

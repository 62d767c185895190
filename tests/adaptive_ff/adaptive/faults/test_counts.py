"""Sensors of few counts: how they are told, and that what the controller makes of them makes no joint worse."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.faults.counts import (
    BEGUN,
    COARSE,
    FEW,
    KICKS,
    KICKS_MORE,
    LOW_PASSED,
    PLAIN,
    TOO_COARSE,
    fine_share,
    first_counts,
    is_counted,
    is_low_passed,
    kicked_share,
    shown_deviation,
    spurious_torque,
)
from adaptive_ff.adaptive.faults.seen_velocity import initial_seen_velocity
from adaptive_ff.adaptive.supervision.noise_level import initial_noise
from benchmarks.cases.other_joints import draw, driven
from controllers import PI

PERIOD, GAIN = 1e-3, 100.0


def counted(finest, changes, fine):
    return initial_seen_velocity()._replace(finest=finest, changes=changes, fine=fine)


@pytest.mark.parametrize(("finest", "share"), [(0.5 * COARSE, 1.0), (1.2, 0.5), (1.01 * TOO_COARSE, 0.0)])
def test_the_observer_is_held_back_by_counts_larger_than_the_plan(finest, share):
    assert fine_share(counted(finest, 20.0, 18.0), 1000, 1.0) == pytest.approx(share)
    assert fine_share(counted(finest, 20.0, 1.0), 1000, 1.0) == 1.0  # values held by a fine sensor
    assert fine_share(counted(finest, 40.0, 20.0), 60, 1.0) == 1.0  # noise of a fine one, of which little is known
    assert fine_share(counted(finest, 900.0, 900.0), 1000, 1.0) == pytest.approx(share)
    exact = counted(finest, 40.0, 20.0)._replace(multiples=40.0)
    assert fine_share(exact, 60, 1.0) == pytest.approx(share)
    assert fine_share(exact._replace(changes=2.0, multiples=2.0), 3, 1.0) == 1.0


def test_few_changes_of_a_sensor_that_stands_still_are_counts():
    assert is_counted(counted(0.1, 30.0, 30.0), 100)
    assert not is_counted(counted(0.1, 30.0, 30.0), 60)  # every second sample brings one: noise of a fine sensor
    assert is_counted(counted(0.1, 30.0, 6.0), 100)
    assert not is_counted(counted(0.1, 30.0, 5.9), 100)


def test_before_the_plan_begins_a_count_is_nothing_to_answer_to():
    assert fine_share(counted(0.1, 1.0, 1.0), 100, 0.0) == 0.0
    assert fine_share(initial_seen_velocity(), 100, 0.0) == 1.0


def coarse_run(controller, seed, duration=30.0, inertia=6.6, count=4.8e-5, period=5e-4):
    """Errors of a joint with little friction and an encoder of one count in several periods, along a multisine."""
    generator, time = np.random.default_rng(seed), np.arange(0.0, duration, period)
    rates, phases = generator.uniform(0.3, 7.0, 6), generator.uniform(0.0, 2.0 * np.pi, 6)
    plan = np.sin(np.outer(time, rates) + phases).sum(axis=1) * np.minimum(1.0, time)
    plan *= 0.09 / np.abs(plan).max()
    velocity = position = 0.0
    last, errors = 0.0, np.empty(time.size - 1)
    for k in range(time.size - 1):
        errors[k] = plan[k] - velocity
        reading = count * round(position / count)
        torque = controller.step(plan[k], (reading - last) / period, next_reference=plan[k + 1])
        last = reading
        free = velocity + period * (torque - 8.5 * velocity) / inertia
        velocity = math.copysign(max(0.0, abs(free) - period * 0.8 / inertia), free)
        position += period * velocity
    first = round(5.0 / period)
    return math.sqrt(np.mean(errors[:first] ** 2)), math.sqrt(np.mean(errors[errors.size // 2 :] ** 2))


@pytest.mark.parametrize("seed", [103, 104, 105])
def test_an_encoder_too_coarse_for_its_plan_makes_no_joint_worse_than_its_loop_alone(seed):
    """The first 5 s had 2 to 3.4 times the error of PI: what the observer made of a count went into the integral."""
    design = PI.design(inertia=6.6, period=5e-4, bandwidth=12.8)
    gains = design.proportional, design.integral, 5e-4
    alone = coarse_run(PI(*gains), seed)
    with_it = coarse_run(AdaptiveController(*gains, inertia=6.6, stribeck_velocity=0.02), seed)
    assert with_it[0] < 1.2 * alone[0]
    assert with_it[1] < alone[1] / 0.95


def kicked(deviation, friction, *, seen=None, known=True, peak=1.0):
    noise = initial_noise()._replace(measured=2.0 if known else 0.1, variance=0.0, least=deviation**2)
    noise = noise._replace(variance=deviation**2, usual=deviation**2) if known else noise
    return kicked_share(seen or initial_seen_velocity(), 1000, noise, GAIN, friction, peak, PERIOD)


@pytest.mark.parametrize(("part", "share"), [(0.9, 0.0), (1.5, 0.5), (2.1, 1.0)])
def test_noise_that_is_small_beside_the_plan_kicks_nothing(part, share):
    assert kicked(part * PLAIN, 1e-3) == pytest.approx(share)
    behind = initial_seen_velocity()._replace(decays=FEW)
    assert kicked(part * LOW_PASSED, 1e-3, seen=behind) == pytest.approx(share)
    assert kicked(part * PLAIN, 1e-3, peak=10.0) == 0.0


@pytest.mark.parametrize(("part", "share"), [(0.9 * KICKS, 0.0), (KICKS + 0.5 * KICKS_MORE, 0.5), (1.0, 1.0)])
def test_kicks_count_beside_the_friction(part, share):
    assert kicked(1.0, GAIN / part) == pytest.approx(share)


def test_before_the_noise_is_known_only_counts_that_are_told_kick():
    assert kicked(1.0, 1.0, known=False) == 0.0
    assert kicked(1.0, 1.0, known=False, seen=counted(0.5, 20.0, 18.0)) == 1.0
    assert kicked(1.0, 1.0, known=False, seen=initial_seen_velocity()._replace(decays=FEW)) == 1.0
    assert kicked(1.0, 1.0, known=False, seen=initial_seen_velocity()._replace(decays=FEW - 1.0, changes=900.0)) == 0.0


def test_falls_that_are_alike_by_chance_are_no_low_pass():
    assert is_low_passed(initial_seen_velocity()._replace(decays=FEW, changes=300.0))
    assert not is_low_passed(initial_seen_velocity()._replace(decays=16.0, changes=4000.0))
    assert not is_low_passed(initial_seen_velocity()._replace(decays=FEW - 1.0, changes=10.0))


def test_behind_a_low_pass_the_mean_of_the_noise_tells_of_kicks_not_that_of_slow_motion():
    noise = initial_noise()._replace(measured=2.0, variance=0.01, least=0.04, usual=0.09)
    low_passed = initial_seen_velocity()._replace(decays=FEW)
    assert shown_deviation(low_passed, noise) == pytest.approx(0.3)
    assert shown_deviation(initial_seen_velocity(), noise) == pytest.approx(0.1)
    assert shown_deviation(low_passed, noise._replace(measured=0.1)) == pytest.approx(0.2)


def test_the_first_changes_of_a_sensor_that_has_stood_still_may_be_counts():
    assert first_counts(counted(0.5, BEGUN - 1.0, 1.0), 1000, 2.0, 1.0)
    assert not first_counts(counted(0.5, BEGUN - 1.0, 1.0), 1000, 0.9, 1.0)  # it has stuck, and breaks away
    assert not first_counts(counted(0.5, BEGUN, 1.0), 1000, 2.0, 1.0)
    assert not first_counts(counted(0.5, 1.0, 1.0), 2, 2.0, 1.0)
    assert not first_counts(initial_seen_velocity(), 1000, 2.0, 1.0)
    assert not is_counted(initial_seen_velocity(), 1000)


def test_of_what_is_observed_no_more_than_the_friction_goes_into_the_integral():
    assert spurious_torque(5.0, 4.0, 1.0, 0.0, 2.0) == 0.0
    assert spurious_torque(5.0, 4.0, 0.25, 0.0, 2.0) == pytest.approx(0.75)
    assert spurious_torque(5.0, 4.0, 1.0, 1.0, 2.0) == pytest.approx(3.0)
    assert spurious_torque(-5.0, -4.0, 1.0, 0.5, 2.0) == pytest.approx(-1.5)
    assert spurious_torque(-5.0, -4.0, 0.0, 0.25, 2.0) == pytest.approx(-1.5)


def test_what_a_count_takes_from_the_observed_torque_is_as_little_the_integrals_as_what_it_adds():
    """Where it fell to much less and kicks were many times the friction, the integral took its fall for a rise."""
    for observed in (1.0, -1.0):
        taken = observed - spurious_torque(observed, 4.0, 0.0, 1.0, 2.0)
        assert taken == pytest.approx(2.0)
    assert -1.0 - spurious_torque(-1.0, 4.0, 0.0, 0.0, 2.0) == pytest.approx(4.0)


@pytest.mark.parametrize("counts", [0.1, 0.3])
@pytest.mark.parametrize(("seed", "sensor"), [(619, "encoder"), (640, "encoder"), (631, "low-passed encoder")])
def test_a_count_in_several_periods_leaves_no_window_that_is_worse_than_the_loop_alone(seed, sensor, counts):
    """With a tenth of a count the first 5 s had 3.5, 1.1 and 2.7 times the error of PI."""
    joint, loop, plan = draw(seed)
    resolution = float(np.abs(plan).max()) * loop.period / counts
    figures = driven(joint, loop._replace(sensor=sensor, resolution=resolution), plan, seed, ["adaptive"])["adaptive"]
    assert figures["window"] < 1.2


def test_kicks_that_become_rare_where_a_joint_is_slow_are_not_forgotten():
    """The friction that was learnt from them was fed forward, and windows had up to 4.4 times the error of PI."""
    joint, loop, plan = draw(637)
    resolution = float(np.abs(plan).max()) * loop.period / 0.1
    coarse = loop._replace(sensor="low-passed encoder", resolution=resolution)
    figures = driven(joint, coarse, plan, 637, ["adaptive"])["adaptive"]
    assert figures["settled"] > 0.8  # 0.41 before
    assert figures["window"] < 2.0


def test_kicks_are_said():
    joint, loop, plan = draw(619)
    count = float(np.abs(plan).max()) * loop.period / 0.1
    design = PI.design(inertia=joint.inertia, period=loop.period, bandwidth=loop.bandwidth)
    gains = design.proportional, design.integral, loop.period
    controller = AdaptiveController(*gains, inertia=joint.inertia, stribeck_velocity=0.02)
    position = reading = 0.0
    for reference in plan[:1000]:
        position += loop.period * reference
        last, reading = reading, count * round(position / count)
        controller.step(reference, (reading - last) / loop.period)
    said = " ".join(controller.diagnose().supervision)
    assert "such kicks shake a joint free of it" in said
    assert "all of the observed torque is fed back" not in said

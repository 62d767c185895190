"""Velocities that no motion makes: what is believed, and that the controller is no worse than PI with such a sensor."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from closed_loops import SCENARIO, begin, course_along, make, own_loop

from adaptive_ff.adaptive.faults.seen_velocity import (
    LIGHTER,
    LONGEST,
    OFTEN,
    ROUGHLY,
    advance_seen_velocity,
    initial_seen_velocity,
    seen_inputs,
)
from adaptive_ff.adaptive.supervision.noise_level import initial_noise
from controllers import Inputs
from tests.helpers.judged import judge

PERIOD, GAIN, INERTIA, LARGEST, SPEED, NOISE = 0.01, 1000.0, 20.0, 100.0, 0.4, 0.002
KNOWN = initial_noise()._replace(measured=10.0, variance=NOISE**2)
BLOCK = SimpleNamespace(
    feedback=SimpleNamespace(proportional=GAIN, delay=0.0),
    observer=SimpleNamespace(inertia=INERTIA),
    estimator=SimpleNamespace(form=SimpleNamespace(stribeck_velocity=0.05)),
)
BELIEVED = 3.0 * LARGEST * PERIOD / INERTIA + 8.0 * NOISE
"""Change of the velocity in a period that is believed without any torque."""


def inputs(velocity, torque=0.0, plan=0.2):
    return Inputs(plan, velocity, math.nan, 0.0, math.nan, torque, 0.0, math.nan, PERIOD, math.nan, math.nan)


def seen(velocities, torques=None, plans=None, noise=KNOWN):
    """What is remembered after each of some velocities."""
    torques = np.zeros(len(velocities)) if torques is None else torques
    plans = np.full(len(velocities), 0.2) if plans is None else plans
    state = SimpleNamespace(
        feedback=SimpleNamespace(commands=(0.0,)),
        seen=initial_seen_velocity()._replace(last=velocities[0], believed=velocities[0]),
        observer=SimpleNamespace(noise=noise),
        estimator=SimpleNamespace(
            levels=SimpleNamespace(torque=LARGEST, speed=SPEED), recursion=SimpleNamespace(estimate=[INERTIA])
        ),
        doubt=SimpleNamespace(speed=SPEED),
    )
    states = []
    for velocity, torque, plan in zip(velocities[1:], torques[1:], plans[1:], strict=True):
        state.seen = advance_seen_velocity(BLOCK, state, inputs(velocity, torque, plan))
        states.append(state.seen)
    return states


@pytest.mark.parametrize(("share", "missing"), [(0.99, False), (1.01, True)])
def test_a_velocity_further_than_the_largest_torque_takes_it_is_not_believed(share, missing):
    for sign in (-1.0, 1.0):
        (state,) = seen([0.1, 0.1 + sign * share * BELIEVED])
        assert (state.missing, state.leaps) == (missing, int(missing))


@pytest.mark.parametrize("inertia", [INERTIA, INERTIA / LIGHTER])
def test_what_the_torque_of_the_drive_explains_is_believed_in_its_direction(inertia):
    change = 400.0 * PERIOD / inertia
    (with_it,) = seen([0.1, 0.1 + change + 0.9 * BELIEVED], [0.0, 400.0])
    (against,) = seen([0.1, 0.1 - change - 0.9 * BELIEVED], [0.0, 400.0])
    assert not with_it.missing
    assert against.missing


def test_after_a_leap_the_joint_is_found_again_where_it_was():
    first, second, third = seen([0.1, 3.0, 0.11, 0.12])
    assert [first.missing, second.missing, third.missing] == [True, False, False]
    assert (second.believed, second.gap, third.believed) == (0.11, 0.0, 0.12)


def test_a_glitch_of_a_position_is_two_leaps():
    assert [state.missing for state in seen([0.1, 3.1, -2.9, 0.1])] == [True, True, False]


def test_what_stays_is_believed():
    states = seen([0.1, 3.0, 0.1 - 3.0, 3.2, -2.8, 3.4])
    assert [state.missing for state in states] == [True] * LONGEST + [False, True]
    assert [state.missing for state in seen([0.1, 3.0, 3.01, 3.02])] == [True, False, False]


def test_over_a_gap_the_joint_may_have_moved_further():
    lost = [0.1, *[math.nan] * 9, 0.1 + 5.0 * BELIEVED]
    assert [state.gap for state in seen(lost)[-2:]] == pytest.approx([9 * PERIOD, 0.0])
    assert not seen(lost)[-1].missing
    assert seen([0.1, 0.1 + 5.0 * BELIEVED])[-1].missing


def test_before_anything_is_known_of_the_noise_nothing_leaps():
    assert not seen([0.1, 30.0], noise=initial_noise())[-1].missing
    rough = initial_noise()._replace(measured=1.1 * ROUGHLY, mean=NOISE**2)
    assert seen([0.1, 30.0], noise=rough)[-1].missing


def test_a_value_that_a_fine_sensor_repeats_is_held():
    noisy = 0.2 + NOISE * np.random.default_rng(101).standard_normal(200)
    assert not any(state.missing for state in seen(noisy))
    again = seen([*noisy, noisy[-1], noisy[-1], 0.2])
    assert [state.missing for state in again[-3:]] == [True, True, False]
    assert again[-2].leaps == 0


def test_a_value_that_an_encoder_repeats_is_not_held_unless_the_plan_moves_on():
    count = 0.003
    counted = count * np.round((0.2 + NOISE * np.random.default_rng(101).standard_normal(400)) / count)
    assert np.any(np.diff(counted) == 0.0)
    assert not any(state.missing for state in seen(counted))
    values, plans = [*counted, *[counted[-1]] * 5], [*[0.2] * 400, 0.205, 0.21, 0.215, 0.22, 0.225]
    assert [state.missing for state in seen(values, plans=plans)[-5:]] == [False, False, True, True, True]


def test_velocities_made_of_positions_repeat_but_for_rounding():
    """Such a difference was the least change of the sensor, and whatever came twice was held."""
    count, period, start = 6e-6, 0.002, 3.0
    moved = np.cumsum([20 + (k // 4) % 3 for k in range(200)])
    velocities = np.diff(start + count * moved) / period
    changes = np.abs(np.diff(velocities))
    rounded = (changes > 0.0) & (changes < 1e-9)
    assert rounded.sum() > 50
    states = seen(velocities)
    assert not any(state.missing for state in states)
    assert states[-1].finest == pytest.approx(count / period, rel=1e-6)
    assert states[-1].changes == (~rounded & (changes > 0.0)).sum()


def test_changes_of_an_encoder_are_whole_multiples_of_a_count_and_those_of_a_tachometer_are_not():
    random = np.random.default_rng(101)
    counts = seen(0.7 * np.concatenate([[2, 0, 1], random.integers(-3, 4, 60)]))[-1]
    assert counts.finest == pytest.approx(0.7)
    assert counts.multiples == counts.changes > 30.0
    noise = seen(0.7 * random.standard_normal(60))[-1]
    assert noise.multiples < 0.2 * noise.changes


def test_a_joint_that_stands_is_believed():
    assert not any(state.missing for state in seen([*np.linspace(0.3, 0.0, 100), *[0.0] * 50]))


def test_the_estimator_leaves_out_what_is_missing_unless_that_is_usual():
    state = seen([0.1, 3.0])[0]
    assert math.isnan(seen_inputs(state, inputs(3.0)).velocity)
    assert seen_inputs(state._replace(share=1.01 * OFTEN), inputs(3.0)).velocity == 3.0
    assert seen_inputs(state._replace(missing=False), inputs(3.0)).velocity == 3.0


@pytest.mark.parametrize(
    "sensor",
    [
        {"leap": 3.0, "leap_share": 0.001},
        {"leap": 1.0, "leap_share": 0.01},
        {"held": 10, "held_share": 0.002},
        {"held": 2, "held_share": 0.1},
    ],
    ids=["leaps", "many leaps", "held for 0.1 s", "often held"],
)
@pytest.mark.parametrize("seed", [101, 102])
def test_a_sensor_with_faults_never_makes_a_joint_worse_than_its_loop_alone(sensor, seed):
    judged = judge(SCENARIO.modified(seed=seed, sensor=sensor), "adaptive", draws=2)
    assert judged.settled > 1.05
    assert judged.worst_window < 1.2


@pytest.mark.parametrize(
    ("field", "value"), [("share", 1.5), ("gap", -1.0), ("leaps", -1), ("finest", -1.0), ("multiples", -1.0)]
)
def test_a_state_that_cannot_be_is_refused_when_it_is_restored(field, value):
    controller = make("adaptive")
    saved = json.loads(controller.state_to_json())
    saved["state"]["seen"][field] = value
    with pytest.raises(ValueError, match="seen"):
        controller.state_from_json(json.dumps(saved))


def test_leaps_are_told_of():
    controller = make("adaptive")
    course = course_along(0.3 * np.sin(0.02 * np.arange(3001)), noise=0.002)
    own_loop(controller, course, lost={k: 3.0 for k in range(1500, 3000, 300)})
    assert begin(course).sample == 0
    told = [warning for warning in controller.diagnose().warnings if "leapt" in warning]
    assert len(told) == 1
    assert told[0].startswith("5 measured velocities leapt")

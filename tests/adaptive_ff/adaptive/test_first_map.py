"""A first map of friction over position: what a controller begins with, what it is worth, how it is unlearnt."""

import copy
import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController, JointGroup, TorqueModel, load_scenario
from adaptive_ff.adaptive.learning.friction_map import map_value
from adaptive_ff.comparison.run import simulate
from controllers import pi_gains

GAINS = pi_gains(20.0, 10.0)
TRUE = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
PERIOD = {"position_periods": [0.3]}
HATS = {"position_hats": 5, "position_range": [0.0, 4.0]}


def make(model=TRUE, **options):
    options = {"deviation": 0.05, **options} if model is not None else options
    return AdaptiveController(*GAINS, 0.01, inertia=20.0, stribeck_velocity=0.05, model=model, **options)


def error(amplitude, seed, seconds, part=slice(None), **options):
    """Rms error of a joint whose friction varies by a share over 0.3 rad, rad/s."""
    varied = {"position_amplitude": amplitude, "position_period": 0.3} if amplitude else {}
    scenario = load_scenario().modified(duration=seconds, seed=seed, variation=varied)
    run = simulate(scenario, make(**options), uncertain=False)
    return float(np.sqrt(np.mean((run.reference - run.velocity)[part] ** 2)))


def test_first_seconds_are_better_with_a_map_that_is_right():
    for seed in (1, 2, 3):
        plain, learnt = error(0.3, seed, 5.0), error(0.3, seed, 5.0, **PERIOD)
        carried = error(0.3, seed, 5.0, **PERIOD, position_map=[0.0, 0.3], map_deviation=0.02)
        assert carried < 0.75 * plain
        assert carried < 0.75 * learnt


def test_a_map_that_is_wrong_is_unlearnt():
    for seed in (1, 2, 3):
        late = slice(-2000, None)
        plain = error(0.0, seed, 40.0, late)
        assert error(0.0, seed, 40.0, late, **PERIOD, position_map=[0.0, 0.3], map_deviation=0.02) < 1.15 * plain
        turned = error(0.3, seed, 40.0, late, **PERIOD, position_map=[0.0, -0.3], map_deviation=0.02)
        assert turned < error(0.3, seed, 40.0, late)


def test_a_map_as_vague_as_it_is_large_is_not_fed():
    shares = [
        make(**PERIOD, position_map=[0.0, 0.3], map_deviation=each).learnt_map.share for each in (0.05, 0.16, 0.3)
    ]
    assert shares[0] == 1.0
    assert 0.0 < shares[1] < 1.0
    assert shares[2] == 0.0
    assert make(**PERIOD, position_map=[0.0, 0.0]).learnt_map.share == 0.0


@pytest.mark.parametrize(
    ("asked", "coefficients"), [(PERIOD, [0.2, -0.1]), (HATS, [0.3, -0.3, 0.1, 0.2, -0.3])], ids=["period", "hats"]
)
def test_the_controller_begins_with_the_map_after_a_reset_too(asked, coefficients):
    controller = make(**asked, position_map=coefficients)
    begun = controller.state_to_json()
    curve = controller.learnt_map
    mapped = controller.parameters.estimator.friction_map
    truth = [1.0 + map_value(mapped, np.array(coefficients), place, 0.0) for place in curve.position]
    assert curve.factor == pytest.approx(np.array(truth) / np.mean(truth))
    for k in range(300):
        controller.step(0.3 * math.sin(0.02 * k), 0.29 * math.sin(0.02 * k), position=0.3 * math.sin(0.01 * k))
    assert controller.state_to_json() != begun
    twin = make(**asked)  # of the same kind, but for what it begins with
    twin.state_from_json(controller.state_to_json())
    assert twin.state_to_json() == controller.state_to_json()
    copied = copy.deepcopy(controller)
    for one in (controller, copied):
        one.reset()
        assert one.state_to_json() == begun


def test_how_sure_the_map_is_says_how_soon_it_is_corrected():
    def after(deviation):
        controller = make(**HATS, position_map=[0.4, 0.4, -0.4, -0.4, 0.0], map_deviation=deviation)
        return controller.state.estimator.friction_map.information

    vague, sure = after(0.2), after(0.05)
    assert sure == pytest.approx(16.0 * vague)
    assert after([0.05, 0.05, 0.05, 0.05, math.inf]).tolist() == [*sure[:4], 0.0]
    assert after(1e-9) == pytest.approx(25.0 * sure)  # surer than a hundredth is none


def test_beside_the_load_the_map_keeps_its_order_and_the_load_is_learnt_anew():
    state = make(**PERIOD, load_friction=True, position_map=[0.2, -0.1]).state.estimator.friction_map
    assert state.coefficients.tolist() == [0.0, 0.2, -0.1]
    assert state.information[0] == 0.0


def test_without_a_position_nothing_is_fed():
    plain, mapped = make(**PERIOD), make(**PERIOD, position_map=[0.05, 0.3])
    torques = []
    for k in range(300):
        plan = [0.3 * math.sin(0.02 * k), 0.3 * math.sin(0.02 * k - 0.02)]
        torques.append([one.step(*plan) for one in (plain, mapped)])
    torques = np.array(torques)
    assert np.max(np.abs(torques[:, 1] - torques[:, 0])) < 1e-4 * np.max(np.abs(torques))


def test_a_group_takes_the_map_from_its_table():
    joint = {"proportional": GAINS[0], "integral": GAINS[1], "inertia": 20.0, "stribeck_velocity": 0.05}
    joint |= {"model": TRUE._asdict(), **PERIOD, "position_map": [0.0, 0.3], "map_deviation": [0.02, 0.03]}
    group = JointGroup.from_table({"period": 0.01, "joints": {"one": joint}})
    assert group.joints["one"].learnt_map.share == 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"position_map": [0.1]}, "^position_map is not allowed without position_periods or position_hats"),
        (
            {**PERIOD, "model": None, "position_map": [0.1, 0.1]},
            "^position_map is not allowed without a model that has",
        ),
        ({**PERIOD, "model": TRUE._replace(coulomb=0.0), "position_map": [0.1, 0.1]}, "^position_map is not allowed"),
        ({**PERIOD, "position_map": [0.1]}, r"^position_map has shape \(1,\); it must be \(2,\): cosine and sine"),
        ({**HATS, "position_map": [0.1, 0.2]}, r"^position_map has shape \(2,\); it must be \(5,\)"),
        (
            {**PERIOD, "position_map": [0.1, math.nan]},
            r"^position_map\[1\] = nan is not allowed: it must be from -2 to 2",
        ),
        ({**PERIOD, "position_map": [2.5, 0.0]}, r"^position_map\[0\] = 2.5 is not allowed"),
        ({**PERIOD, "position_map": "ab"}, "^position_map = 'ab' is not allowed: it must be 2 numbers"),
        ({**PERIOD, "position_map": [0.1, 0.1], "map_deviation": -0.1}, "^map_deviation = -0.1 is not allowed"),
        (
            {**PERIOD, "position_map": [0.1, 0.1], "map_deviation": [0.1, -1]},
            r"^map_deviation\[1\] = -1 is not allowed",
        ),
        ({**PERIOD, "position_map": [0.1, 0.1], "map_deviation": "much"}, "^map_deviation = "),
        ({**PERIOD, "position_map": [0.1, 0.1], "map_deviation": [0.1]}, r"^map_deviation has shape \(1,\)"),
        ({"map_deviation": -0.1}, "^map_deviation = -0.1 is not allowed"),
        ({"map_deviation": "much"}, "^map_deviation = "),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(options, message):
    with pytest.raises(ValueError, match=message) as raised:
        make(**options)
    assert "\n" not in str(raised.value)


def test_a_wave_of_unknown_size_does_not_keep_the_others_from_being_fed():
    one = make(position_periods=[0.3], position_map=[0.0, 0.3], map_deviation=0.02)
    two = make(
        position_periods=[0.3, 0.5], position_map=[0.0, 0.3, 0.0, 0.0], map_deviation=[0.02, 0.02, math.inf, math.inf]
    )
    assert two.learnt_map.share == one.learnt_map.share == 1.0


def test_a_map_that_is_exact_is_taken_for_one_of_a_hundredth():
    exact, sure = (make(**PERIOD, position_map=[0.0, 0.3], map_deviation=each) for each in (0.0, 0.01))
    assert exact.state_to_json() == sure.state_to_json()


def test_a_map_that_says_nothing_waits_as_without_one():
    nothing, without = make(**PERIOD, position_map=[0.0, 0.0]), make(**PERIOD)
    assert nothing.state.estimator.friction_map.seen == without.state.estimator.friction_map.seen == 0.0

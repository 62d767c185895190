"""Further known regressors of a group against single controllers given the same, and refusals that change nothing."""

import math

import numpy as np
import pytest

from adaptive_ff import WITH_GRAVITY, AdaptiveController, JointGroup
from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR, MOST_REGRESSORS
from controllers import pi_gains

PERIOD, SAMPLES = 0.01, 300
JOINT = dict(zip(("proportional", "integral"), pi_gains(2.0, 10.0), strict=True))
JOINT |= {"inertia": 2.0, "stribeck_velocity": 0.05}
NAMES = ("shoulder", "elbow", "wrist")


def controllers(counts):
    return {
        name: AdaptiveController(**JOINT, period=PERIOD, parameters=WITH_GRAVITY, regressors=count)
        for name, count in zip(NAMES, counts, strict=False)
    }


def chain(count, **first):
    """Table of a chain of joints, each behind all that come before it."""
    names = [f"joint_{place}" for place in range(count)]
    joints = {name: {**JOINT, "preceding": names[:place]} for place, name in enumerate(names)}
    joints[names[0]] |= first
    return {"period": PERIOD, "joints": joints}


def signals(joints):
    """Made-up motion and load: plan, measured velocity, position, further regressors (two, the last joint one)."""
    time = PERIOD * np.arange(SAMPLES + 1)[:, None]
    plan = np.sin(time * [1.7, 2.9, 3.7] + [0.3, 1.1, 2.0])[:, :joints] * 0.3
    noise = 0.002 * np.random.default_rng(101).standard_normal((SAMPLES, joints))
    position = np.cumsum(plan[:-1], axis=0) * PERIOD
    further = [[np.sin([0.7 * k, 1.3 * k]) for _ in range(joints - 1)] + [[math.cos(0.9 * k)]] for k in time[:-1, 0]]
    return plan, 0.95 * plan[:-1] + noise, position, further


def test_group_with_regressors_is_its_joints_alone_to_the_bit():
    group, alone = JointGroup(controllers((2, 2, 1))), controllers((2, 2, 1))
    plan, measured, position, further = signals(3)
    for k in range(SAMPLES):
        now = {"next_reference": plan[k + 1], "position": position[k], "realised_torque": 3.0 * measured[k]}
        torques = group.step(plan[k], measured[k], regressors=further[k], **now)
        for place, one in enumerate(alone.values()):
            row = {name: values[place] for name, values in now.items()}
            assert one.step(plan[k, place], measured[k, place], regressors=further[k][place], **row) == torques[place]
    for name, one in alone.items():
        assert group.joints[name].state_to_json() == one.state_to_json()
    assert group.estimates["elbow"]["regressor_2"] != 0.0


def test_given_regressors_follow_those_of_the_chain_to_the_bit():
    group = JointGroup(controllers((6, 4, 1)), {"elbow": ["shoulder"], "wrist": ["shoulder", "elbow"]})
    alone = tuple(controllers((6, 4, 1)).values())
    plan, measured, position, further = signals(3)
    for k in range(SAMPLES):
        torques = group.step(plan[k], measured[k], position=position[k], regressors=further[k])
        angles = np.array([np.sum(position[k, : place + 1]) for place in range(3)])
        for place, one in enumerate(alone):
            formed = [part for angle in angles[place + 1 :] for part in (np.sin(angle), np.cos(angle))]
            given = {"position": angles[place], "regressors": [*formed, *further[k][place]]}
            assert one.step(plan[k, place], measured[k, place], **given) == torques[place]


def test_takeover_with_regressors_is_that_of_the_joints_alone():
    group, alone = JointGroup(controllers((2, 1))), controllers((2, 1))
    plan, measured, _, further = signals(2)
    for k in range(100):
        group.step(plan[k], measured[k], regressors=further[k])
        for place, one in enumerate(alone.values()):
            one.step(plan[k, place], measured[k, place], regressors=further[k][place])
    torque, arguments = [7.0, -2.0], (plan[100], measured[100])
    group.take_over(torque, *arguments, regressors=further[100])
    np.testing.assert_allclose(group.step(*arguments, regressors=further[100]), torque, atol=1e-9)
    for place, one in enumerate(alone.values()):
        single = (plan[100, place], measured[100, place])
        one.take_over(torque[place], *single, regressors=further[100][place])
        one.step(*single, regressors=further[100][place])
    for name, one in alone.items():
        assert group.joints[name].state_to_json() == one.state_to_json()


def test_regressors_may_be_an_array_and_hold_where_they_are_not_given():
    group = JointGroup(controllers((2, 2)))
    group.step([0.1, 0.1], [0.1, 0.1], regressors=np.array([[0.1, 0.2], [0.3, 0.4]]))
    group.step([0.1, 0.1], [0.1, 0.1], regressors=[None, [0.5, math.nan]])
    group.step([0.1, 0.1], [0.1, 0.1])
    held = [joint.state.psi[-4:-2].tolist() for joint in group.joints.values()]
    assert held == [[0.1, 0.2], [0.5, 0.4]]


def saved_and_loaded(controller, new):
    new.state_from_json(controller.state_to_json())
    return new


@pytest.mark.parametrize("lost", [math.nan, math.inf, None])
@pytest.mark.parametrize("before", [0, 60])
def test_a_chain_goes_on_from_its_save_after_a_lost_position(lost, before):
    group = JointGroup.from_table(chain(3))
    plan, measured, position, _ = signals(3)
    for k in range(before):
        group.step(plan[k], measured[k], position=position[k])
    for k in range(before, before + 3):
        torn = None if lost is None else np.where([False, True, False], lost, position[k])
        group.step(plan[k], measured[k], position=torn)
        other = saved_and_loaded(group, JointGroup.from_table(chain(3)))
    for k in range(before + 3, 120):
        now = position[k] if k % 10 else None
        torques = group.step(plan[k], measured[k], position=now)
        assert np.array_equal(other.step(plan[k], measured[k], position=now), torques)
    assert other.state_to_json() == group.state_to_json()


@pytest.mark.parametrize("unknown", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("before", [0, 60])
def test_group_and_single_controller_go_on_from_their_save_after_an_unknown_regressor(unknown, before):
    group, (one, *_) = JointGroup(controllers((2, 1))), controllers((2,)).values()
    plan, measured, _, further = signals(2)
    for k in range(before):
        group.step(plan[k], measured[k], regressors=further[k])
        one.step(plan[k, 0], measured[k, 0], regressors=further[k][0])
    held = further[before - 1][0][0] if before else 0.0
    torn = [unknown, 0.25]
    group.step(plan[before], measured[before], regressors=[torn, [unknown]])
    one.step(plan[before, 0], measured[before, 0], regressors=torn)
    assert one.regressors.tolist() == group.joints["shoulder"].regressors.tolist() == [held, 0.25]
    group_again = saved_and_loaded(group, JointGroup(controllers((2, 1))))
    one_again = saved_and_loaded(one, *controllers((2,)).values())
    for k in range(before + 1, 120):
        given = further[k] if k % 10 == 0 else None
        torques = group.step(plan[k], measured[k], regressors=given)
        assert np.array_equal(group_again.step(plan[k], measured[k], regressors=given), torques)
        single = {"regressors": None if given is None else given[0]}
        torque = one.step(plan[k, 0], measured[k, 0], **single)
        assert one_again.step(plan[k, 0], measured[k, 0], **single) == torque == torques[0]
    assert one_again.state_to_json() == one.state_to_json()


@pytest.mark.parametrize("size", [1e7, -1e100, 1e308])
def test_far_too_large_regressors_are_refused_and_change_nothing(size):
    group, (one, *_) = JointGroup(controllers((2, 1))), controllers((2,)).values()
    before = group.state_to_json(), one.state_to_json()
    message = r"-?1e\+\d+ is not allowed: they should be of the size of one, from -1e\+06 to 1e\+06 at most$"
    with pytest.raises(ValueError, match=f"^regressors of elbow = {message}"):
        group.step([0.1, 0.1], [0.1, 0.1], regressors=[[0.1, 0.2], [size]])
    with pytest.raises(ValueError, match=f"^regressors = {message}"):
        one.step(0.1, 0.1, regressors=[0.1, size])
    assert (group.state_to_json(), one.state_to_json()) == before


def test_from_the_largest_regressors_a_save_can_be_loaded():
    group, size = JointGroup(controllers((2, 1))), LARGEST_REGRESSOR
    plan, measured, _, _ = signals(2)
    for k in range(100):
        group.step(plan[k], measured[k], regressors=[[size, -size], [size]], realised_torque=[1.0, 2.0])
    saved_and_loaded(group, JointGroup(controllers((2, 1))))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([[0.1], [0.2]], r"^regressors of shoulder has shape \(1,\); it must be \(3,\), .* beside the 2 that"),
        ([[0.1, 0.2, 0.3], [0.2, 0.3]], r"^regressors of elbow has shape \(2,\); it must be \(1,\), as it was made"),
        ([[0.1, 0.2, 0.3], 0.2], r"^regressors of elbow has shape \(\); it must be \(1,\)"),
        ([[0.1, 0.2, 0.3], ["x"]], r"^regressors of elbow = \['x'\] is not allowed: it must be a vector of 1"),
        ([[0.1, 0.2, 0.3]], r"^regressors = .* is not allowed: it must be a vector, or None, for each of the 2 joints"),
        (0.1, r"^regressors = 0.1 is not allowed: it must be a vector"),
    ],
)
def test_wrong_regressors_are_refused_and_change_nothing(given, message):
    group = JointGroup(controllers((5, 1)), {"elbow": ["shoulder"]})
    group.step([0.1, 0.2], [0.1, 0.2], position=[0.1, 0.2], regressors=[[0.1, 0.2, 0.3], [0.4]])
    before = group.state_to_json()
    for refused in (
        lambda: group.step([0.1, 0.2], [0.1, 0.2], position=[0.3, 0.4], regressors=given),
        lambda: group.take_over([1.0, 1.0], [0.1, 0.2], [0.1, 0.2], position=[0.3, 0.4], regressors=given),
    ):
        with pytest.raises(ValueError, match=message):
            refused()
        assert group.state_to_json() == before


@pytest.mark.parametrize("name", ["reference", "correction", "feedforward", "inertia"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_command_that_is_not_finite_is_refused_by_name_and_no_joint_is_touched(name, value):
    group, other = (JointGroup.from_table(chain(3)) for _ in range(2))
    plan, measured, position, _ = signals(3)
    wrong = np.array([1.0, value, 1.0])
    for k in range(100):
        given = {"reference": plan[k], "velocity": measured[k], "position": position[k]}
        assert np.array_equal(group.step(**given), other.step(**given))
        if k % 25 == 24:
            refused = {**given, "position": position[k + 1], name: wrong}
            before = group.state_to_json()
            with pytest.raises(ValueError, match=f"^{name} of joint_1 = {value} is not allowed: it must be "):
                group.step(**refused)
            with pytest.raises(ValueError, match=f"^{name} of joint_1 = {value} is not allowed: it must be "):
                group.take_over([1.0, 2.0, 3.0], **refused)
            assert group.state_to_json() == before == other.state_to_json()


@pytest.mark.parametrize("name", ["velocity", "next_reference", "realised_torque", "position"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_measurement_that_is_not_finite_concerns_its_joint_alone(name, value):
    whole, torn = JointGroup(controllers((0, 0, 0))), JointGroup(controllers((0, 0, 0)))
    plan, measured, position, _ = signals(3)
    for k in range(SAMPLES):
        given = {"reference": plan[k], "velocity": measured[k], "next_reference": plan[k + 1]}
        given |= {"position": position[k], "realised_torque": 3.0 * measured[k]}
        lost = {**given, name: np.where([False, k >= 150, False], value, given[name])}
        torques, hurt = whole.step(**given), torn.step(**lost)
        assert np.array_equal(hurt[[0, 2]], torques[[0, 2]])
        assert np.all(np.isfinite(hurt))
    for joint in ("shoulder", "wrist"):
        assert torn.joints[joint].state_to_json() == whole.joints[joint].state_to_json()


def test_a_takeover_that_one_joint_refuses_prepares_none():
    joints = controllers((2, 2))
    joints["elbow"] = AdaptiveController(**{**JOINT, "integral": 0.0}, period=PERIOD, regressors=2)
    group = JointGroup(joints)
    plan, measured, _, _ = signals(2)
    for k in range(50):
        group.step(plan[k], measured[k], regressors=[[0.1, 0.2], [0.3, 0.4]])
    before = group.state_to_json()
    with pytest.raises(ValueError, match=r"^elbow: integral = 0 is not allowed for a takeover"):
        group.take_over([1.0, 1.0], plan[50], measured[50], regressors=[[0.5, 0.6], [0.7, 0.8]])
    with pytest.raises(ValueError, match=r"^velocity of elbow = nan is not allowed"):
        group.take_over([1.0, 1.0], plan[50], [0.1, math.nan])
    assert group.state_to_json() == before


def test_a_chain_of_eleven_is_taken_and_one_of_twelve_refused_with_a_way_out():
    group = JointGroup.from_table(chain(11))
    assert [joint.regressors.size for joint in group.joints.values()] == list(range(MOST_REGRESSORS, -1, -2))
    assert np.all(np.isfinite(group.step(np.full(11, 0.1), np.zeros(11), position=np.zeros(11))))
    message = r"^joint_0\.regressors = 22 is not allowed: .* 11 joints .* 0 given .* 20, .* leave preceding"
    with pytest.raises(ValueError, match=message):
        JointGroup.from_table(chain(12))
    with pytest.raises(ValueError, match=r"^joint_0\.regressors = 21 is not allowed: .* 10 joints .* and 1 given"):
        JointGroup.from_table(chain(11, regressors=1))
    joints = {f"joint_{place}": next(iter(controllers((0,)).values())) for place in range(12)}
    with pytest.raises(ValueError, match=r"^joint_0\.regressors = 22 is not allowed"):
        JointGroup(joints, {name: list(joints)[:place] for place, name in enumerate(joints)})


def test_a_table_counts_the_given_regressors_beside_those_of_the_chain():
    group = JointGroup.from_table(chain(2, regressors=3))
    assert [joint.regressors.size for joint in group.joints.values()] == [5, 0]
    with pytest.raises(ValueError, match=r"^joint_0: regressors = -1 is not allowed"):
        JointGroup.from_table(chain(2, regressors=-1))
    with pytest.raises(ValueError, match=r"^shoulder has regressors = 1; it must be 2 at least"):
        JointGroup(controllers((1, 0)), {"elbow": ["shoulder"]})

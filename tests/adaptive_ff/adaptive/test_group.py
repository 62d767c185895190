"""A group of joints against its joints one by one, what one joint must not do to another, and refusals."""

import copy
import json
import math
from unittest.mock import patch

import numpy as np
import pytest

from adaptive_ff import WITH_GRAVITY, AdaptiveController, JointGroup
from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR, MOST_REGRESSORS
from adaptive_ff.adaptive.extensions.joints import joints_of_table
from adaptive_ff.adaptive.prior import wave_place
from controllers import Controller, compiles, pi_gains
from controllers.native import declined

PERIOD, SAMPLES = 0.01, 300
JOINT = dict(zip(("proportional", "integral"), pi_gains(2.0, 10.0), strict=True))
JOINT |= {"inertia": 2.0, "stribeck_velocity": 0.05}
NAMES = ("shoulder", "elbow", "wrist")
ARM = {"period": PERIOD, "joints": {"shoulder": JOINT, "elbow": {**JOINT, "preceding": ["shoulder"]}}}


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


def signals(joints=2):
    """Made-up motion and load: reference, measured velocity, position, further regressors (two, the last joint one)."""
    time = PERIOD * np.arange(SAMPLES + 1)[:, None]
    reference = np.sin(time * [1.7, 2.9, 3.7] + [0.3, 1.1, 2.0])[:, :joints] * 0.3
    noise = 0.002 * np.random.default_rng(101).standard_normal((SAMPLES, joints))
    position = np.cumsum(reference[:-1], axis=0) * PERIOD
    further = [[np.sin([0.7 * k, 1.3 * k]) for _ in range(joints - 1)] + [[math.cos(0.9 * k)]] for k in time[:-1, 0]]
    return reference, 0.95 * reference[:-1] + noise, position, further


def run(group, samples=SAMPLES):
    reference, measured, position, _ = signals(len(group.joints))
    rows = zip(reference[:samples], measured[:samples], reference[1:], position, strict=False)
    return np.array([group.step(*now, next_reference=later, position=place) for *now, later, place in rows])


def learnt(group):
    """Estimates without the offsets, which are what the integrals hold."""
    return {name: {key: value for key, value in found.items() if key != "offset"} for name, found in group.items()}


def test_group_with_regressors_is_its_joints_alone_to_the_bit():
    group, alone = JointGroup(controllers((2, 2, 1))), controllers((2, 2, 1))
    reference, measured, position, further = signals(3)
    for k in range(SAMPLES):
        now = {"next_reference": reference[k + 1], "position": position[k], "realised_torque": 3.0 * measured[k]}
        torques = group.step(reference[k], measured[k], regressors=further[k], **now)
        for place, one in enumerate(alone.values()):
            row = {name: values[place] for name, values in now.items()} | {"regressors": further[k][place]}
            assert one.step(reference[k, place], measured[k, place], **row) == torques[place]
    group.take_over([7.0, -2.0, 1.0], reference[k], measured[k], regressors=further[k])
    for place, one in enumerate(alone.values()):
        one.take_over((7.0, -2.0, 1.0)[place], reference[k, place], measured[k, place], regressors=further[k][place])
    for name, one in alone.items():
        assert group.joints[name].state_to_json() == one.state_to_json()
        assert group.estimates[name] == one.estimates
    assert group.estimates["elbow"]["regressor_2"] != 0.0


def test_plain_python_agrees():
    group, plain = JointGroup(controllers((0, 0))), JointGroup(controllers((0, 0))).run_uncompiled()
    np.testing.assert_allclose(run(group, 60), run(plain, 60), rtol=1e-9)


@pytest.mark.skipif(not compiles(), reason="joints in plain Python are stepped one by one")
def test_compiled_joints_without_a_chain_are_stepped_in_one_call():
    mixed = JointGroup(controllers((0, 0)))
    mixed.joints["elbow"].run_uncompiled()
    for group, together in (
        (JointGroup(controllers((0, 0))), True),
        (JointGroup.from_table(ARM), False),
        (mixed, False),
    ):
        for released in (1, 0):  # how often a controller has left its memory
            with patch.object(Controller, "released", released):
                for one in (group, copy.deepcopy(group)):
                    run(one, 2)
                    assert (one._fast is not declined) is together


def test_given_regressors_follow_those_of_the_chain_to_the_bit():
    group = JointGroup(controllers((6, 4, 1)), {"elbow": ["shoulder"], "wrist": ["shoulder", "elbow"]})
    alone = tuple(controllers((6, 4, 1)).values())
    reference, measured, position, further = signals(3)
    for k in range(SAMPLES):
        torques = group.step(reference[k], measured[k], position=position[k], regressors=further[k])
        angles = np.array([np.sum(position[k, : place + 1]) for place in range(3)])
        for place, one in enumerate(alone):
            formed = [part for angle in angles[place + 1 :] for part in (np.sin(angle), np.cos(angle))]
            given = {"position": angles[place], "regressors": [*formed, *further[k][place]]}
            assert one.step(reference[k, place], measured[k, place], **given) == torques[place]


def gravity(joint):
    """Unit torques of gravity over the coming period."""
    place = wave_place(joint.parameters.hypothesis)
    return joint.state.psi[place : place + 2]


def test_regressors_are_sines_of_the_summed_angles_of_the_joints_that_follow():
    group = JointGroup.from_table(ARM)
    shoulder, elbow = group.joints["shoulder"], group.joints["elbow"]
    assert shoulder.estimate_names[-6:-2] == ("gravity_sin", "gravity_cos", "regressor_1", "regressor_2")
    assert elbow.estimate_names[-4:-2] == ("gravity_sin", "gravity_cos")
    group.step([0.1, 0.2], [0.1, 0.2], position=[0.4, 0.7])
    np.testing.assert_allclose(shoulder.state.regressors, [math.sin(1.1), math.cos(1.1)])
    np.testing.assert_allclose(gravity(shoulder), [math.sin(0.4), math.cos(0.4)], atol=1e-3)
    np.testing.assert_allclose(gravity(elbow), [math.sin(1.1), math.cos(1.1)], atol=2e-3)
    torques = group.step([0.1, 0.2], [0.1, 0.2], position=[math.nan, 0.8])
    assert np.all(np.isfinite(torques))
    assert math.hypot(*gravity(elbow)) == pytest.approx(1.0)  # it goes on with its reference


def test_positions_of_motors_are_summed_as_angles_of_their_joints():
    ratios = {"shoulder": 50.0, "elbow": -80.0}
    joints = {name: {**entry, "gear_ratio": ratios[name]} for name, entry in ARM["joints"].items()}
    geared, direct = JointGroup.from_table({**ARM, "joints": joints}), JointGroup.from_table(ARM)
    for group, position in ((direct, [0.4, 0.7]), (geared, [50.0 * 0.4, -80.0 * 0.7])):
        group.step([0.1, 0.2], [0.1, 0.2], position=position)
    for name in joints:
        one, other = geared.joints[name].state, direct.joints[name].state
        np.testing.assert_allclose(one.psi, other.psi, atol=2e-3)
        np.testing.assert_allclose(one.regressors, other.regressors, rtol=1e-12)


def goes_on(group, new, **given):
    """Restore a group's state in a new one; both then do the same until the end, regressors given now and then."""
    new.state_from_json(group.state_to_json())
    reference, measured, position, further = signals(len(group.joints))
    for k in range(70, 130):
        now = {"position": position[k], **({"regressors": further[k]} if given and k % 10 == 0 else {})}
        torques = group.step(reference[k], measured[k], **now)
        assert np.array_equal(new.step(reference[k], measured[k], **now), torques)
    assert new.state_to_json() == group.state_to_json()


@pytest.mark.parametrize("lost", [math.nan, math.inf, None])
@pytest.mark.parametrize("before", [0, 60])
def test_a_chain_goes_on_from_its_save_after_a_lost_position(lost, before):
    group = JointGroup.from_table(chain(3))
    run(group, before)
    reference, measured, position, _ = signals(3)
    for k in range(before, before + 3):
        torn = None if lost is None else np.where([False, True, False], lost, position[k])
        group.step(reference[k], measured[k], position=torn)
    goes_on(group, JointGroup.from_table(chain(3)))


@pytest.mark.parametrize("unknown", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("before", [0, 60])
def test_a_group_goes_on_from_its_save_after_an_unknown_regressor(unknown, before):
    group = JointGroup(controllers((2, 1)))
    reference, measured, _, further = signals()
    for k in range(before):
        group.step(reference[k], measured[k], regressors=further[k])
    held = further[before - 1][0][0] if before else 0.0
    group.step(reference[before], measured[before], regressors=[[unknown, 0.25], [unknown]])
    assert group.joints["shoulder"].regressors.tolist() == [held, 0.25]
    goes_on(group, JointGroup(controllers((2, 1))), regressors=True)


def test_from_the_largest_regressors_a_save_can_be_loaded():
    group, size = JointGroup(controllers((2, 1))), LARGEST_REGRESSOR
    reference, measured, _, _ = signals()
    for k in range(100):
        group.step(reference[k], measured[k], regressors=[[size, -size], [size]], realised_torque=[1.0, 2.0])
    JointGroup(controllers((2, 1))).state_from_json(group.state_to_json())


def test_a_damaged_state_is_refused_and_the_own_kept():
    group, other = JointGroup.from_table(ARM), JointGroup.from_table(ARM)
    run(group, 100)
    damaged, kept = json.loads(group.state_to_json()), other.state_to_json()
    damaged["group"]["elbow"]["state"]["weight"] = None
    for text in (json.dumps(damaged), "x" * 50, '{"group": {}}', '{"group": ["shoulder", "elbow"]}', "[]"):
        with pytest.raises(ValueError, match=r"elbow|'(x{40}|\[]|{.*})' is no saved state|this group has"):
            other.state_from_json(text)
        assert other.state_to_json() == kept


@pytest.mark.parametrize("name", ["velocity", "next_reference", "realised_torque", "position"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_measurement_that_is_not_finite_concerns_its_joint_alone(name, value):
    whole, torn = JointGroup(controllers((0, 0, 0))), JointGroup(controllers((0, 0, 0)))
    reference, measured, position, _ = signals(3)
    for k in range(SAMPLES):
        given = {"reference": reference[k], "velocity": measured[k], "next_reference": reference[k + 1]}
        given |= {"position": position[k], "realised_torque": 3.0 * measured[k]}
        lost = {**given, name: np.where([False, k >= 150, False], value, given[name])}
        torques, hurt = whole.step(**given), torn.step(**lost)
        assert np.array_equal(hurt[[0, 2]], torques[[0, 2]])
        assert np.all(np.isfinite(hurt))
    for joint in ("shoulder", "wrist"):
        assert torn.joints[joint].state_to_json() == whole.joints[joint].state_to_json()
    assert torn.rejected == {"shoulder": 0, "elbow": 150 if name == "velocity" else 0, "wrist": 0}


@pytest.mark.parametrize("coupled", [False, True])
def test_takeover_of_a_group_in_a_cascade_does_not_let_the_torques_jump(coupled):
    group = JointGroup.from_table(ARM) if coupled else JointGroup(controllers((0, 0)))
    run(group, 100)
    now = {"correction": [0.02, -0.01], "feedforward": [30.0, -5.0], "position": [0.4, math.nan]}
    now |= {"next_reference": [0.11, 0.09], "inertia": [2.1, 2.0]}
    group.take_over([40.0, -3.0], [0.1, 0.1], [0.09, 0.11], **now)
    np.testing.assert_allclose(group.step([0.1, 0.1], [0.09, 0.11], **now), [40.0, -3.0], atol=1e-9)


def test_joints_of_a_group_are_switched_and_restarted_together_or_one_by_one():
    group = JointGroup(controllers((0, 0)))
    run(group, 50)
    for name in ("enabled", "feedforward_enabled"):
        assert getattr(group, name).tolist() == [True, True]
        setattr(group, name, [True, False])
        assert [getattr(joint, name) for joint in group.joints.values()] == [True, False]
        with pytest.raises(ValueError, match="read-only"):  # it would change nothing
            getattr(group, name)[1] = True
        setattr(group, name, False)
        assert getattr(group, name).tolist() == [False, False]
        with pytest.raises(ValueError, match=rf"^{name} = 'no' is not allowed: it must be True or False"):
            setattr(next(iter(group.joints.values())), name, "no")
    before = learnt(group.estimates)
    run(group, 100)
    group.restart()
    np.testing.assert_allclose(group.step([0.0, 0.0], [0.0, 0.0]), 0.0, atol=1e-9)
    assert learnt(group.estimates) == before
    assert set(group.diagnose()) == {"shoulder", "elbow"}
    group.reset()
    assert group.estimates == JointGroup(controllers((0, 0))).estimates


def test_group_from_a_file(tmp_path):
    path = tmp_path / "arm.toml"
    lines = ["period = 0.01"]
    for name, entry in ARM["joints"].items():
        lines += [f"[joints.{name}]", *(f"{key} = {json.dumps(value)}" for key, value in entry.items())]
    path.write_text("\n".join(lines))
    assert list(JointGroup.from_toml(path).joints) == ["shoulder", "elbow"]
    assert joints_of_table({"period": PERIOD, "joints": {"alone": JOINT}})[1] is None
    for text in ("period = [", "joints = 3\nperiod = 1.0", "period = 0.01\n[joints.a]\nmass = 3.0"):
        path.write_text(text)
        with pytest.raises(ValueError, match=r"arm\.toml: "):
            JointGroup.from_toml(path)
    path.write_bytes("# Prüfstand".encode("latin-1"))
    with pytest.raises(ValueError, match=r"arm\.toml: is not valid TOML: byte 0xfc in line 1 is no text in UTF-8$"):
        JointGroup.from_toml(path)
    with pytest.raises(ValueError, match=r"gone\.toml: cannot be read: No such file or directory$"):
        JointGroup.from_toml(tmp_path / "gone.toml")


TWO = [0.1, 0.2]
INPUTS = [
    ({"reference": [1.0, math.nan]}, r"^reference of elbow = nan is not allowed: it must be "),
    ({"correction": [1.0, math.inf]}, r"^correction of elbow = inf is not allowed"),
    ({"reference": [0.1]}, r"^reference has shape \(1,\); it must be \(2,\)"),
    ({"dt": -1.0}, r"^dt(?: of shoulder = -1.0)? is not allowed"),
    ({"regressors": [[0.1], [0.2]]}, r"^regressors of shoulder has shape \(1,\); it must be \(3,\), .* beside the 2"),
    ({"regressors": [[0.1, 0.2, 0.3], [-1e100]]}, r"^regressors of elbow = -1e\+100 is not allowed: they should be of"),
]


@pytest.mark.parametrize(("given", "message"), INPUTS)
def test_wrong_inputs_are_refused_and_change_nothing(given, message):
    group = JointGroup(controllers((5, 1)), {"elbow": ["shoulder"]})
    group.step(TWO, TWO, position=TWO, regressors=[[0.1, 0.2, 0.3], [0.4]])
    before = group.state_to_json()
    arguments = {"reference": TWO, "velocity": TWO, "position": [0.3, 0.4], "regressors": [[0.5, 0.6, 0.7], [0.8]]}
    for refusing in (group.step, lambda **arguments: group.take_over([1.0, 1.0], **arguments)):
        with pytest.raises(ValueError, match=message):
            refusing(**{**arguments, **given})
        assert group.state_to_json() == before


@pytest.mark.parametrize(
    ("torque", "velocity", "message"),
    [
        ([1.0, 1.0], [0.1, 0.1], r"^elbow: integral = 0 is not allowed for a takeover"),
        ([1.0, 1.0], [0.1, math.nan], r"^velocity of elbow = nan is not allowed"),
        ([1.0, 1.0, 1.0], [0.1, 0.1], r"^torque has shape \(3,\); it must be \(2,\)"),
    ],
)
def test_a_takeover_that_one_joint_refuses_prepares_none(torque, velocity, message):
    joints = controllers((0, 0))
    joints["elbow"] = AdaptiveController(**{**JOINT, "integral": 0.0}, period=PERIOD)
    group = JointGroup(joints)
    run(group, 50)
    before = group.state_to_json()
    with pytest.raises(ValueError, match=message):
        group.take_over(torque, [0.1, 0.1], velocity)
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
    with pytest.raises(ValueError, match=r"^shoulder has regressors = 1; it must be 2 at least"):
        JointGroup(controllers((1, 0)), {"elbow": ["shoulder"]})


def test_a_joint_behind_another_has_no_map_over_its_own_angle():
    table = chain(2)
    table["joints"]["joint_1"]["ripple_periods"] = [0.5]
    with pytest.raises(ValueError, match=r"^joint_1\.preceding is not allowed with ripple_periods"):
        JointGroup.from_table(table)

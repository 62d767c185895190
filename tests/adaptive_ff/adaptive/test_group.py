"""A group of joints against its joints one by one, and what one joint must not do to another."""

import json
import math

import numpy as np
import pytest

from adaptive_ff import WITH_GRAVITY, AdaptiveController, JointGroup
from adaptive_ff.adaptive.prior import wave_place
from controllers import PI, pi_gains

PERIOD, SAMPLES = 0.01, 300
JOINT = dict(zip(("proportional", "integral"), pi_gains(20.0, 10.0), strict=True))
JOINT |= {"inertia": 20.0, "stribeck_velocity": 0.05}
LIGHT = dict(zip(("proportional", "integral"), pi_gains(2.0, 10.0), strict=True))
LIGHT |= {"inertia": 2.0, "stribeck_velocity": 0.05}
ARM = {"period": PERIOD, "joints": {"shoulder": JOINT, "elbow": {**LIGHT, "preceding": ["shoulder"]}}}


def pair(**options):
    return JointGroup(
        {
            name: AdaptiveController(**table, period=PERIOD, parameters=WITH_GRAVITY, **options)
            for name, table in (("shoulder", JOINT), ("elbow", LIGHT))
        }
    )


def signals(samples=SAMPLES):
    """Made-up motion of two joints: plan, measured velocity, position, shape (samples, 2) each."""
    time = PERIOD * np.arange(samples + 1)[:, None]
    plan = np.sin(time * [1.7, 2.9] + [0.3, 1.1]) * [0.3, 0.2]
    noise = 0.002 * np.random.default_rng(101).standard_normal((samples, 2))
    return plan, 0.95 * plan[:-1] + noise, np.cumsum(plan[:-1], axis=0) * PERIOD


def run(group, velocity=None, samples=SAMPLES):
    plan, measured, position = signals(samples)
    seen = measured if velocity is None else velocity
    return np.array(
        [group.step(plan[k], seen[k], next_reference=plan[k + 1], position=position[k]) for k in range(samples)]
    )


def test_group_does_what_its_joints_do_alone():
    group, alone = pair(), pair()
    plan, measured, position = signals()
    torques = run(group)
    for place, controller in enumerate(alone.joints.values()):
        for k in range(SAMPLES):
            torque = controller.step(
                plan[k, place], measured[k, place], next_reference=plan[k + 1, place], position=position[k, place]
            )
            assert torque == pytest.approx(torques[k, place], rel=1e-12)
    assert group.estimates == {name: pytest.approx(found, rel=1e-9) for name, found in alone.estimates.items()}


def test_plain_python_agrees():
    np.testing.assert_allclose(run(pair(), samples=60), run(pair().run_uncompiled(), samples=60), rtol=1e-9)


def test_measurements_lost_in_one_joint_do_not_touch_another():
    plan, measured, position = signals()
    torn = measured.copy()
    torn[100:200, 0] = np.nan
    whole, hurt = pair(), pair()
    torques, others = run(whole), run(hurt, torn)
    np.testing.assert_array_equal(others[:, 1], torques[:, 1])
    assert hurt.rejected == {"shoulder": 100, "elbow": 0}
    assert hurt.faults == {"shoulder": 0, "elbow": 0}
    assert hurt.fault == {"shoulder": False, "elbow": False}
    assert np.all(np.isfinite(others))
    del plan, position


def gravity(joint):
    """Unit torques of gravity over the coming period."""
    place = wave_place(joint.parameters.hypothesis)
    return joint.state.psi[place : place + 2]


def learnt(group):
    """Estimates without the offsets, which are what the integrals hold."""
    return {name: {key: value for key, value in found.items() if key != "offset"} for name, found in group.items()}


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
    joints = {
        name: {**entry, "gear_ratio": ratio}
        for (name, entry), ratio in zip(ARM["joints"].items(), (50.0, -80.0), strict=True)
    }
    geared, direct = JointGroup.from_table({**ARM, "joints": joints}), JointGroup.from_table(ARM)
    for group, position in ((direct, [0.4, 0.7]), (geared, [50.0 * 0.4, -80.0 * 0.7])):
        group.step([0.1, 0.2], [0.1, 0.2], position=position)
    for name in joints:
        one, other = geared.joints[name].state, direct.joints[name].state
        np.testing.assert_allclose(one.psi, other.psi, atol=2e-3)
        np.testing.assert_allclose(one.regressors, other.regressors, rtol=1e-12)


def test_state_of_all_joints_is_one_text():
    first, second = JointGroup.from_table(ARM), JointGroup.from_table(ARM)
    run(first, samples=100)
    second.state_from_json(first.state_to_json())
    plan, measured, position = signals()
    arguments = (plan[100], measured[100])
    np.testing.assert_array_equal(
        first.step(*arguments, position=position[100]), second.step(*arguments, position=position[100])
    )
    damaged = json.loads(first.state_to_json())
    damaged["group"]["elbow"]["state"]["weight"] = None
    kept = second.state_to_json()
    for text in (json.dumps(damaged), "no JSON", '{"group": {}}', '{"group": ["shoulder", "elbow"]}', "[]"):
        with pytest.raises(ValueError, match=r"elbow|no saved state|this group has"):
            second.state_from_json(text)
        assert second.state_to_json() == kept


def test_group_from_a_file(tmp_path):
    path = tmp_path / "arm.toml"
    lines = ["period = 0.01"]
    for name, entry in ARM["joints"].items():
        lines += [f"[joints.{name}]", *(f"{key} = {json.dumps(value)}" for key, value in entry.items())]
    path.write_text("\n".join(lines))
    assert list(JointGroup.from_toml(path).joints) == ["shoulder", "elbow"]
    for text in ("period = [", "joints = 3\nperiod = 1.0", "period = 0.01\n[joints.a]\nmass = 3.0"):
        path.write_text(text)
        with pytest.raises(ValueError, match=r"arm\.toml: "):
            JointGroup.from_toml(path)
    path.write_bytes("# Prüfstand".encode("latin-1"))
    with pytest.raises(ValueError, match=r"arm\.toml: is not valid TOML: byte 0xfc in line 1 is no text in UTF-8$"):
        JointGroup.from_toml(path)
    with pytest.raises(ValueError, match=r"gone\.toml: cannot be read: No such file or directory$"):
        JointGroup.from_toml(tmp_path / "gone.toml")


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"period": PERIOD}, r"^joints is missing"),
        ({"period": PERIOD, "joints": {}}, r"^joints = \{\} is not allowed"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "inertia": -1.0}}}, r"^a: inertia = -1.0 is not allowed"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "preceding": ["b"]}}}, r"^preceding: 'b' is not a joint"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "preceding": ["a"]}}}, r"^a\.preceding = \['a'\] is not allowed"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "preceding": "a"}}}, r"^a\.preceding = 'a' is not allowed"),
        (
            {**ARM, "joints": {**ARM["joints"], "wrist": {**LIGHT, "preceding": ["elbow"]}}},
            r"^wrist\.preceding = \['elbow'\] is not allowed: shoulder precedes elbow; it must be all joints between",
        ),
        (
            {**ARM, "joints": {**ARM["joints"], "shoulder": {**JOINT, "preceding": ["elbow"]}}},
            r"^shoulder\.preceding = \['elbow'\] is not allowed: shoulder precedes elbow; it must be",
        ),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "identify": "all"}}}, r"^a\.identify = 'all' is not allowed"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "identify": ["offset"]}}}, r"^a\.identify = \['offset'\] is not"),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "period": 0.1}}}, r"^a\.period is not allowed: all joints have"),
        (
            {"period": PERIOD, "joints": {"a": {**JOINT, "parameters": []}}},
            r"^a\.parameters is not allowed: it is named",
        ),
        ({"period": PERIOD, "joints": {"a": {**JOINT, "torque_limit": "x"}}}, r"^a: torque_limit = 'x' is not allowed"),
        ({"period": PERIOD, "joints": {"a": 3}}, r"^a = 3 is not allowed: it must be a table of settings"),
        ({"period": PERIOD, "joints": {"a": JOINT}, "gain": 1.0}, r"^gain is not allowed"),
    ],
)
def test_what_is_no_group_is_refused_in_one_line(table, message):
    with pytest.raises(ValueError, match=message) as raised:
        JointGroup.from_table(table)
    assert "\n" not in str(raised.value)


def test_joints_without_names_are_refused():
    with pytest.raises(TypeError, match=r"^joints = \[0, 1\] is not allowed: it must be controllers by name, such as"):
        JointGroup([0, 1])


def test_wrong_inputs_step_no_joint():
    group = pair()
    before = group.state_to_json()
    for arguments, message in (
        (([0.1], [0.0, 0.0]), r"^reference has shape \(1,\); it must be \(2,\)"),
        (([0.1, math.nan], [0.0, 0.0]), r"^reference of elbow = nan is not allowed"),
    ):
        with pytest.raises(ValueError, match=message):
            group.step(*arguments)
    with pytest.raises(ValueError, match=r"^inertia of shoulder = 0.0 is not allowed: it must be positive"):
        group.step([0.1, 0.1], [0.0, 0.0], inertia=[0.0, 1.0])
    with pytest.raises(ValueError, match=r"^dt of shoulder = -1.0 is not allowed"):
        group.step([0.1, 0.1], [0.0, 0.0], dt=-1.0)
    with pytest.raises(ValueError, match=r"^dt has shape \(2,\); it must be one number for all joints"):
        group.step([0.1, 0.1], [0.0, 0.0], dt=[0.01, 0.01])
    for name in ("reference", "correction", "feedforward"):
        with pytest.raises(ValueError, match=rf"^{name} = None is not allowed: it must be 2 numbers"):
            group.step(**{"reference": [0.1, 0.1], "velocity": [0.0, 0.0], name: None})
        with pytest.raises(ValueError, match=rf"^{name} of shoulder = nan is not allowed: it must be a finite number"):
            group.step(**{"reference": [0.1, 0.1], "velocity": [0.0, 0.0], name: math.nan})
    with pytest.raises(ValueError, match=r"^velocity of elbow = nan is not allowed"):
        group.take_over([1.0, 1.0], [0.0, 0.0], [0.0, math.nan])
    with pytest.raises(ValueError, match=r"^torque has shape \(3,\); it must be \(2,\)"):
        group.take_over([1.0, 1.0, 1.0], [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match=r"^correction of elbow = inf is not allowed"):
        group.take_over([1.0, 1.0], [0.0, 0.0], [0.0, 0.0], correction=[0.0, math.inf])
    with pytest.raises(ValueError, match=r"^dt is not allowed: it must be one of next_reference, "):
        group.take_over([1.0, 1.0], [0.0, 0.0], [0.0, 0.0], dt=0.01)
    for name in ("enabled", "feedforward_enabled"):
        for wrong in (1.0, [True], "no"):
            with pytest.raises(ValueError, match=f"^{name} = .* is not allowed: it must be true or false"):
                setattr(group, name, wrong)
        with pytest.raises(ValueError, match=rf"^{name} = 'no' is not allowed: it must be True or False"):
            setattr(next(iter(group.joints.values())), name, "no")
    assert group.state_to_json() == before


@pytest.mark.parametrize("coupled", [False, True])
def test_takeover_of_a_group_in_a_cascade_does_not_let_the_torques_jump(coupled):
    group = JointGroup.from_table(ARM) if coupled else pair()
    run(group, samples=100)
    now = {"correction": [0.02, -0.01], "feedforward": [30.0, -5.0], "position": [0.4, math.nan]}
    now |= {"next_reference": [0.11, 0.09], "inertia": [21.0, 2.0]}
    group.take_over([40.0, -3.0], [0.1, 0.1], [0.09, 0.11], **now)
    np.testing.assert_allclose(group.step([0.1, 0.1], [0.09, 0.11], **now), [40.0, -3.0], atol=1e-9)


def test_all_joints_of_a_group_are_switched_together_or_one_by_one():
    group = pair()
    for name in ("enabled", "feedforward_enabled"):
        assert getattr(group, name).tolist() == [True, True]
        setattr(group, name, [True, False])
        assert [getattr(joint, name) for joint in group.joints.values()] == [True, False]
        with pytest.raises(ValueError, match="read-only"):  # it would change nothing
            getattr(group, name)[1] = True
        setattr(group, name, False)
        assert getattr(group, name).tolist() == [False, False]
    before = learnt(group.estimates)
    run(group, samples=100)
    assert learnt(group.estimates) == before


def test_takeover_and_switches_of_a_group():
    group = pair()
    run(group, samples=50)
    group.take_over([5.0, -3.0], [0.1, 0.1], [0.09, 0.11])
    np.testing.assert_allclose(group.step([0.1, 0.1], [0.09, 0.11]), [5.0, -3.0], atol=1e-9)
    group.joints["elbow"].enabled = False
    held = learnt(group.estimates)["elbow"]
    run(group, samples=100)
    assert learnt(group.estimates)["elbow"] == held
    assert set(group.diagnose()) == {"shoulder", "elbow"}
    before = learnt(group.estimates)
    group.restart()
    np.testing.assert_allclose(group.step([0.0, 0.0], [0.0, 0.0]), 0.0, atol=1e-9)
    assert learnt(group.estimates) == before


def test_what_is_no_adaptive_controller_is_refused_by_name():
    for other in (PI(100.0, 1000.0, 0.01), 3):
        with pytest.raises(TypeError, match=r"^elbow = .* is not allowed: it must be an AdaptiveController"):
            JointGroup({"elbow": other})


def test_one_controller_under_two_names_is_refused():
    one = AdaptiveController(100.0, 1000.0, 0.01, inertia=2.0, stribeck_velocity=0.05)
    with pytest.raises(ValueError, match="one controller stands under two names"):
        JointGroup({"shoulder": one, "elbow": one})


def test_what_a_joint_has_lost_or_not_believed_is_told_by_joint():
    plan, measured, position = signals()
    group = pair()
    for k in range(260):
        feedforward = [0.0, 1e306 if k < 3 else 0.0]
        group.step(plan[k], [math.nan, measured[k, 1]], position=position[k], feedforward=feedforward)
    assert group.fault == {"shoulder": True, "elbow": False}
    assert group.faults == {"shoulder": 0, "elbow": 3}

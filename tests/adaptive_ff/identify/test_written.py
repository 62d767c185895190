"""What was found is what is written: scenario, model, first estimate, simulators, open loop."""

import re

import mujoco
import numpy as np
import pytest
from synthetic_logs import make_log, motion, sines_log

from adaptive_ff import AdaptiveController, InputError, TorqueModel, identify_log, load_scenario, simulate
from adaptive_ff.files import write_csv
from adaptive_ff.friction.model import GRAVITY
from adaptive_ff.identify.scenario_text import reference_columns, scenario_text
from adaptive_ff.identify.score import score_log
from adaptive_ff.logs.log import Log
from controllers import PI


@pytest.fixture(scope="module")
def heavy():
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w) + 2.0 * np.sin(q + 0.3))
    return log, identify_log(log)


def written(found, folder):
    write_csv(folder / "reference.csv", reference_columns(found))
    (folder / "scenario.toml").write_text(scenario_text(found, "reference.csv"), encoding="utf-8")
    return load_scenario(folder / "scenario.toml")


def test_scenario_model_and_first_estimate_are_one(heavy, tmp_path):
    log, found = heavy
    joint, model, first = written(found, tmp_path).joint, found.torque_model(), found.first_estimate()
    assert isinstance(model, TorqueModel)
    for name in ("inertia", "coulomb", "stiction", "viscous", "offset"):
        assert getattr(joint, name) == pytest.approx(getattr(model, name), rel=1e-4, abs=1e-4)
        assert first["model"][name] == getattr(model, name)
    assert joint.gravity == pytest.approx(np.hypot(*(first["model"][name] for name in GRAVITY)), rel=1e-4)
    start = found.data.longest.position[0]
    assert joint.gravity_phase == pytest.approx(0.3 + start, abs=0.02)
    assert start == pytest.approx(log.position[0], abs=0.01)


@pytest.mark.parametrize("shape", ["gravity", "directions", "stribeck"])
def test_simulated_scenario_has_the_friction_curve_of_the_log(shape, heavy, tmp_path):
    further = {
        "directions": lambda q, w: 0.8 * np.sign(w) + 0.2 * np.abs(w) + 0.1,
        "stribeck": lambda q, w: np.sign(w) * (0.8 + 0.6 * np.exp(-np.abs(w) / 0.3)),
    }
    found = heavy[1] if shape == "gravity" else identify_log(sines_log(further[shape])[0])
    run = simulate(written(found, tmp_path).modified(sensor={"velocity_noise": 0.0}, duration=25.0), "oracle")
    speeds = np.array([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0])
    scale = np.max(np.abs(found.friction(speeds)))
    if shape == "gravity":  # a velocity has no position: the weight would be part of what is left there
        again = identify_log(Log("run", run.time, run.torque, position=np.cumsum(run.measured) * 0.002))
        assert again.gravity[0] == pytest.approx(found.gravity[0], rel=0.05)
    else:
        again = identify_log(Log("run", run.time, run.torque, velocity=run.measured), torque_delay=0.0005)
    assert again.friction(speeds) == pytest.approx(found.friction(speeds), abs=0.08 * scale)


def test_controller_begins_with_what_was_identified(heavy):
    first = heavy[1].first_estimate()
    design = PI.design(inertia=first["inertia"], period=0.01, bandwidth=5.0)
    controller = AdaptiveController(design.proportional, design.integral, 0.01, **first)
    assert controller.estimates["gravity_sin"] == pytest.approx(first["model"]["gravity_sin"])
    assert all(value > 0.0 for value in first["deviation"].values())


def test_current_takes_a_torque_constant():
    log = make_log(noise=0.05)
    found = identify_log(Log("log", log.time, log.torque / 0.11, position=log.position), is_current=True)
    with pytest.raises(InputError, match="the torque is a current; give torque_constant"):
        found.torque_model()
    assert found.torque_model(0.11).inertia == pytest.approx(2.0, rel=0.01)
    assert found.units["inertia"] == "A s²/rad"


def mujoco_run(model, torque, position, step):
    """Positions of a joint in MuJoCo under a torque, from the first position at rest."""
    data = mujoco.MjData(model)
    data.qpos[0], seen = position, []
    for value in torque:
        seen.append(data.qpos[0])
        data.qfrc_applied[0] = value
        mujoco.mj_step(model, data)
    assert model.opt.timestep == pytest.approx(step)
    return np.array(seen)


JOINT = """<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody><body>
<joint name="joint" type="hinge" axis="0 1 0" armature="0.05" damping="0.3" frictionloss="0.8"/>
<inertial pos="0 0 -0.2" mass="1.0" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def of_mujoco():
    """A joint of MuJoCo, with a PD loop along a sum of sines, and its log."""
    model = mujoco.MjModel.from_xml_string(JOINT)
    data = mujoco.MjData(model)
    time = 0.001 * np.arange(30_000)
    plan = 1.2 * np.sin(1.3 * time) + 0.6 * np.sin(4.1 * time + 1.0) + 0.16 * np.sin(9.7 * time + 2.0)
    position, torque = np.empty(time.size), np.empty(time.size)
    for k in range(time.size):
        position[k] = data.qpos[0]
        slope = (plan[min(k + 1, time.size - 1)] - plan[k]) / 0.001
        torque[k] = 60.0 * (plan[k] - data.qpos[0]) + 6.0 * (slope - data.qvel[0])
        data.qfrc_applied[0] = torque[k]
        mujoco.mj_step(model, data)
    log = Log("mujoco", time[2000:], torque[2000:], position=position[2000:])
    return log, identify_log(log, torque_delay=0.0005)


def test_joint_of_mujoco_gets_its_own_parameters_back(of_mujoco):
    found = of_mujoco[1]
    assert found.value("inertia") == pytest.approx(0.05 + 0.01 + 1.0 * 0.2**2, rel=0.03)
    assert found.joint_parameters["coulomb"].value == pytest.approx(0.8, rel=0.03)
    assert found.joint_parameters["viscous"].value == pytest.approx(0.3, rel=0.03)
    assert found.gravity[0] == pytest.approx(9.81 * 0.2, rel=0.03)


@pytest.mark.parametrize("kind", ["mjcf", "urdf"])
def test_written_joint_moves_as_the_log_does(of_mujoco, kind, tmp_path):
    log, found = of_mujoco
    path = tmp_path / f"joint.{'xml' if kind == 'mjcf' else 'urdf'}"
    path.write_text(found.simulator(kind), encoding="utf-8")
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = 0.001
    begin = int(np.argmin(np.abs(np.gradient(log.position[:5000]))))
    part = slice(begin, begin + 1000)
    simulated = mujoco_run(model, log.torque[part], log.position[begin], 0.001)
    moved = np.ptp(log.position[part])
    assert np.sqrt(np.mean((simulated - log.position[part]) ** 2)) < 0.05 * moved


def test_open_loop_follows_another_log_of_the_joint_and_not_one_of_another(heavy):
    log, found = heavy
    score = score_log(log.part(slice(0, 7500)), log.part(slice(7500, None)))
    assert score.grade == "follows"
    assert score.windows < 0.05 * score.moved
    assert score.rms == pytest.approx(np.sqrt(np.mean((score.simulated - score.measured) ** 2)))
    assert score.fit == pytest.approx(100.0 * (1.0 - score.rms / np.std(score.measured)))
    assert score.found.best.values["inertia"] == pytest.approx(found.value("inertia"), rel=0.02)
    other, _ = sines_log(lambda q, w: 4.0 * np.sign(w) + 2.0 * np.sin(q + 0.3))
    worse = score_log(log, other.part(np.delete(np.arange(15000), np.s_[6000:7000])))
    assert f"{other.name}: the longest of 2 segments is simulated, " in worse.cautions[-1]
    assert worse.windows > 3.0 * score.windows
    np.testing.assert_allclose(np.interp(score.time, log.time, log.position), score.measured, atol=1e-9)
    assert worse.torque_left > 0.2
    assert score.to_dict()["verdict"] == "follows"


@pytest.mark.parametrize(
    "friction",
    [
        lambda q, w: np.sign(w) * (0.8 - 0.5 * np.exp(-np.abs(w) / 0.4)),
        lambda q, w: 0.8 * np.sign(w) + 0.1 * w + 0.8 * np.abs(w),
    ],
    ids=["dips at low speed", "falls with the speed one way"],
)
def test_open_loop_has_friction_that_no_scenario_has(friction):
    log, _ = sines_log(friction)
    score = score_log(log.part(slice(0, 7500)), log.part(slice(7500, None)), linear=True)
    assert score.windows < 0.05 * score.moved
    assert score.found.linear
    assert not any("lacks" in caution for caution in score.cautions)


def test_score_of_the_log_itself_is_said_to_say_nothing(heavy):
    log = heavy[0].part(slice(0, 5000))
    assert any("its error says nothing about other motion" in caution for caution in score_log(log, log).cautions)
    fast = score_log(log := make_log(6.0, period=0.0005), log)
    assert fast.simulated.size == fast.time.size == fast.measured.size


@pytest.mark.parametrize("role", ["train", "test"])
def test_both_logs_of_a_score_have_positions(heavy, role):
    given = dict.fromkeys(("train", "test"), heavy[0])
    with pytest.raises(TypeError, match=rf"^{role} = None is not allowed: it must be a Log"):
        score_log(**{**given, role: None})
    with pytest.raises(InputError, match="log: a score takes a log with positions, not velocities"):
        score_log(**{**given, role: make_log(6.0, as_position=False)})
    with pytest.raises(TypeError, match=r"^log = None is not allowed: it must be a Log"):
        identify_log(None)


def test_motion_of_the_scenario_is_that_of_the_log():
    columns = reference_columns(found := identify_log(make_log(period=0.004)))
    assert 0.05 < columns["time"][2] * found.data.band / 2.0 <= 0.1
    inner = (columns["time"] > 1.0) & (columns["time"] < 29.0)
    assert columns["velocity"][inner] == pytest.approx(motion(columns["time"][inner])[1], abs=0.02)


def test_comments_of_the_scenario_are_intervals_of_its_own_values():
    """A dip at low speed is not simulated: the line through it is, with its own interval."""
    found = identify_log(sines_log(lambda q, w: np.sign(w) * (0.8 - 0.5 * np.exp(-np.abs(w) / 0.4)))[0])
    assert found.value("stiction_excess") < 0.0
    joint = scenario_text(found, "reference.csv").partition("[sampling]")[0]
    for name in ("inertia", "coulomb", "viscous"):
        (line,) = re.findall(rf"^{name} = .* # .*", joint, re.M)
        value, low, high = (float(number) for number in re.findall(r"= (\S+) .*interval (\S+) to (\S+)", line)[0])
        assert low < value < high


def test_motion_that_narrows_an_interval_is_that_of_its_own_column():
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w))
    by = identify_log(log, linear=True).narrowed_by
    assert by["viscous"][0] == "speed"
    assert by["viscous"][1] > 1.0
    assert by["coulomb"][0] == "speed"
    assert by["coulomb"][1] < 1.0
    assert by["inertia"][0] == "acceleration"
    assert by["inertia"][1] > 1.0
